/* _files.c: documents: opened, read as arrays, computed, saved; from a path or from bytes. */
#include "_norma.h"
#include <stdlib.h>
#include <string.h>

PyObject *norma_py_document_refusal(
    norma_document_result result, const norma_document_error *error) {
    PyObject *message = norma_py_text(error->message);
    return message ? Py_BuildValue("iN", (int)result, message) : NULL;
}

const char norma_py_document[] = "norma_document";

static void close_document(PyObject *capsule) {
    PyObject *bytes = PyCapsule_GetContext(capsule);
    norma_document_close(PyCapsule_GetPointer(capsule, norma_py_document));
    Py_XDECREF(bytes);
}

norma_document_result norma_py_open(PyObject *name, PyObject *bytes,
    const norma_document_options *options, norma_document **document, norma_document_error *error) {
    const char *path = name == Py_None ? NULL : PyBytes_AsString(name);
    if (bytes == Py_None) return norma_document_open(path, options, document, error);
    return norma_document_open_memory(
        PyBytes_AsString(bytes), (size_t)PyBytes_Size(bytes), path, options, document, error);
}

/* open_document(path in bytes or None, the file's bytes or None, format, threads) -> a capsule, or
 * why it was refused. Bytes are read where they are: the capsule keeps them. */
static PyObject *open_document(PyObject *self, PyObject *arguments) {
    PyObject *path, *bytes;
    int format;
    unsigned int threads;
    norma_document *document = NULL;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OOiI", &path, &bytes, &format, &threads)) return NULL;
    watch w = norma_py_give_up_lock();
    const norma_document_options options = {.struct_size = sizeof options,
        .format = (norma_file_format)format,
        .threads = threads,
        .progress = norma_py_let_signals_in,
        .progress_user = &w,
        .lenient = 1};
    const norma_document_result result = norma_py_open(path, bytes, &options, &document, &error);
    if (norma_py_take_lock(&w)) {
        norma_document_close(document);
        return NULL;
    }
    if (result != NORMA_DOCUMENT_OK) return norma_py_document_refusal(result, &error);
    PyObject *capsule = PyCapsule_New(document, norma_py_document, close_document);
    if (!capsule) norma_document_close(document);
    if (capsule && bytes != Py_None && !PyCapsule_SetContext(capsule, bytes)) Py_INCREF(bytes);
    return capsule;
}

static int add_tile(void *list, const char *path) {
    PyObject *name = PyBytes_FromString(path);
    const int failed = !name || PyList_Append(list, name) != 0;
    Py_XDECREF(name);
    return failed;
}

/* tileset_tiles(path in bytes) -> [path in bytes], or why it was refused */
static PyObject *tileset_tiles(PyObject *self, PyObject *path) {
    norma_document_error error = {0};
    PyObject *list = PyList_New(0);
    const char *name = PyBytes_AsString(path);
    (void)self;
    if (!list || !name) {
        Py_XDECREF(list);
        return NULL;
    }
    const norma_document_result result = norma_tileset_visit_tiles(name, add_tile, list, &error);
    if (result == NORMA_DOCUMENT_OK && !PyErr_Occurred()) return list;
    Py_DECREF(list);
    return PyErr_Occurred() ? NULL : norma_py_document_refusal(result, &error);
}

/* document_meshes(document) -> (format, [(name, where, vertices, faces, storage, encoding,
 * morph targets, why not read or None)]) */
static PyObject *document_meshes(PyObject *self, PyObject *capsule) {
    const norma_document *document = PyCapsule_GetPointer(capsule, norma_py_document);
    (void)self;
    if (!document) return NULL;
    const size_t count = norma_document_mesh_count(document);
    PyObject *list = PyList_New((Py_ssize_t)count);
    for (size_t i = 0; list && i < count; ++i) {
        norma_mesh_info info;
        norma_document_mesh_info(document, i, &info);
        PyObject *item = Py_BuildValue("NNnnisnN", norma_py_text(info.name),
            norma_py_text(info.where), (Py_ssize_t)info.vertices, (Py_ssize_t)info.faces,
            (int)info.normals, info.encoding, (Py_ssize_t)info.morph_targets,
            info.not_read ? norma_py_text(info.not_read) : (Py_INCREF(Py_None), Py_None));
        if (!item) {
            Py_DECREF(list);
            return NULL;
        }
        PyList_SetItem(list, (Py_ssize_t)i, item);
    }
    if (!list) return NULL;
    return Py_BuildValue("sN", norma_file_format_name(norma_document_format(document)), list);
}

/* document_arrays(document, index) -> ((address, count, stride, format) of positions, (address,
 * count, size) of corners, (address, count) of face_starts, the first again of normals, the address
 * of corner_normals, (address, count) of texcoords, address of their corners, (address, count) of
 * tangents), or why it was refused. The addresses hold until the document changes. */
static PyObject *document_arrays(PyObject *self, PyObject *arguments) {
    PyObject *capsule;
    Py_ssize_t index;
    norma_mesh_data data;
    norma_mesh_attributes more;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "On", &capsule, &index)) return NULL;
    norma_document *document = PyCapsule_GetPointer(capsule, norma_py_document);
    if (!document) return NULL;
    watch w = norma_py_give_up_lock();
    norma_document_result result = norma_document_mesh_data(document, (size_t)index, &data, &error);
    if (result == NORMA_DOCUMENT_OK)
        result = norma_document_mesh_attributes(document, (size_t)index, &more, &error);
    if (norma_py_take_lock(&w)) return NULL;
    if (result != NORMA_DOCUMENT_OK) return norma_py_document_refusal(result, &error);
    const norma_vec3_view *p = &data.mesh.positions, *n = &data.normals;
    return Py_BuildValue("(Knni)(Knn)(Kn)(Knni)K(Kn)K(Kn)", (address)(uintptr_t)p->data,
        (Py_ssize_t)p->count, (Py_ssize_t)p->stride, (int)p->format,
        (address)(uintptr_t)data.mesh.corners, (Py_ssize_t)data.mesh.corner_count,
        (Py_ssize_t)(data.mesh.corner_size ? data.mesh.corner_size : 4),
        (address)(uintptr_t)data.mesh.face_starts, (Py_ssize_t)data.mesh.face_count,
        (address)(uintptr_t)n->data, (Py_ssize_t)n->count, (Py_ssize_t)n->stride, (int)n->format,
        (address)(uintptr_t)data.corner_normals, (address)(uintptr_t)more.texcoords,
        (Py_ssize_t)more.texcoord_count, (address)(uintptr_t)more.corner_texcoords,
        (address)(uintptr_t)more.tangents, (Py_ssize_t)more.tangent_count);
}

/* document_compute(document, (shading, crease, weight, weld, distance, non_manifold, groups, only,
 * morphs, threads, tangents, address of a mark for each mesh or 0)) -> (changed, faces, before,
 * after, shading, crease, hard edges, filled, counts), or why it was refused */
static PyObject *document_compute(PyObject *self, PyObject *arguments) {
    PyObject *capsule;
    int shading, weight, weld, non_manifold, groups, only, morphs, tangents;
    double crease, distance;
    unsigned int threads;
    address meshes;
    norma_compute_summary s;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "O(idiidiiipIiK)", &capsule, &shading, &crease, &weight, &weld,
            &distance, &non_manifold, &groups, &only, &morphs, &threads, &tangents, &meshes))
        return NULL;
    norma_document *document = PyCapsule_GetPointer(capsule, norma_py_document);
    if (!document) return NULL;
    watch w = norma_py_give_up_lock();
    const norma_compute_options options = {.struct_size = sizeof options,
        .shading = (norma_shading)shading,
        .crease_angle_rad = crease,
        .weight = (norma_weight)weight,
        .weld = (norma_weld)weld,
        .weld_distance = distance,
        .non_manifold = (norma_non_manifold)non_manifold,
        .groups = (norma_groups)groups,
        .only = (norma_only)only,
        .morphs = morphs,
        .threads = threads,
        .progress = norma_py_let_signals_in,
        .progress_user = &w,
        .tangents = (norma_stored_tangents)tangents,
        .meshes = at(meshes)};
    const norma_document_result result = norma_document_compute(document, &options, &s, &error);
    if (norma_py_take_lock(&w)) return NULL;
    if (result != NORMA_DOCUMENT_OK) return norma_py_document_refusal(result, &error);
    return Py_BuildValue("innnidnnN", s.changed, (Py_ssize_t)s.faces, (Py_ssize_t)s.vertices_before,
        (Py_ssize_t)s.vertices_after, (int)s.shading, s.crease_angle_rad,
        s.edges_counted ? (Py_ssize_t)s.hard_edges : -1, (Py_ssize_t)s.filled,
        norma_py_counts(&s.report));
}

/* document_save(document, path in bytes, in_place) -> None, or why it was refused */
static PyObject *document_save(PyObject *self, PyObject *arguments) {
    PyObject *capsule;
    const char *path;
    int in_place;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "Oyp", &capsule, &path, &in_place)) return NULL;
    norma_document *document = PyCapsule_GetPointer(capsule, norma_py_document);
    if (!document) return NULL;
    watch w = norma_py_give_up_lock();
    const norma_save_options options = {.struct_size = sizeof options,
        .in_place = in_place,
        .progress = norma_py_let_signals_in,
        .progress_user = &w};
    const norma_document_result result = norma_document_save(document, path, &options, &error);
    if (norma_py_take_lock(&w)) return NULL;
    if (result != NORMA_DOCUMENT_OK) return norma_py_document_refusal(result, &error);
    Py_RETURN_NONE;
}

/* A file's bytes as they are written. */
typedef struct written {
    char *bytes;
    size_t size, capacity;
} written;

static int append(void *user, const void *bytes, size_t size) {
    written *w = user;
    if (size > w->capacity - w->size) {
        const size_t capacity = w->size + size + w->capacity / 2;
        char *larger = capacity > w->size ? realloc(w->bytes, capacity) : NULL;
        if (!larger) return 1;
        w->bytes = larger;
        w->capacity = capacity;
    }
    memcpy(w->bytes + w->size, bytes, size);
    w->size += size;
    return 0;
}

/* document_bytes(document) -> the file as bytes, or why it was refused */
static PyObject *document_bytes(PyObject *self, PyObject *capsule) {
    norma_document *document = PyCapsule_GetPointer(capsule, norma_py_document);
    norma_document_error error = {0};
    written file = {0};
    (void)self;
    if (!document) return NULL;
    watch w = norma_py_give_up_lock();
    const norma_document_result result = norma_document_write(document, append, &file, &error);
    PyObject *answer = norma_py_take_lock(&w) ? NULL
                       : result != NORMA_DOCUMENT_OK
                           ? norma_py_document_refusal(result, &error)
                           : PyBytes_FromStringAndSize(file.bytes, (Py_ssize_t)file.size);
    free(file.bytes);
    return answer;
}

/* save_bytes(path in bytes, bytes) -> None, or why it was refused */
static PyObject *save_bytes(PyObject *self, PyObject *arguments) {
    const char *path, *bytes;
    Py_ssize_t size;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "yy#", &path, &bytes, &size)) return NULL;
    watch w = norma_py_give_up_lock();
    const norma_document_result result = norma_save_bytes(path, bytes, (size_t)size, &error);
    if (norma_py_take_lock(&w)) return NULL;
    if (result != NORMA_DOCUMENT_OK) return norma_py_document_refusal(result, &error);
    Py_RETURN_NONE;
}

/* document_transform(document, address of 16 doubles by columns, bake, threads) -> (changed,
 * vertices, meshes, nodes baked, mirrored), or why it was refused */
static PyObject *document_transform(PyObject *self, PyObject *arguments) {
    PyObject *capsule;
    address matrix;
    int bake;
    unsigned int threads;
    norma_transform_summary s;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OKpI", &capsule, &matrix, &bake, &threads)) return NULL;
    norma_document *document = PyCapsule_GetPointer(capsule, norma_py_document);
    if (!document) return NULL;
    watch w = norma_py_give_up_lock();
    norma_transform_options options = {.struct_size = sizeof options,
        .bake = bake,
        .threads = threads,
        .progress = norma_py_let_signals_in,
        .progress_user = &w};
    memcpy(options.matrix, at(matrix), sizeof options.matrix);
    const norma_document_result result = norma_document_transform(document, &options, &s, &error);
    if (norma_py_take_lock(&w)) return NULL;
    if (result != NORMA_DOCUMENT_OK) return norma_py_document_refusal(result, &error);
    return Py_BuildValue("innni", s.changed, (Py_ssize_t)s.vertices, (Py_ssize_t)s.meshes,
        (Py_ssize_t)s.nodes_baked, s.mirrored);
}

/* document_tangents(document, (mode, weight, set of texture coordinates or -1, only, threads)) ->
 * (changed, primitives, left out, before, after, degenerate, non_finite, cancelled), or why it was
 * refused */
static PyObject *document_tangents(PyObject *self, PyObject *arguments) {
    PyObject *capsule;
    int mode, weight, set, only;
    unsigned int threads;
    norma_tangent_summary s;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "O(iiiiI)", &capsule, &mode, &weight, &set, &only, &threads))
        return NULL;
    norma_document *document = PyCapsule_GetPointer(capsule, norma_py_document);
    if (!document) return NULL;
    watch w = norma_py_give_up_lock();
    const norma_tangent_options options = {.struct_size = sizeof options,
        .mode = (norma_tangent_mode)mode,
        .weight = (norma_weight)weight,
        .texcoord_given = set >= 0,
        .texcoord = set >= 0 ? (uint32_t)set : 0,
        .only = (norma_only)only,
        .threads = threads,
        .progress = norma_py_let_signals_in,
        .progress_user = &w};
    const norma_document_result result = norma_document_tangents(document, &options, &s, &error);
    if (norma_py_take_lock(&w)) return NULL;
    if (result != NORMA_DOCUMENT_OK) return norma_py_document_refusal(result, &error);
    return Py_BuildValue("innnnnnn", s.changed, (Py_ssize_t)s.primitives, (Py_ssize_t)s.left_out,
        (Py_ssize_t)s.vertices_before, (Py_ssize_t)s.vertices_after, (Py_ssize_t)s.degenerate,
        (Py_ssize_t)s.non_finite, (Py_ssize_t)s.cancelled);
}

/* document_set_normals(document, mesh, normals, a mark for each, source vertices, their number,
 * corners) -> None, or why it was refused; addresses, the last two 0 if vertices stay */
static PyObject *document_set_normals(PyObject *self, PyObject *arguments) {
    PyObject *capsule;
    address normals, marks, sources, corners;
    Py_ssize_t index, vertices;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OnKKKnK", &capsule, &index, &normals, &marks, &sources,
            &vertices, &corners))
        return NULL;
    norma_document *document = PyCapsule_GetPointer(capsule, norma_py_document);
    if (!document) return NULL;
    norma_mesh_edit *edits = calloc(norma_document_mesh_count(document), sizeof *edits);
    if (!edits) return PyErr_NoMemory();
    edits[index] = (norma_mesh_edit){.normals = at(normals),
        .set_normals = at(marks),
        .source_vertices = at(sources),
        .vertex_count = (size_t)vertices,
        .new_corners = at(corners)};
    watch w = norma_py_give_up_lock();
    const norma_document_result result = norma_document_edit(document, edits, &error);
    free(edits);
    if (norma_py_take_lock(&w)) return NULL;
    if (result != NORMA_DOCUMENT_OK) return norma_py_document_refusal(result, &error);
    Py_RETURN_NONE;
}

PyMethodDef norma_py_files[] = {{"open_document", open_document, METH_VARARGS, NULL},
    {"tileset_tiles", tileset_tiles, METH_O, NULL},
    {"document_meshes", document_meshes, METH_O, NULL},
    {"document_arrays", document_arrays, METH_VARARGS, NULL},
    {"document_compute", document_compute, METH_VARARGS, NULL},
    {"document_save", document_save, METH_VARARGS, NULL},
    {"document_bytes", document_bytes, METH_O, NULL},
    {"save_bytes", save_bytes, METH_VARARGS, NULL},
    {"document_transform", document_transform, METH_VARARGS, NULL},
    {"document_tangents", document_tangents, METH_VARARGS, NULL},
    {"document_set_normals", document_set_normals, METH_VARARGS, NULL}, {NULL, NULL, 0, NULL}};
