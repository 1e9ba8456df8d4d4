/* attributes.c: who may read and write a file, and what is attached to it, carried from a file to
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
#define _GNU_SOURCE
#endif
#define _POSIX_C_SOURCE 200809L
#include "io/file/file_stamp.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

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
static int copy_attributes(const char *from, int to, int is_anothers) {
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
static int copy_attributes(const char *from, int to, int is_anothers) {
    return (void)from, (void)to, (void)is_anothers, 0;
}
#endif

/* Who writes into another's file becomes its owner, as with every program that replaces files. Then
 * the bits that lend the owner's rights go; where the group cannot be kept either, the writer's own
 * gets no more rights than everyone; and an access list, whose owner would lose his, is a reason to
 * refuse. */
int norma_file_keep_attributes(const char *from, const struct stat *old, int to) {
    mode_t mode = old->st_mode & 07777;
    const int is_anothers = fchown(to, old->st_uid, old->st_gid) != 0;
    if (is_anothers) {
        mode &= 0777;
        if (fchown(to, (uid_t)-1, old->st_gid)) mode &= (mode_t)(0707 | (mode & 07) << 3);
    }
    const int error = copy_attributes(from, to, is_anothers);
    if (!error) return fchmod(to, mode) ? errno : 0;
    return error == ENOMEM || error == ENOSPC || error == EDQUOT ? error : FILE_ATTRIBUTES;
}
