// Each function of norma.glsl once a vertex; run_glsl.c puts #version and norma.glsl before it, and captures what comes out. shader_judge.c says what the numbers are.
layout(location = 0) in vec4 a0;
layout(location = 1) in vec4 a1;
layout(location = 2) in vec4 a2;
layout(location = 3) in vec4 a3;
layout(location = 4) in vec4 a4;
layout(location = 5) in vec4 a5;
layout(location = 6) in vec4 a6;
layout(location = 7) in vec4 a7;
layout(location = 8) in vec4 a8;
layout(location = 9) in vec4 a9;
layout(location = 10) in vec4 a10;
layout(location = 11) in uvec4 a11;
out vec4 o0, o1, o2, o3, o4, o5, o6, o7, o8, o9, o10, o11, o12, o13;

void main() {
    mat3 model = mat3(a0.xyz, a1.xyz, a2.xyz), second = mat3(a6.xyz, a7.xyz, a8.xyz), matrix = norma_normal_matrix(model);
    vec3 normal = norma_transform_normal(matrix, a3.xyz);
    uint code = a11.x;
    o0 = vec4(matrix[0], norma_mirror_sign(model));
    o1 = vec4(matrix[1], 0.0);
    o2 = vec4(matrix[2], 0.0);
    o3 = vec4(normal, 0.0);
    o4 = norma_transform_tangent(model, a4, normal);
    o5 = vec4(norma_instance_normal(model, second, a3.xyz), 0.0);
    o6 = vec4(norma_skin_normal(norma_skin_matrix(mat4(model), mat4(second), mat4(0.0), mat4(0.0), vec4(a0.w, a1.w, 0.0, 0.0)), a3.xyz), 0.0);
    o7 = vec4(norma_decode_octahedral_8(code), 0.0);
    o8 = vec4(norma_decode_octahedral_12(code), 0.0);
    o9 = vec4(norma_decode_octahedral_16(code), 0.0);
    o10 = vec4(norma_decode_10_10_10_2(code), 0.0);
    o11 = vec4(norma_perturb(a3.xyz, a4, a5.xyz, a5.w), 0.0);
    o12 = vec4(norma_flat_normal(a9.xyz, a10.xyz), 0.0);
    o13 = vec4(norma_facing_normal(norma_decode_octahedral(a9.xy), a9.w > 0.0), 0.0);
}
