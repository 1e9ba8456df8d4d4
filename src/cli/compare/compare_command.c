/* compare_command.c: norma compare: by how much the normals of one file differ from another's. */
#define _POSIX_C_SOURCE 200809L
#include "cli/compare/compare.h"
#include "cli/render/render.h"
#include "compare/compare_scene.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char compare_help_text[] =
    "norma compare BASE OTHER: by how many degrees the normals of OTHER differ from BASE\n"
    "\n"
    "Examples\n"
    "  norma compare chair.obj chair-lod2.glb         a level of detail, or another exporter\n"
    "  norma compare scan.ply small.ply --max 5       status 1 if any normal is off by more than "
    "5 degrees\n"
    "  norma compare a.glb b.glb --max 5 --share 0.01 allows that on 1 % of the area\n"
    "  norma compare reference/ built/ --max 5        each file of built with the one of the same "
    "path in reference\n"
    "\n"
    "Options\n"
    "  -o, --output OUT.png|OUT.html\n"
    "                        OTHER drawn from two sides, its colours the angles; HTML: with what "
    "is "
    "printed\n"
    "  --max DEG             exit status 1 if the normals of some of the area are off by more\n"
    "  --share PART          the part of the area that may be, from 0 to 1 (0); needs --max\n"
    "  --input-format " CLI_FORMATS "\n"
    "                        the format of standard input; needed if a file is -\n"
    "  --threads N           uses at most N threads (all processors), with the same result\n"
    "  --max-memory SIZE     uses at most SIZE (512M, 2G)\n"
    "  --json                prints JSON to standard output\n"
    "  --quiet               prints nothing about the files but errors\n"
    "\n"
    "If both have the same faces in the same order, each corner is compared with its counterpart. "
    "Otherwise\n"
    "each corner of OTHER is compared with the nearest point of BASE, where the normals of BASE "
    "are\n"
    "interpolated; at a crease, with the side that faces as its own face does. Files are compared "
    "as they are\n"
    "drawn at rest: node transforms, skins and morph targets are applied. In a glTF, a mesh is "
    "compared with\n"
    "the mesh of the same name, if BASE has one. Missing normals are computed first, as norma "
    "compute does.\n"
    "Percentiles and shares are of area. Distances are in the units of the files.\n"
    "Exit status: 0 fine, 1 normals are off by more than --max, 2 wrong usage, 3 a file could not "
    "be read,\n"
    "130 interrupted.\n";

enum { MOST_WORST = 5 };

typedef struct worst_place {
    size_t corner, face; /* of other: the corner among all, the face within its piece */
    const compared_piece *piece;
    double position[3], normal[3], base_normal[3];
} worst_place;

typedef struct compare_work {
    cli_common common;
    cli_files files;
    compare_limits limits;
    const char *output, *base, *names[2]; /* base: a folder; names: BASE and OTHER */
    FILE *out;
    compared_pair pair;
    norma_document *documents[2];
    void *memory[2]; /* what standard input held */
    worst_place places[MOST_WORST];
    size_t place_count;
} compare_work;

const cli_option compare_limit_options[] = {
    {"max", CLI_TO(CLI_RADIANS, compare_limits, max_rad), .most = 180,
        .expected = "degrees from 0 to 180", CLI_GIVEN(compare_limits, given, COMPARE_MAX)},
    {"share", CLI_TO(CLI_DOUBLE, compare_limits, share), .most = 1,
        .expected = "a part from 0 to 1", CLI_GIVEN(compare_limits, given, COMPARE_SHARE)},
};
const size_t compare_limit_option_count = CLI_COUNT(compare_limit_options);

static const cli_option compare_options[] = {
    {"output", 'o', CLI_TO(CLI_TEXT, compare_work, output), .expected = "a file"},
};

static norma_document_result open_compared(
    compare_work *work, const cli_files *files, int which, norma_document_error *error) {
    static const norma_document_options reading = {.struct_size = 0};
    compared_scene *scene = which ? &work->pair.other : &work->pair.base;
    const char *input = work->names[which];
    norma_document_result result = cli_read(files, &work->common, input, &reading,
        &work->documents[which], &work->memory[which], error);
    *scene = (compared_scene){.name = cli_input_name(input)};
    if (!result)
        result = compared_scene_make(
            work->documents[which], scene->name, work->common.threads, scene, error);
    return result || scene->count ? result
                                  : cli_fail_empty(scene->document, input, "compare", error);
}

static norma_document_result compare_files(compare_work *work, norma_document_error *error) {
    cli_progress progress;
    const norma_options options = {.struct_size = sizeof options,
        .threads = work->common.threads,
        .progress = cli_progress_elapsed,
        .progress_user = &progress};
    const int standard = strcmp(work->names[0], "-") == 0 || strcmp(work->names[1], "-") == 0;
    norma_document_result result = NORMA_DOCUMENT_OK;
    work->pair = (compared_pair){.corners = 0};
    for (int i = 0; i < 2 && !result; ++i) {
        cli_files files = work->files;
        if (standard && strcmp(work->names[i], "-") != 0) files.format = NORMA_FILE_UNKNOWN;
        result = open_compared(work, &files, i, error);
    }
    if (result) return error->result = result;
    cli_progress_start(&progress, "comparing", work->names[1], work->common.quiet, 0);
    result = compared_pair_measure(&work->pair, work->limits.max_rad, &options, error);
    cli_progress_stop(&progress);
    return result;
}

/* ---- the worst places */

static void describe_place(const compare_work *work, size_t corner, worst_place *place) {
    const compared_scene *scene = &work->pair.other;
    const compared_piece *piece = scene->pieces;
    while (corner - piece->first_corner >= piece->corners) ++piece;
    size_t face = 0, end = piece->first_corner;
    while ((end += scene->sizes[piece->first_face + face]) <= corner) ++face;
    *place = (worst_place){.corner = corner, .face = face, .piece = piece};
    const size_t position = piece->first_position + scene->corners[corner];
    const uint32_t number = scene->numbers[corner];
    memcpy(place->position, scene->positions + 3 * position, sizeof place->position);
    for (size_t k = 0; k < 3; ++k) {
        if (number != UINT32_MAX)
            place->normal[k] = (double)scene->normals[3 * (piece->first_normal + number) + k];
        place->base_normal[k] = (double)work->pair.samples[corner].normal[k];
    }
}

static double apart(const double a[3], const double b[3]) {
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

static double size_of_base(const compared_scene *scene) {
    const compared_piece *last = &scene->pieces[scene->count - 1];
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < 3 * (last->first_position + last->positions); ++i) {
        low[i % 3] = fmin(low[i % 3], scene->positions[i]);
        high[i % 3] = fmax(high[i % 3], scene->positions[i]);
    }
    return apart(low, high);
}

/* One after the other the worst corner that is not near one before: a twentieth of the size of
 * BASE. */
static void find_worst(compare_work *work) {
    const compared_scene *scene = &work->pair.other;
    const double near = size_of_base(&work->pair.base) / 20;
    work->place_count = 0; /* those of the pair before are gone */
    for (size_t count = 0; count < MOST_WORST; work->place_count = ++count) {
        const norma_compare_sample *worst = NULL;
        for (const compared_piece *p = scene->pieces; p < scene->pieces + scene->count; ++p)
            for (size_t i = p->first_corner; i < p->first_corner + p->corners; ++i) {
                const norma_compare_sample *s = &work->pair.samples[i];
                const double *at = scene->positions + 3 * (p->first_position + scene->corners[i]);
                size_t k = 0;
                if (!(s->area > 0) || !(s->angle_rad > 2e-5f)) continue; /* 0.001 degrees */
                if (worst && s->angle_rad <= worst->angle_rad) continue;
                while (k < count && apart(at, work->places[k].position) > near) ++k;
                if (k == count) worst = s;
            }
        if (!worst) break;
        describe_place(work, (size_t)(worst - work->pair.samples), &work->places[count]);
    }
}

/* ---- for programs */

static void write_comparison(
    cli_json *json, const compare_work *work, const norma_comparison *sum) {
    cli_json_print(json,
        "corners: %zu, missing: %zu, normals: {p50_deg: %g, p99_deg: %g, max_deg: %g}, "
        "distances: {p50: %g, p99: %g, max: %g}, share_above: %g",
        sum->corners, sum->missing, cli_to_degrees(sum->p50_rad), cli_to_degrees(sum->p99_rad),
        cli_to_degrees(sum->max_rad), sum->p50_distance, sum->p99_distance, sum->max_distance,
        work->limits.given & COMPARE_MAX ? sum->share_above : NAN);
}

static void write_groups(cli_json *json, const compare_work *work) {
    cli_json_open(json, "meshes", '[');
    for (size_t i = 0; i < work->pair.group_count; ++i) {
        const compared_group *group = &work->pair.groups[i];
        cli_json_print(json, "{name: %s, same_name: %d, compared: %s",
            work->pair.other.pieces[group->first].name, group->named,
            group->same_faces ? "corners" : "nearest");
        write_comparison(json, work, &group->sum);
        cli_json_close(json, '}');
    }
    cli_json_close(json, ']');
}

static void write_worst_places(cli_json *json, const compare_work *work) {
    const worst_place *places = work->places;
    cli_json_open(json, "worst", '[');
    for (size_t i = 0; i < work->place_count; ++i) {
        const norma_compare_sample *s = &work->pair.samples[places[i].corner];
        norma_mesh_info info = {.where = ""};
        norma_document_mesh_info(work->pair.other.document, places[i].piece->mesh, &info);
        cli_json_print(json, "{angle_deg: %g, distance: %g", cli_to_degrees((double)s->angle_rad),
            s->distance < 0 ? NAN : (double)s->distance);
        cli_json_numbers(json, "position", places[i].position, 3);
        cli_json_numbers(json, "normal", places[i].normal, 3);
        cli_json_numbers(json, "base_normal", places[i].base_normal, 3);
        cli_json_print(json, "mesh: %s, where: %s, face: %zu}", places[i].piece->name, info.where,
            places[i].face);
    }
    cli_json_close(json, ']');
}

static int passes_gate(const compare_work *work) {
    return !(work->limits.given & COMPARE_MAX) ||
           work->pair.all.share_above <= work->limits.share + 1e-9;
}

static void write_compare_json(const compare_work *work, const char *error) {
    cli_json json = {.out = work->out};
    cli_json_print(&json, "{base: %s, other: %s", work->names[0], work->names[1]);
    if (error) {
        cli_json_string(&json, "error", error);
    } else {
        const int is_limited = (work->limits.given & COMPARE_MAX) != 0;
        cli_json_print(&json, "compared: %s, max_deg: %g, share: %g", compared_way(&work->pair),
            is_limited ? cli_given_degrees(work->limits.max_rad) : NAN,
            is_limited ? work->limits.share : NAN);
        write_comparison(&json, work, &work->pair.all);
        cli_json_print(&json, "ok: %d, base_computed: %d, other_computed: %d", passes_gate(work),
            work->pair.base.computed, work->pair.other.computed);
        write_groups(&json, work);
        write_worst_places(&json, work);
        if (work->output) cli_json_string(&json, "output", work->output);
        cli_json_notes(&json, work->pair.other.document);
    }
    cli_json_close(&json, '}');
}

/* ---- for people */

static void print_percentiles(FILE *out, const char *what, double p50, double p99, double most) {
    fprintf(out, "  %-10s p50 %.4g, p99 %.4g, at most %.4g\n", what, p50, p99, most);
}

static double shown_degrees(double radians) { return rint(cli_to_degrees(radians) * 1e4) / 1e4; }

static void print_vector(FILE *out, const char *before, const double v[3]) {
    fprintf(out, "%s(%.4g, %.4g, %.4g)", before, v[0] + 0.0, v[1] + 0.0, v[2] + 0.0);
}

static void print_place(const compare_work *work, FILE *out, const worst_place *place) {
    fprintf(out, "  %.4g degrees at ",
        shown_degrees((double)work->pair.samples[place->corner].angle_rad));
    print_vector(out, "", place->position);
    fprintf(out, ", face %zu", place->face);
    if (place->piece->name[0]) {
        fputs(" of \"", out);
        cli_write_outside(out, place->piece->name);
        fputc('"', out);
    }
    print_vector(out, ": ", place->normal);
    print_vector(out, " instead of ", place->base_normal);
    fputc('\n', out);
}

static void print_comparison(const compare_work *work, FILE *out) {
    const norma_comparison *all = &work->pair.all;
    const char *way = compared_way(&work->pair);
    char max[32], share[32], allowed[32];
    cli_say(out, "%s against %s: ", work->pair.other.name, work->pair.base.name);
    cli_counted(out, all->corners, "corner", "corners");
    fputs(way[0] == 'c' ? ", each with its counterpart: the faces are the same\n"
          : way[0] == 'm'
              ? ", with their counterparts in meshes of the same faces, others with the "
                "nearest points"
              : ", each with the nearest point\n",
        out);
    print_percentiles(out, "degrees", shown_degrees(all->p50_rad), shown_degrees(all->p99_rad),
        shown_degrees(all->max_rad));
    print_percentiles(out, "distances", all->p50_distance, all->p99_distance, all->max_distance);
    for (size_t i = 0; i < work->place_count; ++i) print_place(work, out, &work->places[i]);
    if (all->missing) {
        fputs("  ", out);
        cli_counted(out, all->missing, "corner", "corners");
        fputs(" without a normal, which count as above --max\n", out);
    }
    if (work->limits.given & COMPARE_MAX)
        fprintf(out, "  %s: %s %% of the area is above %s degrees, %s %% may be\n",
            passes_gate(work) ? "fine" : "too far off",
            cli_decimals(share, 100 * all->share_above, 4),
            cli_decimals(max, cli_given_degrees(work->limits.max_rad), 6),
            cli_decimals(allowed, 100 * work->limits.share, 4));
}

static void print_computed(const compare_work *work, const compared_scene *scene) {
    if (scene->computed && !work->common.quiet)
        cli_error("%s: note: some normals were missing and were computed, as " NORMA_PROGRAM
                  " compute does",
            scene->name);
}

/* ---- a picture, or a page with it */

static int write_page(FILE *out, const compare_work *work, const render_png *png) {
    cli_memory_stream words;
    if (!cli_memory_open(&words)) return cli_out_of_memory();
    print_comparison(work, words.out);
    if (!cli_memory_close(&words)) return cli_out_of_memory();
    fputs(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
        "content=\"width=device-width,initial-scale=1\">\n<title>norma compare</title>\n<style>"
        ":root{color-scheme:light dark}body{font:16px/1.5 system-ui,sans-serif;max-width:64rem;"
        "margin:0 auto;padding:1rem}img{max-width:100%;height:auto}pre{white-space:pre-wrap;"
        "overflow-wrap:anywhere}</style></head><body>\n<main><h1>norma compare</h1>\n<pre>",
        out);
    for (char *line = words.text; *line;) { /* a line end is none of what is escaped */
        char *end = line + strcspn(line, "\n");
        const char ended = *end;
        *end = '\0';
        cli_write_outside_html(out, line);
        fputc('\n', out);
        line = end + (ended == '\n');
    }
    fputs(
        "</pre>\n<img alt=\"The second model from two sides: its colours are the angles, dots the "
        "worst places\" src=\"data:image/png;base64,",
        out);
    cli_write_base64(out, png->bytes, png->size);
    fputs("\"></main></body></html>\n", out);
    free(words.text);
    return CLI_OK;
}

static int write_output(const compare_work *work) {
    render_dot dots[MOST_WORST];
    render_png png = {.bytes = NULL};
    cli_output output;
    cli_progress progress;
    for (size_t i = 0; i < work->place_count; ++i) {
        dots[i] = (render_dot){.colour = 0xD01C1C, .vertex = SIZE_MAX, .face = SIZE_MAX};
        memcpy(dots[i].position, work->places[i].position, sizeof dots[i].position);
    }
    cli_progress_start(&progress, "drawing", work->output, work->common.quiet, 0);
    cli_progress_tick(&progress);
    int status = render_compared(&work->pair, dots, work->place_count, &png);
    cli_progress_stop(&progress);
    if (!status) status = cli_output_begin(&output, work->output, work->files.guard);
    if (!status) {
        if (cli_ends_in(work->output, ".html"))
            status = write_page(output.out, work, &png);
        else
            fwrite(png.bytes, 1, png.size, output.out);
        if (status)
            cli_output_drop(&output);
        else
            status = cli_output_end(&output);
    }
    free(png.bytes);
    return status;
}

/* A usage, or an output that is one of the inputs: a status. */
static int check_drawing(const cli_subcommand *command, compare_work *work) {
    const cli_words *words = &work->files.words;
    if (cli_is_folder(words->words[0]) && cli_is_folder(words->words[1]))
        return cli_usage(command, "one -o for two folders; expected two files");
    if (cli_is_standard(work->output)) {
        work->out = stderr;
        if (work->common.json)
            return cli_usage(command, "-o - and --json would both write to standard output");
        return isatty(STDOUT_FILENO) ? cli_usage(command, "standard output is a terminal, which "
                                                          "shows no picture; expected -o OUT.png, "
                                                          "or a pipe")
                                     : CLI_OK;
    }
    if (!cli_ends_in(work->output, ".html") && !cli_ends_in(work->output, ".png") &&
        !cli_is_stream(work->output))
        return cli_usage(
            command, "-o %s: expected a name that ends in .png or .html", work->output);
    for (size_t i = 0; i < words->count; ++i) cli_guard_read(work->files.guard, words->words[i]);
    return cli_guard_output(work->files.guard, work->output, NULL);
}

/* ---- a pair */

/* Compares work->names and writes what comes of it to work->out and work->output. A status; error:
 * why there is nothing. */
static int compare_into(compare_work *work, norma_document_error *error) {
    const norma_document_result result = compare_files(work, error);
    int status = cli_status_of(result), lost = CLI_OK; /* lost: why there is no work->output */
    if (!result) {
        find_worst(work);
        if (work->output) lost = write_output(work);
        status = cli_worse(passes_gate(work) ? CLI_OK : CLI_FINDINGS, lost);
    }
    if (lost) /* which was printed */
        snprintf(error->message, sizeof error->message, "%.500s: was not written", work->output);
    if (result) cli_name_error(error, work->names[work->pair.other.name != NULL]);
    if (work->common.json)
        write_compare_json(work, result || lost ? error->message : NULL);
    else if (!result)
        print_comparison(work, work->out);
    if (work->output && status < CLI_USAGE && !work->common.json) {
        cli_say(work->out, "  drawn in %s",
            cli_is_standard(work->output) ? "standard output" : work->output);
        fputc('\n', work->out);
    }
    compared_pair_close(&work->pair);
    for (int i = 0; i < 2; ++i) {
        norma_document_close(work->documents[i]);
        free(work->memory[i]);
        work->documents[i] = NULL;
        work->memory[i] = NULL;
    }
    return status;
}

int compare_pair(const cli_files *files, const cli_common *common, const compare_limits *limits,
    const char *const names[2], FILE *out, norma_document_error *error) {
    compare_work work = {.common = *common,
        .files = *files,
        .limits = *limits,
        .names = {names[0], names[1]},
        .out = out};
    return compare_into(&work, error);
}

static int compare_and_report(compare_work *work) {
    norma_document_error error = {0};
    const int status = compare_into(work, &error);
    if (error.result) {
        cli_print_error(&error);
    } else {
        print_computed(work, &work->pair.base);
        print_computed(work, &work->pair.other);
    }
    if (work->common.json) fputc('\n', stdout);
    fflush(stdout);
    return status;
}

/* ---- folders: each file of OTHER with the file of the same path in BASE */

/* NULL: no memory. To be freed once the pair is done with. */
static char *name_pair(compare_work *work, size_t file) {
    const cli_inputs *inputs = &work->files.inputs;
    char *counterpart = cli_join(work->base, inputs->list[file].path + inputs->list[file].within);
    work->names[0] = counterpart;
    work->names[1] = inputs->list[file].path;
    return counterpart;
}

static int compare_one(void *user, size_t file) {
    char *counterpart = name_pair(user, file);
    const int status = counterpart ? compare_and_report(user) : cli_out_of_memory();
    free(counterpart);
    return status;
}

static void report_lost_pair(void *user, size_t file, int worker, const char *why) {
    (void)worker;
    compare_work *work = user;
    norma_document_error error;
    char *counterpart = name_pair(work, file);
    cli_lost_error(&error, work->names[1], why);
    cli_print_error(&error);
    if (work->common.json && counterpart) {
        write_compare_json(work, error.message);
        fputc('\n', stdout);
    }
    free(counterpart);
}

static int compare_folders(const cli_subcommand *command, compare_work *work, const char *other) {
    work->files.words = (cli_words){&other, 1};
    const int status = cli_find_inputs(command, &work->files);
    const cli_each each = {
        work->files.inputs.count, compare_one, report_lost_pair, work, work->files.guard};
    return status == CLI_USAGE ? status : cli_worse(status, cli_run_each(&each));
}

/* ---- the command */

static int compare_run(const cli_subcommand *command, int count, char **arguments) {
    compare_work work = {.common = {.threads = NORMA_ALL_THREADS}, .out = stdout};
    const cli_table tables[] = {
        {compare_options, CLI_COUNT(compare_options), &work},
        {compare_limit_options, compare_limit_option_count, &work.limits},
        {cli_input_options, cli_input_option_count, &work.files},
        {cli_common_options, cli_common_option_count, &work.common},
    };
    int status = cli_read_files(command, &work.files, tables, CLI_COUNT(tables), count, arguments);
    if (status) return status;
    const cli_words given = work.files.words, *words = &given;
    if (words->count != 2)
        status = cli_usage(
            command, "expected two files or two folders, BASE and OTHER, not %zu", words->count);
    else if (strcmp(words->words[0], "-") == 0 && strcmp(words->words[1], "-") == 0)
        status = cli_usage(command, "only one of the two files can be standard input");
    else if (work.limits.given == COMPARE_SHARE)
        status = cli_usage(command, "--share needs --max");
    else if (work.output)
        status = check_drawing(command, &work);
    if (!status && cli_is_folder(words->words[0]) && cli_is_folder(words->words[1])) {
        work.base = words->words[0];
        status = compare_folders(command, &work, words->words[1]);
    } else if (!status) {
        memcpy((void *)work.names, (const void *)words->words, sizeof work.names);
        status = compare_and_report(&work);
    }
    work.files.words = given;
    cli_files_end(&work.files);
    return cli_finish(status);
}

const cli_subcommand cli_subcommand_compare = {"compare",
    "measures by how much the normals of two files differ", compare_help_text, compare_run};
