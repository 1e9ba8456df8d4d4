/* test_tangents.c: norma_corner_tangents against closed forms and properties: planes whose texture
 * is affine, quads against the triangles they are cut into, any order of faces, any number of
 * threads, each allocation failing, arguments. Its bits are compared with other programs by
 * tests/tangent. */
#include "check.h"
#include "core/tangent/tangents.h"
#include "accountant.h"
#include "watcher.h"
#include <inttypes.h>
#include <stdio.h>

enum { MOST = 6400 };

typedef struct shape {
    float positions[MOST][3], normals[MOST][3], texcoords[MOST][2];
    uint32_t corners[MOST], starts[MOST];
    size_t vertices, corner_count, faces;
} shape;

typedef struct answer {
    norma_result result;
    float tangents[MOST][4];
    uint8_t reasons[MOST];
    norma_report report;
} answer;

static norma_mesh mesh_of(const shape *s) {
    return (norma_mesh){.positions = {.data = s->positions, .count = s->vertices},
        .corners = s->corners,
        .corner_count = s->corner_count,
        .face_starts = s->starts,
        .face_count = s->faces};
}

static answer *compute(const shape *s, norma_tangent_mode mode, norma_options options) {
    answer *a = calloc(1, sizeof *a);
    const norma_mesh mesh = mesh_of(s);
    const norma_attribute normals = {.data = s->normals, .count = s->vertices},
                          texcoords = {.data = s->texcoords, .count = s->vertices};
    options.reasons = a->reasons;
    a->result = norma_corner_tangents(
        &mesh, &normals, &texcoords, mode, &options, a->tangents[0], MOST, &a->report);
    return a;
}

static uint32_t add_vertex(shape *s, const float p[3], const float n[3], const float t[2]) {
    memcpy(s->positions[s->vertices], p, 12);
    memcpy(s->normals[s->vertices], n, 12);
    memcpy(s->texcoords[s->vertices], t, 8);
    return (uint32_t)s->vertices++;
}

static void add_face(shape *s, size_t count, const uint32_t *corners) {
    memcpy(s->corners + s->corner_count, corners, count * sizeof *corners);
    s->corner_count += count;
    s->starts[++s->faces] = (uint32_t)s->corner_count;
}

/* A grid with waves. corners 3: each square as the two triangles that a quad is cut into, since the
 * texture is sheared so that the diagonal from its first corner is the shorter one. */
static shape *grid(int side, size_t corners, double wave) {
    shape *s = calloc(1, sizeof *s);
    for (int y = 0; y <= side; ++y)
        for (int x = 0; x <= side; ++x) {
            const double z = wave * sin(x * .7) * cos(y * .5),
                         zx = wave * .7 * cos(x * .7) * cos(y * .5),
                         zy = -wave * .5 * sin(x * .7) * sin(y * .5),
                         l = sqrt(1 + zx * zx + zy * zy);
            add_vertex(s, (float[]){(float)x, (float)y, (float)z},
                (float[]){(float)(-zx / l), (float)(-zy / l), (float)(1 / l)},
                (float[]){(float)x / 8 - (float)y / 64, (float)y / 8});
        }
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const uint32_t a = (uint32_t)(y * (side + 1) + x), b = a + 1,
                           d = a + (uint32_t)side + 1, c = d + 1;
            if (corners == 4) {
                add_face(s, 4, (uint32_t[]){a, b, c, d});
                continue;
            }
            add_face(s, 3, (uint32_t[]){a, b, c});
            add_face(s, 3, (uint32_t[]){a, c, d});
        }
    return s;
}

/* A fan of so many triangles, u once round it: at its middle each tangent is opposed to another. */
static shape *swirl(int count) {
    shape *s = calloc(1, sizeof *s);
    const float up[3] = {0, 0, 1};
    add_vertex(s, (float[]){0, 0, 0}, up, (float[]){.5F, 0});
    for (int i = 0; i <= count; ++i) {
        const double angle = 2 * 3.141592653589793 * (i % count) / count;
        add_vertex(s, (float[]){(float)cos(angle), (float)sin(angle), 0}, up,
            (float[]){(float)i / (float)count, 1});
    }
    for (uint32_t i = 1; i <= (uint32_t)count; ++i) add_face(s, 3, (uint32_t[]){0, i, i + 1});
    return s;
}

static const norma_options NO_OPTIONS;

/* ---- closed forms */

static void affine_texture(void **state) {
    (void)state;
    for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode)
        for (size_t corners = 3; corners <= 4; ++corners)
            for (int mirrored = 0; mirrored < 2; ++mirrored) {
                shape *s = grid(5, corners, 0);
                for (size_t v = 0; mirrored && v < s->vertices; ++v) s->texcoords[v][1] *= -1;
                answer *a = compute(s, (norma_tangent_mode)mode, NO_OPTIONS);
                assert_ok(a->result);
                for (size_t c = 0; c < s->corner_count; ++c) {
                    assert_direction(a->tangents[c], 1, 0, 0, 1e-5);
                    assert_true(a->tangents[c][3] == (mirrored ? -1 : 1));
                    assert_int_equal(a->reasons[c], NORMA_REASON_NONE);
                }
                assert_int_equal(a->report.degenerate_faces.count, 0);
                free(a);
                free(s);
            }
}

static void every_weight_is_exact_on_a_plane(void **state) {
    (void)state;
    shape *s = grid(4, 4, 0);
    for (int weight = NORMA_WEIGHT_ANGLE; norma_weight_name((norma_weight)weight); ++weight) {
        answer *a =
            compute(s, NORMA_TANGENTS_STEADY, (norma_options){.weight = (norma_weight)weight});
        for (size_t c = 0; c < s->corner_count; ++c)
            assert_direction(a->tangents[c], 1, 0, 0, 1e-5);
        free(a);
    }
    free(s);
}

/* Tangents of any size of texture and of mesh: STEADY has no absolute bounds. */
static void steady_at_any_scale(void **state) {
    static const float scales[] = {1e-30F, 1e-12F, 1, 1e12F, 1e30F};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(scales); ++i) {
        shape *s = grid(3, 3, 0);
        for (size_t v = 0; v < s->vertices; ++v)
            for (int k = 0; k < 3; ++k) s->positions[v][k] *= scales[i];
        answer *a = compute(s, NORMA_TANGENTS_STEADY, NO_OPTIONS);
        for (size_t c = 0; c < s->corner_count; ++c)
            assert_direction(a->tangents[c], 1, 0, 0, 1e-5);
        free(a);
        free(s);
    }
}

/* Of a direction along the normal only rounding is left: it adds nothing, however little the other
 * faces weigh. */
static void steady_along_the_normal(void **state) {
    static const float normal[3] = {1, 1e-7F, 0}, up[3] = {0, 0, 1};
    static const float origin[2] = {0, 0}, s_axis[2] = {1, 0}, t_axis[2] = {0, 1}, both[2] = {1, 1};
    const norma_options options = {.struct_size = sizeof options, .weight = NORMA_WEIGHT_MAX};
    (void)state;
    for (int size = 0; size < 2; ++size) {
        const float large = size ? 1e15F : 1e4F;
        shape *s = calloc(1, sizeof *s);
        const uint32_t at = add_vertex(s, (const float[]){0, 0, 0}, normal, origin);
        add_face(s, 4,
            (const uint32_t[]){at, add_vertex(s, (const float[]){1, 0, 0}, up, s_axis),
                add_vertex(s, (const float[]){1, 1, 0}, up, both),
                add_vertex(s, (const float[]){0, 1, 0}, up, t_axis)});
        add_face(s, 3,
            (const uint32_t[]){at, add_vertex(s, (const float[]){0, 0, large}, normal, s_axis),
                add_vertex(s, (const float[]){0, large, 0}, normal, t_axis)});
        answer *a = compute(s, NORMA_TANGENTS_STEADY, options);
        assert_ok(a->result);
        for (int corner = 0; corner <= 4; corner += 4)
            assert_direction(a->tangents[corner], 0, 0, 1, 1e-6);
        free(a);
        free(s);
    }
}

/* Doubles far from the origin, which floats do not tell apart, and such as floats do not reach. As
 * a plan has them, too, of all vertices and of some. */
static void steady_in_doubles(void **state) {
    static const double scales[] = {1e-3, 1e-200, 1e200};
    static const uint32_t moved = 12;
    (void)state;
    for (size_t i = 0; i < COUNT_OF(scales); ++i) {
        shape *s = grid(12, 4, 0);
        norma_tangent_plan *plan = NULL;
        double(*p)[3] = calloc(s->vertices, sizeof *p);
        float(*t)[4] = calloc(s->corner_count, sizeof *t);
        for (size_t v = 0; v < s->vertices; ++v)
            for (int k = 0; k < 3; ++k)
                p[v][k] = ((double)s->positions[v][k] + (i ? 0 : 1e8)) * scales[i];
        norma_mesh mesh = mesh_of(s);
        mesh.positions.data = p;
        mesh.positions.format = NORMA_FORMAT_DOUBLE;
        const norma_attribute normals = {.data = s->normals, .count = s->vertices},
                              texcoords = {.data = s->texcoords, .count = s->vertices};
        assert_ok(norma_corner_tangents(
            &mesh, &normals, &texcoords, NORMA_TANGENTS_STEADY, NULL, t[0], s->corner_count, NULL));
        for (size_t c = 0; c < s->corner_count; ++c) assert_direction(t[c], 1, 0, 0, 1e-5);
        assert_ok(norma_tangent_plan_create(
            &mesh, &normals, &texcoords, NORMA_TANGENTS_STEADY, NULL, &plan));
        for (int some = 0; some < 2; ++some) {
            memset(t, 0, s->corner_count * sizeof *t);
            assert_ok(norma_tangent_plan_update(plan, mesh.positions, &normals,
                some ? &moved : NULL, (size_t)some, NULL, t[0], s->corner_count, NULL));
            size_t there = 0;
            for (size_t c = 0; c < s->corner_count; ++c) {
                if (some && t[c][3] == 0) continue;
                assert_direction(t[c], 1, 0, 0, 1e-5);
                ++there;
            }
            assert_true(some ? there > 0 && there < s->corner_count : there == s->corner_count);
        }
        norma_tangent_plan_destroy(plan);
        free(p);
        free(t);
        free(s);
    }
}

/* The arc cosines that lie nearest to a tie between two floats, from quadruple precision. */
static void arc_cosines_are_rounded_right(void **state) {
    static const float known[][2] = {{0x1.110b44p-26F, 0x1.921fb6p+0F},
        {0x1.110b46p-26F, 0x1.921fb4p+0F}, {0x1.110b48p-26F, 0x1.921fb4p+0F},
        {0x1.04c444p-12F, 0x1.920f68p+0F}, {0x1.d4921ep-11F, 0x1.91e524p+0F},
        {0x1.fa5036p-9F, 0x1.91228ep+0F}, {0x1.145f36p-6F, 0x1.8dce2cp+0F},
        {-0x1.80d99ap-7F, 0x1.95216cp+0F}, {-0x1.cd19a2p-3F, 0x1.cc4282p+0F},
        {-0x1.bbbd2ep-24F, 0x1.921fb6p+0F}, {-0x1.cdbddap-11F, 0x1.92596cp+0F},
        {-0x1.3abeeap-10F, 0x1.926e66p+0F}, {-0x1.dbfe6ep-3F, 0x1.ce2c16p+0F}};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(known); ++i)
        assert_true(norma_core_mikk_acos(known[i][0]) == known[i][1]);
}

static void quads_are_the_triangles_they_are_cut_into(void **state) {
    (void)state;
    shape *quads = grid(9, 4, .4), *triangles = grid(9, 3, .4);
    answer *a = compute(quads, NORMA_TANGENTS_MIKK, NO_OPTIONS),
           *b = compute(triangles, NORMA_TANGENTS_MIKK, NO_OPTIONS);
    for (size_t c = 0; c < triangles->corner_count; ++c) {
        static const size_t of_quad[] = {0, 1, 2, 0, 2, 3};
        assert_memory_equal(a->tangents[c / 6 * 4 + of_quad[c % 6]], b->tangents[c], 16);
    }
    free(a);
    free(b);
    free(quads);
    free(triangles);
}

/* ---- corners without a tangent */

static void check_fallback(const shape *s, const answer *a, size_t corner, int reason) {
    const float *t = a->tangents[corner], *n = s->normals[s->corners[corner]];
    double dot = 0, square = 0;
    for (int k = 0; k < 3; ++k) {
        dot += isfinite(n[k]) ? (double)t[k] * (double)n[k] : 0;
        square += (double)t[k] * (double)t[k];
    }
    assert_int_equal(a->reasons[corner], reason);
    assert_true(fabs(dot) < 1e-6 && fabs(square - 1) < 1e-6 && fabsf(t[3]) == 1);
}

static void reasons(void **state) {
    (void)state;
    for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode)
        for (int reason = NORMA_REASON_DEGENERATE; reason <= NORMA_REASON_CANCELLED; ++reason) {
            if (reason == NORMA_REASON_UNREFERENCED) continue;
            shape *s = grid(1, 3, 0);
            for (size_t v = 0; v < s->vertices; ++v) {
                if (reason == NORMA_REASON_DEGENERATE) s->texcoords[v][1] = s->texcoords[v][0];
                if (reason == NORMA_REASON_NON_FINITE) s->positions[v][v % 3] = NAN;
                if (reason == NORMA_REASON_CANCELLED)
                    memcpy(s->normals[v], (float[]){1, 0, 0}, 12); /* along the tangent */
            }
            answer *a = compute(s, (norma_tangent_mode)mode, NO_OPTIONS);
            const norma_report *r = &a->report;
            assert_ok(a->result);
            for (size_t c = 0; c < s->corner_count; ++c) check_fallback(s, a, c, reason);
            assert_int_equal(reason == NORMA_REASON_DEGENERATE   ? r->degenerate_faces.count
                             : reason == NORMA_REASON_NON_FINITE ? r->non_finite.count
                                                                 : r->cancelled.count,
                s->corner_count);
            free(a);
            free(s);
        }
}

/* A face with two equal positions takes the tangents of its vertices' other faces. */
static void degenerate_faces_copy(void **state) {
    (void)state;
    for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
        shape *s = grid(2, 3, .3);
        const size_t first = s->corner_count;
        add_face(s, 3, (uint32_t[]){4, 4, 1});
        answer *a = compute(s, (norma_tangent_mode)mode, NO_OPTIONS);
        for (size_t c = first; c < s->corner_count; ++c) {
            size_t other = 0;
            while (s->corners[other] != s->corners[c]) ++other;
            assert_int_equal(a->reasons[c], NORMA_REASON_NONE);
            assert_memory_equal(a->tangents[c], a->tangents[other], 16);
        }
        free(a);
        free(s);
    }
}

/* ---- properties */

static uint32_t random_below(uint64_t *seed, uint32_t count) {
    *seed = *seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*seed >> 33) % count;
}

/* Few places and few texture coordinates: edges of many faces, mirrored and collapsed texture,
 * degenerate faces, polygons of up to six corners. Odd seeds: numbers whose sums are rounded. */
static shape *scramble(uint64_t seed) {
    static const float steps[] = {1, 0.137F};
    const float step = steps[seed % 2];
    const uint32_t finer = seed % 2 ? 40 : 1;
    shape *s = calloc(1, sizeof *s);
    for (int v = 0; v < 12; ++v) {
        float p[3], n[3], t[2];
        for (int k = 0; k < 3; ++k) p[k] = step * (float)random_below(&seed, 3 * finer);
        for (int k = 0; k < 3; ++k) n[k] = step * ((float)random_below(&seed, 5 * finer) - 2);
        for (int k = 0; k < 2; ++k) t[k] = step * (float)random_below(&seed, 4 * finer) / 3;
        add_vertex(s, p, n, t);
    }
    for (int f = 0; f < 40; ++f) {
        uint32_t corners[6];
        const size_t count = 3 + random_below(&seed, 4) * (f % 4 == 0);
        for (size_t i = 0; i < count; ++i) corners[i] = random_below(&seed, 12);
        add_face(s, count, corners);
    }
    return s;
}

static void steady_in_any_order(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= 300 / SLOWER; ++seed) {
        shape *s = scramble(seed), *t = calloc(1, sizeof *t);
        uint64_t other = seed + 1000;
        uint32_t from[MOST], order[64];
        memcpy(t, s, sizeof *t);
        t->corner_count = t->faces = 0;
        for (uint32_t f = 0; f < s->faces; ++f) {
            const uint32_t at = random_below(&other, f + 1);
            order[f] = order[at];
            order[at] = f;
        }
        for (size_t f = 0; f < s->faces; ++f) {
            const uint32_t begin = s->starts[order[f]], count = s->starts[order[f] + 1] - begin,
                           turn = random_below(&other, count);
            uint32_t corners[6];
            for (uint32_t i = 0; i < count; ++i) {
                from[t->corner_count + i] = begin + (i + turn) % count;
                corners[i] = s->corners[begin + (i + turn) % count];
            }
            add_face(t, count, corners);
        }
        const norma_options options = {.weight = (norma_weight)(seed % 7)};
        answer *a = compute(s, NORMA_TANGENTS_STEADY, options),
               *b = compute(t, NORMA_TANGENTS_STEADY, options);
        for (size_t c = 0; c < t->corner_count; ++c) {
            assert_memory_equal(b->tangents[c], a->tangents[from[c]], 16);
            assert_int_equal(b->reasons[c], a->reasons[from[c]]);
        }
        for (size_t f = 0; f < t->faces; ++f) /* one sign for a face */
            for (uint32_t c = t->starts[f]; c < t->starts[f + 1]; ++c)
                assert_true(b->tangents[c][3] == b->tangents[t->starts[f]][3]);
        free(a);
        free(b);
        free(s);
        free(t);
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
    for (uint64_t seed = 0; seed < 40; ++seed)
        for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
            shape *s = seed == 1 ? swirl(1000) : seed ? scramble(seed) : grid(30, 4, .4);
            answer *a = compute(s, (norma_tangent_mode)mode, NO_OPTIONS);
            assert_ok(a->result);
            for (size_t i = 0; i < COUNT_OF(ways); ++i) {
                answer *b = compute(s, (norma_tangent_mode)mode, ways[i]);
                if (b->result == NORMA_ERROR_ARGUMENT) {
                    free(b); /* a machine without these instructions */
                    continue;
                }
                assert_memory_equal(a->tangents, b->tangents, sizeof a->tangents);
                assert_memory_equal(a->reasons, b->reasons, sizeof a->reasons);
                assert_memory_equal(&a->report, &b->report, sizeof a->report);
                free(b);
            }
            free(a);
            free(s);
        }
}

/* ---- what the reference gave */

static uint32_t next_bits(FILE *file) {
    unsigned bits;
    assert_int_equal(fscanf(file, "%x", &bits), 1);
    return bits;
}

static void next_floats(FILE *file, size_t count, float *floats) {
    for (size_t i = 0; i < count; ++i) {
        const uint32_t bits = next_bits(file);
        memcpy(&floats[i], &bits, sizeof bits);
    }
}

/* Of one mesh: its shape and the tangents of its corners. NULL: there are no more. */
static shape *next_mesh(FILE *file, float (*tangents)[4]) {
    unsigned vertices, faces, count;
    if (fscanf(file, " mesh %u %u", &vertices, &faces) != 2) return NULL;
    shape *s = calloc(1, sizeof *s);
    for (unsigned i = 0; i < vertices; ++i) {
        float v[8];
        next_floats(file, 8, v);
        add_vertex(s, v, v + 3, v + 6);
    }
    for (unsigned f = 0; f < faces; ++f) {
        uint32_t corners[4];
        assert_true(fscanf(file, "%u", &count) == 1 && count <= 4);
        for (unsigned i = 0; i < count; ++i)
            assert_int_equal(fscanf(file, "%" SCNu32, &corners[i]), 1);
        for (unsigned i = 0; i < count; ++i) next_floats(file, 4, tangents[s->corner_count + i]);
        add_face(s, count, corners);
    }
    return s;
}

/* Zero, not a number, or not unit; a fallback has the bits of a tangent. */
static int is_of_no_use(const float t[4]) {
    const double length = sqrt(
        (double)t[0] * (double)t[0] + (double)t[1] * (double)t[1] + (double)t[2] * (double)t[2]);
    return !(fabs(length - 1) < 1e-3) || (t[0] == 1 && t[1] == 0 && t[2] == 0 && t[3] == -1);
}

/* Quads, which the programs of tests/tangent do not take; collinear faces and numbers that are not
 * finite among them. */
static void the_bits_of_the_reference(void **state) {
    (void)state;
    size_t compared = 0, meshes = 0;
    float(*expected)[4] = calloc(MOST, sizeof *expected);
    FILE *file = fopen("tests/tangent/reference.txt", "r");
    assert_non_null(file);
    for (int c, line = 0; line < 3 && (c = getc(file)) != EOF;) line += c == '\n';
    for (shape *s; (s = next_mesh(file, expected)) != NULL; ++meshes) {
        answer *a = compute(s, NORMA_TANGENTS_MIKK, NO_OPTIONS);
        assert_ok(a->result);
        for (size_t c = 0; c < s->corner_count; ++c) {
            if (a->reasons[c] == NORMA_REASON_NONE && ++compared)
                assert_memory_equal(a->tangents[c], expected[c], sizeof expected[c]);
            else
                assert_true(a->reasons[c] == NORMA_REASON_NON_FINITE || is_of_no_use(expected[c]));
        }
        free(a);
        free(s);
    }
    assert_true(feof(file) && meshes == 11 && compared > 500);
    fclose(file);
    free(expected);
}

/* ---- memory, cancelling, arguments */

static void each_allocation_failing(void **state) {
    (void)state;
    for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode)
        for (uint64_t seed = 0; seed < 3; ++seed) {
            shape *s = seed ? scramble(seed) : grid(9, 3, .2);
            answer *expected = compute(s, (norma_tangent_mode)mode, NO_OPTIONS);
            for (size_t n = 1, done = 0; !done; ++n) {
                accountant a = {.fail_at = n};
                answer *got = compute(s, (norma_tangent_mode)mode,
                    (norma_options){.allocator = {accountant_take, accountant_give, &a}});
                assert_true(a.live == 0 && !a.wrong);
                assert_int_equal(got->result, a.calls < n ? NORMA_OK : NORMA_ERROR_MEMORY);
                done = !got->result;
                if (done)
                    assert_memory_equal(got->tangents, expected->tangents, sizeof got->tangents);
                free(got);
            }
            free(expected);
            free(s);
        }
}

/* At a large vertex the call may go on with less memory, with the same bits. */
static void each_allocation_of_a_large_star_failing(void **state) {
    (void)state;
    shape *s = swirl(300);
    answer *expected = compute(s, NORMA_TANGENTS_MIKK, NO_OPTIONS);
    for (size_t n = 1, calls = n; calls >= n; ++n) {
        accountant a = {.fail_at = n};
        answer *got = compute(s, NORMA_TANGENTS_MIKK,
            (norma_options){.allocator = {accountant_take, accountant_give, &a}});
        calls = a.calls;
        assert_true(a.live == 0 && !a.wrong);
        assert_true(!got->result || got->result == NORMA_ERROR_MEMORY);
        if (!got->result)
            assert_memory_equal(got->tangents, expected->tangents, sizeof got->tangents);
        free(got);
    }
    free(expected);
    free(s);
}

/* Where more corners meet than are compared in pairs, opposed tangents are those of the triangles.
 */
static void too_many_opposed_tangents(void **state) {
    (void)state;
    shape *s = swirl(2100);
    answer *all = compute(s, NORMA_TANGENTS_MIKK, NO_OPTIONS);
    assert_ok(all->result);
    for (size_t f = 0; f < s->faces; f += 50) {
        shape *one = calloc(1, sizeof *one);
        memcpy(one, s, sizeof *one);
        memcpy(one->corners, s->corners + 3 * f, 3 * sizeof *one->corners);
        one->corner_count = 3;
        one->faces = 1;
        answer *alone = compute(one, NORMA_TANGENTS_MIKK, NO_OPTIONS);
        assert_ok(alone->result);
        assert_memory_equal(alone->tangents[0], all->tangents[3 * f], sizeof all->tangents[0]);
        free(alone);
        free(one);
    }
    free(all);
    free(s);
}

/* Triangles that touch only at one vertex, whose normal is no number: none goes on with another. */
static void large_star_without_a_normal(void **state) {
    (void)state;
    for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
        enum { FACES = 300 };
        shape *s = calloc(1, sizeof *s);
        const uint32_t hub =
            add_vertex(s, (float[]){0, 0, 0}, (float[]){0, NAN, 1}, (float[]){0, 0});
        for (int i = 0; i < FACES; ++i) {
            uint32_t rim[2];
            for (int k = 0; k < 2; ++k) {
                const float a = (float)(6.283 * (i + .4 * k) / FACES), x = cosf(a), y = sinf(a);
                rim[k] = add_vertex(s, (float[]){x, y, 0}, (float[]){0, 0, 1}, (float[]){x, y});
            }
            add_face(s, 3, (uint32_t[]){hub, rim[0], rim[1]});
        }
        answer *a = compute(s, (norma_tangent_mode)mode, NO_OPTIONS);
        assert_int_equal(a->result, NORMA_OK);
        assert_int_equal(a->report.non_finite.count, FACES);
        for (int i = 0; i < FACES; ++i)
            for (int k = 1; k < 3; ++k) {
                const float *t = a->tangents[3 * i + k];
                assert_float_equal(t[0], 1, 1e-5);
                assert_true(t[3] == 1);
            }
        free(a);
        free(s);
    }
}

static void cancelling(void **state) {
    (void)state;
    shape *s = grid(20, 4, .2);
    for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode)
        for (size_t n = 1, done = 0; !done; ++n) {
            watcher w = {.stop_at = n};
            accountant account = {0};
            answer *a = compute(s, (norma_tangent_mode)mode,
                (norma_options){.progress = watch,
                    .progress_user = &w,
                    .allocator = {accountant_take, accountant_give, &account}});
            assert_int_equal(a->result, w.calls < n ? NORMA_OK : NORMA_CANCELLED);
            assert_int_equal(w.fell, 0);
            assert_int_equal(account.live, 0);
            done = !a->result;
            if (done) assert_true(w.last == 1);
            free(a);
        }
    free(s);
}

typedef struct arguments {
    norma_mesh mesh;
    norma_attribute normals, texcoords;
    int mode;
    norma_options options;
    float *tangents;
    size_t capacity;
} arguments;

static norma_result call(const arguments *a) {
    return norma_corner_tangents(&a->mesh, &a->normals, &a->texcoords, (norma_tangent_mode)a->mode,
        &a->options, a->tangents, a->capacity, NULL);
}

static void wrong_arguments(void **state) {
    (void)state;
    shape *s = grid(2, 4, 0);
    float tangents[64][4];
    const uint32_t beyond[64] = {9};
    const arguments right = {.mesh = mesh_of(s),
        .normals = {.data = s->normals, .count = s->vertices},
        .texcoords = {.data = s->texcoords, .count = s->vertices},
        .mode = NORMA_TANGENTS_MIKK,
        .tangents = tangents[0],
        .capacity = s->corner_count};
    arguments a = right;
    assert_ok(call(&a));
#define WRONG(change, result)                                                                      \
    do {                                                                                           \
        a = right;                                                                                 \
        change;                                                                                    \
        assert_int_equal(call(&a), result);                                                        \
    } while (0)
    WRONG(a.mode = 2, NORMA_ERROR_ARGUMENT);
    WRONG(a.tangents = NULL, NORMA_ERROR_ARGUMENT);
    WRONG(a.capacity--, NORMA_ERROR_CAPACITY);
    WRONG(a.normals.data = NULL, NORMA_ERROR_ARGUMENT);
    WRONG(a.normals.count--, NORMA_ERROR_ARGUMENT);
    WRONG(a.texcoords.format = (norma_format)9, NORMA_ERROR_ARGUMENT);
    WRONG(a.texcoords.of = (norma_element)7, NORMA_ERROR_ARGUMENT);
    WRONG(a.texcoords.of = NORMA_PER_CORNER, NORMA_ERROR_ARGUMENT);
    WRONG(a.texcoords.corners = beyond, NORMA_ERROR_INDEX);
    WRONG(a.texcoords.stride = SIZE_MAX / 2, NORMA_ERROR_OVERFLOW);
    WRONG(a.options.normal_stride = 12, NORMA_ERROR_ARGUMENT);
    WRONG(a.mesh.positions.count = 3, NORMA_ERROR_INDEX);
    assert_int_equal(norma_corner_tangents(&right.mesh, NULL, &right.texcoords, NORMA_TANGENTS_MIKK,
                         NULL, tangents[0], 64, NULL),
        NORMA_ERROR_ARGUMENT);
    const norma_mesh nothing = {.corner_count = 0};
    assert_ok(
        norma_corner_tangents(&nothing, NULL, NULL, NORMA_TANGENTS_MIKK, NULL, NULL, 0, NULL));
    free(s);
}

/* What attributes are numbered by, and in which format, changes nothing. */
static void other_dress(void **state) {
    (void)state;
    shape *s = grid(3, 4, 0);
    uint16_t texcoords[64][2];
    double normals[64][3];
    float expected[64][4], tangents[64][5];
    for (size_t v = 0; v < s->vertices; ++v)
        for (int k = 0; k < 2; ++k) {
            texcoords[v][k] = (uint16_t)(100 * v * (size_t)(k + 1) + v * v);
            s->texcoords[v][k] = (float)((double)texcoords[v][k] / 65535);
        }
    for (size_t c = 0; c < s->corner_count; ++c)
        for (int k = 0; k < 3; ++k) normals[c][k] = (double)s->normals[s->corners[c]][k];
    const norma_mesh mesh = mesh_of(s);
    const norma_attribute plain[] = {
        {.data = s->normals, .count = s->vertices}, {.data = s->texcoords, .count = s->vertices}};
    const norma_attribute other[] = {
        {.data = normals, .count = 64, .format = NORMA_FORMAT_DOUBLE, .of = NORMA_PER_CORNER},
        {.data = texcoords,
            .count = s->vertices,
            .format = NORMA_FORMAT_UINT16,
            .of = NORMA_PER_CORNER,
            .corners = s->corners}};
    const norma_options options = {.normal_stride = 20};
    for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
        memset(tangents, 0x5a, sizeof tangents);
        assert_ok(norma_corner_tangents(
            &mesh, &plain[0], &plain[1], (norma_tangent_mode)mode, NULL, expected[0], 64, NULL));
        assert_ok(norma_corner_tangents(&mesh, &other[0], &other[1], (norma_tangent_mode)mode,
            &options, tangents[0], 64, NULL));
        for (size_t c = 0; c < s->corner_count; ++c) {
            assert_memory_equal(tangents[c], expected[c], 16);
            assert_memory_equal(&tangents[c][4], "\x5a\x5a\x5a\x5a", 4);
        }
    }
    free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(affine_texture),
        cmocka_unit_test(every_weight_is_exact_on_a_plane), cmocka_unit_test(steady_at_any_scale),
        cmocka_unit_test(steady_along_the_normal), cmocka_unit_test(steady_in_doubles),
        cmocka_unit_test(arc_cosines_are_rounded_right),
        cmocka_unit_test(quads_are_the_triangles_they_are_cut_into), cmocka_unit_test(reasons),
        cmocka_unit_test(degenerate_faces_copy), cmocka_unit_test(steady_in_any_order),
        cmocka_unit_test(the_same_bits_however), cmocka_unit_test(the_bits_of_the_reference),
        cmocka_unit_test(each_allocation_failing),
        cmocka_unit_test(each_allocation_of_a_large_star_failing),
        cmocka_unit_test(too_many_opposed_tangents), cmocka_unit_test(large_star_without_a_normal),
        cmocka_unit_test(cancelling), cmocka_unit_test(wrong_arguments),
        cmocka_unit_test(other_dress)};
    return cmocka_run_group_tests_name("tangents", tests, NULL, NULL);
}
