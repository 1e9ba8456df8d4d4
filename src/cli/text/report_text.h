/* report_text.h: what people read: counts, angles, names of weights and kinds. */
#ifndef NORMA_CLI_REPORT_TEXT_H
#define NORMA_CLI_REPORT_TEXT_H
#include <norma/document.h>
#include <norma/norma.h>
#include <stddef.h>
#include <stdio.h>

void cli_count(FILE *out, size_t count); /* 1,234 */
void cli_counted(FILE *out, size_t count, const char *one, const char *many);
/* Rounded to so many decimals, without trailing zeros. */
char *cli_decimals(char text[32], double number, int digits);
/* NULL, or what was expected instead. */
const char *cli_find_weight(const char *word, norma_weight *out);
const char *cli_find_only(const char *word, norma_only *out);
const char *cli_kind_name(norma_kind kind);
double cli_radians(double degrees);
double cli_to_degrees(double radians);
double cli_given_degrees(double radians); /* 60 where 60 was given: rounded to 1e-9 */
#endif
