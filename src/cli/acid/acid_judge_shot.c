/* acid_judge_shot.c: norma acid --judge: one screenshot, from its file to an exit status. */
#include "cli/acid/acid.h"
#include "cli/check/check.h"
#include "cli/process/process.h"
#include <stdlib.h>

static int read_shot(const acid_work *work, acid_picture *picture) {
    size_t size;
    char *bytes = check_read_bytes(work->judge, &size);
    if (!bytes) return CLI_FILE;
    cli_guard_read(work->files.guard, work->judge);
    const image_result result = acid_read_picture((const unsigned char *)bytes, size, picture);
    free(bytes);
    if (!result) return CLI_OK;
    if (result == IMAGE_MEMORY) return cli_out_of_memory();
    cli_error("%s: cannot be read as a picture: %s", work->judge, acid_picture_text(result));
    return CLI_FILE;
}

static int write_marked(const acid_work *work, const acid_picture *picture) {
    growing_bytes png = {0};
    cli_output output;
    int status = CLI_OK;
    if (!acid_write_picture(picture, &png)) status = cli_out_of_memory();
    if (!status) status = cli_output_begin(&output, work->output, work->files.guard);
    if (!status) {
        fwrite(png.data, 1, png.size, output.out);
        status = cli_output_end(&output);
    }
    free(png.data);
    return status;
}

static void print_verdicts(
    const acid_work *work, const acid_layout *layout, const acid_judgement *found) {
    if (work->common.json)
        acid_print_json(work, layout, found);
    else if (work->tap)
        acid_print_tap(work, layout, found);
    else if (!work->common.quiet)
        acid_print_text(work, layout, found);
}

static int judge_picture(const acid_work *work, acid_picture *picture, const acid_layout *layout) {
    acid_map map;
    acid_judgement found;
    const int marks = acid_find_marks(picture, layout, &map);
    if (marks < 0 || (marks && !acid_judge(picture, layout, &map, &found)))
        return cli_out_of_memory();
    if (!marks) {
        cli_error("%s: the four marks of the scene were not found; expected a red, a green, a blue "
                  "and a yellow square in its corners",
            work->judge);
        return CLI_FILE;
    }
    int status = CLI_OK;
    if (found.counts[ACID_PASS] + found.counts[ACID_SKIPPED] < layout->row_count)
        status = CLI_FINDINGS;
    if (work->output) {
        acid_frame(picture, layout, &map, &found);
        const int written = write_marked(work, picture);
        if (written) status = written;
    }
    if (status != CLI_FILE) print_verdicts(work, layout, &found);
    free(found.findings);
    return cli_finish(status);
}

int acid_judge_shot(const cli_subcommand *command, acid_work *work) {
    acid_picture picture = {0};
    acid_layout layout;
    if (work->common.json && work->tap)
        return cli_usage(command, "--json and --tap exclude each other");
    if (work->output && cli_is_standard(work->output) && (work->common.json || work->tap))
        return cli_usage(command, "standard output can have the picture or the verdicts, not both");
    int status = acid_layout_of(work, &layout);
    if (!status) status = read_shot(work, &picture);
    if (!status) status = judge_picture(work, &picture, &layout);
    free(picture.pixels);
    free(layout.rows);
    return status;
}
