/* transform_stored_normals.h: stored normals under the matrix of a whole document. */
#ifndef NORMA_IO_CARRY_H
#define NORMA_IO_CARRY_H
#include "io/format/format.h"

typedef struct normal_carrier {
    float matrix[9]; /* the normal matrix, its greatest entry 1 */
    double flat[3];  /* where the model flattens: the direction of the normals that remain */
    int mirrored;
} normal_carrier;

/* Progress is 0, and the summary knows whether the matrix mirrors. */
norma_document_result norma_stored_normals_begin(const norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    normal_carrier *carrier, norma_document_error *error);
norma_document_result norma_stored_normals_progress(const norma_document *document,
    const norma_transform_options *options, double fraction, norma_document_error *error);
/* normals: three doubles each, out: three floats. What the matrix takes to nothing gets the
 * direction that remains, what is not finite becomes zero; notes say how many. */
norma_document_result norma_transform_stored_normals(norma_document *document,
    const normal_carrier *carrier, const double *normals, size_t count, float *out,
    norma_document_error *error);
/* Refuses a matrix that takes a finite coordinate beyond most, the largest number that the file can
 * hold. what: the element that the message names, which has positions_each of them. */
norma_document_result norma_check_transformed_range(const norma_document *document,
    const norma_vec3_view *before, const double *after, double most, const char *what,
    size_t positions_each, norma_document_error *error);
int norma_stored_normals_is_identity(const double model[16]);
#endif
