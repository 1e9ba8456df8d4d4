/* gltf_compute.h: what computing normals of glTF shares between its files.
 *
 * A surface is all triangles of one mesh, whatever their primitives: a seam between materials is a
 * seam that people see. It gives normals to points: a position with one of its normals. A set is
 * the primitives that draw the same vertices (the same accessors for every attribute): there each
 * point becomes a vertex, the first of an old vertex under its number, further ones behind all
 * others. */
#ifndef NORMA_IO_GLTF_COMPUTE_H
#define NORMA_IO_GLTF_COMPUTE_H
#include "io/format/compute_policy.h"
#include "io/gltf/asset.h"

typedef struct gltf_surface {
    uint32_t mesh;
    norma_mesh core;
    void *positions;      /* owned, where they are not the file's own */
    uint32_t *corners;    /* owned, where there are several primitives */
    size_t *corner_start; /* for each primitive of the mesh: its first corner; SIZE_MAX: it draws no
                             triangles that are read */
    size_t *position_start;
    /* what the core found */
    uint32_t *points;  /* the point of each corner; NULL: its position */
    uint32_t *sources; /* for each point its position */
    float *normals;
    uint8_t *reasons;
    size_t point_count;
    int in_order; /* points are numbered as corners first use them, and each is used */
} gltf_surface;

typedef struct gltf_set {
    uint32_t lead, last; /* its first and last primitive; in between by the job's next_in_set */
    uint32_t
        next_at; /* the next set in the same slot of the table, while sets are made; or GLTF_NONE */
    uint32_t mesh; /* GLTF_NONE: several meshes draw it */
    int wanted, has_morphs;
    size_t vertices, added_count, added_capacity;
    uint8_t *broken; /* NULL: every vertex gets a new normal; else those that are nonzero do */
    uint8_t *taken;  /* an old vertex's number is given away */
    uint32_t *added; /* old vertex of each added one */
    float *normals;  /* of vertices + added_count */
    uint8_t *reasons;
    uint32_t *point_of; /* with morphs: the surface's point of each vertex, or GLTF_NONE */
    size_t capacity;    /* of normals, reasons, point_of */
    uint32_t *table;    /* vertices of several meshes by old vertex and normal; 0: free */
    size_t table_size;
    float **deltas; /* for each target its new normal deltas, or NULL */
    size_t tangents_kept, tangents_turned;
} gltf_set;

typedef struct gltf_job {
    gltf *g;
    const norma_compute_options *options;
    norma_document_error *error;
    compute_policy policy;
    gltf_set *sets;
    uint32_t set_count;
    uint32_t *set_of;      /* for each primitive; GLTF_NONE: not read */
    uint32_t *next_in_set; /* for each primitive the next one of its set, or GLTF_NONE */
    uint32_t **corners;    /* for each primitive its new corners, or NULL */
    double progress_base, progress_scale;
} gltf_job;

/* The point of each corner: smooth, each position is one. */
static inline const uint32_t *norma_gltf_points(const gltf_surface *s) {
    return s->points ? s->points : (const uint32_t *)s->core.corners;
}

norma_document_result norma_gltf_gather(
    gltf_job *job, uint32_t mesh, gltf_surface *surface); /* mesh_surface.c */
norma_document_result norma_gltf_find_points(gltf_job *job, gltf_surface *surface);
void norma_gltf_surface_free(gltf_surface *surface);

norma_document_result norma_gltf_find_vertex_sharing(gltf_job *job); /* vertex_sharing.c */
norma_document_result norma_gltf_take_points(
    gltf_job *job, gltf_surface *surface); /* points become corners */
norma_document_result norma_gltf_fill_unreferenced(gltf_job *job, gltf_set *set);
void norma_gltf_vertex_sharing_free(gltf_job *job);

norma_document_result norma_gltf_morph(
    gltf_job *job, const gltf_surface *surface); /* morph_deltas.c */

/* The old vertex that a vertex of a set is, or is a copy of. */
static inline uint32_t norma_gltf_old_vertex(const gltf_set *set, size_t vertex) {
    return vertex < set->vertices ? (uint32_t)vertex : set->added[vertex - set->vertices];
}
/* set_contents.c: a further vertex behind all others, a copy of an old one: its number; SIZE_MAX:
 * out of memory, or of numbers. */
size_t norma_gltf_add_vertex(gltf_set *set, uint32_t vertex);
/* The same contents in a slot of every primitive of the set; the elements of an
 * accessor, with copies for the added vertices. */
norma_document_result norma_gltf_put_in_set(
    gltf_job *job, const gltf_set *set, int32_t target, const char *attribute, gltf_data *data);
norma_document_result norma_gltf_copy_elements(
    gltf_job *job, const gltf_set *set, uint32_t accessor, gltf_data *data);

norma_document_result norma_gltf_put_set(gltf_job *job, uint32_t set); /* vertex_contents.c */
/* New differences of a target's normals or tangents, three numbers a vertex, in the encoding that
 * they had where that can hold them all; vertices that are not broken keep their bits. */
norma_document_result norma_gltf_put_deltas(
    gltf_job *job, gltf_set *set, uint32_t target, const char *attribute, const float *deltas);
/* stored_tangents.c: once all sets are put, what became of their tangents: counted, and marked
 * where they are to be computed anew. */
norma_document_result norma_gltf_account_tangents(gltf_job *job);
norma_document_result norma_gltf_put_indices(gltf_job *job, uint32_t primitive); /* new_indices.c */
#endif
