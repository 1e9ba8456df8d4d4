/* mutate_glb.c: a GLB's JSON chunk stays JSON, its BIN chunk is bytes; the lengths around them
 * follow, but for one in twenty. */
#include "mutate.h"
#include <stdlib.h>
#include <string.h>

static uint32_t read_u32(const uint8_t *at) {
    return at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static void write_u32(uint8_t *at, size_t number) {
    for (int i = 0; i < 4; ++i) at[i] = (uint8_t)(number >> 8 * i);
}

typedef struct chunks {
    uint8_t *json, *bin;
    size_t json_size, bin_size;
} chunks;

static int split(const uint8_t *bytes, size_t size, size_t capacity, chunks *c) {
    if (size < 20 || memcmp(bytes, "glTF", 4) != 0 || read_u32(bytes + 12) > size - 20) return 0;
    c->json_size = read_u32(bytes + 12);
    size_t bin = 20 + c->json_size + 8;
    c->bin_size = bin < size ? size - bin : 0;
    c->json = malloc(capacity + 1);
    c->bin = malloc(capacity + 1);
    memcpy(c->json, bytes + 20, c->json_size);
    if (c->bin_size) memcpy(c->bin, bytes + bin, c->bin_size);
    return 1;
}

static size_t join(const chunks *c, uint8_t *bytes, size_t capacity, fuzz_random *random) {
    size_t json_size = (c->json_size + 3) / 4 * 4, bin_size = (c->bin_size + 3) / 4 * 4,
           size = 20 + json_size + (bin_size ? 8 + bin_size : 0);
    if (size > capacity) return 0;
    memcpy(bytes, "glTF\2\0\0\0", 8);
    write_u32(bytes + 8, size);
    write_u32(bytes + 12, json_size);
    memcpy(bytes + 16, "JSON", 4);
    memcpy(bytes + 20, c->json, c->json_size);
    memset(bytes + 20 + c->json_size, ' ', json_size - c->json_size);
    if (bin_size) {
        uint8_t *at = bytes + 20 + json_size;
        write_u32(at, bin_size);
        memcpy(at + 4, "BIN\0", 4);
        memcpy(at + 8, c->bin, c->bin_size);
        memset(at + 8 + c->bin_size, 0, bin_size - c->bin_size);
    }
    if (fuzz_random_below(random, 20) == 0)
        write_u32(bytes + (fuzz_random_below(random, 2) ? 8 : 12),
            fuzz_random_u32(random) >> fuzz_random_below(random, 32));
    return size;
}

size_t fuzz_mutate_glb(uint8_t *bytes, size_t size, size_t capacity, fuzz_random *random) {
    chunks c;
    if (!split(bytes, size, capacity, &c)) return 0;
    if (c.bin_size && fuzz_random_below(random, 5) < 2)
        c.bin_size = LLVMFuzzerMutate(c.bin, c.bin_size, capacity);
    else {
        size_t mutated = fuzz_mutate_json(c.json, c.json_size, capacity, random);
        c.json_size = mutated ? mutated : LLVMFuzzerMutate(c.json, c.json_size, capacity);
    }
    size = join(&c, bytes, capacity, random);
    free(c.json);
    free(c.bin);
    return size;
}
