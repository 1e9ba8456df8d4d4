/* net.h: everything public of the core, called with a made case in arrays between pages that nobody
 * may touch, and judged by the definitions. */
#ifndef NORMA_TESTS_NET_H
#define NORMA_TESTS_NET_H
#include "oracle/made_case.h"

/* Returns how many answers are wrong; each is printed. */
size_t net_judge(const char *name, const made_case *made);

/* The same of the cases of seeds first to last, until twenty are wrong. The first that is wrong, or
 * that crashes, is printed; the tool oracle_cases makes it smaller. */
size_t net_judge_seeds(uint64_t first, uint64_t last);
#endif
