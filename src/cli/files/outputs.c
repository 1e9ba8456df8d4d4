/* outputs.c: work on the files of a batch, where outputs go, whether they may, and how a document
 * or a report gets there. */
#define _GNU_SOURCE /* fopencookie */
#include "cli/files/files.h"
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- The worker says of each file what became of it; the one that it says nothing of has ended
 * it. */

static int run_each_here(const cli_each *each, size_t first) {
    int status = CLI_OK;
    for (size_t file = first; file < each->count; ++file)
        status = cli_worse(status, each->one(each->user, file));
    return status;
}

/* A message for each file: its status; and one in the end, for standard output. */
static _Noreturn void run_in_worker(const cli_worker *worker, const cli_each *each, size_t first) {
    size_t sent = cli_guard_count(each->guard);
    for (size_t file = first; file <= each->count; ++file) {
        const int status = file < each->count ? each->one(each->user, file) : cli_finish(CLI_OK);
        fflush(stdout); /* what was told of it stays, whatever the next one does */
        cli_worker_send(worker, &status, sizeof status);
        cli_guard_send(each->guard, &sent, worker);
    }
    cli_worker_finish(worker);
}

int cli_run_each(const cli_each *each) {
    int status = CLI_OK, one;
    char why[CLI_WHY_ROOM];
    for (size_t next = 0; next < each->count;) {
        cli_worker worker;
        const int side = each->count > 1 ? cli_worker_start(&worker) : -1;
        if (side < 0) return cli_worse(status, run_each_here(each, next));
        if (side == 0) run_in_worker(&worker, each, next);
        for (; cli_worker_receive(&worker, &one, sizeof one); ++next) {
            status = cli_worse(status, one);
            cli_guard_receive(each->guard, &worker);
        }
        if (cli_worker_wait(&worker, next < each->count, why)) continue;
        status = CLI_FILE;
        if (next < each->count)
            each->lost(each->user, next, worker.process, why);
        else
            cli_error("%s", why);
        ++next;
    }
    return status;
}

/* ---- files that are opened later */

typedef struct look_ahead {
    cli_guard *guard;
    const cli_inputs *inputs;
    norma_file_format format;
} look_ahead;

static int look_into(void *user, size_t file) {
    const look_ahead *ahead = user;
    cli_guard_names(ahead->guard, ahead->inputs->list[file].path, ahead->format);
    return CLI_OK;
}

/* So will the work be. */
static void pass_over(void *user, size_t file, int worker, const char *why) {
    (void)user, (void)file, (void)worker, (void)why;
}

void cli_guard_look_ahead(cli_guard *guard, const cli_inputs *inputs, norma_file_format format) {
    if (!cli_guard_watches(guard)) return;
    look_ahead ahead = {guard, inputs, format};
    const cli_each each = {inputs->count, look_into, pass_over, &ahead, guard};
    cli_run_each(&each);
}

/* ---- Where the output of each input goes: the one -o, below --out-dir, or in place.
 * Below --out-dir a file that was named has its own name, a file of a folder or a pattern its place
 * in that folder; if two files would meet, all keep their place below the folder that they share.
 */

int cli_ends_in(const char *path, const char *ending) {
    const char *name = cli_base_name(path);
    const size_t length = strlen(name), size = strlen(ending);
    return length > size && strcasecmp(name + length - size, ending) == 0;
}

int cli_is_standard(const char *name) { return strcmp(name, "-") == 0; }

int cli_is_folder(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

int cli_is_stream(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

static size_t stem_length(const char *name) {
    const char *base = cli_base_name(name), *dot = strrchr(base, '.');
    return dot && dot > base ? (size_t)(dot - name) : strlen(name);
}

/* Without "./" and doubled slashes, so that two spellings of a name are one. */
static void simplify_path(char *path) {
    char *to = path;
    for (const char *at = path; *at;) {
        const size_t length = strcspn(at, "/"), part = length + (at[length] == '/');
        if (length > 1 || (length == 1 && *at != '.')) {
            memmove(to, at, part);
            to += part;
        }
        at += part;
    }
    *to = '\0';
}

char *cli_output_of(const cli_files *files, size_t index, const char *ending) {
    const char *input = files->inputs.list[index].path;
    if (files->output) return strdup(files->output);
    if (!files->folder) return strdup(input);
    const char *name = input + files->inputs.list[index].tail;
    const size_t kept = ending ? stem_length(name) : strlen(name),
                 size = kept + (ending ? strlen(ending) : 0) + 1;
    char *changed = malloc(size);
    if (!changed) return NULL;
    snprintf(changed, size, "%.*s%s", (int)kept, name, ending ? ending : "");
    simplify_path(changed);
    char *path = cli_join(files->folder, changed);
    free(changed);
    return path;
}

/* ---- two inputs for one output */

typedef struct placed {
    char *output;
    const char *input;
} placed;

static int compare_placed(const void *a, const void *b) {
    return strcmp(((const placed *)a)->output, ((const placed *)b)->output);
}

/* The first output, in the order of names, that two inputs have, in both; 0: none; -1: out of
 * memory. */
static int find_meeting(const cli_files *files, const char *ending, placed both[2]) {
    const size_t count = files->inputs.count;
    placed *all = calloc(count + 1, sizeof *all);
    int found = all ? 0 : -1;
    for (size_t i = 0; i < count && !found; ++i) {
        all[i] = (placed){cli_output_of(files, i, ending), files->inputs.list[i].path};
        if (!all[i].output) found = -1;
    }
    if (!found) qsort(all, count, sizeof *all, compare_placed);
    for (size_t i = 1; i < count && !found; ++i)
        if (strcmp(all[i - 1].output, all[i].output) == 0) {
            both[0] = all[i - 1];
            both[1] = all[i];
            both[1].output = strdup(all[i].output);
            found = both[1].output ? 1 : -1;
        }
    for (size_t i = 0; all && i < count; ++i) free(all[i].output);
    free(all);
    return found;
}

/* The length of the folders that all paths begin with. */
static size_t shared_folder(const cli_inputs *inputs) {
    const char *first = inputs->list[0].path;
    size_t shared = strlen(first);
    for (size_t i = 0; i < inputs->count; ++i) {
        size_t same = 0;
        while (same < shared && inputs->list[i].path[same] == first[same]) ++same;
        shared = same;
    }
    while (shared && first[shared - 1] != '/') --shared;
    return shared;
}

static int climbs(const char *path) {
    for (const char *at = path; at; at = strchr(at, '/')) {
        at += *at == '/';
        if (at[0] == '.' && at[1] == '.' && (at[2] == '/' || !at[2])) return 1;
    }
    return 0;
}

static void keep_tree(cli_inputs *inputs) {
    const size_t shared = shared_folder(inputs);
    for (size_t i = 0; i < inputs->count; ++i)
        if (climbs(inputs->list[i].path + shared)) return; /* it would leave the folder */
    for (size_t i = 0; i < inputs->count; ++i) inputs->list[i].tail = shared;
}

int cli_place_outputs(const cli_subcommand *command, cli_files *files, const char *ending) {
    placed both[2];
    if (!files->folder || !files->inputs.count) return CLI_OK;
    int meeting = find_meeting(files, ending, both);
    if (meeting > 0) {
        free(both[1].output);
        keep_tree(&files->inputs);
        meeting = find_meeting(files, ending, both);
    }
    if (meeting == 0) return CLI_OK;
    if (meeting < 0) return cli_out_of_memory();
    const int status = cli_usage(command, "%s and %s would both be written to %s", both[0].input,
        both[1].input, both[1].output);
    free(both[1].output);
    return status;
}

/* ---- folders */

static int fail_folder(const char *folder) {
    cli_error("%s: cannot be made: %s", folder, strerror(errno));
    return CLI_FILE;
}

/* Below --out-dir nothing is written through a link, which may lead anywhere: the names there come
 * from the inputs. */
static int refuse_links(const cli_files *files, char *output) {
    struct stat status;
    const size_t folder = strlen(files->folder);
    for (char *end = output + folder; *end;) {
        end += 1 + strcspn(end + 1, "/");
        const char after = *end;
        *end = '\0';
        const int is_link = lstat(output, &status) == 0 && S_ISLNK(status.st_mode);
        if (is_link) cli_error("%s: is a symbolic link, and is not written through", output);
        *end = after;
        if (is_link) return CLI_FILE;
    }
    return CLI_OK;
}

int cli_make_folders(const cli_files *files, const char *output) {
    struct stat status;
    if (!files->folder) return CLI_OK;
    char *path = strdup(output);
    if (!path) return cli_out_of_memory();
    int result = refuse_links(files, path);
    for (char *slash = strchr(path + 1, '/'); slash && !result; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        if (mkdir(path, 0777) && errno != EEXIST && stat(path, &status)) result = fail_folder(path);
        *slash = '/';
    }
    free(path);
    return result;
}

int cli_make_out_dir(const cli_subcommand *command, cli_files *files) {
    struct stat status;
    if (!files->folder) return CLI_OK;
    files->made_folder = mkdir(files->folder, 0777) == 0;
    if (!files->made_folder && errno != EEXIST) return fail_folder(files->folder);
    if (stat(files->folder, &status) || !S_ISDIR(status.st_mode))
        return cli_usage(command, "--out-dir %s is not a folder", files->folder);
    return CLI_OK;
}

/* Temporary files have the number of the process that writes them in their names (file_write.c). */
void cli_remove_left_by(int worker, const cli_files *files, size_t index) {
    char *output = cli_output_of(files, index, NULL),
         *real = output ? realpath(output, NULL) : NULL;
    char *const path = real ? real : output, *slash = path ? strrchr(path, '/') : NULL;
    char start[48];
    const int length = snprintf(start, sizeof start, ".norma-%d-", worker);
    if (slash) slash[slash == path] = '\0';
    DIR *folder = path ? opendir(slash ? path : ".") : NULL;
    for (const struct dirent *entry; folder && (entry = readdir(folder));)
        if (strncmp(entry->d_name, start, (size_t)length) == 0)
            unlinkat(dirfd(folder), entry->d_name, 0);
    if (folder) closedir(folder);
    free(real);
    free(output);
}

/* rmdir leaves folders that hold anything. */
void cli_remove_empty_folders(const cli_files *files) {
    if (!files->made_folder) return;
    for (size_t i = 0; i < files->inputs.count; ++i) {
        char *path = cli_output_of(files, i, NULL), *slash = NULL;
        while (path && (slash = strrchr(path, '/')) > path + strlen(files->folder)) {
            *slash = '\0';
            if (rmdir(path) && errno != ENOENT) break; /* what was never made is gone, too */
        }
        free(path);
    }
    rmdir(files->folder);
}

/* ---- whether all outputs have somewhere to go, and none is a source */

const cli_option cli_output_options[] = {
    {"output", 'o', CLI_TO(CLI_ONCE, cli_files, output),
        .expected = "a name, or - for standard output"},
    {"out-dir", CLI_TO(CLI_ONCE, cli_files, folder), .expected = "the name of a folder"},
    {"in-place", CLI_SETS(cli_files, in_place, 1)},
};
const size_t cli_output_option_count = CLI_COUNT(cli_output_options);

int cli_guard_output_of(const cli_files *files, const char *input, const char *output) {
    return cli_guard_output(files->guard, output, files->in_place ? input : NULL);
}

static int guard_each(const cli_files *files, const char *ending) {
    int status = CLI_OK;
    for (size_t i = 0; i < files->inputs.count && !status; ++i) {
        char *output = cli_output_of(files, i, ending);
        status = output ? cli_guard_output_of(files, files->inputs.list[i].path, output)
                        : cli_out_of_memory();
        free(output);
    }
    return status;
}

int cli_guard_outputs(const cli_files *files, const char *ending) {
    const int status = guard_each(files, ending);
    if (status) return status;
    if (ending || files->inputs.count > 1)
        cli_guard_look_ahead(files->guard, &files->inputs, files->format);
    return guard_each(files, ending);
}

static int same_file(const char *a, const char *b) {
    struct stat of_a, of_b;
    return stat(a, &of_a) == 0 && stat(b, &of_b) == 0 && S_ISREG(of_a.st_mode) &&
           of_a.st_dev == of_b.st_dev && of_a.st_ino == of_b.st_ino;
}

/* What the library would say after the work, said before it. */
static int check_output(const cli_subcommand *command, const cli_files *files, const char *input) {
    const char *output = files->output, *dot = strrchr(cli_base_name(output), '.'),
               *input_dot = strrchr(cli_base_name(input), '.');
    norma_file_format format = files->format ? files->format : norma_file_format_of_path(input),
                      named = norma_file_format_of_path(output);
    if (cli_is_standard(output)) return CLI_OK;
    if (cli_is_folder(output))
        return cli_usage(
            command, "-o %s is a folder; expected a file, or --out-dir %s", output, output);
    if (!cli_is_standard(input) && same_file(input, output))
        return cli_usage(
            command, "-o names the input %s; expected another name, or --in-place", input);
    if (!format || named == format || cli_is_stream(output) ||
        (!named && dot && input_dot && !strcmp(dot, input_dot)))
        return CLI_OK;
    const char *name = norma_file_format_name(format);
    return cli_usage(command,
        "-o %s: the output has the format of its input, %s; expected a name that ends in .%s",
        output, name, name);
}

int cli_check_outputs(const cli_subcommand *command, const cli_common *common, cli_files *files) {
    int ways = (files->output != NULL) + (files->folder != NULL) + files->in_place, standard = 0;
    for (size_t i = 0; i < files->inputs.count; ++i)
        standard |= cli_is_standard(files->inputs.list[i].path);
    if (ways == 0)
        return cli_usage(
            command, "no output was given; expected -o OUT, --out-dir FOLDER or --in-place");
    if (ways > 1) return cli_usage(command, "-o, --out-dir and --in-place exclude each other");
    if (files->output && files->inputs.count > 1)
        return cli_usage(command, "one -o for %zu inputs; expected --out-dir FOLDER or --in-place",
            files->inputs.count);
    if (files->output && cli_is_standard(files->output) && common->json)
        return cli_usage(command, "-o - and --json would both write to standard output");
    if (!files->output && standard)
        return cli_usage(command, "standard input has no name to write to; expected -o OUT");
    int status = files->output ? check_output(command, files, files->inputs.list[0].path)
                               : cli_place_outputs(command, files, NULL);
    if (!status) status = cli_guard_outputs(files, NULL);
    return status ? status : cli_make_out_dir(command, files);
}

/* ---- a document written */

/* Past stdio's buffer. *failed: what the system said. */
static int write_to_stdout(void *failed, const void *bytes, size_t size) {
    const unsigned char *at = bytes;
    while (size > 0) {
        ssize_t written = write(STDOUT_FILENO, at, size);
        if (written < 0 && errno != EINTR) {
            *(int *)failed = errno;
            return 1;
        }
        at += written > 0 ? written : 0;
        size -= written > 0 ? (size_t)written : 0;
    }
    return 0;
}

static norma_document_result write_standard(norma_document *document, norma_document_error *error) {
    int failed = 0;
    norma_document_result result = norma_document_write(document, write_to_stdout, &failed, error);
    if (result && failed)
        snprintf(error->message, sizeof error->message, "standard output: cannot be written: %s",
            strerror(failed));
    return result;
}

norma_document_result cli_save(const cli_files *files, norma_document *document, const char *output,
    norma_save_options *options, norma_document_error *error) {
    if (cli_is_standard(output)) return write_standard(document, error);
    if (cli_make_folders(files, output)) return cli_reported(error);
    options->struct_size = sizeof *options;
    options->in_place = files->in_place;
    cli_writing_begin();
    const norma_document_result result = norma_document_save(document, output, options, error);
    cli_writing_end();
    return result;
}

/* ---- A report that goes to a file, written whole or not at all. It goes there piece
 * by piece, so a report on any number of files takes no memory. "-" is standard output. */

/* ---- a stream whose bytes go to norma_save_piece, which remembers its first error */

#if defined(__linux__) || defined(__wasi__)
static ssize_t pass_on(void *user, const char *bytes, size_t count) {
    return norma_save_piece(user, bytes, count, NULL) ? 0 : (ssize_t)count;
}

static FILE *open_stream(norma_saving *saving) {
    return fopencookie(saving, "w", (cookie_io_functions_t){.write = pass_on});
}
#else
static int pass_on(void *user, const char *bytes, int count) {
    return norma_save_piece(user, bytes, (size_t)count, NULL) ? -1 : count;
}

static FILE *open_stream(norma_saving *saving) {
    return funopen(saving, NULL, pass_on, NULL, NULL);
}
#endif

/* ---- the output */

/* The temporary file is made before the work, so what would fail in the end is said at once. */
static int begin_file(cli_output *output) {
    norma_document_error error;
    output->passes_on = cli_is_stream(output->path);
    if (norma_save_begin(output->path, &output->saving, &error)) {
        cli_print_error(&error);
        return CLI_FILE;
    }
    cli_tidy_when_ended(norma_save_temporary(output->saving));
    output->out = open_stream(output->saving);
    if (output->out) return CLI_OK;
    cli_output_drop(output);
    return cli_out_of_memory();
}

int cli_output_begin(cli_output *output, const char *path, cli_guard *guard) {
    *output = (cli_output){.path = path, .guard = guard};
    const int status = cli_guard_output(guard, path, NULL);
    if (status || strcmp(path, "-") != 0) return status ? status : begin_file(output);
    output->out = stdout;
    output->passes_on = 1;
    return CLI_OK;
}

void cli_output_drop(cli_output *output) {
    if (output->saving && output->out) fclose(output->out);
    if (output->passes_on && output->saving) {
        norma_save_end(output->saving, NULL); /* the reader gets what there was */
    } else {
        cli_writing_begin(); /* a signal waits: the name that it would remove is freed */
        norma_save_abandon(output->saving);
        cli_tidy_when_ended(NULL);
        cli_writing_end();
    }
    *output = (cli_output){0};
}

int cli_output_end(cli_output *output) {
    if (!output->saving) return cli_finish(CLI_OK);
    norma_document_error error;
    const int refused = cli_guard_output(output->guard, output->path, NULL);
    if (refused) {
        cli_output_drop(output);
        return refused;
    }
    cli_writing_begin();
    fclose(output->out); /* a piece that cannot be written fails at the end */
    cli_tidy_when_ended(NULL);
    const int failed = norma_save_end(output->saving, &error) != NORMA_DOCUMENT_OK;
    cli_writing_end();
    if (failed) cli_print_error(&error);
    *output = (cli_output){0};
    return failed ? CLI_FILE : CLI_OK;
}
