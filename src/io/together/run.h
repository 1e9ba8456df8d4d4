/* run.h: one call of norma_together_compute. */
#ifndef NORMA_IO_TOGETHER_RUN_H
#define NORMA_IO_TOGETHER_RUN_H
#include "io/format/format.h"
#include "io/together/join.h"
#include "io/together/member.h"
#include "io/together/near.h"

typedef struct creases creases; /* creases.h */

typedef struct together_run {
    const norma_together_file *files;
    size_t count, number; /* number: of the file at hand */
    norma_together_options options;
    norma_compute_options compute;
    norma_document_error *error;
    equality equal;
    near_positions *near;
    spill *votes, *normals;
    creases *creases;   /* NULL: normals are smooth */
    size_t *degenerate; /* faces of each file */
    const char *folder; /* of temporary files */
    char *own_folder;
    companion_writers writers; /* of all outputs, complete, waiting to be put in place */
    double passes, passes_done;
} together_run;

/* run.c */
norma_document_result norma_together_fail_spill(together_run *run, int failed);
/* Nonzero: the caller wants to stop. */
int norma_together_tell(together_run *run, double share_of_file);

/* take_votes.c: each position of a file, what its faces add there, or the normal that it keeps. */
norma_document_result norma_together_take_votes(together_run *run, member *m);
norma_document_result norma_together_take_positions(together_run *run, member *m);

/* write_file.c: a file's normals, and its output, complete but not in place. */
norma_document_result norma_together_write_file(together_run *run, member *m);
norma_document_result norma_together_commit(together_run *run);
char *norma_together_folder_of(const char *path); /* to be freed; NULL: out of memory */

/* What became of a surface's positions, or with creases of its corners. */
typedef struct surface_normals {
    float *normals;
    uint8_t *reasons;
    size_t count;
} surface_normals;

/* surface_normals.c: the next records of run->normals. */
norma_document_result norma_together_surface_normals(
    together_run *run, member *m, const document_surface *surface, surface_normals *made);
/* A normal of the world in the mesh's own space. */
void norma_together_into_mesh(const placement *place, const position_normal *from, float normal[3]);
/* By more than rounding: then a mesh that is drawn at several places would need one copy for each.
 */
int norma_together_differ(const float a[3], const float b[3]);
norma_document_result norma_together_fail_places(
    const together_run *run, const member *m, const document_surface *surface, size_t count);
#endif
