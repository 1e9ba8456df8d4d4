/* rule_table.c: the table of rules as the public sees it, and lists of rules by name. */
#include "check/findings/check_run.h"
#include <string.h>

static const norma_rule rules[] = {
#define RULE(id, name, render, print, fix, verb, validator, what, cause, why, how)                 \
    {#id, name, NORMA_SEVERITY_##render, NORMA_SEVERITY_##print, NORMA_FIX_##fix, verb, what,      \
        cause, why, how, validator},
#include "check/findings/rules.def"
#undef RULE
};

const norma_rule *norma_rules(size_t *count) {
    if (count) *count = sizeof rules / sizeof *rules;
    return rules;
}

/* What a generated model must not have. */
int norma_check_is_required(const norma_rule *rule) {
    static const char *const ids[] = {"N203", "N206", "N302", "N303", "N305", "N306", "N307"};
    for (size_t i = 0; i < sizeof ids / sizeof *ids; ++i)
        if (strcmp(rule->id, ids[i]) == 0) return 1;
    return 0;
}

norma_severity norma_rule_severity(const norma_rule *rule, norma_check_profile profile) {
    if (profile == NORMA_CHECK_PROFILE_PRINT) return rule->print;
    if (profile != NORMA_CHECK_PROFILE_GENERATED) return rule->render;
    const norma_severity graver = rule->render > rule->print ? rule->render : rule->print;
    return norma_check_is_required(rule) ? NORMA_SEVERITY_ERROR : graver;
}

static char lower(char c) { return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c; }

/* How many characters of text the word begins with: its length where it does. */
static int begins_with(const char *text, const char *word, size_t length) {
    for (size_t i = 0; i < length; ++i)
        if (!text[i] || lower(text[i]) != lower(word[i])) return 0;
    return 1;
}

/* A beginning of an id says at least its N, so that no word of another sense is taken for one. */
static int names_rule(const norma_rule *rule, const char *word, size_t length) {
    return (length > 0 && begins_with(rule->id, word, length)) ||
           (begins_with(rule->name, word, length) && !rule->name[length]);
}

static size_t select_word(const char *word, size_t length, uint8_t *mask) {
    size_t named = 0;
    for (size_t i = 0; i < CHECK_RULE_COUNT; ++i) {
        if (!names_rule(&rules[i], word, length)) continue;
        ++named;
        if (mask) mask[i] = 1;
    }
    return named;
}

static norma_result refuse_word(const char *word, size_t length, char unknown[64]) {
    if (unknown) {
        length = length < 63 ? length : 63;
        memcpy(unknown, word, length);
        unknown[length] = 0;
    }
    return NORMA_ERROR_ARGUMENT;
}

static int is_gap(char c) { return c == ' ' || c == '\t' || c == ','; }

/* mask NULL: only looks whether each word names a rule. */
static norma_result select_words(const char *list, uint8_t *mask, char unknown[64]) {
    while (*list) {
        size_t length = 0;
        while (list[length] && !is_gap(list[length])) ++length;
        if (length && !select_word(list, length, mask)) return refuse_word(list, length, unknown);
        list += length + (list[length] != 0);
    }
    return NORMA_OK;
}

norma_result norma_rules_select(const char *list, uint8_t *mask, char unknown[64]) {
    if (!list || !mask) return NORMA_ERROR_ARGUMENT;
    norma_result result = select_words(list, NULL, unknown);
    return result ? result : select_words(list, mask, unknown);
}
