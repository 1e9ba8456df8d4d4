/* reflex.h: on which side of straight a corner of a polygon lies, exactly. */
#ifndef NORMA_CORE_REFLEX_H
#define NORMA_CORE_REFLEX_H
#include "core/face/exact_area.h"

/* Whether the edges at a corner, seen along the polygon's vector area, turn the other way than the
 * polygon: those from previous to here and from here to next. The polygon's count points and the
 * corner's are finite. O(count). */
int norma_core_turns_back(exact_point *point, const void *context, size_t count,
    const double here[3], const double next[3], const double previous[3]);
#endif
