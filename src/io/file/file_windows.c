/* file_windows.c: file_read.c and file_write.c for Windows. Paths are UTF-8.
 *
 * Files are read whole, never mapped: a mapped file could not be replaced. Writing goes to a
 * temporary file beside the target, which is flushed (FlushFileBuffers) and moved over it
 * (MoveFileEx with MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH, which returns when the move
 * is on the disk). */
#define WIN32_LEAN_AND_MEAN
#include "io/file/file.h"
#include <windows.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BUFFER_SIZE = 1 << 18, FIRST_READ = 1 << 16, MOST_NAMES = 10000, AT_ONCE = 1 << 24 };

static int windows_error_of(DWORD error) {
    static const struct {
        DWORD system;
        int error;
    } known[] = {
        {ERROR_FILE_NOT_FOUND, ENOENT},
        {ERROR_PATH_NOT_FOUND, ENOENT},
        {ERROR_INVALID_NAME, ENOENT},
        {ERROR_ACCESS_DENIED, EACCES},
        {ERROR_SHARING_VIOLATION, EBUSY},
        {ERROR_FILE_EXISTS, EEXIST},
        {ERROR_ALREADY_EXISTS, EEXIST},
        {ERROR_DISK_FULL, ENOSPC},
        {ERROR_HANDLE_DISK_FULL, ENOSPC},
        {ERROR_WRITE_PROTECT, EROFS},
        {ERROR_BROKEN_PIPE, EPIPE},
        {ERROR_NO_DATA, EPIPE},
        {ERROR_FILENAME_EXCED_RANGE, ENAMETOOLONG},
        {ERROR_DIRECTORY, ENOTDIR},
        {ERROR_NOT_ENOUGH_MEMORY, ENOMEM},
        {ERROR_OUTOFMEMORY, ENOMEM},
        {ERROR_TOO_MANY_OPEN_FILES, EMFILE},
    };
    for (size_t i = 0; i < sizeof known / sizeof *known; ++i)
        if (known[i].system == error) return known[i].error;
    return EIO;
}

/* NULL: out of memory, or no UTF-8. */
static wchar_t *wide(const char *path) {
    const int count = MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path, -1, NULL, 0);
    wchar_t *out = count > 0 ? malloc((size_t)count * sizeof *out) : NULL;
    if (out) MultiByteToWideChar(CP_UTF8, MB_ERR_INVALID_CHARS, path, -1, out, count);
    return out;
}

static int open_handle(const char *path, DWORD access, DWORD share, DWORD how, HANDLE *handle) {
    wchar_t *name = wide(path);
    *handle = INVALID_HANDLE_VALUE;
    if (!name) return EINVAL;
    *handle = CreateFileW(name, access, share, NULL, how,
        FILE_ATTRIBUTE_NORMAL | (how == OPEN_EXISTING ? FILE_FLAG_BACKUP_SEMANTICS : 0), NULL);
    const DWORD error = GetLastError();
    free(name);
    return *handle == INVALID_HANDLE_VALUE ? windows_error_of(error) : 0;
}

/* ---- what a file is */

/* 0: it is no file of a disk. */
static int information(HANDLE handle, BY_HANDLE_FILE_INFORMATION *info) {
    return GetFileType(handle) == FILE_TYPE_DISK && GetFileInformationByHandle(handle, info);
}

static uint64_t joined_halves(DWORD high, DWORD low) { return (uint64_t)high << 32 | low; }

static file_stamp stamp_of(const BY_HANDLE_FILE_INFORMATION *info) {
    const uint64_t ticks = joined_halves(info->ftLastWriteTime.dwHighDateTime,
        info->ftLastWriteTime.dwLowDateTime); /* of 100 nanoseconds */
    return (file_stamp){.device = info->dwVolumeSerialNumber,
        .inode = joined_halves(info->nFileIndexHigh, info->nFileIndexLow),
        .size = joined_halves(info->nFileSizeHigh, info->nFileSizeLow),
        .seconds = (int64_t)(ticks / 10000000),
        .nanoseconds = (int64_t)(ticks % 10000000) * 100,
        .known = !(info->dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY)};
}

static int windows_stamp_path(const char *path, file_stamp *stamp) {
    HANDLE handle;
    BY_HANDLE_FILE_INFORMATION info;
    if (open_handle(path, 0, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, OPEN_EXISTING,
            &handle))
        return 0;
    const int is_known = information(handle, &info);
    CloseHandle(handle);
    if (is_known) *stamp = stamp_of(&info);
    return is_known;
}

static int windows_is_same_file(const file_stamp *a, const file_stamp *b) {
    return a->device == b->device && a->inode == b->inode;
}

static int are_equal(const file_stamp *a, const file_stamp *b) {
    return windows_is_same_file(a, b) && a->size == b->size && a->seconds == b->seconds &&
           a->nanoseconds == b->nanoseconds;
}

int norma_file_has_changed(const char *path, const file_stamp *stamp) {
    file_stamp now;
    return stamp->known && windows_stamp_path(path, &now) && now.known &&
           windows_is_same_file(&now, stamp) && !are_equal(&now, stamp);
}

int norma_file_is_unchanged(const char *path, const file_stamp *stamp) {
    file_stamp now;
    return windows_stamp_path(path, &now) && now.known && are_equal(&now, stamp);
}

int norma_file_same(const char *a, const char *b) {
    file_stamp of_a, of_b;
    return strcmp(a, b) == 0 || (windows_stamp_path(a, &of_a) && windows_stamp_path(b, &of_b) &&
                                    windows_is_same_file(&of_a, &of_b));
}

int norma_file_is_stream(const char *path) {
    HANDLE handle;
    if (open_handle(path, 0, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, OPEN_EXISTING,
            &handle))
        return 0;
    const int is_stream = GetFileType(handle) != FILE_TYPE_DISK;
    CloseHandle(handle);
    return is_stream;
}

static DWORD attributes_of(const char *path) {
    wchar_t *name = wide(path);
    const DWORD attributes = name ? GetFileAttributesW(name) : INVALID_FILE_ATTRIBUTES;
    free(name);
    return attributes;
}

int norma_file_is_regular(const char *path) {
    return !(attributes_of(path) & FILE_ATTRIBUTE_DIRECTORY) && !norma_file_is_stream(path);
}

int norma_file_is_link(const char *path) {
    const DWORD attributes = attributes_of(path);
    return attributes != INVALID_FILE_ATTRIBUTES && attributes & FILE_ATTRIBUTE_REPARSE_POINT;
}

/* ---- reading */

static int windows_read_to_end(
    HANDLE handle, uint64_t expected, const file_reading *how, file_bytes *bytes) {
    if (expected >= SIZE_MAX / 2) return EFBIG;
    size_t capacity = expected ? (size_t)expected + 1 : FIRST_READ, size = 0;
    unsigned char *data = malloc(capacity);
    while (data) {
        DWORD got = 0;
        if (size == capacity) {
            unsigned char *larger = capacity > SIZE_MAX / 2 ? NULL : realloc(data, capacity *= 2);
            if (!larger) break;
            data = larger;
        }
        if (!ReadFile(handle, data + size,
                (DWORD)(capacity - size < AT_ONCE ? capacity - size : AT_ONCE), &got, NULL) &&
            GetLastError() != ERROR_BROKEN_PIPE) {
            const int error = windows_error_of(GetLastError());
            free(data);
            return error;
        }
        if (how && how->progress && how->progress(how->progress_user, 0)) {
            free(data);
            return FILE_CANCELLED;
        }
        if (got == 0) {
            *bytes = (file_bytes){.data = data, .size = size, .owned = 1};
            return 0;
        }
        size += got;
    }
    free(data);
    return ENOMEM;
}

int norma_file_open(const char *path, const file_reading *how, file_bytes *bytes) {
    HANDLE handle;
    BY_HANDLE_FILE_INFORMATION info, after;
    *bytes = (file_bytes){0};
    int error = open_handle(path, GENERIC_READ,
        FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, OPEN_EXISTING, &handle);
    if (error) return error;
    const int is_file = information(handle, &info);
    const file_stamp before = is_file ? stamp_of(&info) : (file_stamp){0};
    error = !is_file        ? FILE_NOT_REGULAR
            : !before.known ? EISDIR
                            : windows_read_to_end(handle, before.size, how, bytes);
    if (!error && information(handle, &after)) {
        const file_stamp now = stamp_of(&after);
        bytes->stamp = before;
        error = are_equal(&before, &now) ? 0 : FILE_CHANGED;
    }
    CloseHandle(handle);
    if (error) norma_file_close(bytes);
    return error;
}

void norma_file_close(file_bytes *bytes) {
    if (bytes->owned) free((void *)(uintptr_t)bytes->data);
    *bytes = (file_bytes){0};
}

/* ---- writing */

struct file_writer {
    HANDLE handle;
    char *target, *temporary; /* temporary NULL: a device or a pipe, written as it is */
    int error, replaces, placed;
    file_stamp *expected, own_stamp;
    size_t used;
    unsigned char buffer[BUFFER_SIZE];
};

static size_t windows_folder_length(const char *path) {
    size_t length = strlen(path);
    while (length > 0 && path[length - 1] != '/' && path[length - 1] != '\\' &&
           path[length - 1] != ':')
        --length;
    return length;
}

static char *windows_join(const char *path, size_t folder, const char *name) {
    const size_t length = strlen(name);
    char *joined = malloc(folder + length + 1);
    if (joined) {
        memcpy(joined, path, folder);
        memcpy(joined + folder, name, length + 1);
    }
    return joined;
}

static int windows_open_temporary(file_writer *writer) {
    int error = EEXIST;
    for (unsigned number = 0; number < MOST_NAMES && error == EEXIST; ++number) {
        char name[64];
        snprintf(
            name, sizeof name, ".norma-%lu-%u.tmp", (unsigned long)GetCurrentProcessId(), number);
        char *temporary = windows_join(writer->target, windows_folder_length(writer->target), name);
        if (!temporary) return ENOMEM;
        error = open_handle(temporary, GENERIC_READ | GENERIC_WRITE | DELETE,
            FILE_SHARE_READ | FILE_SHARE_DELETE, CREATE_NEW, &writer->handle);
        if (error)
            free(temporary);
        else
            writer->temporary = temporary;
    }
    return error;
}

static int windows_open_target(file_writer *writer) {
    file_stamp old;
    wchar_t *name = wide(writer->target);
    if (!name) return EINVAL;
    const DWORD attributes = GetFileAttributesW(name);
    free(name);
    if (norma_file_is_stream(writer->target))
        return open_handle(writer->target, GENERIC_WRITE, FILE_SHARE_READ | FILE_SHARE_WRITE,
            OPEN_EXISTING, &writer->handle);
    writer->replaces = windows_stamp_path(writer->target, &old);
    if (writer->replaces && !old.known) return EISDIR;
    return attributes != INVALID_FILE_ATTRIBUTES && attributes & FILE_ATTRIBUTE_READONLY
               ? EACCES
               : windows_open_temporary(writer);
}

int norma_file_writer_open(const char *path, file_writer **writer) {
    *writer = NULL;
    file_writer *made = calloc(1, sizeof *made);
    if (!made) return ENOMEM;
    made->handle = INVALID_HANDLE_VALUE;
    made->target = windows_join(path, 0, path);
    const int error = made->target ? windows_open_target(made) : ENOMEM;
    if (error)
        norma_file_writer_abandon(made);
    else
        *writer = made;
    return error;
}

void norma_file_writer_expect(file_writer *writer, file_stamp *stamp) {
    writer->expected = stamp->known ? stamp : NULL;
}

void norma_file_writer_expect_once(file_writer *writer, const file_stamp *stamp) {
    writer->own_stamp = *stamp;
    norma_file_writer_expect(writer, &writer->own_stamp);
}

void norma_file_writer_batch(file_writer *writer, int alone) { (void)writer, (void)alone; }

int norma_file_writers_meet(file_writer *a, file_writer *b) {
    return strcmp(a->target, b->target) == 0 ? 2 : 0;
}

static int windows_write_all(file_writer *writer, const unsigned char *bytes, size_t size) {
    while (size > 0 && !writer->error) {
        DWORD written = 0;
        if (!WriteFile(
                writer->handle, bytes, (DWORD)(size < AT_ONCE ? size : AT_ONCE), &written, NULL))
            writer->error = windows_error_of(GetLastError());
        else if (written == 0)
            writer->error = EIO;
        bytes += written;
        size -= written;
    }
    return writer->error;
}

static int windows_flush_buffer(file_writer *writer) {
    const size_t used = writer->used;
    writer->used = 0;
    return windows_write_all(writer, writer->buffer, used);
}

int norma_file_writer_write(file_writer *writer, const void *bytes, size_t size) {
    if (writer->error || size == 0) return writer->error;
    if (size > BUFFER_SIZE - writer->used && windows_flush_buffer(writer)) return writer->error;
    if (size >= BUFFER_SIZE) return windows_write_all(writer, bytes, size);
    memcpy(writer->buffer + writer->used, bytes, size);
    writer->used += size;
    return 0;
}

static OVERLAPPED windows_place_of(uint64_t offset) {
    return (OVERLAPPED){.Offset = (DWORD)offset, .OffsetHigh = (DWORD)(offset >> 32)};
}

/* All of them, at an offset; 0, an error, or short_error at the end of the file. */
static int read_at(HANDLE handle, uint64_t offset, void *bytes, size_t size, int short_error) {
    for (unsigned char *at = bytes; size > 0;) {
        OVERLAPPED place = windows_place_of(offset);
        DWORD got = 0;
        if (!ReadFile(handle, at, (DWORD)(size < AT_ONCE ? size : AT_ONCE), &got, &place))
            return GetLastError() == ERROR_HANDLE_EOF ? short_error
                                                      : windows_error_of(GetLastError());
        if (got == 0) return short_error;
        at += got;
        offset += got;
        size -= got;
    }
    return 0;
}

/* A file that is written through one handle has one place in it: what is at an offset moves that
 * place, which then returns to the end. */
static void return_to_end(HANDLE handle) {
    SetFilePointerEx(handle, (LARGE_INTEGER){0}, NULL, FILE_END);
}

int norma_file_writer_read(file_writer *writer, uint64_t offset, void *bytes, size_t size) {
    if (windows_flush_buffer(writer)) return writer->error;
    const int error = read_at(writer->handle, offset, bytes, size, EIO);
    return_to_end(writer->handle);
    return error;
}

int norma_file_writer_patch(file_writer *writer, uint64_t offset, const void *bytes, size_t size) {
    if (windows_flush_buffer(writer)) return writer->error;
    OVERLAPPED place = windows_place_of(offset);
    DWORD written = 0;
    if (!WriteFile(writer->handle, bytes, (DWORD)size, &written, &place) || written != size)
        writer->error = written ? EIO : windows_error_of(GetLastError());
    return_to_end(writer->handle);
    return writer->error;
}

int norma_file_writer_name(file_writer *writer) { return (void)writer, 0; }

const char *norma_file_writer_temporary(const file_writer *writer) { return writer->temporary; }

int norma_file_writer_prepare(file_writer *writer) {
    if (!writer->error && !windows_flush_buffer(writer) && writer->temporary &&
        !FlushFileBuffers(writer->handle))
        writer->error = windows_error_of(GetLastError());
    return writer->error;
}

static int look_at_expected(file_writer *writer) {
    return !writer->expected || norma_file_is_unchanged(writer->target, writer->expected)
               ? 0
               : FILE_CHANGED;
}

static int windows_put_in_place(file_writer *writer) {
    const HANDLE handle = writer->handle;
    writer->handle = INVALID_HANDLE_VALUE;
    if (!CloseHandle(handle)) return windows_error_of(GetLastError());
    if (!writer->temporary) return 0;
    wchar_t *from = wide(writer->temporary), *to = wide(writer->target);
    int error = !from || !to ? ENOMEM
                : MoveFileExW(from, to, MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH)
                    ? 0
                    : windows_error_of(GetLastError());
    free(from);
    free(to);
    if (error) return error;
    free(writer->temporary);
    writer->temporary = NULL;
    writer->placed = 1;
    if (writer->expected && !windows_stamp_path(writer->target, writer->expected))
        writer->expected->known = 0;
    return 0;
}

static void remove_file(const char *path) {
    wchar_t *name = wide(path);
    if (name) DeleteFileW(name);
    free(name);
}

int norma_file_writers_commit(file_writer **writers, size_t count, size_t *failed) {
    static int (*const steps[])(file_writer *) = {
        norma_file_writer_prepare, look_at_expected, windows_put_in_place};
    size_t done = 0;
    int error = 0;
    for (size_t step = 0; step < sizeof steps / sizeof *steps && !error; ++step)
        for (done = 0; done < count && !(error = steps[step](writers[done]));) ++done;
    *failed = done;
    for (size_t i = 0; error && i < count; ++i)
        if (writers[i]->placed && !writers[i]->replaces) remove_file(writers[i]->target);
    for (size_t i = 0; i < count; ++i) norma_file_writer_abandon(writers[i]);
    return error;
}

int norma_file_writer_commit(file_writer *writer) {
    size_t failed;
    return norma_file_writers_commit(&writer, 1, &failed);
}

void norma_file_writer_abandon(file_writer *writer) {
    if (!writer) return;
    if (writer->handle != INVALID_HANDLE_VALUE) CloseHandle(writer->handle);
    if (writer->temporary) remove_file(writer->temporary);
    free(writer->temporary);
    free(writer->target);
    free(writer);
}

/* ---- files read piece by piece */

struct file_window {
    HANDLE handle;
    file_stamp stamp;
};

int norma_window_open(const char *path, file_window **window) {
    BY_HANDLE_FILE_INFORMATION info;
    file_window *made = calloc(1, sizeof *made);
    *window = NULL;
    if (!made) return ENOMEM;
    int error = open_handle(path, GENERIC_READ,
        FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, OPEN_EXISTING, &made->handle);
    if (!error && !information(made->handle, &info)) error = FILE_NOT_REGULAR;
    if (!error) made->stamp = stamp_of(&info);
    if (!error && !made->stamp.known) error = EISDIR;
    if (error)
        norma_window_close(made);
    else
        *window = made;
    return error;
}

void norma_window_close(file_window *window) {
    if (!window) return;
    if (window->handle != INVALID_HANDLE_VALUE) CloseHandle(window->handle);
    free(window);
}

const file_stamp *norma_window_stamp(const file_window *window) { return &window->stamp; }

int norma_window_read(const file_window *window, uint64_t offset, void *bytes, size_t size) {
    return read_at(window->handle, offset, bytes, size, FILE_CHANGED);
}

int norma_window_has_changed(const file_window *window) {
    BY_HANDLE_FILE_INFORMATION info;
    if (!information(window->handle, &info)) return 1;
    const file_stamp now = stamp_of(&info);
    return !are_equal(&now, &window->stamp);
}

/* ---- folders */

int norma_folder_make(const char *path, int *made) {
    wchar_t *name = wide(path);
    *made = name && CreateDirectoryW(name, NULL);
    const DWORD error = *made || !name ? 0 : GetLastError();
    free(name);
    return !name ? EINVAL : error && error != ERROR_ALREADY_EXISTS ? windows_error_of(error) : 0;
}

int norma_folder_visit(const char *path, int (*visit)(void *user, const char *name), void *user) {
    WIN32_FIND_DATAW entry;
    char name[4 * MAX_PATH];
    char *pattern = windows_join(path, strlen(path), "\\*");
    wchar_t *wide_pattern = pattern ? wide(pattern) : NULL;
    HANDLE found = wide_pattern ? FindFirstFileW(wide_pattern, &entry) : INVALID_HANDLE_VALUE;
    DWORD error = found == INVALID_HANDLE_VALUE ? GetLastError() : 0;
    free(wide_pattern);
    free(pattern);
    if (error) return windows_error_of(error);
    do {
        const int size =
            WideCharToMultiByte(CP_UTF8, 0, entry.cFileName, -1, name, sizeof name, NULL, NULL);
        if (size > 0 && visit(user, name)) break;
    } while (FindNextFileW(found, &entry) || (error = GetLastError(), 0));
    FindClose(found);
    return error && error != ERROR_NO_MORE_FILES ? windows_error_of(error) : 0;
}

void norma_folder_remove(const char *path) {
    wchar_t *name = wide(path);
    if (name) RemoveDirectoryW(name);
    free(name);
}
