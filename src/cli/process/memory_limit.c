/* memory_limit.c: --max-memory limits the memory of this process. The system refuses every block
 * beyond the limit. What can be done in parts is done in parts that fit; an input that needs more
 * in one piece ends with "out of memory" and status 3, as on a machine without more memory. */
#define _POSIX_C_SOURCE 200809L
#include "cli/process/memory_limit.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
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

uint64_t cli_memory_limit(void) {
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
