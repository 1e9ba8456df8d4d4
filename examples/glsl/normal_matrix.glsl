// The normal matrix without an inverse, for models that change on the GPU: sign(det M) cof(M).
mat3 normal_matrix_of(mat3 m) {
    mat3 cofactor = mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
    return dot(m[0], cofactor[0]) < 0.0 ? -cofactor : cofactor;
}

// "Stop using normal matrices": right for rotations and scales along the model's own axes.
// Wrong with shear, not a number if a column is zero.
vec3 normal_without_matrix(mat3 m, vec3 n) {
    return m * (n / vec3(dot(m[0], m[0]), dot(m[1], m[1]), dot(m[2], m[2])));
}
