/* stl_facets.c: facets read, written and edited. Binary STL: 80 bytes of anything, the number of
 * facets, then 50 bytes for each, little-endian: normal, three vertices, two bytes of attributes.
 */
#include "io/stl/stl.h"
#include "io/text/text.h"
#include <stdio.h>

static uint32_t load_32(const unsigned char *at) {
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static int stl_is_little_endian(void) {
    const uint16_t probe = 1;
    unsigned char first;
    memcpy(&first, &probe, 1);
    return first == 1;
}

static void stl_load_floats(const unsigned char *at, float *out, size_t count) {
    if (stl_is_little_endian()) {
        memcpy(out, at, count * sizeof *out);
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits = load_32(at + 4 * i);
        memcpy(out + i, &bits, sizeof bits);
    }
}

static void store_floats(unsigned char *at, const float *values, size_t count) {
    if (stl_is_little_endian()) {
        memcpy(at, values, count * sizeof *values);
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, values + i, sizeof bits);
        for (size_t k = 0; k < 4; ++k) at[4 * i + k] = (unsigned char)(bits >> (8 * k));
    }
}

static int is_in_line(int byte) { return byte != '\n' && byte != '\r'; }

/* The format has no comments, but people and programs write them, up to the end of a line. */
static int begins_comment(const char *at, const char *end) {
    return at < end && (*at == '#' || *at == ';' || *at == '!' || *at == '%' ||
                           (*at == '/' && at + 1 < end && at[1] == '/'));
}

/* Behind comments. Of a file that is read in parts no more than its beginning is there. */
static int begins_with_solid(const stl_state *state) {
    enum { MOST_SKIPPED = 1 << 16 };
    static const char word[] = "solid";
    const size_t size = state->size < MOST_SKIPPED ? state->size : MOST_SKIPPED;
    const char *at = (const char *)state->bytes, *end = at + size;
    for (;;) {
        while (at < end && norma_is_blank(*at)) ++at;
        if (!begins_comment(at, end)) break;
        while (at < end && is_in_line(*at)) ++at;
    }
    for (size_t i = 0; i < 5; ++i, ++at)
        if (at == end || (*at | 0x20) != word[i]) return 0;
    return 1;
}

/* No text holds bytes of zero, and every binary header of fewer than 2^24 facets does. */
static int looks_like_text(const stl_state *state) {
    const size_t looked_at = state->size < 1024 ? state->size : 1024;
    return memchr(state->bytes, 0, looked_at) == NULL;
}

/* The size decides, since many programs begin their binary files with "solid" too. */
int norma_stl_is_binary(const stl_state *state) {
    if (state->size >= STL_HEADER &&
        STL_HEADER + (uint64_t)STL_FACET * load_32(state->bytes + 80) == state->size)
        return 1;
    return !(begins_with_solid(state) && looks_like_text(state));
}

norma_document_result norma_stl_read_binary(norma_document *document, norma_document_error *error) {
    stl_state *state = document->state;
    if (state->size < STL_HEADER)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_MALFORMED, "byte 0",
            "%s; an STL file begins with \"solid\" or with a binary header of 84 bytes",
            state->size == 0 ? "the file is empty" : "not an STL file");
    const uint32_t count = load_32(state->bytes + 80);
    const size_t room = (state->size - STL_HEADER) / STL_FACET;
    /* A count of -1 is what binary writers leave that never came to the end. */
    if (count > room && count != UINT32_MAX && looks_like_text(state))
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_MALFORMED, "1",
            "text that does not begin with \"solid\"; expected an STL file");
    if (count > room)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_MALFORMED, "byte 80",
            "the header declares %lu facets, but the file holds only %zu", (unsigned long)count,
            room);
    state->facets = count;
    const size_t end = STL_HEADER + (size_t)count * STL_FACET, rest = state->size - end;
    state->tail = rest >= STL_FACET || !norma_is_padding(state->bytes + end, rest) ? end : 0;
    if (rest > 0)
        norma_document_add_note(document,
            "%zu bytes after the last of the %lu facets declared are kept as they are", rest,
            (unsigned long)count);
    return NORMA_DOCUMENT_OK;
}

void norma_stl_load(const stl_state *state, size_t facet, float normal[3], float vertices[9]) {
    const unsigned char *at = state->bytes + STL_HEADER + facet * STL_FACET;
    if (normal) stl_load_floats(at, normal, 3);
    if (vertices) stl_load_floats(at + STL_NORMAL, vertices, 9);
}

int norma_stl_replace_normals(
    unsigned char *bytes, size_t first, size_t count, const float *normals) {
    unsigned char *at = bytes + STL_HEADER + first * STL_FACET;
    int changed = 0;
    for (size_t i = 0; i < count; ++i, at += STL_FACET) {
        float stored[3], now[3];
        stl_load_floats(at, stored, 3);
        for (size_t k = 0; k < 3; ++k)
            now[k] = norma_policy_keep_zero(normals[3 * i + k], (double)stored[k]);
        changed |= memcmp(now, stored, sizeof now) != 0;
        store_floats(at, now, 3);
    }
    return changed;
}

norma_document_result norma_stl_decode_binary(
    norma_document *document, norma_document_error *error) {
    stl_state *state = document->state;
    const size_t bytes_a_facet = STL_VERTICES, count = state->facets;
    if (count > SIZE_MAX / STL_FACET) return norma_document_fail_memory(document, error);
    float *positions = norma_io_block(count, bytes_a_facet),
          *normals = norma_io_block(count, STL_NORMAL);
    state->positions = positions;
    state->stored = normals;
    if (!positions || !normals) return norma_document_fail_memory(document, error);
    for (size_t i = 0; i < count; ++i) norma_stl_load(state, i, normals + 3 * i, positions + 9 * i);
    return NORMA_DOCUMENT_OK;
}

static void put_vertices(const stl_state *state, unsigned char *out, size_t facet) {
    float vertices[9];
    for (size_t i = 0; i < 9; ++i) vertices[i] = (float)state->vertices[9 * facet + i];
    store_floats(out, vertices, 9);
}

enum { SLICE = 1 << 12 }; /* facets */

static void make_facets(void *context, size_t slice, norma_data_run *piece) {
    const stl_state *state = context;
    const size_t first = slice * SLICE, left = state->facets - first,
                 end = first + (left < SLICE ? left : SLICE);
    const unsigned char *at = state->bytes + STL_HEADER + first * STL_FACET;
    for (size_t i = first; i < end; ++i, at += STL_FACET) {
        unsigned char *out = norma_sink_room(&piece->sink, STL_FACET);
        memcpy(out, at, STL_FACET);
        if (state->normals) store_floats(out, state->normals + 3 * i, 3);
        if (state->vertices) put_vertices(state, out + STL_NORMAL, i);
    }
}

norma_document_result norma_stl_write_binary(
    norma_document *document, norma_sink *sink, norma_document_error *error) {
    stl_state *state = document->state;
    norma_sink_put(sink, state->bytes, STL_HEADER);
    const norma_document_result result = norma_edited_put_ordered(
        document, sink, (state->facets + SLICE - 1) / SLICE, make_facets, state, error);
    const size_t end = STL_HEADER + state->facets * STL_FACET;
    norma_sink_put(sink, state->bytes + end, state->size - end);
    return result;
}

/* Facets reversed, left out, their normals and corners replaced: the bytes of all others are
 * copied.
 */

static void edit_facet(unsigned char *at, const norma_mesh_edit *edit, size_t facet) {
    unsigned char second[12];
    for (size_t corner = 3 * facet; corner < 3 * facet + 3; ++corner)
        if (norma_edit_says(edit->set_positions, corner)) {
            const double *p = edit->positions + 3 * corner;
            const float moved[3] = {(float)p[0], (float)p[1], (float)p[2]};
            store_floats(at + STL_NORMAL + 12 * (corner - 3 * facet), moved, 3);
        }
    if (norma_edit_says(edit->reverse_faces, facet)) {
        memcpy(second, at + STL_NORMAL + 12, 12);
        memcpy(at + STL_NORMAL + 12, at + STL_NORMAL + 24, 12);
        memcpy(at + STL_NORMAL + 24, second, 12);
    }
    if (norma_edit_says(edit->set_normals, facet)) store_floats(at, edit->normals + 3 * facet, 3);
}

void norma_stl_edit_binary(const stl_state *state, const norma_mesh_edit *edit, norma_sink *sink) {
    unsigned char header[STL_HEADER];
    const unsigned char *at = state->bytes + STL_HEADER;
    size_t kept = 0;
    for (size_t facet = 0; facet < state->facets; ++facet)
        kept += !norma_edit_says(edit->drop_faces, facet);
    memcpy(header, state->bytes, STL_HEADER);
    for (int i = 0; i < 4; ++i) header[80 + i] = (unsigned char)(kept >> 8 * i);
    norma_sink_put(sink, header, STL_HEADER);
    for (size_t facet = 0; facet < state->facets; ++facet, at += STL_FACET) {
        unsigned char copy[STL_FACET];
        if (norma_edit_says(edit->drop_faces, facet)) continue;
        memcpy(copy, at, STL_FACET);
        edit_facet(copy, edit, facet);
        norma_sink_put(sink, copy, STL_FACET);
    }
    norma_sink_put(sink, at, state->size - (size_t)(at - state->bytes));
}

/* ---- STL as text: "solid NAME", facets, "endsolid NAME", as often as one likes; words
 * in any case, white space of any kind between them. Writing scans the text again and replaces
 * single numbers, so that all else stays as it is. A scan that is stopped jumps
 * to the end of the text. */

typedef struct stl_word {
    const char *text, *end;
} stl_word;
/* Is given the three words of each normal (part 0) and vertex (parts 1 to 3). Nonzero stops: the
 * rest of the text is not wanted, and the result is fine. */
typedef int stl_visitor(
    void *user, size_t facet, int part, const stl_word words[3], const double values[3]);

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

static int is_no_blank(int byte) { return !norma_is_blank(byte); }

static void stl_stop(text_scanner *scanner) {
    scanner->stopped = 1;
    scanner->at = scanner->end;
}

/* Past bytes of a kind, as many as there are. */
static inline void pass(text_scanner *scanner, int (*is)(int byte)) {
    const char *at = scanner->at;
    do {
        const size_t left = (size_t)(scanner->end - at);
        const char *limit = at + (left < WATCH_BYTES ? left : WATCH_BYTES);
        while (at < limit && is(*at)) ++at;
        scanner->at = at;
        if (at < limit) return;
        if (norma_watch_cancelled(norma_document_watch(scanner->document))) stl_stop(scanner);
    } while (scanner->at < scanner->end);
}

/* The same of words, as many as there are. */
static int stl_is_cancelled(text_scanner *scanner) {
    if (norma_watch_passed(norma_document_watch(scanner->document), &scanner->asked, scanner->at))
        stl_stop(scanner);
    return scanner->stopped;
}

/* Empty at the end of the file. */
static stl_word stl_next_word(text_scanner *scanner) {
    for (pass(scanner, norma_is_blank); begins_comment(scanner->at, scanner->end);
         pass(scanner, norma_is_blank))
        pass(scanner, is_in_line);
    const char *text = scanner->at;
    pass(scanner, is_no_blank);
    return (stl_word){text, scanner->at};
}

static int stl_is_word(stl_word word, const char *lower) {
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

static norma_document_result stl_fail_word(
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

static norma_document_result stl_expect(text_scanner *scanner, const char *lower) {
    stl_word word = stl_next_word(scanner);
    return stl_is_word(word, lower) ? NORMA_DOCUMENT_OK : stl_fail_word(scanner, word, lower);
}

static norma_document_result scan_triple(text_scanner *scanner, int part) {
    stl_word words[3];
    double values[3];
    for (int axis = 0; axis < 3; ++axis) {
        words[axis] = stl_next_word(scanner);
        if (words[axis].text == words[axis].end ||
            norma_number_parse(words[axis].text, words[axis].end, &values[axis]) != words[axis].end)
            return stl_fail_word(scanner, words[axis], "a number");
    }
    if (scanner->visit && scanner->visit(scanner->user, scanner->facet, part, words, values))
        stl_stop(scanner);
    return scanner->stopped ? NORMA_DOCUMENT_CANCELLED : NORMA_DOCUMENT_OK;
}

static norma_document_result scan_facet(text_scanner *scanner) {
    if (stl_is_cancelled(scanner)) return NORMA_DOCUMENT_CANCELLED;
    norma_document_result result = stl_expect(scanner, "normal");
    result = result ? result : scan_triple(scanner, 0);
    result = result ? result : stl_expect(scanner, "outer");
    result = result ? result : stl_expect(scanner, "loop");
    for (int part = 1; part <= 3 && !result; ++part) {
        result = stl_expect(scanner, "vertex");
        result = result ? result : scan_triple(scanner, part);
    }
    result = result ? result : stl_expect(scanner, "endloop");
    result = result ? result : stl_expect(scanner, "endfacet");
    ++scanner->facet;
    return result;
}

/* What stands after "solid" on its line, as UTF-8: bytes beyond ASCII of some other encoding become
 * question marks. */
static norma_document_result stl_take_name(text_scanner *scanner) {
    stl_state *state = scanner->document->state;
    norma_watch *watch = norma_document_watch(scanner->document);
    const char *begin = scanner->at, *end;
    pass(scanner, is_in_line);
    for (end = scanner->at; end > begin && norma_is_blank(end[-1]);) --end;
    while (begin < end && norma_is_blank(*begin)) ++begin;
    if (state->name || scanner->stopped) return NORMA_DOCUMENT_OK;
    char *name = norma_io_allocate((size_t)(end - begin) + 1, 1);
    if (!name) return norma_document_fail_memory(scanner->document, scanner->error);
    state->name = name;
    for (scanner->asked = begin;
         begin < end && !norma_watch_passed(watch, &scanner->asked, begin);) {
        uint32_t code;
        size_t length = norma_utf8_take(begin, (size_t)(end - begin), &code);
        *name++ = length ? *begin++ : '?';
        for (size_t i = 1; i < length; ++i) *name++ = *begin++;
        begin += length == 0;
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result scan_statement(text_scanner *scanner, stl_word word) {
    if (!scanner->inside) {
        scanner->inside = 1;
        return stl_is_word(word, "solid") ? stl_take_name(scanner)
                                          : stl_fail_word(scanner, word, "solid");
    }
    if (stl_is_word(word, "facet")) return scan_facet(scanner);
    if (!stl_is_word(word, "endsolid")) return stl_fail_word(scanner, word, "facet or endsolid");
    scanner->inside = 0;
    pass(scanner, is_in_line);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result scan(text_scanner *scanner) {
    for (;;) {
        stl_word word = stl_next_word(scanner);
        if (word.text == word.end) return NORMA_DOCUMENT_OK;
        norma_document_result result = scan_statement(scanner, word);
        if (result) return result;
    }
}

static text_scanner scanner_of(norma_document *document, norma_document_error *error) {
    const stl_state *state = document->state;
    const char *begin = (const char *)state->bytes;
    return (text_scanner){.document = document,
        .error = error,
        .begin = begin,
        .at = begin,
        .asked = begin,
        .end = begin + state->size};
}

static norma_document_result stl_scan(
    norma_document *document, stl_visitor *visit, void *user, norma_document_error *error) {
    text_scanner scanner = scanner_of(document, error);
    scanner.visit = visit;
    scanner.user = user;
    const norma_document_result result = scan(&scanner);
    return scanner.stopped ? NORMA_DOCUMENT_OK : result;
}

/* ---- reading */

norma_document_result norma_stl_read_text(norma_document *document, norma_document_error *error) {
    stl_state *state = document->state;
    text_scanner scanner = scanner_of(document, error);
    norma_document_result result = scan(&scanner);
    state->facets = scanner.facet;
    if (!result && scanner.inside && !scanner.stopped)
        norma_document_add_note(
            document, "the last solid has no \"endsolid\"; the file may have been cut off");
    return result;
}

static int stl_take_numbers(
    void *user, size_t facet, int part, const stl_word words[3], const double values[3]) {
    stl_state *state = user;
    double *positions = state->positions;
    for (int axis = 0; axis < 3; ++axis) {
        if (part == 0) {
            state->stored[3 * facet + (size_t)axis] = (float)values[axis];
            continue;
        }
        positions[9 * facet + (size_t)(3 * (part - 1) + axis)] = values[axis];
        state->many_digits |=
            norma_significant_digits(words[axis].text, words[axis].end) > FLT_DECIMAL_DIG;
    }
    return 0;
}

norma_document_result norma_stl_decode_text(norma_document *document, norma_document_error *error) {
    stl_state *state = document->state;
    state->positions =
        state->facets > SIZE_MAX / 72 ? NULL : norma_io_allocate(state->facets, 9 * sizeof(double));
    state->stored = norma_io_allocate(state->facets, 3 * sizeof(float));
    if (!state->positions || !state->stored) return norma_document_fail_memory(document, error);
    return stl_scan(document, stl_take_numbers, state, error);
}

/* ---- writing */

typedef struct text_copier {
    const stl_state *state;
    norma_sink *sink;
    const char *at; /* up to where the old text has been copied */
} text_copier;

/* A number of a normal, or of a vertex, as text that gets one. */
static size_t stl_format(const stl_state *state, int is_normal, double value, char text[32]) {
    if (is_normal) return norma_number_format_normal((float)value, text);
    return state->many_digits ? norma_number_format_double(value, text)
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
        norma_sink_put(copier->sink, text, stl_format(state, part == 0, value, text));
        copier->at = words[axis].end;
    }
    return 0;
}

norma_document_result norma_stl_write_text(
    norma_document *document, norma_sink *sink, norma_document_error *error) {
    const stl_state *state = document->state;
    const char *begin = (const char *)state->bytes;
    text_copier copier = {.state = state, .sink = sink, .at = begin};
    norma_document_result result = stl_scan(document, replace_numbers, &copier, error);
    norma_sink_put(sink, copier.at, (size_t)(begin + state->size - copier.at));
    return result;
}

/* ---- editing: the same as in binary files; what stands between numbers stays */

typedef struct text_editor {
    const stl_state *state;
    const norma_mesh_edit *edit;
    norma_sink *sink;
    const char *begin, *at, *end; /* copied up to at */
    stl_word second[3];           /* the second corner of a facet that is reversed */
} text_editor;

/* From the numbers of a facet's normal back over "facet normal", and over what stands before it on
 * its line if that is blank. */
static const char *facet_begin(const text_editor *editor, const char *normal) {
    const char *p = normal;
    for (int words = 0; words < 2; ++words) {
        while (p > editor->begin && norma_is_blank(p[-1])) --p;
        while (p > editor->begin && !norma_is_blank(p[-1])) --p;
    }
    while (p > editor->at && (p[-1] == ' ' || p[-1] == '\t')) --p;
    return p;
}

/* From the end of its last number over "endloop endfacet" and the line's end. */
static const char *facet_end(const text_editor *editor, const char *last) {
    const char *p = last;
    for (int words = 0; words < 2; ++words) {
        while (p < editor->end && norma_is_blank(*p)) ++p;
        while (p < editor->end && !norma_is_blank(*p)) ++p;
    }
    while (p < editor->end && (*p == ' ' || *p == '\t' || *p == '\r')) ++p;
    return p < editor->end && *p == '\n' ? p + 1 : p;
}

static void stl_copy_to(text_editor *editor, const char *to) {
    if (to > editor->at) norma_sink_put(editor->sink, editor->at, (size_t)(to - editor->at));
    editor->at = to;
}

static void put_numbers(
    text_editor *editor, const stl_word words[3], const double numbers[3], int unit) {
    for (int axis = 0; axis < 3; ++axis) {
        char text[32];
        const size_t length = stl_format(editor->state, unit, numbers[axis], text);
        stl_copy_to(editor, words[axis].text);
        norma_sink_put(editor->sink, text, length);
        editor->at = words[axis].end;
    }
}

static int edit_part(
    void *user, size_t facet, int part, const stl_word words[3], const double values[3]) {
    text_editor *editor = user;
    const norma_mesh_edit *edit = editor->edit;
    (void)values;
    if (norma_edit_says(edit->drop_faces, facet)) {
        if (part == 0)
            stl_copy_to(editor, facet_begin(editor, words[0].text));
        else if (part == 3)
            editor->at = facet_end(editor, words[2].end);
        return 0;
    }
    if (part == 0 && norma_edit_says(edit->set_normals, facet)) {
        const float *n = edit->normals + 3 * facet;
        const double numbers[3] = {(double)n[0], (double)n[1], (double)n[2]};
        put_numbers(editor, words, numbers, 1);
    }
    if (part > 0 && norma_edit_says(edit->set_positions, 3 * facet + (size_t)part - 1))
        put_numbers(editor, words, edit->positions + 3 * (3 * facet + (size_t)part - 1), 0);
    if (!norma_edit_says(edit->reverse_faces, facet)) return 0;
    if (part == 2) memcpy(editor->second, words, sizeof editor->second);
    if (part == 3) { /* the numbers change places, what stands between them does not */
        stl_copy_to(editor, editor->second[0].text);
        norma_sink_put(editor->sink, words[0].text, (size_t)(words[2].end - words[0].text));
        editor->at = editor->second[2].end;
        stl_copy_to(editor, words[0].text);
        norma_sink_put(editor->sink, editor->second[0].text,
            (size_t)(editor->second[2].end - editor->second[0].text));
        editor->at = words[2].end;
    }
    return 0;
}

norma_document_result norma_stl_edit_text(norma_document *document, const norma_mesh_edit *edit,
    norma_sink *sink, norma_document_error *error) {
    const stl_state *state = document->state;
    const char *begin = (const char *)state->bytes;
    text_editor editor = {.state = state,
        .edit = edit,
        .sink = sink,
        .begin = begin,
        .at = begin,
        .end = begin + state->size};
    norma_document_result result = stl_scan(document, edit_part, &editor, error);
    stl_copy_to(&editor, editor.end);
    return result;
}
