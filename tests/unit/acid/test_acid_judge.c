/* The judge of acid scenes, on pictures that are shaded from normals in closed form, with mistakes
 * put in and distorted as screenshots are. */
#include "check.h"
#include "acid_shots.h"

static acid_layout layout;

static int set_up(void **state) {
    (void)state;
    return acid_shots_layout(&layout) ? 0 : -1;
}
static int tear_down(void **state) {
    (void)state;
    free(layout.rows);
    return 0;
}

static acid_shot plain_shot(void) {
    return (acid_shot){.width = 560,
        .height = 420,
        .corners = {{0, 0}, {560, 0}, {560, 420}, {0, 420}},
        .exposure = 1,
        .gamma = 2.2};
}

/* 1, 0 or -1 as acid_find_marks; on 1 the caller frees findings. */
static int judge_picture(acid_picture *picture, acid_judgement *judgement) {
    acid_map map;
    const int found = acid_find_marks(picture, &layout, &map);
    if (found == 1) assert_true(acid_judge(picture, &layout, &map, judgement));
    return found;
}

static void judge(const acid_shot *shot, acid_judgement *judgement) {
    acid_picture picture;
    assert_true(acid_shot_take(shot, &layout, &picture));
    assert_int_equal(judge_picture(&picture, judgement), 1);
    free(picture.pixels);
}

static acid_verdict expected(const acid_shot *shot, size_t row) {
    const int what = shot->shows[row];
    if (what == ACID_SHOWS_OTHER || !acid_shot_can_name(shot, &layout, row)) return ACID_UNCLEAR;
    if (what == ACID_SHOWS_NOTHING)
        return strcmp(layout.rows[row].id, "flattened") == 0 ? ACID_FAIL : ACID_MISSING;
    return what == 0 ? ACID_PASS : ACID_FAIL;
}

static int is_as_expected(const acid_shot *shot, size_t row, const acid_finding *finding) {
    return finding->verdict == expected(shot, row) &&
           (shot->shows[row] < 0 || finding->nearest == shot->shows[row]);
}

static void assert_expected(const acid_shot *shot, const acid_judgement *judgement) {
    for (size_t i = 0; i < layout.row_count; ++i)
        if (!is_as_expected(shot, i, &judgement->findings[i])) {
            print_error("%s shows %d: verdict %d, nearest %d, reason %d\n", layout.rows[i].id,
                shot->shows[i], (int)judgement->findings[i].verdict, judgement->findings[i].nearest,
                (int)judgement->findings[i].reason);
            fail();
        }
}

static void each_mistake(void **state) {
    (void)state;
    acid_shot shot = plain_shot();
    for (int mistake = 0; mistake < 4; ++mistake) {
        acid_judgement judgement;
        for (size_t i = 0; i < layout.row_count; ++i)
            shot.shows[i] = mistake < (int)layout.rows[i].reference_count ? mistake : 0;
        judge(&shot, &judgement);
        assert_expected(&shot, &judgement);
        free(judgement.findings);
    }
}

static void missing_and_strange(void **state) {
    (void)state;
    acid_shot shot = plain_shot();
    for (int background = 0; background < 5; ++background) {
        acid_judgement judgement;
        shot.background = background;
        for (size_t i = 1; i < layout.row_count; ++i)
            shot.shows[i] = i % 2 ? ACID_SHOWS_NOTHING : ACID_SHOWS_OTHER;
        judge(&shot, &judgement);
        assert_expected(&shot, &judgement);
        assert_int_equal(judgement.counts[ACID_PASS], 1);
        free(judgement.findings);
    }
}

/* On white, where the light is so strong that parts of patches are white. */
static void hidden_by_white(void **state) {
    (void)state;
    acid_shot shot = plain_shot();
    acid_judgement judgement;
    shot.background = 1;
    shot.exposure = 2.6;
    for (size_t i = 1; i < layout.row_count; ++i) shot.shows[i] = ACID_SHOWS_NOTHING;
    judge(&shot, &judgement);
    for (size_t i = 1; i < layout.row_count; ++i)
        if (strcmp(layout.rows[i].id, "flattened") != 0)
            assert_int_equal(judgement.findings[i].reason, ACID_REASON_HIDDEN);
    free(judgement.findings);
}

static int is_of_mark(const acid_picture *picture, size_t pixel) {
    const double at[2] = {(double)(pixel % picture->width) / (double)picture->width,
        (double)(pixel / picture->width) / (double)picture->height};
    for (int i = 0; i < ACID_MARKS; ++i)
        if (fabs(at[0] - layout.marks[i].center[0]) < 0.6 * layout.marks[i].size[0] &&
            fabs(at[1] - layout.marks[i].center[1]) < 0.6 * layout.marks[i].size[1])
            return 1;
    return 0;
}

/* What is drawn is not missing, however near the colours of patches are to those around them: here
 * noise about the mean of all patches, and less and less of their contrast. */
static void drawn_on_its_own_color(void **state) {
    (void)state;
    acid_shot shot = plain_shot();
    acid_picture dark, light;
    double mean[3] = {0}, count = 0;
    uint32_t noise = 1;
    assert_true(acid_shot_take(&shot, &layout, &dark));
    shot.background = 1;
    assert_true(acid_shot_take(&shot, &layout, &light));
    const size_t size = 3 * light.width * light.height;
    uint8_t *shown = malloc(size);
    for (size_t i = 0; i < size; i += 3) {
        const uint8_t *p = dark.pixels + i;
        if (memcmp(p, light.pixels + i, 3) != 0 || is_of_mark(&dark, i / 3)) continue;
        for (int k = 0; k < 3; ++k) mean[k] += p[k];
        ++count;
    }
    for (double share = 0.5; share > 0.25; share -= 0.02) {
        acid_judgement judgement;
        acid_picture picture = light;
        picture.pixels = shown;
        for (size_t i = 0; i < size; ++i) {
            const size_t first = i / 3 * 3;
            const double about = mean[i % 3] / count;
            noise = noise * 1664525 + 1013904223;
            if (is_of_mark(&dark, i / 3))
                shown[i] = dark.pixels[i];
            else if (memcmp(dark.pixels + first, light.pixels + first, 3) == 0)
                shown[i] = (uint8_t)(about + share * (dark.pixels[i] - about));
            else
                shown[i] = (uint8_t)(about - 24 + (noise >> 16) % 48);
        }
        assert_int_equal(judge_picture(&picture, &judgement), 1);
        assert_int_equal(judgement.counts[ACID_MISSING], 0);
        free(judgement.findings);
    }
    free(shown);
    free(dark.pixels);
    free(light.pixels);
}

/* None is judged wrongly, and hardly any is left open. */
static void distorted(void **state) {
    (void)state;
    size_t open = 0, all = 0;
    for (uint32_t number = 1000; number < 1000 + 4 / (SLOWER > 4 ? 4 : SLOWER); ++number) {
        acid_shot shot;
        acid_judgement judgement;
        acid_shot_choose(&shot, &layout, number);
        judge(&shot, &judgement);
        for (size_t i = 0; i < layout.row_count; ++i) {
            const acid_finding *finding = &judgement.findings[i];
            const int is_open = finding->verdict == ACID_UNCLEAR;
            ++all;
            open += is_open && expected(&shot, i) != ACID_UNCLEAR;
            if (!is_open && !is_as_expected(&shot, i, finding)) {
                print_error("%u: %s shows %d: verdict %d, nearest %d\n", number, layout.rows[i].id,
                    shot.shows[i], (int)finding->verdict, finding->nearest);
                fail();
            }
        }
        free(judgement.findings);
    }
    assert_true(100 * open <= all);
}

static size_t row_of(const char *id) {
    size_t row = 0;
    while (strcmp(layout.rows[row].id, id) != 0) assert_true(++row < layout.row_count);
    return row;
}

static void assert_open(const acid_shot *shot, size_t row, acid_reason reason) {
    acid_judgement judgement;
    judge(shot, &judgement);
    assert_int_equal(judgement.findings[row].verdict, ACID_UNCLEAR);
    assert_int_equal(judgement.findings[row].reason, reason);
    assert_int_equal(judgement.counts[ACID_FAIL], shot->shows[row_of("tangent-sign")] > 0);
    free(judgement.findings);
}

/* sign-kept is named where tangent-sign passes, and only there. */
static void alike(void **state) {
    (void)state;
    const size_t mirror = row_of("tangent-mirror"), sign = row_of("tangent-sign");
    acid_shot shot = plain_shot();
    acid_judgement judgement;
    shot.shows[mirror] = 1;
    judge(&shot, &judgement);
    assert_expected(&shot, &judgement);
    assert_int_equal(judgement.counts[ACID_FAIL], 1);
    free(judgement.findings);
    for (int what = ACID_SHOWS_OTHER; what < 3; ++what) {
        shot.shows[sign] = what;
        if (what) assert_open(&shot, mirror, ACID_REASON_ELSEWHERE);
    }
    shot.shows[sign] = 0;
    layout.rows[sign].skipped = 1;
    assert_open(&shot, mirror, ACID_REASON_ELSEWHERE);
    layout.rows[sign].skipped = 0;
}

/* scale-on-z is not named where tangent-sign shows neither the right relief nor a mistake's. */
static void without_relief(void **state) {
    (void)state;
    const size_t scale = row_of("normal-scale"), sign = row_of("tangent-sign");
    acid_shot shot = plain_shot();
    shot.shows[scale] = 2;
    assert_string_equal(layout.rows[scale].references[2].id, "scale-on-z");
    for (int what = ACID_SHOWS_OTHER; what < 3; ++what) {
        acid_judgement judgement;
        shot.shows[sign] = what;
        if (what < 0) {
            assert_open(&shot, scale, ACID_REASON_NO_RELIEF);
            continue;
        }
        judge(&shot, &judgement);
        assert_expected(&shot, &judgement);
        free(judgement.findings);
    }
}

/* A picture that is turned or mirrored shows the same. */
static void turned(void **state) {
    (void)state;
    acid_shot shot = plain_shot();
    for (size_t i = 0; i < layout.row_count; ++i)
        shot.shows[i] = (int)(i % layout.rows[i].reference_count);
    for (int turn = 0; turn < 4; ++turn) {
        acid_judgement judgement;
        const double x = turn & 1 ? 560 : 0, y = turn & 2 ? 420 : 0,
                     corners[4][2] = {{x, y}, {560 - x, y}, {560 - x, 420 - y}, {x, 420 - y}};
        memcpy(shot.corners, corners, sizeof corners);
        judge(&shot, &judgement);
        assert_expected(&shot, &judgement);
        free(judgement.findings);
    }
}

/* Where the control is not like its reference, nothing is known. */
static void control_fails(void **state) {
    (void)state;
    acid_shot shot = plain_shot();
    for (int what = -2; what < 0; ++what) {
        acid_judgement judgement;
        shot.shows[0] = what;
        judge(&shot, &judgement);
        assert_int_equal(
            judgement.findings[0].verdict, what == ACID_SHOWS_NOTHING ? ACID_MISSING : ACID_FAIL);
        assert_int_equal(judgement.findings[0].nearest, -1);
        assert_int_equal(judgement.counts[ACID_UNCLEAR], layout.row_count - 1);
        assert_int_equal(judgement.findings[5].reason, ACID_REASON_CONTROL);
        free(judgement.findings);
    }
}

/* Without light all patches are alike: no verdict, rather than a pass. */
static void no_light(void **state) {
    (void)state;
    acid_shot shot = plain_shot();
    acid_judgement judgement;
    shot.exposure = 0.0002;
    judge(&shot, &judgement);
    assert_int_equal(judgement.counts[ACID_PASS], 0);
    assert_int_equal(judgement.findings[0].verdict, ACID_FAIL);
    free(judgement.findings);
}

static int is_in_box(double u, double v, const acid_box *box) {
    return fabs(u - box->center[0]) < 0.6 * box->size[0] &&
           fabs(v - box->center[1]) < 0.6 * box->size[1];
}

/* One light makes all patches green: a hundred squares of a mark's hue, larger than the mark. */
static void one_color(void **state) {
    (void)state;
    acid_shot shot = plain_shot();
    acid_judgement judgement;
    acid_picture picture;
    assert_true(acid_shot_take(&shot, &layout, &picture));
    for (size_t i = 0; i < picture.width * picture.height; ++i) {
        const double u = ((double)(i % picture.width) + 0.5) / (double)picture.width,
                     v = ((double)(i / picture.width) + 0.5) / (double)picture.height;
        uint8_t *p = picture.pixels + 3 * i;
        int is_mark = 0;
        for (int k = 0; k < ACID_MARKS; ++k) is_mark |= is_in_box(u, v, &layout.marks[k]);
        if (is_mark || p[0] + p[1] + p[2] == 0) continue;
        p[1] = (uint8_t)(150 + p[1] / 4);
        p[0] = (uint8_t)(p[1] / 4);
        p[2] = (uint8_t)(p[1] / 8);
    }
    assert_int_equal(judge_picture(&picture, &judgement), 1);
    assert_expected(&shot, &judgement);
    free(judgement.findings);
    free(picture.pixels);
}

static void too_small(void **state) {
    (void)state;
    acid_shot shot = plain_shot();
    acid_judgement judgement;
    shot.width = 180;
    shot.height = 135;
    shot.antialias = 1;
    for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 2; ++k) shot.corners[i][k] *= 180.0 / 560;
    judge(&shot, &judgement);
    assert_int_equal(judgement.findings[0].reason, ACID_REASON_SMALL);
    assert_int_equal(judgement.counts[ACID_PASS], 0);
    free(judgement.findings);
}

static void skipped(void **state) {
    (void)state;
    acid_shot shot = plain_shot();
    acid_judgement judgement;
    layout.rows[9].skipped = 1;
    shot.shows[9] = 1;
    judge(&shot, &judgement);
    layout.rows[9].skipped = 0;
    assert_int_equal(judgement.findings[9].verdict, ACID_SKIPPED);
    assert_int_equal(judgement.counts[ACID_SKIPPED], 1);
    assert_int_equal(judgement.counts[ACID_PASS], layout.row_count - 1);
    free(judgement.findings);
}

/* ---- pictures without the marks */

static void paint_box(acid_picture *picture, const acid_box *box, const uint8_t color[3]) {
    for (size_t y = 0; y < picture->height; ++y)
        for (size_t x = 0; x < picture->width; ++x)
            if (is_in_box(((double)x + 0.5) / (double)picture->width,
                    ((double)y + 0.5) / (double)picture->height, box))
                memcpy(picture->pixels + 3 * (y * picture->width + x), color, 3);
}

static void marks_absent(void **state) {
    (void)state;
    static const uint8_t grey[3] = {90, 90, 90}, red[3] = {255, 0, 0};
    acid_shot shot = plain_shot();
    acid_judgement judgement;
    for (int mark = 0; mark < ACID_MARKS; ++mark) { /* one is covered, or has another's colour */
        acid_picture picture;
        assert_true(acid_shot_take(&shot, &layout, &picture));
        paint_box(&picture, &layout.marks[mark], mark ? red : grey);
        assert_int_equal(judge_picture(&picture, &judgement), 0);
        free(picture.pixels);
    }
}

static void other_pictures(void **state) {
    (void)state;
    static uint8_t pixels[3 * 300 * 200];
    acid_picture picture = {300, 200, pixels};
    acid_judgement judgement;
    uint32_t seed = 7;
    assert_int_equal(judge_picture(&picture, &judgement), 0);
    for (int coarse = 1; coarse <= 16; coarse *= 2) { /* random colours, in squares */
        for (size_t i = 0; i < 300 * 200; ++i) {
            const size_t x = i % 300 / (size_t)coarse, y = i / 300 / (size_t)coarse;
            seed = (uint32_t)(x * 2654435761u + y * 40503u + (size_t)coarse);
            for (int k = 0; k < 3; ++k) {
                seed = seed * 1664525u + 1013904223u;
                pixels[3 * i + (size_t)k] = (uint8_t)(seed >> 24 & 0x80 ? 255 : 0);
            }
        }
        if (judge_picture(&picture, &judgement) == 0) continue;
        assert_int_equal(judgement.counts[ACID_PASS], 0); /* squares that happen to lie so */
        assert_int_equal(judgement.counts[ACID_UNCLEAR], layout.row_count - 1);
        free(judgement.findings);
    }
    picture.width = picture.height = 1;
    assert_int_equal(judge_picture(&picture, &judgement), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_mistake),
        cmocka_unit_test(missing_and_strange),
        cmocka_unit_test(hidden_by_white),
        cmocka_unit_test(drawn_on_its_own_color),
        cmocka_unit_test(distorted),
        cmocka_unit_test(alike),
        cmocka_unit_test(without_relief),
        cmocka_unit_test(turned),
        cmocka_unit_test(control_fails),
        cmocka_unit_test(no_light),
        cmocka_unit_test(one_color),
        cmocka_unit_test(too_small),
        cmocka_unit_test(skipped),
        cmocka_unit_test(marks_absent),
        cmocka_unit_test(other_pictures),
    };
    return cmocka_run_group_tests_name("acid_judge", tests, set_up, tear_down);
}
