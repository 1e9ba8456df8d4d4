/* report_files.c: reading reports by offset. Entries are sorted by path, and those of a shard lie
 * between those of all others, so the descriptors of the last reports stay open. */
#define _GNU_SOURCE /* memmem */
#include "cli/report/report_files.h"
#include "cli/check/check_command.h"
#include "cli/process/errors.h"
#include <errno.h>
#include <string.h>
#include <unistd.h>

/* Half of the descriptors that a process may have is enough for others. */
void report_files_open(report_files *files, const char *const *paths) {
    const long most = sysconf(_SC_OPEN_MAX) / 2;
    *files = (report_files){.paths = paths, .keeps = 1};
    if (most > 1) files->keeps = most < REPORT_KEPT ? (size_t)most : REPORT_KEPT;
}

void report_files_close(report_files *files) {
    for (size_t i = 0; i < REPORT_KEPT; ++i)
        if (files->kept[i].report) close(files->kept[i].file);
    *files = (report_files){0};
}

/* -1: reported. */
static int open_report(report_files *files, size_t report) {
    const size_t slot = report % files->keeps;
    if (files->kept[slot].report == report + 1) return files->kept[slot].file;
    const int file = check_open_regular(files->paths[report]);
    if (file < 0) return -1;
    if (files->kept[slot].report) close(files->kept[slot].file);
    files->kept[slot].report = report + 1;
    files->kept[slot].file = file;
    return file;
}

size_t report_files_read(
    report_files *files, size_t report, uint64_t offset, char *bytes, size_t size) {
    const int file = open_report(files, report);
    size_t filled = 0;
    files->failed |= file < 0;
    if (file < 0) return 0;
    while (filled < size) {
        const ssize_t got = pread(file, bytes + filled, size - filled, (off_t)(offset + filled));
        if (got == 0) break;
        if (got > 0)
            filled += (size_t)got;
        else if (errno != EINTR) {
            cli_error("%s: cannot be read", files->paths[report]);
            files->failed = 1;
            break;
        }
    }
    return filled;
}

/* ---- in blocks */

void report_text_begin(report_text *text, report_files *files, size_t report) {
    text->files = files;
    text->report = report;
    text->start = 0;
    text->size = 0;
    text->stops_at_zero = 0;
}

static void read_block(report_text *text, uint64_t offset) {
    text->start = offset;
    text->size =
        report_files_read(text->files, text->report, offset, text->block, sizeof text->block);
    const char *zero = text->stops_at_zero ? memchr(text->block, '\0', text->size) : NULL;
    if (zero) text->size = (size_t)(zero - text->block);
}

const char *report_text_at(report_text *text, uint64_t offset, size_t *size) {
    if (offset < text->start || offset - text->start >= text->size) read_block(text, offset);
    *size = offset < text->start ? 0 : text->size - (size_t)(offset - text->start);
    return *size ? text->block + (offset - text->start) : NULL;
}

/* Words may lie across the end of a block: the next one begins before it. */
uint64_t report_text_find(report_text *text, uint64_t offset, const char *words) {
    const size_t length = strlen(words);
    size_t size;
    for (const char *at; (at = report_text_at(text, offset, &size)); offset += size - length + 1) {
        if (size < length) {
            read_block(text, offset);
            at = text->block;
            size = text->size;
        }
        if (size < length) break;
        const char *found = memmem(at, size, words, length);
        if (found) return offset + (uint64_t)(found - at);
    }
    return UINT64_MAX;
}

/* FNV-1a (Fowler, Noll, Vo), 64 bits. */
uint64_t report_hash(uint64_t before, const char *bytes, size_t size) {
    uint64_t hash = before;
    for (size_t i = 0; i < size; ++i)
        hash = (hash ^ (unsigned char)bytes[i]) * UINT64_C(1099511628211);
    return hash;
}
