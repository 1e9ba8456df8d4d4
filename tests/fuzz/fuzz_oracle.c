/* fuzz_oracle.c: the core's answers against an independent oracle in exact arithmetic (GMP,
 * tests/support/oracle): normals of faces, vertices and corners, counts of edges, split, plans, and
 * windings made to agree. Meshes are small, on a coarse lattice or of any numbers, so that exact
 * ties, twins, degenerate faces and crowded edges are common. */
#include "fuzz.h"
#include "mesh_files.h"
#include "oracle/compare.h"
#include "oracle/judge.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_POSITIONS = 14, MOST_FACES = 14, MOST_CORNERS = 6 };

typedef struct any_mesh {
    mesh_file file;
    norma_mesh view;
    uint32_t groups[MOST_FACES];
    uint8_t hard[MOST_FACES * MOST_CORNERS];
} any_mesh;

static double coordinate(fuzz_bytes *bytes, int any_number) {
    const uint8_t byte = fuzz_u8(bytes);
    if (any_number && byte >= 200) return (double)fuzz_float(bytes);
    return (double)(byte % 7) - 3;
}

static void take_mesh(fuzz_bytes *bytes, any_mesh *mesh) {
    const uint8_t kind = fuzz_u8(bytes);
    const uint32_t positions = 3 + fuzz_below(bytes, MOST_POSITIONS - 2),
                   faces = 1 + fuzz_below(bytes, MOST_FACES);
    memset(mesh, 0, sizeof *mesh);
    for (uint32_t i = 0; i < positions; ++i) {
        double p[3];
        for (int k = 0; k < 3; ++k) p[k] = coordinate(bytes, kind & 1);
        mesh_file_add_position(&mesh->file, p[0], p[1], p[2]);
    }
    for (uint32_t f = 0; f < faces; ++f) {
        uint32_t corners[MOST_CORNERS];
        const uint32_t count = kind & 2 ? fuzz_below(bytes, MOST_CORNERS + 1) : 3;
        for (uint32_t i = 0; i < count; ++i) corners[i] = fuzz_u8(bytes) % positions;
        mesh_file_add_face(&mesh->file, corners, count);
    }
    mesh->view = mesh_file_view_polygons(&mesh->file);
    for (uint32_t f = 0; f < faces; ++f) mesh->groups[f] = fuzz_u8(bytes) % 4;
    for (size_t c = 0; c < mesh->file.corner_count; ++c) mesh->hard[c] = fuzz_u8(bytes) % 8 == 0;
    if (kind & 4) mesh->view.smoothing_groups = mesh->groups;
    if (kind & 8) mesh->view.hard_edges = mesh->hard;
}

static norma_options take_options(fuzz_bytes *bytes) {
    static const norma_weld welds[] = {NORMA_WELD_EXACT, NORMA_WELD_NONE};
    const uint8_t kind = fuzz_u8(bytes);
    norma_options options = {.struct_size = sizeof options};
    options.weight = (norma_weight)(kind % 7);
    options.weld = welds[kind / 7 % 2];
    options.non_manifold = kind & 128 ? NORMA_NON_MANIFOLD_SMOOTH : NORMA_NON_MANIFOLD_HARD;
    options.threads = kind & 64 ? 2 : 1;
    return options;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    static const float creases[] = {0, 0.5F, 1.04719755F, 1.57079637F, 3.14159274F};
    fuzz_bytes rest = {bytes, size};
    any_mesh mesh;
    take_mesh(&rest, &mesh);
    norma_options options = take_options(&rest);
    const float crease = creases[fuzz_below(&rest, 5)];
    comparison total = {0};
    oracle o;
    oracle_create(&o, &mesh.view, options.weld, 0);
    compare_faces(&total, "fuzz", &o, &mesh.view, &options);
    compare_vertices(&total, "fuzz", &o, &mesh.view, &options, 1);
    compare_corners(&total, "fuzz", &o, &mesh.view, crease, &options);
    total.wrong += judge_split("fuzz", &mesh.view, crease, &options) +
                   judge_plans("fuzz", &o, &mesh.view, crease, &options) +
                   judge_orientation("fuzz", &o, &mesh.view, &options);
    oracle_destroy(&o);
    if (total.wrong) fuzz_fail("%zu answers are not the oracle's", total.wrong);
    mesh_file_free(&mesh.file);
    return 0;
}
