/* core.c: a program that needs the core alone. Prints bits, so that two builds of the library can
 * be compared. */
#include <norma/norma.h>
#include <stdio.h>
#include <string.h>

static void print_bits(const char *what, const float *numbers, size_t count) {
    printf("%s", what);
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, &numbers[i], sizeof bits);
        printf(" %08lx", (unsigned long)bits);
    }
    printf("\n");
}

int main(void) {
    /* A box of 1 x 2 x 3 leaning on a corner that is pulled out, as six quads. */
    static const float positions[] = {
        0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 2, 0, 0, 0, 3, 1, 0, 3, 1.5F, 2.25F, 3.125F, 0, 2, 3};
    static const uint32_t corners[] = {
        0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};
    static const uint32_t starts[] = {0, 4, 8, 12, 16, 20, 24};
    const norma_mesh mesh = {.positions = {.data = positions, .count = 8},
        .corners = corners,
        .corner_count = 24,
        .face_starts = starts,
        .face_count = 6};
    float normals[72], matrix[9];

    for (int weight = NORMA_WEIGHT_ANGLE; weight <= NORMA_WEIGHT_ANGLE_LENGTHS; ++weight) {
        const norma_options options = {
            .struct_size = sizeof options, .weight = (norma_weight)weight, .threads = 2};
        if (norma_vertex_normals(&mesh, &options, normals, 24, NULL)) return 1;
        print_bits("vertices", normals, 24);
    }
    if (norma_corner_normals(&mesh, 0.5F, NULL, normals, 72, NULL)) return 1;
    print_bits("corners", normals, 72);

    const float model[16] = {2, 0, 0, 0, 0.25F, 0.5F, 0, 0, 0, 0, -1, 0, 7, 8, 9, 1};
    if (norma_normal_matrix(model, NORMA_WINDING_REVERSED, matrix, NULL)) return 1;
    print_bits("matrix", matrix, 9);
    const norma_vec3_view view = {.data = normals, .count = 24};
    if (norma_transform_normals(matrix, view, normals, 12, 24)) return 1;
    print_bits("carried", normals, 72);
    printf("%s\n", norma_version());
    return 0;
}
