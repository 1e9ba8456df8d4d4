/* cut_polygon.h: polygons cut into triangles that do not fold, for files and for pictures. */
#ifndef NORMA_CORE_CUT_POLYGON_H
#define NORMA_CORE_CUT_POLYGON_H
#include <norma/norma.h>

typedef struct core_cutter {
    double (*points)[3]; /* the polygon's corners; the caller fills them in before each call */
    size_t work; /* steps left for all polygons together: the time that a concave one takes grows
                    with the square of its corners */
    double (*flat)[2]; /* in the polygon's plane, counter-clockwise */
    double area[3];
    uint32_t *left; /* corners that are not yet cut off */
    size_t count, left_count;
    uint8_t *gone;     /* for each corner: it is cut off */
    uint32_t *checked; /* for each corner: the corners before this one do not lie in the triangle
                          that cuts it off */
} core_cutter;

/* Bytes of memory that a cutter needs for polygons of up to that many corners. */
size_t norma_core_cutter_size(size_t largest);

/* memory: norma_core_cutter_size(largest) bytes, aligned for double.
 * all_corners: of all polygons that are to be cut, which limits the work. */
void norma_core_cutter_begin(core_cutter *cutter, void *memory, size_t largest, size_t all_corners);

/* Whether the fan from the first corner cuts the polygon well: no corner is reflex, or it has no
 * area that a better cut could follow. count: at least 3. */
int norma_core_polygon_fans(core_cutter *cutter, size_t count);

/* Cuts a polygon of count corners, at least 3, into count - 2 triangles, by clipping ears (Meisters
 * 1975) in the plane of its vector area: each time the ear with the shortest cut, of those whose
 * triangles do not turn far away from the polygon.
 * triangles: room for 3 * (count - 2) numbers of corners, from 0.
 * Returns how many triangles, from the first, are ears. Fewer than count - 2: the polygon crosses
 * itself, has no area or no finite corners, or the work is used up; the other triangles are a fan
 * of what was left. */
size_t norma_core_cut_polygon(core_cutter *cutter, size_t count, uint32_t *triangles);
#endif
