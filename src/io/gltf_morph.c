/* gltf_morph.c: normal deltas of morph targets: the morphed shape's normals less the base's, over the positions and fans that the base shares, so that no seam opens.
 * What shares a sum in the base, the points at one position with one normal, is one vertex of a mesh that is then morphed; both normals come from that mesh, so that
 * where nothing moves the delta is exactly zero. */
#include "gltf_compute.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct morph {
    gltf_job           *job;
    const gltf_surface *s;
    float    *positions;                  /* of the surface's positions, decoded */
    uint32_t *group_of;                   /* for each point */
    uint32_t *first_of;                   /* for each group the position that it takes */
    uint32_t *corners;                    /* of groups */
    size_t    groups;
    float    *base, *normals, *moved;     /* of groups: normals of the base and of the target, positions in the target */
    uint8_t  *base_reasons, *reasons;
} morph;

static norma_document_result out_of_memory(const morph *m)
{
    return norma_document_fail_memory(m->job->g->document, m->job->error);
}

static void free_morph(morph *m)
{
    void *const blocks[] = {m->positions, m->group_of, m->first_of, m->corners, m->base, m->normals, m->moved, m->base_reasons, m->reasons};
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; ++i)
        free(blocks[i]);
}

/* ---- groups */

static void key_of(const morph *m, size_t point, uint32_t key[6])
{
    const float *position = m->positions + 3 * (size_t)m->s->sources[point];
    for (int k = 0; k < 3; ++k) {
        float number = position[k] + 0.0F; /* -0 becomes 0 */
        memcpy(&key[k], &number, sizeof number);
    }
    memcpy(key + 3, m->s->normals + 3 * point, 3 * sizeof(float));
}

static size_t hash_key(const uint32_t key[6])
{
    uint64_t hash = 0;
    for (int k = 0; k < 6; ++k) {
        hash = (hash ^ key[k]) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 29;
    }
    return (size_t)hash;
}

static int find_groups(morph *m)
{
    size_t size = 16, count = m->s->point_count;
    while (size / 2 < count)
        size *= 2;
    uint32_t *table = norma_io_allocate(size, sizeof *table), *lead = norma_io_allocate(count, sizeof *lead);
    for (size_t p = 0; table && lead && p < count; ++p) {
        uint32_t key[6], other[6];
        key_of(m, p, key);
        size_t at = hash_key(key) & (size - 1);
        for (; table[at]; at = (at + 1) & (size - 1)) {
            key_of(m, lead[table[at] - 1], other);
            if (memcmp(key, other, sizeof key) == 0 && m->job->options->weld != NORMA_WELD_NONE)
                break;
        }
        if (!table[at]) {
            lead[m->groups] = (uint32_t)p;
            m->first_of[m->groups] = m->s->sources[p];
            table[at] = (uint32_t)++m->groups;
        }
        m->group_of[p] = table[at] - 1;
    }
    int ok = table && lead;
    free(table);
    free(lead);
    return ok;
}

static norma_document_result decode_positions(morph *m)
{
    gltf *g = m->job->g;
    const gltf_mesh *mesh = &g->meshes[m->s->mesh];
    for (uint32_t i = 0; i < mesh->primitive_count; ++i) {
        gltf_array array;
        if (g->primitives[mesh->first_primitive + i].not_read)
            continue;
        norma_document_result result = norma_gltf_array(g, g->primitives[mesh->first_primitive + i].base.position, &array, m->job->error);
        for (size_t v = 0; !result && v < array.count; ++v)
            norma_gltf_floats(&array, v, m->positions + 3 * (m->s->position_start[i] + v));
        if (result)
            return result;
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result find_normals(morph *m, const float *positions, float *normals, uint8_t *reasons)
{
    norma_options options = m->job->core;
    options.weld = NORMA_WELD_NONE;
    options.reasons = reasons;
    options.edges = NULL;
    const norma_mesh mesh = {.positions = {.data = positions, .count = m->groups, .format = NORMA_FORMAT_FLOAT}, .corners = m->corners, .corner_count = m->s->core.corner_count};
    norma_result result = norma_vertex_normals(&mesh, &options, normals, m->groups, NULL);
    return result ? norma_document_fail_core(m->job->g->document, m->job->error, result) : NORMA_DOCUMENT_OK;
}

static void take_positions(const morph *m, const float *of_surface)
{
    for (size_t i = 0; i < m->groups; ++i)
        memcpy(m->moved + 3 * i, of_surface + 3 * (size_t)m->first_of[i], 3 * sizeof(float));
}

static norma_document_result begin(morph *m)
{
    const gltf_surface *s = m->s;
    m->positions = norma_io_allocate(s->core.positions.count, 3 * sizeof *m->positions);
    m->group_of = norma_io_allocate(s->point_count, sizeof *m->group_of);
    m->first_of = norma_io_allocate(s->point_count, sizeof *m->first_of);
    m->corners = norma_io_allocate(s->core.corner_count, sizeof *m->corners);
    if (!m->positions || !m->group_of || !m->first_of || !m->corners)
        return out_of_memory(m);
    norma_document_result result = decode_positions(m);
    if (result)
        return result;
    if (!find_groups(m))
        return out_of_memory(m);
    for (size_t c = 0; c < s->core.corner_count; ++c)
        m->corners[c] = m->group_of[norma_gltf_points(s)[c]];
    m->base = norma_io_allocate(m->groups, 3 * sizeof *m->base);
    m->normals = norma_io_allocate(m->groups, 3 * sizeof *m->normals);
    m->moved = norma_io_allocate(m->groups, 3 * sizeof *m->moved);
    m->base_reasons = norma_io_allocate(m->groups, 1);
    m->reasons = norma_io_allocate(m->groups, 1);
    if (!m->base || !m->normals || !m->moved || !m->base_reasons || !m->reasons)
        return out_of_memory(m);
    take_positions(m, m->positions);
    return find_normals(m, m->moved, m->base, m->base_reasons);
}

/* ---- one target */

static int wants(const gltf_job *job, uint32_t primitive, uint32_t target)
{
    const gltf_primitive *p = &job->g->primitives[primitive];
    uint32_t set = job->set_of[primitive];
    if (set == GLTF_NONE || !job->sets[set].wanted || target >= p->target_count)
        return 0;
    const gltf_attributes *attributes = &job->g->targets[p->first_target + target];
    if (job->options->only == NORMA_ONLY_MISSING && p->base.normal != GLTF_NONE && attributes->normal != GLTF_NONE)
        return 0;
    return attributes->normal != GLTF_NONE || (job->options->morphs && attributes->position != GLTF_NONE);
}

static norma_document_result add_displacements(morph *m, uint32_t target, float *positions)
{
    gltf *g = m->job->g;
    const gltf_mesh *mesh = &g->meshes[m->s->mesh];
    memcpy(positions, m->positions, m->s->core.positions.count * 3 * sizeof *positions);
    for (uint32_t i = 0; i < mesh->primitive_count; ++i) {
        const gltf_primitive *p = &g->primitives[mesh->first_primitive + i];
        uint32_t accessor = p->not_read || target >= p->target_count ? GLTF_NONE : g->targets[p->first_target + target].position;
        gltf_array array;
        if (accessor == GLTF_NONE)
            continue;
        norma_document_result result = norma_gltf_array(g, accessor, &array, m->job->error);
        if (result)
            return result;
        if (array.width != 3)
            return norma_gltf_malformed(g, m->job->error, g->accessors[accessor].token, "displacements of three numbers");
        for (size_t v = 0; v < array.count; ++v) {
            float delta[3];
            size_t at = 3 * (m->s->position_start[i] + v);
            norma_gltf_floats(&array, v, delta);
            for (size_t k = 0; k < 3; ++k)
                positions[at + k] = m->positions[at + k] + delta[k];
        }
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result store(const morph *m, gltf_set *set, uint32_t target)
{
    size_t count = set->vertices + set->added_count;
    if (!set->deltas && !(set->deltas = norma_io_allocate(m->job->g->primitives[set->lead].target_count, sizeof *set->deltas)))
        return out_of_memory(m);
    if (set->deltas[target])
        return NORMA_DOCUMENT_OK;
    float *deltas = set->deltas[target] = norma_io_allocate(count, 3 * sizeof *deltas);
    if (!deltas)
        return out_of_memory(m);
    for (size_t v = 0; v < count; ++v) {
        if (set->point_of[v] == GLTF_NONE)
            continue;
        size_t group = m->group_of[set->point_of[v]];
        for (size_t k = 0; k < 3 && !m->reasons[group] && !m->base_reasons[group]; ++k)
            deltas[3 * v + k] = m->normals[3 * group + k] - m->base[3 * group + k];
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result morph_target(morph *m, uint32_t target, float *positions)
{
    const gltf_mesh *mesh = &m->job->g->meshes[m->s->mesh];
    int wanted = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; ++i)
        wanted |= wants(m->job, mesh->first_primitive + i, target);
    if (!wanted)
        return NORMA_DOCUMENT_OK;
    norma_document_result result = m->groups ? NORMA_DOCUMENT_OK : begin(m);
    if (!result)
        result = add_displacements(m, target, positions);
    if (!result) {
        take_positions(m, positions);
        result = find_normals(m, m->moved, m->normals, m->reasons);
    }
    for (uint32_t i = 0; !result && i < mesh->primitive_count; ++i)
        if (wants(m->job, mesh->first_primitive + i, target))
            result = store(m, &m->job->sets[m->job->set_of[mesh->first_primitive + i]], target);
    return result;
}

norma_document_result norma_gltf_morph(gltf_job *job, const gltf_surface *surface)
{
    morph m = {.job = job, .s = surface};
    const gltf_mesh *mesh = &job->g->meshes[surface->mesh];
    uint32_t targets = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; ++i)
        if (job->g->primitives[mesh->first_primitive + i].target_count > targets)
            targets = job->g->primitives[mesh->first_primitive + i].target_count;
    if (targets == 0)
        return NORMA_DOCUMENT_OK;
    float *positions = norma_io_allocate(surface->core.positions.count, 3 * sizeof *positions);
    norma_document_result result = positions ? NORMA_DOCUMENT_OK : out_of_memory(&m);
    for (uint32_t t = 0; !result && t < targets; ++t)
        result = morph_target(&m, t, positions);
    free(positions);
    free_morph(&m);
    return result;
}
