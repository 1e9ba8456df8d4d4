/* fuzz_tile.c: any bytes as a tile of 3D Tiles, whichever kind their beginning says. */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    return fuzz_reader(bytes, size, NORMA_FILE_CMPT);
}
