/* findings.h: what stands behind norma_findings. */
#ifndef NORMA_CHECK_FINDINGS_H
#define NORMA_CHECK_FINDINGS_H
#include "check/findings/check_run.h"

typedef struct findings_entry {
    norma_finding finding;
    size_t order; /* of its place, then of its addition */
    size_t number;
} findings_entry;

struct norma_findings {
    norma_check_profile profile;
    int partly;
    findings_entry *entries;
    size_t count, room;
};

norma_findings *norma_findings_new(norma_check_profile profile); /* NULL: out of memory */
void norma_findings_sort(norma_findings *findings);              /* by place, rule, severity */

/* To be changed: by norma_finding_withdraw, which takes its fix from it and gives it another
 * message. 0: out of memory. */
norma_finding *norma_findings_change(norma_findings *findings, size_t index);
int norma_finding_withdraw(norma_finding *finding, const char *message);

/* Fills in the positions of samples, as locate finds that of their vertex or else the middle of
 * their face. */
typedef norma_document_result check_locate(void *context, norma_sample *sample);
norma_document_result norma_findings_locate(
    norma_findings *findings, check_locate *locate, void *context);
#endif
