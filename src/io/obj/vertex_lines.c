/* vertex_lines.c: v lines of an OBJ as a list of copies of old ones: some go, others stay in their
 * order, further ones come before the first face that names one of them, so that no number points
 * forward; and which lines are equal, word for word. */
#include "io/obj/vertex_lines.h"
#include "io/format/edit.h"
#include "io/stream/equal_rows.h"
#include "io/obj/statements.h"
#include "io/stream/sink.h"
#include <stdlib.h>
#include <string.h>

/* ---- where the v lines are */

typedef struct text_span {
    const char *begin, *end; /* from the first word behind the keyword to the end of the last */
} text_span;

typedef struct text_walk {
    text_span *positions;
    size_t before_face; /* v lines before the face asked for */
    int has_curves;     /* free-form geometry names positions in ways of its own */
} text_walk;

static text_span words_of(const char *p, const char *end) {
    text_span span = {norma_obj_skip_blanks(p, end), NULL};
    span.end = span.begin;
    for (p = span.begin; p < end && !norma_obj_is_end(*p) && *p != '#';
         p = norma_obj_skip_blanks(p, end))
        span.end = p = norma_obj_token_end(p, end);
    return span;
}

static int has_corner(const char *p, const char *end) {
    p = norma_obj_skip_blanks(p, end);
    return p < end && !norma_obj_is_end(*p) && *p != '#';
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
            walk->positions[positions++] = words_of(rest, end);
        else if (kind == OBJ_FACE && has_corner(rest, end) && faces++ == face)
            walk->before_face = positions;
        walk->has_curves |= kind == OBJ_SURFACE || (kind == OBJ_REFERRING && rest - word > 1);
        p = norma_obj_skip_end(norma_obj_statement_end(rest, end, NULL), end);
    }
    return walk->positions != NULL;
}

/* ---- equal ones */

static const unsigned char *row_of(const void *context, size_t row, size_t *length) {
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
        fine = norma_equal_rows(row_of, walk.positions, state->position_count, first);
    for (size_t v = 0; fine && walk.has_curves && v < state->position_count; ++v)
        first[v] = (uint32_t)v;
    free(walk.positions);
    free(written.data);
    return fine ? NORMA_DOCUMENT_OK : norma_document_fail_memory(document, error);
}

/* ---- new numbers */

/* Old ones that stay, from the first of the list on. */
static size_t count_kept(const norma_mesh_edit *edit) {
    size_t kept = edit->vertex_count > 0;
    while (
        kept < edit->vertex_count && edit->source_vertices[kept] > edit->source_vertices[kept - 1])
        ++kept;
    return kept;
}

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
static const char *line_ending(const norma_document *document, size_t *size) {
    const char *p = (const char *)document->source.data, *end = p + document->source.size;
    while (p < end && !norma_obj_is_end(*p)) ++p;
    *size = p < end ? (size_t)(norma_obj_skip_end(p, end) - p) : 1;
    return p < end ? p : "\n";
}

static norma_document_result fill(norma_document *document, const norma_mesh_edit *edit,
    obj_vertices *v, norma_document_error *error) {
    const obj_state *state = document->state;
    const size_t kept = count_kept(edit);
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
    const char *ending = line_ending(document, &ending_size);
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
    return state->vertices ? fill(document, edit, state->vertices, error)
                           : norma_document_fail_memory(document, error);
}
