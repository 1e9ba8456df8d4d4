/* polygons.c: N404 and N405: polygons that fold over where a reader cuts them into a fan, and
 * polygons that are not flat. */
#include "check/rules/local_rules.h"
#include "check/rules/mesh_rules.h"
#include "check/findings/angle.h"
#include "core/face/triangle.h"
#include <math.h>
#include <string.h>

enum { FACES_IN_BLOCK = 1 << 12, MOST_CROSSING = 2000 };
static const double FOLD = 1e-6;  /* of the polygon's area: what rounding may turn over */
static const double SLIGHT = .01; /* of its area: as much facing away hardly shows */
static const double OUT_OF_PLANE_SINE = 0.0174524064; /* of 1 degree */

typedef struct polygon_pass {
    const check_mesh *m;
    check_polygons *parts;
} polygon_pass;

static void corner_from(
    const core_mesh *mesh, size_t corner, const double origin[3], double out[3]) {
    double p[3];
    norma_core_position(mesh, norma_core_corner(mesh, corner), p);
    norma_core_subtract(p, origin, out);
}

typedef struct polygon_shape {
    double least; /* share of the polygon's area that a triangle of its fan has; negative where it
                     faces away */
    double away;  /* the share of all that face away */
    double sine;  /* of the greatest angle of a corner out of the plane through the centre; 0 where
                     none is above OUT_OF_PLANE_SINE */
    size_t at;    /* that corner */
} polygon_shape;

static void measure_fan(const core_mesh *mesh, size_t face, const double origin[3],
    const double normal[3], double centre[3], polygon_shape *shape) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    double a[3] = {0}, b[3], cross[3], sum = 0, least = INFINITY, away = 0;
    for (size_t c = begin + 1; c < end; c++) {
        corner_from(mesh, c, origin, b);
        for (int k = 0; k < 3; k++) centre[k] += b[k] / (double)(end - begin);
        if (c > begin + 1) {
            norma_core_cross(a, b, cross);
            const double area = norma_core_dot(cross, normal);
            sum += area;
            away += area < 0 ? -area : 0;
            least = fmin(least, area);
        }
        memcpy(a, b, sizeof a);
    }
    shape->away = away / sum;
    shape->least = least / sum;
}

/* Corners that are near the plane are passed by: most of them, without a root or a quotient. */
static void measure_height(const core_mesh *mesh, size_t face, const double origin[3],
    const double normal[3], const double centre[3], polygon_shape *shape) {
    const double flat = .99 * OUT_OF_PLANE_SINE * OUT_OF_PLANE_SINE;
    for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face); c++) {
        double p[3], from_centre[3];
        corner_from(mesh, c, origin, p);
        norma_core_subtract(p, centre, from_centre);
        const double height = norma_core_dot(from_centre, normal),
                     square = norma_core_dot(from_centre, from_centre);
        if (square > NORMA_TINIEST && height * height <= flat * square) continue;
        const double sine = square > 0 ? fabs(height) / sqrt(square) : 0;
        if (sine > OUT_OF_PLANE_SINE && sine > shape->sine) {
            shape->sine = sine;
            shape->at = c;
        }
    }
}

static polygon_shape shape_of(const core_mesh *mesh, size_t face, const double normal[3]) {
    polygon_shape shape = {.at = SIZE_MAX};
    double origin[3], centre[3] = {0};
    norma_core_position(mesh, norma_core_corner(mesh, norma_core_face_begin(mesh, face)), origin);
    measure_fan(mesh, face, origin, normal, centre, &shape);
    measure_height(mesh, face, origin, normal, centre, &shape);
    return shape;
}

/* ---- whether a polygon crosses itself, seen along its normal */

typedef struct flat_view {
    const core_mesh *mesh;
    size_t begin, count;
    int x, y;
    double origin[3];
} flat_view;

static void flat_point(const flat_view *view, size_t i, double out[2]) {
    double p[3];
    corner_from(view->mesh, view->begin + i % view->count, view->origin, p);
    out[0] = p[view->x];
    out[1] = p[view->y];
}

static double side(const double a[2], const double b[2], const double p[2]) {
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

static int edges_cross(const flat_view *view, size_t i, size_t k) {
    double a[2], b[2], c[2], d[2];
    flat_point(view, i, a);
    flat_point(view, i + 1, b);
    flat_point(view, k, c);
    flat_point(view, k + 1, d);
    return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

static int crosses_itself(const core_mesh *mesh, size_t face, const double normal[3]) {
    flat_view view = {.mesh = mesh, .begin = norma_core_face_begin(mesh, face)};
    int drop = fabs(normal[0]) > fabs(normal[1]) ? (fabs(normal[0]) > fabs(normal[2]) ? 0 : 2)
                                                 : (fabs(normal[1]) > fabs(normal[2]) ? 1 : 2);
    view.count = norma_core_face_end(mesh, face) - view.begin;
    view.x = drop == 0;
    view.y = drop == 2 ? 1 : 2;
    norma_core_position(mesh, norma_core_corner(mesh, view.begin), view.origin);
    if (view.count > MOST_CROSSING) return 0;
    for (size_t i = 0; i < view.count; i++)
        for (size_t k = i + 2; k < view.count; k++)
            if ((k + 1) % view.count != i && edges_cross(&view, i, k)) return 1;
    return 0;
}

/* ---- all polygons */

static int position_is_finite(const check_mesh *m, size_t face) {
    for (size_t c = norma_core_face_begin(&m->mesh, face); c < norma_core_face_end(&m->mesh, face);
         c++) {
        double p[3];
        norma_core_position(&m->mesh, norma_core_corner(&m->mesh, c), p);
        if (!norma_core_finite(p)) return 0;
    }
    return 1;
}

/* Its area cancels though it is broad: one half of it faces away, whichever half that is. */
static void judge_cancelled(const polygon_pass *pass, check_polygons *part, size_t face) {
    const check_face *shape = &pass->m->faces[face];
    if (norma_check_is_sliver(shape) || !position_is_finite(pass->m, face)) return;
    norma_check_hit(pass->m->run, &part->folds.hits, 1, norma_check_face(face));
    part->folds.crossing++;
}

static void judge_polygon(const polygon_pass *pass, check_polygons *part, size_t face) {
    const check_mesh *m = pass->m;
    const core_mesh *mesh = &m->topology.mesh;
    if (norma_core_face_end(mesh, face) - norma_core_face_begin(mesh, face) < 4) return;
    if (!norma_check_directed(&m->faces[face])) {
        judge_cancelled(pass, part, face);
        return;
    }
    const double normal[3] = {(double)m->faces[face].normal[0], (double)m->faces[face].normal[1],
        (double)m->faces[face].normal[2]};
    const polygon_shape shape = shape_of(mesh, face, normal);
    if (shape.least < -FOLD && !norma_check_is_sliver(&m->faces[face])) {
        check_folds *to = shape.away < SLIGHT ? &part->slight : &part->folds;
        norma_check_hit(m->run, &to->hits, -shape.least, norma_check_face(face));
        to->crossing += crosses_itself(mesh, face, normal) != 0;
    }
    if (shape.sine > 0)
        norma_check_hit(m->run, &part->bent,
            norma_check_arc_sine(fmin(shape.sine, 1)) * (180 / NORMA_PI),
            (check_spot){norma_core_corner(&m->mesh, shape.at), face, SIZE_MAX});
}

static void judge_polygons(void *context, size_t block, size_t begin, size_t end) {
    const polygon_pass *pass = context;
    for (size_t f = begin; f < end; f++) judge_polygon(pass, &pass->parts[block], f);
}

static norma_result add_folded(check_mesh *m, norma_severity severity, check_folds *f) {
    if (!f->hits.count || !norma_check_wants(m, RULE_N404)) return NORMA_OK;
    return norma_check_report(m,
        &(check_report){.rule = RULE_N404,
            .severity = severity,
            .unit = "ratio",
            .no_fix = f->crossing == f->hits.count,
            .hits = &f->hits},
        f->crossing ? "%z of %z polygons %s over if a reader cuts them into a fan from their first "
                      "corner; %z of them cross%s"
                    : "%z of %z polygons %s over if a reader cuts them into a fan from their first "
                      "corner",
        f->hits.count, m->mesh.face_count, f->hits.count == 1 ? "folds" : "fold", f->crossing,
        f->crossing == 1 ? "es itself" : " themselves");
}

static norma_result add_findings(check_mesh *m, check_polygons *sum) {
    norma_result result = add_folded(m, NORMA_SEVERITY_WARNING, &sum->folds);
    if (!result) result = add_folded(m, NORMA_SEVERITY_INFO, &sum->slight);
    if (result || !sum->bent.count || !norma_check_wants(m, RULE_N405)) return result;
    return norma_check_report(m,
        &(check_report){
            .rule = RULE_N405, .severity = NORMA_SEVERITY_INFO, .unit = "deg", .hits = &sum->bent},
        "%z of %z polygons %s not flat, by up to %g degrees; readers cut them differently",
        sum->bent.count, m->mesh.face_count, sum->bent.count == 1 ? "is" : "are", sum->bent.worst);
}

static void add_part(const check_run *run, check_polygons *sum, check_polygons *part) {
    norma_check_hits_merge(run, &sum->folds.hits, &part->folds.hits);
    norma_check_hits_merge(run, &sum->slight.hits, &part->slight.hits);
    norma_check_hits_merge(run, &sum->bent, &part->bent);
    sum->folds.crossing += part->folds.crossing;
    sum->slight.crossing += part->slight.crossing;
}

void norma_check_polygons_drop(check_polygons *sum) {
    norma_check_hits_free(&sum->folds.hits);
    norma_check_hits_free(&sum->slight.hits);
    norma_check_hits_free(&sum->bent);
}

norma_result norma_check_polygons_add(check_mesh *m, check_polygons *sum) {
    const norma_result result = add_findings(m, sum);
    norma_check_polygons_drop(sum);
    return result;
}

norma_result norma_check_polygons_look(check_mesh *m, check_polygons *sum) {
    size_t blocks = norma_check_block_count(m->mesh.face_count, FACES_IN_BLOCK);
    if (!m->mesh.face_starts || !blocks || !norma_check_wants_any(m, RULE_N404, RULE_N405))
        return NORMA_OK;
    norma_result result = norma_check_faces(m);
    polygon_pass pass = {
        m, result ? NULL : norma_core_allocate(&m->run->call, blocks, sizeof *pass.parts)};
    if (!pass.parts) return result ? result : NORMA_ERROR_MEMORY;
    memset(pass.parts, 0, blocks * sizeof *pass.parts);
    result = norma_check_blocks(m->run, m->mesh.face_count, FACES_IN_BLOCK, judge_polygons, &pass);
    for (size_t i = 0; i < blocks; i++) add_part(m->run, sum, &pass.parts[i]);
    norma_core_release(&m->run->call, pass.parts, blocks, sizeof *pass.parts);
    return result;
}

norma_result norma_check_polygons(check_mesh *m) {
    check_polygons sum = {.bent = {0}};
    norma_result result = norma_check_polygons_look(m, &sum);
    if (!result) result = norma_check_polygons_add(m, &sum);
    norma_check_polygons_drop(&sum);
    return result;
}
