/* file_stamp.h: stamps from what the system says of a file. */
#ifndef NORMA_IO_FILE_STAMP_H
#define NORMA_IO_FILE_STAMP_H
#include "io/file/file.h"
#include <sys/stat.h>

file_stamp norma_file_stamp_of(const struct stat *status);
int norma_file_stamps_equal(const file_stamp *a, const file_stamp *b);
#endif
