/* gltf_tangents.h: what computing tangents of glTF shares between its files. Sets of primitives
 * that draw the same vertices are those of computing normals; their vertices are split where
 * corners have different tangents. */
#ifndef NORMA_IO_GLTF_TANGENTS_H
#define NORMA_IO_GLTF_TANGENTS_H
#include "io/gltf/gltf_compute.h"

typedef struct tangent_job {
    gltf_job sets;
    norma_compute_options all; /* what the sets are made for */
    const norma_tangent_options *options;
    norma_tangent_summary *summary;
    norma_options core;
    uint32_t *materials; /* the token of each material */
    double progress_base, progress_scale;
} tangent_job;

/* The tangents of a set's vertices as they will be. */
typedef struct tangent_set {
    gltf_set *set;
    gltf_array encoding; /* of the stored tangents; floats where there are none */
    size_t size;         /* bytes of one code */
    unsigned char *codes;
    uint32_t *table; /* vertices by old vertex and code, + 1; 0: free */
    size_t table_size;
    float **deltas; /* for each morph target with normals three numbers a vertex; else NULL */
    size_t capacity;
} tangent_set;

/* The corners of one primitive. */
typedef struct tangent_corners {
    const uint32_t *corners; /* old vertices */
    size_t count;
    unsigned char *codes;
    float **deltas;
} tangent_corners;

/* tangent_inputs.c: whether a primitive has what its tangents are made of. */
int norma_gltf_takes_tangents(const tangent_job *job, const gltf_primitive *p);
int norma_gltf_has_map_texcoords(const tangent_job *job, const gltf_primitive *p);
norma_document_result norma_gltf_find_materials(tangent_job *job);
/* The texture coordinates of its vertices, through the normal map's transform where it has one;
 * *owned: to be freed. */
norma_document_result norma_gltf_tangent_texcoords(
    tangent_job *job, const gltf_primitive *p, const float **texcoords, float **owned);

/* tangent_corners.c: a primitive's tangents, encoded, and their deltas in morph targets. */
norma_document_result norma_gltf_corner_tangents(
    tangent_job *job, uint32_t primitive, const tangent_set *of, tangent_corners *made);
void norma_gltf_corner_tangents_free(const gltf_primitive *p, tangent_corners *made);
/* Vectors of count normals and any tangents, made unit and perpendicular; encoded. */
norma_document_result norma_gltf_encode_tangents(
    tangent_job *job, const tangent_set *of, const float *tangents, size_t count, gltf_data *data);

/* tangent_vertices.c: corners become vertices, vertices contents. */
norma_document_result norma_gltf_begin_tangents(tangent_job *job, gltf_set *set, tangent_set *of);
norma_document_result norma_gltf_take_tangents(
    tangent_job *job, uint32_t primitive, tangent_set *of, const tangent_corners *made);
norma_document_result norma_gltf_put_tangents(tangent_job *job, tangent_set *of);
void norma_gltf_tangent_set_free(const gltf *g, tangent_set *of);
#endif
