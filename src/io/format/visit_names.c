/* visit_names.c: names in a file as the paths that they may stand for. */
#include "io/format/format.h"
#include <stdlib.h>
#include <string.h>

int norma_document_visit_name(const norma_document *document, const char *name, size_t length,
    norma_visit_file *visit, void *user) {
    const size_t folder_length = length && name[0] == '/' ? 0 : strlen(document->folder);
    if (length == 0 || memchr(name, '\0', length)) return 0;
    char *path = norma_io_allocate(folder_length + length + 1, 1);
    if (!path) return -1;
    memcpy(path, document->folder, folder_length);
    memcpy(path + folder_length, name, length);
    const int stop = visit(user, path) != 0;
    free(path);
    return stop;
}

int norma_document_visit_names(const norma_document *document, const char *text, size_t length,
    norma_visit_file *visit, void *user) {
    static const char blanks[] = " \t";
    while (length && strchr(blanks, text[length - 1])) --length;
    while (length && strchr(blanks, text[0])) ++text, --length;
    int stop = norma_document_visit_name(document, text, length, visit, user);
    for (size_t at = 0, end; at < length && !stop; at = end) {
        while (at < length && strchr(blanks, text[at])) ++at;
        for (end = at; end < length && !strchr(blanks, text[end]);) ++end;
        if (at > 0 || end < length) /* one alone is all of the text */
            stop = norma_document_visit_name(document, text + at, end - at, visit, user);
    }
    return stop;
}
