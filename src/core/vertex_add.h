/* vertex_add.h: the two loops that most of the time of norma_vertex_normals goes to: triangles added to the sums of positions, and sums made normals. */
#ifndef NORMA_CORE_VERTEX_ADD_H
#define NORMA_CORE_VERTEX_ADD_H
#include "vertices.h"

typedef struct core_adder {
    const core_mesh *mesh;            /* of triangles */
    norma_weight     weight;
    vertex_sum      *sums;            /* of count positions from first on; corners elsewhere are passed over */
    uint32_t         first, count;
    int              owns_all;        /* no corner of the faces that are to be added is elsewhere */
    int              scattered;       /* corners in a row lie far apart: memory is asked for ahead */
    int              by_distance;     /* positions that differ may be welded into one */
    void           (*add_face)(void *context, size_t face);   /* a triangle that doubles do not decide */
    void            *context;
} core_adder;

/* Adds the faces from begin to before end, in ascending order. */
typedef void core_add_triangles(const core_adder *adder, size_t begin, size_t end);
/* The normals of CORE_LANES sums. Returns whether each is one; where one has no votes, cancels, or is beyond what doubles square, none of them is to be used. */
typedef int core_finish_sums(const vertex_sum sums[CORE_LANES], float normals[CORE_LANES][3]);

core_add_triangles *norma_core_choose_add(norma_isa isa);
core_finish_sums   *norma_core_choose_finish(norma_isa isa);
#endif
