/* window.h: a file read piece by piece, for those that are larger than memory. */
#ifndef NORMA_IO_FILE_WINDOW_H
#define NORMA_IO_FILE_WINDOW_H
#include "io/file/file.h"

typedef struct file_window file_window;

/* Opens a regular file. Returns 0, errno or FILE_NOT_REGULAR. */
int norma_window_open(const char *path, file_window **window);
void norma_window_close(file_window *window); /* NULL is fine */
const file_stamp *norma_window_stamp(const file_window *window);
/* All of these bytes. Returns 0, errno, or FILE_CHANGED where the file has become shorter. */
int norma_window_read(const file_window *window, uint64_t offset, void *bytes, size_t size);
/* Whether the file has been written to since it was opened. */
int norma_window_has_changed(const file_window *window);
#endif
