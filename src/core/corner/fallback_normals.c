/* fallback_normals.c: the stars of the sources are made a second time rather than all normals kept,
 * since files where many corners lack one are rare. */
#include "core/corner/corner.h"
#include "core/mesh/mesh.h"
#include "core/call/call.h"

norma_result norma_core_find_sources(const core_prepared_mesh *prepared, const uint8_t *reasons,
    const uint8_t *wanted, corner_request *requests, size_t count, size_t *found) {
    const core_mesh *mesh = &prepared->mesh;
    core_nearest nearest;
    norma_result result = norma_core_nearest_begin(prepared->call, mesh, &nearest);
    *found = 0;
    if (result != NORMA_OK) return result;
    for (size_t c = 0; c < mesh->corner_count; c++)
        if (reasons[c] == NORMA_REASON_NONE)
            norma_core_nearest_add(&nearest, norma_core_corner(mesh, c), (uint32_t)c);
    result = norma_core_nearest_plant(&nearest, count);
    for (size_t c = 0; c < mesh->corner_count && result == NORMA_OK; c++) {
        if (wanted ? !wanted[c] : reasons[c] == NORMA_REASON_NONE) continue;
        const uint32_t source = norma_core_nearest_find(&nearest, norma_core_corner(mesh, c));
        if (source == UINT32_MAX) break;
        requests[(*found)++] =
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

norma_result norma_core_fetch_normals(const core_prepared_mesh *prepared, corner_request *requests,
    size_t count, corner_receiver *receive, void *context) {
    core_star star;
    const size_t most = prepared->corners_of.most;
    if (norma_core_star_allocate(prepared->call, &star, most) != NORMA_OK)
        return NORMA_ERROR_MEMORY;
    norma_core_sort(requests, count, sizeof *requests, request_less);
    for (size_t i = 0; i < count; i++) {
        if (i == 0 || requests[i].position != requests[i - 1].position)
            norma_core_make_star(prepared, CORE_JOIN_FANS, requests[i].position, NULL, &star);
        receive(context, &requests[i], fan_of_corner(&star, requests[i].corner)->normal);
    }
    norma_core_star_release(prepared->call, &star, most);
    return NORMA_OK;
}
