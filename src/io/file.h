/* file.h: bytes of a file, mapped for reading; files written whole or not at all. */
#ifndef NORMA_IO_FILE_H
#define NORMA_IO_FILE_H
#include <stddef.h>
#include <stdint.h>
#include <norma/document.h>

typedef struct file_bytes {
    const unsigned char *data; /* never NULL after a successful open, also for an empty file */
    size_t size;
    int mapped, owned; /* how close releases them */
} file_bytes;

/* Regular files are mapped; pipes and devices are read to their end. Returns 0, or errno. */
int norma_file_open(const char *path, file_bytes *bytes);
void norma_file_close(file_bytes *bytes);
/* What has been read of a large mapped file need not stay in this process's memory; it is mapped again where it is needed. */
void norma_file_forget(const file_bytes *bytes);

/* Whether two paths name one existing file. */
int norma_file_same(const char *a, const char *b);
/* Whether path is there and is neither a regular file nor a folder: a device, a pipe. */
int norma_file_is_stream(const char *path);

/* An atomic writer: bytes go through a buffer to a temporary file in the folder of path; prepare flushes it to the disk; commit prepares, renames it to path and
 * flushes the folder; abandon removes it. Each returns 0 or errno. Permissions are those of the file that is replaced, else 0666 less the umask. A symbolic link
 * stays, what it points to is replaced; a file that may not be written is not replaced either. A device or a pipe is written as it is. */
typedef struct file_writer file_writer;
int norma_file_writer_open(const char *path, file_writer **writer);
int norma_file_writer_write(file_writer *writer, const void *bytes, size_t size);
int norma_file_writer_prepare(file_writer *writer);  /* several files: prepare all, then commit all. The writer stays */
int norma_file_writer_commit(file_writer *writer);   /* frees the writer, also on failure (then the temporary file is gone) */
void norma_file_writer_abandon(file_writer *writer); /* frees; NULL is fine */
#endif
