/* animation.h: what an animation does to the rotations and scales of nodes, at any time.
 * Translations and weights are no matter here. */
#ifndef NORMA_IO_GLTF_ANIMATION_H
#define NORMA_IO_GLTF_ANIMATION_H
#include "io/gltf/gltf_scene.h"

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

/* All of the file, in scene->animations, read once. Fails for what glTF does not allow, each time
 * in the same words. */
norma_document_result norma_gltf_animations(
    gltf *g, gltf_scene *scene, norma_document_error *error);
void norma_gltf_channel_at(
    const gltf_channel *channel, double time, double out[4]); /* quaternions made unit */
#endif
