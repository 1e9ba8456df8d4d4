/* named_files.c: the files that a document was read from or names, beside its own: buffers, images,
 * material libraries. A program that writes somewhere asks for them, so that no source is
 * overwritten; none of them is opened here. */
#include "io/format/format.h"
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

norma_document_result norma_document_visit_files(
    norma_document *document, norma_visit_file *visit, void *user, norma_document_error *error) {
    const int is_summary = document && document->depth == NORMA_DOCUMENT_SUMMARY;
    norma_document_clear(error);
    norma_document_result result =
        is_summary ? NORMA_DOCUMENT_OK : norma_document_usable(document, error);
    if (result) return result;
    if (!visit)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "no function that receives the files was given");
    if (!document->folder || !document->functions->visit_files) return NORMA_DOCUMENT_OK;
    return document->functions->visit_files(document, visit, user) < 0
               ? norma_document_fail_memory(document, error)
               : NORMA_DOCUMENT_OK;
}

typedef struct search {
    const char *path;
    int found;
} search;

static int compare_file(void *user, const char *path) {
    search *s = user;
    s->found = norma_file_same(path, s->path);
    return s->found;
}

int norma_document_names_file(const norma_document *document, const char *path) {
    search s = {.path = path};
    struct stat status;
    /* Most outputs do not exist yet, and then they are nobody's source. */
    if (document->folder && document->functions->visit_files && stat(path, &status) == 0)
        document->functions->visit_files(document, compare_file, &s);
    return s.found;
}
