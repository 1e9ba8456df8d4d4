/* ply_rows.h: a PLY file cut into its rows and properties, read as plainly as can be and without
 * the library, to see what a rewrite changed. */
#ifndef NORMA_TESTS_PLY_ROWS_H
#define NORMA_TESTS_PLY_ROWS_H
#include <stddef.h>

enum { ROWS_PROPERTIES = 32, ROWS_ELEMENTS = 8 };

typedef struct rows_value {
    const unsigned char *at;
    size_t size;
} rows_value; /* bytes, or words with the white space between them */

typedef struct rows_property {
    char name[64], type[16], count_type[16];
} rows_property; /* count_type "": no list */

typedef struct rows_element {
    char name[64];
    size_t count, property_count;
    rows_property properties[ROWS_PROPERTIES];
    rows_value *values; /* count * property_count */
} rows_element;

typedef struct ply_rows {
    int encoding; /* 'a', 'l', 'b' */
    size_t element_count, header_size;
    rows_element elements[ROWS_ELEMENTS];
    rows_value rest; /* after the last row */
} ply_rows;

/* 0 where it is beyond what this plain reader reads. */
int rows_parse(const unsigned char *data, size_t size, ply_rows *rows);
void rows_free(ply_rows *rows);

const rows_element *rows_find(const ply_rows *rows, const char *element);
int rows_property_of(const rows_element *element, const char *name); /* -1: none */
rows_value rows_value_of(const rows_element *element, size_t row, int property);
double rows_number(const ply_rows *rows, const rows_element *element, size_t row, const char *name);
/* Items of a list; out may be NULL, to count. */
size_t rows_list(
    const ply_rows *rows, const rows_element *element, size_t row, int property, long long *out);
#endif
