/* crease_slider.c: ordinary positions, nearly all there are (up to so many triangles, one way round
 * them, directions that doubles decide), by short loops over what is kept; any other by the core's
 * star, which knows everything. Both add in ascending order of corners, so that the bits are the
 * same. */
#include "crease_slider.h"
#include "core/call/call.h"
#include "core/corner/corner.h"
#include "core/face/face.h"
#include <stdlib.h>

enum { MOST_CORNERS = 16, NO_WEIGHT = -1 };
enum { BY_RING = 0, CLOSED, OPEN }; /* how a position is done */

static const double DOUBT =
    0x1p-30; /* a cosine this near to the crease's does not tell; the core's star does */

typedef struct kept_face {
    double normal[3], weight[3];
} kept_face;

struct creases {
    core_call call;
    core_prepared_mesh surface;
    core_star star;
    size_t star_room;
    kept_face *faces;
    uint8_t *kinds;  /* of each position */
    double *least;   /* of each ordinary position, the least cosine round it */
    double *cosines; /* of each corner round a position, on the way round, between its face and the
                        following one */
    uint8_t *way;    /* the same: which of the ascending corners it is */
    float (*whole)[3]; /* of each position, the normal of all its corners together, once it was
                          asked for */
    uint8_t *has_whole;
    float (*alone)[3]; /* of each face, the most visible normal of itself alone, once it was asked
                          for */
    uint8_t *has_alone;
    int weight;   /* faces are weighed by this */
    int whole_of; /* whole normals are made of this weight */
};

/* ---- faces */

/* Measures up to CORE_LANES triangles. Returns one bit for each that doubles decide and that has
 * three corners. */
static unsigned measure(creases *c, size_t first, size_t count, norma_weight weight) {
    const core_mesh *mesh = &c->surface.mesh;
    core_batch batch;
    unsigned sure = 0;
    for (size_t lane = 0; lane < CORE_LANES; ++lane) {
        const size_t corner = 3 * (lane < count ? first + lane : first);
        double p[3][3];
        for (size_t i = 0; i < 3; ++i)
            norma_core_position(mesh, norma_core_corner(mesh, corner + i), p[i]);
        for (int axis = 0; axis < 3; ++axis) {
            batch.u[axis][lane] = p[1][axis] - p[0][axis];
            batch.v[axis][lane] = p[2][axis] - p[0][axis];
            batch.a[axis][lane] = p[2][axis] - p[1][axis];
        }
    }
    norma_core_kernels(c->call.level)->measure(&batch, weight);
    for (size_t lane = 0; lane < count; ++lane) {
        kept_face *face = &c->faces[first + lane];
        for (int i = 0; i < 3; ++i) {
            face->normal[i] = batch.normal[i][lane];
            face->weight[i] = batch.weight[i][lane];
        }
        sure |= (unsigned)(batch.sure[lane] != 0) << lane;
    }
    return sure;
}

/* sure: NULL, or set for each face. */
static void measure_all(creases *c, norma_weight weight, uint8_t *sure) {
    const size_t faces = c->surface.mesh.face_count;
    for (size_t first = 0; first < faces; first += CORE_LANES) {
        const size_t count = faces - first < CORE_LANES ? faces - first : CORE_LANES;
        const unsigned bits = measure(c, first, count, weight);
        for (size_t lane = 0; lane < count && sure; ++lane) sure[first + lane] = bits >> lane & 1;
    }
    c->weight = (int)weight;
}

/* ---- the way round a position, from each face to the one whose edge to next is its own edge from
 * previous */

typedef struct round_position {
    uint32_t count, next[MOST_CORNERS],
        previous[MOST_CORNERS]; /* of each corner, ascending: its face's other positions */
    uint8_t way[MOST_CORNERS];
    int open;
} round_position;

/* The one corner whose next is that position, its number; count: there is none, and count + 1:
 * there are several. */
static uint32_t find_next(const round_position *r, uint32_t position) {
    uint32_t found = r->count;
    for (uint32_t i = 0; i < r->count; ++i)
        if (r->next[i] == position) found = found == r->count ? i : r->count + 1;
    return found;
}

/* 0: there is no single way through all corners, so that edges of other than two faces, twins, or
 * fans that only touch are here. */
static int walk(round_position *r) {
    uint32_t follows[MOST_CORNERS], followed = 0, seen = 0, at = 0;
    const uint32_t all = (1U << r->count) - 1;
    for (uint32_t i = 0; i < r->count; ++i) {
        follows[i] = find_next(r, r->previous[i]);
        if (follows[i] > r->count || (follows[i] < r->count && followed >> follows[i] & 1))
            return 0;
        if (follows[i] < r->count) followed |= 1U << follows[i];
    }
    r->open = followed != all;
    while (r->open && followed >> at & 1) ++at;
    const uint32_t begin = at;
    for (uint32_t i = 0; i < r->count; ++i) {
        r->way[i] = (uint8_t)at;
        seen |= 1U << at;
        at = follows[at];
        if (at == r->count) return seen == all;
    }
    return !r->open && at == begin && seen == all && r->count > 2;
}

static double dot3(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Names the neighbours; 0: a face here is not sure, has an edge of no length, or there are too
 * many. */
static int look_round(const creases *c, uint32_t position, const uint8_t *sure, round_position *r) {
    const core_mesh *mesh = &c->surface.mesh;
    const uint32_t *corners =
        c->surface.corners_of.corners + c->surface.corners_of.starts[position];
    r->count = c->surface.corners_of.starts[position + 1] - c->surface.corners_of.starts[position];
    if (r->count > MOST_CORNERS) return 0;
    for (uint32_t i = 0; i < r->count; ++i) {
        const uint32_t begin = corners[i] / 3 * 3, turn = corners[i] - begin;
        if (!sure[corners[i] / 3]) return 0;
        r->next[i] = norma_core_welded_corner(mesh, begin + (turn + 1) % 3);
        r->previous[i] = norma_core_welded_corner(mesh, begin + (turn + 2) % 3);
        if (r->next[i] == position || r->previous[i] == position || r->next[i] == r->previous[i])
            return 0;
    }
    return walk(r);
}

static void keep_position(creases *c, uint32_t position, const uint8_t *sure) {
    const size_t begin = c->surface.corners_of.starts[position];
    const uint32_t *corners = c->surface.corners_of.corners + begin;
    round_position r;
    c->kinds[position] = BY_RING;
    if (!look_round(c, position, sure, &r)) return;
    c->kinds[position] = r.open ? OPEN : CLOSED;
    c->least[position] = 2;
    for (uint32_t i = 0; i < r.count; ++i) {
        const int last = i + 1 == r.count;
        const double *here = c->faces[corners[r.way[i]] / 3].normal,
                     *there = c->faces[corners[r.way[last ? 0 : i + 1]] / 3].normal;
        c->way[begin + i] = r.way[i];
        c->cosines[begin + i] =
            last && r.open ? 2 : dot3(here, there); /* across a gap everything passes */
        c->least[position] =
            c->cosines[begin + i] < c->least[position] ? c->cosines[begin + i] : c->least[position];
    }
}

/* ---- opening */

static int allocate(creases *c) {
    const core_prepared_mesh *s = &c->surface;
    const size_t positions = s->mesh.positions.count + 1, corners = s->mesh.corner_count + 1,
                 most = s->corners_of.most + 1;
    if (norma_core_star_allocate(&c->call, &c->star, most)) return 0;
    c->star_room = most;
    c->kinds = calloc(positions, sizeof *c->kinds);
    if (s->mesh.face_starts) return c->kinds != NULL;
    c->faces = malloc((s->mesh.face_count + 1) * sizeof *c->faces);
    c->least = malloc(positions * sizeof *c->least);
    c->cosines = malloc(corners * sizeof *c->cosines);
    c->way = malloc(corners);
    c->whole = malloc(positions * sizeof *c->whole);
    c->has_whole = malloc(positions);
    c->alone = malloc((s->mesh.face_count + 1) * sizeof *c->alone);
    c->has_alone = calloc(s->mesh.face_count + 1, 1);
    return c->kinds && c->faces && c->least && c->cosines && c->way && c->whole && c->has_whole &&
           c->alone && c->has_alone;
}

/* Of those that doubles do not decide, some may have no direction. */
static int find_lenders(creases *c, const uint8_t *sure) {
    const core_mesh *mesh = &c->surface.mesh;
    if (norma_core_watch_for_flat(&c->surface)) return 0;
    for (size_t corner = 0; corner < mesh->corner_count; ++corner)
        if (!sure[corner / 3])
            norma_core_mark_flat(&c->surface, norma_core_welded_corner(mesh, corner));
    return !norma_core_borrow_directions(&c->surface);
}

static int keep_triangles(creases *c) {
    const size_t faces = c->surface.mesh.face_count;
    uint8_t *sure = malloc(faces + 1);
    if (!sure) return 0;
    measure_all(c, NORMA_WEIGHT_ANGLE, sure);
    for (size_t p = 0; p < c->surface.mesh.positions.count; ++p)
        keep_position(c, (uint32_t)p, sure);
    const int found = !memchr(sure, 0, faces) || find_lenders(c, sure);
    free(sure);
    return found;
}

creases *creases_open(const norma_mesh *mesh, norma_weld weld) {
    const norma_options options = {.weld = weld};
    core_mesh checked;
    creases *c = calloc(1, sizeof *c);
    if (!c || mesh->hard_edges || mesh->smoothing_groups || norma_core_begin(&c->call, &options) ||
        norma_core_mesh_shape(mesh, &checked) || norma_core_mesh_content(&c->call, &checked) ||
        norma_core_prepared_mesh_open(&c->call, &checked, CORE_FOR_FANS, 0, &c->surface)) {
        free(c);
        return NULL;
    }
    c->weight = c->whole_of = NO_WEIGHT;
    if (allocate(c) && (checked.face_starts || keep_triangles(c))) return c;
    creases_close(c);
    return NULL;
}

void creases_close(creases *c) {
    if (!c) return;
    if (c->star_room) norma_core_star_release(&c->call, &c->star, c->star_room);
    norma_core_prepared_mesh_close(&c->surface);
    free(c->faces);
    free(c->kinds);
    free(c->least);
    free(c->cosines);
    free(c->way);
    free(c->whole);
    free(c->has_whole);
    free(c->alone);
    free(c->has_alone);
    free(c);
}

norma_weld creases_weld(const creases *c) { return c->call.options.weld; }

/* ---- computing */

static void copy3(float *to, const float *from) { memcpy(to, from, 3 * sizeof *to); }

/* 0: some corner has no normal. */
static int compute_by_star(creases *c, uint32_t position, float *normals) {
    core_star *star = &c->star;
    norma_core_star_load(&c->surface, position, 1, star);
    norma_core_star_join_fans(&c->surface, star, NULL);
    norma_core_star_sum(&c->surface, star);
    for (size_t i = 0; i < star->count; ++i) {
        const core_fan *fan = &star->fans[star->fan_of[i]];
        if (fan->reason != NORMA_REASON_NONE) return 0;
        copy3(normals + 3 * (size_t)star->corners[i].corner, fan->normal);
    }
    return 1;
}

typedef struct fan_sum {
    double sum[3], weight;
} fan_sum;

static inline void vote(const kept_face *faces, uint32_t corner, fan_sum *s) {
    const uint32_t number = corner / 3;
    const kept_face *face = &faces[number];
    const double weight = face->weight[corner - 3 * number];
    for (int axis = 0; axis < 3; ++axis) s->sum[axis] += weight * face->normal[axis];
    s->weight += weight;
}

/* The core's decision, and what it comes to where neither overflow nor cancelling is near. 0: they
 * cancel. */
static inline int decide(const fan_sum *s, float normal[3]) {
    const double square = dot3(s->sum, s->sum), length = sqrt(square), inverse = 1 / length;
    if (square > NORMA_TINIEST && square < NORMA_HUGEST && length > 0x1p-20 * s->weight) {
        for (int axis = 0; axis < 3; ++axis) normal[axis] = (float)(s->sum[axis] * inverse) + 0.0F;
        return 1;
    }
    core_fan fan;
    norma_core_decide_sum(s->sum, s->weight, &fan);
    copy3(normal, fan.normal);
    return fan.reason == NORMA_REASON_NONE;
}

/* The most visible normal has no sum; of one fan of several, or, fan_of being NULL, of all corners.
 */
static int see_some(const creases *c, const uint32_t *corners, size_t count, const uint8_t *fan_of,
    size_t fan, float normal[3]) {
    double normals[MOST_CORNERS][3], axis[3];
    size_t members = 0;
    for (size_t i = 0; i < count; ++i)
        if (!fan_of || fan_of[i] == fan)
            memcpy(normals[members++], c->faces[corners[i] / 3].normal, sizeof normals[0]);
    if (!norma_core_smallest_cone((const double(*)[3])normals, members, axis)) return 0;
    norma_core_direction(axis, normal);
    return 1;
}

static int see_one(creases *c, const uint32_t *corner, float normal[3]) {
    const uint32_t face = *corner / 3;
    if (!c->has_alone[face] && !see_some(c, corner, 1, NULL, 0, c->alone[face])) return 0;
    c->has_alone[face] = 1;
    copy3(normal, c->alone[face]);
    return 1;
}

static int is_visible(const creases *c) { return c->call.options.weight == NORMA_WEIGHT_VISIBLE; }

static int make_whole(const creases *c, const uint32_t *corners, size_t count, float normal[3]) {
    fan_sum s = {{0, 0, 0}, 0};
    if (is_visible(c)) return see_some(c, corners, count, NULL, 0, normal);
    for (size_t i = 0; i < count; ++i) vote(c->faces, corners[i], &s);
    return decide(&s, normal);
}

static int compute_whole(
    creases *c, uint32_t position, const uint32_t *corners, size_t count, float *normals) {
    if (!c->has_whole[position] && !make_whole(c, corners, count, c->whole[position])) return 0;
    c->has_whole[position] = 1;
    for (size_t i = 0; i < count; ++i) copy3(normals + 3 * (size_t)corners[i], c->whole[position]);
    return 1;
}

/* One bit for each step of the way that is cut. 0: too near the crease to tell by the cosine. */
static int find_cuts(const creases *c, size_t begin, size_t count, uint32_t *cuts) {
    const double crease = c->surface.crease.cosine;
    int told = 1;
    *cuts = 0;
    for (size_t i = 0; i < count; ++i) {
        const double cosine = c->cosines[begin + i];
        *cuts |= (uint32_t)(cosine < crease - DOUBT) << i;
        told &= (cosine > crease + DOUBT) | (cosine < crease - DOUBT);
    }
    return told;
}

/* Where the ways from one cut to the next lie, in the order of the way; behind the last cut of a
 * closed way the first begins. Returns how many there are. */
static uint8_t part_fans(const creases *c, size_t begin, size_t count, uint32_t cuts, int open,
    uint8_t fan_of[MOST_CORNERS]) {
    const uint8_t fans = (uint8_t)(__builtin_popcount(cuts) + (open ? 1 : 0));
    uint8_t fan = 0;
    for (size_t i = 0; i < count; ++i) {
        fan_of[c->way[begin + i]] = fan == fans ? 0 : fan;
        fan = (uint8_t)(fan + (cuts >> i & 1));
    }
    return fans;
}

static int sum_fans(const creases *c, const uint32_t *corners, size_t count, const uint8_t *fan_of,
    uint8_t fans, float of_fan[MOST_CORNERS][3]) {
    fan_sum sums[MOST_CORNERS];
    for (size_t f = 0; f < fans; ++f) sums[f] = (fan_sum){{0, 0, 0}, 0};
    for (size_t i = 0; i < count; ++i) vote(c->faces, corners[i], &sums[fan_of[i]]);
    for (size_t f = 0; f < fans; ++f)
        if (!decide(&sums[f], of_fan[f])) return 0;
    return 1;
}

static int see_fans(creases *c, const uint32_t *corners, size_t count, const uint8_t *fan_of,
    uint8_t fans, float of_fan[MOST_CORNERS][3]) {
    uint8_t members[MOST_CORNERS] = {0}, last[MOST_CORNERS];
    for (size_t i = 0; i < count; ++i) {
        ++members[fan_of[i]];
        last[fan_of[i]] = (uint8_t)i;
    }
    for (size_t f = 0; f < fans; ++f)
        if (!(members[f] == 1 ? see_one(c, &corners[last[f]], of_fan[f])
                              : see_some(c, corners, count, fan_of, f, of_fan[f])))
            return 0;
    return 1;
}

static int compute_fans(creases *c, size_t begin, const uint32_t *corners, size_t count,
    uint32_t cuts, int open, float *normals) {
    uint8_t fan_of[MOST_CORNERS];
    float of_fan[MOST_CORNERS][3];
    const uint8_t fans = part_fans(c, begin, count, cuts, open, fan_of);
    if (!(is_visible(c) ? see_fans(c, corners, count, fan_of, fans, of_fan)
                        : sum_fans(c, corners, count, fan_of, fans, of_fan)))
        return 0;
    for (size_t i = 0; i < count; ++i) copy3(normals + 3 * (size_t)corners[i], of_fan[fan_of[i]]);
    return 1;
}

static int compute_position(creases *c, uint32_t position, float *normals) {
    const size_t begin = c->surface.corners_of.starts[position],
                 count = c->surface.corners_of.starts[position + 1] - begin;
    const uint32_t *corners = c->surface.corners_of.corners + begin;
    const int open = c->kinds[position] == OPEN;
    uint32_t cuts;
    if (count == 0) return 1;
    if (c->kinds[position] == BY_RING) return compute_by_star(c, position, normals);
    if (c->least[position] > c->surface.crease.cosine + DOUBT)
        return compute_whole(c, position, corners, count, normals);
    if (!find_cuts(c, begin, count, &cuts)) return compute_by_star(c, position, normals);
    if ((cuts & (cuts - 1)) == 0 && !(cuts && open))
        return compute_whole(c, position, corners, count, normals);
    return compute_fans(c, begin, corners, count, cuts, open, normals);
}

int creases_compute(creases *c, float crease_rad, norma_weight weight, float *normals) {
    if (!(crease_rad == crease_rad)) return 0;
    c->call.options.weight = weight;
    c->surface.crease = norma_core_crease_at((double)crease_rad);
    if (c->faces && c->weight != (int)weight && !is_visible(c)) measure_all(c, weight, NULL);
    if (c->faces && c->whole_of != (int)weight)
        memset(c->has_whole, 0, c->surface.mesh.positions.count);
    c->whole_of = (int)weight;
    for (size_t p = 0; p < c->surface.mesh.positions.count; ++p)
        if (!compute_position(c, (uint32_t)p, normals)) return 0;
    return 1;
}
