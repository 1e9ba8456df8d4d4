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

static void pack_mesh(const norma_mesh_info *info, const norma_mesh_data *data, view_pack *pack,
    view_pack_mesh *record) {
    const norma_mesh *mesh = &data->mesh;
    *record = (view_pack_mesh){.position_count = (uint32_t)mesh->positions.count,
        .is_double = mesh->positions.format == NORMA_FORMAT_DOUBLE,
        .corner_count = (uint32_t)mesh->corner_count,
        .face_count = (uint32_t)mesh->face_count,
        .face_starts = VIEW_PACK_NONE,
        .groups = VIEW_PACK_NONE,
        .corner_normals = VIEW_PACK_NONE,
        .storage = data->normals.count ? info->normals : NORMA_NORMALS_NONE};
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

/* ---- fewer triangles */

static uint32_t append_some(
    view_pack *pack, const norma_vec3_view *view, const view_decimated *decimated) {
    const int is_double = view->format == NORMA_FORMAT_DOUBLE;
    const size_t size = 3 * (is_double ? sizeof(double) : sizeof(float));
    const uint32_t start = reserve(pack, decimated->vertex_count * size);
    for (size_t i = 0; i < decimated->vertex_count && !pack->failed; ++i) {
        double v[3];
        norma_view_vector(view, decimated->vertices[i], v);
        const float floats[3] = {(float)v[0], (float)v[1], (float)v[2]};
        memcpy(pack->bytes + start + i * size, is_double ? (void *)v : (void *)floats, size);
    }
    return start;
}

/* Normals per corner or facet are left out: the page computes them. */
static void pack_decimated(const norma_mesh_info *info, const norma_mesh_data *data,
    const view_decimated *decimated, view_pack *pack, view_pack_mesh *record) {
    const int has_normals =
        info->normals == NORMA_NORMALS_PER_VERTEX && data->normals.count && !data->corner_normals;
    *record = (view_pack_mesh){.position_count = (uint32_t)decimated->vertex_count,
        .is_double = data->mesh.positions.format == NORMA_FORMAT_DOUBLE,
        .corner_count = (uint32_t)decimated->corner_count,
        .face_count = (uint32_t)(decimated->corner_count / 3),
        .face_starts = VIEW_PACK_NONE,
        .groups = VIEW_PACK_NONE,
        .corner_normals = VIEW_PACK_NONE,
        .storage = has_normals ? NORMA_NORMALS_PER_VERTEX : NORMA_NORMALS_NONE,
        .normal_count = has_normals ? (uint32_t)decimated->vertex_count : 0,
        .decimated = 1};
    record->positions = append_some(pack, &data->mesh.positions, decimated);
    record->corners = view_pack_append(pack, decimated->corners, decimated->corner_count, 4);
    if (has_normals) record->normals = append_some(pack, &data->normals, decimated);
}

/* Which record a mesh of the document became, by its number there; made anew of each document. */
typedef struct packing {
    norma_document *document;
    const view_pack_options *options;
    size_t triangles; /* of all meshes */
    view_pack *pack;
    view_pack_mesh *records;
    uint32_t *record_of, count, capacity;
    uint8_t *drawn;         /* of each record: whether it was drawn */
    uint32_t *draw_of_node; /* of each node its first draw, or VIEW_PACK_NONE */
    view_pack_draw *draws;
    uint32_t draw_count, draw_capacity;
} packing;

/* Of a mesh that is too large its share, as one that is not moved and made of triangles alone. */
static int decimate(const packing *work, const norma_mesh_info *info, const norma_mesh_data *data,
    view_decimated *decimated) {
    const size_t most = work->options->most_triangles;
    *decimated = (view_decimated){0};
    if (!most || work->triangles <= most || data->mesh.face_starts || info->morph_targets) return 1;
    const double share = (double)most / (double)work->triangles;
    return work->options->decimate(
        &data->mesh, (size_t)(share * (double)info->triangles) + 1, decimated);
}

static norma_document_result pack_one(
    packing *work, size_t index, const norma_mesh_info *info, norma_document_error *error) {
    norma_mesh_data data;
    view_decimated decimated;
    const norma_document_result result =
        norma_document_mesh_data(work->document, index, &data, error);
    if (result) return result;
    view_pack_mesh *record = &work->records[work->count];
    work->pack->failed |= !decimate(work, info, &data, &decimated);
    if (decimated.corners)
        pack_decimated(info, &data, &decimated, work->pack, record);
    else
        pack_mesh(info, &data, work->pack, record);
    work->record_of[index] = work->count++;
    const norma_document_result dressed =
        view_pack_material(work->document, index, decimated.vertices, work->pack, record, error);
    free(decimated.vertices);
    free(decimated.corners);
    return dressed;
}

static size_t count_triangles(norma_document *document) {
    size_t triangles = 0;
    norma_mesh_info info;
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i)
        if (!norma_document_mesh_info(document, i, &info)) triangles += info.triangles;
    return triangles;
}

static norma_document_result pack_meshes(
    packing *work, size_t mesh_count, view_pack_head *head, norma_document_error *error) {
    for (size_t i = 0; i < mesh_count; ++i) {
        norma_mesh_info info;
        norma_document_result result = norma_document_mesh_info(work->document, i, &info);
        work->record_of[i] = VIEW_PACK_NONE;
        if (result == NORMA_DOCUMENT_OK && (info.not_read || info.faces == 0)) {
            head->unread_count += info.not_read != NULL;
            continue;
        }
        if (result == NORMA_DOCUMENT_OK) result = pack_one(work, i, &info, error);
        if (result != NORMA_DOCUMENT_OK) return result;
    }
    return NORMA_DOCUMENT_OK;
}

/* world: NULL: the identity. */
static void append_draw(packing *work, uint32_t mesh, const double world[16]) {
    static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    if (work->draw_count == work->draw_capacity) {
        const size_t capacity = 2 * (size_t)work->draw_capacity + 16;
        view_pack_draw *grown =
            capacity < UINT32_MAX ? realloc(work->draws, capacity * sizeof *work->draws) : NULL;
        work->pack->failed |= !grown;
        if (!grown) return;
        work->draws = grown;
        work->draw_capacity = (uint32_t)capacity;
    }
    view_pack_draw *draw = &work->draws[work->draw_count++];
    *draw = (view_pack_draw){.mesh = mesh};
    memcpy(draw->world, world ? world : identity, sizeof draw->world);
}

/* ---- where meshes stand, as a viewer of the format draws them at rest */

/* A mesh that morph targets or a skin move has its moved positions and normals in its record, so
 * that what is found in it is shown there; drawn by further nodes, it gets a record for each. 0:
 * more records than there is room for. */
static int pack_moved(packing *work, uint32_t *record, const norma_drawn_mesh *drawn) {
    if (work->drawn[*record]) {
        if (work->count == work->capacity) return 0;
        work->records[work->count] = work->records[*record];
        *record = work->count++;
    }
    view_pack_mesh *moved = &work->records[*record];
    moved->is_double = drawn->positions.format == NORMA_FORMAT_DOUBLE;
    moved->positions = append_vectors(work->pack, &drawn->positions);
    if (moved->storage != NORMA_NORMALS_NONE && drawn->normals.count == moved->normal_count)
        moved->normals = append_vectors(work->pack, &drawn->normals);
    if (moved->tangents != VIEW_PACK_NONE && drawn->tangents)
        moved->tangents =
            view_pack_append(work->pack, drawn->tangents, moved->position_count, 4 * sizeof(float));
    return 1;
}

/* A mesh that cannot be moved as the file says, which norma check reports, stands as it is stored.
 */
static norma_document_result find_drawn(packing *work, size_t node, size_t instance, size_t mesh,
    norma_drawn_mesh *drawn, norma_document_error *error) {
    const norma_document_result result =
        norma_document_drawn_mesh(work->document, node, instance, mesh, drawn, error);
    if (!result || result == NORMA_DOCUMENT_ERROR_MEMORY || result == NORMA_DOCUMENT_CANCELLED)
        return result;
    *drawn = (norma_drawn_mesh){.shown = 1};
    return norma_document_instance_world(work->document, node, instance, drawn->world, error);
}

/* The records of a node's mesh, each at its instances. */
static norma_document_result draw_mesh(
    packing *work, size_t node, size_t instances, size_t mesh, norma_document_error *error) {
    uint32_t record = work->record_of[mesh];
    norma_drawn_mesh drawn;
    for (size_t i = 0; i < instances && !work->pack->failed; ++i) {
        const norma_document_result result = find_drawn(work, node, i, mesh, &drawn, error);
        if (result) return result;
        if (!drawn.shown || (drawn.skinned && i > 0)) continue;
        if (drawn.moved && i == 0 && !work->records[record].decimated &&
            !pack_moved(work, &record, &drawn))
            return NORMA_DOCUMENT_OK;
        work->drawn[record] = 1;
        append_draw(work, record, drawn.world);
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result draw_node(packing *work, size_t node, norma_document_error *error) {
    norma_node_info info;
    norma_document_result result = norma_document_node_info(work->document, node, &info);
    work->draw_of_node[node] = VIEW_PACK_NONE;
    for (size_t i = info.first_mesh; i < info.first_mesh + info.mesh_count && !result; ++i) {
        if (work->record_of[i] == VIEW_PACK_NONE) continue;
        const uint32_t before = work->draw_count;
        result = draw_mesh(work, node, info.instances, i, error);
        if (work->draw_of_node[node] == VIEW_PACK_NONE && work->draw_count > before)
            work->draw_of_node[node] = before;
    }
    return result;
}

/* Every node's mesh where its instances stand; in files without nodes, what there is where it is.
 */
static norma_document_result pack_draws(
    packing *work, view_pack_head *head, norma_document_error *error) {
    const size_t nodes = norma_document_node_count(work->document);
    for (size_t n = 0; n < nodes; ++n) {
        const norma_document_result result = draw_node(work, n, error);
        if (result) return result;
    }
    if (!nodes)
        for (uint32_t i = 0; i < work->count; ++i) append_draw(work, i, NULL);
    head->draw_count = work->draw_count;
    head->draws = view_pack_append(work->pack, work->draws, work->draw_count, sizeof *work->draws);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result pack_all(
    packing *work, size_t mesh_count, norma_document_error *error) {
    view_pack_head head = {
        .magic = VIEW_PACK_MAGIC, .format = (uint32_t)norma_document_format(work->document)};
    reserve(work->pack, sizeof head);
    norma_document_result result = pack_meshes(work, mesh_count, &head, error);
    if (result == NORMA_DOCUMENT_OK) result = pack_draws(work, &head, error);
    head.finding_count = VIEW_PACK_NONE;
    if (result == NORMA_DOCUMENT_OK && !work->options->unchecked)
        result = view_pack_findings(work->document, work->record_of, work->draw_of_node,
            work->records, work->options->threads, work->pack, &head, error);
    head.mesh_count = work->count;
    head.meshes = view_pack_append(work->pack, work->records, work->count, sizeof *work->records);
    head.size = (uint32_t)work->pack->size;
    if (!work->pack->failed) memcpy(work->pack->bytes, &head, sizeof head);
    return result;
}

/* Of every mesh, and of each that a further node moves. */
static size_t room_for_records(norma_document *document) {
    size_t room = norma_document_mesh_count(document);
    for (size_t n = 0; n < norma_document_node_count(document); ++n) {
        norma_node_info node;
        norma_mesh_info mesh;
        if (norma_document_node_info(document, n, &node)) continue;
        for (size_t i = node.first_mesh; i < node.first_mesh + node.mesh_count; ++i)
            if (!norma_document_mesh_info(document, i, &mesh))
                room += node.skin != SIZE_MAX || mesh.morph_targets > 0;
    }
    return room < UINT32_MAX ? room : UINT32_MAX - 1;
}

norma_document_result view_pack_document(norma_document *document, const view_pack_options *options,
    view_pack *pack, norma_document_error *error) {
    const size_t count = norma_document_mesh_count(document),
                 nodes = norma_document_node_count(document), records = room_for_records(document);
    packing work = {.document = document,
        .options = options,
        .triangles = count_triangles(document),
        .pack = pack,
        .records = calloc(records + 1, sizeof *work.records),
        .record_of = calloc(count + 1, sizeof *work.record_of),
        .capacity = (uint32_t)records,
        .drawn = calloc(records + 1, 1),
        .draw_of_node = calloc(nodes + 1, sizeof *work.draw_of_node)};
    *pack = (view_pack){
        .failed = !work.records || !work.record_of || !work.drawn || !work.draw_of_node};
    norma_document_result result =
        pack->failed ? NORMA_DOCUMENT_ERROR_MEMORY : pack_all(&work, count, error);
    free(work.records);
    free(work.record_of);
    free(work.drawn);
    free(work.draw_of_node);
    free(work.draws);
    if (result == NORMA_DOCUMENT_OK && pack->failed) result = NORMA_DOCUMENT_ERROR_MEMORY;
    if (result == NORMA_DOCUMENT_OK) return result;
    if (error && !error->message[0])
        strcpy(error->message, "out of memory, or more than the page holds");
    free(pack->bytes);
    pack->bytes = NULL;
    return result;
}
