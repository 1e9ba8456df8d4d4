/* instances.c: the places where a node draws its mesh again and again (EXT_mesh_gpu_instancing). */
#include "io/gltf/gltf_scene.h"
#include "io/gltf/node_matrix.h"
#include <math.h>

typedef struct instance_attribute {
    uint32_t attributes; /* the object that may name it */
    const char *key;
    uint32_t width;
} instance_attribute;

static norma_document_result read_instance_array(gltf *g, const instance_attribute *attribute,
    size_t count, gltf_array *array, int *has, norma_document_error *error) {
    const uint32_t token = norma_json_member(&g->json, attribute->attributes, attribute->key);
    uint64_t accessor;
    *has = token != JSON_NONE;
    if (!*has) return NORMA_DOCUMENT_OK;
    if (!norma_json_uint(&g->json, token, &accessor) || accessor >= g->accessor_count)
        return norma_gltf_malformed(g, error, token, "the number of an existing accessor");
    const norma_document_result result = norma_gltf_array(g, (uint32_t)accessor, array, error);
    if (result) return result;
    return array->width == attribute->width && array->count >= count &&
                   array->component != GLTF_UINT
               ? NORMA_DOCUMENT_OK
               : norma_gltf_malformed(g, error, token, "one vector for each instance");
}

/* Instances that have no place of their own are as many as the first attribute has elements: those
 * must be there then, or a few bytes would draw a mesh any number of times. */
static norma_document_result read_first(gltf *g, uint32_t attributes, norma_document_error *error) {
    const uint32_t first = norma_json_is(&g->json, attributes, JSON_OBJECT)
                               ? norma_json_first(&g->json, attributes)
                               : JSON_NONE;
    uint64_t accessor;
    gltf_array array;
    if (first == JSON_NONE || !norma_json_uint(&g->json, first, &accessor) ||
        accessor >= g->accessor_count)
        return NORMA_DOCUMENT_OK; /* one instance: node_tree.c */
    return norma_gltf_array(g, (uint32_t)accessor, &array, error);
}

norma_document_result norma_gltf_read_instances(
    gltf *g, uint32_t node, gltf_instances *instances, norma_document_error *error) {
    const uint32_t extensions = norma_json_member(&g->json, g->nodes[node].token, "extensions");
    const uint32_t attributes = norma_json_member(
        &g->json, norma_json_member(&g->json, extensions, "EXT_mesh_gpu_instancing"), "attributes");
    const size_t count = g->nodes[node].instances;
    *instances = (gltf_instances){.attributes = attributes};
    const instance_attribute translation = {attributes, "TRANSLATION", 3},
                             rotation = {attributes, "ROTATION", 4},
                             scale = {attributes, "SCALE", 3};
    norma_document_result result = read_instance_array(
        g, &translation, count, &instances->translation, &instances->has_translation, error);
    if (!result)
        result = read_instance_array(
            g, &rotation, count, &instances->rotation, &instances->has_rotation, error);
    if (!result)
        result =
            read_instance_array(g, &scale, count, &instances->scale, &instances->has_scale, error);
    if (!result && !instances->has_translation && !instances->has_rotation && !instances->has_scale)
        result = read_first(g, attributes, error);
    return result;
}

void norma_gltf_instance_matrix(const gltf_instances *instances, size_t index, double matrix[16]) {
    gltf_trs trs = {{0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1}};
    float f[4];
    if (instances->has_translation) {
        norma_gltf_floats(&instances->translation, index, f);
        for (int k = 0; k < 3; k++) trs.translation[k] = (double)f[k];
    }
    if (instances->has_scale) {
        norma_gltf_floats(&instances->scale, index, f);
        for (int k = 0; k < 3; k++) trs.scale[k] = (double)f[k];
    }
    if (instances->has_rotation) {
        norma_gltf_floats(&instances->rotation, index, f);
        double squares = 0;
        for (int k = 0; k < 4; k++) squares += (double)f[k] * (double)f[k];
        for (int k = 0; k < 4 && squares > 0; k++) trs.rotation[k] = (double)f[k] / sqrt(squares);
    }
    norma_gltf_matrix_compose(&trs, matrix);
}
