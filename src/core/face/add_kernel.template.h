/* add_kernel.template.h: faces added to the sums of their corners' positions, in ascending order;
 * sums made normals. Included by a file for each instruction set behind face_kernel.template.h. */
#include "core/face/eight_vectors.h"
#include "core/face/face.h"

/* ---- eight measured triangles added */

/* Eight triangles, or fewer at the end of all: what each adds to the sums of its corners, its row
 * times the weight of each; where all corners weigh the same, the row itself. */
typedef struct core_eight {
    const double (*row)[4];
    const double (*weight)[CORE_LANES]; /* of each corner */
    const unsigned char *at; /* the corners' positions, welded where they are: three indices of 32
                                bits for each triangle */
    unsigned sure;           /* a bit for each: doubles decide it */
} core_eight;

enum { CORE_ALL_SURE = (1 << CORE_LANES) - 1 };

CORE_INLINE int core_weighs_evenly(norma_weight weight) {
    return core_weighed(weight) == CORE_BY_FACE;
}

CORE_INLINE uint32_t core_eight_at(const core_eight *e, int lane, int corner) {
    uint32_t at;
    memcpy(&at, e->at + sizeof at * (size_t)(3 * lane + corner), sizeof at);
    return at;
}

CORE_INLINE void core_add_corner(
    core_vertex_sum *sum, const core_eight *e, int lane, int corner, norma_weight weight) {
    if (core_weighs_evenly(weight))
        core_add_whole(&sum->x, e->row[lane]);
    else
        core_add_row(&sum->x, e->row[lane], e->weight[corner][lane]);
}

/* Corners of a range that is another's are passed over. */
CORE_INLINE void core_add_lane(
    const core_adder *adder, const core_eight *e, int lane, norma_weight weight) {
    for (int k = 0; k < 3; ++k) {
        const uint32_t sum = core_eight_at(e, lane, k) - adder->first;
        if (sum < adder->count) core_add_corner(&adder->sums[sum], e, lane, k, weight);
    }
}

/* The same of all lanes, for those who own all their corners. */
CORE_INLINE void core_add_all_lanes(
    const core_adder *adder, const core_eight *e, norma_weight weight) {
    const uintptr_t origin = (uintptr_t)adder->sums - adder->first * sizeof *adder->sums;
    for (int i = 0; i < CORE_LANES; ++i)
        for (int k = 0; k < 3; ++k)
            core_add_corner(
                (core_vertex_sum *)(origin + core_eight_at(e, i, k) * sizeof *adder->sums), e, i, k,
                weight);
}

/* By doubles, and its corners are at three places. Face f is the first of them. */
CORE_INLINE int core_is_decided(const core_adder *adder, const core_eight *e, size_t f, int lane) {
    uint32_t at[3];
    for (int k = 0; k < 3; ++k)
        at[k] = adder->targets && adder->by_distance
                    ? norma_core_welded_corner(adder->mesh, 3 * (f + (size_t)lane) + (size_t)k)
                    : core_eight_at(e, lane, k);
    return (e->sure >> lane & 1U) && at[0] != at[1] && at[1] != at[2] && at[2] != at[0];
}

/* What doubles decide has three places, unless those that differ are welded. */
CORE_INLINE int core_all_are_decided(const core_adder *adder, const core_eight *e, int lanes) {
    return lanes == CORE_LANES && !adder->by_distance && e->sure == CORE_ALL_SURE;
}

/* Face f is the first of them. */
CORE_INLINE void core_add_eight(
    const core_adder *adder, const core_eight *e, size_t f, int lanes, norma_weight weight) {
    if (adder->owns_all && core_all_are_decided(adder, e, lanes)) {
        core_add_all_lanes(adder, e, weight);
        return;
    }
    for (int i = 0; i < lanes; ++i) {
        if (core_is_decided(adder, e, f, i))
            core_add_lane(adder, e, i, weight);
        else
            adder->add_alone(adder->context, adder->first_face + f + (size_t)i);
    }
}

/* ---- triangles, from corners to rows */

enum { AHEAD = 32 }; /* triangles between asking for memory and using it */

/* What is kept of eight triangles until they are added. */
typedef struct kept_eight {
    _Alignas(64) double row[CORE_LANES][4];
    double weight[3][CORE_LANES];
    kept_edges edges;
    uint32_t at[3 * CORE_LANES]; /* the corners' positions, where they are not the mesh's own
                                    corners, nor targets */
    unsigned sure;
} kept_eight;

static const unsigned char *corners_at(const core_mesh *mesh, size_t f) {
    return (const unsigned char *)mesh->corners + 3 * sizeof(uint32_t) * f;
}

/* Where the corners vote, from face f on. */
static const unsigned char *sums_at(const core_adder *adder, const kept_eight *kept, size_t f) {
    if (adder->targets) return (const unsigned char *)(adder->targets + 3 * f);
    return adder->mesh->weld ? (const unsigned char *)kept->at : corners_at(adder->mesh, f);
}

/* From lane first on. Where all corners weigh the same, the rows are times that. */
IN_VECTORS void keep_lanes(const opened_faces *o, const sloped_faces *s, norma_weight weight,
    int first, kept_eight *kept) {
    const vector one = VECTORS(all)(1), factor = weight == NORMA_WEIGHT_AREA ? o->length : one;
    double(*rows)[4] = kept->row + first;
    kept->sure |= VECTORS(bits)(o->sure) << first;
    if (core_weighs_evenly(weight)) {
        VECTORS(store_rows)
        (o->normal[0] * factor, o->normal[1] * factor, o->normal[2] * factor, factor, rows);
        return;
    }
    VECTORS(store_rows)(o->normal[0], o->normal[1], o->normal[2], one, rows);
    double *const weights[3] = {kept->weight[0], kept->weight[1], kept->weight[2]};
    keep_weights(o, s, weight, first, weights, &kept->edges);
}

IN_VECTORS void weigh_eight(norma_weight weight, kept_eight *kept) {
    double *const weights[3] = {kept->weight[0], kept->weight[1], kept->weight[2]};
    if (!core_weighs_evenly(weight) && weight != NORMA_WEIGHT_ANGLE)
        weigh_kept(weight, &kept->edges, weights);
}

IN_VECTORS void keep_welded(const core_mesh *mesh, size_t f, kept_eight *kept) {
    memcpy(kept->at, corners_at(mesh, f), sizeof kept->at);
    for (size_t c = 0; c < 3 * CORE_LANES; ++c) kept->at[c] = mesh->weld[kept->at[c]];
}

IN_VECTORS void add_kept(
    const core_adder *adder, const kept_eight *kept, size_t f, norma_weight weight) {
    const core_eight eight = {(const double(*)[4])kept->row,
        (const double(*)[CORE_LANES])kept->weight, sums_at(adder, kept, f), kept->sure};
    core_add_eight(adder, &eight, f, CORE_LANES, weight);
}

/* Asks for the memory of triangles to come, into the second cache, to which twice as many requests
 * are under way at once as to the first: positions, which may lie across two lines, and sums. Where
 * there is a map of welded positions, that is asked for earlier still. */
CORE_INLINE void ask_for_triangles(const core_adder *adder, size_t f) {
    const core_mesh *mesh = adder->mesh;
    const size_t begin = 3 * (f + AHEAD), end = begin + (size_t)3 * CORE_LANES,
                 map = (size_t)3 * AHEAD;
    for (size_t c = begin; c < end && c < mesh->corner_count; ++c) {
        const uint32_t at = norma_core_corner(mesh, c);
        const unsigned char *position =
            (const unsigned char *)mesh->positions.data + at * mesh->positions.stride;
        __builtin_prefetch(position, 0, 2);
        __builtin_prefetch(position + 11, 0, 2);
        const uint32_t sum =
            (adder->targets ? adder->targets[c] : norma_core_welded(mesh, at)) - adder->first;
        if (sum < adder->count) __builtin_prefetch(&adder->sums[sum], 0, 2);
        if (mesh->weld && !adder->targets && c + map < mesh->corner_count)
            __builtin_prefetch(&mesh->weld[norma_core_corner(mesh, c + map)], 0, 2);
    }
}

/* The next faces are read and multiplied and the last eight added while these ones' divisions are
 * under way: what waits for them would otherwise keep the processor from seeing that far ahead. */
IN_VECTORS void add_weighted(
    const core_adder *adder, size_t begin, size_t end, int doubles, norma_weight weight) {
    const core_mesh *mesh = adder->mesh;
    const size_t eights = (end - begin) / CORE_LANES;
    kept_eight kept[2];
    opened_faces next;
    if (eights) open_faces(mesh, corners_at(mesh, begin), doubles, weight, &next);
    for (size_t i = 0; i < eights; ++i) {
        const size_t f = begin + i * CORE_LANES;
        kept_eight *this = &kept[i % 2], *last = &kept[(i + 1) % 2];
        this->sure = 0;
        if (adder->scattered) ask_for_triangles(adder, f);
        for (int lane = 0; lane < CORE_LANES; lane += LANES) {
            const size_t after = f + (size_t)(lane + LANES);
            opened_faces o = next;
            sloped_faces s;
            divide_faces(&o, weight, &s);
            open_faces(mesh, corners_at(mesh, after + LANES <= end ? after : begin), doubles,
                weight, &next);
            if (!lane && i > 0) add_kept(adder, last, f - CORE_LANES, weight);
            keep_lanes(&o, &s, weight, lane, this);
        }
        weigh_eight(weight, this);
        if (mesh->weld && !adder->targets) keep_welded(mesh, f, this);
    }
    if (eights) add_kept(adder, &kept[(eights - 1) % 2], begin + (eights - 1) * CORE_LANES, weight);
}

/* Eight or fewer that cannot be read so: copied first. Lanes beyond the end repeat the first. */
IN_VECTORS void add_copied(const core_adder *adder, size_t f, int lanes, norma_weight weight) {
    const core_mesh *mesh = adder->mesh;
    double points[3 * CORE_LANES][3];
    uint32_t names[3 * CORE_LANES];
    kept_eight kept = {.sure = 0};
    const core_mesh copy = {
        .positions = {points, 3 * CORE_LANES, sizeof points[0], NORMA_FORMAT_DOUBLE},
        .corners = names,
        .scale = 1};
    for (int i = 0; i < 3 * CORE_LANES; ++i) {
        const size_t corner = 3 * f + (size_t)(i / 3 < lanes ? i : i % 3);
        const uint32_t at = norma_core_corner(mesh, corner);
        norma_core_position(mesh, at, points[i]);
        names[i] = (uint32_t)i;
        kept.at[i] = adder->targets ? adder->targets[corner] : norma_core_welded(mesh, at);
    }
    for (int lane = 0; lane < CORE_LANES; lane += LANES) {
        opened_faces o;
        sloped_faces s;
        memset(&o, 0, sizeof o); /* the weight is not known here, nor what it leaves as it was */
        memset(&s, 0, sizeof s);
        open_faces(&copy, corners_at(&copy, (size_t)lane), 1, weight, &o);
        divide_faces(&o, weight, &s);
        keep_lanes(&o, &s, weight, lane, &kept);
    }
    weigh_eight(weight, &kept);
    const core_eight eight = {(const double(*)[4])kept.row,
        (const double(*)[CORE_LANES])kept.weight, (const unsigned char *)kept.at, kept.sure};
    core_add_eight(adder, &eight, f, lanes, weight);
}

/* In WebAssembly, what is seldom asked for goes through one loop, for the module's size. */
#if defined(__wasm__) && !defined(NORMA_SMALL)
#define EACH_WEIGHT(adder, begin, end, doubles)                                                    \
    if ((adder)->weight == NORMA_WEIGHT_ANGLE && !(doubles))                                       \
        add_weighted(adder, begin, end, doubles, NORMA_WEIGHT_ANGLE);                              \
    else if ((adder)->weight == NORMA_WEIGHT_AREA && !(doubles))                                   \
        add_weighted(adder, begin, end, doubles, NORMA_WEIGHT_AREA);                               \
    else                                                                                           \
        add_weighted(adder, begin, end, doubles, (adder)->weight);
#else
#define EACH_WEIGHT(adder, begin, end, doubles)                                                    \
    CORE_LOOP_FOR_WEIGHT((adder)->weight, add_weighted, adder, begin, end, doubles)
#endif

/* Functions of their own: in one with the other, each would be a tenth slower for want of
 * registers. */
FOR_VECTORS static void add_floats(const core_adder *adder, size_t begin, size_t end){
    EACH_WEIGHT(adder, begin, end, 0)}

FOR_VECTORS static void add_doubles(const core_adder *adder, size_t begin, size_t end){
    EACH_WEIGHT(adder, begin, end, 1)}

FOR_VECTORS static void add_others(const core_adder *adder, size_t begin, size_t end) {
    for (size_t f = begin; f < end; f += CORE_LANES)
        add_copied(adder, f, end - f < CORE_LANES ? (int)(end - f) : CORE_LANES, adder->weight);
}

static void add_triangles(const core_adder *adder, size_t begin, size_t end) {
    const core_mesh *mesh = adder->mesh;
    const norma_format format = mesh->positions.format;
    const int can = mesh->corner_size == sizeof(uint32_t) &&
                    (format == NORMA_FORMAT_FLOAT || format == NORMA_FORMAT_DOUBLE);
    const size_t whole = can ? end - (end - begin) % CORE_LANES : begin;
    if (whole > begin && format == NORMA_FORMAT_FLOAT) add_floats(adder, begin, whole);
    if (whole > begin && format == NORMA_FORMAT_DOUBLE) add_doubles(adder, begin, whole);
    add_others(adder, whole, end);
}

/* ---- faces of any number of corners, measured a block at a time */

/* Asks for the positions of a block to come. */
static void ask_for_polygons(const core_mesh *mesh, size_t begin, size_t end) {
    const size_t last = norma_core_face_begin(mesh, end);
    for (size_t c = norma_core_face_begin(mesh, begin); c < last; ++c) {
        const uint32_t at = norma_core_corner(mesh, c);
        const unsigned char *position =
            (const unsigned char *)mesh->positions.data + at * mesh->positions.stride;
        __builtin_prefetch(position, 0, 2);
        __builtin_prefetch(position + 11, 0, 2);
        if (mesh->weld) __builtin_prefetch(&mesh->weld[at], 0, 2);
    }
}

static void ask_for_sums(
    const core_adder *adder, const core_measured *m, const uint32_t *sums, size_t faces) {
    for (size_t i = 0; i < faces; ++i)
        for (size_t k = 0; k < m->corners[i]; ++k) {
            const uint32_t sum = sums[m->first[i] + k] - adder->first;
            if (sum < adder->count) __builtin_prefetch(&adder->sums[sum], 1, 2);
        }
}

/* Corners of a range that is another's are passed over. sums: of each corner of the block. */
CORE_INLINE void add_corners(const core_adder *adder, const core_measured *m, const uint32_t *sums,
    size_t face, size_t corners, int owns_all) {
    const size_t slot = m->slot[face];
    const core_lane *weight = m->weight[slot / CORE_LANES];
    const uint32_t *at = sums + m->first[face];
    for (size_t k = 0; k < corners; ++k) {
        const uint32_t sum = at[k] - adder->first;
        if (owns_all || sum < adder->count)
            core_add_row(&adder->sums[sum].x, m->row[slot], weight[k][slot % CORE_LANES]);
    }
}

CORE_INLINE void add_block(const core_adder *adder, const core_measured *m, const uint32_t *sums,
    size_t begin, size_t faces) {
    for (size_t i = 0; i < faces; ++i) {
        if (!m->corners[i])
            adder->add_alone(adder->context, begin + i);
        else if (m->corners[i] == 4 && adder->owns_all)
            add_corners(adder, m, sums, i, 4, 1);
        else
            add_corners(adder, m, sums, i, m->corners[i], 0);
    }
}

FOR_VECTORS static void add_polygons(const core_adder *adder, size_t begin, size_t end) {
    core_measured measured;
    for (size_t f = begin, next; f < end; f = next) {
        next = end - f < CORE_FACES_AT_ONCE ? end : f + CORE_FACES_AT_ONCE;
        measure_faces(adder->mesh, f, next, adder->weight, CORE_ALL_CORNERS, &measured);
        const uint32_t *sums =
            adder->targets ? adder->targets + norma_core_face_begin(adder->mesh, f) : measured.at;
        if (adder->scattered) {
            ask_for_sums(adder, &measured, sums, next - f);
            ask_for_polygons(adder->mesh, next,
                end - next < CORE_FACES_AT_ONCE ? end : next + CORE_FACES_AT_ONCE);
        }
        add_block(adder, &measured, sums, f, next - f);
    }
}

/* ---- sums become normals */

/* Rows are of four: wider registers take half as long again. */
FOR_ROWS static int finish_sums(const core_vertex_sum *sums, float (*normals)[3]) {
    core_lengths lengths;
    core_lane fine = {0};
    core_lanes_lengths(sums, &lengths, fine);
    core_lanes_directions(&lengths, normals);
    return core_lanes_total(fine) == CORE_LANES;
}

/* ---- what a level has */

static const core_kernels KERNELS = {
    measure_batch, measure_faces, add_triangles, CORE_IS_SMALL ? NULL : add_polygons, finish_sums};
