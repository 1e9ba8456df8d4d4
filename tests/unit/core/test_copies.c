/* test_copies.c: small meshes made without taste (the oracle's, which judges them), each many times
 * over in one call, so that all that works in blocks, parts and threads has to do with them: every
 * copy must have the bits that the mesh has alone. Copies stand apart by a power of two, where that
 * changes no difference of two coordinates; elsewhere nothing is welded and they stand in one
 * place.
 */
#include "check.h"
#include "oracle/made_case.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static made_case made;

typedef struct many { /* a mesh of so many copies, of arrays of its own */
    norma_mesh mesh;
    size_t copies, positions, corners, faces;
    int mixed; /* faces and positions of all copies in turn, or one copy after the other */
    double *at;
    float *near_at;
    uint32_t *names, *starts, *groups;
    uint8_t *hard;
} many;

static void *allocate(size_t count, size_t size) {
    void *memory = calloc(count + 1, size);
    assert_non_null(memory);
    return memory;
}

static void many_free(many *m) {
    void *blocks[] = {m->at, m->near_at, m->names, m->starts, m->groups, m->hard};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i) free(blocks[i]);
}

static size_t place(const many *m, size_t number, size_t of, size_t copy) {
    return m->mixed ? number * m->copies + copy : copy * of + number;
}

/* ---- how far apart */

static int holds(double x) { return made.format == NORMA_FORMAT_DOUBLE || (double)(float)x == x; }

/* 0: no step moves every coordinate exactly, or a distance would reach from copy to copy. */
static double step_between(size_t copies) {
    double most = made.options.weld == NORMA_WELD_DISTANCE ? made.options.weld_distance : 0;
    for (size_t v = 0; v < made.position_count; ++v)
        for (int k = 0; k < 3; ++k) most = fmax(most, fabs(made.positions[v][k]));
    if (!(most < 1e30)) return 0;
    const double step = ldexp(1, ilogb(fmax(most, 0x1p-100)) + 3), far = step * (double)copies;
    for (size_t v = 0; v < made.position_count; ++v) {
        const double x = made.positions[v][0];
        if (!(x + far - far == x) || !holds(x + far) || !(x + step - step == x) || !holds(x + step))
            return 0;
    }
    return step;
}

/* ---- the copies */

static void copy_positions(many *m, double step) {
    m->positions = m->copies * made.position_count;
    m->at = allocate(3 * m->positions, sizeof *m->at);
    m->near_at = allocate(3 * m->positions, sizeof *m->near_at);
    for (size_t v = 0; v < made.position_count; ++v)
        for (size_t copy = 0; copy < m->copies; ++copy)
            for (size_t k = 0; k < 3; ++k) {
                const size_t to = 3 * place(m, v, made.position_count, copy) + k;
                m->at[to] = made.positions[v][k] + (k || !copy ? 0 : step * (double)copy);
                if (made.format == NORMA_FORMAT_FLOAT) m->near_at[to] = (float)m->at[to];
            }
    m->mesh.positions = made.format == NORMA_FORMAT_DOUBLE
                            ? (norma_vec3_view){m->at, m->positions, 0, NORMA_FORMAT_DOUBLE}
                            : (norma_vec3_view){m->near_at, m->positions, 0, NORMA_FORMAT_FLOAT};
}

static void copy_face(many *m, size_t face, size_t copy) {
    const size_t to = m->faces++;
    for (size_t c = made.starts[face]; c < made.starts[face + 1]; ++c) {
        m->hard[m->corners] = made.hard[c];
        m->names[m->corners++] = (uint32_t)place(m, made.corners[c], made.position_count, copy);
    }
    m->groups[to] = made.groups[face];
    m->starts[to + 1] = (uint32_t)m->corners;
}

static void copy_faces(many *m) {
    const size_t faces = m->copies * made.face_count, corners = m->copies * made.corner_count;
    m->names = allocate(corners, sizeof *m->names);
    m->hard = allocate(corners, 1);
    m->starts = allocate(faces + 1, sizeof *m->starts);
    m->groups = allocate(faces, sizeof *m->groups);
    for (size_t i = 0; i < faces; ++i)
        copy_face(m, m->mixed ? i / m->copies : i % made.face_count,
            m->mixed ? i % m->copies : i / made.face_count);
    m->mesh.corners = m->names;
    m->mesh.corner_count = corners;
    if (made.polygons) {
        m->mesh.face_starts = m->starts;
        m->mesh.face_count = faces;
    }
    if (made.has_groups) m->mesh.smoothing_groups = m->groups;
    if (made.has_hard) m->mesh.hard_edges = m->hard;
}

static many make(size_t copies, int mixed, double step) {
    many m = {.copies = copies, .mixed = mixed};
    copy_positions(&m, step);
    copy_faces(&m);
    return m;
}

/* ---- the same bits */

typedef struct answer {
    float *normals;
    uint8_t *reasons;
    size_t count;
} answer;

enum { FACES, VERTICES, CORNERS, KINDS };

static answer ask(const many *m, int kind, norma_options options) {
    answer a = {.count = kind == FACES ? m->faces : kind == VERTICES ? m->positions : m->corners};
    a.normals = allocate(3 * a.count, sizeof *a.normals);
    a.reasons = options.reasons = allocate(a.count, 1);
    const norma_result result =
        kind == FACES ? norma_face_normals(&m->mesh, &options, a.normals, a.count, NULL)
        : kind == VERTICES
            ? norma_vertex_normals(&m->mesh, &options, a.normals, a.count, NULL)
            : norma_corner_normals(&m->mesh, made.crease, &options, a.normals, a.count, NULL);
    assert_int_equal(result, NORMA_OK);
    return a;
}

static void answer_free(answer *a) {
    free(a->normals);
    free(a->reasons);
}

/* Where an element of the mesh stands in a copy. Corners of a face stay together. */
static size_t element_at(const many *m, int kind, size_t face, size_t element, size_t copy) {
    if (kind == VERTICES) return place(m, element, made.position_count, copy);
    const size_t to = place(m, face, made.face_count, copy);
    return kind == FACES ? to : m->starts[to] + (element - made.starts[face]);
}

static size_t count_differences(const many *m, int kind, const answer *one, const answer *all) {
    size_t wrong = 0, face = 0;
    for (size_t i = 0; i < one->count; ++i) {
        while (kind != VERTICES && (kind == FACES ? face < i : made.starts[face + 1] <= i)) ++face;
        for (size_t copy = 0; copy < m->copies; ++copy) {
            const size_t at = element_at(m, kind, face, i, copy);
            wrong += memcmp(one->normals + 3 * i, all->normals + 3 * at, 12) != 0 ||
                     one->reasons[i] != all->reasons[at];
        }
    }
    return wrong;
}

static size_t judge(unsigned long long seed, size_t copies, int mixed) {
    static const char *const names[KINDS] = {"faces", "vertices", "corners"};
    static const uint32_t threads[] = {1, 2, 3, 0};
    const double step = step_between(copies);
    norma_options options = made.options;
    size_t wrong = 0;
    if (options.fallback == NORMA_FALLBACK_NEAREST) options.fallback = NORMA_FALLBACK_ZERO;
    if (step == 0) options.weld = NORMA_WELD_NONE;
    options.threads = 1;
    many single = make(1, 0, 0), m = make(copies, mixed, step);
    for (int kind = 0; kind < KINDS; ++kind) {
        answer one = ask(&single, kind, options);
        options.threads = threads[(seed + (unsigned)kind) % 4];
        answer all = ask(&m, kind, options);
        const size_t differ = count_differences(&m, kind, &one, &all);
        if (differ)
            print_message("# seed %llu: %zu copies%s, %s: %zu differ\n", seed, copies,
                mixed ? ", mixed" : "", names[kind], differ);
        wrong += differ;
        answer_free(&one);
        answer_free(&all);
        options.threads = 1;
    }
    many_free(&single);
    many_free(&m);
    return wrong;
}

static int has_instructions(norma_isa isa) {
    const norma_options options = {.isa = isa};
    const norma_mesh none = {0};
    return !norma_face_normals(&none, &options, NULL, 0, NULL);
}

static void every_copy_has_the_bits_of_one(void **state) {
    (void)state;
    static const size_t corners[] = {
        1 << 11, 1 << 13, 1 << 15, 1 << 17, 1 << 11, 1 << 13, 1 << 15, 1 << 19};
    size_t wrong = 0;
    for (unsigned long long seed = 1; seed <= 300 / SLOWER && wrong == 0; ++seed) {
        made_case_of_seed(&made, 1000000 + seed);
        if (!made.corner_count || made.soup ||
            (made.format != NORMA_FORMAT_FLOAT && made.format != NORMA_FORMAT_DOUBLE) ||
            !has_instructions(made.options.isa))
            continue;
        wrong += judge(seed, 1 + corners[seed % 8] / made.corner_count, (int)(seed / 8 % 2));
    }
    assert_int_equal(wrong, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_copy_has_the_bits_of_one)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
