/* test_file.c: files are written whole or not at all: a full disk, a folder that cannot be written,
 * an abandoned writer leave the old file and no temporary. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <grp.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>
#include "io/file/file.h"
#include "io/format/format.h"

typedef struct place {
    char folder[128], path[160];
} place;

static int set_up(void **state) {
    place *made = calloc(1, sizeof *made);
    const char *temporary = getenv("TMPDIR");
    snprintf(made->folder, sizeof made->folder, "%.90s/norma-file-XXXXXX",
        temporary ? temporary : "/tmp");
    if (!mkdtemp(made->folder)) return -1;
    snprintf(made->path, sizeof made->path, "%s/mesh.obj", made->folder);
    umask(022);
    *state = made;
    return 0;
}

static int tear_down(void **state) {
    place *here = *state;
    char command[400];
    snprintf(
        command, sizeof command, "chmod -R u+w '%s' && rm -rf '%s'", here->folder, here->folder);
    int status = system(command);
    free(here);
    return status;
}

static void put(const char *path, const char *text) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
}

static void assert_holds(const char *path, const char *text) {
    file_bytes bytes;
    assert_int_equal(norma_file_open(path, NULL, &bytes), 0);
    assert_int_equal(bytes.size, strlen(text));
    assert_memory_equal(bytes.data, text, bytes.size);
    norma_file_close(&bytes);
}

static size_t count_entries(const char *path) {
    DIR *folder = opendir(path);
    size_t count = 0;
    assert_non_null(folder);
    for (const struct dirent *entry; (entry = readdir(folder));)
        count += entry->d_name[0] != '.' || strncmp(entry->d_name, ".norma", 6) == 0;
    closedir(folder);
    return count;
}

static int write_text(const char *path, const char *text) {
    file_writer *writer;
    int error = norma_file_writer_open(path, &writer);
    if (error) return error;
    error = norma_file_writer_write(writer, text, strlen(text));
    if (error) {
        norma_file_writer_abandon(writer);
        return error;
    }
    return norma_file_writer_commit(writer);
}

static mode_t mode_of(const char *path) {
    struct stat status;
    assert_int_equal(stat(path, &status), 0);
    return status.st_mode & 07777;
}

/* ---- reading */

static void reads_what_is_there(void **state) {
    const place *here = *state;
    file_bytes bytes;
    put(here->path, "v 0 0 0\n");
    assert_holds(here->path, "v 0 0 0\n");
    put(here->path, "");
    assert_int_equal(norma_file_open(here->path, NULL, &bytes), 0);
    assert_non_null(bytes.data);
    assert_int_equal(bytes.size, 0);
    norma_file_close(&bytes);
    assert_int_equal(norma_file_open(here->folder, NULL, &bytes), EISDIR);
    unlink(here->path);
    assert_int_equal(norma_file_open(here->path, NULL, &bytes), ENOENT);
}

/* They may have no end, and a pipe whose other end nobody opens would wait for ever. */
static void refuses_devices_and_pipes(void **state) {
    const place *here = *state;
    file_bytes bytes;
    assert_int_equal(mkfifo(here->path, 0600), 0);
    assert_int_equal(norma_file_open(here->path, NULL, &bytes), FILE_NOT_REGULAR);
    assert_int_equal(norma_file_open("/dev/zero", NULL, &bytes), FILE_NOT_REGULAR);
}

static int stop_at_once(void *calls, double fraction) {
    (void)fraction;
    return ++*(int *)calls > 1;
}

static void stops_reading_when_told(void **state) {
    const place *here = *state;
    file_bytes bytes;
    int calls = 0;
    const file_reading how = {.progress = stop_at_once, .progress_user = &calls};
    put(here->path, "");
    assert_int_equal(truncate(here->path, (off_t)1 << 30), 0);
    assert_int_equal(norma_file_open(here->path, &how, &bytes), FILE_CANCELLED);
    assert_int_equal(calls, 2);
}

/* ---- writing */

static void writes_a_new_file(void **state) {
    const place *here = *state;
    assert_int_equal(write_text(here->path, "v 1 2 3\n"), 0);
    assert_holds(here->path, "v 1 2 3\n");
    assert_int_equal(mode_of(here->path), 0644); /* 0666 less the umask */
    assert_int_equal(count_entries(here->folder), 1);
}

static void writes_more_than_its_buffer(void **state) {
    const place *here = *state;
    const size_t size = 1000003, part = 777;
    unsigned char *text = malloc(size);
    for (size_t i = 0; i < size; ++i) text[i] = (unsigned char)(i * 2654435761u >> 13);
    file_writer *writer;
    assert_int_equal(norma_file_writer_open(here->path, &writer), 0);
    size_t at = 0;
    for (; at < size / 2; at += part)
        assert_int_equal(norma_file_writer_write(writer, text + at, part), 0);
    assert_int_equal(norma_file_writer_write(writer, text + at, size - at), 0);
    assert_int_equal(norma_file_writer_commit(writer), 0);
    file_bytes bytes;
    assert_int_equal(norma_file_open(here->path, NULL, &bytes), 0);
    assert_int_equal(bytes.size, size);
    assert_memory_equal(bytes.data, text, size);
    norma_file_close(&bytes);
    free(text);
}

static void replaces_only_at_the_end(void **state) {
    const place *here = *state;
    put(here->path, "old");
    file_writer *writer;
    assert_int_equal(norma_file_writer_open(here->path, &writer), 0);
    assert_int_equal(norma_file_writer_write(writer, "new", 3), 0);
    assert_int_equal(norma_file_writer_prepare(writer), 0);
    assert_holds(here->path, "old");
    assert_int_equal(norma_file_writer_commit(writer), 0);
    assert_holds(here->path, "new");
    assert_int_equal(count_entries(here->folder), 1);
}

static void keeps_a_mapped_source_whole(void **state) {
    const place *here = *state;
    file_bytes source;
    put(here->path, "old bytes");
    assert_int_equal(norma_file_open(here->path, NULL, &source), 0);
    assert_int_equal(write_text(here->path, "n"), 0);
    assert_memory_equal(source.data, "old bytes", source.size);
    norma_file_close(&source);
    assert_holds(here->path, "n");
}

static void abandoning_leaves_nothing(void **state) {
    const place *here = *state;
    put(here->path, "old");
    file_writer *writer;
    assert_int_equal(norma_file_writer_open(here->path, &writer), 0);
    assert_int_equal(norma_file_writer_write(writer, "new", 3), 0);
    assert_int_equal(norma_file_writer_prepare(writer), 0);
    assert_in_range(count_entries(here->folder), 1, 2); /* the temporary may have no name */
    norma_file_writer_abandon(writer);
    norma_file_writer_abandon(NULL);
    assert_holds(here->path, "old");
    assert_int_equal(count_entries(here->folder), 1);
}

static void a_full_disk_keeps_the_old_file(void **state) {
    const place *here = *state;
    static char text[400000];
    struct rlimit old, small;
    memset(text, 'x', sizeof text - 1);
    put(here->path, "old");
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    small = old;
    small.rlim_cur = 100000;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    int error = write_text(here->path, text), again = 0;
    text[150000] = '\0'; /* fits the buffer, and fails only when that is flushed, at the end */
    again = write_text(here->path, text);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    signal(SIGXFSZ, SIG_DFL);
    assert_int_equal(error, EFBIG);
    assert_int_equal(again, EFBIG);
    assert_holds(here->path, "old");
    assert_int_equal(count_entries(here->folder), 1);
}

static void an_error_is_remembered(void **state) {
    (void)state;
    file_writer *writer;
    if (norma_file_writer_open("/dev/full", &writer)) skip();
    static const char text[300000];
    assert_int_equal(norma_file_writer_write(writer, text, sizeof text), ENOSPC);
    assert_int_equal(norma_file_writer_write(writer, "a", 1), ENOSPC);
    assert_int_equal(norma_file_writer_commit(writer), ENOSPC);
    struct stat status;
    assert_int_equal(stat("/dev/full", &status), 0);
    assert_true(S_ISCHR(status.st_mode)); /* a device is written, not replaced */
}

static void keeps_permissions(void **state) {
    const place *here = *state;
    put(here->path, "old");
    assert_int_equal(chmod(here->path, 0640), 0);
    assert_int_equal(write_text(here->path, "new"), 0);
    assert_int_equal(mode_of(here->path), 0640);
    assert_int_equal(chmod(here->path, 0600), 0);
    assert_int_equal(write_text(here->path, "newer"), 0);
    assert_int_equal(mode_of(here->path), 0600);
}

/* ---- access lists and attributes */

/* An access control list as Linux has it in an attribute (linux/posix_acl_xattr.h). */
typedef struct acl_entry {
    uint16_t tag, rights;
    uint32_t id;
} acl_entry;

typedef struct access_list {
    uint32_t version;
    acl_entry entries[5];
} access_list;

enum { NAMED = 1001, SHARED = 2001, NOBODY = 65534 };
static const char ACCESS_LIST[] = "system.posix_acl_access";

/* u::rw-, u:NAMED:rw-, g::---, m::rw-, o::---: as mode bits -rw-rw----. */
static access_list list_of_one(void) {
    return (access_list){2, {{0x01, 6, UINT32_MAX}, {0x02, 6, NAMED}, {0x04, 0, UINT32_MAX},
                                {0x10, 6, UINT32_MAX}, {0x20, 0, UINT32_MAX}}};
}

static void give_list(const char *path, const char *name) {
    const access_list list = list_of_one();
    if (setxattr(path, name, &list, sizeof list, 0) == 0) return;
    print_message("no access lists on this file system: %s\n", strerror(errno));
    skip();
}

static void assert_has_list(const char *path) {
    const access_list expected = list_of_one();
    access_list list;
    assert_int_equal(getxattr(path, ACCESS_LIST, &list, sizeof list), sizeof list);
    assert_memory_equal(&list, &expected, sizeof list);
}

/* What the system lets a user of a group do: the error of opening the file for writing. */
static int try_as(const char *path, uid_t user, gid_t group) {
    const pid_t child = fork();
    if (child == 0) {
        if (setgroups(0, NULL) || setgid(group) || setuid(user)) _exit(255);
        _exit(open(path, O_RDWR) < 0 ? errno : 0);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static void keeps_an_access_list(void **state) {
    const place *here = *state;
    put(here->path, "old");
    assert_int_equal(chmod(here->folder, 0755), 0);
    give_list(here->path, ACCESS_LIST);
    assert_int_equal(write_text(here->path, "new"), 0);
    assert_holds(here->path, "new");
    assert_has_list(here->path);
    assert_int_equal(mode_of(here->path), 0660);
    if (geteuid() != 0) return;
    assert_int_equal(try_as(here->path, NAMED, NOBODY), 0);
    assert_int_equal(try_as(here->path, NOBODY, getegid()), EACCES);
}

/* A file without a list in a folder that gives one to new files. */
static void takes_no_access_list_of_the_folder(void **state) {
    const place *here = *state;
    put(here->path, "old");
    assert_int_equal(chmod(here->path, 0660), 0);
    give_list(here->folder, "system.posix_acl_default");
    assert_int_equal(write_text(here->path, "new"), 0);
    assert_int_equal(getxattr(here->path, ACCESS_LIST, NULL, 0), -1);
    assert_int_equal(mode_of(here->path), 0660);
    char fresh[200];
    snprintf(fresh, sizeof fresh, "%s/fresh.obj", here->folder);
    assert_int_equal(write_text(fresh, "new"), 0);
    assert_has_list(fresh);
}

/* The library's calls come here (--wrap). */
static int refused_attribute;

int __real_fsetxattr(int file, const char *name, const void *value, size_t size, int flags);
int __wrap_fsetxattr(int file, const char *name, const void *value, size_t size, int flags);
int __wrap_fsetxattr(int file, const char *name, const void *value, size_t size, int flags) {
    if (refused_attribute) return errno = refused_attribute, -1;
    return __real_fsetxattr(file, name, value, size, flags);
}

static void keeps_attributes(void **state) {
    const place *here = *state;
    static char large[2000];
    char value[sizeof large + 1];
    put(here->path, "old");
    memset(large, 'x', sizeof large);
    if (setxattr(here->path, "user.origin", large, sizeof large, 0)) {
        print_message("no attributes on this file system: %s\n", strerror(errno));
        skip();
    }
    assert_int_equal(setxattr(here->path, "user.empty", "", 0, 0), 0);
    assert_int_equal(write_text(here->path, "new"), 0);
    assert_int_equal(getxattr(here->path, "user.origin", value, sizeof value), sizeof large);
    assert_memory_equal(value, large, sizeof large);
    assert_int_equal(getxattr(here->path, "user.empty", value, sizeof value), 0);
    const int errors[] = {EPERM, ENOSPC}, expected[] = {FILE_ATTRIBUTES, ENOSPC};
    for (int i = 0; i < 2; ++i) {
        file_writer *writer;
        refused_attribute = errors[i];
        const int error = norma_file_writer_open(here->path, &writer);
        refused_attribute = 0;
        assert_int_equal(error, expected[i]);
        assert_holds(here->path, "new");
        assert_int_equal(count_entries(here->folder), 1);
    }
}

/* Root may write anywhere, so a child gives its rights up. Returns the error that it met. */
static int write_as(const char *path, uid_t user, gid_t group) {
    const gid_t shared = SHARED;
    const pid_t child = fork();
    if (child == 0) {
        if (geteuid() == 0 && (setgroups(1, &shared) || setgid(group) || setuid(user))) _exit(255);
        const int error = write_text(path, "new");
        _exit(error == FILE_ATTRIBUTES ? 254 : error);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status) == 254 ? FILE_ATTRIBUTES : WEXITSTATUS(status);
}

/* Who may write into another's file, and make files in the folder. */
static void anothers_file_gives_no_group_new_rights(void **state) {
    const place *here = *state;
    struct stat status;
    if (geteuid() != 0) skip();
    put(here->path, "old");
    assert_int_equal(chmod(here->folder, 0777), 0);
    assert_int_equal(chown(here->path, 0, SHARED), 0);
    assert_int_equal(chmod(here->path, 06662), 0);
    assert_int_equal(write_as(here->path, NAMED, NOBODY), 0); /* of the group: it is kept */
    assert_int_equal(stat(here->path, &status), 0);
    assert_int_equal(status.st_uid, NAMED);
    assert_int_equal(status.st_gid, SHARED);
    assert_int_equal(status.st_mode & 07777, 0662);
    assert_int_equal(chown(here->path, 0, 0), 0);
    assert_int_equal(write_as(here->path, NAMED, NOBODY), 0); /* not of the group */
    assert_int_equal(stat(here->path, &status), 0);
    assert_int_equal(status.st_gid, NOBODY);
    assert_int_equal(status.st_mode & 07777, 0622);
    assert_int_equal(chown(here->path, 0, 0), 0);
    give_list(here->path, ACCESS_LIST);
    assert_int_equal(write_as(here->path, NAMED, NOBODY), FILE_ATTRIBUTES);
    assert_int_equal(count_entries(here->folder), 1);
    assert_has_list(here->path);
}

static void a_read_only_folder_is_an_error(void **state) {
    const place *here = *state;
    put(here->path, "old");
    assert_int_equal(chmod(here->path, 0666), 0);
    assert_int_equal(chmod(here->folder, 0555), 0);
    int error = write_as(here->path, NOBODY, NOBODY);
    assert_int_equal(chmod(here->folder, 0755), 0);
    assert_int_equal(error, EACCES);
    assert_holds(here->path, "old");
    assert_int_equal(count_entries(here->folder), 1);
}

static void a_read_only_file_is_not_replaced(void **state) {
    const place *here = *state;
    put(here->path, "old");
    assert_int_equal(chmod(here->path, 0444), 0);
    assert_int_equal(chmod(here->folder, 0777), 0);
    assert_int_equal(write_as(here->path, NOBODY, NOBODY), EACCES);
    assert_holds(here->path, "old");
    assert_int_equal(count_entries(here->folder), 1);
}

static void a_symbolic_link_stays(void **state) {
    const place *here = *state;
    char link[200], folder[200], target[240];
    struct stat status;
    snprintf(folder, sizeof folder, "%s/deep", here->folder);
    snprintf(link, sizeof link, "%s/link.obj", here->folder);
    snprintf(target, sizeof target, "%s/target.obj", folder);
    assert_int_equal(mkdir(folder, 0755), 0);
    assert_int_equal(symlink("deep/target.obj", link), 0);
    assert_int_equal(write_text(link, "first"), 0); /* to a file that is not there yet */
    assert_holds(target, "first");
    assert_int_equal(write_text(link, "second"), 0);
    assert_holds(target, "second");
    assert_int_equal(lstat(link, &status), 0);
    assert_true(S_ISLNK(status.st_mode));
    assert_int_equal(count_entries(folder), 1);
}

static void a_circle_of_links_is_an_error(void **state) {
    const place *here = *state;
    assert_int_equal(symlink("mesh.obj", here->path), 0);
    assert_int_equal(write_text(here->path, "new"), ELOOP);
    assert_int_equal(count_entries(here->folder), 1);
}

static void folders_are_refused(void **state) {
    const place *here = *state;
    char missing[240];
    snprintf(missing, sizeof missing, "%s/none/mesh.obj", here->folder);
    assert_int_equal(write_text(here->folder, "new"), EISDIR);
    assert_int_equal(write_text(missing, "new"), ENOENT);
}

static void a_temporary_in_the_way_is_left_alone(void **state) {
    const place *here = *state;
    char other[200];
    snprintf(other, sizeof other, "%s/.norma-%ld-0.tmp", here->folder, (long)getpid());
    put(other, "someone else's");
    assert_int_equal(write_text(here->path, "new"), 0);
    assert_holds(here->path, "new");
    assert_holds(other, "someone else's");
}

static void knows_one_file_by_two_names(void **state) {
    const place *here = *state;
    char other[200], link[200];
    snprintf(other, sizeof other, "%s/./mesh.obj", here->folder);
    snprintf(link, sizeof link, "%s/hard.obj", here->folder);
    assert_int_equal(norma_file_same(here->path, other), 0);
    put(here->path, "v");
    assert_int_equal(norma_file_same(here->path, other), 1);
    put(link, "v");
    assert_int_equal(norma_file_same(here->path, link), 0);
    unlink(link);
    assert_int_equal(symlink(here->path, link), 0);
    assert_int_equal(norma_file_same(here->path, link), 1);
    assert_int_equal(norma_file_is_stream("/dev/null"), 1);
    assert_int_equal(norma_file_is_stream(here->path), 0);
    assert_int_equal(norma_file_is_stream(here->folder), 0);
}

/* ---- a folder that cannot be flushed */

static int folder_flushes_left = INT_MAX; /* then each of a folder fails */

int __real_fsync(int descriptor);
int __wrap_fsync(int descriptor);
int __wrap_fsync(int descriptor) {
    struct stat status;
    if (fstat(descriptor, &status) == 0 && S_ISDIR(status.st_mode) && folder_flushes_left-- <= 0) {
        errno = EIO;
        return -1;
    }
    return __real_fsync(descriptor);
}

static file_writer *writer_of(const char *path, const char *text) {
    file_writer *writer;
    assert_int_equal(norma_file_writer_open(path, &writer), 0);
    assert_int_equal(norma_file_writer_write(writer, text, strlen(text)), 0);
    return writer;
}

static void a_folder_that_is_not_flushed_is_called_so(void **state) {
    const place *here = *state;
    char text[200];
    put(here->path, "old");
    folder_flushes_left = 0;
    const int result = write_text(here->path, "new");
    folder_flushes_left = INT_MAX;
    assert_int_equal(result, FILE_NOT_FLUSHED);
    assert_holds(here->path, "new");
    assert_int_equal(count_entries(here->folder), 1);
    norma_document_system_text(result, text, sizeof text);
    assert_non_null(strstr(text, "the new file is in its place"));
}

/* Of several, the first is taken away again: nobody may be told that it is in its place. */
static void the_first_of_two_is_not_called_in_its_place(void **state) {
    const place *here = *state;
    char first[200];
    size_t failed = 9;
    snprintf(first, sizeof first, "%s/mesh.bin", here->folder);
    file_writer *writers[2] = {writer_of(first, "buffer"), writer_of(here->path, "asset")};
    folder_flushes_left = 0;
    const int result = norma_file_writers_commit(writers, 2, &failed);
    folder_flushes_left = INT_MAX;
    assert_int_equal(result, EIO);
    assert_int_equal(failed, 0);
    assert_int_equal(access(first, F_OK), -1);
    assert_int_equal(access(here->path, F_OK), -1);
    assert_int_equal(count_entries(here->folder), 0);
}

/* A folder has come to stand in the way of the last one: what the first replaced is back. */
static void what_was_replaced_is_put_back(void **state) {
    const place *here = *state;
    char first[200], second[200];
    size_t failed = 9;
    struct stat before, after;
    snprintf(first, sizeof first, "%s/a.ply", here->folder);
    snprintf(second, sizeof second, "%s/b.ply", here->folder);
    put(first, "old");
    stat(first, &before);
    file_writer *writers[2] = {writer_of(first, "new"), writer_of(second, "newer")};
    norma_file_writer_batch(writers[0], 1);
    norma_file_writer_batch(writers[1], 1);
    assert_int_equal(mkdir(second, 0777), 0);
    assert_int_equal(norma_file_writers_commit(writers, 2, &failed), EISDIR);
    assert_int_equal(failed, 1);
    assert_holds(first, "old");
    stat(first, &after);
    assert_true(before.st_ino == after.st_ino);
    assert_int_equal(count_entries(here->folder), 2);
    rmdir(second);
}

/* More files at once than the process may open. */
static void a_thousand_files_need_few_descriptors(void **state) {
    enum { FILES = 1000, DESCRIPTORS = 500 };
    const place *here = *state;
    file_writer *writers[FILES];
    struct rlimit before, few;
    char path[200], text[16];
    size_t failed;
    getrlimit(RLIMIT_NOFILE, &before);
    few = (struct rlimit){DESCRIPTORS, before.rlim_max};
    setrlimit(RLIMIT_NOFILE, &few);
    for (int i = 0; i < FILES; ++i) {
        snprintf(path, sizeof path, "%s/%d.png", here->folder, i);
        snprintf(text, sizeof text, "%d", i);
        writers[i] = writer_of(path, text);
        assert_int_equal(norma_file_writer_prepare(writers[i]), 0);
    }
    const int result = norma_file_writers_commit(writers, FILES, &failed);
    setrlimit(RLIMIT_NOFILE, &before);
    assert_int_equal(result, 0);
    for (int i = 0; i < FILES; ++i) {
        snprintf(path, sizeof path, "%s/%d.png", here->folder, i);
        snprintf(text, sizeof text, "%d", i);
        assert_holds(path, text);
    }
    assert_int_equal(count_entries(here->folder), FILES);
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, set_up, tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        TEST(reads_what_is_there),
        TEST(refuses_devices_and_pipes),
        TEST(stops_reading_when_told),
        TEST(writes_a_new_file),
        TEST(writes_more_than_its_buffer),
        TEST(replaces_only_at_the_end),
        TEST(keeps_a_mapped_source_whole),
        TEST(abandoning_leaves_nothing),
        TEST(a_full_disk_keeps_the_old_file),
        TEST(an_error_is_remembered),
        TEST(keeps_permissions),
        TEST(keeps_an_access_list),
        TEST(takes_no_access_list_of_the_folder),
        TEST(keeps_attributes),
        TEST(anothers_file_gives_no_group_new_rights),
        TEST(a_read_only_folder_is_an_error),
        TEST(a_read_only_file_is_not_replaced),
        TEST(a_symbolic_link_stays),
        TEST(a_circle_of_links_is_an_error),
        TEST(folders_are_refused),
        TEST(a_temporary_in_the_way_is_left_alone),
        TEST(knows_one_file_by_two_names),
        TEST(a_folder_that_is_not_flushed_is_called_so),
        TEST(the_first_of_two_is_not_called_in_its_place),
        TEST(what_was_replaced_is_put_back),
        TEST(a_thousand_files_need_few_descriptors),
    };
    return cmocka_run_group_tests_name("files", tests, NULL, NULL);
}
