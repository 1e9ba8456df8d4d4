/* _norma.c: the extension module below norma_mesh. It speaks the limited API of Python 3.9, which
 * has no buffers, so the Python files beside it (which look at every argument) hand over arrays as
 * addresses, counts and strides, and this file hands them to the library. Nothing here is public.
 *
 * A call gives up the interpreter's lock. Its progress callback takes the lock back twenty times a
 * second to let signals in: Ctrl-C cancels the call, which then raises KeyboardInterrupt. */
#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x03090000
#include <Python.h>

#include <norma/check.h>
#include <norma/document.h>
#include <norma/norma.h>
#include <stdint.h>
#include <string.h>
#include <time.h>

typedef unsigned long long address;

static void *at(address value) { return (void *)(uintptr_t)value; } // NOLINT

/* ---- signals while the lock is given up */

typedef struct watch {
    PyThreadState *thread;
    double last;
    int interrupted;
} watch;

static double seconds(void) {
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int let_signals_in(void *user, double fraction) {
    watch *w = user;
    const double now = seconds();
    (void)fraction;
    if (now - w->last < 0.05 && now >= w->last) return w->interrupted;
    w->last = now;
    PyEval_RestoreThread(w->thread);
    if (PyErr_CheckSignals() != 0) w->interrupted = 1;
    w->thread = PyEval_SaveThread();
    return w->interrupted;
}

static watch give_up_lock(void) {
    return (watch){.last = seconds(), .thread = PyEval_SaveThread()};
}

/* Returns whether an exception is pending. */
static int take_lock(watch *w) {
    PyEval_RestoreThread(w->thread);
    return w->interrupted;
}

/* ---- meshes and options, as tuples of numbers */

typedef struct mesh_call {
    norma_mesh mesh;
    norma_options options;
} mesh_call;

/* The first two arguments of each call on a mesh: (positions, count, stride, format, corners,
 * count, size, face_starts, face_count, groups, hard) and (weight, weld, weld_distance,
 * non_manifold, fallback, x, y, z, stride, reasons, threads). */
static int parse_mesh_call(PyObject *mesh, PyObject *options, mesh_call *call) {
    address positions, corners, starts, groups, hard, reasons;
    Py_ssize_t count, stride, corner_count, corner_size, face_count, normal_stride;
    int format, weight, weld, non_manifold, fallback;
    double distance;
    float x, y, z;
    unsigned int threads;
    if (!PyArg_ParseTuple(mesh, "KnniKnnKnKK", &positions, &count, &stride, &format, &corners,
            &corner_count, &corner_size, &starts, &face_count, &groups, &hard) ||
        !PyArg_ParseTuple(options, "iidiifffnKI", &weight, &weld, &distance, &non_manifold,
            &fallback, &x, &y, &z, &normal_stride, &reasons, &threads))
        return 0;
    *call = (mesh_call){
        .mesh = {.positions = {at(positions), (size_t)count, (size_t)stride, (norma_format)format},
            .corners = at(corners),
            .corner_count = (size_t)corner_count,
            .corner_size = (size_t)corner_size,
            .face_starts = at(starts),
            .face_count = (size_t)face_count,
            .smoothing_groups = at(groups),
            .hard_edges = at(hard)},
        .options = {.struct_size = sizeof(norma_options),
            .weight = (norma_weight)weight,
            .weld = (norma_weld)weld,
            .weld_distance = distance,
            .non_manifold = (norma_non_manifold)non_manifold,
            .fallback = (norma_fallback)fallback,
            .fallback_normal = {x, y, z},
            .normal_stride = (size_t)normal_stride,
            .reasons = at(reasons),
            .threads = threads}};
    return 1;
}

/* Gives up the lock for a call whose progress lets signals in. */
static void begin_call(mesh_call *call, watch *w) {
    call->options.progress = let_signals_in;
    call->options.progress_user = w;
    *w = give_up_lock();
}

static PyObject *counts_of(const norma_report *r) {
    return Py_BuildValue("nnnnnn", (Py_ssize_t)r->degenerate_faces.count,
        (Py_ssize_t)r->non_finite.count, (Py_ssize_t)r->unreferenced.count,
        (Py_ssize_t)r->cancelled.count, (Py_ssize_t)r->non_manifold_edges.count,
        (Py_ssize_t)r->winding_conflicts.count);
}

/* What a refused call answers: (result, argument, index or -1, what was expected). */
static PyObject *refusal(norma_result result, const norma_fault *fault) {
    const int known = fault && fault->result == result && fault->argument;
    return Py_BuildValue("isns", (int)result, known ? fault->argument : "",
        known && fault->index != SIZE_MAX ? (Py_ssize_t)fault->index : -1,
        known && fault->expected ? fault->expected : norma_result_text(result));
}

static PyObject *refused_mesh(norma_result result, const mesh_call *call, const float *crease) {
    norma_fault fault;
    norma_find_fault(&call->mesh, crease, &call->options, &fault);
    return refusal(result, &fault);
}

/* ---- normals */

enum { OF_FACES, OF_VERTICES, OF_CORNERS };

/* normals(mesh, options, of, crease, out, capacity) -> counts, or why it was refused */
static PyObject *normals(PyObject *self, PyObject *arguments) {
    PyObject *mesh, *options;
    int of;
    float crease;
    address out;
    Py_ssize_t capacity;
    mesh_call call;
    norma_report report;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OOifKn", &mesh, &options, &of, &crease, &out, &capacity) ||
        !parse_mesh_call(mesh, options, &call))
        return NULL;
    watch w;
    begin_call(&call, &w);
    const norma_result result =
        of == OF_FACES
            ? norma_face_normals(&call.mesh, &call.options, at(out), (size_t)capacity, &report)
        : of == OF_VERTICES
            ? norma_vertex_normals(&call.mesh, &call.options, at(out), (size_t)capacity, &report)
            : norma_corner_normals(
                  &call.mesh, crease, &call.options, at(out), (size_t)capacity, &report);
    if (take_lock(&w)) return NULL;
    if (result != NORMA_OK) return refused_mesh(result, &call, of == OF_CORNERS ? &crease : NULL);
    return counts_of(&report);
}

/* split(mesh, options, crease, corners, source_vertices, normals, capacity) -> (counts, vertices),
 * or why it was refused */
static PyObject *split(PyObject *self, PyObject *arguments) {
    PyObject *mesh, *options;
    float crease;
    address corners, sources, out;
    Py_ssize_t capacity;
    mesh_call call;
    norma_report report;
    size_t vertices = 0;
    (void)self;
    if (!PyArg_ParseTuple(
            arguments, "OOfKKKn", &mesh, &options, &crease, &corners, &sources, &out, &capacity) ||
        !parse_mesh_call(mesh, options, &call))
        return NULL;
    watch w;
    begin_call(&call, &w);
    const norma_result result = norma_split(&call.mesh, crease, &call.options, at(corners),
        call.mesh.corner_count, at(sources), at(out), (size_t)capacity, &vertices, &report);
    if (take_lock(&w)) return NULL;
    if (result != NORMA_OK) return refused_mesh(result, &call, &crease);
    return Py_BuildValue("Nn", counts_of(&report), (Py_ssize_t)vertices);
}

static int parse_attribute(PyObject *tuple, norma_attribute *attribute) {
    address data, corners;
    Py_ssize_t count, stride;
    int format, of;
    if (!PyArg_ParseTuple(tuple, "KnniiK", &data, &count, &stride, &format, &of, &corners))
        return 0;
    *attribute = (norma_attribute){.data = at(data),
        .count = (size_t)count,
        .stride = (size_t)stride,
        .format = (norma_format)format,
        .of = (norma_element)of,
        .corners = at(corners)};
    return 1;
}

/* tangents(mesh, options, normals, texcoords, mode, out, capacity) -> counts, or why it was refused
 */
static PyObject *tangents(PyObject *self, PyObject *arguments) {
    PyObject *mesh, *options, *n, *t;
    int mode;
    address out;
    Py_ssize_t capacity;
    mesh_call call;
    norma_attribute directions, texcoords;
    norma_report report;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OOOOiKn", &mesh, &options, &n, &t, &mode, &out, &capacity) ||
        !parse_mesh_call(mesh, options, &call) || !parse_attribute(n, &directions) ||
        !parse_attribute(t, &texcoords))
        return NULL;
    watch w;
    begin_call(&call, &w);
    const norma_result result = norma_corner_tangents(&call.mesh, &directions, &texcoords,
        (norma_tangent_mode)mode, &call.options, at(out), (size_t)capacity, &report);
    if (take_lock(&w)) return NULL;
    if (result != NORMA_OK) return refused_mesh(result, &call, NULL);
    return counts_of(&report);
}

/* orient(mesh, options, by_rays, reverse, capacity) -> what was found, or why it was refused */
/* Of a list of (address, size, stride), each with count values; NULL: an exception is pending. */
static norma_stream *parse_streams(PyObject *list, size_t count) {
    const Py_ssize_t streams = PyList_Size(list);
    norma_stream *made = PyMem_Calloc((size_t)streams + 1, sizeof *made);
    if (!made) PyErr_NoMemory();
    for (Py_ssize_t i = 0; made && i < streams; i++) {
        address data;
        Py_ssize_t size, stride;
        if (PyArg_ParseTuple(PyList_GetItem(list, i), "Knn", &data, &size, &stride)) {
            made[i] = (norma_stream){at(data), count, (size_t)size, (size_t)stride, NULL};
            continue;
        }
        PyMem_Free(made);
        return NULL;
    }
    return made;
}

/* index_corners(streams, count, threads, corners, source_corners) -> how many vertices, or why it
 * was refused */
static PyObject *index_corners(PyObject *self, PyObject *arguments) {
    PyObject *list;
    Py_ssize_t count;
    unsigned int threads;
    address corners, sources;
    (void)self;
    if (!PyArg_ParseTuple(
            arguments, "O!nIKK", &PyList_Type, &list, &count, &threads, &corners, &sources))
        return NULL;
    norma_stream *streams = parse_streams(list, (size_t)count);
    if (!streams) return NULL;
    mesh_call call = {.options = {.struct_size = sizeof(norma_options), .threads = threads}};
    norma_indexed indexed = {.corners = at(corners),
        .corner_capacity = (size_t)count,
        .source_corners = at(sources),
        .vertex_capacity = (size_t)count};
    const size_t stream_count = (size_t)PyList_Size(list);
    watch w;
    begin_call(&call, &w);
    const norma_result result =
        norma_index_corners(streams, stream_count, (size_t)count, &call.options, &indexed);
    const int interrupted = take_lock(&w);
    PyMem_Free(streams);
    if (interrupted) return NULL;
    return result == NORMA_OK ? PyLong_FromSize_t(indexed.vertex_count) : refusal(result, NULL);
}

static PyObject *orient(PyObject *self, PyObject *arguments) {
    PyObject *mesh, *options;
    int by_rays;
    address reverse;
    Py_ssize_t capacity;
    mesh_call call;
    norma_orient_report r;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OOiKn", &mesh, &options, &by_rays, &reverse, &capacity) ||
        !parse_mesh_call(mesh, options, &call))
        return NULL;
    watch w;
    begin_call(&call, &w);
    const norma_result result = norma_orient(
        &call.mesh, (norma_orient_open)by_rays, &call.options, at(reverse), (size_t)capacity, &r);
    if (take_lock(&w)) return NULL;
    if (result != NORMA_OK) return refused_mesh(result, &call, NULL);
    return Py_BuildValue("nnnnnnnndnnn", (Py_ssize_t)r.parts, (Py_ssize_t)r.closed,
        (Py_ssize_t)r.open, (Py_ssize_t)r.one_sided, (Py_ssize_t)r.inward, (Py_ssize_t)r.nested,
        (Py_ssize_t)r.by_rays, (Py_ssize_t)r.undecided, r.least_confidence,
        (Py_ssize_t)r.reversed_faces, (Py_ssize_t)r.winding_conflicts,
        (Py_ssize_t)r.non_manifold_edges);
}

/* ---- plans */

static const char PLAN[] = "norma_plan", DOCUMENT[] = "norma_document";

static void free_plan(PyObject *capsule) {
    norma_plan_destroy(PyCapsule_GetPointer(capsule, PLAN));
}

/* plan(mesh, options, per_corner, crease) -> a capsule, or why it was refused */
static PyObject *plan(PyObject *self, PyObject *arguments) {
    PyObject *mesh, *options;
    int of;
    float crease;
    mesh_call call;
    norma_plan *made = NULL;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OOif", &mesh, &options, &of, &crease) ||
        !parse_mesh_call(mesh, options, &call))
        return NULL;
    watch w;
    begin_call(&call, &w);
    const norma_result result =
        norma_plan_create(&call.mesh, (norma_element)of, crease, &call.options, &made);
    if (take_lock(&w)) {
        norma_plan_destroy(made);
        return NULL;
    }
    if (result != NORMA_OK) return refused_mesh(result, &call, &crease);
    PyObject *capsule = PyCapsule_New(made, PLAN, free_plan);
    if (!capsule) norma_plan_destroy(made);
    return capsule;
}

/* plan_update(plan, mesh, options, moved, moved_count, out, capacity) -> counts, or why it was
 * refused; of the mesh, only the positions are read */
static PyObject *plan_update(PyObject *self, PyObject *arguments) {
    PyObject *capsule, *mesh, *options;
    address moved, out;
    Py_ssize_t moved_count, capacity;
    mesh_call call;
    norma_report report;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OOOKnKn", &capsule, &mesh, &options, &moved, &moved_count,
            &out, &capacity) ||
        !parse_mesh_call(mesh, options, &call))
        return NULL;
    const norma_plan *of = PyCapsule_GetPointer(capsule, PLAN);
    if (!of) return NULL;
    watch w;
    begin_call(&call, &w);
    const norma_result result = norma_plan_update(of, call.mesh.positions, at(moved),
        (size_t)moved_count, &call.options, at(out), (size_t)capacity, &report);
    if (take_lock(&w)) return NULL;
    return result == NORMA_OK ? counts_of(&report) : refusal(result, NULL);
}

static PyObject *plan_bytes(PyObject *self, PyObject *capsule) {
    const norma_plan *of = PyCapsule_GetPointer(capsule, PLAN);
    (void)self;
    return of ? PyLong_FromSize_t(norma_plan_bytes(of)) : NULL;
}

/* ---- matrices. Matrices of Python are rows, those of the library columns: what is handed over is
 * the transpose, and the cofactors of a transpose are the transposed cofactors. */

/* normal_matrices(models, count, doubles, out) -> None, or why it was refused */
static PyObject *normal_matrices(PyObject *self, PyObject *arguments) {
    address models, out;
    Py_ssize_t count;
    int doubles;
    norma_fault fault = {NORMA_ERROR_ARGUMENT, "models", SIZE_MAX, "finite in the upper 3x3"};
    norma_result result = NORMA_OK;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "KnpK", &models, &count, &doubles, &out)) return NULL;
    watch w = give_up_lock();
    if (!doubles)
        result = norma_normal_matrices(
            at(models), (size_t)count, NORMA_WINDING_REVERSED, at(out), (size_t)count);
    for (size_t i = 0; doubles && i < (size_t)count && !let_signals_in(&w, 0); i++) {
        const double *model = (const double *)at(models) + 16 * i;
        double *normal_matrix = (double *)at(out) + 9 * i;
        if (norma_normal_matrix_double(model, NORMA_WINDING_REVERSED, normal_matrix, NULL) !=
                NORMA_OK &&
            result == NORMA_OK) {
            result = NORMA_ERROR_ARGUMENT;
            fault.index = i;
        }
    }
    if (result != NORMA_OK && !doubles)
        norma_find_model_fault(at(models), 0, (size_t)count, &fault);
    if (take_lock(&w)) return NULL;
    if (result != NORMA_OK) return refusal(result, &fault);
    Py_RETURN_NONE;
}

/* matrix_info(model) -> (kind, rank, mirrored, determinant, anisotropy, worst error, x, y, z) */
static PyObject *matrix_info(PyObject *self, PyObject *argument) {
    const address model = PyLong_AsUnsignedLongLong(argument);
    double columns[16], unused[9];
    norma_matrix_info info;
    (void)self;
    if (PyErr_Occurred()) return NULL;
    for (size_t i = 0; i < 16; i++) columns[i] = ((const double *)at(model))[i % 4 * 4 + i / 4];
    const norma_result result =
        norma_normal_matrix_double(columns, NORMA_WINDING_REVERSED, unused, &info);
    if (result != NORMA_OK)
        return refusal(
            result, &(norma_fault){result, "model", SIZE_MAX, "finite in the upper 3x3"});
    const float *n = info.worst_normal;
    return Py_BuildValue("iiidddfff", (int)info.kind, info.rank, info.mirrored, info.determinant,
        info.anisotropy, info.worst_error_rad, n[0], n[1], n[2]);
}

/* transform_normals(matrix, normals, count, stride, format, out, stride) -> None, or why it was
 * refused */
static PyObject *transform_normals(PyObject *self, PyObject *arguments) {
    address matrix, in, out;
    Py_ssize_t count, stride, out_stride;
    int format;
    (void)self;
    if (!PyArg_ParseTuple(
            arguments, "KKnniKn", &matrix, &in, &count, &stride, &format, &out, &out_stride))
        return NULL;
    watch w = give_up_lock();
    const norma_vec3_view view = {at(in), (size_t)count, (size_t)stride, (norma_format)format};
    const norma_result result =
        norma_transform_normals(at(matrix), view, at(out), (size_t)out_stride, (size_t)count);
    if (take_lock(&w)) return NULL;
    if (result != NORMA_OK) return refusal(result, NULL);
    Py_RETURN_NONE;
}

/* ---- indices */

static int64_t read_index(const unsigned char *from, int size, int is_signed) {
    int64_t wide;
    int32_t word;
    int16_t half;
    switch (size) {
    case 8:
        memcpy(&wide, from, 8);
        return is_signed || wide >= 0 ? wide : -1;
    case 4:
        memcpy(&word, from, 4);
        return is_signed ? word : (int64_t)(uint32_t)word;
    case 2:
        memcpy(&half, from, 2);
        return is_signed ? half : (int64_t)(uint16_t)half;
    default:
        return is_signed ? (int64_t)(int8_t)*from : *from;
    }
}

/* numpy's default, int64, row after row: a block at a time, so that the range is checked in lanes.
 * Returns how many blocks of 1024 were fine. */
static Py_ssize_t convert_packed(const int64_t *from, Py_ssize_t count, uint32_t *to) {
    Py_ssize_t block = 0;
    for (; (block + 1) * 1024 <= count; block++) {
        uint64_t bad = 0;
        for (Py_ssize_t i = block * 1024; i < (block + 1) * 1024; i++) {
            bad |= (uint64_t)(from[i] + 1) >> 32 | ((uint64_t)from[i] >> 32);
            to[i] = (uint32_t)from[i];
        }
        if (bad) break;
    }
    return block;
}

/* indices(from, rows, columns, row stride, column stride, size, signed, out) -> the number of the
 * first index that is negative or above 2^32 - 2, or -1. Strides may be negative. */
static PyObject *indices(PyObject *self, PyObject *arguments) {
    address from, out;
    Py_ssize_t rows, columns, row_stride, column_stride, bad = -1;
    int size, is_signed;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "KnnnnipK", &from, &rows, &columns, &row_stride,
            &column_stride, &size, &is_signed, &out))
        return NULL;
    watch w = give_up_lock();
    uint32_t *to = at(out);
    const unsigned char *place = at(from);
    Py_ssize_t done = 0;
    if (size == 8 && column_stride == 8 && (rows < 2 || row_stride == 8 * columns) && from % 8 == 0)
        done = 1024 * convert_packed((const int64_t *)(const void *)place, rows * columns, to);
    for (; done < rows * columns && bad < 0; done++) {
        const unsigned char *element = place + done / columns * row_stride;
        const int64_t index = read_index(element + done % columns * column_stride, size, is_signed);
        if (index < 0 || index >= UINT32_MAX)
            bad = done;
        else
            to[done] = (uint32_t)index;
    }
    take_lock(&w);
    return PyLong_FromSsize_t(bad);
}

/* ---- files */

/* What a document call that fails answers: (result, message). */
static PyObject *document_refusal(norma_document_result result, const norma_document_error *error) {
    PyObject *message =
        PyUnicode_DecodeUTF8(error->message, (Py_ssize_t)strlen(error->message), "replace");
    return message ? Py_BuildValue("iN", (int)result, message) : NULL;
}

static PyObject *text(const char *words) {
    return PyUnicode_DecodeUTF8(words, (Py_ssize_t)strlen(words), "replace");
}

static void close_document(PyObject *capsule) {
    norma_document_close(PyCapsule_GetPointer(capsule, DOCUMENT));
}

/* open_document(path in bytes, threads) -> a capsule, or why it was refused */
static PyObject *open_document(PyObject *self, PyObject *arguments) {
    const char *path;
    unsigned int threads;
    norma_document *document = NULL;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "yI", &path, &threads)) return NULL;
    watch w = give_up_lock();
    const norma_document_options options = {.struct_size = sizeof options,
        .threads = threads,
        .progress = let_signals_in,
        .progress_user = &w,
        .lenient = 1};
    const norma_document_result result = norma_document_open(path, &options, &document, &error);
    if (take_lock(&w)) {
        norma_document_close(document);
        return NULL;
    }
    if (result != NORMA_DOCUMENT_OK) return document_refusal(result, &error);
    PyObject *capsule = PyCapsule_New(document, DOCUMENT, close_document);
    if (!capsule) norma_document_close(document);
    return capsule;
}

/* document_meshes(document) -> (format, [(name, where, vertices, faces, storage, encoding,
 * morph targets, why not read or None)]) */
static PyObject *document_meshes(PyObject *self, PyObject *capsule) {
    const norma_document *document = PyCapsule_GetPointer(capsule, DOCUMENT);
    (void)self;
    if (!document) return NULL;
    const size_t count = norma_document_mesh_count(document);
    PyObject *list = PyList_New((Py_ssize_t)count);
    for (size_t i = 0; list && i < count; i++) {
        norma_mesh_info info;
        norma_document_mesh_info(document, i, &info);
        PyObject *item = Py_BuildValue("NNnnisnN", text(info.name), text(info.where),
            (Py_ssize_t)info.vertices, (Py_ssize_t)info.faces, (int)info.normals, info.encoding,
            (Py_ssize_t)info.morph_targets,
            info.not_read ? text(info.not_read) : (Py_INCREF(Py_None), Py_None));
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
    norma_document *document = PyCapsule_GetPointer(capsule, DOCUMENT);
    if (!document) return NULL;
    watch w = give_up_lock();
    norma_document_result result = norma_document_mesh_data(document, (size_t)index, &data, &error);
    if (result == NORMA_DOCUMENT_OK)
        result = norma_document_mesh_attributes(document, (size_t)index, &more, &error);
    if (take_lock(&w)) return NULL;
    if (result != NORMA_DOCUMENT_OK) return document_refusal(result, &error);
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

/* copy(from, rows, bytes of a row, stride, out): rows that lie stride bytes apart, packed. */
static PyObject *copy(PyObject *self, PyObject *arguments) {
    address from, out;
    Py_ssize_t rows, bytes, stride;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "KnnnK", &from, &rows, &bytes, &stride, &out)) return NULL;
    const unsigned char *in = at(from);
    for (Py_ssize_t i = 0; i < rows; i++)
        memcpy((unsigned char *)at(out) + i * bytes, in + i * (stride ? stride : bytes),
            (size_t)bytes);
    Py_RETURN_NONE;
}

/* document_compute(document, (shading, crease, weight, weld, distance, non_manifold, groups, only,
 * morphs, threads, tangents)) -> (changed, faces, before, after, shading, crease, hard edges,
 * filled, counts), or why it was refused */
static PyObject *document_compute(PyObject *self, PyObject *arguments) {
    PyObject *capsule;
    int shading, weight, weld, non_manifold, groups, only, morphs, tangents;
    double crease, distance;
    unsigned int threads;
    norma_compute_summary s;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "O(idiidiiipIi)", &capsule, &shading, &crease, &weight, &weld,
            &distance, &non_manifold, &groups, &only, &morphs, &threads, &tangents))
        return NULL;
    norma_document *document = PyCapsule_GetPointer(capsule, DOCUMENT);
    if (!document) return NULL;
    watch w = give_up_lock();
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
        .progress = let_signals_in,
        .progress_user = &w,
        .tangents = (norma_stored_tangents)tangents};
    const norma_document_result result = norma_document_compute(document, &options, &s, &error);
    if (take_lock(&w)) return NULL;
    if (result != NORMA_DOCUMENT_OK) return document_refusal(result, &error);
    return Py_BuildValue("innnidnnN", s.changed, (Py_ssize_t)s.faces, (Py_ssize_t)s.vertices_before,
        (Py_ssize_t)s.vertices_after, (int)s.shading, s.crease_angle_rad,
        s.edges_counted ? (Py_ssize_t)s.hard_edges : -1, (Py_ssize_t)s.filled,
        counts_of(&s.report));
}

/* document_save(document, path in bytes, in_place) -> None, or why it was refused */
static PyObject *document_save(PyObject *self, PyObject *arguments) {
    PyObject *capsule;
    const char *path;
    int in_place;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "Oyp", &capsule, &path, &in_place)) return NULL;
    norma_document *document = PyCapsule_GetPointer(capsule, DOCUMENT);
    if (!document) return NULL;
    watch w = give_up_lock();
    const norma_save_options options = {.struct_size = sizeof options,
        .in_place = in_place,
        .progress = let_signals_in,
        .progress_user = &w};
    const norma_document_result result = norma_document_save(document, path, &options, &error);
    if (take_lock(&w)) return NULL;
    if (result != NORMA_DOCUMENT_OK) return document_refusal(result, &error);
    Py_RETURN_NONE;
}

/* ---- rules */

static PyObject *number_or_none(size_t number) {
    if (number == SIZE_MAX) Py_RETURN_NONE;
    return PyLong_FromSize_t(number);
}

/* (vertex, face, normal, position or None) */
static PyObject *sample_of(const norma_sample *s) {
    PyObject *position = s->has_position
                             ? Py_BuildValue("ddd", s->position[0], s->position[1], s->position[2])
                             : (Py_INCREF(Py_None), Py_None);
    return Py_BuildValue("NNNN", number_or_none(s->vertex), number_or_none(s->face),
        number_or_none(s->normal), position);
}

/* (shading, weight, crease, mean, p50, p99, max, [corners below each bound]) or None */
static PyObject *deviation_of(const norma_deviation *d) {
    if (!d) Py_RETURN_NONE;
    PyObject *bins = PyList_New(NORMA_DEVIATION_BINS);
    for (Py_ssize_t i = 0; bins && i < NORMA_DEVIATION_BINS; i++)
        PyList_SetItem(bins, i, PyLong_FromSize_t(d->histogram[i]));
    return Py_BuildValue("iidddddN", (int)d->shading, (int)d->weight, d->crease_angle_rad,
        d->mean_rad, d->p50_rad, d->p99_rad, d->max_rad, bins);
}

/* (id, name, severity, where, label, count, worst value, unit, worst, samples, fix, message,
 * deviation) */
static PyObject *finding_of(const norma_finding *f) {
    PyObject *samples = PyList_New((Py_ssize_t)f->sample_count);
    for (size_t i = 0; samples && i < f->sample_count; i++) {
        PyObject *sample = sample_of(&f->samples[i]);
        if (!sample)
            Py_CLEAR(samples);
        else
            PyList_SetItem(samples, (Py_ssize_t)i, sample);
    }
    if (!samples) return NULL;
    return Py_BuildValue("ssiNNndsNNiNN", f->rule->id, f->rule->name, (int)f->severity,
        text(f->where), text(f->label), (Py_ssize_t)f->count, f->worst_value, f->unit,
        sample_of(&f->worst), samples, (int)f->fix, text(f->message), deviation_of(f->deviation));
}

static PyObject *findings_list(norma_findings *findings) {
    PyObject *list = PyList_New((Py_ssize_t)norma_findings_count(findings));
    for (size_t i = 0; list && i < norma_findings_count(findings); i++) {
        PyObject *item = finding_of(norma_findings_get(findings, i));
        if (!item)
            Py_CLEAR(list);
        else
            PyList_SetItem(list, (Py_ssize_t)i, item);
    }
    PyObject *answer = list ? Py_BuildValue("iiN", (int)norma_findings_profile(findings),
                                  norma_findings_partly(findings), list)
                            : NULL;
    norma_findings_free(findings);
    return answer;
}

/* check(path in bytes, profile, strict, samples, mask of rules in bytes or None, threads) ->
 * (profile, partly, unreadable, [findings]); why it was refused if there was no memory */
static PyObject *check(PyObject *self, PyObject *arguments) {
    const char *path, *mask;
    int profile, strict;
    Py_ssize_t samples, mask_size;
    unsigned int threads;
    norma_document *document = NULL;
    norma_findings *findings = NULL;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(
            arguments, "yipnz#I", &path, &profile, &strict, &samples, &mask, &mask_size, &threads))
        return NULL;
    watch w = give_up_lock();
    const norma_document_options opening = {.struct_size = sizeof opening,
        .threads = threads,
        .progress = let_signals_in,
        .progress_user = &w,
        .lenient = 1};
    const norma_check_options options = {.struct_size = sizeof options,
        .profile = (norma_check_profile)profile,
        .strict = strict,
        .max_samples = (size_t)samples,
        .rules = (const uint8_t *)mask,
        .threads = threads,
        .progress = let_signals_in,
        .progress_user = &w};
    norma_document_result result = norma_document_open(path, &opening, &document, &error);
    const int unreadable = result != NORMA_DOCUMENT_OK;
    if (!unreadable)
        result = norma_check_document(document, &options, &findings, &error);
    else if (result != NORMA_DOCUMENT_ERROR_MEMORY)
        findings = norma_check_unreadable(&error, norma_file_format_of_path(path), &options);
    norma_document_close(document);
    if (take_lock(&w)) {
        norma_findings_free(findings);
        return NULL;
    }
    if (!findings) return document_refusal(result, &error);
    PyObject *list = findings_list(findings);
    return list ? Py_BuildValue("Ni", list, unreadable) : NULL;
}

/* The notes of a document from the given one on, as texts. */
static PyObject *notes_since(const norma_document *document, size_t first) {
    PyObject *list = PyList_New(0);
    for (size_t i = first; list && i < norma_document_note_count(document); i++) {
        PyObject *note = text(norma_document_note(document, i));
        if (!note || PyList_Append(list, note)) Py_CLEAR(list);
        Py_XDECREF(note);
    }
    return list;
}

/* document_fix(document, profile, mask of rules in bytes or None, unsafe, open by rays, threads) ->
 * (changed, fixes left out, [notes]), or why it was refused */
static PyObject *document_fix(PyObject *self, PyObject *arguments) {
    PyObject *capsule;
    const char *mask;
    int profile, unsafe, open_by_rays;
    Py_ssize_t mask_size;
    unsigned int threads;
    norma_fix_summary s;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "Oiz#ppI", &capsule, &profile, &mask, &mask_size, &unsafe,
            &open_by_rays, &threads))
        return NULL;
    norma_document *document = PyCapsule_GetPointer(capsule, DOCUMENT);
    if (!document) return NULL;
    const size_t known = norma_document_note_count(document);
    watch w = give_up_lock();
    const norma_check_options options = {.struct_size = sizeof options,
        .profile = (norma_check_profile)profile,
        .rules = (const uint8_t *)mask,
        .threads = threads,
        .progress = let_signals_in,
        .progress_user = &w,
        .open_by_rays = open_by_rays};
    const norma_document_result result = norma_fix_document(document, &options, unsafe, &s, &error);
    if (take_lock(&w)) return NULL;
    if (result != NORMA_DOCUMENT_OK) return document_refusal(result, &error);
    return Py_BuildValue("inN", s.changed, (Py_ssize_t)s.left_out, notes_since(document, known));
}

/* rules() -> [(id, name, render, print, fix, verb, what, why, how)] */
static PyObject *rules(PyObject *self, PyObject *unused) {
    size_t count;
    const norma_rule *rule = norma_rules(&count);
    PyObject *list = PyList_New((Py_ssize_t)count);
    (void)self, (void)unused;
    for (size_t i = 0; list && i < count; i++) {
        const norma_rule *r = &rule[i];
        PyObject *item = Py_BuildValue("ssiiissss", r->id, r->name, (int)r->render, (int)r->print,
            (int)r->fix, r->fix_verb, r->what, r->why, r->how);
        if (!item)
            Py_CLEAR(list);
        else
            PyList_SetItem(list, (Py_ssize_t)i, item);
    }
    return list;
}

/* rules_select(list, mask in bytes) -> the mask with the named rules marked, or the word that names
 * none */
static PyObject *rules_select(PyObject *self, PyObject *arguments) {
    const char *list, *mask;
    char unknown[64];
    Py_ssize_t size;
    uint8_t marked[256];
    size_t count;
    (void)self;
    norma_rules(&count);
    if (!PyArg_ParseTuple(arguments, "sy#", &list, &mask, &size)) return NULL;
    if ((size_t)size != count || count > sizeof marked) {
        PyErr_SetString(PyExc_ValueError, "mask: one byte for each rule is needed");
        return NULL;
    }
    memcpy(marked, mask, count);
    if (norma_rules_select(list, marked, unknown) != NORMA_OK) return text(unknown);
    return PyBytes_FromStringAndSize((const char *)marked, size);
}

/* weights() -> the names of the weights, in the order of their numbers */
static PyObject *weights(PyObject *self, PyObject *unused) {
    PyObject *list = PyList_New(0);
    (void)self, (void)unused;
    for (int i = 0; list && norma_weight_name((norma_weight)i); i++) {
        PyObject *name = PyUnicode_FromString(norma_weight_name((norma_weight)i));
        if (!name || PyList_Append(list, name)) Py_CLEAR(list);
        Py_XDECREF(name);
    }
    return list;
}

/* bounds() -> the upper bounds of the bins of a deviation, in radians */
static PyObject *bounds(PyObject *self, PyObject *unused) {
    PyObject *list = PyList_New(NORMA_DEVIATION_BINS);
    (void)self, (void)unused;
    for (Py_ssize_t i = 0; list && i < NORMA_DEVIATION_BINS; i++)
        PyList_SetItem(list, i, PyFloat_FromDouble(norma_deviation_bound_rad((size_t)i)));
    return list;
}

static PyObject *version(PyObject *self, PyObject *unused) {
    (void)self, (void)unused;
    return PyUnicode_FromString(norma_version());
}

static PyMethodDef methods[] = {{"normals", normals, METH_VARARGS, NULL},
    {"split", split, METH_VARARGS, NULL}, {"tangents", tangents, METH_VARARGS, NULL},
    {"index_corners", index_corners, METH_VARARGS, NULL}, {"orient", orient, METH_VARARGS, NULL},
    {"plan", plan, METH_VARARGS, NULL}, {"plan_update", plan_update, METH_VARARGS, NULL},
    {"plan_bytes", plan_bytes, METH_O, NULL},
    {"normal_matrices", normal_matrices, METH_VARARGS, NULL},
    {"matrix_info", matrix_info, METH_O, NULL},
    {"transform_normals", transform_normals, METH_VARARGS, NULL},
    {"indices", indices, METH_VARARGS, NULL}, {"copy", copy, METH_VARARGS, NULL},
    {"open_document", open_document, METH_VARARGS, NULL},
    {"document_meshes", document_meshes, METH_O, NULL},
    {"document_arrays", document_arrays, METH_VARARGS, NULL},
    {"document_compute", document_compute, METH_VARARGS, NULL},
    {"document_save", document_save, METH_VARARGS, NULL}, {"check", check, METH_VARARGS, NULL},
    {"document_fix", document_fix, METH_VARARGS, NULL}, {"rules", rules, METH_NOARGS, NULL},
    {"rules_select", rules_select, METH_VARARGS, NULL}, {"weights", weights, METH_NOARGS, NULL},
    {"bounds", bounds, METH_NOARGS, NULL}, {"version", version, METH_NOARGS, NULL},
    {NULL, NULL, 0, NULL}};

static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT, "_norma", NULL, 0, methods, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__norma(void);
PyMODINIT_FUNC PyInit__norma(void) { return PyModule_Create(&module); }
