/* explain_stored_normals.h: how the normals and tangents of a file were probably made. */
#ifndef NORMA_CLI_EXPLAIN_STORED_NORMALS_H
#define NORMA_CLI_EXPLAIN_STORED_NORMALS_H
#include <norma/check.h>

typedef struct cli_explained {
    norma_weight weight;
    double crease_deg; /* NaN: smooth, one normal for each position */
    int flat;
    double p50_deg, p99_deg, max_deg; /* between the stored normals and those that it gives */
} cli_explained;
/* 1 if there were normals to explain. */
int cli_explain_normals(norma_document *document, size_t mesh, uint32_t threads,
    cli_explained *explained, norma_document_result *result, norma_document_error *error);

typedef struct cli_explained_tangents {
    norma_tangent_deviation deviation;
    double p50_deg, p99_deg, max_deg;
} cli_explained_tangents;
/* 1 if there were tangents to explain. */
int cli_explain_tangents(norma_document *document, size_t mesh, uint32_t threads,
    cli_explained_tangents *explained, norma_document_result *result, norma_document_error *error);
#endif
