// scale.vert: a bar over the whole viewport, for the legend of --show error. drawArrays(TRIANGLE_STRIP, 0, 4), no attributes. How the files make a program: colour.glsl.
out float scale_value;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    scale_value = corner.x;
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
