/* mutate.h: mutations that know a format's structure, so that most of what they make is read past
 * its first bytes. Each works in place and returns the new size, at most capacity; all that is
 * random comes from the seed. */
#ifndef NORMA_FUZZ_MUTATE_H
#define NORMA_FUZZ_MUTATE_H
#include "fuzz.h"

size_t fuzz_mutate_json(uint8_t *bytes, size_t size, size_t capacity,
    fuzz_random *random); /* JSON stays JSON; 0: it was none */
size_t fuzz_mutate_glb(
    uint8_t *bytes, size_t size, size_t capacity, fuzz_random *random); /* 0: it was none */
size_t fuzz_mutate_ply(
    uint8_t *bytes, size_t size, size_t capacity, fuzz_random *random); /* 0: it has no header */
/* By the format; one in sixteen is libFuzzer's own, of bytes. */
size_t fuzz_mutate(
    norma_file_format format, uint8_t *bytes, size_t size, size_t capacity, unsigned seed);
#endif
