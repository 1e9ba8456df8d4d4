/* companion_writers.c: the files that go beside a document, written and waiting to be renamed. */
#include "io/format/format.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>

int norma_document_add_writer(companion_writers *writers, file_writer *writer, const char *path) {
    file_writer **list =
        norma_io_grow(writers->list, &writers->list_capacity, writers->count + 1, sizeof *list);
    writers->list = list ? list : writers->list;
    char **paths = list ? norma_io_grow(writers->paths, &writers->path_capacity, writers->count + 1,
                              sizeof *paths)
                        : NULL,
         *copy = paths ? norma_io_copy_text(path, strlen(path)) : NULL;
    writers->paths = paths ? paths : writers->paths;
    if (!copy) {
        norma_file_writer_abandon(writer);
        return 0;
    }
    list[writers->count] = writer;
    paths[writers->count++] = copy;
    return 1;
}

void norma_document_expect(
    const companion_writers *writers, file_writer *writer, file_stamp *stamp) {
    if (writers->outlive)
        norma_file_writer_expect_once(writer, stamp);
    else
        norma_file_writer_expect(writer, stamp);
}

int norma_document_add_folder(companion_writers *writers, const char *path) {
    int made;
    char *copy = norma_io_copy_text(path, strlen(path)),
         **folders = copy ? norma_io_grow(writers->folders, &writers->folder_capacity,
                                writers->folder_count + 1, sizeof *folders)
                          : NULL;
    writers->folders = folders ? folders : writers->folders;
    const int error = folders ? norma_folder_make(path, &made) : ENOMEM;
    if (error || !made)
        free(copy);
    else
        folders[writers->folder_count++] = copy;
    return error;
}

void norma_document_free_writers(companion_writers *writers, int abandon) {
    for (size_t i = 0; i < writers->count; ++i) {
        if (abandon) norma_file_writer_abandon(writers->list[i]);
        free(writers->paths[i]);
    }
    while (writers->folder_count > 0) { /* what lies in another was made after it */
        if (abandon) norma_folder_remove(writers->folders[writers->folder_count - 1]);
        free(writers->folders[--writers->folder_count]);
    }
    free(writers->list);
    free(writers->paths);
    free(writers->folders);
}
