/* compute_together.c: normals of one surface that lies in many files: all are read, then all are
 * written, or none; or, by votes of all, one after the other. */
#include "cli/compute/compute_together.h"
#include "cli/files/files.h"
#include "cli/options/options.h"
#include "cli/process/process.h"
#include <stdlib.h>
#include <string.h>

/* ---- options */

static const char *add_lock(void *settings, const char *value) {
    compute_work *work = settings;
    if (!value[0]) return "a pattern of names";
    const char **grown =
        cli_grow((void *)work->locks, work->lock_count, &work->lock_room, sizeof *grown);
    if (!grown) return "fewer; out of memory";
    work->locks = grown;
    work->locks[work->lock_count++] = value;
    return NULL;
}

const cli_option compute_together_options[] = {
    {"together", CLI_SETS(compute_work, together, 1)},
    {"lock", CLI_SET(add_lock)},
    {"levels", CLI_SETS(compute_work, levels, 1)},
};
const size_t compute_together_option_count = CLI_COUNT(compute_together_options);

int compute_check_together(const cli_subcommand *command, const compute_work *work) {
    if (!work->together)
        return work->lock_count || work->levels
                   ? cli_usage(command, "--lock and --levels need --together")
                   : CLI_OK;
    if (work->flat_given)
        return cli_usage(command,
            "--together shares normals, but flat normals cannot be shared; leave out --flat");
    if (work->crease_given && (work->lock_count || work->levels))
        return cli_usage(command, "with --together, --lock and --levels work only for smooth "
                                  "normals; leave out --crease");
    if (work->options.weld == NORMA_WELD_NONE)
        return cli_usage(
            command, "--together joins equal positions; --weld none would join nothing");
    if (work->options.weight == NORMA_WEIGHT_VISIBLE)
        return cli_usage(command, "--together needs a weight that is summed over faces, and "
                                  "visible is not; give another --weight");
    if (work->options.only != NORMA_ONLY_ALL)
        return cli_usage(
            command, "--together computes all normals; --lock PATTERN keeps some, --only cannot");
    return CLI_OK;
}

int compute_refuse_moved(const cli_inputs *inputs) {
    if (inputs->moved)
        cli_error("%s: its tiles have transforms, which are not applied, so seams would be sought "
                  "at wrong places; expected tiles in one frame",
            inputs->moved);
    return inputs->moved != NULL;
}

/* ---- the run */

typedef struct joint_file {
    norma_compute_summary summary;
    uint64_t size;
    double before; /* bytes of the input and of what it names */
    char *output;
} joint_file;

typedef struct joint_run {
    const cli_all_files *all;
    norma_together_file *files;
    joint_file *own;             /* what each of them points to */
    size_t count, done, at_once; /* done: files of the calls before */
    const compute_work *work;
    size_t *lock_matches;                  /* of each --lock: names that match it */
    char (*nearest)[CLI_LONGEST_WORD + 1]; /* to each, of the names that do not */
    cli_progress progress;
} joint_run;

static void free_run(joint_run *run) {
    for (size_t i = 0; run->own && i < run->count; ++i) free(run->own[i].output);
    free(run->files);
    free(run->own);
    free(run->lock_matches);
    free(run->nearest);
}

static int make_run(joint_run *run) {
    const size_t count = run->count;
    run->files = calloc(count, sizeof *run->files);
    run->own = calloc(count, sizeof *run->own);
    run->lock_matches = calloc(run->work->lock_count + 1, sizeof *run->lock_matches);
    run->nearest = calloc(run->work->lock_count + 1, sizeof *run->nearest);
    if (!run->files || !run->own || !run->lock_matches || !run->nearest) return 0;
    for (size_t i = 0; i < count; ++i) {
        joint_file *own = &run->own[i];
        own->output = cli_output_of(run->all->files, i, NULL);
        if (!own->output) return 0;
        run->files[i] = (norma_together_file){.input = run->all->files->inputs.paths[i],
            .output = own->output,
            .format = run->all->files->format,
            .summary = &own->summary,
            .size = &own->size};
    }
    return 1;
}

static int check_names(const joint_run *run) {
    for (size_t i = 0; i < run->count; ++i)
        if (strcmp(run->files[i].input, "-") == 0 || strcmp(run->files[i].output, "-") == 0)
            return cli_usage(run->all->command,
                run->work->votes
                    ? "standard input and output cannot be among the files"
                    : "--together reads its files twice and writes them all at once; standard "
                      "input and output cannot be among them");
    return CLI_OK;
}

/* ---- a --lock that nothing matches */

static void compare_name(joint_run *run, const char *name) {
    for (size_t i = 0; name && strlen(name) <= CLI_LONGEST_WORD && i < run->work->lock_count; ++i) {
        const char *both[] = {name, run->nearest[i]};
        const char *nearest =
            cli_suggest(run->work->locks[i], both, both[1][0] ? 2 : 1, sizeof *both);
        if (nearest == name) strcpy(run->nearest[i], name);
    }
}

static void compare_document_names(joint_run *run, const norma_document *given) {
    norma_document *document = (norma_document *)(uintptr_t)given;
    norma_mesh_info mesh;
    norma_material_info material;
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i)
        if (!norma_document_mesh_info(document, i, &mesh)) compare_name(run, mesh.name);
    for (size_t i = 0; i < norma_document_material_count(document); ++i)
        if (!norma_document_material_info(document, i, &material)) compare_name(run, material.name);
}

static void report_locks(const joint_run *run) {
    for (size_t i = 0; i < run->work->lock_count; ++i) {
        const char *nearest = run->nearest[i];
        if (run->lock_matches[i]) continue;
        cli_error("--lock '%s' matches no mesh, material or group, and locks nothing%s%s%s",
            run->work->locks[i], nearest[0] ? "; did you mean " : "", nearest,
            nearest[0] ? "?" : "");
    }
}

static void note_done(void *user, size_t file, const norma_document *document) {
    joint_run *run = user;
    file += run->done;
    if (run->work->lock_count) compare_document_names(run, document);
    run->own[file].before = 1e6 * cli_megabytes(run->files[file].input);
    cli_progress_hide(&run->progress);
    if (!run->all->common->quiet && !run->all->common->json)
        cli_print_notes(run->files[file].input, document);
}

/* Of the files that are computed at once, as a share of all. */
static int report_share(void *user, double fraction) {
    joint_run *run = user;
    return cli_progress_report(
        &run->progress, ((double)run->done + fraction * (double)run->at_once) / (double)run->count);
}

/* Those from run->done on. */
static norma_document_result compute_some(
    joint_run *run, compute_work *work, norma_document_error *error) {
    norma_compute_options options = work->options;
    const uint64_t allowed = cli_memory_for_data();
    options.progress = report_share;
    options.progress_user = run;
    const norma_together_options together = {.struct_size = sizeof together,
        .lock = work->locks,
        .lock_count = work->lock_count,
        .lock_matches = run->lock_matches,
        .levels = work->levels,
        .in_place = run->all->files->in_place,
        .threads = options.threads,
        .max_memory = allowed < (uint64_t)1 << 29 ? allowed : 0,
        .temporary_folder = getenv("TMPDIR"),
        .votes = work->votes,
        .weight = &work->options.weight,
        .file_done = note_done,
        .file_done_user = run};
    return norma_together_compute(run->files + run->done, run->at_once, &together, &options, error);
}

static void report_file(const joint_run *run, compute_work *work, size_t file) {
    const norma_file_format format = run->files[file].format;
    const joint_file *own = &run->own[file];
    work->summary = own->summary;
    work->format = format ? format : norma_file_format_of_path(run->files[file].input);
    cli_report_grown(run->all, run->files[file].input, own->output, own->before, (double)own->size);
}

/* Files that were computed at once have one error: then none of them was written. */
static void report_some(joint_run *run, compute_work *work, norma_document_error *error) {
    cli_progress_hide(&run->progress);
    if (error->result) {
        cli_name_error(error, run->at_once == 1 ? run->files[run->done].input : "");
        cli_print_error(error);
    } else
        report_locks(run);
    for (size_t i = run->done; i < run->done + run->at_once; ++i)
        if (!error->result)
            report_file(run, work, i);
        else if (run->all->common->json)
            cli_report_changed(run->all, run->files[i].input, NULL, error);
}

/* All files at once, or by votes one after the other: then one that fails does not stop the others.
 * The worst status. */
static int compute_files(joint_run *run, compute_work *work) {
    double megabytes = 0;
    int status = CLI_OK;
    for (size_t i = 0; i < run->count; ++i) megabytes += cli_megabytes(run->files[i].input);
    cli_progress_start(
        &run->progress, "computing", "all files", run->all->common->quiet, megabytes);
    run->at_once = work->votes ? 1 : run->count;
    for (; run->done < run->count && !cli_interrupted(); run->done += run->at_once) {
        norma_document_error error = {0};
        cli_writing_begin();
        error.result = compute_some(run, work, &error);
        if (cli_interrupted()) cli_progress_stop(&run->progress);
        if (!error.result || !cli_interrupted()) report_some(run, work, &error);
        cli_writing_end(); /* ends the process if it was interrupted */
        status = cli_worse(status, cli_status_of(error.result));
    }
    cli_progress_stop(&run->progress);
    return status;
}

static int make_folders(const joint_run *run) {
    int status = CLI_OK;
    for (size_t i = 0; i < run->count && !status; ++i)
        status = cli_make_folders(run->all->files, run->own[i].output);
    return status;
}

static int run_all(joint_run *run, compute_work *work) {
    int status = check_names(run);
    if (!status) status = make_folders(run);
    return status ? status : compute_files(run, work);
}

int compute_all_together(const cli_all_files *all, const cli_changer *changer) {
    joint_run run = {.all = all, .count = all->files->inputs.count, .work = changer->work};
    if (compute_refuse_moved(&all->files->inputs)) return CLI_FILE;
    const int status = make_run(&run) ? run_all(&run, changer->work) : cli_out_of_memory();
    free_run(&run);
    return status;
}
