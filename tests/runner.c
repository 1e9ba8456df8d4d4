/* runner.c: all unit tests in one program. Each unit/.../test_*.c keeps its own main, which CMake
 * renames (tests/CMakeLists.txt); here each is run in a process of its own, several at a time, and
 * what they print is one TAP stream. A test file that crashes, hangs or reports fewer cases than it
 * promised is a failed case of its own. */
#define _GNU_SOURCE
#include <ctype.h>
#include <errno.h>
#include <fnmatch.h>
#include <ftw.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <setjmp.h>
/* after those it needs */
#include <cmocka.h>

typedef struct unit_test {
    const char *name;
    int (*run)(void);
    int is_long; /* left out by --quick */
} unit_test;

#define TEST(name, is_long) int name##_main(void);
#include "unit_tests.def"
#undef TEST
static const unit_test all_tests[] = {
#define TEST(name, is_long) {#name, name##_main, is_long},
#include "unit_tests.def"
#undef TEST
};
enum { TEST_COUNT = sizeof all_tests / sizeof *all_tests, MOST_JOBS = 64 };

typedef struct job {
    pid_t pid;
    const unit_test *test;
    FILE *out, *err;
    char scratch[64];
} job;

/* What all processes reported so far. */
static struct { unsigned cases, failed; } total;

static const char usage[] =
    "usage: norma_tests [-j JOBS] [--quick | --long] [--list] [NAME[:CASE]...]\n"
    "  NAME   a test file, with or without test_, or a pattern in quotes; none: all of them\n"
    "  CASE   only cases of that name, or pattern\n"
    "  --quick, --long   without, or only, those that take long in this tree\n"
    "  TEST_TIMEOUT   seconds that a test file may take (7200)\n";

/* ---- starting */

static const char *case_of; /* the pattern of cases, or NULL */

static void run_child(const job *j) {
    const char *limit = getenv("TEST_TIMEOUT");
    if (!freopen("/dev/null", "r", stdin) || dup2(fileno(j->out), 1) < 0 ||
        dup2(fileno(j->err), 2) < 0)
        exit(99);
    setvbuf(stdout, NULL, _IOLBF, BUFSIZ); /* what a crash would lose */
    setenv("NORMA_SCRATCH", j->scratch, 1);
    setenv("CMOCKA_MESSAGE_OUTPUT", "TAP", 1);
    alarm(limit ? (unsigned)atoi(limit) : 7200);
    if (case_of) cmocka_set_test_filter(case_of);
    exit(j->test->run());
}

static int start(job *j, const unit_test *test) {
    *j = (job){.test = test, .out = tmpfile(), .err = tmpfile(), .scratch = "/tmp/norma-XXXXXX"};
    if (!j->out || !j->err || !mkdtemp(j->scratch)) return 0;
    fflush(NULL);
    j->pid = fork();
    if (j->pid == 0) run_child(j);
    return j->pid > 0;
}

/* ---- telling */

static int remove_one(const char *path, const struct stat *s, int kind, struct FTW *walk) {
    (void)s, (void)kind, (void)walk;
    return remove(path);
}

/* A line of TAP under our numbers, with the test file's name in front of the case's. 1: it was a
 * case. */
static int tell_case(const char *name, char *line) {
    const int bad = strncmp(line, "not ok ", 7) == 0;
    char *words = line + (bad ? 7 : 3);
    if (!bad && strncmp(line, "ok ", 3) != 0) return 0;
    while (isdigit((unsigned char)*words) || *words == ' ') ++words;
    ++total.cases;
    if (strncmp(words, "# SKIP", 6) == 0)
        printf("ok %u # SKIP %s:%s", total.cases, name, words + 6);
    else
        printf("%sok %u - %s: %s", bad ? "not " : "", total.cases, name,
            words + (strncmp(words, "- ", 2) == 0 ? 2 : 0));
    total.failed += bad && strncmp(words, "# SKIP", 6) != 0;
    return 1;
}

/* How it ended where that is not what its cases said. */
static int trouble(
    int status, unsigned cases, unsigned planned, unsigned failed, char *words, size_t size) {
    if (WIFSIGNALED(status))
        snprintf(words, size, "ended by signal %d (%s) after %u of %u cases", WTERMSIG(status),
            strsignal(WTERMSIG(status)), cases, planned);
    else if (case_of && planned == 0)
        return 0;
    else if (cases == 0 || cases < planned)
        snprintf(words, size, "reported %u of %u cases, exit status %d", cases, planned,
            WEXITSTATUS(status));
    else if (WEXITSTATUS(status) != 0 && failed == 0)
        snprintf(words, size, "exit status %d, though no case failed", WEXITSTATUS(status));
    else
        return 0;
    return 1;
}

/* The last lines of its standard error, as comments. */
static void tell_end(FILE *err) {
    enum { LINES = 40 };
    char line[1024];
    unsigned count = 0, at = 0;
    rewind(err);
    while (fgets(line, sizeof line, err)) ++count;
    rewind(err);
    while (fgets(line, sizeof line, err))
        if (at++ + LINES >= count) printf("# %s%s", line, strchr(line, '\n') ? "" : "\n");
}

static double seconds(struct timeval t) { return (double)t.tv_sec + 1e-6 * (double)t.tv_usec; }

static void finish(job *j, int status, const struct rusage *used) {
    char line[4096], words[160];
    unsigned cases = 0, planned = 0;
    const unsigned failed = total.failed;
    rewind(j->out);
    while (fgets(line, sizeof line, j->out)) {
        if (strncmp(line, "1..", 3) == 0)
            planned += (unsigned)strtoul(line + 3, NULL, 10);
        else if (tell_case(j->test->name, line))
            ++cases;
        else if (*line == '#')
            fputs(line, stdout);
    }
    if (trouble(status, cases, planned, total.failed - failed, words, sizeof words)) {
        printf("not ok %u - %s: %s\n", ++total.cases, j->test->name, words);
        ++total.failed;
    }
    if (total.failed != failed) tell_end(j->err);
    printf("# seconds %s %.1f\n", j->test->name, seconds(used->ru_utime) + seconds(used->ru_stime));
    fclose(j->out);
    fclose(j->err);
    nftw(j->scratch, remove_one, 16, FTW_DEPTH | FTW_PHYS);
    j->pid = 0;
}

/* ---- all of them */

static void wait_for_one(job *jobs, size_t count) {
    struct rusage used;
    int status;
    const pid_t pid = wait4(-1, &status, 0, &used);
    for (size_t i = 0; i < count; ++i)
        if (jobs[i].pid == pid) finish(&jobs[i], status, &used);
}

static job *free_one(job *jobs, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (jobs[i].pid == 0) return &jobs[i];
    return NULL;
}

static int is_running(const job *jobs, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (jobs[i].pid) return 1;
    return 0;
}

static int run_all(const unit_test *const *tests, size_t count, size_t job_count) {
    job jobs[MOST_JOBS] = {0}, *j;
    for (size_t i = 0; i < count; ++i) {
        while ((j = free_one(jobs, job_count)) == NULL) wait_for_one(jobs, job_count);
        if (!start(j, tests[i])) {
            perror("norma_tests");
            return 2;
        }
    }
    while (is_running(jobs, job_count)) wait_for_one(jobs, job_count);
    printf("1..%u\n", total.cases);
    return total.failed || total.cases == 0;
}

static int is_named(const char *pattern, const char *name) {
    char whole[128];
    snprintf(whole, sizeof whole, "test_%s", pattern);
    return fnmatch(pattern, name, 0) == 0 || fnmatch(whole, name, 0) == 0;
}

/* Adds the tests that the pattern names; those of one kind only (-1: both). */
static size_t choose(const char *pattern, int kind, const unit_test **chosen) {
    size_t count = 0;
    for (size_t i = 0; i < TEST_COUNT; ++i)
        if (is_named(pattern, all_tests[i].name) && (kind < 0 || all_tests[i].is_long == kind))
            chosen[count++] = &all_tests[i];
    return count;
}

static const char *program_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

int main(int count, char **words) {
    const unit_test *chosen[4 * TEST_COUNT];
    size_t chosen_count = 0, job_count = 1;
    int kind = -1, list = 0, i = 1;
    for (; i < count && words[i][0] == '-'; ++i) {
        if (strcmp(words[i], "-j") == 0 && i + 1 < count)
            job_count = strtoul(words[++i], NULL, 10);
        else if (strcmp(words[i], "--quick") == 0 || strcmp(words[i], "--long") == 0)
            kind = strcmp(words[i], "--long") == 0;
        else if (strcmp(words[i], "--list") == 0)
            list = 1;
        else
            return fputs(usage, stderr), 2;
    }
    if (job_count < 1) job_count = 1;
    if (job_count > MOST_JOBS) job_count = MOST_JOBS;
    if (strncmp(program_name(words[0]), "test_", 5) == 0) /* a link to this program */
        chosen_count = choose(program_name(words[0]), -1, chosen);
    else if (i == count)
        chosen_count = choose("*", kind, chosen);
    for (; i < count && chosen_count <= 3 * TEST_COUNT; ++i) {
        char *colon = strchr(words[i], ':');
        if (colon) *colon = '\0', case_of = colon + 1;
        const size_t more = choose(words[i], kind, chosen + chosen_count);
        if (more == 0) return fprintf(stderr, "norma_tests: no test is called %s\n", words[i]), 2;
        chosen_count += more;
    }
    if (!list) return run_all(chosen, chosen_count, job_count);
    for (size_t c = 0; c < chosen_count; ++c) puts(chosen[c]->name);
    return 0;
}
