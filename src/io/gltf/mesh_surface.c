/* mesh_surface.c: the triangles of a mesh as one surface, whatever its primitives: for computing
 * normals, and for surfaces that lie in several files. */
#include "io/gltf/gltf.h"
#include "io/file/file.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- The triangles of a mesh as one surface for the core, and the points that the core
 * makes of them. */

void norma_gltf_surface_free(gltf_surface *s) {
    void *const blocks[] = {s->positions, s->corners, s->corner_start, s->position_start, s->points,
        s->sources, s->normals, s->reasons};
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; ++i) free(blocks[i]);
    *s = (gltf_surface){0};
}

/* ---- gathering */

/* Primitives with the same positions, in the base and in every target, share them. */
static int same_positions(const gltf *g, const gltf_primitive *a, const gltf_primitive *b) {
    if (a->base.position != b->base.position || a->target_count != b->target_count) return 0;
    for (uint32_t t = 0; t < a->target_count; ++t)
        if (g->targets[a->first_target + t].position != g->targets[b->first_target + t].position)
            return 0;
    return 1;
}

/* A table of primitives by what they share; SIZE_MAX: free. */
typedef struct sharers {
    size_t *first, size;
} sharers;

static size_t hash_surface_positions(const gltf *g, const gltf_primitive *p) {
    uint64_t hash = p->base.position;
    for (uint32_t t = 0; t < p->target_count; ++t)
        hash = (hash ^ hash >> 29 ^ g->targets[p->first_target + t].position) * 0x9E3779B97F4A7C15u;
    return (size_t)(hash ^ hash >> 32);
}

/* The first primitive with the same positions, and, where corners is nonzero, the same corners;
 * else i itself, which is put in. */
static size_t first_like(
    const gltf *g, const gltf_primitive *list, sharers *table, size_t i, int corners) {
    uint64_t hash = hash_surface_positions(g, &list[i]);
    if (corners)
        hash = (hash ^ ((uint64_t)list[i].indices << 8 | list[i].mode)) * 0xD6E8FEB86659FD93u;
    size_t at = (size_t)(hash ^ hash >> 32) & (table->size - 1);
    for (; table->first[at] != SIZE_MAX; at = (at + 1) & (table->size - 1)) {
        const gltf_primitive *other = &list[table->first[at]];
        if (same_positions(g, &list[i], other) &&
            (!corners || (list[i].indices == other->indices && list[i].mode == other->mode)))
            return table->first[at];
    }
    return table->first[at] = i;
}

/* Where each primitive's positions and corners begin; an exact repetition of a primitive (another
 * material over the same triangles) is taken once. 0: out of memory. */
static int lay_out_surface(const gltf *g, gltf_surface *s, size_t *positions, size_t *corners) {
    const gltf_mesh *mesh = &g->meshes[s->mesh];
    const gltf_primitive *list = g->primitives + mesh->first_primitive;
    size_t size = 2;
    while (size / 2 < mesh->primitive_count) size *= 2;
    sharers by_positions = {norma_io_allocate(size, sizeof(size_t)), size},
            by_corners = {norma_io_allocate(size, sizeof(size_t)), size};
    const int there = by_positions.first && by_corners.first;
    if (there) {
        memset(by_positions.first, 0xFF, size * sizeof(size_t));
        memset(by_corners.first, 0xFF, size * sizeof(size_t));
    }
    for (uint32_t i = 0; there && i < mesh->primitive_count; ++i) {
        s->corner_start[i] = s->position_start[i] = SIZE_MAX;
        if (list[i].not_read) continue;
        const size_t with_positions = first_like(g, list, &by_positions, i, 0),
                     with_corners = first_like(g, list, &by_corners, i, 1);
        s->position_start[i] = with_positions == i ? *positions : s->position_start[with_positions];
        s->corner_start[i] = with_corners == i ? *corners : s->corner_start[with_corners];
        *positions += with_positions == i ? list[i].vertices : 0;
        *corners += with_corners == i ? 3 * list[i].faces : 0;
    }
    free(by_positions.first);
    free(by_corners.first);
    return there;
}

typedef struct encoding {
    int component, normalized, mixed, count;
} encoding;

static encoding surface_encoding(const gltf *g, const gltf_mesh *mesh) {
    encoding e = {.count = 0};
    for (uint32_t i = 0; i < mesh->primitive_count; ++i) {
        const gltf_primitive *p = &g->primitives[mesh->first_primitive + i];
        if (p->not_read) continue;
        const gltf_accessor *a = &g->accessors[p->base.position];
        e.mixed |= a->component == GLTF_HALF ||
                   (e.count > 0 && (e.component != a->component || e.normalized != a->normalized));
        e.component = a->component;
        e.normalized = a->normalized;
        ++e.count;
    }
    return e;
}

/* -128 and -127 mean the same where they are normalised: the core must see equal numbers. */
static void clamp_signed(unsigned char *at, int component) {
    static const unsigned char least8 = 0x80, least16[2] = {0x00, 0x80};
    for (int k = 0; k < 3; ++k) {
        if (component == GLTF_BYTE && at[k] == least8) at[k] = 0x81;
        if (component == GLTF_SHORT && memcmp(at + 2 * k, least16, 2) == 0) at[2 * k] = 0x01;
    }
}

static void copy_surface_positions(
    const gltf_array *array, const encoding *e, unsigned char *to, size_t size) {
    for (size_t i = 0; i < array->count; ++i, to += size) {
        if (e->mixed) {
            float element[3];
            norma_gltf_floats(array, i, element);
            memcpy(to, element, sizeof element);
        } else {
            memcpy(to, array->data + i * array->stride, size);
            if (e->normalized) clamp_signed(to, e->component);
        }
    }
}

static norma_document_result gather_surface_positions(
    gltf_job *job, gltf_surface *s, size_t count) {
    gltf *g = job->g;
    const gltf_mesh *mesh = &g->meshes[s->mesh];
    encoding e = surface_encoding(g, mesh);
    size_t size = e.mixed ? 3 * sizeof(float) : 3 * norma_gltf_component_size(e.component);
    gltf_array shape = {.component = e.mixed ? GLTF_FLOAT : e.component}, array;
    size_t next = 0;
    int direct =
        !e.mixed && !(e.normalized && (e.component == GLTF_BYTE || e.component == GLTF_SHORT));
    s->core.positions = norma_gltf_vec3_view(&shape);
    s->core.positions.count = count;
    s->core.positions.stride = size;
    for (uint32_t i = 0; i < mesh->primitive_count; ++i) {
        if (s->position_start[i] != next || g->primitives[mesh->first_primitive + i].not_read)
            continue;
        norma_document_result result = norma_gltf_array(
            g, g->primitives[mesh->first_primitive + i].base.position, &array, job->error);
        if (result) return result;
        if (direct && array.count == count) {
            s->core.positions = norma_gltf_vec3_view(&array);
            return NORMA_DOCUMENT_OK;
        }
        if (!s->positions && !(s->positions = norma_io_block(count, size)))
            return norma_gltf_job_memory(job);
        copy_surface_positions(&array, &e, (unsigned char *)s->positions + next * size, size);
        next += array.count;
    }
    s->core.positions.data = s->positions;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result gather_corners(gltf_job *job, gltf_surface *s, size_t count) {
    gltf *g = job->g;
    const gltf_mesh *mesh = &g->meshes[s->mesh];
    size_t next = 0;
    s->core.corner_count = count;
    for (uint32_t i = 0; i < mesh->primitive_count; ++i) {
        const gltf_primitive *p = &g->primitives[mesh->first_primitive + i];
        const uint32_t *corners;
        if (s->corner_start[i] != next || p->not_read) continue;
        norma_document_result result =
            norma_gltf_corners(g, mesh->first_primitive + i, &corners, job->error);
        if (result) return result;
        if (3 * p->faces == count && s->position_start[i] == 0) {
            s->core.corners = corners;
            return NORMA_DOCUMENT_OK;
        }
        if (!s->corners && !(s->corners = norma_io_block(count, sizeof *s->corners)))
            return norma_gltf_job_memory(job);
        for (size_t k = 0; k < 3 * p->faces; ++k)
            s->corners[next + k] = corners[k] + (uint32_t)s->position_start[i];
        next += 3 * p->faces;
    }
    s->core.corners = s->corners;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_gather(gltf_job *job, uint32_t mesh, gltf_surface *s) {
    size_t positions = 0, corners = 0, count = job->g->meshes[mesh].primitive_count;
    *s = (gltf_surface){.mesh = mesh};
    s->corner_start = norma_io_allocate(count, sizeof *s->corner_start);
    s->position_start = norma_io_allocate(count, sizeof *s->position_start);
    if (!s->corner_start || !s->position_start || !lay_out_surface(job->g, s, &positions, &corners))
        return norma_gltf_job_memory(job);
    if (positions > UINT32_MAX || corners > UINT32_MAX)
        return norma_document_fail(job->g->document, job->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            job->g->primitives[job->g->meshes[mesh].first_primitive].where,
            "a mesh of more than 4294967295 vertices or corners");
    norma_document_result result = gather_surface_positions(job, s, positions);
    return result ? result : gather_corners(job, s, corners);
}

/* ---- points */

static uint64_t hash_point(uint32_t source, const float normal[3]) {
    uint32_t bits[3];
    memcpy(bits, normal, sizeof bits);
    uint64_t hash = ((uint64_t)source << 32 | bits[0]) * 0x9E3779B97F4A7C15u;
    hash = (hash ^ hash >> 31 ^ ((uint64_t)bits[1] << 32 | bits[2])) * 0xD6E8FEB86659FD93u;
    return hash ^ hash >> 32;
}

/* A point for each position and face normal that meet. */
static int join_faces(gltf_surface *s, const float *faces, const uint8_t *reasons) {
    const size_t most = s->core.corner_count;
    s->points = norma_io_block(most, sizeof *s->points);
    s->sources = norma_io_block(most, sizeof *s->sources);
    s->normals = norma_io_block(most, 3 * sizeof *s->normals);
    s->reasons = norma_io_allocate(most, 1);
    if (!s->points || !s->sources || !s->normals || !s->reasons) return 0;
    size_t size = 16;
    while (size / 2 < s->core.corner_count) size *= 2;
    uint32_t *table = norma_io_allocate(size, sizeof *table);
    const uint32_t *corners = s->core.corners;
    for (size_t c = 0; table && c < s->core.corner_count; ++c) {
        const float *normal = faces + c / 3 * 3;
        size_t at = hash_point(corners[c], normal) & (size - 1);
        while (table[at] && (s->sources[table[at] - 1] != corners[c] ||
                                memcmp(s->normals + 3 * (size_t)(table[at] - 1), normal,
                                    3 * sizeof *normal) != 0))
            at = (at + 1) & (size - 1);
        if (!table[at]) {
            s->sources[s->point_count] = corners[c];
            memcpy(s->normals + 3 * s->point_count, normal, 3 * sizeof *normal);
            s->reasons[s->point_count] = reasons[c / 3];
            table[at] = (uint32_t)++s->point_count;
        }
        s->points[c] = table[at] - 1;
    }
    s->in_order = 1;
    free(table);
    return table != NULL;
}

/* Each position is one point. */
static int take_surface_positions(gltf_surface *s) {
    s->sources = norma_io_block(s->point_count, sizeof *s->sources);
    for (size_t i = 0; s->sources && i < s->point_count; ++i) s->sources[i] = (uint32_t)i;
    return s->sources != NULL;
}

static void take_surface_points(gltf_surface *s, computed_normals *made) {
    s->points = made->points;
    s->sources = made->sources;
    s->normals = made->normals;
    s->reasons = made->reasons;
    s->point_count = made->count;
    s->in_order = made->elements == NORMALS_OF_POINTS;
    *made = (computed_normals){.elements = made->elements};
}

norma_document_result norma_gltf_find_points(gltf_job *job, gltf_surface *s) {
    const norma_compute_summary *summary = job->policy.summary;
    computed_normals made = {.elements = norma_policy_elements(summary->shading),
        .with_reasons = 1,
        .crease_angle_rad = summary->crease_angle_rad};
    norma_document_result result = norma_document_fail_core(
        job->g->document, job->error, norma_policy_compute(&job->policy, &s->core, &made));
    int ok = 1;
    if (!result && made.elements == NORMALS_OF_FACES)
        ok = join_faces(s, made.normals, made.reasons);
    else if (!result)
        take_surface_points(s, &made);
    if (!result && made.elements == NORMALS_OF_POSITIONS) ok = take_surface_positions(s);
    for (size_t i = 0; !result && ok && i < s->point_count; ++i)
        norma_policy_point_up(s->normals + 3 * i);
    norma_computed_normals_free(&made);
    return ok ? result : norma_gltf_job_memory(job);
}

/* ---- The surfaces of a glTF as computing sees them, for those who only look. */

/* Integers that stand for numbers from -1 to 1; mixed ones were made floats already. */
static double surface_unit_of(const gltf *g, const gltf_mesh *mesh, norma_format format) {
    for (uint32_t i = mesh->first_primitive; i < mesh->first_primitive + mesh->primitive_count;
         ++i) {
        if (g->primitives[i].not_read) continue;
        const gltf_accessor *a = &g->accessors[g->primitives[i].base.position];
        if (!a->normalized || format == NORMA_FORMAT_FLOAT) return 1;
        return a->component == GLTF_BYTE    ? 1.0 / 127
               : a->component == GLTF_UBYTE ? 1.0 / 255
               : a->component == GLTF_SHORT ? 1.0 / 32767
                                            : 1.0 / 65535;
    }
    return 1;
}

static size_t find_surface_parts(const gltf *g, const gltf_surface *s, surface_part *parts) {
    const gltf_mesh *mesh = &g->meshes[s->mesh];
    size_t count = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; ++i) {
        if (g->primitives[mesh->first_primitive + i].not_read) continue;
        int repeated = 0;
        for (size_t k = 0; k < count && !repeated; ++k)
            repeated = parts[k].first_corner == s->corner_start[i] &&
                       g->primitives[parts[k].mesh].faces > 0;
        parts[count++] = (surface_part){mesh->first_primitive + i, s->position_start[i],
            repeated ? SIZE_MAX : s->corner_start[i]};
    }
    return count;
}

static norma_document_result visit_mesh(
    gltf_job *job, uint32_t mesh, visit_surface *visit, void *user) {
    gltf_surface surface;
    norma_document_result result = norma_gltf_gather(job, mesh, &surface);
    surface_part *parts = norma_io_allocate(job->g->meshes[mesh].primitive_count, sizeof *parts);
    if (!result && !parts) result = norma_document_fail_memory(job->g->document, job->error);
    if (!result) {
        document_surface seen = {.number = mesh, .mesh = &surface.core, .parts = parts};
        seen.unit = surface_unit_of(job->g, &job->g->meshes[mesh], surface.core.positions.format);
        seen.part_count = find_surface_parts(job->g, &surface, parts);
        if (seen.part_count) result = visit(user, &seen);
    }
    free(parts);
    norma_gltf_surface_free(&surface);
    return result;
}

norma_document_result norma_gltf_visit_surfaces(
    norma_document *document, visit_surface *visit, void *user, norma_document_error *error) {
    gltf_job job = {.g = norma_gltf_of(document), .error = error};
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t m = 0; !result && m < job.g->mesh_count; ++m)
        result = visit_mesh(&job, m, visit, user);
    return result;
}
