/* gltf.c: a glTF document as a format: its container (text, or GLB 2.0 with its chunks), what it
 * requires, and its table of functions. */
#include "io/gltf/gltf.h"
#include "io/gltf/draco_decoder.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { GLB_HEADER = 12, GLB_CHUNK_HEADER = 8 };
static const uint32_t GLB_MAGIC = 0x46546C67, GLB_JSON = 0x4E4F534A, GLB_BIN = 0x004E4942;

static norma_document_result fail_glb(
    const gltf *g, norma_document_error *error, size_t byte, const char *expected) {
    char place[40], found[40] = "the end of the file";
    const unsigned char *at = g->document->source.data + g->tile.at + byte;
    snprintf(place, sizeof place, "byte %zu", g->tile.at + byte);
    for (size_t i = 0; i < GLB_CHUNK_HEADER && i < g->tile.end - g->tile.at - byte; ++i)
        snprintf(found + 3 * i, sizeof found - 3 * i, " %02X", at[i]);
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, place,
        "expected %s; found %s", expected, found + (found[0] == ' '));
}

/* Chunks behind the JSON: the first BIN is the buffer without a uri; all others are kept as they
 * are. */
static norma_document_result read_glb_chunks(gltf *g, size_t end, norma_document_error *error) {
    const unsigned char *bytes = g->document->source.data + g->tile.at;
    size_t at = GLB_HEADER;
    for (uint32_t i = 0; at < end; ++i) {
        if (end - at < GLB_CHUNK_HEADER)
            return fail_glb(g, error, at, "the 8 bytes of a chunk's header");
        size_t length = norma_gltf_u32(bytes + at);
        uint32_t type = norma_gltf_u32(bytes + at + 4);
        if (length > end - at - GLB_CHUNK_HEADER)
            return fail_glb(
                g, error, at, "a chunk that ends within the length that the header declares");
        if ((i == 0) != (type == GLB_JSON))
            return fail_glb(g, error, at, i == 0 ? "a JSON chunk first" : "one JSON chunk");
        if (i == 0) {
            g->text = (const char *)bytes + at + GLB_CHUNK_HEADER;
            g->text_size = length;
        } else if (type == GLB_BIN) {
            if (g->bin) return fail_glb(g, error, at, "one BIN chunk");
            g->bin = bytes + at + GLB_CHUNK_HEADER;
            g->bin_size = length;
            g->bin_chunk = at;
        }
        at += GLB_CHUNK_HEADER + length;
    }
    return g->text ? NORMA_DOCUMENT_OK : fail_glb(g, error, at, "a JSON chunk");
}

static norma_document_result read_glb(gltf *g, norma_document_error *error) {
    norma_document_result result = norma_gltf_find_tile(g, error);
    if (result) return result;
    const unsigned char *bytes = g->document->source.data + g->tile.at;
    const size_t size = g->tile.end - g->tile.at;
    char place[40];
    if (size < GLB_HEADER || norma_gltf_u32(bytes) != GLB_MAGIC)
        return fail_glb(g, error, 0, "the 12 bytes of a GLB header, \"glTF\" first");
    uint32_t version = norma_gltf_u32(bytes + 4), length = norma_gltf_u32(bytes + 8);
    snprintf(place, sizeof place, "byte %zu", g->tile.at + (version == 2 ? 8 : 4));
    if (version != 2)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, place,
            "this is GLB version %u; only version 2 can be read", (unsigned)version);
    if (length > size)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, place,
            "the header declares %u bytes, but the %s has only %zu", (unsigned)length,
            g->tile.depth ? "tile" : "file", size);
    g->container_size = length;
    if (norma_gltf_surplus(g))
        norma_document_add_note(g->document,
            "%zu bytes follow the %u that the header declares; they are kept, not read",
            size - length, (unsigned)length);
    return read_glb_chunks(g, length, error);
}

static norma_document_result parse_text(gltf *g, norma_document_error *error) {
    json_error wrong;
    if (norma_json_parse(
            g->text, g->text_size, norma_document_watch(g->document), &g->json, &wrong))
        return norma_json_is(&g->json, 0, JSON_OBJECT)
                   ? NORMA_DOCUMENT_OK
                   : norma_gltf_malformed(g, error, 0, "an object");
    if (!wrong.expected) return norma_document_fail_memory(g->document, error);
    char place[40], found[24] = "the end of the text";
    const unsigned char *at = (const unsigned char *)g->text + wrong.byte;
    snprintf(place, sizeof place, "byte %zu", (size_t)(at - g->document->source.data));
    if (wrong.byte < g->text_size)
        snprintf(found, sizeof found, *at > ' ' && *at < 127 ? "%c" : "the byte %02X", *at);
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, place,
        "is not JSON: expected %s; found %s", wrong.expected, found);
}

/* "2.0" or "2.1" in a version string. */
static int is_version_2(const gltf *g, uint32_t token) {
    const json_token *t = &g->json.tokens[token];
    return t->type == JSON_STRING && t->end - t->start >= 5 && g->text[t->start + 1] == '2' &&
           g->text[t->start + 2] == '.';
}

static norma_document_result check_version(const gltf *g, norma_document_error *error) {
    uint32_t version =
        norma_json_member(&g->json, norma_json_member(&g->json, 0, "asset"), "version");
    if (version == JSON_NONE)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED,
            "/asset/version", "the version is missing; every glTF file has one");
    if (!is_version_2(g, version))
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            "/asset/version", "is not version 2; only glTF 2.0 can be read");
    if (norma_gltf_needs_later(g) && !g->document->lenient)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            "/asset/minVersion",
            "needs a later version of glTF than 2.0, the only one that can be read here");
    return NORMA_DOCUMENT_OK;
}

/* A compression that a file requires and that cannot be read here; NULL for other extensions. */
static const char *why_not_required(const char *name) {
    if (!norma_draco_reads() && strcmp(name, GLTF_DRACO) == 0) return norma_draco_missing(0);
    if (!norma_gltf_reads_meshopt() && (strcmp(name, "EXT_meshopt_compression") == 0 ||
                                           strcmp(name, "KHR_meshopt_compression") == 0))
        return "needs meshoptimizer, which this Norma was built without; save the meshes without "
               "compression";
    return NULL;
}

static norma_document_result check_required(const gltf *g, norma_document_error *error) {
    const json *j = &g->json;
    uint32_t list = norma_json_member(j, 0, "extensionsRequired");
    if (list != JSON_NONE && !norma_json_is(j, list, JSON_ARRAY))
        return norma_gltf_malformed(g, error, list, "an array");
    for (uint32_t item = JSON_NONE; norma_json_each(j, list, &item);) {
        if (!norma_json_is(j, item, JSON_STRING))
            return norma_gltf_malformed(g, error, item, "the name of an extension");
        char *name = norma_json_string(j, item);
        if (!name) return norma_document_fail_memory(g->document, error);
        const char *why = why_not_required(name);
        int known = why ? g->document->depth == NORMA_DOCUMENT_SUMMARY : norma_gltf_is_known(name);
        norma_document_result result = NORMA_DOCUMENT_OK;
        if (!known && !g->document->lenient)
            result = norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
                "/extensionsRequired", "requires %s, which %s", name,
                why ? why : "is unknown to this version");
        free(name);
        if (result) return result;
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result gltf_open(norma_document *document, norma_document_error *error) {
    gltf *g = norma_io_allocate(1, sizeof *g);
    if (!g) return norma_document_fail_memory(document, error);
    document->state = g;
    g->document = document;
    g->text = (const char *)document->source.data;
    g->text_size = document->source.size;
    g->held = document->source.size;
    g->tile.end = document->source.size;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (document->format != NORMA_FILE_GLTF) {
        g->text = NULL;
        result = read_glb(g, error);
    }
    if (!result) result = parse_text(g, error);
    norma_document_result (*const steps[])(gltf *, norma_document_error *) = {
        norma_gltf_read_buffers, norma_gltf_read_accessors, norma_gltf_read_meshes,
        norma_gltf_read_nodes};
    if (!result) result = check_version(g, error);
    if (!result) result = check_required(g, error);
    for (size_t i = 0; !result && i < sizeof steps / sizeof steps[0]; ++i)
        result = steps[i](g, error);
    if (!result && !(g->edits = norma_json_edits_create(&g->json, 0)))
        result = norma_document_fail_memory(document, error);
    return result;
}

static void gltf_close(norma_document *document) {
    gltf *g = norma_gltf_of(document);
    if (!g) return;
    norma_gltf_patch_free(g);
    norma_json_edits_destroy(g->edits);
    for (uint32_t i = 0; g->buffers && i < g->buffer_count; ++i) {
        free(g->buffers[i].name);
        free(g->buffers[i].owned);
        norma_file_close(&g->buffers[i].file);
    }
    for (uint32_t i = 0; g->views && i < g->view_count; ++i) free(g->views[i].decoded);
    for (uint32_t i = 0; g->accessors && i < g->accessor_count; ++i) free(g->accessors[i].owned);
    for (uint32_t i = 0; g->meshes && i < g->mesh_count; ++i) free(g->meshes[i].name);
    for (uint32_t i = 0; g->primitives && i < g->primitive_count; ++i) {
        free(g->primitives[i].corners);
        free(g->primitives[i].corner_normals);
    }
    for (uint32_t i = 0; g->attributes && i < g->attribute_count; ++i) free(g->attributes[i].name);
    for (uint32_t i = 0; g->nodes && i < g->node_count; ++i) free(g->nodes[i].name);
    void *const blocks[] = {g->buffers, g->views, g->accessors, g->meshes, g->primitives,
        g->targets, g->attributes, g->nodes, g->drawing};
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; ++i) free(blocks[i]);
    norma_json_free(&g->json);
    free(g);
    document->state = NULL;
}

/* ---- what is in it */

static size_t gltf_mesh_count(const norma_document *document) {
    return norma_gltf_of(document)->primitive_count;
}

static const char *compression_of_view(const gltf *g, uint32_t accessor) {
    const uint32_t view = g->accessors[accessor].view;
    return view == GLTF_NONE || g->views[view].meshopt.token == GLTF_NONE
               ? NULL
               : norma_gltf_extension_of(g, &g->views[view].meshopt);
}

static const char *compression_of(const gltf *g, const gltf_primitive *p) {
    if (p->draco.token != GLTF_NONE) return GLTF_DRACO;
    const char *name = p->indices == GLTF_NONE ? NULL : compression_of_view(g, p->indices);
    for (uint32_t t = 0; t <= p->target_count && !name; ++t) {
        const gltf_attributes *set = t ? &g->targets[p->first_target + t - 1] : &p->base;
        for (uint32_t i = 0; i < set->count && !name; ++i)
            name = compression_of_view(g, g->attributes[set->first + i].accessor);
    }
    return name;
}

static norma_document_result gltf_mesh_info(
    const norma_document *document, size_t index, norma_mesh_info *info) {
    const gltf *g = norma_gltf_of(document);
    const gltf_primitive *p = &g->primitives[index];
    *info = (norma_mesh_info){
        .name = g->meshes[p->mesh].name,
        .where = p->where,
        .mesh = p->mesh,
        .primitive = p->number,
        .vertices = p->vertices,
        .faces = p->faces,
        .triangles = p->faces,
        .normals = p->base.normal == GLTF_NONE ? NORMA_NORMALS_NONE : NORMA_NORMALS_PER_VERTEX,
        .encoding = norma_gltf_encoding_name(g, p->base.normal),
        .has_tangents = p->base.tangent != GLTF_NONE,
        .morph_targets = p->target_count,
        .compression = compression_of(g, p),
        .not_read = p->not_read,
    };
    return NORMA_DOCUMENT_OK;
}

static size_t node_count(const norma_document *document) {
    return norma_gltf_of(document)->drawing_count;
}

static norma_document_result node_info(
    const norma_document *document, size_t index, norma_node_info *info) {
    const gltf *g = norma_gltf_of(document);
    const gltf_node *node = &g->nodes[g->drawing[index]];
    *info = (norma_node_info){.name = node->name,
        .node = g->drawing[index],
        .mesh = node->mesh,
        .instances = node->instances};
    memcpy(info->world, node->world, sizeof info->world);
    return norma_gltf_describe_node(document, index, info);
}

const format_functions norma_gltf_functions = {
    .open = gltf_open,
    .close = gltf_close,
    .mesh_count = gltf_mesh_count,
    .mesh_info = gltf_mesh_info,
    .mesh_data = norma_gltf_mesh_data,
    .node_count = node_count,
    .node_info = node_info,
    .compute = norma_gltf_compute,
    .tangents = norma_gltf_tangents,
    .pack = norma_gltf_pack,
    .transform = norma_gltf_transform,
    .edit = norma_gltf_edit,
    .equal_vertices = norma_gltf_equal_vertices,
    .recentre = norma_gltf_recentre,
    .turn_green = norma_gltf_turn_green,
    .write = norma_gltf_write,
    .write_companions = norma_gltf_write_companions,
    .changed_companion = norma_gltf_changed_companion,
    .has_change = norma_gltf_has_change,
    .reopen = norma_gltf_reopen,
    .adopt = norma_gltf_adopt,
    .drop_change = norma_gltf_drop_change,
    .visit_files = norma_gltf_visit_files,
    .scene = &norma_gltf_scene,
};
