/* find_inputs.c: which files norma check looks at: those that are named, those of folders and
 * below, those that patterns match, those of a list. Folders are walked in the order of names, so
 * that a report does not depend on the file system; what is hidden is passed over there. */
#define _POSIX_C_SOURCE 200809L
#include "cli/check/check_command.h"
#include <dirent.h>
#include <errno.h>
#include <fnmatch.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static int out_of_memory(void) {
    cli_error("out of memory");
    return CLI_FILE;
}

static int add_path(check_inputs *inputs, char *path) {
    if (!path) return out_of_memory();
    if (inputs->count == inputs->capacity) {
        size_t capacity = inputs->capacity ? 2 * inputs->capacity : 64;
        char **paths = realloc(inputs->paths, capacity * sizeof *paths);
        if (!paths) {
            free(path);
            return out_of_memory();
        }
        inputs->paths = paths;
        inputs->capacity = capacity;
    }
    inputs->paths[inputs->count++] = path;
    return CLI_OK;
}

void check_inputs_free(check_inputs *inputs) {
    for (size_t i = 0; i < inputs->count; ++i) free(inputs->paths[i]);
    free(inputs->paths);
}

/* ---- patterns */

/* Both run component by component; the last "**" met is where a mismatch goes back to, so nothing
 * is tried twice. */
static int components_match(const char *pattern, const char *path) {
    const char *star = NULL, *resume = NULL;
    char part[512], name[512];
    for (;;) {
        size_t length = strcspn(pattern, "/"), name_length = strcspn(path, "/");
        if (length == 2 && memcmp(pattern, "**", 2) == 0) {
            star = pattern + length + (pattern[length] == '/');
            resume = path;
            pattern = star;
            if (!*pattern) return 1;
            continue;
        }
        int same = 0;
        if (*pattern && *path && length < sizeof part && name_length < sizeof name) {
            memcpy(part, pattern, length), part[length] = '\0';
            memcpy(name, path, name_length), name[name_length] = '\0';
            same = fnmatch(part, name, 0) == 0 &&
                   (pattern[length] == '\0') == (path[name_length] == '\0');
            /* A pattern that goes on after "**" must reach the path's end. */
            if (same && pattern[length] == '\0') return 1;
        }
        if (same) {
            pattern += length + 1;
            path += name_length + 1;
            continue;
        }
        if (!star || !resume[strcspn(resume, "/")]) return 0;
        resume += strcspn(resume, "/") + 1;
        path = resume;
        pattern = star;
    }
}

int check_path_matches(const char *pattern, const char *path) {
    const char *slash = strrchr(path, '/');
    return components_match(pattern, strchr(pattern, '/') ? path : slash ? slash + 1 : path);
}

/* ---- folders */

static char *join(const char *folder, const char *name) {
    size_t length = strlen(folder), size = length + strlen(name) + 2;
    char *path = malloc(size);
    if (path)
        snprintf(
            path, size, "%s%s%s", folder, length && folder[length - 1] != '/' ? "/" : "", name);
    return path;
}

static int is_visible(const struct dirent *entry) { return entry->d_name[0] != '.'; }

static int compare_names(const struct dirent **a, const struct dirent **b) {
    return strcmp((*a)->d_name, (*b)->d_name);
}

typedef struct folder_walk {
    check_inputs *found;
    check_inputs folders; /* to be walked yet; the last first */
    const char *pattern;  /* NULL: all files of a format that can be read */
} folder_walk;

static int is_wanted(const folder_walk *walk, const char *path) {
    return walk->pattern ? components_match(walk->pattern, path)
                         : norma_file_format_of_path(path) != NORMA_FILE_UNKNOWN;
}

/* A link to a file is a file; one to a folder is not followed, since it may lead round in a circle.
 */
static int add_entry(folder_walk *walk, char *path) {
    struct stat status;
    if (!path) return out_of_memory();
    if (lstat(path, &status) == 0 && S_ISDIR(status.st_mode)) return add_path(&walk->folders, path);
    if (is_wanted(walk, path) && stat(path, &status) == 0 && S_ISREG(status.st_mode))
        return add_path(walk->found, path);
    free(path);
    return CLI_OK;
}

static int walk_one(folder_walk *walk, const char *folder) {
    struct dirent **entries;
    int count = scandir(folder[0] ? folder : ".", &entries, is_visible, compare_names),
        status = CLI_OK;
    if (count < 0) {
        cli_error("%s: cannot be read: %s", folder[0] ? folder : ".", strerror(errno));
        return CLI_FILE;
    }
    size_t first = walk->folders.count;
    for (int i = 0; i < count; ++i) {
        status = cli_worse(status, add_entry(walk, join(folder, entries[i]->d_name)));
        free(entries[i]);
    }
    free(entries);
    /* The first is to be walked next. */
    for (size_t a = first, b = walk->folders.count; a + 1 < b; ++a) {
        char *swapped = walk->folders.paths[a];
        walk->folders.paths[a] = walk->folders.paths[--b];
        walk->folders.paths[b] = swapped;
    }
    return status;
}

static int walk_folder(check_inputs *inputs, const char *folder, const char *pattern) {
    folder_walk walk = {.found = inputs, .pattern = pattern};
    char *copy = malloc(strlen(folder) + 1);
    int status = copy ? add_path(&walk.folders, strcpy(copy, folder)) : out_of_memory();
    while (walk.folders.count) {
        char *next = walk.folders.paths[--walk.folders.count];
        status = cli_worse(status, walk_one(&walk, next));
        free(next);
    }
    check_inputs_free(&walk.folders);
    return status;
}

/* The folders before the first component with a wildcard. */
static int add_pattern(check_inputs *inputs, const char *pattern) {
    size_t before = inputs->count, length = strcspn(pattern, "*?[");
    while (length && pattern[length - 1] != '/') --length;
    char *folder = malloc(length + 1);
    if (!folder) return out_of_memory();
    memcpy(folder, pattern, length);
    folder[length] = '\0';
    int status = walk_folder(inputs, folder, pattern);
    free(folder);
    if (!status && inputs->count == before) {
        cli_error("%s: no file is named so", pattern);
        return CLI_FILE;
    }
    return status;
}

int check_inputs_add(const cli_subcommand *verb, check_inputs *inputs, const char *word) {
    struct stat status;
    if (!word[0]) return cli_usage(verb, "the name of an input is empty");
    int is_there = strcmp(word, "-") != 0 && stat(word, &status) == 0;
    if (is_there && S_ISDIR(status.st_mode)) {
        size_t before = inputs->count;
        int result = walk_folder(inputs, word, NULL);
        if (!result && inputs->count == before) {
            cli_error("%s: holds no OBJ, PLY, STL, glTF or GLB file", word);
            return CLI_FILE;
        }
        return result;
    }
    if (!is_there && strpbrk(word, "*?[")) return add_pattern(inputs, word);
    char *copy = malloc(strlen(word) + 1);
    return copy ? add_path(inputs, strcpy(copy, word)) : out_of_memory();
}

int check_inputs_add_list(const cli_subcommand *verb, check_inputs *inputs, const char *list) {
    int standard = strcmp(list, "-") == 0, status = CLI_OK;
    FILE *file = standard ? stdin : fopen(list, "r");
    char *line = NULL;
    size_t capacity = 0;
    ssize_t length;
    if (!file) {
        cli_error("%s: cannot be opened: %s", list, strerror(errno));
        return CLI_FILE;
    }
    while (!status && (length = getline(&line, &capacity, file)) >= 0) {
        while (length && (line[length - 1] == '\n' || line[length - 1] == '\r'))
            line[--length] = '\0';
        if (strcmp(line, "-") == 0)
            status = cli_usage(verb, "--files-from %s names standard input", list);
        else if (length)
            status = check_inputs_add(verb, inputs, line);
    }
    if (!status && !feof(file)) { /* also where memory is out */
        cli_error("%s: cannot be read: %s", cli_input_name(list), strerror(errno));
        status = CLI_FILE;
    }
    free(line);
    if (!standard) fclose(file);
    return status;
}
