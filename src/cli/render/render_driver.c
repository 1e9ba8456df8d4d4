/* render_driver.c: a graphics driver that gets no memory may end the program instead of saying so.
 * Under --max-memory what it ends by is caught, and the limit is named. Nothing is half-written
 * then: a picture has no name before it is whole. */
#define _POSIX_C_SOURCE 200809L
#include "cli/render/render_command.h"
#include "cli/process/process.h"
#include <stdio.h>
#include <string.h>

#if !defined(_WIN32)
#include <signal.h>
#include <unistd.h>

static char driver_failed[CLI_LIMIT_ROOM + 192];

static void catch_driver(int number) {
    (void)number;
    const ssize_t written = write(STDERR_FILENO, driver_failed, strlen(driver_failed));
    (void)written;
    _exit(CLI_FILE);
}

void render_watch_driver(void) {
    char limit[CLI_LIMIT_ROOM];
    cli_memory_limit_words(limit);
    if (!limit[0]) return;
    snprintf(driver_failed, sizeof driver_failed,
        "norma: the graphics driver ended because memory ran out%s" RENDER_DRIVER_NEEDS "\n",
        limit);
    struct sigaction action = {.sa_handler = catch_driver};
    sigemptyset(&action.sa_mask);
    sigaction(SIGSEGV, &action, NULL);
    sigaction(SIGABRT, &action, NULL);
}
#else
void render_watch_driver(void) {}
#endif
