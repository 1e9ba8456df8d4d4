/* marks.c: finds the four marks of an acid scene in a picture of any size, by their hues,
 * their shapes and their places to each other.
 *
 * One pass over the rows joins neighbouring pixels of one hue and nearly one colour to spots (two
 * rows of runs and a union-find: memory of a few rows). A spot may be a mark if its second moments
 * are those of a parallelogram. Four are the marks if the homography of their middles predicts the
 * moments of each. Of several such choices the largest is taken: the marks are the scene's corners,
 * so that what looks like them by accident lies between them and is smaller. */
#include "acid/acid.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Under a light of one colour all patches have one hue, and are larger than the mark. EVEN: levels
 * that a spot's pixels may be off its mean. */
enum { MOST_SPOTS = 256, EVEN = 45 };
#define MOST_CHOICES 6e6 /* of four spots, so that hostile pictures take no longer than seconds */

typedef struct spot {
    size_t parent, last_row; /* while it grows */
    int color;
    double count, x, y, xx, xy, yy, level[3]; /* sums, then means and covariances */
} spot;

typedef struct spot_list {
    spot spots[MOST_SPOTS]; /* the largest first */
    size_t count;
} spot_list;

/* ---- the hue of a pixel */

/* Of the marks' order; -1: grey, dark, or a hue between theirs. Tone curves turn hues by some ten
 * degrees and take much of their saturation. */
static int mark_hue(const uint8_t p[3]) {
    static const struct {
        int from, to;
    } hues[ACID_MARKS] = {{-26, 28}, {85, 165}, {200, 280}, {38, 78}};
    const int most = p[0] > p[1] ? (p[0] > p[2] ? p[0] : p[2]) : (p[1] > p[2] ? p[1] : p[2]),
              least = p[0] < p[1] ? (p[0] < p[2] ? p[0] : p[2]) : (p[1] < p[2] ? p[1] : p[2]),
              range = most - least;
    if (most < 48 || 10 * range < 3 * most) return -1;
    int hue = p[0] == most   ? 60 * (p[1] - p[2]) / range
              : p[1] == most ? 120 + 60 * (p[2] - p[0]) / range
                             : 240 + 60 * (p[0] - p[1]) / range;
    for (int i = 0; i < ACID_MARKS; ++i)
        if (hue >= hues[i].from && hue <= hues[i].to) return i;
    return -1;
}

/* ---- spots, row by row */

typedef struct run {
    size_t begin, end, spot;
    int color;
} run;

typedef struct spot_search {
    const acid_picture *picture;
    spot *pool; /* those that still grow, and holes */
    size_t used;
    run *runs[2]; /* of the row before, and of this one */
    size_t run_count[2];
    spot_list lists[ACID_MARKS];
} spot_search;

static size_t spot_root(const spot *pool, size_t i) {
    while (pool[i].parent != i) i = pool[i].parent;
    return i;
}

static int is_even(const double sum[3], double count, const uint8_t pixel[3]) {
    for (int k = 0; k < 3; ++k)
        if (fabs(sum[k] - count * pixel[k]) > EVEN * count) return 0;
    return 1;
}

static void add_sums(spot *to, const spot *from) {
    to->count += from->count;
    to->x += from->x;
    to->y += from->y;
    to->xx += from->xx;
    to->xy += from->xy;
    to->yy += from->yy;
    for (int k = 0; k < 3; ++k) to->level[k] += from->level[k];
}

/* part: how much of it the spot covers. */
static void add_pixel(spot *to, size_t column, size_t row, double part, const uint8_t pixel[3]) {
    const double x = (double)column + 0.5, y = (double)row + 0.5;
    to->count += part;
    to->x += part * x;
    to->y += part * y;
    to->xx += part * x * x;
    to->xy += part * x * y;
    to->yy += part * y * y;
    for (int k = 0; k < 3; ++k) to->level[k] += part * pixel[k];
}

static spot spot_of_run(const acid_picture *picture, const run *r, size_t y) {
    spot s = {.last_row = y, .color = r->color};
    const uint8_t *row = picture->pixels + 3 * picture->width * y;
    for (size_t x = r->begin; x < r->end; ++x) add_pixel(&s, x, y, 1, row + 3 * x);
    return s;
}

static void find_runs(spot_search *search, size_t y) {
    const acid_picture *picture = search->picture;
    const uint8_t *row = picture->pixels + 3 * picture->width * y;
    run *runs = search->runs[y % 2];
    size_t count = 0;
    double sum[3] = {0};
    for (size_t x = 0; x < picture->width; ++x) {
        const uint8_t *pixel = row + 3 * x;
        const int color = mark_hue(pixel);
        if (color < 0) continue;
        run *last = count ? &runs[count - 1] : NULL;
        if (last && last->end == x && last->color == color &&
            is_even(sum, (double)(last->end - last->begin), pixel)) {
            last->end = x + 1;
        } else {
            runs[count++] = (run){x, x + 1, 0, color};
            memset(sum, 0, sizeof sum);
        }
        for (int k = 0; k < 3; ++k) sum[k] += pixel[k];
    }
    search->run_count[y % 2] = count;
}

static int is_like(const spot *a, const spot *b) {
    for (int k = 0; k < 3; ++k)
        if (fabs(a->level[k] / a->count - b->level[k] / b->count) > EVEN) return 0;
    return a->color == b->color;
}

/* A new spot for each run of this row, joined with those above it that are like it. */
static void join_runs(spot_search *search, size_t y) {
    const run *above = search->runs[(y + 1) % 2];
    const size_t above_count = y ? search->run_count[(y + 1) % 2] : 0;
    size_t first = 0, hole = 0;
    for (size_t i = 0; i < search->run_count[y % 2]; ++i) {
        run *r = &search->runs[y % 2][i];
        while (hole < search->used && search->pool[hole].count > 0) ++hole;
        if (hole == search->used) ++search->used;
        r->spot = hole;
        search->pool[hole] = spot_of_run(search->picture, r, y);
        search->pool[hole].parent = hole;
        while (first < above_count && above[first].end <= r->begin) ++first;
        for (size_t k = first; k < above_count && above[k].begin < r->end; ++k) {
            const size_t a = spot_root(search->pool, r->spot),
                         b = spot_root(search->pool, above[k].spot);
            if (a == b || !is_like(&search->pool[a], &search->pool[b])) continue;
            add_sums(&search->pool[b], &search->pool[a]);
            search->pool[b].last_row = y;
            search->pool[a].parent = b;
        }
    }
}

/* Sums become means and covariances. Whether it may be a mark: a parallelogram of area A has a
 * covariance of determinant (A/12)^2. */
static int may_be_mark(spot *s) {
    const double n = s->count;
    if (n < 9) return 0;
    s->x /= n;
    s->y /= n;
    s->xx = s->xx / n - s->x * s->x + 1.0 / 12; /* and a pixel's own */
    s->xy = s->xy / n - s->x * s->y;
    s->yy = s->yy / n - s->y * s->y + 1.0 / 12;
    const double determinant = s->xx * s->yy - s->xy * s->xy;
    if (!(determinant > 0)) return 0;
    const double ratio = 12 * sqrt(determinant) / n;
    return ratio > 0.8 && ratio < 1.25;
}

static void keep_spot(spot_list *list, spot s) {
    if (!may_be_mark(&s)) return;
    size_t at = list->count;
    while (at > 0 && list->spots[at - 1].count < s.count) --at;
    if (at == MOST_SPOTS) return;
    if (list->count < MOST_SPOTS) ++list->count;
    memmove(list->spots + at + 1, list->spots + at, (list->count - at - 1) * sizeof s);
    list->spots[at] = s;
}

/* Spots that were joined to others, or that this row no longer touches, are done. */
static void end_spots(spot_search *search, size_t y, int is_last) {
    for (size_t i = 0; i < search->run_count[y % 2]; ++i) {
        run *r = &search->runs[y % 2][i];
        r->spot = spot_root(search->pool, r->spot);
    }
    for (size_t i = 0; i < search->used; ++i) {
        spot *s = &search->pool[i];
        if (s->count == 0 || (s->parent == i && s->last_row == y && !is_last)) continue;
        if (s->parent == i) keep_spot(&search->lists[s->color], *s);
        s->count = 0;
    }
    while (search->used && search->pool[search->used - 1].count == 0) --search->used;
}

static int find_spots(spot_search *search) {
    const size_t width = search->picture->width, height = search->picture->height;
    search->pool = norma_io_allocate(2 * width + 2, sizeof *search->pool);
    for (int i = 0; i < 2; ++i) search->runs[i] = norma_io_allocate(width, sizeof *search->runs[i]);
    const int there = search->pool && search->runs[0] && search->runs[1];
    for (size_t y = 0; y < height && there; ++y) {
        find_runs(search, y);
        join_runs(search, y);
        end_spots(search, y, y + 1 == height);
    }
    free(search->pool);
    for (int i = 0; i < 2; ++i) free(search->runs[i]);
    return there;
}

/* ---- spots of blurred squares, measured anew */

typedef struct window {
    long left, top, right, bottom; /* the last two are behind it */
} window;

/* A little larger than the spot, and within the picture. */
static window around_spot(const acid_picture *picture, const spot *s) {
    const double x = 1.15 * sqrt(3 * s->xx) + 3, y = 1.15 * sqrt(3 * s->yy) + 3;
    const long width = (long)picture->width, height = (long)picture->height;
    const window w = {lround(s->x - x), lround(s->y - y), lround(s->x + x), lround(s->y + y)};
    return (window){w.left > 0 ? w.left : 0, w.top > 0 ? w.top : 0,
        w.right < width ? w.right : width, w.bottom < height ? w.bottom : height};
}

/* The mean colours of the window's border and of the spot's middle. */
static void find_colors(const acid_picture *picture, const spot *s, const window *w,
    double border[3], double middle[3]) {
    double counts[2] = {0, 0};
    for (int k = 0; k < 3; ++k) border[k] = middle[k] = 0;
    for (long y = w->top; y < w->bottom; ++y)
        for (long x = w->left; x < w->right; ++x) {
            const double dx = fabs((double)x + 0.5 - s->x), dy = fabs((double)y + 0.5 - s->y);
            const int is_middle = dx < 0.5 + sqrt(s->xx) / 2 && dy < 0.5 + sqrt(s->yy) / 2;
            if (!is_middle && y > w->top && y < w->bottom - 1 && x > w->left && x < w->right - 1)
                continue;
            const uint8_t *pixel = picture->pixels + 3 * ((size_t)y * picture->width + (size_t)x);
            for (int k = 0; k < 3; ++k) (is_middle ? middle : border)[k] += pixel[k];
            counts[is_middle] += 1;
        }
    for (int k = 0; k < 3; ++k) {
        border[k] /= fmax(1, counts[0]);
        middle[k] /= fmax(1, counts[1]);
    }
}

/* How far a colour is on the way from border to middle, 0 to 1; 0 for one that is not on it, as of
 * letters beside the mark. */
static double part_covered(const uint8_t pixel[3], const double border[3], const double middle[3]) {
    double along = 0, whole = 0, off = 0;
    for (int k = 0; k < 3; ++k) {
        along += (pixel[k] - border[k]) * (middle[k] - border[k]);
        whole += (middle[k] - border[k]) * (middle[k] - border[k]);
    }
    const double part = along / fmax(1, whole);
    for (int k = 0; k < 3; ++k) {
        const double there = border[k] + part * (middle[k] - border[k]);
        off += (pixel[k] - there) * (pixel[k] - there);
    }
    return part < 0.15 || off > 0.1 * whole ? 0 : fmin(1, part);
}

/* Compression smears colours over some pixels, and where a spot seems to end depends on its colour
 * and on what lies around it. Counted by the part of each pixel that it covers, it does not. */
static void measure_spot(const acid_picture *picture, spot *s) {
    const window w = around_spot(picture, s);
    double border[3], middle[3];
    spot sum = {.color = s->color};
    if (w.right - w.left > 512 || w.bottom - w.top > 512) return;
    find_colors(picture, s, &w, border, middle);
    for (size_t y = (size_t)w.top; y < (size_t)w.bottom; ++y)
        for (size_t x = (size_t)w.left; x < (size_t)w.right; ++x) {
            const uint8_t *pixel = picture->pixels + 3 * (y * picture->width + x);
            add_pixel(&sum, x, y, part_covered(pixel, border, middle), pixel);
        }
    if (may_be_mark(&sum)) *s = sum;
}

/* ---- maps */

void acid_map_point(const acid_map *map, const double unit[2], double pixel[2]) {
    const double *m = map->m, w = m[6] * unit[0] + m[7] * unit[1] + m[8];
    pixel[0] = (m[0] * unit[0] + m[1] * unit[1] + m[2]) / w;
    pixel[1] = (m[3] * unit[0] + m[4] * unit[1] + m[5]) / w;
}

void acid_map_sides(const acid_map *map, const acid_box *box, double sides[2][2]) {
    for (int k = 0; k < 2; ++k) {
        double from[2] = {box->center[0], box->center[1]}, to[2] = {from[0], from[1]}, a[2], b[2];
        from[k] -= box->size[k] / 2;
        to[k] += box->size[k] / 2;
        acid_map_point(map, from, a);
        acid_map_point(map, to, b);
        for (int i = 0; i < 2; ++i) sides[k][i] = b[i] - a[i];
    }
}

/* Gauss with pivots; 0: singular. */
static int solve_eight(double a[8][9]) {
    for (int column = 0; column < 8; ++column) {
        int pivot = column;
        for (int row = column + 1; row < 8; ++row)
            if (fabs(a[row][column]) > fabs(a[pivot][column])) pivot = row;
        if (!(fabs(a[pivot][column]) > 1e-12)) return 0;
        for (int k = 0; k < 9; ++k) {
            const double kept = a[pivot][k];
            a[pivot][k] = a[column][k];
            a[column][k] = kept;
        }
        for (int row = 0; row < 8; ++row) {
            const double factor = row == column ? 0 : a[row][column] / a[column][column];
            for (int k = 0; k < 9; ++k) a[row][k] -= factor * a[column][k];
        }
    }
    return 1;
}

/* The homography that takes the middles of the marks to those of the spots. */
static int map_of_spots(
    const acid_layout *layout, const spot *const spots[ACID_MARKS], acid_map *map) {
    double a[8][9];
    for (int i = 0; i < ACID_MARKS; ++i) {
        const double x = layout->marks[i].center[0], y = layout->marks[i].center[1],
                     u = spots[i]->x, v = spots[i]->y;
        const double rows[2][9] = {
            {x, y, 1, 0, 0, 0, -u * x, -u * y, u}, {0, 0, 0, x, y, 1, -v * x, -v * y, v}};
        memcpy(a[2 * i], rows, sizeof rows);
    }
    if (!solve_eight(a)) return 0;
    for (int i = 0; i < 8; ++i) map->m[i] = a[i][8] / a[i][i];
    map->m[8] = 1;
    return 1;
}

/* Only a mild perspective is one: no corner of the picture lies twice as far as another. */
static int is_mild_map(const acid_map *map) {
    const double x = map->m[6], y = map->m[7];
    const double w[4] = {1, 1 + x, 1 + y, 1 + x + y};
    double least = 1, most = 1;
    for (int i = 0; i < 4; ++i) {
        least = fmin(least, w[i]);
        most = fmax(most, w[i]);
    }
    return least > 0.5 * most;
}

/* ---- four spots that are the marks */

/* The covariance of a mark under the map; its derivative is nearly constant over a mark. */
static void predict_moments(const acid_map *map, const acid_box *mark, double moments[3]) {
    double sides[2][2]; /* of the parallelogram */
    acid_map_sides(map, mark, sides);
    moments[0] = (sides[0][0] * sides[0][0] + sides[1][0] * sides[1][0]) / 12;
    moments[1] = (sides[0][0] * sides[0][1] + sides[1][0] * sides[1][1]) / 12;
    moments[2] = (sides[0][1] * sides[0][1] + sides[1][1] * sides[1][1]) / 12;
}

typedef struct misfit { /* of a spot beside its prediction */
    double size;        /* logarithm of the ratio of sides */
    double shape;       /* 0: the same */
    double rim;         /* what part of a side a pixel is */
} misfit;

static misfit misfit_of(const spot *s, const double predicted[3]) {
    const double p = sqrt(predicted[0] * predicted[2] - predicted[1] * predicted[1]),
                 m = sqrt(s->xx * s->yy - s->xy * s->xy);
    const double trace = s->xx * predicted[2] + s->yy * predicted[0] - 2 * s->xy * predicted[1];
    return (misfit){0.5 * log(m / p), trace / (2 * p * m) - 1, 1 / sqrt(12 * p)};
}

/* The number of pixels of the spots, less where the fit is worse; 0: they are not the marks. A
 * blurred rim of a pixel makes small spots much smaller, but all four alike. */
static double fit_spots(
    const acid_layout *layout, const spot *const spots[ACID_MARKS], acid_map *map) {
    misfit misfits[ACID_MARKS];
    double size = 0, sum = 0, count = 0;
    if (!map_of_spots(layout, spots, map) || !is_mild_map(map)) return 0;
    for (int i = 0; i < ACID_MARKS; ++i) {
        double moments[3];
        predict_moments(map, &layout->marks[i], moments);
        misfits[i] = misfit_of(spots[i], moments);
        size += misfits[i].size / ACID_MARKS;
    }
    for (int i = 0; i < ACID_MARKS; ++i) {
        const misfit *m = &misfits[i];
        if (!(fabs(size) < 0.1 + 2 * m->rim && fabs(m->size - size) < 0.05 + m->rim &&
                m->shape < 0.02 + m->rim * m->rim))
            return 0;
        sum += m->shape + fabs(m->size - size);
        count += spots[i]->count;
    }
    return count * exp(-2 * sum);
}

static int about_as_large(const spot *a, const spot *b) {
    return a->count < 3 * b->count && b->count < 3 * a->count;
}

/* Whether the fourth lies about where a parallelogram has it. */
static int closes(const spot *const spots[ACID_MARKS]) {
    const double diagonal = hypot(spots[2]->x - spots[0]->x, spots[2]->y - spots[0]->y),
                 x = spots[0]->x + spots[2]->x - spots[1]->x - spots[3]->x,
                 y = spots[0]->y + spots[2]->y - spots[1]->y - spots[3]->y;
    return hypot(x, y) < 0.2 * diagonal;
}

/* Drops the smallest spots of the longest lists until there are few enough choices. */
static void limit_choices(spot_list lists[ACID_MARKS]) {
    for (;;) {
        double choices = 1;
        spot_list *longest = lists;
        for (int i = 0; i < ACID_MARKS; ++i) {
            choices *= (double)lists[i].count;
            if (lists[i].count > longest->count) longest = &lists[i];
        }
        if (choices <= MOST_CHOICES) return;
        --longest->count;
    }
}

static double choose_spots(const spot_list lists[ACID_MARKS], const acid_layout *layout,
    const spot *spots[ACID_MARKS], int next, acid_map *best, double most) {
    if (next == ACID_MARKS) {
        acid_map map;
        const double fit = closes(spots) ? fit_spots(layout, spots, &map) : 0;
        if (fit > most) *best = map;
        return fmax(fit, most);
    }
    for (size_t i = 0; i < lists[next].count; ++i) {
        spots[next] = &lists[next].spots[i];
        if (next == 0 || about_as_large(spots[0], spots[next]))
            most = choose_spots(lists, layout, spots, next + 1, best, most);
    }
    return most;
}

int acid_find_marks(const acid_picture *picture, const acid_layout *layout, acid_map *map) {
    spot_search *search = norma_io_allocate(1, sizeof *search);
    const spot *spots[ACID_MARKS];
    int found = -1;
    if (search) {
        search->picture = picture;
        if (find_spots(search)) {
            limit_choices(search->lists);
            for (int i = 0; i < ACID_MARKS; ++i)
                for (size_t k = 0; k < search->lists[i].count; ++k)
                    measure_spot(picture, &search->lists[i].spots[k]);
            found = choose_spots(search->lists, layout, spots, 0, map, 0) > 0;
        }
    }
    free(search);
    return found;
}
