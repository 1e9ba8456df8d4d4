/* gltf_tangents.c: tangents for an asset: what they are made of, those of corners, the vertices
 * that they become. */
#include "core/tangent/tangents.h"
#include "io/gltf/gltf.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct tangent_job {
    gltf_job sets;
    norma_compute_options all; /* what the sets are made for */
    const norma_tangent_options *options;
    norma_tangent_summary *summary;
    norma_options core;
} tangent_job;

/* The tangents of a set's vertices as they will be. */
typedef struct tangent_set {
    gltf_set *set;
    gltf_array encoding; /* of the stored tangents; floats where there are none */
    size_t size;         /* bytes of one code */
    unsigned char *codes;
    size_t capacity;
} tangent_set;

/* The corners of one primitive. */
typedef struct tangent_corners {
    const uint32_t *corners; /* old vertices */
    size_t count;
    unsigned char *codes;
    float **deltas;
} tangent_corners;

/* ---- What the tangents of a primitive are made of: normals, and the set of texture
 * coordinates that its normal map uses, through that map's KHR_texture_transform. */

static norma_texture_info placement_of_map(const tangent_job *job, const gltf_primitive *p) {
    gltf *g = job->sets.g;
    norma_texture_info place = {.scale = {1, 1}};
    if (p->material < g->material_count)
        place = norma_gltf_normal_map(g, norma_gltf_material(g, p->material));
    if (job->options->texcoord_given && place.texcoord != job->options->texcoord)
        place = (norma_texture_info){.texcoord = job->options->texcoord, .scale = {1, 1}};
    return place;
}

static int gltf_has_map_texcoords(const tangent_job *job, const gltf_primitive *p) {
    return norma_gltf_texcoords(job->sets.g, p, placement_of_map(job, p).texcoord) != GLTF_NONE;
}

/* gltf_tangents.c: whether a primitive has what its tangents are made of. */
static int gltf_takes_tangents(const tangent_job *job, const gltf_primitive *p) {
    const gltf *g = job->sets.g;
    return !p->not_read && p->faces > 0 && p->base.normal != GLTF_NONE &&
           g->accessors[p->base.normal].width == 3 &&
           g->accessors[p->base.normal].count == p->vertices && gltf_has_map_texcoords(job, p);
}

/* The texture coordinates of its vertices, through the normal map's transform where it has one;
 * *owned: to be freed. */
static norma_document_result gltf_tangent_texcoords(
    tangent_job *job, const gltf_primitive *p, const float **texcoords, float **owned) {
    gltf *g = job->sets.g;
    const norma_texture_info place = placement_of_map(job, p);
    *owned = NULL;
    norma_document_result result = norma_gltf_decode(
        g, norma_gltf_texcoords(g, p, place.texcoord), 2, texcoords, job->sets.error);
    if (result || !norma_gltf_moves(&place)) return result;
    *owned = norma_io_block(p->vertices, 2 * sizeof **owned);
    if (!*owned) return norma_document_fail_memory(g->document, job->sets.error);
    norma_texture_place(&place, *texcoords, p->vertices, 2, *owned);
    *texcoords = *owned;
    return NORMA_DOCUMENT_OK;
}

/* ---- The tangents of a primitive's corners by norma_corner_tangents, in the
 * encoding that the file is to have them in, and how they differ in its morph targets. */

/* Vectors of count normals and any tangents, made unit and perpendicular; encoded. */
static norma_document_result gltf_encode_tangents(
    tangent_job *job, const tangent_set *of, const float *tangents, size_t count, gltf_data *data) {
    *data = (gltf_data){.component = GLTF_FLOAT, .width = 4, .count = count};
    if (of->encoding.component == GLTF_FLOAT) {
        data->bytes = norma_io_block(count, 16);
        if (!data->bytes) return norma_gltf_job_memory(&job->sets);
        memcpy(data->bytes, tangents, count * 16);
        return NORMA_DOCUMENT_OK;
    }
    double *values = norma_io_block(4 * count, sizeof *values);
    for (size_t i = 0; values && i < 4 * count; ++i) values[i] = (double)tangents[i];
    gltf_array shape = of->encoding;
    shape.count = count;
    shape.data = NULL; /* its elements are others, and may be fewer */
    const bake_encoded encoded =
        values ? norma_gltf_encode(BAKE_TANGENTS, &shape, values, data) : BAKE_NO_MEMORY;
    free(values);
    return encoded ? norma_gltf_job_memory(&job->sets) : NORMA_DOCUMENT_OK;
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
    job->core.progress = job->options->progress ? norma_gltf_pass_on : NULL;
    job->core.progress_user = &job->sets;
    tangent_maker *maker = job->options->meshopt                       ? norma_core_meshopt_tangents
                           : job->options->mode == NORMA_TANGENTS_MIKK ? norma_core_mikk_tangents
                                                                       : norma_core_steady_tangents;
    const norma_result result = norma_core_corner_tangents(
        &mesh, &normals, &texcoords, maker, &job->core, tangents, shape->corner_count, report);
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
    norma_document_result result = positions && unit && moved && *deltas
                                       ? NORMA_DOCUMENT_OK
                                       : norma_gltf_job_memory(&job->sets);
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
    if (!made->deltas) return norma_gltf_job_memory(&job->sets);
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
    return result ? result : gltf_tangent_texcoords(job, p, &shape->texcoords, owned);
}

static norma_document_result gltf_corner_tangents(
    tangent_job *job, uint32_t primitive, const tangent_set *of, tangent_corners *made) {
    const gltf_primitive *p = &job->sets.g->primitives[primitive];
    tangent_shape shape;
    norma_report report;
    gltf_data data = {0};
    float *owned = NULL, *tangents = norma_io_block(3 * p->faces, 16);
    *made = (tangent_corners){.count = 3 * p->faces};
    norma_document_result result =
        tangents ? gather_shape(job, primitive, &shape, &owned) : norma_gltf_job_memory(&job->sets);
    if (!result) result = compute_shape_tangents(job, &shape, tangents, &report);
    if (!result) {
        made->corners = shape.corners;
        count_reasons(job->summary, &report);
        result = morph_all(job, p, &shape, tangents, made);
    }
    if (!result) result = gltf_encode_tangents(job, of, tangents, made->count, &data);
    made->codes = data.bytes;
    free(tangents);
    free(owned);
    return result;
}

/* gltf_tangents.c: a primitive's tangents, encoded, and their deltas in morph targets. */
static void gltf_corner_tangents_free(const gltf_primitive *p, tangent_corners *made) {
    for (uint32_t t = 0; made->deltas && t < p->target_count; ++t) free(made->deltas[t]);
    free(made->deltas);
    free(made->codes);
    *made = (tangent_corners){0};
}

/* ---- Corners with their tangents become vertices: the first tangent at an old
 * vertex gets its number, so that old indices stay right; further ones are added behind. */

/* ---- which old tangents stay */

/* Rules N801 and N802, as norma check measures them: not of unit length, or a sign that is none. */
static int is_broken_tangent(const float tangent[4], int bits) {
    const double vector[3] = {(double)tangent[0], (double)tangent[1], (double)tangent[2]};
    return norma_normal_is_broken(vector, bits) || (tangent[3] != 1 && tangent[3] != -1);
}

static norma_document_result find_broken_tangents(tangent_job *job, tangent_set *of) {
    gltf_set *set = of->set;
    set->broken = norma_io_allocate(set->vertices, 1);
    if (!set->broken) return norma_gltf_job_memory(&job->sets);
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
           norma_gltf_holds_units(array->component, array->normalized);
}

static norma_document_result gltf_begin_tangents(tangent_job *job, gltf_set *set, tangent_set *of) {
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
        float *deltas = norma_io_move_block(of->set->deltas[t], of->capacity * 12, larger, 12);
        if (!deltas) return 0;
        of->set->deltas[t] = deltas;
        memset(deltas + 3 * of->capacity, 0, (larger - of->capacity) * 12);
    }
    of->capacity = larger;
    return 1;
}

static int begin_tangent_vertices(tangent_set *of, const gltf_primitive *p, float *const *like) {
    gltf_set *set = of->set;
    if (set->taken) return 1;
    set->taken = norma_io_allocate(set->vertices, 1);
    of->set->deltas = norma_io_allocate((size_t)p->target_count + 1, sizeof *of->set->deltas);
    return set->taken && of->set->deltas && grow_vertices(of, p->target_count, like, set->vertices);
}

/* The number of the vertex that a corner's becomes; GLTF_NONE: out of memory, or of numbers. */
static uint32_t take_tangent_vertex(tangent_set *of, const gltf_primitive *p, uint32_t vertex,
    const tangent_corners *made, size_t corner) {
    gltf_set *set = of->set;
    const unsigned char *code = made->codes + corner * of->size;
    size_t number = vertex;
    if (set->broken && !set->broken[vertex]) return vertex;
    uint32_t *place = norma_gltf_find_vertex(set, of->codes, of->size, vertex, code);
    if (!place) return GLTF_NONE;
    if (*place) return *place - 1;
    if (set->taken[vertex]) {
        number = norma_gltf_add_vertex(set, vertex);
        if (number == SIZE_MAX || !grow_vertices(of, p->target_count, made->deltas, number + 1))
            return GLTF_NONE;
    }
    set->taken[vertex] = 1;
    memcpy(of->codes + number * of->size, code, of->size);
    for (uint32_t t = 0; t < p->target_count; ++t)
        if (made->deltas[t])
            memcpy(of->set->deltas[t] + 3 * number, made->deltas[t] + 3 * corner, 12);
    *place = (uint32_t)number + 1;
    return (uint32_t)number;
}

static norma_document_result gltf_take_tangents(
    tangent_job *job, uint32_t primitive, tangent_set *of, const tangent_corners *made) {
    const gltf_primitive *p = &job->sets.g->primitives[primitive];
    of->size = 4 * norma_gltf_component_size(of->encoding.component);
    uint32_t *corners = norma_io_block(made->count, sizeof *corners);
    job->sets.corners[primitive] = corners;
    if (!corners || !begin_tangent_vertices(of, p, made->deltas))
        return norma_gltf_job_memory(&job->sets);
    for (size_t c = 0; c < made->count; ++c) {
        corners[c] = take_tangent_vertex(of, p, made->corners[c], made, c);
        if (corners[c] == GLTF_NONE) return norma_gltf_job_memory(&job->sets);
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
    if (!tangents ||
        norma_orthogonalise_tangents(tangents, 0, view, set->vertices, tangents, 0, set->vertices))
        result = norma_gltf_job_memory(&job->sets);
    for (size_t v = 0; !result && v < set->vertices; ++v) tangents[4 * v + 3] = 1;
    if (!result) result = gltf_encode_tangents(job, of, tangents, set->vertices, &data);
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
        const int made = of->set->deltas[t] != NULL;
        if (of->set->added_count)
            result = put_copies(job, of, (int32_t)t, &g->targets[lead->first_target + t], made);
        if (!result && made)
            result = norma_gltf_put_deltas(&job->sets, of->set, t, "TANGENT", of->set->deltas[t]);
        free(of->set->deltas[t]);
        of->set->deltas[t] = NULL;
    }
    return result;
}

static norma_document_result gltf_put_tangents(tangent_job *job, tangent_set *of) {
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

/* ---- What became of the tangents that stood on the normals which were computed
 * anew: kept, made perpendicular, or marked to be computed anew as well. */

/* Whether norma_gltf_tangents will give tangents to all primitives of the set, now that each has
 * normals. */
static int can_renew(const tangent_job *job, const gltf_job *computed, const gltf_set *set) {
    if (job->sets.g->primitives[set->lead].base.tangent == GLTF_NONE) return 0;
    for (uint32_t i = set->lead; i != GLTF_NONE; i = computed->next_in_set[i])
        if (job->sets.g->primitives[i].faces == 0 ||
            !gltf_has_map_texcoords(job, &job->sets.g->primitives[i]))
            return 0;
    return 1;
}

/* Vertices count once for each primitive, as those of the summary do. */
static void count_set_tangents(const gltf_job *job, const gltf_set *set) {
    norma_compute_summary *summary = job->policy.summary;
    uint8_t *renew = job->g->document->renew;
    for (uint32_t i = set->lead; i != GLTF_NONE; i = job->next_in_set[i]) {
        if (renew && renew[i]) {
            summary->tangents_regenerated += set->vertices + set->added_count;
        } else {
            summary->tangents_kept += set->tangents_kept;
            summary->tangents_orthogonalised += set->tangents_turned;
        }
    }
}

static norma_document_result mark_renewed(const gltf_job *job) {
    const norma_tangent_options options = {0};
    tangent_job tangents = {.sets = {.g = job->g, .error = job->error}, .options = &options};
    uint8_t *renew = norma_io_allocate((size_t)job->g->primitive_count + 1, 1);
    if (!renew || !norma_gltf_scene_of(job->g)) {
        free(renew);
        return norma_gltf_job_memory(job);
    }
    for (uint32_t s = 0; s < job->set_count; ++s) {
        const gltf_set *set = &job->sets[s];
        if (!set->wanted || !can_renew(&tangents, job, set)) continue;
        for (uint32_t i = set->lead; i != GLTF_NONE; i = job->next_in_set[i]) renew[i] = 1;
    }
    job->g->document->renew = renew;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_account_tangents(gltf_job *job) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (job->options->tangents == NORMA_STORED_TANGENTS_REGENERATE) result = mark_renewed(job);
    for (uint32_t s = 0; !result && s < job->set_count; ++s)
        if (job->sets[s].wanted) count_set_tangents(job, &job->sets[s]);
    return result;
}

/* ---- Tangents for a glTF asset: set by set the tangents of its primitives' corners,
 * the vertices that they become, and the new contents of the accessors. */

/* Each primitive of a set must have what tangents need: they share their vertices. */
static int is_possible(const tangent_job *job, const gltf_set *set) {
    const uint8_t *meshes = job->options->meshes;
    for (uint32_t i = set->lead; i != GLTF_NONE; i = job->sets.next_in_set[i])
        if ((meshes && !meshes[i]) || !gltf_takes_tangents(job, &job->sets.g->primitives[i]))
            return 0;
    return 1;
}

static size_t count_surfaces(const tangent_job *job, const gltf_set *set) {
    size_t count = 0;
    for (uint32_t i = set->lead; i != GLTF_NONE; i = job->sets.next_in_set[i])
        count += job->sets.g->primitives[i].mode >= GLTF_TRIANGLES;
    return count;
}

static norma_document_result compute_set(tangent_job *job, gltf_set *set) {
    const gltf *g = job->sets.g;
    tangent_set of;
    norma_document_result result = gltf_begin_tangents(job, set, &of);
    for (uint32_t i = set->lead; !result && set->wanted && i != GLTF_NONE;
         i = job->sets.next_in_set[i]) {
        tangent_corners made;
        result = gltf_corner_tangents(job, i, &of, &made);
        if (!result) result = gltf_take_tangents(job, i, &of, &made);
        gltf_corner_tangents_free(&g->primitives[i], &made);
        job->sets.progress_base += job->sets.progress_scale;
        ++job->summary->primitives;
    }
    if (!result && set->wanted) result = gltf_put_tangents(job, &of);
    free(of.codes);
    return result;
}

static norma_document_result compute_sets(tangent_job *job) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t s = 0; !result && s < job->sets.set_count; ++s) {
        gltf_set *set = &job->sets.sets[s];
        set->wanted = is_possible(job, set);
        if (set->wanted)
            result = compute_set(job, set);
        else
            job->summary->left_out += count_surfaces(job, set);
    }
    for (uint32_t i = 0; !result && i < job->sets.g->primitive_count; ++i)
        if (job->sets.corners[i]) result = norma_gltf_put_indices(&job->sets, i);
    return result;
}

static void count_tangents(const tangent_job *job) {
    for (uint32_t i = 0; i < job->sets.g->primitive_count; ++i) {
        const gltf_primitive *p = &job->sets.g->primitives[i];
        const gltf_set *set =
            job->sets.set_of[i] == GLTF_NONE ? NULL : &job->sets.sets[job->sets.set_of[i]];
        job->summary->vertices_before += p->vertices;
        job->summary->vertices_after += p->vertices + (set && set->wanted ? set->added_count : 0);
        job->summary->left_out += p->mode >= GLTF_TRIANGLES && !set;
    }
}

norma_document_result norma_gltf_tangents(norma_document *document,
    const norma_tangent_options *options, norma_tangent_summary *summary,
    norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    tangent_job job = {
        .sets = {.g = g,
            .error = error,
            .progress_scale = g->primitive_count ? 1 / (double)g->primitive_count : 0},
        .all = {.progress = options->progress, .progress_user = options->progress_user},
        .options = options,
        .summary = summary,
        .core = {.struct_size = sizeof job.core,
            .weight = options->weight,
            .threads = options->threads}};
    job.sets.options = &job.all;
    norma_gltf_begin_change(g);
    norma_document_result result = norma_gltf_scene_of(g)
                                       ? norma_gltf_find_vertex_sharing(&job.sets)
                                       : norma_gltf_job_memory(&job.sets);
    if (!result) result = compute_sets(&job);
    if (!result) {
        count_tangents(&job);
        result = norma_gltf_finish(g, error);
        summary->changed = g->changed;
    }
    norma_gltf_vertex_sharing_free(&job.sets);
    return result;
}
