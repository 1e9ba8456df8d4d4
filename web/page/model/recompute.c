/* recompute.c: the normals of a model's mesh as the page asks for them, and by how much the stored
 * ones differ. */
#include "model.h"
#include "../../package/wasm/calls.h"
#include "../../package/wasm/exports.h"
#include <math.h>
#include <string.h>

enum { WANT_CREASED = 0, WANT_FLAT, WANT_STORED };

static void copy3(float *to, const float *from) { memcpy(to, from, 3 * sizeof *to); }

/* One normal for each face, at each of its corners. From the last to the first: of a triangle mesh
 * the face's normal lies before its corners'. */
static norma_result compute_flat(const model_mesh *mesh, const norma_options *options) {
    const norma_result result =
        norma_face_normals(&mesh->mesh, options, mesh->normals, mesh->mesh.corner_count, NULL);
    if (result) return result;
    const uint32_t *starts = mesh->mesh.face_starts;
    for (size_t face = mesh->record->face_count; face-- > 0;) {
        float normal[3];
        copy3(normal, mesh->normals + 3 * face);
        const size_t start = starts ? starts[face] : 3 * face,
                     end = starts ? starts[face + 1] : 3 * face + 3;
        for (size_t corner = start; corner < end; ++corner)
            copy3(mesh->normals + 3 * corner, normal);
    }
    return NORMA_OK;
}

/* The number of a corner's stored normal; SIZE_MAX: it has none. */
static size_t stored_of(const model_mesh *mesh, size_t corner, size_t face) {
    size_t number = mesh->record->storage == NORMA_NORMALS_PER_FACET ? face
                    : mesh->record->storage == NORMA_NORMALS_PER_CORNER
                        ? corner
                        : model_corner_position(mesh, corner);
    if (mesh->stored_of_corner) number = mesh->stored_of_corner[corner];
    return number < mesh->stored.count ? number : SIZE_MAX;
}

static void take_stored(const model_mesh *mesh, float *normals) {
    static const float none[3] = {0, 0, 0};
    const float *stored = mesh->stored.data;
    for (size_t face = 0; face < mesh->record->face_count; ++face) {
        const size_t start = mesh->mesh.face_starts ? mesh->mesh.face_starts[face] : 3 * face,
                     end = mesh->mesh.face_starts ? mesh->mesh.face_starts[face + 1] : 3 * face + 3;
        for (size_t corner = start; corner < end; ++corner) {
            const size_t number = stored_of(mesh, corner, face);
            copy3(normals + 3 * corner, number == SIZE_MAX ? none : stored + 3 * number);
        }
    }
}

static void gather(const model_mesh *mesh) {
    if (mesh->triangle_corners)
        for (size_t i = 0; i < 3 * mesh->triangle_count; ++i)
            copy3(mesh->draw_normals + 3 * i, mesh->normals + 3 * mesh->triangle_corners[i]);
}

static norma_result compute_creased(
    model_mesh *mesh, const norma_options *options, double crease_deg) {
    if (mesh->creases && creases_weld(mesh->creases) != options->weld) {
        creases_close(mesh->creases);
        mesh->creases = NULL;
    }
    if (!mesh->creases) mesh->creases = creases_open(&mesh->mesh, options->weld);
    if (mesh->creases &&
        creases_compute(mesh->creases, web_radians(crease_deg), options->weight, mesh->normals))
        return NORMA_OK;
    return norma_corner_normals(&mesh->mesh, web_radians(crease_deg), options, mesh->normals,
        mesh->mesh.corner_count, NULL);
}

norma_result WEB_EXPORT(model_compute)(
    model *m, uint32_t index, int wanted, norma_weight weight, norma_weld weld, double crease_deg) {
    model_mesh *mesh = &m->meshes[index];
    const norma_options options = {
        .weight = weight, .weld = weld, .fallback = NORMA_FALLBACK_NEAREST};
    norma_result result = NORMA_OK;
    if (wanted == WANT_STORED && mesh->stored.count)
        take_stored(mesh, mesh->normals);
    else if (wanted == WANT_FLAT)
        result = compute_flat(mesh, &options);
    else
        result = compute_creased(mesh, &options, crease_deg);
    gather(mesh);
    return result;
}

static double angle_between(const float *a, const float *b) {
    const double x = (double)a[1] * (double)b[2] - (double)a[2] * (double)b[1],
                 y = (double)a[2] * (double)b[0] - (double)a[0] * (double)b[2],
                 z = (double)a[0] * (double)b[1] - (double)a[1] * (double)b[0];
    return atan2(sqrt(x * x + y * y + z * z), (double)a[0] * (double)b[0] +
                                                  (double)a[1] * (double)b[1] +
                                                  (double)a[2] * (double)b[2]) *
           (180 / 3.141592653589793);
}

static const float *stored_normal(const model_mesh *mesh, size_t corner, size_t face) {
    const size_t number = stored_of(mesh, corner, face);
    return number == SIZE_MAX ? NULL : (const float *)mesh->stored.data + 3 * number;
}

/* Fills draw_values with the degrees between each stored normal and the one that is computed now,
 * and returns the largest; -1 where nothing is stored. A stored normal that is missing, zero or not
 * finite counts as 180. */
double WEB_EXPORT(model_errors)(model *m, uint32_t index) {
    model_mesh *mesh = &m->meshes[index];
    double worst = 0;
    size_t face = 0;
    for (size_t i = 0; !mesh->stored.count && i < 3 * mesh->triangle_count; ++i)
        mesh->draw_values[i] = -1; /* grey: there is nothing to compare */
    if (!mesh->stored.count) return -1;
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const size_t corner = mesh->triangle_corners ? mesh->triangle_corners[i] : i;
        if (mesh->mesh.face_starts)
            while (
                corner < mesh->mesh.face_starts[face] || corner >= mesh->mesh.face_starts[face + 1])
                ++face;
        else
            face = i / 3;
        const float *stored = stored_normal(mesh, corner, face);
        const double length =
            stored ? fabs((double)stored[0]) + fabs((double)stored[1]) + fabs((double)stored[2])
                   : 0;
        const double error = length > 0 && isfinite(length)
                                 ? angle_between(stored, mesh->normals + 3 * corner)
                                 : 180;
        mesh->draw_values[i] = (float)error;
        worst = fmax(worst, error);
    }
    return worst;
}

/* The largest angle between a normal through the matrix and through the right one, both
 * column-major, over all that are drawn. */
double WEB_EXPORT(model_worst)(
    const model *m, uint32_t index, const double plain[9], const double right[9]) {
    const model_mesh *mesh = &m->meshes[index];
    double worst = 0;
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        const float *n = mesh->draw_normals + 3 * i;
        double p[3], r[3];
        for (int axis = 0; axis < 3; ++axis) {
            p[axis] = plain[axis] * (double)n[0] + plain[3 + axis] * (double)n[1] +
                      plain[6 + axis] * (double)n[2];
            r[axis] = right[axis] * (double)n[0] + right[3 + axis] * (double)n[1] +
                      right[6 + axis] * (double)n[2];
        }
        const double x = p[1] * r[2] - p[2] * r[1], y = p[2] * r[0] - p[0] * r[2],
                     z = p[0] * r[1] - p[1] * r[0], across = sqrt(x * x + y * y + z * z);
        const double along = p[0] * r[0] + p[1] * r[1] + p[2] * r[2];
        /* A measure that grows with the angle: 0 at 0, 1 at 90 degrees, 2 at 180. */
        const double measure =
            across + fabs(along) > 0
                ? (along >= 0 ? across / (across + along) : 2 - across / (across - along))
                : 0;
        worst = fmax(worst, measure);
    }
    return worst;
}
