/* _norma.h: what the parts of the extension share. Each part has a table of its functions, which
 * _norma.c puts into the module. They speak the limited API of Python 3.9. */
#ifndef NORMA_PYTHON_H
#define NORMA_PYTHON_H
#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x03090000
#include <Python.h>

#include <norma/check.h>
#include <norma/document.h>
#include <norma/norma.h>
#include <stdint.h>

extern PyMethodDef norma_py_calls[], norma_py_matrices[], norma_py_arrays[], norma_py_files[],
    norma_py_rules[];

/* The limited API has no buffers: arrays come as addresses. */
typedef unsigned long long address;
static inline void *at(address value) { return (void *)(uintptr_t)value; } // NOLINT

/* A call without the interpreter's lock. norma_py_let_signals_in is its progress callback: it takes
 * the lock back twenty times a second, and cancels the call after Ctrl-C. */
typedef struct watch {
    PyThreadState *thread;
    double last;
    int interrupted;
} watch;
watch norma_py_give_up_lock(void);
int norma_py_let_signals_in(void *user, double fraction);
/* Returns whether an exception is pending. */
int norma_py_take_lock(watch *w);

/* The name of the capsule of an open document. */
extern const char norma_py_document[];
/* Opens a path, given in bytes, or the contents of a file of this name (or None). Needs no lock. */
norma_document_result norma_py_open(PyObject *name, PyObject *bytes,
    const norma_document_options *options, norma_document **document, norma_document_error *error);

/* A mesh and the options of a call on it, of the two tuples that _arguments.py makes. */
typedef struct mesh_call {
    norma_mesh mesh;
    norma_options options;
} mesh_call;
int norma_py_mesh_call(PyObject *mesh, PyObject *options, mesh_call *call);
int norma_py_attribute(PyObject *tuple, norma_attribute *attribute);

PyObject *norma_py_text(const char *words);
PyObject *norma_py_counts(const norma_report *report);
/* What a refused call answers: (result, argument, index or -1, what was expected). */
PyObject *norma_py_refusal(norma_result result, const norma_fault *fault);
/* What a document call that fails answers: (result, message). */
PyObject *norma_py_document_refusal(
    norma_document_result result, const norma_document_error *error);
#endif
