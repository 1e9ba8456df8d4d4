/* large.c: the public calls for files larger than memory, and files read part by part. */
#include "io/large/large.h"
#include "core/call/call.h"
#include <math.h>
#include <stdlib.h>

/* ---- Parts of a PLY larger than memory. A part is as many faces in a row as fit, with the
 * vertices that they name; of the vertices only those blocks are read that hold some of them. */

enum { CHUNKS_IN_BLOCK = LARGE_FACES_IN_BLOCK / LARGE_CHUNK };
/* Of a part's memory for each corner: the arrays here, and what the rules make of them. */
static const size_t BYTES_A_CORNER = 192, MOST_CORNERS = (size_t)3 << 20;

/* ---- opening */

static int walk_open_part(walk_ply *w) {
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

static norma_document_result walk_ply_open(large_file *file, walk_ply *w) {
    norma_document_result result = norma_large_ply_open(file, &w->ply);
    if (result) return result;
    w->chunk_count = (size_t)(w->ply.faces / LARGE_CHUNK) + (w->ply.faces % LARGE_CHUNK != 0);
    if (!walk_open_part(w)) return norma_large_fail_memory(file);
    w->offsets[0] = w->ply.face ? w->ply.face->begin : 0;
    return NORMA_DOCUMENT_OK;
}

static void walk_ply_close(walk_ply *w) {
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
    double *stored;
    const norma_document_result result = norma_large_ply_stored(ply, first, count, &stored);
    const double scale = norma_ply_normal_scale(header, ply->vertex, header->normal);
    for (size_t i = 0; !result && i < 3 * count; ++i)
        normals[i] = norma_ply_normal_value(stored[i], scale);
    free(stored);
    return result;
}

static norma_document_result walk_ply_vertices(
    walk_ply *w, large_visit_vertices *visit, void *context) {
    large_ply *ply = &w->ply;
    const int has_normals = ply->state->header.normal[0] != PLY_NONE;
    float *normals =
        has_normals ? norma_large_take(&ply->file->budget, LARGE_BLOCK, 3 * sizeof *normals) : NULL;
    norma_document_result result =
        has_normals && !normals ? norma_large_fail_memory(ply->file) : NORMA_DOCUMENT_OK;
    for (size_t first = 0; first < ply->vertices && !result; first += LARGE_BLOCK) {
        const size_t count = norma_large_some(ply->vertices - first, LARGE_BLOCK);
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

static norma_document_result read_chunk(walk_ply *w, size_t chunk) {
    uint64_t offset = w->offsets[chunk];
    const norma_document_result result = norma_large_ply_chunk(
        &w->ply, (uint64_t)chunk * LARGE_CHUNK, norma_large_chunk_faces(&w->ply, chunk), &offset);
    if (!result) w->offsets[chunk + 1] = offset;
    return result;
}

static void *walk_grow(walk_ply *w, void *block, size_t count, size_t size) {
    return norma_large_grow(&w->ply.file->budget, block, w->corner_room, count, size);
}

/* A chunk of large polygons may need more than a part was given. */
static int walk_make_room(walk_ply *w, size_t corners) {
    const size_t count = w->corner_count + corners;
    if (count <= w->corner_room) return 1;
    if (count > UINT32_MAX) return 0; /* starts of faces are 32 bits */
    uint32_t *grown_corners = walk_grow(w, w->corners, count, sizeof *w->corners);
    if (grown_corners) w->corners = grown_corners;
    uint32_t *grown_vertices =
        grown_corners ? walk_grow(w, w->vertices, count, sizeof *w->vertices) : NULL;
    if (grown_vertices) w->vertices = grown_vertices;
    void *positions = grown_vertices
                          ? walk_grow(w, w->positions, count, norma_large_position_size(&w->ply))
                          : NULL;
    if (positions) w->positions = positions;
    if (positions) w->corner_room = count;
    return positions != NULL;
}

static int take_chunk(walk_ply *w) {
    const large_faces *faces = &w->ply.chunk;
    if (!walk_make_room(w, faces->corner_count)) return 0;
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
static norma_document_result walk_take_faces(walk_ply *w, size_t *chunk) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    w->first_face = *chunk * LARGE_CHUNK;
    w->corner_count = w->face_count = w->starts[0] = 0;
    w->least = UINT32_MAX;
    w->most = 0;
    while (*chunk < w->chunk_count && !result) {
        const size_t count = norma_large_some(w->chunk_count - *chunk, CHUNKS_IN_BLOCK),
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

static void walk_number_vertices(walk_ply *w) {
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

static norma_document_result walk_ply_surface(
    walk_ply *w, large_visit_surface *visit, void *context) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t chunk = 0; chunk < w->chunk_count && !result;) {
        result = walk_take_faces(w, &chunk);
        if (result) break;
        walk_number_vertices(w);
        result = norma_large_gather_positions(
            &w->ply, &w->named, w->least, w->corner_count ? w->most + 1U : 0, w->positions);
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
    if (!result) norma_large_scratch_position(ply, 0, position);
    return result;
}

static norma_document_result walk_ply_locate(
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

/* ---- The public calls for files larger than memory. */

enum { FIRST_VERSION = sizeof(norma_large_options) };
static const uint64_t WALK_USUAL_MEMORY = (uint64_t)1 << 29, MEMORY_FOR_THREADS = (uint64_t)1 << 26;

/* ---- options */

static norma_large_options large_options_of(const norma_large_options *given) {
    norma_large_options options;
    norma_document_copy_options(&options, sizeof options, FIRST_VERSION, given);
    if (!options.max_memory) options.max_memory = WALK_USUAL_MEMORY;
    return options;
}

static norma_file_format walk_format_of(const char *path, norma_file_format format) {
    return format ? format : norma_file_format_of_path(path);
}

static norma_document_result walk_fail_argument(norma_document_error *error, const char *what) {
    return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", what);
}

/* large.c: made whole; and what is said of formats that are read whole. */
static norma_document_result large_fail_format(const char *path, norma_document_error *error) {
    const norma_document named = {.path = (char *)(uintptr_t)path};
    return norma_document_fail(&named, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "only PLY and STL can be read in passes; allow more memory");
}

/* ---- the calls */

norma_document_result norma_large_compute(const char *input, const char *output,
    const norma_large_options *given, const norma_compute_options *compute,
    norma_compute_summary *summary, norma_document_error *error) {
    const norma_large_options options = large_options_of(given);
    norma_compute_options chosen;
    norma_compute_summary unwanted;
    large_file file;
    norma_document_clear(error);
    if (!input || !output) return walk_fail_argument(error, "no path was given");
    const norma_file_format format = walk_format_of(input, options.format);
    if (format != NORMA_FILE_PLY && format != NORMA_FILE_STL)
        return large_fail_format(input, error);
    norma_document_copy_options(
        &chosen, sizeof chosen, offsetof(norma_compute_options, tangents), compute);
    /* Each thread takes megabytes for its stack. */
    if (options.max_memory < MEMORY_FOR_THREADS) chosen.threads = 1;
    const char *bad = norma_document_bad_compute_option(&chosen);
    if (bad) return walk_fail_argument(error, bad);
    summary = summary ? summary : &unwanted;
    *summary = (norma_compute_summary){0};
    large_compute job = {.file = &file, .output = output, .options = &options};
    norma_document_result result = norma_large_open(input, &options, format, &file, error);
    file.progress = chosen.progress;
    file.progress_user = chosen.progress_user;
    if (file.document) file.document->threads = chosen.threads;
    const int is_stl = format == NORMA_FILE_STL;
    job.policy =
        norma_policy_begin(&chosen, summary, is_stl ? NORMA_SHADING_FLAT : NORMA_SHADING_SMOOTH, 0);
    if (!result) result = is_stl ? norma_large_compute_stl(&job) : norma_large_compute_ply(&job);
    norma_large_close(&file);
    return result;
}

/* ---- what a whole file takes */

/* The file, corners, the core's sums and map, normals and reasons; and what is decoded. */
static uint64_t need_of_ply(large_file *file, int *possible) {
    large_ply ply;
    uint64_t bytes = file->size;
    *possible = norma_large_ply_open(file, &ply) == NORMA_DOCUMENT_OK;
    if (*possible) {
        const uint64_t decoded =
            (ply.plain_floats ? 0U : 24U) + (ply.state->header.normal[0] == PLY_NONE ? 0U : 24U);
        bytes += ply.faces * 12 + ply.vertices * (56 + 13 + decoded);
    }
    norma_large_ply_close(&ply);
    return bytes;
}

static uint64_t need_of_stl(large_file *file, int *possible) {
    stl_state state = {.bytes = file->document->source.data, .size = (size_t)file->size};
    *possible = file->size >= STL_HEADER && norma_stl_is_binary(&state);
    return *possible ? file->size + file->size / 50 : 2 * file->size;
}

int norma_large_need(const char *path, norma_file_format format, uint64_t *bytes) {
    const norma_large_options options = {.max_memory = (uint64_t)1 << 26};
    norma_document_error error;
    large_file file;
    int possible = 0;
    uint64_t need = 0;
    format = path ? walk_format_of(path, format) : NORMA_FILE_UNKNOWN;
    if (format == NORMA_FILE_PLY || format == NORMA_FILE_STL) {
        if (norma_large_open(path, &options, format, &file, &error) == NORMA_DOCUMENT_OK)
            need = format == NORMA_FILE_STL ? need_of_stl(&file, &possible)
                                            : need_of_ply(&file, &possible);
        norma_large_close(&file);
    }
    if (bytes) *bytes = need;
    return possible;
}

/* ---- Files larger than memory, part by part: PLY by walk_ply, STL as it comes. */

struct large_walk {
    large_file file;
    norma_file_format format;
    walk_ply ply;
    large_stl stl;
};

/* ---- opening */

norma_file_format norma_large_format(const char *path, const norma_large_options *options) {
    return walk_format_of(path, large_options_of(options).format);
}

static norma_document_result open_walk(
    large_walk *w, const char *path, const norma_large_options *given, norma_document_error *e) {
    const norma_large_options options = large_options_of(given);
    if (w->format != NORMA_FILE_PLY && w->format != NORMA_FILE_STL)
        return large_fail_format(path, e);
    norma_document_result result = norma_large_open(path, &options, w->format, &w->file, e);
    if (result) return result;
    return w->format == NORMA_FILE_STL ? norma_large_stl_open(&w->file, &w->stl)
                                       : walk_ply_open(&w->file, &w->ply);
}

static void walk_describe(const large_walk *w, norma_mesh_info *info) {
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
    if (!result) walk_describe(w, info);
    return result;
}

static norma_document_result close_walk(large_walk *w, norma_document_result result) {
    if (!result && norma_window_has_changed(w->file.window))
        result = norma_large_fail_read(&w->file, FILE_CHANGED);
    walk_ply_close(&w->ply);
    norma_large_stl_close(&w->stl);
    norma_large_close(&w->file);
    return result;
}

norma_document_result norma_large_walk_close(large_walk *w, norma_document_result result) {
    if (!w) return result;
    result = close_walk(w, result);
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
        const size_t count = norma_large_some(w->stl.facets - first, LARGE_FACETS);
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
                                       : walk_ply_vertices(&w->ply, visit, context);
}

norma_document_result norma_large_walk_surface(
    large_walk *w, double from, double to, large_visit_surface *visit, void *context) {
    const stl_visits visits = {.surface = visit, .context = context};
    norma_large_stage(&w->file, from, to);
    return w->format == NORMA_FILE_STL ? walk_stl(w, &visits)
                                       : walk_ply_surface(&w->ply, visit, context);
}

/* ---- what is in a file, counted part by part */

static norma_document_result include_vertices(void *context, const large_vertices *part) {
    norma_large_description *description = context;
    for (size_t i = 0; i < part->positions.count; ++i) {
        double at[3];
        norma_view_read(&part->positions, i, at);
        if (!isfinite(at[0]) || !isfinite(at[1]) || !isfinite(at[2])) continue;
        for (int axis = 0; axis < 3; ++axis) {
            double *least = &description->least[axis], *most = &description->most[axis];
            if (!description->has_bounds || at[axis] < *least) *least = at[axis];
            if (!description->has_bounds || at[axis] > *most) *most = at[axis];
        }
        description->has_bounds = 1;
    }
    return NORMA_DOCUMENT_OK;
}

/* Triangles of a PLY: if each face is cut. */
static norma_document_result describe_walk(large_walk *w, norma_large_description *description) {
    const int is_ply = w->format == NORMA_FILE_PLY;
    large_survey survey = {0};
    norma_mesh_info info;
    norma_document_result result = is_ply ? norma_large_ply_open(&w->file, &w->ply.ply)
                                          : norma_large_stl_open(&w->file, &w->stl);
    norma_large_stage(&w->file, 0, 0.7);
    if (!result && is_ply) result = norma_large_survey(&w->ply.ply, &survey);
    if (!result)
        result = norma_large_walk_vertices(w, is_ply ? 0.7 : 0, 1, include_vertices, description);
    if (!result) {
        walk_describe(w, &info);
        description->vertices = info.vertices;
        description->faces = info.faces;
        description->triangles = is_ply ? (size_t)survey.triangles : info.triangles;
        description->normals = info.normals;
        description->encoding = info.encoding;
    }
    if (is_ply) norma_large_survey_close(&w->ply.ply, &survey);
    return result;
}

norma_document_result norma_large_describe(const char *path, const norma_large_options *given,
    norma_progress *progress, void *progress_user, norma_large_description *description,
    norma_document_error *error) {
    const norma_large_options options = large_options_of(given);
    large_walk w = {.format = NORMA_FILE_UNKNOWN};
    norma_document_clear(error);
    if (!path || !description) return walk_fail_argument(error, "no path or no place was given");
    w.format = walk_format_of(path, options.format);
    *description = (norma_large_description){.format = w.format, .encoding = ""};
    if (w.format != NORMA_FILE_PLY && w.format != NORMA_FILE_STL)
        return large_fail_format(path, error);
    norma_document_result result = norma_large_open(path, &options, w.format, &w.file, error);
    w.file.progress = progress;
    w.file.progress_user = progress_user;
    if (!result) result = describe_walk(&w, description);
    return close_walk(&w, result);
}

/* ---- places */

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
                                       : walk_ply_locate(&w->ply, vertex, face, position);
}
