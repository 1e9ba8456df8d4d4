/* acid_labels.c: words as triangles: each stroke of a letter becomes a thin rectangle. The letters
 * are those that norma render writes with. */
#include "acid/acid_labels.h"
#include "render/picture/font.h"
#include <stdlib.h>
#include <string.h>

enum { MOST_STROKES = 65535 / 4 };

static const char *glyph_of_letter(char letter) {
    const int index = (unsigned char)letter - RENDER_FIRST_GLYPH;
    return render_glyphs[index >= 0 && index < RENDER_GLYPHS ? index : '?' - RENDER_FIRST_GLYPH];
}

static double letter_unit(double size) { return size / (RENDER_GLYPH_BOTTOM - RENDER_GLYPH_TOP); }

static double words_width(const char *text, size_t length, double size) {
    double units = 0;
    for (size_t i = 0; i < length; ++i) {
        const char *glyph = glyph_of_letter(text[i]);
        units += glyph[1] - glyph[0];
    }
    return units * letter_unit(size);
}

static int make_room(acid_ink *ink) {
    if (ink->strokes < ink->capacity) return 1;
    const size_t capacity = ink->capacity ? 2 * ink->capacity : 256;
    float *positions = realloc(ink->positions, capacity * 12 * sizeof *positions);
    if (positions) ink->positions = positions;
    uint16_t *indices = realloc(ink->indices, capacity * 6 * sizeof *indices);
    if (indices) ink->indices = indices;
    ink->failed |= !positions || !indices || ink->strokes == MOST_STROKES;
    if (!ink->failed) ink->capacity = capacity;
    return !ink->failed;
}

/* Both ends reach half a width further, so that strokes meet. */
static void add_stroke(acid_ink *ink, const double a[2], const double b[2], double half) {
    const double dx = b[0] - a[0], dy = b[1] - a[1], length = sqrt(dx * dx + dy * dy);
    if (!(length > 0) || !make_room(ink)) return;
    const double ux = half * dx / length, uy = half * dy / length;
    const double corners[4][2] = {{a[0] - ux + uy, a[1] - uy - ux},
        {b[0] + ux + uy, b[1] + uy - ux}, {b[0] + ux - uy, b[1] + uy + ux},
        {a[0] - ux - uy, a[1] - uy + ux}};
    static const uint16_t order[6] = {0, 1, 2, 0, 2, 3};
    for (size_t i = 0; i < 4; ++i) {
        float *to = ink->positions + 12 * ink->strokes + 3 * i;
        to[0] = (float)corners[i][0];
        to[1] = (float)corners[i][1];
        to[2] = 0;
    }
    for (size_t i = 0; i < 6; ++i)
        ink->indices[6 * ink->strokes + i] = (uint16_t)(4 * ink->strokes + order[i]);
    ++ink->strokes;
}

static void write_letter(acid_ink *ink, const char *glyph, double x, double y, double size) {
    const double unit = letter_unit(size), half = 0.055 * size;
    double last[2] = {0, 0};
    int down = 0;
    for (const char *at = glyph + 2; at[0] && at[1]; at += 2) {
        if (at[0] == ' ') {
            down = 0;
            continue;
        }
        const double point[2] = {
            x + (at[0] - glyph[0]) * unit, y - (at[1] - 'R' - RENDER_GLYPH_BOTTOM) * unit};
        if (down) add_stroke(ink, last, point, half);
        memcpy(last, point, sizeof last);
        down = 1;
    }
}

static void write_span(
    acid_ink *ink, const char *text, size_t length, double x, double y, double size) {
    for (size_t i = 0; i < length; ++i) {
        write_letter(ink, glyph_of_letter(text[i]), x, y, size);
        x += words_width(text + i, 1, size);
    }
}

void acid_write_words(acid_ink *ink, const char *text, double x, double y, double size) {
    write_span(ink, text, strlen(text), x, y, size);
}

void acid_write_lines(
    acid_ink *ink, const char *text, double x, double y, double size, double width) {
    while (*text) {
        size_t taken = 0;
        for (size_t i = 1; i <= strlen(text); ++i)
            if ((!text[i] || text[i - 1] == '-') && (!taken || words_width(text, i, size) <= width))
                taken = i;
        write_span(ink, text, taken, x, y, size);
        text += taken;
        y -= 1.45 * size;
    }
}

void acid_free_ink(acid_ink *ink) {
    free(ink->positions);
    free(ink->indices);
    *ink = (acid_ink){0};
}
