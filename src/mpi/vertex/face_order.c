/* face_order.c: faces sorted by their global numbers, digit by digit from the lowest; numbers are
 * read where they are, so that only places move. */
#include "core/call/call.h"
#include "mpi/vertex/vertex.h"
#include <string.h>

enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS };

static int ascend(const uint64_t *ids, size_t count) {
    for (size_t i = 1; i < count; ++i)
        if (ids[i - 1] > ids[i]) return 0;
    return 1;
}

static size_t radix_digit(uint64_t id, int shift) { return (size_t)(id >> shift) & (DIGITS - 1); }

/* Equal digits keep their order. */
static void sort_by_digit(
    const uint64_t *ids, size_t count, int shift, const uint32_t *from, uint32_t *to) {
    uint32_t starts[DIGITS] = {0}, sum = 0;
    for (size_t i = 0; i < count; ++i) ++starts[radix_digit(ids[i], shift)];
    for (size_t d = 0; d < DIGITS; ++d) {
        const uint32_t here = starts[d];
        starts[d] = sum;
        sum += here;
    }
    for (size_t i = 0; i < count; ++i) to[starts[radix_digit(ids[from[i]], shift)]++] = from[i];
}

/* Returns the array that holds the result. */
static uint32_t *sort_places(
    const uint64_t *ids, size_t count, uint32_t *places, uint32_t *others) {
    uint64_t differ = 0;
    for (size_t i = 0; i < count; ++i) {
        differ |= ids[i] ^ ids[0];
        places[i] = (uint32_t)i;
    }
    for (int shift = 0; shift < 64 && differ >> shift; shift += DIGIT_BITS) {
        uint32_t *const from = places;
        if (!radix_digit(differ, shift)) continue;
        sort_by_digit(ids, count, shift, from, others);
        places = others;
        others = from;
    }
    return places;
}

norma_result norma_mpi_order_faces(
    const core_call *call, const uint64_t *ids, size_t count, mpi_face_order *order) {
    *order = (mpi_face_order){.ids = ids, .count = count};
    if (!ids || ascend(ids, count)) return NORMA_OK;
    uint32_t *places = norma_core_allocate(call, count, sizeof *places),
             *others = norma_core_allocate(call, count, sizeof *others);
    if (!places || !others) {
        norma_core_release(call, places, count, sizeof *places);
        norma_core_release(call, others, count, sizeof *others);
        return NORMA_ERROR_MEMORY;
    }
    order->order = sort_places(ids, count, places, others);
    norma_core_release(call, order->order == places ? others : places, count, sizeof *places);
    return NORMA_OK;
}

void norma_mpi_order_close(const core_call *call, mpi_face_order *order) {
    norma_core_release(call, order->order, order->count, sizeof *order->order);
    order->order = NULL;
}
