/* cancelled.c: N403: vertices around which the weighted normals of faces all but cancel. Where some
 * direction sees all faces at a position from the front there is nothing to look at closer: no
 * weights can make their sum shorter than the least cosine. */
#include "check/rules/mesh_rules.h"
#include "core/call/sort.h"
#include <math.h>
#include <string.h>

enum { POSITIONS_IN_BLOCK = 1 << 13, FEW = 64 };
static const double CANCELLED = 1e-3;

typedef struct member {
    uint32_t vertex, corner;
} member;

typedef struct cancel_pass {
    check_mesh *m;
    check_hits *parts;
} cancel_pass;

static int all_in_front(const check_mesh *m, const uint32_t *corners, size_t count) {
    double sum[3] = {0}, least = 1;
    for (size_t i = 0; i < count; i++) {
        const float *n = m->faces[norma_core_topology_face(&m->topology, corners[i])].normal;
        for (int k = 0; k < 3; k++) sum[k] += (double)n[k];
    }
    double length = sqrt(norma_core_dot(sum, sum));
    for (size_t i = 0; i < count; i++) {
        const check_face *face = &m->faces[norma_core_topology_face(&m->topology, corners[i])];
        if (!norma_check_directed(face)) continue;
        const double cosine = norma_check_dot(face->normal, sum);
        least = cosine < least ? cosine : least;
    }
    return least > 1.01 * CANCELLED * length;
}

/* A face as its corners' weights need it. One of very many corners is not measured again at each of
 * them: its direction, to a float, is there. */
static void measure(const check_mesh *m, size_t face, core_face *geometry) {
    const core_mesh *mesh = &m->topology.mesh;
    enum { MANY = 64 };
    if (norma_core_face_end(mesh, face) - norma_core_face_begin(mesh, face) <= MANY) {
        norma_core_face_geometry(mesh, face, geometry);
        return;
    }
    *geometry = (core_face){.flags = CORE_FACE_DIRECTED};
    for (int k = 0; k < 3; k++) geometry->normal[k] = (double)m->faces[face].normal[k];
}

/* ‖Σ w n‖ / Σ w over the corners of one vertex, by angle; 1 where no face has a direction. */
static double strength(const check_mesh *m, const member *members, size_t count) {
    const core_mesh *mesh = &m->topology.mesh;
    double sum[3] = {0}, weights = 0;
    for (size_t i = 0; i < count; i++) {
        size_t face = norma_core_topology_face(&m->topology, members[i].corner);
        core_face geometry;
        if (!norma_check_directed(&m->faces[face]) ||
            !norma_core_is_kept(mesh, face, members[i].corner))
            continue;
        measure(m, face, &geometry);
        double weight =
            norma_core_corner_weight(mesh, NORMA_WEIGHT_ANGLE, face, &geometry, members[i].corner);
        for (int k = 0; k < 3; k++) sum[k] += weight * geometry.normal[k];
        weights += weight;
    }
    return weights > 0 ? norma_core_length(sum) / weights : 1;
}

static int member_is_less(const void *first, const void *second) {
    const member *a = first, *b = second;
    return a->vertex != b->vertex ? a->vertex < b->vertex : a->corner < b->corner;
}

/* A position counts once, whichever of its vertices is worst. */
static void judge_position(
    const check_mesh *m, check_hits *hits, const uint32_t *corners, size_t count, member *members) {
    double worst = 1;
    uint32_t at = 0;
    if (count < 2 || all_in_front(m, corners, count)) return;
    for (size_t i = 0; i < count; i++)
        members[i] = (member){norma_core_corner(&m->mesh, corners[i]), corners[i]};
    norma_core_sort(members, count, sizeof *members, member_is_less);
    for (size_t begin = 0, end; begin < count; begin = end) {
        for (end = begin + 1; end < count && members[end].vertex == members[begin].vertex;) end++;
        double here = end - begin > 1 ? strength(m, &members[begin], end - begin) : 1;
        if (here < worst) {
            worst = here;
            at = members[begin].vertex;
        }
    }
    if (worst < CANCELLED) norma_check_hit(m->run, hits, worst, norma_check_vertex(at));
}

static void judge_positions(void *context, size_t block, size_t begin, size_t end) {
    const cancel_pass *pass = context;
    const core_corners_of_position *around = &pass->m->topology.corners_of;
    member members[FEW];
    pass->parts[block].least = 1;
    for (size_t p = begin; p < end; p++) {
        size_t count = around->starts[p + 1] - around->starts[p];
        if (count <= FEW)
            judge_position(
                pass->m, &pass->parts[block], &around->corners[around->starts[p]], count, members);
    }
}

static norma_result judge_large(const check_mesh *m, check_hits *hits) {
    const core_corners_of_position *around = &m->topology.corners_of;
    if (around->most <= FEW) return NORMA_OK;
    member *members = norma_core_allocate(&m->run->call, around->most, sizeof *members);
    if (!members) return NORMA_ERROR_MEMORY;
    for (size_t p = 0; p < around->position_count; p++) {
        size_t count = around->starts[p + 1] - around->starts[p];
        if (count > FEW)
            judge_position(m, hits, &around->corners[around->starts[p]], count, members);
    }
    norma_core_release(&m->run->call, members, around->most, sizeof *members);
    return NORMA_OK;
}

static norma_result add_cancelled(check_mesh *m, check_hits *hits) {
    int missing = m->given->info.normals == NORMA_NORMALS_NONE;
    return norma_check_report(m,
        &(check_report){.rule = RULE_N403,
            .severity = missing ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO,
            .unit = "ratio",
            .hits = hits},
        "%z position%s where the normals of the faces cancel, so their average has no direction%s",
        hits->count, norma_check_plural(hits->count),
        missing ? ", and normals will be computed there" : "");
}

norma_result norma_check_cancelled(check_mesh *m) {
    /* In STL no two corners share a vertex. */
    if (!m->mesh.face_count || !norma_check_wants(m, RULE_N403) || m->run->format == NORMA_FILE_STL)
        return NORMA_OK;
    norma_result result = norma_check_faces(m);
    if (!result) result = norma_check_around(m);
    if (result) return result;
    size_t count = m->topology.corners_of.position_count,
           blocks = norma_check_block_count(count, POSITIONS_IN_BLOCK);
    cancel_pass pass = {m, norma_core_allocate(&m->run->call, blocks, sizeof *pass.parts)};
    if (!pass.parts) return NORMA_ERROR_MEMORY;
    memset(pass.parts, 0, blocks * sizeof *pass.parts);
    result = norma_check_blocks(m->run, count, POSITIONS_IN_BLOCK, judge_positions, &pass);
    check_hits hits = {.least = 1};
    for (size_t i = 0; i < blocks; i++) norma_check_hits_merge(m->run, &hits, &pass.parts[i]);
    norma_core_release(&m->run->call, pass.parts, blocks, sizeof *pass.parts);
    if (!result) result = judge_large(m, &hits);
    if (!result && hits.count) return add_cancelled(m, &hits);
    norma_check_hits_free(&hits);
    return result;
}
