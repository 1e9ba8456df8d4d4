// shadow.vert: the shadow of a model on the ground below it.
// #define CAST      the model as it is seen from below
//         BLUR      all of a picture
//         otherwise the ground, a rectangle: local_to_world takes (-1, 0, -1) and (1, 0, 1) to its corners
uniform mat4 local_to_world, world_to_view, view_to_clip;
#if defined(CAST)
layout(location = 0) in vec3 position;
void main() { gl_Position = view_to_clip * (world_to_view * (local_to_world * vec4(position, 1.0))); }
#else
out vec2 at;
void main() {
    at = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    vec4 corner = vec4(2.0 * at - 1.0, 0.0, 1.0);
#if defined(BLUR)
    gl_Position = corner;
#else
    gl_Position = view_to_clip * (world_to_view * (local_to_world * corner.xzyw));
#endif
}
#endif
