/* acid_verdicts.c: the verdicts of norma acid --judge as text, as JSON, and as TAP. */
#include "acid/acid_mistakes.h"
#include "cli/acid/acid.h"
#include <stdio.h>
#include <string.h>

static const char *const verdict_names[ACID_VERDICTS] = {
    "pass", "fail", "unclear", "missing", "skipped"};

/* ---- words */

static const char *reason_words(acid_reason reason) {
    switch (reason) {
    case ACID_REASON_NONE:
        break;
    case ACID_REASON_CONTROL:
        return "the control failed, so nothing in this picture can be judged";
    case ACID_REASON_OUTSIDE:
        return "a patch lies outside the picture";
    case ACID_REASON_SMALL:
        return "patches have fewer than 8 pixels in a row; draw a larger picture";
    case ACID_REASON_NOT_DRAWN:
        return "the right reference is not drawn";
    case ACID_REASON_ALIKE:
        return "the references look alike in this picture";
    case ACID_REASON_BETWEEN:
        return "the nearest two references are about as near";
    case ACID_REASON_FAR:
        return "no reference is near";
    case ACID_REASON_HIDDEN:
        return "the subject is not drawn, or has the colour of what lies around it";
    case ACID_REASON_NO_RELIEF:
        return "scale-on-z looks much like no normal map at all, and tangent-sign does not show "
               "whether one is drawn";
    case ACID_REASON_ELSEWHERE:
        return "sign-kept, sign-lost and green-flipped look the same here, and tangent-sign, which "
               "tells them apart, is not judged or does not pass";
    }
    return NULL;
}

/* The reference that a failure looks like; NULL: none. */
static const char *mistake_id(const acid_row *row, const acid_finding *finding) {
    return finding->verdict == ACID_FAIL && finding->nearest > 0
               ? row->references[finding->nearest].id
               : NULL;
}

/* What is known beside the verdict; NULL: nothing. */
static const char *verdict_words(const acid_row *row, const acid_finding *finding) {
    const char *id = mistake_id(row, finding);
    const acid_mistake *mistake = id ? acid_find_mistake(id) : NULL;
    if (mistake) return mistake->words;
    if (finding->verdict == ACID_MISSING) return "the subject is not drawn";
    if (finding->verdict == ACID_SKIPPED) return "an extension that it needs is missing";
    if (finding->verdict == ACID_FAIL && finding->reason == ACID_REASON_ALIKE)
        return "no shading is visible";
    if (finding->verdict == ACID_FAIL && finding->reason == ACID_REASON_FAR)
        return "the subject is not like its reference, although both are drawn the same way";
    return reason_words(finding->reason);
}

static int is_compared(const acid_finding *finding) {
    for (size_t i = 0; i < ACID_MOST_REFERENCES; ++i)
        if (finding->distances[i] > 0) return 1;
    return finding->verdict == ACID_PASS;
}

static void write_nearness(const acid_row *row, const acid_finding *finding) {
    if (finding->verdict != ACID_UNCLEAR || !is_compared(finding)) return;
    fputs(" (distances:", stdout);
    for (size_t i = 0; i < row->reference_count; ++i) {
        fputs(i ? ", " : " ", stdout);
        cli_write_outside(stdout, row->references[i].id);
        printf(" %.3f", finding->distances[i]);
    }
    fputc(')', stdout);
}

/* ---- for people */

static size_t longest_id(const acid_layout *layout) {
    size_t longest = 0;
    for (size_t i = 0; i < layout->row_count; ++i) {
        const size_t length = strlen(layout->rows[i].id);
        longest = length > longest ? length : longest;
    }
    return longest;
}

static void print_verdict(const acid_row *row, const acid_finding *finding, int width) {
    const char *words = verdict_words(row, finding), *id = mistake_id(row, finding);
    const acid_mistake *mistake = id ? acid_find_mistake(id) : NULL;
    printf("  %-8s ", verdict_names[finding->verdict]);
    cli_write_outside(stdout, row->id);
    if (words || id) printf("%*s", width - (int)strlen(row->id) + 2, "");
    if (id) {
        cli_write_outside(stdout, id);
        if (words) fputs(": ", stdout);
    }
    if (words) fputs(words, stdout);
    write_nearness(row, finding);
    if (mistake) printf("\n%*smend: %s", width + 13, "", mistake->mend);
    fputc('\n', stdout);
}

void acid_print_text(
    const acid_work *work, const acid_layout *layout, const acid_judgement *found) {
    cli_write_outside(stdout, work->judge);
    for (int i = 0; i < ACID_VERDICTS; ++i)
        if (i <= ACID_FAIL || found->counts[i])
            printf("%s %zu %s", i ? "," : ":", found->counts[i], verdict_names[i]);
    fputc('\n', stdout);
    for (size_t i = 0; i < layout->row_count; ++i)
        print_verdict(&layout->rows[i], &found->findings[i], (int)longest_id(layout));
}

/* ---- for programs */

static void print_cell_json(cli_json *json, const acid_row *row, const acid_finding *finding) {
    cli_json_open(json, NULL, '{');
    cli_json_string(json, "id", row->id);
    cli_json_string(json, "verdict", verdict_names[finding->verdict]);
    cli_json_string(json, "mistake", mistake_id(row, finding));
    cli_json_open(json, "distances", '{');
    for (size_t i = 0; i < row->reference_count && is_compared(finding); ++i)
        cli_json_number(json, row->references[i].id, finding->distances[i]);
    cli_json_close(json, '}');
    cli_json_string(json, "reason", verdict_words(row, finding));
    cli_json_close(json, '}');
}

void acid_print_json(
    const acid_work *work, const acid_layout *layout, const acid_judgement *found) {
    cli_json json = {.out = stdout};
    cli_json_open(&json, NULL, '{');
    cli_json_string(&json, "schema", "norma-acid/1");
    cli_json_string(&json, "image", work->judge);
    cli_json_open(&json, "cells", '[');
    for (size_t i = 0; i < layout->row_count; ++i)
        print_cell_json(&json, &layout->rows[i], &found->findings[i]);
    cli_json_close(&json, ']');
    cli_json_open(&json, "summary", '{');
    for (int i = 0; i < ACID_VERDICTS; ++i)
        cli_json_size(&json, verdict_names[i], found->counts[i]);
    cli_json_close(&json, '}');
    cli_json_close(&json, '}');
    fputc('\n', stdout);
}

/* Test Anything Protocol, version 12. */
void acid_print_tap(const acid_work *work, const acid_layout *layout, const acid_judgement *found) {
    (void)work;
    printf("1..%zu\n", layout->row_count);
    for (size_t i = 0; i < layout->row_count; ++i) {
        const acid_row *row = &layout->rows[i];
        const acid_finding *finding = &found->findings[i];
        const char *words = verdict_words(row, finding), *id = mistake_id(row, finding);
        const int is_fine = finding->verdict == ACID_PASS || finding->verdict == ACID_SKIPPED;
        printf("%sok %zu - ", is_fine ? "" : "not ", i + 1);
        cli_write_outside(stdout, row->id);
        if (finding->verdict == ACID_SKIPPED) fputs(" # SKIP", stdout);
        if (!is_fine) printf(": %s", verdict_names[finding->verdict]);
        if (id) fputs(", ", stdout);
        if (id) cli_write_outside(stdout, id);
        fputc('\n', stdout);
        if (!is_fine && words) printf("# %s\n", words);
    }
}
