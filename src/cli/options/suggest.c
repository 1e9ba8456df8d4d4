/* suggest.c: what a misspelt word may mean: the name with the least number of letters to put in,
 * take out, change or swap with the next. */
#include "cli/options/suggest.h"
#include <norma/check.h>
#include <stdint.h>
#include <string.h>

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

static size_t edit_distance(const char *a, const char *b) {
    size_t of_a = strlen(a), of_b = strlen(b), rows[3][CLI_LONGEST_WORD + 1];
    if (of_a > CLI_LONGEST_WORD || of_b > CLI_LONGEST_WORD) return SIZE_MAX;
    for (size_t j = 0; j <= of_b; ++j) rows[0][j] = j;
    for (size_t i = 1; i <= of_a; ++i) {
        size_t *row = rows[i % 3], *above = rows[(i + 2) % 3], *two_above = rows[(i + 1) % 3];
        row[0] = i;
        for (size_t j = 1; j <= of_b; ++j) {
            row[j] = least(least(above[j], row[j - 1]) + 1, above[j - 1] + (a[i - 1] != b[j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = least(row[j], two_above[j - 2] + 1);
        }
    }
    return rows[of_a % 3][of_b];
}

const char *cli_suggest(const char *word, const void *names, size_t count, size_t stride) {
    const char *best = NULL;
    size_t nearest = strlen(word) < 4 ? 2 : 3; /* further off, it is no misspelling of anything */
    for (size_t i = 0; i < count; ++i) {
        const char *name;
        memcpy(&name, (const char *)names + i * stride, sizeof name);
        size_t distance = edit_distance(word, name);
        /* A word cut short: --transl. */
        if (strlen(word) >= 3 && strncmp(name, word, strlen(word)) == 0)
            distance = least(distance, 1);
        if (distance < nearest) {
            nearest = distance;
            best = name;
        }
    }
    return best;
}

const char *cli_suggest_rule(const char *word) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    const char *name = cli_suggest(word, &rules->name, count, sizeof *rules);
    return name ? name : cli_suggest(word, &rules->id, count, sizeof *rules);
}

/* The words of a list such as "error, warning, info or never" are what is compared. What does not
 * read as such a list names nothing. */
static int next_word(const char **text, char word[CLI_LONGEST_WORD + 1]) {
    const size_t length = strcspn(*text, ", "), quoted = **text == '"';
    if (length == 0 || length - 2 * quoted > CLI_LONGEST_WORD) return 0;
    memcpy(word, *text + quoted, length - 2 * quoted);
    word[length - 2 * quoted] = '\0';
    *text += length;
    const char *const between[] = {", ", " or "};
    for (size_t i = 0; i < sizeof between / sizeof *between; ++i)
        if (strncmp(*text, between[i], strlen(between[i])) == 0) {
            *text += strlen(between[i]);
            return 1;
        }
    return **text == '\0';
}

int cli_suggest_listed(const char *given, const char *expected, char meant[CLI_LONGEST_WORD + 1]) {
    char word[CLI_LONGEST_WORD + 1];
    size_t nearest = SIZE_MAX;
    while (*expected) {
        if (!next_word(&expected, word)) return 0;
        const char *name = word;
        const size_t distance = edit_distance(given, word);
        if (cli_suggest(given, &name, 1, sizeof name) && distance < nearest) {
            nearest = distance;
            strcpy(meant, word);
        }
    }
    return nearest != SIZE_MAX;
}
