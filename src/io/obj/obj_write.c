/* obj_write.c: the file again, its statements walked in the order they were read. What did not
 * change is copied as bytes, in spans as long as they come; stretches of the text and slices of the
 * block of normals are made side by side. */
#include <math.h>
#include <stdlib.h>
#include "io/text/digits.h"
#include "io/text/number.h"
#include "io/obj/vertex_lines.h"
#include "io/obj/statements.h"
#include "io/stream/ordered.h"

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
static int stops(writer *w, const char *p) { return norma_watch_passed(w->watch, &w->asked, p); }

static void put(writer *w, const char *begin, const char *end) {
    for (; end - begin > WATCH_BYTES; begin += WATCH_BYTES) {
        if (norma_watch_cancelled(w->watch)) return;
        norma_sink_put(w->sink, begin, WATCH_BYTES);
    }
    norma_sink_put(w->sink, begin, (size_t)(end - begin));
}

/* Copies up to p, and goes on after next. */
static void copy_then_skip(writer *w, const char *p, const char *next) {
    put(w, w->pending, p);
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
        /* Also if the old one is not a number. */
        if (!isfinite(values[i]) || fabs((double)values[i] - old) <= 1e-9) continue;
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
    put(w, w->pending, after);
    if (after == end) put(w, ending.begin, ending.end);
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
static int says(const writer *w, const obj_corner *corner, uint32_t normal) {
    return !w->state->normals_replaced || normal >= OBJ_BAD_NORMAL ||
           (corner->has_normal && corner->normal == (int64_t)normal + 1);
}

/* Whether a token stands at *p, then past blanks. */
static inline int at_token(const writer *w, const char **p) {
    *p = norma_obj_skip_blanks(*p, w->end);
    return *p < w->end && !norma_obj_is_end(**p) && **p != '#';
}

/* Plain corners, one blank before each, which get their normals: as far as they come. Returns how
 * many. */
static size_t rewrite_plain_corners(
    writer *w, const char **p, const uint32_t *normals, size_t count) {
    size_t done = 0;
#if NORMA_DIGITS_BY_WORD
    enum { LONGEST = 2 * OBJ_PLAIN_LENGTH }; /* of a corner as it is copied; less of it stays */
    const size_t gap = (size_t)(*p - w->pending), room = (count + 1) * LONGEST;
    if (count > SINK_BLOCK / LONGEST - 1 || gap > LONGEST) return 0;
    char *out = (char *)norma_sink_room(w->sink, room), *const room_end = out + room;
    const char *at = *p;
    memcpy(out, w->pending, gap);
    out += gap;
    for (obj_plain_corner corner;
         done < count && w->end - at > OBJ_PLAIN_LENGTH && *at == ' ' && normals[done] < 99999999 &&
         norma_obj_read_plain_corner(at + 1, &corner);
         ++done, at = corner.end) {
        memcpy(out, at, OBJ_PLAIN_LENGTH);
        if (corner.has_normal && corner.normal == normals[done] + 1) { /* perhaps with zeros */
            out += corner.end - at;
            continue;
        }
        out += corner.texture_end - at;
        memcpy(out, "//", 2);
        out += corner.has_texture ? 1 : 2;
        out += norma_digits_write(normals[done] + 1, out);
    }
    *p = at;
    w->sink->used -= (size_t)(room_end - out);
    w->pending = *p;
#endif
    return done;
}

/* Returns the place behind the last corner. */
static const char *rewrite_face(writer *w, const char *p) {
    const size_t begin = norma_obj_face_start(w->state, w->face),
                 end = norma_obj_face_start(w->state, w->face + 1);
    const uint32_t *normals = w->state->corner_normals + begin;
    normals += rewrite_plain_corners(w, &p, normals, end - begin);
    obj_corner corner;
    for (; !stops(w, p) && at_token(w, &p) && norma_obj_corner(p, w->end, &corner);
         p = corner.end, ++normals)
        if (!says(w, &corner, *normals)) {
            copy_then_skip(w, corner.texture_end, corner.end);
            put_number(w, &corner, *normals);
        }
    return p;
}

/* The places of a face's tokens; how many. 0: out of memory. */
static size_t gather_tokens(writer *w, const char *p) {
    size_t count = 0;
    obj_corner corner;
    for (; !stops(w, p) && at_token(w, &p) && norma_obj_corner(p, w->end, &corner);
         p = corner.end) {
        void *grown = norma_io_grow(w->tokens, &w->token_room, count + 1, sizeof *w->tokens);
        w->out_of_memory |= !grown;
        if (!grown) return 0;
        w->tokens = grown;
        w->tokens[count++] = p;
    }
    return count;
}

static void put_token(writer *w, const char *p) {
    obj_corner corner;
    norma_obj_corner(p, w->end, &corner);
    put(w, corner.begin, corner.end);
}

/* Its triangles, each a statement that begins as the face's does, on a line of its own; what
 * follows the face on its line follows the last. */
static void cut_face(writer *w, const char *begin, const char *p) {
    const uint32_t *triangles = w->state->cut_corners + 3 * norma_obj_face_start(w->state, w->face);
    const size_t count = gather_tokens(w, p);
    obj_corner last;
    if (count < 3) return;
    const char *first = w->tokens[0];
    const line_ending ending = ending_like(w, first);
    norma_obj_corner(w->tokens[count - 1], w->end, &last);
    copy_then_skip(w, first, last.end);
    for (size_t t = 0; t + 2 < count && !stops(w, w->tokens[t]); ++t, triangles += 3) {
        if (t > 0) {
            put(w, ending.begin, ending.end);
            put(w, begin, first);
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
    for (size_t i = 0; i < count && !stops(w, w->tokens[i]); ++i) {
        uint32_t normal = norma_obj_normal(w->state, begin + i);
        norma_obj_corner(w->tokens[i], w->end, &slot);
        norma_obj_corner(w->tokens[i ? count - i : 0], w->end, &corner);
        copy_then_skip(w, slot.begin, slot.end);
        if (says(w, &corner, normal)) {
            put(w, corner.begin, corner.end);
        } else {
            put(w, corner.begin, corner.texture_end);
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
    for (; !stops(w, p) && at_token(w, &p) && norma_obj_corner(p, w->end, &corner); p = corner.end)
        put_position(w, &corner, *numbers++, before);
}

/* Lines and points; what is not there stays as it is. */
static void renumber_referring(writer *w, const char *p) {
    const size_t before = lines_before(w, 0);
    obj_corner corner;
    for (; !stops(w, p) && at_token(w, &p); p = norma_obj_token_end(p, w->end)) {
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
    for (; !stops(w, p) && at_token(w, &p); p = norma_obj_token_end(p, w->end)) {
        if (!norma_obj_corner(p, w->end, &corner) || !corner.has_normal) continue;
        uint32_t normal = w->state->other_normals[w->other++];
        if (!says(w, &corner, normal)) {
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
    if (!at_token(w, &first)) return statement_end(w, first); /* not a face: it has no corners */
    const size_t face = w->face;
    const int drops = state->drop_faces && state->drop_faces[face];
    if (state->vertices && state->vertices->face == face) {
        copy_then_skip(w, begin, begin);
        norma_sink_put(w->sink, (const char *)state->vertices->lines, state->vertices->lines_size);
    }
    if (state->vertices) renumber_face(w, first);
    if (!drops && state->cut_faces && state->cut_faces[face])
        cut_face(w, begin, first);
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
    for (const char *p = begin; p < end && !w->sink->failed && !w->out_of_memory && !stops(w, p);) {
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

static void make_normals(const pieces *p, size_t slice, norma_data_run *piece) {
    const size_t begin = slice * SLICE, left = p->state->normal_count - begin,
                 end = begin + (left < SLICE ? left : SLICE);
    writer w = {.state = p->state, .sink = &piece->sink, .text = p->text, .end = p->end};
    for (size_t i = begin; i < end; ++i)
        if (norma_obj_normal_offset(p->state, i) == SIZE_MAX)
            write_new_normal(&w, i, p->ending);
        else
            write_kept_normal(&w, i, p->ending);
}

static void make_run(void *context, size_t index, norma_data_run *piece) {
    const pieces *p = context;
    const obj_stretch *stretches = p->state->stretches;
    const int behind = index > p->split + p->slices;
    if (index > p->split && !behind) {
        make_normals(p, index - p->split - 1, piece);
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
        (norma_ordered_how){document->threads, p.watch}, count, make_run, &p, write, user)) {
    case NORMA_ORDERED_REFUSED:
        return norma_document_fail(
            document, error, NORMA_DOCUMENT_ERROR_FILE, NULL, "the output could not be written");
    case NORMA_ORDERED_MEMORY:
        return norma_document_fail_memory(document, error);
    default:
        return NORMA_DOCUMENT_OK;
    }
}
