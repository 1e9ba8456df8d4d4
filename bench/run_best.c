/* run_best.c: runs a command several times and prints the best wall time, the processor time of
 * that run, and the largest memory of any run. run_best RUNS COMMAND... Prints: milliseconds,
 * milliseconds of processor time, peak MB with mapped files, peak MB of its own memory alone
 * (sampled; Linux). The command's standard output is thrown away. */
#define _GNU_SOURCE
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static double now_ms(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e3 * (double)time.tv_sec + 1e-6 * (double)time.tv_nsec;
}

/* Memory of its own, in MB; 0 where the system does not tell. */
static double anonymous_mb(pid_t child) {
    char path[64], line[256];
    double kilobytes = 0;
    snprintf(path, sizeof path, "/proc/%ld/status", (long)child);
    FILE *status = fopen(path, "r");
    while (status && fgets(line, sizeof line, status))
        if (!strncmp(line, "RssAnon:", 8)) kilobytes = atof(line + 8);
    if (status) fclose(status);
    return kilobytes / 1e3;
}

static pid_t start(char **command) {
    pid_t child = fork();
    if (child) return child;
    int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere >= 0) dup2(nowhere, STDOUT_FILENO);
    execvp(command[0], command);
    _exit(127);
}

int main(int count, char **arguments) {
    if (count < 3) return fprintf(stderr, "usage: run_best RUNS COMMAND...\n"), 2;
    double best = 1e30, best_cpu = 0, peak = 0, own = 0;
    const int runs = atoi(arguments[1]) > 0 ? atoi(arguments[1]) : 1;
    for (int run = 0; run <= runs;
         ++run) { /* the last one is not timed: its memory is looked at every half millisecond */
        struct rusage usage;
        int status = 0;
        double began = now_ms();
        pid_t child = start(arguments + 2), done = 0;
        if (run < runs) done = wait4(child, &status, 0, &usage);
        while (done != child) {
            double mb = anonymous_mb(child);
            own = mb > own ? mb : own;
            usleep(500);
            done = wait4(child, &status, WNOHANG, &usage);
        }
        double wall = now_ms() - began;
        if (!WIFEXITED(status) || WEXITSTATUS(status))
            return fprintf(stderr, "run_best: %s failed\n", arguments[2]), 1;
        if (run < runs && wall < best) {
            best = wall;
            best_cpu = 1e3 * ((double)usage.ru_utime.tv_sec + (double)usage.ru_stime.tv_sec) +
                       1e-3 * ((double)usage.ru_utime.tv_usec + (double)usage.ru_stime.tv_usec);
        }
        peak = (double)usage.ru_maxrss / 1e3 > peak ? (double)usage.ru_maxrss / 1e3 : peak;
    }
    printf("%.1f %.1f %.1f %.1f\n", best, best_cpu, peak, own);
    return 0;
}
