/* skins.c: skins, and the animations that move their joints. */
#include "io/gltf/gltf.h"
#include "core/matrix/matrix.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What an animation does to the rotations and scales of nodes, at any time. Translations and
 * weights are no matter here. */
typedef struct gltf_channel {
    uint32_t node;
    int scales; /* 1: scale, three numbers; 0: rotation, a quaternion */
    enum { GLTF_LINEAR, GLTF_STEP, GLTF_CUBIC } interpolation;
    const float *times, *values; /* cubic: in-tangent, value, out-tangent for each time */
    size_t count;                /* of times; at least one */
} gltf_channel;

typedef struct gltf_animation {
    gltf_channel *channels;
    size_t count;
} gltf_animation;

/* ---- Channels of rotations and scales, and their values between keys (glTF 2.0, appendix
 * C: step, linear, spherical linear, cubic spline). */

static norma_document_result read_animation_sampler(
    gltf *g, uint32_t sampler, gltf_channel *channel, norma_document_error *error) {
    const json *j = &g->json;
    uint32_t input = GLTF_NONE, output = GLTF_NONE,
             kind = norma_json_member(j, sampler, "interpolation");
    if (!norma_gltf_index_member(g, sampler, "input", g->accessor_count, &input) ||
        !norma_gltf_index_member(g, sampler, "output", g->accessor_count, &output) ||
        input == GLTF_NONE || output == GLTF_NONE)
        return norma_gltf_malformed(
            g, error, sampler, "the numbers of existing accessors in \"input\" and \"output\"");
    channel->interpolation = norma_json_equals(j, kind, "STEP")          ? GLTF_STEP
                             : norma_json_equals(j, kind, "CUBICSPLINE") ? GLTF_CUBIC
                                                                         : GLTF_LINEAR;
    channel->count = g->accessors[input].count;
    if (g->accessors[output].count / (channel->interpolation == GLTF_CUBIC ? 3 : 1) <
        channel->count)
        return norma_gltf_malformed(g, error, sampler, "as many values as times");
    norma_document_result result = norma_gltf_decode(g, input, 1, &channel->times, error);
    return result ? result
                  : norma_gltf_decode(g, output, channel->scales ? 3 : 4, &channel->values, error);
}

/* 0: a channel of no matter here. */
static int is_channel_wanted(const gltf *g, uint32_t target, gltf_channel *channel) {
    const json *j = &g->json;
    uint32_t path = norma_json_member(j, target, "path");
    channel->node = GLTF_NONE;
    channel->scales = norma_json_equals(j, path, "scale");
    return (channel->scales || norma_json_equals(j, path, "rotation")) &&
           norma_gltf_index_member(g, target, "node", g->node_count, &channel->node) &&
           channel->node != GLTF_NONE;
}

static norma_document_result read_animation(
    gltf *g, uint32_t token, gltf_animation *animation, norma_document_error *error) {
    const json *j = &g->json;
    uint32_t channels = norma_json_member(j, token, "channels"),
             samplers = norma_json_member(j, token, "samplers");
    uint32_t count = norma_json_is(j, channels, JSON_ARRAY) ? norma_json_size(j, channels) : 0,
             sampler_count = norma_json_size(j, samplers), at = 0;
    *animation = (gltf_animation){
        .channels = norma_scene_allocate(g->document->scene, count, sizeof *animation->channels)};
    uint32_t *tokens = norma_scene_allocate(g->document->scene, sampler_count, sizeof *tokens);
    if (!animation->channels || !tokens) return norma_document_fail_memory(g->document, error);
    for (uint32_t sampler = JSON_NONE; norma_json_each(j, samplers, &sampler);)
        tokens[at++] = sampler;
    for (uint32_t item = JSON_NONE; count && norma_json_each(j, channels, &item);) {
        gltf_channel *channel = &animation->channels[animation->count];
        uint32_t sampler = GLTF_NONE;
        if (!is_channel_wanted(g, norma_json_member(j, item, "target"), channel)) continue;
        if (!norma_gltf_index_member(g, item, "sampler", sampler_count, &sampler) ||
            sampler == GLTF_NONE)
            return norma_gltf_malformed(g, error, item, "the number of an existing sampler");
        norma_document_result result = read_animation_sampler(g, tokens[sampler], channel, error);
        if (result) return result;
        ++animation->count;
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_animations(
    gltf *g, gltf_scene *scene, norma_document_error *error) {
    uint32_t list = norma_json_member(&g->json, 0, "animations"),
             count = norma_json_size(&g->json, list), number = 0;
    gltf_animation *made = norma_scene_allocate(g->document->scene, count, sizeof *made);
    norma_document_result result =
        made ? NORMA_DOCUMENT_OK : norma_document_fail_memory(g->document, error);
    for (uint32_t item = JSON_NONE; !result && norma_json_each(&g->json, list, &item);)
        result = read_animation(g, item, &made[number++], error);
    if (!result) {
        scene->animations = made;
        scene->animation_count = count;
    }
    return result;
}

static norma_document_result gltf_animations(
    gltf *g, gltf_scene *scene, norma_document_error *error) {
    norma_document_error *first = NULL;
    if (scene->animations) return NORMA_DOCUMENT_OK;
    if (!scene->animation_error) {
        first = norma_scene_allocate(g->document->scene, 1, sizeof *first);
        if (!first) return norma_document_fail_memory(g->document, error);
        if (!read_animations(g, scene, first)) return NORMA_DOCUMENT_OK;
        scene->animation_error = first;
    }
    if (error) *error = *scene->animation_error;
    return scene->animation_error->result;
}

/* ---- between keys */

static void normalise_rotation(double q[4]) {
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4 && length > 0; ++k) q[k] /= length;
}

static void slerp(const float *a, const float *b, double t, double out[4]) {
    double dot = 0;
    for (int k = 0; k < 4; ++k) dot += (double)a[k] * (double)b[k];
    double sign = dot < 0 ? -1 : 1, cosine = fmin(fabs(dot), 1),
           s = sqrt((1 - cosine) * (1 + cosine)), angle = norma_core_angle(s, cosine);
    double u = s > 1e-6 ? norma_gltf_sine((1 - t) * angle) / s : 1 - t,
           v = s > 1e-6 ? norma_gltf_sine(t * angle) / s : t;
    for (int k = 0; k < 4; ++k) out[k] = u * (double)a[k] + sign * v * (double)b[k];
}

static void cubic(const float *keys, size_t width, double step, double t, double *out) {
    const float *value = keys + width, *leaving = keys + 2 * width, *arriving = keys + 3 * width,
                *next = keys + 4 * width;
    double t2 = t * t, t3 = t2 * t;
    for (size_t k = 0; k < width; ++k)
        out[k] = (2 * t3 - 3 * t2 + 1) * (double)value[k] +
                 step * (t3 - 2 * t2 + t) * (double)leaving[k] +
                 (3 * t2 - 2 * t3) * (double)next[k] + step * (t3 - t2) * (double)arriving[k];
}

/* The last key at or before time; the first if time is before all keys. */
static size_t key_before(const gltf_channel *c, double time) {
    size_t low = 0, high = c->count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if ((double)c->times[middle] <= time)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* All of the file, in scene->animations, read once. Fails for what glTF does not allow, each time
 * in the same words. */
static void gltf_channel_at(const gltf_channel *c, double time, double out[4]) {
    size_t width = c->scales ? 3 : 4, stride = c->interpolation == GLTF_CUBIC ? 3 * width : width,
           key = key_before(c, time);
    const float *at = c->values + key * stride,
                *value = at + (c->interpolation == GLTF_CUBIC ? width : 0);
    double from = (double)c->times[key],
           step = key + 1 < c->count ? (double)c->times[key + 1] - from : 0;
    double t = step > 0 ? fmin(fmax((time - from) / step, 0), 1) : 0;
    for (size_t k = 0; k < width; ++k) out[k] = (double)value[k];
    if (t > 0 && c->interpolation == GLTF_CUBIC)
        cubic(at, width, step, t, out);
    else if (t > 0 && c->interpolation == GLTF_LINEAR && c->scales)
        for (size_t k = 0; k < width; ++k) out[k] += t * ((double)at[width + k] - out[k]);
    else if (t > 0 && c->interpolation == GLTF_LINEAR)
        slerp(at, at + width, t, out);
    if (!c->scales) normalise_rotation(out);
}

/* ---- Skins: how far from a uniform scale the world matrix of a joint ever is, at rest and in
 * every key of an animation that scales it or a node above it. Uniform scales and rotations keep a
 * uniform matrix uniform: an animation without a key that scales differently along the axes changes
 * nothing, and is not played. */

typedef struct pose {
    gltf *g;
    gltf_scene *scene;
    uint32_t *joints;
    size_t joint_count;
    norma_skin_info *info;
    const gltf_channel **rotation,
        **scale;         /* of each node in the animation that is played; NULL: at rest */
    double (*world)[16]; /* of each node; its translation means nothing where a channel moves it */
    size_t *stamp;       /* of each node: the time that its world is of, from 1 */
    uint32_t *chain;
    double *times;
    /* while errors of normals are measured */
    int is_measuring;
    size_t *effort; /* what was spent, of all skins */
    uint32_t index, skin;
    float *matrices; /* sixteen for each joint: from the mesh, as it was bound */
    gltf_array inverse;
    int has_inverse;
    size_t animation;
    double time;
} pose;

static norma_document_result fail_skin(const pose *p, norma_document_error *error) {
    return norma_document_fail_memory(p->g->document, error);
}

/* ---- anisotropy */

static void judge_joint(pose *p, const double world[16], uint32_t joint) {
    double scaled[9], values[3], vectors[9], largest = 0, anisotropy = INFINITY;
    for (int i = 0; i < 9; ++i) largest = fmax(largest, fabs(world[4 * (i / 3) + i % 3]));
    if (largest > 0 && isfinite(largest)) {
        for (int i = 0; i < 9; ++i) scaled[i] = world[4 * (i / 3) + i % 3] / largest;
        norma_singular_values(scaled, values, vectors);
        double most = fmax(values[0], fmax(values[1], values[2])),
               least = fmin(values[0], fmin(values[1], values[2]));
        anisotropy = least > 1e-6 * most ? most / least : INFINITY;
    }
    if (p->info->joint == SIZE_MAX || anisotropy > p->info->anisotropy) {
        p->info->anisotropy = anisotropy;
        p->info->joint = joint;
    }
}

/* ---- a moment of an animation */

static void read_rest(const gltf *g, uint32_t node, const char *key, size_t count, double *out) {
    const json *j = &g->json;
    uint32_t list = norma_json_member(j, g->nodes[node].token, key);
    size_t i = 0;
    for (uint32_t item = JSON_NONE; i < count && norma_json_each(j, list, &item);)
        norma_json_number(j, item, &out[i++]);
}

static void local_at(const pose *p, uint32_t node, double time, double local[16]) {
    gltf_trs trs = {{0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1}};
    double value[4];
    if (!p->rotation[node] && !p->scale[node]) {
        memcpy(local, p->g->nodes[node].local, sizeof p->g->nodes[node].local);
        return;
    }
    read_rest(p->g, node, "rotation", 4, trs.rotation);
    read_rest(p->g, node, "scale", 3, trs.scale);
    if (p->rotation[node]) gltf_channel_at(p->rotation[node], time, trs.rotation);
    if (p->scale[node]) {
        gltf_channel_at(p->scale[node], time, value);
        memcpy(trs.scale, value, sizeof trs.scale);
    }
    norma_gltf_matrix_compose(&trs, local);
}

/* How many nodes were visited. */
static size_t play(pose *p, double time, size_t stamp) {
    size_t visited = p->joint_count;
    for (size_t i = 0; i < p->joint_count; ++i) {
        size_t depth = 0;
        for (uint32_t at = p->joints[i]; at != GLTF_NONE && p->stamp[at] != stamp;
             at = p->g->nodes[at].parent)
            p->chain[depth++] = at;
        visited += depth;
        while (depth-- > 0) {
            uint32_t node = p->chain[depth], parent = p->g->nodes[node].parent;
            local_at(p, node, time, p->world[node]);
            if (parent != GLTF_NONE)
                norma_gltf_matrix_multiply(p->world[parent], p->world[node], p->world[node]);
            p->stamp[node] = stamp;
        }
        if (!p->is_measuring) judge_joint(p, p->world[p->joints[i]], p->joints[i]);
    }
    return visited;
}

/* ---- an animation */

static int is_uneven(const gltf_channel *channel) {
    size_t width = channel->interpolation == GLTF_CUBIC ? 9 : 3,
           value = channel->interpolation == GLTF_CUBIC ? 3 : 0;
    for (size_t i = 0; i < channel->count; ++i) {
        const float *s = channel->values + i * width + value;
        float most = fmaxf(fabsf(s[0]), fmaxf(fabsf(s[1]), fabsf(s[2]))),
              least = fminf(fabsf(s[0]), fminf(fabsf(s[1]), fabsf(s[2])));
        if (!(most <= least * 1.001F)) return 1;
    }
    return 0;
}

static int compare_times(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Every moment of a channel that scales a node at or above a joint, once; measuring, of one that
 * turns it as well. */
static size_t collect_times(pose *p, const gltf_animation *animation) {
    size_t count = 0, kept = 0;
    for (size_t i = 0; i < animation->count; ++i)
        for (size_t k = 0;
             (p->is_measuring || animation->channels[i].scales) &&
             p->stamp[animation->channels[i].node] && k < animation->channels[i].count;
             ++k)
            p->times[count++] = (double)animation->channels[i].times[k];
    qsort(p->times, count, sizeof *p->times, compare_times);
    for (size_t i = 0; i < count; ++i)
        if (kept == 0 || p->times[i] > p->times[kept - 1]) p->times[kept++] = p->times[i];
    return kept;
}

static size_t most_effort(const pose *p) {
    const size_t held = p->g->held < (size_t)1 << 22 ? p->g->held : (size_t)1 << 22;
    return ((size_t)1 << 24) + 64 * held;
}

/* A small file can ask for any number of skins under any number of animations of any number of keys
 * that share their bytes: it gets no more time than its size is worth. */
static norma_document_result spend(const pose *p, size_t steps, norma_document_error *error) {
    const size_t most = most_effort(p);
    *p->effort = steps < most - *p->effort ? *p->effort + steps : most;
    if (*p->effort < most) return NORMA_DOCUMENT_OK;
    return norma_document_fail(p->g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
        p->info->where, "it has more joints and animation keys than this version examines");
}

static norma_document_result take_channels(pose *p, const gltf_animation *animation, int *uneven,
    size_t *times, norma_document_error *error) {
    gltf *g = p->g;
    norma_document_result result = spend(p, g->node_count + animation->count, error);
    *uneven = 0;
    *times = 0;
    if (result) return result;
    memset(p->rotation, 0, g->node_count * sizeof *p->rotation);
    memset(p->scale, 0, g->node_count * sizeof *p->scale);
    for (size_t i = 0; !result && i < animation->count; ++i) {
        const gltf_channel *channel = &animation->channels[i];
        *(channel->scales ? &p->scale[channel->node] : &p->rotation[channel->node]) = channel;
        if (!(channel->scales || p->is_measuring) || !p->stamp[channel->node]) continue;
        result = spend(p, 16 * channel->count, error); /* they will be sorted */
        *uneven |= !result && channel->scales && is_uneven(channel);
        *times += channel->count;
    }
    return result;
}

/* What playing takes, for the first animation. */
static norma_document_result allocate_pose(pose *p, norma_document_error *error) {
    size_t count = p->g->node_count;
    if (p->rotation) return NORMA_DOCUMENT_OK;
    p->rotation = norma_io_allocate(count, sizeof *p->rotation);
    p->scale = norma_io_allocate(count, sizeof *p->scale);
    p->world = norma_io_allocate(count, sizeof *p->world);
    p->stamp = norma_io_allocate(count, sizeof *p->stamp);
    p->chain = norma_io_allocate(count, sizeof *p->chain);
    return p->rotation && p->scale && p->world && p->stamp && p->chain ? NORMA_DOCUMENT_OK
                                                                       : fail_skin(p, error);
}

/* Marks each joint and all nodes above it. */
static void mark_chains(pose *p) {
    memset(p->stamp, 0, p->g->node_count * sizeof *p->stamp);
    for (size_t i = 0; i < p->joint_count; ++i)
        for (uint32_t at = p->joints[i]; at != GLTF_NONE && !p->stamp[at];
             at = p->g->nodes[at].parent)
            p->stamp[at] = 1;
}

/* ---- Errors of normals: many skinning shaders take them through the blended matrix itself, which
 * is right only where that scales evenly. Each vertex of each mesh that the skin moves, at rest and
 * in every key of an animation that scales or turns a joint or a node above one. */

enum { EFFORT_OF_VERTEX = 64 };
static const double MEASURED_FROM = 1.05;

/* The largest angle between the normals through the blended matrix, moved as positions are, and the
 * right ones. */
static void measure_angles(
    pose *p, uint32_t primitive, const float *through, const float *right, size_t count) {
    norma_skin_info *info = p->info;
    for (size_t i = 0; i < count; ++i) {
        double a[3], b[3], cross[3];
        for (size_t k = 0; k < 3; ++k) {
            a[k] = (double)through[3 * i + k];
            b[k] = (double)right[3 * i + k];
        }
        norma_core_cross(a, b, cross);
        const double sine = sqrt(norma_core_dot(cross, cross)), cosine = norma_core_dot(a, b);
        if (!(sine > 0 || cosine > 0 || cosine < 0) || !isfinite(sine) || !isfinite(cosine))
            continue;
        const double angle = norma_core_angle(sine, cosine);
        if (angle <= info->normal_error_rad) continue;
        info->normal_error_rad = angle;
        info->error_mesh = primitive;
        info->error_vertex = i;
        info->error_animation = p->animation;
        info->error_time_s = p->time;
    }
}

static norma_document_result measure_primitive(
    pose *p, uint32_t primitive, norma_document_error *error) {
    gltf *g = p->g;
    const uint32_t normal = g->primitives[primitive].base.normal;
    norma_skin skin = {.matrices = p->matrices, .joint_count = p->joint_count};
    norma_vec3_view normals = {.count = g->accessors[normal].count};
    const float *stored = NULL;
    norma_document_result result =
        spend(p, EFFORT_OF_VERTEX * g->primitives[primitive].vertices, error);
    if (!result) result = norma_gltf_decode(g, normal, 3, &stored, error);
    if (!result) result = norma_gltf_read_influences(g, primitive, &skin, error);
    if (skin.vertex_count > normals.count) skin.vertex_count = normals.count;
    const size_t count = skin.vertex_count;
    float *moved = result ? NULL : norma_io_allocate(count, 6 * sizeof *moved);
    normals.data = stored;
    if (!moved && !result) result = fail_skin(p, error);
    norma_result blended =
        result ? NORMA_ERROR_ARGUMENT : norma_skin_positions(&skin, normals, NULL, moved, count);
    if (!blended)
        blended = norma_skin_normals(&skin, normals, NULL, moved + 3 * count, count, NULL);
    if (!blended) measure_angles(p, primitive, moved, moved + 3 * count, count);
    if (blended == NORMA_ERROR_MEMORY) result = fail_skin(p, error);
    if (blended == NORMA_ERROR_INDEX)
        result = norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED,
            g->primitives[primitive].where, "a vertex names a joint that its skin, of %zu, lacks",
            p->joint_count);
    free(moved);
    norma_gltf_free_influences(g, primitive, &skin);
    return result;
}

/* Each primitive that the skin moves and that has normals is measured; or, where vertices is not
 * NULL, its vertices are added to that. */
static norma_document_result visit_skinned(pose *p, size_t *vertices, norma_document_error *error) {
    const gltf *g = p->g;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t i = 0; i < g->drawing_count; ++i) {
        const gltf_node *node = &g->nodes[g->drawing[i]];
        const gltf_mesh *mesh = &g->meshes[node->mesh];
        for (uint32_t k = 0; node->skin == p->index && k < mesh->primitive_count && !result; ++k) {
            const gltf_primitive *of = &g->primitives[mesh->first_primitive + k];
            if (of->not_read || of->base.normal == GLTF_NONE) continue;
            if (vertices)
                *vertices += of->vertices;
            else
                result = measure_primitive(p, mesh->first_primitive + k, error);
        }
    }
    return result;
}

static norma_document_result measure_moment(pose *p, norma_document_error *error) {
    for (size_t j = 0; j < p->joint_count; ++j) {
        const uint32_t joint = p->joints[j];
        double bound[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, matrix[16];
        if (p->has_inverse) norma_gltf_doubles(&p->inverse, j, bound);
        norma_gltf_matrix_multiply(
            p->animation == SIZE_MAX ? p->g->nodes[joint].world : p->world[joint], bound, matrix);
        for (int i = 0; i < 16; ++i)
            p->matrices[16 * j + (size_t)i] = i < 12 ? (float)matrix[i] : 0;
    }
    return visit_skinned(p, NULL, error);
}

/* ---- An animation at each of its moments: the joints are judged or, as far as time lasts, the
 * normals of the vertices measured. */

static norma_document_result play_animation(
    pose *p, const gltf_animation *animation, size_t vertices, norma_document_error *error) {
    int uneven;
    size_t times, step = 1;
    norma_document_result result = take_channels(p, animation, &uneven, &times, error);
    if (result || !(p->is_measuring ? times > 0 : uneven)) return result;
    p->times = norma_io_allocate(times, sizeof *p->times);
    if (!p->times) return fail_skin(p, error);
    times = collect_times(p, animation);
    if (p->is_measuring) {
        const size_t left = most_effort(p) - *p->effort,
                     of_key =
                         EFFORT_OF_VERTEX * vertices + 16 * (p->g->node_count + p->joint_count),
                     room = left / 2 / of_key;
        step = room ? (times + room - 1) / room : 0;
        p->info->keys += times;
    }
    memset(p->stamp, 0, p->g->node_count * sizeof *p->stamp);
    for (size_t i = 0; !result && step && i < times; i += step) {
        p->time = p->times[i];
        result = spend(p, 8 * play(p, p->time, i + 1), error);
        if (!result && p->is_measuring) result = measure_moment(p, error);
        if (p->is_measuring) p->info->examined_keys += !result;
    }
    free(p->times);
    return result;
}

static norma_document_result play_animations(
    pose *p, size_t vertices, norma_document_error *error) {
    norma_document_result result = gltf_animations(p->g, p->scene, error);
    for (uint32_t i = 0; !result && i < p->scene->animation_count; ++i) {
        p->animation = i;
        result = spend(p, p->g->node_count + p->joint_count, error);
        if (!result) result = allocate_pose(p, error);
        if (result) break;
        mark_chains(p);
        result = play_animation(p, &p->scene->animations[i], vertices, error);
    }
    return result;
}

static norma_document_result measure_animations(pose *p, norma_document_error *error) {
    size_t vertices = 0;
    norma_document_result result = visit_skinned(p, &vertices, error);
    if (!result && vertices) result = spend(p, EFFORT_OF_VERTEX * vertices, error);
    if (result || !vertices) return result;
    result =
        norma_gltf_read_inverse(p->g, p->skin, p->joint_count, &p->inverse, &p->has_inverse, error);
    if (!result) result = norma_gltf_spend(p->g, p->skin, p->joint_count, 64, error);
    p->matrices = result ? NULL : norma_io_allocate(p->joint_count, 16 * sizeof *p->matrices);
    if (!p->matrices) return result ? result : fail_skin(p, error);
    p->animation = SIZE_MAX;
    p->time = 0;
    result = measure_moment(p, error);
    if (!result) result = play_animations(p, vertices, error);
    free(p->matrices);
    return result;
}

/* What cannot be measured, others say: weights that are not there, too many vertices. */
static norma_document_result measure_errors(pose *p, norma_document_error *error) {
    norma_document_error why;
    if (!(p->info->anisotropy > MEASURED_FROM)) return NORMA_DOCUMENT_OK;
    p->is_measuring = 1;
    p->effort = &p->scene->measured;
    p->info->normal_error_rad = -1;
    const norma_document_result result = measure_animations(p, &why);
    if (p->info->normal_error_rad < 0) p->info->normal_error_rad = NAN;
    if (result == NORMA_DOCUMENT_ERROR_MEMORY && error) *error = why;
    return result == NORMA_DOCUMENT_ERROR_MEMORY ? result : NORMA_DOCUMENT_OK;
}

/* ---- a skin */

static norma_document_result make_skin(
    gltf *g, size_t index, norma_skin_info *info, norma_document_error *error) {
    gltf_scene *scene = norma_gltf_scene_of(g);
    if (!scene) return norma_document_fail_memory(g->document, error);
    const uint32_t token = scene->skins[index];
    pose p = {.g = g,
        .scene = scene,
        .info = info,
        .effort = &scene->effort,
        .index = (uint32_t)index,
        .skin = token};
    *info = (norma_skin_info){.joint = SIZE_MAX, .normal_error_rad = NAN};
    info->name = norma_gltf_name(g, token);
    info->where = norma_gltf_where(g, "skins", index);
    info->ignore = norma_gltf_root_ignore(g);
    norma_document_result result =
        info->name && info->where && info->ignore
            ? norma_gltf_read_joints(g, token, &p.joints, &p.joint_count, error)
            : fail_skin(&p, error);
    info->joint_count = p.joint_count;
    if (!result) {
        for (size_t i = 0; i < p.joint_count; ++i)
            judge_joint(&p, g->nodes[p.joints[i]].world, p.joints[i]);
        result = play_animations(&p, 0, error);
    }
    if (!result) result = measure_errors(&p, error);
    void *const blocks[] = {
        p.joints, (void *)p.rotation, (void *)p.scale, p.world, p.stamp, p.chain};
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; ++i) free(blocks[i]);
    return result;
}

size_t norma_gltf_skin_count(const norma_document *document) {
    return norma_gltf_of(document)->skin_count;
}

norma_document_result norma_gltf_skin(
    norma_document *document, size_t index, norma_skin_info *info, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    norma_scene *scene = document->scene;
    if (!scene->skins && !(scene->skins = norma_scene_allocate(
                               scene, norma_gltf_skin_count(document), sizeof *scene->skins)))
        return norma_document_fail_memory(document, error);
    if (!scene->skins[index]) {
        norma_skin_info *made = norma_scene_allocate(scene, 1, sizeof *made);
        norma_document_result result =
            made ? make_skin(g, index, made, error) : norma_document_fail_memory(document, error);
        if (result) return result;
        scene->skins[index] = made;
    }
    *info = *scene->skins[index];
    return NORMA_DOCUMENT_OK;
}
