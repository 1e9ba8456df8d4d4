/* fix_judge.h: what a fix may never do (RULES.md), looked at a second time, naively: the file
 * before and the file after are read anew, and compared face by face, edge by edge and rule by
 * rule. */
#ifndef NORMA_TESTS_FIX_JUDGE_H
#define NORMA_TESTS_FIX_JUDGE_H
#include <norma/check.h>

typedef struct fix_file {
    const void *bytes;
    size_t size;
    norma_file_format format;
} fix_file;

typedef struct fix_verdict {
    int changed;  /* the fix wrote another file */
    size_t wrong; /* what it may never do; each is printed */
} fix_verdict;

/* Fixes a file in memory as options say, calls fixed (or NULL) where it was changed, and judges
 * what is written. */
fix_verdict judge_fix(const char *name, fix_file file, const norma_check_options *options,
    int unsafe, void (*fixed)(void));
#endif
