/* made_meshes.c: sheets, fans and soups. No two runs differ: the random numbers are our own. */
#include "made_meshes.h"
#include "timing.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static uint64_t random_number(uint64_t *state) {
    uint64_t z = (*state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static double random_unit(uint64_t *state) {
    return (double)(random_number(state) >> 11) * 0x1p-53;
}

static made_mesh room_for(size_t positions, size_t corners, int indexed) {
    made_mesh mesh = {.position_count = positions, .corner_count = corners};
    mesh.positions = bench_memory(positions, sizeof *mesh.positions);
    if (indexed) mesh.corners = bench_memory(corners, sizeof *mesh.corners);
    return mesh;
}

static void set(float position[3], double x, double y, double z) {
    position[0] = (float)x;
    position[1] = (float)y;
    position[2] = (float)z;
}

made_mesh made_grid(size_t triangles) {
    const size_t cells = (size_t)ceil(sqrt((double)triangles / 2)), row = cells + 1;
    made_mesh mesh = room_for(row * row, 6 * cells * cells, 1);
    uint64_t seed = 1;
    for (size_t i = 0; i < row * row; ++i) {
        const double x = (double)(i % row) / (double)cells, y = (double)(i / row) / (double)cells;
        set(mesh.positions[i], x, y,
            0.1 * sin(20 * x) * cos(15 * y) + 0.2 / (double)cells * random_unit(&seed));
    }
    for (size_t i = 0; i < cells * cells; ++i) {
        const uint32_t a = (uint32_t)(i / cells * row + i % cells), b = a + 1,
                       c = a + (uint32_t)row, d = c + 1;
        memcpy(mesh.corners + 6 * i, (uint32_t[]){a, b, d, a, d, c}, 6 * sizeof *mesh.corners);
    }
    return mesh;
}

static uint32_t *random_order(size_t count, uint64_t seed) {
    uint32_t *order = bench_memory(count, sizeof *order);
    for (size_t i = 0; i < count; ++i) order[i] = (uint32_t)i;
    for (size_t i = count; i > 1; --i) {
        const size_t j = random_number(&seed) % i;
        const uint32_t k = order[i - 1];
        order[i - 1] = order[j];
        order[j] = k;
    }
    return order;
}

void made_shuffle(made_mesh *mesh) {
    const size_t faces = mesh->corner_count / 3;
    made_mesh to = room_for(mesh->position_count, mesh->corner_count, 1);
    uint32_t *vertex = random_order(mesh->position_count, 2), *face = random_order(faces, 3);
    for (size_t i = 0; i < mesh->position_count; ++i)
        memcpy(to.positions[vertex[i]], mesh->positions[i], sizeof *to.positions);
    for (size_t f = 0; f < faces; ++f)
        for (size_t k = 0; k < 3; ++k)
            to.corners[3 * (size_t)face[f] + k] = vertex[mesh->corners[3 * f + k]];
    free(vertex);
    free(face);
    made_free(mesh);
    *mesh = to;
}

static void set_on_circle(float position[3], size_t i, size_t count) {
    const double turn = 6.283185307179586 * (double)i / (double)count;
    set(position, cos(turn), sin(turn), 0);
}

made_mesh made_fan(size_t triangles) {
    made_mesh mesh = room_for(triangles + 1, 3 * triangles, 1);
    set(mesh.positions[0], 0, 0, 0.5);
    for (size_t i = 0; i < triangles; ++i) {
        set_on_circle(mesh.positions[i + 1], i, triangles);
        memcpy(mesh.corners + 3 * i,
            (uint32_t[]){0, (uint32_t)i + 1, (uint32_t)((i + 1) % triangles) + 1},
            3 * sizeof *mesh.corners);
    }
    return mesh;
}

made_mesh made_soup(size_t triangles) {
    made_mesh mesh = room_for(3 * triangles, 3 * triangles, 0);
    uint64_t seed = 5;
    for (size_t i = 0; i < triangles; ++i) {
        const double x = 1000 * random_unit(&seed), y = 1000 * random_unit(&seed),
                     z = 1000 * random_unit(&seed);
        for (size_t k = 0; k < 3; ++k)
            set(mesh.positions[3 * i + k], x + random_unit(&seed), y + random_unit(&seed),
                z + random_unit(&seed));
    }
    return mesh;
}

made_mesh made_tips(size_t triangles) {
    const size_t turns = 4099; /* a prime: no point comes twice, and no triangle is so thin that
                                  doubles would not do */
    made_mesh mesh = room_for(2 * triangles, 3 * triangles, 1);
    for (size_t i = 0; i < triangles; ++i) {
        set(mesh.positions[i], 0, 0, 0.5);
        set_on_circle(mesh.positions[triangles + i], i * turns % triangles, triangles);
        memcpy(mesh.corners + 3 * i,
            (uint32_t[]){(uint32_t)i, (uint32_t)(triangles + i),
                (uint32_t)(triangles + (i + 1) % triangles)},
            3 * sizeof *mesh.corners);
    }
    return mesh;
}

void made_free(made_mesh *mesh) {
    free(mesh->positions);
    free(mesh->corners);
    *mesh = (made_mesh){0};
}

norma_mesh made_view(const made_mesh *mesh) {
    return (norma_mesh){.positions = {mesh->positions, mesh->position_count, 0, NORMA_FORMAT_FLOAT},
        .corners = mesh->corners,
        .corner_count = mesh->corner_count};
}
