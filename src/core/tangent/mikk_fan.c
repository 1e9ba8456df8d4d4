/* mikk_fan.c: what nearly all vertices are: a few triangles of one sign that make one fan, each
 * edge shared by two at most. They are one group, found without a branch for each pair of them. */
#include "core/tangent/mikk_star.h"

enum { MOST_IN_FAN = 8 };

/* Of each corner: 1 + the one that mikk_links has, or 0; and how many there are to choose from. */
typedef struct fan_links {
    uint32_t left[MOST_IN_FAN], right[MOST_IN_FAN], lefts[MOST_IN_FAN], rights[MOST_IN_FAN];
} fan_links;

CORE_INLINE void find_links(const uint32_t *restrict next, const uint32_t *restrict previous,
    uint32_t count, fan_links *restrict f) {
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t out = next[i], in = previous[i];
#pragma GCC unroll 1 /* lanes of vectors instead: a third faster */
        for (int l = 0; l < MOST_IN_FAN; l++) {
            const uint32_t left = next[l] == in ? UINT32_MAX : 0,
                           right = previous[l] == out ? UINT32_MAX : 0;
            f->left[l] |= left & (i + 1);
            f->right[l] |= right & (i + 1);
            f->lefts[l] -= left;
            f->rights[l] -= right;
        }
    }
}

static int is_one_fan(const fan_links *f, size_t count) {
    uint32_t crowded = 0, corner = 1;
    size_t seen = 0;
    for (int l = 0; l < MOST_IN_FAN; l++) crowded |= (f->lefts[l] | f->rights[l]) & ~UINT32_C(1);
    if (crowded) return 0;
    do {
        corner = f->left[corner - 1];
        seen++;
    } while (corner > 1);
    if (corner == 0)
        for (corner = f->right[0]; corner; corner = f->right[corner - 1]) seen++;
    return seen == count;
}

int norma_core_mikk_fan(
    const mikk_record *records, const uint32_t *corners, size_t count, mikk_space *space) {
    uint32_t next[MOST_IN_FAN], previous[MOST_IN_FAN];
    unsigned ends = 0, flags = 0, all_flags = MIKK_POSITIVE;
    float sum[3] = {0};
    if (count == 0 || count > MOST_IN_FAN) return 0;
    for (size_t j = 0; j < count; j++) {
        const mikk_record *r = &records[corners[j]];
        next[j] = r->next;
        previous[j] = r->previous;
        ends |= r->ends;
        flags |= r->flags;
        all_flags &= r->flags;
        for (int k = 0; k < 3; k++) sum[k] += r->sum[k];
    }
    if (mikk_ends_oppose(ends) || (flags & MIKK_FOLLOWS) || (flags & MIKK_POSITIVE) != all_flags)
        return 0;
    for (size_t j = count; j < MOST_IN_FAN; j++) next[j] = previous[j] = MIKK_NONE;
    fan_links links = {{0}, {0}, {0}, {0}};
    find_links(next, previous, (uint32_t)count, &links);
    *space = (mikk_space){.s = {sum[0], sum[1], sum[2]}, .positive = flags & MIKK_POSITIVE};
    return is_one_fan(&links, count);
}
