/* fallback_normals.c: the rings of the sources are made a second time rather than all normals kept,
 * since files where many corners lack one are rare. */
#include "core/corner/fallback_normals.h"
#include "core/mesh/nearest.h"
#include "core/call/sort.h"

norma_result norma_core_find_sources(const core_surface *surface, const uint8_t *reasons,
    const uint8_t *wanted, corner_request *requests, size_t count, size_t *found) {
    const core_mesh *mesh = &surface->mesh;
    core_nearest nearest;
    norma_result result = norma_core_nearest_begin(surface->call, mesh, &nearest);
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

static const core_fan *fan_of_corner(const core_ring *ring, uint32_t corner) {
    size_t low = 0, high = ring->count;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (ring->corners[middle].corner <= corner)
            low = middle;
        else
            high = middle;
    }
    return &ring->fans[ring->fan_of[low]];
}

norma_result norma_core_fetch_normals(const core_surface *surface, corner_request *requests,
    size_t count, corner_receiver *receive, void *context) {
    core_ring ring;
    const size_t most = surface->around.most;
    if (norma_core_ring_allocate(surface->call, &ring, most) != NORMA_OK) return NORMA_ERROR_MEMORY;
    norma_core_sort(requests, count, sizeof *requests, request_less);
    for (size_t i = 0; i < count; i++) {
        if (i == 0 || requests[i].position != requests[i - 1].position)
            norma_core_make_ring(surface, CORE_JOIN_FANS, requests[i].position, NULL, &ring);
        receive(context, &requests[i], fan_of_corner(&ring, requests[i].corner)->normal);
    }
    norma_core_ring_release(surface->call, &ring, most);
    return NORMA_OK;
}
