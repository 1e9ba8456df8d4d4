/* seams.c: N501: normals that differ across a seam of UVs, colours or materials in the middle of a
 * smooth surface. The primitives of one glTF mesh are judged together (seams_joined.c). */
#include "check/rules/seams.h"
#include "core/face/triangle.h"
#include <string.h>

enum { POSITIONS_IN_BLOCK = 1 << 13 };

typedef struct seam_pass {
    check_mesh *m;
    double least;                /* radians */
    const seam_creases *creases; /* NULL: not known yet */
    check_hits *parts;
} seam_pass;

static void judge_positions(void *context, size_t block, size_t begin, size_t end) {
    const seam_pass *pass = context;
    const check_mesh *m = pass->m;
    for (size_t p = begin; p < end; p++) {
        double angle = norma_check_seam_angle(m, p, pass->least, pass->creases);
        if (angle > 0)
            norma_check_hit(
                m->run, &pass->parts[block], angle * (180 / NORMA_PI), norma_check_vertex(p));
    }
}

static int can_be_joined(const check_mesh *m) {
    const norma_mesh_attributes *a = &m->given->attributes;
    int per_vertex = m->given->info.normals == NORMA_NORMALS_PER_VERTEX &&
                     !m->given->data.corner_normals &&
                     norma_check_normal_count(m) == m->mesh.positions.count;
    return per_vertex && !m->mesh.face_starts && !a->corner_texcoords && !a->face_materials;
}

/* hits: of all positions. */
static norma_result gather_seams(
    check_mesh *m, double least, const seam_creases *creases, check_hits *hits) {
    size_t count = m->topology.corners_of.position_count,
           blocks = norma_check_block_count(count, POSITIONS_IN_BLOCK);
    seam_pass pass = {
        m, least, creases, norma_core_allocate(&m->run->call, blocks, sizeof *pass.parts)};
    if (!pass.parts) return NORMA_ERROR_MEMORY;
    memset(pass.parts, 0, blocks * sizeof *pass.parts);
    const norma_result result =
        norma_check_blocks(m->run, count, POSITIONS_IN_BLOCK, judge_positions, &pass);
    for (size_t i = 0; i < blocks; i++) norma_check_hits_merge(m->run, hits, &pass.parts[i]);
    norma_core_release(&m->run->call, pass.parts, blocks, sizeof *pass.parts);
    return result;
}

/* The file's own crease is looked for only where there may be a seam. */
static norma_result judge_seams(check_mesh *m, check_hits *hits) {
    const double least = norma_check_seam_least(m->given->info.encoding);
    seam_creases creases;
    norma_result result = gather_seams(m, least, NULL, hits);
    if (result || !hits->count) return result;
    norma_check_hits_free(hits);
    norma_check_seam_creases(m, least, &creases);
    return gather_seams(m, least, &creases, hits);
}

norma_result norma_check_seams(check_mesh *m) {
    const norma_mesh_attributes *a = &m->given->attributes;
    if (!m->mesh.face_count || !norma_check_wants(m, RULE_N501) || !norma_check_normal_count(m) ||
        m->given->info.normals == NORMA_NORMALS_PER_FACET ||
        (!m->siblings && !a->texcoords && !a->colors && !a->face_materials))
        return NORMA_OK;
    int other_frame = 0;
    norma_result result = NORMA_OK;
    if (m->siblings && can_be_joined(m)) {
        result = norma_check_is_of_another_frame(m, &other_frame);
        return result || other_frame ? result : norma_check_seams_hold(m);
    }
    result = norma_check_faces(m);
    if (!result) result = norma_check_pairs(m);
    if (result) return result;
    check_hits hits = {0};
    result = judge_seams(m, &hits);
    if (!result && hits.count) result = norma_check_is_of_another_frame(m, &other_frame);
    if (!result && hits.count && !other_frame) return norma_check_add_seams(m, &hits);
    norma_check_hits_free(&hits);
    return result;
}
