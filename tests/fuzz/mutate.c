/* mutate.c: which mutation a format gets. */
#include "mutate.h"

size_t fuzz_mutate(
    norma_file_format format, uint8_t *bytes, size_t size, size_t capacity, unsigned seed) {
    fuzz_random random = {seed};
    size_t mutated = 0;
    if (fuzz_random_below(&random, 16) != 0) {
        if (format == NORMA_FILE_GLTF)
            mutated = fuzz_mutate_json(bytes, size, capacity, &random);
        else if (format == NORMA_FILE_GLB)
            mutated = fuzz_mutate_glb(bytes, size, capacity, &random);
        else if (format == NORMA_FILE_PLY)
            mutated = fuzz_mutate_ply(bytes, size, capacity, &random);
    }
    return mutated ? mutated : LLVMFuzzerMutate(bytes, size, capacity);
}
