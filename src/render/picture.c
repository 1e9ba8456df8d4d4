/* picture.c: pictures in memory: letters on them, and PNG files of them. */
#include "render/parts.h"
#include "io/image/image.h"
#include "render/outlines.h"
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

/* ---- Words in a picture: the outlines of a font, filled, each pixel as far as it is within. */

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
    if (character >= RENDER_FIRST_OUTLINE && character < RENDER_FIRST_OUTLINE + RENDER_OUTLINES)
        return render_outlines[character - RENDER_FIRST_OUTLINE];
    for (size_t i = 0; i < sizeof render_extra_outlines / sizeof *render_extra_outlines; ++i)
        if (render_extra_outlines[i].character == character) return render_extra_outlines[i].glyph;
    return render_outlines['?' - RENDER_FIRST_OUTLINE];
}

static double unit_of(double size) { return size / RENDER_CAPITALS; }

static int outline_number(const char *letters) {
    const int first = letters[0] - '#' - (letters[0] > '?'),
              second = letters[1] - '#' - (letters[1] > '?');
    return first * RENDER_OUTLINE_BASE + second - RENDER_OUTLINE_OFFSET;
}

double render_text_width(const char *text, double size) {
    double units = 0;
    while (*text) units += outline_number(glyph_of(next_character(&text)));
    return units * unit_of(size);
}

/* ---- coverage: how much of each pixel of a box is ink */

typedef struct coverage {
    long left, top, width, height;
    float *ink; /* of rows longer by two */
} coverage;

typedef struct pen { /* glyphs' units to pixels of the box */
    double x, y, unit;
} pen;

/* What lies to the right of an edge is within, or, where the edge goes up, no more: each of a
 * pixel's rows adds its share where it crosses, and sums from the left tell how much is ink. */
static void add_edge(coverage *c, const double a[2], const double b[2]) {
    enum { ROWS = 16 };
    const double *upper = a[1] < b[1] ? a : b, *lower = a[1] < b[1] ? b : a;
    const float share = (a[1] < b[1] ? 1.0F : -1.0F) / ROWS;
    const long end = (long)ceil(fmin(lower[1], (double)c->height) * ROWS - 0.5);
    for (long row = (long)ceil(fmax(upper[1], 0) * ROWS - 0.5); row < end; ++row) {
        const double t = (((double)row + 0.5) / ROWS - upper[1]) / (lower[1] - upper[1]),
                     x = fmin(fmax(upper[0] + t * (lower[0] - upper[0]), 0), (double)c->width),
                     whole = floor(x);
        float *ink = c->ink + row / ROWS * (c->width + 2) + (long)whole;
        ink[0] += share * (float)(1 - (x - whole));
        ink[1] += share * (float)(x - whole);
    }
}

static void add_curve(coverage *c, const double from[2], const double by[2], const double to[2]) {
    enum { PARTS = 6 };
    double last[2] = {from[0], from[1]}, next[2];
    for (int i = 1; i <= PARTS; ++i) {
        const double t = (double)i / PARTS, u = 1 - t;
        for (int k = 0; k < 2; ++k) next[k] = u * u * from[k] + 2 * u * t * by[k] + t * t * to[k];
        add_edge(c, last, next);
        memcpy(last, next, sizeof last);
    }
}

static const char *read_point(const pen *p, const char *letters, double point[2]) {
    point[0] = p->x + outline_number(letters) * p->unit;
    point[1] = p->y - outline_number(letters + 2) * p->unit;
    return letters + 4;
}

static void add_glyph(coverage *c, const pen *p, const char *glyph) {
    double start[2] = {0}, last[2] = {0}, by[2], next[2];
    for (const char *at = glyph + 4; *at;) {
        const char part = *at++;
        if (part == 'm') {
            add_edge(c, last, start); /* the outline before it is closed */
            at = read_point(p, at, start);
            memcpy(last, start, sizeof last);
            continue;
        }
        if (part == 'q') at = read_point(p, at, by);
        at = read_point(p, at, next);
        if (part == 'q')
            add_curve(c, last, by, next);
        else
            add_edge(c, last, next);
        memcpy(last, next, sizeof last);
    }
    add_edge(c, last, start);
}

static void sum_ink(coverage *c) {
    for (long y = 0; y < c->height; ++y) {
        float sum = 0, *row = c->ink + y * (c->width + 2);
        for (long x = 0; x < c->width; ++x) {
            sum += row[x];
            row[x] = fminf(fabsf(sum), 1);
        }
    }
}

static void blend(render_picture *picture, const coverage *c, const uint8_t ink[3]) {
    for (long y = 0; y < c->height; ++y)
        for (long x = 0; x < c->width; ++x) {
            uint8_t *pixel = picture->pixels +
                             4 * ((size_t)(c->top + y) * picture->width + (size_t)(c->left + x));
            const double a = (double)c->ink[y * (c->width + 2) + x],
                         under = pixel[3] / 255.0 * (1 - a), alpha = a + under;
            for (int k = 0; k < 3 && alpha > 0; ++k)
                pixel[k] = (uint8_t)lround((a * ink[k] + under * pixel[k]) / alpha);
            pixel[3] = (uint8_t)lround(alpha * 255);
        }
}

void render_text_draw(render_picture *picture, const char *text, double x, double y, double size,
    const uint8_t ink[3]) {
    coverage c = {.left = (long)floor(x - size), .top = (long)floor(y - 2 * size)};
    long right = (long)ceil(x + render_text_width(text, size) + size),
         bottom = (long)ceil(y + size);
    c.left = c.left > 0 ? c.left : 0;
    c.top = c.top > 0 ? c.top : 0;
    right = right < (long)picture->width ? right : (long)picture->width;
    bottom = bottom < (long)picture->height ? bottom : (long)picture->height;
    c.width = right - c.left;
    c.height = bottom - c.top;
    if (c.width <= 0 || c.height <= 0) return;
    c.ink = calloc(((size_t)c.width + 2) * (size_t)c.height, sizeof *c.ink);
    if (!c.ink) return;
    pen p = {x - (double)c.left, round(y) - (double)c.top, unit_of(size)};
    while (*text) {
        const char *glyph = glyph_of(next_character(&text));
        add_glyph(&c, &p, glyph);
        p.x += outline_number(glyph) * p.unit;
    }
    sum_ink(&c);
    blend(picture, &c, ink);
    free(c.ink);
}

/* ---- A picture as PNG bytes in memory. Its chunk sRGB says what the numbers mean. */

enum render_result render_png_encode(
    const render_picture *picture, render_png *out, render_error *error) {
    growing_bytes bytes = {0};
    const int failed = norma_image_write_srgb(
                           picture->pixels, picture->width, picture->height, &bytes) != IMAGE_OK;
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

float render_linear(uint32_t level) { return (float)decoded(level / 255.0); }

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

enum render_result render_fail_core(norma_result result, render_error *error) {
    if (!result) return RENDER_OK;
    return result == NORMA_ERROR_MEMORY
               ? render_fail_memory(error)
               : render_fail(error, RENDER_ERROR_ARGUMENT, "%s", norma_result_text(result));
}
