// patch.frag: a white patch in the light of light.glsl. Where a renderer forgets that normals have unit length, they keep the one that they have.
uniform float keeps_length;
in vec3 lit_normal;
out vec4 pixel;

void main() {
    pixel = vec4(encode(lit(vec3(0.0), keeps_length > 0.5 ? lit_normal : norma_unit(lit_normal), vec3(1.0))), 1.0);
}
