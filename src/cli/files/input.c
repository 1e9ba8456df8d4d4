/* input.c: opens the files that the command line names, standard input included. */
#define _POSIX_C_SOURCE 200809L
#include "cli/files/input.h"
#include "cli/files/find_inputs.h"
#include "cli/process/errors.h"
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *set_input_format(void *settings, const char *value) {
    for (int format = NORMA_FILE_OBJ; format <= NORMA_FILE_GLB; ++format)
        if (strcmp(value, norma_file_format_name((norma_file_format)format)) == 0) {
            ((cli_files *)settings)->format = (norma_file_format)format;
            return NULL;
        }
    return "obj, ply, stl, gltf or glb";
}

const cli_option cli_input_options[] = {{"input-format", 0, 1, set_input_format}};
const size_t cli_input_option_count = CLI_COUNT(cli_input_options);

int cli_files_begin(const cli_subcommand *command, cli_files *files, int count) {
    files->words.words = calloc((size_t)count + 1, sizeof(char *));
    files->lists.words = calloc((size_t)count + 1, sizeof(char *));
    files->guard = cli_guard_new(command);
    if (files->words.words && files->lists.words && files->guard) return 1;
    if (files->guard) cli_out_of_memory();
    cli_files_end(files);
    return 0;
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

static norma_document_result fail_input(norma_document_error *error, norma_document_result result,
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

/* To its end. */
static norma_document_result read_pipe(
    int descriptor, const char *input, void **memory, size_t *size, norma_document_error *error) {
    size_t capacity = (size_t)1 << 16;
    unsigned char *bytes = malloc(capacity);
    *size = 0;
    while (bytes) {
        if (*size == capacity) {
            const char *endless = why_endless(descriptor, capacity);
            if (endless) {
                free(bytes);
                return fail_input(error, NORMA_DOCUMENT_ERROR_REFUSED, input, endless);
            }
            unsigned char *larger = capacity <= SIZE_MAX / 2 ? realloc(bytes, capacity * 2) : NULL;
            if (!larger) break;
            bytes = larger;
            capacity *= 2;
        }
        ssize_t got = read(descriptor, bytes + *size, capacity - *size);
        const char *why = got < 0 && errno != EINTR ? strerror(errno) : NULL;
        if (why) {
            free(bytes);
            return fail_input(error, NORMA_DOCUMENT_ERROR_FILE, input, why);
        }
        if (got == 0) {
            *memory = bytes;
            return NORMA_DOCUMENT_OK;
        }
        *size += got > 0 ? (size_t)got : 0;
    }
    free(bytes);
    return fail_input(error, NORMA_DOCUMENT_ERROR_MEMORY, input, "out of memory");
}

static norma_document_result read_named_pipe(
    const char *path, void **memory, size_t *size, norma_document_error *error) {
    int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) return fail_input(error, NORMA_DOCUMENT_ERROR_FILE, path, strerror(errno));
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
    if (!result) cli_guard_document(files->guard, *document, input);
    return result;
}

void cli_json_notes(struct cli_json *json, const norma_document *document) {
    cli_json_open(json, "notes", '[');
    for (size_t i = 0; i < norma_document_note_count(document); ++i)
        cli_json_string(json, NULL, norma_document_note(document, i));
    cli_json_close(json, ']');
}
