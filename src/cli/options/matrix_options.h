/* matrix_options.h: one matrix from --scale, --rotate, --translate and --matrix. */
#ifndef NORMA_CLI_MATRIX_OPTIONS_H
#define NORMA_CLI_MATRIX_OPTIONS_H
#include "cli/options/options.h"

#define CLI_MATRIX_HELP                                                                            \
    "The matrix: several options combine; the first is applied first\n"                            \
    "  --scale X,Y,Z         one factor for each axis, or one number for all three\n"              \
    "  --rotate X,Y,Z,DEG    about the axis X,Y,Z, counter-clockwise seen from its tip\n"          \
    "  --translate X,Y,Z\n"                                                                        \
    "  --matrix \"16 numbers, row by row\"\n"                                                      \
    "                        for column vectors: the translation is the last column\n"

extern const cli_option cli_matrix_options[];
extern const size_t cli_matrix_option_count;
typedef struct cli_matrix {
    double matrix[16]; /* column-major */
    int given;         /* how many options made it */
    int overflow;
} cli_matrix;
extern const cli_matrix cli_matrix_identity;
#endif
