// norma.wgsl: normals and tangents in shaders, for WebGPU. norma.glsl and norma.hlsl say the same.
//
// Matrices take columns (model * vector). A zero normal stays zero, and a normal becomes zero if it or a matrix is not finite. No result is a NaN.
// Floats lose digits if products cancel, as in cofactors of stretched models. Factors are therefore split into an integer and a rest. Products and sums of the integers are exact, and no compiler
// rearranges them. The error is at most about 2^-36 of the largest term; with floats alone it is 2^-23.
// Results are within 1e-6 of those of the C library (norma.h), of which each function names the one it follows.

// ---- exact enough

// The power of two that brings the largest of three numbers between 1/2 and 1; 0 if one is not finite.
fn norma_scale(v: vec3f) -> f32 {
    let bits = bitcast<vec3u>(v) & vec3u(0x7fffffffu);
    let largest = max(bits.x, max(bits.y, bits.z));
    return select(bitcast<f32>(0x7e800000u - min(largest & 0x7f800000u, 0x7e000000u)), 0.0, largest >= 0x7f800000u);
}

// Numbers up to 1 in 8192ths.
fn norma_whole(v: vec3f) -> vec3i { return vec3i(floor(v * 8192.0 + 0.5)); }

// For vectors of entries up to 1.
fn norma_dot(a: vec3f, b: vec3f) -> f32 {
    let p = norma_whole(a);
    let q = norma_whole(b);
    let rest_a = a * 8192.0 - vec3f(p);
    let rest_b = b * 8192.0 - vec3f(q);
    return (f32(p.x * q.x + p.y * q.y + p.z * q.z) + (dot(vec3f(p), rest_b) + dot(rest_a, b * 8192.0))) * 1.4901161e-8;
}

fn norma_cross(a: vec3f, b: vec3f) -> vec3f {
    let p = norma_whole(a);
    let q = norma_whole(b);
    let rest_a = a * 8192.0 - vec3f(p);
    let rest_b = b * 8192.0 - vec3f(q);
    return (vec3f(p.yzx * q.zxy - p.zxy * q.yzx) + (cross(vec3f(p), rest_b) + cross(rest_a, b * 8192.0))) * 1.4901161e-8;
}

// The direction of m v: m v times a positive factor.
fn norma_direction(m: mat3x3f, v: vec3f) -> vec3f {
    let scale = min(norma_scale(m[0]), min(norma_scale(m[1]), norma_scale(m[2])));
    let scale_v = norma_scale(v);
    if (scale == 0.0 || scale_v == 0.0) { return vec3f(); }
    let rows = transpose(m * scale);
    let scaled = v * scale_v;
    return vec3f(norma_dot(rows[0], scaled), norma_dot(rows[1], scaled), norma_dot(rows[2], scaled));
}

// The unit vector along v, for any length from 1e-38 to 1e38; zero if v is zero or not finite.
fn norma_unit(v: vec3f) -> vec3f {
    let scale = norma_scale(v);
    if (scale == 0.0) { return vec3f(); }
    let scaled = v * scale;
    let square = dot(scaled, scaled);
    if (square > 0.0) { return scaled * inverseSqrt(square); }
    return vec3f();
}

// A unit vector perpendicular to the unit vector n: the axis that n leans on least, made perpendicular.
fn norma_perpendicular(n: vec3f) -> vec3f {
    let size = abs(n);
    var axis = vec3f(1.0, 0.0, 0.0);
    if (size.y < size.x) { axis = vec3f(0.0, 1.0, 0.0); }
    if (size.z < min(size.x, size.y)) { axis = vec3f(0.0, 0.0, 1.0); }
    return norma_unit(axis - dot(axis, n) * n);
}

// ---- through matrices

// cof(M) times a positive factor: its columns are the cross products of M's columns.
fn norma_cofactors(model: mat3x3f) -> mat3x3f {
    let scale = vec3f(norma_scale(model[0]), norma_scale(model[1]), norma_scale(model[2]));
    if (min(scale.x, min(scale.y, scale.z)) == 0.0) { return mat3x3f(); }
    let a = model[0] * scale.x;
    let b = model[1] * scale.y;
    let c = model[2] * scale.z;
    let share = max(scale * norma_scale(scale), vec3f(1e-30));
    return mat3x3f(norma_cross(b, c) * share.x, norma_cross(c, a) * share.y, norma_cross(a, b) * share.z);
}

// det(M) times a positive factor.
fn norma_determinant(model: mat3x3f) -> f32 {
    return norma_dot(model[0] * norma_scale(model[0]), norma_cross(model[1] * norma_scale(model[1]), model[2] * norma_scale(model[2])));
}

// The normal matrix, sign(det M) cof(M), times a positive factor. It points as the inverse transpose does, needs no division, and is right for flattened models (rank 2) and under mirrors.
// Zeros if every face loses its direction (rank 0 or 1), or if an entry is not finite. norma_normal_matrix with NORMA_WINDING_REVERSED.
fn norma_normal_matrix(model: mat3x3f) -> mat3x3f { return norma_mirror_sign(model) * norma_cofactors(model); }

// -1 if the model mirrors, else 1. If it mirrors, the winding of front faces is reversed.
fn norma_mirror_sign(model: mat3x3f) -> f32 { return select(1.0, -1.0, norma_determinant(model) < 0.0); }

// The unit normal after the model whose normal matrix is given. norma_transform_normals.
fn norma_transform_normal(normal_matrix: mat3x3f, normal: vec3f) -> vec3f { return norma_unit(norma_direction(normal_matrix, normal)); }

// A tangent is a vector of the surface: it goes through the model itself, never through the normal matrix; then it is made perpendicular to the transformed normal, and its sign is negated if
// the model mirrors. norma_transform_tangents.
fn norma_transform_tangent(model: mat3x3f, tangent: vec4f, transformed_normal: vec3f) -> vec4f {
    let n = norma_unit(transformed_normal);
    let t = norma_unit(norma_direction(model, tangent.xyz));
    let handed = tangent.w * norma_mirror_sign(model);
    if (all(n == vec3f())) { return vec4f(select(t, vec3f(1.0, 0.0, 0.0), all(t == vec3f())), handed); }
    var across = t - n * norma_dot(n, t);
    if (dot(across, across) > 9.094947e-13) { across = norma_unit(across); } else { across = norma_perpendicular(n); }
    return vec4f(norma_unit(across - n * norma_dot(n, across)), handed); // once more: little may have been left
}

// The normal of an instance (EXT_mesh_gpu_instancing): first the instance's own matrix, then the node's; the sign is that of both together. norma_normal_matrix_model_view.
fn norma_instance_normal(node: mat3x3f, instance: mat3x3f, normal: vec3f) -> vec3f {
    let n = norma_transform_normal(norma_cofactors(node), norma_transform_normal(norma_cofactors(instance), normal));
    return select(n, -n, norma_determinant(node) * norma_determinant(instance) < 0.0);
}

// The matrix that four joints make together; each is the joint's world matrix times its inverse bind matrix. Weights are taken as they are.
fn norma_skin_matrix(joint0: mat4x4f, joint1: mat4x4f, joint2: mat4x4f, joint3: mat4x4f, weights: vec4f) -> mat4x4f {
    return joint0 * weights.x + joint1 * weights.y + joint2 * weights.z + joint3 * weights.w;
}

// The normal under a skin: through the normal matrix of the blended matrix. The node's own matrix is left out, as glTF asks. norma_skin_normals.
fn norma_skin_normal(skin: mat4x4f, normal: vec3f) -> vec3f {
    return norma_transform_normal(norma_normal_matrix(mat3x3f(skin[0].xyz, skin[1].xyz, skin[2].xyz)), normal);
}

// ---- unit vectors in few bits (norma_decode_normals)

fn norma_signed_bits(code: u32, place: u32, bits: u32) -> i32 {
    return max(extractBits(bitcast<i32>(code), place * bits, bits), 1 - (1 << (bits - 1u)));
}

fn norma_decode_octahedral_bits(code: u32, bits: u32) -> vec3f {
    let most = (1 << (bits - 1u)) - 1;
    let p = vec2i(norma_signed_bits(code, 0u, bits), norma_signed_bits(code, 1u, bits));
    let size = abs(p);
    let z = most - size.x - size.y;
    let folded = vec2i(select(most - size.y, size.y - most, p.x < 0), select(most - size.x, size.x - most, p.y < 0));
    return norma_unit(vec3f(vec2f(select(p, folded, z < 0)), f32(z)));
}

fn norma_decode_octahedral_8(code: u32) -> vec3f { return norma_decode_octahedral_bits(code, 8u); }
fn norma_decode_octahedral_12(code: u32) -> vec3f { return norma_decode_octahedral_bits(code, 12u); }
fn norma_decode_octahedral_16(code: u32) -> vec3f { return norma_decode_octahedral_bits(code, 16u); }

// For an attribute that is read as two snorm numbers already (Meyer et al. 2010).
fn norma_decode_octahedral(p: vec2f) -> vec3f {
    let z = 1.0 - abs(p.x) - abs(p.y);
    let folded = vec2f((1.0 - abs(p.y)) * select(1.0, -1.0, p.x < 0.0), (1.0 - abs(p.x)) * select(1.0, -1.0, p.y < 0.0));
    return norma_unit(vec3f(select(p, folded, z < 0.0), z));
}

fn norma_decode_10_10_10_2(code: u32) -> vec3f {
    let n = vec3f(f32(norma_signed_bits(code, 0u, 10u)), f32(norma_signed_bits(code, 1u, 10u)), f32(norma_signed_bits(code, 2u, 10u)));
    return select(norma_unit(n), vec3f(0.0, 0.0, 1.0), all(n == vec3f()));
}

// ---- for each pixel

// The normal that a normal map bends, in MikkTSpace's order (Mikkelsen 2008): normal and tangent as they are interpolated, neither made unit before; the bitangent from both and the tangent's
// sign; one normalisation at the end. texel: the map's colour from 0 to 1, linear, green up. scale: glTF's normalTexture.scale, for x and y.
fn norma_perturb(normal: vec3f, tangent: vec4f, texel: vec3f, scale: f32) -> vec3f {
    let bent = (2.0 * texel - 1.0) * vec3f(scale, scale, 1.0);
    return norma_unit(bent.x * tangent.xyz + bent.y * (tangent.w * cross(normal, tangent.xyz)) + bent.z * normal);
}

// The normal of the face that is drawn, towards the viewer: from dpdx and dpdy of the position in the space of the normals, a right-handed one; y runs down the screen.
fn norma_flat_normal(along_x: vec3f, along_y: vec3f) -> vec3f { return norma_unit(cross(along_y, along_x)); }

// What a two-sided surface shows from its back: front is the builtin front_facing, with the front reversed if the model mirrors.
fn norma_facing_normal(normal: vec3f, front: bool) -> vec3f { return select(-normal, normal, front); }
