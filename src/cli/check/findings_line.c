/* findings_line.c: findings for grep and editors, one on each line and nothing else:
 *   path: severity rule place: message
 * The place is a JSON pointer, "/" for a whole file. */
#include "cli/check/check_command.h"
#include "cli/process/errors.h"

static void begin(FILE *out, const check_settings *settings) {
    (void)out;
    (void)settings;
}

static void write_file(FILE *out, const check_report *report) {
    for (size_t i = 0; i < report->count; ++i) {
        const check_item *item = &report->items[i];
        if (!check_is_listed(report, item)) continue;
        const char *where = item->finding->where;
        cli_say(out, "%s: %s %s %s: %s", cli_input_name(report->path),
            check_severity_name(item->severity), item->finding->rule->id, where[0] ? where : "/",
            item->finding->message);
        fputc('\n', out);
    }
}

static void end(FILE *out, const check_totals *totals, const check_settings *settings) {
    (void)out;
    (void)totals;
    (void)settings;
}

const check_format check_format_line = {"line", begin, write_file, "", end};
