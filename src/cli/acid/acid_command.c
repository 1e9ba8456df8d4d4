/* acid_command.c: norma acid: scenes that show whether a renderer carries normals, and a judge for
 * its screenshots: where things lie, one picture, and what was found. */
#include "cli/acid/acid.h"
#include "cli/check/check.h"
#include "cli/process/process.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- acid.json: where the marks and the patches of an acid scene lie */

static int refuse_layout(const acid_work *work, const char *where, const char *expected) {
    cli_error("%s: %s: expected %s, as in acid.json of norma acid", work->scene, where, expected);
    return CLI_FILE;
}

static int read_pair(cli_value pair, double to[2]) {
    return cli_elements(pair) == 2 && cli_number_of(cli_element(pair, 0), &to[0]) &&
           cli_number_of(cli_element(pair, 1), &to[1]);
}

static int is_sound_box(const acid_box *box) {
    for (int k = 0; k < 2; ++k)
        if (!(fabs(box->center[k]) <= 2 && box->size[k] > 1e-4 && box->size[k] <= 2)) return 0;
    return 1;
}

static int read_box(cli_value place, acid_box *box) {
    return read_pair(cli_get(place, "center"), box->center) &&
           read_pair(cli_get(place, "size"), box->size) && is_sound_box(box);
}

static int copy_id(cli_value id, char to[ACID_ID_ROOM]) {
    const char *text = cli_string(id);
    const size_t length = text ? strlen(text) : 0;
    if (!length || length >= ACID_ID_ROOM) return 0;
    memcpy(to, text, length + 1);
    return 1;
}

/* The box around a mark's corners. */
static int read_mark(cli_value corners, acid_box *box) {
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY}, at[2];
    if (cli_elements(corners) != 4) return 0;
    for (uint32_t i = 0; i < 4; ++i) {
        if (!read_pair(cli_element(corners, i), at)) return 0;
        for (int k = 0; k < 2; ++k) {
            low[k] = fmin(low[k], at[k]);
            high[k] = fmax(high[k], at[k]);
        }
    }
    for (int k = 0; k < 2; ++k) {
        box->center[k] = (low[k] + high[k]) / 2;
        box->size[k] = high[k] - low[k];
    }
    return is_sound_box(box);
}

static int read_marks(cli_value marks, acid_box boxes[ACID_MARKS]) {
    static const char *const colors[ACID_MARKS] = {"red", "green", "blue", "yellow"};
    int found = 0;
    for (cli_value mark = cli_first(marks); mark.in; mark = cli_next(mark)) {
        const char *color = cli_string(cli_get(mark, "color"));
        for (int i = 0; i < ACID_MARKS; ++i)
            if (color && strcmp(color, colors[i]) == 0 &&
                read_mark(cli_get(mark, "corners"), &boxes[i]))
                found |= 1 << i;
    }
    return found == (1 << ACID_MARKS) - 1;
}

/* "right" becomes the first. */
static int read_references(cli_value references, acid_row *row) {
    int right = -1;
    for (cli_value r = cli_first(references); r.in; r = cli_next(r)) {
        if (row->reference_count == ACID_MOST_REFERENCES) return 0;
        acid_place *place = &row->references[row->reference_count];
        if (!copy_id(cli_get(r, "id"), place->id) || !read_box(r, &place->box)) return 0;
        if (strcmp(place->id, "right") == 0) right = (int)row->reference_count;
        ++row->reference_count;
    }
    if (right < 0) return 0;
    const acid_place first = row->references[0];
    row->references[0] = row->references[right];
    row->references[right] = first;
    return 1;
}

static int lacks(const acid_work *work, const char *extension) {
    for (size_t i = 0; extension && i < work->without_count; ++i)
        if (strlen(extension) == work->without[i].length &&
            memcmp(extension, work->without[i].name, work->without[i].length) == 0)
            return 1;
    return 0;
}

/* places: the cell itself, or its "alone". */
static int read_row(const acid_work *work, cli_value cell, cli_value places, acid_row *row) {
    const cli_value extensions = cli_get(cell, "extensions");
    for (cli_value name = cli_first(extensions); name.in; name = cli_next(name))
        row->skipped |= lacks(work, cli_string(name));
    return copy_id(cli_get(cell, "id"), row->id) &&
           read_box(cli_get(places, "subject"), &row->subject) &&
           read_references(cli_get(places, "references"), row);
}

/* ---- scenes */

static int read_scene(const acid_work *work, cli_value root, acid_layout *layout) {
    const cli_value cells = cli_get(root, "cells");
    const size_t count = cli_elements(cells);
    if (!read_marks(cli_get(root, "marks"), layout->marks))
        return refuse_layout(work, "\"marks\"", "red, green, blue and yellow with four corners");
    if (!count || count > ACID_MOST_CELLS)
        return refuse_layout(work, "\"cells\"", "one cell at least, and 256 at most");
    layout->rows = calloc(count, sizeof *layout->rows);
    if (!layout->rows) return cli_out_of_memory();
    for (cli_value cell = cli_first(cells); cell.in; cell = cli_next(cell)) {
        acid_row *row = &layout->rows[layout->row_count++];
        char where[64];
        if (read_row(work, cell, cell, row)) continue;
        snprintf(where, sizeof where, "cell %zu", layout->row_count);
        return refuse_layout(work, where,
            "\"id\", \"subject\", and \"references\" of which one is \"right\", each with "
            "\"center\" and \"size\"");
    }
    return CLI_OK;
}

/* A cell's own file. */
static int read_alone(
    const acid_work *work, cli_value root, const char *id, size_t length, acid_layout *layout) {
    cli_value cell = cli_first(cli_get(root, "cells"));
    for (; cell.in; cell = cli_next(cell)) {
        const char *name = cli_string(cli_get(cell, "id"));
        if (name && strlen(name) == length && memcmp(name, id, length) == 0) break;
    }
    const cli_value alone = cli_get(cell, "alone");
    if (!cell.in)
        return refuse_layout(
            work, "its name is not that of a cell", "norma-acid.glb or cells/ID.glb");
    layout->rows = calloc(1, sizeof *layout->rows);
    if (!layout->rows) return cli_out_of_memory();
    layout->row_count = 1;
    if (!read_marks(cli_get(alone, "marks"), layout->marks) ||
        !read_row(work, cell, alone, layout->rows))
        return refuse_layout(work, "\"alone\"", "\"marks\", \"subject\" and \"references\"");
    return CLI_OK;
}

/* Whether the scene is a .glb; *id: the cell of which it is the own file, by its name. */
static int is_glb(const char *scene, const char **id, size_t *length) {
    const char *base = cli_base_name(scene), *dot = strrchr(base, '.');
    if (!dot || strcmp(dot, ".glb") != 0) return 0;
    *id = strcmp(base, "norma-acid.glb") == 0 ? NULL : base;
    *length = (size_t)(dot - base);
    return 1;
}

/* The layout of the scenes that norma acid -o writes. */
static cli_parsed *built_in_layout(void) {
    const acid_grid grid = acid_grid_of(0, acid_cell_count);
    cli_memory_stream stream;
    cli_json_fault fault;
    cli_parsed *parsed = NULL;
    if (cli_memory_open(&stream)) {
        acid_write_layout(stream.out, &grid);
        if (cli_memory_close(&stream)) parsed = cli_json_parse(stream.text, stream.size, &fault);
        free(stream.text);
    }
    if (!parsed) cli_out_of_memory();
    return parsed;
}

static int is_schema(cli_value root) {
    const char *schema = cli_string(cli_get(root, "schema"));
    return schema && strcmp(schema, "norma-acid-scene/1") == 0;
}

static int read_layout(
    const acid_work *work, cli_value root, const char *id, size_t length, acid_layout *layout) {
    if (!is_schema(root)) return refuse_layout(work, "\"schema\"", "\"norma-acid-scene/1\"");
    return id ? read_alone(work, root, id, length, layout) : read_scene(work, root, layout);
}

/* Where things lie in the scene that was drawn: as a layout file has it, or as this program writes
 * scenes, of one cell where the scene is that cell's .glb. A status; CLI_OK: the caller frees
 * layout->rows. */
static int layout_of(const acid_work *work, acid_layout *layout) {
    const char *id = NULL;
    size_t length = 0;
    const int is_built_in = !work->scene || is_glb(work->scene, &id, &length);
    *layout = (acid_layout){0};
    cli_parsed *parsed = is_built_in ? built_in_layout()
                                     : check_load_json(work->scene, "the layout of an acid scene");
    if (work->scene) cli_guard_read(work->files.guard, work->scene);
    if (!parsed) return CLI_FILE;
    int status = read_layout(work, cli_json_root(parsed), id, length, layout);
    cli_json_free(parsed);
    if (status) {
        free(layout->rows);
        *layout = (acid_layout){0};
    }
    return status;
}

/* ---- the verdicts as text, as JSON, and as TAP */

static const char *const verdict_names[ACID_VERDICTS] = {
    "pass", "fail", "unclear", "missing", "skipped"};

static const char *const reason_words[] = {
    [ACID_REASON_CONTROL] = "the control failed, so nothing in this picture can be judged",
    [ACID_REASON_OUTSIDE] = "a patch lies outside the picture",
    [ACID_REASON_SMALL] = "patches have fewer than 8 pixels in a row; draw a larger picture",
    [ACID_REASON_NOT_DRAWN] = "the right reference is not drawn",
    [ACID_REASON_ALIKE] = "the references look alike in this picture",
    [ACID_REASON_BETWEEN] = "the nearest two references are about as near",
    [ACID_REASON_FAR] = "no reference is near",
    [ACID_REASON_HIDDEN] = "the subject is not drawn, or has the colour of what lies around it",
    [ACID_REASON_NO_RELIEF] =
        "scale-on-z looks much like no normal map at all, and tangent-sign does not show whether "
        "one is drawn",
    [ACID_REASON_ELSEWHERE] =
        "sign-kept, sign-lost and green-flipped look the same here, and tangent-sign, which tells "
        "them apart, is not judged or does not pass"};

/* The reference that a failure looks like; NULL: none. */
static const char *mistake_id(const acid_row *row, const acid_finding *finding) {
    return finding->verdict == ACID_FAIL && finding->nearest > 0
               ? row->references[finding->nearest].id
               : NULL;
}

/* What is known beside the verdict; NULL: nothing. */
static const char *verdict_words(const acid_row *row, const acid_finding *finding) {
    const char *id = mistake_id(row, finding);
    const acid_mistake *mistake = id ? acid_find_mistake(id) : NULL;
    if (mistake) return mistake->words;
    if (finding->verdict == ACID_MISSING) return "the subject is not drawn";
    if (finding->verdict == ACID_SKIPPED) return "an extension that it needs is missing";
    if (finding->verdict == ACID_FAIL && finding->reason == ACID_REASON_ALIKE)
        return "no shading is visible";
    if (finding->verdict == ACID_FAIL && finding->reason == ACID_REASON_FAR)
        return "the subject is not like its reference, although both are drawn the same way";
    return reason_words[finding->reason];
}

static int is_compared(const acid_finding *finding) {
    for (size_t i = 0; i < ACID_MOST_REFERENCES; ++i)
        if (finding->distances[i] > 0) return 1;
    return finding->verdict == ACID_PASS;
}

static void write_nearness(const acid_row *row, const acid_finding *finding) {
    if (finding->verdict != ACID_UNCLEAR || !is_compared(finding)) return;
    fputs(" (distances:", stdout);
    for (size_t i = 0; i < row->reference_count; ++i) {
        fputs(i ? ", " : " ", stdout);
        cli_write_outside(stdout, row->references[i].id);
        printf(" %.3f", finding->distances[i]);
    }
    fputc(')', stdout);
}

/* ---- for people */

static size_t longest_id(const acid_layout *layout) {
    size_t longest = 0;
    for (size_t i = 0; i < layout->row_count; ++i) {
        const size_t length = strlen(layout->rows[i].id);
        longest = length > longest ? length : longest;
    }
    return longest;
}

static void print_verdict(const acid_row *row, const acid_finding *finding, int width) {
    const char *words = verdict_words(row, finding), *id = mistake_id(row, finding);
    const acid_mistake *mistake = id ? acid_find_mistake(id) : NULL;
    printf("  %-8s ", verdict_names[finding->verdict]);
    cli_write_outside(stdout, row->id);
    if (words || id) printf("%*s", width - (int)strlen(row->id) + 2, "");
    if (id) {
        cli_write_outside(stdout, id);
        if (words) fputs(": ", stdout);
    }
    if (words) fputs(words, stdout);
    write_nearness(row, finding);
    if (mistake) printf("\n%*smend: %s", width + 13, "", mistake->mend);
    fputc('\n', stdout);
}

static void print_verdicts_text(
    const acid_work *work, const acid_layout *layout, const acid_judgement *found) {
    cli_write_outside(stdout, work->judge);
    for (int i = 0; i < ACID_VERDICTS; ++i)
        if (i <= ACID_FAIL || found->counts[i])
            printf("%s %zu %s", i ? "," : ":", found->counts[i], verdict_names[i]);
    fputc('\n', stdout);
    for (size_t i = 0; i < layout->row_count; ++i)
        print_verdict(&layout->rows[i], &found->findings[i], (int)longest_id(layout));
}

/* ---- for programs */

static void print_cell_json(cli_json *json, const acid_row *row, const acid_finding *finding) {
    cli_json_print(json, "{id: %s, verdict: %s, mistake: %s, distances: {", row->id,
        verdict_names[finding->verdict], mistake_id(row, finding));
    for (size_t i = 0; i < row->reference_count && is_compared(finding); ++i)
        cli_json_number(json, row->references[i].id, finding->distances[i]);
    cli_json_print(json, "}, reason: %s}", verdict_words(row, finding));
}

static void print_verdicts_json(
    const acid_work *work, const acid_layout *layout, const acid_judgement *found) {
    cli_json json = {.out = stdout};
    cli_json_print(&json, "{schema: %s, image: %s, cells: [", "norma-acid/1", work->judge);
    for (size_t i = 0; i < layout->row_count; ++i)
        print_cell_json(&json, &layout->rows[i], &found->findings[i]);
    cli_json_print(&json, "], summary: {");
    for (int i = 0; i < ACID_VERDICTS; ++i)
        cli_json_size(&json, verdict_names[i], found->counts[i]);
    cli_json_print(&json, "}}\n");
}

/* Test Anything Protocol, version 12. */
static void print_verdicts_tap(const acid_layout *layout, const acid_judgement *found) {
    printf("1..%zu\n", layout->row_count);
    for (size_t i = 0; i < layout->row_count; ++i) {
        const acid_row *row = &layout->rows[i];
        const acid_finding *finding = &found->findings[i];
        const char *words = verdict_words(row, finding), *id = mistake_id(row, finding);
        const int is_fine = finding->verdict == ACID_PASS || finding->verdict == ACID_SKIPPED;
        printf("%sok %zu - ", is_fine ? "" : "not ", i + 1);
        cli_write_outside(stdout, row->id);
        if (finding->verdict == ACID_SKIPPED) fputs(" # SKIP", stdout);
        if (!is_fine) printf(": %s", verdict_names[finding->verdict]);
        if (id) fputs(", ", stdout);
        if (id) cli_write_outside(stdout, id);
        fputc('\n', stdout);
        if (!is_fine && words) printf("# %s\n", words);
    }
}

/* ---- one screenshot, from its file to an exit status */

static int read_shot(const acid_work *work, acid_picture *picture) {
    size_t size;
    char *bytes = check_read_bytes(work->judge, &size);
    if (!bytes) return CLI_FILE;
    cli_guard_read(work->files.guard, work->judge);
    const image_result result = acid_read_picture((const unsigned char *)bytes, size, picture);
    free(bytes);
    if (!result) return CLI_OK;
    if (result == IMAGE_MEMORY) return cli_out_of_memory();
    cli_error("%s: cannot be read as a picture: %s", work->judge, norma_image_text(result));
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
        print_verdicts_json(work, layout, found);
    else if (work->tap)
        print_verdicts_tap(layout, found);
    else if (!work->common.quiet)
        print_verdicts_text(work, layout, found);
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

static int judge_shot(const cli_subcommand *command, const acid_work *work) {
    acid_picture picture = {0};
    acid_layout layout;
    if (work->common.json && work->tap)
        return cli_usage(command, "--json and --tap exclude each other");
    if (work->output && cli_is_standard(work->output) && (work->common.json || work->tap))
        return cli_usage(command, "standard output can have the picture or the verdicts, not both");
    int status = layout_of(work, &layout);
    if (!status) status = read_shot(work, &picture);
    if (!status) status = judge_picture(work, &picture, &layout);
    free(picture.pixels);
    free(layout.rows);
    return status;
}

/* ---- the command */

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
    return judge_shot(command, work);
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
