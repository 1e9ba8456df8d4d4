/* counts.h: what is counted over the parts of a file. */
#ifndef NORMA_IO_LARGE_COUNTS_H
#define NORMA_IO_LARGE_COUNTS_H
#include <norma/large.h>

/* An element without a normal: counted by its reason, with the first one's number. */
void norma_large_count_reason(norma_report *report, uint8_t reason, size_t element);
/* first: added to the number of the first one counted. */
void norma_large_add_count(norma_count *sum, const norma_count *count, size_t first);
/* A position, in the bounds. */
void norma_large_include(norma_large_description *description, const double at[3]);
#endif
