/* tangents_indexed.c: a mesh with values per corner, as many exporters give it, becomes buffers for
 * a graphics card: tangents by MikkTSpace's rules, one vertex for all corners that agree, indices
 * of 16 bits if they fit.
 *
 * The mesh is two squares side by side. The texture of the second is mirrored, so that the vertices
 * between them need two tangents. norma_split_tangents is called twice: to count, and to fill. */
#include <norma/norma.h>
#include <stdio.h>
#include <stdlib.h>

enum { CORNERS = 12 };

typedef struct corner {
    float position[3], normal[3], texcoord[2];
    uint8_t colour[4];
} corner;

static void make_squares(corner corners[CORNERS]) {
    static const float square[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    for (int c = 0; c < CORNERS; ++c) {
        const float x = square[c % 6][0], y = square[c % 6][1];
        const int mirrored = c >= 6;
        corners[c] = (corner){{x + (float)mirrored, y, 0}, {0, 0, 1}, {mirrored ? 1 - x : x, y},
            {255, (uint8_t)(127 * y), 0, 255}};
    }
}

int main(void) {
    corner corners[CORNERS];
    make_squares(corners);

    const norma_mesh mesh = {
        .positions = {.data = corners[0].position, .count = CORNERS, .stride = sizeof(corner)},
        .corner_count = CORNERS};
    const norma_attribute normals = {.data = corners[0].normal,
                              .count = CORNERS,
                              .stride = sizeof(corner)},
                          texcoords = {.data = corners[0].texcoord,
                              .count = CORNERS,
                              .stride = sizeof(corner)};
    norma_indexed indexed = {0};
    if (norma_split_tangents(&mesh, &normals, &texcoords, NORMA_TANGENTS_MIKK, NULL, NULL, &indexed,
            NULL) != NORMA_OK)
        return 1;

    const size_t count = indexed.vertex_count, size = norma_index_size(count);
    float(*tangents)[4] = malloc(count * sizeof *tangents);
    corner *vertices = malloc(count * sizeof *vertices);
    indexed = (norma_indexed){.corners = malloc(CORNERS * size),
        .corner_size = size,
        .corner_capacity = CORNERS,
        .source_corners = malloc(count * sizeof *indexed.source_corners),
        .vertex_capacity = count};
    if (!tangents || !vertices || !indexed.corners || !indexed.source_corners) return 1;
    if (norma_split_tangents(&mesh, &normals, &texcoords, NORMA_TANGENTS_MIKK, NULL, tangents[0],
            &indexed, NULL) != NORMA_OK)
        return 1;

    /* Everything else of a vertex comes from its source corner. */
    const norma_stream all = {.data = corners, .count = CORNERS, .size = sizeof(corner)};
    if (norma_copy_values(&all, indexed.source_corners, count, vertices, 0, count) != NORMA_OK)
        return 1;

    printf("%d corners became %zu vertices, indices of %zu bytes\n", CORNERS, count, size);
    for (size_t v = 0; v < count; ++v)
        printf("vertex %zu at %g %g: tangent %g %g %g, sign %+g\n", v,
            (double)vertices[v].position[0], (double)vertices[v].position[1],
            (double)tangents[v][0], (double)tangents[v][1], (double)tangents[v][2],
            (double)tangents[v][3]);
    free(indexed.corners);
    free(indexed.source_corners);
    free(vertices);
    free(tangents);
    return 0;
}
