/* face_normals.c: norma_face_normals. Each face by itself; a weld matters only where it joins
 * positions that differ. */
#include "core/mesh/mesh.h"
#include "core/call/call.h"
#include "core/face/face.h"

enum { FACES_IN_CHUNK = 8192 };

typedef struct face_work {
    const core_kernels *kernels;
    const core_mesh *mesh;
    const core_output *output;
} face_work;

static int face_reason(const core_face *face) {
    if (face->flags & CORE_FACE_DIRECTED) return NORMA_REASON_NONE;
    return face->flags & CORE_FACE_FINITE ? NORMA_REASON_DEGENERATE : NORMA_REASON_NON_FINITE;
}

static int take_normal(const core_face *face, float normal[3]) {
    for (int k = 0; k < 3; k++) normal[k] = (float)face->normal[k] + 0.0F; /* never -0 */
    return face_reason(face);
}

static int normal_of_face(const void *mesh, size_t f, float normal[3]) {
    core_face face;
    norma_core_face_geometry(mesh, f, &face);
    return take_normal(&face, normal);
}

static int take_all_normals(const core_measured *measured, size_t count, float (*normals)[3]) {
    int all = 1;
    for (size_t i = 0; i < count; i++) all &= measured->corners[i] != 0;
    for (size_t i = 0; all && i < count; i++)
        for (int k = 0; k < 3; k++)
            normals[i][k] = (float)measured->row[measured->slot[i]][k] + 0.0F;
    return all;
}

static void write_block(const face_work *work, size_t begin, size_t end, core_tally *tally) {
    core_measured measured;
    float normals[CORE_FACES_AT_ONCE][3];
    norma_core_measure_faces(
        work->kernels, work->mesh, begin, end, NORMA_WEIGHT_UNIFORM, CORE_NO_CORNER, &measured);
    if (take_all_normals(&measured, end - begin, normals)) {
        norma_core_write_normals(work->output, begin, end - begin, (const float(*)[3])normals);
        return;
    }
    for (size_t f = begin; f < end; f++) {
        const int reason = normal_of_face(work->mesh, f, normals[0]);
        norma_core_write_element(work->output, f, reason, normals[0], tally);
    }
}

static void write_face_normals(const void *context, size_t begin, size_t end, core_tally *tally) {
    for (size_t f = begin, next; f < end; f = next) {
        next = end - f < CORE_FACES_AT_ONCE ? end : f + CORE_FACES_AT_ONCE;
        write_block(context, f, next, tally);
    }
}

/* The position that stands for a face among its neighbours. A face without corners is at none, and
 * gets the first normal. */
static uint32_t place_of_face(const void *mesh, size_t f) {
    const size_t begin = norma_core_face_begin(mesh, f);
    return begin < norma_core_face_end(mesh, f) ? norma_core_corner(mesh, begin) : UINT32_MAX;
}

static norma_result compute_faces(
    core_call *call, core_mesh *mesh, const core_output *output, norma_report *report) {
    const face_work work = {norma_core_kernels(call->level), mesh, output};
    const core_elements faces = {mesh, mesh->face_count, mesh, normal_of_face, place_of_face};
    core_tally tally = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    norma_core_stage(call, 0.1, 0.3);
    norma_result result =
        call->options.weld == NORMA_WELD_DISTANCE ? norma_core_weld(call, mesh) : NORMA_OK;
    norma_core_stage(call, 0.3, 0.95);
    if (result == NORMA_OK)
        result = norma_core_write_chunks(
            call, mesh->face_count, FACES_IN_CHUNK, write_face_normals, &work, &tally);
    const size_t without = tally.degenerate.count + tally.non_finite.count;
    if (result == NORMA_OK && output->nearest && without)
        result = norma_core_fill_nearest(call, &faces, output, without);
    if (mesh->weld) norma_core_unweld(call, mesh);
    result = norma_core_finish(call, result);
    if (result == NORMA_OK) norma_core_write_report(report, &tally, NULL, NULL);
    return result;
}

norma_result norma_face_normals(const norma_mesh *mesh, const norma_options *options,
    float *normals, size_t capacity, norma_report *report) {
    core_call call;
    core_mesh checked;
    core_output output;
    norma_result result = norma_core_begin(&call, options);
    if (result == NORMA_OK) result = norma_core_mesh_shape(mesh, &checked);
    if (result == NORMA_OK) norma_core_share(&call, checked.corner_count);
    if (result == NORMA_OK)
        result = norma_core_output_open(&call, normals, checked.face_count, capacity, &output);
    norma_core_stage(&call, 0, 0.1);
    if (result == NORMA_OK) result = norma_core_mesh_content(&call, &checked);
    return result == NORMA_OK ? compute_faces(&call, &checked, &output, report) : result;
}
