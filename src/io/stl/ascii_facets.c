/* ascii_facets.c: STL as text: "solid NAME", facets, "endsolid NAME", as often as one likes; words
 * in any case, white space of any kind between them. Writing scans the text again and replaces
 * single numbers, so that all else stays as it is. A scan that is stopped jumps
 * to the end of the text. */
#include "io/stl/stl.h"
#include "io/text/number.h"
#include <stdio.h>
#include <stdlib.h>

typedef struct text_scanner {
    norma_document *document;
    norma_document_error *error;
    const char *begin, *at, *end;
    size_t facet;
    stl_visitor *visit;
    void *user;
    int inside;        /* a solid */
    const void *asked; /* where it was last asked whether to go on */
    int stopped;       /* by that, or by the visitor */
} text_scanner;

static int is_blank(char byte) { return byte == ' ' || (byte >= '\t' && byte <= '\r'); }
static int is_no_blank(char byte) { return !is_blank(byte); }
static int is_in_line(char byte) { return byte != '\n' && byte != '\r'; }

static void stop(text_scanner *scanner) {
    scanner->stopped = 1;
    scanner->at = scanner->end;
}

/* Past bytes of a kind, as many as there are. */
static inline void pass(text_scanner *scanner, int (*is)(char byte)) {
    const char *at = scanner->at;
    do {
        const size_t left = (size_t)(scanner->end - at);
        const char *limit = at + (left < WATCH_BYTES ? left : WATCH_BYTES);
        while (at < limit && is(*at)) ++at;
        scanner->at = at;
        if (at < limit) return;
        if (norma_watch_cancelled(norma_document_watch(scanner->document))) stop(scanner);
    } while (scanner->at < scanner->end);
}

/* The same of words, as many as there are. */
static int is_cancelled(text_scanner *scanner) {
    if (norma_watch_passed(norma_document_watch(scanner->document), &scanner->asked, scanner->at))
        stop(scanner);
    return scanner->stopped;
}

/* Empty at the end of the file. */
static stl_word next_word(text_scanner *scanner) {
    pass(scanner, is_blank);
    const char *text = scanner->at;
    pass(scanner, is_no_blank);
    return (stl_word){text, scanner->at};
}

static int is_word(stl_word word, const char *lower) {
    const char *at = word.text;
    for (; at < word.end && *lower; ++at, ++lower) {
        char letter = *at >= 'A' && *at <= 'Z' ? (char)(*at - 'A' + 'a') : *at;
        if (letter != *lower) return 0;
    }
    return at == word.end && !*lower;
}

/* Lines end in LF or CRLF, in old files in CR. */
static size_t line_of(const text_scanner *scanner, const char *place) {
    const char line_end =
        memchr(scanner->begin, '\n', (size_t)(scanner->end - scanner->begin)) ? '\n' : '\r';
    size_t line = 1;
    for (const char *at = scanner->begin; (at = memchr(at, line_end, (size_t)(place - at))) != NULL;
         ++at)
        ++line;
    return line;
}

static norma_document_result fail_word(
    const text_scanner *scanner, stl_word word, const char *expected) {
    char place[32];
    if (scanner->stopped) return NORMA_DOCUMENT_CANCELLED;
    snprintf(place, sizeof place, "%zu", line_of(scanner, word.text));
    if (word.text == word.end)
        return norma_document_fail(scanner->document, scanner->error,
            NORMA_DOCUMENT_ERROR_MALFORMED, place, "the file ends in facet %zu, before %s",
            scanner->facet, expected);
    const int length = word.end - word.text > 60 ? 60 : (int)(word.end - word.text);
    return norma_document_fail(scanner->document, scanner->error, NORMA_DOCUMENT_ERROR_MALFORMED,
        place, "\"%.*s\" stands in facet %zu in place of %s", length, word.text, scanner->facet,
        expected);
}

static norma_document_result expect(text_scanner *scanner, const char *lower) {
    stl_word word = next_word(scanner);
    return is_word(word, lower) ? NORMA_DOCUMENT_OK : fail_word(scanner, word, lower);
}

static norma_document_result scan_triple(text_scanner *scanner, int part) {
    stl_word words[3];
    double values[3];
    for (int axis = 0; axis < 3; ++axis) {
        words[axis] = next_word(scanner);
        if (words[axis].text == words[axis].end ||
            norma_number_parse(words[axis].text, words[axis].end, &values[axis]) != words[axis].end)
            return fail_word(scanner, words[axis], "a number");
    }
    if (scanner->visit && scanner->visit(scanner->user, scanner->facet, part, words, values))
        stop(scanner);
    return scanner->stopped ? NORMA_DOCUMENT_CANCELLED : NORMA_DOCUMENT_OK;
}

static norma_document_result scan_facet(text_scanner *scanner) {
    if (is_cancelled(scanner)) return NORMA_DOCUMENT_CANCELLED;
    norma_document_result result = expect(scanner, "normal");
    result = result ? result : scan_triple(scanner, 0);
    result = result ? result : expect(scanner, "outer");
    result = result ? result : expect(scanner, "loop");
    for (int part = 1; part <= 3 && !result; ++part) {
        result = expect(scanner, "vertex");
        result = result ? result : scan_triple(scanner, part);
    }
    result = result ? result : expect(scanner, "endloop");
    result = result ? result : expect(scanner, "endfacet");
    ++scanner->facet;
    return result;
}

/* What stands after "solid" on its line, as UTF-8: bytes beyond ASCII of some other encoding become
 * question marks. */
static size_t utf8_length(const char *at, const char *end) {
    const unsigned char first = (unsigned char)*at;
    const size_t length = first < 0x80                    ? 1
                          : first >= 0xC2 && first < 0xE0 ? 2
                          : (first & 0xF0) == 0xE0        ? 3
                          : first >= 0xF0 && first < 0xF5 ? 4
                                                          : 0;
    if (length > (size_t)(end - at)) return 0;
    for (size_t i = 1; i < length; ++i)
        if (((unsigned char)at[i] & 0xC0) != 0x80) return 0;
    return length;
}

static norma_document_result take_name(text_scanner *scanner) {
    stl_state *state = scanner->document->state;
    norma_watch *watch = norma_document_watch(scanner->document);
    const char *begin = scanner->at, *end;
    pass(scanner, is_in_line);
    for (end = scanner->at; end > begin && is_blank(end[-1]);) --end;
    while (begin < end && is_blank(*begin)) ++begin;
    if (state->name || scanner->stopped) return NORMA_DOCUMENT_OK;
    char *name = norma_io_allocate((size_t)(end - begin) + 1, 1);
    if (!name) return norma_document_fail_memory(scanner->document, scanner->error);
    state->name = name;
    for (scanner->asked = begin;
         begin < end && !norma_watch_passed(watch, &scanner->asked, begin);) {
        size_t length = utf8_length(begin, end);
        *name++ = length ? *begin++ : '?';
        for (size_t i = 1; i < length; ++i) *name++ = *begin++;
        begin += length == 0;
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result scan_statement(text_scanner *scanner, stl_word word) {
    if (!scanner->inside) {
        scanner->inside = 1;
        return is_word(word, "solid") ? take_name(scanner) : fail_word(scanner, word, "solid");
    }
    if (is_word(word, "facet")) return scan_facet(scanner);
    if (!is_word(word, "endsolid")) return fail_word(scanner, word, "facet or endsolid");
    scanner->inside = 0;
    pass(scanner, is_in_line);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result scan(text_scanner *scanner) {
    for (;;) {
        stl_word word = next_word(scanner);
        if (word.text == word.end) return NORMA_DOCUMENT_OK;
        norma_document_result result = scan_statement(scanner, word);
        if (result) return result;
    }
}

norma_document_result norma_stl_scan(
    norma_document *document, stl_visitor *visit, void *user, norma_document_error *error) {
    const stl_state *state = document->state;
    const char *begin = (const char *)state->bytes;
    text_scanner scanner = {.document = document,
        .error = error,
        .begin = begin,
        .at = begin,
        .asked = begin,
        .end = begin + state->size,
        .visit = visit,
        .user = user};
    const norma_document_result result = scan(&scanner);
    return scanner.stopped ? NORMA_DOCUMENT_OK : result;
}

/* ---- reading */

norma_document_result norma_stl_read_text(norma_document *document, norma_document_error *error) {
    stl_state *state = document->state;
    const char *begin = (const char *)state->bytes;
    text_scanner scanner = {.document = document,
        .error = error,
        .begin = begin,
        .at = begin,
        .asked = begin,
        .end = begin + state->size};
    norma_document_result result = scan(&scanner);
    state->facets = scanner.facet;
    if (!result && scanner.inside && !scanner.stopped)
        norma_document_add_note(
            document, "the last solid has no \"endsolid\"; the file may have been cut off");
    return result;
}

static int has_many_digits(const stl_word *word) {
    int digits = 0, zeros = 0;
    for (const char *at = word->text; at < word->end && *at != 'e' && *at != 'E'; ++at) {
        if (*at < '0' || *at > '9') continue;
        zeros = *at == '0' ? zeros + 1 : 0;
        digits += digits > 0 || *at != '0';
    }
    return digits - zeros > 9;
}

static int take_numbers(
    void *user, size_t facet, int part, const stl_word words[3], const double values[3]) {
    stl_state *state = user;
    double *positions = state->positions;
    for (int axis = 0; axis < 3; ++axis) {
        if (part == 0) {
            state->stored[3 * facet + (size_t)axis] = (float)values[axis];
            continue;
        }
        positions[9 * facet + (size_t)(3 * (part - 1) + axis)] = values[axis];
        state->many_digits |= has_many_digits(&words[axis]);
    }
    return 0;
}

norma_document_result norma_stl_decode_text(norma_document *document, norma_document_error *error) {
    stl_state *state = document->state;
    state->positions =
        state->facets > SIZE_MAX / 72 ? NULL : norma_io_allocate(state->facets, 9 * sizeof(double));
    state->stored = norma_io_allocate(state->facets, 3 * sizeof(float));
    if (!state->positions || !state->stored) return norma_document_fail_memory(document, error);
    return norma_stl_scan(document, take_numbers, state, error);
}

/* ---- writing */

typedef struct text_copier {
    const stl_state *state;
    norma_sink *sink;
    const char *at; /* up to where the old text has been copied */
} text_copier;

static size_t format_number(const text_copier *copier, int part, double value, char text[32]) {
    if (part == 0) return norma_number_format_normal((float)value, text);
    return copier->state->many_digits ? norma_number_format_double(value, text)
                                      : norma_number_format_float((float)value, text);
}

static int replace_numbers(
    void *user, size_t facet, int part, const stl_word words[3], const double values[3]) {
    text_copier *copier = user;
    const stl_state *state = copier->state;
    if (copier->sink->failed) return 1;
    if (part == 0 ? !state->normals : !state->vertices) return 0;
    for (int axis = 0; axis < 3; ++axis) {
        char text[32];
        const double value = part == 0
                                 ? (double)state->normals[3 * facet + (size_t)axis]
                                 : state->vertices[9 * facet + (size_t)(3 * (part - 1) + axis)];
        const int single = part == 0 || !state->many_digits;
        if ((single ? (float)value == (float)values[axis] : value == values[axis]) ||
            (value != value && values[axis] != values[axis]))
            continue;
        norma_sink_put(copier->sink, copier->at, (size_t)(words[axis].text - copier->at));
        norma_sink_put(copier->sink, text, format_number(copier, part, value, text));
        copier->at = words[axis].end;
    }
    return 0;
}

norma_document_result norma_stl_write_text(
    norma_document *document, norma_sink *sink, norma_document_error *error) {
    const stl_state *state = document->state;
    const char *begin = (const char *)state->bytes;
    text_copier copier = {.state = state, .sink = sink, .at = begin};
    norma_document_result result = norma_stl_scan(document, replace_numbers, &copier, error);
    norma_sink_put(sink, copier.at, (size_t)(begin + state->size - copier.at));
    return result;
}
