/* animation.c: channels of rotations and scales, and their values between keys (glTF 2.0, appendix
 * C: step, linear, spherical linear, cubic spline). */
#include "io/gltf/animation.h"
#include "io/gltf/sine.h"
#include "core/face/triangle.h"
#include <math.h>
#include <string.h>

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
    for (uint32_t sampler = norma_json_first(j, samplers); sampler != JSON_NONE;
         sampler = norma_json_next(j, samplers, sampler))
        tokens[at++] = sampler;
    for (uint32_t item = count ? norma_json_first(j, channels) : JSON_NONE; item != JSON_NONE;
         item = norma_json_next(j, channels, item)) {
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
    for (uint32_t item = norma_json_first(&g->json, list); !result && item != JSON_NONE;
         item = norma_json_next(&g->json, list, item))
        result = read_animation(g, item, &made[number++], error);
    if (!result) {
        scene->animations = made;
        scene->animation_count = count;
    }
    return result;
}

norma_document_result norma_gltf_animations(
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

void norma_gltf_channel_at(const gltf_channel *c, double time, double out[4]) {
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
