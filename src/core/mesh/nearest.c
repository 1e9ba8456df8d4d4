/* nearest.c: few askers look at every site, many get a tree. Both give the same answer. */
#include "core/mesh/nearest.h"

enum { FEW_QUERIES = 48 };

norma_result norma_core_nearest_begin(
    core_call *call, const core_mesh *mesh, core_nearest *nearest) {
    const size_t count = mesh->positions.count;
    *nearest = (core_nearest){.call = call, .mesh = mesh, .first = UINT32_MAX};
    nearest->first_at = norma_core_allocate(call, count, sizeof *nearest->first_at);
    nearest->found_at = norma_core_allocate(call, count, sizeof *nearest->found_at);
    nearest->sites = norma_core_allocate(call, count, sizeof *nearest->sites);
    if (!nearest->first_at || !nearest->found_at || !nearest->sites) {
        norma_core_nearest_end(nearest);
        return NORMA_ERROR_MEMORY;
    }
    memset(nearest->first_at, 0xff, count * sizeof *nearest->first_at);
    memset(nearest->found_at, 0xff, count * sizeof *nearest->found_at);
    return NORMA_OK;
}

void norma_core_nearest_add(core_nearest *nearest, uint32_t position, uint32_t element) {
    if (nearest->first == UINT32_MAX) nearest->first = element;
    if (nearest->first_at[position] != UINT32_MAX) return;
    nearest->first_at[position] = element;
    nearest->sites[nearest->site_count++] = position;
}

norma_result norma_core_nearest_plant(core_nearest *nearest, size_t queries) {
    if (queries <= FEW_QUERIES || !nearest->site_count) return NORMA_OK;
    const norma_result result = norma_core_kdtree_build(nearest->call, nearest->mesh,
        nearest->first_at, nearest->sites, nearest->site_count, &nearest->tree);
    nearest->planted = result == NORMA_OK;
    return result;
}

void norma_core_nearest_end(core_nearest *nearest) {
    const size_t count = nearest->mesh->positions.count;
    if (nearest->planted) norma_core_kdtree_release(nearest->call, &nearest->tree);
    norma_core_release(nearest->call, nearest->first_at, count, sizeof *nearest->first_at);
    norma_core_release(nearest->call, nearest->found_at, count, sizeof *nearest->found_at);
    norma_core_release(nearest->call, nearest->sites, count, sizeof *nearest->sites);
    *nearest = (core_nearest){.mesh = nearest->mesh};
}

static uint32_t look_at_every_site(const core_nearest *nearest, const double point[3]) {
    uint32_t best = UINT32_MAX;
    double least = 0;
    for (size_t i = 0; i < nearest->site_count; i++) {
        double p[3], sum = 0;
        norma_core_position(nearest->mesh, nearest->sites[i], p);
        for (int k = 0; k < 3; k++) sum += (p[k] - point[k]) * (p[k] - point[k]);
        const uint32_t element = nearest->first_at[nearest->sites[i]];
        if (best != UINT32_MAX && !(sum < least || (sum == least && element < best))) continue;
        least = sum;
        best = element;
    }
    return best;
}

/* Equal positions ask for the same; those that are one by a distance need not be at one place. */
static uint32_t place_of(const core_nearest *nearest, uint32_t position) {
    return nearest->call->options.weld == NORMA_WELD_DISTANCE
               ? position
               : norma_core_welded(nearest->mesh, position);
}

static uint32_t look_up(const core_nearest *nearest, uint32_t position) {
    double point[3];
    norma_core_position(nearest->mesh, position, point);
    if (!norma_core_finite(point)) return nearest->first;
    if (!nearest->planted) return look_at_every_site(nearest, point);
    return nearest->first_at[norma_core_kdtree_nearest(&nearest->tree, point)];
}

uint32_t norma_core_nearest_find(core_nearest *nearest, uint32_t position) {
    if (nearest->first == UINT32_MAX) return UINT32_MAX;
    if (nearest->first_at[position] != UINT32_MAX) return nearest->first_at[position];
    uint32_t *found = &nearest->found_at[place_of(nearest, position)];
    if (*found == UINT32_MAX) *found = look_up(nearest, position);
    return *found;
}
