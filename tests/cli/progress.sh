#!/bin/bash
# Where a person watches (a terminal) and the work takes longer than a second, a line on standard error says how far it is; in a pipe, with --quiet and for short work there is none.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
NORMA=${NORMA_BIN:-$tree/bin/norma}
cd "$scratch" || exit 1
command -v script >/dev/null || { skip "script(1) is not there"; finish; exit; }
awk 'BEGIN { n = 1500; for (i = 0; i < n; ++i) for (j = 0; j < n; ++j) print "v", i, j, sin(i * .1) * cos(j * .1);
    for (i = 0; i < n - 1; ++i) for (j = 0; j < n - 1; ++j) { a = i * n + j + 1; print "f", a, a + n, a + 1; print "f", a + 1, a + n, a + n + 1 } }' >large.obj
for i in 1 2 3 4; do ln large.obj large$i.obj; done
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >small.obj

# Seconds are of processor time, of the process and of the workers that it began, so that other work of the machine changes nothing: the time left is steady where the work is.
cat >clock.c <<'END'
#define _GNU_SOURCE
#include <stdio.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
static double seconds_of(clockid_t clock) {
    struct timespec time;
    return syscall(SYS_clock_gettime, clock, &time) ? 0 : time.tv_sec + 1e-9 * time.tv_nsec;
}
static double ended_seconds(void) {
    struct rusage used;
    getrusage(RUSAGE_CHILDREN, &used);
    return used.ru_utime.tv_sec + used.ru_stime.tv_sec + 1e-6 * (used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}
int clock_gettime(clockid_t clock, struct timespec *now) {
    char path[64];
    clockid_t of;
    if (clock != CLOCK_MONOTONIC) return (int)syscall(SYS_clock_gettime, clock, now);
    double sum = seconds_of(CLOCK_PROCESS_CPUTIME_ID) + ended_seconds();
    snprintf(path, sizeof path, "/proc/self/task/%d/children", (int)getpid());
    FILE *workers = fopen(path, "r");
    for (int worker; workers && fscanf(workers, "%d", &worker) == 1;)
        if (!clock_getcpuclockid(worker, &of)) sum += seconds_of(of);
    if (workers) fclose(workers);
    *now = (struct timespec){(time_t)sum, (long)(1e9 * (sum - (double)(time_t)sum))};
    return 0;
}
END
clock=
! grep -qa __asan_init "$NORMA" && ${CC:-cc} -std=gnu11 -shared -fPIC clock.c -o clock.so 2>log && clock="LD_PRELOAD=$scratch/clock.so"

# watched COMMAND...: what a terminal of a person shows.
watched() { TERM=xterm script -qec "$clock $NORMA $*" /dev/null </dev/null 2>&1 | tr '\r' '\n' >shown; }
shows() { if grep -qE -- "$2" shown; then pass "$1"; else fail "$1" "$(cat -v shown)"; fi; }
shows_not() { if grep -qE -- "$2" shown; then fail "$1" "$(cat -v shown)"; else pass "$1"; fi; }

# Twice as much is checked in no less than two seconds; the time left is not guessed from the first of them.
{ cat large.obj; awk '/^v/ { print $1, $2, $3, $4 + 5 } /^f/ { print $1, $2 + 2250000, $3 + 2250000, $4 + 2250000 }' large.obj; } >larger.obj
watched check larger.obj --no-config --threads 1 --max-samples 1
shows "check of one file shows percent and the time left" '^checking larger.obj: +[0-9]+ %, [0-9]+ s left'
sed -nE '/^checking .* ([2-9]|[1-9][0-9]) %/{p;q}' shown >first; mv first shown
shows "the first line of some percent does not guess the time left" ' %[^,]*$'
watched check large.obj --no-config --threads 1 --max-samples 1
# Lines begin after a second, and a fast machine is nearly done by then: what counts is that none falls, and the steps between them.
steady() { # NAME MOST: of what was shown
    local parts step
    parts=$(sed -nE 's/^checking [a-z.]+: +([0-9]+) %.*/\1/p' shown)
    step=$(awk 'NR > 1 && ($1 < before || $1 - before > most) { most = $1 < before ? 100 : $1 - before } { before = $1 } END { print NR < 2 ? "one line" : most + 0 }' <<<"$parts")
    if [ "$(echo "$parts" | sort -nu | wc -l)" -ge 3 ] && [ "$step" -le "$2" ]; then pass "$1"; else fail "$1" "$parts"; fi
}
steady "the percent never fall, and do not jump" 35
watched check large.obj large1.obj large2.obj large3.obj large4.obj --no-config --threads 2
shows "check of several files shows percent and the time left" '^checking files: +[0-9]+ %, [0-9]+ s left'
steady "the percent of several files count what is done of each" 15
shows "what is left of the line is cleared before a report" $'\e\\[Klarge'
watched check large.obj --no-config --threads 1 --fix-unsafe --select N1 -o fixed.obj
shows "--fix shows percent" '^checking large.obj: +[0-9]+ %'
shows_not "--fix does not guess the time left: how many passes it takes is not known before" 's left'
watched check large.obj --no-config --threads 1 --quiet
shows_not "--quiet shows none" '^checking'
watched check small.obj --no-config
shows_not "short work shows none" '^checking'
"$NORMA" check large.obj --no-config --threads 1 2>shown >/dev/null
shows_not "a pipe shows none" 'checking'
if "$NORMA" render small.obj -o drawn.png >/dev/null 2>&1; then
    watched render larger.obj --show findings --threads 1 --size 32x32 -o drawn.png
    shows "render --show findings shows the time" '^checking larger.obj: [0-9]+ s'
    rm larger.obj
    watched render large.obj --size 2048x2048 --samples 4 -o drawn.png
    shows "drawing shows the time" '^drawing drawn.png: [0-9]+ s'
fi
if "$NORMA" view small.obj -o small.html >/dev/null 2>&1; then
    watched view large.obj -o large.html
    shows "packing a page shows the time" '^packing large.obj: [0-9]+ s'
fi
finish
