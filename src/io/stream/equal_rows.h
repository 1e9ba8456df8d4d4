/* equal_rows.h: of rows of bytes, which equal one before them. */
#ifndef NORMA_IO_EQUAL_ROWS_H
#define NORMA_IO_EQUAL_ROWS_H
#include <stddef.h>
#include <stdint.h>

typedef const unsigned char *norma_row_of(const void *context, size_t row, size_t *length);
/* first: of each row the first that has the same bytes. 0: out of memory. Expected linear time. */
int norma_equal_rows(norma_row_of *row_of, const void *context, size_t count, uint32_t *first);
#endif
