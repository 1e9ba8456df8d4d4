/* document.c: a program in C that needs a library with documents: reads a mesh from memory,
 * computes, writes. */
#include <norma/document.h>
#include <stdio.h>
#include <string.h>

static int print(void *user, const void *bytes, size_t size) {
    (void)user;
    return fwrite(bytes, 1, size, stdout) != size;
}

int main(void) {
    static const char obj[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    const norma_document_options options = {
        .struct_size = sizeof options, .format = NORMA_FILE_OBJ};
    norma_document *document;
    norma_document_error error;
    if (norma_document_open_memory(obj, strlen(obj), "triangle.obj", &options, &document, &error) !=
            NORMA_DOCUMENT_OK ||
        norma_document_compute(document, NULL, NULL, &error) != NORMA_DOCUMENT_OK ||
        norma_document_write(document, print, NULL, &error) != NORMA_DOCUMENT_OK) {
        fprintf(stderr, "%s\n", error.message);
        return 1;
    }
    norma_document_close(document);
    return 0;
}
