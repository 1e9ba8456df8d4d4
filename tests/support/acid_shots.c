/* See acid_shots.h. */
#define _GNU_SOURCE /* strtok_r */
#include "acid_shots.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <jpeglib.h> /* after those it needs */

const char *const acid_curve_names[ACID_CURVES] = {"none", "Reinhard", "ACES", "AgX"};

/* ---- the layout: cells in four columns, patches of a cell in a row */

static const char *const table[] = {"control", "rotation object-space",
    "uniform-scale not-normalized", "non-uniform-scale model-matrix not-normalized object-space",
    "shear model-matrix separate-scale", "mirror reversed model-matrix",
    "mirror-double-sided reversed", "mirror-twice reversed", "flattened lost",
    "instanced model-matrix instance-ignored", "instanced-mirror reversed",
    "skinned model-matrix node-applied", "skinned-blend model-matrix strongest-joint",
    "skinned-mirror reversed", "morph normals-not-morphed not-normalized", "quantized model-matrix",
    "flat smoothed", "back-side not-flipped", "tangent-absent sign-lost",
    "tangent-sign sign-lost green-flipped", "tangent-non-uniform tangent-by-normal-matrix",
    "tangent-mirror sign-kept", "tangent-skinned tangent-by-normal-matrix",
    "normal-scale scale-ignored scale-on-z"};
enum { ROWS = sizeof table / sizeof *table, COLUMNS = 4 };

int acid_shots_layout(acid_layout *layout) {
    static const double at[ACID_MARKS][2] = {
        {0.03, 0.04}, {0.97, 0.04}, {0.97, 0.96}, {0.03, 0.96}};
    const double size = 0.038;
    *layout = (acid_layout){.rows = calloc(ROWS, sizeof *layout->rows), .row_count = ROWS};
    for (int i = 0; i < ACID_MARKS; ++i)
        layout->marks[i] = (acid_box){{at[i][0], at[i][1]}, {0.03, 0.04}};
    for (int i = 0; i < ROWS && layout->rows; ++i) {
        acid_row *row = &layout->rows[i];
        const double x = 0.08 + 0.23 * (i % COLUMNS), y = 0.14 + 0.14 * (i / COLUMNS);
        char words[128], *rest = words;
        snprintf(words, sizeof words, "%s", table[i]);
        snprintf(row->id, sizeof row->id, "%s", strtok_r(rest, " ", &rest));
        row->subject = (acid_box){{x, y}, {size, size * 4 / 3}};
        for (const char *id = "right"; id; id = strtok_r(rest, " ", &rest)) {
            acid_place *place = &row->references[row->reference_count++];
            snprintf(place->id, sizeof place->id, "%s", id);
            place->box = row->subject;
            place->box.center[0] += 1.15 * size * (double)row->reference_count;
        }
    }
    return layout->rows != NULL;
}

/* ---- normals */

static void unit(double n[3]) {
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3 && length > 0; ++k) n[k] /= length;
}

/* An egg with a ridge and a dent, by the slopes of its height: u, v from -1 to 1, v downwards. */
static void surface_normal(double u, double v, double n[3]) {
    const double egg = 1.1 * exp(-1.6 * (u * u + 1.5 * v * v + 0.5 * u * v)),
                 ridge = 0.25 * exp(-40 * (v - 0.5 * u - 0.2) * (v - 0.5 * u - 0.2)), du = u - 0.35,
                 dv = v + 0.4, dent = -0.35 * exp(-14 * (du * du + dv * dv));
    const double across = egg * -1.6 * (2 * u + 0.5 * v) + ridge * 40 * (v - 0.5 * u - 0.2) +
                          dent * -28 * du,
                 down = egg * -1.6 * (3 * v + 0.5 * u) - ridge * 80 * (v - 0.5 * u - 0.2) +
                        dent * -28 * dv;
    n[0] = -across;
    n[1] = down; /* y upwards */
    n[2] = 1;
    unit(n);
}

static void turn(double n[3], int axis, double degrees) {
    const double c = cos(degrees / 57.29577951308232), s = sin(degrees / 57.29577951308232);
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    const double x = n[a], y = n[b];
    n[a] = c * x - s * y;
    n[b] = s * x + c * y;
}

static void stretch(double n[3], double x, double y, double z, double degrees) {
    turn(n, 2, degrees);
    n[0] *= x;
    n[1] *= y;
    n[2] *= z;
    turn(n, 2, -degrees);
    unit(n);
}

/* The normal that a mistake gives in place of the right one. *light: by which the light is off. */
static void mistaken_normal(const char *id, double u, double n[3], double *light) {
    if (strcmp(id, "object-space") == 0) {
        turn(n, 2, 50);
        turn(n, 0, 20);
    } else if (strcmp(id, "model-matrix") == 0) {
        stretch(n, 4, 1, 0.6, 20);
    } else if (strcmp(id, "separate-scale") == 0) {
        stretch(n, 1, 2.2, 1, -30);
    } else if (strcmp(id, "not-normalized") == 0) {
        *light = 0.35;
    } else if (strcmp(id, "reversed") == 0 || strcmp(id, "not-flipped") == 0) {
        for (int k = 0; k < 3; ++k) n[k] = -n[k];
    } else if (strcmp(id, "lost") == 0) {
        *light = 0;
    } else if (strcmp(id, "instance-ignored") == 0 || strcmp(id, "node-applied") == 0) {
        turn(n, 2, -60);
    } else if (strcmp(id, "strongest-joint") == 0) {
        turn(n, 1, u > 0 ? 25 : -25);
    } else if (strcmp(id, "normals-not-morphed") == 0 || strcmp(id, "scale-ignored") == 0) {
        n[2] *= 2.2;
    } else if (strcmp(id, "scale-on-z") == 0) {
        n[2] *= 0.4;
    } else if (strcmp(id, "smoothed") == 0) {
        n[2] += 0.9;
    } else if (strcmp(id, "sign-lost") == 0) {
        if (u > 0) n[1] = -n[1];
    } else if (strcmp(id, "green-flipped") == 0) {
        n[1] = -n[1];
    } else if (strcmp(id, "tangent-by-normal-matrix") == 0) {
        turn(n, 2, 25);
    } else if (strcmp(id, "sign-kept") == 0) {
        n[0] = -n[0];
    } else if (strcmp(id, "other") == 0) {
        turn(n, 2, 130);
        turn(n, 0, -30);
    }
    unit(n);
}

/* ---- light */

static void shade(const acid_shot *shot, const double n[3], double light, double color[3]) {
    static const double to_light[3][3] = {{-0.7, 0.3, 0.65}, {0.7, 0.35, 0.6}, {0.05, -0.75, 0.65}};
    for (int k = 0; k < 3; ++k) {
        double dot = 0;
        for (int i = 0; i < 3; ++i) dot += to_light[k][i] * n[i];
        const double sky = 0.5 + 0.5 * n[1], white = k == 2 ? 1 : 0.8;
        color[k] =
            light * (0.9 * fmax(0, dot) + shot->environment * (sky * white + (1 - sky) * 0.3));
    }
}

static double aces(double x) { /* Narkowicz 2015 */
    return fmin(1, x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14));
}

static void tone(const acid_shot *shot, double color[3]) {
    double mean = 0;
    for (int k = 0; k < 3; ++k) {
        color[k] *= shot->exposure;
        mean += color[k] / 3;
    }
    for (int k = 0; k < 3; ++k) {
        double c = color[k];
        if (shot->curve == 1) c = c / (1 + c);
        if (shot->curve == 2) c = aces(0.8 * c);
        if (shot->curve == 3) { /* colours run into each other, then a soft curve */
            c = 0.8 * c + 0.2 * mean;
            c = c * (1 + c / 9) / (1 + c);
        }
        color[k] = fmin(1, c);
    }
}

static void background_color(const acid_shot *shot, double y, double color[3]) {
    static const double plain[5][3] = {
        {0, 0, 0}, {1, 1, 1}, {0.2, 0.2, 0.2}, {0.3, 0.5, 0.8}, {0.02, 0.03, 0.12}};
    for (int k = 0; k < 3; ++k) {
        color[k] = plain[shot->background][k];
        if (shot->background == 3) color[k] += (0.9 - color[k]) * fmax(0, fmin(1, y));
    }
}

/* ---- what lies at a point of the unit square */

static int within(const acid_box *box, const double p[2], double local[2]) {
    for (int k = 0; k < 2; ++k) {
        local[k] = 2 * (p[k] - box->center[k]) / box->size[k];
        if (fabs(local[k]) > 1) return 0;
    }
    return 1;
}

static void patch_color(
    const acid_shot *shot, const char *shows, const double local[2], double color[3]) {
    double n[3], light = 1;
    surface_normal(local[0], local[1], n);
    mistaken_normal(shows, local[0], n, &light);
    shade(shot, n, light, color);
    tone(shot, color);
}

static const char *shown_by(const acid_shot *shot, const acid_layout *layout, size_t row) {
    const int what = shot->shows[row];
    return what >= 0 ? layout->rows[row].references[what].id : "other";
}

static void color_at(
    const acid_shot *shot, const acid_layout *layout, const double p[2], double color[3]) {
    static const double marks[ACID_MARKS][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}};
    double local[2];
    background_color(shot, p[1], color);
    for (int i = 0; i < ACID_MARKS; ++i)
        if (within(&layout->marks[i], p, local)) {
            memcpy(color, marks[i], sizeof marks[i]);
            if (shot->marks_toned) tone(shot, color);
        }
    for (size_t i = 0; i < layout->row_count; ++i) {
        const acid_row *row = &layout->rows[i];
        if (fabs(p[1] - row->subject.center[1]) > row->subject.size[1]) continue;
        if (within(&row->subject, p, local) && shot->shows[i] != ACID_SHOWS_NOTHING)
            patch_color(shot, shown_by(shot, layout, i), local, color);
        for (size_t k = 0; k < row->reference_count; ++k)
            if (within(&row->references[k].box, p, local))
                patch_color(shot, row->references[k].id, local, color);
    }
}

/* ---- the camera: from pixels to the unit square (Heckbert 1989, square to quadrilateral,
 * inverted) */

static void pixels_to_unit(const double c[4][2], double m[9]) {
    const double dx1 = c[1][0] - c[2][0], dx2 = c[3][0] - c[2][0],
                 sx = c[0][0] - c[1][0] + c[2][0] - c[3][0], dy1 = c[1][1] - c[2][1],
                 dy2 = c[3][1] - c[2][1], sy = c[0][1] - c[1][1] + c[2][1] - c[3][1],
                 d = dx1 * dy2 - dx2 * dy1, g = (sx * dy2 - dx2 * sy) / d,
                 h = (dx1 * sy - sx * dy1) / d;
    const double f[9] = {c[1][0] - c[0][0] + g * c[1][0], c[3][0] - c[0][0] + h * c[3][0], c[0][0],
        c[1][1] - c[0][1] + g * c[1][1], c[3][1] - c[0][1] + h * c[3][1], c[0][1], g, h, 1};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 3; ++column) {
            const int a = (column + 1) % 3, b = (column + 2) % 3, p = (row + 1) % 3,
                      q = (row + 2) % 3;
            m[3 * row + column] = f[3 * a + p] * f[3 * b + q] - f[3 * a + q] * f[3 * b + p];
        }
}

static uint32_t next_random(uint32_t *seed) {
    *seed = *seed * 1664525u + 1013904223u;
    return *seed >> 8;
}
static double between(uint32_t *seed, double least, double most) {
    return least + (most - least) * next_random(seed) / (1 << 24);
}

static void draw(const acid_shot *shot, const acid_layout *layout, acid_picture *picture) {
    const int taps = shot->antialias ? 2 : 1;
    double m[9], last[3] = {-1, -1, -1}, encoded[3] = {0};
    uint32_t seed = shot->seed;
    pixels_to_unit(shot->corners, m);
    for (size_t i = 0; i < shot->width * shot->height; ++i) {
        double sum[3] = {0};
        for (int tap = 0; tap < taps * taps; ++tap) {
            const double x = (double)(i % shot->width) + (tap % taps + 0.5) / taps,
                         y = (double)(i / shot->width) + (tap / taps + 0.5) / taps,
                         w = m[6] * x + m[7] * y + m[8],
                         p[2] = {
                             (m[0] * x + m[1] * y + m[2]) / w, (m[3] * x + m[4] * y + m[5]) / w};
            double color[3];
            color_at(shot, layout, p, color);
            for (int k = 0; k < 3; ++k) {
                if (color[k] != last[k]) encoded[k] = pow(last[k] = color[k], 1 / shot->gamma);
                sum[k] += encoded[k];
            }
        }
        for (int k = 0; k < 3; ++k) {
            const double level =
                255 * sum[k] / (taps * taps) + between(&seed, -shot->noise, shot->noise);
            picture->pixels[3 * i + (size_t)k] = (uint8_t)lround(fmax(0, fmin(255, level)));
        }
    }
}

/* ---- a JPEG on the way */

static int compress(acid_picture *picture, int quality) {
    struct jpeg_compress_struct to;
    struct jpeg_error_mgr errors;
    unsigned char *bytes = NULL;
    unsigned long size = 0;
    to.err = jpeg_std_error(&errors);
    jpeg_create_compress(&to);
    jpeg_mem_dest(&to, &bytes, &size);
    to.image_width = (JDIMENSION)picture->width;
    to.image_height = (JDIMENSION)picture->height;
    to.input_components = 3;
    to.in_color_space = JCS_RGB;
    jpeg_set_defaults(&to);
    jpeg_set_quality(&to, quality, TRUE);
    jpeg_start_compress(&to, TRUE);
    while (to.next_scanline < to.image_height) {
        JSAMPROW row = picture->pixels + 3 * picture->width * to.next_scanline;
        jpeg_write_scanlines(&to, &row, 1);
    }
    jpeg_finish_compress(&to);
    jpeg_destroy_compress(&to);
    free(picture->pixels);
    const int read = acid_read_picture(bytes, size, picture) == IMAGE_OK;
    free(bytes);
    return read;
}

int acid_shot_take(const acid_shot *shot, const acid_layout *layout, acid_picture *picture) {
    *picture = (acid_picture){shot->width, shot->height, malloc(3 * shot->width * shot->height)};
    if (!picture->pixels) return 0;
    draw(shot, layout, picture);
    return !shot->quality || compress(picture, shot->quality);
}

/* ---- which distortions */

int acid_shot_can_name(const acid_shot *shot, const acid_layout *layout, size_t row) {
    const char *id = layout->rows[row].id;
    if (shot->shows[row] == ACID_SHOWS_NOTHING) /* on black, and on white */
        return !(shot->background == 0 && strcmp(id, "tangent-mirror") == 0) &&
               !(shot->background == 1 && strcmp(id, "quantized") == 0);
    const char *shows = shown_by(shot, layout, row);
    const int is_kept = strcmp(shows, "sign-kept") == 0;
    if (!is_kept && strcmp(shows, "scale-on-z") != 0) return 1;
    for (size_t i = 0; i < layout->row_count; ++i)
        if (strcmp(layout->rows[i].id, "tangent-sign") == 0)
            return is_kept ? shot->shows[i] == 0 : shot->shows[i] >= 0;
    return 0;
}

static int choose_shown(uint32_t *seed, const acid_row *row) {
    const double dice = between(seed, 0, 1);
    if (strcmp(row->id, "control") == 0 || dice < 0.3) return 0;
    if (dice < 0.36) return ACID_SHOWS_NOTHING;
    if (dice < 0.42) return ACID_SHOWS_OTHER;
    return 1 + (int)(next_random(seed) % (row->reference_count - 1));
}

void acid_shot_choose(acid_shot *shot, const acid_layout *layout, uint32_t number) {
    uint32_t seed = number * 2654435761u + 12345;
    for (int i = 0; i < 4; ++i) next_random(&seed);
    const double scale = exp(between(&seed, log(640), log(2000))), tall = scale * 0.75;
    *shot = (acid_shot){.curve = (int)(next_random(&seed) % ACID_CURVES),
        .exposure = exp(between(&seed, log(0.6), log(1.6))),
        .gamma = between(&seed, 1.8, 2.4),
        .environment = next_random(&seed) % 2 ? between(&seed, 0, 0.4) : 0,
        .quality = next_random(&seed) % 4 ? (int)between(&seed, 60, 96) : 0,
        .antialias = next_random(&seed) % 2 == 0,
        .background = (int)(next_random(&seed) % 5),
        .marks_toned = next_random(&seed) % 2 == 0,
        .noise = next_random(&seed) % 2 ? between(&seed, 0, 6) : 0,
        .seed = number};
    /* From a crop that just keeps the marks to borders of a third. */
    const double left = scale * between(&seed, -0.012, 0.3),
                 top = tall * between(&seed, -0.015, 0.3), lean = next_random(&seed) % 2 ? 0.02 : 0;
    shot->width = (size_t)(scale + left + scale * (lean + between(&seed, -0.012, 0.3)));
    shot->height = (size_t)(tall + top + tall * (lean + between(&seed, -0.015, 0.3)));
    for (int i = 0; i < 4; ++i) {
        shot->corners[i][0] =
            left + scale * (i == 1 || i == 2) + (lean > 0 ? scale * between(&seed, 0, lean) : 0);
        shot->corners[i][1] =
            top + tall * (i >= 2) + (lean > 0 ? tall * between(&seed, 0, lean) : 0);
    }
    for (size_t i = 0; i < layout->row_count; ++i)
        shot->shows[i] = choose_shown(&seed, &layout->rows[i]);
}
