/* explain.h: how stored normals and tangents were made: the weight and crease, the frame, the way
 * of making tangents that explain them best. */
#ifndef NORMA_CHECK_EXPLAIN_H
#define NORMA_CHECK_EXPLAIN_H
#include "check/findings/check_run.h"
#include <math.h>

typedef struct explain_trial {
    norma_weight weight;
    double crease_rad; /* NaN: smooth */
    int flat;
} explain_trial;

/* A surface whose corners have stored normals: the whole mesh, or a part of it that has whole rings
 * around some positions. */
typedef struct explain_surface {
    const norma_mesh *mesh;
    core_mesh checked;
    int per_vertex;
    int welded; /* no two positions are equal */
    float *
        stored; /* of each corner, or of each vertex; zero: it has none, or its ring is not whole */
    size_t stored_count;
    float *computed; /* room for a normal of each corner, vertex or face */
    float *angles;   /* of each corner, radians; negative: not compared */
    size_t room;
} explain_surface;

/* Says in a deviation what the trial's weight and crease are. */
void norma_explain_tell(const explain_trial *trial, norma_deviation *deviation);
/* Computes the trial's normals and the angle at each corner that has a stored one. */
norma_result norma_explain_measure(
    core_call *call, explain_surface *surface, const explain_trial *trial);
/* Which of the stored and the computed normals are a corner's. */
static inline size_t norma_explain_stored_of(const explain_surface *s, size_t corner) {
    return s->per_vertex ? norma_core_corner(&s->checked, corner) : corner;
}
static inline size_t norma_explain_computed_of(
    const explain_surface *s, const explain_trial *trial, size_t face, size_t corner) {
    return trial->flat                ? face
           : isnan(trial->crease_rad) ? norma_core_corner(&s->checked, corner)
                                      : corner;
}
/* Right for small angles, whatever the lengths. Negative: one of them is no direction. */
float norma_explain_angle(const float *a, const float *b);

/* topology: that of the mesh, its corners sorted; NULL: made here. worst: the first corner with the
 * greatest angle; SIZE_MAX: all are zero. */
norma_result norma_explain_with(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, norma_deviation *deviation,
    size_t *worst);

/* Whether half of the stored normals are within 30 degrees of those that explain them best, as far
 * as that can be said at once: 0 says nothing. likely: NULL, or what may explain them. */
norma_result norma_explain_is_near(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, const norma_deviation *likely,
    int *is_near);

/* Calls visit with the surface, its normals read; with a sample of it where it is large. */
typedef norma_result explain_visit(core_call *call, explain_surface *surface, void *context);
norma_result norma_explain_on_sample(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, explain_visit *visit, void *context);
/* Calls visit with every weight and crease that makes a difference, the likeliest first, until
 * *done is set. */
typedef norma_result explain_try(const explain_trial *trial, void *context);
norma_result norma_explain_each_trial(
    core_call *call, explain_surface *surface, explain_try *visit, void *context, const int *done);

/* explain_frame.c: what all normals were turned by, so that a weight and a crease explain them. */
typedef enum explain_frame_kind {
    EXPLAIN_FRAME_NONE = 0, /* nothing that was tried */
    EXPLAIN_FRAME_REVERSED,
    EXPLAIN_FRAME_MIRROR,
    EXPLAIN_FRAME_ROTATION,
    EXPLAIN_FRAME_BOTH /* mirrored along the axis and rotated about it */
} explain_frame_kind;
typedef struct explain_frame {
    explain_frame_kind kind;
    double turn[4]; /* a unit quaternion; of all but a rotation, what it turns is then reversed */
    double axis[3]; /* unit; not of what is reversed */
    double angle_rad;
    double median_rad; /* left when that is undone */
    explain_trial trial;
} explain_frame;
norma_result norma_explain_find_frame(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, explain_frame *frame);

norma_result norma_explain_summarise(
    core_call *call, const explain_surface *surface, norma_deviation *deviation, size_t *worst);
norma_result norma_explain_tangents_with(core_call *call, const norma_mesh_data *data,
    const norma_mesh_attributes *attributes, const core_mesh *checked,
    norma_tangent_deviation *deviation, size_t *worst);
#endif
