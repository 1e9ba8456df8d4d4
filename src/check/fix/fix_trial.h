/* fix_trial.h: what fixes would make of a document, found out on a copy of it, and measured. */
#ifndef NORMA_FIX_TRIAL_H
#define NORMA_FIX_TRIAL_H
#include "check/fix/fix.h"

enum { FIX_MOST_STEPS = 8 };

typedef struct fix_measure { /* of a document, by all rules */
    norma_findings *findings;
    int has_shape;        /* the following is known */
    size_t loose;         /* edges along which faces do not run as often one way as the other */
    size_t surplus;       /* faces at edges, beyond the second */
    double area, opposed; /* twice, of all faces; of those with normals on their other side */
} fix_measure;
/* Every element that any rule finds, to be freed by the caller. */
norma_document_result norma_fix_find(norma_document *document, const fix_request *request,
    norma_findings **findings, norma_document_error *error);
norma_document_result norma_fix_measure_shape(norma_document *document, const fix_request *request,
    fix_measure *measure, norma_document_error *error);
void norma_fix_measure_free(fix_measure *measure);

/* Rules that report more than before at warning or above, or graver; 0: there are none. worse: room
 * for a mark of each rule. What one rule gains is no excuse for what another loses. */
int norma_fix_find_worse(const fix_measure *before, const fix_measure *after, uint8_t *worse);
const char *norma_fix_worse_shape(
    const fix_measure *before, const fix_measure *after); /* NULL: it is no worse */

typedef struct fix_trial {
    fix_plan plans[FIX_MOST_STEPS]; /* of each step, until nothing more is to be done */
    size_t count;
    fix_measure after;
    char said[CHECK_MESSAGE]; /* by the format: what it could not do; "": nothing */
} fix_trial;
/* first: the plan for the document as it is; it becomes the trial's. */
norma_document_result norma_fix_try(norma_document *document, const fix_request *request,
    fix_plan *first, fix_trial *trial, norma_document_error *error);
void norma_fix_trial_free(fix_trial *trial);
#endif
