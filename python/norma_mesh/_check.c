/* _check.c: the rules: what they find in a file, and their fixes. */
#include "_norma.h"
#include <string.h>

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
    for (Py_ssize_t i = 0; bins && i < NORMA_DEVIATION_BINS; ++i)
        PyList_SetItem(bins, i, PyLong_FromSize_t(d->histogram[i]));
    return Py_BuildValue("iidddddN", (int)d->shading, (int)d->weight, d->crease_angle_rad,
        d->mean_rad, d->p50_rad, d->p99_rad, d->max_rad, bins);
}

/* (id, name, severity, where, label, count, worst value, unit, worst, samples, fix, message,
 * deviation, mesh, cause, impact) */
static PyObject *finding_of(const norma_finding *f) {
    PyObject *samples = PyList_New((Py_ssize_t)f->sample_count);
    for (size_t i = 0; samples && i < f->sample_count; ++i) {
        PyObject *sample = sample_of(&f->samples[i]);
        if (!sample)
            Py_CLEAR(samples);
        else
            PyList_SetItem(samples, (Py_ssize_t)i, sample);
    }
    if (!samples) return NULL;
    return Py_BuildValue("ssiNNndsNNiNNKss", f->rule->id, f->rule->name, (int)f->severity,
        norma_py_text(f->where), norma_py_text(f->label), (Py_ssize_t)f->count, f->worst_value,
        f->unit, sample_of(&f->worst), samples, (int)f->fix, norma_py_text(f->message),
        deviation_of(f->deviation), (unsigned long long)f->mesh, f->rule->cause, f->rule->why);
}

static PyObject *findings_list(norma_findings *findings) {
    PyObject *list = PyList_New((Py_ssize_t)norma_findings_count(findings));
    for (size_t i = 0; list && i < norma_findings_count(findings); ++i) {
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

/* check(path in bytes or None, the file's bytes or None, format, profile, strict, samples, mask of
 * rules in bytes or None, threads) -> (profile, partly, unreadable, [findings]); why it was refused
 * if there was no memory */
static PyObject *check(PyObject *self, PyObject *arguments) {
    const char *mask;
    PyObject *path, *bytes;
    int format, profile, strict;
    Py_ssize_t samples, mask_size;
    unsigned int threads;
    norma_document *document = NULL;
    norma_findings *findings = NULL;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OOiipnz#I", &path, &bytes, &format, &profile, &strict,
            &samples, &mask, &mask_size, &threads))
        return NULL;
    watch w = norma_py_give_up_lock();
    const norma_document_options opening = {.struct_size = sizeof opening,
        .format = (norma_file_format)format,
        .threads = threads,
        .progress = norma_py_let_signals_in,
        .progress_user = &w,
        .lenient = 1};
    const norma_check_options options = {.struct_size = sizeof options,
        .profile = (norma_check_profile)profile,
        .strict = strict,
        .max_samples = (size_t)samples,
        .rules = (const uint8_t *)mask,
        .threads = threads,
        .progress = norma_py_let_signals_in,
        .progress_user = &w};
    norma_document_result result = norma_py_open(path, bytes, &opening, &document, &error);
    const int unreadable = result != NORMA_DOCUMENT_OK;
    if (!unreadable) result = norma_check_document(document, &options, &findings, &error);
    if (!unreadable && result == NORMA_DOCUMENT_OK)
        result =
            norma_document_try_fixes(document, &options, NORMA_SEVERITY_INFO, findings, &error);
    if (unreadable && result != NORMA_DOCUMENT_ERROR_MEMORY)
        findings = norma_check_unreadable(&error,
            format || path == Py_None ? (norma_file_format)format
                                      : norma_file_format_of_path(PyBytes_AsString(path)),
            &options);
    norma_document_close(document);
    if (result != NORMA_DOCUMENT_OK && !unreadable) {
        norma_findings_free(findings);
        findings = NULL;
    }
    if (norma_py_take_lock(&w)) {
        norma_findings_free(findings);
        return NULL;
    }
    if (!findings) return norma_py_document_refusal(result, &error);
    PyObject *list = findings_list(findings);
    return list ? Py_BuildValue("Ni", list, unreadable) : NULL;
}

/* check_arrays(mesh, options, normals or None, profile, strict, samples, mask of rules or None) ->
 * (profile, partly, [findings]), or why it was refused. Normals are one for each corner if they
 * have corners, else one for each position. */
static PyObject *check_arrays(PyObject *self, PyObject *arguments) {
    PyObject *mesh, *options_of, *normals;
    const char *mask;
    int profile, strict;
    Py_ssize_t samples, mask_size;
    mesh_call call;
    norma_attribute n = {0};
    norma_findings *findings = NULL;
    (void)self;
    if (!PyArg_ParseTuple(arguments, "OOOipnz#", &mesh, &options_of, &normals, &profile, &strict,
            &samples, &mask, &mask_size) ||
        !norma_py_mesh_call(mesh, options_of, &call) ||
        (normals != Py_None && !norma_py_attribute(normals, &n)))
        return NULL;
    const size_t faces = call.mesh.face_starts ? call.mesh.face_count : call.mesh.corner_count / 3;
    const norma_check_mesh one = {.info = {.name = "",
                                      .where = "",
                                      .vertices = call.mesh.positions.count,
                                      .faces = faces,
                                      .triangles = call.mesh.corner_count - 2 * faces,
                                      .normals = !n.count    ? NORMA_NORMALS_NONE
                                                 : n.corners ? NORMA_NORMALS_PER_CORNER
                                                             : NORMA_NORMALS_PER_VERTEX,
                                      .encoding = n.count ? "float" : ""},
        .data = {.mesh = call.mesh,
            .normals = {n.data, n.count, n.stride, n.format},
            .corner_normals = n.corners},
        .attributes = {.material = SIZE_MAX, .tangent_encoding = "", .ignore = ""},
        .material = {.name = "", .where = "", .base_color = {1, 1, 1, 1}, .ignore = ""}};
    const norma_check_scene scene = {
        .meshes = &one, .mesh_count = 1, .format = n.corners ? NORMA_FILE_OBJ : NORMA_FILE_PLY};
    watch w = norma_py_give_up_lock();
    const norma_check_options options = {.struct_size = sizeof options,
        .profile = (norma_check_profile)profile,
        .strict = strict,
        .max_samples = (size_t)samples,
        .rules = (const uint8_t *)mask,
        .threads = call.options.threads,
        .progress = norma_py_let_signals_in,
        .progress_user = &w};
    const norma_result result = norma_check_scene_run(&scene, &options, &findings);
    if (norma_py_take_lock(&w)) {
        norma_findings_free(findings);
        return NULL;
    }
    if (!result) return findings_list(findings);
    norma_fault fault;
    norma_find_fault(&call.mesh, NULL, &call.options, &fault);
    return norma_py_refusal(result, &fault);
}

/* The notes of a document from the given one on, as texts. */
static PyObject *notes_since(const norma_document *document, size_t first) {
    PyObject *list = PyList_New(0);
    for (size_t i = first; list && i < norma_document_note_count(document); ++i) {
        PyObject *note = norma_py_text(norma_document_note(document, i));
        if (!note || PyList_Append(list, note)) Py_CLEAR(list);
        Py_XDECREF(note);
    }
    return list;
}

/* document_fix(document, profile, mask of rules in bytes or None, unsafe (2: of informations too),
 * open by rays, threads) -> (changed, fixes left out, [notes]), or why it was refused */
static PyObject *document_fix(PyObject *self, PyObject *arguments) {
    PyObject *capsule;
    const char *mask;
    int profile, unsafe, open_by_rays;
    Py_ssize_t mask_size;
    unsigned int threads;
    norma_fix_summary s;
    norma_document_error error = {0};
    (void)self;
    if (!PyArg_ParseTuple(arguments, "Oiz#ipI", &capsule, &profile, &mask, &mask_size, &unsafe,
            &open_by_rays, &threads))
        return NULL;
    norma_document *document = PyCapsule_GetPointer(capsule, norma_py_document);
    if (!document) return NULL;
    const size_t known = norma_document_note_count(document);
    watch w = norma_py_give_up_lock();
    const norma_check_options options = {.struct_size = sizeof options,
        .profile = (norma_check_profile)profile,
        .rules = (const uint8_t *)mask,
        .threads = threads,
        .progress = norma_py_let_signals_in,
        .progress_user = &w,
        .open_by_rays = open_by_rays,
        .fix_from = unsafe > 1 ? NORMA_SEVERITY_NONE : NORMA_SEVERITY_WARNING};
    const norma_document_result result = norma_fix_document(document, &options, unsafe, &s, &error);
    if (norma_py_take_lock(&w)) return NULL;
    if (result != NORMA_DOCUMENT_OK) return norma_py_document_refusal(result, &error);
    return Py_BuildValue("inN", s.changed, (Py_ssize_t)s.left_out, notes_since(document, known));
}

/* rules() -> [(id, name, render, print, fix, verb, what, cause, why, how)] */
static PyObject *rules(PyObject *self, PyObject *unused) {
    size_t count;
    const norma_rule *rule = norma_rules(&count);
    PyObject *list = PyList_New((Py_ssize_t)count);
    (void)self, (void)unused;
    for (size_t i = 0; list && i < count; ++i) {
        const norma_rule *r = &rule[i];
        PyObject *item = Py_BuildValue("ssiiisssss", r->id, r->name, (int)r->render, (int)r->print,
            (int)r->fix, r->fix_verb, r->what, r->cause, r->why, r->how);
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
    if (norma_rules_select(list, marked, unknown)) return norma_py_text(unknown);
    return PyBytes_FromStringAndSize((const char *)marked, size);
}

/* bounds() -> the upper bounds of the bins of a deviation, in radians */
static PyObject *bounds(PyObject *self, PyObject *unused) {
    PyObject *list = PyList_New(NORMA_DEVIATION_BINS);
    (void)self, (void)unused;
    for (Py_ssize_t i = 0; list && i < NORMA_DEVIATION_BINS; ++i)
        PyList_SetItem(list, i, PyFloat_FromDouble(norma_deviation_bound_rad((size_t)i)));
    return list;
}

PyMethodDef norma_py_rules[] = {{"check", check, METH_VARARGS, NULL},
    {"check_arrays", check_arrays, METH_VARARGS, NULL},
    {"document_fix", document_fix, METH_VARARGS, NULL}, {"rules", rules, METH_NOARGS, NULL},
    {"rules_select", rules_select, METH_VARARGS, NULL}, {"bounds", bounds, METH_NOARGS, NULL},
    {NULL, NULL, 0, NULL}};
