/* explain_command.c: norma explain N501: what a rule measures, why it matters, what to do; as text,
 * or as a page with pictures. */
#include "cli/files/files.h"
#include <stdlib.h>
#include <string.h>

static const char explain_help[] =
    "norma explain RULE...: explains a rule of norma check: what it measures, why, and what to do\n"
    "\n"
    "Examples\n"
    "  norma explain N501\n"
    "  norma explain inconsistent-winding\n"
    "  norma explain                  lists all rules, one per line\n"
    "  norma explain -o rules.html    a page about all rules, with pictures\n"
    "\n"
    "RULE is an id (N301), the beginning of several ids (N3) or a name.\n"
    "  --json                prints one object per line\n"
    "  -o, --output FILE     writes an HTML page with a wrong and a right picture for each rule\n"
    "\n"
    "To start with a folder of models\n"
    "  norma check models --write-baseline norma-baseline.json\n"
    "                                 records what is there, so that only new findings are shown\n"
    "  norma check models --baseline norma-baseline.json --fail-on warning\n"
    "                                 the gate. --profile render suits models to look at, print\n"
    "                                 those to print, generated those that a program made\n"
    "  docs/checking.md has the hook for pre-commit, and the action for GitHub\n"
    "\n"
    "Exit status: 0 fine, 2 unknown rule.\n";

enum { MOST_RULES = 128 }; /* room for a byte of each */

/* The severity for models to render, and where it is another for prints or generated models. */
static void write_severities(const norma_rule *rule) {
    const norma_severity generated = norma_rule_severity(rule, NORMA_CHECK_PROFILE_GENERATED);
    fputs(cli_severity_name(rule->render), stdout);
    if (rule->render == rule->print && generated == rule->print) return;
    printf(" (render), %s (print)", cli_severity_name(rule->print));
    if (generated != rule->print) printf(", %s (generated)", cli_severity_name(generated));
}

static void write_fix(const norma_rule *rule) {
    if (rule->fix == NORMA_FIX_NONE)
        fputs("Fix: by hand only.\n", stdout);
    else
        printf("Fix (%s): " NORMA_PROGRAM " check FILE %s --select %s -o FIXED\n", rule->fix_verb,
            rule->fix == NORMA_FIX_SAFE ? "--fix" : "--fix-unsafe", rule->id);
}

/* At most 100 columns. */
static void print_paragraph(const char *text) {
    cli_write_wrapped(stdout, text, 100, 0);
    putchar('\n');
}

static void print_rule(const norma_rule *rule) {
    char cause[1000];
    snprintf(cause, sizeof cause, "Usual cause: %s", rule->cause);
    printf("%s %s: ", rule->id, rule->name);
    write_severities(rule);
    const char *const paragraphs[] = {"", "", rule->what, "", cause, "", rule->why, "", rule->how};
    for (size_t i = 0; i < CLI_COUNT(paragraphs); ++i) print_paragraph(paragraphs[i]);
    write_fix(rule);
    printf("Found by the glTF validator: %s\n", rule->validator);
}

static void write_rule_json(const norma_rule *rule) {
    cli_json json = {.out = stdout};
    cli_json_print(&json,
        "{id: %s, name: %s, render: %s, print: %s, generated: %s, fix: %s, what: %s, cause: %s, "
        "why: %s, how: %s}\n",
        rule->id, rule->name, cli_severity_name(rule->render), cli_severity_name(rule->print),
        cli_severity_name(norma_rule_severity(rule, NORMA_CHECK_PROFILE_GENERATED)),
        cli_fix_name(rule->fix), rule->what, rule->cause, rule->why, rule->how);
}

static void list_rule(const norma_rule *rule) {
    printf("%s  %-26s ", rule->id, rule->name);
    write_severities(rule);
    putchar('\n');
}

static int fail_unknown(const cli_subcommand *command, const char *word) {
    const char *meant = cli_suggest_rule(word);
    return cli_usage(command,
        "no rule is called '%s'; expected an id (N301), the beginning of several (N3) or a "
        "name%s%s%s",
        word, meant ? "; did you mean " : "", meant ? meant : "", meant ? "?" : "");
}

/* The rules that words name; without any all. A status. */
static int choose_named_rules(
    const cli_subcommand *command, const cli_words *words, uint8_t mask[MOST_RULES]) {
    int status = CLI_OK;
    memset(mask, words->count == 0, MOST_RULES);
    for (size_t i = 0; i < words->count && !status; ++i) {
        char unknown[64] = "";
        if (norma_rules_select(words->words[i], mask, unknown))
            status = fail_unknown(command, unknown);
    }
    return status;
}

static void print_rules(const uint8_t *mask, int is_list, int json) {
    size_t count, told = 0;
    const norma_rule *rules = norma_rules(&count);
    for (size_t i = 0; i < count; ++i) {
        if (!mask[i]) continue;
        if (json)
            write_rule_json(&rules[i]);
        else if (is_list)
            list_rule(&rules[i]);
        else {
            fputs(told++ ? "\n\n" : "", stdout);
            print_rule(&rules[i]);
        }
    }
}

static int write_rules_page(const uint8_t *mask, const char *path) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    cli_output output;
    const int status = cli_output_begin(&output, path, NULL);
    if (status) return status;
    fputs(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
        "content=\"width=device-width,initial-scale=1\">\n<title>Rules of norma check</title>\n"
        "<style>\n:root{color-scheme:light dark;--ground:#fff;--ink:#1b1c1e}@media(prefers-color-"
        "scheme:dark){:root{--ground:#15171a;--ink:#e4e6e8}}\n"
        "body{font:16px/1.5 system-ui,sans-serif;max-width:48rem;margin:0 auto;padding:1rem;"
        "background:var(--ground);color:var(--ink)}h2{font-size:1rem;margin:0}\n",
        output.out);
    cli_write_rule_style(output.out);
    fputs("</style></head><body><main>\n<h1>Rules of norma check</h1>\n", output.out);
    cli_write_rule_marks(output.out);
    for (size_t i = 0; i < count; ++i)
        if (mask[i]) cli_write_rule_html(output.out, &rules[i], 2);
    fputs("</main></body></html>\n", output.out);
    return cli_output_end(&output);
}

typedef struct explain_work {
    cli_common common;
    cli_files files; /* its words */
    const char *output;
} explain_work;

static const cli_option explain_options[] = {{"output", 'o', CLI_TO(CLI_TEXT, explain_work, output),
    .expected = "the name of a file, or -"}};

static int explain(
    const cli_subcommand *command, const cli_words *words, const char *output, int json) {
    uint8_t mask[MOST_RULES];
    const int status = choose_named_rules(command, words, mask);
    if (status) return status;
    if (output)
        return json ? cli_usage(command, "--json and -o exclude each other")
                    : write_rules_page(mask, output);
    print_rules(mask, words->count == 0, json);
    return CLI_OK;
}

static int explain_run(const cli_subcommand *command, int count, char **arguments) {
    explain_work work = {0};
    const cli_table tables[] = {{explain_options, CLI_COUNT(explain_options), &work},
        {cli_common_options, cli_common_option_count, &work.common}};
    int status = cli_read_files(command, &work.files, tables, CLI_COUNT(tables), count, arguments);
    if (status) return status;
    status = explain(command, &work.files.words, work.output, work.common.json);
    cli_files_end(&work.files);
    return cli_finish(status);
}

const cli_subcommand cli_subcommand_explain = {"explain",
    "explains a rule of norma check: what it measures, why, and what to do", explain_help,
    explain_run};
