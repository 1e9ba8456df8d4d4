/* ring_lanes.c: a batch of rings measured, joined and summed: loops over lanes, compiled for each instruction set as those of measure.c are. */
#include "ring_batch.h"
#include "isa.h"
#include "triangle.h"

#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline))
#else
#define INLINE static inline
#endif

/* ---- directions and votes */

INLINE double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* A triangle's direction is measured from its first corner, whichever corner is looked at: with a and b the edges to the next and the previous corner, and
 * c the edge between those, u x v is a x b at the first corner, c x b at the second, c x a at the third. */
INLINE void measure_corner(ring_batch *t, size_t i, norma_weight weight)
{
    double a[3], b[3], u[3], v[3], area;
    for (int k = 0; k < 3; k++) {
        const double p = t->at[k][i], next = t->next_at[k][i], previous = t->previous_at[k][i];
        a[k] = next - p;
        b[k] = previous - p;
        u[k] = t->turn[i] == 0 ? a[k] : next - previous;
        v[k] = t->turn[i] == 2 ? a[k] : b[k];
    }
    const int sure = norma_core_triangle(u[0], u[1], u[2], v[0], v[1], v[2], &t->normal[0][i], &t->normal[1][i], &t->normal[2][i], &area);
    t->sure[i] = sure ? 1 : 0;
    t->weight[i] = norma_core_weigh(weight, dot(a, a), dot(b, b), dot(a, b), area, area, 0);
    for (int k = 0; k < 3; k++) t->vote[k][i] = t->weight[i] * t->normal[k][i];
}

INLINE void measure(ring_batch *t, size_t count, norma_weight weight)
{
    for (size_t from = 0; from < count; from += CORE_LANES)
        for (size_t i = from; i < from + CORE_LANES; i++) measure_corner(t, i, weight);
}

/* One loop for each weight, so that none asks inside. */
INLINE void measure_all(ring_batch *t, size_t count, norma_weight weight)
{
    switch (weight) {
    case NORMA_WEIGHT_ANGLE:         measure(t, count, NORMA_WEIGHT_ANGLE); break;
    case NORMA_WEIGHT_AREA:          measure(t, count, NORMA_WEIGHT_AREA); break;
    case NORMA_WEIGHT_MAX:           measure(t, count, NORMA_WEIGHT_MAX); break;
    case NORMA_WEIGHT_ANGLE_AREA:    measure(t, count, NORMA_WEIGHT_ANGLE_AREA); break;
    case NORMA_WEIGHT_ANGLE_LENGTHS: measure(t, count, NORMA_WEIGHT_ANGLE_LENGTHS); break;
    default:                         measure(t, count, NORMA_WEIGHT_UNIFORM); break;
    }
}

/* ---- joining */

typedef struct ring_links {
    uint32_t back[ORDINARY_CORNERS];   /* of each corner, one bit for each corner whose face runs out along the edge that its own comes back along */
    uint32_t met, smooth;              /* corners of which there is one; of which that edge is smooth */
} ring_links;

INLINE void compare(const uint32_t *next, const uint32_t *previous, uint32_t count, uint32_t lanes, uint32_t *back)
{
    for (uint32_t j = 0; j < lanes; j++) back[j] = 0;
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t j = 0; j < lanes; j++) back[j] |= (uint32_t)(previous[j] == next[i]) << i;
}

static inline uint32_t lowest(uint32_t bits) { return (uint32_t)__builtin_ctz(bits); }
INLINE int at_most_one(uint32_t bits) { return (bits & (bits - 1)) == 0; }

/* Whether a walk from face to face, four bits of leads_to for each, comes through all of them: else two fans touch here. */
INLINE int is_round(uint64_t leads_to, uint32_t count)
{
    uint32_t at = 0, seen = 0;
    for (uint32_t i = 0; i < count; i++) {
        at = (uint32_t)(leads_to >> 4 * at) & 15;
        seen |= 1U << at;
    }
    return seen == (1U << count) - 1;
}

/* Whether each edge is one face's out and one face's back, but for one gap at most, no two faces are twins, and there is but one way round. */
INLINE int link_up(const ring_batch *t, const listed_ring *ring, ring_links *links)
{
    const uint32_t *next = t->next + ring->begin, *previous = t->previous + ring->begin, count = ring->count, full = (1U << count) - 1;
    uint32_t any = 0, sum = 0, several = 0, twins = 0, met = 0;
    uint64_t leads_to = 0;
    if (count <= CORE_LANES) compare(next, previous, count, CORE_LANES, links->back);
    else compare(next, previous, count, ORDINARY_CORNERS, links->back);
    for (uint32_t j = 0; j < count; j++) {
        const uint32_t bits = links->back[j];
        any |= bits;
        sum += bits;
        several |= bits & (bits - 1);
        met |= (uint32_t)(bits != 0) << j;
        twins |= bits ? links->back[lowest(bits)] >> j & 1 : 0;
        leads_to |= bits ? (uint64_t)lowest(bits) << 4 * j : 0;
    }
    links->met = met;
    if (any != sum || several || twins || !at_most_one(met ^ full)) return 0;
    if (met != full) leads_to |= (uint64_t)lowest(any ^ full) << 4 * lowest(met ^ full);      /* across the gap */
    return is_round(leads_to, count);
}

static const double DOUBT = 0x1p-30;

/* 1 smooth, 0 not, -1 too near the crease to tell by the cosine. */
INLINE int is_smooth(const core_surface *s, const ring_list *list, const ring_batch *t, uint32_t out, uint32_t back)
{
    const core_mesh *mesh = &s->mesh;
    if (mesh->hard_edges) {
        const uint32_t corner = list->corners[back], before = corner % 3 == 0 ? corner + 2 : corner - 1;
        if (mesh->hard_edges[list->corners[out]] || mesh->hard_edges[before]) return 0;
    }
    if (mesh->smoothing_groups && !(mesh->smoothing_groups[list->corners[out] / 3] & mesh->smoothing_groups[list->corners[back] / 3])) return 0;
    const double cosine = t->normal[0][out] * t->normal[0][back] + t->normal[1][out] * t->normal[1][back] + t->normal[2][out] * t->normal[2][back];
    if (cosine > s->crease_cosine + DOUBT) return 1;
    return cosine < s->crease_cosine - DOUBT ? 0 : -1;
}

INLINE int judge_edges(const core_surface *s, const ring_list *list, const ring_batch *t, const listed_ring *ring, ring_links *links)
{
    uint32_t smooth = 0;
    for (uint32_t j = 0; j < ring->count; j++) {
        if (!links->back[j]) continue;
        const int judged = is_smooth(s, list, t, ring->begin + lowest(links->back[j]), ring->begin + j);
        if (judged < 0) return 0;
        smooth |= (uint32_t)judged << j;
    }
    links->smooth = smooth;
    return 1;
}

/* Edges to positions of higher number: of two faces where they come back, of one where they go out or come back alone. */
INLINE void count_edges(const ring_batch *t, const listed_ring *ring, const ring_links *links, norma_edges *edges)
{
    uint32_t out = 0, back = 0;
    for (uint32_t i = 0; i < ring->count; i++) {
        out += ring->position < t->next[ring->begin + i];
        back |= (uint32_t)(ring->position < t->previous[ring->begin + i]) << i;
    }
    const uint32_t alone = back & ~links->met, shared = back & links->met;
    uint32_t smooth = 0, two = 0;
    for (uint32_t i = 0; i < ring->count; i++) {
        two += shared >> i & 1;
        smooth += shared >> i & links->smooth >> i & 1;
    }
    edges->count += out + (alone != 0);
    edges->open += out - two + (alone != 0);
    edges->smooth += smooth;
    edges->hard += two - smooth;
}

/* ---- fans: a ring that is cut nowhere or once is one, any other as many as there are cuts */

static void number_fans(const listed_ring *ring, const ring_links *links, uint32_t *fan_of)
{
    uint32_t heads = (1U << ring->count) - 1, leads_to[ORDINARY_CORNERS], first[ORDINARY_CORNERS];
    for (uint32_t j = 0; j < ring->count; j++) {
        leads_to[j] = links->smooth >> j & 1 ? lowest(links->back[j]) : UINT32_MAX;
        if (leads_to[j] != UINT32_MAX) heads &= ~(1U << leads_to[j]);
        fan_of[j] = UINT32_MAX;
    }
    for (uint32_t j = 0; j < ring->count; j++) {
        if (!(heads >> j & 1)) continue;
        for (uint32_t i = j; i != UINT32_MAX; i = leads_to[i]) fan_of[i] = j;
    }
    uint32_t count = 0;
    for (uint32_t j = 0; j < ORDINARY_CORNERS; j++) first[j] = UINT32_MAX;
    for (uint32_t j = 0; j < ring->count; j++) {
        if (first[fan_of[j]] == UINT32_MAX) first[fan_of[j]] = count++;
        fan_of[j] = first[fan_of[j]];
    }
}

INLINE void sum_one_fan(ring_batch *t, const listed_ring *ring)
{
    double x = 0, y = 0, z = 0, weight = 0;
    for (uint32_t i = ring->begin; i < (uint32_t)ring->begin + ring->count; i++) {
        x += t->vote[0][i];
        y += t->vote[1][i];
        z += t->vote[2][i];
        weight += t->weight[i];
        t->fan_of[i] = 0;
    }
    t->sum[0][ring->first_fan] = x;
    t->sum[1][ring->first_fan] = y;
    t->sum[2][ring->first_fan] = z;
    t->total[ring->first_fan] = weight;
}

static void sum_fans(ring_batch *t, const listed_ring *ring, const ring_links *links)
{
    number_fans(ring, links, t->fan_of + ring->begin);
    for (uint32_t f = ring->first_fan; f < (uint32_t)ring->first_fan + ring->fan_count; f++) t->sum[0][f] = t->sum[1][f] = t->sum[2][f] = t->total[f] = 0;
    for (uint32_t i = ring->begin; i < (uint32_t)ring->begin + ring->count; i++) {
        const uint32_t f = ring->first_fan + t->fan_of[i];
        for (int k = 0; k < 3; k++) t->sum[k][f] += t->vote[k][i];
        t->total[f] += t->weight[i];
    }
}

INLINE uint32_t count_bits(uint32_t bits)
{
    uint32_t count = 0;
    for (; bits; bits &= bits - 1) count++;
    return count;
}

INLINE int settle_ring(const core_surface *s, const ring_list *list, ring_batch *t, listed_ring *ring, uint32_t first_fan, norma_edges *edges)
{
    ring_links links;
    double sure = 1;
    for (uint32_t i = ring->begin; i < (uint32_t)ring->begin + ring->count; i++) sure = t->sure[i] == 0 ? 0 : sure;
    if (sure == 0 || !link_up(t, ring, &links) || !judge_edges(s, list, t, ring, &links)) return 0;
    const uint32_t cuts = ((1U << ring->count) - 1) ^ links.smooth;
    ring->first_fan = (uint8_t)first_fan;
    ring->fan_count = 1;
    if (at_most_one(cuts)) {
        sum_one_fan(t, ring);
    } else {
        ring->fan_count = (uint8_t)count_bits(cuts);
        sum_fans(t, ring, &links);
    }
    if (edges) count_edges(t, ring, &links, edges);
    return 1;
}

/* ---- normals */

/* What norma_core_decide_sum does, where neither overflow nor cancelling is near; decided: 0 where they are. */
INLINE void decide(ring_batch *t, size_t count)
{
    for (size_t from = 0; from < count; from += CORE_LANES)
        for (size_t f = from; f < from + CORE_LANES; f++) {
            const double x = t->sum[0][f], y = t->sum[1][f], z = t->sum[2][f], square = x * x + y * y + z * z, length = sqrt(square);
            t->direction[0][f] = (float)(x / length) + 0.0F;
            t->direction[1][f] = (float)(y / length) + 0.0F;
            t->direction[2][f] = (float)(z / length) + 0.0F;
            t->decided[f] = (square > NORMA_TINIEST) & (square < NORMA_HUGEST) & (length > 0x1p-20 * t->total[f]) ? 1 : 0;
        }
}

static void name_fans(ring_batch *t, size_t count)
{
    for (size_t f = 0; f < count; f++) {
        t->fans[f] = (core_fan){{t->direction[0][f], t->direction[1][f], t->direction[2][f]}, NORMA_REASON_NONE};
        if (t->decided[f] != 0) continue;
        const double sum[3] = {t->sum[0][f], t->sum[1][f], t->sum[2][f]};
        norma_core_decide_sum(sum, t->total[f], &t->fans[f]);
    }
}

INLINE int settle(const core_surface *s, ring_list *list, ring_batch *t, norma_edges *edges)
{
    uint32_t fans = 0;
    int all = 1;
    measure_all(t, list->corner_count, s->call->options.weight);
    for (size_t i = 0; i < list->ring_count; i++) {
        listed_ring *ring = &list->rings[i];
        if (ring->fan_count && !settle_ring(s, list, t, ring, fans, edges)) ring->fan_count = 0;
        fans += ring->fan_count;
        all &= ring->fan_count != 0;
    }
    decide(t, fans);
    name_fans(t, fans);
    return all;
}

/* ---- instruction sets */

static int settle_portable(const core_surface *s, ring_list *list, ring_batch *t, norma_edges *edges) { return settle(s, list, t, edges); }

#if defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
__attribute__((target("avx2"))) static int settle_avx2(const core_surface *s, ring_list *list, ring_batch *t, norma_edges *edges)
{
    return settle(s, list, t, edges);
}
#if defined(__clang__)
#define AVX512 "avx512f,avx512dq,avx512vl"
#else
#define AVX512 "avx512f,avx512dq,avx512vl,prefer-vector-width=512"
#endif
__attribute__((target(AVX512))) static int settle_avx512(const core_surface *s, ring_list *list, ring_batch *t, norma_edges *edges)
{
    return settle(s, list, t, edges);
}

ring_lanes *norma_core_choose_ring_lanes(norma_isa isa)
{
    if (isa == NORMA_ISA_PORTABLE || isa == NORMA_ISA_SSE2) return settle_portable;
    if (isa != NORMA_ISA_AVX2 && norma_core_has_isa(NORMA_ISA_AVX512)) return settle_avx512;
    return norma_core_has_isa(NORMA_ISA_AVX2) ? settle_avx2 : settle_portable;
}
#else
ring_lanes *norma_core_choose_ring_lanes(norma_isa isa)
{
    (void)isa;
    return settle_portable;
}
#endif
