/* file_stamp.h: stamps from what the system says of a file, and what a file keeps that is replaced.
 */
#ifndef NORMA_IO_FILE_STAMP_H
#define NORMA_IO_FILE_STAMP_H
#include "io/file/file.h"
#include <sys/stat.h>

file_stamp norma_file_stamp_of(const struct stat *status);
/* What the file called from, of which the system says old, has of owner, permissions, access lists
 * and attributes, for the open file that will take its place. Returns 0, errno, or FILE_ATTRIBUTES
 * where one of them cannot be kept. */
#endif
