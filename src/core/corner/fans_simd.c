/* fans_simd.c: a batch of stars measured, joined and summed: loops over lanes, compiled for each
 * instruction set as those of measure.c are. */
#include "core/corner/fan_batch.h"
#include "core/call/instruction_set.h"
#include "core/face/measure.h"
#include "core/face/polygon.h"
#include "core/mesh/face_corners.h"

/* ---- directions and votes */

/* The angle where the edges have the dot product own, as core_lanes_angles gives it: of the two
 * greater dot products by an arc tangent, of the least as what those leave of pi. */
CORE_INLINE double angle_at(double own, double next, double previous, double length) {
    const double lesser = next < previous ? next : previous,
                 greater = next < previous ? previous : next, kept = own < lesser ? lesser : own;
    const core_slope a = norma_core_slope(length, kept), b = norma_core_slope(length, greater);
    const double belows = 1 / (a.below * b.below);
    const double angle_a = norma_core_slope_angle(a, a.above * (belows * b.below)),
                 angle_b = norma_core_slope_angle(b, b.above * (belows * a.below));
    return own < lesser ? NORMA_PI - (angle_a + angle_b) : angle_a;
}

/* A triangle's direction is measured from its first corner, whichever corner is looked at: with a
 * and b the edges to the next and the previous corner, and c the edge between those, u x v is a x b
 * at the first corner, c x b at the second, c x a at the third. */
CORE_INLINE void measure_corner(fan_batch *t, size_t i, norma_weight weight) {
    const int by_angle = core_weighed(weight) == CORE_BY_ANGLE;
    const int is_first = t->turn[i] == 0, is_third = t->turn[i] == 2;
    double a[3], b[3], c[3], u[3], v[3];
    for (int k = 0; k < 3; k++) {
        const double p = t->at[k][i], next = t->next_at[k][i], previous = t->previous_at[k][i];
        a[k] = next - p;
        b[k] = previous - p;
        c[k] = next - previous;
        u[k] = is_first ? a[k] : c[k];
        v[k] = is_third ? a[k] : b[k];
    }
    const double x = u[1] * v[2] - u[2] * v[1], y = u[2] * v[0] - u[0] * v[2],
                 z = u[0] * v[1] - u[1] * v[0];
    const double square = x * x + y * y + z * z, length = sqrt(square), inverse = 1 / length;
    const double own = norma_core_dot(a, b), at_next = norma_core_dot(a, c),
                 at_previous = -norma_core_dot(b, c);
    const double angle = by_angle ? angle_at(own, at_next, at_previous, length) : 0;
    t->normal[0][i] = x * inverse;
    t->normal[1][i] = y * inverse;
    t->normal[2][i] = z * inverse;
    t->sure[i] = norma_core_triangle_is_sure(square, is_first   ? own
                                                     : is_third ? at_next
                                                                : at_previous)
                     ? 1
                     : 0;
    t->weight[i] = norma_core_weight_of(
        weight, norma_core_dot(a, a), norma_core_dot(b, b), angle, length, length);
    for (int k = 0; k < 3; k++) t->vote[k][i] = t->weight[i] * t->normal[k][i];
}

/* A polygon's corner: its direction and area are there. Weights are those of face_geometry.c. */
CORE_INLINE void measure_polygon_corner(fan_batch *t, size_t i, norma_weight weight) {
    const int by_angle = core_weighed(weight) == CORE_BY_ANGLE, is_triangle = t->turn[i] != 0;
    double a[3], b[3], cross[3];
    for (int k = 0; k < 3; k++) {
        a[k] = t->next_at[k][i] - t->at[k][i];
        b[k] = t->previous_at[k][i] - t->at[k][i];
    }
    norma_core_cross(a, b, cross);
    const double aa = norma_core_dot(a, a), bb = norma_core_dot(b, b),
                 square = norma_core_dot(cross, cross), own = sqrt(square),
                 length = is_triangle ? t->area[i] : own,
                 along = cross[0] * t->normal[0][i] + cross[1] * t->normal[1][i] +
                         cross[2] * t->normal[2][i];
    const double turn = by_angle ? norma_core_weight_angle(length, norma_core_dot(a, b)) : 0,
                 angle = along < 0 && !is_triangle ? 2 * NORMA_PI - turn : turn;
    const int sure = core_weighed(weight) == CORE_BY_FACE || is_triangle ||
                     (norma_core_corner_is_sure(square, aa * bb) &
                         ((by_angle == 0) | norma_core_turn_is_sure(along, length)));
    t->sure[i] = sure ? t->sure[i] : 0;
    t->weight[i] = norma_core_weight_of(weight, aa, bb, angle, length, t->area[i]);
    for (int k = 0; k < 3; k++) t->vote[k][i] = t->weight[i] * t->normal[k][i];
}

CORE_INLINE void measure_polygons(fan_batch *t, size_t count, norma_weight weight) {
    for (size_t from = 0; from < count; from += CORE_LANES)
        for (size_t i = from; i < from + CORE_LANES; i++) measure_polygon_corner(t, i, weight);
}

CORE_INLINE void measure(fan_batch *t, size_t count, norma_weight weight) {
    for (size_t from = 0; from < count; from += CORE_LANES)
        for (size_t i = from; i < from + CORE_LANES; i++) measure_corner(t, i, weight);
}

CORE_INLINE void measure_all(fan_batch *t, size_t count, int polygons, norma_weight weight) {
    if (polygons) {
        CORE_LOOP_FOR_WEIGHT(weight, measure_polygons, t, count)
    } else {
        CORE_LOOP_FOR_WEIGHT(weight, measure, t, count)
    }
}

/* ---- lanes round a star: from each face to the one whose edge to next is its own edge from
 * previous */

typedef uint32_t index_lanes __attribute__((vector_size(4 * CORE_LANES)));
typedef uint8_t byte_lanes __attribute__((vector_size(CORE_LANES)));

/* Closed stars of few corners, most of them, walked in a register: byte j tells where lane j leads,
 * eight times its number, with LEADS. Were two nexts the same, some corner could not be reached.
 * Vectors by name: left to themselves, compilers unroll the lanes and compare one by one, which
 * takes four times as long. */
CORE_INLINE int walk_closed(
    const uint32_t *next, const uint32_t *previous, uint32_t count, uint8_t *order) {
    enum { LEADS = 0x80, BYTE = 0xff, SHIFT = 56 };
    index_lanes codes = {0}, here, code = (index_lanes){0} + LEADS;
    uint64_t leads_to;
    uint32_t at = LEADS, seen = 0;
    memcpy(&here, previous, sizeof here);
    for (uint32_t i = 0; i < count; i++, code += 8)
        codes |= (index_lanes)(here == (index_lanes){0} + next[i]) & code;
    const byte_lanes bytes = __builtin_convertvector(codes, byte_lanes);
    memcpy(&leads_to, &bytes, sizeof leads_to);
    for (uint32_t i = 0; i < count; i++) {
        order[i] = (uint8_t)((at & SHIFT) / 8);
        seen |= 1U << (at & SHIFT) / 8;
        at = (uint32_t)(leads_to >> (at & SHIFT)) & BYTE;
        if (!at) return 0;
    }
    return at == LEADS && seen == (1U << count) - 1 && count > 2;
}

static inline uint32_t lowest(uint32_t bits) { return (uint32_t)__builtin_ctz(bits); }

/* Any star: open ones begin at the corner whose next is nobody's previous. 0: there is no single
 * way through all corners, so that edges of other than two faces, twins, or fans that only touch
 * are here. */
static int walk(
    const uint32_t *next, const uint32_t *previous, uint32_t count, uint8_t *order, int *open) {
    const uint32_t all = (1U << count) - 1;
    uint32_t same[ORDINARY_CORNERS], any = 0, seen = 0, at = 0;
    for (uint32_t j = 0; j < count; j++) {
        same[j] = 0;
        for (uint32_t i = 0; i < count; i++) same[j] |= (uint32_t)(previous[j] == next[i]) << i;
        any |= same[j];
    }
    *open = any != all;
    if (*open) at = lowest(any ^ all);
    for (uint32_t i = 0; i < count; i++) {
        order[i] = (uint8_t)at;
        seen |= 1U << at;
        if (!same[at]) return *open && seen == all;
        at = lowest(same[at]);
    }
    return !*open && at == 0 && seen == all && count > 2;
}

CORE_INLINE void load_at(const core_mesh *mesh, uint32_t index, batch_lane to[3], size_t lane) {
    double p[3];
    norma_core_position(mesh, index, p);
    for (int k = 0; k < 3; k++) to[k][lane] = p[k];
}

CORE_INLINE void load_lanes(const core_mesh *mesh, const star_list *list, const listed_star *star,
    const uint8_t *order, fan_batch *t) {
    const size_t begin = star->begin,
                 lanes = star->count <= CORE_LANES ? CORE_LANES : ORDINARY_CORNERS;
    double own[3];
    norma_core_position(mesh, star->position, own);
    for (int k = 0; k < 3; k++)
        for (size_t i = 0; i < lanes; i++) t->at[k][begin + i] = own[k];
    load_at(mesh, list->next[begin + order[0]], t->next_at, begin);
    for (size_t i = 0; i < star->count; i++) {
        const size_t corner = begin + order[i];
        double p[3];
        t->lane_of[corner] = (uint8_t)(begin + i);
        t->turn[begin + i] = list->turn[corner];
        norma_core_position(mesh, list->previous[corner], p);
        for (int k = 0; k < 3; k++)
            t->previous_at[k][begin + i] = t->next_at[k][begin + i + 1] = p[k];
    }
}

/* Polygons that keep all their corners and have a direction. */
static void load_faces(
    const core_prepared_mesh *s, const star_list *list, const listed_star *star, fan_batch *t) {
    for (size_t corner = star->begin; corner < (size_t)star->begin + star->count; corner++) {
        const size_t lane = t->lane_of[corner], f = list->face[corner];
        const core_face *face = &s->faces[f];
        const size_t corners =
            norma_core_face_end(&s->mesh, f) - norma_core_face_begin(&s->mesh, f);
        for (int k = 0; k < 3; k++) t->normal[k][lane] = face->normal[k];
        t->area[lane] = face->twice_area;
        t->sure[lane] = (face->flags & CORE_FACE_DIRECTED) && face->kept == corners ? 1 : 0;
    }
}

/* 0: the star is not ordinary. */
CORE_INLINE int order_star(
    const core_mesh *mesh, const star_list *list, listed_star *star, fan_batch *t) {
    uint32_t welded[2][ORDINARY_CORNERS], higher = 0;
    const uint32_t *next = list->next + star->begin, *previous = list->previous + star->begin;
    uint8_t order[ORDINARY_CORNERS];
    int open = 0;
    for (uint32_t i = 0; i < star->count && mesh->weld; i++) {
        welded[0][i] = mesh->weld[next[i]];
        welded[1][i] = mesh->weld[previous[i]];
    }
    if (mesh->weld) {
        next = welded[0];
        previous = welded[1];
    }
    if (!(star->count <= CORE_LANES && walk_closed(next, previous, star->count, order)) &&
        !walk(next, previous, star->count, order, &open))
        return 0;
    for (uint32_t i = 0; i < star->count; i++) higher += star->position < next[i];
    star->higher = (uint8_t)higher;
    star->open = (uint8_t)open;
    load_lanes(mesh, list, star, order, t);
    return 1;
}

#define UNSURE (-4.0)

/* Also across the ends of stars, where they mean nothing. */
CORE_INLINE void compare_normals(fan_batch *t, size_t count) {
    for (size_t from = 0; from < count; from += CORE_LANES)
        for (size_t i = from; i < from + CORE_LANES; i++) {
            const double cosine = t->normal[0][i] * t->normal[0][i + 1] +
                                  t->normal[1][i] * t->normal[1][i + 1] +
                                  t->normal[2][i] * t->normal[2][i + 1];
            t->cosine[i] = t->sure[i] == 0 ? UNSURE : cosine;
        }
}

/* From the last lane to the first; across the gap of an open star everything passes. */
CORE_INLINE void close_star(fan_batch *t, const listed_star *star) {
    const size_t first = star->begin, last = first + star->count - 1U;
    double cosine = 2;
    if (!star->open)
        cosine = t->normal[0][last] * t->normal[0][first] +
                 t->normal[1][last] * t->normal[1][first] +
                 t->normal[2][last] * t->normal[2][first];
    t->cosine[last] = t->sure[last] == 0 ? UNSURE : cosine;
}

/* ---- joining */

/* out begins at the star, back ends there. */
static int is_unmarked(const core_prepared_mesh *s, uint32_t out, uint32_t back) {
    const size_t face = norma_core_face_of(&s->corners_of, back);
    return norma_core_is_unmarked(&s->mesh, out, (uint32_t)norma_core_face_of(&s->corners_of, out),
        (uint32_t)norma_core_previous_in_face(&s->mesh, face, back), (uint32_t)face);
}

/* One bit for each lane whose edge to the following one is cut. 0: too near the crease to tell by
 * the cosine. */
static int find_cuts(const core_prepared_mesh *s, const star_list *list, const fan_batch *t,
    const listed_star *star, uint32_t *cuts) {
    const int marked = s->mesh.hard_edges || s->mesh.smoothing_groups;
    uint32_t corner_of[ORDINARY_CORNERS];
    for (uint32_t i = 0; i < star->count; i++)
        corner_of[t->lane_of[star->begin + i] - star->begin] = list->corners[star->begin + i];
    *cuts = 0;
    for (uint32_t i = 0; i < star->count; i++) {
        const uint32_t following = i + 1U == star->count ? 0 : i + 1;
        if (star->open && !following) break;
        if (marked && !is_unmarked(s, corner_of[following], corner_of[i])) {
            *cuts |= 1U << i;
            continue;
        }
        const core_crease_verdict verdict =
            norma_core_crease_by_cosine(&s->crease, t->cosine[star->begin + i]);
        if (verdict == CORE_CREASE_UNDECIDED) return 0;
        if (verdict == CORE_CREASE_HARD) *cuts |= 1U << i;
    }
    return 1;
}

/* Edges to positions of higher number: one at each face's previous, and at the first one's next if
 * that is another. */
static void count_edges(const core_prepared_mesh *s, const star_list *list, const fan_batch *t,
    const listed_star *star, uint32_t cuts, norma_edges *edges) {
    for (uint32_t i = 0; i < star->count; i++) {
        const uint32_t lane = (uint32_t)t->lane_of[star->begin + i] - star->begin;
        const size_t higher =
            star->position < norma_core_welded(&s->mesh, list->previous[star->begin + i]);
        const int shared = !star->open || lane + 1 < star->count;
        edges->count += higher;
        if (!shared)
            edges->open += higher;
        else if (cuts >> lane & 1)
            edges->hard += higher;
        else
            edges->smooth += higher;
        if (!star->open || lane) continue;
        const size_t first =
            star->position < norma_core_welded(&s->mesh, list->next[star->begin + i]);
        edges->count += first;
        edges->open += first;
    }
}

/* ---- fans: a star that is cut nowhere or once is one, any other as many as there are cuts */

CORE_INLINE void sum_one_fan(fan_batch *t, const listed_star *star) {
    double x = 0, y = 0, z = 0, weight = 0;
    for (uint32_t i = star->begin; i < (uint32_t)star->begin + star->count; i++) {
        const size_t lane = t->lane_of[i];
        x += t->vote[0][lane];
        y += t->vote[1][lane];
        z += t->vote[2][lane];
        weight += t->weight[lane];
    }
    t->sum[0][star->first_fan] = x;
    t->sum[1][star->first_fan] = y;
    t->sum[2][star->first_fan] = z;
    t->total[star->first_fan] = weight;
}

/* From one cut to the next, and then in the order of first corners. */
static uint32_t number_fans(fan_batch *t, const listed_star *star, uint32_t cuts) {
    uint32_t fan_of_lane[ORDINARY_CORNERS], number[ORDINARY_CORNERS + 1], fan = 0, count = 0;
    const uint32_t last = star->count - 1U;
    for (uint32_t i = 0; i < star->count; i++) {
        fan_of_lane[i] = fan;
        number[i] = UINT32_MAX;
        fan += cuts >> i & 1;
    }
    number[star->count] = UINT32_MAX;
    for (uint32_t i = 0; i <= last && !star->open && !(cuts >> last & 1);
         i++) /* the last fan goes on in the first */
        if (fan_of_lane[i] == fan) fan_of_lane[i] = 0;
    for (uint32_t i = 0; i < star->count; i++) {
        uint32_t *of = &number[fan_of_lane[t->lane_of[star->begin + i] - star->begin]];
        if (*of == UINT32_MAX) *of = count++;
        t->fan_of[star->begin + i] = *of;
    }
    return count;
}

static void sum_fans(fan_batch *t, listed_star *star, uint32_t cuts) {
    star->fan_count = (uint8_t)number_fans(t, star, cuts);
    for (uint32_t f = star->first_fan; f < (uint32_t)star->first_fan + star->fan_count; f++)
        t->sum[0][f] = t->sum[1][f] = t->sum[2][f] = t->total[f] = 0;
    for (uint32_t i = star->begin; i < (uint32_t)star->begin + star->count; i++) {
        const size_t f = star->first_fan + t->fan_of[i], lane = t->lane_of[i];
        for (int k = 0; k < 3; k++) t->sum[k][f] += t->vote[k][lane];
        t->total[f] += t->weight[lane];
    }
}

/* Every edge far from the crease and smooth, no marks: what most stars are. -1: not ordinary. */
CORE_INLINE int is_smooth(const core_prepared_mesh *s, fan_batch *t, const listed_star *star) {
    double least = 2;
    close_star(t, star);
    for (size_t i = star->begin; i < (size_t)star->begin + star->count; i++)
        least = t->cosine[i] < least ? t->cosine[i] : least;
    if (least == UNSURE) return -1;
    return norma_core_crease_by_cosine(&s->crease, least) == CORE_CREASE_SMOOTH &&
           !s->mesh.hard_edges && !s->mesh.smoothing_groups;
}

CORE_INLINE int settle_star(const core_prepared_mesh *s, const star_list *list, fan_batch *t,
    listed_star *star, uint32_t first_fan, norma_edges *edges) {
    uint32_t cuts = 0;
    const int smooth = is_smooth(s, t, star);
    if (smooth < 0 || (!smooth && !find_cuts(s, list, t, star, &cuts))) return 0;
    star->first_fan = (uint8_t)first_fan;
    star->fan_count = 1;
    if ((cuts & (cuts - 1)) == 0 && !(cuts && star->open))
        sum_one_fan(t, star);
    else
        sum_fans(t, star, cuts);
    if (!edges) return 1;
    if (star->open || cuts) {
        count_edges(s, list, t, star, cuts, edges);
    } else {
        edges->count += star->higher;
        edges->smooth += star->higher;
    }
    return 1;
}

/* ---- normals */

/* What norma_core_decide_sum does, where neither overflow nor cancelling is near; decided: 0 where
 * they are. */
CORE_INLINE void decide(fan_batch *t, size_t count) {
    for (size_t from = 0; from < count; from += CORE_LANES)
        for (size_t f = from; f < from + CORE_LANES; f++) {
            const double x = t->sum[0][f], y = t->sum[1][f], z = t->sum[2][f],
                         square = x * x + y * y + z * z, length = sqrt(square),
                         inverse = 1 / length;
            t->direction[0][f] = (float)(x * inverse) + 0.0F;
            t->direction[1][f] = (float)(y * inverse) + 0.0F;
            t->direction[2][f] = (float)(z * inverse) + 0.0F;
            t->decided[f] = ((square > NORMA_TINIEST) & (square < NORMA_HUGEST) &
                                (length > 0x1p-20 * t->total[f]))
                                ? 1
                                : 0;
        }
}

static void name_fans(fan_batch *t, size_t count) {
    for (size_t f = 0; f < count; f++) {
        t->fans[f] = (core_fan){
            {t->direction[0][f], t->direction[1][f], t->direction[2][f]}, NORMA_REASON_NONE};
        if (t->decided[f] != 0) continue;
        const double sum[3] = {t->sum[0][f], t->sum[1][f], t->sum[2][f]};
        norma_core_decide_sum(sum, t->total[f], &t->fans[f]);
    }
}

/* So that lanes beyond the last one compute with numbers. */
static void fill_up(fan_batch *t, size_t count) {
    for (size_t i = count; i < count + CORE_LANES; i++) {
        t->turn[i] = 0;
        for (int k = 0; k < 3; k++)
            t->at[k][i] = t->next_at[k][i] = t->previous_at[k][i] = t->normal[k][i] = 0;
        t->area[i] = t->sure[i] = 0;
    }
}

CORE_INLINE int settle(
    const core_prepared_mesh *s, star_list *list, fan_batch *t, norma_edges *edges) {
    uint32_t fans = 0;
    int all = 1;
    for (size_t i = 0; i < list->star_count; i++) {
        listed_star *star = &list->stars[i];
        if (star->scattered) norma_core_ask_for_targets(list, star);
        star->fan_count = (uint8_t)order_star(&s->mesh, list, star, t);
        if (s->faces && star->fan_count) load_faces(s, list, star, t);
    }
    fill_up(t, list->corner_count);
    measure_all(t, list->corner_count, s->faces != NULL, s->call->options.weight);
    compare_normals(t, list->corner_count);
    for (size_t i = 0; i < list->star_count; i++) {
        listed_star *star = &list->stars[i];
        if (star->scattered) norma_core_ask_for_corners(s, star);
        if (star->fan_count && !settle_star(s, list, t, star, fans, edges)) star->fan_count = 0;
        fans += star->fan_count;
        all &= star->fan_count != 0;
    }
    for (size_t f = fans; f < fans + CORE_LANES; f++)
        t->sum[0][f] = t->sum[1][f] = t->sum[2][f] = t->total[f] = 0;
    decide(t, fans);
    name_fans(t, fans);
    return all;
}

/* ---- instruction sets */

static int settle_portable(
    const core_prepared_mesh *s, star_list *list, fan_batch *t, norma_edges *edges) {
    return settle(s, list, t, edges);
}

#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static int settle_avx2(
    const core_prepared_mesh *s, star_list *list, fan_batch *t, norma_edges *edges) {
    return settle(s, list, t, edges);
}
#if defined(CORE_HAS_AVX512)
CORE_FOR_AVX512 static int settle_avx512(
    const core_prepared_mesh *s, star_list *list, fan_batch *t, norma_edges *edges) {
    return settle(s, list, t, edges);
}
#endif
#endif

fans_simd *norma_core_choose_fans(norma_isa isa) {
    static fans_simd *const settles[] = CORE_KERNELS(settle);
    return settles[norma_core_level(isa)];
}
