/* _norma.c: the extension module below norma_mesh, and what its parts share. The Python files
 * beside it look at every argument and hand over arrays as addresses, counts and strides; the parts
 * hand them to the library. Nothing here is public.
 *
 * A call gives up the interpreter's lock. Its progress callback takes the lock back twenty times a
 * second to let signals in: Ctrl-C cancels the call, which then raises KeyboardInterrupt. */
#include "_norma.h"
#include <string.h>
#include <time.h>

/* ---- signals while the lock is given up */

static double seconds(void) {
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

int norma_py_let_signals_in(void *user, double fraction) {
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

watch norma_py_give_up_lock(void) {
    return (watch){.last = seconds(), .thread = PyEval_SaveThread()};
}

int norma_py_take_lock(watch *w) {
    PyEval_RestoreThread(w->thread);
    return w->interrupted;
}

/* ---- answers */

PyObject *norma_py_text(const char *words) {
    return PyUnicode_DecodeUTF8(words, (Py_ssize_t)strlen(words), "replace");
}

PyObject *norma_py_counts(const norma_report *r) {
    return Py_BuildValue("nnnnnn", (Py_ssize_t)r->degenerate_faces.count,
        (Py_ssize_t)r->non_finite.count, (Py_ssize_t)r->unreferenced.count,
        (Py_ssize_t)r->cancelled.count, (Py_ssize_t)r->non_manifold_edges.count,
        (Py_ssize_t)r->winding_conflicts.count);
}

PyObject *norma_py_refusal(norma_result result, const norma_fault *fault) {
    const int known = fault && fault->result == result && fault->argument;
    return Py_BuildValue("isns", (int)result, known ? fault->argument : "",
        known && fault->index != SIZE_MAX ? (Py_ssize_t)fault->index : -1,
        known && fault->expected ? fault->expected : norma_result_text(result));
}

/* ---- the module */

/* weights() -> the names of the weights, in the order of their numbers */
static PyObject *weights(PyObject *self, PyObject *unused) {
    PyObject *list = PyList_New(0);
    (void)self, (void)unused;
    for (int i = 0; list && norma_weight_name((norma_weight)i); ++i) {
        PyObject *name = PyUnicode_FromString(norma_weight_name((norma_weight)i));
        if (!name || PyList_Append(list, name)) Py_CLEAR(list);
        Py_XDECREF(name);
    }
    return list;
}

static PyObject *version(PyObject *self, PyObject *unused) {
    (void)self, (void)unused;
    return PyUnicode_FromString(norma_version());
}

static PyMethodDef methods[] = {{"weights", weights, METH_NOARGS, NULL},
    {"version", version, METH_NOARGS, NULL}, {NULL, NULL, 0, NULL}};

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "_norma", NULL, 0, methods, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__norma(void);
PyMODINIT_FUNC PyInit__norma(void) {
    PyMethodDef *parts[] = {
        norma_py_calls, norma_py_matrices, norma_py_arrays, norma_py_files, norma_py_rules};
    PyObject *module = PyModule_Create(&definition);
    for (size_t i = 0; module && i < sizeof parts / sizeof *parts; ++i)
        if (PyModule_AddFunctions(module, parts[i])) Py_CLEAR(module);
    return module;
}
