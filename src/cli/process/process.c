/* process.c: this process: errors and exit statuses, memory, progress and signals, workers. */
#define _POSIX_C_SOURCE 200809L
#define _DEFAULT_SOURCE /* BUS_ADRERR, kill, strsignal */
#include "cli/process/process.h"
#include "cli/text/text.h"
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* ---- What went wrong, in one line on standard error, and the exit status that follows. */

const char *cli_input_name(const char *input) {
    return strcmp(input, "-") ? input : "standard input";
}

int cli_out_of_memory(void) {
    char limit[CLI_LIMIT_ROOM];
    cli_memory_limit_words(limit);
    cli_error("out of memory%s", limit);
    return CLI_FILE;
}

void *cli_grow(void *list, size_t count, size_t *room, size_t size) {
    if (count < *room) return list;
    const size_t more = *room ? 2 * *room : 64;
    void *grown = more > SIZE_MAX / size ? NULL : realloc(list, more * size);
    if (grown) *room = more;
    return grown;
}

int cli_status_of(norma_document_result result) {
    return result == NORMA_DOCUMENT_OK               ? CLI_OK
           : result == NORMA_DOCUMENT_ERROR_ARGUMENT ? CLI_USAGE
                                                     : CLI_FILE;
}

int cli_worse(int status, int other) { return other > status ? other : status; }

/* For an error that came without a message: nothing ends in silence. */
static const char *plain_reason(norma_document_result result) {
    static const char *const reasons[] = {
        [-NORMA_DOCUMENT_ERROR_MALFORMED] = "is malformed",
        [-NORMA_DOCUMENT_ERROR_UNSUPPORTED] = "contains something that this version cannot read",
        [-NORMA_DOCUMENT_ERROR_REFUSED] = "was refused",
        [-NORMA_DOCUMENT_ERROR_MEMORY] = "out of memory",
        [-NORMA_DOCUMENT_ERROR_ARGUMENT] = "does not contain the requested data",
    };
    const char *reason = result < 0 ? reasons[-result] : NULL;
    return reason ? reason : "cannot be read or written";
}

static const char reported_already[] = "reported already";

norma_document_result cli_reported(norma_document_error *error) {
    error->result = NORMA_DOCUMENT_ERROR_FILE;
    snprintf(error->message, sizeof error->message, "%s", reported_already);
    return error->result;
}

/* One wording for every place that can run out of memory; names the limit if one was set. */
static void name_limit(norma_document_error *error, const char *input) {
    char limit[CLI_LIMIT_ROOM];
    cli_memory_limit_words(limit);
    snprintf(error->message, sizeof error->message, "%.800s: out of memory%s",
        cli_input_name(input), limit);
}

void cli_name_error(norma_document_error *error, const char *input) {
    static const char nameless[] = "<memory>";
    char rest[sizeof error->message];
    if (error->result && !error->message[0])
        snprintf(error->message, sizeof error->message, "%.900s: %s", cli_input_name(input),
            plain_reason(error->result));
    if (error->result == NORMA_DOCUMENT_ERROR_MEMORY) name_limit(error, input);
    if (error->message[0] == ':') {
        strcpy(rest, error->message);
        snprintf(
            error->message, sizeof error->message, "%.400s%.400s", cli_input_name(input), rest);
    }
    if (strncmp(error->message, nameless, sizeof nameless - 1) != 0) return;
    strcpy(rest, error->message + sizeof nameless - 1);
    snprintf(error->message, sizeof error->message, "standard input%.900s", rest);
}

void cli_lost_error(norma_document_error *error, const char *input, const char *why) {
    *error = (norma_document_error){.result = NORMA_DOCUMENT_ERROR_FILE};
    snprintf(error->message, sizeof error->message, ": %s", why);
    cli_name_error(error, input);
}

void cli_print_error(const norma_document_error *error) {
    if (strcmp(error->message, reported_already) != 0) cli_error("%s", error->message);
}

void cli_print_notes(const char *input, const norma_document *document) {
    const size_t most = 20;
    size_t count = norma_document_note_count(document);
    for (size_t i = 0; i < count && i < most; ++i)
        cli_error("%s: note: %s", cli_input_name(input), norma_document_note(document, i));
    if (count > most)
        cli_error(
            "%s: note: and %zu more; --json has them all", cli_input_name(input), count - most);
}

int cli_finish(int status) {
    if (fflush(stdout) == 0 && !ferror(stdout)) return status;
    cli_error("standard output: cannot be written: %s", strerror(errno));
    return cli_worse(status, CLI_FILE);
}

/* ---- --max-memory limits the memory of this process. The system refuses every block
 * beyond the limit. What can be done in parts is done in parts that fit; an input that needs more
 * in one piece ends with "out of memory" and status 3, as on a machine without more memory. */

#if defined(__unix__) || defined(__APPLE__)
#include <sys/resource.h>
#include <unistd.h>
#endif

/* Reads 512M, 1.5G or 1000000 (bytes). Returns 0 if the text is not a size. */
static double read_bytes(const char *text) {
    static const char units[] = "KMGT";
    char *rest;
    if (strspn(text, "0123456789.") == 0) return 0;
    double bytes = strtod(text, &rest);
    const char *unit =
        *rest ? strchr(units, *rest >= 'a' && *rest <= 'z' ? *rest - 'a' + 'A' : *rest) : NULL;
    for (const char *u = units; unit && u <= unit; ++u) bytes *= 1024;
    rest += unit != NULL;
    return *rest == '\0' || (unit && (strcmp(rest, "B") == 0 || strcmp(rest, "iB") == 0))
               ? floor(bytes)
               : 0;
}

const char *cli_limit_memory(const char *value) {
    double bytes = read_bytes(value);
    if (!(bytes >= 1 && bytes < 9e18)) return "a number of bytes, or one with K, M, G or T";
#if defined(RLIMIT_DATA)
    struct rlimit limit;
    if (getrlimit(RLIMIT_DATA, &limit)) return "a limit that this system can set";
    if (limit.rlim_max == RLIM_INFINITY || bytes < (double)limit.rlim_max)
        limit.rlim_cur = (rlim_t)bytes;
    return setrlimit(RLIMIT_DATA, &limit) ? "a limit that this system can set" : NULL;
#else
    return "no --max-memory, because this system cannot limit the memory of a process";
#endif
}

/* As --max-memory takes it: 512M. */
static void write_bytes(char *text, size_t room, unsigned long long bytes) {
    static const char units[] = "\0KMGT";
    size_t unit = 0;
    for (; unit < 4 && bytes && bytes % 1024 == 0; ++unit) bytes /= 1024;
    snprintf(text, room, "%llu%s%c", bytes, unit ? "" : " bytes", units[unit]);
}

/* Without a limit, what the machine has, less what it needs itself. */
static uint64_t machine_memory(void) {
#if defined(_SC_PHYS_PAGES)
    const double bytes = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    return bytes > 0 ? (uint64_t)(bytes * 0.85) : UINT64_MAX;
#else
    return UINT64_MAX;
#endif
}

/* In bytes: what the option allows, else what this machine has. */
static uint64_t cli_memory_limit(void) {
    const uint64_t machine = machine_memory();
#if defined(RLIMIT_DATA)
    struct rlimit limit;
    if (getrlimit(RLIMIT_DATA, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
        (uint64_t)limit.rlim_cur < machine)
        return (uint64_t)limit.rlim_cur;
#endif
    return machine;
}

uint64_t cli_memory_for_data(void) {
    const uint64_t limit = cli_memory_limit(), program = (uint64_t)32 << 20;
    return limit > 4 * program ? limit - program - limit / 16 : limit / 2;
}

void cli_memory_limit_words(char text[CLI_LIMIT_ROOM]) {
    text[0] = '\0';
#if defined(RLIMIT_DATA)
    struct rlimit limit;
    char bytes[40];
    if (getrlimit(RLIMIT_DATA, &limit) || limit.rlim_cur == RLIM_INFINITY) return;
    write_bytes(bytes, sizeof bytes, (unsigned long long)limit.rlim_cur);
    snprintf(text, CLI_LIMIT_ROOM, "; memory is limited to %s (--max-memory)", bytes);
#else
    (void)write_bytes;
#endif
}

/* ---- A line on stderr while a person waits, and Ctrl-C. Only while an output is written is
 * there anything to tidy up: then a signal sets a flag, which the library's progress callback turns
 * into a cancel. At any other time it ends the process where it is, whatever is being read,
 * computed or drawn, and however long the next callback would take. */

/* The variables of the tool: a signal handler has no other way to know anything. */
static volatile sig_atomic_t caught_signal, caught_count, line_shown;
static atomic_int writers;
static const char *volatile left_behind;
static volatile sig_atomic_t worker_process,
    is_worker; /* the process of another, or whether this is one */

static _Noreturn void end_now(int number) {
    static const char words[] = "\r\033[Knorma: interrupted\n";
    const size_t clear = line_shown ? 0 : 4;
    if (!is_worker) { /* else the caller says so */
        const ssize_t written = write(STDERR_FILENO, words + clear, sizeof words - 1 - clear);
        (void)written;
    }
    if (left_behind) unlink(left_behind);
    _exit(128 + number);
}

/* Three times: someone insists, while a write does not come back. A worker hears a terminal's
 * signals twice, once from its caller, which waits for it. */
static void catch_signal(int number) {
    enum { INSISTING = 3 };
    const int insists = ++caught_count >= INSISTING * (is_worker ? 2 : 1);
    caught_signal = number;
    if (worker_process) kill((pid_t)worker_process, insists ? SIGKILL : number);
    if (insists || (!worker_process && atomic_load(&writers) == 0)) end_now(number);
}

/* A process that is worked in: signals go on to it, and end this one when it has ended; 0: it has.
 */
static void cli_watch_worker(int process) {
    worker_process = process;
    if (!process && caught_signal) end_now(caught_signal);
}

/* this is such a process */
static void cli_be_worker(void) {
    is_worker = 1;
    worker_process = 0;
    left_behind = NULL;
}

void cli_tidy_when_ended(const char *path) { left_behind = path; }

void cli_writing_begin(void) { atomic_fetch_add(&writers, 1); }

void cli_writing_end(void) {
    if (atomic_fetch_sub(&writers, 1) == 1 && caught_signal) end_now(caught_signal);
}

void cli_watch_interrupts(void) {
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    struct sigaction action = {.sa_handler = catch_signal}, old;
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i)
        if (sigaction(numbers[i], NULL, &old) == 0 &&
            old.sa_handler != SIG_IGN) /* ignored: as nohup wants it */
            sigaction(numbers[i], &action, NULL);
    setvbuf(stdout, NULL, _IOLBF, 0); /* what was printed of earlier files is not lost */
    signal(SIGXFSZ,
        SIG_IGN); /* a file over its limit is then an error like a full disk, which tidies up */
}

int cli_interrupted(void) { return caught_signal != 0; }

static double now(void) {
    struct timespec time;
    return clock_gettime(CLOCK_MONOTONIC, &time)
               ? 0
               : (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static int progress_channel = -1;

void cli_progress_send(int descriptor) { progress_channel = descriptor; }

void cli_progress_start(
    cli_progress *progress, const char *what, const char *name, int quiet, double megabytes) {
    const char *terminal = getenv("TERM");
    int person = isatty(STDERR_FILENO) && terminal && strcmp(terminal, "dumb") != 0;
    *progress = (cli_progress){.enabled = !quiet && (person || progress_channel >= 0),
        .what = what,
        .name = name,
        .megabytes = megabytes,
        .began = now()};
    progress->said = progress->began;
}

/* Stages of work differ in speed: the time that is left is known once the same whole is expected,
 * to a half, for a second. */
static int is_steady(cli_progress *progress, double fraction, double elapsed) {
    const double whole = fraction > 0 ? elapsed / fraction : 0;
    if (!(whole < 1.5 * progress->whole && 1.5 * whole > progress->whole)) {
        progress->whole = whole;
        progress->steady_from = elapsed;
    }
    return elapsed - progress->steady_from >= 1;
}

static void show(cli_progress *progress, double fraction, double elapsed) {
    if (progress_channel >= 0) {
        const ssize_t written = write(progress_channel, &fraction, sizeof fraction);
        (void)written;
        return;
    }
    fprintf(stderr, "\r%s ", progress->what);
    cli_write_outside_cut(stderr,
        strrchr(progress->name, '/') ? strrchr(progress->name, '/') + 1 : progress->name, 40);
    if (fraction < 0) /* how much there is to do is not known */
        fprintf(stderr, ": %.0f s", elapsed);
    else
        fprintf(stderr, ": %3.0f %%", 100 * fraction);
    if (fraction >= 0 && progress->megabytes > 0)
        fprintf(stderr, ", %.1f MB/s", progress->megabytes * fraction / elapsed);
    if (fraction >= 0 && !progress->is_uneven && is_steady(progress, fraction, elapsed))
        fprintf(stderr, ", %.0f s left", elapsed * (1 - fraction) / fraction);
    fputs("\033[K", stderr);
    fflush(stderr);
    line_shown = 1;
}

static void show_in_time(cli_progress *progress, double fraction) {
    const double first_wait = 0.7, between = 0.1; /* seconds: short work shows nothing */
    if (!progress->enabled) return;
    const double time = now(), elapsed = time - progress->began;
    if (elapsed < first_wait || time - progress->said < between) return;
    show(progress, fraction, elapsed);
    progress->said = time;
}

int cli_progress_report(void *user, double fraction) {
    if (fraction >= 0 && fraction <= 1) show_in_time(user, fraction);
    return cli_interrupted();
}

int cli_progress_elapsed(void *user, double fraction) {
    (void)fraction;
    show_in_time(user, -1);
    return cli_interrupted();
}

void cli_progress_hide(cli_progress *progress) {
    if (progress->enabled && line_shown) {
        fputs("\r\033[K", stderr);
        fflush(stderr);
        line_shown = 0;
    }
}

/* ---- a thread that shows the seconds */

struct cli_ticker {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t ended;
    int stop;
    cli_progress *progress;
};

static void *tick(void *user) {
    struct cli_ticker *ticker = user;
    pthread_mutex_lock(&ticker->lock);
    while (!ticker->stop) {
        struct timespec next;
        clock_gettime(CLOCK_REALTIME, &next);
        next.tv_nsec += 100000000;
        next.tv_sec += next.tv_nsec / 1000000000;
        next.tv_nsec %= 1000000000;
        pthread_cond_timedwait(&ticker->ended, &ticker->lock, &next);
        if (!ticker->stop) show_in_time(ticker->progress, -1);
    }
    pthread_mutex_unlock(&ticker->lock);
    return NULL;
}

void cli_progress_tick(cli_progress *progress) {
    struct cli_ticker *ticker = progress->enabled ? calloc(1, sizeof *ticker) : NULL;
    if (!ticker) return;
    ticker->progress = progress;
    pthread_mutex_init(&ticker->lock, NULL);
    pthread_cond_init(&ticker->ended, NULL);
    if (pthread_create(&ticker->thread, NULL, tick, ticker) == 0)
        progress->ticker = ticker;
    else
        free(ticker);
}

static void stop_ticker(struct cli_ticker *ticker) {
    pthread_mutex_lock(&ticker->lock);
    ticker->stop = 1;
    pthread_cond_signal(&ticker->ended);
    pthread_mutex_unlock(&ticker->lock);
    pthread_join(ticker->thread, NULL);
    pthread_cond_destroy(&ticker->ended);
    pthread_mutex_destroy(&ticker->lock);
    free(ticker);
}

void cli_progress_stop(cli_progress *progress) {
    if (progress->ticker) stop_ticker(progress->ticker);
    progress->ticker = NULL;
    cli_progress_hide(progress);
    progress->enabled = 0;
}

/* ---- What a caller may have taken from the tool, or another program may take from it
 * while it runs: standard streams, and files that are mapped. */

/* Without standard output or error, the next file that is opened would be taken for it, and a
 * report would be written into it. What stands there instead cannot be used either, so that writing
 * fails as it should. */
static void hold_standard_streams(void) {
    for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor)
        if (fcntl(descriptor, F_GETFD) < 0 && errno == EBADF &&
            open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY) < 0)
            _exit(CLI_FILE);
}

#if defined(__linux__) && defined(BUS_ADRERR)
/* Of /proc/self/maps, byte by byte: a signal handler has no library. -1: its end. */
static int next_byte(int maps) {
    unsigned char byte;
    return maps >= 0 && read(maps, &byte, 1) == 1 ? byte : -1;
}

static uintptr_t read_hex(int maps) {
    static const char digits[] = "0123456789abcdef";
    uintptr_t number = 0;
    for (int byte; (byte = next_byte(maps)) > 0;) {
        const char *digit = strchr(digits, byte);
        if (!digit) break;
        number = number << 4 | (uintptr_t)(digit - digits);
    }
    return number;
}

/* "start-end rights offset device inode name": the name of the file that lies at address; "" where
 * none does. */
static void find_mapped(uintptr_t address, char *name, size_t room) {
    const int maps = open("/proc/self/maps", O_RDONLY | O_CLOEXEC);
    int byte = 0, found = 0;
    size_t length = 0;
    while (byte >= 0 && !found) {
        const uintptr_t start = read_hex(maps), end = read_hex(maps);
        found = start <= address && address < end;
        length = 0;
        while ((byte = next_byte(maps)) >= 0 && byte != '\n')
            if (found && (length > 0 || byte == '/') && length + 1 < room)
                name[length++] = (char)(byte < 0x20 || byte >= 0x7F ? '?' : byte);
    }
    if (maps >= 0) close(maps);
    name[found ? length : 0] = '\0';
}

static size_t append_words(char *text, size_t used, size_t room, const char *more) {
    for (; *more && used < room; ++more) text[used++] = *more;
    return used;
}

/* Bytes of a mapped file are gone. Nothing is half-written: what was being written has no name yet.
 */
static void catch_lost_bytes(int number, siginfo_t *info, void *context) {
    char name[1024];
    (void)context;
    find_mapped((uintptr_t)info->si_addr, name, sizeof name);
    if (info->si_code != BUS_ADRERR || !name[0]) {
        signal(number, SIG_DFL); /* no file's: the same again, and the end */
        return;
    }
    char text[sizeof name + 128]; /* in one piece: other threads may say the same */
    size_t used = append_words(text, 0, sizeof text, "norma: ");
    used = append_words(text, used, sizeof text, name);
    used = append_words(
        text, used, sizeof text, ": cannot be read: another program truncated it meanwhile\n");
    const ssize_t written = write(STDERR_FILENO, text, used);
    (void)written;
    _exit(CLI_FILE);
}

static void watch_mapped_files(void) {
    struct sigaction action = {.sa_sigaction = catch_lost_bytes, .sa_flags = SA_SIGINFO};
    sigemptyset(&action.sa_mask);
    sigaction(SIGBUS, &action, NULL);
}
#else
static void watch_mapped_files(void) {}
#endif

void cli_startup_checks(void) {
    hold_standard_streams();
    watch_mapped_files();
}

/* ---- Processes for the files of a batch, by fork. One process works on all files; only
 * behind a file that ended it another one is made, so that a batch without faults costs one fork.
 */

#if defined(__linux__)
#include <sys/prctl.h>
#endif

/* Whatever ends the caller ends its worker. */
static void follow_caller(void) {
#if defined(__linux__)
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
}

int cli_worker_start(cli_worker *worker) {
    int ends[2];
    if (pipe(ends)) return -1;
    fflush(NULL); /* else the worker would write it again */
    const pid_t process = fork();
    worker->process = (int)process;
    worker->channel = ends[process == 0];
    close(ends[process != 0]);
    if (process == 0) {
        follow_caller();
        cli_be_worker();
    } else if (process > 0) {
        cli_watch_worker(worker->process);
    } else {
        close(worker->channel);
    }
    return process < 0 ? -1 : process > 0;
}

void cli_worker_send(const cli_worker *worker, const void *bytes, size_t size) {
    const char *at = bytes;
    while (size > 0) {
        const ssize_t written = write(worker->channel, at, size);
        if (written < 0 && errno != EINTR) _exit(CLI_FILE); /* nobody is there to read it */
        at += written > 0 ? written : 0;
        size -= written > 0 ? (size_t)written : 0;
    }
}

void cli_worker_finish(const cli_worker *worker) {
    close(worker->channel);
    exit(0);
}

int cli_worker_receive(const cli_worker *worker, void *bytes, size_t size) {
    char *at = bytes;
    while (size > 0) {
        const ssize_t got = read(worker->channel, at, size);
        if (got == 0 || (got < 0 && errno != EINTR)) return 0;
        at += got > 0 ? got : 0;
        size -= got > 0 ? (size_t)got : 0;
    }
    return 1;
}

static void say_why(int status, int had_file, char why[CLI_WHY_ROOM]) {
    const char *who = had_file ? "norma" : "the worker process",
               *when = had_file ? "while it worked on this file" : "after all files were done";
    if (WIFSIGNALED(status))
        snprintf(why, CLI_WHY_ROOM, "%s ended by signal %d (%s) %s%s", who, WTERMSIG(status),
            strsignal(WTERMSIG(status)), when,
            WTERMSIG(status) == SIGKILL ? "; perhaps memory ran out" : "");
    else
        snprintf(why, CLI_WHY_ROOM, "%s ended with status %d %s", who, WEXITSTATUS(status), when);
}

int cli_worker_wait(cli_worker *worker, int had_file, char why[CLI_WHY_ROOM]) {
    int status = 0;
    close(worker->channel);
    while (waitpid((pid_t)worker->process, &status, 0) < 0 && errno == EINTR) {
    }
    cli_watch_worker(0);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return 1;
    say_why(status, had_file, why);
    return 0;
}
