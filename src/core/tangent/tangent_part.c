/* tangent_part.c: the faces of a region as a mesh of their own, whose tangents are computed as
 * those of any mesh. Of the places that are wanted it has all faces, so that the tangents there
 * are those of the whole mesh. */
#include "core/call/sort.h"
#include "core/tangent/tangent_plan.h"

typedef struct tangent_part {
    const norma_tangent_plan *plan;
    const tangent_mesh *whole;
    tangent_mesh mesh;
    size_t face_count, corner_count;
    uint32_t *corners;     /* of the whole mesh */
    uint32_t *face_starts; /* NULL: triangles */
    uint32_t *keys;        /* of each corner */
    uint64_t *by_key;      /* keys of the whole mesh and corners, ascending */
    float (*tangents)[4];
    uint8_t *reasons;
} tangent_part;

static void list_corners(tangent_part *p, const tangent_region *region) {
    const core_mesh *mesh = &p->plan->mesh;
    uint32_t corner = 0;
    for (size_t f = 0, number = 0; number < p->face_count; f++) {
        if (!region->near[f]) continue;
        if (p->face_starts) p->face_starts[number] = corner;
        number++;
        for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); c++)
            p->corners[corner++] = (uint32_t)c;
    }
    if (p->face_starts) p->face_starts[p->face_count] = corner;
}

/* Keys get numbers of their own; one vertex stays one, even if it is not a number. */
static int read_keys(tangent_part *p) {
    uint32_t number = 0;
    for (size_t i = 0; i < p->corner_count; i++)
        p->by_key[i] =
            (uint64_t)norma_core_tangent_key(p->whole, p->corners[i]) << 32 | (uint32_t)i;
    norma_core_sort_numbers(p->by_key, p->corner_count);
    for (size_t i = 0; i < p->corner_count; i++) {
        const uint32_t key = (uint32_t)(p->by_key[i] >> 32);
        if (i && key != p->by_key[i - 1] >> 32) number++;
        p->keys[(uint32_t)p->by_key[i]] = number;
        if ((!i || key != p->by_key[i - 1] >> 32) &&
            !norma_core_tangent_read_key(p->whole, key, &p->mesh.vertices[number]))
            return 0;
    }
    p->mesh.key_count = p->mesh.mesh.positions.count = p->corner_count ? number + 1 : 0;
    return 1;
}

static norma_result compute(tangent_part *p) {
    const tangent_output output = {(unsigned char *)p->tangents, sizeof *p->tangents, p->reasons};
    core_tally tally = {0};
    tangent_mesh *m = &p->mesh;
    m->call = p->whole->call;
    m->by_position = 1;
    m->mesh = (core_mesh){.corners = p->keys,
        .corner_count = p->corner_count,
        .corner_size = 4,
        .face_starts = p->face_starts,
        .face_count = p->face_count};
    if (!read_keys(p)) return NORMA_ERROR_INDEX;
    const norma_result result = norma_core_tangent_weld(m);
    if (result != NORMA_OK) return result;
    return p->plan->mode == NORMA_TANGENTS_MIKK ? norma_core_mikk_tangents(m, &output, &tally)
                                                : norma_core_steady_tangents(m, &output, &tally);
}

static void write_wanted(const tangent_part *p, const tangent_region *region,
    const tangent_output *output, core_tally *tally) {
    for (size_t i = 0; i < p->corner_count; i++) {
        const uint32_t corner = p->corners[i];
        written_tangent out = {.reason = p->reasons[i]};
        if (!region->wanted[norma_core_tangent_place(p->plan, corner)]) continue;
        memcpy(out.numbers, p->tangents[i], sizeof out.numbers);
        norma_core_put_tangent(output, corner, &out, tally);
    }
}

static int open_part(tangent_part *p, const core_call *call) {
    const size_t count = p->corner_count;
    p->corners = norma_core_allocate(call, count, sizeof *p->corners);
    p->keys = norma_core_allocate(call, count, sizeof *p->keys);
    p->by_key = norma_core_allocate(call, count, sizeof *p->by_key);
    p->mesh.vertices = norma_core_allocate(call, count, sizeof *p->mesh.vertices);
    p->tangents = norma_core_allocate(call, count, sizeof *p->tangents);
    p->reasons = norma_core_allocate(call, count, 1);
    if (p->plan->mesh.face_starts)
        p->face_starts = norma_core_allocate(call, p->face_count + 1, sizeof *p->face_starts);
    return p->corners && p->keys && p->by_key && p->mesh.vertices && p->tangents && p->reasons &&
           (p->face_starts || !p->plan->mesh.face_starts);
}

static void close_part(tangent_part *p, const core_call *call) {
    const size_t count = p->corner_count;
    norma_core_release(call, p->mesh.own_weld, p->mesh.key_count, sizeof *p->mesh.own_weld);
    norma_core_release(call, p->corners, count, sizeof *p->corners);
    norma_core_release(call, p->keys, count, sizeof *p->keys);
    norma_core_release(call, p->by_key, count, sizeof *p->by_key);
    norma_core_release(call, p->mesh.vertices, count, sizeof *p->mesh.vertices);
    norma_core_release(call, p->tangents, count, sizeof *p->tangents);
    norma_core_release(call, p->reasons, count, 1);
    norma_core_release(call, p->face_starts, p->face_count + 1, sizeof *p->face_starts);
}

norma_result norma_core_tangent_update_part(const norma_tangent_plan *plan,
    const tangent_mesh *whole, const tangent_region *region, const tangent_output *output,
    core_tally *tally, int *is_awkward) {
    tangent_part p = {.plan = plan,
        .whole = whole,
        .mesh = {.is_awkward = is_awkward},
        .face_count = region->face_count,
        .corner_count = region->corner_count};
    norma_result result = NORMA_ERROR_MEMORY;
    *is_awkward = 0;
    if (!region->corner_count) return NORMA_OK;
    if (open_part(&p, whole->call)) {
        list_corners(&p, region);
        result = compute(&p);
    }
    if (result == NORMA_OK && !*is_awkward) write_wanted(&p, region, output, tally);
    close_part(&p, whole->call);
    return result;
}
