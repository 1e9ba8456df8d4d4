/* obj_read.c: one pass over the text, statement by statement, into the arrays of obj_state. They grow with what the text holds, never by a count in it.
 * Faces may name positions that follow them: whether each is there is seen at the end, and so is the line to blame where one is not. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "number.h"
#include "obj.h"
#include "obj_text.h"

typedef struct reader {
    norma_document       *document;
    norma_document_error *error;
    obj_state            *state;
    const char           *text, *start, *end;  /* start: past a byte order mark */
    const char           *statement;           /* where the one that is read now begins, blanks before it included */
    uint32_t              last_position;       /* the greatest that a face names */
    uint32_t              last_normal;
    int64_t               group;               /* in force */
    int                   known;               /* some statement was OBJ's */
    size_t                unknown_count;
    const char           *unknown;             /* the first of them */
    size_t                empty_face_count;    /* of no corner */
    const char           *empty_face;          /* the first of them */
    size_t                odd_number_count;    /* followed by something else */
    const char           *odd_number;          /* the first of them */
    void                 *grown;               /* what RESERVE got */
} reader;

static norma_document_result fail_at(const reader *r, const char *p, const char *expected)
{
    char place[24];
    const char *token_end = norma_obj_token_end(p, r->end);
    int length = token_end - p > 40 ? 40 : (int)(token_end - p);
    place[norma_number_format_integer(norma_obj_line(r->text, p), place)] = 0;
    if (length == 0)
        return norma_document_fail(r->document, r->error, NORMA_DOCUMENT_ERROR_MALFORMED, place, "the statement ends where %s was expected", expected);
    return norma_document_fail(r->document, r->error, NORMA_DOCUMENT_ERROR_MALFORMED, place, "\"%.*s\" where %s was expected", length, p, expected);
}

static norma_document_result fail_count(const reader *r, const char *what)
{
    return norma_document_fail(r->document, r->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL, "more than 4294967293 %s; this version reads no more", what);
}

static norma_document_result fail_memory(const reader *r)
{
    return norma_document_fail_memory(r->document, r->error);
}

/* Nonzero where block has room for needed elements of size bytes, or was given it. */
#define RESERVE(r, block, room, needed, size) \
    (((block) && (needed) <= (room)) || (((r)->grown = norma_io_grow((block), &(room), (needed), (size))) != NULL && ((block) = (r)->grown, 1)))

/* What follows a number in its token is passed over, as other readers do ("3.1+e2" is 3.1), and noted; but not a comma, which were a decimal one. */
static norma_document_result read_numbers(reader *r, const char **p, double numbers[3], const char *expected)
{
    for (int i = 0; i < 3; ++i) {
        *p = norma_obj_skip_blanks(*p, r->end);
        const char *next = norma_number_parse(*p, r->end, &numbers[i]);
        int whole = next && norma_obj_is_delimiter(next, r->end);
        if (!next || (!whole && *next == ','))
            return fail_at(r, *p, expected);
        if (!whole && !r->odd_number_count++)
            r->odd_number = *p;
        *p = norma_obj_number_end(next, r->end);
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_position(reader *r, const char **p)
{
    obj_state *state = r->state;
    if (state->position_count >= OBJ_MOST)
        return fail_count(r, "positions");
    if (!RESERVE(r, state->positions, state->position_room, state->position_count + 1, 3 * sizeof(double)))
        return fail_memory(r);
    norma_document_result result = read_numbers(r, p, state->positions + 3 * state->position_count, "one of a position's three numbers");
    state->position_count += result == NORMA_DOCUMENT_OK;
    return result;
}

static float to_float(double value)
{
    return fabs(value) > 3.4028235677973366e38 ? copysignf(INFINITY, (float)copysign(1, value)) : (float)value;
}

static void see_block(reader *r)
{
    if (r->state->block == SIZE_MAX)
        r->state->block = (size_t)(r->statement - r->text);
}

static norma_document_result read_normal(reader *r, const char **p)
{
    obj_state *state = r->state;
    size_t count = state->normal_count;
    double numbers[3];
    if (count >= OBJ_MOST)
        return fail_count(r, "normals");
    if (!RESERVE(r, state->normals, state->normal_room, count + 1, 3 * sizeof(float)) ||
        !RESERVE(r, state->normal_offsets, state->normal_offset_room, count + 1, sizeof(size_t)))
        return fail_memory(r);
    norma_document_result result = read_numbers(r, p, numbers, "one of a normal's three numbers");
    if (result)
        return result;
    see_block(r);
    for (int i = 0; i < 3; ++i)
        state->normals[3 * count + (size_t)i] = to_float(numbers[i]);
    state->normal_offsets[count] = (size_t)(r->statement - r->text);
    state->normal_count = count + 1;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result add_corner(reader *r, const obj_corner *corner)
{
    obj_state *state = r->state;
    size_t count = state->corner_count;
    if (count >= OBJ_MOST)
        return fail_count(r, "corners");
    if (!RESERVE(r, state->corners, state->corner_room, count + 1, sizeof(uint32_t)) ||
        !RESERVE(r, state->corner_normals, state->corner_normal_room, count + 1, sizeof(uint32_t)))
        return fail_memory(r);
    uint32_t position = norma_obj_resolve(corner->position, state->position_count);
    if (position == UINT32_MAX)
        return fail_at(r, corner->begin, corner->position ? "a position that stands before this face" : "a position, numbered from 1,");
    uint32_t normal = OBJ_NO_NORMAL;
    if (corner->has_normal) {
        normal = norma_obj_resolve(corner->normal, state->normal_count);
        if (normal == UINT32_MAX)
            normal = OBJ_BAD_NORMAL;
        else if (normal > r->last_normal)
            r->last_normal = normal;
        state->has_normals |= normal != OBJ_BAD_NORMAL;
        state->bad_normal_count += normal == OBJ_BAD_NORMAL;
    }
    if (position > r->last_position)
        r->last_position = position;
    state->corners[count] = position;
    state->corner_normals[count] = normal;
    state->corner_count = count + 1;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result end_face(reader *r)
{
    obj_state *state = r->state;
    size_t count = state->face_count;
    if (!RESERVE(r, state->face_starts, state->face_room, count + 2, sizeof(uint32_t)))
        return fail_memory(r);
    see_block(r);
    state->has_groups |= r->group != 0;
    state->face_starts[0] = 0;
    state->face_starts[count + 1] = (uint32_t)state->corner_count;
    state->face_count = count + 1;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_face(reader *r, const char **p)
{
    size_t corners = 0;
    for (;; ++corners) {
        obj_corner corner;
        *p = norma_obj_skip_blanks(*p, r->end);
        if (*p >= r->end || norma_obj_is_end(**p) || **p == '#')
            break;
        if (!norma_obj_corner(*p, r->end, &corner))
            return fail_at(r, *p, "a corner (v, v/vt, v//vn or v/vt/vn)");
        norma_document_result result = add_corner(r, &corner);
        if (result)
            return result;
        *p = corner.end;
    }
    if (corners >= 3)
        return end_face(r);
    if (corners == 0) {                        /* it says nothing, and is passed through like what is not known */
        if (!r->empty_face_count++)
            r->empty_face = r->statement;
        return NORMA_DOCUMENT_OK;
    }
    char place[24];
    const char *first = norma_obj_skip_blanks(r->statement, r->end);
    place[norma_number_format_integer(norma_obj_line(r->text, first), place)] = 0;
    return norma_document_fail(r->document, r->error, NORMA_DOCUMENT_ERROR_MALFORMED, place, "a face of %zu corners, where at least three were expected", corners);
}

/* Normals that surfaces, curves, lines and points name: a v/vt/vn anywhere in them. */
static norma_document_result read_referring(reader *r, const char **p)
{
    obj_state *state = r->state;
    for (;;) {
        obj_corner corner;
        *p = norma_obj_skip_blanks(*p, r->end);
        if (*p >= r->end || norma_obj_is_end(**p) || **p == '#')
            return NORMA_DOCUMENT_OK;
        if (norma_obj_corner(*p, r->end, &corner) && corner.has_normal) {
            if (!RESERVE(r, state->other_normals, state->other_room, state->other_count + 1, sizeof(uint32_t)))
                return fail_memory(r);
            uint32_t normal = norma_obj_resolve(corner.normal, state->normal_count);
            state->other_normals[state->other_count++] = normal == UINT32_MAX ? OBJ_BAD_NORMAL : normal;
        }
        *p = norma_obj_token_end(*p, r->end);
    }
}

/* Another number for every other text. */
static int64_t group_of_text(const char *p, const char *end)
{
    uint64_t hash = UINT64_C(14695981039346656037);
    for (; p < end; ++p)
        hash = (hash ^ (unsigned char)*p) * UINT64_C(1099511628211);
    return (int64_t)(hash >> 2 | UINT64_C(1) << 62);
}

/* A number, "off", or nothing, which is off. Numbers too large for 64 bits, and words, are groups as well: equal texts are equal. */
static norma_document_result read_smoothing(reader *r, const char **p)
{
    obj_state *state = r->state;
    int64_t group = 0;
    *p = norma_obj_skip_blanks(*p, r->end);
    const char *token_end = norma_obj_token_end(*p, r->end);
    size_t length = (size_t)(token_end - *p);
    int off = length == 0 || **p == '#' || (length == 3 && memcmp(*p, "off", 3) == 0);
    if (!off && norma_number_parse_integer(*p, r->end, &group) != token_end)
        group = group_of_text(*p, token_end);
    if (group != r->group) {
        if (!RESERVE(r, state->runs, state->run_room, state->run_count + 1, sizeof(obj_run)))
            return fail_memory(r);
        if (state->run_count && state->runs[state->run_count - 1].first_face == state->face_count)
            --state->run_count;                            /* no face lies between */
        state->runs[state->run_count++] = (obj_run){ state->face_count, group };
    }
    r->group = group;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_object(reader *r, const char **p)
{
    *p = norma_obj_skip_blanks(*p, r->end);
    const char *name = *p;
    *p = norma_obj_statement_end(*p, r->end);
    if (r->state->name)
        return NORMA_DOCUMENT_OK;
    const char *name_end = *p;
    while (name_end > name && norma_obj_is_blank(name_end[-1]))
        --name_end;
    r->state->name = norma_io_allocate((size_t)(name_end - name) + 1, 1);
    if (!r->state->name)
        return fail_memory(r);
    memcpy(r->state->name, name, (size_t)(name_end - name));
    return NORMA_DOCUMENT_OK;
}

/* A word that is no OBJ statement is passed through, and noted; but what is not even text is no OBJ. */
static norma_document_result see_unknown(reader *r, const char *word, const char *word_end)
{
    for (const char *p = word; p < word_end; ++p)
        if ((unsigned char)*p < 0x20 || *p == 0x7f) {
            char place[24];
            place[norma_number_format_integer(norma_obj_line(r->text, p), place)] = 0;
            return norma_document_fail(r->document, r->error, NORMA_DOCUMENT_ERROR_MALFORMED, place, "a byte of value %d where a statement's text was expected", (unsigned char)*p);
        }
    if (!r->unknown_count++)
        r->unknown = word;
    return NORMA_DOCUMENT_OK;
}

/* Reads what the statement's kind needs; *p then lies somewhere in the statement, at a token or a token's end. */
static norma_document_result read_statement(reader *r, const char **p)
{
    const char *word = *p;
    obj_kind kind = norma_obj_keyword(word, r->end, p);
    r->state->has_surfaces |= kind == OBJ_SURFACE;
    r->known |= kind != OBJ_NOTHING && kind != OBJ_UNKNOWN;
    switch (kind) {
    case OBJ_POSITION: return read_position(r, p);
    case OBJ_NORMAL: return read_normal(r, p);
    case OBJ_FACE: return read_face(r, p);
    case OBJ_REFERRING:
    case OBJ_SURFACE: return read_referring(r, p);
    case OBJ_SMOOTHING: return read_smoothing(r, p);
    case OBJ_OBJECT: return read_object(r, p);
    case OBJ_UNKNOWN: return see_unknown(r, word, *p);
    default: return NORMA_DOCUMENT_OK;
    }
}

static norma_document_result read_statements(reader *r)
{
    const size_t between_reports = (size_t)1 << 22;
    const char *report = r->text + ((size_t)(r->end - r->text) < between_reports ? (size_t)(r->end - r->text) : between_reports);
    for (const char *p = r->start; p < r->end;) {
        if (p >= report) {
            if (r->document->progress && r->document->progress(r->document->progress_user, (double)(p - r->text) / (double)(r->end - r->text)))
                return norma_document_fail(r->document, r->error, NORMA_DOCUMENT_CANCELLED, NULL, "cancelled");
            report = (size_t)(r->end - p) < between_reports ? r->end : p + between_reports;
        }
        r->statement = p;
        p = norma_obj_skip_blanks(p, r->end);
        norma_document_result result = read_statement(r, &p);
        if (result)
            return result;
        p = norma_obj_skip_end(norma_obj_statement_end(p, r->end), r->end);
    }
    return NORMA_DOCUMENT_OK;
}

/* The first face's line that names a position past the last one. */
static norma_document_result fail_position(reader *r)
{
    obj_state *state = r->state;
    size_t corner = 0;
    for (const char *p = r->start; p < r->end; p = norma_obj_skip_end(norma_obj_statement_end(p, r->end), r->end)) {
        p = norma_obj_skip_blanks(p, r->end);
        if (norma_obj_keyword(p, r->end, &p) != OBJ_FACE)
            continue;
        for (obj_corner token;; p = token.end) {
            p = norma_obj_skip_blanks(p, r->end);
            if (!norma_obj_corner(p, r->end, &token))
                break;
            if (state->corners[corner++] < state->position_count)
                continue;
            char place[24];
            place[norma_number_format_integer(norma_obj_line(r->text, p), place)] = 0;
            return norma_document_fail(r->document, r->error, NORMA_DOCUMENT_ERROR_MALFORMED, place, "position %lld of a face, where the file holds %zu positions",
                                       (long long)token.position, state->position_count);
        }
    }
    return NORMA_DOCUMENT_OK;
}

/* Normals are the part that is computed: what names one that is not there is no reason to refuse the file. */
static void mark_bad_normals(obj_state *state)
{
    state->bad_normal_count = 0;
    state->has_normals = 0;
    for (size_t i = 0; i < state->corner_count; ++i) {
        if (state->corner_normals[i] == OBJ_NO_NORMAL)
            continue;
        if (state->corner_normals[i] >= state->normal_count)
            state->corner_normals[i] = OBJ_BAD_NORMAL;
        state->bad_normal_count += state->corner_normals[i] == OBJ_BAD_NORMAL;
        state->has_normals |= state->corner_normals[i] != OBJ_BAD_NORMAL;
    }
}

/* Where a statement's first token stands, for a note: at most 40 bytes of it, and its line. */
static void add_note(const reader *r, size_t count, const char *what, const char *first)
{
    if (!count)
        return;
    const char *token = norma_obj_skip_blanks(first, r->end);
    const char *token_end = norma_obj_token_end(token, r->end);
    int length = token_end - token > 40 ? 40 : (int)(token_end - token);
    norma_document_add_note(r->document, "%zu %s, the first \"%.*s\" in line %zu", count, what, length, token, norma_obj_line(r->text, token));
}

static void add_notes(const reader *r)
{
    add_note(r, r->unknown_count, "statements of kinds that OBJ does not have are kept as they are", r->unknown);
    add_note(r, r->empty_face_count, "faces without a corner are kept as they are", r->empty_face);
    add_note(r, r->odd_number_count, "numbers end in something else, which is passed over", r->odd_number);
}

static norma_document_result check_whole(reader *r)
{
    obj_state *state = r->state;
    if (!r->known && r->unknown)
        return fail_at(r, r->unknown, "an OBJ statement");
    if (state->corner_count && r->last_position >= state->position_count)
        return fail_position(r);
    if (r->last_normal >= state->normal_count)
        mark_bad_normals(state);
    for (size_t i = 0; i < state->other_count; ++i)
        if (state->other_normals[i] >= state->normal_count)
            state->other_normals[i] = OBJ_BAD_NORMAL;
    add_notes(r);
    return NORMA_DOCUMENT_OK;
}

static int is_utf16(const unsigned char *bytes, size_t size)
{
    return size >= 2 && ((bytes[0] == 0xfe && bytes[1] == 0xff) || (bytes[0] == 0xff && bytes[1] == 0xfe) || (!bytes[0] && bytes[1]) || (bytes[0] && !bytes[1]));
}

norma_document_result norma_obj_read(norma_document *document, obj_state *state, norma_document_error *error)
{
    const unsigned char *bytes = document->source.data;
    size_t size = document->source.size;
    reader r = { .document = document, .error = error, .state = state, 
                 .text = (const char *)bytes, .start = (const char *)bytes, .end = (const char *)bytes + size };
    state->block = SIZE_MAX;
    if (!size)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_MALFORMED, NULL, "the file is empty; expected OBJ statements");
    if (is_utf16(bytes, size))
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL, "UTF-16 text; expected ASCII or UTF-8 (convert it first)");
    if (size >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0)
        r.start += 3;
    norma_document_result result = read_statements(&r);
    if (!result)
        result = check_whole(&r);
    return result;
}

void norma_obj_free(obj_state *state)
{
    free(state->positions);
    free(state->corners);
    free(state->corner_normals);
    free(state->face_starts);
    free(state->normals);
    free(state->normal_offsets);
    free(state->other_normals);
    free(state->runs);
    free(state->name);
    free(state->shown_normals);
    free(state->group_masks);
    free(state->hard_edges);
}
