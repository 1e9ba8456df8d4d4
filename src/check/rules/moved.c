/* N601 to N605 and N901 to N903: what moves a mesh. World matrices of the nodes that draw meshes,
 * of each of their instances, and of the joints of skins; a skinned mesh follows its joints, and
 * the matrix of its own node is ignored (glTF 2.0, 3.7.3.3): such a node is not judged. Morph
 * targets that turn the surface and not its normals, that cancel normals, that have normals where
 * the mesh has none. */
#include "check/rules/rules.h"
#include "core/face/face.h"
#include <math.h>
#include <string.h>

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

static node_judgement begin_judgement(
    check_run *run, const char *where, const char *label, const char *ignore) {
    node_judgement j = {.run = run, .place = {run->next_order++, where ? where : "", label}};
    memcpy(j.rules, run->rules, sizeof j.rules);
    norma_check_silence(j.rules, ignore);
    return j;
}

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
    node_judgement j = begin_judgement(run, node->where, label, node->ignore);
    node_sums sums = {0};
    j.node = node;
    j.has_worlds = world_of != NULL;
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
    const node_judgement j = begin_judgement(run, skin->where, label, skin->ignore);
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

/* ---- N901 to N903: morph targets */

static const double BENDS_DEG = 5, BENDS_MUCH_DEG = 30, CANCELS = 0.1, NO_LENGTH = 1e-6,
                    DEGENERATE = 1e-6;

static inline double greater_square(double a, double b) { return a > b ? a : b; }

/* ---- N901 */

static void moved_position(
    const check_mesh *m, const norma_vec3_view *deltas, uint32_t v, double p[3]) {
    double delta[3];
    norma_core_position(&m->mesh, v, p);
    norma_view_read(deltas, v, delta);
    for (int k = 0; k < 3; ++k) p[k] += delta[k];
}

static int moves(const check_mesh *m, const norma_vec3_view *deltas, size_t face) {
    double delta[3];
    for (size_t c = norma_core_face_begin(&m->mesh, face); c < norma_core_face_end(&m->mesh, face);
         ++c) {
        norma_view_read(deltas, norma_core_corner(&m->mesh, c), delta);
        if (delta[0] != 0 || delta[1] != 0 || delta[2] != 0) return 1;
    }
    return 0;
}

/* A normal of the moved face; 0 where it has become degenerate. */
static int moved_normal(
    const check_mesh *m, const norma_vec3_view *deltas, size_t face, double normal[3]) {
    size_t begin = norma_core_face_begin(&m->mesh, face), end = norma_core_face_end(&m->mesh, face);
    double first[3], before[3], p[3], longest = 0;
    moved_position(m, deltas, norma_core_corner(&m->mesh, begin), first);
    memset(before, 0, sizeof before);
    memset(normal, 0, 3 * sizeof *normal);
    for (size_t c = begin + 1; c < end; ++c) {
        double edge[3];
        moved_position(m, deltas, norma_core_corner(&m->mesh, c), p);
        norma_core_subtract(p, first, edge);
        longest = greater_square(longest, norma_core_dot(edge, edge));
        if (c > begin + 1) {
            double between[3];
            norma_core_subtract(edge, before, between);
            longest = greater_square(longest, norma_core_dot(between, between));
            normal[0] += before[1] * edge[2] - before[2] * edge[1];
            normal[1] += before[2] * edge[0] - before[0] * edge[2];
            normal[2] += before[0] * edge[1] - before[1] * edge[0];
        }
        memcpy(before, edge, sizeof before);
    }
    double twice_area = norma_core_length(normal);
    return twice_area > DEGENERATE * longest && isfinite(twice_area);
}

/* 0 where it is no more than BENDS_DEG. */
static double bend_of_face_deg(const check_mesh *m, const norma_vec3_view *deltas, size_t face) {
    static const double tangent = 0.08748866352592401; /* of BENDS_DEG */
    const check_face *at_rest = &m->faces[face];
    double moved[3];
    if (!norma_check_directed(at_rest) || !moves(m, deltas, face) ||
        !moved_normal(m, deltas, face, moved))
        return 0;
    const double n[3] = {
        (double)at_rest->normal[0], (double)at_rest->normal[1], (double)at_rest->normal[2]};
    const double cross[3] = {n[1] * moved[2] - n[2] * moved[1], n[2] * moved[0] - n[0] * moved[2],
        n[0] * moved[1] - n[1] * moved[0]};
    double sine = norma_core_length(cross), cosine = norma_core_dot(n, moved);
    return cosine > 0 && sine <= tangent * cosine
               ? 0
               : norma_core_angle(sine, cosine) * (180 / 3.141592653589793);
}

enum { FACES_IN_BLOCK = 1 << 13 };

typedef struct bend_pass {
    const check_mesh *m;
    const norma_vec3_view *deltas;
} bend_pass;

static void judge_bends(const void *context, check_sum *part, size_t begin, size_t end) {
    const bend_pass *pass = context;
    for (size_t f = begin; f < end; ++f) {
        double bend = bend_of_face_deg(pass->m, pass->deltas, f);
        if (bend > BENDS_DEG)
            norma_check_hit(pass->m->run, &part->hits[0], bend, norma_check_face(f));
    }
}

static norma_result judge_targets(check_mesh *m) {
    check_sum sum = {.twice_area = 0};
    check_hits *hits = &sum.hits[0];
    size_t targets = 0;
    norma_result result = norma_check_faces(m);
    for (size_t t = 0; t < m->given->morph_count && !result; ++t) {
        const norma_morph_data *morph = &m->given->morphs[t];
        const bend_pass pass = {m, &morph->positions};
        const size_t before = hits->count;
        if (morph->normals.count || morph->positions.count < m->mesh.positions.count) continue;
        result = norma_check_gather(
            m->run, m->mesh.face_count, FACES_IN_BLOCK, judge_bends, &pass, &sum);
        targets += hits->count > before;
    }
    if (result) {
        norma_check_sum_free(&sum);
        return result;
    }
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N901,
            .severity = hits->worst > BENDS_MUCH_DEG ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO,
            .unit = "deg",
            .hits = hits},
        "the moved surface is shaded as if it had not moved: %z of %z morph targets turn faces "
        "(by up to %g degrees) but have no normals",
        targets, m->given->morph_count, hits->worst);
}

/* ---- N902 */

static norma_result judge_sums(check_mesh *m) {
    check_hits hits = {.least = 1};
    size_t normals = norma_check_normal_count(m);
    for (size_t t = 0; t < m->given->morph_count; ++t) {
        const norma_vec3_view *deltas = &m->given->morphs[t].normals;
        for (size_t v = 0; v < deltas->count && v < normals; ++v) {
            double n[3], delta[3];
            norma_check_normal(m, v, n);
            norma_view_read(deltas, v, delta);
            if (!(norma_core_length(n) >= NO_LENGTH)) /* already none: N101, N102 */
                continue;
            for (int k = 0; k < 3; ++k) n[k] += delta[k];
            if (norma_core_length(n) < CANCELS)
                norma_check_hit(m->run, &hits, norma_core_length(n), norma_check_vertex(v));
        }
    }
    if (!hits.count) return NORMA_OK;
    return norma_check_report(m,
        &(check_finding){
            .rule = RULE_N902, .severity = NORMA_SEVERITY_WARNING, .unit = "length", .hits = &hits},
        "spots and sparks: %z normal%s reduced to less than a tenth by a morph target at weight 1 "
        "(to %g)",
        hits.count, norma_check_plural(hits.count), hits.worst);
}

/* ---- N903 */

static norma_result judge_bases(check_mesh *m) {
    size_t normals = 0, tangents = 0;
    for (size_t t = 0; t < m->given->morph_count; ++t) {
        normals +=
            m->given->morphs[t].normals.count && m->given->info.normals == NORMA_NORMALS_NONE;
        tangents += m->given->morphs[t].tangents.count && !m->given->attributes.tangents &&
                    !m->given->info.has_tangents;
    }
    if (!normals && !tangents) return NORMA_OK;
    return norma_check_report_one(m, RULE_N903, NORMA_SEVERITY_ERROR, NAN,
        "refused by validators: %z morph target%s with %s to add to those of the mesh, which has "
        "none",
        normals ? normals : tangents, norma_check_plural(normals ? normals : tangents),
        normals ? "normals" : "tangents");
}

norma_result norma_check_morphs(check_mesh *m) {
    if (!m->given->morph_count || !m->given->morphs) return NORMA_OK;
    int lit = norma_check_normal_count(m) > 0 && !m->given->material.unlit;
    norma_result result = lit && norma_check_wants(m, RULE_N901) ? judge_targets(m) : NORMA_OK;
    if (!result && norma_check_wants(m, RULE_N902) &&
        m->given->info.normals == NORMA_NORMALS_PER_VERTEX)
        result = judge_sums(m);
    return !result && norma_check_wants(m, RULE_N903) ? judge_bases(m) : result;
}
