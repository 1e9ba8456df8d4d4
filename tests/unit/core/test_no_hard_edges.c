/* test_no_hard_edges.c: an array of hard edges that marks none changes nothing: corner normals and
 * norma_split give the same bits, vertices and edges with it and without, on meshes that are smooth
 * nearly everywhere, and on such that only look so: all faces given twice, given once more the
 * other way round, cones that meet at their tips, a turn of more than 360 degrees. */
#include "check.h"
#include "oracle/shapes.h"

static const float CREASES[] = {0.3F, 0.6F, 1.0472F, 2, 3.14159274F};
enum { CREASE_COUNT = sizeof CREASES / sizeof *CREASES };

typedef struct split_result {
    uint32_t *corners, *sources;
    float *split, *normals;
    size_t made;
    norma_edges edges[2];
    norma_report report[2];
} split_result;

static split_result split_and_corners(const norma_mesh *mesh, float crease, uint32_t threads) {
    const size_t count = mesh->corner_count;
    split_result r = {.corners = test_calloc(count, 4),
        .sources = test_calloc(count, 4),
        .split = test_calloc(count, 12),
        .normals = test_calloc(count, 12)};
    norma_options options = {
        .struct_size = sizeof options, .threads = threads, .edges = &r.edges[0]};
    assert_ok(norma_split(mesh, crease, &options, r.corners, count, r.sources, r.split, count,
        &r.made, &r.report[0]));
    options.edges = &r.edges[1];
    assert_ok(norma_corner_normals(mesh, crease, &options, r.normals, count, &r.report[1]));
    return r;
}

static void free_result(split_result *r) {
    test_free(r->corners);
    test_free(r->sources);
    test_free(r->split);
    test_free(r->normals);
}

static void compare(const norma_mesh *mesh, float crease, uint32_t threads) {
    const size_t count = mesh->corner_count;
    norma_mesh marked = *mesh;
    uint8_t *marks = test_calloc(count, 1);
    marked.hard_edges = marks;
    split_result given = split_and_corners(mesh, crease, threads),
                 wanted = split_and_corners(&marked, crease, 1);
    assert_int_equal(given.made, wanted.made);
    assert_memory_equal(given.corners, wanted.corners, 4 * count);
    assert_memory_equal(given.sources, wanted.sources, 4 * count);
    assert_memory_equal(given.split, wanted.split, 12 * count);
    assert_memory_equal(given.normals, wanted.normals, 12 * count);
    assert_memory_equal(given.edges, wanted.edges, sizeof given.edges);
    assert_memory_equal(given.report, wanted.report, sizeof given.report);
    for (size_t c = 0; c < count; ++c)
        assert_memory_equal(given.split + 3 * (size_t)given.corners[c], given.normals + 3 * c, 12);
    free_result(&given);
    free_result(&wanted);
    test_free(marks);
}

static void compare_all(const norma_mesh *mesh) {
    for (int i = 0; i < CREASE_COUNT; ++i)
        for (uint32_t threads = 1; threads < 4; threads += 2) compare(mesh, CREASES[i], threads);
}

/* Its faces from the last to the first, every third one first: what is joined grows both ways. */
static void reorder(mesh_file *mesh) {
    uint32_t *to = test_malloc(4 * mesh->corner_count);
    size_t at = 0;
    for (size_t third = 0; third < 3; ++third)
        for (size_t f = mesh->face_count; f-- > 0;)
            if (f % 3 == third) memcpy(to + 3 * at++, mesh->corners + 3 * f, 12);
    memcpy(mesh->corners, to, 4 * mesh->corner_count);
    test_free(to);
}

/* Every third corner names a copy of its position, so that sums are shared by several vertices. */
static void copy_vertices(mesh_file *mesh) {
    const norma_mesh view = mesh_file_view(mesh);
    const size_t positions = view.positions.count;
    float *twice = test_malloc(24 * positions);
    uint32_t *corners = test_malloc(4 * view.corner_count);
    for (size_t p = 0; p < 2 * positions; ++p) {
        double at[3];
        norma_view_vector(&view.positions, p % positions, at);
        for (int k = 0; k < 3; ++k) twice[3 * p + (size_t)k] = (float)at[k];
    }
    for (size_t c = 0; c < view.corner_count; ++c)
        corners[c] = mesh->corners[c] + (c % 3 == 1 ? (uint32_t)positions : 0);
    const norma_mesh copied = {.positions = {twice, 2 * positions, 0, NORMA_FORMAT_FLOAT},
        .corners = corners,
        .corner_count = view.corner_count};
    compare_all(&copied);
    test_free(twice);
    test_free(corners);
}

static void smooth_meshes(void **state) {
    (void)state;
    for (int shape = 0; shape < 3; ++shape) {
        mesh_file mesh = {0};
        if (shape == 0) shape_octahedron_sphere(&mesh, 5);
        if (shape == 1) shape_wavy_grid(&mesh, 60, 0);
        if (shape == 2) shape_wavy_grid(&mesh, 12, 0);
        norma_mesh view = mesh_file_view(&mesh);
        compare_all(&view);
        copy_vertices(&mesh);
        reorder(&mesh);
        compare_all(&view);
        mesh_file_free(&mesh);
    }
}

/* Every edge has two faces on either side, so no normal is but its own face's. */
static void all_faces_twice(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_wavy_grid(&mesh, 40, 0);
    norma_mesh view = mesh_file_view(&mesh);
    const size_t count = view.corner_count, faces = count / 3;
    uint32_t *twice = test_malloc(8 * count);
    float *normals = test_malloc(24 * count), *of_faces = test_malloc(12 * faces);
    memcpy(twice, mesh.corners, 4 * count);
    memcpy(twice + count, mesh.corners, 4 * count);
    assert_ok(norma_face_normals(&view, NULL, of_faces, faces, NULL));
    view.corners = twice;
    view.corner_count = 2 * count;
    compare_all(&view);
    assert_ok(norma_corner_normals(&view, 2, NULL, normals, 2 * count, NULL));
    for (size_t c = 0; c < 2 * count; ++c)
        for (size_t k = 0; k < 3; ++k)
            if (fabsf(normals[3 * c + k] - of_faces[3 * (c / 3 % faces) + k]) > 1e-6F)
                fail_msg("corner %zu", c);
    for (size_t f = 0; f < faces; ++f) { /* the other way round: double-sided */
        twice[count + 3 * f] = mesh.corners[3 * f + 1];
        twice[count + 3 * f + 1] = mesh.corners[3 * f];
    }
    compare_all(&view);
    test_free(twice);
    test_free(normals);
    test_free(of_faces);
    mesh_file_free(&mesh);
}

/* Quads and the triangles at poles; then ever more bent, so that corners leave the plane of their
 * face; then some that come back to a corner of theirs (a slit). */
static void polygons(void **state) {
    (void)state;
    uint64_t random = 5;
    mesh_file mesh = {0};
    shape_uv_sphere(&mesh, 40, 30, 1, 1);
    const norma_mesh view = mesh_file_view(&mesh);
    float *bent = test_malloc(12 * view.positions.count);
    for (double by = 0; by < 0.2; by = 2 * by + 0.002) {
        norma_mesh moved = view;
        for (size_t i = 0; i < view.positions.count; ++i) {
            double at[3];
            norma_view_vector(&view.positions, i, at);
            for (size_t k = 0; k < 3; ++k)
                bent[3 * i + k] = (float)(at[k] + by * shape_random_unit(&random));
        }
        moved.positions = (norma_vec3_view){bent, view.positions.count, 0, NORMA_FORMAT_FLOAT};
        compare_all(&moved);
    }
    for (size_t f = 0; f < view.face_count; f += 7) {
        const size_t c = view.face_starts[f];
        if (view.face_starts[f + 1] - c == 4) mesh.corners[c + 2] = mesh.corners[c];
    }
    compare_all(&view);
    test_free(bent);
    mesh_file_free(&mesh);
}

/* A sheet of n by n cells cut at random: quads, pairs of triangles, two cells as one face of six
 * corners with two of them straight, three round a corner as one that is concave; the vertices
 * in random order, each face from a random corner on; some faces come back to a corner. */
enum { CELLS = 14, POINTS = (CELLS + 1) * (CELLS + 1), MOST_CORNERS = 8 };

typedef struct cut_sheet {
    float positions[POINTS][3];
    uint32_t corners[6 * CELLS * CELLS], starts[2 * CELLS * CELLS + 1], number[POINTS];
    size_t corner_count, face_count;
} cut_sheet;

static void add_face(cut_sheet *s, uint64_t *random, const uint32_t *at, size_t count) {
    const size_t first = shape_random(random) % count;
    uint32_t *to = s->corners + s->corner_count;
    for (size_t k = 0; k < count; ++k) to[k] = s->number[at[(first + k) % count]];
    if (count > 4 && shape_random(random) % 16 == 0) to[3] = to[0];
    s->corner_count += count;
    s->starts[++s->face_count] = (uint32_t)s->corner_count;
}

static void cut_cells(cut_sheet *s, uint64_t *random) {
    static const uint32_t side = CELLS + 1;
    uint8_t taken[CELLS * CELLS] = {0};
    for (uint32_t cell = 0; cell < CELLS * CELLS; ++cell) {
        const uint32_t x = cell % CELLS, y = cell / CELLS, p = y * side + x, q = p + side;
        const uint32_t kind = shape_random(random) % 4;
        const int right = x + 1 < CELLS && !taken[cell + 1],
                  above = y + 1 < CELLS && !taken[cell + CELLS];
        if (taken[cell]) continue;
        if (kind == 0 && right && above) {
            const uint32_t corner[MOST_CORNERS] = {
                p, p + 1, p + 2, q + 2, q + 1, q + 1 + side, q + side, q};
            taken[cell + 1] = taken[cell + CELLS] = 1;
            add_face(s, random, corner, MOST_CORNERS);
        } else if (kind == 1 && right) {
            taken[cell + 1] = 1;
            add_face(s, random, (const uint32_t[]){p, p + 1, p + 2, q + 2, q + 1, q}, 6);
        } else if (kind == 2) {
            add_face(s, random, (const uint32_t[]){p, p + 1, q + 1}, 3);
            add_face(s, random, (const uint32_t[]){p, q + 1, q}, 3);
        } else {
            add_face(s, random, (const uint32_t[]){p, p + 1, q + 1, q}, 4);
        }
    }
}

static void make_sheet(cut_sheet *s, uint64_t seed) {
    uint64_t random = seed;
    const double waves = 0.04 * (double)(seed % 7),
                 noise = seed % 3 ? 0.02 * (double)(seed % 5) : 0;
    s->corner_count = s->face_count = 0;
    s->starts[0] = 0;
    for (uint32_t i = 0; i < POINTS; ++i) s->number[i] = i;
    for (uint32_t i = POINTS; i > 1; --i) {
        const uint32_t k = shape_random(&random) % i, kept = s->number[i - 1];
        s->number[i - 1] = s->number[k];
        s->number[k] = kept;
    }
    for (uint32_t i = 0; i < POINTS; ++i) {
        const double x = i % (CELLS + 1), y = i / (CELLS + 1);
        float *at = s->positions[s->number[i]];
        at[0] = (float)(x + noise * shape_random_unit(&random));
        at[1] = (float)(y + noise * shape_random_unit(&random));
        at[2] = (float)(waves * sin(x) * cos(y) + noise * shape_random_unit(&random));
    }
    cut_cells(s, &random);
}

static void polygons_cut_at_random(void **state) {
    (void)state;
    cut_sheet *s = test_malloc(sizeof *s);
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        make_sheet(s, seed);
        compare_all(&(norma_mesh){.positions = {s->positions, POINTS, 0, NORMA_FORMAT_FLOAT},
            .corners = s->corners,
            .corner_count = s->corner_count,
            .face_starts = s->starts,
            .face_count = s->face_count});
    }
    test_free(s);
}

/* Sixty faces round the origin, by so many degrees each: one fan that rises a little, or two cones
 * of one tip, one within the other. */
static void turn(double degrees, int cones) {
    enum { FACES = 60 };
    float p[2 * FACES + 3][3] = {{0, 0, 0}};
    uint32_t c[6 * FACES];
    for (int cone = 0; cone < cones; ++cone)
        for (uint32_t i = 0; i <= FACES; ++i) {
            const double a = degrees * i / 57.29577951308232;
            float *at = p[1 + (uint32_t)cone * (FACES + 1) + i];
            at[0] = (float)cos(a);
            at[1] = (float)sin(a);
            at[2] = cones > 1 ? (float)(0.2 * cone + 0.2) : (float)(0.001 * i);
        }
    for (uint32_t i = 0; i < FACES * (uint32_t)cones; ++i) {
        const uint32_t first = 1 + i / FACES * (FACES + 1), at = i % FACES;
        c[3 * i] = 0;
        c[3 * i + 1] = first + at;
        c[3 * i + 2] = cones > 1 && at + 1 == FACES ? first : first + at + 1;
    }
    const norma_mesh mesh = {.positions = {p, 2 * FACES + 3, 0, NORMA_FORMAT_FLOAT},
        .corners = c,
        .corner_count = 3 * FACES * (size_t)cones};
    compare_all(&mesh);
}

static void turns(void **state) {
    (void)state;
    turn(4, 1);
    turn(5.9, 1);
    turn(6.1, 1);
    turn(11, 1);
    turn(6, 2);
}

/* A lid of n corners in three rings of quads, each lower by a little: what is known of it is the
 * same for every n. Bent polygons are few here; the lid is flat. */
static void lid(uint32_t n) {
    float(*p)[3] = test_calloc(4 * (size_t)n, sizeof *p);
    uint32_t *c = test_calloc(13 * (size_t)n, 4), *starts = test_calloc(3 * (size_t)n + 2, 4);
    for (uint32_t ring = 0; ring < 4; ++ring)
        for (uint32_t i = 0; i < n; ++i) {
            const double a = 2 * 3.141592653589793 * i / n, r = ring + 1;
            memcpy(p[ring * n + i],
                (const float[]){
                    (float)(r * cos(a)), (float)(r * sin(a)), (float)(-0.03 * ring * ring)},
                12);
        }
    for (uint32_t i = 0; i < n; ++i) c[i] = i;
    starts[1] = n;
    for (uint32_t q = 0; q < 3 * n; ++q) {
        const uint32_t in = q, next = q % n + 1 == n ? q + 1 - n : q + 1;
        memcpy(c + n + 4 * q, (const uint32_t[]){in, in + n, next + n, next}, 16);
        starts[q + 2] = n + 4 * (q + 1);
    }
    const norma_mesh mesh = {.positions = {p, 4 * (size_t)n, 0, NORMA_FORMAT_FLOAT},
        .corners = c,
        .corner_count = 13 * (size_t)n,
        .face_starts = starts,
        .face_count = 3 * (size_t)n + 1};
    const float crease = 1.0472F;
    compare(&mesh, crease, 1);
    compare(&mesh, crease, 3);
    split_result r = split_and_corners(&mesh, crease, 1);
    assert_int_equal(r.made, 4 * (size_t)n);
    assert_int_equal(r.edges[1].count, 7 * (size_t)n);
    assert_int_equal(r.edges[1].open, n);
    assert_int_equal(r.edges[1].smooth, 6 * (size_t)n);
    for (size_t i = 0; i < mesh.corner_count; ++i) { /* in the plane of its position and the axis */
        const float *at = p[c[i]], *m = r.normals + 3 * i;
        if (!(m[2] > 0.9F) || fabsf(m[0] * at[1] - m[1] * at[0]) > 1e-3F)
            fail_msg("%u corners: corner %zu", n, i);
    }
    free_result(&r);
    test_free(p);
    test_free(c);
    test_free(starts);
}

static void polygons_of_any_number_of_corners(void **state) {
    (void)state;
    static const uint32_t counts[] = {
        3, 4, 5, 8, 9, 31, 64, 92, 95, 96, 97, 100, 128, 191, 192, 193, 289, 1000, 4097, 100000};
    for (size_t i = 0; i < COUNT_OF(counts); ++i) lid(counts[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(smooth_meshes),
        cmocka_unit_test(polygons_of_any_number_of_corners), cmocka_unit_test(all_faces_twice),
        cmocka_unit_test(polygons), cmocka_unit_test(polygons_cut_at_random),
        cmocka_unit_test(turns)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
