/* report_formats.c: the forms of a report, by their names and by the endings of files. */
#include "cli/check/check_command.h"
#include <string.h>

static const check_format *const formats[] = {&check_format_text, &check_format_line,
    &check_format_json, &check_format_sarif, &check_format_html};

const check_format *check_find_format(const char *name) {
    for (size_t i = 0; i < CLI_COUNT(formats); ++i)
        if (strcmp(name, formats[i]->name) == 0) return formats[i];
    return NULL;
}

const check_format *check_format_of_name(const char *path) {
    const char *ending = strrchr(path, '.');
    if (!ending || strchr(ending, '/')) return NULL;
    if (strcmp(ending, ".htm") == 0) return &check_format_html;
    return strcmp(ending, ".txt") == 0 ? &check_format_text : check_find_format(ending + 1);
}
