/* fuzz_obj.c: any bytes as OBJ. */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    return fuzz_reader(bytes, size, NORMA_FILE_OBJ);
}
