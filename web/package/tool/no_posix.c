/* no_posix.c: POSIX for the tool under node's WASI. The whole file system is open to it as "/", and
 * it enters the folder in which node was started. Rights, owners and numbers of processes are asked
 * of node. */
#undef sysconf
#undef stat
#undef lstat
#undef fstat
#undef access
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_PATH = 4096, MOST_LINKS = 40 };

#define FROM_HOST(name) __attribute__((import_module("norma"), import_name(#name))) name

/* Of a path, or of the file behind a descriptor if path is NULL: mode, owner, group. 0, or an
 * errno of POSIX, as all that follow. */
int FROM_HOST(host_status)(int descriptor, const char *path, int follows, uint32_t found[3]);
int FROM_HOST(host_access)(const char *path, int mode);
int FROM_HOST(host_chmod)(int descriptor, uint32_t mode);
int FROM_HOST(host_chown)(int descriptor, uint32_t owner, uint32_t group);
int FROM_HOST(host_path)(int descriptor, char *path, int room);
int FROM_HOST(host_user)(void);
int FROM_HOST(host_process)(void);

/* Before main. */
__attribute__((constructor)) static void enter_folder(void) {
    const char *folder = getenv("PWD");
    if (folder) (void)chdir(folder);
}

/* A WebAssembly memory has an end before the machine's has: of 4 GiB, three are for data. */
long tool_sysconf(int what) {
    enum { PAGE = 1 << 16, PAGES = 3 << 14 };
    return what == _SC_PHYS_PAGES ? PAGES : what == _SC_PAGESIZE ? PAGE : sysconf(what);
}

int madvise(void *address, unsigned long size, int advice) {
    return (void)address, (void)size, (void)advice, 0;
}

/* ---- rights and owners. The host's errors are WASI's numbers. */

static int fail_with(int error) { return error ? errno = error, -1 : 0; }

static int add_rights(
    int failed, int descriptor, const char *path, int follows, struct stat *status) {
    uint32_t found[3];
    if (failed || host_status(descriptor, path, follows, found)) return failed;
    status->st_mode = (status->st_mode & S_IFMT) | (found[0] & 07777);
    status->st_uid = found[1];
    status->st_gid = found[2];
    return 0;
}

int tool_stat(const char *path, struct stat *status) {
    return add_rights(stat(path, status), -1, path, 1, status);
}
int tool_lstat(const char *path, struct stat *status) {
    return add_rights(lstat(path, status), -1, path, 0, status);
}
int tool_fstat(int descriptor, struct stat *status) {
    return add_rights(fstat(descriptor, status), descriptor, NULL, 1, status);
}

int tool_access(const char *path, int mode) { return fail_with(host_access(path, mode)); }
int fchmod(int descriptor, mode_t mode) { return fail_with(host_chmod(descriptor, mode)); }
int fchown(int descriptor, uid_t owner, gid_t group) {
    return fail_with(host_chown(descriptor, owner, group));
}
int flock(int descriptor, int how);
int flock(int descriptor, int how) { return (void)descriptor, (void)how, 0; /* not to be had */ }
uid_t geteuid(void) { return (uid_t)host_user(); }
pid_t getpid(void) { return host_process(); }

int dup(int descriptor) {
    char path[MOST_PATH];
    const int error = host_path(descriptor, path, sizeof path);
    return error ? fail_with(error) : open(path, O_RDONLY);
}

/* ---- realpath: from the root, without ".", ".." and symbolic links. */

static size_t without_last(const char *path, size_t length) {
    while (length > 0 && path[length] != '/') --length;
    return length;
}

/* Replaces what lies ahead of rest by the link's text. */
static int follow_link(const char *target, size_t size, const char *rest, char *ahead) {
    char text[MOST_PATH];
    const size_t more = strlen(rest);
    if (size + more + 2 > sizeof text) return ENAMETOOLONG;
    memcpy(text, target, size);
    text[size] = '/';
    memcpy(text + size + 1, rest, more + 1);
    return memcpy(ahead, text, size + more + 2), 0;
}

static int resolve(const char *path, char out[MOST_PATH]) {
    char ahead[MOST_PATH], target[MOST_PATH];
    size_t length = 0;
    if (strlen(path) >= MOST_PATH) return ENAMETOOLONG;
    strcpy(ahead, path);
    if (path[0] != '/') {
        if (!getcwd(out, MOST_PATH)) return errno;
        length = strlen(out);
        if (length == 1) length = 0;
    }
    const char *at = ahead;
    for (int links = 0; *at;) {
        const size_t word = strcspn(at, "/"), before = length;
        const char *rest = at + word + (at[word] == '/');
        if (word == 2 && memcmp(at, "..", 2) == 0)
            length = without_last(out, length ? length - 1 : 0);
        else if (word > 0 && !(word == 1 && *at == '.')) {
            if (length + word + 2 > MOST_PATH) return ENAMETOOLONG;
            out[length++] = '/';
            memcpy(out + length, at, word);
            length += word;
            out[length] = '\0';
            const ssize_t size = readlink(out, target, sizeof target);
            if (size > 0) {
                const int error =
                    ++links > MOST_LINKS ? ELOOP : follow_link(target, (size_t)size, rest, ahead);
                if (error) return error;
                length = target[0] == '/' ? 0 : before;
                at = ahead;
                continue;
            }
        }
        at = rest;
    }
    if (length == 0) out[length++] = '/';
    out[length] = '\0';
    return 0;
}

char *realpath(const char *restrict path, char *restrict resolved) {
    char full[MOST_PATH];
    struct stat status;
    const int error = *path ? resolve(path, full) : ENOENT;
    if (error) return errno = error, NULL;
    if (stat(full, &status)) return NULL;
    return resolved ? strcpy(resolved, full) : strdup(full);
}
