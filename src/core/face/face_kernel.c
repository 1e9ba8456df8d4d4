/* face_kernel.c: the faces of a block are sorted by their number of corners, and those of each
 * number measured eight at a time. */
#include "core/face/face.h"

/* ---- which faces, and their corners */

static int has_plain_corners(const core_mesh *mesh) {
    return mesh->corner_size == sizeof(uint32_t) &&
           (uintptr_t)mesh->corners % _Alignof(uint32_t) == 0;
}

/* Returns the positions of the block's corners as the mesh names them, in named if it does not have
 * them so; out->at: as they are welded. */
static const uint32_t *list_block_corners(
    const core_mesh *mesh, size_t begin, size_t count, uint32_t *named, core_measured *out) {
    const uint32_t *at = named;
    if (has_plain_corners(mesh))
        at = (const uint32_t *)mesh->corners + begin;
    else
        norma_core_read_corners(mesh, begin, count, named);
    out->at = mesh->weld || at == named ? out->room : at;
    for (size_t i = 0; i < count && out->at != at; ++i)
        out->room[i] = norma_core_welded(mesh, at[i]);
    return at;
}

/* Whether all faces have as many corners as the first: that number, else 0. */
static size_t count_alike(const core_mesh *mesh, size_t begin, size_t end) {
    const size_t corners = norma_core_face_end(mesh, begin) - norma_core_face_begin(mesh, begin);
    uint32_t other = 0;
    if (norma_core_face_starts(mesh))
        for (size_t f = begin; f < end; ++f)
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
    for (size_t f = begin; f < end; ++f) {
        const size_t c = norma_core_face_begin(mesh, f), last = norma_core_face_end(mesh, f);
        out->first[f - begin] = (uint32_t)(c - first);
        corners[f - begin] = out->corners[f - begin] = 0;
        if (last - c < 3 || last - c > CORE_MOST_CORNERS || last - first > corners_there) continue;
        corners[f - begin] = (uint8_t)(last - c);
        ++count[last - c];
    }
    size_t slot = 0;
    for (size_t n = 3; n <= CORE_MOST_CORNERS; ++n) {
        begins->of[n] = slot;
        for (size_t i = 0; i < end - begin && count[n]; ++i) {
            if (corners[i] != n) continue;
            out->slot[i] = (uint8_t)slot;
            out->face[slot++] = (uint8_t)i;
        }
        for (; slot % CORE_LANES; ++slot) out->face[slot] = out->face[slot - slot % CORE_LANES];
    }
    begins->of[CORE_MOST_CORNERS + 1] = slot;
}

/* The same where all have equally many. */
static void give_slots_in_order(
    size_t faces, size_t corners, slot_begins *begins, core_measured *out) {
    size_t slot = faces;
    for (size_t i = 0; i < CORE_FACES_AT_ONCE; ++i) {
        out->corners[i] = 0;
        out->slot[i] = out->face[i] = (uint8_t)i;
        out->first[i] = (uint32_t)(corners * i);
    }
    for (; slot % CORE_LANES; ++slot) out->face[slot] = out->face[slot - slot % CORE_LANES];
    for (size_t n = 3; n <= CORE_MOST_CORNERS + 1; ++n) begins->of[n] = n > corners ? slot : 0;
}

/* ---- a block */

void norma_core_measure_faces(const core_kernels *kernels, const core_mesh *mesh, size_t begin,
    size_t end, norma_weight weight, core_corners wanted, core_measured *out) {
    const size_t first = norma_core_face_begin(mesh, begin),
                 corners = norma_core_face_begin(mesh, end) - first,
                 count = corners < CORE_CORNERS_AT_ONCE ? corners : CORE_CORNERS_AT_ONCE,
                 alike = count_alike(mesh, begin, end);
    uint32_t named[CORE_CORNERS_AT_ONCE];
    slot_begins begins;
    const core_faces_alike faces = {
        mesh, list_block_corners(mesh, first, count, named, out), weight, wanted, out};
    if (alike)
        give_slots_in_order(end - begin, alike, &begins, out);
    else
        give_slots(mesh, begin, end, count, &begins, out);
    for (size_t n = 3; n <= CORE_MOST_CORNERS; ++n)
        if (begins.of[n] < begins.of[n + 1])
            kernels->measure_alike(&faces, begins.of[n], begins.of[n + 1], n);
}
