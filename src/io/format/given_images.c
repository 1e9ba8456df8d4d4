/* given_images.c: images that a change has made, until they are files. */
#include "io/format/format.h"
#include <stdlib.h>

const given_image *norma_document_given_image(const norma_document *document, size_t number) {
    for (size_t i = 0; i < document->image_count; ++i)
        if (document->images[i].number == number) return &document->images[i];
    return NULL;
}

void norma_document_forget_images(norma_document *document) {
    for (size_t i = 0; i < document->image_count; ++i) {
        free(document->images[i].bytes);
        free(document->images[i].name);
    }
    free(document->images);
    document->images = NULL;
    document->image_count = 0;
}
