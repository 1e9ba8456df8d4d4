/* change_files.c: a command that changes files: each is opened, changed and written, at once or in
 * passes, and a line says so. Begin at cli_run_changer, at the end. */
#define _POSIX_C_SOURCE 200809L
#include "cli/files/files.h"
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- Files that do not fit into memory, changed piece by piece; the line that a person
 * watches counts the passes. */

#if defined(__GLIBC__)
#include <malloc.h>
#endif

/* No row of a file takes as much as this many times its bytes. */
enum { MOST_NEED = 200 };

int cli_can_take_passes(const cli_files *files, const char *input, uint64_t *need) {
    struct stat status;
    return strcmp(input, "-") != 0 && stat(input, &status) == 0 && S_ISREG(status.st_mode) &&
           (uint64_t)status.st_size > cli_memory_for_data() / MOST_NEED &&
           norma_large_need(input, files->format, need);
}

int cli_needs_passes(const cli_files *files, const char *input) {
    uint64_t need;
    return cli_can_take_passes(files, input, &need) && need > cli_memory_for_data();
}

typedef struct pass_line {
    cli_progress progress;
    char what[64];
    size_t passes;
} pass_line;

static void count_pass(void *user, size_t number, size_t count) {
    pass_line *line = user;
    line->passes = number;
    snprintf(line->what, sizeof line->what, "computing, pass %zu of %zu,", number, count);
}

/* Large blocks go back to the system as soon as they are freed, so that the next pass has room for
 * blocks of other sizes. */
static void return_freed_memory(void) {
#if defined(__GLIBC__)
    mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

/* Changes it so. *size: bytes of the output. */
static norma_document_result cli_change_in_passes(const cli_changer *changer,
    const cli_common *common, const cli_files *files, const char *input, const char *output,
    uint64_t *size, norma_document_error *error) {
    pass_line line = {.what = "reading"};
    const norma_large_options options = {.struct_size = sizeof options,
        .max_memory = cli_memory_for_data(),
        .format = files->format,
        .in_place = files->in_place,
        .pass = count_pass,
        .pass_user = &line,
        .size = size};
    if (strcmp(output, "-") == 0) {
        snprintf(error->message, sizeof error->message,
            "%.800s: does not fit into the memory allowed, and standard output cannot be written "
            "in passes; give -o FILE",
            input);
        return NORMA_DOCUMENT_ERROR_UNSUPPORTED;
    }
    if (cli_make_folders(files, output)) return cli_reported(error);
    return_freed_memory();
    cli_progress_start(&line.progress, line.what, input, common->quiet, cli_megabytes(input));
    cli_writing_begin();
    const norma_document_result result = changer->in_passes(
        changer->work, input, output, &options, cli_progress_report, &line.progress, error);
    cli_progress_stop(&line.progress);
    cli_writing_end();
    return result;
}

/* ---- One triangle in each format of a batch is changed first. What the format as such refuses
 * (creases in an STL) is then refused before any file is written. */

static const char *triangle_in(norma_file_format format) {
    switch (format) {
    case NORMA_FILE_OBJ:
        return "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    case NORMA_FILE_PLY:
        return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
               "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
               "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    case NORMA_FILE_STL:
        return "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
               "endloop\nendfacet\nendsolid\n";
    default:
        return "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
               "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
               "\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
               "\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]}],\"bufferViews\":[{"
               "\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,\"uri\":\"data:"
               "application/octet-stream;base64,"
               "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}";
    }
}

static int try_format(const cli_changer *changer, const char *input, norma_file_format kind) {
    const norma_document_options options = {.struct_size = sizeof options, .format = kind};
    const char *text = triangle_in(kind);
    norma_document *document;
    norma_document_error error = {0};
    norma_document_result result =
        norma_document_open_memory(text, strlen(text), input, &options, &document, &error);
    if (!result) {
        result = changer->change(changer->work, document, NULL, NULL, &error);
        norma_document_close(document);
    }
    if (result != NORMA_DOCUMENT_ERROR_ARGUMENT) return CLI_OK; /* told of the file itself */
    cli_print_error(&error);
    return CLI_USAGE;
}

/* A status: CLI_USAGE, printed already, where some input's format does not take the options. */
static int cli_try_formats(const cli_files *files, const cli_changer *changer) {
    int tried = 0, status = CLI_OK;
    for (size_t i = 0; files->inputs.count > 1 && i < files->inputs.count && !status; ++i) {
        const char *input = files->inputs.list[i].path;
        norma_file_format kind = files->format ? files->format : norma_file_format_of_path(input);
        if (kind == NORMA_FILE_UNKNOWN) continue;
        if (norma_file_format_is_gltf(kind)) kind = NORMA_FILE_GLTF;
        if (!(tried & 1 << kind)) status = try_format(changer, input, kind);
        tried |= 1 << kind;
    }
    return status;
}

/* ---- one file */

typedef struct file_job {
    const cli_common *common;
    const cli_files *files;
    const cli_changer *changer;
    const char *input, *output;
    double before;  /* bytes of the input and the files that it names; 0: not known */
    uint64_t after; /* the same of the output */
} file_job;

static norma_document_result change_document(
    file_job *job, norma_document *document, norma_document_error *error) {
    cli_progress progress;
    double megabytes = cli_megabytes(job->input);
    cli_progress_start(&progress, "computing", job->input, job->common->quiet, megabytes);
    norma_document_result result =
        job->changer->change(job->changer->work, document, cli_progress_report, &progress, error);
    cli_progress_stop(&progress);
    if (result) return result;
    cli_progress_start(&progress, "writing", job->output, job->common->quiet, megabytes);
    norma_save_options saving = {
        .progress = cli_progress_report, .progress_user = &progress, .size = &job->after};
    result = cli_save(job->files, document, job->output, &saving, error);
    cli_progress_stop(&progress);
    return result;
}

/* ---- sizes */

static int add_size(void *user, const char *path) {
    struct stat status;
    if (stat(path, &status) == 0 && S_ISREG(status.st_mode))
        *(double *)user += (double)status.st_size;
    return 0;
}

/* Of the input and, for glTF, of the files that it names, which are written beside the output. */
static norma_document_result measure_input(
    file_job *job, norma_document *document, norma_document_error *error) {
    if (cli_is_standard(job->input)) return NORMA_DOCUMENT_OK;
    add_size(&job->before, job->input);
    const norma_file_format format = norma_document_format(document);
    return format == NORMA_FILE_GLTF || format == NORMA_FILE_GLB
               ? norma_document_visit_files(document, add_size, &job->before, error)
               : NORMA_DOCUMENT_OK;
}

static void write_size(FILE *out, double bytes) {
    char number[32];
    const int unit = bytes >= 1e6 ? 2 : bytes >= 1e3 ? 1 : 0;
    static const char *const names[] = {"bytes", "kB", "MB"};
    static const double sizes[] = {1, 1e3, 1e6};
    fprintf(out, "%s %s", cli_decimals(number, bytes / sizes[unit], unit ? 1 : 0), names[unit]);
}

/* Only if it grew by more than a tenth. */
static void write_growth(const file_job *job, FILE *out) {
    const double after = (double)job->after;
    if (job->before <= 0 || after <= 1.1 * job->before) return;
    fputs("; size ", out);
    write_size(out, job->before);
    fputs(" -> ", out);
    write_size(out, after);
}

static void report_change_json(
    const file_job *job, const norma_document *document, const norma_document_error *error) {
    cli_json json = {.out = stdout};
    cli_json_print(&json, "{input: %s, output: %s", job->input, error->result ? NULL : job->output);
    if (error->result)
        cli_json_string(&json, "error", error->message);
    else {
        job->changer->write_json(job->changer->work, &json);
        cli_json_notes(&json, document);
    }
    cli_json_print(&json, "}\n");
}

static void report_change(
    const file_job *job, const norma_document *document, const norma_document_error *error) {
    if (error->result) {
        cli_print_error(error);
    } else if (!job->common->quiet && !job->common->json) {
        int to_stdout = cli_is_standard(job->output);
        FILE *out = to_stdout ? stderr : stdout;
        fflush(stdout);
        cli_say(out, "%s -> %s: ", cli_input_name(job->input),
            to_stdout ? "standard output" : job->output);
        job->changer->write_text(job->changer->work, document, out);
        write_growth(job, out);
        fputc('\n', out);
        fflush(out);
        cli_print_notes(job->input, document);
    }
    if (job->common->json) report_change_json(job, document, error);
}

static file_job job_of(const cli_all_files *all, const char *input, const char *output) {
    return (file_job){.common = all->common,
        .files = all->files,
        .changer = all->changer,
        .input = input,
        .output = output};
}

void cli_report_changed(const cli_all_files *all, const char *input, const char *output,
    const double bytes[2], const norma_document_error *error) {
    file_job job = job_of(all, input, output);
    if (error->result && all->common->json) report_change_json(&job, NULL, error);
    if (error->result) return;
    job.before = bytes[0];
    job.after = (uint64_t)bytes[1];
    report_change(&job, NULL, error);
}

/* Of a file larger than memory. */
static int run_in_passes(file_job *job) {
    norma_document_error error = {0};
    const int refused = cli_guard_output_of(job->files, job->input, job->output);
    if (refused) return refused;
    add_size(&job->before, job->input);
    error.result = cli_change_in_passes(
        job->changer, job->common, job->files, job->input, job->output, &job->after, &error);
    cli_name_error(&error, job->input);
    report_change(job, NULL, &error);
    return cli_status_of(error.result);
}

static int run_file_job(file_job *job) {
    if (job->changer->in_passes && cli_needs_passes(job->files, job->input))
        return run_in_passes(job);
    const norma_document_options reading = {0};
    norma_document *document;
    void *memory;
    norma_document_error error = {0};
    norma_document_result result =
        cli_read(job->files, job->common, job->input, &reading, &document, &memory, &error);
    const int refused = result ? CLI_OK : cli_guard_output_of(job->files, job->input, job->output);
    if (!result && !refused) result = measure_input(job, document, &error);
    if (!result && !refused) result = change_document(job, document, &error);
    error.result = result;
    cli_name_error(&error, job->input);
    if (!refused) report_change(job, document, &error);
    norma_document_close(document);
    free(memory);
    return refused ? refused : cli_status_of(result);
}

static int change_one(void *user, size_t file) {
    file_job job = *(const file_job *)user;
    char *output = cli_output_of(job.files, file, NULL);
    if (!output) return cli_out_of_memory();
    job.input = job.files->inputs.list[file].path;
    job.output = output;
    const int status = run_file_job(&job);
    free(output);
    return status;
}

static void report_lost_change(void *user, size_t file, int worker, const char *why) {
    file_job job = *(const file_job *)user;
    norma_document_error error;
    job.input = job.files->inputs.list[file].path;
    cli_remove_left_by(worker, job.files, file);
    cli_lost_error(&error, job.input, why);
    report_change(&job, NULL, &error);
}

static int change_files(const cli_subcommand *command, const cli_common *common, cli_files *files,
    const cli_changer *changer) {
    int status = cli_find_inputs(command, files);
    if (status == CLI_USAGE || files->inputs.count == 0) return status;
    int placed = cli_try_formats(files, changer);
    if (!placed) placed = cli_check_outputs(command, common, files);
    if (placed) return placed;
    if (changer->all && changer->takes_all(changer->work)) {
        const cli_all_files all = {command, common, files, changer};
        return cli_finish(cli_worse(status, status ? CLI_OK : changer->all(&all)));
    }
    file_job job = {.common = common, .files = files, .changer = changer};
    const cli_each each = {files->inputs.count, change_one, report_lost_change, &job, files->guard};
    return cli_finish(cli_worse(status, cli_run_each(&each)));
}

int cli_run_changer(const cli_subcommand *command, const cli_changer *changer, const cli_table *own,
    size_t own_count, int count, char **arguments) {
    cli_common common = {.threads = NORMA_ALL_THREADS};
    cli_files files = {0};
    const cli_table shared[] = {
        {cli_output_options, cli_output_option_count, &files},
        {cli_input_options, cli_input_option_count, &files},
        {cli_common_options, cli_common_option_count, &common},
    };
    cli_table tables[CLI_OWN_TABLES + CLI_COUNT(shared)];
    own_count = own_count < CLI_OWN_TABLES ? own_count : CLI_OWN_TABLES;
    memcpy(tables, own, own_count * sizeof *own);
    memcpy(tables + own_count, shared, sizeof shared);
    int status =
        cli_read_files(command, &files, tables, own_count + CLI_COUNT(shared), count, arguments);
    if (status) return status;
    if (changer->prepare) status = changer->prepare(command, changer->work, common.threads);
    if (!status) status = change_files(command, &common, &files, changer);
    cli_remove_empty_folders(&files);
    cli_files_end(&files);
    return status;
}
