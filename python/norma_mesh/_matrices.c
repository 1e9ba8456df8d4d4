/* _matrices.c: normal matrices, normals through them and through skins, and normals in few bits.
 * Matrices of Python are rows, those of the library columns: what is handed over is the transpose,
 * and the cofactors of a transpose are the transposed cofactors. */
#include "_norma.h"
#include <math.h>

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
    for (size_t i = 0; doubles && i < (size_t)count && !norma_py_let_signals_in(&w, 0); ++i) {
        const double *model = (const double *)at(models) + 16 * i;
        double *normal_matrix = (double *)at(out) + 9 * i;
        if (norma_normal_matrix_double(model, NORMA_WINDING_REVERSED, normal_matrix, NULL) &&
            !result) {
            result = NORMA_ERROR_ARGUMENT;
            fault.index = i;
        }
    }
    if (result && !doubles) norma_find_model_fault(at(models), 0, (size_t)count, &fault);
    if (norma_py_take_lock(&w)) return NULL;
    if (result) return norma_py_refusal(result, &fault);
    Py_RETURN_NONE;
}

/* matrix_info(model) -> (kind, rank, mirrored, determinant, anisotropy, worst error, x, y, z) */
static PyObject *matrix_info(PyObject *self, PyObject *argument) {
    const address model = PyLong_AsUnsignedLongLong(argument);
    double columns[16], unused[9];
    norma_matrix_info info;
    (void)self;
    if (PyErr_Occurred()) return NULL;
    for (size_t i = 0; i < 16; ++i) columns[i] = ((const double *)at(model))[i % 4 * 4 + i / 4];
    const norma_result result =
        norma_normal_matrix_double(columns, NORMA_WINDING_REVERSED, unused, &info);
    if (result)
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
    if (result) return norma_py_refusal(result, NULL);
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
    return !result ? norma_py_counts(&report) : norma_py_refusal(result, NULL);
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
    if (result) return norma_py_refusal(result, NULL);
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
    if (result) norma_find_skin_fault(&s, &options, &fault);
    if (norma_py_take_lock(&w)) return NULL;
    return !result ? norma_py_counts(&report) : norma_py_refusal(result, &fault);
}

/* A row of heights, the ones before and after it (or itself at the border), and what 1 in the
 * differences across two columns and along the rows is in slope. */
typedef struct height_row {
    const void *here, *before, *after;
    int doubles;
    double across, along;
} height_row;

enum { HEIGHTS_AT_ONCE = 256 };

/* Functions that are compiled for AVX2 too, which the loader chooses where it is there. The bits
 * are the same: AVX2 has no fused products. */
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) &&       \
    !defined(__SANITIZE_ADDRESS__)
#define ALSO_AVX2   __attribute__((target_clones("avx2", "default")))
#define WITHIN_BOTH __attribute__((always_inline)) inline
#else
#define ALSO_AVX2
#define WITHIN_BOTH
#endif

static double height_of(const void *row, int doubles, Py_ssize_t i) {
    return doubles ? ((const double *)row)[i] : (double)((const float *)row)[i];
}

/* A single one, at the border or too steep for squares of floats. Returns whether it is not finite;
 * then it is zero. */
static int write_height_normal(
    const height_row *r, Py_ssize_t columns, Py_ssize_t i, float normal[3]) {
    const Py_ssize_t left = i > 0 ? i - 1 : i, right = i + 1 < columns ? i + 1 : i;
    const double x = (height_of(r->here, r->doubles, left) -
                         height_of(r->here, r->doubles, right)) *
                     r->across * (right - left == 2 ? 1 : 2),
                 y = (height_of(r->before, r->doubles, i) - height_of(r->after, r->doubles, i)) *
                     r->along,
                 steep = fmax(fabs(x), fabs(y)), unit = steep > 1e150 ? 1 / steep : 1,
                 length = sqrt(x * unit * (x * unit) + y * unit * (y * unit) + unit * unit);
    const int fine = isfinite(x) && isfinite(y);
    normal[0] = fine ? (float)(x * unit / length) : 0;
    normal[1] = fine ? (float)(y * unit / length) : 0;
    normal[2] = fine ? (float)(unit / length) : 0;
    return !fine;
}

/* x, y: slopes of count heights from a place inside the row on. Plain loops, which compilers turn
 * into lanes. */
static WITHIN_BOTH void slopes_of(
    const height_row *r, Py_ssize_t first, int count, float *x, float *y) {
    if (r->doubles) {
        const double *h = (const double *)r->here + first, *b = (const double *)r->before + first,
                     *a = (const double *)r->after + first;
        for (int i = 0; i < count; ++i) x[i] = (float)((h[i - 1] - h[i + 1]) * r->across);
        for (int i = 0; i < count; ++i) y[i] = (float)((b[i] - a[i]) * r->along);
    } else {
        const float *h = (const float *)r->here + first, *b = (const float *)r->before + first,
                    *a = (const float *)r->after + first;
        const float across = (float)r->across, along = (float)r->along;
        for (int i = 0; i < count; ++i) x[i] = (h[i - 1] - h[i + 1]) * across;
        for (int i = 0; i < count; ++i) y[i] = (b[i] - a[i]) * along;
    }
}

/* Three floats for each height. Returns how many are not finite. */
ALSO_AVX2 static Py_ssize_t write_height_normals(
    const height_row *r, Py_ssize_t columns, float *out) {
    Py_ssize_t wrong = write_height_normal(r, columns, 0, out);
    float x[HEIGHTS_AT_ONCE], y[HEIGHTS_AT_ONCE], z[HEIGHTS_AT_ONCE];
    for (Py_ssize_t first = 1; first + 1 < columns; first += HEIGHTS_AT_ONCE) {
        const Py_ssize_t left = columns - 1 - first;
        const int count = left < HEIGHTS_AT_ONCE ? (int)left : HEIGHTS_AT_ONCE;
        float *to = out + 3 * first;
        slopes_of(r, first, count, x, y);
        int steep = 0;
        for (int i = 0; i < count; ++i) {
            z[i] = 1 / sqrtf(x[i] * x[i] + y[i] * y[i] + 1);
            x[i] *= z[i];
            y[i] *= z[i];
            steep |= !(z[i] > 1e-15F);
        }
        for (int i = 0; i < count; ++i) {
            to[3 * i] = x[i];
            to[3 * i + 1] = y[i];
            to[3 * i + 2] = z[i];
        }
        for (int i = 0; steep && i < count; ++i)
            if (!(z[i] > 1e-15F)) wrong += write_height_normal(r, columns, first + i, to + 3 * i);
    }
    if (columns > 1) wrong += write_height_normal(r, columns, columns - 1, out + 3 * columns - 3);
    return wrong;
}

/* height_normals(heights, rows, columns, doubles, spacing of x, of y, out) -> how many have none */
static PyObject *height_normals(PyObject *self, PyObject *arguments) {
    address heights, out;
    Py_ssize_t rows, columns, wrong = 0;
    int doubles;
    double dx, dy;
    (void)self;
    if (!PyArg_ParseTuple(
            arguments, "KnnpddK", &heights, &rows, &columns, &doubles, &dx, &dy, &out))
        return NULL;
    const Py_ssize_t row_bytes = columns * (doubles ? 8 : 4);
    watch w = norma_py_give_up_lock();
    for (Py_ssize_t i = 0; i < rows; ++i) {
        const Py_ssize_t before = i > 0 ? i - 1 : i, after = i + 1 < rows ? i + 1 : i;
        const char *first = at(heights);
        const height_row row = {first + i * row_bytes, first + before * row_bytes,
            first + after * row_bytes, doubles, 0.5 / dx, (after - before == 2 ? 0.5 : 1) / dy};
        wrong += write_height_normals(&row, columns, (float *)at(out) + 3 * i * columns);
    }
    norma_py_take_lock(&w);
    return PyLong_FromSsize_t(wrong);
}

PyMethodDef norma_py_matrices[] = {{"normal_matrices", normal_matrices, METH_VARARGS, NULL},
    {"matrix_info", matrix_info, METH_O, NULL},
    {"transform_normals", transform_normals, METH_VARARGS, NULL},
    {"encode_normals", encode_normals, METH_VARARGS, NULL},
    {"decode_normals", decode_normals, METH_VARARGS, NULL},
    {"encoding_error_rad", encoding_error_rad, METH_O, NULL}, {"skin", skin, METH_VARARGS, NULL},
    {"height_normals", height_normals, METH_VARARGS, NULL}, {NULL, NULL, 0, NULL}};
