/* test_tangent_plan.c: updates of tangent plans against norma_corner_tangents at the same positions
 * and normals, bit for bit: meshes whose vertices part, meet, collapse and are no numbers, all
 * updated or only what moved; threads, memory, cancelling, arguments. */
#include "check.h"
#include "accountant.h"
#include "watcher.h"

enum { MOST = 2000, MOST_FACES = 600 };

/* How normals and texture coordinates are given. */
enum { PER_VERTEX, NORMALS_PER_CORNER, OWN_TEXCOORDS, LAYOUTS };

typedef struct model {
    float positions[MOST][3], first[MOST][3]; /* now, and as the plan was made of them */
    float normals[MOST][3], texcoords[MOST][2];
    uint32_t corners[MOST], texcoord_corners[MOST], starts[MOST_FACES + 1];
    size_t vertices, corner_count, faces;
    int layout;
    uint64_t seed;
    uint32_t moved[64];
    size_t moved_count;
} model;

static const norma_options NO_OPTIONS;

typedef struct answer {
    norma_result result;
    float tangents[MOST][4];
    uint8_t reasons[MOST];
    norma_report report;
} answer;

static uint32_t below(model *m, uint32_t count) {
    m->seed = m->seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(m->seed >> 33) % count;
}

/* ---- models */

static void choose_normal(model *m, float normal[3]) {
    static const float choices[][3] = {{0, 0, 1}, {0, 0.6F, 0.8F}, {0.6F, 0, 0.8F}, {-0.0F, 0, 1}};
    memcpy(normal, choices[below(m, 4)], 12);
}

static void add_face(model *m, size_t count, const uint32_t *corners) {
    memcpy(m->corners + m->corner_count, corners, count * sizeof *corners);
    m->corner_count += count;
    m->starts[++m->faces] = (uint32_t)m->corner_count;
}

/* Few places, so that nearly everything is a special case. */
static void fill_scramble(model *m) {
    const uint32_t steps = 2 + (uint32_t)(m->seed / 12 % 3);
    m->vertices = steps == 2 ? 60 : 14; /* many of the same texture coordinates, or some */
    for (size_t v = 0; v < m->vertices; ++v) {
        for (int k = 0; k < 3; ++k) m->positions[v][k] = (float)below(m, 3) * 0.37F;
        for (int k = 0; k < 2; ++k) m->texcoords[v][k] = (float)below(m, steps) / 3;
    }
    for (int f = 0; f < 30; ++f) {
        uint32_t corners[6];
        const size_t count = 3 + below(m, 4) * (f % 5 == 0 && m->seed % 2);
        for (size_t i = 0; i < count; ++i) corners[i] = below(m, (uint32_t)m->vertices);
        add_face(m, count, corners);
    }
}

/* A sheet, in triangles or in quads, so large that most of it lies far from what moves. Some of its
 * vertices stand twice, and some texture coordinates on both of two charts, between which there may
 * be faces without texture area. */
static void fill_sheet(model *m, int quads) {
    enum { SIDE = 15 };
    const int tiled = m->seed % 5 == 4; /* many vertices for each pair of texture coordinates */
    const uint32_t mirrored = below(m, 3), cracked = below(m, 2);
    for (int y = 0; y <= SIDE; ++y)
        for (int x = 0; x <= SIDE; ++x) {
            const size_t v = m->vertices++;
            const int crack = cracked && y % 5 == 4;
            memcpy(m->positions[v],
                (float[]){(float)x, (float)(y - crack), 0.1F * (float)below(m, 5)}, 12);
            if (crack) memcpy(m->positions[v], m->positions[v - SIDE - 1], 12);
            const int u = mirrored && x > SIDE / 2 ? SIDE - 2 + (int)mirrored - x : x;
            memcpy(m->texcoords[v], (float[]){(float)u / 8, (float)(y - crack) / 8}, 8);
            if (tiled) memcpy(m->texcoords[v], (float[]){(float)(x % 2), (float)(y % 2)}, 8);
        }
    for (uint32_t y = 0; y < SIDE; ++y)
        for (uint32_t x = 0; x < SIDE; ++x) {
            const uint32_t a = y * (SIDE + 1) + x, d = a + SIDE + 1;
            if (cracked && y % 5 == 3) continue;
            if (quads && below(m, 3)) {
                add_face(m, 4, (uint32_t[]){a, a + 1, d + 1, d});
                continue;
            }
            add_face(m, 3, (uint32_t[]){a, a + 1, d + 1});
            add_face(m, 3, (uint32_t[]){a, d + 1, d});
        }
}

static model *make(uint64_t seed) {
    model *m = calloc(1, sizeof *m);
    m->seed = seed;
    if (seed % 4 == 0)
        fill_scramble(m);
    else
        fill_sheet(m, seed % 4 == 1);
    m->layout = (int)(seed / 4 % LAYOUTS);
    const size_t count = m->layout == NORMALS_PER_CORNER ? m->corner_count : m->vertices;
    for (size_t i = 0; i < count; ++i) memcpy(m->normals[i], (float[]){0, 0, 1}, 12);
    memcpy(m->texcoord_corners, m->corners, sizeof m->corners);
    memcpy(m->first, m->positions, sizeof m->first);
    return m;
}

static norma_mesh mesh_of(const model *m) {
    return (norma_mesh){.positions = {.data = m->positions, .count = m->vertices},
        .corners = m->corners,
        .corner_count = m->corner_count,
        .face_starts = m->starts,
        .face_count = m->faces};
}

static norma_attribute normals_of(const model *m) {
    const int per_corner = m->layout == NORMALS_PER_CORNER;
    return (norma_attribute){.data = m->normals,
        .count = per_corner ? m->corner_count : m->vertices,
        .of = per_corner ? NORMA_PER_CORNER : NORMA_PER_VERTEX};
}

static norma_attribute texcoords_of(const model *m) {
    return (norma_attribute){.data = m->texcoords,
        .count = m->vertices,
        .corners = m->layout == OWN_TEXCOORDS ? m->texcoord_corners : NULL};
}

static norma_tangent_plan *plan_of(const model *m, norma_tangent_mode mode) {
    const norma_mesh mesh = mesh_of(m);
    const norma_attribute normals = normals_of(m), texcoords = texcoords_of(m);
    norma_tangent_plan *plan = NULL;
    assert_ok(norma_tangent_plan_create(&mesh, &normals, &texcoords, mode, NULL, &plan));
    return plan;
}

static void full(const model *m, norma_tangent_mode mode, norma_options options, answer *a) {
    const norma_mesh mesh = mesh_of(m);
    const norma_attribute normals = normals_of(m), texcoords = texcoords_of(m);
    options.reasons = a->reasons;
    assert_ok(norma_corner_tangents(
        &mesh, &normals, &texcoords, mode, &options, a->tangents[0], MOST, &a->report));
}

static void update(const norma_tangent_plan *plan, const model *m, const uint32_t *moved,
    norma_options options, answer *a) {
    const norma_vec3_view positions = mesh_of(m).positions;
    const norma_attribute normals = normals_of(m);
    options.reasons = a->reasons;
    a->result = norma_tangent_plan_update(plan, positions, &normals, moved, m->moved_count,
        &options, a->tangents[0], MOST, &a->report);
}

/* ---- motions */

static int same_first(const model *m, uint32_t v, uint32_t w) {
    const float *a = m->first[v], *b = m->first[w];
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static int is_moved(const model *m, uint32_t vertex) {
    for (size_t i = 0; i < m->moved_count; ++i)
        if (m->moved[i] == vertex) return 1;
    return 0;
}

/* Normals at a place: some of them change. */
static void turn_normals(model *m, uint32_t vertex) {
    if (m->layout != NORMALS_PER_CORNER) {
        for (uint32_t v = 0; v < m->vertices; ++v)
            if (same_first(m, v, vertex) && !below(m, 3)) choose_normal(m, m->normals[v]);
        return;
    }
    for (size_t c = 0; c < m->corner_count; ++c)
        if (same_first(m, m->corners[c], vertex) && !below(m, 3)) choose_normal(m, m->normals[c]);
}

static void turn_normals_around(model *m) {
    uint8_t touched[MOST] = {0};
    for (size_t f = 0; f < m->faces; ++f) {
        int moves = 0;
        for (uint32_t c = m->starts[f]; c < m->starts[f + 1]; ++c)
            moves |= is_moved(m, m->corners[c]);
        for (uint32_t c = m->starts[f]; moves && c < m->starts[f + 1]; ++c)
            touched[m->corners[c]] = 1;
    }
    for (uint32_t v = 0; v < m->vertices; ++v)
        if (touched[v] && !below(m, 2)) turn_normals(m, v);
}

static void move_vertex(model *m, uint32_t v) {
    const uint32_t last = (uint32_t)m->vertices - 1, kind = below(m, 12),
                   other = kind % 2 && v < last ? v + 1 : below(m, last + 1);
    if (kind < 6)
        m->positions[v][below(m, 3)] += 0.01F * (float)below(m, 20);
    else if (kind < 9)
        memcpy(m->positions[v], m->first[v], 12);
    else if (kind < 11)
        memcpy(m->positions[v], m->positions[other], 12);
    else
        m->positions[v][below(m, 3)] = below(m, 2) ? NAN : INFINITY;
}

static void move(model *m) {
    m->moved_count = below(m, 4);
    for (size_t i = 0; i < m->moved_count; ++i) {
        m->moved[i] = below(m, (uint32_t)m->vertices);
        move_vertex(m, m->moved[i]);
    }
    if (below(m, 2)) turn_normals_around(m);
    if (m->moved_count && !below(m, 4)) m->moved[m->moved_count++] = m->moved[0];
}

/* ---- the same bits */

static void assert_same(const answer *a, const answer *b, size_t corners) {
    for (size_t c = 0; c < corners; ++c) {
        assert_memory_equal(a->tangents[c], b->tangents[c], 16);
        assert_int_equal(a->reasons[c], b->reasons[c]);
    }
}

static size_t count_reasons(const answer *a, size_t corners, int reason, const uint8_t *written) {
    size_t count = 0;
    for (size_t c = 0; c < corners; ++c)
        count += a->reasons[c] == reason && (!written || written[c]);
    return count;
}

/* From one right state to the next by what moved alone. Returns how many corners were written. */
static size_t follow(const norma_tangent_plan *plan, const model *m, answer *a) {
    static const float mark[4] = {7, 7, 7, 7};
    uint8_t written[MOST];
    size_t count = 0;
    answer *fresh = malloc(sizeof *fresh);
    for (size_t c = 0; c < m->corner_count; ++c) memcpy(fresh->tangents[c], mark, 16);
    memset(fresh->reasons, 99, sizeof fresh->reasons);
    update(plan, m, m->moved, (norma_options){.threads = 1}, fresh);
    assert_ok(fresh->result);
    for (size_t c = 0; c < m->corner_count; ++c) {
        written[c] = memcmp(fresh->tangents[c], mark, 16) != 0;
        assert_int_equal(written[c], fresh->reasons[c] != 99);
        count += written[c];
        if (!written[c]) continue;
        memcpy(a->tangents[c], fresh->tangents[c], 16);
        a->reasons[c] = fresh->reasons[c];
    }
    assert_int_equal(fresh->report.non_finite.count,
        count_reasons(a, m->corner_count, NORMA_REASON_NON_FINITE, written));
    assert_int_equal(fresh->report.cancelled.count,
        count_reasons(a, m->corner_count, NORMA_REASON_CANCELLED, written));
    assert_int_equal(fresh->report.degenerate_faces.count,
        count_reasons(a, m->corner_count, NORMA_REASON_DEGENERATE, written));
    free(fresh);
    return count;
}

static void moving_meshes(void **state) {
    (void)state;
    size_t in_part = 0, whole = 0;
    answer *a = calloc(1, sizeof *a), *b = calloc(1, sizeof *b), *expected = calloc(1, sizeof *a);
    for (uint64_t seed = 0; seed < 144 / SLOWER; ++seed)
        for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
            model *m = make(seed);
            norma_tangent_plan *plan = plan_of(m, (norma_tangent_mode)mode);
            full(m, (norma_tangent_mode)mode, NO_OPTIONS, a);
            for (int step = 0; step < 40; ++step) {
                move(m);
                const size_t count = follow(plan, m, a);
                in_part += count > 0 && count < m->corner_count;
                whole += count == m->corner_count;
                full(m, (norma_tangent_mode)mode, NO_OPTIONS, expected);
                assert_same(a, expected, m->corner_count);
                update(plan, m, NULL, NO_OPTIONS, b);
                assert_ok(b->result);
                assert_same(b, expected, m->corner_count);
                assert_memory_equal(&b->report, &expected->report, sizeof b->report);
            }
            norma_tangent_plan_destroy(plan);
            free(m);
        }
    assert_true(in_part > 400 / SLOWER && whole > 400 / SLOWER); /* both ways were taken */
    free(a);
    free(b);
    free(expected);
}

/* Far from what moved nothing is written. */
static void only_what_moved(void **state) {
    (void)state;
    for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
        model *m = make(2); /* a sheet in triangles, values per vertex */
        answer *a = calloc(1, sizeof *a);
        norma_tangent_plan *plan = plan_of(m, (norma_tangent_mode)mode);
        full(m, (norma_tangent_mode)mode, NO_OPTIONS, a);
        m->moved_count = 1;
        m->moved[0] = 40;
        m->positions[40][2] += 0.5F;
        const size_t count = follow(plan, m, a);
        assert_true(count > 0 && count < m->corner_count / 4);
        m->moved_count = 0;
        assert_int_equal(follow(plan, m, a), 0);
        assert_true(norma_tangent_plan_bytes(plan) > m->corner_count * sizeof(uint32_t));
        norma_tangent_plan_destroy(plan);
        free(a);
        free(m);
    }
}

/* A quad with two equal positions: one of the two corners there takes the tangent of the other,
 * though it has other texture coordinates, also when the other's changes later. */
static void quad_with_an_edge_of_no_length(void **state) {
    (void)state;
    enum { QUADS = 40, AT = 20 };
    model *m = calloc(1, sizeof *m);
    answer *a = calloc(1, sizeof *a), *expected = calloc(1, sizeof *a);
    for (uint32_t y = 0; y < 2; ++y)
        for (uint32_t x = 0; x <= QUADS; ++x) {
            const float p[3] = {(float)x, (float)y, 0};
            memcpy(m->positions[m->vertices], p, 12);
            memcpy(m->texcoords[m->vertices], p, 8);
            memcpy(m->normals[m->vertices++], (float[]){0, 0, 1}, 12);
        }
    for (uint32_t q = 0; q < QUADS; ++q)
        add_face(m, 4, (uint32_t[]){q, q + 1, q + QUADS + 2, q + QUADS + 1});
    memcpy(m->first, m->positions, sizeof m->first);
    norma_tangent_plan *plan = plan_of(m, NORMA_TANGENTS_MIKK);
    memcpy(m->positions[AT + 1], m->positions[AT], 12);
    full(m, NORMA_TANGENTS_MIKK, NO_OPTIONS, a);
    m->moved_count = 1;
    m->moved[0] = AT + 2;
    m->positions[AT + 2][1] -= 0.3F;
    (void)follow(plan, m, a);
    full(m, NORMA_TANGENTS_MIKK, NO_OPTIONS, expected);
    assert_same(a, expected, m->corner_count);
    norma_tangent_plan_destroy(plan);
    free(m);
    free(a);
    free(expected);
}

/* One good triangle, and a corner that lies first with one of its corners, then with another. */
static void quad_whose_corner_moves_along(void **state) {
    (void)state;
    model *m = calloc(1, sizeof *m);
    answer *a = calloc(1, sizeof *a), *expected = calloc(1, sizeof *a);
    const float places[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                normals[4][3] = {{0, 0, 1}, {0.6F, 0, 0.8F}, {0, 0, 1}, {-0.6F, 0, 0.8F}};
    memcpy(m->positions, places, sizeof places);
    memcpy(m->normals, normals, sizeof normals);
    for (size_t v = 0; v < 4; ++v) {
        m->texcoords[v][0] = places[v][0] + 0.25F * places[v][1]; /* cut at the second corner */
        m->texcoords[v][1] = places[v][1];
    }
    m->vertices = 4;
    add_face(m, 4, (uint32_t[]){0, 1, 2, 3});
    memcpy(m->positions[0], places[1], 12);
    norma_tangent_plan *plan = plan_of(m, NORMA_TANGENTS_MIKK);
    memcpy(m->positions[0], places[3], 12);
    update(plan, m, NULL, NO_OPTIONS, a);
    assert_ok(a->result);
    full(m, NORMA_TANGENTS_MIKK, NO_OPTIONS, expected);
    assert_same(a, expected, 4);
    assert_memory_equal(a->tangents[0], a->tangents[3], 16);
    assert_memory_not_equal(a->tangents[1], a->tangents[3], 16);
    norma_tangent_plan_destroy(plan);
    free(m);
    free(a);
    free(expected);
}

/* A normal that was not finite kept the whole face from having tangents: its vertex is named when
 * it gets another, and then the tangents of the face's other corners follow. */
static void normals_that_were_not_finite(void **state) {
    (void)state;
    enum { AT = 40 };
    for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
        model *m = make(2); /* a sheet in triangles, values per vertex */
        answer *a = calloc(1, sizeof *a), *expected = calloc(1, sizeof *a);
        norma_tangent_plan *plan = plan_of(m, (norma_tangent_mode)mode);
        m->normals[AT][1] = NAN;
        full(m, (norma_tangent_mode)mode, NO_OPTIONS, a);
        m->normals[AT][1] = 0;
        m->moved_count = 1;
        m->moved[0] = AT;
        const size_t count = follow(plan, m, a);
        assert_true(count > 0 && count < m->corner_count / 4);
        full(m, (norma_tangent_mode)mode, NO_OPTIONS, expected);
        assert_same(a, expected, m->corner_count);
        norma_tangent_plan_destroy(plan);
        free(expected);
        free(a);
        free(m);
    }
}

static void backwards(void *user, size_t count, norma_task *task, void *context) {
    (void)user;
    while (count-- > 0) task(context, count);
}

static void the_same_bits_however(void **state) {
    (void)state;
    const norma_options ways[] = {{.threads = 2}, {.threads = 64}, {.parallel_for = backwards},
        {.isa = NORMA_ISA_PORTABLE}, {.isa = NORMA_ISA_AVX2}, {.isa = NORMA_ISA_AVX512}};
    answer *a = calloc(1, sizeof *a), *b = calloc(1, sizeof *b);
    for (uint64_t seed = 0; seed < 24; ++seed)
        for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
            model *m = make(seed);
            norma_tangent_plan *plan = plan_of(m, (norma_tangent_mode)mode);
            for (int step = 0; step < 4; ++step) move(m);
            full(m, (norma_tangent_mode)mode, NO_OPTIONS, a);
            for (size_t i = 0; i < COUNT_OF(ways); ++i) {
                *b = *a;
                update(plan, m, i % 2 ? m->moved : NULL, ways[i], b);
                if (b->result == NORMA_ERROR_ARGUMENT) continue; /* no such machine */
                /* The last step's corners are written, the others are as they were. */
                assert_same(b, a, m->corner_count);
            }
            norma_tangent_plan_destroy(plan);
            free(m);
        }
    free(a);
    free(b);
}

/* ---- memory and cancelling */

static void each_allocation_of_creation_failing(void **state) {
    (void)state;
    for (uint64_t seed = 0; seed < 12; ++seed)
        for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
            model *m = make(seed);
            const norma_mesh mesh = mesh_of(m);
            const norma_attribute normals = normals_of(m), texcoords = texcoords_of(m);
            for (size_t n = 1, done = 0; !done; ++n) {
                accountant a = {.fail_at = n};
                const norma_options options = {.allocator = {accountant_take, accountant_give, &a}};
                norma_tangent_plan *plan = NULL;
                const norma_result result = norma_tangent_plan_create(
                    &mesh, &normals, &texcoords, (norma_tangent_mode)mode, &options, &plan);
                assert_int_equal(result, a.calls < n ? NORMA_OK : NORMA_ERROR_MEMORY);
                done = !result;
                assert_int_equal(plan != NULL, done);
                assert_int_equal(a.live != 0, done);
                norma_tangent_plan_destroy(plan);
                assert_true(a.live == 0 && !a.wrong);
            }
            free(m);
        }
}

static void each_allocation_of_updates_failing(void **state) {
    (void)state;
    answer *expected = calloc(1, sizeof *expected), *got = calloc(1, sizeof *got);
    for (uint64_t seed = 0; seed < 12; ++seed)
        for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
            model *m = make(seed);
            norma_tangent_plan *plan = plan_of(m, (norma_tangent_mode)mode);
            for (int step = 0; step < 6; ++step) move(m);
            full(m, (norma_tangent_mode)mode, NO_OPTIONS, expected);
            for (int all = 0; all < 2; ++all)
                for (size_t n = 1, done = 0; !done; ++n) {
                    accountant a = {.fail_at = n};
                    *got = *expected;
                    update(plan, m, all ? NULL : m->moved,
                        (norma_options){.allocator = {accountant_take, accountant_give, &a}}, got);
                    assert_true(a.live == 0 && !a.wrong);
                    assert_int_equal(got->result, a.calls < n ? NORMA_OK : NORMA_ERROR_MEMORY);
                    done = !got->result;
                    if (done) assert_same(got, expected, m->corner_count);
                }
            norma_tangent_plan_destroy(plan);
            free(m);
        }
    free(expected);
    free(got);
}

static void cancelling(void **state) {
    (void)state;
    answer *a = calloc(1, sizeof *a);
    for (uint64_t seed = 0; seed < 8; ++seed)
        for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
            model *m = make(seed);
            const norma_mesh mesh = mesh_of(m);
            const norma_attribute normals = normals_of(m), texcoords = texcoords_of(m);
            norma_tangent_plan *plan = NULL;
            for (size_t n = 1; !plan; ++n) {
                watcher w = {.stop_at = n};
                accountant account = {0};
                const norma_options options = {.progress = watch,
                    .progress_user = &w,
                    .allocator = {accountant_take, accountant_give, &account}};
                const norma_result result = norma_tangent_plan_create(
                    &mesh, &normals, &texcoords, (norma_tangent_mode)mode, &options, &plan);
                assert_int_equal(result, w.calls < n ? NORMA_OK : NORMA_CANCELLED);
                assert_true(!w.fell && (plan != NULL) == (account.live != 0));
                norma_tangent_plan_destroy(plan);
                assert_int_equal(account.live, 0);
            }
            plan = plan_of(m, (norma_tangent_mode)mode);
            move(m);
            for (int all = 0; all < 2; ++all)
                for (size_t n = 1, done = 0; !done; ++n) {
                    watcher w = {.stop_at = n};
                    accountant account = {0};
                    update(plan, m, all ? NULL : m->moved,
                        (norma_options){.progress = watch,
                            .progress_user = &w,
                            .allocator = {accountant_take, accountant_give, &account}},
                        a);
                    assert_int_equal(a->result, w.calls < n ? NORMA_OK : NORMA_CANCELLED);
                    assert_true(!w.fell && account.live == 0);
                    done = !a->result;
                    if (done) assert_true(w.last == 1);
                }
            norma_tangent_plan_destroy(plan);
            free(m);
        }
    free(a);
}

/* ---- arguments */

static void wrong_arguments(void **state) {
    (void)state;
    model *m = make(1);
    const norma_mesh mesh = mesh_of(m);
    const norma_attribute normals = normals_of(m), texcoords = texcoords_of(m),
                          per_corner = {.data = m->normals, .count = MOST, .of = NORMA_PER_CORNER};
    const norma_tangent_mode mode = NORMA_TANGENTS_MIKK;
    norma_tangent_plan *plan = NULL;
    assert_int_equal(norma_tangent_plan_create(&mesh, &normals, &texcoords, mode, NULL, NULL),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_tangent_plan_create(&mesh, &normals, &texcoords, (norma_tangent_mode)2, NULL, &plan),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_tangent_plan_create(&mesh, NULL, &texcoords, mode, NULL, &plan),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_tangent_plan_create(NULL, &normals, &texcoords, mode, NULL, &plan),
        NORMA_ERROR_ARGUMENT);
    m->corners[5] = 1999;
    assert_int_equal(norma_tangent_plan_create(&mesh, &normals, &texcoords, mode, NULL, &plan),
        NORMA_ERROR_INDEX);
    m->corners[5] = 1;
    assert_null(plan);
    plan = plan_of(m, mode);

    answer *a = calloc(1, sizeof *a), *before = calloc(1, sizeof *a);
    const uint32_t beyond[] = {3, (uint32_t)m->vertices};
    const size_t corners = m->corner_count;
    norma_vec3_view fewer = mesh.positions;
    --fewer.count;
    norma_attribute short_normals = normals, unknown = normals;
    --short_normals.count;
    unknown.format = (norma_format)9;
    const norma_options narrow = {.normal_stride = 12};
#define UPDATE(plan, positions, normals, moved, options, tangents, capacity)                       \
    norma_tangent_plan_update(plan, positions, normals, moved, 2, options, tangents, capacity, NULL)
#define REFUSED(call, expected)                                                                    \
    do {                                                                                           \
        assert_int_equal(call, expected);                                                          \
        assert_memory_equal(a, before, sizeof *a);                                                 \
    } while (0)
    float *out = a->tangents[0];
    const norma_vec3_view at = mesh.positions;
    REFUSED(UPDATE(NULL, at, &normals, NULL, NULL, out, corners), NORMA_ERROR_ARGUMENT);
    REFUSED(UPDATE(plan, fewer, &normals, NULL, NULL, out, corners), NORMA_ERROR_ARGUMENT);
    REFUSED(UPDATE(plan, at, NULL, NULL, NULL, out, corners), NORMA_ERROR_ARGUMENT);
    REFUSED(UPDATE(plan, at, &short_normals, NULL, NULL, out, corners), NORMA_ERROR_ARGUMENT);
    REFUSED(UPDATE(plan, at, &unknown, NULL, NULL, out, corners), NORMA_ERROR_ARGUMENT);
    REFUSED(UPDATE(plan, at, &per_corner, NULL, NULL, out, corners), NORMA_ERROR_ARGUMENT);
    REFUSED(UPDATE(plan, at, &normals, NULL, &narrow, out, corners), NORMA_ERROR_ARGUMENT);
    REFUSED(UPDATE(plan, at, &normals, NULL, NULL, NULL, corners), NORMA_ERROR_ARGUMENT);
    REFUSED(UPDATE(plan, at, &normals, NULL, NULL, out, corners - 1), NORMA_ERROR_CAPACITY);
    REFUSED(UPDATE(plan, at, &normals, beyond, NULL, out, corners), NORMA_ERROR_INDEX);
    norma_tangent_plan_destroy(plan);

    const norma_mesh nothing = {.corner_count = 0};
    assert_ok(norma_tangent_plan_create(&nothing, NULL, NULL, mode, NULL, &plan));
    assert_ok(norma_tangent_plan_update(
        plan, (norma_vec3_view){.count = 0}, NULL, NULL, 0, NULL, NULL, 0, NULL));
    norma_tangent_plan_destroy(plan);
    norma_tangent_plan_destroy(NULL);
    assert_int_equal(norma_tangent_plan_bytes(NULL), 0);
    free(a);
    free(before);
    free(m);
}

/* It is refused although no tangent that is wanted needs it. */
static void corner_far_away_that_names_no_normal(void **state) {
    (void)state;
    const uint32_t moved = 40;
    for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
        model *m = make(2); /* a sheet in triangles */
        answer *a = calloc(1, sizeof *a), *before = calloc(1, sizeof *a);
        norma_attribute normals = normals_of(m);
        const norma_vec3_view positions = mesh_of(m).positions;
        m->layout = OWN_TEXCOORDS;
        norma_tangent_plan *plan = plan_of(m, (norma_tangent_mode)mode);
        normals.corners = m->texcoord_corners;
        m->texcoord_corners[m->corner_count - 1] = (uint32_t)m->vertices;
        for (int all = 0; all < 2; ++all) {
            assert_int_equal(norma_tangent_plan_update(plan, positions, &normals,
                                 all ? NULL : &moved, 1, NULL, a->tangents[0], MOST, NULL),
                NORMA_ERROR_INDEX);
            assert_memory_equal(a, before, sizeof *a);
        }
        norma_tangent_plan_destroy(plan);
        free(before);
        free(a);
        free(m);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(moving_meshes),
        cmocka_unit_test(only_what_moved), cmocka_unit_test(quad_with_an_edge_of_no_length),
        cmocka_unit_test(quad_whose_corner_moves_along),
        cmocka_unit_test(normals_that_were_not_finite), cmocka_unit_test(the_same_bits_however),
        cmocka_unit_test(each_allocation_of_creation_failing),
        cmocka_unit_test(each_allocation_of_updates_failing), cmocka_unit_test(cancelling),
        cmocka_unit_test(wrong_arguments), cmocka_unit_test(corner_far_away_that_names_no_normal)};
    return cmocka_run_group_tests_name("tangent plans", tests, NULL, NULL);
}
