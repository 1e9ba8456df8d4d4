/* 3mf.c: 3MF packages as documents: a mesh for each object that has one. Triangles can be reversed
 * and dropped; there is nowhere to write a normal. */
#include "io/3mf/3mf.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void tmf_free_content(void *content) {
    tmf_state *state = content;
    for (size_t i = 0; i < state->part_count; ++i) {
        free(state->parts[i].name);
        free(state->parts[i].text);
    }
    for (size_t i = 0; i < state->object_count; ++i) {
        free(state->objects[i].name);
        free(state->objects[i].where);
        free(state->objects[i].positions);
        free(state->objects[i].corners);
    }
    for (size_t i = 0; i < state->node_count; ++i) free(state->nodes[i].where);
    free(state->parts);
    free(state->objects);
    free(state->components);
    free(state->items);
    free(state->nodes);
    free(state->meshes);
    free(state->others);
    for (size_t i = 0; i < state->required_count; ++i) free(state->required[i].space);
    free(state->required);
}

static int tmf_has_edit(const void *content) { return (void)content, 0; }

static norma_document_result number_meshes(norma_document *document, norma_document_error *error) {
    tmf_state *state = document->state;
    state->meshes = norma_io_allocate(state->object_count + 1, sizeof *state->meshes);
    if (!state->meshes) return norma_document_fail_memory(document, error);
    for (uint32_t i = 0; i < state->object_count; ++i)
        if (state->objects[i].has_mesh) {
            state->objects[i].mesh = state->mesh_count;
            state->meshes[state->mesh_count++] = i;
        }
    return NORMA_DOCUMENT_OK;
}

/* Parts are added on the way, by items and components that name them. */
static norma_document_result tmf_read(norma_document *document, norma_document_error *error) {
    tmf_state *state = document->state;
    norma_document_result result = norma_3mf_open(document, error);
    if (!result) result = norma_3mf_find_model(document, error);
    for (uint32_t part = 0; part < state->part_count && !result; ++part) {
        result = norma_3mf_unpack(document, part, error);
        if (!result) result = norma_3mf_read_model(document, part, error);
        if (!result) result = norma_3mf_check_relationships(document, part, error);
        free(state->parts[part].text);
        state->parts[part].text = NULL;
    }
    norma_3mf_close(document);
    if (!result) result = number_meshes(document, error);
    return result ? result : norma_3mf_place(document, error);
}

static const edited_format TMF_EDITED = {
    sizeof(tmf_state), 0, tmf_has_edit, tmf_free_content, tmf_read, NULL, NULL};

/* ---- describing */

static const tmf_object *object_of(const norma_document *document, size_t mesh) {
    const tmf_state *state = document->state;
    return &state->objects[state->meshes[mesh]];
}

static size_t tmf_mesh_count(const norma_document *document) {
    return ((const tmf_state *)document->state)->mesh_count;
}

static norma_document_result tmf_mesh_info(
    const norma_document *document, size_t index, norma_mesh_info *info) {
    const tmf_object *object = object_of(document, index);
    *info = (norma_mesh_info){.name = object->name,
        .where = object->where,
        .mesh = index,
        .vertices = object->vertices,
        .faces = object->faces,
        .triangles = object->faces,
        .normals = NORMA_NORMALS_NONE,
        .encoding = ""};
    return NORMA_DOCUMENT_OK;
}

static norma_document_result tmf_mesh_data(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error) {
    const tmf_object *object = object_of(document, index);
    (void)error;
    data->mesh = (norma_mesh){.positions = {.data = object->positions,
                                  .count = object->vertices,
                                  .format = NORMA_FORMAT_DOUBLE},
        .corners = object->corners,
        .corner_count = 3 * object->faces};
    return NORMA_DOCUMENT_OK;
}

static size_t tmf_node_count(const norma_document *document) {
    return ((const tmf_state *)document->state)->node_count;
}

static norma_document_result tmf_node_info(
    const norma_document *document, size_t index, norma_node_info *info) {
    const tmf_node *node = &((const tmf_state *)document->state)->nodes[index];
    info->name = info->path = node->name;
    info->where = node->where;
    info->node = index;
    info->mesh = node->mesh;
    memcpy(info->world, node->world, sizeof info->world);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result tmf_instance_world(norma_document *document, size_t node,
    size_t instance, double world[16], norma_document_error *error) {
    (void)instance, (void)error;
    memcpy(world, ((const tmf_state *)document->state)->nodes[node].world, 16 * sizeof *world);
    return NORMA_DOCUMENT_OK;
}

/* Extensions that are required, and not known here: what they add was not looked at. */
static norma_document_result tmf_unread(norma_document *document, norma_document_error *error) {
    const tmf_state *state = document->state;
    norma_unread *unread = norma_scene_tell_unread(document, state->required_count, error);
    if (!unread) return NORMA_DOCUMENT_ERROR_MEMORY;
    for (size_t i = 0; i < state->required_count; ++i) {
        const tmf_required *required = &state->required[i];
        const size_t size = strlen(required->space) + 64;
        char *why = norma_scene_allocate(document->scene, size, 1);
        if (!why) document->scene->unread = NULL;
        if (!why) return norma_document_fail_memory(document, error);
        snprintf(why, size, "requires %s, which is unknown to this version", required->space);
        unread[i] = (norma_unread){state->parts[required->part].name, why};
    }
    return NORMA_DOCUMENT_OK;
}

/* ---- changing */

static norma_document_result tmf_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error) {
    (void)options, (void)summary;
    return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
        "3MF has no normals: the order of a triangle's vertices says where outward is; check --fix "
        "corrects that");
}

static norma_document_result tmf_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error) {
    (void)options, (void)summary;
    return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
        "a 3MF is not transformed: its build says where objects lie on a printer's bed");
}

static norma_document_result tmf_recentre(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error) {
    (void)document, (void)meshes, (void)changed, (void)error;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result check_edits(
    const norma_document *document, const norma_mesh_edit *edits, norma_document_error *error) {
    for (size_t i = 0; i < tmf_mesh_count(document); ++i)
        if (edits[i].cut_faces || edits[i].set_normals || edits[i].set_positions ||
            edits[i].set_tangents || edits[i].strip_normals || edits[i].source_vertices)
            return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT,
                object_of(document, i)->where,
                "triangles of a 3MF can only be reversed or dropped");
    return NORMA_DOCUMENT_OK;
}

static norma_document_result edit_parts(norma_document *document, const norma_mesh_edit *edits,
    growing_bytes *texts, norma_document_error *error) {
    tmf_state *state = document->state;
    norma_document_result result = NORMA_DOCUMENT_OK;
    state->unpacked = 0;
    for (size_t i = 0; i < state->mesh_count; ++i)
        if (edits[i].drop_faces && object_of(document, i)->has_sets)
            norma_document_add_note(document,
                "%s: no triangle is dropped, because sets name triangles by their numbers",
                object_of(document, i)->where);
    for (size_t i = 0, first = 0; i < state->mesh_count && !result; first = i) {
        const uint32_t part = object_of(document, i)->part; /* those of a part follow each other */
        int any = 0;
        for (; i < state->mesh_count && object_of(document, i)->part == part; ++i)
            any |= edits[i].reverse_faces || edits[i].drop_faces;
        if (any) result = norma_3mf_unpack(document, part, error);
        if (any && !result)
            result =
                norma_3mf_edit_model(document, state->meshes[first], edits, &texts[part], error);
    }
    return result;
}

static norma_document_result tmf_edit(
    norma_document *document, const norma_mesh_edit *edits, norma_document_error *error) {
    const tmf_state *state = document->state;
    const size_t count = state->part_count;
    growing_bytes package = {0}, *texts = norma_io_allocate(count + 1, sizeof *texts);
    norma_document_result result =
        texts ? check_edits(document, edits, error) : norma_document_fail_memory(document, error);
    if (!result) result = norma_3mf_open(document, error);
    if (!result) result = edit_parts(document, edits, texts, error);
    if (!result) result = norma_3mf_pack(document, texts, &package, error);
    norma_3mf_close(document);
    for (size_t i = 0; texts && i < count; ++i) free(texts[i].data);
    free(texts);
    if (!result) return norma_edited_replace(document, &package, error);
    free(package.data);
    return result;
}

static const scene_functions TMF_SCENE = {
    .instance_world = tmf_instance_world, .unread = tmf_unread};

const format_functions norma_3mf_functions = {
    .open = norma_edited_open,
    .close = norma_edited_close,
    .edited = &TMF_EDITED,
    .mesh_count = tmf_mesh_count,
    .mesh_info = tmf_mesh_info,
    .mesh_data = tmf_mesh_data,
    .node_count = tmf_node_count,
    .node_info = tmf_node_info,
    .compute = tmf_compute,
    .transform = tmf_transform,
    .edit = tmf_edit,
    .recentre = tmf_recentre,
    .write = norma_edited_write,
    .scene = &TMF_SCENE,
};
