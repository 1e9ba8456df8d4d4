/* creases_split.c: a cylinder whose side is smooth and whose rims are sharp, as an indexed mesh for
 * a vertex buffer.
 *
 * The faces are polygons: twelve quads and two caps of twelve corners. Edges of more than 60
 * degrees are creases; a vertex on a rim then needs two normals, and becomes two vertices.
 * norma_split is called twice: to count, and to fill. */
#include <math.h>
#include <norma/norma.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDES = 12, POSITIONS = 2 * SIDES, FACES = SIDES + 2, CORNERS = 4 * SIDES + 2 * SIDES };

static void make_cylinder(
    float positions[POSITIONS][3], uint32_t corners[CORNERS], uint32_t starts[FACES + 1]) {
    size_t c = 0, face = 0;
    for (uint32_t i = 0; i < SIDES; ++i) {
        const double turn = 2 * 3.14159265358979 * i / SIDES;
        for (uint32_t top = 0; top < 2; ++top) {
            float *p = positions[i + top * SIDES];
            p[0] = (float)cos(turn);
            p[1] = (float)sin(turn);
            p[2] = (float)top;
        }
        const uint32_t next = (i + 1) % SIDES, quad[4] = {i, next, next + SIDES, i + SIDES};
        starts[face++] = (uint32_t)c;
        for (int k = 0; k < 4; ++k) corners[c++] = quad[k];
    }
    starts[face++] = (uint32_t)c;
    for (uint32_t i = SIDES; i-- > 0;) corners[c++] = i;
    starts[face++] = (uint32_t)c;
    for (uint32_t i = 0; i < SIDES; ++i) corners[c++] = SIDES + i;
    starts[face] = (uint32_t)c;
}

int main(void) {
    float positions[POSITIONS][3];
    uint32_t corners[CORNERS], starts[FACES + 1];
    make_cylinder(positions, corners, starts);

    const norma_mesh mesh = {.positions = {.data = positions, .count = POSITIONS},
        .corners = corners,
        .corner_count = CORNERS,
        .face_starts = starts,
        .face_count = FACES};
    const float crease = 60 * 3.14159265F / 180;
    size_t count = 0;
    if (norma_split(&mesh, crease, NULL, NULL, 0, NULL, NULL, 0, &count, NULL) != NORMA_OK)
        return 1;

    uint32_t new_corners[CORNERS], *source = malloc(count * sizeof *source);
    float(*normals)[3] = malloc(count * sizeof *normals);
    if (!source || !normals) return 1;
    if (norma_split(&mesh, crease, NULL, new_corners, CORNERS, source, normals[0], count, &count,
            NULL) != NORMA_OK)
        return 1;

    printf("%d positions became %zu vertices\n", POSITIONS, count);
    for (size_t v = 0; v < count; ++v)
        if (source[v] == 0)
            printf("position 0 as vertex %zu: normal %.3f %.3f %.3f\n", v, (double)normals[v][0],
                (double)normals[v][1], (double)normals[v][2]);
    free(normals);
    free(source);
    return 0;
}
