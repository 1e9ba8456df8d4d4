/* fuzz_gltf.c: any bytes as GLTF, mutated by its structure. */
#include "mutate.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    return fuzz_reader(bytes, size, NORMA_FILE_GLTF);
}

size_t LLVMFuzzerCustomMutator(uint8_t *bytes, size_t size, size_t capacity, unsigned seed) {
    return fuzz_mutate(NORMA_FILE_GLTF, bytes, size, capacity, seed);
}
