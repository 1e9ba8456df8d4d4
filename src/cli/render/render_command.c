/* render_command.c: norma render: pictures of files. */
#define _POSIX_C_SOURCE 200809L
#include "cli/render/render.h"
#include "cli/process/process.h"
#include "cli/files/files.h"
#include "cli/text/text.h"
#include "compare/compare_scene.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- A graphics driver that gets no memory may end the program instead of saying so.
 * Under --max-memory what it ends by is caught, and the limit is named. Nothing is half-written
 * then: a picture has no name before it is whole. */

#if !defined(_WIN32)
#include <signal.h>
#include <unistd.h>

static char driver_failed[CLI_LIMIT_ROOM + 192];

static void catch_driver(int number) {
    (void)number;
    const ssize_t written = write(STDERR_FILENO, driver_failed, strlen(driver_failed));
    (void)written;
    _exit(CLI_FILE);
}

/* Under --max-memory a driver that ends the program for want of memory is told of,
 * with status 3. */
static void render_watch_driver(void) {
    char limit[CLI_LIMIT_ROOM];
    cli_memory_limit_words(limit);
    if (!limit[0]) return;
    snprintf(driver_failed, sizeof driver_failed,
        "norma: the graphics driver ended because memory ran out%s" RENDER_DRIVER_NEEDS "\n",
        limit);
    struct sigaction action = {.sa_handler = catch_driver};
    sigemptyset(&action.sa_mask);
    sigaction(SIGSEGV, &action, NULL);
    sigaction(SIGABRT, &action, NULL);
}
#else
static void render_watch_driver(void) {}
#endif

/* ---- Norma render: pictures of meshes, drawn without a display. */

static const char render_help[] =
    "norma render IN -o OUT.png: draws a picture of a mesh, without a display\n"
    "\n"
    "Examples\n"
    "  norma render chair.glb -o chair.png\n"
    "  norma render chair.glb -o wrong.png --compare --scale 2,0.5,1\n"
    "                        normals under M itself beside right ones, with the largest error\n"
    "  norma render chair.obj -o creases.png --compare=30,60,180\n"
    "  norma render chair.glb -o findings.png --show findings --select N3\n"
    "  norma render *.glb --out-dir pictures\n"
    "\n"
    "What is drawn\n"
    "  --shading flat|gouraud|phong\n"
    "                        lights each face (flat), each vertex (gouraud) or each pixel (phong, "
    "the default)\n"
    "  --show LIST           one of: normals (as colours), winding (front green, back red), error "
    "(of stored\n"
    "                        normals), findings (of norma check), matcap, zebra (stripes), "
    "tangents (as\n"
    "                        colours). Over it, or alone: hedgehog (normals as lines), wireframe\n"
    "  --select RULES        shows only findings of these rules, as for norma check\n"
    "  --clay                no vertex colours, maps or masks; the default for --compare, error\n"
    "                        and findings, unless --clay=no\n"
    "  --lines LIST          lines of a hedgehog at vertices, faces, edges (vertices,faces)\n"
    "  --line-length N       their length, as a multiple of nearby edges (0.7)\n"
    "  --line-width PIXELS   the width of lines (1.6)\n"
    "  --most-lines N        at most N lines at vertices, as many at faces, edges (4000)\n"
    "  --error-top DEG       top of the colour scale for errors (what 99 of 100 do not exceed)\n"
    "\n"
    "Side by side\n"
    "  --compare             shows normals under M itself (--scale etc., the file's) beside right "
    "ones\n"
    "  --compare=LIST        a panel for each shading (flat,phong), transform of normals "
    "(before,plain,\n"
    "                        right), weight (angle,area) or crease (30,60,180)\n"
    "  --label WORDS         text above the first panel; repeat it for the next\n"
    "\n"
    "Normals\n"
    "  --normals stored|computed\n"
    "                        computes missing normals (stored), or all (computed)\n"
    "  --weight, --crease    as for norma compute; without --crease, a glTF without normals is "
    "flat\n"
    "  --space view|world    the space in which light is computed (world); the picture is the "
    "same\n"
    "\n"
    "Camera and light, in degrees\n"
    "  --camera AZIMUTH,ELEVATION\n"
    "                        0,0 is the front, 90,0 the right side, 0,90 above (35,22)\n"
    "  --fov DEG             the angle of view (28); 0 is orthographic\n"
    "  --up x|y|z|-x|-y|-z   the upward axis: y in glTF; guessed in other formats\n"
    "  --light AZIMUTH,ELEVATION[,STRENGTH]\n"
    "                        a light seen from the camera, up to four (-30,50,0.78 and 75,5,0.34)\n"
    "  --phong AMBIENT,DIFFUSE,SPECULAR,EXPONENT\n"
    "                        Phong's model (0.09,0.9,0.07,25)\n"
    "\n"
    "The picture\n"
    "  --size WIDTHxHEIGHT   the size of each panel in pixels (512x512)\n"
    "  --samples N           N times N samples in each pixel, 1 to 4 (2)\n"
    "  --background paper|white|black|grey|transparent|#RRGGBB\n"
    "  --renderer auto|software\n"
    "                        the GPU if there is one (auto), or Mesa's software renderer\n"
    "\n" CLI_MATRIX_HELP "\n"
    "Files\n"
    "  -o, --output OUT.png  the picture; - is standard output, unless that is a terminal\n"
    "  --out-dir FOLDER      for several inputs: writes FOLDER/NAME.png\n" CLI_INPUT_FORMAT_HELP
    "  --threads, --max-memory, --json, --quiet\n"
    "                        as for norma compute\n"
    "\n"
    "Exit status: 0 fine, 2 wrong usage, 3 a file could not be read or written, or no renderer "
    "starts.\n";

/* ---- one picture */

typedef struct picture_job {
    const render_settings *settings;
    render_device *device;
    int has_no_device; /* it could not be opened */
    const char *input;
    size_t index; /* of the input */
    char *output;
    render_plan plan;
    render_sheet sheet;
    size_t width, height;
} picture_job;

int render_fail_drawing(const char *input, const render_error *error) {
    char limit[CLI_LIMIT_ROOM];
    cli_memory_limit_words(limit);
    const int memory = error->result == RENDER_ERROR_MEMORY || strstr(error->message, "memory");
    cli_error("%s: %s%s%s", cli_input_name(input), error->message, memory ? limit : "",
        memory && limit[0] ? RENDER_DRIVER_NEEDS : "");
    return error->result == RENDER_ERROR_ARGUMENT ? CLI_USAGE : CLI_FILE;
}

static int write_png(picture_job *job, const render_picture *picture) {
    cli_output output;
    render_png png;
    render_error error = {.result = RENDER_OK};
    if (render_png_encode(picture, &png, &error)) return render_fail_drawing(job->input, &error);
    int status = cli_make_folders(&job->settings->files, job->output);
    if (!status) status = cli_output_begin(&output, job->output, job->settings->files.guard);
    if (!status) {
        const size_t written = fwrite(png.bytes, 1, png.size, output.out);
        status = cli_output_end(&output);
        if (!status && written != png.size) status = cli_out_of_memory();
    }
    free(png.bytes);
    return status;
}

static int draw_picture(picture_job *job) {
    render_picture picture;
    render_error error;
    job->sheet = (render_sheet){.panels = job->plan.panels, .panel_count = job->plan.count};
    render_plan_legend(&job->plan, &job->sheet);
    job->plan.difference = -1;
    job->sheet.below = job->settings->show == RENDER_SHOW_ERROR ||
                               (job->settings->compare == 2 && job->plan.count == 2)
                           ? ""
                           : NULL;
    cli_progress progress;
    cli_progress_start(&progress, "drawing", job->output, job->settings->common.quiet, 0);
    cli_progress_tick(&progress);
    const int failed = render_sheet_draw(job->device, &job->settings->look, &job->sheet,
                           render_plan_tell, &job->plan, &picture, &error) != RENDER_OK;
    cli_progress_stop(&progress);
    if (failed) return render_fail_drawing(job->input, &error);
    job->width = picture.width;
    job->height = picture.height;
    int status = write_png(job, &picture);
    render_picture_free(&picture);
    return status;
}

/* ---- telling */

/* Of plain M, or of the stored normals; NaN: neither was asked for. */
static double worst_error(const picture_job *job) {
    double worst = NAN;
    for (size_t i = 0; i < job->plan.count; ++i) {
        const render_panel *panel = &job->plan.panels[i];
        worst = fmax(worst, panel->measured                    ? panel->worst_plain_rad
                            : panel->show == RENDER_SHOW_ERROR ? panel->worst_error_rad
                                                               : NAN);
    }
    return cli_to_degrees(worst);
}

static void notes_json(cli_json *json, const picture_job *job) {
    cli_json_open(json, "notes", '[');
    for (size_t i = 0; i < norma_document_note_count(job->plan.file->document); ++i)
        cli_json_string(json, NULL, norma_document_note(job->plan.file->document, i));
    for (size_t i = 0; i < job->plan.file->note_count; ++i)
        cli_json_string(json, NULL, job->plan.file->notes[i]);
    cli_json_close(json, ']');
}

static void report_picture_json(const picture_job *job) {
    cli_json json = {.out = stdout};
    cli_json_print(&json,
        "{input: %s, output: %s, width: %zu, height: %zu, panels: %zu, triangles: %zu, "
        "renderer: %s, worst_error_deg: %g, largest_difference: %zd, lines_left_out: %zu, up: %s, "
        "up_guessed: %d, not_drawn: %s",
        job->input, job->output, job->width, job->height, job->plan.count,
        job->plan.panels[0].triangles, render_device_name(job->device), worst_error(job),
        job->plan.difference < 0 ? SIZE_MAX : (size_t)job->plan.difference,
        job->sheet.lines_left_out, render_up_name(job->plan.file->up), job->plan.file->up_guessed,
        job->plan.left_out);
    /* of the first panel */
    cli_json_numbers(&json, "world_to_clip", job->plan.panels[0].world_to_clip, 16);
    notes_json(&json, job);
    cli_json_close(&json, '}');
    fputc('\n', stdout);
}

static void print_notes(const render_scene_file *file) {
    cli_print_notes(file->input, file->document);
    for (size_t i = 0; i < file->note_count; ++i)
        cli_error("%s: note: %s", cli_input_name(file->input), file->notes[i]);
}

static void report_text(const picture_job *job) {
    FILE *out = cli_is_standard(job->output) ? stderr : stdout;
    const double worst = worst_error(job);
    char number[32];
    cli_say(out, "%s -> %s: ", cli_input_name(job->input),
        cli_is_standard(job->output) ? "standard output" : job->output);
    cli_counted(out, job->plan.panels[0].triangles, "triangle", "triangles");
    fprintf(out, ", %zux%zu", job->width, job->height);
    if (isfinite(worst) && job->settings->compare)
        fprintf(out, ", plain M errs by up to %s degrees", cli_decimals(number, worst, 2));
    else if (isfinite(worst))
        fprintf(out, ", stored normals differ from computed ones by up to %s degrees",
            cli_decimals(number, worst, 2));
    else if (job->settings->show == RENDER_SHOW_ERROR && !job->settings->compare)
        fputs(", no normals are stored: there is nothing to compare", out);
    if (job->plan.difference >= 0)
        fprintf(out, ", the two differ by up to %d of 255 levels", job->plan.difference);
    if (job->sheet.lines_left_out) {
        fputs(", ", out);
        cli_count(out, job->sheet.lines_left_out);
        fputs(" lines left out (--most-lines)", out);
    }
    if (job->plan.file->up_guessed)
        fprintf(out, "; guessed that %s is up (--up)", render_up_name(job->plan.file->up));
    if (job->plan.left_out[0]) fprintf(out, "; not drawn: %s", job->plan.left_out);
    fputc('\n', out);
    fflush(out);
    print_notes(job->plan.file);
}

static void report_picture(const picture_job *job) {
    if (job->settings->common.json)
        report_picture_json(job);
    else if (!job->settings->common.quiet)
        report_text(job);
}

/* ---- files */

static int fail_picture(
    const render_settings *settings, const char *input, norma_document_error *error) {
    cli_name_error(error, input);
    cli_print_error(error);
    if (settings->common.json) {
        cli_json json = {.out = stdout};
        cli_json_print(&json, "{input: %s, output: null, error: %s}\n", input, error->message);
    }
    return cli_status_of(error->result);
}

static int draw_file(picture_job *job) {
    const render_settings *settings = job->settings;
    render_scene_file file;
    norma_document_error error = {0};
    job->plan = (render_plan){.settings = settings, .difference = -1};
    int status = CLI_OK;
    if (render_file_open(settings, job->input, &file, &error))
        status = fail_picture(settings, job->input, &error);
    if (!status) {
        status = render_plan_add(&job->plan, &file, &error);
        if (status && error.result) status = fail_picture(settings, job->input, &error);
    }
    if (!status) status = render_guard_outputs(settings);
    job->output = cli_output_of(&settings->files, job->index, ".png");
    if (!status) status = job->output ? draw_picture(job) : cli_out_of_memory();
    if (!status) report_picture(job);
    render_device_forget(job->device);
    render_file_close(&file);
    free(job->output);
    job->output = NULL;
    return status;
}

int render_start(int software, render_device **device) {
    render_error error = {.message = "out of memory"};
    render_watch_driver();
    if (!render_device_open(software, device, &error)) return CLI_OK;
    char limit[CLI_LIMIT_ROOM]; /* within which a driver may not fit */
    cli_memory_limit_words(limit);
    cli_error("%s%s%s", error.message, limit, limit[0] ? RENDER_DRIVER_NEEDS : "");
    return CLI_FILE;
}

/* Once, in the process that draws. */
static int open_device(picture_job *job) {
    if (job->has_no_device) return CLI_FILE;
    if (!job->device) job->has_no_device = render_start(job->settings->software, &job->device);
    return job->has_no_device ? CLI_FILE : CLI_OK;
}

static int draw_one(void *user, size_t file) {
    picture_job *job = user;
    job->input = job->settings->files.inputs.list[file].path;
    job->index = file;
    const int status = open_device(job);
    return status ? status : draw_file(job);
}

static void report_lost_picture(void *user, size_t file, int worker, const char *why) {
    const render_settings *settings = ((const picture_job *)user)->settings;
    norma_document_error error;
    cli_remove_left_by(worker, &settings->files, file);
    cli_lost_error(&error, settings->files.inputs.list[file].path, why);
    fail_picture(settings, settings->files.inputs.list[file].path, &error);
}

static int draw_all(const render_settings *settings) {
    picture_job *job = calloc(1, sizeof *job);
    if (!job) return cli_out_of_memory();
    job->settings = settings;
    const cli_each each = {
        settings->files.inputs.count, draw_one, report_lost_picture, job, settings->files.guard};
    const int status = cli_run_each(&each);
    render_device_close(job->device);
    free(job);
    return status;
}

static int draw_inputs(const cli_subcommand *command, render_settings *settings) {
    const int found = cli_find_inputs(command, &settings->files);
    if (found == CLI_USAGE || settings->files.inputs.count == 0) return found;
    const int refused = render_settings_check(command, settings);
    return refused ? refused : cli_finish(cli_worse(found, draw_all(settings)));
}

static int render_run(const cli_subcommand *command, int count, char **arguments) {
    render_settings settings;
    render_settings_default(&settings);
    const cli_table tables[] = {
        {render_options, render_option_count, &settings},
        {cli_matrix_options, cli_matrix_option_count, &settings.matrix},
        {cli_input_options, cli_input_option_count, &settings.files},
        {cli_common_options, cli_common_option_count, &settings.common},
    };
    int status =
        cli_read_files(command, &settings.files, tables, CLI_COUNT(tables), count, arguments);
    if (status) return status;
    status = draw_inputs(command, &settings);
    cli_remove_empty_folders(&settings.files);
    cli_files_end(&settings.files);
    return status;
}

const cli_subcommand cli_subcommand_render = {"render",
    "draws a picture of a mesh, its normals, their errors or findings", render_help, render_run};

/* ---- what norma compare found, as a picture */

enum { SIDES = 2 };

/* Of each corner: the normal of BASE that it was compared with. */
static float *base_normals(const compared_pair *pair) {
    float *normals = malloc((3 * pair->corners + 1) * sizeof *normals);
    for (size_t i = 0; i < pair->corners && normals; ++i)
        memcpy(normals + 3 * i, pair->samples[i].normal, 3 * sizeof *normals);
    return normals;
}

static enum render_result draw_compared(const compared_pair *pair, const render_surface *surface,
    render_device *device, render_png *png, render_error *error) {
    static const render_draw draw = {.world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    const render_scene scene = {surface, 1, &draw, 1};
    char words[120], worst[32], most[32];
    render_settings settings;
    render_picture picture;
    render_panel panels[SIDES];
    render_settings_default(&settings);
    for (int i = 0; i < SIDES; ++i) {
        panels[i] = (render_panel){.scene = &scene,
            .azimuth_deg = settings.azimuth_deg + 180 * i,
            .elevation_deg = settings.elevation_deg,
            .up = render_find_up(pair->other.document, surface, 1),
            .show = RENDER_SHOW_ERROR,
            .lines = RENDER_DOTS,
            .above = i ? "from behind" : "from the front"};
        memcpy(panels[i].matrix, settings.matrix.matrix, sizeof panels[i].matrix);
    }
    snprintf(words, sizeof words, "normals off by up to %s°, on 99 %% of the area by up to %s°",
        cli_decimals(worst, cli_to_degrees(pair->all.max_rad), 2),
        cli_decimals(most, cli_to_degrees(pair->all.p99_rad), 2));
    render_sheet sheet = {.panels = panels, .panel_count = SIDES, .below = words};
    enum render_result result =
        render_sheet_draw(device, &settings.look, &sheet, NULL, NULL, &picture, error);
    if (result) return result;
    result = render_png_encode(&picture, png, error);
    render_picture_free(&picture);
    return result;
}

int render_compared(
    const compared_pair *pair, const render_dot *dots, size_t dot_count, render_png *png) {
    render_device *device = NULL;
    render_error error = {.result = RENDER_ERROR_MEMORY, .message = "out of memory"};
    norma_surface other;
    int status = render_start(0, &device);
    if (status) return status;
    float *expected = base_normals(pair);
    if (compared_surface_make(&pair->other, 0, pair->other.count, &other) && expected) {
        const render_surface surface = {.mesh = other.mesh,
            .stored = RENDER_NORMALS_PER_CORNER,
            .normals = other.normals,
            .corner_normals = other.corner_normals,
            .expected = expected,
            .dots = dots,
            .dot_count = dot_count,
            .base_colour = {0.5F, 0.5F, 0.5F},
            .two_sided = 1};
        draw_compared(pair, &surface, device, png, &error);
    }
    if (!png->bytes) status = render_fail_drawing(pair->other.name, &error);
    render_device_close(device);
    compared_surface_free(&other);
    free(expected);
    return status;
}
