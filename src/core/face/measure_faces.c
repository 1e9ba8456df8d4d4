/* measure_faces.c: the faces of a block are sorted by their number of corners, and those of each
 * number measured eight at a time, lane by lane; compiled for each instruction set. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize(                                                                              \
    "no-tree-slp-vectorize") /* this compiler gathers neighbouring addresses into vectors, only to \
                                take them out again one by one */
#endif
#include "core/face/measure_faces.h"
#include "core/face/eight_vectors.h"
#include "core/face/polygon.h"

/* One corner of each of eight faces: what its weight is made of. */
typedef struct corner_lanes {
    _Alignas(64) core_lane aa;
    core_lane bb, ab, length, along, tangent, turn, angle, sure, weight;
} corner_lanes;

/* Eight faces of equally many corners. */
typedef struct face_lanes {
    _Alignas(64) core_lane at[CORE_MOST_CORNERS][3];
    core_lane normal[3], size, twice_area, sure, flat;
    corner_lanes corner[CORE_MOST_CORNERS];
} face_lanes;

/* ---- which faces, and their corners */

static int is_plain(const core_mesh *mesh) {
    return mesh->corner_size == sizeof(uint32_t) &&
           (uintptr_t)mesh->corners % _Alignof(uint32_t) == 0;
}

/* Returns the positions of the block's corners as the mesh names them, in named if it does not have
 * them so; out->at: as they are welded. */
static const uint32_t *list_corners(
    const core_mesh *mesh, size_t begin, size_t count, uint32_t *named, core_measured *out) {
    const uint32_t *at = named;
    if (is_plain(mesh))
        at = (const uint32_t *)mesh->corners + begin;
    else
        norma_core_read_corners(mesh, begin, count, named);
    out->at = mesh->weld || at == named ? out->room : at;
    for (size_t i = 0; i < count && out->at != at; i++)
        out->room[i] = norma_core_welded(mesh, at[i]);
    return at;
}

/* Whether all faces have as many corners as the first: that number, else 0. */
static size_t count_alike(const core_mesh *mesh, size_t begin, size_t end) {
    const size_t corners = norma_core_face_end(mesh, begin) - norma_core_face_begin(mesh, begin);
    uint32_t other = 0;
    if (mesh->face_starts)
        for (size_t f = begin; f < end; f++)
            other |= (mesh->face_starts[f + 1] - mesh->face_starts[f]) ^ (uint32_t)corners;
    return !other && corners >= 3 && corners <= CORE_MOST_CORNERS ? corners : 0;
}

/* Of each number of corners, where its slots begin; they end where the next one's begin. */
typedef struct slot_begins {
    size_t of[CORE_MOST_CORNERS + 2];
} slot_begins;

/* The faces in ascending order in eights of equally many corners; lanes that are left over in the
 * last of them repeat its first. */
static void give_slots(const core_mesh *mesh, size_t begin, size_t end, size_t corners_there,
    slot_begins *begins, core_measured *out) {
    uint32_t count[CORE_MOST_CORNERS + 1] = {0};
    uint8_t corners[CORE_FACES_AT_ONCE];
    const size_t first = norma_core_face_begin(mesh, begin);
    for (size_t f = begin; f < end; f++) {
        const size_t c = norma_core_face_begin(mesh, f), last = norma_core_face_end(mesh, f);
        out->first[f - begin] = (uint32_t)(c - first);
        corners[f - begin] = out->corners[f - begin] = 0;
        if (last - c < 3 || last - c > CORE_MOST_CORNERS || last - first > corners_there) continue;
        corners[f - begin] = (uint8_t)(last - c);
        count[last - c]++;
    }
    size_t slot = 0;
    for (size_t n = 3; n <= CORE_MOST_CORNERS; n++) {
        begins->of[n] = slot;
        for (size_t i = 0; i < end - begin && count[n]; i++) {
            if (corners[i] != n) continue;
            out->slot[i] = (uint8_t)slot;
            out->face[slot++] = (uint8_t)i;
        }
        for (; slot % CORE_LANES; slot++) out->face[slot] = out->face[slot - slot % CORE_LANES];
    }
    begins->of[CORE_MOST_CORNERS + 1] = slot;
}

/* The same where all have equally many. */
static void give_slots_in_order(
    size_t faces, size_t corners, slot_begins *begins, core_measured *out) {
    size_t slot = faces;
    for (size_t i = 0; i < CORE_FACES_AT_ONCE; i++) {
        out->corners[i] = 0;
        out->slot[i] = out->face[i] = (uint8_t)i;
        out->first[i] = (uint32_t)(corners * i);
    }
    for (; slot % CORE_LANES; slot++) out->face[slot] = out->face[slot - slot % CORE_LANES];
    for (size_t n = 3; n <= CORE_MOST_CORNERS + 1; n++) begins->of[n] = n > corners ? slot : 0;
}

CORE_INLINE void read_lanes(const core_mesh *mesh, const core_measured *m, const uint32_t *at,
    size_t slot, size_t corners, face_lanes *t) {
    uint32_t eight[CORE_LANES * CORE_MOST_CORNERS];
    for (size_t i = 0; i < CORE_LANES; i++)
        memcpy(eight + corners * i, at + m->first[m->face[slot + i]], corners * sizeof *at);
    const core_points points = core_points_of(mesh, eight, (int)corners);
    for (size_t k = 0; k < corners; k++)
        if (core_can_gather(mesh))
            core_gather_lanes(points, (int)k, t->at[k]);
        else
            for (size_t i = 0; i < CORE_LANES; i++) {
                double p[3];
                norma_core_position(mesh, eight[corners * i + k], p);
                for (int x = 0; x < 3; x++) t->at[k][x][i] = p[x];
            }
}

/* ---- directions */

CORE_INLINE void edge_between(
    const face_lanes *t, size_t from, size_t to, int lane, double edge[3]) {
    for (int x = 0; x < 3; x++) edge[x] = t->at[to][x][lane] - t->at[from][x][lane];
}

CORE_INLINE void measure_triangles(face_lanes *t) {
    CORE_EACH_LANE {
        double u[3], v[3], normal[3];
        edge_between(t, 0, 1, i, u);
        edge_between(t, 0, 2, i, v);
        t->sure[i] = norma_core_triangle(u, v, normal, &t->twice_area[i]) ? 1 : 0;
        for (int x = 0; x < 3; x++) t->normal[x][i] = normal[x];
    }
}

/* The vector area, a triangle of its fan at a time. */
CORE_INLINE void add_fan(face_lanes *t, size_t k) {
    CORE_EACH_LANE {
        double u[3], v[3], term[3];
        edge_between(t, 0, k - 1, i, u);
        edge_between(t, 0, k, i, v);
        norma_core_cross(u, v, term);
        for (int x = 0; x < 3; x++) t->normal[x][i] += term[x];
        t->size[i] += norma_core_dot(v, v);
    }
}

CORE_INLINE void measure_polygons(face_lanes *t, size_t corners) {
    CORE_EACH_LANE {
        double v[3];
        edge_between(t, 0, 1, i, v);
        t->normal[0][i] = t->normal[1][i] = t->normal[2][i] = 0;
        t->size[i] = norma_core_dot(v, v);
    }
    for (size_t k = 2; k < corners; k++) add_fan(t, k);
    CORE_EACH_LANE {
        const double x = t->normal[0][i], y = t->normal[1][i], z = t->normal[2][i],
                     square = x * x + y * y + z * z, length = sqrt(square);
        t->sure[i] = norma_core_area_is_sure(square, t->size[i], (uint32_t)corners) ? 1 : 0;
        t->twice_area[i] = length;
        t->normal[0][i] = x / length;
        t->normal[1][i] = y / length;
        t->normal[2][i] = z / length;
    }
}

/* ---- weights */

/* Of a corner: the squares of its edges, their dot product, the length of their cross product, and
 * the angle between them, turn + atan(tangent). A triangle's own cross product serves at each of
 * its corners. */
CORE_INLINE void measure_corner(face_lanes *t, corner_lanes *c, size_t k, size_t corners) {
    const size_t next = k + 1 < corners ? k + 1 : 0, previous = k ? k - 1 : corners - 1;
    CORE_EACH_LANE {
        double a[3], b[3], cross[3];
        edge_between(t, k, next, i, a);
        edge_between(t, k, previous, i, b);
        norma_core_cross(a, b, cross);
        const double aa = norma_core_dot(a, a), bb = norma_core_dot(b, b),
                     ab = norma_core_dot(a, b), square = norma_core_dot(cross, cross),
                     length = corners == 3 ? t->twice_area[i] : sqrt(square);
        const core_slope slope = norma_core_slope(length, ab < 0 ? -ab : ab);
        c->aa[i] = aa;
        c->bb[i] = bb;
        c->ab[i] = ab;
        c->length[i] = length;
        c->along[i] =
            cross[0] * t->normal[0][i] + cross[1] * t->normal[1][i] + cross[2] * t->normal[2][i];
        c->tangent[i] = slope.above / slope.below;
        c->turn[i] = slope.turn;
        c->sure[i] = (norma_core_corner_is_sure(square, aa * bb) | (corners == 3)) ? 1 : 0;
    }
}

/* The interior angle: above pi where the corner turns the other way than the polygon. */
CORE_INLINE void take_angle(corner_lanes *c, size_t corners) {
    CORE_EACH_LANE {
        const double acute = c->turn[i] + norma_core_weight_atan(c->tangent[i]),
                     angle = c->ab[i] < 0 ? NORMA_PI - acute : acute;
        const int sure = norma_core_turn_is_sure(c->along[i], c->length[i]) | (corners == 3),
                  reflex = (c->along[i] < 0) & (corners > 3);
        c->angle[i] = reflex ? 2 * NORMA_PI - angle : angle;
        c->sure[i] = sure ? c->sure[i] : 0;
    }
}

CORE_INLINE void weigh_corner(const face_lanes *t, corner_lanes *c, norma_weight weight) {
    CORE_EACH_LANE
    c->weight[i] = norma_core_weight_of(
        weight, c->aa[i], c->bb[i], c->angle[i], c->length[i], t->twice_area[i]);
}

CORE_INLINE void see_flat(face_lanes *t, const corner_lanes *c, size_t k) {
    CORE_EACH_LANE {
        const double flat = c->along[i] >= CORE_FLAT_COSINE * c->length[i] ? 1 : 0;
        t->flat[i] = k ? t->flat[i] * flat : flat;
    }
}

/* Each step for all corners, so that none waits for another's. */
CORE_INLINE void weigh_lanes(face_lanes *t, size_t corners, norma_weight weight) {
    const core_weighed_by by = core_weighed(weight);
    for (size_t k = 0; k < corners && by != CORE_BY_FACE; k++)
        measure_corner(t, &t->corner[k], k, corners);
    for (size_t k = 0; k < corners && by == CORE_BY_ANGLE; k++) take_angle(&t->corner[k], corners);
    for (size_t k = 0; k < corners && by == CORE_BY_ANGLE; k++) see_flat(t, &t->corner[k], k);
    for (size_t k = 0; k < corners; k++) {
        corner_lanes *c = &t->corner[k];
        CORE_LOOP_FOR_WEIGHT(weight, weigh_corner, t, c)
        for (int i = 0; i < CORE_LANES && by != CORE_BY_FACE; i++) t->sure[i] *= c->sure[i];
    }
}

/* ---- a block */

CORE_INLINE int has_kept_corners(const uint32_t *at, size_t corners) {
    int kept = at[corners - 1] != at[0];
    for (size_t k = 1; k < corners; k++) kept &= at[k - 1] != at[k];
    return kept;
}

CORE_INLINE void keep_lanes(
    const face_lanes *t, size_t slot, size_t corners, core_corners wanted, core_measured *out) {
    static const double ones[CORE_LANES] = {1, 1, 1, 1, 1, 1, 1, 1};
    const size_t eight = slot / CORE_LANES;
    core_lanes_to_rows(
        t->normal[0], t->normal[1], t->normal[2], ones, (core_rows *)(void *)out->row[slot]);
    memcpy(out->twice_area[eight], t->twice_area, sizeof t->twice_area);
    for (size_t k = 0; wanted == CORE_ALL_CORNERS && k < corners; k++)
        memcpy(out->weight[eight][k], t->corner[k].weight, sizeof(core_lane));
    for (size_t i = 0; i < CORE_LANES; i++) {
        const size_t f = out->face[slot + i];
        const int kept = has_kept_corners(out->at + out->first[f], corners);
        out->corners[f] = (uint8_t)(t->sure[i] != 0 && kept ? corners : 0);
        out->flat[f] = t->flat[i] != 0;
    }
}

CORE_INLINE void measure_alike(const core_mesh *mesh, const uint32_t *at, size_t begin, size_t end,
    size_t corners, norma_weight weight, core_corners wanted, core_measured *out) {
    face_lanes t;
    for (size_t slot = begin; slot < end; slot += CORE_LANES) {
        read_lanes(mesh, out, at, slot, corners, &t);
        if (corners == 3)
            measure_triangles(&t);
        else
            measure_polygons(&t, corners);
        for (size_t i = 0; i < CORE_LANES; i++) t.flat[i] = 0;
        if (wanted == CORE_ALL_CORNERS) weigh_lanes(&t, corners, weight);
        keep_lanes(&t, slot, corners, wanted, out);
    }
}

CORE_INLINE void measure_faces(const core_mesh *mesh, size_t begin, size_t end, norma_weight weight,
    core_corners wanted, core_measured *out) {
    const size_t first = norma_core_face_begin(mesh, begin),
                 corners = norma_core_face_begin(mesh, end) - first,
                 count = corners < CORE_CORNERS_AT_ONCE ? corners : CORE_CORNERS_AT_ONCE,
                 alike = count_alike(mesh, begin, end);
    uint32_t named[CORE_CORNERS_AT_ONCE];
    slot_begins begins;
    const uint32_t *at = list_corners(mesh, first, count, named, out);
    if (alike)
        give_slots_in_order(end - begin, alike, &begins, out);
    else
        give_slots(mesh, begin, end, count, &begins, out);
    measure_alike(mesh, at, begins.of[3], begins.of[4], 3, weight, wanted, out);
    measure_alike(mesh, at, begins.of[4], begins.of[5], 4, weight, wanted, out);
    for (size_t n = 5; n <= CORE_MOST_CORNERS; n++)
        measure_alike(mesh, at, begins.of[n], begins.of[n + 1], n, weight, wanted, out);
}

/* ---- for each instruction set */

static void measure_portable(const core_mesh *mesh, size_t begin, size_t end, norma_weight weight,
    core_corners wanted, core_measured *out) {
    measure_faces(mesh, begin, end, weight, wanted, out);
}
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void measure_avx2(const core_mesh *mesh, size_t begin, size_t end,
    norma_weight weight, core_corners wanted, core_measured *out) {
    measure_faces(mesh, begin, end, weight, wanted, out);
}
#if defined(CORE_HAS_AVX512)
CORE_FOR_AVX512 static void measure_avx512(const core_mesh *mesh, size_t begin, size_t end,
    norma_weight weight, core_corners wanted, core_measured *out) {
    measure_faces(mesh, begin, end, weight, wanted, out);
}
#endif
#endif

void norma_core_measure_faces(core_level level, const core_mesh *mesh, size_t begin, size_t end,
    norma_weight weight, core_corners wanted, core_measured *out) {
    typedef void measure_for(const core_mesh *mesh, size_t begin, size_t end, norma_weight weight,
        core_corners wanted, core_measured *out);
    static measure_for *const measures[] = CORE_KERNELS(measure);
    measures[level](mesh, begin, end, weight, wanted, out);
}
