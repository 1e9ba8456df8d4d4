/* matrix_options.c: one matrix from --scale, --rotate, --translate and --matrix; the first given
 * acts first on the points. */
#include "cli/options/matrix_options.h"
#include "cli/text/report_text.h"
#include <math.h>
#include <string.h>

const cli_matrix cli_matrix_identity = {.matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};

/* matrix = next * matrix, column-major. */
static void compose(cli_matrix *matrix, const double next[16]) {
    double product[16];
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += next[4 * k + row] * matrix->matrix[4 * column + k];
            product[4 * column + row] = sum;
            matrix->overflow |= !isfinite(sum);
        }
    memcpy(matrix->matrix, product, sizeof product);
    ++matrix->given;
}

static const char *compose_checked(cli_matrix *matrix, const double next[16]) {
    compose(matrix, next);
    return matrix->overflow
               ? "numbers for which the combined matrix stays within the range of doubles"
               : NULL;
}

static const char *set_scale(void *settings, const char *value) {
    double s[3], next[16];
    size_t count = cli_numbers(value, s, 3);
    if (count != 3 && count != 1) return "X,Y,Z or one number for all three, such as 2,1,1";
    memcpy(next, cli_matrix_identity.matrix, sizeof next);
    for (int i = 0; i < 3; ++i) next[5 * i] = s[count == 1 ? 0 : i];
    return compose_checked(settings, next);
}

static const char *set_translate(void *settings, const char *value) {
    double next[16];
    memcpy(next, cli_matrix_identity.matrix, sizeof next);
    if (cli_numbers(value, next + 12, 3) != 3) return "X,Y,Z, such as 0,0,10";
    return compose_checked(settings, next);
}

/* Quarter turns are exact, so that a rotation by 90 degrees leaves no 6e-17 behind. */
static void sine_cosine(double degrees, double *sine, double *cosine) {
    static const double exact[4][2] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
    double turned = fmod(degrees, 360), quarters = turned / 90;
    if (quarters == floor(quarters)) {
        const double *pair = exact[((int)quarters + 4) % 4];
        *sine = pair[0];
        *cosine = pair[1];
        return;
    }
    *sine = sin(cli_radians(turned));
    *cosine = cos(cli_radians(turned));
}

/* Rodrigues' formula about the unit axis: R = c I + s [u]x + (1 - c) u u^T. */
static const char *set_rotate(void *settings, const char *value) {
    static const char expected[] =
        "X,Y,Z,DEG: an axis that is not 0,0,0, and degrees, such as 0,1,0,90";
    double given[4], next[16], sine, cosine;
    if (cli_numbers(value, given, 4) != 4) return expected;
    double largest = fmax(fabs(given[0]), fmax(fabs(given[1]), fabs(given[2])));
    if (largest == 0) return expected;
    double x = given[0] / largest, y = given[1] / largest, z = given[2] / largest,
           length = sqrt(x * x + y * y + z * z);
    x /= length;
    y /= length;
    z /= length;
    sine_cosine(given[3], &sine, &cosine);
    const double rest = 1 - cosine;
    memcpy(next, cli_matrix_identity.matrix, sizeof next);
    next[0] = cosine + rest * x * x, next[4] = rest * x * y - sine * z,
    next[8] = rest * x * z + sine * y;
    next[1] = rest * y * x + sine * z, next[5] = cosine + rest * y * y,
    next[9] = rest * y * z - sine * x;
    next[2] = rest * z * x - sine * y, next[6] = rest * z * y + sine * x,
    next[10] = cosine + rest * z * z;
    return compose_checked(settings, next);
}

static const char *set_matrix(void *settings, const char *value) {
    double rows[16], next[16];
    if (cli_numbers(value, rows, 16) != 16)
        return "16 numbers, row by row, such as \"1 0 0 5  0 1 0 0  0 0 1 0  0 0 0 1\"";
    /* A translation in the last row and none in the last column. */
    if ((rows[12] != 0 || rows[13] != 0 || rows[14] != 0) && rows[15] == 1 && rows[3] == 0 &&
        rows[7] == 0 && rows[11] == 0)
        return "16 numbers row by row, the last row 0 0 0 1; column-major? transpose it";
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column) next[4 * column + row] = rows[4 * row + column];
    return compose_checked(settings, next);
}

const cli_option cli_matrix_options[] = {
    {"scale", 0, 1, set_scale},
    {"rotate", 0, 1, set_rotate},
    {"translate", 0, 1, set_translate},
    {"matrix", 0, 1, set_matrix},
};
const size_t cli_matrix_option_count = CLI_COUNT(cli_matrix_options);
