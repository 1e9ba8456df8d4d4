/* fuzz_oracle.c: everything public of the core, on small meshes made without taste of the input's
 * bytes, against the definitions in exact arithmetic (GMP, tests/support/oracle). An input that is
 * a case as text is that case. What fails is printed as such a case, for tests/fuzz/found/oracle,
 * which test_oracle replays too. */
#define _POSIX_C_SOURCE 200809L
#include "fuzz.h"
#include "oracle/net.h"
#include <string.h>

static made_case made;

static int is_text(const uint8_t *bytes, size_t size) {
    if (size < 5 || memcmp(bytes, "case ", 5) != 0) return 0;
    FILE *file = fmemopen((void *)(uintptr_t)bytes, size, "r");
    const int there = file && made_case_read(&made, file);
    if (file) fclose(file);
    return there;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    if (!is_text(bytes, size)) made_case_make(&made, bytes, size);
    const size_t wrong = net_judge("fuzz", &made);
    if (!wrong) return 0;
    fflush(stdout);
    made_case_print(&made, stderr);
    fuzz_fail("%zu answers are not the definitions'", wrong);
}
