/* inputs.c: the files that a command names and opens; none of them is ever an output. */
#define _POSIX_C_SOURCE 200809L
#define _XOPEN_SOURCE   700
#include "cli/files/files.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <fnmatch.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- The list of sources, and the question whether an output is one of them. */

typedef struct source {
    dev_t device;
    ino_t inode;
    char *named_by; /* the input that names it; NULL: it is read itself */
} source;

struct cli_guard {
    const cli_subcommand *command;
    pthread_mutex_t lock;
    source *sources;
    size_t count, capacity;
    int watches;    /* an output exists already, so there is something to lose */
    int incomplete; /* memory was out: nothing that exists may be written any more */
};

static cli_guard *cli_guard_new(const cli_subcommand *command) {
    cli_guard *guard = calloc(1, sizeof *guard);
    if (!guard) {
        cli_out_of_memory();
        return NULL;
    }
    guard->command = command;
    pthread_mutex_init(&guard->lock, NULL);
    return guard;
}

static void cli_guard_free(cli_guard *guard) {
    if (!guard) return;
    for (size_t i = 0; i < guard->count; ++i) free(guard->sources[i].named_by);
    free(guard->sources);
    pthread_mutex_destroy(&guard->lock);
    free(guard);
}

/* Only regular files can be lost: devices and pipes are written as they are. */
static int regular_file(const char *path, int standard, struct stat *status) {
    const int failed = strcmp(path, "-") == 0 ? fstat(standard, status) : stat(path, status);
    return !failed && S_ISREG(status->st_mode);
}

static int is_one(const struct stat *a, const struct stat *b) {
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino;
}

/* The length of path's folder, its last slash included. */
static size_t find_folder(const char *path, struct stat *status) {
    const char *slash = strrchr(path, '/');
    const size_t length = slash ? (size_t)(slash - path) + 1 : 0;
    char *folder = length ? strndup(path, length) : strdup(".");
    if (!folder || stat(folder, status)) *status = (struct stat){0};
    free(folder);
    return length;
}

int cli_is_same_output(const char *a, const char *b) {
    struct stat of_a, of_b;
    if (strcmp(a, b) == 0) return 1;
    if (strcmp(a, "-") == 0 || strcmp(b, "-") == 0) return 0;
    if (stat(a, &of_a) == 0 && stat(b, &of_b) == 0)
        return S_ISREG(of_a.st_mode) && is_one(&of_a, &of_b);
    return strcmp(a + find_folder(a, &of_a), b + find_folder(b, &of_b)) == 0 &&
           is_one(&of_a, &of_b);
}

static const source *find(const cli_guard *guard, const struct stat *status) {
    for (size_t i = 0; i < guard->count; ++i)
        if (guard->sources[i].inode == status->st_ino && guard->sources[i].device == status->st_dev)
            return &guard->sources[i];
    return NULL;
}

static void add(cli_guard *guard, const struct stat *status, const char *named_by) {
    char *copy = named_by ? strdup(named_by) : NULL;
    source *grown = cli_grow(guard->sources, guard->count, &guard->capacity, sizeof *grown);
    if (grown) guard->sources = grown;
    if (!grown || (named_by && !copy)) {
        guard->incomplete = 1;
        free(copy);
        return;
    }
    guard->sources[guard->count++] = (source){status->st_dev, status->st_ino, copy};
}

static void add_source(cli_guard *guard, const char *path, const char *named_by) {
    struct stat status;
    if (!regular_file(path, STDIN_FILENO, &status)) return;
    pthread_mutex_lock(&guard->lock);
    add(guard, &status, named_by);
    pthread_mutex_unlock(&guard->lock);
}

void cli_guard_read(cli_guard *guard, const char *path) {
    if (guard) add_source(guard, path, NULL);
}

typedef struct named {
    cli_guard *guard;
    const char *by;
} named;

static int add_named(void *user, const char *path) {
    const named *names = user;
    add_source(names->guard, path, names->by);
    return 0;
}

static void cli_guard_document(cli_guard *guard, norma_document *document, const char *input) {
    named names = {guard, cli_input_name(input)};
    norma_document_error error;
    if (!guard || !guard->watches) return;
    if (norma_document_visit_files(document, add_named, &names, &error) ==
        NORMA_DOCUMENT_ERROR_MEMORY)
        guard->incomplete = 1;
}

void cli_guard_names(cli_guard *guard, const char *path, norma_file_format format) {
    const norma_file_format kind = format ? format : norma_file_format_of_path(path);
    const norma_document_options options = {.struct_size = sizeof options,
        .format = format,
        .depth = NORMA_DOCUMENT_SUMMARY,
        .lenient = 1};
    norma_document *document;
    norma_document_error error; /* reported where the file is read for the work */
    struct stat status;
    /* Opening a pipe, even to refuse it, would take it away from who writes into it. */
    if (!cli_guard_watches(guard) || !norma_file_format_is_gltf(kind) || strcmp(path, "-") == 0 ||
        !regular_file(path, STDIN_FILENO, &status))
        return;
    const norma_document_result result = norma_document_open(path, &options, &document, &error);
    if (result == NORMA_DOCUMENT_ERROR_MEMORY) guard->incomplete = 1;
    if (result) return;
    cli_guard_document(guard, document, path);
    norma_document_close(document);
}

/* ---- between processes */

typedef struct sources_message {
    size_t count;
    int incomplete;
} sources_message;

typedef struct source_message {
    dev_t device;
    ino_t inode;
    size_t name; /* bytes of it; 0: none */
} source_message;

int cli_guard_watches(const cli_guard *guard) { return guard && guard->watches; }

size_t cli_guard_count(cli_guard *guard) { return guard ? guard->count : 0; }

void cli_guard_send(cli_guard *guard, size_t *first, const cli_worker *worker) {
    if (!guard) return;
    pthread_mutex_lock(&guard->lock);
    const sources_message message = {guard->count - *first, guard->incomplete};
    cli_worker_send(worker, &message, sizeof message);
    for (; *first < guard->count; ++*first) {
        const source *from = &guard->sources[*first];
        const source_message one = {
            from->device, from->inode, from->named_by ? strlen(from->named_by) + 1 : 0};
        cli_worker_send(worker, &one, sizeof one);
        cli_worker_send(worker, from->named_by, one.name);
    }
    pthread_mutex_unlock(&guard->lock);
}

static int receive_source(cli_guard *guard, const cli_worker *worker) {
    source_message one;
    if (!cli_worker_receive(worker, &one, sizeof one)) return 0;
    char *name = one.name ? malloc(one.name) : NULL;
    const int fine = !one.name || (name && cli_worker_receive(worker, name, one.name));
    const struct stat status = {.st_dev = one.device, .st_ino = one.inode};
    if (fine) add(guard, &status, name);
    free(name);
    return fine;
}

int cli_guard_receive(cli_guard *guard, const cli_worker *worker) {
    sources_message message = {0};
    int fine = !guard || cli_worker_receive(worker, &message, sizeof message);
    for (size_t i = 0; i < message.count && fine; ++i) fine = receive_source(guard, worker);
    if (guard) guard->incomplete |= message.incomplete;
    return fine;
}

static int refuse_source(const cli_guard *guard, const char *output, const source *found) {
    const char *name = strcmp(output, "-") == 0 ? "standard output" : output;
    if (found->named_by)
        return cli_usage(guard->command,
            "%s is used by %s and would be overwritten; expected another name for the output", name,
            found->named_by);
    return cli_usage(guard->command,
        "%s is read by this command and would be overwritten; expected another name for the output",
        name);
}

int cli_guard_output(cli_guard *guard, const char *output, const char *own) {
    struct stat status, of_own;
    if (!guard || !regular_file(output, STDOUT_FILENO, &status)) return CLI_OK;
    if (own && regular_file(own, STDIN_FILENO, &of_own) && is_one(&of_own, &status)) return CLI_OK;
    pthread_mutex_lock(&guard->lock);
    guard->watches = 1;
    const source *found = find(guard, &status);
    const int incomplete = guard->incomplete;
    const int result = found ? refuse_source(guard, output, found) : CLI_OK;
    pthread_mutex_unlock(&guard->lock);
    return !result && incomplete ? cli_out_of_memory() : result;
}

/* ---- Opens the files that the command line names, standard input included. */

const cli_option cli_input_options[] = {
    {"input-format", CLI_TO(CLI_CHOICE, cli_files, format), .number = NORMA_FILE_OBJ,
        .words = "obj,ply,stl,gltf,glb,b3dm,i3dm,cmpt,3mf", .expected = CLI_FORMATS}};
const size_t cli_input_option_count = CLI_COUNT(cli_input_options);

int cli_read_files(const cli_subcommand *command, cli_files *files, const cli_table *tables,
    size_t table_count, int count, char **arguments) {
    files->words.words = calloc((size_t)count + 1, sizeof(char *));
    files->lists.words = calloc((size_t)count + 1, sizeof(char *));
    files->guard = cli_guard_new(command);
    int status = CLI_FILE;
    if (files->words.words && files->lists.words && files->guard)
        status = cli_parse(command, tables, table_count, count, arguments, &files->words);
    else if (files->guard)
        cli_out_of_memory();
    if (status) cli_files_end(files);
    return status;
}

void cli_files_end(cli_files *files) {
    free((void *)files->words.words);
    free((void *)files->lists.words);
    cli_inputs_free(&files->inputs);
    cli_guard_free(files->guard);
    *files = (cli_files){0};
}

double cli_megabytes(const char *input) {
    struct stat status;
    return strcmp(input, "-") != 0 && stat(input, &status) == 0 && S_ISREG(status.st_mode)
               ? (double)status.st_size / 1e6
               : 0;
}

static norma_document_result fail_reading(norma_document_error *error, norma_document_result result,
    const char *input, const char *what) {
    error->result = result;
    snprintf(error->message, sizeof error->message, "%.800s: %s", cli_input_name(input), what);
    return result;
}

/* Memory stays bounded, whatever is on the other side. NULL: more may be read. */
static const char *why_endless(int descriptor, size_t size) {
    struct stat status;
    if (fstat(descriptor, &status) == 0 && S_ISCHR(status.st_mode) && !isatty(descriptor))
        return "is a device, which may have no end; expected a file or a pipe";
    const double memory = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    return memory > 0 && (double)size > memory / 2
               ? "is larger than half of this machine's memory; expected a file"
               : NULL;
}

char *cli_read_all(int file, size_t *size, const char **endless) {
    size_t room = (size_t)1 << 16;
    char *bytes = malloc(room);
    ssize_t got = 1;
    for (*size = 0; bytes && got; *size += got > 0 ? (size_t)got : 0) {
        if (*size == room && endless && (*endless = why_endless(file, room))) break;
        char *larger = *size < room           ? bytes
                       : room <= SIZE_MAX / 2 ? realloc(bytes, room *= 2)
                                              : NULL;
        if (!larger) break;
        bytes = larger;
        got = read(file, bytes + *size, room - *size);
        if (got < 0 && errno != EINTR) break;
    }
    if (bytes && !got) return bytes;
    const int why = *size == room ? ENOMEM : errno; /* or no room can be twice as large */
    free(bytes);
    errno = why;
    return NULL;
}

static norma_document_result read_pipe(
    int descriptor, const char *input, void **memory, size_t *size, norma_document_error *error) {
    const char *endless = NULL;
    *memory = cli_read_all(descriptor, size, &endless);
    return *memory   ? NORMA_DOCUMENT_OK
           : endless ? fail_reading(error, NORMA_DOCUMENT_ERROR_REFUSED, input, endless)
           : errno == ENOMEM
               ? fail_reading(error, NORMA_DOCUMENT_ERROR_MEMORY, input, "out of memory")
               : fail_reading(error, NORMA_DOCUMENT_ERROR_FILE, input, strerror(errno));
}

static norma_document_result read_named_pipe(
    const char *path, void **memory, size_t *size, norma_document_error *error) {
    int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0)
        return fail_reading(error, NORMA_DOCUMENT_ERROR_FILE, path, strerror(errno));
    norma_document_result result = read_pipe(descriptor, path, memory, size, error);
    close(descriptor);
    return result;
}

static norma_document_result open_input(const char *input, const norma_document_options *options,
    norma_document **document, void **memory, norma_document_error *error) {
    int is_standard = strcmp(input, "-") == 0;
    struct stat status;
    size_t size = 0;
    *memory = NULL;
    *document = NULL;
    /* The library reads no pipes. */
    if (!is_standard && (stat(input, &status) || !S_ISFIFO(status.st_mode)))
        return norma_document_open(input, options, document, error);
    norma_document_result result = is_standard
                                       ? read_pipe(STDIN_FILENO, input, memory, &size, error)
                                       : read_named_pipe(input, memory, &size, error);
    /* Without a name the document has no folder, and files that it names are not opened. */
    return result ? result
                  : norma_document_open_memory(
                        *memory, size, is_standard ? NULL : input, options, document, error);
}

norma_document_result cli_open(const cli_files *files, const char *input,
    const norma_document_options *options, norma_document **document, void **memory,
    norma_document_error *error) {
    const norma_document_result result = open_input(input, options, document, memory, error);
    if (!result)
        cli_guard_document(files->guard, *document, input);
    else /* a buffer of it that cannot be read makes no other one free to be overwritten */
        cli_guard_names(files->guard, input, options->format);
    return result;
}

norma_document_result cli_read(const cli_files *files, const cli_common *common, const char *input,
    const norma_document_options *asked, norma_document **document, void **memory,
    norma_document_error *error) {
    cli_progress progress;
    norma_document_options options = *asked;
    options.struct_size = sizeof options;
    options.format = files->format;
    options.threads = common->threads;
    options.progress = cli_progress_report;
    options.progress_user = &progress;
    cli_progress_start(&progress, "reading", input, common->quiet, cli_megabytes(input));
    const norma_document_result result = cli_open(files, input, &options, document, memory, error);
    cli_progress_stop(&progress);
    return error->result = result;
}

/* ---- what a report says of the file */

norma_document_result cli_fail_empty(
    norma_document *document, const char *input, const char *what, norma_document_error *error) {
    char reason[400] = "it holds no mesh";
    for (size_t i = norma_document_mesh_count(document); i-- > 0;) {
        norma_mesh_info info;
        if (norma_document_mesh_info(document, i, &info)) continue;
        if (info.not_read)
            snprintf(reason, sizeof reason, "%.100s%s%.250s", info.where, info.where[0] ? ": " : "",
                info.not_read);
        else
            snprintf(reason, sizeof reason, "%s",
                info.triangles  ? "no node draws its meshes"
                : info.vertices ? "it holds points without faces"
                                : "it holds no faces");
    }
    snprintf(error->message, sizeof error->message, "%.500s: there is no surface to %s: %.400s",
        cli_input_name(input), what, reason);
    return error->result = NORMA_DOCUMENT_ERROR_UNSUPPORTED;
}

void cli_json_notes(struct cli_json *json, const norma_document *document) {
    cli_json_open(json, "notes", '[');
    for (size_t i = 0; i < norma_document_note_count(document); ++i)
        cli_json_string(json, NULL, norma_document_note(document, i));
    cli_json_close(json, ']');
}

/* ---- Which files a command works on: those that are named, those of folders and below,
 * those that patterns match, those of a list; and what of each path is kept below --out-dir.
 * Folders are walked in the order of names, so that a report does not depend on the file system;
 * hidden entries are left out there, and links that lead out of the folder. */

static int add_path(cli_inputs *inputs, char *path, size_t tail, size_t within) {
    cli_input *grown =
        path ? cli_grow(inputs->list, inputs->count, &inputs->capacity, sizeof *grown) : NULL;
    if (!grown) {
        free(path);
        return cli_out_of_memory();
    }
    inputs->list = grown;
    inputs->list[inputs->count] = (cli_input){path, tail, within, inputs->count};
    ++inputs->count;
    return CLI_OK;
}

int cli_compare_inputs(const void *a, const void *b) {
    const cli_input *one = a, *other = b;
    const int order = strcmp(one->path, other->path);
    return order ? order : (one->number > other->number) - (one->number < other->number);
}

void cli_inputs_free(cli_inputs *inputs) {
    for (size_t i = 0; i < inputs->count; ++i) free(inputs->list[i].path);
    free(inputs->list);
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

static int compare_entries(const struct dirent **a, const struct dirent **b) {
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
    int count = scandir(folder[0] ? folder : ".", &entries, is_visible, compare_entries),
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
        const cli_input swapped = walk->folders.list[a];
        walk->folders.list[a] = walk->folders.list[--b];
        walk->folders.list[b] = swapped;
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
        char *next = walk.folders.list[--walk.folders.count].path;
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

const char *cli_base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static size_t base_of(const char *path) { return (size_t)(cli_base_name(path) - path); }

typedef struct tile_list {
    cli_inputs *inputs;
    size_t tail;
    int status;
} tile_list;

static int add_tile(void *user, const char *path) {
    tile_list *list = user;
    list->status = add_path(list->inputs, strdup(path), list->tail, list->tail);
    return list->status;
}

static int compare_numbers(const void *a, const void *b) {
    const size_t one = ((const cli_input *)a)->number, other = ((const cli_input *)b)->number;
    return (one > other) - (one < other);
}

/* A tileset may draw one file at many places: it is read where it is named first. */
static void drop_repeated(cli_inputs *inputs, size_t first) {
    const size_t count = inputs->count - first;
    size_t kept = 0;
    if (!count) return;
    cli_input *tiles = inputs->list + first;
    qsort(tiles, count, sizeof *tiles, cli_compare_inputs);
    for (size_t i = 0; i < count; ++i) {
        if (kept && strcmp(tiles[i].path, tiles[kept - 1].path) == 0)
            free(tiles[i].path);
        else
            tiles[kept++] = tiles[i];
    }
    qsort(tiles, kept, sizeof *tiles, compare_numbers);
    inputs->count = first + kept;
}

/* A tileset stands for its tiles, as a folder does for its files. */
static int add_tiles(cli_inputs *inputs, const char *tileset) {
    tile_list list = {inputs, base_of(tileset), CLI_OK};
    norma_document_error error;
    const size_t before = inputs->count;
    const int failed = norma_tileset_visit_tiles(tileset, add_tile, &list, &error) != 0;
    if (failed) cli_print_error(&error);
    if (norma_tileset_moves_tiles(tileset)) inputs->moved = tileset;
    drop_repeated(inputs, before);
    if (failed || list.status || inputs->count > before) return failed ? CLI_FILE : list.status;
    cli_error("%s: names no tile that can be read", tileset);
    return CLI_FILE;
}

static int add_word(const cli_subcommand *command, cli_inputs *inputs, const char *word) {
    struct stat status;
    if (!word[0]) return cli_usage(command, "the name of an input is empty");
    const int is_there = strcmp(word, "-") != 0 && stat(word, &status) == 0;
    if (is_there && S_ISDIR(status.st_mode)) {
        const size_t before = inputs->count;
        const int result = walk_folder(inputs, word, NULL);
        if (result || inputs->count > before) return result;
        cli_error("%s: holds no OBJ, PLY, STL, glTF or 3MF file, nor a tile", word);
        return CLI_FILE;
    }
    if (is_there && norma_is_tileset(word)) return add_tiles(inputs, word);
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
                                      "--input-format " CLI_FORMATS);
        if (standard > 1) return cli_usage(command, "standard input can be read only once");
        status = cli_worse(status, add_word(command, &files->inputs, word));
    }
    if (files->words.count == 0 && files->lists.count == 0)
        return cli_usage(command, "no input file was given");
    for (size_t i = 0; i < files->inputs.count; ++i)
        cli_guard_read(files->guard, files->inputs.list[i].path);
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
        status = add_path(inputs, strdup(missing->list[i].path), missing->list[i].tail, 0);
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
        cli_error("%s: names skipped: %zu of other formats, %zu that do not exist",
            cli_input_name(name), list.unknown, skipped);
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
