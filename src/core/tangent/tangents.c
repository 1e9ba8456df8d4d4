/* tangents.c: norma_corner_tangents and norma_split_tangents. */
#include "core/tangent/tangents.h"
#include "core/corner/corner.h"

/* ---- norma_corner_tangents. Arguments, the vertices that corners share, then one of
 * two ways to make tangents. */

static norma_result compute_corner_tangents(tangent_mesh *mesh, norma_tangent_mode mode,
    const tangent_output *output, norma_report *report) {
    core_tally tally = {0};
    norma_core_stage(mesh->call, 0.05, 0.3);
    norma_result result = norma_core_tangent_open(mesh);
    if (result != NORMA_OK) return result;
    norma_core_stage(mesh->call, 0.3, 0.97);
    result = mode == NORMA_TANGENTS_MIKK ? norma_core_mikk_tangents(mesh, output, &tally)
                                         : norma_core_steady_tangents(mesh, output, &tally);
    result = norma_core_finish(mesh->call, result);
    norma_core_tangent_close(mesh);
    if (result == NORMA_OK) norma_core_write_report(report, &tally, NULL, NULL);
    return result;
}

norma_result norma_corner_tangents(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, norma_tangent_mode mode, const norma_options *options,
    float *tangents, size_t capacity, norma_report *report) {
    core_call call;
    tangent_mesh checked = {.call = &call};
    tangent_output output;
    norma_result result = norma_core_begin(&call, options);
    if (result == NORMA_OK && mode != NORMA_TANGENTS_STEADY && mode != NORMA_TANGENTS_MIKK)
        result = NORMA_ERROR_ARGUMENT;
    if (result == NORMA_OK) result = norma_core_mesh_shape(mesh, &checked.mesh);
    if (result == NORMA_OK) norma_core_share(&call, checked.mesh.corner_count);
    if (result == NORMA_OK)
        result = norma_core_tangent_attributes(&checked, mode, normals, texcoords);
    if (result == NORMA_OK)
        result = norma_core_tangent_output_open(
            options, tangents, checked.mesh.corner_count, capacity, &output);
    norma_core_stage(&call, 0, 0.05);
    if (result == NORMA_OK) result = norma_core_mesh_content(&call, &checked.mesh);
    if (result != NORMA_OK) return result;
    norma_core_gather(&call, checked.mesh.corner_count);
    result = compute_corner_tangents(&checked, mode, &output, report);
    norma_core_dismiss(&call);
    return result;
}

/* ---- norma_split_tangents: tangents of corners, then corners that agree in what they
 * have, byte for byte, as vertices. */

enum { STREAMS = 4, TANGENT_BYTES = 4 * sizeof(float) };

static norma_stream stream_of(const norma_attribute *a, size_t numbers, const uint32_t *corners) {
    return (norma_stream){.data = a->data,
        .count = a->count,
        .size = numbers * norma_format_size(a->format),
        .stride = a->stride,
        .corners = a->corners                  ? a->corners
                   : a->of == NORMA_PER_VERTEX ? corners
                                               : NULL};
}

/* The mesh's indices in 32 bits: its own, or made. NULL: no memory, or the mesh has none. */
static const uint32_t *wide_corners(
    const core_call *call, const norma_mesh *mesh, uint32_t **made) {
    if (!mesh->corners) return NULL;
    if ((!mesh->corner_size || mesh->corner_size == 4) &&
        (uintptr_t)mesh->corners % sizeof(uint32_t) == 0)
        return mesh->corners;
    *made = norma_core_allocate(call, mesh->corner_count, sizeof **made);
    for (size_t c = 0; *made && c < mesh->corner_count; c++)
        (*made)[c] = norma_mesh_corner(mesh, c);
    return *made;
}

typedef struct tangent_split {
    core_call call;
    const norma_mesh *mesh;
    const norma_attribute *normals, *texcoords;
    norma_indexed *indexed;
    float *tangents; /* of corners */
    uint32_t *corners, *sources;
    size_t corner_count;
} tangent_split;

static norma_result index_corners(tangent_split *s) {
    const norma_mesh *mesh = s->mesh;
    const uint32_t *corners = wide_corners(&s->call, mesh, &s->corners);
    if (mesh->corners && !corners) return NORMA_ERROR_MEMORY;
    const norma_vec3_view *p = &mesh->positions;
    const norma_stream streams[STREAMS] = {
        {p->data, p->count, 3 * norma_format_size(p->format), p->stride, corners},
        stream_of(s->normals, 3, corners), stream_of(s->texcoords, 2, corners),
        {.data = s->tangents, .count = s->corner_count, .size = TANGENT_BYTES}};
    return norma_core_index_corners(&s->call, streams, STREAMS, s->corner_count, s->indexed);
}

/* By the sources, in memory of our own: what is written for the caller is not read again. */
static norma_result split_by_tangents(tangent_split *s, float *tangents, size_t stride) {
    norma_indexed *to = s->indexed;
    uint32_t *wanted = to->source_corners;
    if (tangents) {
        s->sources = norma_core_allocate(&s->call, to->vertex_capacity, sizeof *s->sources);
        if (!s->sources) return NORMA_ERROR_MEMORY;
        to->source_corners = s->sources;
    }
    norma_result result = index_corners(s);
    const norma_stream values = {
        .data = s->tangents, .count = s->corner_count, .size = TANGENT_BYTES};
    if (result == NORMA_OK && tangents)
        result = norma_copy_values(
            &values, s->sources, to->vertex_count, tangents, stride, to->vertex_capacity);
    if (result == NORMA_OK && tangents && wanted)
        memcpy(wanted, s->sources, to->vertex_count * sizeof *wanted);
    norma_core_release(&s->call, s->sources, to->vertex_capacity, sizeof *s->sources);
    to->source_corners = wanted;
    return result;
}

norma_result norma_split_tangents(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, norma_tangent_mode mode, const norma_options *options,
    float *tangents, norma_indexed *indexed, norma_report *report) {
    tangent_split s = {
        .mesh = mesh, .normals = normals, .texcoords = texcoords, .indexed = indexed};
    norma_result result = norma_core_begin(&s.call, options);
    if (result == NORMA_OK) result = norma_core_check_indexed(indexed);
    if (result != NORMA_OK) return result;
    const size_t asked = options && options->normal_stride ? options->normal_stride : TANGENT_BYTES;
    core_mesh checked;
    result = norma_core_mesh_shape(mesh, &checked);
    if (result == NORMA_OK && asked < TANGENT_BYTES) result = NORMA_ERROR_ARGUMENT;
    if (result != NORMA_OK) return result;
    s.corner_count = checked.corner_count;
    s.tangents = norma_core_allocate(&s.call, s.corner_count, TANGENT_BYTES);
    if (!s.tangents) return NORMA_ERROR_MEMORY;
    norma_options per_corner = s.call.options;
    per_corner.struct_size = sizeof per_corner;
    per_corner.normal_stride = TANGENT_BYTES;
    result = norma_corner_tangents(
        mesh, normals, texcoords, mode, &per_corner, s.tangents, s.corner_count, report);
    if (result == NORMA_OK && s.corner_count) {
        norma_core_share(&s.call, s.corner_count);
        norma_core_stage(&s.call, 1, 1);
        result = split_by_tangents(&s, tangents, asked);
    } else if (result == NORMA_OK) {
        indexed->vertex_count = 0;
    }
    norma_core_release(&s.call, s.corners, s.corner_count, sizeof *s.corners);
    norma_core_release(&s.call, s.tangents, s.corner_count, TANGENT_BYTES);
    return result;
}
