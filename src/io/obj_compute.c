/* obj_compute.c: new normals for the corners that need one; of the old ones stay those that something still names. Equal normals are one, numbered as corners
 * first use them, after the old ones. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "obj.h"

#define PI 3.14159265358979323846

typedef struct computation {
    norma_document        *document;
    obj_state             *state;
    norma_compute_summary *summary;
    norma_document_error  *error;
    norma_only             only;
    norma_mesh             mesh;
    norma_options          core;
    norma_shading          shading;
    double                 crease;
    norma_edges            edges;
    uint8_t               *wanted;         /* of each corner; NULL: all */
    float                 *computed;       /* of each corner, position or face, as the shading has it; zero where the mesh has none at all */
    uint8_t               *reasons;        /* in step with computed */
    size_t                 element_count;
} computation;

/* ---- which corners */

/* What N101 to N103 name: not finite, no length, no unit length. */
static int is_broken(const float *n)
{
    double length = sqrt((double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] + (double)n[2] * (double)n[2]);
    return !(fabs(length - 1) <= 5e-4);
}

/* A face without normals: none of its corners names one that is there. */
static int lacks_normals(const obj_state *state, size_t face)
{
    for (size_t c = state->face_starts[face]; c < state->face_starts[face + 1]; ++c)
        if (state->corner_normals[c] < OBJ_BAD_NORMAL)
            return 0;
    return 1;
}

/* A corner that names a normal which is not there always gets one: left alone, it would come to name one of the new ones. */
static int is_wanted(const computation *c, size_t corner)
{
    uint32_t normal = c->state->corner_normals[corner];
    if (normal == OBJ_BAD_NORMAL)
        return 1;
    if (c->only == NORMA_ONLY_MISSING)
        return 0;
    return normal == OBJ_NO_NORMAL || is_broken(c->state->normals + 3 * (size_t)normal);
}

/* 0: memory is out. */
static int choose_corners(computation *c, size_t *count)
{
    const obj_state *state = c->state;
    *count = state->corner_count;
    if (c->only == NORMA_ONLY_ALL)
        return 1;
    c->wanted = norma_io_allocate(state->corner_count, 1);
    if (!c->wanted)
        return 0;
    *count = 0;
    for (size_t face = 0; face < state->face_count; ++face) {
        int whole = lacks_normals(state, face);
        for (size_t corner = state->face_starts[face]; corner < state->face_starts[face + 1]; ++corner) {
            c->wanted[corner] = (uint8_t)(whole || is_wanted(c, corner));
            *count += c->wanted[corner];
        }
    }
    return 1;
}

/* ---- computing */

static norma_result choose_shading(computation *c, const norma_compute_options *options)
{
    int by_groups = options->groups == NORMA_GROUPS_AUTO && c->state->has_groups;
    c->shading = options->shading;
    c->crease = options->shading == NORMA_SHADING_CREASE ? options->crease_angle_rad : by_groups ? PI : PI / 3;
    if (c->shading == NORMA_SHADING_DEFAULT)
        c->shading = NORMA_SHADING_CREASE;
    by_groups &= c->shading == NORMA_SHADING_CREASE;
    c->summary->shading = c->shading;
    c->summary->crease_angle_rad = c->shading == NORMA_SHADING_CREASE ? c->crease : 0;
    c->summary->by_groups = by_groups;
    c->mesh = norma_obj_mesh(c->state);
    if (!by_groups)
        return NORMA_OK;
    norma_result result = norma_obj_groups(c->state, &c->core);
    c->mesh.smoothing_groups = c->state->group_masks;
    c->mesh.hard_edges = c->state->hard_edges;
    return result;
}

static norma_result compute_elements(computation *c)
{
    const obj_state *state = c->state;
    norma_report *report = &c->summary->report;
    size_t count = c->shading == NORMA_SHADING_SMOOTH ? state->position_count : c->shading == NORMA_SHADING_FLAT ? state->face_count : state->corner_count;
    if (count > SIZE_MAX / (3 * sizeof(float)))
        return NORMA_ERROR_MEMORY;
    c->element_count = count;
    c->computed = malloc(3 * count * sizeof(float));
    c->reasons = norma_io_allocate(count, 1);
    if (!c->computed || !c->reasons)
        return NORMA_ERROR_MEMORY;
    c->core.reasons = c->reasons;
    if (c->shading == NORMA_SHADING_SMOOTH)
        return norma_vertex_normals(&c->mesh, &c->core, c->computed, count, report);
    if (c->shading == NORMA_SHADING_FLAT)
        return norma_face_normals(&c->mesh, &c->core, c->computed, count, report);
    c->core.edges = &c->edges;
    norma_result result = norma_corner_normals(&c->mesh, (float)c->crease, &c->core, c->computed, count, report);
    c->summary->edges_counted = 1;
    c->summary->hard_edges = c->edges.hard;
    return result;
}

/* ---- numbering */

typedef struct normal_table {
    float    *normals;         /* three each */
    size_t    count, room;
    uint64_t *slots;           /* a normal's number + 1 below the upper half of its hash, so that others are told apart without a look at them; 0: free */
    size_t    mask;
} normal_table;

static uint64_t hash_normal(const float *n)
{
    uint32_t bits[3];
    memcpy(bits, n, sizeof bits);
    uint64_t hash = (bits[0] | (uint64_t)bits[1] << 32) * UINT64_C(0x9e3779b97f4a7c15);
    hash = (hash ^ hash >> 29 ^ bits[2]) * UINT64_C(0xbf58476d1ce4e5b9);
    return hash ^ hash >> 32;
}

static uint64_t upper_half(uint64_t hash)
{
    return hash & ~(uint64_t)UINT32_MAX;
}

static int rehash(normal_table *table, size_t size)
{
    uint64_t *slots = norma_io_allocate(size, sizeof *slots);
    if (!slots)
        return 0;
    free(table->slots);
    table->slots = slots;
    table->mask = size - 1;
    for (size_t i = 0; i < table->count; ++i) {
        uint64_t hash = hash_normal(table->normals + 3 * i);
        size_t slot = (size_t)hash & table->mask;
        while (slots[slot])
            slot = (slot + 1) & table->mask;
        slots[slot] = upper_half(hash) | (i + 1);
    }
    return 1;
}

static int is_number(const normal_table *table, uint32_t number, const float *n)
{
    return number < table->count && memcmp(table->normals + 3 * (size_t)number, n, 3 * sizeof(float)) == 0;
}

/* The number of n among the table's normals; UINT32_MAX: memory is out. */
static uint32_t find_or_add(normal_table *table, const float *n)
{
    if (2 * table->count >= table->mask && !rehash(table, table->mask ? 2 * (table->mask + 1) : 1024))
        return UINT32_MAX;
    uint64_t hash = hash_normal(n);
    size_t slot = (size_t)hash & table->mask;
    for (; table->slots[slot]; slot = (slot + 1) & table->mask)
        if (upper_half(table->slots[slot]) == upper_half(hash) && is_number(table, (uint32_t)table->slots[slot] - 1, n))
            return (uint32_t)table->slots[slot] - 1;
    void *grown = norma_io_grow(table->normals, &table->room, table->count + 1, 3 * sizeof(float));
    if (!grown)
        return UINT32_MAX;
    table->normals = grown;
    memcpy(table->normals + 3 * table->count, n, 3 * sizeof(float));
    table->slots[slot] = upper_half(hash) | ++table->count;
    return (uint32_t)table->count - 1;
}

/* Of the old normals those that stay, given their new numbers; the others UINT32_MAX. With --only, lines that nothing named stay too: they are no business
 * of ours. */
static size_t number_old(const computation *c, uint32_t *numbers)
{
    const obj_state *state = c->state;
    size_t kept = 0;
    memset(numbers, c->wanted ? 1 : 0, state->normal_count * sizeof *numbers);
    for (size_t corner = 0; c->wanted && corner < state->corner_count; ++corner)
        if (c->wanted[corner] && state->corner_normals[corner] < OBJ_BAD_NORMAL)
            numbers[state->corner_normals[corner]] = 0;
    for (size_t corner = 0; c->wanted && corner < state->corner_count; ++corner)
        if (!c->wanted[corner] && state->corner_normals[corner] < OBJ_BAD_NORMAL)
            numbers[state->corner_normals[corner]] = 1;
    for (size_t i = 0; i < state->other_count; ++i)
        if (state->other_normals[i] < OBJ_BAD_NORMAL)
            numbers[state->other_normals[i]] = 1;
    for (size_t i = 0; i < state->normal_count; ++i)
        numbers[i] = numbers[i] ? (uint32_t)kept++ : UINT32_MAX;
    return kept;
}

/* The normal of an element as it is written: what no element of the mesh has is up; zero has no sign. */
static void final_normal(const float *computed, float n[3])
{
    for (int i = 0; i < 3; ++i)
        n[i] = computed[i] + 0.0f;
    if (n[0] == 0 && n[1] == 0 && n[2] == 0)
        n[2] = 1;
}

/* The number of a corner's normal. Most corners have that of the one before, or of the last one at their position: asking there first spares the table. */
static uint32_t number_of(normal_table *table, const float *n, uint32_t before, uint32_t *at_position)
{
    if (is_number(table, before, n))
        return before;
    if (!is_number(table, *at_position, n))
        *at_position = find_or_add(table, n);
    return *at_position;
}

/* Gives each wanted corner its number in the table, from base on, and counts the elements that had no normal of their own. recent: a number for each
 * position. */
static int number_new(computation *c, normal_table *table, const uint32_t *old_numbers, size_t base, uint32_t *recent, uint32_t *corner_normals)
{
    const obj_state *state = c->state;
    uint32_t number = UINT32_MAX;
    for (size_t face = 0; face < state->face_count; ++face)
        for (size_t corner = state->face_starts[face]; corner < state->face_starts[face + 1]; ++corner) {
            uint32_t old = state->corner_normals[corner];
            if (c->wanted && !c->wanted[corner]) {
                corner_normals[corner] = old == OBJ_NO_NORMAL ? old : old_numbers[old];
                continue;
            }
            size_t element = c->shading == NORMA_SHADING_SMOOTH ? state->corners[corner] : c->shading == NORMA_SHADING_FLAT ? face : corner;
            float n[3];
            final_normal(c->computed + 3 * element, n);
            number = number_of(table, n, number, &recent[state->corners[corner]]);
            if (number == UINT32_MAX || number + base >= OBJ_MOST)
                return 0;
            corner_normals[corner] = (uint32_t)(number + base);
            c->summary->filled += c->reasons[element] != NORMA_REASON_NONE;
            c->reasons[element] = NORMA_REASON_NONE;
        }
    return 1;
}

/* Whether every corner that gets a normal has these very numbers already (the sign of a zero aside): then the file stays as it is. */
static int says_so_already(const computation *c, const normal_table *table, size_t base, const uint32_t *corner_normals)
{
    const obj_state *state = c->state;
    for (size_t corner = 0; corner < state->corner_count; ++corner) {
        if (c->wanted && !c->wanted[corner])
            continue;
        const uint32_t old = state->corner_normals[corner];
        const float *now = table->normals + 3 * (corner_normals[corner] - base);
        if (old >= OBJ_BAD_NORMAL)
            return 0;
        for (size_t i = 0; i < 3; ++i)
            if (state->normals[3 * (size_t)old + i] != now[i])
                return 0;
    }
    return 1;
}

/* Puts kept and new normals in place of the old ones. */
static int replace_normals(obj_state *state, const normal_table *table, const uint32_t *old_numbers, size_t kept)
{
    size_t count = kept + table->count;
    float *normals = norma_io_allocate(count, 3 * sizeof *normals);
    size_t *offsets = norma_io_allocate(count, sizeof *offsets);
    if (!normals || !offsets) {
        free(normals);
        free(offsets);
        return 0;
    }
    for (size_t i = 0; i < state->normal_count; ++i)
        if (old_numbers[i] != UINT32_MAX) {
            memcpy(normals + 3 * (size_t)old_numbers[i], state->normals + 3 * i, 3 * sizeof *normals);
            offsets[old_numbers[i]] = state->normal_offsets[i];
        }
    if (table->count)
        memcpy(normals + 3 * kept, table->normals, 3 * table->count * sizeof *normals);
    for (size_t i = kept; i < count; ++i)
        offsets[i] = SIZE_MAX;
    for (size_t i = 0; i < state->other_count; ++i)
        if (state->other_normals[i] < OBJ_BAD_NORMAL)
            state->other_normals[i] = old_numbers[state->other_normals[i]];
    free(state->normals);
    free(state->normal_offsets);
    state->normals = normals;
    state->normal_offsets = offsets;
    state->normal_count = count;
    return 1;
}

static norma_document_result store(computation *c)
{
    obj_state *state = c->state;
    normal_table table = { 0 };
    uint32_t *old_numbers = norma_io_allocate(state->normal_count, sizeof *old_numbers);
    uint32_t *corner_normals = norma_io_allocate(state->corner_count, sizeof *corner_normals);
    uint32_t *recent = norma_io_allocate(state->position_count, sizeof *recent);
    size_t kept = old_numbers ? number_old(c, old_numbers) : 0;
    int stored = old_numbers && corner_normals && recent && number_new(c, &table, old_numbers, kept, recent, corner_normals);
    int idle = stored && says_so_already(c, &table, kept, corner_normals);
    if (stored && !idle)
        stored = replace_normals(state, &table, old_numbers, kept);
    free(old_numbers);
    free(recent);
    free(table.normals);
    free(table.slots);
    if (!stored || idle) {
        free(corner_normals);
        return stored ? NORMA_DOCUMENT_OK : norma_document_fail_memory(c->document, c->error);
    }
    free(state->corner_normals);
    state->corner_normals = corner_normals;
    state->has_normals = 1;
    state->bad_normal_count = 0;
    state->normals_replaced = 1;
    c->summary->changed = 1;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result run(computation *c, const norma_compute_options *options)
{
    size_t wanted;
    if (!choose_corners(c, &wanted))
        return norma_document_fail_memory(c->document, c->error);
    norma_result result = choose_shading(c, options);
    if (!result && wanted)
        result = compute_elements(c);
    if (result)
        return norma_document_fail_core(c->document, c->error, result);
    return wanted ? store(c) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_obj_compute(norma_document *document, const norma_compute_options *options, norma_compute_summary *summary, norma_document_error *error)
{
    obj_state *state = document->state;
    computation c = { .document = document, .state = state, .summary = summary, .error = error, .only = options->only };
    norma_count *counts[] = { &summary->report.degenerate_faces, &summary->report.non_finite, &summary->report.unreferenced,
                              &summary->report.cancelled, &summary->report.non_manifold_edges, &summary->report.winding_conflicts };
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i)
        counts[i]->first = SIZE_MAX;
    summary->faces = state->face_count;
    summary->vertices_before = summary->vertices_after = state->position_count;
    norma_options_of_compute(options, &c.core);
    norma_document_result result = run(&c, options);
    free(c.wanted);
    free(c.computed);
    free(c.reasons);
    return result;
}
