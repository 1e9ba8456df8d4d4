/* compute_policy.h: what is decided when the normals of a file are computed, alike for every
 * format: how the mesh is shaded, which stored normals are replaced, what is written for elements
 * without a normal, and what is counted. A format says how it stores normals and hands over its
 * meshes. */
#ifndef NORMA_IO_COMPUTE_POLICY_H
#define NORMA_IO_COMPUTE_POLICY_H
#include "io/format/format.h"

typedef struct compute_policy {
    const norma_compute_options *options;
    norma_compute_summary *summary;
    norma_options core; /* options of the core's calls, with the nearest fallback in force */
    size_t meshes;      /* computed so far */
    const shared_normals *shared; /* NULL, or where the normals of positions come from */
    size_t surface;               /* the number of the surface that is to be computed */
} compute_policy;

/* Begins the summary. usual: the shading that the format gets if none was asked for; has_groups:
 * the mesh has smoothing groups, which decide about a crease if they are not to be ignored. */
compute_policy norma_policy_begin(const norma_compute_options *options,
    norma_compute_summary *summary, norma_shading usual, int has_groups);

/* ---- which stored normals are replaced */

/* By core/face/unit_length.h, in so many bits. */
int norma_normal_is_broken(const double normal[3], int bits);
/* Whether --only asks for a new one in place of a normal that is there. */
int norma_policy_wants(norma_only only, const double normal[3], int bits);
/* The same for the facet of an STL, where zero is a custom that means "take the winding": it counts
 * as missing, so that missing and broken fill it; broken beyond that is only what is not finite. */
int norma_policy_wants_facet(norma_only only, const float stored[3]);

/* ---- computing */

typedef enum normal_elements {
    NORMALS_OF_POSITIONS, /* smooth */
    NORMALS_OF_FACES,     /* flat */
    NORMALS_OF_CORNERS,   /* creased, one for each corner */
    NORMALS_OF_POINTS     /* creased, one for all corners at a vertex that share theirs */
} normal_elements;
normal_elements norma_policy_elements(norma_shading shading);

typedef struct computed_normals {
    normal_elements elements;
    int with_reasons; /* whether reasons and, of points, sources are asked for */
    double crease_angle_rad;
    float *normals;    /* of each element; zero if the mesh has no normal at all */
    uint8_t *reasons;  /* of each element, why it got the nearest normal instead of its own */
    uint32_t *points;  /* of each corner its point, numbered as corners first use them */
    uint32_t *sources; /* of each point its position */
    size_t count;      /* of elements */
} computed_normals;

/* Adds the report of one mesh to the sum; the firsts become SIZE_MAX from the second mesh on. */
void norma_policy_add_report(norma_report *sum, const norma_report *report, size_t meshes_before);

/* The normals of one mesh. Adds to the report,
 * and to the hard edges if there are creases. */
norma_result norma_policy_compute(
    compute_policy *policy, const norma_mesh *mesh, computed_normals *made);
void norma_computed_normals_free(computed_normals *made);

/* ---- what is written, what is counted */

/* Files get the z axis if the whole mesh has no direction, and so no nearest normal either. */
static inline void norma_policy_point_up(float normal[3]) {
    if (normal[0] == 0 && normal[1] == 0 && normal[2] == 0) normal[2] = 1;
}
/* The sign of a stored zero says nothing: it stays, so that right normals stay to the bit. */
static inline float norma_policy_keep_zero(float now, double stored) {
    return now == 0 && stored == 0 ? (float)stored : now;
}
/* Points up where there is no normal, and counts the elements that were filled. wanted: of the
 * first wanted_count elements, whether they get a new normal, as all others do; may be NULL. */
void norma_policy_fill(compute_policy *policy, float *normals, const uint8_t *reasons, size_t count,
    const uint8_t *wanted, size_t wanted_count);
/* Formats whose vertices are others than the core's count them as they stand in the file: they
 * forget what the core counted without a normal of its own, and count by reasons. several: there
 * are other meshes, so no vertex is the first. */
void norma_policy_forget(norma_report *report);
void norma_policy_report(norma_report *report, const uint8_t *reasons, size_t count,
    const uint8_t *wanted, size_t wanted_count, int several);
/* What the core counted without a normal of its own. */
size_t norma_policy_without_normal(const norma_report *report);
#endif
