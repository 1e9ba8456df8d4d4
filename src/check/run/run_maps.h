/* run_maps.h: the rules that look into normal maps, which a document alone has. */
#ifndef NORMA_CHECK_RUN_MAPS_H
#define NORMA_CHECK_RUN_MAPS_H
#include "check/run/run.h"

typedef struct map_job {
    check_run *run;
    norma_document *document;
    const norma_check_mesh *meshes; /* of the document, those that were read */
    const size_t *orders;           /* of their places */
    size_t mesh_count;
    norma_document_error *error; /* of what is returned */
} map_job;

/* failed: of a rule. */
norma_document_result norma_check_maps(const map_job *job, norma_result *failed);
#endif
