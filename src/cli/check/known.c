/* known.c: what is written beside files: configurations, and findings that are known. */
#define _POSIX_C_SOURCE 200809L
#define _DEFAULT_SOURCE /* MAP_ANONYMOUS */
#define _XOPEN_SOURCE   700
#include "cli/check/check.h"
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- Reads a JSON file that someone wrote for norma check: a configuration, a baseline. A
 * pipe or a device in its place would be waited for without end, so it is refused. */

/* Without waiting for a writer, if it is a pipe. */
int check_open_regular(const char *path) {
    struct stat status;
    const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK),
              failed = file < 0 || fstat(file, &status);
    if (!failed && S_ISREG(status.st_mode)) return file;
    if (failed)
        cli_error("%s: cannot be opened: %s", path, strerror(errno));
    else
        cli_error("%s: is not a regular file; expected one", path);
    if (file >= 0) close(file);
    return -1;
}

char *check_read_bytes(const char *path, size_t *size) {
    const int file = check_open_regular(path);
    char *text = file < 0 ? NULL : cli_read_all(file, size, NULL);
    const int why = errno;
    if (file < 0) return NULL;
    close(file);
    if (!text && why == ENOMEM)
        cli_out_of_memory();
    else if (!text)
        cli_error("%s: cannot be read: %s", path, strerror(why));
    errno = why;
    return text;
}

cli_parsed *check_load_json(const char *path, const char *expected) {
    size_t size;
    cli_json_fault fault;
    char *text = check_read_bytes(path, &size);
    if (!text) return NULL;
    cli_parsed *parsed = cli_json_parse(text, size, &fault);
    free(text);
    if (!parsed && fault.expected)
        cli_error("%s:%zu: %s%s%s: expected %s, in %s", path, fault.line,
            fault.near[0] ? "near '" : "at the end", fault.near, fault.near[0] ? "'" : "",
            fault.expected, expected);
    else if (!parsed) {
        cli_out_of_memory();
        errno = ENOMEM;
    }
    return parsed;
}

/* ---- .norma.json, found in a file's folder or the nearest one above it: what norma check is
 * to look for there. Every key that is not known is an error, since a misspelt one
 * would silence nothing or everything unseen.
 *
 *   {"profile": "print", "strict": true, "fail-on": "warning", "select": ["N1", "N3"], "ignore":
 * ["N402"], "severity": {"N104": "warning", "N701": "off"}, "overrides": [{"files": ["foliage"],
 * "meshes": ["leaf*"], "materials": ["*grass*"], "nodes": ["hall*"], "ignore": ["N2"], "severity":
 * {...}}]} */

struct check_configs {
    const char *named;
    check_config_trust trust;
    cli_guard *guard;
    check_config **configs; /* each read once */
    size_t config_count;
    const check_config **of_files; /* of each input */
    char **strange;                /* those of other users, each told once */
    size_t strange_count;
    check_config empty;
};

/* ---- reading */

static int fail_config(const check_config *config, const char *where, const char *expected) {
    cli_error("%s: %s: expected %s", config->path, where, expected);
    return 0;
}

/* Of a word where one of a list is expected. */
static int fail_word(
    const check_config *config, const char *where, const char *word, const char *expected) {
    char meant[CLI_LONGEST_WORD + 1];
    if (!word || !cli_suggest_listed(word, expected, meant))
        return fail_config(config, where, expected);
    cli_error("%s: %s: expected %s; did you mean %s?", config->path, where, expected, meant);
    return 0;
}

static int fail_rule(const check_config *config, const char *where, const char *unknown) {
    const char *meant = cli_suggest_rule(unknown);
    if (!meant) return fail_config(config, where, "ids of rules, their beginnings or names");
    cli_error(
        "%s: %s: no rule is called '%s'; did you mean %s?", config->path, where, unknown, meant);
    return 0;
}

static int read_rules(
    const check_config *config, const char *where, cli_value list, uint8_t *mask) {
    char unknown[64] = "";
    if (!cli_is_array(list))
        return fail_config(
            config, where, "a list of rules, such as [\"N301\", \"N5\", \"sliver-face\"]");
    for (cli_value word = cli_first(list); word.in; word = cli_next(word)) {
        uint8_t some[CHECK_RULES] = {0};
        if (!cli_string(word) || norma_rules_select(cli_string(word), some, unknown))
            return fail_rule(config, where, unknown);
        for (size_t rule = 0; rule < CHECK_RULES; ++rule) mask[rule] |= some[rule];
    }
    return 1;
}

static int read_severities(
    const check_config *config, const char *where, cli_value table, uint8_t *severity) {
    char unknown[64] = "";
    if (!cli_is_object(table))
        return fail_config(
            config, where, "an object of rules and \"off\", \"info\", \"warning\" or \"error\"");
    for (cli_value value = cli_first(table); value.in; value = cli_next(value)) {
        uint8_t mask[CHECK_RULES] = {0};
        const char *word = cli_string(value);
        const int number =
            word && strcmp(word, "off") == 0 ? CHECK_SEVERITY_OFF : (int)cli_find_severity(word);
        if (!number)
            return fail_word(config, where, word, "\"off\", \"info\", \"warning\" or \"error\"");
        if (norma_rules_select(cli_key(value), mask, unknown))
            return fail_rule(config, where, unknown);
        for (size_t rule = 0; rule < CHECK_RULES; ++rule)
            if (mask[rule]) severity[rule] = (uint8_t)number;
    }
    return 1;
}

static int read_patterns(const check_config *config, const char *where, cli_value list) {
    int fine = cli_is_array(list);
    for (cli_value word = cli_first(list); word.in; word = cli_next(word))
        fine = fine && cli_string(word);
    return fine || fail_config(config, where, "a list of patterns, such as [\"leaf*\"]");
}

const char *const check_list_keys[CHECK_LISTS] = {"files", "meshes", "materials", "nodes"};

static int read_override(const check_config *config, cli_value table, check_override *override) {
    if (!cli_is_object(table)) return fail_config(config, "overrides", "a list of objects");
    for (cli_value value = cli_first(table); value.in; value = cli_next(value)) {
        const char *key = cli_key(value);
        uint8_t ignore[CHECK_RULES] = {0};
        char where[40];
        int fine, list = 0;
        while (list < CHECK_LISTS && strcmp(key, check_list_keys[list]) != 0) ++list;
        snprintf(where, sizeof where, "overrides: %s", key);
        if (list < CHECK_LISTS) {
            override->lists[list] = value;
            fine = read_patterns(config, where, value);
        } else if (strcmp(key, "severity") == 0) {
            fine = read_severities(config, where, value, override->severity);
        } else if (strcmp(key, "ignore") == 0) {
            fine = read_rules(config, where, value, ignore);
            for (size_t rule = 0; rule < CHECK_RULES; ++rule)
                if (ignore[rule]) override->severity[rule] = CHECK_SEVERITY_OFF;
        } else {
            fine =
                fail_word(config, key, key, "files, meshes, materials, nodes, ignore or severity");
        }
        if (!fine) return 0;
    }
    return 1;
}

/* Workers are processes: their marks lie in memory that all of them share. */
static int make_pattern_marks(check_config *config) {
    for (size_t i = 0; i < config->override_count; ++i)
        for (int list = 0; list < CHECK_LISTS; ++list) {
            config->overrides[i].first[list] = config->pattern_count;
            config->pattern_count += cli_elements(config->overrides[i].lists[list]);
        }
    ++config->pattern_count; /* never none */
    void *shared = mmap(
        NULL, config->pattern_count, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    config->matched = shared == MAP_FAILED ? NULL : shared;
    return config->matched != NULL;
}

static int read_overrides(check_config *config, cli_value list) {
    if (!cli_is_array(list)) return fail_config(config, "overrides", "a list of objects");
    config->overrides = calloc(cli_elements(list) + 1, sizeof *config->overrides);
    if (!config->overrides) return fail_config(config, "overrides", "memory for them");
    for (cli_value table = cli_first(list); table.in; table = cli_next(table))
        if (!read_override(config, table, &config->overrides[config->override_count++])) return 0;
    return make_pattern_marks(config) || fail_config(config, "overrides", "memory for them");
}

static int read_config_profile(check_config *config, cli_value value) {
    const char *word = cli_string(value);
    return check_find_profile(word, &config->profile) ||
           fail_word(config, "profile", word, "\"render\", \"print\" or \"generated\"");
}

static int read_fail_on(check_config *config, cli_value value) {
    const char *word = cli_string(value);
    config->fail_on =
        word && strcmp(word, "never") == 0 ? CHECK_FAIL_NEVER : (int)cli_find_severity(word);
    return config->fail_on > 0 ||
           fail_word(config, "fail-on", word, "\"error\", \"warning\", \"info\" or \"never\"");
}

static int read_key(check_config *config, const char *key, cli_value value) {
    if (strcmp(key, "profile") == 0) return read_config_profile(config, value);
    if (strcmp(key, "fail-on") == 0) return read_fail_on(config, value);
    if (strcmp(key, "strict") == 0) {
        config->strict = cli_is_true(value);
        return config->strict || cli_is_false(value) || fail_config(config, key, "true or false");
    }
    if (strcmp(key, "select") == 0) {
        config->has_select = 1;
        return read_rules(config, key, value, config->select);
    }
    if (strcmp(key, "ignore") == 0) return read_rules(config, key, value, config->ignore);
    if (strcmp(key, "severity") == 0) return read_severities(config, key, value, config->severity);
    if (strcmp(key, "overrides") == 0) return read_overrides(config, value);
    return fail_word(
        config, key, key, "profile, strict, fail-on, select, ignore, severity or overrides");
}

static void free_config(check_config *config) {
    if (!config) return;
    if (config->matched) munmap(config->matched, config->pattern_count);
    cli_json_free(config->text);
    free(config->overrides);
    free(config->path);
    free(config->folder);
    free(config);
}

static char *folder_with_slash(const char *path) {
    const char *slash = strrchr(path, '/');
    return strndup(path, slash ? (size_t)(slash - path) + 1 : 0);
}

/* NULL: it is not there, or memory is out (errno). */
static char *absolute_folder_of(const char *path) {
    char *folder = folder_with_slash(path),
         *absolute = folder ? realpath(folder[0] ? folder : ".", NULL) : NULL;
    free(folder);
    return absolute;
}

/* errno shows the caller that the configuration's text is not at fault. */
static check_config *without_memory(void) {
    cli_out_of_memory();
    errno = ENOMEM;
    return NULL;
}

static check_config *read_config(const char *path) {
    check_config *config = calloc(1, sizeof *config);
    if (!config) return without_memory();
    config->strict = config->fail_on = -1;
    config->path = strdup(path);
    config->folder = absolute_folder_of(path);
    config->text = check_load_json(path, "a configuration in JSON"); /* last: errno stays */
    int fine = config->path && config->folder && config->text;
    if (config->text && !fine)
        without_memory();
    else if (fine && !cli_is_object(cli_json_root(config->text)))
        fine = fail_config(config, "the file", "an object");
    for (cli_value v = fine ? cli_first(cli_json_root(config->text)) : (cli_value){0}; v.in && fine;
         v = cli_next(v))
        fine = read_key(config, cli_key(v), v);
    if (fine) return config;
    free_config(config);
    return NULL;
}

/* ---- finding */

static check_config *add_config(check_configs *configs, const char *path) {
    for (size_t i = 0; i < configs->config_count; ++i)
        if (strcmp(configs->configs[i]->path, path) == 0) return configs->configs[i];
    check_config **grown = realloc(configs->configs, (configs->config_count + 1) * sizeof *grown);
    if (!grown) return without_memory();
    configs->configs = grown;
    cli_guard_read(configs->guard, path);
    check_config *config = read_config(path);
    if (config) configs->configs[configs->config_count++] = config;
    return config;
}

/* A configuration that nobody named may be a stranger's, who would have another file's words quoted
 * in a message through a link. */
static int is_link(const char *path, const struct stat *status) {
    if (!S_ISLNK(status->st_mode)) return 0;
    cli_error("%s: is a symbolic link; expected a regular file, or --config FILE", path);
    return 1;
}

/* Whose configurations are obeyed: the user's, the system's, and through sudo those of who called
 * it. */
static int is_trusted_owner(uid_t owner) {
    const char *caller = getenv("SUDO_UID");
    char *end = NULL;
    if (owner == 0 || owner == geteuid()) return 1;
    if (geteuid() != 0 || !caller || !caller[0]) return 0;
    const unsigned long number = strtoul(caller, &end, 10);
    return *end == '\0' && number == (unsigned long)owner;
}

/* Each is told once, however many folders lie below it. 0: out of memory. */
static int tell_strange(check_configs *configs, const char *path) {
    for (size_t i = 0; i < configs->strange_count; ++i)
        if (strcmp(configs->strange[i], path) == 0) return 1;
    char **grown = realloc(configs->strange, (configs->strange_count + 1) * sizeof *grown);
    if (grown) configs->strange = grown;
    if (!grown || !(grown[configs->strange_count] = strdup(path))) return 0;
    ++configs->strange_count;
    cli_error("%s: ignored because it or its folder belongs to another user; --trust-config or "
              "--config FILE uses it",
        path);
    return 1;
}

/* As git does with repositories (safe.directory): in a folder that many can write to, anybody could
 * silence the findings of all others. *trusted: 0 where it is passed over. 0: out of memory. */
static int judge_owner(check_configs *configs, const char *folder, const char *path,
    const struct stat *file, int *trusted) {
    struct stat status;
    *trusted = configs->trust == CHECK_CONFIG_ANY ||
               (is_trusted_owner(file->st_uid) && stat(folder[0] ? folder : "/", &status) == 0 &&
                   is_trusted_owner(status.st_uid));
    return *trusted || tell_strange(configs, path);
}

/* Looks in folder (absolute, without its last slash) and above. *found stays NULL if no file
 * exists. Returns 0 if one exists and cannot be read. */
static int find_upward(check_configs *configs, char *folder, check_config **found) {
    for (;;) {
        char *slash, path[4200];
        struct stat status;
        int trusted = 0;
        snprintf(path, sizeof path, "%s/.norma.json", folder);
        if (strlen(folder) < 4096 && lstat(path, &status) == 0 &&
            !judge_owner(configs, folder, path, &status, &trusted)) {
            without_memory();
            return 0;
        }
        if (trusted) {
            *found = is_link(path, &status) ? NULL : add_config(configs, path);
            return *found != NULL;
        }
        slash = strrchr(folder, '/');
        if (!slash) return 1;
        *slash = '\0';
    }
}

static check_config *config_of_folder(check_configs *configs, const char *folder) {
    check_config *found = &configs->empty;
    char *absolute = realpath(folder[0] ? folder : ".", NULL);
    if (!absolute) return found; /* the file will not be found either */
    check_config *above = NULL;
    if (strcmp(absolute, "/") == 0) absolute[0] = '\0';
    if (!find_upward(configs, absolute, &above))
        found = NULL;
    else if (above)
        found = above;
    free(absolute);
    return found;
}

check_configs *check_configs_new(const char *named, check_config_trust trust, cli_guard *guard) {
    check_configs *configs = calloc(1, sizeof *configs);
    if (!configs) return NULL;
    configs->named = named;
    configs->trust = trust;
    configs->guard = guard;
    if (named) cli_guard_read(guard, named);
    configs->empty.strict = configs->empty.fail_on = -1;
    return configs;
}

void check_configs_free(check_configs *configs) {
    if (!configs) return;
    for (size_t i = 0; i < configs->config_count; ++i) free_config(configs->configs[i]);
    for (size_t i = 0; i < configs->strange_count; ++i) free(configs->strange[i]);
    free(configs->strange);
    free(configs->configs);
    free(configs->of_files);
    free(configs);
}

/* NULL: one that cannot be read, which has been said; errno shows memory. */
static const check_config *find_config(check_configs *configs, const char *path) {
    if (configs->trust == CHECK_CONFIG_NONE) return &configs->empty;
    if (configs->named) return add_config(configs, configs->named);
    char *folder = folder_with_slash(path);
    if (!folder) return without_memory();
    const check_config *found = config_of_folder(configs, folder);
    free(folder);
    return found;
}

/* Files of one folder follow each other. */
static int is_beside(const char *path, const char *other) {
    const size_t folder = (size_t)(cli_base_name(path) - path);
    return folder == (size_t)(cli_base_name(other) - other) && memcmp(path, other, folder) == 0;
}

int check_configs_read(check_configs *configs, const cli_inputs *inputs) {
    configs->of_files = calloc(inputs->count + 1, sizeof *configs->of_files);
    if (!configs->of_files) return cli_out_of_memory();
    for (size_t i = 0; i < inputs->count; ++i) {
        errno = 0;
        configs->of_files[i] = i && is_beside(inputs->list[i].path, inputs->list[i - 1].path)
                                   ? configs->of_files[i - 1]
                                   : find_config(configs, inputs->list[i].path);
        if (!configs->of_files[i]) return errno == ENOMEM ? CLI_FILE : CLI_USAGE;
    }
    return CLI_OK;
}

const check_config *check_config_of(const check_configs *configs, size_t file) {
    return configs->of_files[file];
}

/* ---- Findings of old, kept in a file, so that a repository with many can begin to check
 * today: known findings are hidden unless they get worse. Paths are relative to the baseline's own
 * folder, so it does not matter from where the check is run or how a file is spelt.
 *
 *   {"schema": "norma-baseline/1", "findings": [{"path", "rule", "where", "severity", "count"},
 * ...]} */

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

/* Over the parts and a zero after each. */
void check_fingerprint(
    const char *path, const char *rule, const char *where, norma_severity severity, char text[17]) {
    const char *parts[] = {path, rule, where, cli_severity_name(severity)};
    uint64_t hash = CLI_HASH;
    for (size_t i = 0; i < CLI_COUNT(parts); ++i)
        hash = cli_hash(hash, parts[i], strlen(parts[i]) + 1);
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
    known_finding *grown =
        cli_grow(baseline->known, baseline->count, &baseline->capacity, sizeof *grown);
    if (!grown) return 0;
    baseline->known = grown;
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

/* How many bytes two absolute folders share, whole components only. */
static size_t shared_length(const char *a, const char *b) {
    size_t same = 0, length = 0;
    for (; a[same] && a[same] == b[same]; ++same)
        if (a[same] == '/') length = same;
    const int ends = (!a[same] || a[same] == '/') && (!b[same] || b[same] == '/');
    return ends ? same : length;
}

/* A file as the baseline names it: from its own folder, with ../ where it lies elsewhere. The file
 * may be a link, or missing: only its folder is looked up. The caller's to free; NULL: memory is
 * out. */
static char *place_in_baseline(const check_baseline *baseline, const char *path) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    errno = 0;
    char *folder = strcmp(path, "-") == 0 || !baseline->folder ? NULL : absolute_folder_of(path);
    if (!folder) return errno == ENOMEM ? NULL : strdup(path);
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
    baseline->is_new = 1;
    errno = 0;
    baseline->folder = absolute_folder_of(path);
    if (baseline->folder || errno != ENOMEM) return baseline;
    cli_out_of_memory();
    check_baseline_free(baseline);
    return NULL;
}

void check_baseline_free(check_baseline *baseline) {
    if (!baseline) return;
    for (size_t i = 0; i < baseline->count; ++i) free_known(&baseline->known[i]);
    free(baseline->known);
    free(baseline->folder);
    free(baseline);
}

int check_baseline_is_new(const check_baseline *baseline) { return baseline->is_new; }

static int read_known(check_baseline *baseline, cli_value root) {
    const cli_value list = cli_get(root, "findings");
    const char *schema = cli_string(cli_get(root, "schema"));
    if (!cli_is_array(list) || !schema || strcmp(schema, "norma-baseline/1") != 0) return 0;
    for (cli_value entry = cli_first(list); entry.in; entry = cli_next(entry)) {
        const char *path = cli_string(cli_get(entry, "path")),
                   *rule = cli_string(cli_get(entry, "rule")),
                   *where = cli_string(cli_get(entry, "where"));
        const norma_severity severity = cli_find_severity(cli_string(cli_get(entry, "severity")));
        size_t count;
        if (!path || !rule || !where || !severity ||
            !cli_count_of(cli_get(entry, "count"), &count) ||
            !add_known(baseline, path, rule, where, severity, count))
            return 0;
    }
    if (baseline->count)
        qsort(baseline->known, baseline->count, sizeof *baseline->known, compare_known);
    return 1;
}

check_baseline *check_baseline_read(const char *path) {
    static const char expected[] = "a baseline that --write-baseline wrote";
    check_baseline *baseline = check_baseline_new(path);
    cli_parsed *root = baseline ? check_load_json(path, expected) : NULL;
    errno = 0;
    if (root && read_known(baseline, cli_json_root(root))) {
        baseline->is_new = 0;
        cli_json_free(root);
        return baseline;
    }
    if (!baseline) return NULL;
    if (root && errno == ENOMEM)
        cli_out_of_memory();
    else if (root)
        cli_error("%s: expected %s", path, expected);
    cli_json_free(root);
    check_baseline_free(baseline);
    return NULL;
}

int check_baseline_knows(const check_baseline *baseline, const char *path,
    const norma_finding *finding, norma_severity severity, int *knows) {
    known_finding key;
    char *place = place_in_baseline(baseline, path);
    if (!place) return 0;
    check_fingerprint(place, finding->rule->id, finding->where, severity, key.fingerprint);
    free(place);
    const known_finding *known = baseline->count ? bsearch(&key, baseline->known, baseline->count,
                                                       sizeof *baseline->known, compare_known)
                                                 : NULL;
    *knows = known && finding->count <= known->count;
    return 1;
}

int check_baseline_note(const check_baseline *baseline, const char *path,
    const norma_finding *finding, norma_severity severity, FILE *known) {
    char *place = place_in_baseline(baseline, path);
    if (!place) return 0;
    fprintf(known, "%zu %d %s%c%s%c%s%c", finding->count, (int)severity, place, 0,
        finding->rule->id, 0, finding->where, 0);
    free(place);
    return 1;
}

void check_baseline_add(check_baseline *baseline, const char *known, size_t size, int forgot) {
    baseline->incomplete |= forgot;
    if (!size) return;
    for (const char *at = known, *end = known + size; at < end;) {
        char *path;
        const size_t count = (size_t)strtoull(at, &path, 10);
        const norma_severity severity = (norma_severity)strtol(path, &path, 10);
        ++path; /* a blank */
        const char *rule = path + strlen(path) + 1, *where = rule + strlen(rule) + 1;
        baseline->incomplete |= !add_known(baseline, path, rule, where, severity, count);
        at = where + strlen(where) + 1;
    }
}

static int compare_known_places(const void *a, const void *b) {
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
        cli_json_print(&json, "{path: %s, rule: %s, where: %s, severity: %s, count: %zu}",
            known->path, known->rule, known->where, cli_severity_name(known->severity),
            known->count);
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
        qsort(baseline->known, baseline->count, sizeof *baseline->known, compare_known_places);
    const int status = cli_output_begin(&output, baseline->path, guard);
    if (status) return status;
    write_known(output.out, baseline);
    return cli_output_end(&output);
}
