/* test_check_known.c: files of the data set with a known answer: what INDEX.tsv says of them was
 * measured by scripts that know nothing of this library. And files that are as they should be: no
 * rule of ours has an error or a warning for them. */
#include "check.h"
#include "mesh_files.h"
#include <norma/check.h>

static norma_findings *findings_of(const char *name) {
    char path[4096];
    norma_document *document = NULL;
    norma_document_error error;
    norma_findings *findings = NULL;
    snprintf(path, sizeof path, "%s/%s", data_folder(), name);
    const norma_document_options options = {.struct_size = sizeof options, .lenient = 1};
    if (norma_document_open(path, &options, &document, &error)) fail_msg("%s", error.message);
    if (norma_check_document(document, NULL, &findings, &error)) fail_msg("%s", error.message);
    norma_document_close(document);
    return findings;
}

/* Over all primitives. */
static size_t sum_of(const norma_findings *findings, const char *id, norma_severity severity) {
    size_t sum = 0;
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *f = norma_findings_get(findings, i);
        if (!strcmp(f->rule->id, id) &&
            (severity == NORMA_SEVERITY_NONE || f->severity == severity))
            sum += f->count;
    }
    return sum;
}

typedef struct known {
    const char *name, *rule;
    norma_severity severity;
    size_t count;
} known;

static const known answers[] = {
    {"obj/lint/moebius.obj", "N301", NORMA_SEVERITY_WARNING, 4},
    {"obj/lint/moebius.obj", "N304", NORMA_SEVERITY_INFO, 1},
    {"obj/lint/fan3.obj", "N303", NORMA_SEVERITY_INFO, 1},
    {"obj/lint/hourglass.obj", "N303", NORMA_SEVERITY_INFO, 1},
    {"obj/box/box-mixed-attributes-2.obj", "N303", NORMA_SEVERITY_INFO, 12},
    {"obj/box/box-incorrect-winding-order.obj", "N301", NORMA_SEVERITY_ERROR, 3},
    {"obj/box/box-incorrect-winding-order.obj", "N201", NORMA_SEVERITY_ERROR, 1},
    {"obj/dcc/cube-six-smoothing-groups.obj", "N103", NORMA_SEVERITY_ERROR, 8},
    {"obj/spider.obj", "N301", NORMA_SEVERITY_INFO, 10},
    {"stl/spider-binary.stl", "N301", NORMA_SEVERITY_INFO, 10},
    {"stl/spider-ascii.stl", "N401", NORMA_SEVERITY_INFO, 56},
    {"stl/spider-ascii.stl", "N205", NORMA_SEVERITY_WARNING, 1312},
    {"bad/obj/joined-tetrahedra.obj", "N306", NORMA_SEVERITY_INFO, 1},
    {"bad/obj/nan-inf.obj", "N101", NORMA_SEVERITY_ERROR, 1},
    {"bad/glb/nan-normal.glb", "N101", NORMA_SEVERITY_ERROR, 1},
    {"bad/gltf/box-infinite.glb", "N002", NORMA_SEVERITY_WARNING, 12},
    {"bad/obj/nan-inf.obj", "N002", NORMA_SEVERITY_WARNING, 3},
    {"bad/gltf/box-bad-normals.glb", "N102", NORMA_SEVERITY_ERROR, 4},
    {"bad/gltf/box-bad-normals.glb", "N103", NORMA_SEVERITY_ERROR, 4},
    {"large/voxel/pandora/pandora.obj", "N301", NORMA_SEVERITY_INFO, 51},
    {"large/voxel/pandora/pandora.obj", "N306", NORMA_SEVERITY_INFO, 4},
    {"large/cad/as1-assembly.obj", "N306", NORMA_SEVERITY_INFO, 174},
    {"large/medical/mni152-brain.ply", "N306", NORMA_SEVERITY_INFO, 32},
    {"large/medical/headsq-bone.ply", "N306", NORMA_SEVERITY_INFO, 1},
    {"large/medical/headsq-bone.ply", "N304", NORMA_SEVERITY_INFO, 2},
    {"large/medical/headsq-skin.ply", "N304", NORMA_SEVERITY_INFO, 2},
    {"large/foliage/japanese-bridge-garden.glb", "N304", NORMA_SEVERITY_INFO,
        25}, /* its parts by material: 177 */
    {"large/foliage/japanese-bridge-garden.glb", "N302", NORMA_SEVERITY_INFO, 25},
    {"large/interior/garage/garage.gltf", "N304", NORMA_SEVERITY_INFO, 38}, /* likewise 72 */
    {"large/game/steampunk-robot/scene.gltf", "N304", NORMA_SEVERITY_INFO, 40},
    {"large/toon/bee-bot.glb", "N304", NORMA_SEVERITY_INFO, 10}, /* likewise 14 */
    {"large/terrain/terrain-level.glb", "N304", NORMA_SEVERITY_INFO, 10},
};

static void known_answers_are_found(void **state) {
    (void)state;
    if (!data_folder()) skip();
    for (size_t i = 0; i < COUNT_OF(answers); ++i) {
        norma_findings *findings = findings_of(answers[i].name);
        const size_t count = sum_of(findings, answers[i].rule, answers[i].severity);
        if (count != answers[i].count)
            fail_msg("%s: %s counts %zu, not %zu", answers[i].name, answers[i].rule, count,
                answers[i].count);
        norma_findings_free(findings);
    }
}

/* Stale normals: of a bent sausage whose normals are those of the straight one, and a cube that was
 * deformed. */
static void stale_normals_are_found(void **state) {
    (void)state;
    if (!data_folder()) skip();
    static const char *const stale[] = {
        "obj/dcc/sausage.obj", "obj/dcc/cube-six-smoothing-groups.obj"};
    for (size_t i = 0; i < COUNT_OF(stale); ++i) {
        norma_findings *findings = findings_of(stale[i]);
        assert_int_equal(sum_of(findings, "N206", NORMA_SEVERITY_ERROR), 1);
        norma_findings_free(findings);
    }
}

/* Hollow heads: cavities of negative volume that lie in them are as they should be. */
static void cavities_are_no_fault(void **state) {
    (void)state;
    static const char *const scans[] = {"large/medical/headsq-skin.ply",
        "large/medical/headsq-bone.ply", "large/medical/mni152-brain.ply"};
    if (!data_folder()) skip();
    for (size_t i = 0; i < COUNT_OF(scans); ++i) {
        norma_findings *findings = findings_of(scans[i]);
        assert_int_equal(sum_of(findings, "N302", NORMA_SEVERITY_NONE), 0);
        norma_findings_free(findings);
    }
}

/* What made the stored normals is known. */
static void makings_are_told(void **state) {
    (void)state;
    static const struct {
        const char *name;
        norma_shading shading;
        norma_weight weight;
    } made[] = {
        {"gltf/blender/01_sphere/01_sphere.gltf", NORMA_SHADING_SMOOTH, NORMA_WEIGHT_ANGLE},
        {"ply/fish-double.ply", NORMA_SHADING_FLAT, NORMA_WEIGHT_ANGLE},
        {"scan/bunny.obj", NORMA_SHADING_FLAT, NORMA_WEIGHT_ANGLE},
        {"scan/spot.obj", NORMA_SHADING_FLAT, NORMA_WEIGHT_ANGLE},
        {"obj/wuson.obj", NORMA_SHADING_SMOOTH, NORMA_WEIGHT_UNIFORM},
    };
    if (!data_folder()) skip();
    for (size_t i = 0; i < COUNT_OF(made); ++i) {
        norma_findings *findings = findings_of(made[i].name);
        for (size_t k = 0; k < norma_findings_count(findings); ++k) {
            const norma_deviation *d = norma_findings_get(findings, k)->deviation;
            if (!d) continue;
            if (d->shading != made[i].shading ||
                (d->shading != NORMA_SHADING_FLAT && d->weight != made[i].weight))
                fail_msg("%s: %s", made[i].name, norma_findings_get(findings, k)->message);
            assert_true(d->p50_rad < .05 / DEGREES);
        }
        norma_findings_free(findings);
    }
}

static void right_ones_are_left_alone(void **state) {
    (void)state;
    static const char *const clean[] = {
        "truth/box-ascii.stl",
        "truth/box-binary.stl",
        "truth/cube-axis-normals.obj",
        "truth/cube-no-bottom.obj",
        "truth/dodecahedron.obj",
        "truth/icosphere.obj",
        "scan/bunny.obj",
        "scan/spot.obj",
        "gltf/khronos/Box/Box.gltf",
        "gltf/khronos/BoxInterleaved/BoxInterleaved.gltf",
        "gltf/khronos/Triangle/Triangle.gltf",
        "gltf/misc/nonuniform-nested.glb",
        "large/cad/a_drive_frame_lower.stl",
        "large/cad/exhaust_filter_housing.stl",
        "large/scan/pizza.obj",
        "large/voxel/obj_house5.glb",
        "large/terrain/terrain-level.glb",
        "large/hair/long01.obj",
        "large/game/steampunk-robot/scene.gltf",
        "obj/dcc/cube-one-smoothing-group.obj",
        "ply/fish-double.ply",
    };
    if (!data_folder()) skip();
    for (size_t i = 0; i < COUNT_OF(clean); ++i) {
        norma_findings *findings = findings_of(clean[i]);
        for (size_t k = 0; k < norma_findings_count(findings); ++k) {
            const norma_finding *f = norma_findings_get(findings, k);
            if (f->severity > NORMA_SEVERITY_INFO && f->rule->id[1] != '6' &&
                strncmp(f->where, "/images/", 8) != 0) /* which the data set left out */
                fail_msg("%s: %s %s", clean[i], f->rule->id, f->message);
        }
        norma_findings_free(findings);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_answers_are_found),
        cmocka_unit_test(stale_normals_are_found),
        cmocka_unit_test(cavities_are_no_fault),
        cmocka_unit_test(makings_are_told),
        cmocka_unit_test(right_ones_are_left_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
