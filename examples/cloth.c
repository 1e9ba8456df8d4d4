/* cloth.c: a cloth that hangs by two corners and swings, its normals kept right by a plan: each
 * step names the vertices that moved, and no others are looked at.
 *
 *     cloth [FOLDER]       with a folder, writes pictures there: cloth-000.pgm, cloth-020.pgm, ...
 *
 * The cloth is a grid of points that keep their distances (Jakobsen 2001). */
#include <math.h>
#include <norma/norma.h>
#include <stdio.h>
#include <string.h>

enum { SIDE = 41, POINTS = SIDE * SIDE, CORNERS = 6 * (SIDE - 1) * (SIDE - 1) };
enum { FRAMES = 61, PIXELS = 320 };

typedef struct cloth {
    float now[POINTS][3], before[POINTS][3], normals[POINTS][3];
    uint32_t corners[CORNERS], moved[POINTS];
} cloth;

static void hang(cloth *c) {
    uint32_t *corner = c->corners;
    for (uint32_t i = 0; i < POINTS; ++i) {
        const float x = (float)(i % SIDE) / (SIDE - 1), y = (float)(i / SIDE) / (SIDE - 1);
        const float place[3] = {x - 0.5F, 0.5F - 0.3F * y, 0.95F * y};
        memcpy(c->now[i], place, sizeof place);
        memcpy(c->before[i], place, sizeof place);
        if (i % SIDE == SIDE - 1 || i / SIDE == SIDE - 1) continue;
        for (uint32_t k = 0; k < 6; ++k)
            *corner++ = i + (uint32_t[]){0, SIDE, 1, 1, SIDE, SIDE + 1}[k];
    }
}

static int is_pinned(uint32_t i) { return i == 0 || i == SIDE - 1; }
static void keep_distance(cloth *c, uint32_t i, uint32_t j) {
    const float rest = 1.0F / (SIDE - 1);
    const float *a = c->now[i], *b = c->now[j], d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const float length = sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const float pull = (length - rest) / length / (float)(2 - is_pinned(i) - is_pinned(j));
    for (int k = 0; k < 3 && length > rest; ++k) {
        if (!is_pinned(i)) c->now[i][k] += pull * d[k];
        if (!is_pinned(j)) c->now[j][k] -= pull * d[k];
    }
}

/* Returns how many points are listed as moved: those that did by more than nobody sees. */
static size_t step(cloth *c) {
    size_t count = 0;
    for (uint32_t i = 0; i < POINTS; ++i)
        for (int k = 0; k < 3; ++k) {
            const float here = c->now[i][k], inertia = 0.985F * (here - c->before[i][k]);
            if (!is_pinned(i)) c->now[i][k] += inertia - (k == 1 ? 0.0012F : 0);
            c->before[i][k] = here;
        }
    for (int pass = 0; pass < 40; ++pass)
        for (uint32_t i = 0; i < POINTS; ++i) {
            if (i % SIDE + 1 < SIDE) keep_distance(c, i, i + 1);
            if (i / SIDE + 1 < SIDE) keep_distance(c, i, i + SIDE);
        }
    for (uint32_t i = 0; i < POINTS; ++i)
        if (memcmp(c->now[i], c->before[i], sizeof c->now[i]) != 0) c->moved[count++] = i;
    return count;
}

/* One triangle, seen along z, as points so close that no pixel is left out. */
static void draw(const cloth *c, const uint32_t *at, unsigned char *image, float *depth) {
    enum { STEPS = 16 };
    for (int step = 0; step < (STEPS + 1) * (STEPS + 1); ++step) {
        const int i = step % (STEPS + 1), j = step / (STEPS + 1);
        const float v = (float)i / STEPS, w = (float)j / STEPS, weights[3] = {1 - v - w, v, w};
        float p[3] = {0, 0, 0}, n[3];
        for (int k = 0; k < 9; ++k) p[k % 3] += weights[k / 3] * c->now[at[k / 3]][k % 3];
        const int x = (int)((p[0] + 0.7F) / 1.4F * PIXELS);
        const int y = (int)((0.6F - p[1]) / 1.4F * PIXELS), at_pixel = PIXELS * y + x;
        if (weights[0] < 0 || x < 0 || y < 0 || x >= PIXELS || y >= PIXELS) continue;
        if (p[2] < depth[at_pixel]) continue;
        const float(*normals)[3] = c->normals;
        norma_interpolate_normal(normals[at[0]], normals[at[1]], normals[at[2]], weights, n);
        const float light = fabsf(0.4F * n[0] + 0.5F * n[1] + 0.768F * n[2]);
        depth[at_pixel] = p[2];
        image[at_pixel] = (unsigned char)(30 + 220 * light);
    }
}

static int write_picture(const cloth *c, const char *folder, int frame) {
    static unsigned char image[PIXELS * PIXELS];
    static float depth[PIXELS * PIXELS];
    memset(image, 0, sizeof image);
    for (int i = 0; i < PIXELS * PIXELS; ++i) depth[i] = -10;
    for (uint32_t i = 0; i < CORNERS; i += 3) draw(c, c->corners + i, image, depth);
    char path[512];
    snprintf(path, sizeof path, "%s/cloth-%03d.pgm", folder, frame);
    FILE *file = fopen(path, "wb");
    if (!file) return 0;
    fprintf(file, "P5\n%d %d\n255\n", PIXELS, PIXELS);
    const int written = fwrite(image, sizeof image, 1, file) == 1;
    return fclose(file) == 0 && written;
}

int main(int argc, char **argv) {
    static cloth c;
    hang(&c);
    norma_plan *plan = NULL;
    const norma_vec3_view at = {.data = c.now, .count = POINTS};
    const norma_mesh mesh = {.positions = at, .corners = c.corners, .corner_count = CORNERS};
    norma_result result = norma_plan_create(&mesh, NORMA_PER_VERTEX, 3.1415927F, NULL, &plan);
    if (result == NORMA_OK)
        result = norma_plan_update(plan, at, NULL, 0, NULL, c.normals[0], POINTS, NULL);
    for (int frame = 0; frame < FRAMES && result == NORMA_OK; ++frame) {
        const uint32_t hem = POINTS - 1 - SIDE / 2;
        if (frame % 20 == 0)
            printf("frame %2d: the hem's middle is at height %5.2f, its normal at %5.2f\n", frame,
                (double)c.now[hem][1], (double)c.normals[hem][1]);
        if (frame % 20 == 0 && argc > 1 && !write_picture(&c, argv[1], frame)) return 3;
        const size_t moved = step(&c);
        result = norma_plan_update(plan, at, c.moved, moved, NULL, c.normals[0], POINTS, NULL);
    }
    norma_plan_destroy(plan);
    if (result != NORMA_OK) fprintf(stderr, "cloth: %s\n", norma_result_text(result));
    return result == NORMA_OK ? 0 : 1;
}
