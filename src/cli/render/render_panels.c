/* render_panels.c: what each panel of a picture draws. */
#include "cli/render/render.h"
#include "cli/process/process.h"
#include "cli/text/text.h"
#include <math.h>
#include <string.h>

/* ---- Options that have no effect: refused if the command line shows it, otherwise noted
 * once the file is open. */

static int refuse_idle(const cli_subcommand *command, const char *option, const char *needed) {
    return cli_usage(command, "%s applies only to %s with it", option, needed);
}

int render_check_idle(const cli_subcommand *command, const render_settings *settings) {
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
    if (settings->compute && errors)
        return cli_usage(command, "--show error compares stored normals with computed ones; "
                                  "--normals computed leaves none to compare");
    return CLI_OK;
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
    if (of_normals && settings->crease_given) render_add_name(list, 80, "--crease");
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

static int is_of(const char *reason, const char *word) {
    return strncmp(reason, word, strlen(word)) == 0;
}

static void render_file_left_out(
    const render_settings *settings, const render_scene_file *file, render_left_out *left_out) {
    size_t *counts = left_out->counts;
    for (size_t i = 0; i < norma_document_mesh_count(file->document); ++i) {
        norma_mesh_info info;
        if (norma_document_mesh_info(file->document, i, &info) || !info.not_read) continue;
        ++counts[is_of(info.not_read, "points")  ? RENDER_NO_POINTS
                 : is_of(info.not_read, "lines") ? RENDER_NO_LINES
                 : info.compression              ? RENDER_NO_COMPRESSION
                                                 : RENDER_NO_MESHES];
    }
    counts[RENDER_NO_NODES] += file->not_shown;
    counts[RENDER_NO_IMAGES] += file->images_left_out;
    if (file->left_out_names[0])
        render_add_name(left_out->images, sizeof left_out->images, file->left_out_names);
    if (settings->show == RENDER_SHOW_MARKS) counts[RENDER_NO_PLACE] += file->found_nowhere;
}

static void add_words(
    char *text, size_t room, size_t count, const char *const words[2], const char *names) {
    const size_t length = strlen(text);
    if (count)
        snprintf(text + length, room - length, "%s%zu %s%s%s%s", length ? ", " : "", count,
            words[count > 1], *names ? " (" : "", names, *names ? ")" : "");
}

static void render_left_out_words(const render_left_out *left_out, char *text, size_t room) {
    static const char *const words[RENDER_LEFT_OUT][2] = {
        [RENDER_NO_POINTS] = {"mesh of points", "meshes of points"},
        [RENDER_NO_LINES] = {"mesh of lines", "meshes of lines"},
        [RENDER_NO_COMPRESSION] = {"mesh with a compression that is not read",
            "meshes with a compression that is not read"},
        [RENDER_NO_MESHES] = {"mesh that is not read", "meshes that are not read"},
        [RENDER_NO_NODES] = {"mesh outside the scene", "meshes outside the scene"},
        [RENDER_NO_IMAGES] = {"image that cannot be read", "images that cannot be read"},
        [RENDER_NO_PLACE] = {"finding without a place", "findings without a place"}};
    text[0] = '\0';
    for (int i = 0; i < RENDER_LEFT_OUT; ++i)
        add_words(text, room, left_out->counts[i], words[i],
            i == RENDER_NO_IMAGES ? left_out->images : "");
}

/* ---- Which panels a picture has: one, or what --compare sets side by side, and the words above
 * and below them. */

/* ---- what can be compared: shadings, ways of a normal through the matrix, weights, creases */

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

/* The next word of a list with commas; 0: it is too long or empty. */
static int next_in_list(const char **list, char *word, size_t room) {
    size_t length = strcspn(*list, ",");
    if (length == 0 || length >= room) return 0;
    memcpy(word, *list, length);
    word[length] = '\0';
    *list += length;
    if (**list == ',') ++*list;
    return 1;
}

static size_t read_sides(const render_settings *settings, side sides[RENDER_MOST_PANELS]) {
    const char *list = settings->compare == 1 ? "plain,right" : settings->compare_list;
    size_t count = 0;
    char word[32];
    while (*list && count < RENDER_MOST_PANELS) {
        if (!next_in_list(&list, word, sizeof word) || !read_side(word, &sides[count])) return 0;
        ++count;
    }
    return *list ? 0 : count;
}

int render_plan_check(const cli_subcommand *command, const render_settings *settings) {
    side sides[RENDER_MOST_PANELS];
    if (settings->compare && read_sides(settings, sides) == 0)
        return cli_usage(
            command, "--compare=%s: expected %s", settings->compare_list, compare_help);
    return CLI_OK;
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

static int add_sides(render_plan *plan, render_scene_file *file, const render_variant *usual,
    norma_document_error *error) {
    side sides[RENDER_MOST_PANELS];
    const size_t count = read_sides(plan->settings, sides);
    for (size_t i = 0; i < count; ++i) {
        const side *s = &sides[i];
        render_variant variant = *usual;
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
    const render_variant usual = {
        settings->compute, settings->crease_given, settings->crease_rad, settings->weight};
    if (settings->compare) {
        const int status = add_sides(plan, file, &usual, error);
        if (status) return status;
    } else {
        const render_scene *scene = render_file_scene(settings, file, &usual, error);
        if (!scene) return cli_status_of(error->result);
        add_panel(plan, file, scene, NULL);
    }
    render_file_left_out(settings, file, &plan->lost);
    render_note_idle(settings, file);
    memcpy(plan->found_counts, file->found_counts, sizeof plan->found_counts);
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
    render_left_out_words(&plan->lost, plan->left_out, sizeof plan->left_out);
    if (plan->left_out[0]) sheet->left_out = plan->left_out;
    for (int i = 3; i > 0; --i) {
        if (!plan->found_counts[i]) continue;
        snprintf(plan->keys[i], sizeof plan->keys[i], "%zu %s", plan->found_counts[i],
            names[i][plan->found_counts[i] > 1]);
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
