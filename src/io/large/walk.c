/* walk.c: files larger than memory, part by part: PLY as walk_ply.c, STL as it comes. */
#include "io/large/walk.h"
#include "io/large/stl_blocks.h"
#include "io/large/walk_ply.h"
#include <stdlib.h>

struct large_walk {
    large_file file;
    norma_file_format format;
    walk_ply ply;
    large_stl stl;
};

/* ---- opening */

norma_file_format norma_large_format(const char *path, const norma_large_options *options) {
    const norma_large_options whole = norma_large_options_of(options);
    return whole.format ? whole.format : norma_file_format_of_path(path);
}

static norma_document_result open_walk(
    large_walk *w, const char *path, const norma_large_options *given, norma_document_error *e) {
    const norma_large_options options = norma_large_options_of(given);
    if (w->format != NORMA_FILE_PLY && w->format != NORMA_FILE_STL)
        return norma_large_fail_format(path, e);
    norma_document_result result = norma_large_open(path, &options, w->format, &w->file, e);
    if (result) return result;
    return w->format == NORMA_FILE_STL ? norma_large_stl_open(&w->file, &w->stl)
                                       : norma_walk_ply_open(&w->file, &w->ply);
}

static void describe(const large_walk *w, norma_mesh_info *info) {
    *info = (norma_mesh_info){.name = "", .where = "", .encoding = ""};
    w->file.document->functions->mesh_info(w->file.document, 0, info);
    if (w->format == NORMA_FILE_PLY) {
        info->vertices = w->ply.ply.vertices;
        info->faces = (size_t)w->ply.ply.faces;
    }
}

norma_document_result norma_large_walk_open(const char *path, const norma_large_options *options,
    norma_progress *progress, void *progress_user, large_walk **walk, norma_mesh_info *info,
    norma_document_error *error) {
    large_walk *w = *walk = norma_io_allocate(1, sizeof *w);
    if (!w) return norma_document_fail_memory(NULL, error);
    w->format = norma_large_format(path, options);
    const norma_document_result result = open_walk(w, path, options, error);
    w->file.progress = progress;
    w->file.progress_user = progress_user;
    if (!result) describe(w, info);
    return result;
}

norma_document_result norma_large_walk_close(large_walk *w, norma_document_result result) {
    if (!w) return result;
    if (!result && norma_window_has_changed(w->file.window))
        result = norma_large_fail_read(&w->file, FILE_CHANGED);
    norma_walk_ply_close(&w->ply);
    norma_large_stl_close(&w->stl);
    norma_large_close(&w->file);
    free(w);
    return result;
}

/* ---- STL */

static norma_vec3_view floats(const float *data, size_t count) {
    return (norma_vec3_view){.data = data, .count = count, .format = NORMA_FORMAT_FLOAT};
}

static norma_document_result read_facets(large_walk *w, size_t first, size_t count) {
    const norma_document_result result = norma_large_stl_read(&w->stl, first, count);
    if (result) return result;
    norma_large_stl_positions(&w->stl, count);
    for (size_t i = 0; i < count; ++i)
        norma_stl_load(w->stl.state, i, w->stl.block->normals + 3 * i, NULL);
    return result;
}

typedef struct stl_visits { /* one of the two */
    large_visit_vertices *vertices;
    large_visit_surface *surface;
    void *context;
} stl_visits;

static norma_document_result visit_facets(
    const large_walk *w, const stl_visits *visits, size_t first, size_t count) {
    const large_facets *block = w->stl.block;
    const norma_vec3_view positions = floats(block->positions, 3 * count);
    const large_vertices vertices = {.first = 3 * first, .positions = positions};
    const large_surface surface = {.first_face = first,
        .mesh = {.positions = positions, .corner_count = 3 * count},
        .first_vertex = 3 * first,
        .normals = floats(block->normals, count)};
    return visits->vertices ? visits->vertices(visits->context, &vertices)
                            : visits->surface(visits->context, &surface);
}

static norma_document_result walk_stl(large_walk *w, const stl_visits *visits) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = 0; first < w->stl.facets && !result; first += LARGE_FACETS) {
        const size_t left = w->stl.facets - first,
                     count = left < LARGE_FACETS ? left : LARGE_FACETS;
        result = read_facets(w, first, count);
        if (!result) result = visit_facets(w, visits, first, count);
        if (!result) result = norma_large_tell(&w->file, (double)first / (double)w->stl.facets);
    }
    return result;
}

/* ---- walks */

norma_document_result norma_large_walk_vertices(
    large_walk *w, double from, double to, large_visit_vertices *visit, void *context) {
    const stl_visits visits = {.vertices = visit, .context = context};
    norma_large_stage(&w->file, from, to);
    return w->format == NORMA_FILE_STL ? walk_stl(w, &visits)
                                       : norma_walk_ply_vertices(&w->ply, visit, context);
}

norma_document_result norma_large_walk_surface(
    large_walk *w, double from, double to, large_visit_surface *visit, void *context) {
    const stl_visits visits = {.surface = visit, .context = context};
    norma_large_stage(&w->file, from, to);
    return w->format == NORMA_FILE_STL ? walk_stl(w, &visits)
                                       : norma_walk_ply_surface(&w->ply, visit, context);
}

static norma_document_result locate_facet(
    large_walk *w, size_t vertex, size_t face, double position[3]) {
    const size_t facet = face == SIZE_MAX ? vertex / 3 : face;
    const norma_document_result result = read_facets(w, facet, 1);
    const float *at = w->stl.block->positions;
    for (size_t k = 0; k < 3 && !result; ++k) {
        position[k] = 0;
        if (vertex != SIZE_MAX)
            position[k] = (double)at[3 * (vertex % 3) + k];
        else
            for (size_t c = 0; c < 3; ++c) position[k] += (double)at[3 * c + k] / 3.0;
    }
    return result;
}

norma_document_result norma_large_walk_locate(
    large_walk *w, size_t vertex, size_t face, double position[3]) {
    return w->format == NORMA_FILE_STL ? locate_facet(w, vertex, face, position)
                                       : norma_walk_ply_locate(&w->ply, vertex, face, position);
}
