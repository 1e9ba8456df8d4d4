/* composite.c: a composite of 3D Tiles 1.0 (OGC 18-053r2) with several models, read and changed as
 * one document: the models are documents of their own, of the bytes of their tiles, whose meshes,
 * nodes and materials follow one another. When it is written, tiles that changed take the places of
 * those that were read, and the lengths around them are set. */
#include "io/format/for_fixes.h"
#include "io/gltf/gltf.h"
#include "io/stream/stream.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BYTE_LENGTH = 8 };
enum { MOST_MODELS = 1024 }; /* each takes some kilobytes beside the file */

/* ---- the models of a composite, each with the numbers at which what it has begins */

enum model_part { MESHES, NODES, MATERIALS, MODEL_PARTS };

typedef struct composite_model {
    norma_document *document;
    gltf_tile tile;
    double step[3];                  /* from its frame to that of the first, in axes of glTF */
    size_t first[MODEL_PARTS];       /* as norma_document_mesh_info, ... count */
    size_t mesh_number, node_number; /* as the file counts */
    size_t skin, image;
    size_t notes;                    /* of its document, so many of which the composite has told */
    char **mesh_where, **node_where; /* NULL: not asked for yet */
} composite_model;

typedef struct composite {
    composite_model *models; /* and one more: the ends */
    size_t count;
    gltf_tile left_out; /* tiles without a model */
} composite;

static composite *composite_of(const norma_document *document) { return document->state; }

static const gltf *gltf_of_model(const composite_model *model) {
    return norma_gltf_of(model->document);
}

static composite_model *model_of(
    const norma_document *document, enum model_part part, size_t number) {
    const composite *c = composite_of(document);
    size_t i = 0;
    while (i + 1 < c->count && number >= c->models[i + 1].first[part]) ++i;
    return &c->models[i];
}

static size_t moved(size_t number, size_t by) { return number == SIZE_MAX ? number : number + by; }

/* What a tile says of itself, with its number. */
static norma_document_result fail_in_model(const norma_document *document, size_t i,
    norma_document_error *error, norma_document_result result) {
    char place[40];
    const size_t length = strlen(document->path);
    if (!result || !error || strncmp(error->message, document->path, length) != 0 ||
        error->message[length] != ':')
        return result;
    const norma_document_error own = *error;
    const char *said = own.message + length + 1;
    snprintf(place, sizeof place, "tile %zu", i);
    return norma_document_fail(document, error, result, place, "%s", said + (*said == ' '));
}

static void free_texts(char ***texts, size_t count) {
    for (size_t i = 0; *texts && i < count; ++i) free((*texts)[i]);
    free((void *)*texts);
    *texts = NULL;
}

/* Before models are counted anew: there are as many texts as were counted. */
static void forget_wheres(composite *c) {
    for (size_t i = 0; i < c->count; ++i) {
        composite_model *m = &c->models[i];
        free_texts(&m->mesh_where, m[1].first[MESHES] - m->first[MESHES]);
        free_texts(&m->node_where, m[1].first[NODES] - m->first[NODES]);
    }
}

/* Where the numbers of each model begin; after each change, for it may add materials, and baking
 * makes meshes. */
static void count_models(const norma_document *document) {
    composite *c = composite_of(document);
    const int is_whole = document->depth == NORMA_DOCUMENT_WHOLE;
    for (size_t i = 0; i < c->count; ++i) {
        composite_model *m = &c->models[i], *next = m + 1;
        norma_document *own = m->document;
        next->first[MESHES] = m->first[MESHES] + norma_document_mesh_count(own);
        next->first[NODES] = m->first[NODES] + norma_document_node_count(own);
        next->skin = m->skin + (is_whole ? norma_document_skin_count(own) : 0);
        next->first[MATERIALS] =
            m->first[MATERIALS] + (is_whole ? norma_document_material_count(own) : 0);
        const gltf *g = gltf_of_model(m);
        next->mesh_number = m->mesh_number + g->mesh_count;
        next->node_number = m->node_number + g->node_count;
        next->image = m->image + g->json.count; /* at least as many as images */
    }
}

static void take_notes(norma_document *document) {
    composite *c = composite_of(document);
    for (size_t i = 0; i < c->count; ++i)
        for (composite_model *m = &c->models[i]; m->notes < norma_document_note_count(m->document);
             ++m->notes)
            norma_document_add_note(
                document, "tile %zu: %s", i, norma_document_note(m->document, m->notes));
}

/* Models that were changed are read anew, as if they stood alone. The first also tells of the tiles
 * without a model. */
static void tell_places(const norma_document *document) {
    const composite *c = composite_of(document);
    for (size_t i = 0; i < c->count; ++i) {
        const gltf_tile *tile = &c->models[i].tile;
        norma_gltf_of(c->models[i].document)->tile.begins = tile->headers[tile->depth - 1];
    }
    gltf_tile *first = &norma_gltf_of(c->models[0].document)->tile;
    first->left_out = c->left_out.left_out;
    first->left_out_at = c->left_out.left_out_at;
    first->left_out_why = c->left_out.left_out_why;
}

void norma_document_tiles_changed(norma_document *document) {
    if (!document->tiles) return;
    forget_wheres(composite_of(document));
    count_models(document);
    tell_places(document);
    take_notes(document);
    norma_scene_forget(document->scene);
}

/* glTF's y points up, a tile's z. */
static void place_models(composite *c) {
    double first[3], own[3];
    if (!norma_gltf_read_frame(gltf_of_model(&c->models[0]), first)) return;
    for (size_t i = 1; i < c->count; ++i) {
        double *step = c->models[i].step;
        if (!norma_gltf_read_frame(gltf_of_model(&c->models[i]), own)) continue;
        step[0] = own[0] - first[0];
        step[1] = own[2] - first[2];
        step[2] = first[1] - own[1];
    }
}

static norma_document_result open_model(
    norma_document *document, size_t i, norma_document_error *error) {
    composite_model *m = &composite_of(document)->models[i];
    const size_t begin = m->tile.headers[m->tile.depth - 1];
    const unsigned char *bytes = document->source.data + begin;
    const norma_document_options options = {.struct_size = sizeof options,
        .format = memcmp(bytes, "i3dm", 4) == 0 ? NORMA_FILE_I3DM : NORMA_FILE_B3DM,
        .depth = document->depth,
        .threads = document->threads,
        .lenient = document->lenient,
        .copied = document->copied};
    norma_document *made = norma_document_make(document->path, document->folder != NULL, &options);
    if (!made) return norma_document_fail_memory(document, error);
    m->document = document->tiles[i] = made;
    made->functions = &norma_gltf_functions;
    made->source = (file_bytes){.data = bytes, .size = m->tile.end - begin};
    return fail_in_model(document, i, error, norma_document_read(made, error));
}

static norma_document_result composite_open(norma_document *document, norma_document_error *error) {
    size_t found;
    gltf_tile left_out;
    norma_document_result result =
        norma_gltf_find_tiles(document, NULL, 0, &found, &left_out, error);
    if (!result && found == 1) {
        document->functions = &norma_gltf_functions;
        return norma_gltf_functions.open(document, error);
    }
    if (!result && found > MOST_MODELS)
        result = norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "the composite has %zu tiles with meshes, more than the %d that are read; split it",
            found, MOST_MODELS);
    if (result) return result;
    composite *c = norma_io_allocate(1, sizeof *c);
    document->state = c;
    if (c) c->models = norma_io_allocate(found + 1, sizeof *c->models);
    document->tiles = norma_io_allocate(found, sizeof *document->tiles);
    gltf_tile *tiles = norma_io_allocate(found, sizeof *tiles);
    if (!c || !c->models || !document->tiles || !tiles) {
        free(tiles);
        return norma_document_fail_memory(document, error);
    }
    c->count = document->tile_count = found;
    c->left_out = left_out;
    result = norma_gltf_find_tiles(document, tiles, found, &found, &left_out, error);
    for (size_t i = 0; !result && i < c->count; ++i) {
        c->models[i].tile = tiles[i];
        result = open_model(document, i, error);
    }
    free(tiles);
    if (result) return result;
    place_models(c);
    norma_document_tiles_changed(document);
    return NORMA_DOCUMENT_OK;
}

static void composite_close(norma_document *document) {
    composite *c = composite_of(document);
    if (!c) return;
    if (c->models) forget_wheres(c);
    free(c->models);
    free(c);
}

/* ---- asking */

/* "/meshes/0" as "/tiles/2/meshes/0", kept; NULL: out of memory. */
static const char *where_of(const norma_document *document, const composite_model *m, char ***list,
    size_t count, size_t index, const char *where) {
    if (!*list) *list = norma_io_allocate(count, sizeof **list);
    if (!*list) return NULL;
    if (!(*list)[index]) {
        char begin[40];
        snprintf(begin, sizeof begin, "/tiles/%zu", (size_t)(m - composite_of(document)->models));
        (*list)[index] = norma_io_join(begin, where);
    }
    return (*list)[index];
}

static size_t composite_mesh_count(const norma_document *document) {
    const composite *c = composite_of(document);
    return c->models[c->count].first[MESHES];
}

static norma_document_result composite_mesh_info(
    const norma_document *document, size_t index, norma_mesh_info *info) {
    composite_model *m = model_of(document, MESHES, index);
    const norma_document_result result =
        norma_document_mesh_info(m->document, index - m->first[MESHES], info);
    if (result) return result;
    info->mesh += m->mesh_number;
    info->where = where_of(document, m, &m->mesh_where, m[1].first[MESHES] - m->first[MESHES],
        index - m->first[MESHES], info->where);
    return info->where ? NORMA_DOCUMENT_OK : NORMA_DOCUMENT_ERROR_MEMORY;
}

static norma_document_result composite_mesh_data(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error) {
    const composite_model *m = model_of(document, MESHES, index);
    return norma_document_mesh_data(m->document, index - m->first[MESHES], data, error);
}

static size_t composite_node_count(const norma_document *document) {
    const composite *c = composite_of(document);
    return c->models[c->count].first[NODES];
}

static void step_to(const composite_model *m, double sign, double world[16]) {
    for (int axis = 0; axis < 3; ++axis) world[12 + axis] += sign * m->step[axis];
}

static norma_document_result composite_node_info(
    const norma_document *document, size_t index, norma_node_info *info) {
    composite_model *m = model_of(document, NODES, index);
    const norma_document_result result =
        norma_document_node_info(m->document, index - m->first[NODES], info);
    if (result) return result;
    info->node += m->node_number;
    info->mesh += m->mesh_number;
    info->parent = moved(info->parent, m->node_number);
    info->skin = moved(info->skin, m->skin);
    step_to(m, 1, info->world);
    info->where = where_of(document, m, &m->node_where, m[1].first[NODES] - m->first[NODES],
        index - m->first[NODES], info->where);
    return info->where ? NORMA_DOCUMENT_OK : NORMA_DOCUMENT_ERROR_MEMORY;
}

static int composite_visit_files(
    const norma_document *document, norma_visit_file *visit, void *user) {
    const composite *c = composite_of(document);
    int stopped = 0;
    for (size_t i = 0; i < c->count && !stopped; ++i)
        stopped = norma_gltf_functions.visit_files(c->models[i].document, visit, user);
    return stopped;
}

/* ---- changing: each model by itself */

typedef struct progress_of_all {
    norma_progress *progress;
    void *user;
    double done, of; /* models */
} progress_of_all;

typedef struct model_change {
    const composite_model *model;
    size_t number;     /* of the model */
    const void *given; /* the options, or edits, or meshes */
    void *sum;         /* of what the models say; or NULL */
    norma_progress *progress;
    progress_of_all *user;
} model_change;

typedef norma_document_result change_model(const model_change *one, norma_document_error *error);

static int tell_progress_of_all(void *user, double fraction) {
    const progress_of_all *all = user;
    return all->progress(all->user, (all->done + fraction) / all->of);
}

static norma_document_result change_each(norma_document *document, change_model *change,
    const void *given, void *sum, norma_progress *progress, void *user,
    norma_document_error *error) {
    const composite *c = composite_of(document);
    progress_of_all all = {progress, user, 0, (double)c->count};
    model_change one = {.given = given,
        .sum = sum,
        .progress = progress ? tell_progress_of_all : NULL,
        .user = &all};
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (; one.number < c->count && !result; ++one.number) {
        one.model = &c->models[one.number];
        all.done = (double)one.number;
        result = change(&one, error);
    }
    norma_document_tiles_changed(document);
    return fail_in_model(document, one.number - 1, error, result);
}

/* meshes: of all models, or NULL. */
static const uint8_t *meshes_of(const model_change *one, const uint8_t *meshes) {
    return meshes ? meshes + one->model->first[MESHES] : NULL;
}

static norma_document_result compute_model(const model_change *one, norma_document_error *error) {
    norma_compute_options options = *(const norma_compute_options *)one->given;
    norma_compute_summary own, *sum = one->sum;
    options.meshes = meshes_of(one, options.meshes);
    options.progress = one->progress;
    options.progress_user = one->user;
    const norma_document_result result =
        norma_document_compute(one->model->document, &options, &own, error);
    if (result) return result;
    const norma_compute_summary before = *sum;
    *sum = own;
    sum->report = before.report;
    norma_policy_add_report(&sum->report, &own.report, one->number);
    sum->changed |= before.changed;
    sum->faces += before.faces;
    sum->vertices_before += before.vertices_before;
    sum->vertices_after += before.vertices_after;
    sum->by_groups |= before.by_groups;
    sum->edges_counted |= before.edges_counted;
    sum->hard_edges += before.hard_edges;
    sum->filled += before.filled;
    sum->tangents_kept += before.tangents_kept;
    sum->tangents_orthogonalised += before.tangents_orthogonalised;
    sum->tangents_regenerated += before.tangents_regenerated;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result composite_compute(norma_document *document,
    const norma_compute_options *given, norma_compute_summary *summary,
    norma_document_error *error) {
    return change_each(
        document, compute_model, given, summary, given->progress, given->progress_user, error);
}

static norma_document_result make_model_tangents(
    const model_change *one, norma_document_error *error) {
    norma_tangent_options options = *(const norma_tangent_options *)one->given;
    norma_tangent_summary own, *sum = one->sum;
    options.meshes = meshes_of(one, options.meshes);
    options.progress = one->progress;
    options.progress_user = one->user;
    const norma_document_result result =
        norma_document_tangents(one->model->document, &options, &own, error);
    if (result) return result;
    sum->changed |= own.changed;
    sum->primitives += own.primitives;
    sum->left_out += own.left_out;
    sum->vertices_before += own.vertices_before;
    sum->vertices_after += own.vertices_after;
    sum->degenerate += own.degenerate;
    sum->non_finite += own.non_finite;
    sum->cancelled += own.cancelled;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result composite_tangents(norma_document *document,
    const norma_tangent_options *given, norma_tangent_summary *summary,
    norma_document_error *error) {
    return change_each(document, make_model_tangents, given, summary, given->progress,
        given->progress_user, error);
}

static void add_pack_part(norma_pack_part *sum, const norma_pack_part *own) {
    sum->accessors += own->accessors;
    sum->packed += own->packed;
    sum->bytes_before += own->bytes_before;
    sum->bytes_after += own->bytes_after;
    if (own->max_error_rad > sum->max_error_rad) sum->max_error_rad = own->max_error_rad;
}

static norma_document_result pack_model(const model_change *one, norma_document_error *error) {
    norma_pack_options options = *(const norma_pack_options *)one->given;
    norma_pack_summary own, *sum = one->sum;
    options.progress = one->progress;
    options.progress_user = one->user;
    const norma_document_result result =
        norma_document_pack(one->model->document, &options, &own, error);
    if (result) return result;
    sum->changed |= own.changed;
    sum->made_unit += own.made_unit;
    add_pack_part(&sum->normals, &own.normals);
    add_pack_part(&sum->tangents, &own.tangents);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result composite_pack(norma_document *document,
    const norma_pack_options *given, norma_pack_summary *summary, norma_document_error *error) {
    return change_each(
        document, pack_model, given, summary, given->progress, given->progress_user, error);
}

/* A model turned or scaled in its own frame stays where its frame is: two of them would drift
 * apart. Moved, they stay together. */
static int would_drift(const composite *c, const double matrix[16]) {
    int is_given = 0, turns = 0; /* all zero is the identity */
    for (int k = 0; k < 16; ++k) {
        is_given |= matrix[k] != 0;
        turns |= k < 12 && k % 4 < 3 && matrix[k] != (k % 5 == 0 ? 1 : 0);
    }
    for (size_t i = 1; i < c->count && is_given && turns; ++i)
        for (int axis = 0; axis < 3; ++axis)
            if (c->models[i].step[axis] != 0) return 1;
    return 0;
}

static norma_document_result transform_model(const model_change *one, norma_document_error *error) {
    norma_transform_options options = *(const norma_transform_options *)one->given;
    norma_transform_summary own, *sum = one->sum;
    options.progress = one->progress;
    options.progress_user = one->user;
    const norma_document_result result =
        norma_document_transform(one->model->document, &options, &own, error);
    if (result) return result;
    sum->changed |= own.changed;
    sum->vertices += own.vertices;
    sum->meshes += own.meshes;
    sum->nodes_baked += own.nodes_baked;
    sum->mirrored |= own.mirrored;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result composite_transform(norma_document *document,
    const norma_transform_options *given, norma_transform_summary *summary,
    norma_document_error *error) {
    if (would_drift(composite_of(document), given->matrix))
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "its tiles stand in frames of their own (RTC_CENTER, CESIUM_RTC), which are not turned "
            "or scaled; expected a translation, or split it first");
    return change_each(
        document, transform_model, given, summary, given->progress, given->progress_user, error);
}

static norma_document_result edit_model(const model_change *one, norma_document_error *error) {
    const norma_mesh_edit *edits = one->given;
    return norma_document_edit(one->model->document, edits + one->model->first[MESHES], error);
}

static norma_document_result composite_edit(
    norma_document *document, const norma_mesh_edit *edits, norma_document_error *error) {
    return change_each(document, edit_model, edits, NULL, NULL, NULL, error);
}

static norma_document_result recentre_model(const model_change *one, norma_document_error *error) {
    int own = 0, *changed = one->sum;
    const norma_document_result result =
        norma_document_recentre(one->model->document, meshes_of(one, one->given), &own, error);
    *changed |= own;
    return result;
}

static norma_document_result composite_recentre(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error) {
    return change_each(document, recentre_model, meshes, changed, NULL, NULL, error);
}

static norma_document_result composite_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error) {
    const composite_model *m = model_of(document, MESHES, mesh);
    return norma_document_equal_vertices(m->document, mesh - m->first[MESHES], first, error);
}

/* ---- writing */

static void add_to_length(unsigned char *header, size_t grown) {
    const uint32_t length = norma_gltf_u32(header + BYTE_LENGTH) + (uint32_t)grown;
    for (int i = 0; i < 4; ++i) header[BYTE_LENGTH + i] = (unsigned char)(length >> (8 * i));
}

/* A model's other files would be told apart by nothing: what changes of them goes into the model,
 * as where there is no path. */
static norma_document_result write_models(norma_document *document, growing_bytes *made,
    unsigned char *around, norma_write *write, void *user, norma_document_error *error) {
    const composite *c = composite_of(document);
    norma_document_result result = NORMA_DOCUMENT_OK;
    uint64_t size = document->source.size;
    for (size_t i = 0; i < c->count && !result; ++i) {
        const gltf_tile *tile = &c->models[i].tile;
        result =
            norma_document_write(c->models[i].document, norma_memory_sink_write, &made[i], error);
        if (result == NORMA_DOCUMENT_ERROR_FILE && made[i].failed)
            result = norma_document_fail_memory(document, error);
        if (result) return fail_in_model(document, i, error, result);
        const size_t was = tile->end - tile->headers[tile->depth - 1];
        size = size - was + made[i].size;
        for (uint32_t k = 0; k + 1 < tile->depth; ++k)
            add_to_length(around + tile->headers[k], made[i].size - was);
    }
    if (size > UINT32_MAX)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "would become larger than the 4 GiB that a tile can be");
    size_t at = 0;
    int failed = 0;
    for (size_t i = 0; i < c->count && !failed; ++i) {
        const gltf_tile *tile = &c->models[i].tile;
        const size_t begin = tile->headers[tile->depth - 1];
        if (begin > at) failed = write(user, around + at, begin - at);
        if (!failed) failed = write(user, made[i].data, made[i].size);
        at = tile->end;
    }
    if (!failed && at < document->source.size)
        failed = write(user, around + at, document->source.size - at);
    return failed ? norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_FILE, NULL,
                        "the output could not be written")
                  : NORMA_DOCUMENT_OK;
}

static norma_document_result composite_write(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error) {
    const composite *c = composite_of(document);
    growing_bytes *made = norma_io_allocate(c->count, sizeof *made);
    unsigned char *around =
        malloc(document->source.size); /* the file, its lengths as they will be */
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (made && around) {
        memcpy(around, document->source.data, document->source.size);
        result = write_models(document, made, around, write, user, error);
    } else {
        result = norma_document_fail_memory(document, error);
    }
    for (size_t i = 0; made && i < c->count; ++i) free(made[i].data);
    free(made);
    free(around);
    (void)path;
    return result;
}

/* ---- what else is told */

static norma_document_result composite_materials(
    norma_document *document, norma_document_error *error) {
    const composite *c = composite_of(document);
    norma_scene *scene = document->scene;
    const size_t count = c->models[c->count].first[MATERIALS];
    norma_material_info *made = norma_scene_allocate(scene, count, sizeof *made);
    if (!made) return norma_document_fail_memory(document, error);
    for (size_t i = 0; i < c->count; ++i)
        for (size_t k = c->models[i].first[MATERIALS]; k < c->models[i + 1].first[MATERIALS]; ++k)
            (void)norma_document_material_info(
                c->models[i].document, k - c->models[i].first[MATERIALS], &made[k]);
    scene->materials = made;
    scene->material_count = count;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result composite_attributes(norma_document *document, size_t mesh,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    const composite_model *m = model_of(document, MESHES, mesh);
    const norma_document_result result =
        norma_document_mesh_attributes(m->document, mesh - m->first[MESHES], attributes, error);
    attributes->material = moved(attributes->material, m->first[MATERIALS]);
    return result;
}

static norma_document_result composite_morph(norma_document *document, size_t mesh, size_t target,
    norma_morph_data *data, norma_document_error *error) {
    const composite_model *m = model_of(document, MESHES, mesh);
    return norma_document_morph_data(m->document, mesh - m->first[MESHES], target, data, error);
}

static norma_document_result composite_instance_world(norma_document *document, size_t node,
    size_t instance, double world[16], norma_document_error *error) {
    const composite_model *m = model_of(document, NODES, node);
    const norma_document_result result =
        norma_document_instance_world(m->document, node - m->first[NODES], instance, world, error);
    if (!result) step_to(m, 1, world);
    return result;
}

static norma_document_result composite_move_drawn(norma_document *document, size_t node,
    size_t mesh, norma_drawn_mesh *drawn, norma_document_error *error) {
    const composite_model *m = model_of(document, NODES, node);
    step_to(m, -1, drawn->world);
    const norma_document_result result = norma_gltf_move_drawn(
        m->document, node - m->first[NODES], mesh - m->first[MESHES], drawn, error);
    step_to(m, 1, drawn->world);
    return result;
}

static norma_document_result composite_material_maps(norma_document *document, size_t material,
    norma_material_maps *maps, norma_document_error *error) {
    const composite_model *m = model_of(document, MATERIALS, material);
    const norma_document_result result =
        norma_document_material_maps(m->document, material - m->first[MATERIALS], maps, error);
    maps->base_color.image = moved(maps->base_color.image, m->image);
    maps->normal.image = moved(maps->normal.image, m->image);
    return result;
}

static norma_document_result composite_normal_map(norma_document *document, size_t material,
    norma_texture_info *map, norma_document_error *error) {
    const composite_model *m = model_of(document, MATERIALS, material);
    const norma_document_result result =
        norma_document_normal_map(m->document, material - m->first[MATERIALS], map, error);
    map->image = moved(map->image, m->image);
    return result;
}

static norma_document_result composite_texcoords(norma_document *document, size_t mesh, size_t set,
    const float **texcoords, size_t *count, norma_document_error *error) {
    const composite_model *m = model_of(document, MESHES, mesh);
    return norma_document_texcoords(
        m->document, mesh - m->first[MESHES], set, texcoords, count, error);
}

/* Skins and what was not read are told by each model alone. */
static const scene_functions composite_scene = {
    .materials = composite_materials,
    .attributes = composite_attributes,
    .morph = composite_morph,
    .instance_world = composite_instance_world,
    .move_drawn = composite_move_drawn,
    .material_maps = composite_material_maps,
    .normal_map = composite_normal_map,
    .texcoords = composite_texcoords,
};

const format_functions norma_composite_functions = {
    .open = composite_open,
    .close = composite_close,
    .mesh_count = composite_mesh_count,
    .mesh_info = composite_mesh_info,
    .mesh_data = composite_mesh_data,
    .node_count = composite_node_count,
    .node_info = composite_node_info,
    .compute = composite_compute,
    .tangents = composite_tangents,
    .pack = composite_pack,
    .transform = composite_transform,
    .edit = composite_edit,
    .equal_vertices = composite_equal_vertices,
    .recentre = composite_recentre,
    .write = composite_write,
    .visit_files = composite_visit_files,
    .scene = &composite_scene,
};
