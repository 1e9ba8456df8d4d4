/* overflow_group.c: the lists of wide slots, filled in two passes: the first counts, the second
 * writes. */
#include "core/plan/plan.h"

/* Unions of fans may overlap; a mesh made up so that they hold very many times its corners is
 * refused. */
enum { MOST_MEMBERS_PER_CORNER = 16, MEMBERS_TO_SPARE = 1 << 20 };

typedef struct widening {
    norma_plan *plan;
    plan_slots *slots;
    const core_mesh *mesh;
    const uint8_t *chosen;
    uint32_t
        *new_corner; /* of each corner of the mesh its number among wide ones; UINT32_MAX: none */
    size_t slot_count, member_count, vertex_count;
} widening;

static void count_slot(void *context, const uint32_t *members, size_t member_count,
    const uint32_t *vertices, size_t vertex_count) {
    widening *w = context;
    (void)members;
    (void)vertices;
    w->slot_count++;
    w->member_count += member_count;
    w->vertex_count += vertex_count;
}

static void write_slot(void *context, const uint32_t *members, size_t member_count,
    const uint32_t *vertices, size_t vertex_count) {
    widening *w = context;
    plan_wide *wide = &w->plan->wide;
    for (size_t i = 0; i < member_count; i++)
        wide->members[w->member_count++] = w->new_corner[members[i]];
    for (size_t i = 0; i < vertex_count; i++) wide->vertices[w->vertex_count++] = vertices[i];
    wide->member_starts[++w->slot_count] = (uint32_t)w->member_count;
    if (wide->vertex_starts) wide->vertex_starts[w->slot_count] = (uint32_t)w->vertex_count;
}

static void for_each_slot(widening *w, plan_slot_receiver *receive) {
    w->slot_count = w->member_count = w->vertex_count = 0;
    for (size_t p = 0; p < w->mesh->positions.count; p++)
        if (w->chosen[p]) norma_core_plan_slots_at(w->slots, (uint32_t)p, receive, w);
}

/* ---- faces */

static int meets_chosen(const widening *w, size_t face) {
    for (size_t c = norma_core_face_begin(w->mesh, face); c < norma_core_face_end(w->mesh, face);
         c++)
        if (w->chosen[norma_core_welded_corner(w->mesh, c)]) return 1;
    return 0;
}

static void count_faces(const widening *w, plan_wide *wide) {
    for (size_t f = 0; f < w->mesh->face_count; f++) {
        if (!meets_chosen(w, f)) continue;
        wide->face_count++;
        wide->corner_count += norma_core_face_end(w->mesh, f) - norma_core_face_begin(w->mesh, f);
    }
}

static int keep_faces(const widening *w, plan_wide *wide) {
    const size_t faces = wide->face_count, corners = wide->corner_count;
    const int polygons = w->mesh->face_starts != NULL;
    wide->faces = norma_core_plan_keep(w->plan, faces, sizeof *wide->faces);
    wide->corners = norma_core_plan_keep(w->plan, corners, sizeof *wide->corners);
    wide->mesh_corners = norma_core_plan_keep(w->plan, corners, sizeof *wide->mesh_corners);
    if (polygons)
        wide->face_starts = norma_core_plan_keep(w->plan, faces + 1, sizeof *wide->face_starts);
    if (polygons)
        wide->corner_faces = norma_core_plan_keep(w->plan, corners, sizeof *wide->corner_faces);
    return wide->faces && wide->corners && wide->mesh_corners &&
           (!polygons || (wide->face_starts && wide->corner_faces));
}

static void write_faces(const widening *w, plan_wide *wide) {
    size_t faces = 0, corners = 0;
    for (size_t f = 0; f < w->mesh->face_count; f++) {
        if (!meets_chosen(w, f)) continue;
        if (wide->face_starts) wide->face_starts[faces] = (uint32_t)corners;
        for (size_t c = norma_core_face_begin(w->mesh, f); c < norma_core_face_end(w->mesh, f);
             c++) {
            if (wide->corner_faces) wide->corner_faces[corners] = (uint32_t)faces;
            wide->corners[corners] = norma_core_corner(w->mesh, c);
            wide->mesh_corners[corners] = (uint32_t)c;
            w->new_corner[c] = (uint32_t)corners++;
        }
        wide->faces[faces++] = (uint32_t)f;
    }
    if (wide->face_starts) wide->face_starts[faces] = (uint32_t)corners;
}

/* ---- lists, and their inverses */

static norma_result keep_lists(widening *w, plan_wide *wide) {
    if (w->member_count / MOST_MEMBERS_PER_CORNER > w->mesh->corner_count + MEMBERS_TO_SPARE)
        return NORMA_ERROR_MEMORY;
    if (w->member_count > UINT32_MAX - 1) return NORMA_ERROR_MEMORY;
    const int per_vertex = w->plan->of == NORMA_PER_VERTEX;
    wide->slot_count = w->slot_count;
    wide->member_starts =
        norma_core_plan_keep(w->plan, w->slot_count + 1, sizeof *wide->member_starts);
    wide->members = norma_core_plan_keep(w->plan, w->member_count, sizeof *wide->members);
    if (per_vertex)
        wide->vertex_starts =
            norma_core_plan_keep(w->plan, w->slot_count + 1, sizeof *wide->vertex_starts);
    if (per_vertex)
        wide->vertices = norma_core_plan_keep(w->plan, w->vertex_count, sizeof *wide->vertices);
    wide->slot_starts =
        norma_core_plan_keep(w->plan, wide->corner_count + 1, sizeof *wide->slot_starts);
    wide->slots = norma_core_plan_keep(w->plan, w->member_count, sizeof *wide->slots);
    wide->at_starts =
        norma_core_plan_keep(w->plan, w->plan->vertex_count + 1, sizeof *wide->at_starts);
    wide->at = norma_core_plan_keep(w->plan, wide->corner_count, sizeof *wide->at);
    if (!wide->member_starts || !wide->members ||
        (per_vertex && (!wide->vertex_starts || !wide->vertices)))
        return NORMA_ERROR_MEMORY;
    if (!wide->slot_starts || !wide->slots || !wide->at_starts || !wide->at)
        return NORMA_ERROR_MEMORY;
    wide->member_starts[0] = 0;
    if (per_vertex) wide->vertex_starts[0] = 0;
    return NORMA_OK;
}

/* Counts become ends; filling backwards turns them into starts. */
static void counts_to_ends(uint32_t *counts, size_t count) {
    uint32_t sum = 0;
    for (size_t i = 0; i < count; i++) counts[i] = sum += counts[i];
    counts[count] = sum;
}

static void list_corners_of_vertices(const norma_plan *plan, plan_wide *wide) {
    memset(wide->at_starts, 0, (plan->vertex_count + 1) * sizeof *wide->at_starts);
    for (size_t c = 0; c < wide->corner_count; c++) wide->at_starts[wide->corners[c]]++;
    counts_to_ends(wide->at_starts, plan->vertex_count);
    for (size_t c = wide->corner_count; c-- > 0;)
        wide->at[--wide->at_starts[wide->corners[c]]] = (uint32_t)c;
}

static void list_slots_of_corners(plan_wide *wide) {
    const uint32_t members = wide->member_starts[wide->slot_count];
    memset(wide->slot_starts, 0, (wide->corner_count + 1) * sizeof *wide->slot_starts);
    for (uint32_t i = 0; i < members; i++) wide->slot_starts[wide->members[i]]++;
    counts_to_ends(wide->slot_starts, wide->corner_count);
    for (size_t slot = wide->slot_count; slot-- > 0;)
        for (uint32_t i = wide->member_starts[slot]; i < wide->member_starts[slot + 1]; i++)
            wide->slots[--wide->slot_starts[wide->members[i]]] = (uint32_t)slot;
}

static norma_result keep_weld(norma_plan *plan, const core_mesh *mesh) {
    size_t shared = 0;
    for (size_t v = 0; v < plan->vertex_count && mesh->weld; v++) shared += mesh->weld[v] != v;
    if (!shared) return NORMA_OK;
    plan->weld = norma_core_plan_keep(plan, plan->vertex_count, sizeof *plan->weld);
    if (!plan->weld) return NORMA_ERROR_MEMORY;
    memcpy(plan->weld, mesh->weld, plan->vertex_count * sizeof *plan->weld);
    return NORMA_OK;
}

norma_result norma_core_plan_widen(norma_plan *plan, plan_slots *slots, const uint8_t *chosen) {
    const core_call *call = slots->surface->call;
    widening w = {.plan = plan, .slots = slots, .mesh = &slots->surface->mesh, .chosen = chosen};
    plan_wide *wide = &plan->wide;
    if (!memchr(chosen, 1, plan->vertex_count)) return NORMA_OK;
    count_faces(&w, wide);
    if (!wide->face_count) return NORMA_OK;
    w.new_corner = norma_core_allocate(call, w.mesh->corner_count, sizeof *w.new_corner);
    norma_result result =
        w.new_corner && keep_faces(&w, wide) ? keep_weld(plan, w.mesh) : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) {
        write_faces(&w, wide);
        for_each_slot(&w, count_slot);
        result = keep_lists(&w, wide);
    }
    if (result == NORMA_OK) {
        for_each_slot(&w, write_slot);
        list_corners_of_vertices(plan, wide);
        list_slots_of_corners(wide);
    }
    norma_core_release(call, w.new_corner, w.mesh->corner_count, sizeof *w.new_corner);
    return result;
}
