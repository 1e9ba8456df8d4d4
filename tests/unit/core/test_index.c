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
    for (size_t s = 0; s < STREAMS; s++) {
        const size_t size = 1 + random_below(&seed, 17), stride = size + random_below(&seed, 4);
        for (size_t i = 0; i < sizeof m->bytes[s]; i++)
            m->bytes[s][i] = (uint8_t)random_below(&seed, 256);
        for (size_t v = 0; v < CORNERS; v++) {
            memset(m->bytes[s] + v * stride, (int)s, size);
            m->bytes[s][v * stride + random_below(&seed, (uint32_t)size)] =
                (uint8_t)random_below(&seed, 3);
        }
        m->streams[s] =
            (norma_stream){.data = m->bytes[s], .count = CORNERS, .size = size, .stride = stride};
    }
    for (size_t c = 0; c < CORNERS; c++) m->numbers[c] = random_below(&seed, 20);
    m->streams[1].corners = m->numbers;
    m->streams[1].count = 20;
    return m;
}

static const uint8_t *value(const norma_stream *s, size_t corner) {
    return (const uint8_t *)s->data + (s->corners ? s->corners[corner] : corner) * s->stride;
}

static int agree(const norma_stream *streams, size_t count, size_t a, size_t b) {
    for (size_t s = 0; s < count; s++)
        for (size_t i = 0; i < streams[s].size; i++)
            if (value(&streams[s], a)[i] != value(&streams[s], b)[i]) return 0;
    return 1;
}

static void corners_that_agree_are_one_vertex(void **state) {
    (void)state;
    for (uint64_t seed = 0; seed < 40; seed++) {
        made_streams *m = make_streams(seed);
        uint32_t corners[CORNERS], sources[CORNERS], next = 0;
        uint16_t narrow[CORNERS];
        norma_indexed counted = {.corner_size = 4}, to = {corners, 4, CORNERS, sources, CORNERS, 0},
                      small = {narrow, 2, CORNERS, NULL, 0, 0};
        const norma_options threads = {.threads = 3};
        assert_ok(norma_index_corners(m->streams, STREAMS, CORNERS, NULL, &counted));
        assert_ok(norma_index_corners(m->streams, STREAMS, CORNERS, &threads, &to));
        assert_ok(norma_index_corners(m->streams, STREAMS, CORNERS, NULL, &small));
        for (uint32_t c = 0; c < CORNERS; c++) {
            uint32_t first = 0;
            while (!agree(m->streams, STREAMS, first, c)) first++;
            if (first == c) assert_int_equal(sources[next++], c);
            assert_int_equal(corners[c], first == c ? next - 1 : corners[first]);
            assert_int_equal(narrow[c], corners[c]);
        }
        assert_true(next > 1 && next < CORNERS && to.vertex_count == next);
        assert_true(counted.vertex_count == next && small.vertex_count == next);
        free(m);
    }
}

/* As 65535 starts a new strip, 65535 vertices are the most. */
static void sixteen_bits(void **state) {
    enum { MOST = 65536 };
    (void)state;
    uint32_t *values = calloc(MOST, 4);
    uint16_t *narrow = calloc(MOST, 2);
    for (uint32_t i = 0; i < MOST; i++) values[i] = i;
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
    for (int i = 0; i < GRID; i++) {
        const int x = i % (SIDE + 1), y = i / (SIDE + 1);
        memcpy(s->positions[i], (float[]){(float)x, (float)y, (float)(x * y) / 9}, 12);
        memcpy(s->normals[i], (float[]){0, 0, 1}, 12);
        memcpy(s->texcoords[i], (float[]){(float)abs(x - SIDE / 2), (float)y}, 8);
    }
    for (int f = 0; f < FACES; f++) {
        const int a = f / 2 / SIDE * (SIDE + 1) + f / 2 % SIDE, odd = f % 2;
        const int three[] = {a, odd ? a + SIDE + 2 : a + 1, odd ? a + SIDE + 1 : a + SIDE + 2};
        for (int k = 0; k < 3; k++) s->corners[3 * f + k] = (uint16_t)three[k];
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
    assert_ok(norma_split_tangents(
        &mesh, &normals, &texcoords, NORMA_TANGENTS_MIKK, &wide, split[0], &to, NULL));
    for (size_t c = 0; c < COUNT; c++) {
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

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(corners_that_agree_are_one_vertex),
        cmocka_unit_test(sixteen_bits), cmocka_unit_test(copies_nothing_between),
        cmocka_unit_test(faults), cmocka_unit_test(split_by_tangents)};
    return cmocka_run_group_tests_name("index", tests, NULL, NULL);
}
