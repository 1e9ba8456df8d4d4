// angle.vert: a surface with both of its normals, through plain M and through the normal matrix. Put together like the programs of src/render/shaders (colour.glsl).
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 local_to_world, world_to_view, view_to_clip;
uniform mat3 plain_matrix, normal_matrix;
out vec3 view_point, plain_normal, right_normal;

void main() {
    vec4 view = world_to_view * (local_to_world * vec4(position, 1.0));
    gl_Position = view_to_clip * view;
    view_point = view.xyz;
    plain_normal = plain_matrix * norma_unit(normal);
    right_normal = normal_matrix * norma_unit(normal);
}
