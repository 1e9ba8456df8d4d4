/* nodes.c: N601 to N605: world matrices of the nodes that draw meshes, of each of their instances,
 * and of the joints of skins. A skinned mesh follows its joints, and the matrix of its own node is
 * ignored (glTF 2.0, 3.7.3.3): such a node is not judged. */
#include "check/rules/rules.h"
#include "check/findings/check_run.h"
#include <math.h>

static const double UNEVEN = 1.05, SHEARED = 1e-3, DEGREES = 180 / 3.141592653589793;

typedef struct node_kind { /* of instances */
    size_t count, first;
} node_kind;

typedef struct node_sums { /* instances, and the worst of each kind */
    node_kind uneven, mirrored, upright, singular, sheared;
    double anisotropy, determinant, cosine, error_rad;
    int rank;
} node_sums;

/* The largest |cosine| between two columns. */
static double shear_of(const double m[16]) {
    double worst = 0;
    for (int i = 0; i < 3; ++i) {
        const double *a = m + 4 * i, *b = m + 4 * ((i + 1) % 3);
        double aa = a[0] * a[0] + a[1] * a[1] + a[2] * a[2],
               bb = b[0] * b[0] + b[1] * b[1] + b[2] * b[2],
               ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        if (aa > 0 && bb > 0) worst = fmax(worst, fabs(ab) / (sqrt(aa) * sqrt(bb)));
    }
    return worst;
}

static void count_instances(node_kind *kind, size_t index, size_t times) {
    if (!kind->count) kind->first = index;
    kind->count += times;
}

/* A matrix that flattens is that and nothing else. times: instances from index on that it moves. */
static void judge_world(const double world[16], size_t index, size_t times, node_sums *sums) {
    double normal_matrix[9];
    norma_matrix_info info;
    int finite = !norma_normal_matrix_double(world, NORMA_WINDING_KEPT, normal_matrix, &info);
    if (!finite || info.rank < 3) {
        const int had_less = sums->singular.count && sums->rank < info.rank;
        sums->rank = had_less ? sums->rank : finite ? info.rank : 0;
        count_instances(&sums->singular, index, times);
        return;
    }
    double cosine = shear_of(world);
    if (info.anisotropy > UNEVEN) count_instances(&sums->uneven, index, times);
    if (cosine > SHEARED) count_instances(&sums->sheared, index, times);
    count_instances(info.mirrored ? &sums->mirrored : &sums->upright, index, times);
    if (info.mirrored && (sums->determinant == 0 || info.determinant < sums->determinant))
        sums->determinant = info.determinant;
    sums->cosine = fmax(sums->cosine, cosine);
    if (info.anisotropy > sums->anisotropy) {
        sums->anisotropy = info.anisotropy;
        sums->error_rad = info.worst_error_rad;
    }
}

/* Of instances in memory, without a document, only the node's matrix and the number of mirrored
 * ones are known. */
static norma_result judge_instances(const norma_node_info *node, check_instance_world *world_of,
    void *context, size_t index, node_sums *sums) {
    double world[16];
    norma_result result = NORMA_OK;
    if (!world_of) {
        judge_world(node->world, 0, node->instances, sums);
        if (node->instances > 1 && node->mirrored_instances <= node->instances &&
            !sums->singular.count) {
            sums->mirrored.count = node->mirrored_instances;
            sums->upright.count = node->instances - node->mirrored_instances;
            sums->determinant = NAN;
        }
        return NORMA_OK;
    }
    for (size_t i = 0; i < node->instances && !result; ++i) {
        result = world_of(context, index, i, world);
        if (!result) judge_world(world, i, 1, sums);
    }
    return result;
}

typedef struct node_judgement {
    check_run *run;
    uint8_t rules[CHECK_RULE_COUNT];
    check_place place;
    const norma_node_info *node;
    int has_worlds;   /* of its instances, each */
    int double_sided; /* some material of its mesh */
} node_judgement;

static norma_result add_node_finding(const node_judgement *j, check_rule rule,
    norma_severity severity, size_t count, double worst, const char *unit, const char *message) {
    check_hits hits = {.count = count, .worst = worst, .worst_spot = CHECK_NOWHERE};
    if (!count || !j->rules[rule]) return NORMA_OK;
    return norma_check_add(j->run, &j->place,
        &(check_finding){.rule = rule,
            .severity = severity,
            .unit = unit,
            .no_value = isnan(worst),
            .no_fix = j->run->has_tile_instances,
            .hits = &hits,
            .message = message});
}

/* " at 2 of 5 instances", or nothing. */
static void name_instances(const node_judgement *j, node_kind kind, char text[CHECK_MESSAGE]) {
    text[0] = 0;
    if (j->node->instances != 1 && j->has_worlds && kind.count == 1)
        norma_check_message(text, " at instance %z of %z", kind.first, j->node->instances);
    else if (j->node->instances != 1 && j->has_worlds)
        norma_check_message(text, " at %z of %z instances, the first of them %z", kind.count,
            j->node->instances, kind.first);
    else if (j->node->instances != 1)
        norma_check_message(text, " at %z of %z instances", kind.count, j->node->instances);
}

static norma_result add_mirrored(const node_judgement *j, const node_sums *sums) {
    char where[CHECK_MESSAGE], determinant[CHECK_MESSAGE], message[CHECK_MESSAGE];
    int mixed = sums->mirrored.count && sums->upright.count;
    name_instances(j, sums->mirrored, where);
    norma_check_message(
        determinant, isnan(sums->determinant) ? "below 0" : "%g", sums->determinant);
    norma_check_message(message, "mirrored%s: world determinant %s%s%s%s", where, determinant,
        mixed ? ", and the others do not mirror" : "",
        j->double_sided ? " and the material is double-sided" : "",
        mixed             ? "; one draw call can cull in only one direction"
        : j->double_sided ? "; renderers disagree on how to light it"
                          : "; renderers must reverse their culling");
    return add_node_finding(j, RULE_N602,
        mixed || j->double_sided ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO,
        sums->mirrored.count, sums->determinant, "determinant", message);
}

static norma_result add_node_findings(const node_judgement *j, const node_sums *sums) {
    char where[CHECK_MESSAGE], message[CHECK_MESSAGE];
    name_instances(j, sums->uneven, where);
    norma_check_message(message,
        "stretched%s, one direction by %g times another; a renderer without the normal matrix errs "
        "by up to %g degrees",
        where, sums->anisotropy, sums->error_rad * DEGREES);
    norma_result result = add_node_finding(
        j, RULE_N601, NORMA_SEVERITY_INFO, sums->uneven.count, sums->anisotropy, "ratio", message);
    if (!result) result = add_mirrored(j, sums);
    name_instances(j, sums->singular, where);
    norma_check_message(message, "flattened%s: world matrix of rank %z, which has no inverse",
        where, (size_t)sums->rank);
    if (!result)
        result = add_node_finding(j, RULE_N603, NORMA_SEVERITY_WARNING, sums->singular.count,
            (double)sums->rank, "rank", message);
    name_instances(j, sums->sheared, where);
    norma_check_message(message,
        "skewed%s: columns of the world matrix are %g degrees off perpendicular; this cannot be "
        "written as translation, rotation and scale",
        where, norma_check_arc_sine(fmin(sums->cosine, 1)) * DEGREES);
    return result ? result
                  : add_node_finding(j, RULE_N604, NORMA_SEVERITY_WARNING, sums->sheared.count,
                        sums->cosine, "cosine", message);
}

static void label_of(const char *kind, size_t number, const char *name, char label[CHECK_MESSAGE]) {
    norma_check_message(
        label, name && *name ? "%s %z \"%s\"" : "%s %z", kind, number, name ? name : "");
}

static int has_double_sided(const norma_check_scene *scene, size_t mesh) {
    for (size_t i = 0; i < scene->mesh_count; ++i)
        if (scene->meshes[i].info.mesh == mesh && scene->meshes[i].material.double_sided) return 1;
    return 0;
}

static norma_result judge_node(check_run *run, const norma_check_scene *scene, size_t index,
    check_instance_world *world_of, void *context) {
    const norma_node_info *node = &scene->nodes[index];
    char label[CHECK_MESSAGE];
    node_judgement j = {.run = run, .node = node, .has_worlds = world_of != NULL};
    node_sums sums = {0};
    j.place = (check_place){
        .order = run->next_order++, .where = node->where ? node->where : "", .label = label};
    memcpy(j.rules, run->rules, sizeof j.rules);
    norma_check_silence(j.rules, node->ignore);
    if (node->skin != SIZE_MAX ||
        !(j.rules[RULE_N601] || j.rules[RULE_N602] || j.rules[RULE_N603] || j.rules[RULE_N604]))
        return NORMA_OK;
    norma_result result = judge_instances(node, world_of, context, index, &sums);
    if (result ||
        !(sums.uneven.count || sums.mirrored.count || sums.singular.count || sums.sheared.count))
        return result;
    label_of("node", node->node, node->name, label);
    j.double_sided = sums.mirrored.count && has_double_sided(scene, node->mesh);
    return add_node_findings(&j, &sums);
}

/* 0: nothing was measured. */
static int describe_skin_error(
    const norma_check_scene *scene, const norma_skin_info *skin, char *text) {
    char when[CHECK_MESSAGE] = "at rest", part[CHECK_MESSAGE] = "";
    if (isnan(skin->normal_error_rad) || skin->error_mesh >= scene->mesh_count) return 0;
    const norma_mesh_info *mesh = &scene->meshes[skin->error_mesh].info;
    if (skin->error_animation != SIZE_MAX)
        norma_check_message(
            when, "in animation %z at %g s", skin->error_animation, skin->error_time_s);
    if (skin->examined_keys < skin->keys)
        norma_check_message(part, " (%z of %z keys examined)", skin->examined_keys, skin->keys);
    norma_check_message(text,
        "a shader that takes normals through the blended matrix errs by up to %g degrees, at "
        "vertex %z of mesh %z, %s%s",
        skin->normal_error_rad * (180 / 3.141592653589793), skin->error_vertex, mesh->mesh, when,
        part);
    return 1;
}

static norma_result judge_skin(
    check_run *run, const norma_check_scene *scene, const norma_skin_info *skin, size_t number) {
    char label[CHECK_MESSAGE], message[CHECK_MESSAGE], measured[CHECK_MESSAGE] = "";
    node_judgement j = {.run = run};
    memcpy(j.rules, run->rules, sizeof j.rules);
    norma_check_silence(j.rules, skin->ignore);
    j.place = (check_place){
        .order = run->next_order++, .where = skin->where ? skin->where : "", .label = label};
    label_of("skin", number, skin->name, label);
    norma_check_message(message,
        "stretched at a joint: node %z stretches one direction by %g times another, at rest or in "
        "an animation; %s",
        skin->joint, skin->anisotropy,
        describe_skin_error(scene, skin, measured) ? measured : "most skinning shaders err there");
    return add_node_finding(&j, RULE_N605, NORMA_SEVERITY_INFO,
        skin->joint_count && skin->anisotropy > UNEVEN, skin->anisotropy, "ratio", message);
}

norma_result norma_check_nodes(
    check_run *run, const norma_check_scene *scene, check_instance_world *world_of, void *context) {
    norma_result result = NORMA_OK;
    for (size_t i = 0; i < scene->node_count && !result; ++i)
        result = judge_node(run, scene, i, world_of, context);
    for (size_t i = 0; i < scene->skin_count && !result; ++i)
        result = judge_skin(run, scene, &scene->skins[i], i);
    return result;
}
