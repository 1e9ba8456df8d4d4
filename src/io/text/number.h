/* number.h: numbers as text, read and written exactly and whatever the locale. */
#ifndef NORMA_IO_NUMBER_H
#define NORMA_IO_NUMBER_H
#include <stddef.h>
#include <stdint.h>

/* Blanks between words, the ends of lines among them. */
static inline int norma_is_blank(int byte) { return byte == ' ' || (byte >= '\t' && byte <= '\r'); }

/* Reads the number that begins at text and ends before end: an optional sign, digits with an
 * optional point (".5" and "5." too), an optional exponent; or nan, inf, infinity in any case,
 * or 1.#INF, 1.#IND, 1.#QNAN as old Windows programs write them. *value is the double nearest to
 * the decimal (ties to even), an infinity where it is too large. Returns the first byte after the
 * number, or NULL if no number stands there; *value is then unchanged. Skips no white space. */
const char *norma_number_parse(const char *text, const char *end, double *value);

/* The same for a decimal integer with an optional sign; NULL also where no int64_t holds it. */
const char *norma_number_parse_integer(const char *text, const char *end, int64_t *value);

/* Write the fewest digits that read back as the same number, fixed or with an exponent, with a
 * final 0; return the length without it. A float's text reads back the same directly and by way of
 * double. "nan", "inf", "-inf", "-0". */
size_t norma_number_format_float(float value, char out[32]);
size_t norma_number_format_double(double value, char out[32]);

/* A unit vector's component: at most eight decimals, zeros at the end cut, never "-0". Off by at
 * most 5e-9. Other numbers than those of [-1, 1] as norma_number_format_float. */
size_t norma_number_format_normal(float value, char out[32]);

/* value without sign in decimal; the length. No final 0. */
size_t norma_number_format_integer(uint64_t value, char out[20]);
#endif
