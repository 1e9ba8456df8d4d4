// main.vert in WGSL, as a compute shader; run_wgsl.mjs puts norma.wgsl before it.
@group(0) @binding(0) var<storage, read> given: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> result: array<vec4f>;

fn whole(m: mat3x3f) -> mat4x4f { return mat4x4f(vec4f(m[0], 0.0), vec4f(m[1], 0.0), vec4f(m[2], 0.0), vec4f(0.0, 0.0, 0.0, 1.0)); }

@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) at: vec3u) {
    let i = 12u * at.x;
    let o = 14u * at.x;
    if (i >= arrayLength(&given)) { return; }
    let model = mat3x3f(given[i].xyz, given[i + 1u].xyz, given[i + 2u].xyz);
    let second = mat3x3f(given[i + 6u].xyz, given[i + 7u].xyz, given[i + 8u].xyz);
    let matrix = norma_normal_matrix(model);
    let normal = norma_transform_normal(matrix, given[i + 3u].xyz);
    let code = bitcast<u32>(given[i + 11u].x);
    let skin = norma_skin_matrix(whole(model), whole(second), mat4x4f(), mat4x4f(), vec4f(given[i].w, given[i + 1u].w, 0.0, 0.0));
    result[o] = vec4f(matrix[0], norma_mirror_sign(model));
    result[o + 1u] = vec4f(matrix[1], 0.0);
    result[o + 2u] = vec4f(matrix[2], 0.0);
    result[o + 3u] = vec4f(normal, 0.0);
    result[o + 4u] = norma_transform_tangent(model, given[i + 4u], normal);
    result[o + 5u] = vec4f(norma_instance_normal(model, second, given[i + 3u].xyz), 0.0);
    result[o + 6u] = vec4f(norma_skin_normal(skin, given[i + 3u].xyz), 0.0);
    result[o + 7u] = vec4f(norma_decode_octahedral_8(code), 0.0);
    result[o + 8u] = vec4f(norma_decode_octahedral_12(code), 0.0);
    result[o + 9u] = vec4f(norma_decode_octahedral_16(code), 0.0);
    result[o + 10u] = vec4f(norma_decode_10_10_10_2(code), 0.0);
    result[o + 11u] = vec4f(norma_perturb(given[i + 3u].xyz, given[i + 4u], given[i + 5u].xyz, given[i + 5u].w), 0.0);
    result[o + 12u] = vec4f(norma_flat_normal(given[i + 10u].xyz, given[i + 9u].xyz), 0.0); // as if y ran up
    result[o + 13u] = vec4f(norma_facing_normal(norma_decode_octahedral(given[i + 9u].xy), given[i + 9u].w > 0.0), 0.0);
}
