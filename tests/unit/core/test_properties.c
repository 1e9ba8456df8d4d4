/* test_properties.c: what must hold whatever the answer is: exact symmetries keep the bits,
 * permutations move them, every way to hand over one mesh is the same mesh, flat polygons weigh as
 * their triangles do, the nearest fallback is the nearest. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/oracle.h"
#include "oracle/shapes.h"

#define MOST 4096
static const float creases[] = {0, 0.4f, 1.04719755f, 3.14159274f};

typedef struct answer {
    float normals[3 * MOST];
    uint8_t reasons[MOST];
    size_t count;
    norma_report report;
} answer;

typedef enum call { FACES, VERTICES, CORNERS } call;

static void ask(answer *a, call kind, const norma_mesh *mesh, float crease, norma_options options) {
    memset(a, 0, sizeof *a);
    options.reasons = a->reasons;
    a->count = kind == FACES      ? (mesh->face_starts ? mesh->face_count : mesh->corner_count / 3)
               : kind == VERTICES ? mesh->positions.count
                                  : mesh->corner_count;
    assert_true(a->count <= MOST);
    if (kind == FACES)
        assert_ok(norma_face_normals(mesh, &options, a->normals, a->count, &a->report));
    if (kind == VERTICES)
        assert_ok(norma_vertex_normals(mesh, &options, a->normals, a->count, &a->report));
    if (kind == CORNERS)
        assert_ok(norma_corner_normals(mesh, crease, &options, a->normals, a->count, &a->report));
}

/* Small meshes of all kinds: smooth, creased, flat polygons, degenerate, cancelling, random. */
#define SAMPLE_COUNT 7
enum { HEAP = 5, LATTICE = 6 };
static void sample(mesh_file *mesh, int which) {
    uint64_t seed = 99;
    memset(mesh, 0, sizeof *mesh);
    switch (which) {
    case 0:
        shape_uv_sphere(mesh, 12, 7, 1, 1);
        break;
    case 1:
        shape_box(mesh, 3, 2, 1, 0);
        break;
    case 2:
        shape_wavy_grid(mesh, 9, 0);
        break;
    case 3:
        shape_pole_sphere(mesh, 9, 5, 0);
        break;
    case 4:
        shape_cone(mesh, 12, .6);
        break;
    case HEAP: /* a heap of triangles and quads that share everything */
        for (int i = 0; i < 40; ++i)
            mesh_file_add_position(
                mesh, shape_random_unit(&seed), shape_random_unit(&seed), shape_random_unit(&seed));
        for (int f = 0; f < 120; ++f) {
            uint32_t c[4];
            for (uint32_t i = 0; i < 4; ++i) c[i] = 10 * i + shape_random(&seed) % 10;
            mesh_file_add_face(mesh, c, 3 + (size_t)(f & 1));
        }
        break;
    default: /* the same on a coarse lattice */
        for (int i = 0; i < 40; ++i)
            mesh_file_add_position(
                mesh, shape_random(&seed) % 3, shape_random(&seed) % 3, shape_random(&seed) % 3);
        for (int f = 0; f < 60; ++f)
            mesh_file_add_face(mesh,
                (uint32_t[]){
                    shape_random(&seed) % 40, shape_random(&seed) % 40, shape_random(&seed) % 40},
                3);
    }
    shape_round_to_float(mesh);
}

/* Calls body with every sample, kind of normal, weight and some creases. */
typedef struct setting {
    mesh_file mesh;
    call kind;
    float crease;
    norma_options options;
    int which;
} setting;

static void for_each_setting(void body(setting *)) {
    for (int which = 0; which < SAMPLE_COUNT; ++which) {
        setting s = {.which = which};
        sample(&s.mesh, which);
        for (int w = NORMA_WEIGHT_ANGLE; norma_weight_name((norma_weight)w); ++w)
            for (int i = 0; i < 6; ++i) {
                s.kind = i == 0 ? FACES : i == 1 ? VERTICES : CORNERS;
                s.crease = i > 1 ? creases[i - 2] : 0;
                s.options = (norma_options){.weight = (norma_weight)w,
                    .non_manifold = i & 1 ? NORMA_NON_MANIFOLD_SMOOTH : NORMA_NON_MANIFOLD_HARD};
                body(&s);
            }
        mesh_file_free(&s.mesh);
    }
}

static double angle(const float *a, const float *b) {
    return degrees_to(a, (double)b[0], (double)b[1], (double)b[2]) / DEGREES;
}

/* ---- symmetries */

/* x, y, z of the image are sign[i] times coordinate source[i] of the original: the 48 symmetries of
 * a cube. Mirrors reverse all faces. */
static void mapped(
    mesh_file *out, const mesh_file *mesh, const int source[3], const int sign[3], int mirrored) {
    memset(out, 0, sizeof *out);
    for (size_t v = 0; v < mesh->position_count; ++v) {
        const double *p = mesh->positions[v];
        mesh_file_add_position(
            out, sign[0] * p[source[0]], sign[1] * p[source[1]], sign[2] * p[source[2]]);
    }
    for (size_t f = 0; f < mesh->face_count; ++f) {
        uint32_t corners[64];
        const size_t count = mesh->starts[f + 1] - mesh->starts[f];
        for (size_t i = 0; i < count; ++i)
            corners[i] = mesh->corners[mesh->starts[f] + (mirrored ? (count - i) % count : i)];
        mesh_file_add_face(out, corners, count);
    }
}

static void compare_mapped(
    setting *s, const int source[3], const int sign[3], int same_bits, int mirrored) {
    if (mirrored && s->which == LATTICE) return; /* which corner comes first decides ties there */
    answer *a = test_malloc(sizeof *a), *b = test_malloc(sizeof *b);
    mesh_file image;
    mapped(&image, &s->mesh, source, sign, mirrored);
    const norma_mesh before = mesh_file_view(&s->mesh), after = mesh_file_view(&image);
    ask(a, s->kind, &before, s->crease, s->options);
    ask(b, s->kind, &after, s->crease, s->options);
    for (size_t f = 0, i = 0; i < a->count; ++i) {
        size_t j = i;
        while (s->kind == CORNERS && i >= s->mesh.starts[f + 1]) ++f;
        if (s->kind == CORNERS && mirrored) {
            const size_t count = s->mesh.starts[f + 1] - s->mesh.starts[f],
                         at = i - s->mesh.starts[f];
            j = s->mesh.starts[f] + (count - at) % count;
        }
        assert_int_equal(a->reasons[i], b->reasons[j]);
        const float *n = a->normals + 3 * i,
                    turned[3] = {(float)sign[0] * n[source[0]], (float)sign[1] * n[source[1]],
                        (float)sign[2] * n[source[2]]};
        if (a->reasons[i]) continue;
        if (!same_bits) { /* sums of three are taken in another order */
            if (!(angle(turned, b->normals + 3 * j) < 1.2e-7))
                fail_msg("sample %d, element %zu: %g rad", s->which, i,
                    angle(turned, b->normals + 3 * j));
        } else {
            for (int x = 0; x < 3; ++x)
                if (turned[x] != b->normals[3 * j + (size_t)x])
                    fail_msg("sample %d, kind %d, weight %d, element %zu: other bits", s->which,
                        (int)s->kind, (int)s->options.weight, i);
        }
    }
    mesh_file_free(&image);
    test_free(a);
    test_free(b);
}

static void turn_half(setting *s) {
    static const int straight[3] = {0, 1, 2}, z[3] = {-1, -1, 1}, x[3] = {1, -1, -1};
    compare_mapped(s, straight, z, 1, 0);
    compare_mapped(s, straight, x, 1, 0);
}

static void half_turns_turn_the_bits(void **state) {
    (void)state;
    for_each_setting(turn_half);
}

static void turn_quarter(setting *s) {
    static const int cycle[3] = {1, 2, 0}, plus[3] = {1, 1, 1}, quarter[3] = {1, 0, 2},
                     left[3] = {-1, 1, 1};
    compare_mapped(s, cycle, plus, 0, 0);
    compare_mapped(s, quarter, left, 0, 0);
}

static void quarter_turns_turn(void **state) {
    (void)state;
    for_each_setting(turn_quarter);
}

static void mirror(setting *s) {
    static const int straight[3] = {0, 1, 2}, left[3] = {-1, 1, 1}, swap[3] = {1, 0, 2},
                     plus[3] = {1, 1, 1};
    compare_mapped(s, straight, left, 0, 1);
    compare_mapped(s, swap, plus, 0, 1);
}

static void mirrors_mirror(void **state) {
    (void)state;
    for_each_setting(mirror);
}

static void scale(setting *s) {
    answer *a = test_malloc(sizeof *a), *b = test_malloc(sizeof *b);
    const norma_mesh mesh = mesh_file_view(&s->mesh);
    ask(a, s->kind, &mesh, s->crease, s->options);
    for (int e = -100; e <= 100; e += 40) { /* -100, -60, -20, 20, 60, 100 */
        mesh_file scaled;
        sample(&scaled, s->which);
        shape_scale(&scaled, ldexp(1, e));
        const norma_mesh view = mesh_file_view(&scaled);
        ask(b, s->kind, &view, s->crease, s->options);
        if (memcmp(a->normals, b->normals, sizeof a->normals))
            fail_msg("sample %d, kind %d, weight %d, 2^%d: other bits", s->which, (int)s->kind,
                (int)s->options.weight, e);
        assert_memory_equal(a->reasons, b->reasons, sizeof a->reasons);
        assert_memory_equal(&a->report, &b->report, sizeof a->report);
        float *floats = test_calloc(3 * scaled.position_count, sizeof *floats);
        const norma_mesh as_floats = mesh_file_view_float(&scaled, floats);
        int exact = 1;
        for (size_t i = 0; i < 3 * scaled.position_count; ++i)
            exact &= (double)floats[i] == ((double *)scaled.positions)[i];
        if (exact) {
            ask(b, s->kind, &as_floats, s->crease, s->options);
            assert_memory_equal(a->normals, b->normals, sizeof a->normals);
        }
        test_free(floats);
        mesh_file_free(&scaled);
    }
    test_free(a);
    test_free(b);
}

static void powers_of_two_keep_the_bits(void **state) {
    (void)state;
    for_each_setting(scale);
}

static void reverse(setting *s) {
    answer *a = test_malloc(sizeof *a), *b = test_malloc(sizeof *b);
    mesh_file reversed;
    static const int straight[3] = {0, 1, 2}, plus[3] = {1, 1, 1};
    mapped(&reversed, &s->mesh, straight, plus, 1);
    const norma_mesh before = mesh_file_view(&s->mesh), after = mesh_file_view(&reversed);
    ask(a, s->kind, &before, s->crease, s->options);
    ask(b, s->kind, &after, s->crease, s->options);
    for (size_t i = 0; i < a->count && s->kind != CORNERS; ++i) {
        assert_int_equal(a->reasons[i], b->reasons[i]);
        for (size_t x = 3 * i; x < 3 * i + 3 && !a->reasons[i]; ++x) {
            if (s->options.weight == NORMA_WEIGHT_VISIBLE || s->which == 0 || s->which == HEAP)
                assert_true(
                    fabs((double)a->normals[x] + (double)b->normals[x]) < 1.2e-7); /* polygons */
            else if (a->normals[x] != -b->normals[x])
                fail_msg("sample %d, kind %d, weight %d, element %zu: not the negative", s->which,
                    (int)s->kind, (int)s->options.weight, i);
        }
    }
    mesh_file_free(&reversed);
    test_free(a);
    test_free(b);
}

static void reversed_winding_negates(void **state) {
    (void)state;
    for_each_setting(reverse);
}

/* ---- permutations */

static void shuffle(size_t *order, size_t count, uint64_t *seed) {
    for (size_t i = 0; i < count; ++i) order[i] = i;
    for (size_t i = count; i > 1; --i) {
        const size_t j = shape_random(seed) % i, other = order[i - 1];
        order[i - 1] = order[j];
        order[j] = other;
    }
}

static void permute(setting *s) {
    answer *a = test_malloc(sizeof *a), *b = test_malloc(sizeof *b);
    uint64_t seed = 5;
    mesh_file mixed = {0};
    size_t *vertex = test_calloc(s->mesh.position_count, sizeof *vertex),
           *face = test_calloc(s->mesh.face_count, sizeof *face),
           *corner = test_calloc(s->mesh.corner_count, sizeof *corner);
    size_t *place = test_calloc(s->mesh.position_count, sizeof *place), at = 0;
    shuffle(vertex, s->mesh.position_count,
        &seed); /* new vertex i is the old vertex[i]; new face i the old face[i], begun elsewhere */
    shuffle(face, s->mesh.face_count, &seed);
    for (size_t i = 0; i < s->mesh.position_count; ++i) {
        const double *p = s->mesh.positions[vertex[i]];
        place[vertex[i]] = i;
        mesh_file_add_position(&mixed, p[0], p[1], p[2]);
    }
    for (size_t i = 0; i < s->mesh.face_count; ++i) {
        uint32_t corners[64];
        const size_t start = s->mesh.starts[face[i]], count = s->mesh.starts[face[i] + 1] - start,
                     turn = s->which == LATTICE
                                ? 0
                                : shape_random(&seed) % count; /* ties go to the first corner */
        for (size_t k = 0; k < count; ++k) {
            corner[at++] = start + (k + turn) % count;
            corners[k] = (uint32_t)place[s->mesh.corners[start + (k + turn) % count]];
        }
        mesh_file_add_face(&mixed, corners, count);
    }
    const size_t *order = s->kind == FACES ? face : s->kind == VERTICES ? vertex : corner;
    const norma_mesh before = mesh_file_view(&s->mesh), after = mesh_file_view(&mixed);
    ask(a, s->kind, &before, s->crease, s->options);
    ask(b, s->kind, &after, s->crease, s->options);
    assert_int_equal(a->report.non_manifold_edges.count, b->report.non_manifold_edges.count);
    assert_int_equal(a->report.winding_conflicts.count, b->report.winding_conflicts.count);
    assert_int_equal(a->report.degenerate_faces.count, b->report.degenerate_faces.count);
    for (size_t i = 0; i < a->count; ++i) {
        assert_int_equal(b->reasons[i], a->reasons[order[i]]);
        if (b->reasons[i]) continue;
        const double off = angle(b->normals + 3 * i, a->normals + 3 * order[i]);
        if (!(off <= 1.2e-7))
            fail_msg("sample %d, kind %d, weight %d, element %zu: %g rad", s->which, (int)s->kind,
                (int)s->options.weight, i, off);
    }
    mesh_file_free(&mixed);
    void *const blocks[] = {a, b, vertex, face, corner, place};
    for (size_t i = 0; i < COUNT_OF(blocks); ++i) test_free(blocks[i]);
}

static void order_does_not_matter(void **state) {
    (void)state;
    for_each_setting(permute);
}

/* ---- split and merge */

static void soup(setting *s) {
    answer *a = test_malloc(sizeof *a), *b = test_malloc(sizeof *b);
    mesh_file apart = {0};
    shape_soup(&apart, &s->mesh);
    const norma_mesh indexed = mesh_file_view(&s->mesh), unwelded = mesh_file_view(&apart);
    norma_mesh without = unwelded;
    without.corners = NULL;
    ask(a, s->kind, &indexed, s->crease, s->options);
    ask(b, s->kind, &unwelded, s->crease, s->options);
    for (size_t i = 0; i < a->count; ++i) {
        const size_t first = s->kind != VERTICES ? i : ORACLE_NONE;
        if (first != ORACLE_NONE) {
            assert_int_equal(a->reasons[i], b->reasons[i]);
            assert_memory_equal(a->normals + 3 * i, b->normals + 3 * i, 12);
        }
    }
    for (size_t c = 0; c < s->mesh.corner_count && s->kind == VERTICES; ++c) {
        const size_t v = s->mesh.corners[c];
        if (a->reasons[v] || b->reasons[c])
            continue; /* cancelled sums are taken again by index, which the soup has other ones of
                       */
        if (s->which != HEAP && s->which != LATTICE)
            assert_memory_equal(a->normals + 3 * v, b->normals + 3 * c, 12);
    }
    ask(a, s->kind, &without, s->crease, s->options);
    assert_memory_equal(a->normals, b->normals, sizeof a->normals);
    assert_memory_equal(a->reasons, b->reasons, sizeof a->reasons);
    mesh_file_free(&apart);
    test_free(a);
    test_free(b);
}

static void unwelded_soup_equals_the_indexed_mesh(void **state) {
    (void)state;
    for_each_setting(soup);
}

static void flat_polygons_weigh_as_their_triangles(void **state) {
    (void)state;
    static answer a, b;
    for (int i = 0; i < 3; ++i) {
        mesh_file polygons = {0}, triangles = {0};
        if (i == 0) shape_box(&polygons, 7, 3, 2, 1);
        if (i == 0) shape_box(&triangles, 7, 3, 2, 0);
        if (i == 1)
            shape_pole_sphere(
                &polygons, 12, 6, 1); /* its quads are trapezoids: flat, but for rounding */
        if (i == 1) shape_pole_sphere(&triangles, 12, 6, 0);
        if (i == 2) shape_uv_sphere(&polygons, 16, 8, 1, 1);
        if (i == 2) shape_uv_sphere(&triangles, 16, 8, 1, 0);
        const norma_mesh p = mesh_file_view(&polygons), t = mesh_file_view(&triangles);
        ask(&a, VERTICES, &p, 0, (norma_options){0});
        ask(&b, VERTICES, &t, 0, (norma_options){0});
        for (size_t v = 0; v < a.count; ++v)
            assert_true(angle(a.normals + 3 * v, b.normals + 3 * v) < 2e-7);
        mesh_file_free(&polygons);
        mesh_file_free(&triangles);
    }
}

/* ---- ways to hand over a mesh */

static void put(unsigned char *out, norma_format format, double value) {
    const float f = (float)value;
    const int8_t i8 = (int8_t)value;
    const uint8_t u8 = (uint8_t)value;
    const int16_t i16 = (int16_t)value;
    const uint16_t u16 = (uint16_t)value;
    switch (format) {
    case NORMA_FORMAT_FLOAT:
        memcpy(out, &f, sizeof f);
        break;
    case NORMA_FORMAT_DOUBLE:
        memcpy(out, &value, sizeof value);
        break;
    case NORMA_FORMAT_INT8:
        memcpy(out, &i8, sizeof i8);
        break;
    case NORMA_FORMAT_UINT8:
        memcpy(out, &u8, sizeof u8);
        break;
    case NORMA_FORMAT_INT16:
        memcpy(out, &i16, sizeof i16);
        break;
    case NORMA_FORMAT_UINT16:
        memcpy(out, &u16, sizeof u16);
        break;
    }
}

static void every_format_and_stride_is_the_same_mesh(void **state) {
    (void)state;
    static const size_t sizes[] = {4, 8, 1, 1, 2, 2};
    static answer a, b;
    static unsigned char bytes[MOST * 64];
    mesh_file mesh;
    sample(&mesh, 6); /* coordinates 0, 1, 2 */
    for (size_t v = 0; v < mesh.position_count; ++v) mesh.positions[v][0] *= 60;
    const norma_mesh plain = mesh_file_view(&mesh);
    for (int k = 0; k < 3; ++k) {
        ask(&a, (call)k, &plain, 1, (norma_options){0});
        for (int f = NORMA_FORMAT_FLOAT; f <= NORMA_FORMAT_UINT16; ++f)
            for (size_t extra = 0; extra <= 17; ++extra)
                for (size_t shift = 0; shift < 2; ++shift) { /* unaligned as well */
                    const size_t size = sizes[f], stride = 3 * size + extra;
                    norma_mesh view = plain;
                    memset(bytes, 0xff, sizeof bytes);
                    for (size_t v = 0; v < mesh.position_count; ++v)
                        for (size_t x = 0; x < 3; ++x)
                            put(bytes + shift + v * stride + x * size, (norma_format)f,
                                mesh.positions[v][x]);
                    view.positions = (norma_vec3_view){
                        bytes + shift, mesh.position_count, extra ? stride : 0, (norma_format)f};
                    ask(&b, (call)k, &view, 1, (norma_options){0});
                    if (memcmp(&a, &b, sizeof a))
                        fail_msg("kind %d, format %d, stride %zu, shift %zu", k, f, stride, shift);
                }
    }
    mesh_file_free(&mesh);
}

static void every_corner_size_is_the_same_mesh(void **state) {
    (void)state;
    static answer a, b;
    static uint8_t c8[MOST];
    static uint16_t c16[MOST];
    for (int which = 0; which < SAMPLE_COUNT; ++which) {
        mesh_file mesh;
        sample(&mesh, which);
        const norma_mesh plain = mesh_file_view(&mesh);
        for (size_t i = 0; i < mesh.corner_count; ++i) {
            c8[i] = (uint8_t)mesh.corners[i];
            c16[i] = (uint16_t)mesh.corners[i];
        }
        for (int k = 0; k < 3; ++k) {
            norma_mesh view = plain;
            ask(&a, (call)k, &plain, 1, (norma_options){0});
            view.corner_size = 4;
            ask(&b, (call)k, &view, 1, (norma_options){0});
            assert_memory_equal(&a, &b, sizeof a);
            view.corners = c16;
            view.corner_size = 2;
            ask(&b, (call)k, &view, 1, (norma_options){0});
            assert_memory_equal(&a, &b, sizeof a);
            if (mesh.position_count > 256) continue;
            view.corners = c8;
            view.corner_size = 1;
            ask(&b, (call)k, &view, 1, (norma_options){0});
            assert_memory_equal(&a, &b, sizeof a);
        }
        mesh_file_free(&mesh);
    }
}

/* norma_view_vector and norma_mesh_corner, on odd addresses. */
static void single_elements_of_every_format(void **state) {
    (void)state;
    static const struct {
        norma_format format;
        size_t size;
        double numbers[6];
    } formats[] = {{NORMA_FORMAT_FLOAT, 4, {0.5, -0x1p126, 0x1p-149, 3, -0.25, 7}},
        {NORMA_FORMAT_DOUBLE, 8, {0.1, -1e300, 0x1p-1074, 3, -0.2, 7}},
        {NORMA_FORMAT_INT8, 1, {-128, 127, 0, 1, -1, 5}},
        {NORMA_FORMAT_UINT8, 1, {0, 255, 128, 1, 2, 5}},
        {NORMA_FORMAT_INT16, 2, {-32768, 32767, 0, 256, -1, 5}},
        {NORMA_FORMAT_UINT16, 2, {0, 65535, 32768, 256, 1, 5}}};
    for (size_t f = 0; f < sizeof formats / sizeof *formats; ++f) {
        unsigned char bytes[1 + 2 * (3 * sizeof(double) + 5)];
        for (size_t gap = 0; gap < 6; gap += 5) {
            const size_t size = formats[f].size, stride = 3 * size + gap;
            for (size_t i = 0; i < 6; ++i) {
                const double d = formats[f].numbers[i];
                const float as_float = (float)d;
                const int32_t whole = fabs(d) < 1e5 ? (int32_t)d : 0; /* little end first */
                const void *from = size == 8   ? (const void *)&d
                                   : size == 4 ? (const void *)&as_float
                                               : (const void *)&whole;
                memcpy(bytes + 1 + i / 3 * stride + i % 3 * size, from, size);
            }
            const norma_vec3_view view = {bytes + 1, 2, gap ? stride : 0, formats[f].format};
            for (size_t i = 0; i < 2; ++i) {
                double out[3];
                norma_view_vector(&view, i, out);
                for (size_t k = 0; k < 3; ++k) assert_true(out[k] == formats[f].numbers[3 * i + k]);
            }
        }
    }
    static const unsigned char corners[] = {9, 1, 2, 3, 4, 5, 6, 7, 8};
    static const struct {
        size_t size;
        uint32_t second;
    } sizes[] = {{0, 0x08070605}, {4, 0x08070605}, {2, 0x0403}, {1, 2}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        const norma_mesh mesh = {
            .corners = corners + 1, .corner_count = 2, .corner_size = sizes[i].size};
        assert_int_equal(norma_mesh_corner(&mesh, 1), sizes[i].second);
    }
    assert_int_equal(norma_mesh_corner(&(norma_mesh){.corner_size = 2, .corner_count = 9}, 7), 7);
}

static void face_starts_of_threes_are_triangles(void **state) {
    (void)state;
    static answer a, b;
    for (int which = 1; which < SAMPLE_COUNT; ++which) {
        if (which == HEAP) continue;
        mesh_file mesh;
        sample(&mesh, which);
        const norma_mesh polygons = mesh_file_view_polygons(&mesh);
        norma_mesh plain = polygons;
        plain.face_starts = NULL;
        plain.face_count = 12345; /* not looked at */
        for (int k = 0; k < 3; ++k)
            for (int w = NORMA_WEIGHT_ANGLE; norma_weight_name((norma_weight)w); ++w) {
                ask(&a, (call)k, &polygons, 1, (norma_options){.weight = (norma_weight)w});
                ask(&b, (call)k, &plain, 1, (norma_options){.weight = (norma_weight)w});
                assert_memory_equal(&a, &b, sizeof a);
            }
        mesh_file_free(&mesh);
    }
}

static void output_stride_leaves_the_gaps(void **state) {
    (void)state;
    static answer a;
    static unsigned char out[MOST * 48], reasons[MOST];
    mesh_file mesh;
    sample(&mesh, 3);
    const norma_mesh view = mesh_file_view(&mesh);
    for (int k = 0; k < 3; ++k)
        for (size_t stride = 12; stride <= 33; ++stride) {
            norma_options options = {.normal_stride = stride, .reasons = reasons};
            norma_report report;
            ask(&a, (call)k, &view, 1, (norma_options){0});
            memset(out, 0xa5, sizeof out);
            memset(reasons, 0xa5, sizeof reasons);
            float *normals = (float *)(void *)out;
            if (k == FACES)
                assert_ok(norma_face_normals(&view, &options, normals, a.count, &report));
            if (k == VERTICES)
                assert_ok(norma_vertex_normals(&view, &options, normals, a.count, &report));
            if (k == CORNERS)
                assert_ok(norma_corner_normals(&view, 1, &options, normals, a.count, &report));
            for (size_t i = 0; i < a.count; ++i) {
                assert_memory_equal(out + i * stride, a.normals + 3 * i, 12);
                for (size_t gap = i * stride + 12; gap < (i + 1) * stride; ++gap)
                    assert_int_equal(out[gap], 0xa5);
            }
            assert_memory_equal(reasons, a.reasons, a.count);
            assert_int_equal(reasons[a.count], 0xa5);
            assert_int_equal(out[a.count * stride], 0xa5);
        }
    mesh_file_free(&mesh);
}

/* ---- reports and fallbacks */

static void count_reasons(setting *s) {
    answer *a = test_malloc(sizeof *a);
    const norma_mesh mesh = mesh_file_view(&s->mesh);
    norma_count counts[5];
    for (int i = 0; i < 5; ++i) counts[i] = (norma_count){0, SIZE_MAX};
    s->mesh.positions[s->mesh.position_count / 2][1] = (double)NAN;
    ask(a, s->kind, &mesh, s->crease, s->options);
    for (size_t i = 0; i < a->count; ++i) {
        assert_true(a->reasons[i] <= NORMA_REASON_CANCELLED);
        if (counts[a->reasons[i]].count++ == 0) counts[a->reasons[i]].first = i;
        const float *n = a->normals + 3 * i;
        const double length = sqrt((double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] +
                                   (double)n[2] * (double)n[2]);
        assert_true(a->reasons[i] ? length == 0 : fabs(length - 1) < 3e-7);
    }
    if (s->kind == FACES)
        assert_memory_equal(
            &counts[NORMA_REASON_DEGENERATE], &a->report.degenerate_faces, sizeof *counts);
    else
        assert_int_equal(counts[NORMA_REASON_DEGENERATE].count, 0);
    assert_memory_equal(&counts[NORMA_REASON_NON_FINITE], &a->report.non_finite, sizeof *counts);
    assert_memory_equal(
        &counts[NORMA_REASON_UNREFERENCED], &a->report.unreferenced, sizeof *counts);
    assert_memory_equal(&counts[NORMA_REASON_CANCELLED], &a->report.cancelled, sizeof *counts);
    test_free(a);
}

static void reasons_add_up_to_the_report(void **state) {
    (void)state;
    for_each_setting(count_reasons);
}

static void nearest_is_the_nearest(void **state) {
    (void)state;
    static answer zero, nearest;
    static const double units[] = {
        1, 0.1, 1e200, 1e-200}; /* squares of the last two leave doubles */
    for (uint64_t seed = 1; seed < 200; ++seed) {
        uint64_t random = seed;
        mesh_file mesh = {0};
        const double unit = units[seed % 5 % 4];
        const uint32_t side = 2 + shape_random(&random) % 5 + (seed % 4 ? 0 : 4),
                       count = 5 + shape_random(&random) % (seed % 4 ? 60 : 500),
                       face_count = 2 + shape_random(&random) % 20; /* few to ask, and many */
        for (uint32_t i = 0; i < count; ++i)
            mesh_file_add_position(&mesh, unit * (shape_random(&random) % side),
                unit * (shape_random(&random) % side), unit * (shape_random(&random) % side));
        if (seed % 3 == 0) mesh.positions[count / 2][2] = (double)INFINITY;
        if (seed % 7 == 0) mesh.positions[0][0] = 3e38;
        if (seed % 11 == 0) mesh.positions[1][0] = 0x1p-20;
        for (uint32_t f = 0; f < face_count; ++f)
            mesh_file_add_face(&mesh,
                (uint32_t[]){shape_random(&random) % count, shape_random(&random) % count,
                    shape_random(&random) % count},
                3);
        const norma_mesh view = mesh_file_view(&mesh);
        oracle o;
        oracle_create(&o, &view, NORMA_WELD_EXACT, 0);
        for (int k = 0; k < 3; ++k) {
            ask(&zero, (call)k, &view, 1, (norma_options){0});
            ask(&nearest, (call)k, &view, 1, (norma_options){.fallback = NORMA_FALLBACK_NEAREST});
            size_t *vertex = test_calloc(zero.count, sizeof *vertex);
            for (size_t i = 0; i < zero.count; ++i)
                vertex[i] = k == FACES ? o.corners[o.starts[i]] : k == VERTICES ? i : o.corners[i];
            assert_memory_equal(zero.reasons, nearest.reasons, zero.count);
            assert_memory_equal(&zero.report, &nearest.report, sizeof zero.report);
            for (size_t i = 0; i < zero.count; ++i) {
                const size_t from =
                    zero.reasons[i] ? oracle_nearest(&o, vertex, zero.reasons, zero.count, i) : i;
                const float *expected =
                    from == ORACLE_NONE ? (const float[3]){0, 0, 0} : zero.normals + 3 * from;
                if (memcmp(nearest.normals + 3 * i, expected, 12))
                    fail_msg("seed %llu, kind %d, element %zu is not that of %zu",
                        (unsigned long long)seed, k, i, from);
            }
            test_free(vertex);
        }
        oracle_destroy(&o);
        mesh_file_free(&mesh);
    }
}

/* Every weight, whatever it is called, is the one asked for: on this mesh all seven differ. */
static void weights_are_seven(void **state) {
    (void)state;
    static answer all[7];
    mesh_file mesh;
    sample(&mesh, 1);
    const norma_mesh view = mesh_file_view(&mesh);
    mesh.positions[7][2] = 1.75;
    mesh.positions[7][0] = 2.5;
    for (int w = 0; w < 7; ++w)
        ask(&all[w], VERTICES, &view, 0, (norma_options){.weight = (norma_weight)w});
    for (int i = 0; i < 7; ++i)
        for (int j = 0; j < i; ++j)
            assert_true(angle(all[i].normals + 21, all[j].normals + 21) > 1e-3);
    mesh_file_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(half_turns_turn_the_bits),
        cmocka_unit_test(quarter_turns_turn),
        cmocka_unit_test(mirrors_mirror),
        cmocka_unit_test(powers_of_two_keep_the_bits),
        cmocka_unit_test(reversed_winding_negates),
        cmocka_unit_test(order_does_not_matter),
        cmocka_unit_test(unwelded_soup_equals_the_indexed_mesh),
        cmocka_unit_test(flat_polygons_weigh_as_their_triangles),
        cmocka_unit_test(every_format_and_stride_is_the_same_mesh),
        cmocka_unit_test(every_corner_size_is_the_same_mesh),
        cmocka_unit_test(single_elements_of_every_format),
        cmocka_unit_test(face_starts_of_threes_are_triangles),
        cmocka_unit_test(output_stride_leaves_the_gaps),
        cmocka_unit_test(reasons_add_up_to_the_report),
        cmocka_unit_test(nearest_is_the_nearest),
        cmocka_unit_test(weights_are_seven),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
