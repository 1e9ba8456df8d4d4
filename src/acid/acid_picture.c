/* acid_picture.c: the pixels of a screenshot, and frames that are drawn into them. */
#include "acid/acid_judge.h"
#include <math.h>
#include <stdlib.h>

/* ---- reading */

static int begin_picture(void *user, size_t width, size_t height) {
    acid_picture *picture = user;
    *picture = (acid_picture){width, height, norma_io_allocate(width * height, 3)};
    return picture->pixels != NULL;
}

static void take_row(void *user, size_t y, const uint8_t *pixels) {
    acid_picture *picture = user;
    uint8_t *to = picture->pixels + 3 * picture->width * y;
    for (size_t x = 0; x < picture->width; ++x)
        for (size_t k = 0; k < 3; ++k)
            to[3 * x + k] = (uint8_t)((pixels[4 * x + k] * pixels[4 * x + 3] + 127) / 255);
}

image_result acid_read_picture(const unsigned char *bytes, size_t size, acid_picture *picture) {
    const image_sink sink = {4, begin_picture, take_row, picture};
    *picture = (acid_picture){0};
    const image_result result = norma_image_read(bytes, size, &sink);
    if (result) {
        free(picture->pixels);
        *picture = (acid_picture){0};
    }
    return result;
}

const char *acid_picture_text(image_result result) { return norma_image_text(result); }

int acid_write_picture(const acid_picture *picture, growing_bytes *png) {
    return norma_image_write(picture->pixels, picture->width, picture->height, png) == IMAGE_OK;
}

/* ---- frames */

static void paint_dot(
    acid_picture *picture, double x, double y, double radius, const uint8_t color[3]) {
    const long left = lround(x - radius), top = lround(y - radius), side = lround(2 * radius);
    for (long row = top; row < top + side; ++row)
        for (long column = left; column < left + side; ++column) {
            if (row < 0 || column < 0 || row >= (long)picture->height ||
                column >= (long)picture->width)
                continue;
            uint8_t *pixel = picture->pixels + 3 * ((size_t)row * picture->width + (size_t)column);
            for (int k = 0; k < 3; ++k) pixel[k] = color[k];
        }
}

static void frame_box(
    acid_picture *picture, const acid_map *map, const acid_box *box, const uint8_t color[3]) {
    static const double corners[5][2] = {
        {-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}, {-0.5, -0.5}};
    double pixels[5][2];
    for (int i = 0; i < 5; ++i) {
        const double unit[2] = {box->center[0] + 1.06 * corners[i][0] * box->size[0],
            box->center[1] + 1.06 * corners[i][1] * box->size[1]};
        acid_map_point(map, unit, pixels[i]);
    }
    for (int i = 0; i < 4; ++i) {
        const double dx = pixels[i + 1][0] - pixels[i][0], dy = pixels[i + 1][1] - pixels[i][1],
                     length = hypot(dx, dy), radius = fmax(1, length / 40);
        if (!(length < 4.0 * (double)(picture->width + picture->height))) return;
        for (double t = 0; t <= length; t += 0.5)
            paint_dot(picture, pixels[i][0] + dx * t / length, pixels[i][1] + dy * t / length,
                radius, color);
    }
}

void acid_frame(acid_picture *picture, const acid_layout *layout, const acid_map *map,
    const acid_judgement *judgement) {
    static const uint8_t colors[ACID_VERDICTS][3] = {
        {0, 200, 60}, {230, 20, 20}, {150, 150, 150}, {230, 20, 20}, {150, 150, 150}};
    for (size_t i = 0; i < layout->row_count; ++i)
        frame_box(picture, map, &layout->rows[i].subject, colors[judgement->findings[i].verdict]);
}
