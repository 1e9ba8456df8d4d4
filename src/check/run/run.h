/* run.h: a run over a file: begin; norma_check_run_group for each glTF mesh or the one mesh of
 * another file; rules on nodes and the like; finish or abandon. */
#ifndef NORMA_CHECK_RUN_H
#define NORMA_CHECK_RUN_H
#include "check/findings/check_run.h"

/* format decides the profile where options do not. ARGUMENT, MEMORY: nothing to abandon. */
norma_result norma_check_begin(
    check_run *run, const norma_check_options *options, norma_file_format format);
/* Without a place. Owns nothing until a rule asks for its geometry. ARGUMENT, INDEX, OVERFLOW:
 * arrays that no rule may walk. */
norma_result norma_check_open_mesh(check_run *run, const norma_check_mesh *given, check_mesh *m);
void norma_check_close_mesh(check_mesh *m);
/* meshes: those that norma_check_group_size says belong together. orders: of their places, or NULL:
 * they are next. */
norma_result norma_check_run_group(
    check_run *run, const norma_check_mesh *meshes, size_t count, const size_t *orders);
size_t norma_check_group_size(const norma_check_mesh *meshes, size_t count);
norma_findings *norma_check_finish(check_run *run);
/* check_document.c: that the rules failed, in words. */
norma_document_result norma_check_fail(norma_document_error *error, norma_result result);
void norma_check_abandon(check_run *run);
#endif
