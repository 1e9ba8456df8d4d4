/* add_polygons.c: faces of any number of corners, measured a block at a time and then added in
 * ascending order; compiled for each instruction set. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-tree-slp-vectorize") /* as in add_triangles.c */
#endif
#include "core/vertex/vertex.h"
#include "core/face/eight_vectors.h"
#include "core/face/face.h"

/* Asks for the positions of a block to come. */
static void look_at_polygons_ahead(const core_mesh *mesh, size_t begin, size_t end) {
    const size_t last = norma_core_face_begin(mesh, end);
    for (size_t c = norma_core_face_begin(mesh, begin); c < last; c++) {
        const uint32_t at = norma_core_corner(mesh, c);
        const unsigned char *position =
            (const unsigned char *)mesh->positions.data + at * mesh->positions.stride;
        __builtin_prefetch(position, 0, 2);
        __builtin_prefetch(position + 11, 0, 2);
        if (mesh->weld) __builtin_prefetch(&mesh->weld[at], 0, 2);
    }
}

static void ask_for_sums(const core_adder *adder, const core_measured *m, size_t faces) {
    for (size_t i = 0; i < faces; i++)
        for (size_t k = 0; k < m->corners[i]; k++) {
            const uint32_t sum = m->at[m->first[i] + k] - adder->first;
            if (sum < adder->count) __builtin_prefetch(&adder->sums[sum], 1, 2);
        }
}

/* Corners of a range that is another's are passed over. */
CORE_INLINE void add_corners(
    const core_adder *adder, const core_measured *m, size_t face, size_t corners, int owns_all) {
    const size_t slot = m->slot[face];
    const core_lane *weight = m->weight[slot / CORE_LANES];
    const uint32_t *at = m->at + m->first[face];
    for (size_t k = 0; k < corners; k++) {
        const uint32_t sum = at[k] - adder->first;
        if (owns_all || sum < adder->count)
            core_add_row(&adder->sums[sum].x, m->row[slot], weight[k][slot % CORE_LANES]);
    }
}

/* ---- the same with chains */

/* Two corners at one position: the face may meet itself there. */
static int has_twice(const uint32_t *at, size_t corners) {
    for (size_t k = 2; k < corners; k++)
        for (size_t j = 0; j + 1 < k; j++)
            if (at[j] == at[k]) return 1;
    return 0;
}

CORE_INLINE void chain_face(
    const core_adder *adder, const core_measured *m, size_t face, size_t corners) {
    const size_t slot = m->slot[face];
    const uint32_t *at = m->at + m->first[face];
    const float normal[3] = {
        (float)m->row[slot][0], (float)m->row[slot][1], (float)m->row[slot][2]};
    for (size_t k = 0; k < corners; k++) {
        const uint32_t sum = at[k] - adder->first;
        if (sum >= adder->count) continue;
        core_add_row(
            &adder->sums[sum].x, m->row[slot], m->weight[slot / CORE_LANES][k][slot % CORE_LANES]);
        core_follow_chains(&adder->chains[sum], normal, adder->chain_cosine,
            at[k + 1 < corners ? k + 1 : 0], at[k ? k - 1 : corners - 1]);
    }
}

static void break_face(const core_adder *adder, size_t face) {
    const core_mesh *mesh = adder->mesh;
    const size_t end = norma_core_face_end(mesh, face);
    for (size_t c = norma_core_face_begin(mesh, face); c < end; c++) {
        const uint32_t sum = norma_core_welded_corner(mesh, c) - adder->first;
        if (sum < adder->count) core_break_chains(&adder->chains[sum]);
    }
}

CORE_INLINE void chain_block(
    const core_adder *adder, const core_measured *m, size_t begin, size_t faces) {
    for (size_t i = 0; i < faces; i++) {
        const size_t corners = m->corners[i];
        if (!corners || !m->flat[i] || has_twice(m->at + m->first[i], corners))
            break_face(adder, begin + i);
        else if (corners == 4)
            chain_face(adder, m, i, 4);
        else
            chain_face(adder, m, i, corners);
    }
}

CORE_INLINE void add_block(
    const core_adder *adder, const core_measured *m, size_t begin, size_t faces) {
    for (size_t i = 0; i < faces; i++) {
        if (!m->corners[i])
            adder->add_face(adder->context, begin + i);
        else if (m->corners[i] == 4 && adder->owns_all)
            add_corners(adder, m, i, 4, 1);
        else
            add_corners(adder, m, i, m->corners[i], 0);
    }
}

CORE_INLINE void add_polygons(const core_adder *adder, size_t begin, size_t end, core_level level) {
    core_measured measured;
    for (size_t f = begin, next; f < end; f = next) {
        next = end - f < CORE_FACES_AT_ONCE ? end : f + CORE_FACES_AT_ONCE;
        norma_core_measure_faces(
            level, adder->mesh, f, next, adder->weight, CORE_ALL_CORNERS, &measured);
        if (adder->scattered) {
            ask_for_sums(adder, &measured, next - f);
            look_at_polygons_ahead(adder->mesh, next,
                end - next < CORE_FACES_AT_ONCE ? end : next + CORE_FACES_AT_ONCE);
        }
        if (adder->chains)
            chain_block(adder, &measured, f, next - f);
        else
            add_block(adder, &measured, f, next - f);
    }
}

static void add_polygons_portable(const core_adder *adder, size_t begin, size_t end) {
    add_polygons(adder, begin, end, CORE_PORTABLE);
}
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void add_polygons_avx2(const core_adder *adder, size_t begin, size_t end) {
    add_polygons(adder, begin, end, CORE_AVX2);
}
#if defined(CORE_HAS_AVX512)
CORE_FOR_AVX512 static void add_polygons_avx512(const core_adder *adder, size_t begin, size_t end) {
    add_polygons(adder, begin, end, CORE_AVX512);
}
#endif
#endif

core_add_faces *norma_core_choose_add_polygons(norma_isa isa) {
    static core_add_faces *const ADD[] = CORE_KERNELS(add_polygons);
    return ADD[norma_core_level(isa)];
}
