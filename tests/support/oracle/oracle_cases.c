/* oracle_cases.c: made cases by hand.
 *   oracle_cases FILE...            judges these cases
 *   oracle_cases --seeds FROM TO    judges those seeds, each in a process of its own, and leaves
 *                                   what fails in seed-N.case
 *   oracle_cases --shrink FILE      writes a smaller case that fails, to standard output */
#define _GNU_SOURCE
#include "oracle/guarded.h"
#include "oracle/net.h"
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

static made_case made;
static char path[64];

static void keep_case(void) {
    FILE *file = fopen(path, "w");
    if (!file) return;
    made_case_print(&made, file);
    fclose(file);
}

static int status_of(pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    return status;
}

static void limit_processor_time(void) {
    const struct rlimit limit = {20, 25};
    setrlimit(RLIMIT_CPU, &limit);
}

static int fails(const made_case *trial) {
    fflush(stdout);
    const pid_t child = fork();
    if (child) return status_of(child) != 0;
    if (!freopen("/dev/null", "w", stdout) || !freopen("/dev/null", "w", stderr)) _exit(0);
    limit_processor_time();
    _exit(net_judge("", trial) != 0);
}

static int judge_seeds(unsigned long long from, unsigned long long to) {
    size_t failed = 0, crashed = 0;
    for (unsigned long long seed = from; seed <= to; ++seed) {
        snprintf(path, sizeof path, "seed-%llu.case", seed);
        made_case_of_seed(&made, seed);
        fflush(stdout);
        const pid_t child = fork();
        if (child == 0) {
            guarded_on_crash(keep_case);
            limit_processor_time();
            path[strlen(path) - 5] = '\0';
            const size_t wrong = net_judge(path, &made);
            path[strlen(path)] = '.';
            if (wrong) keep_case();
            fflush(stdout);
            _exit(wrong != 0);
        }
        const int status = status_of(child);
        failed += status != 0;
        crashed += WIFSIGNALED(status);
        if (WIFSIGNALED(status)) printf("# seed-%llu: signal %d\n", seed, WTERMSIG(status));
    }
    printf("%zu of %llu seeds failed, %zu by a signal\n", failed, to - from + 1, crashed);
    return failed != 0;
}

int main(int count, char **words) {
    size_t wrong = 0;
    if (count == 4 && !strcmp(words[1], "--seeds"))
        return judge_seeds(strtoull(words[2], NULL, 10), strtoull(words[3], NULL, 10));
    if (count == 3 && !strcmp(words[1], "--shrink")) {
        if (!made_case_load(&made, words[2]) || !fails(&made)) return 2;
        made_case_shrink(&made, fails);
        made_case_print(&made, stdout);
        return 0;
    }
    for (int i = 1; i < count; ++i)
        wrong += made_case_load(&made, words[i]) ? net_judge(words[i], &made) : 1;
    return wrong != 0;
}
