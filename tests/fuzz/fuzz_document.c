/* fuzz_document.c: asks a document for everything that its public header lets one ask, and touches
 * every number of every array that it hands out, so that the address sanitizer sees what lies
 * outside; and judges whether the answers agree with each other. */
#include "fuzz.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static volatile unsigned sink; /* what is read is used */

static void touch(const void *data, size_t size) {
    const unsigned char *bytes = data;
    unsigned sum = 0;
    for (size_t i = 0; i < size; ++i) sum += bytes[i];
    sink += sum;
}

static void touch_text(const char *text) {
    if (!text) fuzz_fail("a text that is NULL");
    touch(text, strlen(text));
}

static void touch_view(const norma_vec3_view *view) {
    static const size_t sizes[] = {4, 8, 1, 1, 2, 2};
    const size_t size = 3 * sizes[view->format], stride = view->stride ? view->stride : size;
    for (size_t i = 0; i < view->count; ++i) touch((const char *)view->data + i * stride, size);
}

/* Each corner names a position that is there, faces run from 0 to the end. */
static void read_mesh(const norma_mesh *mesh, const norma_mesh_info *info) {
    const size_t faces = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
    touch_view(&mesh->positions);
    if (mesh->positions.count != info->vertices || faces != info->faces)
        fuzz_fail("%zu positions, %zu faces; the info says %zu, %zu", mesh->positions.count, faces,
            info->vertices, info->faces);
    for (size_t f = 0; mesh->face_starts && f < faces; ++f)
        if (mesh->face_starts[f] > mesh->face_starts[f + 1] ||
            mesh->face_starts[f + 1] > mesh->corner_count)
            fuzz_fail("face %zu begins behind its end", f);
    for (size_t c = 0; c < mesh->corner_count; ++c) {
        size_t position = c;
        if (mesh->corners && mesh->corner_size == 1)
            position = ((const uint8_t *)mesh->corners)[c];
        else if (mesh->corners && mesh->corner_size == 2)
            position = ((const uint16_t *)mesh->corners)[c];
        else if (mesh->corners)
            position = ((const uint32_t *)mesh->corners)[c];
        if (position >= mesh->positions.count)
            fuzz_fail("corner %zu names position %zu of %zu", c, position, mesh->positions.count);
    }
    if (mesh->smoothing_groups)
        touch(mesh->smoothing_groups, faces * sizeof *mesh->smoothing_groups);
    if (mesh->hard_edges) touch(mesh->hard_edges, mesh->corner_count);
}

static void read_attributes(norma_document *document, size_t index, const norma_mesh_data *data) {
    norma_mesh_attributes a;
    if (norma_document_mesh_attributes(document, index, &a, NULL)) return;
    const size_t vertices = data->mesh.positions.count, faces = data->mesh.face_starts
                                                                    ? data->mesh.face_count
                                                                    : data->mesh.corner_count / 3;
    if (a.material != SIZE_MAX && a.material >= norma_document_material_count(document))
        fuzz_fail("material %zu is not there", a.material);
    for (size_t f = 0; a.face_materials && f < faces; ++f)
        if (a.face_materials[f] != UINT32_MAX &&
            a.face_materials[f] >= norma_document_material_count(document))
            fuzz_fail("material %u of face %zu is not there", (unsigned)a.face_materials[f], f);
    if (a.texcoords) touch(a.texcoords, a.texcoord_count * 2 * sizeof(float));
    for (size_t c = 0; a.corner_texcoords && c < data->mesh.corner_count; ++c)
        if (a.corner_texcoords[c] != UINT32_MAX && a.corner_texcoords[c] >= a.texcoord_count)
            fuzz_fail("corner %zu names UV %u of %zu", c, (unsigned)a.corner_texcoords[c],
                a.texcoord_count);
    if (a.colors) touch(a.colors, vertices * 4 * sizeof(float));
    if (a.tangents) touch(a.tangents, a.tangent_count * 4 * sizeof(float));
    if (a.face_faults) touch(a.face_faults, faces);
    touch_text(a.tangent_encoding);
    touch_text(a.ignore);
}

static void read_morphs(norma_document *document, size_t index, size_t targets) {
    for (size_t t = 0; t < targets && t < 8; ++t) {
        norma_morph_data morph;
        if (norma_document_morph_data(document, index, t, &morph, NULL)) continue;
        touch_view(&morph.positions);
        touch_view(&morph.normals);
        touch_view(&morph.tangents);
    }
}

static void read_meshes(norma_document *document) {
    size_t count = norma_document_mesh_count(document);
    for (size_t i = 0; i < count; ++i) {
        norma_mesh_info info;
        norma_mesh_data data;
        norma_document_error error;
        if (norma_document_mesh_info(document, i, &info))
            fuzz_fail("mesh %zu of %zu has no info", i, count);
        touch_text(info.name);
        touch_text(info.where);
        touch_text(info.encoding);
        if (norma_document_mesh_data(document, i, &data, &error)) {
            touch_text(error.message);
            continue;
        }
        read_mesh(&data.mesh, &info);
        touch_view(&data.normals);
        for (size_t c = 0; data.corner_normals && c < data.mesh.corner_count; ++c)
            if (data.corner_normals[c] != UINT32_MAX &&
                data.corner_normals[c] >= data.normals.count)
                fuzz_fail("corner %zu names normal %u of %zu", c, (unsigned)data.corner_normals[c],
                    data.normals.count);
        read_attributes(document, i, &data);
        read_morphs(document, i, info.morph_targets);
    }
}

/* What a node draws, by definition: the primitives whose mesh is the node's, and no other. */
static void judge_meshes_of(norma_document *document, const norma_node_info *node) {
    norma_mesh_info mesh;
    for (size_t i = 0; i < norma_document_mesh_count(document) && i < 4096; ++i)
        if (!norma_document_mesh_info(document, i, &mesh) &&
            (mesh.mesh == node->mesh) != (i - node->first_mesh < node->mesh_count))
            fuzz_fail("%s: mesh %zu is drawn, or is not", node->where, i);
}

static void read_nodes(norma_document *document) {
    for (size_t i = 0; i < norma_document_node_count(document); ++i) {
        norma_node_info node;
        double world[16];
        if (norma_document_node_info(
                document, i, &node)) /* its instances may lie in a file that is not here */
            continue;
        if (i < 256) judge_meshes_of(document, &node);
        touch_text(node.name);
        touch_text(node.where);
        touch_text(node.path);
        touch_text(node.ignore);
        for (size_t instance = 0; instance < node.instances && instance < 4; ++instance)
            (void)norma_document_instance_world(document, i, instance, world, NULL);
    }
}

static void read_others(norma_document *document) {
    for (size_t i = 0; i < norma_document_note_count(document); ++i)
        touch_text(norma_document_note(document, i));
    for (size_t i = 0; i < norma_document_material_count(document); ++i) {
        norma_material_info material;
        if (norma_document_material_info(document, i, &material)) continue;
        touch_text(material.name);
        touch_text(material.where);
        touch_text(material.ignore);
    }
    for (size_t i = 0; i < norma_document_skin_count(document); ++i) {
        norma_skin_info skin;
        if (norma_document_skin_info(document, i, &skin, NULL)) continue;
        touch_text(skin.name);
        touch_text(skin.where);
        touch_text(skin.ignore);
        if (isnan(skin.anisotropy)) fuzz_fail("skin %zu: an anisotropy that is no number", i);
    }
    for (size_t i = 0; i < norma_document_unread_count(document); ++i) {
        norma_unread unread;
        if (norma_document_unread(document, i, &unread)) continue;
        touch_text(unread.where);
        touch_text(unread.why);
    }
}

void fuzz_read_all(norma_document *document) {
    read_meshes(document);
    read_nodes(document);
    read_others(document);
}

static norma_document_result open_and_read(
    const uint8_t *bytes, size_t size, const norma_document_options *options) {
    norma_document *document;
    norma_document_error error;
    norma_document_result result =
        norma_document_open_memory(bytes, size, NULL, options, &document, &error);
    if (result) {
        if (document || error.result != result || !error.message[0] || strchr(error.message, '\n'))
            fuzz_fail("result %d with the message \"%s\"", (int)result, error.message);
        return result;
    }
    fuzz_read_all(document);
    norma_document_close(document);
    return result;
}

int fuzz_reader(const uint8_t *bytes, size_t size, norma_file_format format) {
    norma_document_options options = {.struct_size = sizeof options,
        .format = format,
        .depth = NORMA_DOCUMENT_SUMMARY,
        .threads = 1};
    const int shares = format == NORMA_FILE_GLTF || format == NORMA_FILE_GLB ||
                       format == NORMA_FILE_3MF; /* elements share bytes, a zip unpacks to more */
    shares ? fuzz_meter_begin(size) : fuzz_meter_begin_plain(size);
    (void)open_and_read(bytes, size, &options);
    options.depth = NORMA_DOCUMENT_WHOLE;
    norma_document_result strict = open_and_read(bytes, size, &options);
    options.lenient = 1;
    norma_document_result lenient = open_and_read(bytes, size, &options);
    if (!strict && lenient)
        fuzz_fail("a file that is read is refused where more is let pass: %d", (int)lenient);
    fuzz_meter_end();
    return 0;
}

int fuzz_blob_write(void *user, const void *bytes, size_t size) {
    fuzz_blob *blob = user;
    if (size > blob->capacity - blob->size) {
        size_t capacity = 2 * (blob->size + size);
        uint8_t *larger = realloc(blob->bytes, capacity);
        if (!larger) return 1;
        blob->bytes = larger;
        blob->capacity = capacity;
    }
    if (size) memcpy(blob->bytes + blob->size, bytes, size);
    blob->size += size;
    return 0;
}
