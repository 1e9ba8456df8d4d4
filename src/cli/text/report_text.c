/* report_text.c: what people read: counts with commas, angles without noise, names of weights and
 * kinds. */
#include "cli/text/report_text.h"
#include <math.h>
#include <string.h>

void cli_count(FILE *out, size_t count) {
    char digits[32];
    int length = snprintf(digits, sizeof digits, "%zu", count);
    for (int i = 0; i < length; ++i) {
        if (i > 0 && (length - i) % 3 == 0) fputc(',', out);
        fputc(digits[i], out);
    }
}

void cli_counted(FILE *out, size_t count, const char *one, const char *many) {
    cli_count(out, count);
    fprintf(out, " %s", count == 1 ? one : many);
}

char *cli_decimals(char text[32], double number, int digits) {
    snprintf(text, 32, "%.*f", digits, number);
    if (strchr(text, '.')) {
        size_t length = strlen(text);
        while (text[length - 1] == '0') --length;
        if (text[length - 1] == '.') --length;
        text[length] = '\0';
    }
    return strcmp(text, "-0") == 0 ? strcpy(text, "0") : text;
}

static const double PI = 3.14159265358979323846;

double cli_radians(double degrees) { return degrees * (PI / 180); }

double cli_to_degrees(double radians) { return radians * (180 / PI); }

double cli_given_degrees(double radians) { return round(cli_to_degrees(radians) * 1e9) / 1e9; }

const char *cli_find_weight(const char *word, norma_weight *out) {
    const char *name;
    for (int weight = 0; (name = norma_weight_name((norma_weight)weight)) != NULL; ++weight)
        if (strcmp(word, name) == 0) {
            *out = (norma_weight)weight;
            return NULL;
        }
    return "angle, area, uniform, max, angle-area, visible or angle-lengths";
}

const char *cli_find_only(const char *word, norma_only *out) {
    static const char *const words[] = {"all", "missing", "broken"};
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i)
        if (strcmp(word, words[i]) == 0) {
            *out = (norma_only)i;
            return NULL;
        }
    return "all, missing or broken";
}

const char *cli_kind_name(norma_kind kind) {
    switch (kind) {
    case NORMA_KIND_IDENTITY:
        return "identity";
    case NORMA_KIND_TRANSLATION:
        return "translation";
    case NORMA_KIND_ROTATION:
        return "rotation";
    case NORMA_KIND_UNIFORM_SCALE:
        return "uniform-scale";
    case NORMA_KIND_NON_UNIFORM_SCALE:
        return "non-uniform-scale";
    case NORMA_KIND_SHEAR:
        return "shear";
    case NORMA_KIND_SINGULAR:
        return "singular";
    }
    return "unknown";
}
