#version 300 es
// Transforms a vertex, its normal and its tangent into world space.
in vec3 position;
in vec3 normal;
in vec4 tangent;                              // xyz, and the sign of the bitangent
in vec2 texcoord;
uniform mat4 local_to_world, world_to_clip;
uniform mat3 normal_matrix;                   // sign(det) * cof(mat3(local_to_world)), from the CPU
uniform float handedness;                     // -1.0 if local_to_world mirrors, else 1.0
out vec3 world_position, world_normal;
out vec4 world_tangent;
out vec2 uv;

void main() {
    vec4 world = local_to_world * vec4(position, 1.0);                // a point: w = 1
    world_position = world.xyz;
    world_normal = normalize(normal_matrix * normal);                 // a covector
    vec3 t = (local_to_world * vec4(tangent.xyz, 0.0)).xyz;           // a step: w = 0
    world_tangent.xyz = normalize(t - dot(t, world_normal) * world_normal);
    world_tangent.w = tangent.w * handedness;
    uv = texcoord;
    gl_Position = world_to_clip * world;
}
