/* memory_files.c: the files of a page. Those that somebody dropped on it lie in memory under their
 * paths from the folder that was dropped, "/"; io reads them there, and what it writes is kept
 * beside them until the page has handed it out. One set of files at a time. */
#include "io/file/file.h"
#include "../../package/wasm/exports.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

typedef struct kept_file {
    char *path;
    unsigned char *bytes;
    size_t size;
    int written; /* by io */
} kept_file;

struct file_writer {
    kept_file file;
    size_t capacity;
};

static kept_file *files;
static size_t file_count;

/* Paths begin at the folder "/", whether they say so or not. */
static const char *plain(const char *path) {
    while (path[0] == '/' || (path[0] == '.' && path[1] == '/')) ++path;
    return path[0] == '.' && path[1] == '\0' ? path + 1 : path;
}

static kept_file *find(const char *path) {
    for (size_t i = 0; i < file_count; ++i)
        if (strcmp(files[i].path, plain(path)) == 0) return &files[i];
    return NULL;
}

/* Whether some file lies below a path. */
static int is_folder(const char *path) {
    const size_t length = strlen(plain(path));
    int found = length == 0;
    for (size_t i = 0; i < file_count && !found; ++i)
        found = strncmp(files[i].path, plain(path), length) == 0 && files[i].path[length] == '/';
    return found;
}

static char *copy_text(const char *text) {
    char *copy = malloc(strlen(text) + 1);
    return copy ? strcpy(copy, text) : NULL;
}

/* Takes the file over, in place of one of that name. */
static int keep(kept_file file) {
    kept_file *old = find(file.path);
    if (!old) {
        kept_file *grown = realloc(files, (file_count + 1) * sizeof *files);
        if (!grown) return ENOMEM;
        files = grown;
        old = &files[file_count++];
    } else {
        free(old->path);
        free(old->bytes);
    }
    *old = file;
    return 0;
}

/* ---- the page's side */

void WEB_EXPORT(files_clear)(void) {
    for (size_t i = 0; i < file_count; ++i) {
        free(files[i].path);
        free(files[i].bytes);
    }
    file_count = 0;
}

/* bytes: allocated; taken over. 0: out of memory. */
int WEB_EXPORT(files_add)(const char *path, unsigned char *bytes, size_t size) {
    kept_file file = {copy_text(plain(path)), bytes, size, 0};
    if (file.path && !keep(file)) return 1;
    free(file.path);
    free(bytes);
    return 0;
}

size_t WEB_EXPORT(files_count)(void) { return file_count; }
const char *WEB_EXPORT(files_path)(size_t i) { return files[i].path; }
const unsigned char *WEB_EXPORT(files_bytes)(size_t i) { return files[i].bytes; }
size_t WEB_EXPORT(files_size)(size_t i) { return files[i].size; }
int WEB_EXPORT(files_written)(size_t i) { return files[i].written; }

/* Forgets what io wrote. */
void WEB_EXPORT(files_drop_written)(void) {
    size_t kept = 0;
    for (size_t i = 0; i < file_count; ++i) {
        if (files[i].written) {
            free(files[i].path);
            free(files[i].bytes);
        } else {
            files[kept++] = files[i];
        }
    }
    file_count = kept;
}

/* ---- reading */

int norma_file_open(const char *path, const file_reading *how, file_bytes *bytes) {
    static const unsigned char nothing[1];
    const kept_file *file = find(path);
    (void)how;
    *bytes = (file_bytes){0};
    if (!file) return is_folder(path) ? EISDIR : ENOENT;
    bytes->data = file->bytes ? file->bytes : nothing;
    bytes->size = file->size;
    return 0;
}
void norma_file_close(file_bytes *bytes) { *bytes = (file_bytes){0}; }
int norma_file_has_changed(const char *path, const file_stamp *stamp) {
    return (void)path, (void)stamp, 0;
}
int norma_file_same(const char *a, const char *b) { return strcmp(plain(a), plain(b)) == 0; }
int norma_file_is_stream(const char *path) { return (void)path, 0; }
int norma_file_is_regular(const char *path) { return find(path) != NULL; }
int norma_file_is_link(const char *path) { return (void)path, 0; }
int norma_file_is_unchanged(const char *path, const file_stamp *stamp) {
    return (void)path, (void)stamp, 1;
}

int stat(const char *restrict path, struct stat *restrict status) {
    const kept_file *file = find(path);
    memset(status, 0, sizeof *status);
    if (!file && !is_folder(path)) return errno = ENOENT, -1;
    status->st_mode = file ? S_IFREG : S_IFDIR;
    status->st_size = file ? (off_t)file->size : 0;
    return 0;
}
int lstat(const char *restrict path, struct stat *restrict status) { return stat(path, status); }

/* resolved is NULL wherever io calls this. */
char *realpath(const char *restrict path, char *restrict resolved) {
    (void)resolved;
    if (!find(path) && !is_folder(path)) return errno = ENOENT, NULL;
    char *real = malloc(strlen(plain(path)) + 2);
    if (!real) return errno = ENOMEM, NULL;
    real[0] = '/';
    return strcpy(real + 1, plain(path)), real;
}

/* ---- writing */

int norma_file_writer_open(const char *path, file_writer **writer) {
    *writer = calloc(1, sizeof **writer);
    if (!*writer) return ENOMEM;
    (*writer)->file.path = copy_text(plain(path));
    (*writer)->file.written = 1;
    if ((*writer)->file.path) return 0;
    free(*writer);
    return ENOMEM;
}
int norma_file_writer_write(file_writer *writer, const void *bytes, size_t size) {
    kept_file *file = &writer->file;
    if (size > SIZE_MAX / 4 - file->size) return EFBIG;
    if (file->size + size > writer->capacity) {
        const size_t capacity = 2 * (file->size + size);
        unsigned char *grown = realloc(file->bytes, capacity);
        if (!grown) return ENOMEM;
        file->bytes = grown;
        writer->capacity = capacity;
    }
    if (size) memcpy(file->bytes + file->size, bytes, size);
    file->size += size;
    return 0;
}
int norma_file_writer_prepare(file_writer *writer) { return (void)writer, 0; }
void norma_file_writer_expect(file_writer *writer, file_stamp *stamp) { (void)writer, (void)stamp; }
void norma_file_writer_batch(file_writer *writer, int alone) { (void)writer, (void)alone; }
void norma_file_writer_expect_once(file_writer *writer, const file_stamp *stamp) {
    (void)writer, (void)stamp;
}
void norma_file_writer_abandon(file_writer *writer) {
    if (!writer) return;
    free(writer->file.path);
    free(writer->file.bytes);
    free(writer);
}
int norma_file_writer_commit(file_writer *writer) {
    const int failed = keep(writer->file);
    if (failed)
        norma_file_writer_abandon(writer);
    else
        free(writer);
    return failed;
}
int norma_file_writers_commit(file_writer **writers, size_t count, size_t *failed) {
    int error = 0;
    for (size_t i = 0; i < count; ++i) {
        if (error) {
            norma_file_writer_abandon(writers[i]);
        } else {
            *failed = i;
            error = norma_file_writer_commit(writers[i]);
        }
    }
    return error;
}
int norma_folder_make(const char *path, int *made) { return (void)path, *made = 0, 0; }
int norma_folder_visit(const char *path, int (*visit)(void *user, const char *name), void *user) {
    return (void)path, (void)visit, (void)user, ENOSYS;
}
void norma_folder_remove(const char *path) { (void)path; }
