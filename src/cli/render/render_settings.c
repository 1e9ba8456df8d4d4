/* render_settings.c: what is asked of norma render, and where its pictures go. */
#define _POSIX_C_SOURCE 200809L
#include "cli/render/render.h"
#include "cli/text/text.h"
#include "cli/files/files.h"
#include "cli/process/process.h"
#include <float.h>
#include <math.h>
#include <norma/check.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- The options of norma render. */

void render_settings_default(render_settings *settings) {
    *settings = (render_settings){.matrix = cli_matrix_identity,
        .common.threads = NORMA_ALL_THREADS,
        .shading = RENDER_PHONG,
        .clay = -1,
        .azimuth_deg = 35,
        .elevation_deg = 22};
    settings->look = (render_look){.width = 512,
        .height = 512,
        .samples = 2,
        .background = {250, 249, 246, 255},
        .ink = {38, 38, 38},
        .lights = {{-30, 50, 0.78}, {75, 5, 0.34}},
        .light_count = 2,
        .ambient = 0.09,
        .diffuse = 0.9,
        .specular = 0.07,
        .exponent = 25,
        .field_of_view_deg = 28,
        .line_pixels = 1.6,
        .reach = 0.7,
        .most_lines = 4000};
}

/* The number of the next word of a list with commas among names; -1: none of them. */
static int next_name(const char **list, const char *const *names, size_t count) {
    const size_t length = strcspn(*list, ",");
    for (size_t i = 0; i < count; ++i)
        if (strlen(names[i]) == length && memcmp(names[i], *list, length) == 0) {
            *list += length + ((*list)[length] == ',' && (*list)[length + 1]);
            return (int)i;
        }
    return -1;
}

/* ---- what is drawn */

static const char *set_show(void *user, const char *value) {
    static const char expected[] =
        "normals, winding, error, findings, matcap, zebra or tangents, with hedgehog or "
        "wireframe over it or alone, such as winding,wireframe";
    static const char *const names[] = {"shading", "normals", "winding", "error", "findings",
        "matcap", "zebra", "tangents", "hedgehog", "wireframe"};
    render_settings *settings = user;
    int bases = 0;
    do {
        const int number = next_name(&value, names, CLI_COUNT(names));
        if (number == 8)
            settings->lines |= RENDER_VERTEX_LINES | RENDER_FACE_LINES;
        else if (number == 9)
            settings->lines |= RENDER_WIREFRAME;
        else if (number < 0 || bases++)
            return expected;
        else
            settings->show = (enum render_show)number;
    } while (*value);
    return NULL;
}

static const char *set_lines(void *user, const char *value) {
    static const char *const names[] = {"vertices", "faces", "edges"};
    render_settings *settings = user;
    settings->hedgehog = 0;
    do {
        const int number = next_name(&value, names, CLI_COUNT(names));
        if (number < 0) return "vertices, faces, edges, or several of them, separated by commas";
        settings->hedgehog |= 1U << number;
    } while (*value);
    return NULL;
}

static const char *set_compare(void *user, const char *value) {
    render_settings *settings = user;
    settings->compare = value ? 2 : 1;
    settings->compare_list = value;
    return NULL;
}

static const char *set_label(void *user, const char *value) {
    render_settings *settings = user;
    if (settings->label_count == RENDER_MOST_WORDS) return "at most 64 of these";
    settings->labels[settings->label_count++] = value;
    return NULL;
}

static const char *set_clay(void *settings, const char *value) {
    if (value && strcmp(value, "yes") != 0 && strcmp(value, "no") != 0)
        return "yes, no, or no value";
    ((render_settings *)settings)->clay = !value || value[0] == 'y';
    return NULL;
}

static const char *set_shown_rules(void *user, const char *value) {
    render_settings *settings = user;
    size_t rules;
    norma_rules(&rules);
    if (rules > RENDER_MOST_RULES || norma_rules_select(value, settings->select, NULL))
        return "ids of rules (N301), their beginnings (N3) or names, separated by commas";
    settings->has_select = 1;
    return NULL;
}

/* ---- normals */

/* ---- camera and light */

static const char *set_camera(void *user, const char *value) {
    render_settings *settings = user;
    double angles[2];
    if (cli_numbers(value, angles, 2) != 2 || fabs(angles[1]) > 90)
        return "AZIMUTH,ELEVATION in degrees, such as 35,22; elevation from -90 to 90";
    settings->azimuth_deg = angles[0];
    settings->elevation_deg = angles[1];
    return NULL;
}

static const char *set_fov(void *settings, const char *value) {
    double degrees;
    if (!cli_number(value, &degrees) || degrees < 0 || degrees > 150 ||
        (degrees > 0 && degrees < 0.1))
        return "degrees, 0.1 to 150, or 0 for an orthographic camera";
    ((render_settings *)settings)->look.field_of_view_deg = degrees;
    return NULL;
}

static const char *set_light(void *user, const char *value) {
    render_settings *settings = user;
    render_look *look = &settings->look;
    double numbers[3] = {0, 0, 1};
    size_t count = cli_numbers(value, numbers, 3);
    if ((count != 2 && count != 3) || fabs(numbers[1]) > 90 || numbers[2] < 0 || numbers[2] > 100)
        return "AZIMUTH,ELEVATION or AZIMUTH,ELEVATION,STRENGTH, seen from the camera, such as "
               "-40,42,0.85";
    if (!settings->light_given) look->light_count = 0;
    settings->light_given = 1;
    if (look->light_count == RENDER_MOST_LIGHTS) return "at most four of these";
    look->lights[look->light_count++] = (render_light){numbers[0], numbers[1], numbers[2]};
    return NULL;
}

static const char *set_phong(void *user, const char *value) {
    render_look *look = &((render_settings *)user)->look;
    double numbers[4];
    if (cli_numbers(value, numbers, 4) != 4 || numbers[0] < 0 || numbers[1] < 0 || numbers[2] < 0 ||
        numbers[3] <= 0 || numbers[3] > 1e5)
        return "AMBIENT,DIFFUSE,SPECULAR,EXPONENT, such as 0.1,0.95,0.18,40";
    ((render_settings *)user)->given |= RENDER_GIVEN_PHONG;
    look->ambient = numbers[0];
    look->diffuse = numbers[1];
    look->specular = numbers[2];
    look->exponent = numbers[3];
    return NULL;
}

/* ---- the picture */

static const char *set_size(void *user, const char *value) {
    static const char expected[] = "WIDTHxHEIGHT in pixels, 16x16 to 16384x16384, such as 512x512";
    render_look *look = &((render_settings *)user)->look;
    char text[32];
    double numbers[2];
    if (strlen(value) >= sizeof text || strspn(value, "0123456789x") != strlen(value))
        return expected;
    strcpy(text, value);
    char *cross = strchr(text, 'x');
    if (cross) *cross = ',';
    if (!cross || cli_numbers(text, numbers, 2) != 2 || numbers[0] < 16 || numbers[1] < 16 ||
        numbers[0] > 16384 || numbers[1] > 16384)
        return expected;
    look->width = (size_t)numbers[0];
    look->height = (size_t)numbers[1];
    return NULL;
}

static int hexadecimal(const char *digits, uint8_t colour[3]) {
    if (strlen(digits) != 6 || strspn(digits, "0123456789abcdefABCDEF") != 6) return 0;
    unsigned long all = strtoul(digits, NULL, 16);
    for (int k = 0; k < 3; ++k) colour[k] = (uint8_t)(all >> (16 - 8 * k) & 0xFF);
    return 1;
}

static const char *set_background(void *user, const char *value) {
    render_look *look = &((render_settings *)user)->look;
    static const struct {
        const char *name;
        uint8_t colour[4];
    } names[] = {{"paper", {250, 249, 246, 255}}, {"white", {255, 255, 255, 255}},
        {"black", {0, 0, 0, 255}}, {"grey", {128, 128, 128, 255}}, {"transparent", {0, 0, 0, 0}}};
    int known = 0;
    for (size_t i = 0; i < CLI_COUNT(names); ++i)
        if (strcmp(value, names[i].name) == 0) {
            memcpy(look->background, names[i].colour, 4);
            known = 1;
        }
    if (!known && (value[0] != '#' || !hexadecimal(value + 1, look->background)))
        return "paper, white, black, grey, transparent, or #RRGGBB";
    if (!known) look->background[3] = 255;
    const int dark =
        look->background[3] &&
        2 * look->background[0] + 5 * look->background[1] + look->background[2] < 8 * 110;
    memset(look->ink, dark ? 235 : 38, sizeof look->ink);
    return NULL;
}

const cli_option render_options[] = {
    {"output", 'o', CLI_TO(CLI_ONCE, render_settings, files.output),
        .expected = "a name that ends in .png, or - for standard output"},
    {"out-dir", CLI_TO(CLI_ONCE, render_settings, files.folder),
        .expected = "the name of a folder"},
    {"shading", CLI_TO(CLI_CHOICE, render_settings, shading), .words = "flat,gouraud,phong",
        .expected = "flat, gouraud or phong",
        CLI_GIVEN(render_settings, given, RENDER_GIVEN_SHADING)},
    {"show", CLI_SET(set_show)},
    {"compare", .takes_value = CLI_MAYBE_VALUE, .set = set_compare},
    {"space", CLI_TO(CLI_CHOICE, render_settings, space), .words = "world,view",
        .expected = "world or view"},
    {"label", CLI_SET(set_label)},
    {"clay", .takes_value = CLI_MAYBE_VALUE, .set = set_clay},
    {"select", CLI_SET(set_shown_rules)},
    {"lines", CLI_SET(set_lines)},
    {"line-length", CLI_TO(CLI_DOUBLE, render_settings, look.reach), .least = DBL_TRUE_MIN,
        .most = 1000, .expected = "a number above 0, which multiplies the length of nearby edges",
        CLI_GIVEN(render_settings, given, RENDER_GIVEN_LENGTH)},
    {"line-width", CLI_TO(CLI_DOUBLE, render_settings, look.line_pixels), .least = DBL_TRUE_MIN,
        .most = 100, .expected = "pixels, above 0",
        CLI_GIVEN(render_settings, given, RENDER_GIVEN_WIDTH)},
    {"most-lines", CLI_TO(CLI_SIZE, render_settings, look.most_lines), .least = 1, .most = 1e7,
        .expected = CLI_WHOLE_FROM_1, CLI_GIVEN(render_settings, given, RENDER_GIVEN_MOST)},
    {"error-top", CLI_TO(CLI_DOUBLE, render_settings, look.error_top_deg), .least = DBL_TRUE_MIN,
        .most = 180, .expected = "degrees, above 0 and at most 180"},
    {"normals", CLI_TO(CLI_CHOICE, render_settings, compute), .words = "stored,computed",
        .expected = "stored or computed"},
    {"weight", CLI_TO(CLI_WEIGHT, render_settings, weight),
        CLI_GIVEN(render_settings, given, RENDER_GIVEN_WEIGHT)},
    {"crease", CLI_CREASE(render_settings, crease_rad),
        CLI_GIVEN(render_settings, crease_given, 1)},
    {"camera", CLI_SET(set_camera)},
    {"fov", CLI_SET(set_fov)},
    {"up", CLI_TO(CLI_CHOICE, render_settings, up), .words = "y,z,x,-y,-z,-x",
        .expected = "x, y or z, or -x, -y or -z", CLI_GIVEN(render_settings, up_given, 1)},
    {"light", CLI_SET(set_light)},
    {"phong", CLI_SET(set_phong)},
    {"size", CLI_SET(set_size)},
    {"samples", CLI_TO(CLI_INT, render_settings, look.samples), .least = 1,
        .most = RENDER_MOST_SAMPLES, .expected = "1 to 4 samples in each direction of a pixel"},
    {"background", CLI_SET(set_background)},
    {"renderer", CLI_TO(CLI_CHOICE, render_settings, software), .words = "auto,software",
        .expected = "auto or software"},
};
const size_t render_option_count = CLI_COUNT(render_options);

/* ---- Where the pictures of norma render go, and which options contradict each other:
 * said before anything is drawn. */

static int check_outputs(const cli_subcommand *command, render_settings *settings) {
    cli_files *files = &settings->files;
    int standard = 0;
    for (size_t i = 0; i < files->inputs.count; ++i)
        standard |= cli_is_standard(files->inputs.paths[i]);
    if (!files->output && !files->folder)
        return cli_usage(command, "no output was given; expected -o OUT.png or --out-dir FOLDER");
    if (files->output && files->folder)
        return cli_usage(command, "-o and --out-dir exclude each other");
    if (files->output && files->inputs.count > 1)
        return cli_usage(
            command, "one -o for %zu inputs; expected --out-dir FOLDER", files->inputs.count);
    if (files->folder && standard)
        return cli_usage(command, "standard input has no name to write to; expected -o OUT.png");
    if (files->folder) return cli_place_outputs(command, files, ".png");
    if (cli_is_standard(files->output) && settings->common.json)
        return cli_usage(command, "-o - and --json would both write to standard output");
    if (cli_is_standard(files->output) && isatty(STDOUT_FILENO))
        return cli_usage(command,
            "standard output is a terminal, which shows no picture; expected -o "
            "OUT.png, or a pipe");
    if (!cli_is_standard(files->output) && !cli_ends_in(files->output, ".png") &&
        !cli_is_stream(files->output))
        return cli_usage(
            command, "-o %s: pictures are PNG; expected a name that ends in .png", files->output);
    return CLI_OK;
}

/* Every picture that will be drawn. */
int render_guard_outputs(const render_settings *settings) {
    int status = CLI_OK;
    for (size_t i = 0; i < settings->files.inputs.count && !status; ++i) {
        char *output = cli_output_of(&settings->files, i, ".png");
        status =
            output ? cli_guard_output(settings->files.guard, output, NULL) : cli_out_of_memory();
        free(output);
    }
    return status;
}

int render_settings_check(const cli_subcommand *command, render_settings *settings) {
    if (settings->lines & RENDER_VERTEX_LINES && settings->hedgehog)
        settings->lines = (settings->lines & RENDER_WIREFRAME) | settings->hedgehog;
    else if (settings->hedgehog)
        return cli_usage(
            command, "--lines applies only to a hedgehog; expected --show hedgehog with it");
    if (!cli_is_affine(&settings->matrix))
        return cli_usage(command,
            "the last row of the matrix must be 0 0 0 1; the camera makes the perspective");
    if (settings->has_select && settings->show != RENDER_SHOW_MARKS)
        return cli_usage(command, "--select applies only to findings; expected --show findings");
    if (settings->clay < 0)
        settings->clay = settings->compare || settings->show == RENDER_SHOW_ERROR ||
                         settings->show == RENDER_SHOW_MARKS;
    int status = render_check_idle(command, settings);
    if (!status) status = render_plan_check(command, settings);
    if (!status) status = check_outputs(command, settings);
    if (!status) status = render_guard_outputs(settings);
    if (!status)
        cli_guard_look_ahead(
            settings->files.guard, &settings->files.inputs, settings->files.format);
    if (!status) status = render_guard_outputs(settings);
    return status ? status : cli_make_out_dir(command, &settings->files);
}
