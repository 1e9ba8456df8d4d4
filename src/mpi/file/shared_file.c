/* shared_file.c: slices by MPI-IO; the output is a temporary file that the first rank puts in its
 * place once every rank has written its slice. */
#define _GNU_SOURCE /* SOCK_CLOEXEC */
#include "mpi/file/shared_file.h"
#include "io/format/format.h"
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* ---- memory that is counted */

void norma_mpi_count_memory(mpi_job *job, size_t size) {
    job->memory += size;
    if (job->memory > job->most_memory) job->most_memory = job->memory;
}

static void *mpi_allocate(void *user, size_t size, size_t alignment) {
    mpi_job *job = user;
    (void)alignment; /* nothing here needs more than malloc's */
    void *block = norma_core_default_block(size);
    if (!block) return NULL;
    norma_mpi_count_memory(job, size);
    return block;
}

static void mpi_release(void *user, void *block, size_t size) {
    mpi_job *job = user;
    job->memory -= size;
    free(block);
}

norma_result norma_mpi_open_job(mpi_job *job, MPI_Comm comm) {
    job->options.allocator = (norma_allocator){mpi_allocate, mpi_release, job};
    norma_core_begin(&job->core, &(norma_options){.struct_size = sizeof(norma_options),
                                     .allocator = job->options.allocator});
    return norma_mpi_begin(&job->call, comm, &job->core);
}

/* ---- failing together */

int norma_mpi_fail(mpi_job *job, const char *format, ...) {
    va_list list;
    va_start(list, format);
    vsnprintf(job->message, sizeof job->message, format, list);
    va_end(list);
    return 1;
}

int norma_mpi_failed(mpi_job *job, int mine) {
    int all = mine ? job->call.rank : job->call.ranks;
    norma_mpi_reduce(&job->call, &all, 1, MPI_INT, MPI_MIN);
    if (all == job->call.ranks) return 0;
    MPI_Bcast(job->message, (int)sizeof job->message, MPI_CHAR, all, job->call.comm);
    return 1;
}

int norma_mpi_failed_result(mpi_job *job, norma_result mine) {
    return norma_mpi_failed(
        job, !mine ? 0 : norma_mpi_fail(job, "%s: %s", job->input, norma_result_text(mine)));
}

static int fail_mpi(mpi_job *job, const char *path, const char *what, int code) {
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(code, text, &length);
    return norma_mpi_fail(job, "%s: %s: %s", path, what, text);
}

/* ---- reading */

static int check_size(mpi_job *job) {
    struct stat status;
    if (stat(job->input, &status) != 0)
        return norma_mpi_fail(job, "%s: %s (rank %d)", job->input, strerror(errno), job->call.rank);
    if (!S_ISREG(status.st_mode))
        return norma_mpi_fail(job, "%s: is not a regular file", job->input);
    job->size = (uint64_t)status.st_size;
    return 0;
}

static int check_same_size(mpi_job *job) {
    const uint64_t most = norma_mpi_largest(&job->call, job->size);
    return job->size == most
               ? 0
               : norma_mpi_fail(job,
                     "%s: rank %d sees %llu bytes, another rank %llu; all ranks must see one file",
                     job->input, job->call.rank, (unsigned long long)job->size,
                     (unsigned long long)most);
}

int norma_mpi_open_input(mpi_job *job) {
    if (norma_mpi_failed(job, check_size(job))) return 1;
    if (norma_mpi_failed(job, check_same_size(job))) return 1;
    const int code =
        MPI_File_open(MPI_COMM_SELF, job->input, MPI_MODE_RDONLY, MPI_INFO_NULL, &job->in);
    const int failed = code == MPI_SUCCESS ? 0 : fail_mpi(job, job->input, "cannot be read", code);
    if (failed) job->in = MPI_FILE_NULL;
    return norma_mpi_failed(job, failed);
}

int norma_mpi_read(mpi_job *job, uint64_t offset, void *bytes, size_t size) {
    unsigned char *to = bytes;
    while (size) {
        MPI_Status status;
        int got = 0;
        const int some = size < MPI_BLOCK ? (int)size : MPI_BLOCK,
                  code = MPI_File_read_at(job->in, (MPI_Offset)offset, to, some, MPI_BYTE, &status);
        if (code != MPI_SUCCESS) return fail_mpi(job, job->input, "cannot be read", code);
        MPI_Get_count(&status, MPI_BYTE, &got);
        if (got <= 0)
            return norma_mpi_fail(job, "%s: ends at byte %llu, although more was announced",
                job->input, (unsigned long long)offset);
        offset += (uint64_t)got;
        to += got;
        size -= (size_t)got;
    }
    return 0;
}

/* ---- writing */

/* The temporary file has a name, since the other ranks open it: should this rank end before it has
 * put the file in its place, a guard takes the name away. Launchers end a job whose rank has died
 * by SIGKILL, a few milliseconds after SIGTERM, so no handler could. The guard is a shell in a
 * process group of its own that reads the name from a socket until its end; spawned, not forked,
 * for memory that a network adapter writes must not become a copy; and before there is a name, so
 * that a rank is never without. Without one (no shell) the file would stay. */
static void guard(mpi_job *job) {
    char *words[] = {"sh", "-c",
        "name=$(cat; echo .); name=${name%.}; [ -z \"$name\" ] || rm -f -- \"$name\"", NULL};
    int ends[2];
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends)) return;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[0], 0);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    if (posix_spawnp(&job->guard, "sh", &actions, &attributes, words, environ)) job->guard = 0;
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[0]);
    job->guarded = ends[1];
    if (!job->guard) close(ends[1]);
}

/* A guard that has ended is as none. */
static void tell_guard(const mpi_job *job) {
    if (job->guard) (void)send(job->guarded, job->temporary, strlen(job->temporary), MSG_NOSIGNAL);
}

static void dismiss_guard(mpi_job *job) {
    if (!job->guard) return;
    kill(job->guard, SIGKILL);
    waitpid(job->guard, NULL, 0);
    close(job->guarded);
    job->guard = 0;
}

static int fail_output(mpi_job *job, int failed) {
    char text[160];
    norma_document_system_text(failed, text, sizeof text);
    return norma_mpi_fail(job, "%s: cannot be written: %s", job->output, text);
}

static int make_temporary(mpi_job *job) {
    int failed = norma_file_writer_open(job->output, &job->writer);
    if (failed) return fail_output(job, failed);
    guard(job);
    failed = norma_file_writer_name(job->writer);
    if (failed) return fail_output(job, failed);
    const char *name = norma_file_writer_temporary(job->writer);
    if (strlen(name) >= sizeof job->temporary)
        return norma_mpi_fail(job, "%s: the path is too long", job->output);
    strcpy(job->temporary, name);
    tell_guard(job);
    return 0;
}

int norma_mpi_open_output(mpi_job *job, uint64_t size) {
    if (norma_mpi_failed(job, job->call.rank ? 0 : make_temporary(job))) return 1;
    MPI_Bcast(job->temporary, (int)sizeof job->temporary, MPI_CHAR, 0, job->call.comm);
    int code =
        MPI_File_open(MPI_COMM_SELF, job->temporary, MPI_MODE_WRONLY, MPI_INFO_NULL, &job->out);
    int failed = code == MPI_SUCCESS ? 0 : fail_mpi(job, job->output, "cannot be written", code);
    if (failed) job->out = MPI_FILE_NULL;
    if (!failed && !job->call.rank) {
        code = MPI_File_set_size(job->out, (MPI_Offset)size);
        if (code != MPI_SUCCESS) failed = fail_mpi(job, job->output, "cannot be written", code);
    }
    return norma_mpi_failed(job, failed);
}

int norma_mpi_write(mpi_job *job, uint64_t offset, const void *bytes, size_t size) {
    const unsigned char *from = bytes;
    while (size) {
        MPI_Status status;
        int put = 0;
        const int some = size < MPI_BLOCK ? (int)size : MPI_BLOCK,
                  code = MPI_File_write_at(
                      job->out, (MPI_Offset)offset, from, some, MPI_BYTE, &status);
        if (code == MPI_SUCCESS) MPI_Get_count(&status, MPI_BYTE, &put);
        if (code != MPI_SUCCESS || put <= 0)
            return fail_mpi(job, job->output, "cannot be written", code);
        offset += (uint64_t)put;
        from += put;
        size -= (size_t)put;
    }
    return 0;
}

static int close_mine(mpi_job *job) {
    int failed = 0;
    if (job->out == MPI_FILE_NULL) return 0;
    int code = MPI_File_sync(job->out);
    if (code != MPI_SUCCESS) failed = fail_mpi(job, job->output, "cannot be written", code);
    code = MPI_File_close(&job->out);
    if (code != MPI_SUCCESS) failed = fail_mpi(job, job->output, "cannot be written", code);
    return failed;
}

int norma_mpi_close_output(mpi_job *job, int failed) {
    char why[sizeof job->message];
    memcpy(why, job->message, sizeof why);
    const int closed = close_mine(job);
    if (failed) memcpy(job->message, why, sizeof why);
    failed = norma_mpi_failed(job, failed || closed);
    if (failed)
        norma_file_writer_abandon(job->writer);
    else if (job->writer) {
        const int error = norma_file_writer_commit(job->writer);
        if (error) failed = fail_output(job, error);
    }
    dismiss_guard(job);
    job->writer = NULL;
    job->temporary[0] = '\0';
    return norma_mpi_failed(job, failed);
}

int norma_mpi_copy_share(mpi_job *job, uint64_t from, uint64_t to, uint64_t size) {
    uint64_t at = norma_mpi_share_of(job, size, job->call.rank);
    const uint64_t end = norma_mpi_share_of(job, size, job->call.rank + 1);
    unsigned char *block = norma_core_allocate(&job->core, MPI_BLOCK, 1);
    int failed = block ? 0 : norma_mpi_fail(job, "%s: out of memory", job->input);
    while (at < end && !failed) {
        const size_t some = end - at < MPI_BLOCK ? (size_t)(end - at) : MPI_BLOCK;
        failed = norma_mpi_read(job, from + at, block, some) ||
                 norma_mpi_write(job, to + at, block, some);
        at += some;
    }
    norma_core_release(&job->core, block, MPI_BLOCK, 1);
    return failed;
}
