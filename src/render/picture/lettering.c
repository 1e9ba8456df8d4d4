/* lettering.c: words in a picture: the strokes of a font as lines of even width with round ends,
 * their borders as smooth as their distance says. */
#include "render/picture/font.h"
#include "render/picture/picture.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The next character of UTF-8 text; what is no UTF-8 counts byte for byte, as '?'. */
static uint32_t next_character(const char **text) {
    const unsigned char *at = (const unsigned char *)*text;
    int more = at[0] >= 0xF0 ? 3 : at[0] >= 0xE0 ? 2 : at[0] >= 0xC0 ? 1 : 0;
    uint32_t character = more ? at[0] & (0x3FU >> more) : at[0];
    for (int i = 1; i <= more; ++i) {
        if ((at[i] & 0xC0) != 0x80) {
            ++*text;
            return '?';
        }
        character = character << 6 | (at[i] & 0x3FU);
    }
    *text += more + 1;
    return character;
}

static const char *glyph_of(uint32_t character) {
    if (character >= RENDER_FIRST_GLYPH && character < RENDER_FIRST_GLYPH + RENDER_GLYPHS)
        return render_glyphs[character - RENDER_FIRST_GLYPH];
    for (size_t i = 0; i < sizeof render_extra_glyphs / sizeof *render_extra_glyphs; ++i)
        if (render_extra_glyphs[i].character == character) return render_extra_glyphs[i].glyph;
    return render_glyphs['?' - RENDER_FIRST_GLYPH];
}

static double unit_of(double size) { return size / (RENDER_GLYPH_BOTTOM - RENDER_GLYPH_TOP); }

double render_text_width(const char *text, double size) {
    double units = 0;
    while (*text) {
        const char *glyph = glyph_of(next_character(&text));
        units += glyph[1] - glyph[0];
    }
    return units * unit_of(size);
}

/* ---- coverage: how much of each pixel of a box is ink */

typedef struct coverage {
    long left, top, width, height;
    float *ink;
    double half_width;
} coverage;

static double distance_to(double x, double y, double ax, double ay, double bx, double by) {
    const double dx = bx - ax, dy = by - ay, squared = dx * dx + dy * dy;
    double t = squared > 0 ? ((x - ax) * dx + (y - ay) * dy) / squared : 0;
    t = fmax(0, fmin(1, t));
    return hypot(x - ax - t * dx, y - ay - t * dy);
}

static void stroke(coverage *c, double ax, double ay, double bx, double by) {
    const double reach = c->half_width + 1;
    const long x0 = (long)floor(fmin(ax, bx) - reach), x1 = (long)ceil(fmax(ax, bx) + reach),
               y0 = (long)floor(fmin(ay, by) - reach), y1 = (long)ceil(fmax(ay, by) + reach);
    for (long y = y0 > c->top ? y0 : c->top; y < y1 && y < c->top + c->height; ++y)
        for (long x = x0 > c->left ? x0 : c->left; x < x1 && x < c->left + c->width; ++x) {
            float *ink = &c->ink[(y - c->top) * c->width + x - c->left];
            const double covered =
                c->half_width + 0.5 - distance_to((double)x + 0.5, (double)y + 0.5, ax, ay, bx, by);
            *ink = fmaxf(*ink, (float)fmax(0, fmin(1, covered)));
        }
}

static void strokes(coverage *c, const char *text, double x, double y, double unit) {
    while (*text) {
        const char *glyph = glyph_of(next_character(&text));
        const double origin = x - (glyph[0] - 'R') * unit;
        double last_x = 0, last_y = 0;
        int down = 0;
        for (const char *at = glyph + 2; at[0] && at[1]; at += 2) {
            if (at[0] == ' ') {
                down = 0;
                continue;
            }
            const double px = origin + (at[0] - 'R') * unit,
                         py = y + (at[1] - 'R' - RENDER_GLYPH_BOTTOM) * unit;
            if (down) stroke(c, last_x, last_y, px, py);
            last_x = px;
            last_y = py;
            down = 1;
        }
        x += (glyph[1] - glyph[0]) * unit;
    }
}

static void blend(render_picture *picture, const coverage *c, const uint8_t ink[3]) {
    for (long y = 0; y < c->height; ++y)
        for (long x = 0; x < c->width; ++x) {
            uint8_t *pixel = picture->pixels +
                             4 * ((size_t)(c->top + y) * picture->width + (size_t)(c->left + x));
            const double a = (double)c->ink[y * c->width + x], under = pixel[3] / 255.0 * (1 - a),
                         alpha = a + under;
            for (int k = 0; k < 3 && alpha > 0; ++k)
                pixel[k] = (uint8_t)lround((a * ink[k] + under * pixel[k]) / alpha);
            pixel[3] = (uint8_t)lround(alpha * 255);
        }
}

void render_text_draw(render_picture *picture, const char *text, double x, double y, double size,
    const uint8_t ink[3]) {
    const double unit = unit_of(size);
    coverage c = {.left = (long)floor(x - size),
        .top = (long)floor(y - 2 * size),
        .half_width = fmax(0.55, 0.055 * size)};
    long right = (long)ceil(x + render_text_width(text, size) + size),
         bottom = (long)ceil(y + size);
    c.left = c.left > 0 ? c.left : 0;
    c.top = c.top > 0 ? c.top : 0;
    right = right < (long)picture->width ? right : (long)picture->width;
    bottom = bottom < (long)picture->height ? bottom : (long)picture->height;
    c.width = right - c.left;
    c.height = bottom - c.top;
    if (c.width <= 0 || c.height <= 0) return;
    c.ink = calloc((size_t)c.width * (size_t)c.height, sizeof *c.ink);
    if (!c.ink) return;
    strokes(&c, text, x, y, unit);
    blend(picture, &c, ink);
    free(c.ink);
}
