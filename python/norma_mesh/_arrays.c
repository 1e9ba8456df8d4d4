/* _arrays.c: arrays that the library cannot read as they lie: indices of other types and strides
 * become 32 bits wide, rows with gaps between them are packed. */
#include "_norma.h"
#include <string.h>

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
    for (; (block + 1) * 1024 <= count; ++block) {
        uint64_t bad = 0;
        for (Py_ssize_t i = block * 1024; i < (block + 1) * 1024; ++i) {
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
    watch w = norma_py_give_up_lock();
    uint32_t *to = at(out);
    const unsigned char *place = at(from);
    Py_ssize_t done = 0;
    if (size == 8 && column_stride == 8 && (rows < 2 || row_stride == 8 * columns) && from % 8 == 0)
        done = 1024 * convert_packed((const int64_t *)(const void *)place, rows * columns, to);
    for (; done < rows * columns && bad < 0; ++done) {
        const unsigned char *element = place + done / columns * row_stride;
        const int64_t index = read_index(element + done % columns * column_stride, size, is_signed);
        if (index < 0 || index >= UINT32_MAX)
            bad = done;
        else
            to[done] = (uint32_t)index;
    }
    norma_py_take_lock(&w);
    return PyLong_FromSsize_t(bad);
}

/* copy(from, rows, bytes of a row, stride, out): rows that lie stride bytes apart, packed. */
static PyObject *copy(PyObject *self, PyObject *arguments) {
    address from, out;
    Py_ssize_t rows, bytes, stride;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "KnnnK", &from, &rows, &bytes, &stride, &out)) return NULL;
    const unsigned char *in = at(from);
    watch w = norma_py_give_up_lock();
    for (Py_ssize_t i = 0; i < rows; ++i)
        memcpy((unsigned char *)at(out) + i * bytes, in + i * (stride ? stride : bytes),
            (size_t)bytes);
    norma_py_take_lock(&w);
    Py_RETURN_NONE;
}

PyMethodDef norma_py_arrays[] = {{"indices", indices, METH_VARARGS, NULL},
    {"copy", copy, METH_VARARGS, NULL}, {NULL, NULL, 0, NULL}};
