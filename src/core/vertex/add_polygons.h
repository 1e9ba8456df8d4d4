/* add_polygons.h: faces of any number of corners added to the sums of their positions. */
#ifndef NORMA_CORE_VERTEX_ADD_POLYGONS_H
#define NORMA_CORE_VERTEX_ADD_POLYGONS_H
#include "core/vertex/add_triangles.h"

core_add_faces *norma_core_choose_add_polygons(norma_isa isa);
#endif
