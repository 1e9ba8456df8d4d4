#version 300 es
// Lights a pixel with the interpolated normal; a normal map bends it.
precision highp float;
in vec3 world_position, world_normal;
in vec4 world_tangent;
in vec2 uv;
uniform vec3 to_light;                        // unit, world space
uniform vec3 eye;                             // world space
uniform sampler2D normal_map;                 // without a map: one texel of (0.5, 0.5, 1)
out vec4 colour;

void main() {
    // MikkTSpace's order: unit at the vertices, interpolated as they are, made unit once at the end.
    vec3 bitangent = world_tangent.w * cross(world_normal, world_tangent.xyz);
    vec3 bump = 2.0 * texture(normal_map, uv).xyz - 1.0;
    vec3 n = normalize(bump.x * world_tangent.xyz + bump.y * bitangent + bump.z * world_normal);

    vec3 half_way = normalize(to_light + normalize(eye - world_position));
    float diffuse = max(dot(n, to_light), 0.0);
    float specular = diffuse > 0.0 ? pow(max(dot(n, half_way), 0.0), 40.0) : 0.0;
    colour = vec4(vec3(0.05 + 0.8 * diffuse + 0.3 * specular), 1.0);
}
