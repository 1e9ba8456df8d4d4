/* Where the entries of reports stand, in the order of paths, and what they say. The entries
 * themselves stay on disk. */
#define _GNU_SOURCE /* memmem */
#include "cli/report/report.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- Reading reports by offset. Entries are sorted by path, and those of a shard lie
 * between those of all others, so the descriptors of the last reports stay open. */

/* Half of the descriptors that a process may have is enough for others. */
static void report_files_open(report_files *files, const char *const *paths) {
    const long most = sysconf(_SC_OPEN_MAX) / 2;
    *files = (report_files){.paths = paths, .keeps = 1};
    if (most > 1) files->keeps = most < REPORT_KEPT ? (size_t)most : REPORT_KEPT;
}

static void report_files_close(report_files *files) {
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

/* As many bytes as there are from there on, at most size. Less: the end, or failed. */
static size_t report_files_read(
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

typedef struct report_text {
    report_files *files;
    size_t report;
    uint64_t start; /* of the block */
    size_t size;
    int stops_at_zero; /* the text ends there */
    char block[REPORT_BLOCK];
} report_text;

static void report_text_begin(report_text *text, report_files *files, size_t report) {
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

/* The bytes there, at least one of *size; NULL: the end, or failed. */
static const char *report_text_at(report_text *text, uint64_t offset, size_t *size) {
    if (offset < text->start || offset - text->start >= text->size) read_block(text, offset);
    *size = offset < text->start ? 0 : text->size - (size_t)(offset - text->start);
    return *size ? text->block + (offset - text->start) : NULL;
}

/* The first place from an offset on that has these words; UINT64_MAX: none, or failed. They may lie
 * across the end of a block: the next one begins before it. */
static uint64_t report_text_find(report_text *text, uint64_t offset, const char *words) {
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

/* ---- The parts of all reports, sorted by the paths of files. */

int report_merge_begin(report_merge *merged, const char *const *reports, size_t count) {
    report_files_open(&merged->files, reports);
    merged->shards = calloc(count + 1, sizeof *merged->shards);
    if (!merged->shards) return cli_out_of_memory();
    merged->report_count = count;
    return CLI_OK;
}

static int digit_of(char digit) {
    static const char digits[] = "0123456789ABCDEFabcdef";
    const char *at = digit ? strchr(digits, digit) : NULL;
    return !at ? -1 : at - digits < 16 ? (int)(at - digits) : (int)(at - digits) - 6;
}

/* The bytes of percent-encoded text, in its place. */
static void report_decode(char *text) {
    char *to = text;
    for (const char *at = text; *at; ++to) {
        const int high = *at == '%' ? digit_of(at[1]) : -1, low = high < 0 ? -1 : digit_of(at[2]);
        *to = low < 0 ? *at : (char)(16 * high + low);
        at += low < 0 ? 1 : 3;
    }
    *to = '\0';
}

/* Results of one file follow one another, and share its path. */
static int keep_path(const report_merge *merged, report_part *part) {
    const report_part *last = merged->part_count ? &merged->parts[merged->part_count - 1] : NULL;
    part->owns_path = !last || last->report != part->report || strcmp(last->path, part->path) != 0;
    part->path = part->owns_path ? strdup(part->path) : last->path;
    return part->path != NULL;
}

/* The path is copied. A status. */
static int report_add_part(report_merge *merged, report_part part) {
    report_part *parts =
        cli_grow(merged->parts, merged->part_count, &merged->part_room, sizeof *parts);
    merged->parts = parts ? parts : merged->parts;
    if (!parts || !keep_path(merged, &part)) return cli_out_of_memory();
    merged->parts[merged->part_count++] = part;
    return CLI_OK;
}

/* All but so many. */
static void report_drop_parts(report_merge *merged, size_t count) {
    while (merged->part_count > count) {
        const report_part *part = &merged->parts[--merged->part_count];
        if (part->owns_path) free((char *)(uintptr_t)part->path);
    }
}

/* 0: out of memory, reported. */
static int report_grow_entry(report_merge *merged, size_t size) {
    if (size <= merged->entry_room) return 1;
    const size_t room = size < 4096 ? 4096 : size + size / 2;
    char *entry = realloc(merged->entry, room);
    if (!entry) {
        merged->files.failed = cli_out_of_memory();
        return 0;
    }
    merged->entry = entry;
    merged->entry_room = room;
    return 1;
}

void report_merge_free(report_merge *merged) {
    report_drop_parts(merged, 0);
    report_files_close(&merged->files);
    for (size_t i = 0; i < merged->report_count; ++i) free(merged->shards[i].options);
    free(merged->shards);
    free(merged->parts);
    free(merged->entry);
}

norma_severity report_severity(cli_value finding) {
    return cli_find_severity(cli_string(cli_get(finding, "severity")));
}

int report_fail_on(cli_value file) {
    const char *name = cli_string(cli_get(file, "fail_on"));
    const int severity = (int)cli_find_severity(name ? name : "error");
    return severity ? severity : CHECK_FAIL_NEVER;
}

/* ---- Entries of reports read again. Their hashes were kept, so a report that was written to
 * or cut short meanwhile is seen, wherever that was. */

/* Reads the text of a part into merged->entry, with a 0 behind it, and hashes it. 0: not all of it
 * is there, or memory ran out. */
static int report_read_part(report_merge *merged, report_part *part) {
    const size_t size = (size_t)part->size;
    if (!report_grow_entry(merged, size + 1)) return 0;
    if (report_files_read(&merged->files, part->report, part->offset, merged->entry, size) != size)
        return 0;
    merged->entry[size] = '\0';
    part->hash = cli_hash(CLI_HASH, merged->entry, size);
    return 1;
}

int report_load_part(report_merge *merged, const report_part *part) {
    report_part now = *part;
    if (report_read_part(merged, &now) && now.hash == part->hash) return CLI_OK;
    if (!merged->files.failed)
        cli_error("%s: byte %llu: the entry of %s changed while the reports were joined",
            merged->files.paths[part->report], (unsigned long long)part->offset, part->path);
    return CLI_FILE;
}

/* ---- Reports of shards are put together only as a whole set: a shard that is missing,
 * or there twice, would make a wrong report that looks right. */

static size_t whole_number(cli_value value) {
    size_t number = 0;
    cli_count_of(value, &number);
    return number;
}

/* What a report says of shards, in its members "shard", "options", "missing_shards". A status. */
static int report_note_shard(
    report_merge *merged, size_t report, const char *key, cli_value value) {
    report_shard *shard = &merged->shards[report];
    if (strcmp(key, "missing_shards") == 0 && cli_elements(value)) merged->status = CLI_FILE;
    if (strcmp(key, "shard") == 0) {
        shard->number = whole_number(cli_element(value, 0));
        shard->count = whole_number(cli_element(value, 1));
    }
    if (strcmp(key, "options") != 0 || shard->options) return CLI_OK;
    shard->options = cli_json_sorted(value);
    return shard->options ? CLI_OK : cli_out_of_memory();
}

/* The same of each member of an object. */
static int report_note_shards(report_merge *merged, size_t report, cli_value object) {
    int status = CLI_OK;
    for (cli_value v = cli_is_object(object) ? cli_first(object) : (cli_value){0}; v.in && !status;
         v = cli_next(v))
        status = report_note_shard(merged, report, cli_key(v), v);
    return status;
}

/* ---- Where the entries of a report in JSON or SARIF stand. The report is gone through
 * once, and its values are parsed one by one, so that memory does not grow with the report. */

typedef struct report_scan {
    report_merge *merged;
    report_text *text;
    uint64_t at;       /* of the next byte */
    const char *bytes; /* those of the block from there on */
    size_t left;
    int space;   /* the last white space since a bracket or a comma */
    size_t size; /* of the value that was taken last, in merged->entry */
    uint64_t value_at;
    int status;                                   /* not CLI_OK: reported */
    int has_files, has_runs, is_norma, has_fault; /* has_fault: JSON, but not as check writes it */
    size_t first_part;
    int run_fits, run_fault;
} report_scan;

static int refuse_report(const report_scan *scan, const char *why) {
    cli_error("%s: %s", scan->text->files->paths[scan->text->report], why);
    return CLI_FILE;
}

/* ---- values */

static int peek(report_scan *scan) {
    if (!scan->left) scan->bytes = report_text_at(scan->text, scan->at, &scan->left);
    return scan->left ? (unsigned char)*scan->bytes : EOF;
}

static void advance(report_scan *scan, size_t count) {
    scan->bytes += count;
    scan->left -= count;
    scan->at += count;
}

static int next(report_scan *scan) { /* after white space */
    int byte;
    while ((byte = peek(scan)) == ' ' || byte == '\n' || byte == '\t' || byte == '\r') {
        scan->space = byte;
        advance(scan, 1);
    }
    return byte;
}

static int expect(report_scan *scan, int byte) {
    if (next(scan) != byte) return 0;
    advance(scan, 1);
    scan->space = 0;
    return 1;
}

typedef struct nesting {
    size_t depth;
    int in_string, escaped, ended;
} nesting;

/* Whether a byte of a string ends it. */
static int ends_string(nesting *state, char byte) {
    const int ends = byte == '"' && !state->escaped;
    state->escaped = byte == '\\' && !state->escaped;
    return ends;
}

/* How many of the bytes belong to a value. What it is, the parser sees. */
static size_t span_of_value(nesting *state, const char *bytes, size_t size) {
    for (size_t i = 0; i < size; ++i) {
        const char byte = bytes[i];
        if (state->in_string) {
            if (!ends_string(state, byte)) continue;
            state->in_string = 0;
            state->ended = state->depth == 0;
        } else if (byte == '"') {
            state->in_string = 1;
        } else if (byte == '{' || byte == '[') {
            ++state->depth;
        } else if ((byte == '}' || byte == ']') && state->depth) {
            state->ended = --state->depth == 0;
        } else if (state->depth == 0 && strchr(" \n\t\r,:]}", byte)) {
            state->ended = 1;
            return i;
        }
        if (state->ended) return i + 1;
    }
    return size;
}

/* The text of the value that stands next. 0: it has no end. */
static int take_value(report_scan *scan) {
    nesting state = {0};
    next(scan);
    scan->size = 0;
    scan->value_at = scan->at;
    while (!state.ended && peek(scan) != EOF) {
        const size_t count = span_of_value(&state, scan->bytes, scan->left);
        if (!report_grow_entry(scan->merged, scan->size + count)) {
            scan->status = CLI_FILE;
            return 0;
        }
        memcpy(scan->merged->entry + scan->size, scan->bytes, count);
        scan->size += count;
        advance(scan, count);
    }
    return state.ended && scan->size;
}

static cli_parsed *load_value(report_scan *scan) {
    cli_json_fault fault;
    if (!take_value(scan)) return NULL;
    cli_parsed *value = cli_json_parse(scan->merged->entry, scan->size, &fault);
    if (!value && !fault.expected) scan->status = cli_out_of_memory();
    return value;
}

/* ---- objects and arrays whose values are taken one by one; 0: not to be read any further */

typedef int take(report_scan *scan, const char *key);

/* Names are compared by their hashes, once all are known: an object of a report may have many. */
typedef struct key_hashes {
    uint64_t *hashes;
    size_t count, room;
} key_hashes;

static int note_key(report_scan *scan, key_hashes *keys, const char *name) {
    uint64_t *grown = cli_grow(keys->hashes, keys->count, &keys->room, sizeof *grown);
    if (!grown) {
        scan->status = cli_out_of_memory();
        return 0;
    }
    keys->hashes = grown;
    keys->hashes[keys->count++] = cli_hash(CLI_HASH, name, strlen(name));
    return 1;
}

static int compare_hashes(const void *a, const void *b) {
    const uint64_t one = *(const uint64_t *)a, other = *(const uint64_t *)b;
    return one < other ? -1 : one > other;
}

static int has_key_twice(key_hashes *keys) {
    if (keys->count) qsort(keys->hashes, keys->count, sizeof *keys->hashes, compare_hashes);
    for (size_t i = 1; i < keys->count; ++i)
        if (keys->hashes[i] == keys->hashes[i - 1]) return 1;
    return 0;
}

static int take_member(report_scan *scan, key_hashes *keys, take *member) {
    cli_parsed *key = next(scan) == '"' ? load_value(scan) : NULL;
    const char *name = key ? cli_string(cli_json_root(key)) : NULL;
    const int fine = name && note_key(scan, keys, name) && expect(scan, ':') && member(scan, name);
    cli_json_free(key);
    return fine;
}

static int walk_object(report_scan *scan, take *member) {
    key_hashes keys = {0};
    int fine = expect(scan, '{');
    if (fine && next(scan) != '}') do
            fine = take_member(scan, &keys, member);
        while (fine && expect(scan, ','));
    fine = fine && !has_key_twice(&keys);
    free(keys.hashes);
    return fine && expect(scan, '}');
}

static int walk_array(report_scan *scan, take *element) {
    int fine = expect(scan, '[');
    if (fine && next(scan) != ']') do
            fine = element(scan, NULL);
        while (fine && expect(scan, ','));
    return fine && expect(scan, ']');
}

/* ---- JSON */

/* What is read of an entry must be there. */
static int is_file(cli_value file) {
    const cli_value findings = cli_get(file, "findings");
    if (!cli_string(cli_get(file, "path")) || !cli_string(cli_get(file, "status")) ||
        !cli_is_array(findings))
        return 0;
    for (cli_value finding = cli_first(findings); finding.in; finding = cli_next(finding))
        if (!report_severity(finding) || !cli_string(cli_get(finding, "rule")) ||
            !cli_string(cli_get(finding, "where")) || !cli_string(cli_get(finding, "message")))
            return 0;
    return 1;
}

static void count_file(cli_value file, check_totals *totals) {
    size_t problems = 0;
    for (cli_value v = cli_first(cli_get(file, "findings")); v.in; v = cli_next(v)) {
        const norma_severity severity = report_severity(v);
        totals->errors += severity == NORMA_SEVERITY_ERROR;
        totals->warnings += severity == NORMA_SEVERITY_WARNING;
        totals->infos += severity == NORMA_SEVERITY_INFO;
        problems += severity != NORMA_SEVERITY_INFO;
    }
    ++totals->files;
    totals->files_with_trouble += problems > 0;
    totals->not_checked += strcmp(cli_string(cli_get(file, "status")), "checked") != 0;
}

/* Results of one file that follow one another as norma check writes them are one part, so that
 * memory grows with files, not with findings. */
static int extends_last(const report_scan *scan, const char *path) {
    const report_merge *merged = scan->merged;
    if (merged->part_count == scan->first_part || scan->space != '\n') return 0;
    const report_part *last = &merged->parts[merged->part_count - 1];
    return scan->value_at == last->offset + last->size + strlen(",\n") &&
           strcmp(last->path, path) == 0;
}

static int note_entry(report_scan *scan, const char *path) {
    const char *text = scan->merged->entry;
    if (scan->has_runs && extends_last(scan, path)) {
        report_part *last = &scan->merged->parts[scan->merged->part_count - 1];
        last->size += strlen(",\n") + scan->size;
        last->hash = cli_hash(cli_hash(last->hash, ",\n", strlen(",\n")), text, scan->size);
        return 1;
    }
    scan->status = report_add_part(scan->merged, (report_part){.path = path,
                                                     .report = (uint32_t)scan->text->report,
                                                     .offset = scan->value_at,
                                                     .size = scan->size,
                                                     .hash = cli_hash(CLI_HASH, text, scan->size)});
    return scan->status == CLI_OK;
}

/* Adds a part under the name that percent-encoded text stands for. */
static int add_encoded(report_scan *scan, const char *text) {
    char *path = strdup(text);
    if (!path) {
        scan->status = cli_out_of_memory();
        return 0;
    }
    report_decode(path);
    const int added = note_entry(scan, path);
    free(path);
    return added;
}

/* What the file alone would have ended with: the severity that fails is its own. */
static int status_of(cli_value file) {
    const int least = report_fail_on(file);
    int status = CLI_OK;
    if (strcmp(cli_string(cli_get(file, "status")), "unreadable") == 0) return CLI_FILE;
    for (cli_value v = cli_first(cli_get(file, "findings")); v.in; v = cli_next(v))
        if ((int)report_severity(v) >= least) status = CLI_FINDINGS;
    const cli_value against = cli_get(file, "against");
    if (cli_string(cli_get(against, "error"))) return CLI_FILE;
    return cli_is_false(cli_get(against, "ok")) ? CLI_FINDINGS : status;
}

static int note_file(report_scan *scan, cli_value file) {
    const char *bytes = cli_string(cli_get(file, "path_bytes"));
    count_file(file, &scan->merged->totals);
    scan->merged->status = cli_worse(scan->merged->status, status_of(file));
    return bytes ? add_encoded(scan, bytes) : note_entry(scan, cli_string(cli_get(file, "path")));
}

/* A fault is reported in the end: an error in the JSON goes before it. */
static int take_file(report_scan *scan, const char *key) {
    (void)key;
    cli_parsed *file = load_value(scan);
    int fine = file != NULL;
    if (fine && !scan->has_runs) {
        scan->has_fault |= !is_file(cli_json_root(file));
        fine = scan->has_fault || note_file(scan, cli_json_root(file));
    }
    cli_json_free(file);
    return fine;
}

/* ---- SARIF */

static const char *uri_of(cli_value result) {
    const cli_value location = cli_element(cli_get(result, "locations"), 0),
                    physical = cli_get(location, "physicalLocation");
    const char *uri = cli_string(cli_get(cli_get(physical, "artifactLocation"), "uri"));
    return uri ? uri : "";
}

static int result_status(cli_value result) {
    const char *level = cli_string(cli_get(result, "level")),
               *rule = cli_string(cli_get(result, "ruleId"));
    const cli_value fails = cli_get(cli_get(result, "properties"), "fails");
    if (rule && strcmp(rule, "N001") == 0) return CLI_FILE;
    return (fails.in ? cli_is_true(fails) : level && strcmp(level, "error") == 0) ? CLI_FINDINGS
                                                                                  : CLI_OK;
}

static int take_result(report_scan *scan, const char *key) {
    (void)key;
    cli_parsed *parsed = load_value(scan);
    if (!parsed) return 0;
    const cli_value result = cli_json_root(parsed);
    scan->merged->status = cli_worse(scan->merged->status, result_status(result));
    const int fine = add_encoded(scan, uri_of(result));
    cli_json_free(parsed);
    return fine;
}

/* Results name rules by their numbers, which other versions may have changed. */
static int is_of_this_version(cli_value tool) {
    const char *version = cli_string(cli_get(cli_get(tool, "driver"), "semanticVersion"));
    return version && strcmp(version, norma_version()) == 0;
}

static int take_of_run(report_scan *scan, const char *key) {
    if (strcmp(key, "results") == 0 && next(scan) == '[') return walk_array(scan, take_result);
    cli_parsed *parsed = load_value(scan);
    if (!parsed) return 0;
    const cli_value value = cli_json_root(parsed);
    if (strcmp(key, "tool") == 0) scan->run_fits = is_of_this_version(value);
    if (strcmp(key, "properties") == 0)
        scan->status = report_note_shards(scan->merged, scan->text->report, value);
    if (strcmp(key, "invocations") == 0 &&
        cli_is_false(cli_get(cli_element(value, 0), "executionSuccessful")))
        scan->merged->status = CLI_FILE;
    cli_json_free(parsed);
    return !scan->status;
}

static int take_run(report_scan *scan, const char *key) {
    (void)key;
    scan->run_fits = 0;
    int fine;
    if (next(scan) == '{') {
        fine = walk_object(scan, take_of_run);
    } else {
        cli_parsed *run = load_value(scan);
        fine = run != NULL;
        cli_json_free(run);
    }
    scan->run_fault |= !scan->run_fits;
    return fine;
}

/* ---- both */

static int take_runs(report_scan *scan) {
    scan->has_runs = 1; /* then it is SARIF, and all else is of no importance */
    report_drop_parts(scan->merged, scan->first_part);
    return walk_array(scan, take_run);
}

static void note_member(report_scan *scan, const char *key, cli_value value) {
    scan->status = report_note_shard(scan->merged, scan->text->report, key, value);
    if (strcmp(key, "summary") == 0 && cli_is_false(cli_get(value, "complete"))) {
        scan->merged->status = CLI_FILE;
        scan->merged->totals.incomplete = 1;
    }
}

static int take_of_report(report_scan *scan, const char *key) {
    const int is_array = next(scan) == '[';
    if (is_array && strcmp(key, "runs") == 0) return take_runs(scan);
    if (is_array && strcmp(key, "files") == 0) {
        scan->has_files = 1;
        return walk_array(scan, take_file);
    }
    cli_parsed *parsed = load_value(scan);
    if (!parsed) return 0;
    const cli_value value = cli_json_root(parsed);
    const char *text = cli_string(value);
    if (strcmp(key, "schema") == 0) scan->is_norma = text && strcmp(text, "norma-check/1") == 0;
    if (!scan->has_runs) note_member(scan, key, value);
    cli_json_free(parsed);
    return !scan->status;
}

static const char no_report[] = "is not a report of norma check; expected one in JSON or SARIF";

/* Where and why: the whole report is read for that. */
static int refuse_text(const report_scan *scan) {
    if (scan->status || scan->text->files->failed) return CLI_FILE;
    cli_parsed *report =
        check_load_json(scan->text->files->paths[scan->text->report], "a report of norma check");
    if (!report) return CLI_FILE;
    const int is_object = cli_is_object(cli_json_root(report));
    cli_json_free(report);
    return refuse_report(scan, is_object ? "changed while it was read" : no_report);
}

static int note_report(report_scan *scan) {
    if (scan->has_runs) {
        scan->merged->kind = REPORT_SARIF;
        if (scan->run_fault)
            return refuse_report(scan,
                "was not written by this version of norma check, so its rules may "
                "have other numbers");
        return CLI_OK;
    }
    if (!scan->has_files || !scan->is_norma) return refuse_report(scan, no_report);
    scan->merged->kind = REPORT_JSON;
    if (scan->has_fault)
        return refuse_report(scan, "expected a path, a status and findings in each file");
    return CLI_OK;
}

static int report_add_json(report_merge *merged, report_text *text) {
    report_scan scan = {.merged = merged, .text = text, .first_part = merged->part_count};
    return walk_object(&scan, take_of_report) && next(&scan) == EOF && !merged->files.failed
               ? note_report(&scan)
               : refuse_text(&scan);
}

/* ---- Pages of norma check as one: the sections of their files, pictures included, and a
 * summary of all, from the totals that each page holds as JSON. */

static int report_is_html(report_text *text) {
    const char *bytes;
    size_t size;
    for (uint64_t at = 0; (bytes = report_text_at(text, at, &size)); at += size)
        for (size_t i = 0; i < size; ++i)
            if (!bytes[i] || !strchr(" \t\r\n", bytes[i])) return bytes[i] == '<';
    return 0;
}

static int refuse_page(const report_text *text) {
    if (!text->files->failed)
        cli_error("%s: is not an HTML report of norma check", text->files->paths[text->report]);
    return CLI_FILE;
}

/* ---- totals */

static size_t count_in(cli_value object, const char *key) {
    size_t number = 0;
    cli_count_of(cli_get(object, key), &number);
    return number;
}

static void add_rule(cli_value entry, check_totals *totals) {
    const char *id = cli_string(cli_get(entry, "rule"));
    const norma_severity severity = report_severity(entry);
    const norma_rule *rule = id && severity ? cli_find_rule(id) : NULL;
    if (!rule) return;
    totals->by_rule[rule - norma_rules(NULL)][severity].findings += count_in(entry, "findings");
    totals->by_rule[rule - norma_rules(NULL)][severity].files += count_in(entry, "files");
}

static void add_page_totals(cli_value page, check_totals *totals) {
    totals->errors += count_in(page, "errors");
    totals->warnings += count_in(page, "warnings");
    totals->infos += count_in(page, "infos");
    totals->files += count_in(page, "files");
    totals->files_with_trouble += count_in(page, "files_with_trouble");
    totals->not_checked += count_in(page, "not_checked");
    totals->known += count_in(page, "known");
    totals->incomplete |= cli_is_false(cli_get(page, "complete"));
    for (cli_value v = cli_first(cli_get(page, "rules")); v.in; v = cli_next(v))
        add_rule(v, totals);
}

static int read_totals(report_merge *merged, report_text *text) {
    static const char begin[] = CHECK_HTML_TOTALS;
    cli_json_fault fault;
    uint64_t at = report_text_find(text, 0, begin), last = at;
    if (at != UINT64_MAX) last = report_text_find(text, at, "</script>");
    if (last == UINT64_MAX) return refuse_page(text);
    at += sizeof begin - 1;
    report_part part = {.report = (uint32_t)text->report, .offset = at, .size = last - at};
    if (!report_read_part(merged, &part)) return refuse_page(text);
    cli_parsed *page = cli_json_parse(merged->entry, (size_t)part.size, &fault);
    if (!page) return fault.expected ? refuse_page(text) : cli_out_of_memory();
    add_page_totals(cli_json_root(page), &merged->totals);
    const int status = report_note_shards(merged, text->report, cli_json_root(page));
    if (merged->totals.incomplete) merged->status = CLI_FILE;
    cli_json_free(page);
    return status;
}

/* ---- sections */

/* Its path, whether it was read, how many errors and warnings it has, and whether a finding fails.
 */
static int add_section(report_merge *merged, report_text *text, uint64_t from, uint64_t to) {
    report_part part = {.report = (uint32_t)text->report, .offset = from, .size = to - from};
    char status[16], more[40] = "";
    if (!report_read_part(merged, &part)) return refuse_page(text);
    char *path = merged->entry + sizeof CHECK_HTML_FILE - 1, *path_end = strchr(path, '"');
    if (!path_end ||
        sscanf(path_end, CHECK_HTML_SCAN, status, &part.errors, &part.warnings, more) < 3)
        return refuse_page(text);
    part.is_clean = strstr(more, CHECK_HTML_CLEAN) != NULL;
    if (strstr(more, CHECK_HTML_FAILS)) merged->status = cli_worse(merged->status, CLI_FINDINGS);
    if (strcmp(status, "unreadable") == 0) merged->status = CLI_FILE;
    *path_end = '\0';
    report_decode(path);
    part.path = path;
    return report_add_part(merged, part);
}

static int report_add_html(report_merge *merged, report_text *text) {
    static const char begin[] = CHECK_HTML_FILE, end[] = CHECK_HTML_FILE_END;
    merged->kind = REPORT_HTML;
    text->stops_at_zero = 1;
    text->size = 0; /* reads the block again */
    int status = read_totals(merged, text);
    for (uint64_t at = 0; !status && (at = report_text_find(text, at, begin)) != UINT64_MAX;) {
        const uint64_t last = report_text_find(text, at, end);
        if (last == UINT64_MAX) return refuse_page(text);
        status = add_section(merged, text, at, last + sizeof end - 1);
        at = last + sizeof end - 1;
    }
    return text->files->failed ? CLI_FILE : status;
}

/* ---- any of them */

/* By its content: a page, or JSON. Notes its parts. */
int report_read(report_merge *merged, size_t report) {
    report_text *text = malloc(sizeof *text);
    if (!text) return cli_out_of_memory();
    report_text_begin(text, &merged->files, report);
    const int status =
        report_is_html(text) ? report_add_html(merged, text) : report_add_json(merged, text);
    free(text);
    return status;
}
