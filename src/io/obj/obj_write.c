/* obj_write.c: the file again, its statements walked in the order they were read. */
#include "io/obj/obj.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- The faces of an OBJ whose object, group or material has a name that is asked for. */

enum { KINDS = 3 };
static const char *const KEYWORDS[KINDS] = {"o", "g", "usemtl"};

typedef struct marking {
    const char *end;
    obj_asks_name *asks;
    void *user;
    int marked[KINDS]; /* the name in force is asked for */
} marking;

static int obj_ask(const marking *m, const char *name, size_t length) {
    char *copy = norma_io_copy_text(name, length);
    const int result = copy ? m->asks(m->user, copy) : -1;
    free(copy);
    return result;
}

/* A group statement has several names, the others one that may hold blanks. Returns -1: out of
 * memory. */
static int ask_names(const marking *m, const char *p, int kind) {
    p = norma_obj_skip_blanks(p, m->end);
    const char *end = norma_obj_statement_end(p, m->end, NULL);
    while (end > p && norma_obj_is_blank(end[-1])) --end;
    int asked = obj_ask(m, p, (size_t)(end - p));
    while (kind == 1 && asked == 0 && p < end) {
        const char *word = norma_obj_token_end(p, end);
        asked = obj_ask(m, p, (size_t)(word - p));
        p = word > p ? norma_obj_skip_blanks(word, end) : end;
    }
    return asked;
}

static int obj_kind_of(const char *p, size_t length) {
    for (int kind = 0; kind < KINDS; ++kind)
        if (strlen(KEYWORDS[kind]) == length && memcmp(KEYWORDS[kind], p, length) == 0) return kind;
    return -1;
}

static int face_has_corner(const char *p, const char *end) {
    obj_corner corner;
    return norma_obj_corner(norma_obj_skip_blanks(p, end), end, &corner);
}

int norma_obj_mark_faces(
    const norma_document *document, obj_asks_name *asks, void *user, uint8_t *marks) {
    const obj_state *state = document->state;
    const char *p = (const char *)document->source.data;
    marking m = {.end = p + document->source.size, .asks = asks, .user = user};
    size_t face = 0;
    if (document->source.size >= 3 && memcmp(p, "\xef\xbb\xbf", 3) == 0) p += 3;
    while (p < m.end) {
        const char *rest;
        p = norma_obj_skip_blanks(p, m.end);
        if (p >= m.end) break;
        const obj_kind is = norma_obj_keyword(p, m.end, &rest);
        const int kind = obj_kind_of(p, (size_t)(rest - p));
        if (kind >= 0 && (m.marked[kind] = ask_names(&m, rest, kind)) < 0) return 0;
        if (is == OBJ_FACE && face < state->face_count && face_has_corner(rest, m.end))
            marks[face++] = (uint8_t)(m.marked[0] | m.marked[1] | m.marked[2]);
        p = norma_obj_skip_end(norma_obj_statement_end(rest, m.end, NULL), m.end);
    }
    return 1;
}

/* ---- V lines of an OBJ as a list of copies of old ones: some go, others stay in their
 * order, further ones come before the first face that names one of them, so that no number points
 * forward; and which lines are equal, word for word. */

/* ---- where the v lines are */

typedef struct text_span {
    const char *begin, *end; /* from the first word behind the keyword to the end of the last */
} text_span;

typedef struct text_walk {
    text_span *positions;
    size_t before_face; /* v lines before the face asked for */
    int has_curves;     /* free-form geometry names positions in ways of its own */
} text_walk;

static text_span obj_words_of(const char *p, const char *end) {
    text_span span = {norma_obj_skip_blanks(p, end), NULL};
    span.end = span.begin;
    for (p = span.begin; p < end && !norma_obj_is_end(*p) && *p != '#';
         p = norma_obj_skip_blanks(p, end))
        span.end = p = norma_obj_token_end(p, end);
    return span;
}

/* Whether a token stands at *p, then past blanks. */
static inline int at_token(const char **p, const char *end) {
    *p = norma_obj_skip_blanks(*p, end);
    return *p < end && !norma_obj_is_end(**p) && **p != '#';
}

static int walk_text(
    const obj_state *state, const char *p, size_t size, size_t face, text_walk *walk) {
    const char *end = p + size, *rest;
    size_t positions = 0, faces = 0;
    *walk =
        (text_walk){.positions = norma_io_allocate(state->position_count, sizeof *walk->positions),
            .before_face = state->position_count};
    while (walk->positions && p < end) {
        p = norma_obj_skip_blanks(p, end);
        const char *word = p;
        const obj_kind kind = norma_obj_keyword(p, end, &rest);
        if (kind == OBJ_POSITION && positions < state->position_count)
            walk->positions[positions++] = obj_words_of(rest, end);
        else if (kind == OBJ_FACE && at_token(&rest, end) && faces++ == face)
            walk->before_face = positions;
        walk->has_curves |= kind == OBJ_SURFACE || (kind == OBJ_REFERRING && rest - word > 1);
        p = norma_obj_skip_end(norma_obj_statement_end(rest, end, NULL), end);
    }
    return walk->positions != NULL;
}

/* ---- equal ones */

static const unsigned char *obj_row_of(const void *context, size_t row, size_t *length) {
    const text_span *span = (const text_span *)context + row;
    *length = (size_t)(span->end - span->begin);
    return (const unsigned char *)span->begin;
}

/* Of the text as it would be written, where changes wait: the document's own stays as it is. */
norma_document_result norma_obj_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error) {
    const obj_state *state = document->state;
    growing_bytes written = {0};
    text_walk walk;
    const int changed = norma_obj_edited.has_edit(state);
    const norma_document_result result =
        changed ? norma_obj_write(document, NULL, norma_memory_sink_write, &written, error)
                : NORMA_DOCUMENT_OK;
    (void)mesh;
    if (result) {
        free(written.data);
        return result == NORMA_DOCUMENT_ERROR_FILE ? norma_document_fail_memory(document, error)
                                                   : result;
    }
    int fine =
        walk_text(state, changed ? (const char *)written.data : (const char *)document->source.data,
            changed ? written.size : document->source.size, SIZE_MAX, &walk);
    if (fine && !walk.has_curves)
        fine = norma_equal_rows(obj_row_of, walk.positions, state->position_count, first);
    for (size_t v = 0; fine && walk.has_curves && v < state->position_count; ++v)
        first[v] = (uint32_t)v;
    free(walk.positions);
    free(written.data);
    return fine ? NORMA_DOCUMENT_OK : norma_document_fail_memory(document, error);
}

/* ---- new numbers */

static size_t first_face_of_added(
    const obj_state *state, const norma_mesh_edit *edit, size_t kept) {
    for (size_t face = 0; face < state->face_count; ++face)
        for (size_t c = norma_obj_face_start(state, face);
             c < norma_obj_face_start(state, face + 1); ++c)
            if (edit->new_corners[c] >= kept) return face;
    return SIZE_MAX;
}

/* The number in the file of each vertex of the list. */
static uint32_t file_number(
    const obj_vertices *v, const norma_mesh_edit *edit, size_t kept, size_t place, size_t vertex) {
    if (vertex >= kept) return (uint32_t)(v->kept_before[place] + vertex - kept);
    return (uint32_t)(vertex + (edit->source_vertices[vertex] >= place ? v->added : 0));
}

/* Of each old position; what goes is what its corners become, or NO_VERTEX. */
static void number_vertices(const obj_state *state, const norma_mesh_edit *edit, size_t kept,
    size_t place, obj_vertices *v) {
    memset(v->numbers, 0xff, state->position_count * sizeof *v->numbers);
    for (size_t i = 0; i < kept; ++i) v->kept_before[edit->source_vertices[i] + 1] = 1;
    for (size_t i = 0; i < state->position_count; ++i) v->kept_before[i + 1] += v->kept_before[i];
    for (size_t i = 0; i < kept; ++i)
        v->numbers[edit->source_vertices[i]] = file_number(v, edit, kept, place, i);
    for (size_t c = 0; c < state->corner_count; ++c) {
        v->corners[c] = file_number(v, edit, kept, place, edit->new_corners[c]);
        if (v->numbers[state->corners[c]] == OBJ_NO_VERTEX)
            v->numbers[state->corners[c]] = v->corners[c];
    }
}

static int make_lines(const text_walk *walk, const norma_mesh_edit *edit, size_t kept,
    obj_vertices *v, const char *ending, size_t ending_size) {
    growing_bytes memory = {0};
    norma_sink *sink = norma_sink_create(norma_memory_sink_write, &memory);
    if (!sink) return 0;
    for (size_t i = kept; i < edit->vertex_count; ++i) {
        const text_span *span = &walk->positions[edit->source_vertices[i]];
        norma_sink_put(sink, "v ", 2);
        norma_sink_put(sink, span->begin, (size_t)(span->end - span->begin));
        norma_sink_put(sink, ending, ending_size);
    }
    const int failed = norma_sink_finish(sink);
    v->lines = (unsigned char *)memory.data;
    v->lines_size = memory.size;
    return !failed;
}

/* As the first line ends. */
static const char *first_line_ending(const norma_document *document, size_t *size) {
    const char *p = (const char *)document->source.data, *end = p + document->source.size;
    while (p < end && !norma_obj_is_end(*p)) ++p;
    *size = p < end ? (size_t)(norma_obj_skip_end(p, end) - p) : 1;
    return p < end ? p : "\n";
}

static norma_document_result obj_fill(norma_document *document, const norma_mesh_edit *edit,
    obj_vertices *v, norma_document_error *error) {
    const obj_state *state = document->state;
    const size_t kept = norma_edit_kept(edit);
    size_t ending_size;
    text_walk walk;
    v->added = edit->vertex_count - kept;
    v->face = first_face_of_added(state, edit, kept);
    v->kept_before = norma_io_allocate(state->position_count + 1, sizeof *v->kept_before);
    v->numbers = norma_io_allocate(state->position_count, sizeof *v->numbers);
    v->corners = norma_io_allocate(state->corner_count, sizeof *v->corners);
    int fine = v->kept_before && v->numbers && v->corners &&
               walk_text(state, (const char *)document->source.data, document->source.size, v->face,
                   &walk);
    if (!fine) return norma_document_fail_memory(document, error);
    if (walk.has_curves) {
        free(walk.positions);
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "cannot renumber vertices: free-form curves or surfaces may refer to them");
    }
    number_vertices(state, edit, kept, walk.before_face, v);
    const char *ending = first_line_ending(document, &ending_size);
    fine = make_lines(&walk, edit, kept, v, ending, ending_size);
    free(walk.positions);
    return fine ? NORMA_DOCUMENT_OK : norma_document_fail_memory(document, error);
}

norma_document_result norma_obj_edit_vertices(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    obj_state *state = document->state;
    if (edit->reverse_faces || edit->drop_faces || edit->cut_faces || edit->set_normals ||
        edit->set_positions)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "vertices and other things cannot change at once; change one after the other");
    state->vertices = norma_io_allocate(1, sizeof *state->vertices);
    return state->vertices ? obj_fill(document, edit, state->vertices, error)
                           : norma_document_fail_memory(document, error);
}

/* ---- The file again, its statements walked in the order they were read. What did not
 * change is copied as bytes, in spans as long as they come; stretches of the text and slices of the
 * block of normals are made side by side. */

typedef struct writer {
    const obj_state *state;
    norma_sink *sink;
    const char *text, *end;               /* of the whole file */
    const char *pending;                  /* what lies from here to where we are is to be copied */
    size_t position, normal, face, other; /* the next of each */
    const char **tokens;                  /* of a face that is reversed */
    size_t token_room;
    int out_of_memory;
    norma_watch *watch;
    const void *asked; /* where it was last asked whether to go on */
} writer;

/* It is cancelled, and what would be written matters no more. */
static int obj_stops(writer *w, const char *p) {
    return norma_watch_passed(w->watch, &w->asked, p);
}

static void obj_put(writer *w, const char *begin, const char *end) {
    for (; end - begin > WATCH_BYTES; begin += WATCH_BYTES) {
        if (norma_watch_cancelled(w->watch)) return;
        norma_sink_put(w->sink, begin, WATCH_BYTES);
    }
    norma_sink_put(w->sink, begin, (size_t)(end - begin));
}

/* Copies up to p, and goes on after next. */
static void copy_then_skip(writer *w, const char *p, const char *next) {
    obj_put(w, w->pending, p);
    w->pending = next;
}

/* ---- numbers of v and vn statements */

static size_t format_coordinate(const writer *w, double value, char out[32]) {
    return w->state->floats_suffice ? norma_number_format_float((float)value + 0.0f, out)
                                    : norma_number_format_double(value + 0.0, out);
}

/* The number at or behind *p, which moves to its text; returns that text's end, or NULL. */
static const char *next_number(const writer *w, const char **p, double *number) {
    *p = norma_obj_skip_blanks(*p, w->end);
    const char *next = norma_number_parse(*p, w->end, number);
    return next ? norma_obj_number_end(next, w->end) : NULL;
}

/* The three numbers from p on; each keeps its text where it still says the same. */
static void rewrite_position(writer *w, const char *p) {
    const double *values = w->state->positions + 3 * w->position;
    const char *next;
    double old;
    for (int i = 0; i < 3 && (next = next_number(w, &p, &old)); ++i, p = next) {
        char text[32];
        if (values[i] == old || isnan(values[i])) continue;
        copy_then_skip(w, p, next);
        norma_sink_put(w->sink, text, format_coordinate(w, values[i], text));
    }
}

static void rewrite_normal(writer *w, const char *p, size_t normal) {
    const float *values = w->state->normals + 3 * normal;
    const char *next;
    double old;
    for (int i = 0; i < 3 && (next = next_number(w, &p, &old)); ++i, p = next) {
        char text[32];
        /* Also if the old one is not a number. Normals are floats, which text may say with more
         * digits than they hold. */
        if (!isfinite(values[i]) || (float)old == values[i] ||
            fabs((double)values[i] - old) <= 1e-9)
            continue;
        copy_then_skip(w, p, next);
        norma_sink_put(w->sink, text, norma_number_format_normal(values[i], text));
    }
}

/* ---- the block of normals */

typedef struct line_ending {
    const char *begin, *end;
} line_ending;

/* As the statement at p ends; where that ends the file, as its first line does: a face has lines of
 * positions before or behind it. */
static line_ending ending_like(const writer *w, const char *p) {
    const char *end = norma_obj_statement_end(p, w->end, w->watch);
    if (end == w->end)
        for (end = w->text; end < w->end && !norma_obj_is_end(*end);) ++end;
    return (line_ending){end, norma_obj_skip_end(end, w->end)};
}

static void write_kept_normal(writer *w, size_t normal, line_ending ending) {
    const char *begin = w->text + w->state->normal_offsets[normal];
    const char *rest;
    const char *p = norma_obj_skip_blanks(begin, w->end);
    const char *end = norma_obj_statement_end(p, w->end, w->watch);
    const char *after = norma_obj_skip_end(end, w->end);
    const char *pending = w->pending;
    w->pending = begin;
    norma_obj_keyword(p, w->end, &rest);
    if (w->state->normals_turned) rewrite_normal(w, rest, normal);
    obj_put(w, w->pending, after);
    if (after == end) obj_put(w, ending.begin, ending.end);
    w->pending = pending;
}

static void write_new_normal(writer *w, size_t normal, line_ending ending) {
    enum { LONGEST = 128 };
    char *line = (char *)norma_sink_room(w->sink, LONGEST);
    size_t length = 2;
    memcpy(line, "vn", 2);
    for (int i = 0; i < 3; ++i) {
        line[length++] = ' ';
        length +=
            norma_number_format_normal(w->state->normals[3 * normal + (size_t)i], line + length);
    }
    for (const char *p = ending.begin; p < ending.end; ++p) line[length++] = *p;
    w->sink->used -= LONGEST - length;
}

/* ---- corners */

static void put_number(writer *w, const obj_corner *corner, uint32_t normal) {
    char text[24] = "//";
    size_t length = corner->has_texture ? 1 : 2;
    length += norma_number_format_integer((uint64_t)normal + 1, text + length);
    norma_sink_put(w->sink, text, length);
}

/* Whether a token of the source names its normal as it has to. */
static int obj_says(const writer *w, const obj_corner *corner, uint32_t normal) {
    return !w->state->normals_replaced || normal >= OBJ_BAD_NORMAL ||
           (corner->has_normal && corner->normal == (int64_t)normal + 1);
}

/* Returns the place behind the last corner. */
static const char *rewrite_face(writer *w, const char *p) {
    const uint32_t *normals = w->state->corner_normals + norma_obj_face_start(w->state, w->face);
    obj_corner corner;
    for (; !obj_stops(w, p) && at_token(&p, w->end) && norma_obj_corner(p, w->end, &corner);
         p = corner.end, ++normals)
        if (!obj_says(w, &corner, *normals)) {
            copy_then_skip(w, corner.texture_end, corner.end);
            put_number(w, &corner, *normals);
        }
    return p;
}

/* The places of a face's tokens; how many. 0: out of memory. */
static size_t gather_tokens(writer *w, const char *p) {
    size_t count = 0;
    obj_corner corner;
    for (; !obj_stops(w, p) && at_token(&p, w->end) && norma_obj_corner(p, w->end, &corner);
         p = corner.end) {
        const char **token = norma_io_add(&w->tokens, &w->token_room, &count, sizeof *token);
        w->out_of_memory |= !token;
        if (!token) return 0;
        *token = p;
    }
    return count;
}

static void put_token(writer *w, const char *p) {
    obj_corner corner;
    norma_obj_corner(p, w->end, &corner);
    obj_put(w, corner.begin, corner.end);
}

/* Its triangles, each a statement that begins as the face's does, on a line of its own; what
 * follows the face on its line follows the last. */
static void obj_cut_face(writer *w, const char *begin, const char *p) {
    const uint32_t *triangles = w->state->cut_corners + 3 * norma_obj_face_start(w->state, w->face);
    const size_t count = gather_tokens(w, p);
    obj_corner last;
    if (count < 3) return;
    const char *first = w->tokens[0];
    const line_ending ending = ending_like(w, first);
    norma_obj_corner(w->tokens[count - 1], w->end, &last);
    copy_then_skip(w, first, last.end);
    for (size_t t = 0; t + 2 < count && !obj_stops(w, w->tokens[t]); ++t, triangles += 3) {
        if (t > 0) {
            obj_put(w, ending.begin, ending.end);
            obj_put(w, begin, first);
        }
        for (int k = 0; k < 3; ++k) {
            if (k > 0) norma_sink_put(w->sink, " ", 1);
            put_token(w, w->tokens[triangles[k] < count ? triangles[k] : 0]);
        }
    }
}

/* The first token stays where it is, the others change places; what lies between them does not. */
static void reverse_face(writer *w, const char *p) {
    const size_t begin = norma_obj_face_start(w->state, w->face), count = gather_tokens(w, p);
    obj_corner slot, corner;
    for (size_t i = 0; i < count && !obj_stops(w, w->tokens[i]); ++i) {
        uint32_t normal = norma_obj_normal(w->state, begin + i);
        norma_obj_corner(w->tokens[i], w->end, &slot);
        norma_obj_corner(w->tokens[i ? count - i : 0], w->end, &corner);
        copy_then_skip(w, slot.begin, slot.end);
        if (obj_says(w, &corner, normal)) {
            obj_put(w, corner.begin, corner.end);
        } else {
            obj_put(w, corner.begin, corner.texture_end);
            put_number(w, &corner, normal);
        }
    }
}

/* ---- numbers of vertices that others come or go before */

/* v lines before the statement as it will be written. */
static size_t lines_before(const writer *w, int in_face) {
    const obj_vertices *v = w->state->vertices;
    return v->kept_before[w->position] + (w->face + (in_face ? 1 : 0) > v->face ? v->added : 0);
}

/* What counts back goes on counting back. */
static void put_position(writer *w, const obj_corner *corner, uint32_t number, size_t before) {
    char text[24];
    const int back = corner->position < 0;
    const char *end = corner->begin;
    if (corner->position == (back ? (int64_t)number - (int64_t)before : (int64_t)number + 1))
        return;
    while (end < corner->end && *end != '/') ++end;
    copy_then_skip(w, corner->begin, end);
    if (back) norma_sink_put(w->sink, "-", 1);
    norma_sink_put(w->sink, text,
        norma_number_format_integer(
            back ? (uint64_t)(before - number) : (uint64_t)number + 1, text));
}

static void renumber_face(writer *w, const char *p) {
    const uint32_t *numbers = w->state->vertices->corners + norma_obj_face_start(w->state, w->face);
    const size_t before = lines_before(w, 1);
    obj_corner corner;
    for (; !obj_stops(w, p) && at_token(&p, w->end) && norma_obj_corner(p, w->end, &corner);
         p = corner.end)
        put_position(w, &corner, *numbers++, before);
}

/* Lines and points; what is not there stays as it is. */
static void renumber_referring(writer *w, const char *p) {
    const size_t before = lines_before(w, 0);
    obj_corner corner;
    for (; !obj_stops(w, p) && at_token(&p, w->end); p = norma_obj_token_end(p, w->end)) {
        if (!norma_obj_corner(p, w->end, &corner)) continue;
        const uint32_t old = norma_obj_resolve(corner.position, w->position);
        if (old < w->state->position_count && w->state->vertices->numbers[old] != OBJ_NO_VERTEX)
            put_position(w, &corner, w->state->vertices->numbers[old], before);
    }
}

static int is_dropped(const writer *w, size_t position) {
    const obj_vertices *v = w->state->vertices;
    return v && v->kept_before[position + 1] == v->kept_before[position];
}

static void rewrite_referring(writer *w, const char *p) {
    obj_corner corner;
    for (; !obj_stops(w, p) && at_token(&p, w->end); p = norma_obj_token_end(p, w->end)) {
        if (!norma_obj_corner(p, w->end, &corner) || !corner.has_normal) continue;
        uint32_t normal = w->state->other_normals[w->other++];
        if (!obj_says(w, &corner, normal)) {
            copy_then_skip(w, corner.texture_end, corner.end);
            put_number(w, &corner, normal);
        }
    }
}

/* ---- statements */

static const char *statement_end(const writer *w, const char *p) {
    return norma_obj_skip_end(norma_obj_statement_end(p, w->end, w->watch), w->end);
}

/* Returns the place behind the statement. */
static const char *write_face(writer *w, const char *begin, const char *p) {
    const obj_state *state = w->state;
    const char *first = p;
    if (!at_token(&first, w->end))
        return statement_end(w, first); /* not a face: it has no corners */
    const size_t face = w->face;
    const int drops = state->drop_faces && state->drop_faces[face];
    if (state->vertices && state->vertices->face == face) {
        copy_then_skip(w, begin, begin);
        norma_sink_put(w->sink, (const char *)state->vertices->lines, state->vertices->lines_size);
    }
    if (state->vertices) renumber_face(w, first);
    if (!drops && state->cut_faces && state->cut_faces[face])
        obj_cut_face(w, begin, first);
    else if (!drops &&
             (state->faces_reversed || (state->reverse_faces && state->reverse_faces[face])))
        reverse_face(w, first);
    else if (!drops && state->normals_replaced)
        first = rewrite_face(w, p);
    ++w->face;
    first = statement_end(w, first);
    if (drops) copy_then_skip(w, begin, first);
    return first;
}

/* The same of any statement; p: behind its keyword. */
static const char *write_statement(writer *w, const char *begin, obj_kind kind, const char *p) {
    const obj_state *state = w->state;
    if (kind == OBJ_FACE) return write_face(w, begin, p);
    const char *after = statement_end(w, p);
    switch (kind) {
    case OBJ_POSITION:
        if (state->positions_moved) rewrite_position(w, p);
        if (is_dropped(w, w->position)) copy_then_skip(w, begin, after);
        ++w->position;
        break;
    case OBJ_NORMAL:
        if (state->normals_replaced)
            copy_then_skip(w, begin, after);
        else if (state->normals_turned)
            rewrite_normal(w, p, w->normal);
        ++w->normal;
        break;
    case OBJ_REFERRING:
    case OBJ_SURFACE:
        if (state->vertices) renumber_referring(w, p);
        if (state->normals_replaced) rewrite_referring(w, p);
        break;
    default:
        break;
    }
    return after;
}

/* From begin to end, whole statements. What lies before from is walked over without being written.
 */
static void write_statements(writer *w, const char *begin, const char *from, const char *end) {
    w->asked = begin;
    for (const char *p = begin;
         p < end && !w->sink->failed && !w->out_of_memory && !obj_stops(w, p);) {
        const char *statement = p, *rest;
        if (p == from) {
            w->sink->used = 0;
            w->pending = from;
        }
        p = norma_obj_skip_blanks(p, w->end);
        obj_kind kind = norma_obj_keyword(p, w->end, &rest);
        p = write_statement(w, statement, kind, rest);
    }
    copy_then_skip(w, end, end);
}

/* ---- pieces: stretches of the text, that which the block of normals falls into as two, and slices
 * of the block between them */

enum { SLICE = 1 << 13 }; /* normals */

typedef struct pieces {
    const obj_state *state;
    norma_watch *watch;
    const char *text, *end;
    size_t split, slices; /* the stretch that holds the block's place (none: past the last); slices
                             of the block */
    line_ending ending;   /* of the block's lines */
} pieces;

/* Whether anything in a stretch is to be written otherwise than it stands there. */
static int changes(const obj_state *s, const obj_stretch *a, const obj_stretch *b) {
    if (s->vertices || (s->positions_moved && a->position < b->position)) return 1;
    if ((s->normals_replaced || s->normals_turned) && a->normal < b->normal) return 1;
    if ((s->normals_replaced || s->faces_reversed || s->reverse_faces || s->drop_faces ||
            s->cut_faces) &&
        a->face < b->face)
        return 1;
    return s->normals_replaced && a->other < b->other;
}

/* Of one stretch what lies between two places; from: begin, or the block's place. */
static void make_text(
    const pieces *p, size_t stretch, const char *from, const char *to, norma_data_run *piece) {
    const obj_stretch *at = &p->state->stretches[stretch];
    const char *begin = p->text + at->offset;
    if (!changes(p->state, at, at + 1)) {
        piece->span = from;
        piece->span_size = (size_t)(to - from);
        return;
    }
    writer w = {.state = p->state,
        .sink = &piece->sink,
        .text = p->text,
        .end = p->end,
        .watch = p->watch,
        .pending = from > begin ? begin : from,
        .position = at->position,
        .normal = at->normal,
        .face = at->face,
        .other = at->other};
    write_statements(&w, begin, from > begin ? from : NULL, to);
    piece->sink.failed |= w.out_of_memory;
    free((void *)w.tokens);
}

static void obj_make_normals(const pieces *p, size_t slice, norma_data_run *piece) {
    const size_t begin = slice * SLICE, left = p->state->normal_count - begin,
                 end = begin + (left < SLICE ? left : SLICE);
    writer w = {.state = p->state, .sink = &piece->sink, .text = p->text, .end = p->end};
    for (size_t i = begin; i < end; ++i)
        if (norma_obj_normal_offset(p->state, i) == SIZE_MAX)
            write_new_normal(&w, i, p->ending);
        else
            write_kept_normal(&w, i, p->ending);
}

static void obj_make_run(void *context, size_t index, norma_data_run *piece) {
    const pieces *p = context;
    const obj_stretch *stretches = p->state->stretches;
    const int behind = index > p->split + p->slices;
    if (index > p->split && !behind) {
        obj_make_normals(p, index - p->split - 1, piece);
        return;
    }
    const size_t stretch = behind ? index - p->slices - 1 : index;
    const char *from = p->text + (stretch ? stretches[stretch].offset : 0),
               *to = p->text + stretches[stretch + 1].offset;
    if (stretch != p->split) {
        make_text(p, stretch, from, to, piece);
        return;
    }
    const char *block = p->text + p->state->block;
    make_text(p, stretch, behind ? block : from, behind ? to : block, piece);
}

static void find_split(pieces *p, size_t *count) {
    const obj_state *state = p->state;
    p->split = state->stretch_count;
    *count = state->stretch_count;
    if (!state->normals_replaced || state->block == SIZE_MAX) return;
    p->split = 0;
    while (state->stretches[p->split + 1].offset <= state->block) ++p->split;
    p->slices = (state->normal_count + SLICE - 1) / SLICE;
    const writer w = {.state = state, .text = p->text, .end = p->end};
    p->ending = ending_like(&w, p->text + state->block);
    *count += p->slices + 1;
}

norma_document_result norma_obj_write(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error) {
    const obj_state *state = document->state;
    const char *text = (const char *)document->source.data;
    pieces p = {.state = state,
        .watch = &document->watch,
        .text = text,
        .end = text + document->source.size};
    size_t count;
    (void)path;
    find_split(&p, &count);
    switch (norma_write_ordered(
        (norma_ordered_how){document->threads, p.watch}, count, obj_make_run, &p, write, user)) {
    case NORMA_ORDERED_REFUSED:
        return norma_document_fail(
            document, error, NORMA_DOCUMENT_ERROR_FILE, NULL, "the output could not be written");
    case NORMA_ORDERED_MEMORY:
        return norma_document_fail_memory(document, error);
    default:
        return NORMA_DOCUMENT_OK;
    }
}
