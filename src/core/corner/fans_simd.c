/* fans_simd.c: a batch of stars joined and summed: loops over lanes, compiled for each instruction
 * set as those of measure.c are. */
#include "core/corner/fan_batch.h"
#include "core/call/instruction_set.h"
#include "core/face/measure.h"
#include "core/face/polygon.h"
#include "core/mesh/face_corners.h"

/* ---- weights of polygons' corners; triangles are measured as faces (measured_faces.c) */

typedef struct polygon_lanes {
    _Alignas(64) core_lane at[3], next_at[3], previous_at[3]; /* in: positions */
    core_lane normal[3], area, is_triangle;                   /* in: of the face; twice the area */
    core_lane sure, weight; /* in and out: 1 where doubles are enough, else 0; out */
} polygon_lanes;

/* A polygon's corner: its direction and area are there. Weights are those of face_geometry.c. */
CORE_INLINE void measure_polygon_corner(polygon_lanes *t, size_t i, norma_weight weight) {
    const int by_angle = core_weighed(weight) == CORE_BY_ANGLE,
              is_triangle = t->is_triangle[i] != 0;
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
}

CORE_INLINE void measure_lanes(polygon_lanes *t, norma_weight weight) {
    for (size_t i = 0; i < CORE_LANES; i++) measure_polygon_corner(t, i, weight);
}

static void load_position(const core_mesh *mesh, uint32_t index, core_lane to[3], size_t lane) {
    double p[3];
    norma_core_position(mesh, index, p);
    for (int k = 0; k < 3; k++) to[k][lane] = p[k];
}

/* Sure are polygons that keep all their corners and have a direction. */
static void load_polygon(const core_prepared_mesh *s, const star_list *list, size_t corner,
    polygon_lanes *t, size_t lane) {
    const size_t f = list->face[corner],
                 corners = norma_core_face_end(&s->mesh, f) - norma_core_face_begin(&s->mesh, f);
    const core_face *face = &s->faces[f];
    load_position(&s->mesh, list->at[corner], t->at, lane);
    load_position(&s->mesh, list->next[corner], t->next_at, lane);
    load_position(&s->mesh, list->previous[corner], t->previous_at, lane);
    for (int k = 0; k < 3; k++) t->normal[k][lane] = face->normal[k];
    t->area[lane] = face->twice_area;
    t->is_triangle[lane] = corners == 3 ? 1 : 0;
    t->sure[lane] = (face->flags & CORE_FACE_DIRECTED) && face->kept == corners ? 1 : 0;
}

CORE_INLINE void measure_polygons(
    const core_prepared_mesh *s, const star_list *list, fan_batch *b) {
    polygon_lanes t;
    for (size_t from = 0; from < list->corner_count; from += CORE_LANES) {
        const size_t left = list->corner_count - from,
                     count = left < CORE_LANES ? left : CORE_LANES;
        for (size_t i = 0; i < CORE_LANES; i++)
            load_polygon(s, list, from + (i < count ? i : 0), &t, i);
        CORE_LOOP_FOR_WEIGHT(s->call->options.weight, measure_lanes, &t)
        for (size_t i = 0; i < count; i++) {
            b->place[from + i] = norma_core_place_of_corner(from + i);
            b->measured.faces[b->place[from + i]] =
                (measured_face){{t.normal[0][i], t.normal[1][i], t.normal[2][i], t.sure[i]},
                    {t.weight[i], 0, 0, 0}};
        }
    }
}

/* ---- the order round a star: from each face to the one whose edge to next is its own edge from
 * previous */

typedef uint32_t index_lanes __attribute__((vector_size(4 * CORE_LANES)));
typedef uint64_t pair_lanes __attribute__((vector_size(4 * CORE_LANES)));

/* Each lane's lowest byte, in order; compilers take them out one by one. The first lane of a pair
 * is its lower half, or made that. */
CORE_INLINE uint64_t pack_bytes(const index_lanes *lanes) {
    const uint64_t two = 0xffff;
    pair_lanes pairs = (pair_lanes)*lanes;
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    pairs = pairs << 32 | pairs >> 32;
#endif
    pairs |= pairs >> 24;
    return (pairs[0] & two) | (pairs[1] & two) << 16 | (pairs[2] & two) << 32 | pairs[3] << 48;
}

/* Closed stars of few corners, most of them, walked in a register: byte j tells where lane j leads,
 * eight times its number, with LEADS. Were two nexts the same, some corner could not be reached.
 * Vectors by name: left to themselves, compilers unroll the lanes and compare one by one, which
 * takes four times as long. */
CORE_INLINE int walk_closed(
    const uint32_t *next, const uint32_t *previous, uint32_t count, uint8_t *order) {
    enum { LEADS = 0x80, BYTE = 0xff, SHIFT = 56 };
    index_lanes codes = {0}, here, code = (index_lanes){0} + LEADS;
    uint32_t at = LEADS, seen = 0;
    memcpy(&here, previous, sizeof here);
    for (uint32_t i = 0; i < count; i++, code += 8)
        codes |= (index_lanes)(here == (index_lanes){0} + next[i]) & code;
    const uint64_t leads_to = pack_bytes(&codes);
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

/* 0: the star is not ordinary. */
CORE_INLINE int order_star(
    const core_mesh *mesh, const star_list *list, listed_star *star, fan_batch *t) {
    uint32_t welded[2][ORDINARY_CORNERS];
    const uint32_t *next = list->next + star->begin, *previous = list->previous + star->begin;
    uint8_t *order = t->order + star->begin;
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
    star->open = (uint8_t)open;
    return 1;
}

/* ---- joining */

CORE_INLINE const measured_face *face_at(const fan_batch *t, size_t corner) {
    return &t->measured.faces[t->place[corner]];
}

/* out begins at the star, back ends there. */
static int is_unmarked(const core_prepared_mesh *s, uint32_t out, uint32_t back) {
    const size_t face = norma_core_face_of(&s->corners_of, back);
    return norma_core_is_unmarked(&s->mesh, out, (uint32_t)norma_core_face_of(&s->corners_of, out),
        (uint32_t)norma_core_previous_in_face(&s->mesh, face, back), (uint32_t)face);
}

/* One bit for each corner, in order, whose edge to the following one is marked hard. */
static uint32_t find_marks(const core_prepared_mesh *s, const star_list *list,
    const listed_star *star, const uint8_t *order, uint32_t edges) {
    const uint32_t *corners = list->corners + star->begin;
    uint32_t marks = 0;
    for (uint32_t i = 0; i < edges; i++) {
        const uint32_t following = i + 1U == star->count ? 0 : i + 1;
        if (!is_unmarked(s, corners[order[following]], corners[order[i]])) marks |= 1U << i;
    }
    return marks;
}

/* One bit for each corner, in order, whose edge to the following one is cut. 0: some direction is
 * unsure, or some edge too near the crease to tell by the cosine. */
CORE_INLINE int find_cuts(const core_prepared_mesh *s, const star_list *list, const fan_batch *t,
    const listed_star *star, uint32_t *cuts) {
    const uint8_t *order = t->order + star->begin;
    const uint32_t edges = (uint32_t)star->count - star->open;
    uint32_t hard = 0, smooth = 0, marks = 0;
    int sure = 1;
    const double *last = face_at(t, (size_t)star->begin + order[star->count - 1])->normal;
    for (uint32_t i = 0; i < star->count; i++) {
        /* of the edge to this corner from the one before */
        const double *normal = face_at(t, (size_t)star->begin + order[i])->normal;
        const uint32_t edge = i ? i - 1 : star->count - 1U;
        const double cosine = last[0] * normal[0] + last[1] * normal[1] + last[2] * normal[2];
        hard |= (uint32_t)norma_core_is_surely_hard(&s->crease, cosine) << edge;
        smooth |= (uint32_t)norma_core_is_surely_smooth(&s->crease, cosine) << edge;
        sure &= normal[3] != 0;
        last = normal;
    }
    if (s->mesh.hard_edges || s->mesh.smoothing_groups)
        marks = find_marks(s, list, star, order, edges);
    const uint32_t all = (1U << edges) - 1;
    *cuts = (hard | marks) & all;
    return sure && ((hard | smooth | marks) & all) == all;
}

/* Edges to positions of higher number: one at each face's previous, and at the first one's next if
 * that is another. */
static void count_edges(const core_prepared_mesh *s, const star_list *list, const fan_batch *t,
    const listed_star *star, uint32_t cuts, norma_edges *edges) {
    for (uint32_t i = 0; i < star->count; i++) {
        const size_t corner = (size_t)star->begin + t->order[star->begin + i];
        const size_t higher = star->position < norma_core_welded(&s->mesh, list->previous[corner]);
        const int shared = !star->open || i + 1 < star->count;
        edges->count += higher;
        if (!shared)
            edges->open += higher;
        else if (cuts >> i & 1)
            edges->hard += higher;
        else
            edges->smooth += higher;
        if (!star->open || i) continue;
        const size_t first = star->position < norma_core_welded(&s->mesh, list->next[corner]);
        edges->count += first;
        edges->open += first;
    }
}

/* ---- fans: a star that is cut nowhere or once is one, any other as many as there are cuts */

typedef double vote_lanes __attribute__((vector_size(4 * sizeof(double)))); /* and the weight */

CORE_INLINE void add_vote(
    const fan_batch *t, const star_list *list, size_t corner, vote_lanes *sum) {
    const measured_face *face = face_at(t, corner);
    vote_lanes normal;
    memcpy(&normal, face->normal, sizeof normal);
    *sum += normal * face->weight[list->turn[corner]];
}

CORE_INLINE void set_sum(fan_batch *t, size_t fan, const vote_lanes *sum) {
    for (int k = 0; k < 3; k++) t->sum[k][fan] = (*sum)[k];
    t->total[fan] = (*sum)[3];
}

CORE_INLINE void sum_one_fan(fan_batch *t, const star_list *list, const listed_star *star) {
    vote_lanes sum = {0};
    for (size_t i = star->begin; i < (size_t)star->begin + star->count; i++)
        add_vote(t, list, i, &sum);
    set_sum(t, star->first_fan, &sum);
}

/* Of 16 bits; __builtin_popcount would call libgcc where the machine has no instruction for it. */
static uint32_t count_bits(uint32_t bits) {
    bits -= bits >> 1 & 0x5555;
    bits = (bits & 0x3333) + (bits >> 2 & 0x3333);
    bits = (bits + (bits >> 4)) & 0x0f0f;
    return (bits + (bits >> 8)) & 0x1f;
}

/* From one cut to the next, and then in the order of first corners; without branches, which nothing
 * could foretell. Clears their sums. */
CORE_INLINE uint32_t number_fans(
    fan_batch *t, const listed_star *star, uint32_t cuts, vote_lanes *sums) {
    enum { NO_NUMBER = 0xff };
    const uint8_t *order = t->order + star->begin;
    const uint32_t last = star->count - 1U;
    const uint32_t goes_on = !star->open && !(cuts >> last & 1); /* the last fan, in the first */
    const uint32_t wrapped = goes_on ? count_bits(cuts) : NO_NUMBER;
    uint8_t fan_of[ORDINARY_CORNERS], number[ORDINARY_CORNERS + 1];
    uint32_t fan = 0, count = 0;
    for (uint32_t i = 0; i < star->count; i++) {
        fan_of[order[i]] = (uint8_t)(fan == wrapped ? 0 : fan);
        fan += cuts >> i & 1;
    }
    memset(number, NO_NUMBER, sizeof number);
    for (uint32_t i = 0; i < star->count; i++) {
        uint8_t *of = &number[fan_of[i]];
        const uint32_t is_new = *of == NO_NUMBER;
        *of = (uint8_t)(is_new ? count : *of);
        t->fan_of[star->begin + i] = *of;
        sums[*of] = (vote_lanes){0};
        count += is_new;
    }
    return count;
}

CORE_INLINE void sum_fans(fan_batch *t, const star_list *list, listed_star *star, uint32_t cuts) {
    vote_lanes sums[ORDINARY_CORNERS];
    star->fan_count = (uint8_t)number_fans(t, star, cuts, sums);
    for (size_t i = star->begin; i < (size_t)star->begin + star->count; i++)
        add_vote(t, list, i, &sums[t->fan_of[i]]);
    for (size_t f = 0; f < star->fan_count; f++) set_sum(t, star->first_fan + f, &sums[f]);
}

CORE_INLINE int settle_star(const core_prepared_mesh *s, const star_list *list, fan_batch *t,
    listed_star *star, uint32_t first_fan, norma_edges *edges) {
    uint32_t cuts;
    if (!find_cuts(s, list, t, star, &cuts)) return 0;
    star->first_fan = (uint8_t)first_fan;
    star->fan_count = 1;
    if ((cuts & (cuts - 1)) == 0 && !(cuts && star->open))
        sum_one_fan(t, list, star);
    else
        sum_fans(t, list, star, cuts);
    if (edges) count_edges(s, list, t, star, cuts, edges);
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

/* Written as one, since it will be read so: what is written in pieces is read late. */
typedef float fan_lanes __attribute__((vector_size(sizeof(core_fan))));
_Static_assert(NORMA_REASON_NONE == 0, "a fan with a normal ends in zeros");

CORE_INLINE void name_fans(fan_batch *t, size_t count) {
    for (size_t f = 0; f < count; f++) {
        const fan_lanes fan = {t->direction[0][f], t->direction[1][f], t->direction[2][f], 0};
        memcpy(&t->fans[f], &fan, sizeof fan);
        if (t->decided[f] != 0) continue;
        const double sum[3] = {t->sum[0][f], t->sum[1][f], t->sum[2][f]};
        norma_core_decide_sum(sum, t->total[f], &t->fans[f]);
    }
}

/* The faces of a star. */
CORE_INLINE void place_faces(const star_list *list, const listed_star *star, fan_batch *t) {
    for (size_t i = star->begin; i < (size_t)star->begin + star->count; i++)
        t->place[i] = norma_core_place_of_face(&t->measured, list->face[i], i);
}

CORE_INLINE int settle(
    const core_prepared_mesh *s, star_list *list, fan_batch *t, norma_edges *edges) {
    uint32_t fans = 0;
    int all = 1;
    for (size_t i = 0; i < list->star_count; i++) {
        listed_star *star = &list->stars[i];
        if (star->scattered) norma_core_ask_for_targets(list, star);
        star->fan_count = (uint8_t)order_star(&s->mesh, list, star, t);
        if (!s->faces && star->fan_count) place_faces(list, star, t);
    }
    if (s->faces)
        measure_polygons(s, list, t);
    else
        norma_core_measure_waiting(s, &t->measured);
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
