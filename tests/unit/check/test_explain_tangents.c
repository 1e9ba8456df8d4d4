/* test_explain_tangents.c: how stored tangents were made. Two triangles in a plane whose tangents
 * are known by hand, and files of other programs. In triangle A, u and v are x and y. In B, which
 * shares the edge from (0, 0) to (0, 1), u = 2 x and v = y - x, so dP/du = (1/2, 1/2, 0). */
#include "check.h"
#include "mesh_files.h"
#include <norma/check.h>
#include <math.h>
#include <string.h>

static const float POSITIONS[12] = {0, 0, 0, 0, 1, 0, 1, 0, 0, -1, 0, 0};
static const float NORMALS[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
static const float TEXCOORDS[8] = {0, 0, 0, 1, 1, 0, -2, 1};
static const uint32_t CORNERS[6] = {0, 2, 1, 0, 1, 3};

/* (1, 0) of A and (1/2, 1/2) of B, added: (3, 1) / sqrt(10). */
#define SUMS(w)                                                                                    \
    {                                                                                              \
        0.9486833F, 0.3162278F, 0, w, 0.9486833F, 0.3162278F, 0, w, 1, 0, 0, w, 0.7071068F,        \
            0.7071068F, 0, w                                                                       \
    }

static norma_tangent_deviation explain(const float *texcoords, const float *tangents) {
    norma_tangent_deviation found;
    const norma_mesh_data data = {.mesh = {.positions = {.data = POSITIONS, .count = 4},
                                      .corners = CORNERS,
                                      .corner_count = 6},
        .normals = {.data = NORMALS, .count = 4}};
    const norma_mesh_attributes attributes = {.texcoords = texcoords,
        .texcoord_count = 4,
        .tangents = tangents,
        .tangent_count = tangents ? 4 : 0,
        .tangent_encoding = "float"};
    assert_int_equal(norma_explain_tangents(&data, &attributes, NULL, &found), NORMA_OK);
    return found;
}

static void assert_exact(const norma_tangent_deviation *d, norma_tangent_source source) {
    assert_int_equal(d->source, source);
    assert_int_equal(d->corners, 6);
    assert_int_equal(d->explained, 6);
    assert_true(d->max_rad < 1e-6 && d->p50_rad <= d->p99_rad && d->p99_rad <= d->max_rad);
}

static void test_sums(void **state) {
    static const float negated[16] = SUMS(-1), as_is[16] = SUMS(1);
    (void)state;
    norma_tangent_deviation d = explain(TEXCOORDS, negated);
    assert_exact(&d, NORMA_TANGENTS_BY_VERTEX_SUMS);
    assert_int_equal(d.negated, 1);
    assert_int_equal(d.signs_other, 0);
    d = explain(TEXCOORDS, as_is);
    assert_exact(&d, NORMA_TANGENTS_BY_VERTEX_SUMS);
    assert_int_equal(d.negated, 0);
}

/* MikkTSpace adds unit vectors by angle, a right angle each at the vertices 0 and 1: (1, 0) and
 * (1, 1) / sqrt(2) at vertex 0. At vertex 1 both angles are 45 degrees. */
static void test_mikk(void **state) {
    static const float tangents[16] = {0.9238795F, 0.3826834F, 0, -1, 0.9238795F, 0.3826834F, 0, 1,
        1, 0, 0, -1, 0.7071068F, 0.7071068F, 0, -1};
    (void)state;
    const norma_tangent_deviation d = explain(TEXCOORDS, tangents);
    assert_exact(&d, NORMA_TANGENTS_BY_MIKK);
    assert_int_equal(d.negated, 1);
    assert_int_equal(d.signs_other, 2);
}

/* Triangle B twice as wide. meshoptimizer weighs by the angle times both edges: at vertex 0 A by
 * pi/2, B by pi/2 times 2; at vertex 1 by pi/4 times sqrt(2) and by atan(2) times sqrt(5). Its arc
 * cosine is within 5e-4. MikkTSpace halves the angle at vertex 0. */
static void test_meshopt(void **state) {
    static const float positions[12] = {0, 0, 0, 0, 1, 0, 1, 0, 0, -2, 0, 0},
                       texcoords[8] = {0, 0, 0, 1, 1, 0, -4, 2};
    const double pi = 3.141592653589793, root = sqrt(2), b = atan(2) * sqrt(5) / root,
                 ends[2][2] = {{1 + root, root}, {pi / 4 * root + b, b}};
    float tangents[16] = {
        0, 0, 0, -1, 0, 0, 0, -1, 1, 0, 0, -1, (float)(1 / root), (float)(1 / root), 0, -1};
    norma_tangent_deviation d;
    const norma_mesh_data data = {.mesh = {.positions = {.data = positions, .count = 4},
                                      .corners = CORNERS,
                                      .corner_count = 6},
        .normals = {.data = NORMALS, .count = 4}};
    const norma_mesh_attributes attributes = {.texcoords = texcoords,
        .texcoord_count = 4,
        .tangents = tangents,
        .tangent_count = 4,
        .tangent_encoding = "float"};
    (void)state;
    for (size_t v = 0; v < 2; ++v)
        for (size_t k = 0; k < 2; ++k)
            tangents[4 * v + k] = (float)(ends[v][k] / hypot(ends[v][0], ends[v][1]));
    assert_int_equal(norma_explain_tangents(&data, &attributes, NULL, &d), NORMA_OK);
    assert_int_equal(d.source, NORMA_TANGENTS_BY_MESHOPT);
    assert_int_equal(d.negated, 1);
    assert_int_equal(d.explained, 6);
    assert_true(d.under_meshopt.max_rad < 5e-4 && d.max_rad < 5e-4);
    assert_true(fabs(d.under_mikk.max_rad - (atan2(root, 1 + root) - pi / 8)) < 1e-6);
    /* Added as they are: (1, 0) and (1/2, 1/2) make (3, 1) at both ends. */
    assert_true(
        fabs(d.under_vertex_sums.max_rad -
             fmax(atan2(root, 1 + root), atan2(ends[1][1], ends[1][0])) + atan2(1, 3)) < 1e-6);
}

static void test_nothing(void **state) {
    static const float zeros[16] = {0}, flat[8] = {0};
    (void)state;
    assert_int_equal(explain(TEXCOORDS, NULL).corners, 0);
    assert_int_equal(explain(TEXCOORDS, zeros).corners, 0);
    assert_int_equal(explain(flat, zeros).source, NORMA_TANGENTS_UNCOMPARED);
    assert_null(norma_tangent_source_name(NORMA_TANGENTS_UNCOMPARED));
}

/* ---- files of other programs */

typedef struct known {
    const char *name;
    size_t mesh;
    norma_tangent_source source;
    int negated;
} known;

static const known files[] = {
    {"gltf/blender/01_metallic_sphere/01_metallic_sphere.gltf", 0, NORMA_TANGENTS_BY_MIKK_ON_QUADS,
        1},
    {"large/game/pigman/scene.gltf", 0, NORMA_TANGENTS_BY_VERTEX_SUMS, 0},
};

static void check_file(const known *k) {
    char path[4096];
    norma_document *document = NULL;
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    norma_tangent_deviation d;
    norma_findings *findings = NULL;
    size_t found = 0;
    snprintf(path, sizeof path, "%s/%s", data_folder(), k->name);
    assert_int_equal(norma_document_open(path, NULL, &document, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(document, k->mesh, &data, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(
        norma_document_mesh_attributes(document, k->mesh, &attributes, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_explain_tangents(&data, &attributes, NULL, &d), NORMA_OK);
    assert_int_equal(d.source, k->source);
    assert_int_equal(d.negated, k->negated);
    assert_true((double)d.explained > .99 * (double)d.corners);
    assert_int_equal(norma_check_document(document, NULL, &findings, NULL), NORMA_DOCUMENT_OK);
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *f = norma_findings_get(findings, i);
        if (strcmp(f->rule->id, "N807") != 0) continue;
        found += strstr(f->message, norma_tangent_source_name(k->source)) != NULL;
        assert_int_equal(f->count, 1);
        assert_int_equal(f->worst.has_position, f->worst_value >= 0.01);
    }
    assert_true(found > 0);
    norma_findings_free(findings);
    norma_document_close(document);
}

static void test_files(void **state) {
    (void)state;
    if (!data_folder()) skip();
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) check_file(&files[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sums), cmocka_unit_test(test_mikk),
        cmocka_unit_test(test_meshopt), cmocka_unit_test(test_nothing),
        cmocka_unit_test(test_files)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
