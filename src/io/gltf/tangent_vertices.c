/* tangent_vertices.c: corners with their tangents become vertices: the first tangent at an old
 * vertex gets its number, so that old indices stay right; further ones are added behind. */
#include "io/gltf/gltf_tangents.h"
#include "io/gltf/gltf_scene.h"
#include "io/file/large_memory.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static norma_document_result fail_tangent_vertices(const tangent_job *job) {
    return norma_document_fail_memory(job->sets.g->document, job->sets.error);
}

/* ---- which old tangents stay */

/* Rules N801 and N802, as norma check measures them: not of unit length, or a sign that is none. */
static int is_broken_tangent(const float tangent[4], int bits) {
    const double vector[3] = {(double)tangent[0], (double)tangent[1], (double)tangent[2]};
    return norma_normal_is_broken(vector, bits) || (tangent[3] != 1 && tangent[3] != -1);
}

static norma_document_result find_broken_tangents(tangent_job *job, tangent_set *of) {
    gltf_set *set = of->set;
    set->broken = norma_io_allocate(set->vertices, 1);
    if (!set->broken) return fail_tangent_vertices(job);
    set->wanted = 0;
    for (size_t v = 0; v < set->vertices; ++v) {
        float tangent[16];
        norma_gltf_floats(&of->encoding, v, tangent);
        set->broken[v] =
            (uint8_t)is_broken_tangent(tangent, of->encoding.component == GLTF_BYTE ? 8 : 32);
        set->wanted |= set->broken[v];
    }
    return NORMA_DOCUMENT_OK;
}

/* Stored tangents of another shape (glTF has none) are replaced by floats. */
static int keeps_encoding(const gltf_array *array, size_t vertices) {
    return array->width == 4 && array->count == vertices &&
           (array->component == GLTF_FLOAT ||
               (array->normalized &&
                   (array->component == GLTF_BYTE || array->component == GLTF_SHORT)));
}

norma_document_result norma_gltf_begin_tangents(tangent_job *job, gltf_set *set, tangent_set *of) {
    gltf *g = job->sets.g;
    const uint32_t accessor = g->primitives[set->lead].base.tangent;
    norma_document_result result = NORMA_DOCUMENT_OK;
    *of = (tangent_set){.set = set, .encoding = {.component = GLTF_FLOAT, .width = 4}};
    free(set->broken);
    set->broken = NULL;
    set->wanted = accessor == GLTF_NONE || job->options->only != NORMA_ONLY_MISSING;
    if (accessor == GLTF_NONE || !set->wanted) return NORMA_DOCUMENT_OK;
    gltf_array array;
    result = norma_gltf_array(g, accessor, &array, job->sets.error);
    if (result || !keeps_encoding(&array, set->vertices)) return result;
    of->encoding = array;
    return job->options->only == NORMA_ONLY_BROKEN ? find_broken_tangents(job, of)
                                                   : NORMA_DOCUMENT_OK;
}

/* ---- vertices by old vertex and code */

static size_t hash_tangent_vertex(uint32_t vertex, const unsigned char *code, size_t size) {
    uint64_t hash = (uint64_t)vertex + 1;
    for (size_t k = 0; k < size; k += 4) {
        uint32_t word;
        memcpy(&word, code + k, sizeof word);
        hash = (hash ^ hash >> 29 ^ word) * 0x9E3779B97F4A7C15u;
    }
    return (size_t)(hash ^ hash >> 32);
}

/* The place of a vertex with this code in the table, or a free one. */
static uint32_t *find_tangent_vertex(
    const tangent_set *of, uint32_t vertex, const unsigned char *code) {
    size_t at = hash_tangent_vertex(vertex, code, of->size) & (of->table_size - 1);
    while (of->table[at]) {
        const size_t found = of->table[at] - 1;
        if (norma_gltf_old_vertex(of->set, found) == vertex &&
            memcmp(of->codes + found * of->size, code, of->size) == 0)
            break;
        at = (at + 1) & (of->table_size - 1);
    }
    return &of->table[at];
}

static int grow_tangent_table(tangent_set *of, size_t used) {
    uint32_t *old = of->table;
    const size_t old_size = of->table_size;
    if (old_size / 2 > used) return 1;
    while (of->table_size / 4 <= used) of->table_size = of->table_size ? 2 * of->table_size : 64;
    of->table = norma_io_allocate(of->table_size, sizeof *of->table);
    for (size_t i = 0; of->table && i < old_size; ++i) {
        if (!old[i]) continue;
        const size_t vertex = old[i] - 1;
        *find_tangent_vertex(
            of, norma_gltf_old_vertex(of->set, vertex), of->codes + vertex * of->size) = old[i];
    }
    free(old);
    return of->table != NULL;
}

static int grow_vertices(tangent_set *of, uint32_t targets, float *const *like, size_t needed) {
    if (needed <= of->capacity) return 1;
    size_t larger = of->capacity + of->capacity / 2;
    larger = larger < needed ? needed : larger;
    unsigned char *codes =
        norma_io_move_block(of->codes, of->capacity * of->size, larger, of->size);
    if (!codes) return 0;
    of->codes = codes;
    memset(codes + of->capacity * of->size, 0, (larger - of->capacity) * of->size);
    for (uint32_t t = 0; t < targets; ++t) {
        if (!like[t]) continue;
        float *deltas = norma_io_move_block(of->deltas[t], of->capacity * 12, larger, 12);
        if (!deltas) return 0;
        of->deltas[t] = deltas;
        memset(deltas + 3 * of->capacity, 0, (larger - of->capacity) * 12);
    }
    of->capacity = larger;
    return 1;
}

static int begin_tangent_vertices(tangent_set *of, const gltf_primitive *p, float *const *like) {
    gltf_set *set = of->set;
    if (set->taken) return 1;
    set->taken = norma_io_allocate(set->vertices, 1);
    of->deltas = norma_io_allocate((size_t)p->target_count + 1, sizeof *of->deltas);
    return set->taken && of->deltas && grow_vertices(of, p->target_count, like, set->vertices) &&
           grow_tangent_table(of, set->vertices);
}

/* The number of the vertex that a corner's becomes; GLTF_NONE: out of memory, or of numbers. */
static uint32_t take_tangent_vertex(tangent_set *of, const gltf_primitive *p, uint32_t vertex,
    const tangent_corners *made, size_t corner) {
    gltf_set *set = of->set;
    const unsigned char *code = made->codes + corner * of->size;
    size_t number = vertex;
    if (set->broken && !set->broken[vertex]) return vertex;
    if (!grow_tangent_table(of, set->vertices + set->added_count)) return GLTF_NONE;
    uint32_t *place = find_tangent_vertex(of, vertex, code);
    if (*place) return *place - 1;
    if (set->taken[vertex]) {
        number = norma_gltf_add_vertex(set, vertex);
        if (number == SIZE_MAX || !grow_vertices(of, p->target_count, made->deltas, number + 1))
            return GLTF_NONE;
    }
    set->taken[vertex] = 1;
    memcpy(of->codes + number * of->size, code, of->size);
    for (uint32_t t = 0; t < p->target_count; ++t)
        if (made->deltas[t]) memcpy(of->deltas[t] + 3 * number, made->deltas[t] + 3 * corner, 12);
    *place = (uint32_t)number + 1;
    return (uint32_t)number;
}

norma_document_result norma_gltf_take_tangents(
    tangent_job *job, uint32_t primitive, tangent_set *of, const tangent_corners *made) {
    const gltf_primitive *p = &job->sets.g->primitives[primitive];
    of->size = 4 * norma_gltf_component_size(of->encoding.component);
    uint32_t *corners = norma_io_block(made->count, sizeof *corners);
    job->sets.corners[primitive] = corners;
    if (!corners || !begin_tangent_vertices(of, p, made->deltas)) return fail_tangent_vertices(job);
    for (size_t c = 0; c < made->count; ++c) {
        corners[c] = take_tangent_vertex(of, p, made->corners[c], made, c);
        if (corners[c] == GLTF_NONE) return fail_tangent_vertices(job);
    }
    return NORMA_DOCUMENT_OK;
}

/* ---- contents */

/* Vertices that no triangle uses get some unit vector perpendicular to their normal, those that
 * stay what they were. */
static norma_document_result fill_others(tangent_job *job, tangent_set *of) {
    gltf_set *set = of->set;
    const float *normals;
    gltf_data data = {0};
    norma_document_result result = norma_gltf_decode(
        job->sets.g, job->sets.g->primitives[set->lead].base.normal, 3, &normals, job->sets.error);
    if (result) return result;
    float *tangents = norma_io_allocate(set->vertices, 16);
    const norma_vec3_view view = {.data = normals, .count = set->vertices};
    if (!tangents || norma_orthogonalise_tangents(
                         tangents, 0, view, set->vertices, tangents, 0, set->vertices) != NORMA_OK)
        result = fail_tangent_vertices(job);
    for (size_t v = 0; !result && v < set->vertices; ++v) tangents[4 * v + 3] = 1;
    if (!result) result = norma_gltf_encode_tangents(job, of, tangents, set->vertices, &data);
    free(tangents);
    for (size_t v = 0; !result && v < set->vertices; ++v) {
        const unsigned char *from = data.bytes + v * of->size;
        if (set->broken && !set->broken[v]) from = of->encoding.data + v * of->encoding.stride;
        if (!set->taken[v]) memcpy(of->codes + v * of->size, from, of->size);
    }
    free(data.bytes);
    return result;
}

static norma_document_result put_copies(tangent_job *job, tangent_set *of, int32_t target,
    const gltf_attributes *attributes, int skip) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    gltf *g = job->sets.g;
    for (uint32_t i = attributes->first; !result && i < attributes->first + attributes->count;
         ++i) {
        gltf_data data;
        if (skip && strcmp(g->attributes[i].name, "TANGENT") == 0) continue;
        result = norma_gltf_copy_elements(&job->sets, of->set, g->attributes[i].accessor, &data);
        if (!result)
            result =
                norma_gltf_put_in_set(&job->sets, of->set, target, g->attributes[i].name, &data);
    }
    return result;
}

static norma_document_result put_tangent_targets(tangent_job *job, tangent_set *of) {
    gltf *g = job->sets.g;
    const gltf_primitive *lead = &g->primitives[of->set->lead];
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t t = 0; !result && t < lead->target_count; ++t) {
        const int made = of->deltas[t] != NULL;
        if (of->set->added_count)
            result = put_copies(job, of, (int32_t)t, &g->targets[lead->first_target + t], made);
        if (!result && made)
            result = norma_gltf_put_deltas(&job->sets, of->set, t, "TANGENT", of->deltas[t]);
        free(of->deltas[t]);
        of->deltas[t] = NULL;
    }
    return result;
}

norma_document_result norma_gltf_put_tangents(tangent_job *job, tangent_set *of) {
    gltf *g = job->sets.g;
    gltf_set *set = of->set;
    gltf_primitive *lead = &g->primitives[set->lead];
    norma_document_result result = fill_others(job, of);
    if (!result && set->added_count)
        result = norma_gltf_copy_vertices(g, lead, set->vertices + set->added_count,
            norma_gltf_vertex_size(g, lead), job->sets.error);
    if (!result && set->added_count) result = put_copies(job, of, GLTF_SLOT_BASE, &lead->base, 1);
    if (!result) {
        gltf_data data = {.component = of->encoding.component,
            .normalized = of->encoding.normalized,
            .width = 4,
            .count = set->vertices + set->added_count,
            .bytes = of->codes};
        of->codes = NULL;
        result = norma_gltf_put_in_set(&job->sets, set, GLTF_SLOT_BASE, "TANGENT", &data);
    }
    return result ? result : put_tangent_targets(job, of);
}

void norma_gltf_tangent_set_free(const gltf *g, tangent_set *of) {
    for (uint32_t t = 0; of->deltas && t < g->primitives[of->set->lead].target_count; ++t)
        free(of->deltas[t]);
    free(of->deltas);
    free(of->codes);
    free(of->table);
}
