/* fallback_normals.h: corners without a normal get that of the nearest corner that has one. */
#ifndef NORMA_CORE_CORNER_FILL_H
#define NORMA_CORE_CORNER_FILL_H
#include "core/corner/visit_positions.h"

typedef struct corner_request {
    uint32_t position, corner, target;
} corner_request; /* the normal of this corner, at this position, goes to target */

/* reasons: of each corner. Asks for each corner of which wanted (NULL: each without a normal) is
 * nonzero; target is the corner. requests has room for count of them; *found: how many have a
 * source. Where no corner of the mesh has a normal, none. */
norma_result norma_core_find_sources(const core_prepared_mesh *prepared, const uint8_t *reasons,
    const uint8_t *wanted, corner_request *requests, size_t count, size_t *found);

/* Hands each request's normal over; stars are made once for each position. Sorts the requests. */
typedef void corner_receiver(void *context, const corner_request *request, const float normal[3]);
norma_result norma_core_fetch_normals(const core_prepared_mesh *prepared, corner_request *requests,
    size_t count, corner_receiver *receive, void *context);
#endif
