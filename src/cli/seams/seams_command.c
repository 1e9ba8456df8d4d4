/* seams_command.c: norma seams: one surface in more files than one process should hold, in three
 * steps that any scheduler can run. */
#include "cli/compute/compute_command.h"
#include "cli/compute/compute_together.h"
#include "cli/files/files.h"
#include "cli/options/options.h"
#include "cli/process/process.h"
#include "cli/text/text.h"
#include <stdlib.h>
#include <string.h>

static const char seams_help[] =
    "norma seams votes|merge|apply: one seamless surface in more files than a process holds\n"
    "\n"
    "The normals have the same bits as those of norma compute --together for all files.\n"
    "\n"
    "Examples\n"
    "  norma seams votes a.ply b.ply -o ab.votes        what tiles add along their borders\n"
    "  norma seams merge ab.votes cd.votes -o all.votes\n"
    "  norma seams apply a.ply --votes all.votes -o out/a.ply\n"
    "\n"
    "votes TILE... -o FILE\n"
    "  --weight angle|area|uniform|max|angle-area|angle-lengths\n"
    "                        how much each face counts at a vertex (angle)\n"
    "  --everywhere          votes at all positions, not only on edges of one face: needed if\n"
    "                        tiles touch elsewhere (closed bodies, levels of detail)\n"
    "  --rounded             rounds positions to floats, as for a glTF: needed for OBJ and PLY\n"
    "                        tiles of a surface that has glTF tiles too\n"
    "\n"
    "merge VOTES... -o FILE  joins files of votes, also merged ones: in any order, by any tree\n"
    "  --tiles N             refuses to join votes of fewer or more than N tiles\n"
    "\n"
    "apply TILE... --votes FILE\n"
    "  -o, --out-dir, --in-place\n"
    "                        as norma compute; one tile is in memory at a time\n"
    "\n"
    "Files\n" CLI_INPUT_FORMAT_HELP
    "  --threads N           uses at most N threads (all processors), with the same result\n"
    "  --max-memory SIZE     uses at most SIZE (512M, 2G)\n"
    "  --json                prints a summary as JSON\n"
    "  --quiet               prints only errors\n"
    "\n"
    "Files of votes name their tiles by hashes: a tile that is there twice, is missing or has\n"
    "changed since is an error, and so is a damaged file.\n"
    "Exit status: 0 fine, 2 wrong usage, 3 a file could not be read or written, 130 interrupted.\n";

typedef struct seams_work {
    norma_seams_options options;
    cli_common common;
    cli_files files;
    const char *output;
    norma_seams_summary summary;
} seams_work;

static const cli_option votes_options[] = {
    {"weight", CLI_TO(CLI_WEIGHT, seams_work, options.weight)},
    {"everywhere", CLI_SETS(seams_work, options.everywhere, 1)},
    {"rounded", CLI_SETS(seams_work, options.rounded, 1)},
    {"output", 'o', CLI_TO(CLI_TEXT, seams_work, output), .expected = "the name of a file"},
};
static const cli_option merge_options[] = {
    {"tiles", CLI_TO(CLI_SIZE, seams_work, options.tiles), .least = 1, .most = 1e9,
        .expected = CLI_WHOLE_FROM_1},
    {"output", 'o', CLI_TO(CLI_TEXT, seams_work, output), .expected = "the name of a file"},
};

/* ---- votes and merge */

static void report_written(const seams_work *work) {
    const norma_seams_summary *summary = &work->summary;
    cli_json json = {.out = stdout};
    if (work->common.json) {
        cli_json_print(&json, "{output: %s, tiles: %zu, positions: %zu, bytes: %zu}\n",
            work->output, summary->tiles, (size_t)summary->positions, (size_t)summary->bytes);
    } else if (!work->common.quiet) {
        cli_say(stderr, "%s: votes of ", work->output);
        cli_counted(stderr, summary->tiles, "tile", "tiles");
        fputs(" at ", stderr);
        cli_counted(stderr, (size_t)summary->positions, "position", "positions");
        fputc('\n', stderr);
    }
}

static int write_seams(seams_work *work, int merges) {
    const cli_inputs *inputs = &work->files.inputs;
    const char *const *paths =
        merges ? work->files.words.words : (const char *const *)(uintptr_t)inputs->paths;
    const size_t count = merges ? work->files.words.count : inputs->count;
    norma_document_error error = {0};
    cli_progress progress;
    cli_progress_start(
        &progress, merges ? "merging" : "taking votes", work->output, work->common.quiet, 0);
    work->options.progress = cli_progress_report;
    work->options.progress_user = &progress;
    cli_writing_begin();
    const norma_document_result result =
        merges
            ? norma_seams_merge(paths, count, work->output, &work->options, &work->summary, &error)
            : norma_seams_votes(paths, count, work->output, &work->options, &work->summary, &error);
    cli_progress_stop(&progress);
    cli_writing_end();
    if (!result) {
        report_written(work);
        return cli_finish(CLI_OK);
    }
    cli_name_error(&error, work->output);
    cli_print_error(&error);
    return cli_status_of(result);
}

/* The output replaces no tile and no votes that are read. */
static int guard_seams(const seams_work *work, int merges) {
    const cli_words *words = &work->files.words;
    for (size_t i = 0; merges && i < words->count; ++i)
        cli_guard_read(work->files.guard, words->words[i]);
    if (!merges) cli_guard_look_ahead(work->files.guard, &work->files.inputs, work->files.format);
    return cli_guard_output(work->files.guard, work->output, NULL);
}

static int read_seams(const cli_subcommand *command, seams_work *work, int merges) {
    const char *const *words = work->files.words.words;
    int standard = 0;
    for (size_t i = 0; i < work->files.words.count; ++i) standard |= cli_is_standard(words[i]);
    if (!work->output) return cli_usage(command, "no output was given; expected -o FILE");
    if (standard || cli_is_standard(work->output))
        return cli_usage(command, "standard input and output cannot be among the files");
    if (!work->files.words.count)
        return cli_usage(command, merges ? "no votes were given" : "no tile was given");
    if (work->options.weight == NORMA_WEIGHT_VISIBLE)
        return cli_usage(command, "votes need a weight that is summed over faces, and visible is "
                                  "not; give another --weight");
    work->options.format = work->files.format;
    work->options.threads = work->common.threads;
    work->options.temporary_folder = getenv("TMPDIR");
    work->options.max_memory = cli_memory_for_data() / 4;
    int status = merges ? CLI_OK : cli_find_inputs(command, &work->files);
    if (!status && compute_refuse_moved(&work->files.inputs)) status = CLI_FILE;
    if (!status) status = guard_seams(work, merges);
    return status ? status : write_seams(work, merges);
}

static int run_votes(const cli_subcommand *command, int merges, int count, char **arguments) {
    seams_work work = {
        .options = {.struct_size = sizeof work.options}, .common.threads = NORMA_ALL_THREADS};
    const cli_table tables[] = {
        {merges ? merge_options : votes_options,
            merges ? CLI_COUNT(merge_options) : CLI_COUNT(votes_options), &work},
        {cli_input_options, cli_input_option_count, &work.files},
        {cli_common_options, cli_common_option_count, &work.common},
    };
    int status = cli_read_files(command, &work.files, tables, CLI_COUNT(tables), count, arguments);
    if (status) return status;
    status = read_seams(command, &work, merges);
    cli_remove_empty_folders(&work.files);
    cli_files_end(&work.files);
    return status;
}

/* ---- the command */

static int seams_run(const cli_subcommand *command, int count, char **arguments) {
    const char *step = count ? arguments[0] : "";
    if (strcmp(step, "votes") == 0) return run_votes(command, 0, count - 1, arguments + 1);
    if (strcmp(step, "merge") == 0) return run_votes(command, 1, count - 1, arguments + 1);
    if (strcmp(step, "apply") == 0) return compute_with_votes(command, count - 1, arguments + 1);
    return count ? cli_usage(command, "unknown step '%s'; expected votes, merge or apply", step)
                 : cli_usage(command, "expected votes, merge or apply");
}

const cli_subcommand cli_subcommand_seams = {"seams",
    "makes one seamless surface of more files than a process holds, in three steps", seams_help,
    seams_run};
