/* run.h: a run over a file: begin; norma_check_run_mesh for each mesh; rules on nodes and the like;
 * finish or abandon. */
#ifndef NORMA_CHECK_RUN_H
#define NORMA_CHECK_RUN_H
#include "check/findings/check_run.h"

/* format decides the profile where options do not. ARGUMENT, MEMORY: nothing to abandon. */
norma_result norma_check_begin(
    check_run *run, const norma_check_options *options, norma_file_format format);
/* next: of the mesh that comes after it, or NULL. given stays as it is until the last primitive of
 * its mesh was run. */
norma_result norma_check_run_mesh(
    check_run *run, const norma_check_mesh *given, const norma_mesh_info *next);
norma_findings *norma_check_finish(check_run *run);
void norma_check_abandon(check_run *run);
#endif
