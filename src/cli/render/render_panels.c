/* render_panels.c: what is asked of norma render, and what each panel of a picture draws. */
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
    {"normals", CLI_TO(CLI_CHOICE, render_settings, normals.compute), .words = "stored,computed",
        .expected = "stored or computed"},
    {"weight", CLI_TO(CLI_WEIGHT, render_settings, normals.weight),
        CLI_GIVEN(render_settings, given, RENDER_GIVEN_WEIGHT)},
    {"crease", CLI_CREASE(render_settings, normals.crease_rad),
        CLI_GIVEN(render_settings, normals.crease_given, 1)},
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

/* ---- Options that have no effect: refused if the command line shows it, otherwise noted
 * once the file is open. */

static int refuse_idle(const cli_subcommand *command, const char *option, const char *needed) {
    return cli_usage(command, "%s applies only to %s with it", option, needed);
}

static int check_idle_options(const cli_subcommand *command, const render_settings *settings) {
    const unsigned given = settings->given;
    const int hedgehog = (settings->lines & ~(unsigned)RENDER_WIREFRAME) != 0,
              errors = settings->show == RENDER_SHOW_ERROR;
    if (given & RENDER_GIVEN_LENGTH && !hedgehog)
        return refuse_idle(command, "--line-length", "a hedgehog; expected --show hedgehog");
    if (given & RENDER_GIVEN_MOST && !hedgehog)
        return refuse_idle(command, "--most-lines", "a hedgehog; expected --show hedgehog");
    if (given & RENDER_GIVEN_WIDTH && !settings->lines && settings->show != RENDER_SHOW_MARKS)
        return refuse_idle(command, "--line-width", "lines; expected --show hedgehog or wireframe");
    if (settings->look.error_top_deg > 0 && !errors)
        return refuse_idle(command, "--error-top", "errors; expected --show error");
    if (settings->normals.compute && errors)
        return cli_usage(command, "--show error compares stored normals with computed ones; "
                                  "--normals computed leaves none to compare");
    return CLI_OK;
}

/* ---- Which panels a picture has: one, or what --compare sets side by side, and the words above
 * and below them. */

enum way { WAY_NONE = 0, WAY_BEFORE, WAY_PLAIN, WAY_RIGHT };

typedef struct side {
    int has_shading, has_weight, has_crease;
    enum render_shading shading;
    enum way way;
    norma_weight weight;
    double crease_deg;
    char title[64];
} side;

static const struct {
    const char *word;
    side side;
} sides_by_name[] = {{"flat", {.has_shading = 1, .shading = RENDER_FLAT, .title = "flat"}},
    {"gouraud", {.has_shading = 1, .shading = RENDER_GOURAUD, .title = "Gouraud"}},
    {"phong", {.has_shading = 1, .shading = RENDER_PHONG, .title = "Phong"}},
    {"before", {.way = WAY_BEFORE, .title = "before"}},
    {"plain", {.way = WAY_PLAIN, .title = "plain M"}},
    {"right", {.way = WAY_RIGHT, .title = "normal matrix"}}};

static int read_side(const char *word, side *out) {
    double degrees;
    *out = (side){0};
    for (size_t i = 0; i < CLI_COUNT(sides_by_name); ++i)
        if (strcmp(word, sides_by_name[i].word) == 0) {
            *out = sides_by_name[i].side;
            return 1;
        }
    if (!cli_find_weight(word, &out->weight)) {
        out->has_weight = 1;
        snprintf(out->title, sizeof out->title, "weight: %s", word);
        return 1;
    }
    if (!cli_number(word, &degrees) || degrees < 0 || degrees > 180) return 0;
    out->has_crease = 1;
    out->crease_deg = degrees;
    snprintf(out->title, sizeof out->title, "crease %.4g°", degrees);
    return 1;
}

static const char compare_help[] =
    "shadings (flat, gouraud, phong), transforms of normals (before, plain, right), weights "
    "(angle, area, ...) or creases in degrees, separated by commas";

static size_t read_sides(const render_settings *settings, side sides[RENDER_MOST_PANELS]) {
    const char *list = settings->compare == 1 ? "plain,right" : settings->compare_list;
    size_t count = 0;
    char word[32];
    while (*list && count < RENDER_MOST_PANELS) {
        const size_t length = strcspn(list, ",");
        if (length == 0 || length >= sizeof word) return 0;
        snprintf(word, sizeof word, "%.*s", (int)length, list);
        if (!read_side(word, &sides[count++])) return 0;
        list += length + (list[length] == ',');
    }
    return *list ? 0 : count;
}

/* The words of --compare are checked before a file is opened. */
static int check_sides(const cli_subcommand *command, const render_settings *settings) {
    side sides[RENDER_MOST_PANELS];
    if (settings->compare && read_sides(settings, sides) == 0)
        return cli_usage(
            command, "--compare=%s: expected %s", settings->compare_list, compare_help);
    return CLI_OK;
}

/* ---- Where the pictures of norma render go, and which options contradict each other:
 * said before anything is drawn. */

static int check_outputs(const cli_subcommand *command, render_settings *settings) {
    cli_files *files = &settings->files;
    int standard = 0;
    for (size_t i = 0; i < files->inputs.count; ++i)
        standard |= cli_is_standard(files->inputs.list[i].path);
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
    int status = check_idle_options(command, settings);
    if (!status) status = check_sides(command, settings);
    if (!status) status = check_outputs(command, settings);
    if (!status) status = cli_guard_outputs(&settings->files, ".png");
    return status ? status : cli_make_out_dir(command, &settings->files);
}
/* ---- what depends on the file */

/* Whether any normal of the scenes is computed; *flat: some surface has none and is flat. */
static int computes_any(const render_scene_file *file, int *flat) {
    int any = 0;
    *flat = 0;
    for (size_t i = 0; i < file->variant_count; ++i)
        for (size_t k = 0; k < file->scenes[i].surface_count; ++k) {
            const render_surface *surface = &file->scenes[i].surfaces[k];
            const int without = surface->stored == RENDER_NORMALS_NONE;
            any |= surface->replace_zeros || (without && surface->crease_rad >= 0);
            *flat |= without && surface->crease_rad < 0;
        }
    return any;
}

/* "--crease, --weight": those of the options that were given. */
static void name_options(const render_settings *settings, int of_normals, char list[80]) {
    list[0] = '\0';
    if (of_normals && settings->normals.crease_given) render_add_name(list, 80, "--crease");
    if (of_normals && settings->given & RENDER_GIVEN_WEIGHT) render_add_name(list, 80, "--weight");
    if (!of_normals && settings->given & RENDER_GIVEN_SHADING)
        render_add_name(list, 80, "--shading");
    if (!of_normals && settings->light_given) render_add_name(list, 80, "--light");
    if (!of_normals && settings->given & RENDER_GIVEN_PHONG) render_add_name(list, 80, "--phong");
}

static int is_lit(const render_settings *settings) {
    return settings->show == RENDER_SHOW_LIT || settings->show == RENDER_SHOW_MARKS;
}

/* Notes of options that have no effect on this file. */
static void render_note_idle(const render_settings *settings, render_scene_file *file) {
    char list[80];
    int flat;
    name_options(settings, 1, list);
    if (list[0] && settings->show != RENDER_SHOW_ERROR && !computes_any(file, &flat))
        render_file_note(file,
            "no effect: %s. No normal is computed, because %s; --normals computed computes all",
            list, flat ? "surfaces without normals are flat here" : "all of them are stored");
    name_options(settings, 0, list);
    if (list[0] && !is_lit(settings))
        render_file_note(file, "no effect: %s. Nothing that --show draws is lit", list);
}

/* ---- What of a file a picture does not show, in words. */

enum { NO_POINTS, NO_LINES, NO_COMPRESSION, NO_MESHES, NO_NODES, NO_IMAGES, NO_PLACE, LEFT_OUT };

static int is_of(const char *reason, const char *word) {
    return strncmp(reason, word, strlen(word)) == 0;
}

static void count_left_out(
    const render_settings *settings, const render_scene_file *file, size_t counts[LEFT_OUT]) {
    for (size_t i = 0; i < norma_document_mesh_count(file->document); ++i) {
        norma_mesh_info info;
        if (norma_document_mesh_info(file->document, i, &info) || !info.not_read) continue;
        ++counts[is_of(info.not_read, "points")  ? NO_POINTS
                 : is_of(info.not_read, "lines") ? NO_LINES
                 : info.compression              ? NO_COMPRESSION
                                                 : NO_MESHES];
    }
    counts[NO_NODES] = file->not_shown;
    counts[NO_IMAGES] = file->images_left_out;
    if (settings->show == RENDER_SHOW_MARKS) counts[NO_PLACE] = file->found_nowhere;
}

static void write_words_left_out(render_plan *plan) {
    static const char *const words[LEFT_OUT][2] = {
        [NO_POINTS] = {"mesh of points", "meshes of points"},
        [NO_LINES] = {"mesh of lines", "meshes of lines"},
        [NO_COMPRESSION] = {"mesh with a compression that is not read",
            "meshes with a compression that is not read"},
        [NO_MESHES] = {"mesh that is not read", "meshes that are not read"},
        [NO_NODES] = {"mesh outside the scene", "meshes outside the scene"},
        [NO_IMAGES] = {"image that cannot be read", "images that cannot be read"},
        [NO_PLACE] = {"finding without a place", "findings without a place"}};
    size_t counts[LEFT_OUT] = {0}, length = 0;
    count_left_out(plan->settings, plan->file, counts);
    for (int i = 0; i < LEFT_OUT; ++i) {
        const char *names = i == NO_IMAGES ? plan->file->left_out_names : "";
        if (counts[i])
            snprintf(plan->left_out + length, sizeof plan->left_out - length, "%s%zu %s%s%s%s",
                length ? ", " : "", counts[i], words[i][counts[i] > 1], *names ? " (" : "", names,
                *names ? ")" : "");
        length = strlen(plan->left_out);
    }
}

/* ---- panels */

/* The colours of hedgehog lines as the figures of the guide have them. */
static const uint32_t wrong_colour = 0xC0392B, right_colour = 0x1D7A4A;

static render_panel *add_panel(render_plan *plan, const render_scene_file *file,
    const render_scene *scene, const char *title) {
    const render_settings *settings = plan->settings;
    const size_t i = plan->count++;
    render_panel *panel = &plan->panels[i];
    *panel = (render_panel){.scene = scene,
        .azimuth_deg = settings->azimuth_deg,
        .elevation_deg = settings->elevation_deg,
        .up = file->up,
        .shading = settings->shading,
        .show = settings->show,
        .space = settings->space,
        .lines = settings->lines};
    if (settings->show == RENDER_SHOW_MARKS) panel->lines |= RENDER_DOTS;
    memcpy(panel->matrix, settings->matrix.matrix, sizeof panel->matrix);
    if (i < settings->label_count) title = settings->labels[i];
    if (title && *title) {
        snprintf(plan->above[i], sizeof plan->above[i], "%s", title);
        panel->above = plan->above[i];
    }
    return panel;
}

static void apply_way(render_plan *plan, render_panel *panel, enum way way) {
    if (way == WAY_BEFORE) memcpy(panel->matrix, cli_matrix_identity.matrix, sizeof panel->matrix);
    if (way == WAY_PLAIN) {
        panel->plain = panel->measured = 1;
        panel->line_colour = wrong_colour;
        panel->below =
            plan->below[panel - plan->panels]; /* what it says is known when the picture is */
    }
    if (way == WAY_RIGHT) panel->line_colour = right_colour;
}

static int add_sides(render_plan *plan, render_scene_file *file, norma_document_error *error) {
    side sides[RENDER_MOST_PANELS];
    const size_t count = read_sides(plan->settings, sides);
    for (size_t i = 0; i < count; ++i) {
        const side *s = &sides[i];
        render_variant variant = plan->settings->normals;
        if (s->has_weight || s->has_crease) variant.compute = 1;
        if (s->has_weight) variant.weight = s->weight;
        if (s->has_crease) {
            variant.crease_given = 1;
            variant.crease_rad = cli_radians(s->crease_deg);
        }
        const render_scene *scene = render_file_scene(plan->settings, file, &variant, error);
        if (!scene) return cli_status_of(error->result);
        render_panel *panel = add_panel(plan, file, scene, s->title);
        if (s->has_shading) panel->shading = s->shading;
        apply_way(plan, panel, s->way);
    }
    return CLI_OK;
}

static size_t count_unstored(const render_scene *scene) {
    size_t count = 0;
    for (size_t i = 0; i < scene->surface_count; ++i)
        count += scene->surfaces[i].stored == RENDER_NORMALS_NONE;
    return count;
}

int render_plan_add(render_plan *plan, render_scene_file *file, norma_document_error *error) {
    const render_settings *settings = plan->settings;
    if (settings->compare) {
        const int status = add_sides(plan, file, error);
        if (status) return status;
    } else {
        const render_scene *scene = render_file_scene(settings, file, &settings->normals, error);
        if (!scene) return cli_status_of(error->result);
        add_panel(plan, file, scene, NULL);
    }
    plan->file = file;
    write_words_left_out(plan);
    render_note_idle(settings, file);
    plan->unstored = count_unstored(plan->panels[0].scene);
    if (settings->show == RENDER_SHOW_MARKS && !settings->compare) {
        snprintf(plan->below[0], sizeof plan->below[0], "%.150s", file->found);
        plan->panels[0].below = plan->below[0];
    }
    if (settings->show == RENDER_SHOW_TANGENTS) {
        snprintf(plan->below[0], sizeof plan->below[0], "%s; darker where the sign is -1",
            !file->with_tangents ? "computed as MikkTSpace does: none are stored"
            : file->with_tangents < file->with_texcoords ? "stored, or computed where none are"
                                                         : "stored tangents");
        plan->panels[0].below = plan->below[0];
    }
    return CLI_OK;
}

void render_plan_legend(render_plan *plan, render_sheet *sheet) {
    static const char *const names[4][2] = {
        [1] = {"info", "infos"}, [2] = {"warning", "warnings"}, [3] = {"error", "errors"}};
    if (plan->left_out[0]) sheet->left_out = plan->left_out;
    for (int i = 3; i > 0; --i) {
        if (!plan->file->found_counts[i]) continue;
        snprintf(plan->keys[i], sizeof plan->keys[i], "%zu %s", plan->file->found_counts[i],
            names[i][plan->file->found_counts[i] > 1]);
        sheet->keys[sheet->key_count++] = (render_key){render_finding_colours[i], plan->keys[i]};
    }
}

/* ---- what is known once the panels are drawn */

static int compares_pictures(const render_plan *plan) {
    if (plan->settings->compare != 2 || plan->count != 2) return 0;
    return !plan->panels[0].measured && !plan->panels[1].measured &&
           memcmp(plan->panels[0].matrix, plan->panels[1].matrix, sizeof plan->panels[0].matrix) ==
               0;
}

void render_plan_tell(void *user, render_sheet *sheet, const render_picture *picture) {
    render_plan *plan = user;
    const render_look *look = &plan->settings->look;
    char number[32];
    for (size_t i = 0; i < plan->count; ++i)
        if (plan->panels[i].measured)
            snprintf(plan->below[i], sizeof plan->below[i], "largest error %s°",
                cli_decimals(number, cli_to_degrees(plan->panels[i].worst_plain_rad), 2));
    plan->difference = -1;
    if (compares_pictures(plan)) {
        plan->difference = render_picture_difference(picture, sheet->panel_x[0], sheet->panel_y[0],
            sheet->panel_x[1], sheet->panel_y[1], look->width, look->height);
        snprintf(plan->footer, sizeof plan->footer, "largest difference: %d of 255 levels",
            plan->difference);
        sheet->below = plan->footer;
    } else if (plan->settings->show == RENDER_SHOW_ERROR) {
        double worst = NAN;
        for (size_t i = 0; i < plan->count; ++i)
            worst = fmax(worst, plan->panels[i].worst_error_rad);
        if (isnan(worst))
            snprintf(plan->footer, sizeof plan->footer,
                "no normals are stored: there is nothing to compare");
        else
            snprintf(plan->footer, sizeof plan->footer,
                "stored against computed normals: largest error %s°%s",
                cli_decimals(number, cli_to_degrees(worst), 2),
                plan->unstored ? "; grey: no normals are stored" : "");
        sheet->below = plan->footer;
    }
}
