/* plan_kernel.c: a block's faces measured and its groups summed. */
#include "core/plan/plan.h"

/* ---- the normal of a group, from its sum */

int norma_core_plan_decide(const double sum[4], float normal[3]) {
    if (signbit(sum[3])) return NORMA_REASON_UNREFERENCED;
    if (norma_core_cancels(sum, sum[3])) return NORMA_REASON_CANCELLED;
    norma_core_direction(sum, normal);
    return NORMA_REASON_NONE;
}

int norma_core_plan_decide_cone(
    double weight, norma_core_cone_at *at, const void *context, size_t count, float normal[3]) {
    double axis[3];
    if (signbit(weight)) return NORMA_REASON_UNREFERENCED;
    if (!norma_core_smallest_cone_of(at, context, count, axis)) return NORMA_REASON_CANCELLED;
    norma_core_direction(axis, normal);
    return NORMA_REASON_NONE;
}

/* ---- The loops in which an update spends its time: eight triangles at a time are
 * read, measured and kept as rows; groups sum rows in the order of their members. Compiled for each
 * instruction set; what is computed is what norma_vertex_normals computes, by the same steps. */

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-tree-slp-vectorize") /* this compiler takes rows that are read whole      \
                                                 apart again, number by number */
#endif
#include "core/face/eight_vectors.h"

CORE_INLINE uint32_t number_of_some(block_some some, uint32_t i) {
    return some.numbers ? some.numbers[i] : i;
}

/* Some in a row, or by number; the last one again where there are no more. */
CORE_INLINE void name_some(block_some some, uint32_t begin, uint32_t count, uint32_t *out) {
    for (uint32_t i = 0; i < count; i++)
        out[i] = number_of_some(some, begin + i < some.count ? begin + i : some.count - 1);
}

/* ---- positions */

#if defined(CORE_HAS_SHUFFLES)
typedef core_d4 zero_sum; /* 0 as long as all are finite */
CORE_INLINE void load_vertex(const unsigned char *at, double out[4], zero_sum *zero) {
    const core_d4 v = __builtin_convertvector(core_load_three(at), core_d4);
    core_store_row(out, v);
    *zero += v - v;
}
CORE_INLINE int is_zero_position(const zero_sum *zero) {
    return ((*zero)[0] + (*zero)[1]) + ((*zero)[2] + (*zero)[3]) == 0;
}
#else
typedef double zero_sum;
CORE_INLINE void load_vertex(const unsigned char *at, double out[4], zero_sum *zero) {
    float v[3];
    memcpy(v, at, sizeof v);
    for (int k = 0; k < 3; k++) {
        out[k] = (double)v[k];
        *zero += out[k] - out[k];
    }
    out[3] = 0;
}
CORE_INLINE int is_zero_position(const zero_sum *zero) { return *zero == 0; }
#endif

CORE_INLINE int load_vertex_floats(const block_view *t, const block_some *eights,
    const unsigned char *data, size_t stride, double (*out)[4]) {
    zero_sum zero = {0};
    for (uint32_t v = 0; v < t->vertex_count && !eights; v++)
        load_vertex(data + t->vertices[v] * stride, out[v], &zero);
    for (uint32_t i = 0; eights && i < eights->count; i++) {
        const uint16_t *at = t->corners + (size_t)3 * CORE_LANES * number_of_some(*eights, i);
        for (uint32_t c = 0; c < 3 * CORE_LANES; c++)
            load_vertex(data + t->vertices[at[c]] * stride, out[at[c]], &zero);
    }
    return is_zero_position(&zero);
}

/* ---- triangles */

static void list_doubted_faces(
    const block_view *t, unsigned sure, uint32_t begin, block_room *room) {
    for (uint32_t i = 0; i < CORE_LANES && begin + i < t->face_count; i++)
        if (!(sure >> i & 1U)) room->doubted[room->doubted_count++] = (uint16_t)(begin + i);
}

enum { EIGHTS_AT_ONCE = 8 };

static void measure_some(const core_kernels *kernels, const block_view *t, block_some eights,
    norma_weight weight, block_room *room) {
    const core_mesh mesh = {.positions = {room->positions, BLOCK_VERTICES,
                                sizeof room->positions[0], NORMA_FORMAT_DOUBLE},
        .scale = 1};
    for (uint32_t i = 0, count; i < eights.count; i += count) {
        uint32_t at[EIGHTS_AT_ONCE][3 * CORE_LANES];
        core_eight_rows out[EIGHTS_AT_ONCE];
        count = eights.count - i < EIGHTS_AT_ONCE ? eights.count - i : EIGHTS_AT_ONCE;
        for (uint32_t k = 0; k < count; k++) {
            const size_t begin = CORE_LANES * (size_t)number_of_some(eights, i + k);
            for (size_t c = 0; c < 3 * CORE_LANES; c++) at[k][c] = t->corners[3 * begin + c];
            out[k].row = room->normals + begin;
            for (size_t c = 0; c < 3; c++)
                out[k].weight[c] = room->weights + (c << BLOCK_FACE_BITS | begin);
            norma_core_ask_ahead(&room->ahead);
        }
        kernels->measure_at(&mesh, at[0], count, out, weight);
        for (uint32_t k = 0; k < count; k++)
            if (out[k].sure != UINT8_MAX)
                list_doubted_faces(
                    t, out[k].sure, CORE_LANES * number_of_some(eights, i + k), room);
    }
}

/* ---- groups */

/* x, y, z and the weight of one group, in a register where there are some. */
#if defined(CORE_HAS_SHUFFLES)
typedef core_d4 group_sum;
CORE_INLINE group_sum no_votes(void) { return (group_sum){0, 0, 0, -0.0}; }
CORE_INLINE group_sum add_vote_row(group_sum sum, const double *row, double weight) {
    return sum + core_load_row(row) * (core_d4){weight, weight, weight, weight};
}
CORE_INLINE void keep_sum(group_sum sum, core_vertex_sum *out) { core_store_row(&out->x, sum); }
#else
typedef core_vertex_sum group_sum;
CORE_INLINE group_sum no_votes(void) { return (group_sum){0, 0, 0, -0.0}; }
CORE_INLINE group_sum add_vote_row(group_sum sum, const double *row, double weight) {
    return (group_sum){sum.x + row[0] * weight, sum.y + row[1] * weight, sum.z + row[2] * weight,
        sum.weight + row[3] * weight};
}
CORE_INLINE void keep_sum(group_sum sum, core_vertex_sum *out) { *out = sum; }
#endif

typedef struct group_members {
    const uint16_t *numbers;
    uint32_t count;
} group_members;

CORE_INLINE group_members members_of(const block_view *t, uint32_t group) {
    const uint32_t begin = norma_core_block_start(t, group);
    return (group_members){t->members + begin, norma_core_block_start(t, group + 1) - begin};
}

CORE_INLINE group_sum add_group_member(const block_view *t, const block_room *room,
    group_members of, uint32_t i, int polygons, group_sum sum) {
    const uint32_t member = of.numbers[i];
    return add_vote_row(sum,
        room->normals[polygons ? t->corner_faces[member] : member & (BLOCK_FACES - 1U)],
        room->weights[member]);
}

CORE_INLINE void add_rest(const block_view *t, const block_room *room, group_members of,
    uint32_t from, int polygons, group_sum sum, core_vertex_sum *out) {
    for (uint32_t i = from; i < of.count; i++)
        sum = add_group_member(t, room, of, i, polygons, sum);
    keep_sum(sum, out);
}

/* Four groups at a time as far as the shortest goes: what is added to one waits for what was added
 * before, not for the others'. */
CORE_INLINE void sum_four(const block_view *t, const uint32_t groups[4], const block_room *room,
    int polygons, core_vertex_sum *out) {
    const group_members a = members_of(t, groups[0]), b = members_of(t, groups[1]),
                        c = members_of(t, groups[2]), d = members_of(t, groups[3]);
    const uint32_t ab = a.count < b.count ? a.count : b.count,
                   cd = c.count < d.count ? c.count : d.count, together = ab < cd ? ab : cd;
    group_sum sum_a = no_votes(), sum_b = sum_a, sum_c = sum_a, sum_d = sum_a;
    for (uint32_t i = 0; i < together; i++) {
        sum_a = add_group_member(t, room, a, i, polygons, sum_a);
        sum_b = add_group_member(t, room, b, i, polygons, sum_b);
        sum_c = add_group_member(t, room, c, i, polygons, sum_c);
        sum_d = add_group_member(t, room, d, i, polygons, sum_d);
    }
    add_rest(t, room, a, together, polygons, sum_a, out);
    add_rest(t, room, b, together, polygons, sum_b, out + 1);
    add_rest(t, room, c, together, polygons, sum_c, out + 2);
    add_rest(t, room, d, together, polygons, sum_d, out + 3);
}

/* The same of all groups in a row, where their members are listed by fours. */
CORE_INLINE const uint16_t *sum_listed(
    const uint16_t *members, uint32_t count, const block_room *room, core_vertex_sum *out) {
    group_sum sum_a = no_votes(), sum_b = sum_a, sum_c = sum_a, sum_d = sum_a;
    for (const uint16_t *end = members + (size_t)4 * count; members < end; members += 4) {
        sum_a = add_vote_row(
            sum_a, room->normals[members[0] & (BLOCK_FACES - 1U)], room->weights[members[0]]);
        sum_b = add_vote_row(
            sum_b, room->normals[members[1] & (BLOCK_FACES - 1U)], room->weights[members[1]]);
        sum_c = add_vote_row(
            sum_c, room->normals[members[2] & (BLOCK_FACES - 1U)], room->weights[members[2]]);
        sum_d = add_vote_row(
            sum_d, room->normals[members[3] & (BLOCK_FACES - 1U)], room->weights[members[3]]);
    }
    keep_sum(sum_a, out);
    keep_sum(sum_b, out + 1);
    keep_sum(sum_c, out + 2);
    keep_sum(sum_d, out + 3);
    return members;
}

CORE_INLINE void sum_eight(const block_view *t, block_some groups, uint32_t begin,
    const block_room *room, int polygons, core_vertex_sum *out) {
    for (uint32_t i = 0; i < CORE_LANES; i += 4) {
        uint32_t names[4];
        name_some(groups, begin + i, 4, names);
        sum_four(t, names, room, polygons, out + i);
    }
}

/* One by one, where not all have a normal. */
CORE_INLINE int decide_each(
    const block_view *t, block_some groups, block_room *room, int polygons) {
    core_vertex_sum sums[CORE_LANES];
    int all = 1;
    for (uint32_t i = 0; i < groups.count; i++) {
        if (i % CORE_LANES == 0) sum_eight(t, groups, i, room, polygons, sums);
        const core_vertex_sum *s = &sums[i % CORE_LANES];
        room->reasons[i] = (uint8_t)norma_core_plan_decide(
            (const double[4]){s->x, s->y, s->z, s->weight}, room->results[i]);
        all &= room->reasons[i] == NORMA_REASON_NONE;
    }
    return all;
}

typedef struct finisher {
    void (*lengths)(const core_vertex_sum *sums, core_lengths *out, double *fine);
    void (*directions)(const core_lengths *of, float (*normals)[3]);
} finisher;

/* Eight sums become normals while the next ones are added up, in two steps: see eight_vectors.h.
 */
CORE_INLINE int sum_all_groups(
    const block_view *t, block_some groups, finisher finish, block_room *room, int polygons) {
    const uint32_t eights = norma_core_block_eights(groups.count);
    const uint16_t *members = t->fours;
    core_vertex_sum sums[2][CORE_LANES];
    core_lengths lengths[2];
    core_lane fine = {0};
    memset(room->reasons, NORMA_REASON_NONE, groups.count);
    for (uint32_t i = 0; i < eights + 2; i++) {
        if (i < eights && (polygons || groups.numbers || !members))
            sum_eight(t, groups, i * CORE_LANES, room, polygons, sums[i % 2]);
        else if (i < eights)
            for (uint32_t k = 0; k < 2; k++)
                members = sum_listed(members, t->four_counts[2 * i + k], room, &sums[i % 2][4 * k]);
        if (i >= 2)
            finish.directions(&lengths[i % 2], room->results + (size_t)(i - 2) * CORE_LANES);
        if (i >= 1 && i <= eights) finish.lengths(sums[(i - 1) % 2], &lengths[(i - 1) % 2], fine);
    }
    return core_lanes_total(fine) == (double)eights * CORE_LANES ||
           decide_each(t, groups, room, polygons);
}

CORE_INLINE int sum_block_groups(
    const block_view *t, block_some groups, finisher finish, block_room *room) {
    const block_some row = {NULL, groups.count};
    if (t->corner_faces) return sum_all_groups(t, groups, finish, room, 1);
    return groups.numbers ? sum_all_groups(t, groups, finish, room, 0)
                          : sum_all_groups(t, row, finish, room, 0);
}

/* ---- for each instruction set */

static int load_portable(const block_view *t, const block_some *eights, const unsigned char *data,
    size_t stride, double (*out)[4]) {
    return load_vertex_floats(t, eights, data, stride, out);
}
static void measure_block_portable(
    const block_view *t, block_some eights, norma_weight weight, block_room *room) {
    measure_some(norma_core_kernels_portable(), t, eights, weight, room);
}
static void lengths_portable(const core_vertex_sum *sums, core_lengths *out, double *fine) {
    core_lanes_lengths(sums, out, fine);
}
static void directions_portable(const core_lengths *of, float (*normals)[3]) {
    core_lanes_directions(of, normals);
}
static int sum_portable(const block_view *t, block_some groups, block_room *room) {
    return sum_block_groups(t, groups, (finisher){lengths_portable, directions_portable}, room);
}

#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static int load_avx2(const block_view *t, const block_some *eights,
    const unsigned char *data, size_t stride, double (*out)[4]) {
    return load_vertex_floats(t, eights, data, stride, out);
}
static void measure_block_avx2(
    const block_view *t, block_some eights, norma_weight weight, block_room *room) {
    measure_some(norma_core_kernels_avx2(), t, eights, weight, room);
}
#if defined(CORE_HAS_AVX512)
static void measure_block_avx512(
    const block_view *t, block_some eights, norma_weight weight, block_room *room) {
    measure_some(norma_core_kernels_avx512(), t, eights, weight, room);
}
#endif
CORE_FOR_AVX2 static void lengths_avx2(
    const core_vertex_sum *sums, core_lengths *out, double *fine) {
    core_lanes_lengths(sums, out, fine);
}
CORE_FOR_AVX2 static void directions_avx2(const core_lengths *of, float (*normals)[3]) {
    core_lanes_directions(of, normals);
}
CORE_FOR_AVX2 static int sum_avx2(const block_view *t, block_some groups, block_room *room) {
    return sum_block_groups(t, groups, (finisher){lengths_avx2, directions_avx2}, room);
}

/* Rows are of four: wider registers do not help to sum them, nor to finish sums. */
block_kernels norma_core_block_kernels(norma_isa isa) {
    switch (norma_core_level(isa)) {
#if defined(CORE_HAS_AVX512)
    case CORE_AVX512:
        return (block_kernels){load_avx2, measure_block_avx512, sum_avx2};
#endif
    case CORE_AVX2:
        return (block_kernels){load_avx2, measure_block_avx2, sum_avx2};
    default:
        return (block_kernels){load_portable, measure_block_portable, sum_portable};
    }
}
#else
block_kernels norma_core_block_kernels(norma_isa isa) {
    (void)isa;
    return (block_kernels){load_portable, measure_block_portable, sum_portable};
}
#endif
