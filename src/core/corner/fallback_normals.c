/* fallback_normals.c: the stars of the sources are made a second time rather than all normals kept,
 * since files where many corners lack one are rare. */
#include "core/corner/corner.h"
#include "core/mesh/mesh.h"
#include "core/call/call.h"

typedef struct corner_request {
    uint32_t position, corner, target;
} corner_request; /* the normal of this corner, at this position, goes to target */

typedef struct corner_filling {
    const core_prepared_mesh *prepared;
    const uint8_t *reasons, *wanted;
    corner_taker *take;
    void *context;
    corner_request *requests; /* room for count of them; found: how many have a source */
    size_t count, found;
} corner_filling;

static int is_wanting(const corner_filling *f, size_t corner) {
    return f->wanted ? f->wanted[corner] : f->reasons[corner] != NORMA_REASON_NONE;
}

static norma_result find_sources(corner_filling *f) {
    const core_mesh *mesh = &f->prepared->mesh;
    core_nearest nearest;
    norma_result result = norma_core_nearest_begin(f->prepared->call, mesh, &nearest);
    if (result) return result;
    for (size_t c = 0; c < mesh->corner_count; ++c)
        if (f->reasons[c] == NORMA_REASON_NONE)
            norma_core_nearest_add(&nearest, norma_core_corner(mesh, c), (uint32_t)c);
    result = norma_core_nearest_plant(&nearest, f->count);
    for (size_t c = 0; c < mesh->corner_count && !result; ++c) {
        if (!is_wanting(f, c)) continue;
        const uint32_t source = norma_core_nearest_find(&nearest, norma_core_corner(mesh, c));
        if (source == UINT32_MAX) break;
        f->requests[f->found++] =
            (corner_request){norma_core_welded_corner(mesh, source), source, (uint32_t)c};
    }
    norma_core_nearest_end(&nearest);
    return result;
}

static int request_less(const void *one, const void *other) {
    const corner_request *a = one, *b = other;
    if (a->position != b->position) return a->position < b->position;
    return a->target < b->target;
}

static const core_fan *fan_of_corner(const core_star *star, uint32_t corner) {
    size_t low = 0, high = star->count;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (star->corners[middle].corner <= corner)
            low = middle;
        else
            high = middle;
    }
    return &star->fans[star->fan_of[low]];
}

static norma_result fetch_normals(const corner_filling *f) {
    const core_prepared_mesh *prepared = f->prepared;
    corner_request *requests = f->requests;
    core_star star;
    const size_t most = prepared->corners_of.most;
    if (norma_core_star_allocate(prepared->call, &star, most)) return NORMA_ERROR_MEMORY;
    norma_core_sort(requests, f->found, sizeof *requests, request_less);
    for (size_t i = 0; i < f->found; ++i) {
        if (i == 0 || requests[i].position != requests[i - 1].position)
            norma_core_make_star(prepared, CORE_JOIN_FANS, requests[i].position, NULL, &star);
        f->take(f->context, requests[i].target, fan_of_corner(&star, requests[i].corner)->normal);
    }
    norma_core_star_release(prepared->call, &star, most);
    return NORMA_OK;
}

norma_result norma_core_fill_corners(const core_prepared_mesh *prepared, const uint8_t *reasons,
    const uint8_t *wanted, corner_taker *take, void *context) {
    const size_t corners = prepared->mesh.corner_count;
    const float zero[3] = {0, 0, 0};
    corner_filling f = {prepared, reasons, wanted, take, context, NULL, 0, 0};
    for (size_t c = 0; c < corners; ++c) f.count += is_wanting(&f, c) != 0;
    if (!f.count) return NORMA_OK;
    f.requests = norma_core_allocate(prepared->call, f.count, sizeof *f.requests);
    if (!f.requests) return NORMA_ERROR_MEMORY;
    norma_result result = find_sources(&f);
    if (!result && f.found) result = fetch_normals(&f);
    for (size_t c = 0; c < corners && !result && !f.found; ++c)
        if (is_wanting(&f, c)) take(context, (uint32_t)c, zero);
    norma_core_release(prepared->call, f.requests, f.count, sizeof *f.requests);
    return result;
}
