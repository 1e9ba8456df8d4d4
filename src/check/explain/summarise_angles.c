/* summarise_angles.c: mean, percentiles and histogram of the angles between stored and computed
 * normals. */
#include "core/face/triangle.h"
#include "check/explain/explain_normals.h"
#include <math.h>
#include <string.h>

/* Angles that are not negative; their bits, read as integers, have their order. */

enum { CORNERS_IN_BLOCK = 1 << 16, HALVES = 1 << 16 };

static const double bounds_deg[NORMA_DEVIATION_BINS] = {
    .01, .02, .05, .1, .2, .5, 1, 2, 5, 10, 15, 20, 30, 45, 60, 90, 120, 180};

double norma_deviation_bound_rad(size_t bin) {
    return bounds_deg[bin < NORMA_DEVIATION_BINS ? bin : NORMA_DEVIATION_BINS - 1] *
           (NORMA_PI / 180);
}

typedef struct angle_part {
    double sum, max;
    size_t count, histogram[NORMA_DEVIATION_BINS];
} angle_part;

typedef struct angle_pass {
    const explain_surface *surface;
    double bounds[NORMA_DEVIATION_BINS];
    angle_part *parts;
} angle_pass;

static size_t bin_of(const angle_pass *pass, double angle) {
    size_t bin = 0;
    while (bin + 1 < NORMA_DEVIATION_BINS && angle >= pass->bounds[bin]) bin++;
    return bin;
}

static void sum_block(void *context, size_t block) {
    const angle_pass *pass = context;
    const explain_surface *s = pass->surface;
    angle_part *part = &pass->parts[block];
    size_t count = s->checked.corner_count, begin = block * CORNERS_IN_BLOCK,
           end = count - begin < CORNERS_IN_BLOCK ? count : begin + CORNERS_IN_BLOCK;
    for (size_t c = begin; c < end; c++) {
        const double angle = (double)s->angles[c];
        if (angle < 0) continue;
        part->sum += angle;
        part->max = angle > part->max ? angle : part->max;
        part->count++;
        part->histogram[bin_of(pass, angle)]++;
    }
}

static uint32_t bits_of(float angle) {
    uint32_t bits;
    memcpy(&bits, &angle, sizeof bits);
    return bits;
}

/* The upper half of the bits of the angle of that rank, and the rank among those with the same
 * upper half. */
static uint32_t find_half(const uint32_t *counts, size_t rank, size_t *left) {
    uint32_t half = 0;
    while (rank >= counts[half]) rank -= counts[half++];
    *left = rank;
    return half;
}

static double join_halves(uint32_t upper, uint32_t lower) {
    uint32_t bits = upper << 16 | lower;
    float angle;
    memcpy(&angle, &bits, sizeof angle);
    return (double)angle;
}

/* Two ranks at once. counts: room for three times HALVES. */
static void find_percentiles(
    const explain_surface *s, uint32_t *counts, const size_t ranks[2], double angles[2]) {
    uint32_t upper[2], *lower[2] = {counts + HALVES, counts + 2 * HALVES};
    size_t left[2], none;
    memset(counts, 0, 3 * HALVES * sizeof *counts);
    for (size_t c = 0; c < s->checked.corner_count; c++)
        if (s->angles[c] >= 0) counts[bits_of(s->angles[c]) >> 16]++;
    for (int i = 0; i < 2; i++) upper[i] = find_half(counts, ranks[i], &left[i]);
    for (size_t c = 0; c < s->checked.corner_count; c++) {
        uint32_t bits = bits_of(s->angles[c]);
        for (int i = 0; i < 2; i++)
            if (bits >> 16 == upper[i]) lower[i][bits & 0xffff]++;
    }
    for (int i = 0; i < 2; i++)
        angles[i] = join_halves(upper[i], find_half(lower[i], left[i], &none));
}

static void add_part(norma_deviation *d, const angle_part *part) {
    d->mean_rad += part->sum;
    d->max_rad = fmax(d->max_rad, part->max);
    d->corners += part->count;
    for (size_t i = 0; i < NORMA_DEVIATION_BINS; i++) d->histogram[i] += part->histogram[i];
}

norma_result norma_explain_summarise(
    core_call *call, const explain_surface *surface, norma_deviation *d) {
    size_t blocks = norma_check_block_count(surface->checked.corner_count, CORNERS_IN_BLOCK);
    uint32_t *counts = norma_core_allocate(call, 3 * HALVES, sizeof *counts);
    angle_pass pass = {
        .surface = surface, .parts = norma_core_allocate(call, blocks, sizeof *pass.parts)};
    norma_result result = counts && pass.parts ? NORMA_OK : NORMA_ERROR_MEMORY;
    *d = (norma_deviation){.crease_angle_rad = NAN};
    if (!result) {
        for (size_t i = 0; i < NORMA_DEVIATION_BINS; i++)
            pass.bounds[i] = norma_deviation_bound_rad(i);
        memset(pass.parts, 0, blocks * sizeof *pass.parts);
        result = norma_core_parallel(call, blocks, sum_block, &pass);
        for (size_t i = 0; i < blocks; i++) add_part(d, &pass.parts[i]);
    }
    if (!result && d->max_rad > 0) {
        d->mean_rad /= (double)d->corners;
        double angles[2];
        find_percentiles(surface, counts,
            (const size_t[2]){(d->corners - 1) / 2, (size_t)(0.99 * (double)(d->corners - 1))},
            angles);
        d->p50_rad = angles[0];
        d->p99_rad = angles[1];
    }
    norma_core_release(call, counts, 3 * HALVES, sizeof *counts);
    norma_core_release(call, pass.parts, blocks, sizeof *pass.parts);
    return result;
}
