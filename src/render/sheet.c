/* sheet.c: panels side by side and the words above or below them. Words in a strip are smaller
 * where they would not fit, but not below what can be read; then on several lines. */
#include "render/device.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- how the words of a strip are set */

enum { RENDER_MOST_LINES = 6 };

typedef struct render_text_lines {
    double size;                              /* of the letters, in pixels */
    size_t count, lengths[RENDER_MOST_LINES]; /* bytes; a blank lies between two lines */
} render_text_lines;

static const double least_text = 7.5, room_of_width = 0.96, line_step = 1.8; /* of capitals */

/* The bytes of the words that fit, up to a blank; at least one word. */
static size_t line_length(const char *words, double size, double room) {
    size_t fits = 0;
    for (size_t at = 1;; ++at) {
        char line[256];
        if (words[at - 1] == '\0') return fits;
        if (words[at] != ' ' && words[at] != '\0') continue;
        snprintf(line, sizeof line, "%.*s", (int)at, words);
        if (fits && render_text_width(line, size) > room) return fits;
        fits = at;
    }
}

/* In letters of the usual size if they fit, within a strip of this width. */
static render_text_lines break_words(const char *words, double usual, size_t width) {
    const double room = room_of_width * (double)width, wide = render_text_width(words, usual);
    render_text_lines l = {.size = wide > room ? usual * room / wide : usual, .count = 1};
    l.lengths[0] = strlen(words);
    if (l.size >= least_text || l.size >= usual) return l;
    double widest = 0;
    l.size = least_text;
    l.count = 0;
    for (const char *at = words; *at && l.count < RENDER_MOST_LINES; ++l.count) {
        char line[400];
        size_t *length = &l.lengths[l.count];
        *length = l.count + 1 < RENDER_MOST_LINES ? line_length(at, l.size, room) : strlen(at);
        snprintf(line, sizeof line, "%.*s", (int)*length, at);
        widest = fmax(widest, render_text_width(line, l.size));
        at += *length + (at[*length] == ' ');
    }
    if (widest > room) l.size *= room / widest; /* one long word, or very many */
    return l;
}

/* ---- Panels side by side, words above and below them, and the legend of the error's colours. */

static double text_size(const render_look *look) {
    const double shorter = (double)(look->width < look->height ? look->width : look->height);
    return fmin(fmax(shorter / 40, 9), 28);
}

static size_t strip_height(const render_look *look, const char *words, size_t width) {
    const render_text_lines l = break_words(words, text_size(look), width);
    return (size_t)lround(2.4 * text_size(look) + (double)(l.count - 1) * line_step * l.size);
}

/* ---- where things lie */

typedef struct layout {
    size_t above, below, legend, keys, footer, left_out; /* heights of strips */
    char words[640];                                     /* of what is left out */
} layout;

/* Without stored normals there is nothing for a scale to show. */
static int has_errors(const render_panel *panel) {
    return panel->show == RENDER_SHOW_ERROR && !isnan(panel->worst_error_rad);
}

/* As high as the words may become that are written once the picture is drawn. */
static size_t footer_height(const render_look *look, const render_sheet *sheet, size_t width) {
    static const char longest[] = "stored against computed normals: largest error 180.00° or so";
    if (!sheet->below) return 0;
    return strip_height(look, *sheet->below ? sheet->below : longest, width);
}

static size_t taller(size_t height, const render_look *look, const char *words, size_t width) {
    static const char longest[] = "largest error 180.00°";
    if (!words) return height;
    const size_t own = strip_height(look, *words ? words : longest, width);
    return own > height ? own : height;
}

static void write_left_out(const render_sheet *sheet, layout *l) {
    char of_hedgehog[80] = "";
    if (sheet->lines_left_out)
        snprintf(of_hedgehog, sizeof of_hedgehog, "%s%zu lines of the hedgehog",
            sheet->left_out ? "; " : "", sheet->lines_left_out);
    snprintf(l->words, sizeof l->words, "not drawn: %.540s%s",
        sheet->left_out ? sheet->left_out : "", of_hedgehog);
}

static layout lay_out(const render_look *look, render_sheet *sheet) {
    const size_t strip = (size_t)lround(2.4 * text_size(look));
    layout l = {0};
    const size_t width = sheet->panel_count * look->width;
    for (size_t i = 0; i < sheet->panel_count; ++i) {
        l.above = taller(l.above, look, sheet->panels[i].above, look->width);
        l.below = taller(l.below, look, sheet->panels[i].below, look->width);
        if (has_errors(&sheet->panels[i])) l.legend = 2 * strip;
    }
    l.footer = footer_height(look, sheet, width);
    l.keys = sheet->key_count ? strip : 0;
    write_left_out(sheet, &l);
    if (sheet->left_out || sheet->lines_left_out) l.left_out = strip_height(look, l.words, width);
    for (size_t i = 0; i < sheet->panel_count; ++i) {
        sheet->panel_x[i] = i * look->width;
        sheet->panel_y[i] = l.above;
    }
    return l;
}

static enum render_result make_picture(const render_look *look, const layout *l, size_t panels,
    render_picture *picture, render_error *error) {
    const size_t most = (size_t)1 << 15; /* each way: what readers of PNG take without asking */
    picture->width = panels * look->width;
    picture->height =
        l->above + look->height + l->below + l->legend + l->keys + l->footer + l->left_out;
    if (picture->width > most || picture->height > most)
        return render_fail(error, RENDER_ERROR_ARGUMENT,
            "a picture of %zux%zu pixels; expected at most %zu in each direction", picture->width,
            picture->height, most);
    picture->pixels = malloc(4 * picture->width * picture->height);
    if (!picture->pixels) return render_fail_memory(error);
    for (size_t i = 0; i < picture->width * picture->height; ++i)
        memcpy(picture->pixels + 4 * i, look->background, 4);
    return RENDER_OK;
}

/* ---- words */

/* Centred. */
static void draw_centred(const render_look *look, render_picture *picture, const char *words,
    size_t x, size_t width, size_t y, size_t height) {
    const render_text_lines l = break_words(words, text_size(look), width);
    double base =
        (double)y + ((double)height + l.size - (double)(l.count - 1) * line_step * l.size) / 2;
    for (size_t i = 0; i < l.count; ++i) {
        char line[640];
        snprintf(line, sizeof line, "%.*s", (int)l.lengths[i], words);
        render_text_draw(picture, line,
            (double)x + ((double)width - render_text_width(line, l.size)) / 2, base, l.size,
            look->ink);
        base += line_step * l.size;
        words += l.lengths[i] + (words[l.lengths[i]] == ' ');
    }
}

static void write_all_words(
    const render_look *look, const render_sheet *sheet, const layout *l, render_picture *picture) {
    for (size_t i = 0; i < sheet->panel_count; ++i) {
        const render_panel *panel = &sheet->panels[i];
        if (panel->above && l->above)
            draw_centred(look, picture, panel->above, sheet->panel_x[i], look->width,
                sheet->panel_y[i] - l->above, l->above);
        if (panel->below && l->below)
            draw_centred(look, picture, panel->below, sheet->panel_x[i], look->width,
                sheet->panel_y[i] + look->height, l->below);
    }
    if (sheet->below && l->footer)
        draw_centred(look, picture, sheet->below, 0, picture->width,
            picture->height - l->left_out - l->footer, l->footer);
    if (l->left_out)
        draw_centred(
            look, picture, l->words, 0, picture->width, picture->height - l->left_out, l->left_out);
}

/* ---- keys: squares of a colour, each with its words to the right */

static void add_key(render_sheet *sheet, unsigned is_there, uint32_t colour, const char *words) {
    if (is_there && sheet->key_count < RENDER_MOST_KEYS)
        sheet->keys[sheet->key_count++] = (render_key){colour, words};
}

/* Colours that say which of several things something is. */
static void name_colours(render_sheet *sheet) {
    unsigned lines = 0, winding = 0, tangents = 0, uncompared = 0, titled = 0;
    for (size_t i = 0; i < sheet->panel_count; ++i) {
        const render_panel *panel = &sheet->panels[i];
        lines |= panel->lines;
        titled |= panel->line_colour != 0; /* what is above such a panel says what its lines are */
        winding |= panel->show == RENDER_SHOW_WINDING;
        tangents |= panel->show == RENDER_SHOW_TANGENTS;
        uncompared |= has_errors(panel) && panel->uncompared;
    }
    add_key(sheet, winding, RENDER_FRONT_COLOUR, "front");
    add_key(sheet, winding, RENDER_BACK_COLOUR, "back");
    add_key(sheet, tangents, RENDER_NOTHING_COLOUR, "no tangent");
    add_key(sheet, uncompared, RENDER_NOTHING_COLOUR, "nothing to compare");
    add_key(
        sheet, !titled && lines & RENDER_VERTEX_LINES, RENDER_VERTEX_COLOUR, "normal of a vertex");
    add_key(sheet, lines & RENDER_FACE_LINES, RENDER_FACE_COLOUR, "normal of a face");
    add_key(sheet, lines & RENDER_EDGE_LINES, RENDER_EDGE_COLOUR, "normal along an edge");
}

static void fill_square(render_picture *picture, size_t x, size_t y, size_t side, uint32_t colour) {
    for (size_t row = y; row < y + side && row < picture->height; ++row)
        for (size_t column = x; column < x + side && column < picture->width; ++column) {
            uint8_t *pixel = picture->pixels + 4 * (row * picture->width + column);
            for (int k = 0; k < 3; ++k) pixel[k] = (uint8_t)(colour >> (16 - 8 * k));
            pixel[3] = 255;
        }
}

static void write_keys(
    const render_look *look, const render_sheet *sheet, const layout *l, render_picture *picture) {
    double size = text_size(look), wide = 0;
    for (size_t i = 0; i < sheet->key_count; ++i)
        wide += render_text_width(sheet->keys[i].words, size) + 3.5 * size;
    if (wide > 0.96 * (double)picture->width) {
        size *= 0.96 * (double)picture->width / wide;
        wide = 0.96 * (double)picture->width;
    }
    double x = fmax(((double)picture->width - wide) / 2 + size, 0);
    const double y = (double)(picture->height - l->left_out - l->footer - l->keys) +
                     ((double)l->keys - size) / 2;
    for (size_t i = 0; i < sheet->key_count; ++i) {
        fill_square(picture, (size_t)x, (size_t)y, (size_t)ceil(size), sheet->keys[i].colour);
        render_text_draw(picture, sheet->keys[i].words, x + 1.6 * size, y + size, size, look->ink);
        x += render_text_width(sheet->keys[i].words, size) + 3.5 * size;
    }
}

/* ---- the scale of errors */

/* The least of 1, 2, 5 times a power of ten, and of 30, 45, 60, 90, 120, 180, that is not below it.
 */
static double scale_top(double degrees) {
    static const double tops[] = {
        0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 45, 60, 90, 120};
    for (size_t i = 0; i < sizeof tops / sizeof *tops; ++i)
        if (degrees <= tops[i]) return tops[i];
    return 180;
}

static double worst_error_deg(const render_sheet *sheet) {
    double worst = 0;
    for (size_t i = 0; i < sheet->panel_count; ++i)
        worst = fmax(worst, sheet->panels[i].worst_error_rad * 57.29577951308232);
    return worst;
}

/* What 99 of 100 errors do not exceed, but no less than a degree, unless that is the largest: of a
 * few bad normals' own scale the others had one colour. */
static double shown_error_deg(const render_sheet *sheet) {
    double most = 0;
    for (size_t i = 0; i < sheet->panel_count; ++i)
        most = fmax(most, sheet->panels[i].most_errors_rad * 57.29577951308232);
    return fmin(worst_error_deg(sheet), fmax(most, 1));
}

/* ---- the legend: the bar by the same shader function as the surfaces, degrees under it */

enum { LEGEND_STEPS = 4 };

static enum render_result draw_legend(render_device *device, const render_look *look,
    const layout *l, const render_sheet *sheet, render_picture *picture, render_error *error) {
    const float clear[4] = {0, 0, 0, 1};
    const double wide = (double)picture->width,
                 size = fmin(text_size(look), wide / 30); /* so that no two numbers touch */
    const size_t height = (size_t)lround(text_size(look)), width = picture->width * 3 / 4,
                 x = (picture->width - width) / 2,
                 y = picture->height - l->left_out - l->footer - l->keys - l->legend + height / 2;
    const render_area area = {x, y, width, height};
    const render_compiled *program;
    enum render_result result = render_target_begin(device, width, height, clear, error);
    if (!result)
        result =
            render_program_use(device, RENDER_PROGRAM_SCALE, RENDER_SPACE_WORLD, &program, error);
    if (result) return result;
    device->gl.Disable(GL_DEPTH_TEST);
    device->gl.BindVertexArray(device->empty_array);
    device->gl.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    device->gl.BindVertexArray(0);
    result = render_target_read(device, 1, picture, &area, error);
    for (int i = 0; i <= LEGEND_STEPS; ++i) {
        char degrees[32];
        const int beyond =
            i == LEGEND_STEPS && worst_error_deg(sheet) > sheet->error_top_deg * (1 + 1e-6);
        snprintf(degrees, sizeof degrees, "%.4g°%s", sheet->error_top_deg * i / LEGEND_STEPS,
            beyond ? "+" : "");
        render_text_draw(picture, degrees,
            (double)x + (double)width * i / LEGEND_STEPS - render_text_width(degrees, size) / 2,
            (double)(y + height) + 1.7 * size, size, look->ink);
    }
    return result;
}

/* ---- one scale for all panels */

static enum render_result share_scale(
    render_stage *stages, const render_sheet *sheet, render_error *error) {
    double radius = 0;
    for (size_t i = 0; i < sheet->panel_count; ++i) radius = fmax(radius, stages[i].ball.radius);
    for (size_t i = 0; i < sheet->panel_count; ++i) {
        enum render_result result = render_stage_scale(&stages[i], radius, error);
        if (result) return result;
    }
    return RENDER_OK;
}

/* Lines reach farther in one panel than in another; where all else is alike, the model does not
 * move for that. */
static render_frame frame_round(
    const render_frame *frames, const render_sheet *sheet, size_t panel) {
    const render_panel *of = &sheet->panels[panel];
    render_frame all = frames[panel];
    for (size_t k = 0; k < sheet->panel_count; ++k)
        for (int axis = 0;
             axis < 2 && memcmp(sheet->panels[k].matrix, of->matrix, sizeof of->matrix) == 0;
             ++axis) {
            all.most[axis] = fmax(all.most[axis], frames[k].most[axis]);
            all.least[axis] = fmax(all.least[axis], frames[k].least[axis]);
        }
    if (all.per[0] > 0) render_fit_frame(&all);
    return all;
}

static enum render_result share_frames(
    render_stage *stages, const render_sheet *sheet, render_error *error) {
    render_frame own[RENDER_MOST_PANELS], frames[RENDER_MOST_PANELS];
    double distance = 0;
    for (size_t i = 0; i < sheet->panel_count; ++i) {
        own[i] = render_stage_frame(&stages[i]);
        if (own[i].distance < 0) return render_fail_memory(error);
    }
    for (size_t i = 0; i < sheet->panel_count; ++i) {
        frames[i] = frame_round(own, sheet, i);
        distance = fmax(distance, frames[i].distance);
    }
    for (size_t i = 0; i < sheet->panel_count; ++i)
        render_stage_aim(&stages[i], &frames[i], distance);
    return RENDER_OK;
}

static enum render_result make_stages(render_device *device, const render_look *look,
    render_sheet *sheet, render_stage *stages, render_error *error) {
    enum render_result result = RENDER_OK;
    sheet->lines_left_out = 0;
    for (size_t i = 0; i < sheet->panel_count && !result; ++i) {
        result = render_stage_make(device, look, &sheet->panels[i], &stages[i], error);
        sheet->lines_left_out += sheet->panels[i].lines_left_out;
    }
    return result;
}

static enum render_result draw_panels(render_device *device, const render_look *look,
    render_sheet *sheet, render_stage *stages, render_picture *picture, render_error *error) {
    enum render_result result = share_scale(stages, sheet, error);
    if (!result) result = share_frames(stages, sheet, error);
    if (result) return result;
    sheet->error_top_deg =
        look->error_top_deg > 0 ? look->error_top_deg : scale_top(shown_error_deg(sheet));
    for (size_t i = 0; i < sheet->panel_count && !result; ++i) {
        stages[i].error_top_deg = sheet->error_top_deg;
        result = render_stage_draw(device, &stages[i], error);
        if (!result)
            result = render_target_read(device, look->samples, picture,
                &(render_area){sheet->panel_x[i], sheet->panel_y[i], look->width, look->height},
                error);
    }
    return result;
}

enum render_result render_sheet_draw(render_device *device, const render_look *look,
    render_sheet *sheet, render_tell *tell, void *user, render_picture *picture,
    render_error *error) {
    *picture = (render_picture){0};
    if (sheet->panel_count == 0 || sheet->panel_count > RENDER_MOST_PANELS)
        return render_fail(error, RENDER_ERROR_ARGUMENT, "%zu panels; expected 1 to %d",
            sheet->panel_count, RENDER_MOST_PANELS);
    render_stage *stages = calloc(sheet->panel_count, sizeof *stages);
    enum render_result result =
        stages ? make_stages(device, look, sheet, stages, error) : render_fail_memory(error);
    const size_t given = sheet->key_count;
    layout l = {0};
    if (!result) {
        name_colours(sheet);
        l = lay_out(look, sheet);
        result = make_picture(look, &l, sheet->panel_count, picture, error);
    }
    if (!result) result = draw_panels(device, look, sheet, stages, picture, error);
    if (!result && l.legend) result = draw_legend(device, look, &l, sheet, picture, error);
    if (!result && tell) tell(user, sheet, picture);
    if (!result) write_all_words(look, sheet, &l, picture);
    if (!result && l.keys) write_keys(look, sheet, &l, picture);
    for (size_t i = 0; stages && i < sheet->panel_count; ++i) render_stage_free(&stages[i]);
    free(stages);
    sheet->key_count = given;
    if (result) render_picture_free(picture);
    return result;
}
