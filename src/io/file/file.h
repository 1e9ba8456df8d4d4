/* file.h: the bytes of a file, files written whole or not at all, memory, and who waits. */
#ifndef NORMA_IO_FILE_H
#define NORMA_IO_FILE_H
#include <norma/document.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>

/* ---- Checked allocation, lists that grow, copies of texts. */

/* Checked sizes: 0 where count * size overflows or memory is out. *block may be NULL before. */
void *norma_io_allocate(size_t count, size_t size); /* zeroed; never of zero bytes */
char *norma_io_copy_text(const char *text, size_t length);
char *norma_io_join(const char *folder, const char *name); /* folder: with its slash, or "" */
void *norma_io_grow(void *block, size_t *capacity, size_t needed,
    size_t size); /* doubles; NULL: out of memory, block untouched and still owned */
/* One more element, zeroed, at the end of the list whose address list is; NULL: out of memory. */
void *norma_io_add(void *list, size_t *capacity, size_t *count, size_t size);

/* Bytes that grow; data is the caller's to free. */
typedef struct growing_bytes {
    char *data;
    size_t size, capacity;
    int failed; /* out of memory: further bytes are dropped */
} growing_bytes;
void norma_io_append(growing_bytes *to, const void *bytes, size_t size);

/* ---- Blocks that may be large. */

/* A block of bytes, not zeroed, for free(); where it is large, on large pages if the system has
 * them, of which fewer are to be faulted in. What is never written takes no memory. NULL: out of
 * memory. */
void *norma_io_block(size_t count, size_t size);
/* As norma_io_block, with the first kept bytes of block, which is freed. NULL: out of memory, block
 * untouched and still owned. */
void *norma_io_move_block(void *block, size_t kept, size_t count, size_t size);

/* ---- What an error number of the system means. */

/* A few English words, whatever the locale; NULL for a number that has none here. */
const char *norma_system_text(int error);

/* ---- Whether the caller still waits for what is under way. Work that may be long without
 * handing anything on asks once in a while: a line, a list or a string may be gigabytes long. Only
 * the thread that made the call talks to the caller; the others see what it was answered. */

typedef struct norma_watch {
    norma_progress *progress; /* NULL: nobody watches */
    void *user;
    double told; /* a fraction never falls */
    pthread_t caller;
    atomic_int cancelled;
} norma_watch;

enum { WATCH_BYTES = 1 << 20 }; /* of text, from one question to the next: a few milliseconds */

/* By the thread that makes the call; progress may be NULL. end: whether it was cancelled. */
void norma_watch_begin(norma_watch *watch, norma_progress *progress, void *user);
int norma_watch_end(norma_watch *watch);
/* By the thread that made the call: the fraction, and whether to stop. A norma_progress. */
int norma_watch_tell(void *watch, double fraction);
/* By any thread: whether to stop. watch may be NULL. */
int norma_watch_cancelled(norma_watch *watch);
/* The same once WATCH_BYTES lie between *asked, which moves, and at. */
static inline int norma_watch_passed(norma_watch *watch, const void **asked, const void *at) {
    if ((const char *)at - (const char *)*asked < WATCH_BYTES) return 0;
    *asked = at;
    return norma_watch_cancelled(watch);
}
/* Waits for the condition, or a little while: then the caller is asked. */
void norma_watch_wait(norma_watch *watch, pthread_cond_t *condition, pthread_mutex_t *lock);

/* ---- The bytes of a file; files written whole or not at all. */

/* Which file it was, and how it was, when it was read. */
typedef struct file_stamp {
    uint64_t device, inode, size;
    int64_t seconds, nanoseconds; /* of its last modification */
    int known;                    /* zero: no regular file, or none at all */
} file_stamp;

typedef struct file_bytes {
    const unsigned char *data; /* never NULL after a successful open, also for an empty file */
    size_t size;
    int mapped, owned; /* how close releases them */
    file_stamp stamp;
} file_bytes;

/* What these functions return beside 0 and errno. */
enum {
    FILE_CHANGED = -1,
    FILE_IN_USE = -2,
    FILE_CANCELLED = -3,
    FILE_NOT_REGULAR = -4,
    FILE_NOT_FLUSHED = -5,
    FILE_ATTRIBUTES = -6
};

typedef struct file_reading {
    int map_large; /* nonzero: a large file is mapped, for readers that check each byte where they
                      use it and read it once. Cut short by another program, it raises SIGBUS */
    norma_progress *progress; /* asked now and then whether to go on; may be NULL */
    void *progress_user;
} file_reading;

/* Reads a regular file into memory. how may be NULL: no mapping, no progress. Returns 0, errno,
 * FILE_CHANGED, FILE_CANCELLED or, for a device or a pipe, which may have no end,
 * FILE_NOT_REGULAR. */
int norma_file_open(const char *path, const file_reading *how, file_bytes *bytes);
void norma_file_close(file_bytes *bytes);

/* Whether the file has been written to since the stamp was taken. Another file that has taken its
 * name meanwhile is no change: what was read is whole. */
int norma_file_has_changed(const char *path, const file_stamp *stamp);
/* Whether path still names that file, as it was. */
int norma_file_is_unchanged(const char *path, const file_stamp *stamp);
/* Whether two paths name one existing file. */
int norma_file_same(const char *a, const char *b);
/* Whether path is there and is neither a regular file nor a folder: a device, a pipe. */
int norma_file_is_stream(const char *path);

/* Whether path is a regular file, links followed; whether it is itself a symbolic link. */
int norma_file_is_regular(const char *path);
int norma_file_is_link(const char *path);

/* An atomic writer: bytes go through a buffer to a temporary file in the folder of path, which has
 * no name until all is written, where the system can do that; prepare flushes it to the disk;
 * commit prepares, renames it to path and flushes the folder (FILE_NOT_FLUSHED: it
 * is in its place, but the flush failed); abandon removes it. Each returns 0,
 * errno or what stands above. Owner, permissions, access lists and attributes are those of the
 * file that is replaced (FILE_ATTRIBUTES: they cannot be), else 0666 less the umask. A symbolic
 * link stays, what it points to is replaced; a file that may not be written is not replaced either.
 * A device or a pipe is written as it is. */
typedef struct file_writer file_writer;
int norma_file_writer_open(const char *path, file_writer **writer);
/* What is replaced must be the file of this stamp, unchanged: else commit fails with FILE_CHANGED,
 * or FILE_IN_USE while another writer replaces it. Once replaced, *stamp is that of the new one. It
 * must outlive the writer. */
void norma_file_writer_expect(file_writer *writer, file_stamp *stamp);
/* The same, with a stamp of its own, and without a lock where the file was closed early: for one of
 * thousands of files. */
void norma_file_writer_expect_once(file_writer *writer, const file_stamp *stamp);
/* One of many files that are committed together: its bytes are flushed with theirs, before the
 * first is renamed. alone: no other file names it, so its folder is flushed when all are in place.
 */
void norma_file_writer_batch(file_writer *writer, int alone);
/* Whether both hold the same bytes and go to the same file: then one of them is enough. Returns 0:
 * they go elsewhere; 1: the same; 2: the same file, other bytes, or bytes that cannot be read
 * again.
 */
int norma_file_writers_meet(file_writer *a, file_writer *b);
int norma_file_writer_write(file_writer *writer, const void *bytes, size_t size);
/* Gives the temporary file a name at once, for other processes that write it too. Returns 0 or
 * errno. */
int norma_file_writer_name(file_writer *writer);
/* The name of what would stay if the process ended now; NULL: nothing would. */
const char *norma_file_writer_temporary(const file_writer *writer);
/* What was written before, read again, or replaced by as many bytes. Not of a device or a pipe.
 * Return 0 or errno. */
int norma_file_writer_read(file_writer *writer, uint64_t offset, void *bytes, size_t size);
int norma_file_writer_patch(file_writer *writer, uint64_t offset, const void *bytes, size_t size);
int norma_file_writer_prepare(file_writer *writer);
int norma_file_writer_commit(
    file_writer *writer); /* frees the writer, also on failure (then the temporary file is gone) */
void norma_file_writer_abandon(file_writer *writer); /* frees; NULL is fine */
/* Several files: all are prepared and looked at before the first is renamed, and each is in its
 * place on the disk before the next one that may name it. After a failure those that were not there
 * before are gone again, and what was replaced is back, on file systems that have links; *failed is
 * the number of the one that failed. Frees all. */
int norma_file_writers_commit(file_writer **writers, size_t count, size_t *failed);

/* Makes a folder and sees to it that its name is on the disk; *made is 0 where it was there.
 * Returns 0 or errno. */
int norma_folder_make(const char *path, int *made);
/* The names in a folder, in no order, until visit returns something else than 0. Returns errno
 * where it cannot be read. */
int norma_folder_visit(const char *path, int (*visit)(void *user, const char *name), void *user);
void norma_folder_remove(const char *path); /* where it is empty; else it stays */

/* ---- Stamps from what the system says of a file. */

struct stat;
file_stamp norma_file_stamp_of(const struct stat *status);

/* ---- A file read piece by piece, for those that are larger than memory. */

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
