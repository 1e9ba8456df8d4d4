/* fix_positions.c: positions that are almost equal made equal (N503): all of a cluster become the
 * one of the least number. */
#include "core/mesh/weld.h"
#include "check/fix/fix.h"
#include <stdlib.h>
#include <string.h>

static const double NEAR = 1e-6; /* of the diagonal, as the rule has it */

static double diagonal_of(const core_mesh *mesh) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY},
           squares = 0;
    for (size_t i = 0; i < mesh->positions.count; i++) {
        double p[3];
        norma_core_position(mesh, (uint32_t)i, p);
        for (int k = 0; k < 3 && norma_core_finite(p); k++) {
            low[k] = fmin(low[k], p[k]);
            high[k] = fmax(high[k], p[k]);
        }
    }
    for (int k = 0; k < 3; k++) squares += (high[k] - low[k]) * (high[k] - low[k]);
    return isfinite(squares) ? sqrt(squares) : 0;
}

/* The clusters in which a marked position lies. */
static norma_result snap(fix_mesh *m, const core_mesh *mesh, const uint8_t *marks) {
    size_t count = mesh->positions.count;
    uint8_t *meant = calloc(count + 1, 1), *set = calloc(count + 1, 1);
    double *positions = malloc((count + 1) * 3 * sizeof *positions);
    m->edit->positions = positions;
    m->edit->set_positions = set;
    if (!meant || !set || !positions) {
        free(meant);
        return NORMA_ERROR_MEMORY;
    }
    for (size_t i = 0; i < count; i++)
        if (marks[i]) meant[norma_core_welded(mesh, (uint32_t)i)] = 1;
    for (size_t i = 0; i < count; i++) {
        double own[3];
        uint32_t least = norma_core_welded(mesh, (uint32_t)i);
        norma_core_position(mesh, least, positions + 3 * i);
        norma_core_position(mesh, (uint32_t)i, own);
        set[i] = meant[least] && memcmp(own, positions + 3 * i, sizeof own) != 0;
    }
    free(meant);
    return NORMA_OK;
}

norma_result norma_fix_positions(fix_mesh *m) {
    uint8_t *marks = NULL;
    core_mesh mesh = m->mesh;
    core_call call;
    int any = norma_fix_mark(m, RULE_N503, MEND_VERTEX, mesh.positions.count, &marks);
    const norma_options options = {.struct_size = sizeof options,
        .weld = NORMA_WELD_DISTANCE,
        .weld_distance = any > 0 ? NEAR * diagonal_of(&mesh) : 0,
        .threads = m->threads};
    norma_result result = any < 0 ? NORMA_ERROR_MEMORY : norma_core_begin(&call, &options);
    if (!result && any > 0) {
        result = norma_core_weld(&call, &mesh);
        if (!result) result = snap(m, &mesh, marks);
        if (mesh.weld) norma_core_unweld(&call, &mesh);
    }
    free(marks);
    return result;
}
