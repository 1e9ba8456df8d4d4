/* weld_buckets.h: which of many keys are one, for whatever the caller calls a key. */
#ifndef NORMA_CORE_WELD_BUCKETS_H
#define NORMA_CORE_WELD_BUCKETS_H
#include "core/call/call.h"

typedef struct weld_keys {
    size_t count;
    const void *context;
    /* Of count keys in a row; 0 for a key that is equal to nothing. */
    void (*hash)(const void *context, size_t first, size_t count, uint64_t *hashes);
    int (*same)(const void *context, uint32_t one, uint32_t other);
} weld_keys;

/* A sum of products by odd numbers to a hash of which the highest bits depend on every bit of the
 * key; never 0. */
static inline uint64_t norma_core_weld_mix(uint64_t sum) {
    const uint64_t hash = (sum ^ (sum >> 32)) * UINT64_C(0xd6e8feb86659fd93);
    return hash ? hash : 1;
}

/* weld: for each key the least that it is one with. *found: how many keys are one with an earlier
 * one. MEMORY or CANCELLED leave weld undefined. */
norma_result norma_core_weld_keys(
    core_call *call, const weld_keys *keys, uint32_t *weld, size_t *found);
#endif
