/* baseline.c: findings of old, kept in a file, so that a repository with many can begin to check
 * today: known findings are hidden unless they get worse. Paths are relative to the baseline's own
 * folder, so it does not matter from where the check is run or how a file is spelt. Read by
 * jansson.
 *
 *   {"schema": "norma-baseline/1", "findings": [{"path", "rule", "where", "severity", "count"},
 * ...]} */
#define _XOPEN_SOURCE 700
#include "cli/check/check_command.h"
#include "cli/files/report_output.h"
#include "cli/process/errors.h"
#include "cli/process/worker.h"
#include <errno.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

typedef struct known_finding {
    char fingerprint[17];
    size_t count;
    char *path, *rule, *where;
    norma_severity severity;
} known_finding;

struct check_baseline {
    const char *path;
    char *folder;           /* absolute, of the baseline itself; NULL: it does not exist */
    int is_new, incomplete; /* incomplete: memory was out, findings are missing */
    known_finding *known;
    size_t count, capacity;
};

const char *check_severity_name(norma_severity severity) {
    switch (severity) {
    case NORMA_SEVERITY_ERROR:
        return "error";
    case NORMA_SEVERITY_WARNING:
        return "warning";
    case NORMA_SEVERITY_INFO:
        return "info";
    case NORMA_SEVERITY_NONE:
        break;
    }
    return "none";
}

/* FNV-1a (Fowler, Noll, Vo), 64 bits, over the parts and a zero after each. */
void check_fingerprint(
    const char *path, const char *rule, const char *where, norma_severity severity, char text[17]) {
    const char *parts[] = {path, rule, where, check_severity_name(severity)};
    uint64_t hash = 14695981039346656037u;
    for (size_t i = 0; i < CLI_COUNT(parts); ++i)
        for (const char *at = parts[i];; ++at) {
            hash = (hash ^ (unsigned char)*at) * 1099511628211u;
            if (!*at) break;
        }
    snprintf(text, 17, "%016llx", (unsigned long long)hash);
}

static int compare_known(const void *a, const void *b) {
    return strcmp(((const known_finding *)a)->fingerprint, ((const known_finding *)b)->fingerprint);
}

static void free_known(known_finding *known) {
    free(known->path);
    free(known->rule);
    free(known->where);
}

static int add_known(check_baseline *baseline, const char *path, const char *rule,
    const char *where, norma_severity severity, size_t count) {
    if (baseline->count == baseline->capacity) {
        size_t capacity = baseline->capacity ? 2 * baseline->capacity : 64;
        known_finding *grown = realloc(baseline->known, capacity * sizeof *grown);
        if (!grown) return 0;
        baseline->known = grown;
        baseline->capacity = capacity;
    }
    known_finding *known = &baseline->known[baseline->count];
    *known = (known_finding){.count = count,
        .severity = severity,
        .path = strdup(path),
        .rule = strdup(rule),
        .where = strdup(where)};
    if (!known->path || !known->rule || !known->where) {
        free_known(known);
        return 0;
    }
    check_fingerprint(path, rule, where, severity, known->fingerprint);
    ++baseline->count;
    return 1;
}

/* ---- paths */

static char *real_folder_of(const char *path) {
    const char *slash = strrchr(path, '/');
    char *folder = slash ? strndup(path, (size_t)(slash - path) + 1) : strdup("."),
         *real = folder ? realpath(folder, NULL) : NULL;
    free(folder);
    return real;
}

/* How many bytes two absolute folders share, whole components only. */
static size_t shared_length(const char *a, const char *b) {
    size_t same = 0, length = 0;
    for (; a[same] && a[same] == b[same]; ++same)
        if (a[same] == '/') length = same;
    const int ends = (!a[same] || a[same] == '/') && (!b[same] || b[same] == '/');
    return ends ? same : length;
}

/* A file as the baseline names it: from its own folder, with ../ where it lies elsewhere. The file
 * may be a link, or missing: only its folder is looked up. The caller's to free. */
static char *place_of(const check_baseline *baseline, const char *path) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    char *folder = strcmp(path, "-") == 0 || !baseline->folder ? NULL : real_folder_of(path);
    if (!folder) return strdup(path);
    const size_t shared = shared_length(folder, baseline->folder);
    size_t ups = 0;
    for (const char *at = baseline->folder + shared; *at; ++at) ups += *at == '/' && at[1];
    const char *below = folder + shared;
    below += *below == '/';
    const size_t size = 3 * ups + strlen(below) + strlen(name) + 2;
    char *place = malloc(size);
    if (place) {
        for (size_t i = 0; i < ups; ++i) memcpy(place + 3 * i, "../", 3);
        snprintf(place + 3 * ups, size - 3 * ups, "%s%s%s", below, *below ? "/" : "", name);
    }
    free(folder);
    return place;
}

check_baseline *check_baseline_new(const char *path) {
    check_baseline *baseline = calloc(1, sizeof *baseline);
    if (!baseline) {
        cli_out_of_memory();
        return NULL;
    }
    baseline->path = path;
    baseline->folder = real_folder_of(path);
    baseline->is_new = 1;
    return baseline;
}

check_baseline *check_baseline_part(const check_baseline *whole) {
    return check_baseline_new(whole->path);
}

void check_baseline_join(check_baseline *whole, const check_baseline *part, int forgot) {
    whole->incomplete |= forgot || (part && part->incomplete);
    for (size_t i = 0; part && i < part->count; ++i) {
        const known_finding *known = &part->known[i];
        whole->incomplete |= !add_known(
            whole, known->path, known->rule, known->where, known->severity, known->count);
    }
}

size_t check_baseline_count(const check_baseline *baseline) { return baseline->count; }

/* ---- between processes: sizes, then what they measure */

typedef struct finding_message {
    size_t count, path, rule, where;
    norma_severity severity;
} finding_message;

void check_baseline_send(const check_baseline *part, const cli_worker *worker) {
    for (size_t i = 0; i < part->count; ++i) {
        const known_finding *known = &part->known[i];
        const finding_message message = {known->count, strlen(known->path) + 1,
            strlen(known->rule) + 1, strlen(known->where) + 1, known->severity};
        cli_worker_send(worker, &message, sizeof message);
        cli_worker_send(worker, known->path, message.path);
        cli_worker_send(worker, known->rule, message.rule);
        cli_worker_send(worker, known->where, message.where);
    }
}

static int receive_finding(check_baseline *whole, const cli_worker *worker) {
    finding_message message;
    if (!cli_worker_receive(worker, &message, sizeof message)) return 0;
    const size_t size = message.path + message.rule + message.where;
    char *words = malloc(size);
    const int fine = words && cli_worker_receive(worker, words, size);
    if (fine)
        whole->incomplete |= !add_known(whole, words, words + message.path,
            words + message.path + message.rule, message.severity, message.count);
    free(words);
    return fine;
}

int check_baseline_receive(check_baseline *whole, size_t count, const cli_worker *worker) {
    int fine = 1;
    for (size_t i = 0; i < count && fine; ++i) fine = receive_finding(whole, worker);
    return fine;
}

void check_baseline_free(check_baseline *baseline) {
    if (!baseline) return;
    for (size_t i = 0; i < baseline->count; ++i) free_known(&baseline->known[i]);
    free(baseline->known);
    free(baseline->folder);
    free(baseline);
}

int check_baseline_is_new(const check_baseline *baseline) { return baseline->is_new; }

static norma_severity severity_of(const char *name) {
    for (int severity = NORMA_SEVERITY_INFO; severity <= NORMA_SEVERITY_ERROR; ++severity)
        if (name && strcmp(name, check_severity_name((norma_severity)severity)) == 0)
            return (norma_severity)severity;
    return NORMA_SEVERITY_NONE;
}

static int read_known(check_baseline *baseline, const json_t *root) {
    const json_t *list = json_object_get(root, "findings"),
                 *schema = json_object_get(root, "schema");
    size_t i;
    json_t *entry;
    if (!json_is_array(list) || !json_is_string(schema) ||
        strcmp(json_string_value(schema), "norma-baseline/1") != 0)
        return 0;
    json_array_foreach(list, i, entry) {
        const char *path = json_string_value(json_object_get(entry, "path")),
                   *rule = json_string_value(json_object_get(entry, "rule"));
        const char *where = json_string_value(json_object_get(entry, "where"));
        norma_severity severity =
            severity_of(json_string_value(json_object_get(entry, "severity")));
        json_int_t count = json_integer_value(json_object_get(entry, "count"));
        if (!path || !rule || !where || !severity || count < 0 ||
            !add_known(baseline, path, rule, where, severity, (size_t)count))
            return 0;
    }
    if (baseline->count)
        qsort(baseline->known, baseline->count, sizeof *baseline->known, compare_known);
    return 1;
}

check_baseline *check_baseline_read(const char *path) {
    static const char expected[] = "a baseline that --write-baseline wrote";
    check_baseline *baseline = check_baseline_new(path);
    json_t *root = baseline ? check_load_json(path, expected) : NULL;
    if (root && read_known(baseline, root)) {
        baseline->is_new = 0;
        json_decref(root);
        return baseline;
    }
    if (!baseline) return NULL;
    if (root) cli_error("%s: expected %s", path, expected);
    json_decref(root);
    check_baseline_free(baseline);
    return NULL;
}

int check_baseline_knows(const check_baseline *baseline, const char *path,
    const norma_finding *finding, norma_severity severity) {
    known_finding key;
    char *place = place_of(baseline, path);
    if (!place) return 0;
    check_fingerprint(place, finding->rule->id, finding->where, severity, key.fingerprint);
    free(place);
    const known_finding *known = baseline->count ? bsearch(&key, baseline->known, baseline->count,
                                                       sizeof *baseline->known, compare_known)
                                                 : NULL;
    return known && finding->count <= known->count;
}

int check_baseline_add(check_baseline *baseline, const char *path, const norma_finding *finding,
    norma_severity severity) {
    char *place = place_of(baseline, path);
    const int fine = place && add_known(baseline, place, finding->rule->id, finding->where,
                                  severity, finding->count);
    baseline->incomplete |= !fine;
    free(place);
    return fine;
}

static int compare_places(const void *a, const void *b) {
    const known_finding *one = a, *other = b;
    int order = strcmp(one->path, other->path);
    if (!order) order = strcmp(one->where, other->where);
    if (!order) order = strcmp(one->rule, other->rule);
    return order ? order : (int)one->severity - (int)other->severity;
}

static void write_known(FILE *out, const check_baseline *baseline) {
    cli_json json = {.out = out};
    fputs("{\"schema\": \"norma-baseline/1\", \"findings\": [", out);
    for (size_t i = 0; i < baseline->count; ++i) {
        const known_finding *known = &baseline->known[i];
        fputs(i ? ",\n" : "\n", out);
        json.needs_comma = 0;
        cli_json_open(&json, NULL, '{');
        cli_json_string(&json, "path", known->path);
        cli_json_string(&json, "rule", known->rule);
        cli_json_string(&json, "where", known->where);
        cli_json_string(&json, "severity", check_severity_name(known->severity));
        cli_json_size(&json, "count", known->count);
        cli_json_close(&json, '}');
    }
    fputs("\n]}\n", out);
}

int check_baseline_write(check_baseline *baseline, cli_guard *guard) {
    cli_output output;
    if (baseline->incomplete) {
        cli_error("%s: not written: out of memory", baseline->path);
        return CLI_FILE;
    }
    if (baseline->count)
        qsort(baseline->known, baseline->count, sizeof *baseline->known, compare_places);
    const int status = cli_output_begin(&output, baseline->path, guard);
    if (status) return status;
    write_known(output.out, baseline);
    return cli_output_end(&output);
}
