/* fix_files.h: small files with something wrong, for fixes: OBJ, PLY, STL and GLB of solids, sheets
 * and made cases, with faces turned, doubled, left out or without area, normals that are wrong. */
#ifndef NORMA_TESTS_FIX_FILES_H
#define NORMA_TESTS_FIX_FILES_H
#include "fix_judge.h"

typedef struct broken_file {
    fix_file file; /* its bytes are to be freed */
    norma_check_options options;
    uint8_t rules[128];
    int unsafe;
} broken_file;

/* The same seed makes the same file and options. options.rules points into out. */
void broken_file_make(uint64_t seed, broken_file *out);
/* Options as a seed has them, for any file. */
void broken_file_options(uint64_t *state, broken_file *out);
void broken_file_free(broken_file *file);
#endif
