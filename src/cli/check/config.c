/* config.c: .norma.json, found in a file's folder or the nearest one above it: what norma check is
 * to look for there. Read by jansson; every key that is not known is an error, since a misspelt one
 * would silence nothing or everything unseen.
 *
 *   {"profile": "print", "strict": true, "fail-on": "warning", "select": ["N1", "N3"], "ignore":
 * ["N402"], "severity": {"N104": "warning", "N701": "off"}, "overrides": [{"files": ["foliage"],
 * "meshes": ["leaf*"], "materials": ["*grass*"], "ignore": ["N2"], "severity": {...}}]} */
#define _XOPEN_SOURCE 700
#include "cli/check/check_command.h"
#include "cli/options/suggest.h"
#include "cli/process/errors.h"
#include <errno.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct config_entry {
    char *folder; /* where files are that it is for */
    check_config *config;
} config_entry;

struct check_configs {
    const char *named;
    check_config_trust trust;
    cli_guard *guard;
    check_config **configs; /* each read once */
    size_t config_count;
    config_entry *entries;
    size_t entry_count;
    char **strange; /* those of other users, each told once */
    size_t strange_count;
    check_config empty;
};

/* ---- reading */

static int fail(const check_config *config, const char *where, const char *expected) {
    cli_error("%s: %s: expected %s", config->path, where, expected);
    return 0;
}

/* Of a word where one of a list is expected. */
static int fail_word(
    const check_config *config, const char *where, const char *word, const char *expected) {
    char meant[CLI_LONGEST_WORD + 1];
    if (!word || !cli_suggest_listed(word, expected, meant)) return fail(config, where, expected);
    cli_error("%s: %s: expected %s; did you mean %s?", config->path, where, expected, meant);
    return 0;
}

static int fail_rule(const check_config *config, const char *where, const char *unknown) {
    const char *meant = cli_suggest_rule(unknown);
    if (!meant) return fail(config, where, "ids of rules, their beginnings or names");
    cli_error(
        "%s: %s: no rule is called '%s'; did you mean %s?", config->path, where, unknown, meant);
    return 0;
}

static int read_rules(
    const check_config *config, const char *where, const json_t *list, uint8_t *mask) {
    size_t i;
    json_t *word;
    char unknown[64] = "";
    if (!json_is_array(list))
        return fail(config, where, "a list of rules, such as [\"N301\", \"N5\", \"sliver-face\"]");
    json_array_foreach(list, i, word) {
        uint8_t some[CHECK_RULES] = {0};
        if (!json_is_string(word) ||
            norma_rules_select(json_string_value(word), some, unknown) != NORMA_OK)
            return fail_rule(config, where, unknown);
        for (size_t rule = 0; rule < CHECK_RULES; ++rule) mask[rule] |= some[rule];
    }
    return 1;
}

static int read_severity_name(const char *name) {
    static const char *const names[] = {"info", "warning", "error"};
    static const int severities[] = {
        NORMA_SEVERITY_INFO, NORMA_SEVERITY_WARNING, NORMA_SEVERITY_ERROR};
    for (size_t i = 0; name && i < CLI_COUNT(names); ++i)
        if (strcmp(name, names[i]) == 0) return severities[i];
    return -1;
}

static int read_severities(
    const check_config *config, const char *where, json_t *table, uint8_t *severity) {
    const char *key;
    json_t *value;
    char unknown[64] = "";
    if (!json_is_object(table))
        return fail(
            config, where, "an object of rules and \"off\", \"info\", \"warning\" or \"error\"");
    json_object_foreach(table, key, value) {
        uint8_t mask[CHECK_RULES] = {0};
        const char *word = json_string_value(value);
        int number =
            word && strcmp(word, "off") == 0 ? CHECK_SEVERITY_OFF : read_severity_name(word);
        if (number < 0)
            return fail_word(config, where, word, "\"off\", \"info\", \"warning\" or \"error\"");
        if (norma_rules_select(key, mask, unknown) != NORMA_OK)
            return fail_rule(config, where, unknown);
        for (size_t rule = 0; rule < CHECK_RULES; ++rule)
            if (mask[rule]) severity[rule] = (uint8_t)number;
    }
    return 1;
}

static void free_words(char **words) {
    for (size_t i = 0; words && words[i]; ++i) free(words[i]);
    free(words);
}

static int read_patterns(
    const check_config *config, const char *where, const json_t *list, char ***patterns) {
    size_t i;
    json_t *word;
    if (!json_is_array(list)) return fail(config, where, "a list of patterns, such as [\"leaf*\"]");
    free_words(*patterns);
    *patterns = calloc(json_array_size(list) + 1, sizeof **patterns);
    if (!*patterns) return fail(config, where, "memory for it");
    json_array_foreach(list, i, word) {
        if (!json_is_string(word))
            return fail(config, where, "a list of patterns, such as [\"leaf*\"]");
        (*patterns)[i] = strdup(json_string_value(word));
        if (!(*patterns)[i]) return fail(config, where, "memory for it");
    }
    return 1;
}

static void turn_off(const uint8_t *mask, uint8_t *severity) {
    for (size_t rule = 0; rule < CHECK_RULES; ++rule)
        if (mask[rule]) severity[rule] = CHECK_SEVERITY_OFF;
}

static int read_override(const check_config *config, json_t *table, check_override *override) {
    const char *key;
    json_t *value;
    if (!json_is_object(table)) return fail(config, "overrides", "a list of objects");
    json_object_foreach(table, key, value) {
        uint8_t ignore[CHECK_RULES] = {0};
        int fine = 0;
        if (strcmp(key, "files") == 0)
            fine = read_patterns(config, "overrides: files", value, &override->files);
        else if (strcmp(key, "meshes") == 0)
            fine = read_patterns(config, "overrides: meshes", value, &override->meshes);
        else if (strcmp(key, "materials") == 0)
            fine = read_patterns(config, "overrides: materials", value, &override->materials);
        else if (strcmp(key, "severity") == 0)
            fine = read_severities(config, "overrides: severity", value, override->severity);
        else if (strcmp(key, "ignore") == 0) {
            fine = read_rules(config, "overrides: ignore", value, ignore);
            turn_off(ignore, override->severity);
        } else
            fine = fail_word(config, key, key, "files, meshes, materials, ignore or severity");
        if (!fine) return 0;
    }
    return 1;
}

static int read_overrides(check_config *config, const json_t *list) {
    size_t i;
    json_t *table;
    if (!json_is_array(list)) return fail(config, "overrides", "a list of objects");
    if (config->overrides) return fail(config, "overrides", "them once");
    config->overrides = calloc(json_array_size(list) + 1, sizeof *config->overrides);
    if (!config->overrides) return fail(config, "overrides", "memory for them");
    json_array_foreach(list, i, table) {
        config->override_count = i + 1;
        if (!read_override(config, table, &config->overrides[i])) return 0;
    }
    return 1;
}

static int read_profile(check_config *config, const json_t *value) {
    const char *word = json_string_value(value);
    if (word && strcmp(word, "render") == 0)
        config->profile = NORMA_CHECK_PROFILE_RENDER;
    else if (word && strcmp(word, "print") == 0)
        config->profile = NORMA_CHECK_PROFILE_PRINT;
    else if (word && strcmp(word, "generated") == 0)
        config->profile = NORMA_CHECK_PROFILE_GENERATED;
    else
        return fail_word(config, "profile", word, "\"render\", \"print\" or \"generated\"");
    return 1;
}

static int read_fail_on(check_config *config, const json_t *value) {
    const char *word = json_string_value(value);
    config->fail_on =
        word && strcmp(word, "never") == 0 ? CHECK_FAIL_NEVER : read_severity_name(word);
    return config->fail_on > 0 ||
           fail_word(config, "fail-on", word, "\"error\", \"warning\", \"info\" or \"never\"");
}

static int read_key(check_config *config, const char *key, json_t *value) {
    if (strcmp(key, "profile") == 0) return read_profile(config, value);
    if (strcmp(key, "fail-on") == 0) return read_fail_on(config, value);
    if (strcmp(key, "strict") == 0) {
        config->strict = json_is_true(value);
        return json_is_boolean(value) || fail(config, key, "true or false");
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
    for (size_t i = 0; i < config->override_count; ++i) {
        free_words(config->overrides[i].files);
        free_words(config->overrides[i].meshes);
        free_words(config->overrides[i].materials);
    }
    free(config->overrides);
    free(config->path);
    free(config->folder);
    free(config);
}

static char *folder_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return strndup(path, slash ? (size_t)(slash - path) + 1 : 0);
}

static char *absolute_folder_of(const char *path) {
    char *folder = folder_of(path),
         *absolute = folder ? realpath(folder[0] ? folder : ".", NULL) : NULL;
    free(folder);
    return absolute;
}

/* Whoever asked for a configuration sees by errno that its text is not at fault. */
static check_config *without_memory(void) {
    cli_out_of_memory();
    errno = ENOMEM;
    return NULL;
}

static check_config *read_config(const char *path) {
    check_config *config = calloc(1, sizeof *config);
    if (!config) return without_memory();
    const char *key;
    json_t *value, *root = check_load_json(path, "a configuration in JSON");
    config->strict = config->fail_on = -1;
    config->path = strdup(path);
    config->folder = absolute_folder_of(path);
    int fine = config->path && config->folder && root;
    if (root && (!config->path || !config->folder))
        without_memory();
    else if (root && !json_is_object(root))
        fine = fail(config, "the file", "an object");
    if (fine) json_object_foreach(root, key, value) fine = fine && read_key(config, key, value);
    json_decref(root);
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
    for (size_t i = 0; i < configs->entry_count; ++i) free(configs->entries[i].folder);
    for (size_t i = 0; i < configs->strange_count; ++i) free(configs->strange[i]);
    free(configs->strange);
    free(configs->configs);
    free(configs->entries);
    free(configs);
}

static const check_config *remember(check_configs *configs, char *folder, check_config *config) {
    config_entry *grown =
        config ? realloc(configs->entries, (configs->entry_count + 1) * sizeof *grown) : NULL;
    if (!grown) {
        free(folder);
        return config;
    }
    configs->entries = grown;
    configs->entries[configs->entry_count++] = (config_entry){folder, config};
    return config;
}

const check_config *check_config_of(check_configs *configs, const char *path) {
    if (configs->trust == CHECK_CONFIG_NONE) return &configs->empty;
    if (configs->named) return add_config(configs, configs->named);
    char *folder = folder_of(path);
    if (!folder) return without_memory();
    /* Files of one folder follow each other. */
    for (size_t i = configs->entry_count; i-- > 0;)
        if (strcmp(configs->entries[i].folder, folder) == 0) {
            free(folder);
            return configs->entries[i].config;
        }
    return remember(configs, folder, config_of_folder(configs, folder));
}
