/* stl_edit.c: facets of an STL reversed, left out, their normals and corners replaced: the bytes of
 * all others are copied. */
#include "io/format/edit.h"
#include "io/text/number.h"
#include "io/stl/stl.h"
#include <stdlib.h>
#include <string.h>

static size_t count_kept(const stl_state *state, const norma_mesh_edit *edit) {
    size_t kept = 0;
    for (size_t facet = 0; facet < state->facets; ++facet)
        kept += !norma_edit_says(edit->drop_faces, facet);
    return kept;
}

/* ---- binary */

static void store_32(unsigned char *at, uint32_t value) {
    for (int i = 0; i < 4; ++i) at[i] = (unsigned char)(value >> 8 * i);
}

static void store_vector(unsigned char *at, const float vector[3]) {
    for (int axis = 0; axis < 3; ++axis) {
        uint32_t bits;
        memcpy(&bits, vector + axis, sizeof bits);
        store_32(at + 4 * axis, bits);
    }
}

static void edit_facet(unsigned char *at, const norma_mesh_edit *edit, size_t facet) {
    unsigned char second[12];
    for (size_t corner = 3 * facet; corner < 3 * facet + 3; ++corner)
        if (norma_edit_says(edit->set_positions, corner)) {
            const double *p = edit->positions + 3 * corner;
            const float moved[3] = {(float)p[0], (float)p[1], (float)p[2]};
            store_vector(at + STL_NORMAL + 12 * (corner - 3 * facet), moved);
        }
    if (norma_edit_says(edit->reverse_faces, facet)) {
        memcpy(second, at + STL_NORMAL + 12, 12);
        memcpy(at + STL_NORMAL + 12, at + STL_NORMAL + 24, 12);
        memcpy(at + STL_NORMAL + 24, second, 12);
    }
    if (norma_edit_says(edit->set_normals, facet)) store_vector(at, edit->normals + 3 * facet);
}

static void edit_binary(const stl_state *state, const norma_mesh_edit *edit, norma_sink *sink) {
    unsigned char header[STL_HEADER];
    const unsigned char *at = state->bytes + STL_HEADER;
    memcpy(header, state->bytes, STL_HEADER);
    store_32(header + 80, (uint32_t)count_kept(state, edit));
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

/* ---- text */

typedef struct text_editor {
    const stl_state *state;
    const norma_mesh_edit *edit;
    norma_sink *sink;
    const char *begin, *at, *end; /* copied up to at */
    stl_word second[3];           /* the second corner of a facet that is reversed */
} text_editor;

static int is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/* From the numbers of a facet's normal back over "facet normal", and over what stands before it on
 * its line if that is blank. */
static const char *facet_begin(const text_editor *editor, const char *normal) {
    const char *p = normal;
    for (int words = 0; words < 2; ++words) {
        while (p > editor->begin && is_blank(p[-1])) --p;
        while (p > editor->begin && !is_blank(p[-1])) --p;
    }
    while (p > editor->at && (p[-1] == ' ' || p[-1] == '\t')) --p;
    return p;
}

/* From the end of its last number over "endloop endfacet" and the line's end. */
static const char *facet_end(const text_editor *editor, const char *last) {
    const char *p = last;
    for (int words = 0; words < 2; ++words) {
        while (p < editor->end && is_blank(*p)) ++p;
        while (p < editor->end && !is_blank(*p)) ++p;
    }
    while (p < editor->end && (*p == ' ' || *p == '\t' || *p == '\r')) ++p;
    return p < editor->end && *p == '\n' ? p + 1 : p;
}

static void copy_to(text_editor *editor, const char *to) {
    if (to > editor->at) norma_sink_put(editor->sink, editor->at, (size_t)(to - editor->at));
    editor->at = to;
}

static void put_numbers(
    text_editor *editor, const stl_word words[3], const double numbers[3], int unit) {
    for (int axis = 0; axis < 3; ++axis) {
        char text[32];
        size_t length = unit ? norma_number_format_normal((float)numbers[axis], text)
                        : editor->state->many_digits
                            ? norma_number_format_double(numbers[axis], text)
                            : norma_number_format_float((float)numbers[axis], text);
        copy_to(editor, words[axis].text);
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
            copy_to(editor, facet_begin(editor, words[0].text));
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
        copy_to(editor, editor->second[0].text);
        norma_sink_put(editor->sink, words[0].text, (size_t)(words[2].end - words[0].text));
        editor->at = editor->second[2].end;
        copy_to(editor, words[0].text);
        norma_sink_put(editor->sink, editor->second[0].text,
            (size_t)(editor->second[2].end - editor->second[0].text));
        editor->at = words[2].end;
    }
    return 0;
}

static norma_document_result edit_text(norma_document *document, const norma_mesh_edit *edit,
    norma_sink *sink, norma_document_error *error) {
    const stl_state *state = document->state;
    const char *begin = (const char *)state->bytes;
    text_editor editor = {.state = state,
        .edit = edit,
        .sink = sink,
        .begin = begin,
        .at = begin,
        .end = begin + state->size};
    norma_document_result result = norma_stl_scan(document, edit_part, &editor, error);
    copy_to(&editor, editor.end);
    return result;
}

norma_document_result norma_stl_edit(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    growing_bytes memory = {0};
    norma_document_result result = norma_edited_flush(document, error);
    if (result) return result;
    const stl_state *state = document->state;
    norma_sink *sink = norma_sink_create(norma_memory_sink_write, &memory);
    if (!sink) return norma_document_fail_memory(document, error);
    if (edit->reverse_faces && edit->set_positions)
        result = norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "facets cannot be reversed and moved at once; do one after the other");
    else if (state->binary)
        edit_binary(state, edit, sink);
    else
        result = edit_text(document, edit, sink, error);
    int failed = norma_sink_finish(sink);
    if (!result && failed) result = norma_document_fail_memory(document, error);
    if (!result) return norma_edited_replace(document, &memory, error);
    free(memory.data);
    return result;
}
