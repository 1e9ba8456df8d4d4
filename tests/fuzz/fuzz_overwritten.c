/* fuzz_overwritten.c: another program changes a file while a command reads it: at the n-th call of
 * the system that opens, looks at or reads a file it is overwritten, cut short, made longer,
 * replaced or deleted. The command is refused, or what it writes can be read. */
#define _GNU_SOURCE
#include "command_scene.h"
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* One for this process and its children: the tool does each of several files in a child, and what
 * happened there has happened. */
static struct {
    uint32_t left; /* calls until it happens; 0: it does not */
    uint32_t way;
    const char *path;
    int done;
} * intruder;

int __real_open(const char *path, int flags, ...);
ssize_t __real_read(int file, void *bytes, size_t size);
ssize_t __real_pread(int file, void *bytes, size_t size, off_t at);
int __real_stat(const char *path, struct stat *status);
int __real_fstat(int file, struct stat *status);
int __wrap_open(const char *path, int flags, ...);
ssize_t __wrap_read(int file, void *bytes, size_t size);
ssize_t __wrap_pread(int file, void *bytes, size_t size, off_t at);
int __wrap_stat(const char *path, struct stat *status);
int __wrap_fstat(int file, struct stat *status);

static void overwrite(const char *path, int flags, size_t size) {
    static const char other[] =
        "v 9 9 9\nf 1 1 1\n{\"asset\":{\"version\":\"2.0\"},\"meshes\":7}\n3 9 9 9\n";
    const int file = __real_open(path, O_WRONLY | O_CREAT | flags, 0666);
    for (size_t at = 0; file >= 0 && at < size; at += sizeof other - 1)
        if (write(file, other, size - at < sizeof other - 1 ? size - at : sizeof other - 1) < 0)
            break;
    if (file >= 0) close(file);
}

static void intrude(void) {
    struct stat status;
    if (!intruder || intruder->left == 0 || --intruder->left > 0 ||
        __real_stat(intruder->path, &status))
        return;
    intruder->done = 1;
    switch (intruder->way % 6) {
    case 0:
        overwrite(intruder->path, 0, (size_t)status.st_size);
        break;
    case 1:
        if (truncate(intruder->path, status.st_size / 2)) fuzz_fail("cannot be cut short");
        break;
    case 2:
        overwrite(intruder->path, O_APPEND, 100);
        break;
    case 3:
        overwrite("other.tmp", O_TRUNC, (size_t)status.st_size);
        if (rename("other.tmp", intruder->path)) fuzz_fail("cannot be replaced");
        break;
    case 4:
        unlink(intruder->path);
        break;
    default:
        unlink(intruder->path);
        if (symlink("/dev/zero", intruder->path)) fuzz_fail("no link");
    }
}

int __wrap_open(const char *path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    intrude();
    return __real_open(path, flags, mode);
}

ssize_t __wrap_read(int file, void *bytes, size_t size) {
    intrude();
    return __real_read(file, bytes, size);
}

ssize_t __wrap_pread(int file, void *bytes, size_t size, off_t at) {
    intrude();
    return __real_pread(file, bytes, size, at);
}

int __wrap_stat(const char *path, struct stat *status) {
    intrude();
    return __real_stat(path, status);
}

int __wrap_fstat(int file, struct stat *status) {
    intrude();
    return __real_fstat(file, status);
}

/* What was written is whole: it can be opened, unless what it names beside it is what was
 * disturbed: NULL, or that. */
static void read_output(const command *c, const char *disturbed) {
    norma_document *document;
    norma_document_error error = {0};
    struct stat status;
    if (!c->output || norma_file_format_of_path(c->output) == NORMA_FILE_UNKNOWN ||
        strcmp(c->verb, "check") == 0 || stat(c->output, &status) ||
        strncmp(c->output, "new.", 4) != 0)
        return;
    const norma_document_result result = norma_document_open(c->output, NULL, &document, &error);
    if (result && disturbed && strstr(error.message, disturbed)) return;
    if (result) fuzz_fail("what was written cannot be read: %s", error.message);
    norma_document_close(document);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fuzz_bytes rest = {bytes, size};
    command c;
    const uint32_t left = 1 + fuzz_below(&rest, 96);
    const char *path = fuzz_scene_files[fuzz_below(&rest, FUZZ_SCENE_FILES)];
    if (!intruder)
        intruder =
            mmap(NULL, sizeof *intruder, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (intruder == MAP_FAILED) fuzz_fail("no shared memory");
    fuzz_meter_begin(1 << 16);
    intruder->left = 0;
    intruder->done = 0;
    intruder->way = fuzz_u8(&rest);
    fuzz_scene_make(&rest);
    fuzz_command_take(&rest, &c);
    scene_state *before = fuzz_scene_look();
    intruder->path = path;
    intruder->left = left;
    const int status = fuzz_command_run(&c);
    intruder->left = 0;
    scene_state *after = fuzz_scene_look();
    fuzz_scene_judge(before, after, &c, status, intruder->done ? path : NULL);
    if (status == 0) read_output(&c, intruder->done ? path : NULL);
    fuzz_scene_forget(before);
    fuzz_scene_forget(after);
    fuzz_scene_leave();
    fuzz_meter_end();
    return 0;
}
