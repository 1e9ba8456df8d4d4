/* test_index.c: an indexed mesh out of values per corner. Who agrees is told again by comparing
 * each corner with all before it, byte by byte. */
#include "check.h"

enum { CORNERS = 600, STREAMS = 3 };

typedef struct made_streams {
    uint8_t bytes[STREAMS][CORNERS * 24];
    uint32_t numbers[CORNERS];
    norma_stream streams[STREAMS];
} made_streams;

static uint32_t random_below(uint64_t *seed, uint32_t count) {
    *seed = *seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*seed >> 33) % count;
}

/* Few values, so that many corners agree; the bytes between values differ. */
static made_streams *make_streams(uint64_t seed) {
    made_streams *m = calloc(1, sizeof *m);
    for (size_t s = 0; s < STREAMS; ++s) {
        const size_t size = 1 + random_below(&seed, 17), stride = size + random_below(&seed, 4);
        for (size_t i = 0; i < sizeof m->bytes[s]; ++i)
            m->bytes[s][i] = (uint8_t)random_below(&seed, 256);
        for (size_t v = 0; v < CORNERS; ++v) {
            memset(m->bytes[s] + v * stride, (int)s, size);
            m->bytes[s][v * stride + random_below(&seed, (uint32_t)size)] =
                (uint8_t)random_below(&seed, 3);
        }
        m->streams[s] =
            (norma_stream){.data = m->bytes[s], .count = CORNERS, .size = size, .stride = stride};
    }
    for (size_t c = 0; c < CORNERS; ++c) m->numbers[c] = random_below(&seed, 20);
    m->streams[1].corners = m->numbers;
    m->streams[1].count = 20;
    return m;
}

static const uint8_t *value(const norma_stream *s, size_t corner) {
    return (const uint8_t *)s->data + (s->corners ? s->corners[corner] : corner) * s->stride;
}

static int agree(const norma_stream *streams, size_t count, size_t a, size_t b) {
    for (size_t s = 0; s < count; ++s)
        for (size_t i = 0; i < streams[s].size; ++i)
            if (value(&streams[s], a)[i] != value(&streams[s], b)[i]) return 0;
    return 1;
}

static void corners_that_agree_are_one_vertex(void **state) {
    (void)state;
    for (uint64_t seed = 0; seed < 40; ++seed) {
        made_streams *m = make_streams(seed);
        uint32_t corners[CORNERS], sources[CORNERS], next = 0;
        uint16_t narrow[CORNERS];
        norma_indexed counted = {.corner_size = 4}, to = {corners, 4, CORNERS, sources, CORNERS, 0},
                      small = {narrow, 2, CORNERS, NULL, 0, 0};
        const norma_options threads = {.threads = 3};
        assert_ok(norma_index_corners(m->streams, STREAMS, CORNERS, NULL, &counted));
        assert_ok(norma_index_corners(m->streams, STREAMS, CORNERS, &threads, &to));
        assert_ok(norma_index_corners(m->streams, STREAMS, CORNERS, NULL, &small));
        for (uint32_t c = 0; c < CORNERS; ++c) {
            uint32_t first = 0;
            while (!agree(m->streams, STREAMS, first, c)) ++first;
            if (first == c) assert_int_equal(sources[next++], c);
            assert_int_equal(corners[c], first == c ? next - 1 : corners[first]);
            assert_int_equal(narrow[c], corners[c]);
        }
        assert_true(next > 1 && next < CORNERS && to.vertex_count == next);
        assert_true(counted.vertex_count == next && small.vertex_count == next);
        free(m);
    }
}

/* Positions that agree are neighbours in some places and far apart in others, in several slices and
 * buckets: a soup's normals are those of the mesh that names each position once. */
static void many_near_and_far(void **state) {
    (void)state;
    enum { MANY = 150000, VALUES = 40000 };
    uint32_t *values = malloc(MANY * sizeof *values);
    float(*at)[3] = malloc(VALUES * sizeof *at), (*soup)[3] = malloc(MANY * sizeof *soup),
    (*named)[3] = malloc(VALUES * sizeof *named), (*normals)[3] = malloc(MANY * sizeof *normals);
    uint64_t seed = 7;
    assert_true(values && at && soup && named && normals);
    for (uint32_t v = 0; v < VALUES; ++v)
        for (int k = 0; k < 3; ++k) at[v][k] = (float)random_below(&seed, 1000);
    for (uint32_t c = 0; c < MANY; ++c) {
        values[c] = random_below(&seed, 3) ? (c / 5 + random_below(&seed, 400)) % VALUES
                                           : random_below(&seed, VALUES);
        memcpy(soup[c], at[values[c]], sizeof soup[c]);
    }
    const norma_mesh once = {.positions = {.data = at, .count = VALUES},
                         .corners = values,
                         .corner_count = MANY},
                     mesh = {.positions = {.data = soup, .count = MANY}, .corner_count = MANY};
    assert_ok(norma_vertex_normals(&once, NULL, named[0], VALUES, NULL));
    for (uint32_t threads = 1; threads < 6; threads += 2) {
        const norma_options options = {.threads = threads};
        assert_ok(norma_vertex_normals(&mesh, &options, normals[0], MANY, NULL));
        for (uint32_t c = 0; c < MANY; ++c)
            assert_memory_equal(normals[c], named[values[c]], sizeof normals[c]);
    }
    free(values);
    free(at);
    free(soup);
    free(named);
    free(normals);
}

/* As 65535 starts a new strip, 65535 vertices are the most. */
static void sixteen_bits(void **state) {
    enum { MOST = 65536 };
    (void)state;
    uint32_t *values = calloc(MOST, 4);
    uint16_t *narrow = calloc(MOST, 2);
    for (uint32_t i = 0; i < MOST; ++i) values[i] = i;
    const norma_stream stream = {.data = values, .count = MOST, .size = 4};
    norma_indexed to = {.corners = narrow, .corner_size = 2, .corner_capacity = MOST};
    assert_int_equal(norma_index_corners(&stream, 1, MOST, NULL, &to), NORMA_ERROR_OVERFLOW);
    assert_true(narrow[1] == 0 && to.vertex_count == 0);
    assert_ok(norma_index_corners(&stream, 1, MOST - 1, NULL, &to));
    assert_true(to.vertex_count == MOST - 1 && narrow[MOST - 2] == MOST - 2);
    assert_int_equal(norma_index_size(MOST - 1), 2);
    assert_int_equal(norma_index_size(MOST), 4);
    free(values);
    free(narrow);
}

static void copies_nothing_between(void **state) {
    (void)state;
    const uint8_t data[] = {1, 2, 9, 3, 4, 9, 5, 6, 9};
    const uint32_t numbers[] = {2, 0, 1, 0}, sources[] = {3, 0, 2};
    uint8_t out[12];
    norma_stream stream = {.data = data, .count = 3, .size = 2, .stride = 3, .corners = numbers};
    memset(out, 7, sizeof out);
    assert_ok(norma_copy_values(&stream, sources, 3, out, 4, 3));
    assert_memory_equal(out, ((uint8_t[]){1, 2, 7, 7, 5, 6, 7, 7, 3, 4, 7, 7}), 12);
    assert_int_equal(norma_copy_values(&stream, sources, 3, out, 4, 2), NORMA_ERROR_CAPACITY);
    assert_int_equal(norma_copy_values(&stream, sources, 3, out, 1, 3), NORMA_ERROR_ARGUMENT);
    stream.corners = NULL;
    assert_int_equal(norma_copy_values(&stream, sources, 3, out, 4, 3), NORMA_ERROR_INDEX);
    assert_memory_equal(out, ((uint8_t[]){1, 2, 7, 7, 5, 6, 7, 7, 3, 4, 7, 7}), 12);
}

static void expect_fault(norma_stream stream, norma_result result, const char *name, size_t index) {
    const norma_stream streams[] = {{.data = "abcd", .count = 4, .size = 1}, stream};
    norma_indexed to = {0};
    norma_fault fault;
    assert_int_equal(norma_index_corners(streams, 2, 4, NULL, &to), result);
    assert_int_equal(norma_find_stream_fault(streams, 2, 4, NULL, &fault), result);
    assert_string_equal(fault.argument, name);
    assert_true(fault.index == index && fault.expected);
}

static void faults(void **state) {
    (void)state;
    const uint32_t numbers[] = {0, 1, 4, 9};
    norma_fault fault;
    norma_indexed to = {.corner_size = 3};
    const norma_stream stream = {.data = "abcd", .count = 4, .size = 1};
    expect_fault(
        (norma_stream){.data = "abcd", .count = 4}, NORMA_ERROR_ARGUMENT, "streams->size", 1);
    expect_fault((norma_stream){.count = 4, .size = 1}, NORMA_ERROR_ARGUMENT, "streams->data", 1);
    expect_fault((norma_stream){.data = "abc", .count = 3, .size = 1}, NORMA_ERROR_ARGUMENT,
        "streams->count", 1);
    expect_fault((norma_stream){.data = "abcd", .count = 4, .size = 1, .corners = numbers},
        NORMA_ERROR_INDEX, "streams->corners", 2);
    expect_fault((norma_stream){.data = "abcd", .count = SIZE_MAX, .size = 2}, NORMA_ERROR_OVERFLOW,
        "streams->count", 1);
    assert_int_equal(norma_find_stream_fault(NULL, 0, 4, NULL, &fault), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_index_corners(&stream, 1, 4, NULL, &to), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_index_corners(&stream, 1, 4, NULL, NULL), NORMA_ERROR_ARGUMENT);
    assert_ok(norma_find_stream_fault(&stream, 1, 4, NULL, &fault));
}

/* ---- tangents and vertices in one call */

enum { SIDE = 6, GRID = (SIDE + 1) * (SIDE + 1), FACES = 2 * SIDE * SIDE };

typedef struct sheet {
    float positions[GRID][3], normals[GRID][3], texcoords[GRID][2];
    uint16_t corners[3 * FACES];
} sheet;

/* Folded in texture space along its middle, so that vertices there have tangents of both signs. */
static void make_sheet(sheet *s) {
    for (int i = 0; i < GRID; ++i) {
        const int x = i % (SIDE + 1), y = i / (SIDE + 1);
        memcpy(s->positions[i], (float[]){(float)x, (float)y, (float)(x * y) / 9}, 12);
        memcpy(s->normals[i], (float[]){0, 0, 1}, 12);
        memcpy(s->texcoords[i], (float[]){(float)abs(x - SIDE / 2), (float)y}, 8);
    }
    for (int f = 0; f < FACES; ++f) {
        const int a = f / 2 / SIDE * (SIDE + 1) + f / 2 % SIDE, odd = f % 2;
        const int three[] = {a, odd ? a + SIDE + 2 : a + 1, odd ? a + SIDE + 1 : a + SIDE + 2};
        for (int k = 0; k < 3; ++k) s->corners[3 * f + k] = (uint16_t)three[k];
    }
}

static void split_by_tangents(void **state) {
    enum { COUNT = 3 * FACES };
    static sheet s;
    (void)state;
    make_sheet(&s);
    const norma_mesh mesh = {.positions = {.data = s.positions, .count = GRID},
        .corners = s.corners,
        .corner_count = COUNT,
        .corner_size = 2};
    const norma_attribute normals = {.data = s.normals, .count = GRID},
                          texcoords = {.data = s.texcoords, .count = GRID};
    const norma_options wide = {.normal_stride = 20};
    float each[COUNT][4], split[COUNT][5] = {{0}};
    uint32_t corners[COUNT], sources[COUNT];
    norma_indexed counted = {0}, to = {corners, 4, COUNT, sources, COUNT, 0},
                  without = {NULL, 0, 0, NULL, COUNT, 0};
    assert_ok(norma_corner_tangents(
        &mesh, &normals, &texcoords, NORMA_TANGENTS_MIKK, NULL, each[0], COUNT, NULL));
    assert_ok(norma_split_tangents(
        &mesh, &normals, &texcoords, NORMA_TANGENTS_MIKK, NULL, NULL, &counted, NULL));
    assert_int_equal(counted.vertex_count, GRID + SIDE + 1); /* the fold's vertices are two each */
    norma_built built = {.source_vertices = NULL};
    assert_ok(norma_build(&mesh, &texcoords, 3.14F, NORMA_TANGENTS_MIKK, NULL, &built, NULL));
    assert_int_equal(built.indexed.vertex_count, GRID + SIDE + 1);
    assert_ok(norma_split_tangents(
        &mesh, &normals, &texcoords, NORMA_TANGENTS_MIKK, &wide, split[0], &to, NULL));
    for (size_t c = 0; c < COUNT; ++c) {
        assert_memory_equal(split[corners[c]], each[c], 16);
        assert_int_equal(s.corners[sources[corners[c]]], s.corners[c]);
        assert_true(split[corners[c]][4] == 0);
    }
    memset(split, 0, sizeof split);
    assert_ok(norma_split_tangents(
        &mesh, &normals, &texcoords, NORMA_TANGENTS_MIKK, &wide, split[0], &without, NULL));
    assert_memory_equal(split[corners[COUNT - 1]], each[COUNT - 1], 16);
    without.vertex_capacity = GRID;
    assert_int_equal(norma_split_tangents(&mesh, &normals, &texcoords, NORMA_TANGENTS_MIKK, &wide,
                         split[0], &without, NULL),
        NORMA_ERROR_CAPACITY);
    assert_int_equal(norma_split_tangents(NULL, &normals, &texcoords, NORMA_TANGENTS_MIKK, NULL,
                         NULL, &counted, NULL),
        NORMA_ERROR_ARGUMENT);
}

/* A cube of six quads on eight positions, its texture coordinates per corner: the side of each axis
 * and sign, whose first edge runs along the next axis. */
enum { CUBE = 24 };

static void make_cube(float positions[8][3], uint32_t corners[CUBE], uint32_t starts[7]) {
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 3; ++k) positions[i][k] = (float)(i >> k & 1);
    for (uint32_t f = 0; f < 6; ++f) {
        const uint32_t side = f % 2, a = f / 2, u = (a + 1) % 3, v = (a + 2) % 3, base = side << a;
        const uint32_t square[] = {base, base | 1U << u, base | 1U << u | 1U << v, base | 1U << v};
        for (uint32_t k = 0; k < 4; ++k) corners[4 * f + k] = square[side ? k : 3 - k];
        starts[f] = 4 * f;
    }
    starts[6] = CUBE;
}

/* Normals and tangents are the axes, by the way the cube is made; the sides share no vertex, as
 * their normals differ. */
static void builds_a_cube(void **state) {
    float positions[8][3], texcoords[CUBE][2], normals[CUBE][3], tangents[CUBE][5] = {{0}};
    uint32_t corners[CUBE], starts[7], vertices[CUBE];
    uint16_t numbers[CUBE];
    (void)state;
    make_cube(positions, corners, starts);
    for (int c = 0; c < CUBE; ++c) {
        texcoords[c][0] = positions[corners[c]][(c / 8 + 1) % 3];
        texcoords[c][1] = positions[corners[c]][(c / 8 + 2) % 3];
    }
    const norma_mesh mesh = {.positions = {.data = positions, .count = 8},
        .corners = corners,
        .corner_count = CUBE,
        .face_starts = starts,
        .face_count = 6};
    const norma_attribute uv = {.data = texcoords, .count = CUBE, .of = NORMA_PER_CORNER};
    norma_built counted = {.source_vertices = NULL}, built = {.indexed = {.corners = numbers,
                                                                  .corner_size = 2,
                                                                  .corner_capacity = CUBE,
                                                                  .vertex_capacity = CUBE},
                                                         .source_vertices = vertices,
                                                         .normals = normals[0],
                                                         .tangents = tangents[0],
                                                         .tangent_stride = sizeof tangents[0]};
    assert_ok(norma_build(&mesh, &uv, 0.5F, NORMA_TANGENTS_MIKK, NULL, &counted, NULL));
    assert_int_equal(counted.indexed.vertex_count, CUBE);
    assert_ok(norma_build(&mesh, &uv, 0.5F, NORMA_TANGENTS_MIKK, NULL, &built, NULL));
    assert_int_equal(built.indexed.vertex_count, CUBE);
    for (int c = 0; c < CUBE; ++c) {
        const int axis = c / 8, side = c / 4 % 2 ? 1 : -1;
        assert_int_equal(numbers[c], c);
        assert_int_equal(vertices[c], corners[c]);
        for (int k = 0; k < 3; ++k) {
            assert_true(normals[c][k] == (float)(k == axis ? side : 0));
            assert_true(tangents[c][k] == (float)(k == (axis + 1) % 3));
        }
        assert_true(tangents[c][3] == (float)side && tangents[c][4] == 0);
    }
    /* After an error nothing has been written, reasons and report included. */
    uint8_t reasons[CUBE];
    norma_report report = {.cancelled = {7, 7}};
    const norma_options options = {.reasons = reasons};
    norma_attribute broken = uv;
    memset(reasons, 9, sizeof reasons);
    memset(normals, 0, sizeof normals);
    built.indexed.vertex_capacity = CUBE - 1;
    assert_int_equal(norma_build(&mesh, &uv, 0.5F, NORMA_TANGENTS_MIKK, &options, &built, &report),
        NORMA_ERROR_CAPACITY);
    built.indexed.vertex_capacity = CUBE;
    broken.count = CUBE - 1;
    assert_int_equal(
        norma_build(&mesh, &broken, 0.5F, NORMA_TANGENTS_MIKK, &options, &built, &report),
        NORMA_ERROR_ARGUMENT);
    assert_true(normals[0][0] == 0 && reasons[0] == 9 && report.cancelled.count == 7);
    assert_ok(norma_build(&mesh, &uv, 0.5F, NORMA_TANGENTS_MIKK, &options, &built, &report));
    assert_true(reasons[CUBE - 1] == NORMA_REASON_NONE && report.cancelled.count == 0);
    assert_int_equal(norma_build(&mesh, NULL, 0.5F, NORMA_TANGENTS_MIKK, NULL, &built, NULL),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_build(&mesh, &uv, 0.5F, NORMA_TANGENTS_MIKK, NULL, NULL, NULL), NORMA_ERROR_ARGUMENT);
}

/* The same cube as a soup, smooth, without texture: its eight places are eight vertices. */
static void builds_from_a_soup(void **state) {
    float positions[8][3], soup[CUBE][3], normals[CUBE][3];
    uint32_t corners[CUBE], starts[7], numbers[CUBE];
    (void)state;
    make_cube(positions, corners, starts);
    for (int c = 0; c < CUBE; ++c) memcpy(soup[c], positions[corners[c]], sizeof soup[c]);
    const norma_mesh mesh = {.positions = {.data = soup, .count = CUBE},
        .corner_count = CUBE,
        .face_starts = starts,
        .face_count = 6};
    norma_built built = {
        .indexed = {.corners = numbers, .corner_capacity = CUBE, .vertex_capacity = 8},
        .normals = normals[0]};
    assert_ok(norma_build(&mesh, NULL, 3.1415927F, NORMA_TANGENTS_STEADY, NULL, &built, NULL));
    assert_int_equal(built.indexed.vertex_count, 8);
    for (int c = 0; c < CUBE; ++c)
        for (int k = 0; k < 3; ++k) {
            const double diagonal = (soup[c][k] > 0 ? 1 : -1) / sqrt(3);
            assert_true(fabs((double)normals[numbers[c]][k] - diagonal) < 1e-7);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(corners_that_agree_are_one_vertex),
        cmocka_unit_test(many_near_and_far), cmocka_unit_test(sixteen_bits),
        cmocka_unit_test(copies_nothing_between), cmocka_unit_test(faults),
        cmocka_unit_test(split_by_tangents), cmocka_unit_test(builds_a_cube),
        cmocka_unit_test(builds_from_a_soup)};
    return cmocka_run_group_tests_name("index", tests, NULL, NULL);
}
