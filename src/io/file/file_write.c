/* file_write.c: files that are written whole or not at all; the folders they go to; what they keep
 * of the files that they replace. */
#define _POSIX_C_SOURCE 200809L
#if defined(__linux__)
#define _GNU_SOURCE /* O_TMPFILE */
#endif
#define _DEFAULT_SOURCE /* flock */
#include "io/file/file.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- The folders that files go to: opened and flushed, so that names in them survive a crash,
 * made where they are missing, and taken away again. A folder that may not be read cannot be
 * flushed, and some file systems flush none: no reason to call a file unwritten. The descriptor is
 * -1 then. */

static int folder_open(const char *path, int *descriptor) {
    do *descriptor = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    while (*descriptor < 0 && errno == EINTR);
    return *descriptor < 0 && errno != EACCES && errno != EPERM ? errno : 0;
}

static int flush_descriptor(int descriptor) {
    int failed;
    do failed = fsync(descriptor);
    while (failed && errno == EINTR);
    return failed ? errno : 0;
}

static int folder_flush(int descriptor) {
    const int error = flush_descriptor(descriptor);
    return error == EINVAL || error == EBADF || error == ENOTSUP || error == EROFS ? 0 : error;
}

static size_t folder_length(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

/* The first folder bytes of path, then name; NULL: out of memory. */
static char *file_join(const char *path, size_t folder, const char *name) {
    size_t length = strlen(name);
    char *joined = malloc(folder + length + 1);
    if (!joined) return NULL;
    memcpy(joined, path, folder);
    memcpy(joined + folder, name, length + 1);
    return joined;
}

/* That of path, open. */
static int open_folder_of(const char *path, int *descriptor) {
    char *folder = file_join(path, folder_length(path), ".");
    const int error = folder ? folder_open(folder, descriptor) : ENOMEM;
    free(folder);
    return error;
}

static int flush_folder_of(const char *path) {
    int descriptor = -1, error = open_folder_of(path, &descriptor);
    if (!error && descriptor >= 0) error = folder_flush(descriptor);
    if (descriptor >= 0) close(descriptor);
    return error;
}

int norma_folder_make(const char *path, int *made) {
    *made = mkdir(path, 0777) == 0;
    if (!*made) return errno == EEXIST ? 0 : errno;
    const int error = flush_folder_of(path);
    if (error) {
        norma_folder_remove(path);
        *made = 0;
    }
    return error;
}

int norma_folder_visit(const char *path, int (*visit)(void *user, const char *name), void *user) {
    DIR *folder = opendir(path);
    const struct dirent *entry;
    if (!folder) return errno;
    errno = 0;
    while ((entry = readdir(folder)) && !visit(user, entry->d_name)) errno = 0;
    const int error = entry ? 0 : errno;
    closedir(folder);
    return error;
}

void norma_folder_remove(const char *path) { rmdir(path); }

/* ---- Who may read and write a file, and what is attached to it, carried from a file to
 * the one that takes its place.
 *
 * Where a file has an access control list (acl(5)), the group bits of its mode are the list's
 * mask: bits alone would take rights from the users that the list names and give them to the
 * group. On Linux lists are extended attributes (xattr(7)), and so are labels:
 *   system.posix_acl_access, system.nfs4_acl, user.*   kept, or the writer is not opened
 *   security.selinux                                   kept where the system lets us
 * The others vouch for the bytes that were there (security.ima, security.capability), or are of
 * the file system's own (trusted.*): a new file has none. */

#if defined(__linux__)
#include <sys/xattr.h>

static const char ACCESS_LIST[] = "system.posix_acl_access";

/* Most that Linux has of names, and of one value. */
enum { MOST_BYTES = 1 << 16 };

typedef struct attribute_copy {
    const char *from;
    int to, is_anothers;      /* its owner or group could not be kept */
    unsigned char *now, *old; /* values, of MOST_BYTES */
} attribute_copy;

static int is_missing(int error) {
    return error == ENODATA || error == ENOTSUP || error == EOPNOTSUPP || error == ENOSYS;
}

static int copy_one(const attribute_copy *copy, const char *name) {
    const ssize_t size = getxattr(copy->from, name, copy->old, MOST_BYTES);
    if (size < 0) return is_missing(errno) ? 0 : errno;
    if (copy->is_anothers && strcmp(name, ACCESS_LIST) == 0) return EPERM;
    const ssize_t there = fgetxattr(copy->to, name, copy->now, MOST_BYTES);
    if (there == size && memcmp(copy->now, copy->old, (size_t)size) == 0) return 0;
    return fsetxattr(copy->to, name, copy->old, (size_t)size, 0) ? errno : 0;
}

static int is_kept(const char *name) {
    return strncmp(name, "user.", 5) == 0 || strcmp(name, ACCESS_LIST) == 0 ||
           strcmp(name, "system.nfs4_acl") == 0;
}

static int copy_named(const attribute_copy *copy, const char *names, size_t size) {
    for (const char *name = names; name < names + size; name += strlen(name) + 1) {
        const int error =
            is_kept(name) || strcmp(name, "security.selinux") == 0 ? copy_one(copy, name) : 0;
        if (error && is_kept(name)) return error;
    }
    return 0;
}

/* A folder may have given its own list to the new file (acl(5), default ACLs). */
static int file_copy_attributes(const char *from, int to, int is_anothers) {
    if (fremovexattr(to, ACCESS_LIST) && !is_missing(errno)) return errno;
    if (listxattr(from, NULL, 0) <= 0) return 0;
    char *names = malloc(3 * (size_t)MOST_BYTES);
    if (!names) return ENOMEM;
    unsigned char *values = (unsigned char *)names + MOST_BYTES;
    const attribute_copy copy = {from, to, is_anothers, values, values + MOST_BYTES};
    const ssize_t size = listxattr(from, names, MOST_BYTES);
    const int error = size < 0 ? errno : copy_named(&copy, names, (size_t)size);
    free(names);
    return error;
}
#else
static int file_copy_attributes(const char *from, int to, int is_anothers) {
    return (void)from, (void)to, (void)is_anothers, 0;
}
#endif

/* Who writes into another's file becomes its owner, as with every program that replaces files. Then
 * the bits that lend the owner's rights go; where the group cannot be kept either, the writer's own
 * gets no more rights than everyone; and an access list, whose owner would lose his, is a reason to
 * refuse. */
static int file_keep_attributes(const char *from, const struct stat *old, int to) {
    mode_t mode = old->st_mode & 07777;
    const int is_anothers = fchown(to, old->st_uid, old->st_gid) != 0;
    if (is_anothers) {
        mode &= 0777;
        if (fchown(to, (uid_t)-1, old->st_gid)) mode &= (mode_t)(0707 | (mode & 07) << 3);
    }
    const int error = file_copy_attributes(from, to, is_anothers);
    if (!error) return fchmod(to, mode) ? errno : 0;
    return error == ENOMEM || error == ENOSPC || error == EDQUOT ? error : FILE_ATTRIBUTES;
}

/* ---- Files that are written whole or not at all.
 *
 * Writing goes to a temporary file beside the target, which is flushed and renamed over it (rename
 * is atomic in POSIX), and then the folder is flushed: whatever happens, a crash or a full disk,
 * the old file or the new one is whole. On Linux the temporary file has no name (open(2),
 * O_TMPFILE) until all of it is on the disk: what is stopped before leaves nothing. */

enum { BUFFER_SIZE = 1 << 18, MOST_LINKS = 40, MOST_NAMES = 10000, MANY_DESCRIPTORS = 100 };
static const size_t WRITE_AT_ONCE = (size_t)1 << 30; /* Linux writes at most 2 GiB in one call */

struct file_writer {
    int descriptor;
    int held;        /* the file that is to be replaced, locked against other writers; -1: none */
    int folder;      /* of the target; -1: not open, or may not be read */
    char *target;    /* where it goes: path with its symbolic links followed */
    char *temporary; /* NULL: has no name yet, or the target is a device or a pipe, written as it is
                      */
    int nameless, prepared, replaces, placed;
    int batch, alone; /* flushed with others; its folder, too */
    int error;        /* the first one; every later call returns it */
    file_stamp *expected, own_stamp;
    char *replaced; /* another name of what it takes the place of, until all are in place; NULL */
    size_t used;
    unsigned char *buffer; /* of BUFFER_SIZE */
};

/* ---- names */

/* Follows the symbolic links at the end of path, also to a file that is not there yet. */
static int file_resolve(const char *path, char **resolved) {
    char *current = file_join(path, 0, path), link[PATH_MAX + 1];
    for (int hops = 0; current; ++hops) {
        ssize_t length = readlink(current, link, PATH_MAX);
        if (length < 0) {
            *resolved = current;
            return 0; /* EINVAL: no link; anything else shows again when the file is made */
        }
        if (hops == MOST_LINKS) {
            free(current);
            return ELOOP;
        }
        link[length] = '\0';
        char *next = file_join(current, link[0] == '/' ? 0 : folder_length(current), link);
        free(current);
        current = next;
    }
    return ENOMEM;
}

/* A number of its own for most targets (FNV-1a), so that thousands of temporary files in one folder
 * do not try each other's names. */
static unsigned file_number_of(const char *target) {
    uint32_t hash = 2166136261u;
    for (; *target; ++target) hash = (hash ^ (unsigned char)*target) * 16777619u;
    return hash;
}

/* Tries one name after the other until one is free; make returns 0 or errno, and EEXIST or EINTR
 * for another try. */
static int name_temporary(file_writer *writer,
    int (*make)(file_writer *writer, const char *name, mode_t mode), mode_t mode) {
    int error = EEXIST;
    for (unsigned tries = 0; tries < MOST_NAMES && (error == EEXIST || error == EINTR); ++tries) {
        char name[64];
        snprintf(name, sizeof name, ".norma-%ld-%u.tmp", (long)getpid(),
            tries ? file_number_of(writer->target) + tries : 0);
        char *temporary = file_join(writer->target, folder_length(writer->target), name);
        error = temporary ? make(writer, temporary, mode) : ENOMEM;
        if (!error)
            writer->temporary = temporary;
        else
            free(temporary);
    }
    return error;
}

static int make_named(file_writer *writer, const char *name, mode_t mode) {
    writer->descriptor = open(name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
    return writer->descriptor < 0 ? errno : 0;
}

/* ---- temporary files without a name */

#if defined(O_TMPFILE)
static void name_of_descriptor(int descriptor, char name[48]) {
    snprintf(name, 48, "/proc/self/fd/%d", descriptor);
}

/* 0: not on this file system, or not without /proc. */
static int open_nameless(file_writer *writer, mode_t mode) {
    char name[48], *folder = file_join(writer->target, folder_length(writer->target), ".");
    if (!folder) return 0;
    writer->descriptor = open(folder, O_RDWR | O_TMPFILE | O_CLOEXEC, mode);
    free(folder);
    if (writer->descriptor < 0) return 0;
    name_of_descriptor(writer->descriptor, name);
    writer->nameless = access(name, F_OK) == 0;
    if (!writer->nameless) close(writer->descriptor);
    return writer->nameless;
}

static int make_link(file_writer *writer, const char *temporary, mode_t mode) {
    char name[48];
    (void)mode;
    name_of_descriptor(writer->descriptor, name);
    return linkat(AT_FDCWD, name, AT_FDCWD, temporary, AT_SYMLINK_FOLLOW) ? errno : 0;
}

static int file_write_all(file_writer *writer, const unsigned char *bytes, size_t size);

/* For a file system that gives no name to what it made without one: what was written is copied to a
 * file that has one. */
static int copy_to_named(file_writer *writer) {
    const int from = writer->descriptor;
    char name[48];
    struct stat status;
    if (fstat(from, &status)) return errno;
    name_of_descriptor(from, name);
    int error = name_temporary(writer, make_named, 0600);
    if (!error) error = file_keep_attributes(name, &status, writer->descriptor);
    for (off_t at = 0; !error && at < status.st_size;) {
        const ssize_t got = pread(from, writer->buffer, BUFFER_SIZE, at);
        if (got > 0) {
            error = file_write_all(writer, writer->buffer, (size_t)got);
            at += got;
        } else if (got == 0 || errno != EINTR) {
            error = got == 0 ? EIO : errno;
        }
    }
    if (!error) error = flush_descriptor(writer->descriptor);
    close(from);
    return error;
}

/* It must be on the disk before it has a name. */
static int give_name(file_writer *writer) {
    if (!writer->nameless) return 0;
    writer->nameless = 0;
    return name_temporary(writer, make_link, 0) ? copy_to_named(writer) : 0;
}
#else
static int open_nameless(file_writer *writer, mode_t mode) { return (void)writer, (void)mode, 0; }
static int give_name(file_writer *writer) { return (void)writer, 0; }
#endif

/* ---- opening */

static int open_temporary(file_writer *writer, mode_t mode) {
    return open_nameless(writer, mode) ? 0 : name_temporary(writer, make_named, mode);
}

static int open_target(file_writer *writer) {
    struct stat old;
    if (stat(writer->target, &old)) return errno == ENOENT ? open_temporary(writer, 0666) : errno;
    if (S_ISDIR(old.st_mode)) return EISDIR;
    if (access(writer->target, W_OK)) return errno;
    if (!S_ISREG(old.st_mode)) {
        do writer->descriptor = open(writer->target, O_WRONLY | O_CLOEXEC);
        while (writer->descriptor < 0 && errno == EINTR);
        return writer->descriptor < 0 ? errno : 0;
    }
    writer->replaces = 1;
    int error = open_temporary(writer, 0600);
    return error ? error : file_keep_attributes(writer->target, &old, writer->descriptor);
}

int norma_file_writer_open(const char *path, file_writer **writer) {
    *writer = NULL;
    file_writer *made = calloc(1, sizeof *made);
    if (!made) return ENOMEM;
    made->descriptor = made->held = made->folder = -1;
    /* The links of /proc/self/fd name no path that could be opened, so what is no regular file is
     * not resolved. */
    int error = norma_file_is_stream(path)
                    ? ((made->target = file_join(path, 0, path)) ? 0 : ENOMEM)
                    : file_resolve(path, &made->target);
    if (!error) error = (made->buffer = malloc(BUFFER_SIZE)) ? open_target(made) : ENOMEM;
    if (error) {
        norma_file_writer_abandon(made);
        return error;
    }
    *writer = made;
    return 0;
}

void norma_file_writer_expect(file_writer *writer, file_stamp *stamp) {
    writer->expected = stamp->known ? stamp : NULL;
}

void norma_file_writer_expect_once(file_writer *writer, const file_stamp *stamp) {
    writer->own_stamp = *stamp;
    norma_file_writer_expect(writer, &writer->own_stamp);
}

void norma_file_writer_batch(file_writer *writer, int alone) {
    writer->batch = 1;
    writer->alone = alone;
}

/* ---- writing */

static int file_write_all(file_writer *writer, const unsigned char *bytes, size_t size) {
    while (size > 0 && !writer->error) {
        ssize_t written =
            write(writer->descriptor, bytes, size < WRITE_AT_ONCE ? size : WRITE_AT_ONCE);
        if (written > 0) {
            bytes += written;
            size -= (size_t)written;
        } else if (written == 0) {
            writer->error = EIO;
        } else if (errno != EINTR) {
            writer->error =
                errno == EFAULT
                    ? FILE_CHANGED
                    : errno; /* EFAULT: bytes of a mapped file that has become shorter */
        }
    }
    return writer->error;
}

static int flush_buffer(file_writer *writer) {
    size_t used = writer->used;
    writer->used = 0;
    return file_write_all(writer, writer->buffer, used);
}

int norma_file_writer_write(file_writer *writer, const void *bytes, size_t size) {
    if (writer->error || size == 0) return writer->error;
    writer->prepared = 0;
    if (size > BUFFER_SIZE - writer->used && flush_buffer(writer)) return writer->error;
    if (size >= BUFFER_SIZE) return file_write_all(writer, bytes, size);
    memcpy(writer->buffer + writer->used, bytes, size);
    writer->used += size;
    return 0;
}

int norma_file_writer_name(file_writer *writer) { return writer->error = give_name(writer); }

const char *norma_file_writer_temporary(const file_writer *writer) { return writer->temporary; }

int norma_file_writer_read(file_writer *writer, uint64_t offset, void *bytes, size_t size) {
    if (flush_buffer(writer)) return writer->error;
    for (unsigned char *at = bytes; size > 0;) {
        const ssize_t got = pread(writer->descriptor, at, size, (off_t)offset);
        if (got < 0 && errno != EINTR) return errno;
        if (got == 0) return EIO;
        if (got < 0) continue;
        at += got;
        offset += (uint64_t)got;
        size -= (size_t)got;
    }
    return 0;
}

/* Through a map of the bytes that are there already. */
int norma_file_writer_patch(file_writer *writer, uint64_t offset, const void *bytes, size_t size) {
    const uint64_t alignment = 1 << 16, begin = offset / alignment * alignment;
    const size_t before = (size_t)(offset - begin);
    if (flush_buffer(writer)) return writer->error;
    writer->prepared = 0;
    void *map = mmap(
        NULL, before + size, PROT_READ | PROT_WRITE, MAP_SHARED, writer->descriptor, (off_t)begin);
    if (map == MAP_FAILED) return writer->error = errno;
    memcpy((unsigned char *)map + before, bytes, size);
    munmap(map, before + size);
    return 0;
}

/* An asset may name thousands of files, and a process may have a thousand open: from some number on
 * each is closed under its temporary name, to be renamed later. */
static int close_early(file_writer *writer) {
    const int stays = writer->expected && writer->expected != &writer->own_stamp;
    if (writer->descriptor < MANY_DESCRIPTORS || stays) return 0;
    const int error = give_name(writer), descriptor = writer->descriptor;
    if (error || !writer->temporary) return error;
    writer->descriptor = -1;
    free(writer->buffer);
    writer->buffer = NULL;
    return close(descriptor) && errno != EINTR ? errno : 0;
}

int norma_file_writer_prepare(file_writer *writer) {
    if (writer->error || writer->prepared || flush_buffer(writer)) return writer->error;
    if ((writer->nameless || writer->temporary) && !writer->batch)
        writer->error = flush_descriptor(writer->descriptor);
    if (!writer->error) writer->error = close_early(writer);
    writer->prepared = !writer->error;
    return writer->error;
}

/* ---- two that meet */

static int open_again(const file_writer *writer) {
    return writer->descriptor >= 0 ? dup(writer->descriptor)
                                   : open(writer->temporary, O_RDONLY | O_CLOEXEC);
}

static int same_bytes(int a, int b) {
    unsigned char of_a[4096], of_b[4096];
    for (off_t at = 0;; at += (off_t)sizeof of_a) {
        const ssize_t got = pread(a, of_a, sizeof of_a, at),
                      other = pread(b, of_b, sizeof of_b, at);
        if (got < 0 || got != other || memcmp(of_a, of_b, (size_t)got) != 0) return 0;
        if (got == 0) return 1;
    }
}

int norma_file_writers_meet(file_writer *a, file_writer *b) {
    if (strcmp(a->target, b->target) != 0) return 0;
    const int of_a = open_again(a), of_b = open_again(b),
              same = of_a >= 0 && of_b >= 0 && same_bytes(of_a, of_b);
    if (of_a >= 0) close(of_a);
    if (of_b >= 0) close(of_b);
    return same ? 1 : 2;
}

/* ---- into place */

/* Holds what is to be replaced against other writers like this one, and looks at it then: so of two
 * that have read it at once, the second one sees that it has gone. A file system without locks is
 * no reason to write nothing. */
static int hold_expected(file_writer *writer) {
    if (!writer->expected) return 0;
#if defined(LOCK_EX)
    if (writer->descriptor >= 0) writer->held = open(writer->target, O_RDONLY | O_CLOEXEC);
    if (writer->held >= 0 && flock(writer->held, LOCK_EX | LOCK_NB) && errno == EWOULDBLOCK)
        return FILE_IN_USE;
#endif
    return norma_file_is_unchanged(writer->target, writer->expected) ? 0 : FILE_CHANGED;
}

/* The new name must survive a crash as well. */
static int open_folder(file_writer *writer) {
    return writer->nameless || writer->temporary ? open_folder_of(writer->target, &writer->folder)
                                                 : 0;
}

static int open_folder_early(file_writer *writer) {
    return writer->descriptor >= 0 && !writer->alone ? open_folder(writer) : 0;
}

static int make_second_link(file_writer *writer, const char *name, mode_t mode) {
    (void)mode;
    return link(writer->target, name) ? errno : 0;
}

/* So that it can be put back. A file system without links keeps what was replaced so far. */
static void keep_replaced(file_writer *writer) {
    char *temporary = writer->temporary;
    if (!writer->replaces || !temporary) return;
    writer->temporary = NULL;
    if (name_temporary(writer, make_second_link, 0) == 0) writer->replaced = writer->temporary;
    writer->temporary = temporary;
}

static void put_back(file_writer *writer) {
    if (!writer->placed) return;
    if (!writer->replaces)
        unlink(writer->target);
    else if (writer->replaced && rename(writer->replaced, writer->target) == 0) {
        free(writer->replaced);
        writer->replaced = NULL;
    }
}

static int put_in_place(file_writer *writer) {
    struct stat status;
    const int descriptor = writer->descriptor;
    const int is_known = descriptor >= 0 && fstat(descriptor, &status) == 0;
    int error = descriptor >= 0 || writer->alone ? 0 : open_folder(writer);
    writer->descriptor = -1;
    if (descriptor >= 0 && close(descriptor) && errno != EINTR) error = errno;
    if (!error && rename(writer->temporary, writer->target)) error = errno;
    if (error) return error;
    free(writer->temporary);
    writer->temporary = NULL;
    writer->placed = 1;
    if (writer->expected && is_known) *writer->expected = norma_file_stamp_of(&status);
    if (writer->folder < 0) return 0;
    writer->error = folder_flush(writer->folder);
    close(writer->folder);
    writer->folder = -1;
    return writer->error ? FILE_NOT_FLUSHED : 0;
}

static int commit_one(file_writer *writer) {
    if (writer->temporary) return put_in_place(writer);
    int descriptor = writer->descriptor;
    writer->descriptor = -1;
    return close(descriptor) && errno != EINTR ? errno : 0;
}

/* ---- many at once */

static int flush_one(const file_writer *writer) {
    const int descriptor = writer->descriptor >= 0 ? writer->descriptor
                                                   : open(writer->temporary, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return errno;
    const int error = flush_descriptor(descriptor);
    if (descriptor != writer->descriptor) close(descriptor);
    return error;
}

/* All bytes of a batch. Where the system can flush a whole file system, that is once for each,
 * instead of once for each file. */
static int flush_batch(file_writer **writers, size_t count) {
    int error = 0;
#if defined(__linux__)
    dev_t device = 0;
    int flushed = 0;
#endif
    for (size_t i = 0; i < count && !error; ++i) {
        if (!writers[i]->batch || !writers[i]->temporary) continue;
#if defined(__linux__)
        struct stat status;
        const int descriptor = open(writers[i]->temporary, O_RDONLY | O_CLOEXEC);
        if (descriptor < 0 || fstat(descriptor, &status)) error = errno;
        if (!error && (!flushed || status.st_dev != device)) {
            error = syncfs(descriptor) ? errno : 0;
            device = status.st_dev;
            flushed = 1;
        }
        if (descriptor >= 0) close(descriptor);
        if (error == ENOSYS || error == EPERM) error = flush_one(writers[i]);
#else
        error = flush_one(writers[i]);
#endif
    }
    return error;
}

/* The folders of a batch, each once where files of a folder follow each other. */
static int flush_folders(file_writer **writers, size_t count) {
    const char *last = "";
    size_t last_length = 0;
    int error = 0;
    for (size_t i = 0; i < count && !error; ++i) {
        const char *target = writers[i]->target;
        const size_t length = folder_length(target);
        if (!writers[i]->alone ||
            (i > 0 && length == last_length && memcmp(target, last, length) == 0))
            continue;
        last = target;
        last_length = length;
        error = flush_folder_of(target);
    }
    return error ? FILE_NOT_FLUSHED : 0;
}

int norma_file_writers_commit(file_writer **writers, size_t count, size_t *failed) {
    /* Whatever could fail for want of room, memory or descriptors comes before the first is
     * renamed. */
    static int (*const steps[])(file_writer *) = {
        norma_file_writer_prepare, open_folder_early, hold_expected, give_name, commit_one};
    size_t done = 0;
    int error = 0;
    for (size_t step = 0; step < sizeof steps / sizeof *steps && !error; ++step) {
        if (steps[step] == commit_one) error = flush_batch(writers, count);
        for (done = 0; done < count && !error; ++done) {
            if (steps[step] == commit_one && done + 1 < count) keep_replaced(writers[done]);
            error = steps[step](writers[done]);
            if (error) break;
        }
    }
    if (done == count) done = count ? count - 1 : 0;
    if (!error) error = flush_folders(writers, count);
    *failed = done;
    /* All stays where only the last folder could not be flushed. */
    if (error && !writers[count - 1]->placed) {
        for (size_t i = count; i-- > 0;) put_back(writers[i]);
        if (error == FILE_NOT_FLUSHED) error = writers[done]->error; /* it is not there */
    }
    for (size_t i = 0; i < count; ++i) norma_file_writer_abandon(writers[i]);
    return error;
}

int norma_file_writer_commit(file_writer *writer) {
    size_t failed;
    return norma_file_writers_commit(&writer, 1, &failed);
}

/* Tried once more where it fails: some file systems report errors that pass, and nothing else would
 * remove the name. */
static void remove_name(const char *name) {
    if (name && unlink(name) && errno != ENOENT) unlink(name);
}

void norma_file_writer_abandon(file_writer *writer) {
    if (!writer) return;
    if (writer->descriptor >= 0) close(writer->descriptor);
    if (writer->held >= 0) close(writer->held);
    if (writer->folder >= 0) close(writer->folder);
    remove_name(writer->temporary);
    remove_name(writer->replaced);
    free(writer->replaced);
    free(writer->buffer);
    free(writer->temporary);
    free(writer->target);
    free(writer);
}
