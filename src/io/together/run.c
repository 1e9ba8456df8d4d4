/* run.c: what every step of a call reports: a temporary file that fails, and how far it came. */
#include "io/together/run.h"

norma_document_result norma_together_fail_spill(together_run *run, int failed) {
    return norma_document_fail_file(run->folder, run->error,
        "the temporary file of this run cannot be written or read", failed);
}

int norma_together_tell(together_run *run, double share_of_file) {
    const double files = (double)run->count;
    return run->compute.progress &&
           run->compute.progress(run->compute.progress_user,
               (run->passes_done + ((double)run->number + share_of_file) / files) / run->passes);
}
