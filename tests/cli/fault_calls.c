/* fault_calls.c: a program run again and again, each time with one fault at its n-th system call,
 * and the folders that it leaves behind, gathered for a script to judge. Linux's ptrace sees every
 * call of every thread and of every process that it forks, whatever library makes it.
 *
 *     fault_calls MODE FROM WORK STATES -- command...
 *
 * - kill: stopped for good (SIGKILL) before its n-th call;
 * - fail: its n-th call fails, once for each error that the call may have;
 * - short: its n-th read or write moves fewer bytes;
 * - shrink=F, grow=F, scribble=F, halve=F: file F of WORK is changed so before the n-th call;
 * - memory=S: its n-th allocation fails, by the preloaded library S (faults/fail_allocation.c);
 * - trace: no fault; what it did to files, in order.
 *
 * For each n, the folder FROM is copied to WORK, where the command runs; calls count from its first
 * rt_sigaction, with which our tool's main begins. Each different outcome of WORK is kept as
 * STATES/1, /2, ...; temporary files count as one more outcome, whatever is in them. A line for
 * each run: n call error | exit status, or the signal that ended it, negative | state | temporary
 * files | a number for what it printed | first line of stderr; and a last one, "runs N states M".
 * FAULT_ONLY_WRITING=1: from the first call on that makes a file or a folder. */
#define _GNU_SOURCE
#include <stdio.h>
#if !defined(__linux__) || !(defined(__x86_64__) || defined(__aarch64__))
int main(void) {
    puts("not here: system calls are stopped by Linux's ptrace on x86-64 and 64-bit ARM");
    return 77;
}
#else
#include <dirent.h>
#include <elf.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

enum {
    MOST_THREADS = 256,
    MOST_STATES = 4000,
    PATH_ROOM = 4096,
    TELLS_HIT = 199 /* a descriptor */
};

static _Noreturn void die(const char *what) {
    fprintf(stderr, "fault_calls: %s: %s\n", what, strerror(errno));
    exit(99);
}

/* ---- folders */

static void walk(
    const char *path, void (*act)(const char *path, const char *name, void *user), void *user) {
    struct dirent **entries;
    const int count = scandir(path, &entries, NULL, alphasort);
    for (int i = 0; i < count; ++i) {
        if (strcmp(entries[i]->d_name, ".") && strcmp(entries[i]->d_name, ".."))
            act(path, entries[i]->d_name, user);
        free(entries[i]);
    }
    if (count >= 0) free(entries);
}

static void join(char out[PATH_ROOM], const char *folder, const char *name) {
    snprintf(out, PATH_ROOM, "%s/%s", folder, name);
}

static void remove_entry(const char *folder, const char *name, void *user) {
    char path[PATH_ROOM];
    join(path, folder, name);
    if (unlink(path) && (errno == EISDIR || errno == EPERM)) {
        walk(path, remove_entry, user);
        rmdir(path);
    }
}

static void copy_file(const char *from, const char *to, mode_t mode) {
    char block[65536];
    const int in = open(from, O_RDONLY), out = open(to, O_WRONLY | O_CREAT | O_TRUNC, mode);
    if (in < 0 || out < 0) die(to);
    for (ssize_t got; (got = read(in, block, sizeof block)) > 0;)
        if (write(out, block, (size_t)got) != got) die(to);
    close(in);
    close(out);
}

static void copy_entry(const char *folder, const char *name, void *user) {
    char from[PATH_ROOM], to[PATH_ROOM];
    struct stat status;
    join(from, folder, name);
    join(to, user, name);
    if (lstat(from, &status)) die(from);
    if (S_ISDIR(status.st_mode)) {
        mkdir(to, status.st_mode & 07777);
        walk(from, copy_entry, to);
    } else if (S_ISLNK(status.st_mode)) {
        char link[PATH_ROOM];
        const ssize_t length = readlink(from, link, sizeof link - 1);
        link[length > 0 ? length : 0] = '\0';
        if (symlink(link, to)) die(to);
    } else {
        copy_file(from, to, status.st_mode & 07777);
    }
}

static void reset(const char *from, const char *work) {
    if (mkdir(work, 0777) && errno != EEXIST) die(work);
    walk(work, remove_entry, NULL);
    walk(from, copy_entry, (void *)(uintptr_t)work);
}

/* ---- what a folder holds, as one number (FNV-1a) */

typedef struct content {
    uint64_t hash;
    int temporary; /* files that a stopped program may leave */
} content;

static void mix(content *all, const void *bytes, size_t size) {
    const unsigned char *at = bytes;
    for (size_t i = 0; i < size; ++i) all->hash = (all->hash ^ at[i]) * 0x100000001b3u;
}

static int is_temporary(const char *name) {
    const size_t length = strlen(name);
    return strncmp(name, ".norma-", 7) == 0 && length > 4 && strcmp(name + length - 4, ".tmp") == 0;
}

static void add_entry(const char *folder, const char *name, void *user) {
    char path[PATH_ROOM], block[65536];
    content *all = user;
    struct stat status;
    if (is_temporary(name)) {
        ++all->temporary;
        return;
    }
    join(path, folder, name);
    if (lstat(path, &status)) die(path);
    mix(all, name, strlen(name) + 1);
    mix(all, &status.st_mode, sizeof status.st_mode);
    if (S_ISDIR(status.st_mode)) walk(path, add_entry, all);
    if (!S_ISREG(status.st_mode)) return;
    const int in = open(path, O_RDONLY);
    for (ssize_t got; (got = read(in, block, sizeof block)) > 0;) mix(all, block, (size_t)got);
    close(in);
}

static content look(const char *work) {
    content all = {.hash = 0xcbf29ce484222325u};
    walk(work, add_entry, &all);
    return all;
}

/* ---- calls and the errors that they may have */

typedef struct call_kind {
    long number;
    const char *name;
    int errors[5];
} call_kind;

static const call_kind kinds[] = {
    {SYS_openat, "openat", {EINTR, ENFILE, EIO, ENOSPC}},
    {SYS_read, "read", {EINTR, EIO}},
    {SYS_pread64, "pread64", {EINTR, EIO}},
    {SYS_write, "write", {EINTR, ENOSPC, EIO, EDQUOT, EFBIG}},
    {SYS_writev, "writev", {EINTR, ENOSPC, EIO}},
    {SYS_fsync, "fsync", {EINTR, EIO, ENOSPC}},
    {SYS_fdatasync, "fdatasync", {EIO}},
    {SYS_ftruncate, "ftruncate", {EIO}},
    {SYS_close, "close", {EINTR, EIO, ENOSPC}},
#if defined(SYS_open)
    {SYS_open, "open", {EINTR, ENFILE, EIO}},
    {SYS_rename, "rename", {EIO, ENOSPC, EACCES}},
    {SYS_unlink, "unlink", {EIO}},
    {SYS_mkdir, "mkdir", {ENOSPC, EACCES}},
    {SYS_chmod, "chmod", {EPERM}},
    {SYS_stat, "stat", {EIO}},
    {SYS_access, "access", {EIO}},
    {SYS_readlink, "readlink", {EIO}},
    {SYS_link, "link", {EIO, ENOSPC}},
    {SYS_rmdir, "rmdir", {EIO}},
#endif
    {SYS_renameat, "renameat", {EIO, ENOSPC, EACCES}},
    {SYS_renameat2, "renameat2", {EIO, ENOSPC, EACCES}},
    {SYS_unlinkat, "unlinkat", {EIO}},
    {SYS_linkat, "linkat", {EIO, ENOSPC, ENOENT}},
    {SYS_mkdirat, "mkdirat", {ENOSPC, EACCES}},
    {SYS_fchmod, "fchmod", {EPERM}},
    {SYS_fchown, "fchown", {EPERM}},
    {SYS_fstat, "fstat", {EIO}},
    {SYS_newfstatat, "newfstatat", {EIO}},
    {SYS_faccessat, "faccessat", {EIO}},
    {SYS_readlinkat, "readlinkat", {EIO}},
    {SYS_mmap, "mmap", {ENOMEM, EAGAIN}},
    {SYS_mremap, "mremap", {ENOMEM}},
    {SYS_brk, "brk", {0}}, /* never answers with an error */
    {SYS_madvise, "madvise", {EINVAL}},
    {SYS_munmap, "munmap", {ENOMEM}},
    {SYS_getdents64, "getdents64", {EIO}},
    {SYS_clone, "clone", {EAGAIN}},
#if defined(SYS_clone3)
    {SYS_clone3, "clone3", {EAGAIN}},
#endif
    {SYS_lseek, "lseek", {EINVAL}},
    {SYS_fcntl, "fcntl", {EBADF}},
    {SYS_umask, "umask", {0}},
};

static const char *error_name(int error) {
    static const struct {
        int error;
        const char *name;
    } names[] = {{EINTR, "EINTR"}, {EIO, "EIO"}, {ENOSPC, "ENOSPC"}, {EDQUOT, "EDQUOT"},
        {EFBIG, "EFBIG"}, {EACCES, "EACCES"}, {EPERM, "EPERM"}, {ENOENT, "ENOENT"},
        {ENFILE, "ENFILE"}, {ENOMEM, "ENOMEM"}, {EAGAIN, "EAGAIN"}, {EINVAL, "EINVAL"},
        {EBADF, "EBADF"}};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        if (names[i].error == error) return names[i].name;
    return "another";
}

static const call_kind *kind_of(long number) {
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i)
        if (kinds[i].number == number) return &kinds[i];
    return NULL;
}

static int makes_a_file(long number, const uint64_t *args) {
    if (number == SYS_openat) return (args[2] & O_CREAT) != 0 || (args[2] & O_TMPFILE) == O_TMPFILE;
#if defined(SYS_open)
    if (number == SYS_open) return (args[1] & O_CREAT) != 0;
    if (number == SYS_mkdir) return 1;
#endif
    return number == SYS_mkdirat;
}

/* ---- one run */

typedef enum mode { KILL, FAIL, SHORT, CHANGE, MEMORY, TRACE } mode;

typedef struct thread {
    pid_t id;
    int error, traced; /* error: what its call is to answer */
    struct __ptrace_syscall_info entry;
} thread;

typedef struct run {
    mode mode;
    size_t at; /* the call that is hit; 0: none */
    int error_index, error;
    void (*change)(const char *file);
    const char *file;
    int only_writing;
    size_t counted; /* calls so far; 0: its main has not begun */
    int begun, hit, more_errors;
    int tell[2];      /* of a preloaded library: that it was hit */
    const char *call; /* the name of the one that was hit */
    pid_t child;
    int status; /* exit status, or minus the signal */
    thread threads[MOST_THREADS];
} run;

static thread *thread_of(run *r, pid_t id) {
    thread *empty = NULL;
    for (size_t i = 0; i < MOST_THREADS; ++i) {
        if (r->threads[i].id == id) return &r->threads[i];
        if (!r->threads[i].id && !empty) empty = &r->threads[i];
    }
    if (!empty) die("too many threads");
    *empty = (thread){.id = id};
    return empty;
}

#if defined(__x86_64__)
static void set_registers(pid_t id, long call, long result, long third, int change_third) {
    struct user_regs_struct regs;
    if (ptrace(PTRACE_GETREGS, id, NULL, &regs)) return;
    if (call < 0) regs.orig_rax = (unsigned long long)call;
    if (result) regs.rax = (unsigned long long)result;
    if (change_third) regs.rdx = (unsigned long long)third;
    ptrace(PTRACE_SETREGS, id, NULL, &regs);
}
#else
static void set_registers(pid_t id, long call, long result, long third, int change_third) {
    struct user_regs_struct regs;
    struct iovec part = {&regs, sizeof regs};
    if (call < 0) {
        int number = -1;
        struct iovec one = {&number, sizeof number};
        ptrace(PTRACE_SETREGSET, id, (void *)NT_ARM_SYSTEM_CALL, &one);
    }
    if (!result && !change_third) return;
    if (ptrace(PTRACE_GETREGSET, id, (void *)NT_PRSTATUS, &part)) return;
    if (result) regs.regs[0] = (unsigned long long)result;
    if (change_third) regs.regs[2] = (unsigned long long)third;
    ptrace(PTRACE_SETREGSET, id, (void *)NT_PRSTATUS, &part);
}
#endif

static void read_text(pid_t id, uint64_t address, char text[PATH_ROOM]) {
    struct iovec here = {text, PATH_ROOM - 1}, there = {(void *)(uintptr_t)address, 256};
    here.iov_len = 256;
    ssize_t got = process_vm_readv(id, &here, 1, &there, 1, 0);
    if (got < 0) { /* near the end of a page */
        here.iov_len = there.iov_len = 4096 - address % 4096;
        got = process_vm_readv(id, &here, 1, &there, 1, 0);
    }
    text[got > 0 ? got : 0] = '\0';
}

/* A line for what matters to the order in which things reach the disk. */
static void tell(const thread *t, long result) {
    char a[PATH_ROOM] = "", b[PATH_ROOM] = "";
    const uint64_t *args = t->entry.entry.args;
    const long number = (long)t->entry.entry.nr;
    if (result < 0) return;
    switch (number) {
    case SYS_openat:
        read_text(t->id, args[1], a);
        printf("open %ld %s%s%s\n", result, a, args[2] & O_CREAT ? " create" : "",
            (args[2] & O_TMPFILE) == O_TMPFILE ? " nameless" : "");
        break;
    case SYS_write:
        printf("write %d %ld\n", (int)args[0], result);
        break;
    case SYS_fsync:
    case SYS_fdatasync:
        printf("fsync %d\n", (int)args[0]);
        break;
    case SYS_close:
        printf("close %d\n", (int)args[0]);
        break;
#if defined(SYS_rename)
    case SYS_rename:
        read_text(t->id, args[0], a), read_text(t->id, args[1], b);
        printf("rename %s %s\n", a, b);
        break;
    case SYS_unlink:
        read_text(t->id, args[0], a);
        printf("unlink %s\n", a);
        break;
    case SYS_mkdir:
        read_text(t->id, args[0], a);
        printf("mkdir %s\n", a);
        break;
#endif
    case SYS_renameat:
    case SYS_renameat2:
        read_text(t->id, args[1], a), read_text(t->id, args[3], b);
        printf("rename %s %s\n", a, b);
        break;
    case SYS_linkat:
        read_text(t->id, args[1], a), read_text(t->id, args[3], b);
        printf("link %s %s\n", a, b);
        break;
    case SYS_unlinkat:
        read_text(t->id, args[1], a);
        printf("unlink %s\n", a);
        break;
    case SYS_mkdirat:
        read_text(t->id, args[1], a);
        printf("mkdir %s\n", a);
        break;
    default:
        break;
    }
}

/* Whether this kind of fault can hit this call. */
static int can_hit(run *r, long number) {
    const call_kind *kind = kind_of(number);
    if (r->mode == KILL || r->mode == CHANGE) return 1;
    if (r->mode == SHORT) return number == SYS_read || number == SYS_write || number == SYS_pread64;
    return r->mode == FAIL && kind && kind->errors[0];
}

static void hit(run *r, thread *t) {
    static char unknown[32];
    const long number = (long)t->entry.entry.nr;
    const call_kind *kind = kind_of(number);
    snprintf(unknown, sizeof unknown, "%ld", number);
    r->call = kind ? kind->name : unknown;
    r->hit = 1;
    if (r->mode == KILL) {
        kill(t->id, SIGKILL); /* its process: the tool, or its worker */
    } else if (r->mode == CHANGE) {
        r->change(r->file);
    } else if (r->mode == SHORT) {
        const long size = (long)t->entry.entry.args[2];
        set_registers(t->id, 0, 0, size > 1 ? size / 2 : size, 1);
    } else if (r->mode == FAIL) {
        t->error = r->error = kind->errors[r->error_index];
        r->more_errors = r->error_index + 1 < (int)(sizeof kind->errors / sizeof *kind->errors) &&
                         kind->errors[r->error_index + 1];
        /* A close that fails has closed all the same, as on Linux. */
        if (number != SYS_close) set_registers(t->id, -1, 0, 0, 0);
    }
}

static void on_call(run *r, thread *t) {
    struct __ptrace_syscall_info info = {0};
    if (ptrace(PTRACE_GET_SYSCALL_INFO, t->id, sizeof info, &info) <= 0) return;
    if (info.op == PTRACE_SYSCALL_INFO_ENTRY) {
        t->entry = info;
        const long number = (long)info.entry.nr;
        if (number == SYS_rt_sigaction && !r->only_writing) r->begun = 1;
        if (r->only_writing && makes_a_file(number, info.entry.args)) r->begun = 1;
        if (r->begun && can_hit(r, number) && ++r->counted == r->at) hit(r, t);
    } else if (info.op == PTRACE_SYSCALL_INFO_EXIT) {
        if (t->error) set_registers(t->id, 0, -t->error, 0, 0);
        t->error = 0;
        if (r->mode == TRACE && r->begun) tell(t, (long)info.exit.rval);
    }
}

static void start(run *r, const char *work, char **command) {
    char out[PATH_ROOM], err[PATH_ROOM];
    if (r->mode == MEMORY && pipe2(r->tell, O_NONBLOCK | O_CLOEXEC)) die("pipe");
    snprintf(out, sizeof out, "%s.out", work);
    snprintf(err, sizeof err, "%s.err", work);
    fflush(stdout);
    r->child = fork();
    if (r->child < 0) die("fork");
    if (r->child > 0) return;
    const int to_out = open(out, O_WRONLY | O_CREAT | O_TRUNC, 0666),
              to_err = open(err, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    dup2(to_out, 1);
    dup2(to_err, 2);
    close(to_out);
    close(to_err);
    if (chdir(work) || (r->mode != MEMORY && ptrace(PTRACE_TRACEME, 0, NULL, NULL))) _exit(98);
    if (r->mode == MEMORY) {
        char number[32];
        snprintf(number, sizeof number, "%zu", r->at);
        setenv("LD_PRELOAD", r->file, 1);
        setenv("FAULT_ALLOCATION", number, 1);
        dup2(r->tell[1], TELLS_HIT);
    } else {
        raise(SIGSTOP);
    }
    execvp(command[0], command);
    _exit(97);
}

static void wait_for(run *r) {
    int status;
    char byte;
    if (waitpid(r->child, &status, 0) != r->child) die("the command did not start");
    r->status = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    r->hit = read(r->tell[0], &byte, 1) == 1;
    r->call = "allocation";
    close(r->tell[0]);
    close(r->tell[1]);
}

/* Until the command has ended. */
static void follow(run *r) {
    int status;
    if (waitpid(r->child, &status, __WALL) != r->child || !WIFSTOPPED(status))
        die("the command did not start");
    ptrace(PTRACE_SETOPTIONS, r->child, NULL,
        PTRACE_O_EXITKILL | PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACECLONE | PTRACE_O_TRACEFORK |
            PTRACE_O_TRACEVFORK | PTRACE_O_TRACEEXEC);
    ptrace(PTRACE_SYSCALL, r->child, NULL, NULL);
    for (;;) {
        const pid_t id = waitpid(-1, &status, __WALL);
        if (id < 0) return;
        if (WIFEXITED(status) || WIFSIGNALED(status)) {
            if (id == r->child)
                r->status = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
            continue;
        }
        thread *t = thread_of(r, id);
        int signal = WSTOPSIG(status);
        if (signal == (SIGTRAP | 0x80)) {
            on_call(r, t);
            signal = 0;
        } else if (signal == SIGTRAP || (signal == SIGSTOP && !t->traced)) {
            signal = 0; /* an event, or a thread's first stop */
        }
        t->traced = 1;
        ptrace(PTRACE_SYSCALL, id, NULL, (void *)(intptr_t)signal);
    }
}

/* ---- changes to a file while it is read */

static void shrink(const char *file) {
    if (truncate(file, 0)) die(file);
}

static void halve(const char *file) {
    struct stat status;
    if (stat(file, &status) || truncate(file, status.st_size / 2)) die(file);
}

static void grow(const char *file) {
    struct stat status;
    if (stat(file, &status) || truncate(file, status.st_size * 3 + 8192)) die(file);
}

/* Other numbers, far beyond every array, in the second half: the header stays as it is. */
static void scribble(const char *file) {
    unsigned char block[4096];
    struct stat status;
    const int out = open(file, O_WRONLY);
    memset(block, 0x7f, sizeof block);
    if (out < 0 || fstat(out, &status)) die(file);
    for (off_t at = status.st_size / 2; at < status.st_size; at += (off_t)sizeof block)
        if (pwrite(out, block,
                (size_t)(status.st_size - at < (off_t)sizeof block ? status.st_size - at
                                                                   : (off_t)sizeof block),
                at) < 0)
            die(file);
    close(out);
}

/* ---- all runs */

typedef struct states {
    uint64_t seen[MOST_STATES];
    size_t count;
} states;

static size_t state_of(states *all, const content *now, const char *work, const char *folder) {
    for (size_t i = 0; i < all->count; ++i)
        if (all->seen[i] == now->hash) return i + 1;
    if (all->count == MOST_STATES) die("too many outcomes");
    char kept[PATH_ROOM];
    all->seen[all->count++] = now->hash;
    snprintf(kept, sizeof kept, "%s/%zu", folder, all->count);
    reset(work, kept);
    return all->count;
}

/* Where memory is out, lines are broken elsewhere: blanks do not count. */
static uint64_t printed(const char *work) {
    char path[PATH_ROOM], block[65536];
    content all = {.hash = 0xcbf29ce484222325u};
    snprintf(path, sizeof path, "%s.out", work);
    const int in = open(path, O_RDONLY);
    for (ssize_t got; in >= 0 && (got = read(in, block, sizeof block)) > 0;)
        for (ssize_t i = 0; i < got; ++i)
            if (block[i] != ' ' && block[i] != '\n') mix(&all, &block[i], 1);
    close(in);
    return all.hash;
}

/* The first line of a file that has the words in it; NULL: the first. */
static int find_line(const char *work, const char *ending, const char *words, char line[400]) {
    char path[PATH_ROOM];
    int found = 0;
    snprintf(path, sizeof path, "%s%s", work, ending);
    FILE *in = fopen(path, "r");
    while (in && !found && fgets(line, 400, in)) found = !words || strcasestr(line, words);
    if (in) fclose(in);
    line[found ? strcspn(line, "\n") : 0] = '\0';
    return found;
}

/* What was said, wherever: reports of files that could not be read go to standard output. */
static void find_message(const run *r, const char *work, char line[400]) {
    static const char *const words[] = {
        "out of memory", "cannot allocate memory", "memory could not be allocated"};
    for (size_t i = 0; r->mode == MEMORY && i < sizeof words / sizeof *words; ++i)
        if (find_line(work, ".err", words[i], line) || find_line(work, ".out", words[i], line))
            return;
    find_line(work, ".err", NULL, line);
}

static mode mode_of(const char *word, run *r) {
    static const struct {
        const char *name;
        void (*change)(const char *);
    } changes[] = {{"shrink", shrink}, {"halve", halve}, {"grow", grow}, {"scribble", scribble}};
    const char *equals = strchr(word, '=');
    if (strncmp(word, "memory=", 7) == 0) {
        r->file = word + 7;
        return MEMORY;
    }
    for (size_t i = 0; equals && i < sizeof changes / sizeof *changes; ++i)
        if (strncmp(word, changes[i].name, (size_t)(equals - word)) == 0) {
            r->change = changes[i].change;
            r->file = equals + 1;
            return CHANGE;
        }
    if (strcmp(word, "kill") == 0) return KILL;
    if (strcmp(word, "fail") == 0) return FAIL;
    if (strcmp(word, "short") == 0) return SHORT;
    if (strcmp(word, "trace") == 0) return TRACE;
    errno = EINVAL;
    die(word);
}

int main(int count, char **words) {
    static run r;
    static states all;
    if (count < 7 || strcmp(words[5], "--")) {
        fputs("usage: fault_calls MODE FROM WORK STATES -- command...\n", stderr);
        return 2;
    }
    const char *from = words[2], *work = words[3], *folder = words[4];
    char file[PATH_ROOM], line[400];
    size_t runs = 0;
    mkdir(folder, 0777);
    int error_index = 0;
    for (size_t at = 1;;) {
        memset(&r, 0, sizeof r);
        r.mode = mode_of(words[1], &r);
        r.at = r.mode == TRACE ? 0 : at;
        r.error_index = error_index;
        r.only_writing = getenv("FAULT_ONLY_WRITING") != NULL;
        r.call = "none";
        if (r.file && r.mode == CHANGE) {
            join(file, work, r.file);
            r.file = file;
        }
        reset(from, work);
        start(&r, work, words + 6);
        if (r.mode == MEMORY)
            wait_for(&r);
        else
            follow(&r);
        const content now = look(work);
        find_message(&r, work, line);
        printf("%zu %s %s | %d | %zu | %d | %016" PRIx64 " | %s\n", r.hit ? at : 0, r.call,
            r.error ? error_name(r.error) : "-", r.status, state_of(&all, &now, work, folder),
            now.temporary, printed(work), line);
        ++runs;
        if (!r.hit) break;
        error_index = r.more_errors ? error_index + 1 : 0;
        at += !r.more_errors;
    }
    printf("runs %zu states %zu\n", runs, all.count);
    return 0;
}
#endif
