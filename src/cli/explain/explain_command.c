/* explain_command.c: norma explain N501: what a rule measures, why it matters, what to do. */
#include "cli/options/options.h"
#include "cli/options/suggest.h"
#include "cli/process/errors.h"
#include "cli/text/report_json.h"
#include <norma/check.h>
#include <stdlib.h>
#include <string.h>

static const char help[] = "norma explain RULE...: explains what a rule of norma check measures, "
                           "why it matters and what to do\n"
                           "\n"
                           "Examples\n"
                           "  norma explain N501\n"
                           "  norma explain inconsistent-winding\n"
                           "  norma explain                  lists all rules, one a line\n"
                           "\n"
                           "RULE is an id (N301), the beginning of several (N3) or a name.\n"
                           "--json prints one object a line, for programs.\n"
                           "Exit status: 0 fine, 2 unknown rule.\n";

static const char *severity_name(norma_severity severity) {
    static const char *const names[] = {"none", "info", "warning", "error"};
    return names[severity];
}

/* The severity for models to render, and where it is another for prints or generated models. */
static void write_severities(const norma_rule *rule) {
    const norma_severity generated = norma_rule_severity(rule, NORMA_CHECK_PROFILE_GENERATED);
    fputs(severity_name(rule->render), stdout);
    if (rule->render == rule->print && generated == rule->print) return;
    printf(" (render), %s (print)", severity_name(rule->print));
    if (generated != rule->print) printf(", %s (generated)", severity_name(generated));
}

static void write_fix(const norma_rule *rule) {
    if (rule->fix == NORMA_FIX_NONE)
        fputs("Fix: by hand only.\n", stdout);
    else
        printf("Fix: %s, by norma check %s --select %s.\n", rule->fix_verb,
            rule->fix == NORMA_FIX_SAFE ? "--fix" : "--fix-unsafe", rule->id);
}

/* At most 100 columns. */
static void write_paragraph(const char *text) {
    size_t column = 0;
    while (*text) {
        size_t length = strcspn(text, " ");
        if (column && column + 1 + length > 100) {
            putchar('\n');
            column = 0;
        }
        column += (size_t)printf("%s%.*s", column ? " " : "", (int)length, text);
        text += length + (text[length] == ' ');
    }
    putchar('\n');
}

static void write_rule(const norma_rule *rule) {
    printf("%s %s: ", rule->id, rule->name);
    write_severities(rule);
    fputs("\n\n", stdout);
    write_paragraph(rule->what);
    putchar('\n');
    write_paragraph(rule->why);
    putchar('\n');
    write_paragraph(rule->how);
    write_fix(rule);
    printf("glTF validator: %s\n", rule->validator);
}

static void write_rule_json(const norma_rule *rule) {
    cli_json json = {.out = stdout};
    cli_json_open(&json, NULL, '{');
    cli_json_string(&json, "id", rule->id);
    cli_json_string(&json, "name", rule->name);
    cli_json_string(&json, "render", severity_name(rule->render));
    cli_json_string(&json, "print", severity_name(rule->print));
    cli_json_string(&json, "generated",
        severity_name(norma_rule_severity(rule, NORMA_CHECK_PROFILE_GENERATED)));
    cli_json_string(&json, "fix",
        rule->fix == NORMA_FIX_SAFE     ? "safe"
        : rule->fix == NORMA_FIX_UNSAFE ? "unsafe"
                                        : NULL);
    cli_json_string(&json, "what", rule->what);
    cli_json_string(&json, "why", rule->why);
    cli_json_string(&json, "how", rule->how);
    cli_json_close(&json, '}');
    putchar('\n');
}

static void list_rule(const norma_rule *rule) {
    printf("%s  %-26s ", rule->id, rule->name);
    write_severities(rule);
    putchar('\n');
}

static int fail_unknown(const cli_subcommand *verb, const char *word) {
    const char *meant = cli_suggest_rule(word);
    return cli_usage(verb,
        "no rule is called '%s'; expected an id (N301), the beginning of several (N3) or a "
        "name%s%s%s",
        word, meant ? "; did you mean " : "", meant ? meant : "", meant ? "?" : "");
}

static int explain(const cli_subcommand *verb, const cli_words *words, int json) {
    size_t count, told = 0;
    const norma_rule *rules = norma_rules(&count);
    uint8_t *mask = calloc(count + 1, 1);
    int status = CLI_OK;
    if (!mask) return cli_out_of_memory();
    for (size_t i = 0; i < words->count && !status; ++i) {
        char unknown[64] = "";
        if (norma_rules_select(words->words[i], mask, unknown) != NORMA_OK)
            status = fail_unknown(verb, unknown);
    }
    for (size_t i = 0; i < count && !status; ++i) {
        if (words->count && !mask[i]) continue;
        if (json)
            write_rule_json(&rules[i]);
        else if (words->count) {
            fputs(told++ ? "\n\n" : "", stdout);
            write_rule(&rules[i]);
        } else
            list_rule(&rules[i]);
    }
    free(mask);
    return status;
}

static int run(const cli_subcommand *verb, int count, char **arguments) {
    cli_common common = {0};
    cli_words words = {.words = calloc((size_t)count + 1, sizeof(char *))};
    const cli_table tables[] = {{cli_common_options, cli_common_option_count, &common}};
    int wants_help = 0, status = words.words ? cli_parse(verb, tables, CLI_COUNT(tables), count,
                                                   arguments, &words, &wants_help)
                                             : cli_out_of_memory();
    if (wants_help)
        fputs(verb->help, stdout);
    else if (!status)
        status = explain(verb, &words, common.json);
    free(words.words);
    return cli_finish(status);
}

const cli_subcommand cli_subcommand_explain = {"explain",
    "explains a rule of norma check: what it means, why it matters, what to do", help, run};
