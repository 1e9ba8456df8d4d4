/* check.h: what the files of norma check share: its settings, the report on one file, the forms of
 * reports. */
#ifndef NORMA_CLI_CHECK_CHECK_H
#define NORMA_CLI_CHECK_CHECK_H
#include "cli/compare/compare.h"
#include <inttypes.h>

enum { CHECK_RULES = 128 }; /* room for a byte of each rule */
/* More findings of a rule in one file, or reasons, are told in one line. */
enum { CHECK_MOST_LINES = 10 };

/* ---- .norma.json (known.c) */

enum { CHECK_SEVERITY_AS_IS = 0, CHECK_SEVERITY_OFF = 255 }; /* else a norma_severity */

/* What overrides go by: lists of patterns of names. */
enum { CHECK_FILES, CHECK_MESHES, CHECK_MATERIALS, CHECK_NODES, CHECK_LISTS };
extern const char *const check_list_keys[CHECK_LISTS]; /* "files", ... */

typedef struct check_override {
    cli_value lists[CHECK_LISTS]; /* of each kind, arrays of strings; none: all */
    size_t first[CHECK_LISTS];    /* in matched of the configuration: the list's first pattern */
    uint8_t severity[CHECK_RULES];
} check_override;

typedef struct check_config {
    char *path; /* NULL: there is none */
    cli_parsed *text;
    char *folder; /* absolute: what patterns of files are relative to */
    norma_check_profile profile;
    int strict;  /* -1: not said */
    int fail_on; /* -1: not said */
    int has_select;
    uint8_t select[CHECK_RULES], ignore[CHECK_RULES];
    uint8_t severity[CHECK_RULES];
    check_override *overrides;
    size_t override_count, pattern_count;
    unsigned char *matched; /* of each pattern, once something has that name; workers share it */
} check_config;

typedef struct check_configs check_configs; /* those read so far, by folder */
/* Which are obeyed of those that nobody named: the user's own, --no-config, --trust-config. */
typedef enum check_config_trust {
    CHECK_CONFIG_OWN,
    CHECK_CONFIG_NONE,
    CHECK_CONFIG_ANY
} check_config_trust;
/* named: --config FILE, NULL: found upward from each file. */
check_configs *check_configs_new(const char *named, check_config_trust trust, cli_guard *guard);
void check_configs_free(check_configs *configs);
/* Those of all files, before the first is checked. A status: one that cannot be read, or memory; it
 * has been said. */
int check_configs_read(check_configs *configs, const cli_inputs *inputs);
const check_config *check_config_of(const check_configs *configs, size_t file);

/* ---- names that overrides go by (overrides.c) */

typedef struct check_place check_place;
typedef struct check_names { /* of one file */
    const check_config *config;
    const char *path; /* absolute, where it can be */
    norma_document *document;

    /* Where findings may be, of the document or a model of it, so that one is found quickly: by
     * their names, then the nodes once more by their meshes. */
    check_place *places;
    size_t place_count, drawing_count;
    norma_document *placed;
} check_names;

/* Whether an override is for a finding. Negative: memory is out. */
int check_is_meant(
    check_names *names, const check_override *override, const norma_finding *finding);
void check_forget_places(check_names *names);
/* Marks the patterns that match a name in the file, or its own. */
void check_mark_names(const check_names *names);
/* Warns of patterns that matched nothing in the files that were checked. */
void check_warn_unmatched(const check_configs *configs, const cli_inputs *inputs);

/* ---- what is asked (check_command.c) */

typedef struct check_style { /* of a report for people */
    int color;
    size_t width; /* 0: nothing is wrapped */
} check_style;

enum { COMMAND_OPTIONS = 10 };

typedef struct check_settings {
    norma_check_profile profile;
    int strict;
    int fail_on; /* a norma_severity, CHECK_FAIL_NEVER, or -1: as the configuration says, else error
                  */
    size_t max_samples; /* 0: as many as the library gives */
    int has_select;
    uint8_t select[CHECK_RULES], ignore[CHECK_RULES];
    uint32_t threads;
    norma_file_format input_format;
    struct check_baseline *baseline; /* NULL: none */
    FILE *known;                     /* where findings of a new baseline go (check_baseline_note) */
    int fix;                         /* CHECK_FIX_... */
    int dry_run;
    int open_by_rays;       /* of --fix-unsafe */
    const cli_files *files; /* where mended files go */
    int quiet;
    size_t file_count; /* of all shards */
    size_t at_once;    /* files that are checked at the same time */
    int pictures;      /* are drawn: of whole solids */
    int list_infos;    /* else they are only counted, in reports for people */
    check_style style;
    size_t shard, shards;      /* shards 0: all files */
    const char *shard_options; /* JSON: what else the findings of a shard depend on */
    const char *against;       /* a folder of references, one of each file's path; NULL: none */
    const char *page;      /* of the HTML report: norma.html, or a folder of pages; NULL: none */
    compare_limits limits; /* of how much a file may differ from its reference */
    const char *missing;   /* of a merged report: JSON, a list of shards; NULL: none */
    const char *lost;      /* why a file cannot be checked: it ended a worker (process.h) */
    const char *command_options[COMMAND_OPTIONS]; /* what a fix must be told as well; NULL-ended */
    norma_progress *progress;                     /* of whatever takes long */
    void *progress_user;
} check_settings;
enum { CHECK_FAIL_NEVER = 100 };
enum { CHECK_FIX_NOTHING = 0, CHECK_FIX_SAFE, CHECK_FIX_UNSAFE };

/* ---- the report on one file (check_one.c) */

typedef struct check_item {
    const norma_finding *finding;
    norma_severity severity; /* after the configuration */
    char *command;           /* fixes it; NULL: nothing does, or it was tried, and this is left */
} check_item;

enum { CHECK_SEVERITIES = NORMA_SEVERITY_ERROR + 1 };

/* Why a fix was left out. Many that differ in numbers alone are one for people. */
typedef struct check_reason {
    const char *text;
    size_t number, more; /* in their order; how many it stands for besides itself */
    int is_folded;       /* another one stands for it */
} check_reason;

typedef struct check_report {
    const check_settings *settings;
    const char *path;  /* as it was named */
    const char *shown; /* to people; for each form, once check_write_file has it */
    const char *page;  /* what settings->page shows of it (below); NULL: nothing */
    const char *view;  /* else the command that makes one; NULL: none */
    norma_check_profile profile;
    const char *status; /* "checked", "partly", "unreadable" */
    const check_item *items;
    size_t count;
    int fail_on;                            /* for this file */
    const size_t (*same)[CHECK_SEVERITIES]; /* how many items of each rule and severity */
    norma_document *document;               /* for pictures; NULL: unreadable */
    const check_reason *reasons;            /* why fixes were left out; NULL: none was asked for */
    size_t reason_count;
    int is_unchanged;          /* a fix was asked for, and there was nothing to do */
    const char *mended;        /* a table of counts before and after; NULL: nothing was mended */
    size_t by_rays, undecided; /* open components that rays decided on, or did not; 0 where that was
                                  not asked for */
    double least_confidence;   /* of by_rays */
    const char *against;       /* what norma compare prints of it and its reference; NULL: none */
    int against_status;
} check_report;

typedef struct check_rule_total {
    size_t findings, files;
} check_rule_total;

typedef struct check_list check_list;

enum { CHECK_SUMS = 10 + 2 * CHECK_RULES * CHECK_SEVERITIES };

typedef struct check_totals {
    union {
        struct {
            size_t errors, warnings, infos, files, files_with_trouble, not_checked;
            size_t known;     /* silenced by the baseline */
            size_t differing; /* files that differ from their references, or have none */
            size_t clean;     /* files without problems */
            size_t hidden;    /* infos that reports for people only count */
            check_rule_total by_rule[CHECK_RULES][CHECK_SEVERITIES];
        };
        size_t sums[CHECK_SUMS]; /* all of these, of one file added to those of others */
    };
    int status;                   /* worst of its files */
    int unreported;               /* a file is not in the report */
    int incomplete;               /* something could not be read or written that has no entry */
    int forgot;                   /* findings are missing in a new baseline: out of memory */
    size_t left_out[CHECK_RULES]; /* results of SARIF above its limit */
    check_list *list;             /* of forms that put the worst files first */
} check_totals;

/* The forms of a report. file is called by several threads at once, each with an own out; begin and
 * end by one; NULL: they write nothing. */
typedef struct check_format {
    const char *name;
    void (*begin)(FILE *out, const check_settings *settings);
    void (*file)(FILE *out, const check_report *report);
    const char *between; /* two files */
    void (*end)(FILE *out, const check_totals *totals, const check_settings *settings);
    int is_worst_first;       /* else files are in the order of their paths */
    const char *before_clean; /* in front of the first file without problems; NULL: nothing */
} check_format;
extern const check_format check_format_text, check_format_quiet, check_format_line,
    check_format_json, check_format_sarif, check_format_html;

/* ---- files for people: the worst first (check_all.c) */

typedef struct check_entry {
    const char *path;
    size_t errors, warnings;
    int is_clean;
    char *text; /* its part of the report, the list's; NULL: written already */
    size_t size;
} check_entry;

struct check_list {
    check_entry *entries;
    size_t count, room;
};

/* The path stays the caller's, the text becomes the list's. 0: out of memory. */
int check_list_add(check_list *list, const check_entry *entry);
void check_list_free(check_list *list);
int check_compare_entries(const void *a, const void *b); /* for qsort */
void check_list_sort(check_list *list);
int check_list_write(const check_list *list, const check_format *format, FILE *out,
    const check_settings *settings); /* 0: out of memory */
/* Before the part of an entry is written. */
void check_begin_entry(const check_list *list, size_t entry, const check_format *format, FILE *out);
/* In the text of an entry: what is told once though several files have it, behind a key of 16
 * hexadecimal digits, and where the other files are named. No other text has these bytes. */
enum { CHECK_SAME = 1, CHECK_ALSO = 2, CHECK_SAME_END = 3 };
/* findings_text.c: relative to the working folder where it is in there; the caller's path, or a
 * part of it. */
const char *check_shown_path(const char *path);

/* ---- the results of a SARIF report (findings_data.c), of which it holds a limited number: rules
 * with the most of them lose some. text: results as check_format_sarif writes them, each on a line.
 */
typedef struct check_results check_results;
check_results *check_results_new(void); /* NULL: out of memory */
void check_results_free(check_results *results);
int check_results_add(check_results *results, const char *text, size_t size); /* 0: out of memory */
/* Says on standard error, and in totals, what was left out. */
void check_results_write(const check_results *results, FILE *out, check_totals *totals);

/* ---- the forms by name (check_command.c) */
#define CHECK_FORMAT_NAMES "text, line, json, sarif or html"
const check_format *check_find_format(const char *name);    /* NULL: none is called so */
const check_format *check_format_of_name(const char *path); /* by its ending; NULL: none */

/* ---- what the forms write (findings_text.c). How a page can be taken apart again: each file
 * begins with CHECK_HTML_FILE and its path, and the totals are JSON between CHECK_HTML_TOTALS and
 * the end of that script. */
#define CHECK_HTML_FILE   "<section class=\"file\" data-path=\""
#define CHECK_HTML_STATUS "\" data-status=\"%s\" data-errors=\"%zu\" data-warnings=\"%zu\""
#define CHECK_HTML_SCAN                                                                            \
    "\" data-status=\"%15[a-z]\" data-errors=\"%" SCNu32 "\" data-warnings=\"%" SCNu32 "\"%39[^>]"
#define CHECK_HTML_CLEAN    " data-clean"
#define CHECK_HTML_FAILS    " data-fails"
#define CHECK_HTML_FILE_END "</section><!-- end of file -->\n"
#define CHECK_HTML_TOTALS   "<script type=\"application/json\" id=\"totals\">"

/* "shard" and "options", or "missing_shards": members of a JSON object that is open. */
void check_write_shard(cli_json *json, const check_settings *settings);
/* whole: what norma report needs to put pages together, too. */
void check_write_counts(cli_json *json, const check_totals *totals, int whole);
/* Percent-encoded, but for letters, digits and the characters of kept. */
void check_write_uri(FILE *out, const char *text, const char *kept);
void check_write_verdict(FILE *out, const check_totals *totals); /* without a line end */

/* ---- what the forms ask (findings_text.c) */

/* Writes the part of a file, and adds it to the totals. */
void check_write_file(
    check_report *report, const check_format *format, FILE *out, check_totals *totals);

size_t check_rule_number(const norma_rule *rule); /* in norma_rules */
const char *check_profile_name(norma_check_profile profile);
int check_find_profile(const char *name, norma_check_profile *profile); /* 0: none is called so */
/* Checked, and without errors, warnings and whatever fails the check. */
int check_is_clean(const check_report *report);
int check_fails(const check_report *report); /* whether a finding is at or above --fail-on */
int check_is_same(const check_item *item, const check_item *other); /* rule and severity */
int check_is_first(const check_report *report, size_t index);       /* of those that are the same */
/* The same for equal findings of equal meshes in several files, and for pictures that are missing.
 * 0: the finding is of this file alone. */
uint64_t check_key(const check_report *report, const check_item *item);
size_t check_count_same(const check_report *report, const check_item *item);
/* What a clean file was not asked, in words that follow "No problems found"; or "". */
const char *check_unseen(const check_report *report);
/* Names from the root of the scene to the first node that draws the mesh of a finding, or to the
 * node that it is about. NULL: none. */
const char *check_node_path(norma_document *document, const char *where);

int check_page_is_folder(const check_settings *settings); /* check_one.c: else it is norma.html */
/* check_one.c: checks one of settings->files->inputs and writes its part of the report; adds to
 * totals. */
void check_one_file(const check_settings *settings, const check_config *config,
    const check_format *format, size_t index, FILE *out, check_totals *totals);

/* ---- all of them (check_all.c): so many at once as threads says; their parts go to out in the
 * order of inputs. */
int check_all_files(const check_settings *settings, const check_configs *configs,
    const check_format *format, FILE *out, check_totals *totals);

/* ---- old findings (known.c) */

typedef struct check_baseline check_baseline;
check_baseline *check_baseline_read(const char *path); /* NULL: said already */
check_baseline *check_baseline_new(const char *path);  /* to be filled and written */
int check_baseline_knows(const check_baseline *baseline, const char *path,
    const norma_finding *finding, norma_severity severity, int *knows); /* 0: out of memory */
/* For a new one: writes a finding to what is known of its file. 0: out of memory. */
int check_baseline_note(const check_baseline *baseline, const char *path,
    const norma_finding *finding, norma_severity severity, FILE *known);
/* Adds what was written so of a file; forgot: some findings are missing there. */
void check_baseline_add(check_baseline *baseline, const char *known, size_t size, int forgot);
int check_baseline_write(check_baseline *baseline, cli_guard *guard); /* a status */
int check_baseline_is_new(const check_baseline *baseline);
void check_baseline_free(check_baseline *baseline);

/* ---- JSON that someone wrote (known.c) */

int check_open_regular(const char *path); /* a descriptor; -1: reported already */
/* The whole of it; *size bytes, to be freed. NULL: reported already; errno shows memory. */
char *check_read_bytes(const char *path, size_t *size);
/* expected: what it should be, for messages. NULL: reported already. */
cli_parsed *check_load_json(const char *path, const char *expected);

/* ---- words */

/* The same for the same finding from run to run, whatever its count: 16 hexadecimal digits. */
void check_fingerprint(
    const char *path, const char *rule, const char *where, norma_severity severity, char text[17]);

/* ---- A small drawing of a finding's place, as SVG. */

/* Writes an <svg> of the surface round the worst place of a finding, the faces that it names in
 * red; nothing where it names no place. */
void check_draw_finding(FILE *out, norma_document *document, const norma_finding *finding);
/* A place within its model: of a composite's "/tiles/3/meshes/0" what follows the 3, and tile 3. */
const char *check_where_in_tile(const char *where, size_t *tile);
#endif
