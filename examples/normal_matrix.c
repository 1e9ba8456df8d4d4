/* normal_matrix.c: what a model matrix does to normals, and the normal matrices of many instances
 * in a shader's layout. */
#include <math.h>
#include <norma/norma.h>
#include <stdio.h>

static void print_normal(const char *name, const float n[3]) {
    printf("%-20s %.3f %.3f %.3f\n", name, (double)n[0], (double)n[1], (double)n[2]);
}

int main(void) {
    /* Column-major, as OpenGL, glTF and Vulkan shaders have it; the same bytes as Direct3D's
     * row-major matrices. */
    const float model[16] = {2, 0, 0, 0, 0, 0.5F, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1};
    float matrix[9];
    norma_matrix_info info;
    if (norma_normal_matrix(model, NORMA_WINDING_REVERSED, matrix, &info) != NORMA_OK) return 1;
    printf("M itself errs by up to %.2f degrees\n", info.worst_error_rad * 57.29577951308232);

    const float diagonal[3] = {0.70710678F, 0.70710678F, 0};
    const float upper[9] = {2, 0, 0, 0, 0.5F, 0, 0, 0, 1};
    float plain[3], right[3];
    const norma_vec3_view in = {.data = diagonal, .count = 1};
    if (norma_transform_normals(upper, in, plain, 0, 1) != NORMA_OK ||
        norma_transform_normals(matrix, in, right, 0, 1) != NORMA_OK)
        return 1;
    print_normal("normal", diagonal);
    print_normal("with M (wrong)", plain);
    print_normal("with normal matrix", right);

    /* A thousand instances, straight into a uniform block: std140 pads each column of a mat3 to 16
     * bytes and the matrix to 48. */
    enum { INSTANCES = 1000 };
    static float models[INSTANCES][16], block[INSTANCES][12];
    for (int i = 0; i < INSTANCES; ++i) {
        const float turn = 0.01F * (float)i;
        const float instance[16] = {cosf(turn), sinf(turn), 0, 0, -3 * sinf(turn), 3 * cosf(turn),
            0, 0, 0, 0, 1, 0, (float)i, 0, 0, 1};
        for (int k = 0; k < 16; ++k) models[i][k] = instance[k];
    }
    if (norma_normal_matrices_strided(models[0], 64, INSTANCES, NORMA_WINDING_REVERSED, block[0],
            48, 16, INSTANCES) != NORMA_OK)
        return 1;
    print_normal("instance 500, x axis", block[500]);
    return 0;
}
