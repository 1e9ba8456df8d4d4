/* overflow_group_update.c: sums of wide slots. Each streams through the faces that vote in it,
 * eight triangles at a time, and keeps nothing but its sum, so that it needs no memory however many
 * there are. */
#include "core/plan/plan.h"
#include "core/corner/vertex_star.h"
#include <math.h>

enum { CACHED_FACES = 16, SLOTS_IN_BLOCK = 1 << 16, FACES_IN_BLOCK = 1 << 16 };

typedef struct cached_face {
    uint32_t number;
    core_face face;
} cached_face; /* number: UINT32_MAX where there is none */

typedef struct wide_work {
    const plan_work *work;
    plan_work *work_of_call; /* the same, for the calling thread */
    core_mesh mesh;          /* the wide faces, at the update's positions */
    size_t tasks, first_slot, slot_count;
    const uint64_t *touched; /* NULL: all slots from first_slot on; else a bit of each */
    core_tally tallies[PLAN_MOST_TASKS];
} wide_work;

/* ---- votes, in the order of members, eight at a time */

typedef struct votes {
    double normal[CORE_LANES][4], weight[CORE_LANES]; /* the fourth: 1; a weight of -0 is no vote */
} votes;

static uint32_t face_of(const plan_wide *wide, uint32_t corner) {
    return wide->corner_faces ? wide->corner_faces[corner] : corner / 3;
}

static int serves(const plan_wide *wide, size_t slot, uint32_t vertex) {
    if (!wide->vertex_starts) return 1;
    uint32_t low = wide->vertex_starts[slot], high = wide->vertex_starts[slot + 1];
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (wide->vertices[middle] <= vertex)
            low = middle;
        else
            high = middle;
    }
    return wide->vertices[low] == vertex;
}

/* A face without a direction is counted where the normal of its first corner is written. */
static void count_degenerate(const wide_work *w, const core_face *face, uint32_t number,
    uint32_t corner, size_t slot, core_tally *tally) {
    const plan_wide *wide = &w->work->plan->wide;
    if (!tally || (face->flags & CORE_FACE_DIRECTED) || !(face->flags & CORE_FACE_FINITE) ||
        corner != norma_core_face_begin(&w->mesh, number))
        return;
    if (serves(wide, slot, wide->corners[corner]))
        norma_core_count_one(&tally->degenerate, wide->faces[number]);
}

static void take_face(const wide_work *w, const core_face *face, uint32_t number, uint32_t corner,
    double normal[4], double *weight) {
    const int voting =
        (face->flags & CORE_FACE_DIRECTED) && norma_core_is_kept(&w->mesh, number, corner);
    for (int k = 0; k < 3; k++) normal[k] = voting ? face->normal[k] : 0;
    normal[3] = 1;
    *weight = voting ? norma_core_corner_weight(
                           &w->mesh, w->work->call->options.weight, number, face, corner)
                     : -0.0;
}

/* Slots that follow each other meet the same large polygons. */
static const core_face *measured_polygon(const wide_work *w, uint32_t number, cached_face *cache) {
    cached_face *at = &cache[number % CACHED_FACES];
    if (at->number != number) {
        norma_core_face_geometry(&w->mesh, number, &at->face);
        at->number = number;
    }
    return &at->face;
}

static int load_lane(const core_mesh *mesh, uint32_t face, core_batch *batch, int lane) {
    double p[3][3];
    uint32_t welded[3];
    for (size_t k = 0; k < 3; k++) {
        const uint32_t at = norma_core_corner(mesh, 3 * (size_t)face + k);
        welded[k] = norma_core_welded(mesh, at);
        norma_core_position(mesh, at, p[k]);
    }
    for (int k = 0; k < 3; k++) {
        batch->u[k][lane] = p[1][k] - p[0][k];
        batch->v[k][lane] = p[2][k] - p[0][k];
        batch->a[k][lane] = p[2][k] - p[1][k];
    }
    return welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0];
}

static void collect_triangles(const wide_work *w, size_t slot, const uint32_t *members,
    size_t count, core_tally *tally, votes *out) {
    core_batch batch;
    int edged[CORE_LANES];
    for (size_t i = 0; i < CORE_LANES; i++)
        edged[i] = load_lane(&w->mesh, members[i < count ? i : 0] / 3, &batch, (int)i);
    w->work->call->measure(&batch, w->work->call->options.weight, CORE_ALL_CORNERS);
    for (size_t i = 0; i < count; i++) {
        if (edged[i] && batch.sure[i] != 0) {
            for (int k = 0; k < 3; k++) out->normal[i][k] = batch.normal[k][i];
            out->normal[i][3] = 1;
            out->weight[i] = batch.weight[members[i] % 3][i];
            continue;
        }
        core_face face;
        norma_core_face_geometry(&w->mesh, members[i] / 3, &face);
        count_degenerate(w, &face, members[i] / 3, members[i], slot, tally);
        take_face(w, &face, members[i] / 3, members[i], out->normal[i], &out->weight[i]);
    }
}

static void collect(const wide_work *w, size_t slot, const uint32_t *members, size_t count,
    cached_face *cache, core_tally *tally, votes *out) {
    const plan_wide *wide = &w->work->plan->wide;
    if (!wide->corner_faces) {
        collect_triangles(w, slot, members, count, tally, out);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        const uint32_t number = face_of(wide, members[i]);
        const core_face *face = measured_polygon(w, number, cache);
        count_degenerate(w, face, number, members[i], slot, tally);
        take_face(w, face, number, members[i], out->normal[i], &out->weight[i]);
    }
}

/* ---- one slot */

/* Over all members, or those that are corners of one vertex. tally: NULL where its faces are
 * counted already. */
static void sum_slot(const wide_work *w, size_t slot, uint32_t vertex, cached_face *cache,
    core_tally *tally, double sum[4]) {
    const plan_wide *wide = &w->work->plan->wide;
    const uint32_t end = wide->member_starts[slot + 1];
    votes v;
    sum[0] = sum[1] = sum[2] = 0;
    sum[3] = -0.0;
    for (uint32_t i = wide->member_starts[slot]; i < end; i += CORE_LANES) {
        const size_t count = end - i < CORE_LANES ? end - i : CORE_LANES;
        collect(w, slot, wide->members + i, count, cache, tally, &v);
        for (size_t j = 0; j < count; j++) {
            if (vertex != UINT32_MAX && wide->corners[wide->members[i + j]] != vertex) continue;
            for (int k = 0; k < 4; k++) sum[k] += v.weight[j] * v.normal[j][k];
        }
    }
}

typedef struct wide_cone {
    const wide_work *work;
    cached_face *cache;
    const uint32_t *members;
    uint32_t vertex;
} wide_cone;

static int cone_normal(const void *context, size_t index, double normal[3]) {
    const wide_cone *cone = context;
    const wide_work *w = cone->work;
    const plan_wide *wide = &w->work->plan->wide;
    const uint32_t corner = cone->members[index], number = face_of(wide, corner);
    core_face face;
    if (cone->vertex != UINT32_MAX && wide->corners[corner] != cone->vertex) return 0;
    if (wide->corner_faces)
        face = *measured_polygon(w, number, cone->cache);
    else
        norma_core_face_geometry(&w->mesh, number, &face);
    memcpy(normal, face.normal, sizeof face.normal);
    return (face.flags & CORE_FACE_DIRECTED) && norma_core_is_kept(&w->mesh, number, corner);
}

static int decide_slot(const wide_work *w, size_t slot, uint32_t vertex, cached_face *cache,
    core_tally *tally, float normal[3]) {
    const plan_wide *wide = &w->work->plan->wide;
    const wide_cone cone = {w, cache, wide->members + wide->member_starts[slot], vertex};
    double sum[4];
    sum_slot(w, slot, vertex, cache, tally, sum);
    if (w->work->call->options.weight != NORMA_WEIGHT_VISIBLE)
        return norma_core_plan_decide(sum, normal);
    return norma_core_plan_decide_cone(sum[3], cone_normal, &cone,
        wide->member_starts[slot + 1] - wide->member_starts[slot], normal);
}

static int is_finite(const wide_work *w, uint32_t vertex) {
    double p[3];
    norma_core_position(&w->mesh, vertex, p);
    return norma_core_finite(p);
}

static void write_corners(
    const wide_work *w, size_t slot, int reason, const float normal[3], core_tally *tally) {
    const plan_wide *wide = &w->work->plan->wide;
    for (uint32_t i = wide->member_starts[slot]; i < wide->member_starts[slot + 1]; i++) {
        const uint32_t corner = wide->members[i];
        norma_core_write_element(w->work->output, wide->mesh_corners[corner],
            is_finite(w, wide->corners[corner]) ? reason : NORMA_REASON_NON_FINITE, normal, tally);
    }
}

/* Where the slot's votes cancel, those of each vertex's own corners decide. */
static void write_vertices(const wide_work *w, size_t slot, int reason, const float normal[3],
    cached_face *cache, core_tally *tally) {
    const plan_wide *wide = &w->work->plan->wide;
    for (uint32_t i = wide->vertex_starts[slot]; i < wide->vertex_starts[slot + 1]; i++) {
        const uint32_t vertex = wide->vertices[i];
        float own[3] = {0, 0, 0};
        int own_reason = reason;
        if (!is_finite(w, vertex))
            own_reason = NORMA_REASON_NON_FINITE;
        else if (reason == NORMA_REASON_CANCELLED &&
                 decide_slot(w, slot, vertex, cache, NULL, own) == NORMA_REASON_NONE)
            own_reason = NORMA_REASON_NONE;
        norma_core_write_element(
            w->work->output, vertex, own_reason, reason == NORMA_REASON_NONE ? normal : own, tally);
    }
}

static void update_slot(const wide_work *w, size_t slot, cached_face *cache, core_tally *tally) {
    float normal[3] = {0, 0, 0};
    const int reason = decide_slot(w, slot, UINT32_MAX, cache, tally, normal);
    if (w->work->plan->of == NORMA_PER_CORNER)
        write_corners(w, slot, reason, normal, tally);
    else
        write_vertices(w, slot, reason, normal, cache, tally);
}

static void update_some(void *context, size_t task) {
    wide_work *w = context;
    const plan_range range = norma_core_plan_range(w->slot_count, w->tasks, task);
    cached_face cache[CACHED_FACES];
    for (int i = 0; i < CACHED_FACES; i++) cache[i].number = UINT32_MAX;
    for (size_t i = range.begin; i < range.end; i++)
        if (!w->touched || (w->touched[i / 64] >> (i % 64) & 1))
            update_slot(w, w->first_slot + i, cache, &w->tallies[task]);
}

static norma_result run(
    wide_work *w, size_t first_slot, size_t slot_count, const uint64_t *touched) {
    plan_work *work = w->work_of_call;
    w->first_slot = first_slot;
    w->slot_count = slot_count;
    w->touched = touched;
    w->tasks = slot_count < PLAN_MOST_TASKS ? slot_count : PLAN_MOST_TASKS;
    memset(w->tallies, 0, sizeof w->tallies);
    const norma_result result = norma_core_parallel(work->call, w->tasks, update_some, w);
    for (size_t i = 0; i < w->tasks; i++) norma_core_tally_add(work->tally, &w->tallies[i]);
    return result;
}

/* ---- what moved: faces and slots are marked in blocks that the stack has room for, each once
 * however many of its corners moved */

typedef struct slot_block {
    size_t first, count, touched_count;
    uint64_t touched[SLOTS_IN_BLOCK / 64];
} slot_block;

static void mark(uint64_t *bits, size_t i) { bits[i / 64] |= (uint64_t)1 << (i % 64); }

static size_t mark_faces(const wide_work *w, size_t first, size_t count, uint64_t *bits) {
    const plan_wide *wide = &w->work->plan->wide;
    size_t marked = 0;
    memset(bits, 0, FACES_IN_BLOCK / 8);
    for (size_t i = 0; i < w->work->moved_count; i++) {
        const uint32_t vertex = w->work->moved[i];
        for (uint32_t at = wide->at_starts[vertex]; at < wide->at_starts[vertex + 1]; at++) {
            const uint32_t face = face_of(wide, wide->at[at]);
            if (face < first || face - first >= count) continue;
            mark(bits, face - first);
            marked++;
        }
    }
    return marked;
}

static void mark_slots_of_face(const wide_work *w, size_t face, slot_block *block) {
    const plan_wide *wide = &w->work->plan->wide;
    for (size_t c = norma_core_face_begin(&w->mesh, face); c < norma_core_face_end(&w->mesh, face);
         c++)
        for (uint32_t i = wide->slot_starts[c]; i < wide->slot_starts[c + 1]; i++) {
            const uint32_t slot = wide->slots[i];
            if (slot < block->first || slot - block->first >= block->count) continue;
            mark(block->touched, slot - block->first);
            block->touched_count++;
        }
}

static void mark_slots(const wide_work *w, slot_block *block) {
    uint64_t bits[FACES_IN_BLOCK / 64];
    const size_t faces = w->mesh.face_count;
    memset(block->touched, 0, sizeof block->touched);
    block->touched_count = 0;
    for (size_t first = 0; first < faces; first += FACES_IN_BLOCK) {
        const size_t count = faces - first < FACES_IN_BLOCK ? faces - first : FACES_IN_BLOCK;
        if (!mark_faces(w, first, count, bits)) continue;
        for (size_t f = 0; f < count; f++)
            if (bits[f / 64] >> (f % 64) & 1) mark_slots_of_face(w, first + f, block);
    }
}

static norma_result update_moved(wide_work *w) {
    const size_t slots = w->work->plan->wide.slot_count;
    slot_block block;
    norma_result result = NORMA_OK;
    for (block.first = 0; block.first < slots && result == NORMA_OK;
         block.first += SLOTS_IN_BLOCK) {
        block.count = slots - block.first < SLOTS_IN_BLOCK ? slots - block.first : SLOTS_IN_BLOCK;
        mark_slots(w, &block);
        if (block.touched_count) result = run(w, block.first, block.count, block.touched);
    }
    return result;
}

norma_result norma_core_plan_update_wide(plan_work *work) {
    const plan_wide *wide = &work->plan->wide;
    wide_work w = {.work = work, .work_of_call = work, .mesh = work->mesh};
    if (!wide->slot_count) return NORMA_OK;
    w.mesh.corners = wide->corners;
    w.mesh.corner_count = wide->corner_count;
    w.mesh.corner_size = sizeof *wide->corners;
    w.mesh.face_starts = wide->face_starts;
    w.mesh.face_count = wide->face_count;
    w.mesh.weld = work->plan->weld;
    return work->moved ? update_moved(&w) : run(&w, 0, wide->slot_count, NULL);
}

void norma_core_plan_wide_vertices(const norma_plan *plan, uint32_t *vertices) {
    const plan_wide *wide = &plan->wide;
    for (size_t c = 0; c < wide->corner_count; c++)
        vertices[wide->mesh_corners[c]] = wide->corners[c];
}
