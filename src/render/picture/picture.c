/* picture.c: pictures in memory: letters on them, and PNG files of them. */
#include "render/picture/picture.h"
#include "io/image/image.h"
#include "io/image/png_memory.h"
#include "render/picture/font.h"
#include <stdarg.h>
#include <stdio.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Images as pictures: RGBA, eight bits each. */

static int allocate_pixels(void *user, size_t width, size_t height) {
    render_picture *picture = user;
    picture->width = width;
    picture->height = height;
    picture->pixels = malloc(4 * width * height);
    return picture->pixels != NULL;
}

static void copy_row(void *user, size_t y, const uint8_t *pixels) {
    const render_picture *picture = user;
    memcpy(picture->pixels + 4 * picture->width * y, pixels, 4 * picture->width);
}

enum render_result render_image_decode(
    const uint8_t *bytes, size_t size, render_picture *picture, render_error *error) {
    *picture = (render_picture){0};
    const image_sink sink = {4, allocate_pixels, copy_row, picture};
    const image_result result = norma_image_read(bytes, size, &sink);
    if (!result) return RENDER_OK;
    render_picture_free(picture);
    return render_fail(
        error, RENDER_ERROR_ARGUMENT, "an image cannot be decoded: %s", norma_image_text(result));
}

/* ---- Words in a picture: the strokes of a font as lines of even width with round ends,
 * their borders as smooth as their distance says. */

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

/* ---- A picture as PNG bytes in memory. Its chunk sRGB says what the numbers mean. */

static int is_opaque(const render_picture *picture) {
    for (size_t i = 0; i < picture->width * picture->height; ++i)
        if (picture->pixels[4 * i + 3] != 255) return 0;
    return 1;
}

static void write_png_rows(png_structp png, png_infop info, const void *job) {
    const render_picture *picture = job;
    const int opaque = is_opaque(picture);
    png_set_IHDR(png, info, (png_uint_32)picture->width, (png_uint_32)picture->height, 8,
        opaque ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_NONE,
        PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_filter(png, PNG_FILTER_TYPE_BASE,
        PNG_FILTER_SUB); /* even surfaces: as small as with a choice for each row, in less time */
    png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    if (opaque) png_set_filler(png, 0, PNG_FILLER_AFTER);
    for (size_t y = 0; y < picture->height; ++y)
        png_write_row(png, picture->pixels + 4 * y * picture->width);
    png_write_end(png, info);
}

enum render_result render_png_encode(
    const render_picture *picture, render_png *out, render_error *error) {
    growing_bytes bytes = {0};
    const int failed = norma_png_write(&bytes, write_png_rows, picture) != IMAGE_OK;
    if (failed) {
        free(bytes.data);
        bytes = (growing_bytes){0};
    }
    *out = (render_png){(uint8_t *)bytes.data, bytes.size};
    return failed ? render_fail_memory(error) : RENDER_OK;
}

/* ---- A picture in memory: freeing, comparing, and the two directions of sRGB. */

void render_picture_free(render_picture *picture) {
    free(picture->pixels);
    *picture = (render_picture){0};
}

int render_picture_difference(const render_picture *picture, size_t ax, size_t ay, size_t bx,
    size_t by, size_t width, size_t height) {
    int largest = 0;
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) {
            const uint8_t *a = picture->pixels + 4 * ((ay + y) * picture->width + ax + x),
                          *b = picture->pixels + 4 * ((by + y) * picture->width + bx + x);
            for (int k = 0; k < 3; ++k) {
                const int difference = abs((int)a[k] - (int)b[k]);
                largest = difference > largest ? difference : largest;
            }
        }
    return largest;
}

static double decoded(double c) { return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4); }

void render_srgb_make(render_srgb *table) {
    for (int level = 0; level < 256; ++level)
        table->linear[level] = (uint16_t)(decoded(level / 255.0) * 65535 + 0.5);
    /* The level whose light is nearest: borders lie half way between the levels, as they are
     * encoded. */
    int level = 0;
    for (int light = 0; light < 65536; ++light) {
        while (level < 255 && light / 65535.0 > decoded((level + 0.5) / 255.0)) ++level;
        table->encoded[light] = (uint8_t)level;
    }
}

/* ---- errors */

enum render_result render_fail(
    render_error *error, enum render_result result, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->message, sizeof error->message, format, arguments);
    va_end(arguments);
    error->result = result;
    return result;
}
