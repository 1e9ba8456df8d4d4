/* net.h: everything public of the core, called with a made case in arrays between pages that nobody
 * may touch, and judged by the definitions. */
#ifndef NORMA_TESTS_NET_H
#define NORMA_TESTS_NET_H
#include "oracle/made_case.h"

/* Returns how many answers are wrong; each is printed. */
size_t net_judge(const char *name, const made_case *made);
#endif
