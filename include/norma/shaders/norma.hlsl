// norma.hlsl: normals and tangents in shaders, for HLSL (shader model 4 and later). norma.glsl and norma.wgsl say the same.
//
// Matrices are as mathematics writes them: mul(model, vector). A zero normal stays zero, and a normal becomes zero if it or a matrix is not finite. No result is a NaN.
// Floats lose digits if products cancel, as in cofactors of stretched models. Factors are therefore split into an integer and a rest. Products and sums of the integers are exact, and no compiler
// rearranges them. The error is at most about 2^-36 of the largest term; with floats alone it is 2^-23.
// Results are within 1e-6 of those of the C library (norma.h), of which each function names the one it follows.
#ifndef NORMA_HLSL
#define NORMA_HLSL

// ---- exact enough

// The power of two that brings the largest of three numbers between 1/2 and 1; 0 if one is not finite.
float norma_scale(float3 v) {
    uint3 bits = asuint(v) & 0x7fffffffu;
    uint largest = max(bits.x, max(bits.y, bits.z));
    return largest >= 0x7f800000u ? 0.0 : asfloat(0x7e800000u - min(largest & 0x7f800000u, 0x7e000000u));
}

// Numbers up to 1 in 8192ths.
int3 norma_whole(float3 v) { return int3(floor(v * 8192.0 + 0.5)); }

// For vectors of entries up to 1.
float norma_dot(float3 a, float3 b) {
    int3 p = norma_whole(a), q = norma_whole(b);
    float3 rest_a = a * 8192.0 - float3(p), rest_b = b * 8192.0 - float3(q);
    return (float(p.x * q.x + p.y * q.y + p.z * q.z) + (dot(float3(p), rest_b) + dot(rest_a, b * 8192.0))) * 1.4901161e-8;
}

float3 norma_cross(float3 a, float3 b) {
    int3 p = norma_whole(a), q = norma_whole(b);
    float3 rest_a = a * 8192.0 - float3(p), rest_b = b * 8192.0 - float3(q);
    return (float3(p.yzx * q.zxy - p.zxy * q.yzx) + (cross(float3(p), rest_b) + cross(rest_a, b * 8192.0))) * 1.4901161e-8;
}

// The direction of m v: m v times a positive factor.
float3 norma_direction(float3x3 m, float3 v) {
    float scale = min(norma_scale(m[0]), min(norma_scale(m[1]), norma_scale(m[2]))), scale_v = norma_scale(v);
    if (scale == 0.0 || scale_v == 0.0) return float3(0.0, 0.0, 0.0);
    m = m * scale;
    v = v * scale_v;
    return float3(norma_dot(m[0], v), norma_dot(m[1], v), norma_dot(m[2], v));
}

// The unit vector along v, for any length from 1e-38 to 1e38; zero if v is zero or not finite.
float3 norma_unit(float3 v) {
    float scale = norma_scale(v);
    if (scale == 0.0) return float3(0.0, 0.0, 0.0);
    v = v * scale;
    float square = dot(v, v);
    return square > 0.0 ? v * rsqrt(square) : float3(0.0, 0.0, 0.0);
}

// A unit vector perpendicular to the unit vector n: the axis that n leans on least, made perpendicular.
float3 norma_perpendicular(float3 n) {
    float3 size = abs(n), axis = float3(1.0, 0.0, 0.0);
    if (size.y < size.x) axis = float3(0.0, 1.0, 0.0);
    if (size.z < min(size.x, size.y)) axis = float3(0.0, 0.0, 1.0);
    return norma_unit(axis - dot(axis, n) * n);
}

// ---- through matrices

// cof(M) times a positive factor: its columns are the cross products of M's columns.
float3x3 norma_cofactors(float3x3 model) {
    float3x3 columns = transpose(model);
    float3 scale = float3(norma_scale(columns[0]), norma_scale(columns[1]), norma_scale(columns[2]));
    if (min(scale.x, min(scale.y, scale.z)) == 0.0) return float3x3(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    float3 a = columns[0] * scale.x, b = columns[1] * scale.y, c = columns[2] * scale.z, share = max(scale * norma_scale(scale), 1e-30);
    return transpose(float3x3(norma_cross(b, c) * share.x, norma_cross(c, a) * share.y, norma_cross(a, b) * share.z));
}

// det(M) times a positive factor.
float norma_determinant(float3x3 model) {
    float3x3 columns = transpose(model);
    return norma_dot(columns[0] * norma_scale(columns[0]), norma_cross(columns[1] * norma_scale(columns[1]), columns[2] * norma_scale(columns[2])));
}

// The normal matrix, sign(det M) cof(M), times a positive factor. It points as the inverse transpose does, needs no division, and is right for flattened models (rank 2) and under mirrors.
// Zeros if every face loses its direction (rank 0 or 1), or if an entry is not finite. norma_normal_matrix with NORMA_WINDING_REVERSED.
float3x3 norma_normal_matrix(float3x3 model) {
    float3x3 cofactors = norma_cofactors(model);
    return norma_determinant(model) < 0.0 ? -cofactors : cofactors;
}

// -1 if the model mirrors, else 1. If it mirrors, the winding of front faces is reversed.
float norma_mirror_sign(float3x3 model) { return norma_determinant(model) < 0.0 ? -1.0 : 1.0; }

// The unit normal after the model whose normal matrix is given. norma_transform_normals.
float3 norma_transform_normal(float3x3 normal_matrix, float3 normal) { return norma_unit(norma_direction(normal_matrix, normal)); }

// A tangent is a vector of the surface: it goes through the model itself, never through the normal matrix; then it is made perpendicular to the transformed normal, and its sign is negated if
// the model mirrors. norma_transform_tangents.
float4 norma_transform_tangent(float3x3 model, float4 tangent, float3 transformed_normal) {
    float3 n = norma_unit(transformed_normal), t = norma_unit(norma_direction(model, tangent.xyz));
    float handed = tangent.w * norma_mirror_sign(model);
    if (!any(n)) return float4(any(t) ? t : float3(1.0, 0.0, 0.0), handed);
    float3 across = t - n * norma_dot(n, t);
    across = dot(across, across) > 9.094947e-13 ? norma_unit(across) : norma_perpendicular(n);
    return float4(norma_unit(across - n * norma_dot(n, across)), handed); // once more: little may have been left
}

// The normal of an instance (EXT_mesh_gpu_instancing): first the instance's own matrix, then the node's; the sign is that of both together. norma_normal_matrix_model_view.
float3 norma_instance_normal(float3x3 node, float3x3 instance, float3 normal) {
    float3 n = norma_transform_normal(norma_cofactors(node), norma_transform_normal(norma_cofactors(instance), normal));
    return norma_determinant(node) * norma_determinant(instance) < 0.0 ? -n : n;
}

// The matrix that four joints make together; each is the joint's world matrix times its inverse bind matrix. Weights are taken as they are.
float4x4 norma_skin_matrix(float4x4 joint0, float4x4 joint1, float4x4 joint2, float4x4 joint3, float4 weights) {
    return joint0 * weights.x + joint1 * weights.y + joint2 * weights.z + joint3 * weights.w;
}

// The normal under a skin: through the normal matrix of the blended matrix. The node's own matrix is left out, as glTF asks. norma_skin_normals.
float3 norma_skin_normal(float4x4 skin, float3 normal) { return norma_transform_normal(norma_normal_matrix((float3x3)skin), normal); }

// ---- unit vectors in few bits (norma_decode_normals)

int norma_signed_bits(uint code, int place, int bits) {
    int value = asint(code << uint(32 - bits * (place + 1))) >> (32 - bits);
    return max(value, 1 - (1 << (bits - 1)));
}

float3 norma_decode_octahedral_bits(uint code, int bits) {
    int most = (1 << (bits - 1)) - 1;
    int2 p = int2(norma_signed_bits(code, 0, bits), norma_signed_bits(code, 1, bits));
    int2 size = abs(p);
    int z = most - size.x - size.y;
    if (z < 0) p = int2(p.x < 0 ? size.y - most : most - size.y, p.y < 0 ? size.x - most : most - size.x);
    return norma_unit(float3(p.x, p.y, z));
}

float3 norma_decode_octahedral_8(uint code) { return norma_decode_octahedral_bits(code, 8); }
float3 norma_decode_octahedral_12(uint code) { return norma_decode_octahedral_bits(code, 12); }
float3 norma_decode_octahedral_16(uint code) { return norma_decode_octahedral_bits(code, 16); }

// For an attribute that is read as two snorm numbers already (Meyer et al. 2010).
float3 norma_decode_octahedral(float2 p) {
    float z = 1.0 - abs(p.x) - abs(p.y);
    if (z < 0.0) p = float2((1.0 - abs(p.y)) * (p.x < 0.0 ? -1.0 : 1.0), (1.0 - abs(p.x)) * (p.y < 0.0 ? -1.0 : 1.0));
    return norma_unit(float3(p, z));
}

float3 norma_decode_10_10_10_2(uint code) {
    float3 n = float3(norma_signed_bits(code, 0, 10), norma_signed_bits(code, 1, 10), norma_signed_bits(code, 2, 10));
    return any(n) ? norma_unit(n) : float3(0.0, 0.0, 1.0);
}

// ---- for each pixel

// The normal that a normal map bends, in MikkTSpace's order (Mikkelsen 2008): normal and tangent as they are interpolated, neither made unit before; the bitangent from both and the tangent's
// sign; one normalisation at the end. texel: the map's colour from 0 to 1, linear, green up. scale: glTF's normalTexture.scale, for x and y.
float3 norma_perturb(float3 normal, float4 tangent, float3 texel, float scale) {
    float3 bent = (2.0 * texel - 1.0) * float3(scale, scale, 1.0);
    return norma_unit(bent.x * tangent.xyz + bent.y * (tangent.w * cross(normal, tangent.xyz)) + bent.z * normal);
}

// The normal of the face that is drawn, towards the viewer: from ddx and ddy of the position in the space of the normals, a right-handed one; y runs down the screen.
float3 norma_flat_normal(float3 along_x, float3 along_y) { return norma_unit(cross(along_y, along_x)); }

// What a two-sided surface shows from its back: front is SV_IsFrontFace, with the front reversed if the model mirrors.
float3 norma_facing_normal(float3 normal, bool front) { return front ? normal : -normal; }
#endif
