/* build.c: norma_build: normals of corners, tangents of corners, then corners that agree in
 * position, normal, texture coordinates and tangent, byte for byte, as vertices. */
#include "core/tangent/tangents.h"
#include "core/corner/corner.h"
#include <string.h>

enum {
    STREAMS = 4,
    NORMAL_BYTES = 3 * sizeof(float),
    TANGENT_BYTES = 4 * sizeof(float),
    SHARE_OF_NORMALS = 40, /* percent of the progress */
    SHARE_OF_TANGENTS = 80
};

typedef struct mesh_build {
    core_call call;
    const norma_mesh *mesh;
    const norma_attribute *texcoords;
    norma_built *built;
    float *normals, *tangents;  /* of corners */
    uint32_t *corners, *firsts; /* the position of each corner; the first corner of each vertex */
    size_t corner_count;
    double from, to; /* the part of the progress that the current step covers */
} mesh_build;

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
    b->from = from / 100.0;
    b->to = to / 100.0;
    if (options.progress) options.progress = report_step, options.progress_user = b;
    return options;
}

static norma_result compute_values(
    mesh_build *b, float crease_angle_rad, norma_tangent_mode mode, norma_report *report) {
    const int end = b->texcoords ? SHARE_OF_NORMALS : SHARE_OF_TANGENTS;
    norma_options options = step_options(b, 0, end, NORMAL_BYTES);
    norma_result result = norma_corner_normals(
        b->mesh, crease_angle_rad, &options, b->normals, b->corner_count, report);
    if (result != NORMA_OK || !b->texcoords) return result;
    const norma_attribute normals = {
        .data = b->normals, .count = b->corner_count, .of = NORMA_PER_CORNER};
    options = step_options(b, end, SHARE_OF_TANGENTS, TANGENT_BYTES);
    options.reasons = NULL; /* those of the normals */
    return norma_corner_tangents(
        b->mesh, &normals, b->texcoords, mode, &options, b->tangents, b->corner_count, NULL);
}

/* A position of its own number is a vertex of its own. Without numbers, in a triangle soup, equal
 * positions are one. */
static norma_stream position_stream(const mesh_build *b) {
    const norma_vec3_view *p = &b->mesh->positions;
    if (b->corners)
        return (norma_stream){
            .data = b->corners, .count = b->corner_count, .size = sizeof *b->corners};
    return (norma_stream){.data = p->data,
        .count = p->count,
        .size = 3 * norma_format_size(p->format),
        .stride = p->stride};
}

static norma_stream values_of(const float *values, size_t count, size_t size) {
    return (norma_stream){.data = values, .count = count, .size = size};
}

static norma_result find_vertices(mesh_build *b) {
    const norma_attribute *t = b->texcoords;
    norma_stream streams[STREAMS] = {
        position_stream(b), values_of(b->normals, b->corner_count, NORMAL_BYTES)};
    if (t) {
        streams[2] = (norma_stream){.data = t->data,
            .count = t->count,
            .size = 2 * norma_format_size(t->format),
            .stride = t->stride,
            .corners = t->corners                  ? t->corners
                       : t->of == NORMA_PER_VERTEX ? b->corners
                                                   : NULL};
        streams[3] = values_of(b->tangents, b->corner_count, TANGENT_BYTES);
    }
    norma_indexed to = b->built->indexed;
    to.source_corners = b->firsts; /* not read back from the caller's array */
    const norma_result result =
        norma_core_index_corners(&b->call, streams, t ? STREAMS : 2, b->corner_count, &to);
    if (result == NORMA_OK) b->built->indexed.vertex_count = to.vertex_count;
    return result;
}

static norma_result write_built_vertices(const mesh_build *b) {
    const norma_built *to = b->built;
    const size_t count = to->indexed.vertex_count;
    const uint32_t *firsts = b->firsts;
    const norma_stream normals = values_of(b->normals, b->corner_count, NORMAL_BYTES),
                       tangents = values_of(b->tangents, b->corner_count, TANGENT_BYTES);
    norma_result result = NORMA_OK;
    if (to->indexed.source_corners)
        memcpy(to->indexed.source_corners, firsts, count * sizeof *firsts);
    for (size_t v = 0; to->source_vertices && v < count; v++)
        to->source_vertices[v] = b->corners ? b->corners[firsts[v]] : firsts[v];
    if (to->normals)
        result = norma_copy_values(&normals, firsts, count, to->normals, to->normal_stride, count);
    if (to->tangents && result == NORMA_OK)
        result =
            norma_copy_values(&tangents, firsts, count, to->tangents, to->tangent_stride, count);
    return result;
}

/* Nothing is written if a stride is too small. */
static norma_result check_built_output(const mesh_build *b) {
    const norma_built *to = b->built;
    if (!to || (to->normal_stride && to->normal_stride < NORMAL_BYTES) ||
        (to->tangent_stride && to->tangent_stride < TANGENT_BYTES) ||
        (to->tangents && !b->texcoords))
        return NORMA_ERROR_ARGUMENT;
    return norma_core_check_indexed(&to->indexed);
}

static norma_result allocate_build(mesh_build *b) {
    const norma_built *to = b->built;
    const int needs_firsts =
        to->indexed.source_corners || to->source_vertices || to->normals || to->tangents;
    b->normals = norma_core_allocate(&b->call, b->corner_count, NORMAL_BYTES);
    if (!b->normals) return NORMA_ERROR_MEMORY;
    if (b->texcoords) {
        b->tangents = norma_core_allocate(&b->call, b->corner_count, TANGENT_BYTES);
        if (!b->tangents) return NORMA_ERROR_MEMORY;
    }
    if (b->mesh->corners) {
        b->corners = norma_core_allocate(&b->call, b->corner_count, sizeof *b->corners);
        if (!b->corners) return NORMA_ERROR_MEMORY;
        for (size_t c = 0; c < b->corner_count; c++) b->corners[c] = norma_mesh_corner(b->mesh, c);
    }
    if (needs_firsts) {
        b->firsts = norma_core_allocate(&b->call, b->corner_count, sizeof *b->firsts);
        if (!b->firsts) return NORMA_ERROR_MEMORY;
    }
    return NORMA_OK;
}

static void release_build(const mesh_build *b) {
    norma_core_release(&b->call, b->firsts, b->corner_count, sizeof *b->firsts);
    norma_core_release(&b->call, b->corners, b->corner_count, sizeof *b->corners);
    norma_core_release(&b->call, b->tangents, b->corner_count, TANGENT_BYTES);
    norma_core_release(&b->call, b->normals, b->corner_count, NORMAL_BYTES);
}

norma_result norma_build(const norma_mesh *mesh, const norma_attribute *texcoords,
    float crease_angle_rad, norma_tangent_mode mode, const norma_options *options,
    norma_built *built, norma_report *report) {
    mesh_build b = {.mesh = mesh, .texcoords = texcoords, .built = built};
    core_mesh checked;
    norma_result result = norma_core_begin(&b.call, options);
    if (result == NORMA_OK) result = check_built_output(&b);
    if (result == NORMA_OK) result = norma_core_mesh_shape(mesh, &checked);
    if (result != NORMA_OK) return result;
    b.corner_count = checked.corner_count;
    if (b.corner_count) result = allocate_build(&b);
    if (result == NORMA_OK) result = compute_values(&b, crease_angle_rad, mode, report);
    if (result == NORMA_OK && b.corner_count) {
        norma_core_share(&b.call, b.corner_count);
        norma_core_stage(&b.call, SHARE_OF_TANGENTS / 100.0, 1);
        result = find_vertices(&b);
        if (result == NORMA_OK) result = write_built_vertices(&b);
    } else if (result == NORMA_OK) {
        built->indexed.vertex_count = 0;
    }
    release_build(&b);
    return result;
}
