/* explain_normals.h: what the search for an explanation and its measure share. */
#ifndef NORMA_CHECK_EXPLAIN_H
#define NORMA_CHECK_EXPLAIN_H
#include "check/findings/check_run.h"

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
    float *
        stored; /* of each corner, or of each vertex; zero: it has none, or its ring is not whole */
    size_t stored_count;
    float *computed; /* room for a normal of each corner, vertex or face */
    float *angles;   /* of each corner, radians; negative: not compared */
    size_t room;
} explain_surface;

/* explain_sample.c: a part of a mesh with many faces, chosen by numbers alone: the faces around
 * some of its positions. Everything is owned by it. */
typedef struct explain_sample {
    norma_mesh mesh;
    double (*positions)[3];
    uint32_t *corners, *starts, *groups;
    uint8_t *hard_edges;
    uint32_t *sources; /* of each corner the corner of the whole mesh */
    uint8_t *whole;    /* of each corner: all faces at its position are there */
    size_t position_count, corner_count, face_count;
} explain_sample;
enum { EXPLAIN_FACES = 4096 }; /* a mesh of no more is its own sample */
norma_result norma_explain_take_sample(
    core_call *call, const core_topology *topology, explain_sample *sample);
void norma_explain_free_sample(const core_call *call, explain_sample *sample);

/* explain_normals.c */
norma_result norma_explain_open(const core_call *call, const norma_mesh *mesh, int per_vertex,
    explain_surface *surface); /* stored is zeroed */
void norma_explain_close(const core_call *call, explain_surface *surface);
/* Computes the trial's normals and the angle at each corner that has a stored one. */
norma_result norma_explain_measure(
    core_call *call, explain_surface *surface, const explain_trial *trial);
/* topology: that of the mesh, its corners sorted; NULL: made here. */
norma_result norma_explain_with(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, norma_deviation *deviation);

/* summarise_angles.c */
norma_result norma_explain_summarise(
    core_call *call, const explain_surface *surface, norma_deviation *deviation);
#endif
