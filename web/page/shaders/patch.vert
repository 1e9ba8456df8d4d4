// patch.vert: a patch of an acid scene as its camera sees it, from +z: a square of side 2 * half_side about the middle. Put together like the programs of src/render/shaders (colour.glsl).
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform float half_side;
out vec3 lit_normal;

void main() {
    gl_Position = vec4(position.xy / half_side, -position.z, 1.0);
    lit_normal = normal;
}
