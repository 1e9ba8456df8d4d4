/* judge.c: which reference each subject of an acid scene looks like, in the picture's own
 * colours.
 *
 * Each patch is resampled to one small square of means, whatever its size in the picture. The
 * distance of two patches is the root mean square of their colours' difference away from the rim,
 * the least over small shifts (a homography from four marks, and the parallax of a height field,
 * are good to a pixel or a few hundredths of a patch).
 *
 * Noise is what the control, which is drawn as its reference is, differs from it by (compression),
 * or what a reference differs from itself by, sampled half a pixel beside. It adds to all squared
 * distances alike, and nearly nothing to their differences. So a subject at the part t of the way
 * from reference a to reference b has d_b^2 - d_a^2 = D^2 (1 - 2 t), where D is the distance of a
 * and b in the same picture, which tone curves, exposure and environment change as they change
 * those of the subject. It looks like a if t is less than a quarter for each b, and if what is left
 * of its distance from a beside the noise is small as well. Another mistake may be like a mistake
 * in most of the patch: so the subject must be like it where right and mistaken are alike, too.
 *
 * Mistakes that give one picture in a cell are told apart by a cell in which they do not.
 */
#include "acid/acid.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEAST_SIDE = 8, MOST_SIDE = 40, RING = 12 };

static const double near_part = 0.3, near_contrast = 0.25, most_way = 0.25, above_noise = 2,
                    alike_part = 0.25, alike_share = 0.05, least_noise = 1.0 / 255,
                    least_hiding = 0.012, hidden_share = 0.01;

typedef struct swatch { /* a patch, resampled */
    float *colors;      /* side * side * 3 */
    int inside;         /* all of it lies in the picture */
} swatch;

typedef struct judging {
    const acid_picture *picture;
    const acid_layout *layout;
    const acid_map *map;
    int side, inset; /* of swatches; cells at the rim that are not compared */
    double reach;    /* of shifts */
    double noise;
    swatch subject, beside, references[ACID_MOST_REFERENCES];
} judging;

static double squared(double x) { return x * x; }

/* ---- sampling */

static const uint8_t *pixel_at(const acid_picture *picture, double x, double y) {
    const double right = (double)picture->width - 1, bottom = (double)picture->height - 1;
    const size_t column = (size_t)fmax(0, fmin(right, x)), row = (size_t)fmax(0, fmin(bottom, y));
    return picture->pixels + 3 * (row * picture->width + column);
}

/* Adds the bilinear colour at a point; 0: it lies outside. */
static int add_sample(const judging *j, const double unit[2], double sum[3]) {
    double at[2];
    acid_map_point(j->map, unit, at);
    if (!(at[0] >= 0 && at[1] >= 0 && at[0] <= (double)j->picture->width &&
            at[1] <= (double)j->picture->height))
        return 0;
    const double x = floor(at[0] - 0.5), y = floor(at[1] - 0.5), fx = at[0] - 0.5 - x,
                 fy = at[1] - 0.5 - y;
    const uint8_t *p[4] = {pixel_at(j->picture, x, y), pixel_at(j->picture, x + 1, y),
        pixel_at(j->picture, x, y + 1), pixel_at(j->picture, x + 1, y + 1)};
    for (int k = 0; k < 3; ++k)
        sum[k] += ((p[0][k] * (1 - fx) + p[1][k] * fx) * (1 - fy) +
                      (p[2][k] * (1 - fx) + p[3][k] * fx) * fy) /
                  255;
    return 1;
}

/* The longer side of a box in pixels, and the shorter one. */
static void box_pixels(const acid_map *map, const acid_box *box, double *longer, double *shorter) {
    double sides[2][2];
    acid_map_sides(map, box, sides);
    const double a = hypot(sides[0][0], sides[0][1]), b = hypot(sides[1][0], sides[1][1]);
    *longer = fmax(a, b);
    *shorter = fmin(a, b);
}

/* beside: by how many pixels it is sampled to the right and below. */
static void take_swatch(const judging *j, const acid_box *box, double beside, swatch *to) {
    double longer, shorter;
    box_pixels(j->map, box, &longer, &shorter);
    const int taps = (int)fmax(1, fmin(8, ceil(longer / j->side)));
    const double aside = beside / longer;
    to->inside = 1;
    for (int y = 0; y < j->side; ++y)
        for (int x = 0; x < j->side; ++x) {
            double sum[3] = {0};
            for (int tap = 0; tap < taps * taps; ++tap) {
                const double u = aside + (x + (tap % taps + 0.5) / taps) / j->side - 0.5,
                             v = aside + (y + (tap / taps + 0.5) / taps) / j->side - 0.5,
                             unit[2] = {box->center[0] + u * box->size[0],
                                 box->center[1] + v * box->size[1]};
                if (!add_sample(j, unit, sum)) to->inside = 0;
            }
            for (int k = 0; k < 3; ++k)
                to->colors[3 * (y * j->side + x) + k] = (float)(sum[k] / (taps * taps));
        }
}

/* ---- distances */

/* From (left, top) to behind (right, bottom). */
static double distance_at(const judging *j, const swatch *a, const swatch *b, const double shift[2],
    int left, int top, int right, int bottom) {
    const int fx = (int)floor(shift[0]), fy = (int)floor(shift[1]);
    const float u = (float)(shift[0] - fx), v = (float)(shift[1] - fy);
    double sum = 0;
    for (int y = top; y < bottom; ++y)
        for (int x = left; x < right; ++x) {
            const float *p = a->colors + 3 * (y * j->side + x),
                        *q = b->colors + 3 * ((y + fy) * j->side + x + fx), *r = q + 3 * j->side;
            for (int k = 0; k < 3; ++k) {
                const float there =
                    (q[k] * (1 - u) + q[k + 3] * u) * (1 - v) + (r[k] * (1 - u) + r[k + 3] * u) * v;
                sum += (double)((p[k] - there) * (p[k] - there));
            }
        }
    return sqrt(sum / (3.0 * (right - left) * (bottom - top)));
}

/* The least over shifts within reach: a coarse grid, then finer ones around its best. */
static double swatch_distance(
    const judging *j, const swatch *a, const swatch *b, double best_shift[2]) {
    const int begin = j->inset, end = j->side - begin;
    double best = INFINITY;
    best_shift[0] = best_shift[1] = 0;
    for (double step = j->reach / 2, span = 2; step > j->reach / 12; step /= 2, span = 1) {
        const double middle[2] = {best_shift[0], best_shift[1]};
        for (double y = -span; y <= span; ++y)
            for (double x = -span; x <= span; ++x) {
                const double shift[2] = {middle[0] + x * step, middle[1] + y * step};
                if (fabs(shift[0]) > j->reach || fabs(shift[1]) > j->reach) continue;
                const double d = distance_at(j, a, b, shift, begin, begin, end, end);
                if (d >= best) continue;
                best = d;
                memcpy(best_shift, shift, sizeof shift);
            }
    }
    return best;
}

/* Of a swatch's colours around their mean: how much shading it shows. */
static double contrast(const judging *j, const swatch *a) {
    double sum[3] = {0}, square = 0, mean = 0;
    const int begin = j->inset, end = j->side - j->inset, count = (end - begin) * (end - begin);
    for (int y = begin; y < end; ++y)
        for (int x = begin; x < end; ++x)
            for (int k = 0; k < 3; ++k) {
                const double c = (double)a->colors[3 * (y * j->side + x) + k];
                sum[k] += c;
                square += c * c;
            }
    for (int k = 0; k < 3; ++k) mean += sum[k] / count * (sum[k] / count);
    return sqrt(fmax(0, (square / count - mean) / 3));
}

/* ---- the background */

typedef struct background {
    double color[3], spread; /* the median around a patch; half of the colours are not further */
} background;

static int compare_doubles(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double take_median(double *values, size_t count) {
    qsort(values, count, sizeof *values, compare_doubles);
    return values[count / 2];
}

/* How far beyond a box nothing else of its row lies, in sizes of the box; a tenth at most. */
static double free_around(const acid_row *row, const acid_box *box) {
    double gap = 0.2;
    for (size_t i = 0; i <= row->reference_count; ++i) {
        const acid_box *other = i ? &row->references[i - 1].box : &row->subject;
        double between = -INFINITY;
        if (other == box) continue;
        for (int k = 0; k < 2; ++k)
            between = fmax(between,
                (fabs(other->center[k] - box->center[k]) - (other->size[k] + box->size[k]) / 2) /
                    box->size[k]);
        gap = fmin(gap, between);
    }
    return fmax(0, gap) / 2;
}

static void find_background(
    const judging *j, const acid_row *row, const acid_box *box, background *found) {
    const double out = 0.5 + free_around(row, box);
    double colors[3][4 * RING], off[4 * RING];
    size_t count = 0;
    for (int i = 0; i < 4 * RING; ++i) {
        const double along = ((i % RING) + 0.5) / RING * 2 * out - out;
        const int side = i / RING;
        const double u = side < 2 ? along : (side == 2 ? -out : out),
                     v = side < 2 ? (side == 0 ? -out : out) : along,
                     unit[2] = {
                         box->center[0] + u * box->size[0], box->center[1] + v * box->size[1]};
        double sample[3] = {0};
        if (!add_sample(j, unit, sample)) continue;
        for (int k = 0; k < 3; ++k) colors[k][count] = sample[k];
        ++count;
    }
    *found = (background){.spread = INFINITY};
    if (count < RING) return;
    for (size_t i = 0; i < count; ++i) off[i] = 0;
    for (int k = 0; k < 3; ++k) {
        double sorted[4 * RING];
        memcpy(sorted, colors[k], count * sizeof *sorted);
        found->color[k] = take_median(sorted, count);
        for (size_t i = 0; i < count; ++i)
            off[i] = fmax(off[i], fabs(colors[k][i] - found->color[k]));
    }
    found->spread = take_median(off, count);
}

typedef struct hiding {
    double off, explained; /* how far a patch is from what lies around it; what noise may explain */
    double share, above;   /* the part of the patch that noise explains; by how much the brightest
                              channel of the patch is brighter */
} hiding;

static hiding hide(const judging *j, const acid_row *row, const acid_box *box, const swatch *a) {
    background around;
    const int begin = j->inset, end = j->side - j->inset;
    const double count = squared(end - begin);
    hiding found = {.above = -1};
    find_background(j, row, box, &around);
    found.explained =
        around.spread < 0.1 ? fmax(least_hiding, 2 * fmax(around.spread, j->noise)) : 0;
    for (int y = begin; y < end; ++y)
        for (int x = begin; x < end; ++x) {
            double sum = 0;
            for (int k = 0; k < 3; ++k) {
                const double d = (double)a->colors[3 * (y * j->side + x) + k] - around.color[k];
                found.above = fmax(found.above, d);
                sum += squared(d);
            }
            found.off += sum / (3 * count);
            if (sqrt(sum / 3) < found.explained) found.share += 1 / count;
        }
    found.off = sqrt(found.off);
    return found;
}

/* Whether nothing is drawn in the place of the right reference (unclear), or of the subject alone
 * (missing). A subject that its background hides no better than it hides the right one is drawn. */
static acid_verdict verdict_if_drawn(const judging *j, const acid_row *row) {
    const hiding right = hide(j, row, &row->references[0].box, &j->references[0]),
                 subject = hide(j, row, &row->subject, &j->subject);
    if (right.off < right.explained) return ACID_UNCLEAR;
    return subject.off < fmin(subject.explained, right.off / 2) ? ACID_MISSING : ACID_PASS;
}

/* ---- verdicts */

static void unclear(acid_finding *finding, acid_reason reason) {
    finding->verdict = ACID_UNCLEAR;
    finding->reason = reason;
}

/* Takes all patches of a row. */
static int take_row_swatches(judging *j, const acid_row *row) {
    int inside;
    take_swatch(j, &row->subject, 0, &j->subject);
    inside = j->subject.inside;
    for (size_t i = 0; i < row->reference_count; ++i) {
        take_swatch(j, &row->references[i].box, 0, &j->references[i]);
        inside = inside && j->references[i].inside;
    }
    return inside;
}

/* A mistake by which nothing may be drawn at all. */
static int find_lost(const acid_row *row) {
    for (size_t i = 1; i < row->reference_count; ++i)
        if (strcmp(row->references[i].id, "lost") == 0) return (int)i;
    return -1;
}

/* Where a mistake may give all of a patch one end of the scale, which no reference shows: bytes are
 * long normals, and white if they are not normalised; reversed ones are black without ambient
 * light. */
static const struct scale_end {
    const char *cell;
    int is_white;
} scale_ends[] = {{"quantized", 1}, {"tangent-mirror", 0}};

/* Whether the ground is at that end, as the red, green and blue marks are in two channels each. */
static int is_scale_end(const judging *j, const acid_row *row, int is_white) {
    background around;
    find_background(j, row, &row->subject, &around);
    for (int k = 0; k < 3; ++k) {
        double mark[3] = {0};
        add_sample(j, j->layout->marks[is_white ? k : (k + 2) % 3].center, mark);
        const double inward = is_white ? mark[k] - around.color[k] : around.color[k] - mark[k];
        if (inward > fmax(least_hiding, 2 * j->noise)) return 0;
    }
    return 1;
}

/* Whether a subject that is drawn may be seen as little as one that is not: some reference is as
 * the ground, or is where it is brightest. */
static int ground_hides(const judging *j, const acid_row *row) {
    for (size_t i = 0; i < row->reference_count; ++i) {
        const hiding h = hide(j, row, &row->references[i].box, &j->references[i]);
        if (h.off < h.explained || (h.share > hidden_share && h.above < h.explained)) return 1;
    }
    for (size_t i = 0; i < sizeof scale_ends / sizeof *scale_ends; ++i)
        if (strcmp(row->id, scale_ends[i].cell) == 0)
            return is_scale_end(j, row, scale_ends[i].is_white);
    return 0;
}

static void judge_missing(const judging *j, const acid_row *row, acid_finding *finding) {
    finding->nearest = find_lost(row);
    finding->verdict = finding->nearest < 0 ? ACID_MISSING : ACID_FAIL;
    if (finding->nearest < 0 && ground_hides(j, row)) unclear(finding, ACID_REASON_HIDDEN);
}

/* What pixels make of fine detail: the right reference differs so much from itself, sampled half a
 * pixel beside. */
static double sampling_noise(judging *j, const acid_row *row) {
    take_swatch(j, &row->references[0].box, 0.5, &j->beside);
    double shift[2];
    return swatch_distance(j, &j->references[0], &j->beside, shift);
}

/* The subject against each reference, and those against the nearest one (apart). */
static void measure(
    judging *j, const acid_row *row, acid_finding *finding, double apart[ACID_MOST_REFERENCES]) {
    double shift[2];
    for (size_t i = 0; i < row->reference_count; ++i) {
        finding->distances[i] = swatch_distance(j, &j->subject, &j->references[i], shift);
        if (finding->nearest < 0 || finding->distances[i] < finding->distances[finding->nearest])
            finding->nearest = (int)i;
    }
    finding->apart = INFINITY;
    for (size_t i = 0; i < row->reference_count; ++i) {
        if ((int)i == finding->nearest) continue;
        apart[i] = swatch_distance(j, &j->references[finding->nearest], &j->references[i], shift);
        finding->apart = fmin(finding->apart, apart[i]);
    }
}

static int is_between(const acid_row *row, const acid_finding *finding, double noise,
    const double apart[ACID_MOST_REFERENCES]) {
    const double *d = finding->distances, least = squared(d[finding->nearest]);
    for (size_t i = 0; i < row->reference_count; ++i)
        if ((int)i != finding->nearest &&
            squared(d[i]) - least < (1 - 2 * most_way) * (squared(apart[i]) - squared(noise)))
            return 1;
    return 0;
}

/* How far the subject is from the nearest reference where that one is like the right one, which is
 * so in much of the patch if a mistake acts in a part of it only; 0: hardly anywhere. */
static double off_where_alike(const judging *j, int nearest, double apart) {
    static const double in_place[2] = {0, 0};
    const swatch *right = &j->references[0], *mistaken = &j->references[nearest];
    const int begin = j->inset, end = j->side - begin;
    double shift[2], sum = 0;
    int count = 0;
    swatch_distance(j, &j->subject, mistaken, shift);
    for (int y = begin; y < end; ++y)
        for (int x = begin; x < end; ++x) {
            if (distance_at(j, right, mistaken, in_place, x, y, x + 1, y + 1) > alike_part * apart)
                continue;
            sum += squared(distance_at(j, &j->subject, mistaken, shift, x, y, x + 1, y + 1));
            ++count;
        }
    return count < alike_share * squared(end - begin) ? 0 : sqrt(sum / count);
}

static void judge_drawn(judging *j, const acid_row *row, acid_finding *finding) {
    const double noise = fmax(least_noise, fmax(j->noise, sampling_noise(j, row)));
    double apart[ACID_MOST_REFERENCES];
    measure(j, row, finding, apart);
    const double least = finding->distances[finding->nearest],
                 near = fmin(
                     near_part * finding->apart, near_contrast * contrast(j, &j->references[0]));
    if (finding->apart < above_noise * noise)
        unclear(finding, ACID_REASON_ALIKE);
    else if (squared(least) > squared(2 * noise) + squared(0.6 * finding->apart))
        unclear(finding, ACID_REASON_FAR);
    else if (is_between(row, finding, noise, apart))
        unclear(finding, ACID_REASON_BETWEEN);
    else if (squared(least) > squared(1.5 * noise) + squared(near))
        unclear(finding, ACID_REASON_FAR);
    else if (finding->nearest > 0 && squared(off_where_alike(j, finding->nearest, apart[0])) >
                                         squared(1.5 * noise) + squared(near_part * apart[0]))
        unclear(finding, ACID_REASON_FAR);
    else
        finding->verdict = finding->nearest == 0 ? ACID_PASS : ACID_FAIL;
}

/* Whether there is something to compare: all patches lie in the picture, and are drawn. */
static int find_drawn(judging *j, const acid_row *row, acid_finding *finding) {
    finding->reason = ACID_REASON_OUTSIDE;
    if (!take_row_swatches(j, row)) return 0;
    const acid_verdict drawn = verdict_if_drawn(j, row);
    finding->reason = drawn == ACID_UNCLEAR ? ACID_REASON_NOT_DRAWN : ACID_REASON_NONE;
    if (drawn == ACID_MISSING) finding->verdict = ACID_MISSING;
    return drawn == ACID_PASS;
}

static void judge_row(judging *j, const acid_row *row, acid_finding *finding) {
    finding->verdict = ACID_UNCLEAR;
    if (find_drawn(j, row, finding))
        judge_drawn(j, row, finding);
    else if (finding->verdict == ACID_MISSING)
        judge_missing(j, row, finding);
}

/* ---- the control: without it, nothing is known of the picture */

static const acid_row *find_control(const acid_layout *layout, size_t *at) {
    for (*at = 0; *at < layout->row_count; ++*at)
        if (strcmp(layout->rows[*at].id, "control") == 0) return &layout->rows[*at];
    return NULL;
}

static void judge_control(judging *j, const acid_row *row, acid_finding *finding) {
    finding->verdict = ACID_FAIL;
    if (!find_drawn(j, row, finding)) return;
    double shift[2];
    finding->distances[0] = swatch_distance(j, &j->subject, &j->references[0], shift);
    finding->apart = contrast(j, &j->references[0]);
    if (finding->apart < 0.02)
        finding->reason = ACID_REASON_ALIKE;
    else if (finding->distances[0] > near_contrast * finding->apart)
        finding->reason = ACID_REASON_FAR;
    else
        finding->verdict = ACID_PASS, finding->nearest = 0;
}

/* ---- a picture */

static int choose_side(judging *j) {
    double least = INFINITY, shorter, longer;
    for (size_t i = 0; i < j->layout->row_count; ++i) {
        box_pixels(j->map, &j->layout->rows[i].subject, &longer, &shorter);
        least = fmin(least, shorter);
    }
    j->side = (int)fmax(LEAST_SIDE, fmin(MOST_SIDE, floor(least)));
    j->reach = fmax(1, 0.03 * j->side);
    j->inset = (int)ceil(j->reach + 0.08 * j->side);
    return least >= LEAST_SIDE;
}

/* All of them in one block, which begins with the subject's. */
static int allocate_swatches(judging *j) {
    const size_t size = 3 * (size_t)j->side * (size_t)j->side;
    float *block = norma_io_allocate(size, (ACID_MOST_REFERENCES + 2) * sizeof *block);
    if (!block) return 0;
    j->subject.colors = block;
    j->beside.colors = block + size;
    for (size_t i = 0; i < ACID_MOST_REFERENCES; ++i)
        j->references[i].colors = block + (2 + i) * size;
    return 1;
}

/* ---- mistakes that give one picture in a cell */

/* Under a node that mirrors, with one sign of w throughout, a sign that is kept, a sign that is
 * lost and a green channel that is flipped all turn the bitangent round: tangent-sign has to pass.
 * A scale on z makes a relief low, and a renderer that draws no normal maps has none at all: its
 * tangent-sign neither passes nor fails. */
static const struct alike_mistakes {
    const char *cell, *mistake, *told_apart_by;
    int has_to_pass; /* else a mistake there is enough, and so is a picture without that cell */
    acid_reason reason;
} alike[] = {{"tangent-mirror", "sign-kept", "tangent-sign", 1, ACID_REASON_ELSEWHERE},
    {"normal-scale", "scale-on-z", "tangent-sign", 0, ACID_REASON_NO_RELIEF}};

static int are_told_apart(
    const judging *j, const acid_judgement *judgement, const struct alike_mistakes *of) {
    for (size_t i = 0; i < j->layout->row_count; ++i)
        if (strcmp(j->layout->rows[i].id, of->told_apart_by) == 0)
            return judgement->findings[i].verdict == ACID_PASS ||
                   (!of->has_to_pass && judgement->findings[i].verdict == ACID_FAIL);
    return !of->has_to_pass;
}

static void tell_apart(const judging *j, acid_judgement *to) {
    for (size_t i = 0; i < j->layout->row_count; ++i) {
        const acid_row *row = &j->layout->rows[i];
        acid_finding *finding = &to->findings[i];
        for (size_t k = 0; k < sizeof alike / sizeof *alike; ++k)
            if (finding->verdict == ACID_FAIL && finding->nearest > 0 &&
                strcmp(row->id, alike[k].cell) == 0 &&
                strcmp(row->references[finding->nearest].id, alike[k].mistake) == 0 &&
                !are_told_apart(j, to, &alike[k]))
                unclear(finding, alike[k].reason);
    }
}

static void judge_rows(judging *j, int is_large, acid_judgement *to) {
    size_t control_at;
    const acid_row *control = find_control(j->layout, &control_at);
    acid_reason reason = is_large ? ACID_REASON_NONE : ACID_REASON_SMALL;
    if (control) {
        acid_finding *finding = &to->findings[control_at];
        if (is_large)
            judge_control(j, control, finding);
        else
            finding->verdict = ACID_FAIL, finding->reason = reason;
        if (is_large && finding->verdict != ACID_PASS) reason = ACID_REASON_CONTROL;
        to->noise = j->noise = finding->distances[0];
    }
    for (size_t i = 0; i < j->layout->row_count; ++i) {
        const acid_row *row = &j->layout->rows[i];
        if (row->skipped)
            to->findings[i].verdict = ACID_SKIPPED;
        else if (row != control && reason)
            unclear(&to->findings[i], reason);
        else if (row != control)
            judge_row(j, row, &to->findings[i]);
    }
    tell_apart(j, to);
    for (size_t i = 0; i < j->layout->row_count; ++i) ++to->counts[to->findings[i].verdict];
}

int acid_judge(const acid_picture *picture, const acid_layout *layout, const acid_map *map,
    acid_judgement *judgement) {
    judging j = {.picture = picture, .layout = layout, .map = map};
    const int is_large = choose_side(&j);
    *judgement = (acid_judgement){
        .findings = norma_io_allocate(layout->row_count, sizeof *judgement->findings)};
    const int there = allocate_swatches(&j) && judgement->findings;
    for (size_t i = 0; i < layout->row_count && there; ++i) judgement->findings[i].nearest = -1;
    if (there) judge_rows(&j, is_large, judgement);
    free(j.subject.colors);
    if (!there) {
        free(judgement->findings);
        judgement->findings = NULL;
    }
    return there;
}

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
