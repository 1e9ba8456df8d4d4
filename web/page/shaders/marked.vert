// marked.vert: a surface of which some corners are marked with a colour: alpha is 1 there, 0 elsewhere. Put together like the programs of src/render/shaders (colour.glsl).
layout(location = 0) in vec3 position;
layout(location = 2) in vec4 colour;
uniform mat4 local_to_world, world_to_view, view_to_clip;
out vec3 view_point;
out vec4 mark;

void main() {
    vec4 view = world_to_view * (local_to_world * vec4(position, 1.0));
    gl_Position = view_to_clip * view;
    view_point = view.xyz;
    mark = colour;
}
