/* position_order.c: positions in the order of a curve that stays near itself (Morton 1966), so that
 * those that follow each other are neighbours, whatever the order of the mesh. */
#include "core/plan/plan.h"
#include <math.h>

enum { LEVELS = 16, KEY_BITS = 32, DIGIT_BITS = 11, DIGITS = 3 };

typedef struct curve {
    double low[3], scale;
    uint32_t spread[3][2][256]; /* what a byte of a coordinate contributes to the key */
} curve;

static void find_box(const core_mesh *mesh, double low[3], double high[3]) {
    for (int k = 0; k < 3; k++) {
        low[k] = INFINITY;
        high[k] = -INFINITY;
    }
    for (size_t p = 0; p < mesh->positions.count; p++) {
        double at[3];
        norma_core_position(mesh, (uint32_t)p, at);
        if (!norma_core_finite(at)) continue;
        for (int k = 0; k < 3; k++) {
            low[k] = at[k] < low[k] ? at[k] : low[k];
            high[k] = at[k] > high[k] ? at[k] : high[k];
        }
    }
}

static int levels_of(double extent, double scale) {
    int levels = 0;
    for (uint32_t cells = (uint32_t)(extent * scale); cells; cells >>= 1) levels++;
    return levels;
}

/* Cells are cubes; an axis along which the mesh is thin has fewer of them, and takes fewer bits of
 * the key. */
static void lay_out(curve *c, const int levels[3]) {
    int bit = KEY_BITS;
    memset(c->spread, 0, sizeof c->spread);
    for (int level = LEVELS; level-- > 0 && bit > 0;)
        for (int k = 0; k < 3 && bit > 0; k++) {
            if (level >= levels[k]) continue;
            bit--;
            for (uint32_t byte = 0; byte < 256; byte++)
                if (byte >> (level % 8) & 1) c->spread[k][level / 8][byte] |= (uint32_t)1 << bit;
        }
}

static void begin_curve(const core_mesh *mesh, curve *c) {
    double high[3], widest = 0;
    int levels[3];
    find_box(mesh, c->low, high);
    for (int k = 0; k < 3; k++) widest = fmax(widest, high[k] - c->low[k]);
    c->scale = widest > 0 && widest <= 0x1p1000 ? ((1 << LEVELS) - 1) / widest : 0;
    if (!(c->scale <= 0x1p1000)) c->scale = 0;
    for (int k = 0; k < 3; k++)
        levels[k] = c->scale > 0 ? levels_of(high[k] - c->low[k], c->scale) : 0;
    lay_out(c, levels);
}

static uint32_t key_of(const curve *c, const double p[3]) {
    uint32_t key = 0;
    if (!norma_core_finite(p)) return UINT32_MAX;
    for (int k = 0; k < 3; k++) {
        const uint32_t cell = (uint32_t)((p[k] - c->low[k]) * c->scale) & 0xffff;
        key |= c->spread[k][0][cell & 255] | c->spread[k][1][cell >> 8];
    }
    return key;
}

/* Radix sort by the high words, the low ones ascending before and after. */
static void sort_by_key(uint64_t *items, uint64_t *other, size_t count) {
    for (int digit = 0; digit < DIGITS; digit++) {
        const int shift = 32 + digit * DIGIT_BITS;
        size_t starts[1 << DIGIT_BITS], sum = 0;
        memset(starts, 0, sizeof starts);
        for (size_t i = 0; i < count; i++) starts[items[i] >> shift & ((1 << DIGIT_BITS) - 1)]++;
        for (size_t d = 0; d < (size_t)1 << DIGIT_BITS; d++) {
            const size_t here = starts[d];
            starts[d] = sum;
            sum += here;
        }
        for (size_t i = 0; i < count; i++)
            other[starts[items[i] >> shift & ((1 << DIGIT_BITS) - 1)]++] = items[i];
        uint64_t *sorted = other;
        other = items;
        items = sorted;
    }
}

norma_result norma_core_plan_order(
    const core_prepared_mesh *prepared, uint32_t *order, size_t *count) {
    const core_mesh *mesh = &prepared->mesh;
    const size_t room = mesh->positions.count;
    uint64_t *items = norma_core_allocate(prepared->call, room, sizeof *items),
             *other = norma_core_allocate(prepared->call, room, sizeof *other);
    *count = 0;
    if (items && other) {
        curve c;
        begin_curve(mesh, &c);
        for (size_t p = 0; p < room; p++) {
            double at[3];
            if (prepared->corners_of.starts[p] == prepared->corners_of.starts[p + 1]) continue;
            norma_core_position(mesh, (uint32_t)p, at);
            items[(*count)++] = (uint64_t)key_of(&c, at) << 32 | p;
        }
        sort_by_key(items, other, *count);
        for (size_t i = 0; i < *count; i++) order[i] = (uint32_t)(DIGITS % 2 ? other[i] : items[i]);
    }
    const norma_result result = items && other ? NORMA_OK : NORMA_ERROR_MEMORY;
    norma_core_release(prepared->call, items, room, sizeof *items);
    norma_core_release(prepared->call, other, room, sizeof *other);
    return result;
}
