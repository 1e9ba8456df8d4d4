/* members.c: insertion for the few of ordinary rings, a heap for the rest. */
#include "members.h"

_Static_assert(sizeof(ring_member) <= 2 * sizeof(ring_edge), "a ring's members lie in the room of its edges");

static int member_less(const ring_member *a, const ring_member *b)
{
    if (a->vertex != b->vertex) return a->vertex < b->vertex;
    for (int k = 0; k < 3; k++)
        if (a->bits[k] != b->bits[k]) return a->bits[k] < b->bits[k];
    return a->index < b->index;
}

static void swap(ring_member *a, ring_member *b)
{
    const ring_member m = *a;
    *a = *b;
    *b = m;
}

static void sift(ring_member *heap, size_t at, size_t count)
{
    for (size_t child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && member_less(&heap[child], &heap[child + 1])) child++;
        if (!member_less(&heap[at], &heap[child])) return;
        swap(&heap[at], &heap[child]);
    }
}

static void heap_sort(ring_member *members, size_t count)
{
    for (size_t i = count / 2; i-- > 0;) sift(members, i, count);
    for (size_t end = count; end > 1; end--) {
        swap(&members[0], &members[end - 1]);
        sift(members, 0, end - 1);
    }
}

static void insertion_sort(ring_member *members, size_t count)
{
    for (size_t i = 1; i < count; i++)
        for (size_t at = i; at > 0 && member_less(&members[at], &members[at - 1]); at--) swap(&members[at], &members[at - 1]);
}

enum { FEW_MEMBERS = 24 };

void norma_core_sort_members(ring_member *members, size_t count)
{
    if (count <= FEW_MEMBERS) insertion_sort(members, count);
    else heap_sort(members, count);
}
