/* reverse_winding.c: turning faces round, in place. The first corner of each face stays, so that
 * what was said of it stays true. */
#include <norma/norma.h>
#include <string.h>

static void swap(unsigned char *a, unsigned char *b, size_t size) {
    unsigned char kept[4];
    memcpy(kept, a, size);
    memcpy(a, b, size);
    memcpy(b, kept, size);
}

static norma_result check(
    size_t corner_size, size_t corner_count, const uint32_t *face_starts, size_t face_count) {
    if (corner_size != 1 && corner_size != 2 && corner_size != 4) return NORMA_ERROR_ARGUMENT;
    if (corner_count > SIZE_MAX / corner_size) return NORMA_ERROR_OVERFLOW;
    if (!face_starts) return corner_count % 3 ? NORMA_ERROR_ARGUMENT : NORMA_OK;
    if (face_count >= SIZE_MAX / sizeof *face_starts) return NORMA_ERROR_OVERFLOW;
    if (face_starts[0] != 0 || face_starts[face_count] != corner_count) return NORMA_ERROR_ARGUMENT;
    for (size_t f = 0; f < face_count; f++)
        if (face_starts[f + 1] < face_starts[f]) return NORMA_ERROR_ARGUMENT;
    return NORMA_OK;
}

norma_result norma_reverse_winding(void *corners, size_t corner_size, size_t corner_count,
    const uint32_t *face_starts, size_t face_count) {
    if (!corner_size) corner_size = 4;
    const norma_result result = check(corner_size, corner_count, face_starts, face_count);
    if (result || !corner_count) return result;
    if (!corners) return NORMA_ERROR_ARGUMENT;
    if (!face_starts) face_count = corner_count / 3;
    for (size_t f = 0; f < face_count; f++) {
        size_t low = (face_starts ? face_starts[f] : 3 * f) + 1,
               end = face_starts ? face_starts[f + 1] : 3 * f + 3;
        for (; low + 1 < end; low++, end--)
            swap((unsigned char *)corners + low * corner_size,
                (unsigned char *)corners + (end - 1) * corner_size, corner_size);
    }
    return NORMA_OK;
}
