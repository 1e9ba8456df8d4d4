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
/* meshes: those that belong together, as norma_check_siblings has it. orders: of their places, or
 * NULL: they are next. */
norma_result norma_check_run_group(
    check_run *run, const norma_check_mesh *meshes, size_t count, const size_t *orders);
norma_findings *norma_check_finish(check_run *run);
void norma_check_abandon(check_run *run);

/* check_document.c: what is the same in known->document as here is not looked at again, but by the
 * rules of known->again: the findings there, of every rule that is asked for, are copied. known
 * NULL: nothing is known. */
typedef struct check_known {
    norma_document *document;
    const norma_findings *findings;
    const uint8_t *again; /* NULL: none */
    check_judge *judges;  /* NULL, or for each mesh of the document that of the group it begins */
    int is_trial;         /* of a fix: findings are counted, and their words read by nobody */
} check_known;
norma_document_result norma_check_again(norma_document *document, const check_known *known,
    const norma_check_options *options, norma_findings **findings, norma_document_error *error);

/* check_document.c: that a document cannot be checked, or fixed, in words. NORMA_OK: nothing. */
norma_document_result norma_check_fail_to(
    norma_document_error *error, norma_result result, const char *verb);
static inline norma_document_result norma_check_fail(
    norma_document_error *error, norma_result result) {
    return norma_check_fail_to(error, result, "checked");
}
static inline norma_document_result norma_fix_fail(
    norma_document_error *error, norma_result result) {
    return norma_check_fail_to(error, result, "fixed");
}
#endif
