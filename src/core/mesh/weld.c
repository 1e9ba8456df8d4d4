/* weld.c: which positions are exactly equal (-0 = 0). */
#include "core/mesh/weld.h"
#include "core/mesh/weld_buckets.h"

/* The same bits for -0 and 0. */
static void position_key(const core_mesh *mesh, uint32_t index, uint64_t key[3]) {
    double p[3];
    norma_core_position(mesh, index, p);
    for (int k = 0; k < 3; k++) {
        p[k] += 0.0;
        memcpy(&key[k], &p[k], sizeof key[k]);
    }
}

/* NaN is equal to nothing, infinity to itself. */
static int key_has_nan(const uint64_t key[3]) {
    const uint64_t infinity = UINT64_C(0x7ff) << 52, magnitude = ~(UINT64_C(1) << 63);
    return (key[0] & magnitude) > infinity || (key[1] & magnitude) > infinity ||
           (key[2] & magnitude) > infinity;
}

static inline uint64_t hash_key(const uint64_t key[3]) {
    const uint64_t sum = key[0] * UINT64_C(0x9e3779b97f4a7c15) +
                         key[1] * UINT64_C(0xbf58476d1ce4e5b9) +
                         key[2] * UINT64_C(0x94d049bb133111eb);
    return norma_core_weld_mix(sum);
}

/* Of floats the bits of floats, two in one factor: fewer steps. */
static uint64_t hash_floats(const unsigned char *at) {
    float p[3];
    uint32_t bits[3];
    memcpy(p, at, sizeof p);
    for (size_t k = 0; k < 3; k++) p[k] += 0.0F;
    memcpy(bits, p, sizeof bits);
    const float all = p[0] + p[1] + p[2]; /* not a number also where infinities cancel */
    if (all != all && (p[0] != p[0] || p[1] != p[1] || p[2] != p[2])) return 0;
    const uint64_t two = bits[0] | (uint64_t)bits[1] << 32,
                   sum =
                       two * UINT64_C(0x9e3779b97f4a7c15) + bits[2] * UINT64_C(0xbf58476d1ce4e5b9);
    return norma_core_weld_mix(sum);
}

static void hash_positions(const void *context, size_t first, size_t count, uint64_t *hashes) {
    const core_mesh *mesh = context;
    const size_t stride = mesh->positions.stride;
    const unsigned char *data = (const unsigned char *)mesh->positions.data + first * stride;
    if (mesh->positions.format == NORMA_FORMAT_FLOAT) {
        for (size_t i = 0; i < count; i++) hashes[i] = hash_floats(data + i * stride);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        uint64_t key[3];
        position_key(mesh, (uint32_t)(first + i), key);
        hashes[i] = key_has_nan(key) ? 0 : hash_key(key);
    }
}

static int same_position(const void *context, uint32_t one, uint32_t other) {
    double a[3], b[3];
    norma_core_position(context, one, a);
    norma_core_position(context, other, b);
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

norma_result norma_core_weld(core_call *call, core_mesh *mesh) {
    if (call->options.weld == NORMA_WELD_NONE || !mesh->positions.count) return NORMA_OK;
    uint32_t *weld = norma_core_allocate(call, mesh->positions.count, sizeof *weld);
    if (!weld) return NORMA_ERROR_MEMORY;
    size_t found;
    const weld_keys keys = {mesh->positions.count, mesh, hash_positions, same_position};
    norma_result result = norma_core_weld_keys(call, &keys, weld, &found);
    const int by_distance =
        call->options.weld == NORMA_WELD_DISTANCE && call->options.weld_distance > 0;
    if (result == NORMA_OK && by_distance)
        result = norma_core_weld_near(call, mesh, call->options.weld_distance * mesh->scale, weld);
    if (result == NORMA_OK && (found || by_distance))
        mesh->weld =
            weld; /* a map of each to itself would only cost a look into it for each corner */
    else
        norma_core_release(call, weld, mesh->positions.count, sizeof *weld);
    return result;
}

void norma_core_unweld(const core_call *call, core_mesh *mesh) {
    norma_core_release(
        call, (void *)(uintptr_t)mesh->weld, mesh->positions.count, sizeof *mesh->weld);
    mesh->weld = NULL;
}
