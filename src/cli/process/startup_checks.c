/* startup_checks.c: what a caller may have taken from the tool, or another program may take from it
 * while it runs: standard streams, and files that are mapped. */
#define _DEFAULT_SOURCE /* BUS_ADRERR */
#define _POSIX_C_SOURCE 200809L
#include "cli/process/startup_checks.h"
#include "cli/process/errors.h"
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

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
/* Of /proc/self/maps, read byte by byte: a signal handler has no library. */
typedef struct map_reader {
    int descriptor;
    size_t used, size;
    char bytes[1024];
} map_reader;

static int next_byte(map_reader *reader) {
    if (reader->used == reader->size) {
        const ssize_t got = read(reader->descriptor, reader->bytes, sizeof reader->bytes);
        reader->used = 0;
        reader->size = got > 0 ? (size_t)got : 0;
        if (!reader->size) return -1;
    }
    return (unsigned char)reader->bytes[reader->used++];
}

static uintptr_t read_hex(map_reader *reader) {
    uintptr_t number = 0;
    for (int byte; (byte = next_byte(reader)) >= 0;) {
        const int digit = byte >= '0' && byte <= '9'   ? byte - '0'
                          : byte >= 'a' && byte <= 'f' ? byte - 'a' + 10
                                                       : -1;
        if (digit < 0) break;
        number = number << 4 | (uintptr_t)digit;
    }
    return number;
}

/* "start-end rights offset device inode name": the name of the file that lies at address; "" where
 * none does. */
static void find_mapped(uintptr_t address, char *name, size_t room) {
    map_reader reader = {.descriptor = open("/proc/self/maps", O_RDONLY | O_CLOEXEC)};
    int byte = 0, found = 0;
    size_t length = 0;
    while (reader.descriptor >= 0 && byte >= 0 && !found) {
        const uintptr_t start = read_hex(&reader), end = read_hex(&reader);
        found = start <= address && address < end;
        length = 0;
        while ((byte = next_byte(&reader)) >= 0 && byte != '\n')
            if (found && (length > 0 || byte == '/') && length + 1 < room)
                name[length++] = (char)(byte < 0x20 || byte >= 0x7F ? '?' : byte);
    }
    if (reader.descriptor >= 0) close(reader.descriptor);
    name[found ? length : 0] = '\0';
}

static size_t append(char *text, size_t used, size_t room, const char *more) {
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
    size_t used = append(text, 0, sizeof text, "norma: ");
    used = append(text, used, sizeof text, name);
    used = append(
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
