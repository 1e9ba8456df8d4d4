/* acid_command.c: norma acid: scenes that show whether a renderer carries normals, and a judge for
 * its screenshots. */
#include "cli/acid/acid.h"
#include <string.h>

static const char acid_help[] =
    "norma acid -o DIR: writes scenes that show whether a renderer carries normals\n"
    "norma acid --judge SHOT.png: reads a screenshot of them and names the renderer's mistakes\n"
    "\n"
    "Examples\n"
    "  norma acid -o scenes\n"
    "  norma acid --judge shot.png -o marked.png\n"
    "  norma acid --judge shot.png --without EXT_mesh_gpu_instancing\n"
    "  norma acid --judge shear.png --scene cells/shear.glb\n"
    "\n"
    "Options\n"
    "  --judge SHOT.png      the screenshot, a PNG or JPEG of any size that shows the scene's four "
    "marks\n"
    "  --scene FILE          what was drawn, if not norma-acid.glb of this norma: cells/ID.glb, or "
    "an acid.json\n"
    "  --without EXTENSIONS  extensions that the renderer lacks, with commas between; cells that "
    "need\n"
    "                        one are skipped\n"
    "  -o, --output DIR      without --judge: the folder for norma-acid.glb, cells/ID.glb, "
    "acid.json and\n"
    "                        index.html, which explains each cell\n"
    "  -o, --output FILE     with it: writes the screenshot as a PNG with a frame around each "
    "subject: "
    "green (pass),\n"
    "                        red (fail, missing), grey (unclear, skipped)\n"
    "  --tap                 prints the verdicts as TAP, one test for each cell\n"
    "  --json                prints the verdicts and all distances as JSON\n"
    "  --quiet               prints only errors\n"
    "\n"
    "Each subject is compared with the references beside it, in the screenshot's own colours: "
    "pass, "
    "fail\n"
    "with the mistake it looks like, missing (it is not drawn), or unclear (it cannot be told). If "
    "the\n"
    "control fails, all other cells are unclear.\n"
    "Exit status: 0 all cells pass or are skipped, 1 some do not, 2 wrong usage, 3 the marks were "
    "not found\n"
    "or a file could not be read or written, 130 interrupted.\n";

static const char *add_without(void *settings, const char *value) {
    acid_work *work = settings;
    static const char expected[] = "names of extensions with commas between";
    for (const char *at = value;; ++at) {
        const size_t length = strcspn(at, ",");
        if (!length || work->without_count == CLI_COUNT(work->without)) return expected;
        work->without[work->without_count].name = at;
        work->without[work->without_count++].length = length;
        at += length;
        if (!*at) return NULL;
    }
}

static const cli_option acid_options[] = {
    {"judge", CLI_TO(CLI_ONCE, acid_work, judge), .expected = "a screenshot"},
    {"scene", CLI_TO(CLI_ONCE, acid_work, scene), .expected = "cells/ID.glb or an acid.json"},
    {"without", CLI_SET(add_without)},
    {"output", 'o', CLI_TO(CLI_TEXT, acid_work, output),
        .expected = "a folder, or a file with --judge"},
    {"tap", CLI_SETS(acid_work, tap, 1)},
};

static int acid(const cli_subcommand *command, acid_work *work) {
    if (work->files.words.count)
        return cli_usage(
            command, "unexpected '%s'; expected --judge SHOT.png", work->files.words.words[0]);
    if (!work->judge && !work->output)
        return cli_usage(command, "nothing to do was given; expected -o DIR or --judge SHOT.png");
    if (!work->judge) return acid_write_scenes(work);
    return acid_judge_shot(command, work);
}

static int acid_run(const cli_subcommand *command, int count, char **arguments) {
    acid_work work = {0};
    const cli_table tables[] = {{acid_options, CLI_COUNT(acid_options), &work},
        {cli_common_options, cli_common_option_count, &work.common}};
    int status = cli_read_files(command, &work.files, tables, CLI_COUNT(tables), count, arguments);
    if (status) return status;
    status = acid(command, &work);
    cli_files_end(&work.files);
    return status;
}

const cli_subcommand cli_subcommand_acid = {"acid",
    "writes scenes that show whether a renderer carries normals, and judges screenshots", acid_help,
    acid_run};
