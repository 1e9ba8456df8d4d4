/* test_plan.c: plans of meshes that move, over hundreds of small, nasty meshes. What an update must
 * give is found without the plan: the fans of the mesh at creation come from the oracle, each of
 * them becomes a vertex of a mesh whose vertices share nothing, and norma_vertex_normals of that
 * mesh gives the bits. */
#include "oracle/oracle.h"
#include "oracle/shapes.h"
#include "plan_check.h"

enum { MOST = 1024, MOVED_ROOM = 4096 };

typedef struct answer {
    float normals[3 * MOST];
    uint8_t reasons[MOST];
    norma_report report;
} answer;

typedef struct expected {
    oracle o;
    oracle_fans fans;
    int doubtful;
} expected;

static void expect(const plan_case *c, expected *e) {
    oracle_create(&e->o, &c->view, c->options.weld, c->options.weld_distance);
    oracle_fans_create(&e->fans, &e->o, c->crease_rad, c->options.non_manifold, 1e-12L);
    e->doubtful = 0;
    for (size_t f = 0; f < e->fans.fan_count; ++f) e->doubtful |= e->fans.doubtful[f];
}

static void expect_free(expected *e) {
    oracle_fans_destroy(&e->fans);
    oracle_destroy(&e->o);
}

/* A corner that another of its face stands for is in that one's fan. */
static size_t fan_of(const expected *e, size_t corner) {
    return e->fans.fan[e->o.kept[corner] == ORACLE_NONE ? corner : e->o.kept[corner]];
}

/* ---- the bits, by way of meshes that share by index alone */

typedef struct frozen {
    float positions[3 * (MOST + 1)];
    uint32_t corners[MOST];
    float normals[3 * (MOST + 1)];
    uint8_t reasons[MOST + 1];
} frozen;

static void freeze(const plan_case *c, frozen *z, size_t vertices) {
    norma_mesh mesh = c->view;
    norma_options options = c->options;
    mesh.positions = (norma_vec3_view){z->positions, vertices, 0, NORMA_FORMAT_FLOAT};
    mesh.corners = z->corners;
    mesh.corner_size = 4;
    options.weld = NORMA_WELD_NONE;
    options.reasons = z->reasons;
    assert_ok(norma_vertex_normals(&mesh, &options, z->normals, vertices, NULL));
}

static void expect_corners(const plan_case *c, const expected *e, frozen *z, answer *a) {
    for (size_t k = 0; k < c->mesh.corner_count; ++k) {
        z->corners[k] = (uint32_t)fan_of(e, k);
        memcpy(z->positions + 3 * z->corners[k], c->floats + 3 * c->mesh.corners[k], 12);
    }
    freeze(c, z, e->fans.fan_count);
    for (size_t k = 0; k < c->mesh.corner_count; ++k) {
        memcpy(a->normals + 3 * k, z->normals + 3 * z->corners[k], 12);
        a->reasons[k] = z->reasons[z->corners[k]];
    }
}

/* Which fans the corners of a vertex lie in. */
static void fans_of_vertex(const plan_case *c, const expected *e, uint32_t vertex, uint8_t *in) {
    memset(in, 0, e->fans.fan_count);
    for (size_t k = 0; k < c->mesh.corner_count; ++k)
        if (c->mesh.corners[k] == vertex) in[fan_of(e, k)] = 1;
}

static uint32_t first_at(const plan_case *c, const expected *e, uint32_t vertex) {
    for (uint32_t v = 0; v < c->mesh.position_count; ++v)
        if (e->o.shared[v] == e->o.shared[vertex]) return v;
    return vertex;
}

/* The sum over its fans; where that cancels, over its own corners. */
static void expect_vertex(
    const plan_case *c, const expected *e, uint32_t vertex, frozen *z, answer *a) {
    const uint32_t vertices = (uint32_t)c->mesh.position_count;
    uint8_t in[MOST];
    fans_of_vertex(c, e, vertex, in);
    for (int own = 0; own < 2; ++own) {
        memcpy(z->positions, c->floats, 12 * (size_t)vertices);
        memcpy(z->positions + 3 * vertices, c->floats + 3 * vertex, 12);
        for (size_t k = 0; k < c->mesh.corner_count; ++k) {
            const uint32_t at = c->mesh.corners[e->o.kept[k] == ORACLE_NONE ? k : e->o.kept[k]];
            const int votes = own ? at == vertex : in[fan_of(e, k)];
            z->corners[k] = votes ? vertices : first_at(c, e, at);
        }
        freeze(c, z, vertices + 1);
        memcpy(a->normals + 3 * vertex, z->normals + 3 * vertices, 12);
        a->reasons[vertex] = own && z->reasons[vertices] != NORMA_REASON_NONE
                                 ? NORMA_REASON_CANCELLED
                                 : z->reasons[vertices];
        if (a->reasons[vertex] != NORMA_REASON_CANCELLED) return;
    }
}

static void expect_answer(const plan_case *c, const expected *e, frozen *z, answer *a) {
    memset(a, 0, sizeof *a);
    if (c->of == NORMA_PER_CORNER) expect_corners(c, e, z, a);
    for (uint32_t v = 0; v < c->mesh.position_count && c->of == NORMA_PER_VERTEX; ++v)
        expect_vertex(c, e, v, z, a);
}

/* ---- updates, each in a way of its own */

static void backwards(void *user, size_t count, norma_task *task, void *context) {
    (void)user;
    for (size_t i = count; i-- > 0;) task(context, i);
}

static void some_way(uint64_t *seed, norma_options *options) {
    static const norma_isa sets[] = {
        NORMA_ISA_BEST, NORMA_ISA_PORTABLE, NORMA_ISA_AVX2, NORMA_ISA_AVX512};
    options->threads = plan_random(seed, 3);
    options->isa = sets[plan_random(seed, COUNT_OF(sets))];
    if (!plan_random(seed, 3)) options->parallel_for = backwards;
}

static norma_result update(const plan_case *c, const norma_plan *plan, uint64_t *seed,
    const uint32_t *moved, size_t count, answer *a) {
    norma_options options = c->options;
    double doubles[3 * MOST];
    norma_vec3_view positions = {c->floats, c->mesh.position_count, 0, NORMA_FORMAT_FLOAT};
    some_way(seed, &options);
    options.reasons = a->reasons;
    if (plan_random(seed, 2)) {
        for (size_t i = 0; i < 3 * c->mesh.position_count; ++i) doubles[i] = (double)c->floats[i];
        positions.data = doubles;
        positions.format = NORMA_FORMAT_DOUBLE;
    }
    norma_result result = norma_plan_update(
        plan, positions, moved, count, &options, a->normals, c->elements, &a->report);
    if (result == NORMA_ERROR_ARGUMENT) { /* an instruction set that the machine lacks */
        options.isa = NORMA_ISA_BEST;
        result = norma_plan_update(
            plan, positions, moved, count, &options, a->normals, c->elements, &a->report);
    }
    return result;
}

static int same(const plan_case *c, const char *what, const answer *a, const answer *b) {
    for (size_t i = 0; i < c->elements; ++i) {
        if (a->reasons[i] == b->reasons[i] &&
            memcmp(a->normals + 3 * i, b->normals + 3 * i, 12) == 0)
            continue;
        print_error("%s: %s: element %zu: (%.9g %.9g %.9g) %d, not (%.9g %.9g %.9g) %d\n", c->name,
            what, i, (double)a->normals[3 * i], (double)a->normals[3 * i + 1],
            (double)a->normals[3 * i + 2], a->reasons[i], (double)b->normals[3 * i],
            (double)b->normals[3 * i + 1], (double)b->normals[3 * i + 2], b->reasons[i]);
        return 0;
    }
    return 1;
}

/* ---- what may change */

static void mark_element(const plan_case *c, const expected *e, uint32_t element,
    const uint8_t *fans, const uint8_t *vertices, uint8_t *may) {
    uint8_t in[MOST];
    if (c->of == NORMA_PER_CORNER) {
        may[element] = fans[fan_of(e, element)];
        return;
    }
    fans_of_vertex(c, e, element, in);
    may[element] = vertices[element];
    for (size_t f = 0; f < e->fans.fan_count; ++f) may[element] |= in[f] && fans[f];
}

static void may_change(
    const plan_case *c, const expected *e, const uint32_t *moved, size_t count, uint8_t *may) {
    uint8_t vertices[MOST] = {0}, fans[MOST] = {0};
    for (size_t i = 0; i < count; ++i) vertices[moved[i]] = 1;
    for (size_t f = 0; f < c->mesh.face_count; ++f) {
        int touched = 0;
        for (size_t k = c->mesh.starts[f]; k < c->mesh.starts[f + 1]; ++k)
            touched |= vertices[c->mesh.corners[k]];
        for (size_t k = c->mesh.starts[f]; touched && k < c->mesh.starts[f + 1]; ++k)
            fans[fan_of(e, k)] = 1;
    }
    for (uint32_t i = 0; i < c->elements; ++i) mark_element(c, e, i, fans, vertices, may);
}

static void check_written(
    const plan_case *c, const uint8_t *may, const answer *some, const answer *all) {
    for (size_t i = 0; i < c->elements; ++i) {
        const uint8_t untouched[12] = {
            0xa5, 0xa5, 0xa5, 0xa5, 0xa5, 0xa5, 0xa5, 0xa5, 0xa5, 0xa5, 0xa5, 0xa5};
        const int written = memcmp(some->normals + 3 * i, untouched, 12) != 0;
        if (written != may[i])
            fail_msg("%s: element %zu: written %d, may change %d", c->name, i, written, may[i]);
        if (written && (memcmp(some->normals + 3 * i, all->normals + 3 * i, 12) != 0 ||
                           some->reasons[i] != all->reasons[i]))
            fail_msg("%s: element %zu differs", c->name, i);
        if (!written && some->reasons[i] != 0xa5) fail_msg("%s: reason %zu written", c->name, i);
    }
}

static void check_report(
    const plan_case *c, const uint8_t *may, const answer *some, const answer *all) {
    size_t counts[5] = {0}, expected_counts[5] = {0};
    for (size_t i = 0; i < c->elements; ++i)
        ++expected_counts[may && !may[i] ? 0 : all->reasons[i]];
    counts[NORMA_REASON_NON_FINITE] = some->report.non_finite.count;
    counts[NORMA_REASON_UNREFERENCED] = some->report.unreferenced.count;
    counts[NORMA_REASON_CANCELLED] = some->report.cancelled.count;
    for (int r = NORMA_REASON_NON_FINITE; r <= NORMA_REASON_CANCELLED; ++r)
        assert_int_equal(counts[r], expected_counts[r]);
}

/* ---- the properties */

typedef struct run {
    plan_case c;
    expected e;
    norma_plan *plan;
    answer wanted, all, some, kept;
    frozen z;
    uint32_t moved[MOVED_ROOM];
} run;

static void one_step(run *r, uint64_t *seed) {
    uint8_t may[MOST] = {0};
    const size_t count = plan_case_move(&r->c, seed, 1, r->moved, MOVED_ROOM);
    if (count == MOVED_ROOM) return;
    assert_ok(update(&r->c, r->plan, seed, NULL, 0, &r->all));
    check_report(&r->c, NULL, &r->all, &r->all);
    if (!r->e.doubtful && r->c.options.weld != NORMA_WELD_DISTANCE) {
        expect_answer(&r->c, &r->e, &r->z, &r->wanted);
        assert_true(same(&r->c, "all", &r->all, &r->wanted));
    }
    memset(&r->some, 0xa5, sizeof r->some);
    assert_ok(update(&r->c, r->plan, seed, r->moved, count, &r->some));
    assert_ok(update(&r->c, r->plan, seed, r->moved, count, &r->kept));
    assert_true(same(&r->c, "moved", &r->kept, &r->all));
    if (r->e.doubtful) return;
    may_change(&r->c, &r->e, r->moved, count, may);
    check_written(&r->c, may, &r->some, &r->all);
    check_report(&r->c, may, &r->some, &r->all);
}

/* Vertices that were at one place part: each face then goes by the positions that its own corners
 * name, and nothing but the sums is shared. The oracle's directions. */
static oracle_normal expect_apart(const run *r, const oracle *o, size_t element) {
    size_t list[MOST], count = 0;
    uint8_t in[MOST];
    if (r->c.of == NORMA_PER_CORNER)
        return oracle_corner(o, &r->e.fans, element, r->c.options.weight);
    fans_of_vertex(&r->c, &r->e, (uint32_t)element, in);
    for (size_t k = 0; k < r->c.mesh.corner_count; ++k)
        if (in[fan_of(&r->e, k)] && r->e.o.kept[k] == k) list[count++] = k;
    oracle_normal n = oracle_sum(o, list, count, r->c.options.weight);
    if (n.reason != NORMA_REASON_CANCELLED) return n;
    for (size_t i = count = 0; i < r->c.mesh.corner_count; ++i)
        if (r->c.mesh.corners[i] == element && r->e.o.kept[i] == i) list[count++] = i;
    n = oracle_sum(o, list, count, r->c.options.weight);
    if (n.reason == NORMA_REASON_UNREFERENCED) n.reason = NORMA_REASON_CANCELLED;
    return n;
}

static void compare_apart(const run *r, const oracle *o) {
    for (size_t i = 0; i < r->c.elements; ++i) {
        const size_t vertex = r->c.of == NORMA_PER_CORNER ? r->c.mesh.corners[i] : i;
        oracle_normal n = expect_apart(r, o, i);
        const double wanted[3] = {(double)n.normal[0], (double)n.normal[1], (double)n.normal[2]};
        if (!oracle_finite(o->positions[vertex])) n.reason = NORMA_REASON_NON_FINITE;
        if (n.doubtful || (n.reason != NORMA_REASON_NON_FINITE && n.ratio < 1e-3L && n.ratio != 0))
            continue;
        if (r->all.reasons[i] != n.reason)
            fail_msg("%s: apart: element %zu: reason %d, not %d", r->c.name, i, r->all.reasons[i],
                (int)n.reason);
        if (n.reason == NORMA_REASON_NONE && degrees_between(r->all.normals + 3 * i, wanted) > 1e-4)
            fail_msg("%s: apart: element %zu", r->c.name, i);
    }
}

static void step_apart(run *r, uint64_t *seed) {
    oracle o;
    const size_t count = plan_case_move(&r->c, seed, 0, r->moved, MOVED_ROOM);
    if (count == MOVED_ROOM) return;
    assert_ok(update(&r->c, r->plan, seed, NULL, 0, &r->all));
    assert_ok(update(&r->c, r->plan, seed, r->moved, count, &r->kept));
    assert_true(same(&r->c, "apart, moved", &r->kept, &r->all));
    if (r->e.doubtful || r->c.view.face_starts) return;
    oracle_create(&o, &r->c.view, NORMA_WELD_NONE, 0);
    for (size_t f = 0; f < o.face_count; ++f)
        if (r->e.o.kinds[f] == ORACLE_FEW || r->e.o.kinds[f] == ORACLE_NON_FINITE_FEW)
            o.kinds[f] = ORACLE_FEW;
    compare_apart(r, &o);
    oracle_destroy(&o);
}

static void random_case(run *r, uint64_t number) {
    uint64_t seed = number;
    plan_case_make(&r->c, number);
    if (r->c.elements <= MOST - 2 && r->c.mesh.corner_count < MOST - 2 &&
        r->c.mesh.position_count < MOST - 2) {
        assert_ok(norma_plan_create(&r->c.view, r->c.of, r->c.crease_rad, &r->c.options, &r->plan));
        expect(&r->c, &r->e);
        assert_ok(update(&r->c, r->plan, &seed, NULL, 0, &r->kept));
        for (int step = 0; step < 4; ++step) one_step(r, &seed);
        for (int step = 0; step < 2; ++step) step_apart(r, &seed);
        expect_free(&r->e);
        norma_plan_destroy(r->plan);
    }
    plan_case_free(&r->c);
}

static void random_meshes(void **state) {
    (void)state;
    run *r = test_calloc(1, sizeof *r);
    for (uint64_t seed = 1; seed <= 3000 / SLOWER; ++seed) random_case(r, seed);
    test_free(r);
}

/* Two vertices at one position, whose corners cancel each other: each gets the sum of its own. That
 * of the first is zero along y but for what its weights are rounded to, so that their last bits
 * show; it is the same where nothing is welded, and in a plan. */
static void own_corners_to_the_last_bit(void **state) {
    (void)state;
    static const float positions[11][3] = {{0, 0, 0}, {0, 0, 0}, {0, -8, 1}, {-8, 1, -2},
        {-16, -2, -4}, {0, 24, 3}, {0, 1, 6}, {0, 48, 6}, {-32, -4, -8}, {-16, 2, -4}, {0, -16, 2}};
    static const uint32_t corners[] = {
        0, 2, 3, 0, 3, 4, 0, 4, 5, 0, 5, 6, 1, 6, 7, 1, 7, 8, 1, 8, 9, 1, 9, 10};
    const norma_mesh mesh = {.positions = {positions, 11, 0, NORMA_FORMAT_FLOAT},
        .corners = corners,
        .corner_count = 24,
        .corner_size = 4};
    norma_options options = {.struct_size = sizeof options};
    float welded[33], apart[33], planned[33];
    norma_plan *plan;
    assert_ok(norma_vertex_normals(&mesh, &options, welded, 11, NULL));
    assert_ok(norma_plan_create(&mesh, NORMA_PER_VERTEX, 3.1415927F, &options, &plan));
    assert_ok(norma_plan_update(plan, mesh.positions, NULL, 0, &options, planned, 11, NULL));
    norma_plan_destroy(plan);
    options.weld = NORMA_WELD_NONE;
    assert_ok(norma_vertex_normals(&mesh, &options, apart, 11, NULL));
    assert_true(fabsf(apart[1]) < 1e-12F);
    assert_memory_equal(welded, apart, 24);
    assert_memory_equal(planned, apart, 24);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(random_meshes), cmocka_unit_test(own_corners_to_the_last_bit)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
