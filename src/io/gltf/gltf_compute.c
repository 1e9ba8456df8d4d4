/* gltf_compute.c: normals for an asset, and the differences of its morph targets. */
#include "core/call/table.h"
#include "io/gltf/gltf.h"
#include <stdlib.h>
#include <string.h>

/* ---- The triangles of a mesh as one surface for the core, and the points that the core
 * makes of them. */

static void gltf_surface_free(gltf_surface *s) {
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

static uint64_t hash_surface_positions(const gltf *g, const gltf_primitive *p) {
    uint64_t hash = p->base.position;
    for (uint32_t t = 0; t < p->target_count; ++t)
        hash = (hash ^ hash >> 29 ^ g->targets[p->first_target + t].position) * 0x9E3779B97F4A7C15u;
    return hash ^ hash >> 32;
}

/* A primitive of a mesh, looked for by its positions and, where corners is nonzero, its corners. */
typedef struct wanted_primitive {
    const gltf *g;
    const gltf_primitive *list, *like;
    int corners;
} wanted_primitive;

static int is_wanted_primitive(const void *context, uint32_t number) {
    const wanted_primitive *w = context;
    const gltf_primitive *other = &w->list[number];
    return same_positions(w->g, w->like, other) &&
           (!w->corners || (w->like->indices == other->indices && w->like->mode == other->mode));
}

/* Where each primitive's positions and corners begin; an exact repetition of a primitive (another
 * material over the same triangles) is taken once. 0: out of memory. */
static int lay_out_surface(const gltf *g, gltf_surface *s, size_t *positions, size_t *corners) {
    const gltf_mesh *mesh = &g->meshes[s->mesh];
    const gltf_primitive *list = g->primitives + mesh->first_primitive;
    const size_t size = norma_core_table_size(mesh->primitive_count);
    uint32_t *tables = norma_io_allocate(size, 2 * sizeof *tables);
    for (uint32_t i = 0; tables && i < mesh->primitive_count; ++i) {
        const gltf_primitive *p = &list[i];
        uint64_t hash = hash_surface_positions(g, p);
        s->corner_start[i] = s->position_start[i] = SIZE_MAX;
        for (int k = 0; !p->not_read && k < 2; ++k) {
            const wanted_primitive w = {g, list, p, k};
            size_t *starts = k ? s->corner_start : s->position_start,
                   *end = k ? corners : positions;
            uint32_t *first =
                norma_core_table_find(tables + (k ? size : 0), size, hash, is_wanted_primitive, &w);
            starts[i] = *first ? starts[*first - 1] : *end;
            if (!*first) *end += k ? 3 * p->faces : p->vertices;
            if (!*first) *first = i + 1;
            hash = (hash ^ ((uint64_t)p->indices << 8 | p->mode)) * 0xD6E8FEB86659FD93u;
            hash ^= hash >> 32;
        }
    }
    free(tables);
    return tables != NULL;
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

static norma_document_result gltf_gather(gltf_job *job, uint32_t mesh, gltf_surface *s) {
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

typedef struct corner_code {
    uint32_t position;
    float normal[3];
} corner_code;

static const unsigned char *corner_row(const void *context, size_t corner, size_t *length) {
    *length = sizeof(corner_code);
    return (const unsigned char *)((const corner_code *)context + corner);
}

/* A point for each position and face normal that meet. */
static int join_faces(gltf_surface *s, const float *faces, const uint8_t *reasons) {
    const size_t count = s->core.corner_count;
    const uint32_t *corners = s->core.corners;
    corner_code *codes = norma_io_block(count, sizeof *codes);
    s->points = norma_io_block(count, sizeof *s->points);
    s->sources = norma_io_block(count, sizeof *s->sources);
    s->normals = norma_io_block(count, 3 * sizeof *s->normals);
    s->reasons = norma_io_allocate(count, 1);
    int fine = codes && s->points && s->sources && s->normals && s->reasons;
    for (size_t c = 0; fine && c < count; ++c) {
        codes[c].position = corners[c];
        memcpy(codes[c].normal, faces + c / 3 * 3, sizeof codes[c].normal);
    }
    size_t points;
    fine = fine && norma_number_rows(corner_row, codes, count, s->points, &points);
    for (size_t c = 0; fine && c < count; ++c) {
        if (s->points[c] < s->point_count) continue;
        s->sources[s->point_count] = corners[c];
        memcpy(s->normals + 3 * s->point_count, codes[c].normal, sizeof codes[c].normal);
        s->reasons[s->point_count++] = reasons[c / 3];
    }
    free(codes);
    return fine;
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
    *made = (computed_normals){.elements = made->elements};
}

static norma_document_result gltf_find_points(gltf_job *job, gltf_surface *s) {
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
        return 1 / norma_gltf_largest_code(a->component);
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
    norma_document_result result = gltf_gather(job, mesh, &surface);
    surface_part *parts = norma_io_allocate(job->g->meshes[mesh].primitive_count, sizeof *parts);
    if (!result && !parts) result = norma_document_fail_memory(job->g->document, job->error);
    if (!result) {
        document_surface seen = {.number = mesh, .mesh = &surface.core, .parts = parts};
        seen.unit = surface_unit_of(job->g, &job->g->meshes[mesh], surface.core.positions.format);
        seen.part_count = find_surface_parts(job->g, &surface, parts);
        if (seen.part_count) result = visit(user, &seen);
    }
    free(parts);
    gltf_surface_free(&surface);
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

/* ---- Normal deltas of morph targets, by norma_morph_normals over the points of a
 * surface: those at one position with one normal share in the base, and so in every target, so that
 * no seam opens. Targets are looked at some at a time. */

enum { TARGETS_AT_A_TIME = 8 };

typedef struct morph {
    gltf_job *job;
    const gltf_surface *s;
    float *positions, *displaced; /* of the surface: decoded, and in one target */
    float *base, *moved;          /* of points: in the base, and in each of some targets */
    uint32_t *vertices;           /* norma_morph_normals' */
    float *sparse;
    float *deltas; /* of points, in one target */
    uint32_t targets[TARGETS_AT_A_TIME];
    size_t target_count;
} morph;

static void free_morph(morph *m) {
    void *const blocks[] = {
        m->positions, m->displaced, m->base, m->moved, m->vertices, m->sparse, m->deltas};
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; ++i) free(blocks[i]);
}

static norma_document_result decode_positions(morph *m) {
    gltf *g = m->job->g;
    const gltf_mesh *mesh = &g->meshes[m->s->mesh];
    for (uint32_t i = 0; i < mesh->primitive_count; ++i) {
        gltf_array array;
        if (g->primitives[mesh->first_primitive + i].not_read) continue;
        norma_document_result result = norma_gltf_array(
            g, g->primitives[mesh->first_primitive + i].base.position, &array, m->job->error);
        for (size_t v = 0; !result && v < array.count; ++v)
            norma_gltf_floats(&array, v, m->positions + 3 * (m->s->position_start[i] + v));
        if (result) return result;
    }
    return NORMA_DOCUMENT_OK;
}

static void take_morph_points(const morph *m, const float *of_surface, float *points) {
    for (size_t p = 0; p < m->s->point_count; ++p)
        memcpy(points + 3 * p, of_surface + 3 * (size_t)m->s->sources[p], 3 * sizeof(float));
}

static norma_document_result begin_morph(morph *m) {
    const size_t positions = m->s->core.positions.count, points = m->s->point_count;
    m->positions = norma_io_allocate(positions, 3 * sizeof *m->positions);
    m->displaced = norma_io_allocate(positions, 3 * sizeof *m->displaced);
    m->base = norma_io_allocate(points, 3 * sizeof *m->base);
    m->moved = norma_io_allocate(points, 3 * TARGETS_AT_A_TIME * sizeof *m->moved);
    m->vertices = norma_io_allocate(points, TARGETS_AT_A_TIME * sizeof *m->vertices);
    m->sparse = norma_io_allocate(points, 3 * TARGETS_AT_A_TIME * sizeof *m->sparse);
    m->deltas = norma_io_allocate(points, 3 * sizeof *m->deltas);
    if (!m->positions || !m->displaced || !m->base || !m->moved || !m->vertices || !m->sparse ||
        !m->deltas)
        return norma_gltf_job_memory(m->job);
    norma_document_result result = decode_positions(m);
    if (!result) take_morph_points(m, m->positions, m->base);
    return result;
}

/* ---- one target */

static int wants(const gltf_job *job, uint32_t primitive, uint32_t target) {
    const gltf_primitive *p = &job->g->primitives[primitive];
    if (!norma_gltf_wanted_set(job, primitive) || target >= p->target_count) return 0;
    const gltf_attributes *attributes = &job->g->targets[p->first_target + target];
    return norma_gltf_morphs_normals(job, attributes) &&
           (job->options->only != NORMA_ONLY_MISSING || p->base.normal == GLTF_NONE ||
               attributes->normal == GLTF_NONE);
}

static norma_document_result add_displacements(morph *m, uint32_t target, float *positions) {
    gltf *g = m->job->g;
    const gltf_mesh *mesh = &g->meshes[m->s->mesh];
    memcpy(positions, m->positions, m->s->core.positions.count * 3 * sizeof *positions);
    for (uint32_t i = 0; i < mesh->primitive_count; ++i) {
        const gltf_primitive *p = &g->primitives[mesh->first_primitive + i];
        uint32_t accessor = p->not_read || target >= p->target_count
                                ? GLTF_NONE
                                : g->targets[p->first_target + target].position;
        gltf_array array;
        if (accessor == GLTF_NONE) continue;
        norma_document_result result = norma_gltf_array(g, accessor, &array, m->job->error);
        if (result) return result;
        if (array.width != 3)
            return norma_gltf_malformed(
                g, m->job->error, g->accessors[accessor].token, "displacements of three numbers");
        for (size_t v = 0; v < array.count; ++v) {
            float delta[3];
            size_t at = 3 * (m->s->position_start[i] + v);
            norma_gltf_floats(&array, v, delta);
            for (size_t k = 0; k < 3; ++k) positions[at + k] = m->positions[at + k] + delta[k];
        }
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result store_deltas(const morph *m, gltf_set *set, uint32_t target) {
    size_t count = set->vertices + set->added_count;
    if (!set->deltas && !(set->deltas = norma_io_allocate(
                              m->job->g->primitives[set->lead].target_count, sizeof *set->deltas)))
        return norma_gltf_job_memory(m->job);
    if (set->deltas[target]) return NORMA_DOCUMENT_OK;
    float *deltas = set->deltas[target] = norma_io_allocate(count, 3 * sizeof *deltas);
    if (!deltas) return norma_gltf_job_memory(m->job);
    for (size_t v = 0; v < count; ++v)
        if (set->point_of[v] != GLTF_NONE)
            memcpy(deltas + 3 * v, m->deltas + 3 * (size_t)set->point_of[v], 3 * sizeof *deltas);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result store_target(const morph *m, size_t number, const size_t *starts) {
    const gltf_mesh *mesh = &m->job->g->meshes[m->s->mesh];
    norma_document_result result = NORMA_DOCUMENT_OK;
    memset(m->deltas, 0, m->s->point_count * 3 * sizeof *m->deltas);
    for (size_t i = starts[number]; i < starts[number + 1]; ++i)
        memcpy(m->deltas + 3 * (size_t)m->vertices[i], m->sparse + 3 * i, 3 * sizeof *m->deltas);
    for (uint32_t i = 0; !result && i < mesh->primitive_count; ++i)
        if (wants(m->job, mesh->first_primitive + i, m->targets[number]))
            result = store_deltas(
                m, &m->job->sets[m->job->set_of[mesh->first_primitive + i]], m->targets[number]);
    return result;
}

/* The targets gathered so far. */
static norma_document_result finish_targets(morph *m) {
    const gltf_surface *s = m->s;
    const size_t points = s->point_count;
    const norma_mesh base = {
        .positions = {.data = m->base, .count = points, .format = NORMA_FORMAT_FLOAT},
        .corners = norma_gltf_points(s),
        .corner_count = s->core.corner_count};
    const norma_vec3_view normals = {
        .data = s->normals, .count = points, .format = NORMA_FORMAT_FLOAT};
    norma_vec3_view targets[TARGETS_AT_A_TIME];
    size_t starts[TARGETS_AT_A_TIME + 1];
    norma_options options = m->job->policy.core;
    options.weld = m->job->options->weld == NORMA_WELD_NONE ? NORMA_WELD_NONE : NORMA_WELD_EXACT;
    for (size_t t = 0; t < m->target_count; ++t)
        targets[t] = (norma_vec3_view){
            .data = m->moved + 3 * points * t, .count = points, .format = NORMA_FORMAT_FLOAT};
    norma_result found = norma_morph_normals(&base, &normals, targets, m->target_count, 0, &options,
        starts, m->vertices, m->sparse, points * m->target_count);
    norma_document_result result =
        found ? norma_document_fail_core(m->job->g->document, m->job->error, found)
              : NORMA_DOCUMENT_OK;
    for (size_t t = 0; !result && t < m->target_count; ++t) result = store_target(m, t, starts);
    m->target_count = 0;
    return result;
}

static norma_document_result gather_target(morph *m, uint32_t target) {
    const gltf_mesh *mesh = &m->job->g->meshes[m->s->mesh];
    int wanted = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; ++i)
        wanted |= wants(m->job, mesh->first_primitive + i, target);
    if (!wanted) return NORMA_DOCUMENT_OK;
    norma_document_result result = m->positions ? NORMA_DOCUMENT_OK : begin_morph(m);
    if (!result) result = add_displacements(m, target, m->displaced);
    if (result) return result;
    take_morph_points(m, m->displaced, m->moved + 3 * m->s->point_count * m->target_count);
    m->targets[m->target_count++] = target;
    return m->target_count == TARGETS_AT_A_TIME ? finish_targets(m) : NORMA_DOCUMENT_OK;
}

static norma_document_result gltf_morph(gltf_job *job, const gltf_surface *surface) {
    morph m = {.job = job, .s = surface};
    const gltf_mesh *mesh = &job->g->meshes[surface->mesh];
    uint32_t targets = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; ++i)
        if (job->g->primitives[mesh->first_primitive + i].target_count > targets)
            targets = job->g->primitives[mesh->first_primitive + i].target_count;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t t = 0; !result && t < targets; ++t) result = gather_target(&m, t);
    if (!result && m.target_count) result = finish_targets(&m);
    free_morph(&m);
    return result;
}

/* ---- Normals for a glTF asset: mesh by mesh the surface, its points, the deltas of its
 * morph targets; then set by set what the accessors are to hold. */

static int is_mesh_wanted(const gltf_job *job, uint32_t mesh) {
    const gltf_mesh *m = &job->g->meshes[mesh];
    for (uint32_t i = m->first_primitive; i < m->first_primitive + m->primitive_count; ++i)
        if (norma_gltf_wanted_set(job, i)) return 1;
    return 0;
}

static norma_document_result compute_mesh(gltf_job *job, uint32_t mesh) {
    gltf_surface surface;
    norma_document_result result = gltf_gather(job, mesh, &surface);
    job->policy.surface = mesh;
    if (!result) result = gltf_find_points(job, &surface);
    job->policy.core.progress = NULL;
    if (!result) result = norma_gltf_take_points(job, &surface);
    if (!result) result = gltf_morph(job, &surface);
    gltf_surface_free(&surface);
    return result;
}

static norma_document_result compute_meshes(gltf_job *job) {
    const gltf *g = job->g;
    norma_document_result result = NORMA_DOCUMENT_OK;
    size_t wanted = 0;
    for (uint32_t m = 0; m < g->mesh_count; ++m) wanted += (size_t)is_mesh_wanted(job, m);
    job->progress_scale = wanted ? 1 / (double)wanted : 0;
    for (uint32_t m = 0; !result && m < g->mesh_count; ++m) {
        if (!is_mesh_wanted(job, m)) continue;
        job->policy.core.progress = job->options->progress ? norma_gltf_pass_on : NULL;
        job->policy.core.progress_user = job;
        result = compute_mesh(job, m);
        job->progress_base += job->progress_scale;
    }
    return result;
}

/* Between one step and the next, once the core has told that it is done. */
static norma_document_result look_for_cancel(const gltf_job *job) {
    const norma_compute_options *options = job->options;
    if (options->progress && options->progress(options->progress_user, 1))
        return norma_document_fail_core(job->g->document, job->error, NORMA_CANCELLED);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result put_all(gltf_job *job) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_policy_forget(&job->policy.summary->report);
    for (uint32_t s = 0; !result && s < job->set_count; ++s) {
        if (!job->sets[s].wanted) continue;
        result = look_for_cancel(job);
        if (!result) result = norma_gltf_fill_unreferenced(job, &job->sets[s]);
        if (!result) result = norma_gltf_put_set(job, s);
    }
    for (uint32_t i = 0; !result && i < job->g->primitive_count; ++i)
        if (norma_gltf_wanted_set(job, i)) result = norma_gltf_put_indices(job, i);
    if (!result) result = norma_gltf_account_tangents(job);
    return result ? result : look_for_cancel(job);
}

static void count_computed_vertices(const gltf_job *job) {
    norma_compute_summary *summary = job->policy.summary;
    for (uint32_t i = 0; i < job->g->primitive_count; ++i) {
        const gltf_primitive *p = &job->g->primitives[i];
        const gltf_set *set = norma_gltf_wanted_set(job, i);
        summary->faces += p->faces;
        summary->vertices_before += p->vertices;
        summary->vertices_after += p->vertices + (set ? set->added_count : 0);
    }
}

/* Where none of the surfaces can be read, there is nothing that could have been asked for. */
static norma_document_result check_any_surface(const gltf *g, norma_document_error *error) {
    const gltf_primitive *unread = NULL;
    for (uint32_t i = 0; i < g->primitive_count; ++i) {
        const gltf_primitive *p = &g->primitives[i];
        if (p->mode < GLTF_TRIANGLES || p->base.position == GLTF_NONE) continue;
        if (!p->not_read) return NORMA_DOCUMENT_OK;
        unread = unread ? unread : p;
    }
    return unread ? norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
                        unread->where, "no surface of the file can be read: %s", unread->not_read)
                  : NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    gltf_job job = {.g = g,
        .options = options,
        .error = error,
        .policy = norma_policy_begin(options, summary, NORMA_SHADING_CREASE, 0)};
    job.policy.core.progress = NULL;
    job.policy.shared = document->shared;
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_gltf_begin_change(g);
    if (!result) result = check_any_surface(g, error);
    if (!result) result = norma_gltf_find_vertex_sharing(&job);
    if (!result) result = compute_meshes(&job);
    if (!result) result = put_all(&job);
    if (!result) {
        count_computed_vertices(&job);
        result = norma_gltf_finish(g, error);
        summary->changed = g->changed;
    }
    norma_gltf_vertex_sharing_free(&job);
    return result;
}
