/* face_shapes.c: N401 and N402: faces without area, and slivers. */
#include "check/rules/local_rules.h"
#include "check/rules/mesh_rules.h"
#include "core/face/triangle.h"
#include <math.h>
#include <string.h>

enum { FACES_IN_BLOCK = 1 << 14 };
static const double DEGENERATE = 1e-6;
static const double SLIVER_RAD = 0.0017453292519943296; /* 0.1 degrees */

typedef struct shape_pass {
    const check_mesh *m;
    check_shapes *parts;
    int wants_degenerate, wants_slivers;
} shape_pass;

/* Pi for all that are clearly not below SLIVER_RAD: how large they are matters to nobody. */
static double corner_angle(const double before[3], const double here[3], const double after[3]) {
    const double clear = 4 * SLIVER_RAD * SLIVER_RAD;
    double a[3], b[3], cross[3];
    norma_core_subtract(after, here, a);
    norma_core_subtract(before, here, b);
    norma_core_cross(a, b, cross);
    const double along = norma_core_dot(a, b);
    if (along < 0 || norma_core_dot(cross, cross) > clear * along * along) return NORMA_PI;
    return norma_core_angle(norma_core_length(cross), along);
}

/* Over the kept corners of a face that has three or more. */
static double least_angle(const core_topology *t, size_t face) {
    const size_t begin = norma_core_face_begin(&t->mesh, face),
                 last = norma_core_previous_kept(&t->mesh, face, begin);
    double least = NORMA_PI, before[3], here[3], after[3];
    norma_core_position(
        &t->mesh, t->corners[norma_core_previous_kept(&t->mesh, face, last)], before);
    norma_core_position(&t->mesh, t->corners[last], here);
    for (size_t c = begin; c < norma_core_face_end(&t->mesh, face); c++) {
        if (!norma_core_is_kept(&t->mesh, face, c)) continue;
        norma_core_position(&t->mesh, t->corners[c], after);
        least = fmin(least, corner_angle(before, here, after));
        memcpy(before, here, sizeof before);
        memcpy(here, after, sizeof here);
    }
    return least;
}

/* A triangle whose height is at least as many of its longest edge as the sine of the angle has no
 * angle below it; a polygon may have one however large it is. */
static int may_be_sliver(const check_mesh *m, size_t face) {
    size_t corners = norma_core_face_end(&m->mesh, face) - norma_core_face_begin(&m->mesh, face);
    return corners > 3 || (double)m->faces[face].height < 1.01 * SLIVER_RAD;
}

static void judge_shape(const shape_pass *pass, check_shapes *part, size_t face) {
    const check_mesh *m = pass->m;
    double height = (double)m->faces[face].height;
    if (height < DEGENERATE) {
        if (pass->wants_degenerate)
            norma_check_hit(m->run, &part->degenerate, height, norma_check_face(face));
    } else if (pass->wants_slivers && norma_check_directed(&m->faces[face]) &&
               may_be_sliver(m, face)) {
        double angle = least_angle(&m->topology, face);
        if (angle < SLIVER_RAD)
            norma_check_hit(
                m->run, &part->slivers, angle * (180 / NORMA_PI), norma_check_face(face));
    }
}

static void judge_shapes(void *context, size_t block, size_t begin, size_t end) {
    const shape_pass *pass = context;
    pass->parts[block].degenerate.least = pass->parts[block].slivers.least = 1;
    for (size_t f = begin; f < end; f++) judge_shape(pass, &pass->parts[block], f);
}

static norma_result add_findings(check_mesh *m, check_shapes *sum) {
    norma_result result = NORMA_OK;
    if (sum->degenerate.count)
        result = norma_check_report(m,
            &(check_report){.rule = RULE_N401,
                .severity = NORMA_SEVERITY_INFO,
                .unit = "ratio",
                .hits = &sum->degenerate},
            "%z of %z faces are degenerate (almost no area) and have no normal",
            sum->degenerate.count, m->mesh.face_count);
    if (!result && sum->slivers.count)
        result = norma_check_report(m,
            &(check_report){.rule = RULE_N402,
                .severity = NORMA_SEVERITY_INFO,
                .unit = "deg",
                .hits = &sum->slivers},
            "%z of %z faces have an angle below 0.1 degrees (smallest %g); their direction depends "
            "on the last digits of the positions",
            sum->slivers.count, m->mesh.face_count, sum->slivers.worst);
    return result;
}

void norma_check_shapes_drop(check_shapes *sum) {
    norma_check_hits_free(&sum->degenerate);
    norma_check_hits_free(&sum->slivers);
}

norma_result norma_check_shapes_add(check_mesh *m, check_shapes *sum) {
    const norma_result result = add_findings(m, sum);
    norma_check_shapes_drop(sum);
    return result;
}

norma_result norma_check_shapes_look(check_mesh *m, check_shapes *sum) {
    size_t blocks = norma_check_block_count(m->mesh.face_count, FACES_IN_BLOCK);
    sum->degenerate.least = sum->slivers.least = 1;
    if (!blocks || !norma_check_wants_any(m, RULE_N401, RULE_N402)) return NORMA_OK;
    norma_result result = norma_check_faces(m);
    shape_pass pass = {m,
        result ? NULL : norma_core_allocate(&m->run->call, blocks, sizeof *pass.parts),
        norma_check_wants(m, RULE_N401), norma_check_wants(m, RULE_N402)};
    if (!pass.parts) return result ? result : NORMA_ERROR_MEMORY;
    memset(pass.parts, 0, blocks * sizeof *pass.parts);
    result = norma_check_blocks(m->run, m->mesh.face_count, FACES_IN_BLOCK, judge_shapes, &pass);
    for (size_t i = 0; i < blocks; i++) {
        norma_check_hits_merge(m->run, &sum->degenerate, &pass.parts[i].degenerate);
        norma_check_hits_merge(m->run, &sum->slivers, &pass.parts[i].slivers);
    }
    norma_core_release(&m->run->call, pass.parts, blocks, sizeof *pass.parts);
    return result;
}

norma_result norma_check_shapes(check_mesh *m) {
    check_shapes sum = {{0}, {0}};
    norma_result result = norma_check_shapes_look(m, &sum);
    if (!result) result = norma_check_shapes_add(m, &sum);
    norma_check_shapes_drop(&sum);
    return result;
}
