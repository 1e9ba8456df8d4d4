/* tangent_corners.c: the tangents of a primitive's corners by norma_corner_tangents, in the
 * encoding that the file is to have them in, and how they differ in its morph targets. */
#include "io/gltf/gltf_tangents.h"
#include "io/gltf/gltf_scene.h"
#include "io/gltf/encode_vectors.h"
#include "io/file/large_memory.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static norma_document_result fail_tangent_corners(const tangent_job *job) {
    return norma_document_fail_memory(job->sets.g->document, job->sets.error);
}

norma_document_result norma_gltf_encode_tangents(
    tangent_job *job, const tangent_set *of, const float *tangents, size_t count, gltf_data *data) {
    *data = (gltf_data){.component = GLTF_FLOAT, .width = 4, .count = count};
    if (of->encoding.component == GLTF_FLOAT) {
        data->bytes = norma_io_block(count, 16);
        if (!data->bytes) return fail_tangent_corners(job);
        memcpy(data->bytes, tangents, count * 16);
        return NORMA_DOCUMENT_OK;
    }
    double *values = norma_io_block(4 * count, sizeof *values);
    for (size_t i = 0; values && i < 4 * count; ++i) values[i] = (double)tangents[i];
    gltf_array shape = of->encoding;
    shape.count = count;
    const bake_encoded encoded =
        values ? norma_gltf_encode(BAKE_TANGENTS, &shape, values, data) : BAKE_NO_MEMORY;
    free(values);
    return encoded ? fail_tangent_corners(job) : NORMA_DOCUMENT_OK;
}

static int pass_on_tangents(void *user, double fraction) {
    const tangent_job *job = user;
    return job->options->progress(
        job->options->progress_user, job->progress_base + fraction * job->progress_scale);
}

typedef struct tangent_shape { /* of a primitive, at rest or in a morph target */
    const float *positions, *normals, *texcoords;
    const uint32_t *corners;
    size_t vertices, corner_count;
} tangent_shape;

static norma_document_result compute_shape_tangents(
    tangent_job *job, const tangent_shape *shape, float *tangents, norma_report *report) {
    const norma_mesh mesh = {.positions = {.data = shape->positions, .count = shape->vertices},
        .corners = shape->corners,
        .corner_count = shape->corner_count};
    const norma_attribute normals = {.data = shape->normals, .count = shape->vertices},
                          texcoords = {.data = shape->texcoords, .count = shape->vertices};
    job->core.progress = job->options->progress ? pass_on_tangents : NULL;
    job->core.progress_user = job;
    const norma_result result = norma_corner_tangents(&mesh, &normals, &texcoords,
        job->options->mode, &job->core, tangents, shape->corner_count, report);
    for (size_t c = 0; !result && c < shape->corner_count; ++c)
        tangents[4 * c + 3] = -tangents[4 * c + 3]; /* v runs downwards */
    return result ? norma_document_fail_core(job->sets.g->document, job->sets.error, result)
                  : NORMA_DOCUMENT_OK;
}

/* ---- morph targets */

/* Base and displacements together; normals are made unit, as who draws them does. */
static norma_document_result displace(
    tangent_job *job, uint32_t accessor, const float *base, size_t count, int unit, float *moved) {
    gltf *g = job->sets.g;
    const float *deltas = NULL;
    norma_document_result result =
        accessor == GLTF_NONE ? NORMA_DOCUMENT_OK
                              : norma_gltf_decode(g, accessor, 3, &deltas, job->sets.error);
    for (size_t v = 0; !result && v < count; ++v) {
        float *to = moved + 3 * v;
        double squares = 0;
        for (size_t k = 0; k < 3; ++k) {
            to[k] = base[3 * v + k] + (deltas ? deltas[3 * v + k] : 0);
            squares += (double)to[k] * (double)to[k];
        }
        const double length = sqrt(squares);
        for (size_t k = 0; unit && length > 0 && isfinite(length) && k < 3; ++k)
            to[k] = (float)((double)to[k] / length);
    }
    return result;
}

static norma_document_result morph(tangent_job *job, const gltf_attributes *target,
    const tangent_shape *rest, const float *tangents, float **deltas) {
    float *positions = norma_io_block(rest->vertices, 12),
          *unit = norma_io_block(rest->vertices, 12),
          *moved = norma_io_block(rest->corner_count, 16);
    *deltas = norma_io_block(rest->corner_count, 12);
    norma_document_result result =
        positions && unit && moved && *deltas ? NORMA_DOCUMENT_OK : fail_tangent_corners(job);
    if (!result)
        result = displace(job, target->position, rest->positions, rest->vertices, 0, positions);
    if (!result) result = displace(job, target->normal, rest->normals, rest->vertices, 1, unit);
    tangent_shape shape = *rest;
    shape.positions = positions;
    shape.normals = unit;
    if (!result) result = compute_shape_tangents(job, &shape, moved, NULL);
    for (size_t c = 0; !result && c < rest->corner_count; ++c)
        for (size_t k = 0; k < 3; ++k)
            (*deltas)[3 * c + k] = moved[4 * c + k] - tangents[4 * c + k];
    free(positions);
    free(unit);
    free(moved);
    return result;
}

static norma_document_result morph_all(tangent_job *job, const gltf_primitive *p,
    const tangent_shape *rest, const float *tangents, tangent_corners *made) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    made->deltas = norma_io_allocate((size_t)p->target_count + 1, sizeof *made->deltas);
    if (!made->deltas) return fail_tangent_corners(job);
    for (uint32_t t = 0; !result && t < p->target_count; ++t) {
        const gltf_attributes *target = &job->sets.g->targets[p->first_target + t];
        if (target->normal != GLTF_NONE)
            result = morph(job, target, rest, tangents, &made->deltas[t]);
    }
    return result;
}

/* ---- a primitive */

static void count_reasons(norma_tangent_summary *summary, const norma_report *report) {
    summary->degenerate += report->degenerate_faces.count;
    summary->non_finite += report->non_finite.count;
    summary->cancelled += report->cancelled.count;
}

static norma_document_result gather_shape(
    tangent_job *job, uint32_t primitive, tangent_shape *shape, float **owned) {
    gltf *g = job->sets.g;
    const gltf_primitive *p = &g->primitives[primitive];
    shape->vertices = p->vertices;
    shape->corner_count = 3 * p->faces;
    norma_document_result result =
        norma_gltf_corners(g, primitive, &shape->corners, job->sets.error);
    if (!result)
        result = norma_gltf_decode(g, p->base.position, 3, &shape->positions, job->sets.error);
    if (!result) result = norma_gltf_decode(g, p->base.normal, 3, &shape->normals, job->sets.error);
    return result ? result : norma_gltf_tangent_texcoords(job, p, &shape->texcoords, owned);
}

norma_document_result norma_gltf_corner_tangents(
    tangent_job *job, uint32_t primitive, const tangent_set *of, tangent_corners *made) {
    const gltf_primitive *p = &job->sets.g->primitives[primitive];
    tangent_shape shape;
    norma_report report;
    gltf_data data = {0};
    float *owned = NULL, *tangents = norma_io_block(3 * p->faces, 16);
    *made = (tangent_corners){.count = 3 * p->faces};
    norma_document_result result =
        tangents ? gather_shape(job, primitive, &shape, &owned) : fail_tangent_corners(job);
    if (!result) result = compute_shape_tangents(job, &shape, tangents, &report);
    if (!result) {
        made->corners = shape.corners;
        count_reasons(job->summary, &report);
        result = morph_all(job, p, &shape, tangents, made);
    }
    if (!result) result = norma_gltf_encode_tangents(job, of, tangents, made->count, &data);
    made->codes = data.bytes;
    free(tangents);
    free(owned);
    return result;
}

void norma_gltf_corner_tangents_free(const gltf_primitive *p, tangent_corners *made) {
    for (uint32_t t = 0; made->deltas && t < p->target_count; ++t) free(made->deltas[t]);
    free(made->deltas);
    free(made->codes);
    *made = (tangent_corners){0};
}
