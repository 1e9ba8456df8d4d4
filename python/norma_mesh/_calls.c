/* _calls.c: normals, splits, tangents, winding and plans of meshes, which come as tuples of
 * numbers. A refused call is asked once more what was wrong, so that the message can name it. */
#include "_norma.h"

/* The first two arguments of each call on a mesh: (positions, count, stride, format, corners,
 * count, size, face_starts, face_count, groups, hard) and (weight, weld, weld_distance,
 * non_manifold, fallback, x, y, z, stride, reasons, threads). */
int norma_py_mesh_call(PyObject *mesh, PyObject *options, mesh_call *call) {
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
    call->options.progress = norma_py_let_signals_in;
    call->options.progress_user = w;
    *w = norma_py_give_up_lock();
}

static PyObject *refused_mesh(norma_result result, const mesh_call *call, const float *crease) {
    norma_fault fault;
    norma_find_fault(&call->mesh, crease, &call->options, &fault);
    return norma_py_refusal(result, &fault);
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
        !norma_py_mesh_call(mesh, options, &call))
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
    if (norma_py_take_lock(&w)) return NULL;
    if (result) return refused_mesh(result, &call, of == OF_CORNERS ? &crease : NULL);
    return norma_py_counts(&report);
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
        !norma_py_mesh_call(mesh, options, &call))
        return NULL;
    watch w;
    begin_call(&call, &w);
    const norma_result result = norma_split(&call.mesh, crease, &call.options, at(corners),
        call.mesh.corner_count, at(sources), at(out), (size_t)capacity, &vertices, &report);
    if (norma_py_take_lock(&w)) return NULL;
    if (result) return refused_mesh(result, &call, &crease);
    return Py_BuildValue("Nn", norma_py_counts(&report), (Py_ssize_t)vertices);
}

int norma_py_attribute(PyObject *tuple, norma_attribute *attribute) {
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
        !norma_py_mesh_call(mesh, options, &call) || !norma_py_attribute(n, &directions) ||
        !norma_py_attribute(t, &texcoords))
        return NULL;
    watch w;
    begin_call(&call, &w);
    const norma_result result = norma_corner_tangents(&call.mesh, &directions, &texcoords,
        (norma_tangent_mode)mode, &call.options, at(out), (size_t)capacity, &report);
    if (norma_py_take_lock(&w)) return NULL;
    if (result) return refused_mesh(result, &call, NULL);
    return norma_py_counts(&report);
}

/* Of a list of (address, size, stride), each with count values; NULL: an exception is pending. */
static norma_stream *parse_streams(PyObject *list, size_t count) {
    const Py_ssize_t streams = PyList_Size(list);
    norma_stream *made = PyMem_Calloc((size_t)streams + 1, sizeof *made);
    if (!made) PyErr_NoMemory();
    for (Py_ssize_t i = 0; made && i < streams; ++i) {
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
    const int interrupted = norma_py_take_lock(&w);
    PyMem_Free(streams);
    if (interrupted) return NULL;
    return !result ? PyLong_FromSize_t(indexed.vertex_count) : norma_py_refusal(result, NULL);
}

/* orient(mesh, options, by_rays, reverse, capacity) -> what was found, or why it was refused */
static PyObject *orient(PyObject *self, PyObject *arguments) {
    PyObject *mesh, *options;
    int by_rays;
    address reverse;
    Py_ssize_t capacity;
    mesh_call call;
    norma_orient_report r;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OOiKn", &mesh, &options, &by_rays, &reverse, &capacity) ||
        !norma_py_mesh_call(mesh, options, &call))
        return NULL;
    watch w;
    begin_call(&call, &w);
    const norma_result result = norma_orient(
        &call.mesh, (norma_orient_open)by_rays, &call.options, at(reverse), (size_t)capacity, &r);
    if (norma_py_take_lock(&w)) return NULL;
    if (result) return refused_mesh(result, &call, NULL);
    return Py_BuildValue("nnnnnnnndnnn", (Py_ssize_t)r.parts, (Py_ssize_t)r.closed,
        (Py_ssize_t)r.open, (Py_ssize_t)r.one_sided, (Py_ssize_t)r.inward, (Py_ssize_t)r.nested,
        (Py_ssize_t)r.by_rays, (Py_ssize_t)r.undecided, r.least_confidence,
        (Py_ssize_t)r.reversed_faces, (Py_ssize_t)r.winding_conflicts,
        (Py_ssize_t)r.non_manifold_edges);
}

/* compare(base, normals, other, normals, options, most, samples, capacity) -> what was found, or
 * why it was refused */
static PyObject *compare(PyObject *self, PyObject *arguments) {
    PyObject *meshes[2], *normals_of[2], *options;
    double most;
    address samples;
    Py_ssize_t capacity;
    mesh_call calls[2];
    norma_surface surfaces[2];
    norma_comparison c;
    int same;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OOOOOdKn", &meshes[0], &normals_of[0], &meshes[1],
            &normals_of[1], &options, &most, &samples, &capacity))
        return NULL;
    for (int i = 0; i < 2; ++i) {
        norma_attribute n;
        if (!norma_py_mesh_call(meshes[i], options, &calls[i]) ||
            !norma_py_attribute(normals_of[i], &n))
            return NULL;
        surfaces[i] =
            (norma_surface){calls[i].mesh, {n.data, n.count, n.stride, n.format}, n.corners};
    }
    watch w;
    begin_call(&calls[0], &w);
    norma_result result = norma_compare(
        &surfaces[0], &surfaces[1], &calls[0].options, at(samples), (size_t)capacity, &same);
    if (!result) result = norma_compare_summary(at(samples), (size_t)capacity, most, NULL, &c);
    if (norma_py_take_lock(&w)) return NULL;
    for (int i = 0; i < 2 && result; ++i)
        if (i || norma_find_fault(&calls[i].mesh, NULL, NULL, NULL))
            return refused_mesh(result, &calls[i], NULL);
    return Py_BuildValue("innddddddddn", same, (Py_ssize_t)c.corners, (Py_ssize_t)c.missing, c.area,
        c.p50_rad, c.p99_rad, c.max_rad, c.p50_distance, c.p99_distance, c.max_distance,
        c.share_above, (Py_ssize_t)(c.worst == SIZE_MAX ? -1 : (Py_ssize_t)c.worst));
}

/* closest(mesh, points as an attribute, options, address of norma_closest, capacity) -> None, or
 * why it was refused */
static PyObject *closest(PyObject *self, PyObject *arguments) {
    PyObject *mesh, *points, *options;
    address found;
    Py_ssize_t capacity;
    mesh_call call;
    norma_attribute p;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OOOKn", &mesh, &points, &options, &found, &capacity) ||
        !norma_py_mesh_call(mesh, options, &call) || !norma_py_attribute(points, &p))
        return NULL;
    watch w;
    begin_call(&call, &w);
    const norma_result result =
        norma_closest_points(&call.mesh, (norma_vec3_view){p.data, p.count, p.stride, p.format},
            &call.options, at(found), (size_t)capacity);
    if (norma_py_take_lock(&w)) return NULL;
    if (result) return refused_mesh(result, &call, NULL);
    Py_RETURN_NONE;
}

/* ---- plans */

static const char PLAN[] = "norma_plan";

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
        !norma_py_mesh_call(mesh, options, &call))
        return NULL;
    watch w;
    begin_call(&call, &w);
    const norma_result result =
        norma_plan_create(&call.mesh, (norma_element)of, crease, &call.options, &made);
    if (norma_py_take_lock(&w)) {
        norma_plan_destroy(made);
        return NULL;
    }
    if (result) return refused_mesh(result, &call, &crease);
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
        !norma_py_mesh_call(mesh, options, &call))
        return NULL;
    const norma_plan *of = PyCapsule_GetPointer(capsule, PLAN);
    if (!of) return NULL;
    watch w;
    begin_call(&call, &w);
    const norma_result result = norma_plan_update(of, call.mesh.positions, at(moved),
        (size_t)moved_count, &call.options, at(out), (size_t)capacity, &report);
    if (norma_py_take_lock(&w)) return NULL;
    return !result ? norma_py_counts(&report) : norma_py_refusal(result, NULL);
}

static PyObject *plan_bytes(PyObject *self, PyObject *capsule) {
    const norma_plan *of = PyCapsule_GetPointer(capsule, PLAN);
    (void)self;
    return of ? PyLong_FromSize_t(norma_plan_bytes(of)) : NULL;
}

PyMethodDef norma_py_calls[] = {{"normals", normals, METH_VARARGS, NULL},
    {"split", split, METH_VARARGS, NULL}, {"tangents", tangents, METH_VARARGS, NULL},
    {"index_corners", index_corners, METH_VARARGS, NULL}, {"orient", orient, METH_VARARGS, NULL},
    {"compare", compare, METH_VARARGS, NULL}, {"closest", closest, METH_VARARGS, NULL},
    {"plan", plan, METH_VARARGS, NULL}, {"plan_update", plan_update, METH_VARARGS, NULL},
    {"plan_bytes", plan_bytes, METH_O, NULL}, {NULL, NULL, 0, NULL}};
