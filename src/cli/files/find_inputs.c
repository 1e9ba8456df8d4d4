/* find_inputs.c: which files a command works on: those that are named, those of folders and below,
 * those that patterns match, those of a list; and what of each path is kept below --out-dir.
 * Folders are walked in the order of names, so that a report does not depend on the file system;
 * hidden entries are left out there, and links that lead out of the folder. */
#define _XOPEN_SOURCE 700
#include "cli/files/find_inputs.h"
#include "cli/process/errors.h"
#include <dirent.h>
#include <errno.h>
#include <fnmatch.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static int add_path(cli_inputs *inputs, char *path, size_t tail, size_t within) {
    if (!path) return cli_out_of_memory();
    if (inputs->count == inputs->capacity) {
        const size_t capacity = inputs->capacity ? 2 * inputs->capacity : 64;
        char **paths = realloc(inputs->paths, capacity * sizeof *paths);
        if (paths) inputs->paths = paths;
        size_t *tails = realloc(inputs->tails, capacity * sizeof *tails);
        if (tails) inputs->tails = tails;
        size_t *starts = realloc(inputs->within, capacity * sizeof *starts);
        if (starts) inputs->within = starts;
        if (!paths || !tails || !starts) {
            free(path);
            return cli_out_of_memory();
        }
        inputs->capacity = capacity;
    }
    inputs->tails[inputs->count] = tail;
    inputs->within[inputs->count] = within;
    inputs->paths[inputs->count++] = path;
    return CLI_OK;
}

void cli_inputs_free(cli_inputs *inputs) {
    for (size_t i = 0; i < inputs->count; ++i) free(inputs->paths[i]);
    free(inputs->paths);
    free(inputs->tails);
    free(inputs->within);
    *inputs = (cli_inputs){0};
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

int cli_path_matches(const char *pattern, const char *path) {
    const char *slash = strrchr(path, '/');
    return components_match(pattern, strchr(pattern, '/') ? path : slash ? slash + 1 : path);
}

/* ---- folders */

char *cli_join(const char *folder, const char *name) {
    const size_t length = strlen(folder), size = length + strlen(name) + 2;
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
    cli_inputs *found;
    cli_inputs folders;  /* to be walked yet; the last first */
    const char *pattern; /* NULL: all files of a format that can be read */
    size_t tail;         /* of every path found */
    char *real;          /* the folder itself, absolute */
} folder_walk;

static int is_wanted(const folder_walk *walk, const char *path) {
    return walk->pattern ? components_match(walk->pattern, path)
                         : norma_file_format_of_path(path) != NORMA_FILE_UNKNOWN;
}

static int stays_inside(const folder_walk *walk, const char *path) {
    char *real = realpath(path, NULL);
    const size_t length = strlen(walk->real);
    const int inside =
        real && strncmp(real, walk->real, length) == 0 && (real[length] == '/' || length == 1);
    free(real);
    return inside;
}

/* A link to a file of the folder is that file. One to a folder is not followed, since it may lead
 * round in a circle, and one out of the folder would let a stranger's archive name any file. */
static int add_entry(folder_walk *walk, char *path) {
    struct stat status;
    if (!path) return cli_out_of_memory();
    const int known = lstat(path, &status) == 0, is_link = known && S_ISLNK(status.st_mode);
    if (known && S_ISDIR(status.st_mode)) return add_path(&walk->folders, path, 0, 0);
    if (is_wanted(walk, path) && stat(path, &status) == 0 && S_ISREG(status.st_mode)) {
        if (!is_link || stays_inside(walk, path))
            return add_path(walk->found, path, walk->tail, walk->tail);
        cli_error("%s: skipped because it is a link that leads out of the folder", path);
    }
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
        status = cli_worse(status, add_entry(walk, cli_join(folder, entries[i]->d_name)));
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

static int walk_folder(cli_inputs *inputs, const char *folder, const char *pattern) {
    const size_t length = strlen(folder);
    folder_walk walk = {.found = inputs,
        .pattern = pattern,
        .tail = length + (length && folder[length - 1] != '/'),
        .real = realpath(folder[0] ? folder : ".", NULL)};
    if (!walk.real) {
        cli_error("%s: cannot be read: %s", folder[0] ? folder : ".", strerror(errno));
        return CLI_FILE;
    }
    int status = add_path(&walk.folders, strdup(folder), 0, 0);
    while (walk.folders.count) {
        char *next = walk.folders.paths[--walk.folders.count];
        status = cli_worse(status, walk_one(&walk, next));
        free(next);
    }
    cli_inputs_free(&walk.folders);
    free(walk.real);
    return status;
}

/* The folders before the first component with a wildcard. */
static int add_pattern(const cli_subcommand *command, cli_inputs *inputs, const char *pattern) {
    size_t before = inputs->count, length = strcspn(pattern, "*?[");
    struct stat entry;
    while (length && pattern[length - 1] != '/') --length;
    char *folder = strndup(pattern, length);
    if (!folder) return cli_out_of_memory();
    const int is_there = stat(folder[0] ? folder : ".", &entry) == 0;
    const int status = is_there ? walk_folder(inputs, folder, pattern) : CLI_OK;
    free(folder);
    if (status || inputs->count > before) return status;
    return cli_usage(command, "the pattern '%s' matches no file", pattern);
}

static size_t base_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

static int add_word(const cli_subcommand *command, cli_inputs *inputs, const char *word) {
    struct stat status;
    if (!word[0]) return cli_usage(command, "the name of an input is empty");
    const int is_there = strcmp(word, "-") != 0 && stat(word, &status) == 0;
    if (is_there && S_ISDIR(status.st_mode)) {
        const size_t before = inputs->count;
        const int result = walk_folder(inputs, word, NULL);
        if (result || inputs->count > before) return result;
        cli_error("%s: holds no OBJ, PLY, STL, glTF or GLB file", word);
        return CLI_FILE;
    }
    if (!is_there && strpbrk(word, "*?[")) return add_pattern(command, inputs, word);
    return add_path(inputs, strdup(word), base_of(word), 0);
}

int cli_find_inputs(const cli_subcommand *command, cli_files *files) {
    size_t standard = 0;
    int status = CLI_OK;
    for (size_t i = 0; i < files->lists.count; ++i)
        standard += strcmp(files->lists.words[i], "-") == 0;
    for (size_t i = 0; i < files->words.count && status != CLI_USAGE; ++i) {
        const char *word = files->words.words[i];
        const int is_standard = strcmp(word, "-") == 0;
        standard += (size_t)is_standard;
        if (is_standard && !files->format)
            return cli_usage(command, "standard input has no name that shows its format; expected "
                                      "--input-format obj, ply, stl, gltf or glb");
        if (standard > 1) return cli_usage(command, "standard input can be read only once");
        status = cli_worse(status, add_word(command, &files->inputs, word));
    }
    if (files->words.count == 0 && files->lists.count == 0)
        return cli_usage(command, "no input file was given");
    for (size_t i = 0; i < files->inputs.count; ++i)
        cli_guard_read(files->guard, files->inputs.paths[i]);
    return status;
}

/* ---- lists */

typedef struct listed {
    size_t unknown;     /* names of other formats */
    cli_inputs missing; /* names of files that do not exist */
} listed;

/* A list comes from another program, such as git: it names all kinds of files, and some that were
 * deleted. Its names are names, never patterns. */
static int add_line(
    const cli_subcommand *command, cli_files *files, const char *line, listed *list) {
    struct stat status;
    const int is_there = stat(line, &status) == 0,
              is_gone = !is_there && (errno == ENOENT || errno == ENOTDIR);
    if (is_there && S_ISDIR(status.st_mode)) return add_word(command, &files->inputs, line);
    if (!files->format && !norma_file_format_of_path(line)) {
        ++list->unknown;
        return CLI_OK;
    }
    return add_path(is_gone ? &list->missing : &files->inputs, strdup(line), base_of(line), 0);
}

static int add_missing(cli_inputs *inputs, const cli_inputs *missing) {
    int status = CLI_OK;
    for (size_t i = 0; i < missing->count && !status; ++i)
        status = add_path(inputs, strdup(missing->paths[i]), missing->tails[i], 0);
    return status;
}

static int read_lines(
    const cli_subcommand *command, cli_files *files, const char *name, FILE *file) {
    char *line = NULL;
    size_t capacity = 0;
    ssize_t length;
    int status = CLI_OK;
    listed list = {0};
    const size_t before = files->inputs.count;
    errno = 0;
    while (status != CLI_USAGE && (length = getline(&line, &capacity, file)) >= 0) {
        while (length && (line[length - 1] == '\n' || line[length - 1] == '\r'))
            line[--length] = '\0';
        if (strcmp(line, "-") == 0)
            status = cli_usage(command, "--files-from %s names standard input", name);
        else if (length)
            status = cli_worse(status, add_line(command, files, line, &list));
        errno = 0;
    }
    if (!status && !feof(file)) { /* also if memory is out */
        cli_error("%s: cannot be read: %s", cli_input_name(name), strerror(errno));
        status = CLI_FILE;
    }
    free(line);
    /* Deleted files are no fault as long as something is left. A list that leaves nothing to check
     * must not look like a pass: its files are then reported as unreadable. */
    const int is_all = files->inputs.count == before;
    const size_t skipped = is_all ? 0 : list.missing.count;
    if (list.unknown + skipped)
        cli_error("%s: %zu names skipped: %zu of other formats, %zu that do not exist",
            cli_input_name(name), list.unknown + skipped, list.unknown, skipped);
    if (is_all) status = cli_worse(status, add_missing(&files->inputs, &list.missing));
    cli_inputs_free(&list.missing);
    return status;
}

int cli_find_listed(const cli_subcommand *command, cli_files *files) {
    int status = CLI_OK;
    for (size_t i = 0; i < files->lists.count && status != CLI_USAGE; ++i) {
        const char *list = files->lists.words[i];
        const int standard = strcmp(list, "-") == 0;
        FILE *file = standard ? stdin : fopen(list, "r");
        if (!file) {
            cli_error("%s: cannot be opened: %s", list, strerror(errno));
            return CLI_FILE;
        }
        cli_guard_read(files->guard, list);
        status = cli_worse(status, read_lines(command, files, list, file));
        if (!standard) fclose(file);
    }
    return status;
}
