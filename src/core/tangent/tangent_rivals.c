/* tangent_rivals.c: whether those vertices are equal that were. Those that were are compared with
 * the one that stands for them; those that were not can have become so only if their texture
 * coordinates are equal, so that of most meshes nothing is left to compare. */
#include "core/tangent/tangent_plan.h"

enum { FEW = 8, KEYS_IN_TASK = 1 << 14 };

static int stands_for_itself(const norma_tangent_plan *plan, uint32_t key) {
    return !plan->weld || plan->weld[key] == key;
}

/* ---- the keys of each place */

typedef struct rival_sort {
    norma_tangent_plan *plan;
    core_corners_of_position keys; /* at each place */
} rival_sort;

static size_t count_at(const rival_sort *s, size_t place) {
    size_t count = 0;
    for (size_t i = s->keys.starts[place]; i < s->keys.starts[place + 1]; i++)
        count += (size_t)stands_for_itself(s->plan, s->keys.corners[i]);
    return count;
}

static void measure(const rival_sort *s) {
    tangent_rivals *r = &s->plan->rivals;
    for (size_t place = 0; place < s->plan->key_count; place++) {
        const size_t count = count_at(s, place);
        if (count > FEW)
            r->crowd_count += count;
        else if (count > 1)
            r->few_count += 1 + count;
    }
}

static void list(const rival_sort *s) {
    tangent_rivals *r = &s->plan->rivals;
    size_t few = 0, crowd = 0;
    for (size_t place = 0; place < s->plan->key_count; place++) {
        const size_t count = count_at(s, place);
        if (count < 2) continue;
        if (count <= FEW) r->few[few++] = (uint32_t)count;
        for (size_t i = s->keys.starts[place]; i < s->keys.starts[place + 1]; i++) {
            const uint32_t key = s->keys.corners[i];
            if (stands_for_itself(s->plan, key))
                *(count <= FEW ? &r->few[few++] : &r->crowd[crowd++]) = key;
        }
    }
}

norma_result norma_core_tangent_rivals_find(core_call *call, norma_tangent_plan *plan) {
    rival_sort s = {.plan = plan};
    const core_mesh keys = {.positions = {.count = plan->key_count},
        .corner_count = plan->key_count,
        .weld = plan->place};
    if (!plan->place) return NORMA_OK;
    const norma_result result = norma_core_corners_of_position_build(call, &keys, &s.keys);
    if (result != NORMA_OK) return result;
    measure(&s);
    tangent_rivals *r = &plan->rivals;
    r->few = norma_core_tangent_keep(plan, r->few_count, sizeof *r->few);
    r->crowd = norma_core_tangent_keep(plan, r->crowd_count, sizeof *r->crowd);
    if (r->few && r->crowd) list(&s);
    norma_core_corners_of_position_release(call, &s.keys);
    return r->few && r->crowd ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* ---- an update's vertices */

typedef struct weld_check {
    const norma_tangent_plan *plan;
    const tangent_vertex *vertices;
    atomic_int differs;
} weld_check;

static void check_task(void *context, size_t task) {
    weld_check *c = context;
    const size_t count = c->plan->key_count, begin = task * KEYS_IN_TASK,
                 end = count - begin < KEYS_IN_TASK ? count : begin + KEYS_IN_TASK;
    int equal = 1;
    for (size_t key = begin; key < end && equal; key++) {
        const uint32_t one = c->plan->weld[key];
        if (one != key) equal = norma_core_tangent_are_equal(&c->vertices[key], &c->vertices[one]);
    }
    if (!equal) atomic_store_explicit(&c->differs, 1, memory_order_relaxed);
}

static int few_are_apart(const norma_tangent_plan *plan, const tangent_vertex *vertices) {
    const tangent_rivals *r = &plan->rivals;
    for (size_t at = 0; at < r->few_count; at += 1 + r->few[at]) {
        const uint32_t count = r->few[at], *keys = &r->few[at + 1];
        for (uint32_t i = 1; i < count; i++)
            for (uint32_t j = 0; j < i; j++)
                if (norma_core_tangent_are_equal(&vertices[keys[i]], &vertices[keys[j]])) return 0;
    }
    return 1;
}

static norma_result look_at_crowd(
    const norma_tangent_plan *plan, const tangent_mesh *mesh, int *holds) {
    const size_t count = plan->rivals.crowd_count;
    size_t found = 0;
    tangent_vertex *vertices = norma_core_allocate(mesh->call, count, sizeof *vertices);
    uint32_t *weld = norma_core_allocate(mesh->call, count, sizeof *weld);
    norma_result result = vertices && weld ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < count && result == NORMA_OK; i++)
        vertices[i] = mesh->vertices[plan->rivals.crowd[i]];
    if (result == NORMA_OK)
        result = norma_core_tangent_weld_vertices(mesh->call, vertices, count, weld, &found);
    norma_core_release(mesh->call, vertices, count, sizeof *vertices);
    norma_core_release(mesh->call, weld, count, sizeof *weld);
    *holds = !found;
    return result;
}

norma_result norma_core_tangent_weld_holds(
    const norma_tangent_plan *plan, const tangent_mesh *mesh, int *holds) {
    weld_check c = {.plan = plan, .vertices = mesh->vertices};
    norma_result result = NORMA_OK;
    if (plan->weld)
        result = norma_core_parallel(mesh->call,
            plan->key_count / KEYS_IN_TASK + (plan->key_count % KEYS_IN_TASK != 0), check_task, &c);
    *holds = !atomic_load_explicit(&c.differs, memory_order_relaxed) &&
             few_are_apart(plan, mesh->vertices);
    if (result == NORMA_OK && *holds && plan->rivals.crowd_count)
        result = look_at_crowd(plan, mesh, holds);
    return result;
}
