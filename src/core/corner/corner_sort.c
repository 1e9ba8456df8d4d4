/* corner_sort.c: insertion for the few of ordinary stars, a heap for the rest. */
#include "core/corner/corner_sort.h"
#include "core/call/call.h"

_Static_assert(
    sizeof(star_member) <= 2 * sizeof(star_edge), "a star's members lie in the room of its edges");

static int member_less(const void *one, const void *other) {
    const star_member *a = one, *b = other;
    if (a->vertex != b->vertex) return a->vertex < b->vertex;
    for (int k = 0; k < 3; k++)
        if (a->bits[k] != b->bits[k]) return a->bits[k] < b->bits[k];
    return a->index < b->index;
}

static void swap(star_member *a, star_member *b) {
    const star_member m = *a;
    *a = *b;
    *b = m;
}

static void insertion_sort(star_member *members, size_t count) {
    for (size_t i = 1; i < count; i++)
        for (size_t at = i; at > 0 && member_less(&members[at], &members[at - 1]); at--)
            swap(&members[at], &members[at - 1]);
}

enum { FEW_MEMBERS = 24 };

void norma_core_sort_corners(star_member *members, size_t count) {
    if (count <= FEW_MEMBERS)
        insertion_sort(members, count);
    else
        norma_core_sort(members, count, sizeof *members, member_less);
}
