/* flush.c: a format whose changes wait beside what was read (glTF) is read anew from what it has
 * become, before it is asked or changed again. */
#include "io/format/format.h"
#include <stdlib.h>

/* From the disk where it was saved over its own file, else from what the format makes of it. */
static norma_document_result take_source(
    norma_document *document, norma_document *made, norma_document_error *error) {
    if (!document->replaced) {
        made->stamp = document->stamp;
        return document->functions->reopen(document, made, error);
    }
    const int failed = norma_file_open(document->path, &(file_reading){0}, &made->source);
    made->stamp = made->source.stamp;
    return failed ? norma_document_fail_file(document->path, error, "cannot be read", failed)
                  : NORMA_DOCUMENT_OK;
}

/* The document is the one that was made, but for its place in memory, its name and its notes. */
static void swap_documents(norma_document *document, norma_document *made) {
    const norma_document old = *document;
    document->source = made->source;
    document->stamp = made->stamp;
    document->state = made->state;
    document->given = made->given;
    document->given_count = made->given_count;
    document->scene = made->scene;
    if (document->replaced) norma_document_forget_images(document); /* they are files now */
    document->replaced = 0;
    made->source = old.source;
    made->state = old.state;
    made->given = old.given;
    made->given_count = old.given_count;
    made->scene = old.scene;
    document->functions->adopt(document);
    document->functions->adopt(made);
}

norma_document_result norma_document_flush(norma_document *document, norma_document_error *error) {
    if (!document->functions->reopen || !document->functions->has_change(document))
        return NORMA_DOCUMENT_OK;
    const norma_document_options options = {.struct_size = sizeof options,
        .format = document->format,
        .depth = document->depth,
        .threads = document->threads,
        .lenient = document->lenient,
        .copied = document->copied};
    norma_document *made = norma_document_make(document->path, document->folder != NULL, &options);
    norma_document_result result =
        made ? take_source(document, made, error) : norma_document_fail_memory(document, error);
    if (!result && norma_document_changed(document, error)) result = NORMA_DOCUMENT_ERROR_FILE;
    if (!result) result = norma_document_read(made, error);
    if (!result) swap_documents(document, made);
    norma_document_close(made);
    return result;
}

norma_document_result norma_document_settle(norma_document *document, norma_document_error *error) {
    const edited_format *edited = document->functions->edited;
    return edited && !edited->gathers ? norma_edited_flush(document, error)
                                      : norma_document_flush(document, error);
}

norma_document_result norma_document_ready(norma_document *document, norma_document_error *error) {
    const norma_document_result result = norma_document_usable(document, error);
    return result ? result : norma_document_settle(document, error);
}

int norma_document_up_to_date(const norma_document *document) {
    norma_document *own = (norma_document *)(uintptr_t)document;
    if (own && !own->failed && own->state) (void)norma_document_flush(own, NULL);
    return document != NULL;
}
