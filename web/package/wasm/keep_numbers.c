/* keep_numbers.c: what norma_split made, with old vertices under their old numbers: the first of a
 * vertex's parts stays where it was, the others follow behind. */
#include "exports.h"
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* The new number of each part. sources: in, the vertex of each part; out, that of each part that
 * follows. Returns how many vertices there are then; UINT32_MAX: memory does not suffice. */
static uint32_t number_parts(uint32_t *sources, size_t parts, uint32_t vertices, uint32_t *place) {
    uint8_t *is_taken = calloc(vertices ? vertices : 1, 1);
    uint32_t added = 0;
    if (!is_taken) return UINT32_MAX;
    for (size_t i = 0; i < parts; ++i) {
        const uint32_t vertex = sources[i];
        sources[added] = vertex; /* stays only if it is added */
        place[i] = is_taken[vertex] ? vertices + added : vertex;
        added += is_taken[vertex];
        is_taken[vertex] = 1;
    }
    free(is_taken);
    return vertices + added;
}

/* corners: their parts become their vertices. values: of each vertex the normal of its part, 0 for
 * those of no face; room for one for each vertex and each part. place: room for a number for each
 * part. */
uint32_t WEB_EXPORT(web_keep_numbers)(uint32_t *corners, size_t corner_count, uint32_t *sources,
    size_t parts, uint32_t vertices, const float (*normals)[3], float (*values)[3],
    uint32_t *place) {
    const uint32_t count = number_parts(sources, parts, vertices, place);
    if (count == UINT32_MAX) return count;
    memset(values, 0, vertices * sizeof *values);
    for (size_t i = 0; i < parts; ++i) memcpy(values[place[i]], normals[i], sizeof *values);
    for (size_t c = 0; c < corner_count; ++c) corners[c] = place[corners[c]];
    return count;
}

/* The first corner of each vertex; UINT32_MAX: none. */
void WEB_EXPORT(web_first_corners)(
    const uint32_t *corners, size_t corner_count, uint32_t *firsts, size_t vertices) {
    memset(firsts, 0xff, vertices * sizeof *firsts);
    for (size_t c = corner_count; c-- > 0;) firsts[corners[c]] = (uint32_t)c;
}
