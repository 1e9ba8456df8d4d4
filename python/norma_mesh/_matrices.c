/* _matrices.c: normal matrices, normals through them and through skins, and normals in few bits.
 * Matrices of Python are rows, those of the library columns: what is handed over is the transpose,
 * and the cofactors of a transpose are the transposed cofactors. */
#include "_norma.h"

static PyObject *normal_matrices(PyObject *self, PyObject *arguments) {
    address models, out;
    Py_ssize_t count;
    int doubles;
    norma_fault fault = {NORMA_ERROR_ARGUMENT, "models", SIZE_MAX, "finite in the upper 3x3"};
    norma_result result = NORMA_OK;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "KnpK", &models, &count, &doubles, &out)) return NULL;
    watch w = norma_py_give_up_lock();
    if (!doubles)
        result = norma_normal_matrices(
            at(models), (size_t)count, NORMA_WINDING_REVERSED, at(out), (size_t)count);
    for (size_t i = 0; doubles && i < (size_t)count && !norma_py_let_signals_in(&w, 0); i++) {
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
    if (norma_py_take_lock(&w)) return NULL;
    if (result != NORMA_OK) return norma_py_refusal(result, &fault);
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
        return norma_py_refusal(
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
    watch w = norma_py_give_up_lock();
    const norma_vec3_view view = {at(in), (size_t)count, (size_t)stride, (norma_format)format};
    const norma_result result =
        norma_transform_normals(at(matrix), view, at(out), (size_t)out_stride, (size_t)count);
    if (norma_py_take_lock(&w)) return NULL;
    if (result != NORMA_OK) return norma_py_refusal(result, NULL);
    Py_RETURN_NONE;
}

/* encode_normals(normals, count, stride, format, encoding, codes) -> counts, or why it was refused
 */
static PyObject *encode_normals(PyObject *self, PyObject *arguments) {
    address in, codes;
    Py_ssize_t count, stride;
    int format, encoding;
    norma_report report;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "KnniiK", &in, &count, &stride, &format, &encoding, &codes))
        return NULL;
    watch w = norma_py_give_up_lock();
    const norma_vec3_view view = {at(in), (size_t)count, (size_t)stride, (norma_format)format};
    const norma_result result =
        norma_encode_normals(view, (norma_encoding)encoding, at(codes), 0, (size_t)count, &report);
    if (norma_py_take_lock(&w)) return NULL;
    return result == NORMA_OK ? norma_py_counts(&report) : norma_py_refusal(result, NULL);
}

/* decode_normals(codes, count, encoding, out, stride) -> None, or why it was refused */
static PyObject *decode_normals(PyObject *self, PyObject *arguments) {
    address codes, out;
    Py_ssize_t count, out_stride;
    int encoding;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "KniKn", &codes, &count, &encoding, &out, &out_stride))
        return NULL;
    watch w = norma_py_give_up_lock();
    const norma_result result = norma_decode_normals(
        at(codes), 0, (size_t)count, (norma_encoding)encoding, at(out), (size_t)out_stride);
    if (norma_py_take_lock(&w)) return NULL;
    if (result != NORMA_OK) return norma_py_refusal(result, NULL);
    Py_RETURN_NONE;
}

static PyObject *encoding_error_rad(PyObject *self, PyObject *argument) {
    const long encoding = PyLong_AsLong(argument);
    (void)self;
    if (PyErr_Occurred()) return NULL;
    return PyFloat_FromDouble(norma_encoding_error_rad((norma_encoding)encoding));
}

/* ---- skins */

static int parse_view(PyObject *tuple, norma_vec3_view *view) {
    address data;
    Py_ssize_t count, stride;
    int format;
    if (!PyArg_ParseTuple(tuple, "Knni", &data, &count, &stride, &format)) return 0;
    *view = (norma_vec3_view){at(data), (size_t)count, (size_t)stride, (norma_format)format};
    return 1;
}

static int parse_skin(PyObject *tuple, norma_skin *skin) {
    address matrices, joints, weights;
    Py_ssize_t joint_count, joint_size, influences, vertices;
    int blend;
    if (!PyArg_ParseTuple(tuple, "KnKnKnni", &matrices, &joint_count, &joints, &joint_size,
            &weights, &influences, &vertices, &blend))
        return 0;
    *skin = (norma_skin){.matrices = at(matrices),
        .joint_count = (size_t)joint_count,
        .joints = at(joints),
        .joint_size = (size_t)joint_size,
        .weights = at(weights),
        .influences = (size_t)influences,
        .vertex_count = (size_t)vertices,
        .blend = (norma_blend)blend};
    return 1;
}

/* skin(of, skin, in, normals, options of calls on meshes, out) -> counts, or why it was refused;
 * of: 0 positions, 1 normals, 2 tangents, for which normals are the skinned ones */
static PyObject *skin(PyObject *self, PyObject *arguments) {
    PyObject *skin_tuple, *in_tuple, *normals_tuple;
    address out;
    Py_ssize_t stride;
    int of, fallback;
    float x, y, z;
    unsigned int threads;
    norma_skin s;
    norma_vec3_view in, normals;
    norma_report report = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "iOOO(ifffnI)K", &of, &skin_tuple, &in_tuple, &normals_tuple,
            &fallback, &x, &y, &z, &stride, &threads, &out) ||
        !parse_skin(skin_tuple, &s) || !parse_view(in_tuple, &in) ||
        !parse_view(normals_tuple, &normals))
        return NULL;
    watch w = norma_py_give_up_lock();
    const norma_options options = {.struct_size = sizeof options,
        .fallback = (norma_fallback)fallback,
        .fallback_normal = {x, y, z},
        .normal_stride = (size_t)stride,
        .threads = threads,
        .progress = norma_py_let_signals_in,
        .progress_user = &w};
    norma_fault fault = {0};
    const norma_result result =
        of == 0   ? norma_skin_positions(&s, in, &options, at(out), s.vertex_count)
        : of == 1 ? norma_skin_normals(&s, in, &options, at(out), s.vertex_count, &report)
                  : norma_skin_tangents(&s, in.data, normals, &options, at(out), s.vertex_count);
    if (result != NORMA_OK) norma_find_skin_fault(&s, &options, &fault);
    if (norma_py_take_lock(&w)) return NULL;
    return result == NORMA_OK ? norma_py_counts(&report) : norma_py_refusal(result, &fault);
}

PyMethodDef norma_py_matrices[] = {{"normal_matrices", normal_matrices, METH_VARARGS, NULL},
    {"matrix_info", matrix_info, METH_O, NULL},
    {"transform_normals", transform_normals, METH_VARARGS, NULL},
    {"encode_normals", encode_normals, METH_VARARGS, NULL},
    {"decode_normals", decode_normals, METH_VARARGS, NULL},
    {"encoding_error_rad", encoding_error_rad, METH_O, NULL}, {"skin", skin, METH_VARARGS, NULL},
    {NULL, NULL, 0, NULL}};
