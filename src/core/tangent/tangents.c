/* tangents.c: norma_corner_tangents: arguments, the vertices that corners share, then one of three
 * ways to make tangents. */
#include "core/tangent/tangents.h"
#include "core/corner/corner.h"
#include <string.h>

static norma_result compute_corner_tangents(
    tangent_mesh *mesh, tangent_maker *maker, const tangent_output *output, norma_report *report) {
    core_tally tally = {0};
    norma_core_stage(mesh->call, 0.05, 0.3);
    norma_result result = norma_core_tangent_open(mesh);
    if (result) return result;
    norma_core_stage(mesh->call, 0.3, 0.97);
    result = norma_core_finish(mesh->call, maker(mesh, output, &tally));
    norma_core_tangent_close(mesh);
    if (!result) norma_core_write_report(report, &tally, NULL, NULL);
    return result;
}

norma_result norma_core_corner_tangents(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, tangent_maker *maker, const norma_options *options,
    float *tangents, size_t capacity, norma_report *report) {
    core_call call;
    tangent_mesh checked = {.call = &call};
    tangent_output output;
    norma_result result = norma_core_begin(&call, options);
    if (!result && !maker) result = NORMA_ERROR_ARGUMENT;
    if (!result) result = norma_core_mesh_shape(mesh, &checked.mesh);
    if (!result) norma_core_share(&call, checked.mesh.corner_count);
    if (!result)
        result = norma_core_tangent_attributes(&checked,
            !CORE_IS_SMALL && maker == norma_core_steady_tangents ? NORMA_TANGENTS_STEADY
                                                                  : NORMA_TANGENTS_MIKK,
            normals, texcoords);
    if (!result)
        result = norma_core_tangent_output_open(
            options, tangents, checked.mesh.corner_count, capacity, &output);
    norma_core_stage(&call, 0, 0.05);
    if (!result) result = norma_core_mesh_content(&call, &checked.mesh);
    if (result) return result;
    norma_core_gather(&call);
    result = compute_corner_tangents(&checked, maker, &output, report);
    norma_core_dismiss(&call);
    return result;
}

norma_result norma_corner_tangents(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, norma_tangent_mode mode, const norma_options *options,
    float *tangents, size_t capacity, norma_report *report) {
    tangent_maker *maker = mode == NORMA_TANGENTS_MIKK ? norma_core_mikk_tangents
                           : !CORE_IS_SMALL && mode == NORMA_TANGENTS_STEADY
                               ? norma_core_steady_tangents
                               : NULL;
    return norma_core_corner_tangents(
        mesh, normals, texcoords, maker, options, tangents, capacity, report);
}

/* ---- indexed meshes with tangents: norma_split_tangents, which is given normals, and norma_build,
 * which computes them. Corners that agree in position, normal, texture coordinates and tangent,
 * byte for byte, become one vertex (index_corners.c). */

enum {
    STREAMS = 4,
    NORMAL_BYTES = 3 * sizeof(float),
    TANGENT_BYTES = 4 * sizeof(float),
    SHARE_OF_NORMALS = 40, /* percent of the progress of norma_build */
    SHARE_OF_TANGENTS = 80
};

typedef struct mesh_build {
    core_call call;
    const norma_mesh *mesh;
    const norma_attribute *normals, *texcoords; /* without texcoords, no tangents */
    norma_indexed *indexed;
    float *tangents;         /* of corners */
    const uint32_t *corners; /* the mesh's own in 32 bits; NULL: it has none */
    uint32_t *made_corners;  /* those, where they had to be made */
    uint32_t *firsts;        /* the first corner of each new vertex */
    size_t corner_count;
    double from, to; /* the part of the progress that the current step of norma_build covers */
} mesh_build;

/* ---- corners to vertices */

static int find_wide_corners(mesh_build *b) {
    const norma_mesh *mesh = b->mesh;
    if (!mesh->corners) return 1;
    b->corners = mesh->corners;
    if ((!mesh->corner_size || mesh->corner_size == sizeof *b->corners) &&
        (uintptr_t)mesh->corners % sizeof *b->corners == 0)
        return 1;
    b->corners = b->made_corners =
        norma_core_allocate(&b->call, b->corner_count, sizeof *b->made_corners);
    for (size_t c = 0; b->corners && c < b->corner_count; ++c)
        b->made_corners[c] = norma_mesh_corner(mesh, c);
    return b->corners != NULL;
}

static norma_stream values_of(const void *values, size_t count, size_t size) {
    return (norma_stream){.data = values, .count = count, .size = size};
}

static norma_stream stream_of(const norma_attribute *a, size_t numbers, const uint32_t *corners) {
    return (norma_stream){.data = a->data,
        .count = a->count,
        .size = numbers * norma_format_size(a->format),
        .stride = a->stride,
        .corners = a->corners                  ? a->corners
                   : a->of == NORMA_PER_VERTEX ? corners
                                               : NULL};
}

/* by_number: positions of different numbers are different vertices, whatever their bytes.
 * wants_firsts: something is written by them, so they stand in memory of our own: what is written
 * for the caller is not read again. */
static norma_result find_vertices(mesh_build *b, int by_number, int wants_firsts) {
    if (!find_wide_corners(b)) return NORMA_ERROR_MEMORY;
    const norma_vec3_view *p = &b->mesh->positions;
    norma_stream streams[STREAMS] = {
        {p->data, p->count, 3 * norma_format_size(p->format), p->stride, b->corners},
        stream_of(b->normals, 3, b->corners)};
    if (by_number && b->corners)
        streams[0] = values_of(b->corners, b->corner_count, sizeof *b->corners);
    if (b->texcoords) {
        streams[2] = stream_of(b->texcoords, 2, b->corners);
        streams[3] = values_of(b->tangents, b->corner_count, TANGENT_BYTES);
    }
    norma_indexed to = *b->indexed;
    if (wants_firsts || to.source_corners) {
        b->firsts = norma_core_allocate(&b->call, b->corner_count, sizeof *b->firsts);
        if (!b->firsts) return NORMA_ERROR_MEMORY;
        to.source_corners = b->firsts;
    }
    const norma_result result = norma_core_index_corners(
        &b->call, streams, b->texcoords ? STREAMS : 2, b->corner_count, &to);
    if (result) return result;
    b->indexed->vertex_count = to.vertex_count;
    if (b->indexed->source_corners)
        memcpy(b->indexed->source_corners, b->firsts, to.vertex_count * sizeof *b->firsts);
    return NORMA_OK;
}

/* One of the values of each new vertex's first corner; to may be NULL. */
static norma_result write_firsts(
    const mesh_build *b, const float *values, size_t size, float *to, size_t stride) {
    const norma_stream stream = values_of(values, b->corner_count, size);
    const size_t count = b->indexed->vertex_count;
    return to ? norma_copy_values(&stream, b->firsts, count, to, stride, count) : NORMA_OK;
}

static void release_build(const mesh_build *b) {
    norma_core_release(&b->call, b->firsts, b->corner_count, sizeof *b->firsts);
    norma_core_release(&b->call, b->made_corners, b->corner_count, sizeof *b->made_corners);
    norma_core_release(&b->call, b->tangents, b->corner_count, TANGENT_BYTES);
}

/* ---- normals that are given */

norma_result norma_split_tangents(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, norma_tangent_mode mode, const norma_options *options,
    float *tangents, norma_indexed *indexed, norma_report *report) {
    mesh_build b = {.mesh = mesh, .normals = normals, .texcoords = texcoords, .indexed = indexed};
    norma_result result = norma_core_begin(&b.call, options);
    if (!result) result = norma_core_check_indexed(indexed);
    if (result) return result;
    const size_t asked = options && options->normal_stride ? options->normal_stride : TANGENT_BYTES;
    core_mesh checked;
    result = norma_core_mesh_shape(mesh, &checked);
    if (!result && asked < TANGENT_BYTES) result = NORMA_ERROR_ARGUMENT;
    if (result) return result;
    b.corner_count = checked.corner_count;
    b.tangents = norma_core_allocate(&b.call, b.corner_count, TANGENT_BYTES);
    if (!b.tangents) return NORMA_ERROR_MEMORY;
    norma_options per_corner = b.call.options;
    per_corner.struct_size = sizeof per_corner;
    per_corner.normal_stride = TANGENT_BYTES;
    result = norma_corner_tangents(
        mesh, normals, texcoords, mode, &per_corner, b.tangents, b.corner_count, report);
    if (!result && b.corner_count) {
        norma_core_share(&b.call, b.corner_count);
        norma_core_stage(&b.call, 1, 1);
        result = find_vertices(&b, 0, tangents != NULL);
        if (!result) result = write_firsts(&b, b.tangents, TANGENT_BYTES, tangents, asked);
    } else if (!result) {
        indexed->vertex_count = 0;
    }
    release_build(&b);
    return result;
}

/* ---- normals that are computed */

/* What the step that computes normals reports: handed to the caller when the last step cannot be
 * refused any more. */
typedef struct normal_facts {
    norma_report report;
    norma_edges edges;
    uint8_t *reasons;
} normal_facts;

/* The steps are calls of their own, each of which reports from 0 to 1. */
static int report_step(void *user, double fraction) {
    const mesh_build *b = user;
    const norma_options *asked = &b->call.options;
    return asked->progress(asked->progress_user, b->from + fraction * (b->to - b->from));
}

static norma_options step_options(mesh_build *b, int from, int to, size_t stride) {
    norma_options options = b->call.options;
    options.struct_size = sizeof options;
    options.normal_stride = stride;
    options.reasons = NULL;
    options.edges = NULL;
    b->from = from / 100.0;
    b->to = to / 100.0;
    if (options.progress) options.progress = report_step, options.progress_user = b;
    return options;
}

static norma_result compute_values(mesh_build *b, float crease_angle_rad, norma_tangent_mode mode,
    float *normals, normal_facts *facts) {
    const int end = b->texcoords ? SHARE_OF_NORMALS : SHARE_OF_TANGENTS;
    norma_options options = step_options(b, 0, end, NORMAL_BYTES);
    options.reasons = facts->reasons;
    options.edges = b->call.options.edges ? &facts->edges : NULL;
    const norma_result result = norma_corner_normals(
        b->mesh, crease_angle_rad, &options, normals, b->corner_count, &facts->report);
    if (result || !b->texcoords) return result;
    options = step_options(b, end, SHARE_OF_TANGENTS, TANGENT_BYTES);
    return norma_corner_tangents(
        b->mesh, b->normals, b->texcoords, mode, &options, b->tangents, b->corner_count, NULL);
}

static norma_result write_built(
    const mesh_build *b, const float *normals, const norma_built *built) {
    for (size_t v = 0; built->source_vertices && v < b->indexed->vertex_count; ++v)
        built->source_vertices[v] = b->corners ? b->corners[b->firsts[v]] : b->firsts[v];
    const norma_result result =
        write_firsts(b, normals, NORMAL_BYTES, built->normals, built->normal_stride);
    return !result
               ? write_firsts(b, b->tangents, TANGENT_BYTES, built->tangents, built->tangent_stride)
               : result;
}

static norma_result build(mesh_build *b, float crease_angle_rad, norma_tangent_mode mode,
    float *normals, normal_facts *facts, const norma_built *built) {
    const int wants_firsts = built->source_vertices || built->normals || built->tangents;
    norma_result result = compute_values(b, crease_angle_rad, mode, normals, facts);
    if (result) return result;
    b->indexed->vertex_count = 0;
    if (!b->corner_count) return NORMA_OK;
    norma_core_share(&b->call, b->corner_count);
    norma_core_stage(&b->call, SHARE_OF_TANGENTS / 100.0, 1);
    result = find_vertices(b, 1, wants_firsts);
    return !result ? write_built(b, normals, built) : result;
}

static norma_result check_built(const norma_built *built, const norma_attribute *texcoords) {
    if (!built || (built->normal_stride && built->normal_stride < NORMAL_BYTES) ||
        (built->tangent_stride && built->tangent_stride < TANGENT_BYTES) ||
        (built->tangents && !texcoords))
        return NORMA_ERROR_ARGUMENT;
    return norma_core_check_indexed(&built->indexed);
}

norma_result norma_build(const norma_mesh *mesh, const norma_attribute *texcoords,
    float crease_angle_rad, norma_tangent_mode mode, const norma_options *options,
    norma_built *built, norma_report *report) {
    norma_attribute normals = {.of = NORMA_PER_CORNER};
    mesh_build b = {.mesh = mesh, .normals = &normals, .texcoords = texcoords};
    normal_facts facts = {.reasons = NULL};
    core_mesh checked;
    norma_result result = norma_core_begin(&b.call, options);
    if (!result) result = check_built(built, texcoords);
    if (!result) result = norma_core_mesh_shape(mesh, &checked);
    if (result) return result;
    const size_t count = b.corner_count = checked.corner_count;
    const norma_options *asked = &b.call.options;
    b.indexed = &built->indexed;
    float *values = norma_core_allocate(&b.call, count, NORMAL_BYTES);
    if (texcoords) b.tangents = norma_core_allocate(&b.call, count, TANGENT_BYTES);
    if (asked->reasons) facts.reasons = norma_core_allocate(&b.call, count, 1);
    normals.data = values;
    normals.count = count;
    result = values && (!texcoords || b.tangents) && (!asked->reasons || facts.reasons)
                 ? build(&b, crease_angle_rad, mode, values, &facts, built)
                 : NORMA_ERROR_MEMORY;
    if (!result) {
        if (report) *report = facts.report;
        if (asked->edges) *asked->edges = facts.edges;
        if (asked->reasons) memcpy(asked->reasons, facts.reasons, count);
    }
    norma_core_release(&b.call, facts.reasons, count, 1);
    norma_core_release(&b.call, values, count, NORMAL_BYTES);
    release_build(&b);
    return result;
}
