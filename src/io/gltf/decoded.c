/* decoded.c: accessors as floats, decoded once. */
#include "io/gltf/gltf_scene.h"

static int is_plain_array(const gltf_array *array, uint32_t width) {
    return array->component == GLTF_FLOAT && array->stride == width * sizeof(float) &&
           (uintptr_t)array->data % sizeof(float) == 0;
}

norma_document_result norma_gltf_decode(
    gltf *g, uint32_t accessor, uint32_t width, const float **floats, norma_document_error *error) {
    gltf_array array;
    gltf_scene *scene = norma_gltf_scene_of(g);
    *floats = NULL;
    if (!scene) return norma_document_fail_memory(g->document, error);
    norma_document_result result = norma_gltf_array(g, accessor, &array, error);
    if (result) return result;
    if (array.width != width)
        return norma_gltf_malformed(g, error, g->accessors[accessor].token,
            width == 2   ? "pairs of numbers"
            : width == 3 ? "vectors of three numbers"
                         : "vectors of four numbers");
    if (is_plain_array(&array, width)) {
        *floats = (const float *)(const void *)array.data;
        return NORMA_DOCUMENT_OK;
    }
    if (!scene->decoded[accessor]) {
        result = norma_gltf_spend(
            g, g->accessors[accessor].token, array.count, width * sizeof(float), error);
        float *copy =
            result ? NULL
                   : norma_scene_allocate(g->document->scene, array.count, width * sizeof *copy);
        if (!copy) return result ? result : norma_document_fail_memory(g->document, error);
        for (size_t i = 0; i < array.count; ++i) norma_gltf_floats(&array, i, copy + width * i);
        scene->decoded[accessor] = copy;
    }
    *floats = scene->decoded[accessor];
    return NORMA_DOCUMENT_OK;
}

int norma_gltf_is_placeholder(const gltf *g, uint32_t accessor) {
    const gltf_accessor *a = &g->accessors[accessor];
    return a->view == GLTF_NONE && a->sparse.count == 0 && a->draco == GLTF_NONE;
}
