/* calls.h: what the exports of calls.c, plan_calls.c and the page share. */
#ifndef NORMA_WEB_CALLS_H
#define NORMA_WEB_CALLS_H
#include <norma/norma.h>

typedef struct web_mesh_arguments {
    const void *positions;
    size_t position_count, position_stride;
    norma_format format;
    const void *corners; /* NULL: 0, 1, 2, ... */
    size_t corner_count, corner_size;
    norma_weight weight;
    norma_weld weld;
    double weld_distance;
    norma_non_manifold non_manifold;
    norma_fallback fallback;
} web_mesh_arguments;

norma_mesh web_mesh(const web_mesh_arguments *given);
norma_options web_options(const web_mesh_arguments *given);
float web_radians(double degrees);
#endif
