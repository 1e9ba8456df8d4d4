// norma.glsl: normals and tangents in shaders, for GLSL ES 3.00, GLSL 3.30 and GLSL for Vulkan. Paste it after #version, or include it. norma.hlsl and norma.wgsl say the same.
//
// Matrices take columns (model * vector). A zero normal stays zero, and a normal becomes zero if it or a matrix is not finite. No result is a NaN.
// Floats lose digits if products cancel, as in cofactors of stretched models. Factors are therefore split into an integer and a rest. Products and sums of the integers are exact, and no compiler
// rearranges them. The error is at most about 2^-36 of the largest term; with floats alone it is 2^-23.
// Results are within 1e-6 of those of the C library (norma.h), of which each function names the one it follows.
#ifndef NORMA_GLSL
#define NORMA_GLSL
#ifdef GL_ES
precision highp float;
precision highp int;
#endif

// ---- exact enough

// The power of two that brings the largest of three numbers between 1/2 and 1; 0 if one is not finite.
float norma_scale(vec3 v) {
    uvec3 bits = floatBitsToUint(v) & 0x7fffffffu;
    uint largest = max(bits.x, max(bits.y, bits.z));
    return largest >= 0x7f800000u ? 0.0 : uintBitsToFloat(0x7e800000u - min(largest & 0x7f800000u, 0x7e000000u));
}

// Numbers up to 1 in 8192ths.
ivec3 norma_whole(vec3 v) { return ivec3(floor(v * 8192.0 + 0.5)); }

// For vectors of entries up to 1.
float norma_dot(vec3 a, vec3 b) {
    ivec3 p = norma_whole(a), q = norma_whole(b);
    vec3 rest_a = a * 8192.0 - vec3(p), rest_b = b * 8192.0 - vec3(q);
    return (float(p.x * q.x + p.y * q.y + p.z * q.z) + (dot(vec3(p), rest_b) + dot(rest_a, b * 8192.0))) * 1.4901161e-8;
}

vec3 norma_cross(vec3 a, vec3 b) {
    ivec3 p = norma_whole(a), q = norma_whole(b);
    vec3 rest_a = a * 8192.0 - vec3(p), rest_b = b * 8192.0 - vec3(q);
    return (vec3(p.yzx * q.zxy - p.zxy * q.yzx) + (cross(vec3(p), rest_b) + cross(rest_a, b * 8192.0))) * 1.4901161e-8;
}

// The direction of m v: m v times a positive factor.
vec3 norma_direction(mat3 m, vec3 v) {
    float scale = min(norma_scale(m[0]), min(norma_scale(m[1]), norma_scale(m[2]))), scale_v = norma_scale(v);
    if (scale == 0.0 || scale_v == 0.0) return vec3(0.0);
    mat3 rows = transpose(m * scale);
    v *= scale_v;
    return vec3(norma_dot(rows[0], v), norma_dot(rows[1], v), norma_dot(rows[2], v));
}

// The unit vector along v, for any length from 1e-38 to 1e38; zero if v is zero or not finite.
vec3 norma_unit(vec3 v) {
    float scale = norma_scale(v);
    if (scale == 0.0) return vec3(0.0);
    v *= scale;
    float square = dot(v, v);
    return square > 0.0 ? v * inversesqrt(square) : vec3(0.0);
}

// A unit vector perpendicular to the unit vector n: the axis that n leans on least, made perpendicular.
vec3 norma_perpendicular(vec3 n) {
    vec3 size = abs(n);
    vec3 axis = size.y < size.x ? (size.z < size.y ? vec3(0.0, 0.0, 1.0) : vec3(0.0, 1.0, 0.0)) : (size.z < size.x ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0));
    return norma_unit(axis - dot(axis, n) * n);
}

// ---- through matrices

// cof(M) times a positive factor: its columns are the cross products of M's columns.
mat3 norma_cofactors(mat3 model) {
    vec3 scale = vec3(norma_scale(model[0]), norma_scale(model[1]), norma_scale(model[2]));
    if (min(scale.x, min(scale.y, scale.z)) == 0.0) return mat3(0.0);
    vec3 a = model[0] * scale.x, b = model[1] * scale.y, c = model[2] * scale.z, share = max(scale * norma_scale(scale), 1e-30);
    return mat3(norma_cross(b, c) * share.x, norma_cross(c, a) * share.y, norma_cross(a, b) * share.z);
}

// det(M) times a positive factor.
float norma_determinant(mat3 model) {
    return norma_dot(model[0] * norma_scale(model[0]), norma_cross(model[1] * norma_scale(model[1]), model[2] * norma_scale(model[2])));
}

// The normal matrix, sign(det M) cof(M), times a positive factor. It points as the inverse transpose does, needs no division, and is right for flattened models (rank 2) and under mirrors.
// Zeros if every face loses its direction (rank 0 or 1), or if an entry is not finite. norma_normal_matrix with NORMA_WINDING_REVERSED.
mat3 norma_normal_matrix(mat3 model) { return norma_determinant(model) < 0.0 ? -norma_cofactors(model) : norma_cofactors(model); }

// -1 if the model mirrors, else 1. If it mirrors, the winding of front faces is reversed.
float norma_mirror_sign(mat3 model) { return norma_determinant(model) < 0.0 ? -1.0 : 1.0; }

// The unit normal after the model whose normal matrix is given. norma_transform_normals.
vec3 norma_transform_normal(mat3 normal_matrix, vec3 normal) { return norma_unit(norma_direction(normal_matrix, normal)); }

// A tangent is a vector of the surface: it goes through the model itself, never through the normal matrix; then it is made perpendicular to the transformed normal, and its sign is negated if
// the model mirrors. norma_transform_tangents.
vec4 norma_transform_tangent(mat3 model, vec4 tangent, vec3 transformed_normal) {
    vec3 n = norma_unit(transformed_normal), t = norma_unit(norma_direction(model, tangent.xyz));
    float handed = tangent.w * norma_mirror_sign(model);
    if (n == vec3(0.0)) return vec4(t == vec3(0.0) ? vec3(1.0, 0.0, 0.0) : t, handed);
    vec3 across = t - n * norma_dot(n, t);
    across = dot(across, across) > 9.094947e-13 ? norma_unit(across) : norma_perpendicular(n);
    return vec4(norma_unit(across - n * norma_dot(n, across)), handed); // once more: little may have been left
}

// The normal of an instance (EXT_mesh_gpu_instancing): first the instance's own matrix, then the node's; the sign is that of both together. norma_normal_matrix_model_view.
vec3 norma_instance_normal(mat3 node, mat3 instance, vec3 normal) {
    vec3 n = norma_transform_normal(norma_cofactors(node), norma_transform_normal(norma_cofactors(instance), normal));
    return norma_determinant(node) * norma_determinant(instance) < 0.0 ? -n : n;
}

// The matrix that four joints make together; each is the joint's world matrix times its inverse bind matrix. Weights are taken as they are.
mat4 norma_skin_matrix(mat4 joint0, mat4 joint1, mat4 joint2, mat4 joint3, vec4 weights) {
    return joint0 * weights.x + joint1 * weights.y + joint2 * weights.z + joint3 * weights.w;
}

// The normal under a skin: through the normal matrix of the blended matrix. The node's own matrix is left out, as glTF asks. norma_skin_normals.
vec3 norma_skin_normal(mat4 skin, vec3 normal) { return norma_transform_normal(norma_normal_matrix(mat3(skin)), normal); }

// ---- unit vectors in few bits (norma_decode_normals)

int norma_signed_bits(uint code, int place, int bits) {
    int value = int(code << uint(32 - bits * (place + 1))) >> (32 - bits);
    return max(value, 1 - (1 << (bits - 1)));
}

vec3 norma_decode_octahedral_bits(uint code, int bits) {
    int most = (1 << (bits - 1)) - 1;
    ivec2 p = ivec2(norma_signed_bits(code, 0, bits), norma_signed_bits(code, 1, bits));
    ivec2 size = abs(p);
    int z = most - size.x - size.y;
    if (z < 0) p = ivec2(p.x < 0 ? size.y - most : most - size.y, p.y < 0 ? size.x - most : most - size.x);
    return norma_unit(vec3(vec2(p), float(z)));
}

vec3 norma_decode_octahedral_8(uint code) { return norma_decode_octahedral_bits(code, 8); }
vec3 norma_decode_octahedral_12(uint code) { return norma_decode_octahedral_bits(code, 12); }
vec3 norma_decode_octahedral_16(uint code) { return norma_decode_octahedral_bits(code, 16); }

// For an attribute that is read as two snorm numbers already (Meyer et al. 2010).
vec3 norma_decode_octahedral(vec2 p) {
    float z = 1.0 - abs(p.x) - abs(p.y);
    if (z < 0.0) p = vec2((1.0 - abs(p.y)) * (p.x < 0.0 ? -1.0 : 1.0), (1.0 - abs(p.x)) * (p.y < 0.0 ? -1.0 : 1.0));
    return norma_unit(vec3(p, z));
}

vec3 norma_decode_10_10_10_2(uint code) {
    vec3 n = vec3(float(norma_signed_bits(code, 0, 10)), float(norma_signed_bits(code, 1, 10)), float(norma_signed_bits(code, 2, 10)));
    return n == vec3(0.0) ? vec3(0.0, 0.0, 1.0) : norma_unit(n);
}

// ---- for each pixel

// The normal that a normal map bends, in MikkTSpace's order (Mikkelsen 2008): normal and tangent as they are interpolated, neither made unit before; the bitangent from both and the tangent's
// sign; one normalisation at the end. texel: the map's colour from 0 to 1, linear, green up. scale: glTF's normalTexture.scale, for x and y.
vec3 norma_perturb(vec3 normal, vec4 tangent, vec3 texel, float scale) {
    vec3 bent = (2.0 * texel - 1.0) * vec3(scale, scale, 1.0);
    return norma_unit(bent.x * tangent.xyz + bent.y * (tangent.w * cross(normal, tangent.xyz)) + bent.z * normal);
}

// The normal of the face that is drawn, towards the viewer: from dFdx and dFdy of the position in the space of the normals. Vulkan's y runs down.
vec3 norma_flat_normal(vec3 along_x, vec3 along_y) {
#ifdef VULKAN
    return norma_unit(cross(along_y, along_x));
#else
    return norma_unit(cross(along_x, along_y));
#endif
}

// What a two-sided surface shows from its back: front is gl_FrontFacing, with the front clockwise if the model mirrors.
vec3 norma_facing_normal(vec3 normal, bool front) { return front ? normal : -normal; }
#endif
