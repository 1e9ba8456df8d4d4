/* transform_stream.c: an interleaved vertex buffer baked in place through a mirror with unequal
 * scales: positions, normals, tangents, winding.
 *
 * Each kind goes its own way: positions and tangents through M, normals through the normal matrix;
 * a mirror turns the tangents' sign, and the faces are reversed so that they still face outwards.
 */
#include <norma/norma.h>
#include <stddef.h>
#include <stdio.h>

typedef struct vertex {
    float position[3], normal[3], tangent[4];
} vertex;

int main(void) {
    /* A triangle in the plane x + y = 1. */
    const float n = 0.70710678F;
    vertex vertices[3] = {{{1, 0, 0}, {n, n, 0}, {-n, n, 0, 1}},
        {{0, 1, 0}, {n, n, 0}, {-n, n, 0, 1}}, {{0, 1, 1}, {n, n, 0}, {-n, n, 0, 1}}};
    uint16_t corners[3] = {0, 1, 2};

    const double model[16] = {-2, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1};
    float model_float[16], matrix[9];
    for (int i = 0; i < 16; ++i) model_float[i] = (float)model[i];
    norma_matrix_info info;
    if (norma_normal_matrix(model_float, NORMA_WINDING_REVERSED, matrix, &info) != NORMA_OK)
        return 1;

    const norma_vec3_view positions = {
        .data = vertices[0].position, .count = 3, .stride = sizeof(vertex)};
    const norma_vec3_view normals = {
        .data = vertices[0].normal, .count = 3, .stride = sizeof(vertex)};
    if (norma_transform_positions(model, positions, vertices[0].position, sizeof(vertex), 3) !=
        NORMA_OK)
        return 1;
    if (norma_transform_normals(matrix, normals, vertices[0].normal, sizeof(vertex), 3) != NORMA_OK)
        return 1;
    if (norma_transform_tangents(model_float, vertices[0].tangent, sizeof(vertex), normals, 3,
            vertices[0].tangent, sizeof(vertex), 3) != NORMA_OK)
        return 1;
    if (info.mirrored && norma_reverse_winding(corners, sizeof *corners, 3, NULL, 0) != NORMA_OK)
        return 1;

    const vertex *v = &vertices[0];
    printf("position %6.3f %6.3f %6.3f\n", (double)v->position[0], (double)v->position[1],
        (double)v->position[2]);
    printf("normal   %6.3f %6.3f %6.3f\n", (double)v->normal[0], (double)v->normal[1],
        (double)v->normal[2]);
    printf("tangent  %6.3f %6.3f %6.3f, sign %g\n", (double)v->tangent[0], (double)v->tangent[1],
        (double)v->tangent[2], (double)v->tangent[3]);
    printf("corners  %d %d %d\n", corners[0], corners[1], corners[2]);
    return 0;
}
