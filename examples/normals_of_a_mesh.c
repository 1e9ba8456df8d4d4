/* normals_of_a_mesh.c: the normals of a sphere's vertices, against the true ones.
 *
 * The mesh has a seam (the first and the last column of vertices lie at the same places) and poles
 * of many vertices, as meshes with texture coordinates do. Corners at equal positions share one
 * normal by default, so neither shows. */
#include <math.h>
#include <norma/norma.h>
#include <stdio.h>

enum {
    COLUMNS = 32,
    ROWS = 16,
    VERTICES = (COLUMNS + 1) * (ROWS + 1),
    CORNERS = 6 * COLUMNS * ROWS
};

static void make_sphere(float positions[VERTICES][3], uint32_t corners[CORNERS]) {
    size_t c = 0;
    for (uint32_t row = 0; row <= ROWS; ++row)
        for (uint32_t column = 0; column <= COLUMNS; ++column) {
            const double polar = 3.14159265358979 * row / ROWS,
                         turn = 2 * 3.14159265358979 * (column % COLUMNS) / COLUMNS;
            float *p = positions[row * (COLUMNS + 1) + column];
            const double radius = row == 0 || row == ROWS ? 0 : sin(polar);
            p[0] = (float)(radius * cos(turn));
            p[1] = (float)(radius * sin(turn));
            p[2] = (float)cos(polar);
            if (row == ROWS || column == COLUMNS) continue;
            const uint32_t a = row * (COLUMNS + 1) + column, b = a + COLUMNS + 1;
            const uint32_t quad[6] = {a, b, b + 1, a, b + 1, a + 1};
            for (int i = 0; i < 6; ++i) corners[c++] = quad[i];
        }
}

int main(void) {
    static float positions[VERTICES][3], normals[VERTICES][3];
    static uint32_t corners[CORNERS];
    make_sphere(positions, corners);

    const norma_mesh mesh = {.positions = {.data = positions, .count = VERTICES},
        .corners = corners,
        .corner_count = CORNERS};
    norma_report report;
    const norma_result result = norma_vertex_normals(&mesh, NULL, normals[0], VERTICES, &report);
    if (result != NORMA_OK) {
        fprintf(stderr, "%s\n", norma_result_text(result));
        return 1;
    }

    /* A point of the unit sphere is its own normal. */
    double worst = 0;
    for (size_t v = 0; v < VERTICES; ++v) {
        double dot = 0;
        for (int i = 0; i < 3; ++i) dot += (double)normals[v][i] * (double)positions[v][i];
        if (acos(fmin(dot, 1)) > worst) worst = acos(fmin(dot, 1));
    }
    printf("%d vertices; worst difference to the sphere %.2f degrees\n", VERTICES,
        worst * 57.29577951308232);
    printf("faces without a direction (at the poles): %zu; vertices without a normal: %zu\n",
        report.degenerate_faces.count,
        report.non_finite.count + report.unreferenced.count + report.cancelled.count);
    return 0;
}
