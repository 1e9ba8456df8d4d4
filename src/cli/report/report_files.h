/* report_files.h: the reports as files, which are read twice: once to see where each entry stands,
 * and again, entry by entry, when the merged report is written. */
#ifndef NORMA_CLI_REPORT_FILES_H
#define NORMA_CLI_REPORT_FILES_H
#include <stddef.h>
#include <stdint.h>

enum { REPORT_KEPT = 128, REPORT_BLOCK = 65536 };

typedef struct report_files {
    const char *const *paths; /* the caller's */
    int failed;               /* one could not be read, which was reported */
    size_t keeps;             /* descriptors that stay open, at most */
    struct {
        size_t report; /* its number and 1; 0: none */
        int file;
    } kept[REPORT_KEPT];
} report_files;

void report_files_open(report_files *files, const char *const *paths);
void report_files_close(report_files *files);
/* As many bytes as there are from there on, at most size. Less: the end, or failed. */
size_t report_files_read(
    report_files *files, size_t report, uint64_t offset, char *bytes, size_t size);

/* ---- from the beginning to the end, in blocks */

typedef struct report_text {
    report_files *files;
    size_t report;
    uint64_t start; /* of the block */
    size_t size;
    int stops_at_zero; /* the text ends there */
    char block[REPORT_BLOCK];
} report_text;

void report_text_begin(report_text *text, report_files *files, size_t report);
/* The bytes there, at least one of *size; NULL: the end, or failed. */
const char *report_text_at(report_text *text, uint64_t offset, size_t *size);
/* The first place from an offset on that has these words; UINT64_MAX: none, or failed. */
uint64_t report_text_find(report_text *text, uint64_t offset, const char *words);

enum { REPORT_HASH = 1 }; /* of no bytes */
/* Of an entry's bytes, to see in the second reading that they are what they were. */
uint64_t report_hash(uint64_t before, const char *bytes, size_t size);
#endif
