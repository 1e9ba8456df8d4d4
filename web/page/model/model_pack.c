/* model_pack.c: a document as the block of bytes that the page draws. */
#include "model_pack.h"
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 8 };

/* Room for size bytes at the next multiple of eight: its offset, or 0, and the pack has failed. */
static uint32_t reserve(view_pack *pack, size_t size) {
    const size_t at = (pack->size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    if (pack->failed || size > UINT32_MAX - ALIGNMENT || at > UINT32_MAX - ALIGNMENT - size) {
        pack->failed = 1;
        return 0;
    }
    if (at + size > pack->capacity) {
        const size_t doubled = pack->capacity < UINT32_MAX / 2 ? 2 * pack->capacity : UINT32_MAX,
                     capacity = at + size > doubled ? at + size : doubled;
        unsigned char *bytes = realloc(pack->bytes, capacity);
        if (!bytes) {
            pack->failed = 1;
            return 0;
        }
        pack->bytes = bytes;
        pack->capacity = capacity;
    }
    memset(pack->bytes + pack->size, 0, at + size - pack->size);
    pack->size = at + size;
    return (uint32_t)at;
}

uint32_t view_pack_append(view_pack *pack, const void *bytes, size_t count, size_t size) {
    if (count > UINT32_MAX / size) {
        pack->failed = 1;
        return 0;
    }
    const uint32_t at = reserve(pack, count * size);
    if (!pack->failed && count) memcpy(pack->bytes + at, bytes, count * size);
    return at;
}

/* ---- vectors: floats and doubles as they are, integers as floats, which hold them */

static uint32_t append_vectors(view_pack *pack, const norma_vec3_view *view) {
    const int is_double = view->format == NORMA_FORMAT_DOUBLE;
    const size_t packed = 3 * (is_double ? sizeof(double) : sizeof(float));
    if ((is_double || view->format == NORMA_FORMAT_FLOAT) &&
        (view->stride == 0 || view->stride == packed))
        return view_pack_append(pack, view->data, view->count, packed);
    if (view->count > UINT32_MAX / packed) {
        pack->failed = 1;
        return 0;
    }
    const uint32_t start = reserve(pack, view->count * packed);
    for (size_t i = 0; i < view->count && !pack->failed; ++i) {
        double v[3];
        norma_view_vector(view, i, v);
        const float floats[3] = {(float)v[0], (float)v[1], (float)v[2]};
        memcpy(pack->bytes + start + i * packed, is_double ? (void *)v : (void *)floats, packed);
    }
    return start;
}

static uint32_t append_corners(view_pack *pack, const norma_mesh *mesh) {
    const size_t size = mesh->corner_size ? mesh->corner_size : 4;
    if (!mesh->corners) return VIEW_PACK_NONE;
    if (size == 4) return view_pack_append(pack, mesh->corners, mesh->corner_count, 4);
    if (mesh->corner_count > UINT32_MAX / 4) {
        pack->failed = 1;
        return 0;
    }
    const uint32_t at = reserve(pack, mesh->corner_count * 4);
    for (size_t i = 0; i < mesh->corner_count && !pack->failed; ++i) {
        const uint32_t corner = norma_mesh_corner(mesh, i);
        memcpy(pack->bytes + at + 4 * i, &corner, 4);
    }
    return at;
}

/* ---- meshes */

/* White, seen from both sides, where no material says otherwise. */
static void pack_material(
    norma_document *document, size_t index, view_pack *pack, view_pack_mesh *record) {
    norma_mesh_attributes attributes;
    norma_material_info material;
    for (int i = 0; i < 4; ++i) record->colour[i] = 1;
    record->double_sided = 1;
    norma_document_result result =
        norma_document_mesh_attributes(document, index, &attributes, NULL);
    if (!result && attributes.material == SIZE_MAX) return;
    if (!result) result = norma_document_material_info(document, attributes.material, &material);
    pack->failed |= result == NORMA_DOCUMENT_ERROR_MEMORY;
    if (result) return;
    memcpy(record->colour, material.base_color, sizeof record->colour);
    record->double_sided = material.double_sided != 0;
}

static void pack_mesh(norma_document *document, size_t index, const norma_mesh_info *info,
    const norma_mesh_data *data, view_pack *pack, view_pack_mesh *record) {
    const norma_mesh *mesh = &data->mesh;
    *record = (view_pack_mesh){.position_count = (uint32_t)mesh->positions.count,
        .is_double = mesh->positions.format == NORMA_FORMAT_DOUBLE,
        .corner_count = (uint32_t)mesh->corner_count,
        .face_count = (uint32_t)mesh->face_count,
        .face_starts = VIEW_PACK_NONE,
        .groups = VIEW_PACK_NONE,
        .corner_normals = VIEW_PACK_NONE,
        .storage = data->normals.count ? info->normals : NORMA_NORMALS_NONE};
    pack_material(document, index, pack, record);
    record->positions = append_vectors(pack, &mesh->positions);
    record->corners = append_corners(pack, mesh);
    const size_t faces = mesh->face_starts ? mesh->face_count : record->corner_count / 3;
    if (mesh->face_starts)
        record->face_starts = view_pack_append(pack, mesh->face_starts, mesh->face_count + 1, 4);
    record->face_count = (uint32_t)faces;
    if (mesh->smoothing_groups)
        record->groups = view_pack_append(pack, mesh->smoothing_groups, faces, 4);
    if (record->storage == NORMA_NORMALS_NONE) return;
    record->normal_count = (uint32_t)data->normals.count;
    record->normals = append_vectors(pack, &data->normals);
    if (data->corner_normals)
        record->corner_normals =
            view_pack_append(pack, data->corner_normals, record->corner_count, 4);
}

/* Which record a mesh of the document became, by its number there; made anew of each document. */
typedef struct packing {
    norma_document *document;
    view_pack *pack;
    view_pack_mesh *records;
    uint32_t *record_of, count;
} packing;

static norma_document_result pack_meshes(
    packing *work, size_t mesh_count, view_pack_head *head, norma_document_error *error) {
    for (size_t i = 0; i < mesh_count; ++i) {
        norma_mesh_info info;
        norma_mesh_data data;
        norma_document_result result = norma_document_mesh_info(work->document, i, &info);
        work->record_of[i] = VIEW_PACK_NONE;
        if (result == NORMA_DOCUMENT_OK && (info.not_read || info.faces == 0)) {
            head->unread_count += info.not_read != NULL;
            continue;
        }
        if (result == NORMA_DOCUMENT_OK)
            result = norma_document_mesh_data(work->document, i, &data, error);
        if (result != NORMA_DOCUMENT_OK) return result;
        work->record_of[i] = work->count;
        pack_mesh(work->document, i, &info, &data, work->pack, &work->records[work->count++]);
    }
    return NORMA_DOCUMENT_OK;
}

static void append_draw(
    view_pack *pack, view_pack_head *head, uint32_t mesh, const double world[16]) {
    static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    view_pack_draw draw = {.mesh = mesh};
    memcpy(draw.world, world ? world : identity, sizeof draw.world);
    const uint32_t at = view_pack_append(pack, &draw, 1, sizeof draw);
    if (!head->draw_count++) head->draws = at;
}

/* The records of one node's mesh, at one of its instances. */
static void draw_instance(packing *work, size_t mesh_count, view_pack_head *head,
    const norma_node_info *node, const double world[16]) {
    for (size_t i = 0; i < mesh_count; ++i) {
        norma_mesh_info info;
        if (work->record_of[i] != VIEW_PACK_NONE &&
            norma_document_mesh_info(work->document, i, &info) == NORMA_DOCUMENT_OK &&
            info.mesh == node->mesh)
            append_draw(work->pack, head, work->record_of[i], world);
    }
}

/* Every node's mesh where its instances stand; in files without nodes, what there is where it is.
 */
static norma_document_result pack_draws(
    packing *work, size_t mesh_count, view_pack_head *head, norma_document_error *error) {
    const size_t nodes = norma_document_node_count(work->document);
    for (size_t n = 0; n < nodes; ++n) {
        norma_node_info node;
        norma_document_result result = norma_document_node_info(work->document, n, &node);
        for (size_t i = 0; i < node.instances && result == NORMA_DOCUMENT_OK && !work->pack->failed;
             ++i) {
            double world[16];
            result = norma_document_instance_world(work->document, n, i, world, error);
            if (result == NORMA_DOCUMENT_OK) draw_instance(work, mesh_count, head, &node, world);
        }
        if (result != NORMA_DOCUMENT_OK) return result;
    }
    if (!nodes)
        for (uint32_t i = 0; i < work->count; ++i) append_draw(work->pack, head, i, NULL);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result pack_all(
    packing *work, size_t mesh_count, uint32_t threads, norma_document_error *error) {
    view_pack_head head = {
        .magic = VIEW_PACK_MAGIC, .format = (uint32_t)norma_document_format(work->document)};
    reserve(work->pack, sizeof head);
    norma_document_result result = pack_meshes(work, mesh_count, &head, error);
    if (result == NORMA_DOCUMENT_OK) result = pack_draws(work, mesh_count, &head, error);
    if (result == NORMA_DOCUMENT_OK)
        result =
            view_pack_findings(work->document, work->record_of, threads, work->pack, &head, error);
    head.mesh_count = work->count;
    head.meshes = view_pack_append(work->pack, work->records, work->count, sizeof *work->records);
    head.size = (uint32_t)work->pack->size;
    if (!work->pack->failed) memcpy(work->pack->bytes, &head, sizeof head);
    return result;
}

norma_document_result view_pack_document(
    norma_document *document, uint32_t threads, view_pack *pack, norma_document_error *error) {
    const size_t count = norma_document_mesh_count(document);
    packing work = {.document = document,
        .pack = pack,
        .records = calloc(count + 1, sizeof *work.records),
        .record_of = calloc(count + 1, sizeof *work.record_of)};
    *pack = (view_pack){.failed = !work.records || !work.record_of};
    norma_document_result result =
        pack->failed ? NORMA_DOCUMENT_ERROR_MEMORY : pack_all(&work, count, threads, error);
    free(work.records);
    free(work.record_of);
    if (result == NORMA_DOCUMENT_OK && pack->failed) result = NORMA_DOCUMENT_ERROR_MEMORY;
    if (result == NORMA_DOCUMENT_OK) return result;
    if (error && !error->message[0])
        strcpy(error->message, "out of memory, or more than the page holds");
    free(pack->bytes);
    pack->bytes = NULL;
    return result;
}
