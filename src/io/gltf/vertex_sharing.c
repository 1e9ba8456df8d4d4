/* vertex_sharing.c: which primitives share vertices, and what becomes of those: points become
 * vertices, corners new indices. */
#include "io/gltf/gltf.h"
#include "core/call/table.h"
#include <stdlib.h>
#include <string.h>

/* ---- Which primitives draw the same vertices, and which vertices their points
 * become: the first point of an old vertex gets its number, so that old indices stay right; further
 * ones are added behind. */

/* ---- making sets */

static int same_attributes(const gltf *g, const gltf_attributes *a, const gltf_attributes *b) {
    if (a->count != b->count || a->position != b->position || a->normal != b->normal) return 0;
    for (uint32_t i = a->first; i < a->first + a->count; ++i) {
        uint32_t k = norma_gltf_find(g, b, g->attributes[i].name);
        if (k == GLTF_NONE || g->attributes[k].accessor != g->attributes[i].accessor) return 0;
    }
    return 1;
}

static int has_morphs(const gltf_job *job, const gltf_primitive *p) {
    for (uint32_t t = 0; t < p->target_count; ++t)
        if (norma_gltf_morphs_normals(job, &job->g->targets[p->first_target + t])) return 1;
    return 0;
}

/* Deltas hang on what surrounds the vertex in its own mesh: with them a set does not reach over
 * several meshes. */
static int is_same_set(const gltf_job *job, const gltf_set *set, const gltf_primitive *p) {
    const gltf *g = job->g;
    const gltf_primitive *lead = &g->primitives[set->lead];
    int same = p->target_count == lead->target_count &&
               (p->mesh == lead->mesh || (!set->has_morphs && !has_morphs(job, p)));
    for (int32_t t = GLTF_SLOT_BASE; same && t < (int32_t)p->target_count; ++t)
        same = same_attributes(g, norma_gltf_set_of(g, p, t), norma_gltf_set_of(g, lead, t));
    return same;
}

/* Which normals are replaced: broken ones, or only those that are missing behind the others. */
static norma_document_result mark_replaced(gltf_job *job, gltf_set *set, uint32_t normal) {
    gltf_array array = {.count = job->g->accessors[normal].count};
    const int broken = job->options->only == NORMA_ONLY_BROKEN;
    norma_document_result result =
        broken ? norma_gltf_array(job->g, normal, &array, job->error) : NORMA_DOCUMENT_OK;
    if (result) return result;
    set->broken = norma_io_allocate(set->vertices, 1);
    if (!set->broken) return norma_gltf_job_memory(job);
    set->wanted = 0;
    for (size_t i = broken ? 0 : array.count; i < set->vertices; ++i) {
        float n[16] = {0};
        if (broken) norma_gltf_floats(&array, i, n);
        const double vector[3] = {(double)n[0], (double)n[1], (double)n[2]};
        set->broken[i] = !broken || array.width != 3 ||
                         norma_normal_is_broken(vector, array.component == GLTF_BYTE ? 8 : 32);
        set->wanted |= set->broken[i];
    }
    return NORMA_DOCUMENT_OK;
}

/* Of normals that are fewer than positions (read leniently) the rest is missing; too many become as
 * many as there are positions. */
static int counts_differ(const gltf_job *job, const gltf_primitive *p) {
    return job->g->accessors[p->base.normal].count != p->vertices;
}

static int lacks_deltas(const gltf_job *job, const gltf_primitive *p) {
    for (uint32_t t = 0; job->options->morphs && t < p->target_count; ++t) {
        const gltf_attributes *target = &job->g->targets[p->first_target + t];
        if (target->normal == GLTF_NONE && target->position != GLTF_NONE) return 1;
    }
    return 0;
}

static norma_document_result begin_set(gltf_job *job, gltf_set *set, uint32_t primitive) {
    const gltf_primitive *p = &job->g->primitives[primitive];
    *set = (gltf_set){.lead = primitive,
        .last = primitive,
        .mesh = p->mesh,
        .vertices = p->vertices,
        .wanted = 1,
        .has_morphs = has_morphs(job, p)};
    if (job->options->only == NORMA_ONLY_ALL || p->base.normal == GLTF_NONE)
        return NORMA_DOCUMENT_OK;
    const norma_document_result result = mark_replaced(job, set, p->base.normal);
    if (job->options->only == NORMA_ONLY_MISSING) set->wanted = lacks_deltas(job, p);
    set->wanted |= counts_differ(job, p);
    return result;
}

/* Steele, Lea, Flood 2014, splitmix64. */
static uint64_t mixed_accessors(uint64_t z) {
    z = (z + 0x9E3779B97F4A7C15u) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return z ^ z >> 31;
}

/* Primitives of one set have the same one; attributes may stand in any order. */
static uint64_t hash_primitive(const gltf_job *job, const gltf_primitive *p) {
    const gltf *g = job->g;
    uint64_t hash = mixed_accessors(has_morphs(job, p) ? (uint64_t)p->mesh + 1 : 0);
    for (int32_t t = GLTF_SLOT_BASE; t < (int32_t)p->target_count; ++t) {
        const gltf_attributes *set = norma_gltf_set_of(g, p, t);
        uint64_t sum = 0;
        for (uint32_t i = set->first; i < set->first + set->count; ++i)
            sum += mixed_accessors(g->attributes[i].accessor);
        hash = mixed_accessors(hash ^ sum);
    }
    return hash;
}

typedef struct wanted_set {
    const gltf_job *job;
    const gltf_primitive *p;
} wanted_set;

static int is_wanted_set(const void *context, uint32_t number) {
    const wanted_set *w = context;
    return is_same_set(w->job, &w->job->sets[number], w->p);
}

/* Puts a primitive into its set, and makes the set if it does not exist yet. */
static norma_document_result join_set(
    gltf_job *job, uint32_t primitive, uint32_t *table, size_t size) {
    const gltf_primitive *p = &job->g->primitives[primitive];
    const wanted_set w = {job, p};
    uint32_t *number =
        norma_core_table_find(table, size, hash_primitive(job, p), is_wanted_set, &w);
    const int is_new_set = *number == 0;
    if (is_new_set) *number = ++job->set_count;
    gltf_set *set = &job->sets[*number - 1];
    job->set_of[primitive] = *number - 1;
    if (is_new_set) return begin_set(job, set, primitive);
    set->mesh = set->mesh == p->mesh ? p->mesh : GLTF_NONE;
    job->next_in_set[set->last] = primitive;
    set->last = primitive;
    return NORMA_DOCUMENT_OK;
}

/* Vertices that a primitive draws which is locked, or not asked for, keep their normals, whoever
 * else draws them. */
static int is_locked_set(const gltf_job *job, uint32_t primitive) {
    const shared_normals *shared = job->g->document->shared;
    const uint8_t *asked = job->options->meshes;
    const int locked =
        (shared && shared->locked && shared->locked[primitive]) || (asked && !asked[primitive]);
    return locked && job->set_of[primitive] != GLTF_NONE;
}

int norma_gltf_pass_on(void *user, double fraction) {
    const gltf_job *job = user;
    return job->options->progress(
        job->options->progress_user, job->progress_base + fraction * job->progress_scale);
}

norma_document_result norma_gltf_find_vertex_sharing(gltf_job *job) {
    const gltf *g = job->g;
    norma_document_result result = NORMA_DOCUMENT_OK;
    const size_t size = norma_core_table_size(g->primitive_count);
    uint32_t *table = norma_io_allocate(size, sizeof *table);
    job->sets = norma_io_allocate(g->primitive_count, sizeof *job->sets);
    job->set_of = norma_io_allocate(g->primitive_count, sizeof *job->set_of);
    job->next_in_set = norma_io_allocate(g->primitive_count, sizeof *job->next_in_set);
    job->corners = norma_io_allocate(g->primitive_count, sizeof *job->corners);
    if (!table || !job->sets || !job->set_of || !job->next_in_set || !job->corners)
        result = norma_gltf_job_memory(job);
    for (uint32_t i = 0; !result && i < g->primitive_count; ++i) {
        job->set_of[i] = job->next_in_set[i] = GLTF_NONE;
        if (!g->primitives[i].not_read) result = join_set(job, i, table, size);
        if (!result && is_locked_set(job, i)) job->sets[job->set_of[i]].wanted = 0;
    }
    free(table);
    return result;
}

void norma_gltf_vertex_sharing_free(gltf_job *job) {
    for (uint32_t s = 0; s < job->set_count; ++s) {
        gltf_set *set = &job->sets[s];
        for (uint32_t t = 0; set->deltas && t < job->g->primitives[set->lead].target_count; ++t)
            free(set->deltas[t]);
        void *const blocks[] = {set->broken, set->taken, set->added, set->normals, set->reasons,
            set->point_of, set->table, set->deltas};
        for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; ++i) free(blocks[i]);
    }
    for (uint32_t i = 0; job->corners && i < job->g->primitive_count; ++i) free(job->corners[i]);
    free(job->corners);
    free(job->sets);
    free(job->set_of);
    free(job->next_in_set);
}

/* ---- points become vertices */

static int make_set_room(gltf_set *set, size_t needed) {
    if (needed <= set->capacity) return 1;
    size_t larger = set->capacity + set->capacity / 2;
    larger = larger < needed ? needed : larger;
    if (larger > SIZE_MAX / 16) return 0;
    float *normals = realloc(set->normals, larger * 3 * sizeof *normals);
    set->normals = normals ? normals : set->normals;
    uint8_t *reasons = realloc(set->reasons, larger);
    set->reasons = reasons ? reasons : set->reasons;
    uint32_t *point_of = set->has_morphs ? realloc(set->point_of, larger * sizeof *point_of) : NULL;
    set->point_of = point_of ? point_of : set->point_of;
    if (!normals || !reasons || (set->has_morphs && !point_of)) return 0;
    memset(set->normals + 3 * set->capacity, 0, (larger - set->capacity) * 3 * sizeof *normals);
    memset(set->reasons + set->capacity, 0, larger - set->capacity);
    if (set->has_morphs)
        memset(set->point_of + set->capacity, 0xFF, (larger - set->capacity) * sizeof *point_of);
    set->capacity = larger;
    return 1;
}

static int begin_set_vertices(gltf_set *set) {
    if (set->taken) return 1;
    set->taken = norma_io_allocate(set->vertices, 1);
    return set->taken && make_set_room(set, set->vertices);
}

typedef struct wanted_vertex {
    const gltf_set *set;
    const unsigned char *codes; /* size bytes of each vertex */
    size_t size;
    uint32_t vertex;
    const void *code;
} wanted_vertex;

static int is_wanted_vertex(const void *context, uint32_t number) {
    const wanted_vertex *w = context;
    return norma_gltf_old_vertex(w->set, number) == w->vertex &&
           memcmp(w->codes + number * w->size, w->code, w->size) == 0;
}

static uint32_t *look_for_vertex(uint32_t *table, size_t table_size, const wanted_vertex *w) {
    const uint64_t hash =
        norma_core_hash(w->code, w->size) ^ w->vertex * UINT64_C(0xD6E8FEB86659FD93) >> 20;
    return norma_core_table_find(table, table_size, hash, is_wanted_vertex, w);
}

static int grow_vertex_table(gltf_set *set, const unsigned char *codes, size_t size) {
    const size_t larger = norma_core_table_size(2 * (set->vertices + set->added_count + 1));
    uint32_t *table = norma_io_allocate(larger, sizeof *table);
    for (size_t i = 0; table && i < set->table_size; ++i) {
        if (!set->table[i]) continue;
        const uint32_t number = set->table[i] - 1;
        const wanted_vertex w = {
            set, codes, size, norma_gltf_old_vertex(set, number), codes + number * size};
        *look_for_vertex(table, larger, &w) = number + 1;
    }
    if (!table) return 0;
    free(set->table);
    set->table = table;
    set->table_size = larger;
    return 1;
}

uint32_t *norma_gltf_find_vertex(
    gltf_set *set, const void *codes, size_t size, uint32_t vertex, const void *code) {
    const wanted_vertex w = {set, codes, size, vertex, code};
    return set->table_size / 2 > set->vertices + set->added_count ||
                   grow_vertex_table(set, codes, size)
               ? look_for_vertex(set->table, set->table_size, &w)
               : NULL;
}

/* The number of the vertex that an old vertex with this normal becomes; GLTF_NONE: out of memory,
 * or of numbers. */
static uint32_t take_set_vertex(
    gltf_set *set, uint32_t vertex, const float normal[3], uint8_t reason) {
    size_t number = vertex;
    uint32_t *place = NULL;
    if (set->broken && !set->broken[vertex]) return vertex;
    if (set->mesh == GLTF_NONE) { /* within one mesh points differ anyway */
        place = norma_gltf_find_vertex(set, set->normals, 3 * sizeof *normal, vertex, normal);
        if (!place) return GLTF_NONE;
        if (*place) return *place - 1;
    }
    if (set->taken[vertex]) {
        number = norma_gltf_add_vertex(set, vertex);
        if (number == SIZE_MAX || !make_set_room(set, number + 1)) return GLTF_NONE;
    }
    set->taken[vertex] = 1;
    memcpy(set->normals + 3 * number, normal, 3 * sizeof *normal);
    set->reasons[number] = reason;
    if (place) *place = (uint32_t)number + 1;
    return (uint32_t)number;
}

/* The points of a primitive's corners, for which stamps do not say already that they have their
 * place. */
static int take_points_of(gltf_set *set, uint32_t set_number, const gltf_surface *s, uint32_t local,
    size_t corner_count, uint32_t *places, uint32_t *stamps) {
    const uint32_t *points = norma_gltf_points(s) + s->corner_start[local];
    for (size_t c = 0; c < corner_count; ++c) {
        const uint32_t point = points[c];
        if (stamps[point] == set_number + 1) continue;
        uint32_t vertex = s->sources[point] - (uint32_t)s->position_start[local];
        places[point] =
            take_set_vertex(set, vertex, s->normals + 3 * (size_t)point, s->reasons[point]);
        stamps[point] = set_number + 1;
        if (places[point] == GLTF_NONE) return 0;
        if (set->has_morphs) set->point_of[places[point]] = point;
    }
    return 1;
}

/* places: for each point of the surface its vertex in this set, valid where stamps says the set's
 * number + 1. */
static int take_primitive(
    gltf_job *job, const gltf_surface *s, uint32_t number, uint32_t *places, uint32_t *stamps) {
    const gltf_primitive *p = &job->g->primitives[number];
    const uint32_t local = p->number, set_number = job->set_of[number];
    gltf_set *set = &job->sets[set_number];
    if (!begin_set_vertices(set) ||
        !take_points_of(set, set_number, s, local, 3 * p->faces, places, stamps))
        return 0;
    const uint32_t *points = norma_gltf_points(s) + s->corner_start[local];
    uint32_t *corners = job->corners[number] = norma_io_block(p->faces, 3 * sizeof *corners);
    for (size_t c = 0; corners && c < 3 * p->faces; ++c) corners[c] = places[points[c]];
    return corners != NULL;
}

norma_document_result norma_gltf_take_points(gltf_job *job, gltf_surface *s) {
    const gltf_mesh *mesh = &job->g->meshes[s->mesh];
    uint32_t *places = norma_io_block(s->point_count, sizeof *places),
             *stamps = norma_io_allocate(s->point_count, sizeof *stamps);
    unsigned char *done = norma_io_allocate(mesh->primitive_count, 1);
    int ok = places && stamps && done;
    for (uint32_t i = 0; ok && i < mesh->primitive_count; ++i) {
        uint32_t set = job->set_of[mesh->first_primitive + i];
        if (set == GLTF_NONE || !job->sets[set].wanted) continue;
        for (uint32_t k = i; ok && k < mesh->primitive_count && !done[i]; ++k)
            if (job->set_of[mesh->first_primitive + k] == set && !done[k]) {
                ok = take_primitive(job, s, mesh->first_primitive + k, places, stamps);
                done[k] = k != i;
            }
        done[i] = 1;
    }
    free(places);
    free(stamps);
    free(done);
    return ok ? NORMA_DOCUMENT_OK : norma_gltf_job_memory(job);
}

/* ---- vertices that no triangle uses */

static norma_document_result own_corners(
    gltf_job *job, const gltf_set *set, uint32_t **corners, size_t *count) {
    gltf *g = job->g;
    *corners = NULL;
    *count = 0;
    for (uint32_t i = set->lead; i != GLTF_NONE; i = job->next_in_set[i])
        *count += 3 * g->primitives[i].faces;
    *corners = norma_io_allocate(*count, sizeof **corners);
    size_t at = 0;
    for (uint32_t i = set->lead; *corners && i != GLTF_NONE; i = job->next_in_set[i]) {
        const uint32_t *own;
        norma_document_result result = norma_gltf_corners(g, i, &own, job->error);
        if (result) return result;
        memcpy(*corners + at, own, 3 * g->primitives[i].faces * sizeof *own);
        at += 3 * g->primitives[i].faces;
    }
    return *corners ? NORMA_DOCUMENT_OK : norma_gltf_job_memory(job);
}

static void take_nearest(gltf_set *set, const float *normals, const uint8_t *reasons) {
    for (size_t v = 0; v < set->vertices; ++v) {
        const float *from = normals + 3 * v;
        float *to = set->normals + 3 * v;
        if (set->taken[v] || (set->broken && !set->broken[v])) continue;
        memcpy(to, from, 3 * sizeof *to);
        set->reasons[v] = reasons[v] == NORMA_REASON_NON_FINITE ? NORMA_REASON_NON_FINITE
                                                                : NORMA_REASON_UNREFERENCED;
    }
}

norma_document_result norma_gltf_fill_unreferenced(gltf_job *job, gltf_set *set) {
    size_t missing = 0, count;
    norma_vec3_view positions;
    uint32_t *corners = NULL;
    if (!begin_set_vertices(set)) return norma_gltf_job_memory(job);
    for (size_t v = 0; v < set->vertices; ++v)
        missing += !set->taken[v] && (!set->broken || set->broken[v]);
    if (!missing) return NORMA_DOCUMENT_OK;
    norma_document_result result = norma_gltf_position_view(
        job->g, job->g->primitives[set->lead].base.position, &positions, job->error);
    if (!result) result = own_corners(job, set, &corners, &count);
    if (result) {
        free(corners);
        return result;
    }
    float *normals = norma_io_allocate(set->vertices, 3 * sizeof *normals);
    uint8_t *reasons = norma_io_allocate(set->vertices, 1);
    const norma_mesh mesh = {.positions = positions, .corners = corners, .corner_count = count};
    norma_result core = NORMA_ERROR_MEMORY;
    job->policy.core.reasons = reasons;
    if (normals && reasons)
        core = norma_vertex_normals(&mesh, &job->policy.core, normals, set->vertices, NULL);
    job->policy.core.reasons = NULL;
    if (!core) take_nearest(set, normals, reasons);
    free(corners);
    free(normals);
    free(reasons);
    return core ? norma_document_fail_core(job->g->document, job->error, core) : NORMA_DOCUMENT_OK;
}

/* ---- A primitive's new indices. They stay as they are where no corner changed; they
 * widen where added vertices need it, the largest value of each width being no index
 * (glTF 2.0, 3.7.2.1); strips and fans whose corners changed become triangles. */

/* Corners of a triangle list that make no whole triangle stay at its end. */
static size_t left_over(const gltf *g, const gltf_primitive *p) {
    if (p->mode != GLTF_TRIANGLES) return 0;
    return (p->indices == GLTF_NONE ? p->vertices : g->accessors[p->indices].count) - 3 * p->faces;
}

/* Of a strip or fan, what is drawn: triangles that name a vertex twice only lead from one part to
 * the next, and a list needs none. Returns the number of corners. */
static size_t drop_stitches(const uint32_t *old, uint32_t *corners, size_t faces) {
    size_t kept = 0;
    for (size_t f = 0; f < faces; ++f) {
        const uint32_t *of = old + 3 * f;
        if (of[0] == of[1] || of[1] == of[2] || of[2] == of[0]) continue;
        memmove(corners + kept, corners + 3 * f, 3 * sizeof *corners);
        kept += 3;
    }
    return kept ? kept : 3 * faces;
}

/* Takes the corners, which it frees or hands on; further indices of the primitive's own, that make
 * no whole triangle, stay behind them. */
static norma_document_result put_index_list(
    gltf_job *job, uint32_t number, uint32_t *corners, size_t count, size_t extra) {
    gltf *g = job->g;
    const gltf_primitive *p = &g->primitives[number];
    gltf_array old = {0};
    uint32_t largest = 0;
    norma_document_result result = p->indices == GLTF_NONE
                                       ? NORMA_DOCUMENT_OK
                                       : norma_gltf_array(g, p->indices, &old, job->error);
    uint32_t *all =
        extra ? norma_io_move_block(corners, count * sizeof *all, count + extra, sizeof *all)
              : corners;
    if (!result && !all) result = norma_gltf_job_memory(job);
    if (result) {
        free(all ? all : corners);
        return result;
    }
    for (size_t i = 0; i < count; ++i) largest = all[i] > largest ? all[i] : largest;
    for (size_t i = count; i < count + extra; ++i) {
        all[i] = (uint32_t)i;
        if (old.data) norma_gltf_uints(&old, i, &all[i]);
    }
    gltf_data data = {
        .component = norma_gltf_index_component(g, p, (size_t)largest + 1, GLTF_USHORT),
        .width = 1,
        .count = count + extra,
        .is_indices = 1};
    if (data.component == GLTF_UINT && norma_gltf_is_low_first()) {
        data.bytes = (unsigned char *)all; /* as the file is to have them already */
    } else {
        data.bytes = norma_gltf_encode_indices(data.component, all, data.count);
        free(all);
    }
    const gltf_slot slot = {.primitive = number, .target = GLTF_SLOT_INDICES};
    return data.bytes ? norma_gltf_put_new(g, &slot, &data, job->error)
                      : norma_gltf_job_memory(job);
}

/* 0, 1, 2, ...: for a primitive without indices whose vertices became more than it draws. */
static norma_document_result put_sequence(gltf_job *job, uint32_t number) {
    const gltf_primitive *p = &job->g->primitives[number];
    uint32_t *corners = norma_io_allocate(p->vertices, sizeof *corners);
    if (!corners) return norma_gltf_job_memory(job);
    for (size_t i = 0; i < p->vertices; ++i) corners[i] = (uint32_t)i;
    return put_index_list(job, number, corners, p->vertices, 0);
}

norma_document_result norma_gltf_put_indices(gltf_job *job, uint32_t number) {
    gltf *g = job->g;
    const gltf_primitive *p = &g->primitives[number];
    const gltf_set *set = &job->sets[job->set_of[number]];
    const uint32_t *old;
    norma_document_result result = norma_gltf_corners(g, number, &old, job->error);
    if (result || set->added_count == 0) return result;
    if (memcmp(old, job->corners[number], 3 * p->faces * sizeof *old) == 0)
        return p->indices == GLTF_NONE ? put_sequence(job, number) : NORMA_DOCUMENT_OK;
    size_t count = 3 * p->faces;
    if (p->mode != GLTF_TRIANGLES) {
        norma_gltf_set_mode(g, 0, number, GLTF_TRIANGLES);
        count = drop_stitches(old, job->corners[number], p->faces);
    }
    uint32_t *corners = job->corners[number];
    job->corners[number] = NULL;
    return put_index_list(job, number, corners, count, left_over(g, p));
}
