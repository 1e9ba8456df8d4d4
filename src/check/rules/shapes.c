/* shapes.c: N401 to N405: faces without area, slivers, vertices whose normals cancel, polygons that
 * fold or bend. */
#include "check/rules/rules.h"
#include "core/call/call.h"
#include "core/face/face.h"
#include <math.h>
#include <string.h>

/* ---- N401 and N402: faces without area, and slivers. */

enum { FACES_IN_BLOCK = 1 << 14 };
static const double DEGENERATE = 1e-6;
static const double SLIVER_RAD = 0.0017453292519943296; /* 0.1 degrees */

enum { DEGENERATE_FACES, SLIVERS }; /* hits */

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
    for (size_t c = begin; c < norma_core_face_end(&t->mesh, face); ++c) {
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

static void judge_shape(const check_mesh *m, check_sum *part, size_t face) {
    double height = (double)m->faces[face].height;
    if (height < DEGENERATE) {
        if (norma_check_wants(m, RULE_N401))
            norma_check_hit(m->run, &part->hits[DEGENERATE_FACES], height, norma_check_face(face));
    } else if (norma_check_wants(m, RULE_N402) && norma_check_directed(&m->faces[face]) &&
               may_be_sliver(m, face)) {
        double angle = least_angle(&m->topology, face);
        if (angle < SLIVER_RAD)
            norma_check_hit(
                m->run, &part->hits[SLIVERS], angle * (180 / NORMA_PI), norma_check_face(face));
    }
}

static void judge_shapes(const void *m, check_sum *part, size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) judge_shape(m, part, f);
}

norma_result norma_check_shapes_add(check_mesh *m, check_sum *sum) {
    check_hits *degenerate = &sum->hits[DEGENERATE_FACES], *slivers = &sum->hits[SLIVERS];
    const norma_result result = norma_check_report(m,
        &(check_finding){.rule = RULE_N401,
            .severity = NORMA_SEVERITY_INFO,
            .unit = "ratio",
            .hits = degenerate},
        "without area: %z of %z faces are degenerate and have no normal", degenerate->count,
        m->mesh.face_count);
    if (result) return result;
    return norma_check_report(m,
        &(check_finding){
            .rule = RULE_N402, .severity = NORMA_SEVERITY_INFO, .unit = "deg", .hits = slivers},
        "thin as needles: %z of %z faces have an angle below 0.1 degrees (smallest %g); their "
        "direction depends on the last digits of the positions",
        slivers->count, m->mesh.face_count, slivers->worst);
}

norma_result norma_check_shapes_look(check_mesh *m, check_sum *sum) {
    sum->hits[DEGENERATE_FACES].least = sum->hits[SLIVERS].least = 1;
    if (!m->mesh.face_count || !norma_check_wants_any(m, RULE_N401, RULE_N402)) return NORMA_OK;
    const norma_result result = norma_check_faces(m);
    return result ? result
                  : norma_check_gather(
                        m->run, m->mesh.face_count, FACES_IN_BLOCK, judge_shapes, m, sum);
}

norma_result norma_check_shapes(check_mesh *m) {
    check_sum sum = {.twice_area = 0};
    norma_result result = norma_check_shapes_look(m, &sum);
    if (!result) result = norma_check_shapes_add(m, &sum);
    norma_check_sum_free(&sum);
    return result;
}

/* ---- N403: vertices around which the weighted normals of faces all but cancel. Where some
 * direction sees all faces at a position from the front there is nothing to look at closer: no
 * weights can make their sum shorter than the least cosine. */

enum { POSITIONS_IN_BLOCK = 1 << 13, FEW = 64 };
static const double CANCELLED_SHARE = 1e-3;

typedef struct member {
    uint32_t vertex, corner;
} member;

static int all_in_front(const check_mesh *m, const uint32_t *corners, size_t count) {
    double sum[3] = {0}, least = 1;
    for (size_t i = 0; i < count; ++i) {
        const float *n = m->faces[norma_core_topology_face(&m->topology, corners[i])].normal;
        for (int k = 0; k < 3; ++k) sum[k] += (double)n[k];
    }
    double length = sqrt(norma_core_dot(sum, sum));
    for (size_t i = 0; i < count; ++i) {
        const check_face *face = &m->faces[norma_core_topology_face(&m->topology, corners[i])];
        if (!norma_check_directed(face)) continue;
        const double cosine = norma_check_dot(face->normal, sum);
        least = cosine < least ? cosine : least;
    }
    return least > 1.01 * CANCELLED_SHARE * length;
}

/* A face as its corners' weights need it. One of very many corners is not measured again at each of
 * them: its direction, to a float, is there. */
static void measure_cancelled_face(const check_mesh *m, size_t face, core_face *geometry) {
    const core_mesh *mesh = &m->topology.mesh;
    enum { MANY = 64 };
    if (norma_core_face_end(mesh, face) - norma_core_face_begin(mesh, face) <= MANY) {
        norma_core_face_geometry(mesh, face, geometry);
        return;
    }
    *geometry = (core_face){.flags = CORE_FACE_DIRECTED};
    for (int k = 0; k < 3; ++k) geometry->normal[k] = (double)m->faces[face].normal[k];
}

/* ‖Σ w n‖ / Σ w over the corners of one vertex, by angle; 1 where no face has a direction. */
static double strength(const check_mesh *m, const member *members, size_t count) {
    const core_mesh *mesh = &m->topology.mesh;
    double sum[3] = {0}, weights = 0;
    for (size_t i = 0; i < count; ++i) {
        size_t face = norma_core_topology_face(&m->topology, members[i].corner);
        core_face geometry;
        if (!norma_check_directed(&m->faces[face]) ||
            !norma_core_is_kept(mesh, face, members[i].corner))
            continue;
        measure_cancelled_face(m, face, &geometry);
        double weight =
            norma_core_corner_weight(mesh, NORMA_WEIGHT_ANGLE, face, &geometry, members[i].corner);
        for (int k = 0; k < 3; ++k) sum[k] += weight * geometry.normal[k];
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
    for (size_t i = 0; i < count; ++i)
        members[i] = (member){norma_core_corner(&m->mesh, corners[i]), corners[i]};
    norma_core_sort(members, count, sizeof *members, member_is_less);
    for (size_t begin = 0, end; begin < count; begin = end) {
        for (end = begin + 1; end < count && members[end].vertex == members[begin].vertex;) ++end;
        double here = end - begin > 1 ? strength(m, &members[begin], end - begin) : 1;
        if (here < worst) {
            worst = here;
            at = members[begin].vertex;
        }
    }
    if (worst < CANCELLED_SHARE) norma_check_hit(m->run, hits, worst, norma_check_vertex(at));
}

static void judge_positions(const void *context, check_sum *part, size_t begin, size_t end) {
    const check_mesh *m = context;
    const core_corners_of_position *around = &m->topology.corners_of;
    member members[FEW];
    for (size_t p = begin; p < end; ++p) {
        size_t count = around->starts[p + 1] - around->starts[p];
        if (count <= FEW)
            judge_position(m, &part->hits[0], &around->corners[around->starts[p]], count, members);
    }
}

static norma_result judge_large(const check_mesh *m, check_hits *hits) {
    const core_corners_of_position *around = &m->topology.corners_of;
    if (around->most <= FEW) return NORMA_OK;
    member *members = norma_core_allocate(&m->run->call, around->most, sizeof *members);
    if (!members) return NORMA_ERROR_MEMORY;
    for (size_t p = 0; p < around->position_count; ++p) {
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
        &(check_finding){.rule = RULE_N403,
            .severity = missing ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO,
            .unit = "ratio",
            .hits = hits},
        "the normals of the faces cancel at %z position%s, so their average has no direction%s",
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
    check_sum sum = {.hits[0].least = 1};
    result = norma_check_gather(m->run, m->topology.corners_of.position_count, POSITIONS_IN_BLOCK,
        judge_positions, m, &sum);
    if (!result) result = judge_large(m, &sum.hits[0]);
    if (!result) result = add_cancelled(m, &sum.hits[0]);
    norma_check_sum_free(&sum);
    return result;
}

/* ---- N404 and N405: polygons that fold over where a reader cuts them into a fan, and
 * polygons that are not flat. */

enum { POLYGONS_IN_BLOCK = 1 << 12, MOST_CROSSING = 2000 };
static const double FOLD = 1e-6;  /* of the polygon's area: what rounding may turn over */
static const double SLIGHT = .01; /* of its area: as much facing away hardly shows */
static const double OUT_OF_PLANE_SINE = 0.0174524064; /* of 1 degree */

/* Hits; counts of FOLDS and SLIGHT: of them those whose edges cross. SLIGHT: what faces away is
 * next to nothing of the polygon. */
enum { FOLDS, SLIGHT_FOLDS, BENT };

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
    for (size_t c = begin + 1; c < end; ++c) {
        corner_from(mesh, c, origin, b);
        for (int k = 0; k < 3; ++k) centre[k] += b[k] / (double)(end - begin);
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
    for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face); ++c) {
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
    for (size_t i = 0; i < view.count; ++i)
        for (size_t k = i + 2; k < view.count; ++k)
            if ((k + 1) % view.count != i && edges_cross(&view, i, k)) return 1;
    return 0;
}

/* ---- all polygons */

static int position_is_finite(const check_mesh *m, size_t face) {
    for (size_t c = norma_core_face_begin(&m->mesh, face); c < norma_core_face_end(&m->mesh, face);
         ++c) {
        double p[3];
        norma_core_position(&m->mesh, norma_core_corner(&m->mesh, c), p);
        if (!norma_core_finite(p)) return 0;
    }
    return 1;
}

/* Its area cancels though it is broad: one half of it faces away, whichever half that is. */
static void judge_cancelled(const check_mesh *m, check_sum *part, size_t face) {
    if (norma_check_is_sliver(&m->faces[face]) || !position_is_finite(m, face)) return;
    norma_check_hit(m->run, &part->hits[FOLDS], 1, norma_check_face(face));
    ++part->counts[FOLDS];
}

static void judge_polygon(const check_mesh *m, check_sum *part, size_t face) {
    const core_mesh *mesh = &m->topology.mesh;
    if (norma_core_face_end(mesh, face) - norma_core_face_begin(mesh, face) < 4) return;
    if (!norma_check_directed(&m->faces[face])) {
        judge_cancelled(m, part, face);
        return;
    }
    const double normal[3] = {(double)m->faces[face].normal[0], (double)m->faces[face].normal[1],
        (double)m->faces[face].normal[2]};
    const polygon_shape shape = shape_of(mesh, face, normal);
    if (shape.least < -FOLD && !norma_check_is_sliver(&m->faces[face])) {
        const int kind = shape.away < SLIGHT ? SLIGHT_FOLDS : FOLDS;
        norma_check_hit(m->run, &part->hits[kind], -shape.least, norma_check_face(face));
        part->counts[kind] += crosses_itself(mesh, face, normal) != 0;
    }
    if (shape.sine > 0)
        norma_check_hit(m->run, &part->hits[BENT],
            norma_check_arc_sine(fmin(shape.sine, 1)) * (180 / NORMA_PI),
            (check_spot){norma_core_corner(&m->mesh, shape.at), face, SIZE_MAX});
}

static void judge_polygons(const void *m, check_sum *part, size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) judge_polygon(m, part, f);
}

static norma_result add_folded(
    check_mesh *m, norma_severity severity, check_hits *hits, size_t crossing) {
    if (!norma_check_wants(m, RULE_N404)) return NORMA_OK;
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N404,
            .severity = severity,
            .unit = "ratio",
            .no_fix = crossing == hits->count,
            .hits = hits},
        crossing ? "triangles back to front: %z of %z polygons %s over if a reader cuts them "
                   "into a fan from their first corner; %z of them cross%s"
                 : "triangles back to front: %z of %z polygons %s over if a reader cuts them "
                   "into a fan from their first corner",
        hits->count, m->mesh.face_count, hits->count == 1 ? "folds" : "fold", crossing,
        crossing == 1 ? "es itself" : " themselves");
}

norma_result norma_check_polygons_add(check_mesh *m, check_sum *sum) {
    check_hits *bent = &sum->hits[BENT];
    norma_result result =
        add_folded(m, NORMA_SEVERITY_WARNING, &sum->hits[FOLDS], sum->counts[FOLDS]);
    if (!result)
        result =
            add_folded(m, NORMA_SEVERITY_INFO, &sum->hits[SLIGHT_FOLDS], sum->counts[SLIGHT_FOLDS]);
    if (result || !norma_check_wants(m, RULE_N405)) return result;
    return norma_check_report(m,
        &(check_finding){
            .rule = RULE_N405, .severity = NORMA_SEVERITY_INFO, .unit = "deg", .hits = bent},
        "not flat, so that readers cut them differently: %z of %z polygons, by up to %g degrees",
        bent->count, m->mesh.face_count, bent->worst);
}

norma_result norma_check_polygons_look(check_mesh *m, check_sum *sum) {
    if (!m->mesh.face_starts || !m->mesh.face_count ||
        !norma_check_wants_any(m, RULE_N404, RULE_N405))
        return NORMA_OK;
    const norma_result result = norma_check_faces(m);
    return result ? result
                  : norma_check_gather(
                        m->run, m->mesh.face_count, POLYGONS_IN_BLOCK, judge_polygons, m, sum);
}

norma_result norma_check_polygons(check_mesh *m) {
    check_sum sum = {.twice_area = 0};
    norma_result result = norma_check_polygons_look(m, &sum);
    if (!result) result = norma_check_polygons_add(m, &sum);
    norma_check_sum_free(&sum);
    return result;
}
