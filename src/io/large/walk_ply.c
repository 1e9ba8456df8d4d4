/* walk_ply.c: parts of a PLY larger than memory. A part is as many faces in a row as fit, with the
 * vertices that they name; of the vertices only those blocks are read that hold some of them. */
#include "io/large/walk_ply.h"
#include <math.h>
#include <stdlib.h>

enum { CHUNKS_IN_BLOCK = LARGE_FACES_IN_BLOCK / LARGE_CHUNK };
/* Of a part's memory for each corner: the arrays here, and what the rules make of them. */
static const size_t BYTES_A_CORNER = 192, MOST_CORNERS = (size_t)3 << 20;

/* ---- opening */

static int open_part(walk_ply *w) {
    large_budget *budget = &w->ply.file->budget;
    const size_t least = (size_t)3 * LARGE_FACES_IN_BLOCK;
    w->offsets = norma_large_take(budget, w->chunk_count + 1, sizeof *w->offsets);
    if (!w->offsets || !norma_large_bits_open(budget, w->ply.vertices, &w->named)) return 0;
    w->named_room = w->ply.vertices;
    const uint64_t room = (budget->most - budget->used) / BYTES_A_CORNER;
    w->corner_room = room < least ? least : room < MOST_CORNERS ? (size_t)room : MOST_CORNERS;
    w->face_room = w->corner_room / 3 / LARGE_FACES_IN_BLOCK * LARGE_FACES_IN_BLOCK;
    w->corners = norma_large_take(budget, w->corner_room, sizeof *w->corners);
    w->vertices = norma_large_take(budget, w->corner_room, sizeof *w->vertices);
    w->positions = norma_large_take(budget, w->corner_room, norma_large_position_size(&w->ply));
    w->starts = norma_large_take(budget, w->face_room + 1, sizeof *w->starts);
    return w->corners && w->vertices && w->positions && w->starts;
}

norma_document_result norma_walk_ply_open(large_file *file, walk_ply *w) {
    norma_document_result result = norma_large_ply_open(file, &w->ply);
    if (result) return result;
    w->chunk_count = (size_t)(w->ply.faces / LARGE_CHUNK) + (w->ply.faces % LARGE_CHUNK != 0);
    if (!open_part(w)) return norma_large_fail_memory(file);
    w->offsets[0] = w->ply.face ? w->ply.face->begin : 0;
    return NORMA_DOCUMENT_OK;
}

void norma_walk_ply_close(walk_ply *w) {
    if (!w->ply.file) return;
    large_budget *budget = &w->ply.file->budget;
    w->named.count = w->named_room;
    norma_large_bits_close(budget, &w->named);
    norma_large_give(budget, w->offsets, w->chunk_count + 1, sizeof *w->offsets);
    norma_large_give(budget, w->corners, w->corner_room, sizeof *w->corners);
    norma_large_give(budget, w->vertices, w->corner_room, sizeof *w->vertices);
    norma_large_give(budget, w->positions, w->corner_room, norma_large_position_size(&w->ply));
    norma_large_give(budget, w->starts, w->face_room + 1, sizeof *w->starts);
    norma_large_ply_close(&w->ply);
}

/* ---- vertices */

static norma_vec3_view view_of(const large_ply *ply, const void *positions, size_t count) {
    return (norma_vec3_view){.data = positions,
        .count = count,
        .format = ply->single ? NORMA_FORMAT_FLOAT : NORMA_FORMAT_DOUBLE};
}

/* As norma_document_mesh_data has them. */
static norma_document_result read_normals(
    large_ply *ply, size_t first, size_t count, float *normals) {
    const ply_header *header = &ply->state->header;
    norma_document_result result;
    double *stored = NULL;
    const unsigned char *rows = norma_large_ply_rows(ply, first, count, &result);
    if (!rows) return result;
    const large_view before = norma_large_ply_look(ply, rows, count);
    result = norma_ply_read_columns(
        ply->file->document, ply->vertex, header->normal, &stored, ply->file->error);
    norma_large_ply_look_away(ply, &before);
    const double scale = norma_ply_normal_scale(header, ply->vertex, header->normal);
    for (size_t i = 0; !result && i < 3 * count; ++i)
        normals[i] = norma_ply_normal_value(stored[i], scale);
    free(stored);
    return result;
}

norma_document_result norma_walk_ply_vertices(
    walk_ply *w, large_visit_vertices *visit, void *context) {
    large_ply *ply = &w->ply;
    const int has_normals = ply->state->header.normal[0] != PLY_NONE;
    float *normals =
        has_normals ? norma_large_take(&ply->file->budget, LARGE_BLOCK, 3 * sizeof *normals) : NULL;
    norma_document_result result =
        has_normals && !normals ? norma_large_fail_memory(ply->file) : NORMA_DOCUMENT_OK;
    for (size_t first = 0; first < ply->vertices && !result; first += LARGE_BLOCK) {
        const size_t left = ply->vertices - first, count = left < LARGE_BLOCK ? left : LARGE_BLOCK;
        large_vertices part = {.first = first, .positions = view_of(ply, ply->scratch, count)};
        result = norma_large_ply_positions(ply, first, count, ply->scratch);
        if (!result && normals) result = read_normals(ply, first, count, normals);
        if (normals)
            part.normals =
                (norma_vec3_view){.data = normals, .count = count, .format = NORMA_FORMAT_FLOAT};
        if (!result) result = visit(context, &part);
        if (!result) result = norma_large_tell(ply->file, (double)first / (double)ply->vertices);
    }
    norma_large_give(&ply->file->budget, normals, LARGE_BLOCK, 3 * sizeof *normals);
    return result;
}

/* ---- faces */

static size_t chunk_faces(const walk_ply *w, size_t chunk) {
    const uint64_t left = w->ply.faces - (uint64_t)chunk * LARGE_CHUNK;
    return left < LARGE_CHUNK ? (size_t)left : LARGE_CHUNK;
}

static norma_document_result read_chunk(walk_ply *w, size_t chunk) {
    uint64_t offset = w->offsets[chunk];
    const norma_document_result result = norma_large_ply_chunk(
        &w->ply, (uint64_t)chunk * LARGE_CHUNK, chunk_faces(w, chunk), &offset);
    if (!result) w->offsets[chunk + 1] = offset;
    return result;
}

static void *grow(walk_ply *w, void *block, size_t count, size_t size) {
    return norma_large_grow(&w->ply.file->budget, block, w->corner_room, count, size);
}

/* A chunk of large polygons may need more than a part was given. */
static int make_room(walk_ply *w, size_t corners) {
    const size_t count = w->corner_count + corners;
    if (count <= w->corner_room) return 1;
    if (count > UINT32_MAX) return 0; /* starts of faces are 32 bits */
    uint32_t *grown_corners = grow(w, w->corners, count, sizeof *w->corners);
    if (grown_corners) w->corners = grown_corners;
    uint32_t *grown_vertices =
        grown_corners ? grow(w, w->vertices, count, sizeof *w->vertices) : NULL;
    if (grown_vertices) w->vertices = grown_vertices;
    void *positions =
        grown_vertices ? grow(w, w->positions, count, norma_large_position_size(&w->ply)) : NULL;
    if (positions) w->positions = positions;
    if (positions) w->corner_room = count;
    return positions != NULL;
}

static int take_chunk(walk_ply *w) {
    const large_faces *faces = &w->ply.chunk;
    if (!make_room(w, faces->corner_count)) return 0;
    memcpy(
        w->corners + w->corner_count, faces->corners, faces->corner_count * sizeof *faces->corners);
    for (size_t i = 0; i < faces->corner_count; ++i) {
        const uint32_t vertex = faces->corners[i];
        w->least = vertex < w->least ? vertex : w->least;
        w->most = vertex > w->most ? vertex : w->most;
    }
    for (size_t i = 1; i <= faces->count; ++i)
        w->starts[w->face_count + i] = (uint32_t)(w->corner_count + faces->starts[i]);
    w->corner_count += faces->corner_count;
    w->face_count += faces->count;
    return 1;
}

/* Whole blocks of chunks from *chunk on, as many as fit, and one at least. */
static norma_document_result take_faces(walk_ply *w, size_t *chunk) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    w->first_face = *chunk * LARGE_CHUNK;
    w->corner_count = w->face_count = w->starts[0] = 0;
    w->least = UINT32_MAX;
    w->most = 0;
    while (*chunk < w->chunk_count && !result) {
        const size_t left = w->chunk_count - *chunk,
                     count = left < CHUNKS_IN_BLOCK ? left : CHUNKS_IN_BLOCK,
                     a_block = w->face_count ? w->corner_count / (w->face_count / LARGE_CHUNK) *
                                                   CHUNKS_IN_BLOCK * 5 / 4
                                             : 0;
        if (w->face_count && (w->face_count + LARGE_FACES_IN_BLOCK > w->face_room ||
                                 w->corner_count + a_block > w->corner_room))
            break;
        for (size_t i = 0; i < count && !result; ++i, ++*chunk) {
            result = read_chunk(w, *chunk);
            if (!result && !take_chunk(w)) result = norma_large_fail_memory(w->ply.file);
        }
    }
    return result;
}

static void number_vertices(walk_ply *w) {
    const size_t least = w->least, count = w->corner_count ? (size_t)w->most - least + 1 : 0;
    w->named.count = count;
    norma_large_bits_clear(&w->named);
    for (size_t c = 0; c < w->corner_count; ++c)
        norma_large_bits_set(&w->named, w->corners[c] - least);
    w->vertex_count = norma_large_bits_count(&w->named);
    for (size_t c = 0; c < w->corner_count; ++c)
        w->corners[c] = (uint32_t)norma_large_bits_before(&w->named, w->corners[c] - least);
    for (size_t v = 0, at = 0; v < count; ++v)
        if (norma_large_bits_has(&w->named, v)) w->vertices[at++] = (uint32_t)(least + v);
}

static norma_document_result gather_positions(walk_ply *w) {
    large_ply *ply = &w->ply;
    const size_t size = norma_large_position_size(ply), end = w->corner_count ? w->most + 1U : 0;
    unsigned char *out = w->positions;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = w->least, at = 0; first < end && !result; first += LARGE_BLOCK) {
        const size_t count = end - first < LARGE_BLOCK ? end - first : LARGE_BLOCK;
        if (at == w->vertex_count || w->vertices[at] >= first + count) continue;
        result = norma_large_ply_positions(ply, first, count, ply->scratch);
        for (; !result && at < w->vertex_count && w->vertices[at] < first + count;
             ++at, out += size)
            memcpy(
                out, (const unsigned char *)ply->scratch + (w->vertices[at] - first) * size, size);
    }
    return result;
}

static large_surface surface_of(const walk_ply *w) {
    return (large_surface){.first_face = w->first_face,
        .mesh = {.positions = view_of(&w->ply, w->positions, w->vertex_count),
            .corners = w->corners,
            .corner_count = w->corner_count,
            .corner_size = 4,
            .face_starts = w->starts,
            .face_count = w->face_count},
        .vertices = w->vertices};
}

norma_document_result norma_walk_ply_surface(
    walk_ply *w, large_visit_surface *visit, void *context) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t chunk = 0; chunk < w->chunk_count && !result;) {
        result = take_faces(w, &chunk);
        if (result) break;
        number_vertices(w);
        result = gather_positions(w);
        const large_surface part = surface_of(w);
        if (!result) result = visit(context, &part);
        if (!result) result = norma_large_tell(w->ply.file, (double)chunk / (double)w->chunk_count);
    }
    return result;
}

/* ---- places */

static norma_document_result locate_vertex(walk_ply *w, size_t vertex, double position[3]) {
    large_ply *ply = &w->ply;
    const norma_document_result result = norma_large_ply_positions(ply, vertex, 1, ply->scratch);
    const float *single = (const float *)(const void *)ply->scratch;
    for (size_t k = 0; k < 3 && !result; ++k)
        position[k] = ply->single ? (double)single[k] : ply->scratch[k];
    return result;
}

norma_document_result norma_walk_ply_locate(
    walk_ply *w, size_t vertex, size_t face, double position[3]) {
    const large_faces *faces = &w->ply.chunk;
    if (vertex < w->ply.vertices) return locate_vertex(w, vertex, position);
    norma_document_result result = read_chunk(w, face / LARGE_CHUNK);
    if (result) return result;
    const size_t begin = faces->starts[face % LARGE_CHUNK],
                 end = faces->starts[face % LARGE_CHUNK + 1];
    for (size_t k = 0; k < 3; ++k) position[k] = begin < end ? 0 : NAN;
    for (size_t c = begin; c < end && !result; ++c) {
        double corner[3];
        result = locate_vertex(w, faces->corners[c], corner);
        for (size_t k = 0; k < 3; ++k) position[k] += corner[k] / (double)(end - begin);
    }
    return result;
}
