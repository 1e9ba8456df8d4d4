/* set_contents.c: what becomes of the attributes that the primitives of a set share. */
#include "io/gltf/gltf_compute.h"
#include "io/file/large_memory.h"
#include "io/file/memory.h"
#include <string.h>

size_t norma_gltf_add_vertex(gltf_set *set, uint32_t vertex) {
    const size_t number = set->vertices + set->added_count;
    uint32_t *added = number >= UINT32_MAX - 1 ? NULL
                                               : norma_io_grow(set->added, &set->added_capacity,
                                                     set->added_count + 1, sizeof *added);
    if (!added) return SIZE_MAX;
    set->added = added;
    set->added[set->added_count++] = vertex;
    return number;
}

norma_document_result norma_gltf_put_in_set(
    gltf_job *job, const gltf_set *set, int32_t target, const char *attribute, gltf_data *data) {
    gltf *g = job->g;
    uint32_t number = norma_gltf_add_data(g, data);
    int ok = number != GLTF_NONE;
    for (uint32_t i = set->lead; ok && i != GLTF_NONE; i = job->next_in_set[i]) {
        const gltf_slot slot = {.primitive = i, .target = target, .attribute = attribute};
        ok = norma_gltf_put(g, &slot, number);
    }
    return ok ? NORMA_DOCUMENT_OK : norma_document_fail_memory(g->document, job->error);
}

norma_document_result norma_gltf_copy_elements(
    gltf_job *job, const gltf_set *set, uint32_t accessor, gltf_data *data) {
    gltf_array array;
    const size_t size = job->g->accessors[accessor].element_size,
                 count = set->vertices + set->added_count;
    norma_document_result result = norma_gltf_array(job->g, accessor, &array, job->error);
    if (result) return result;
    *data = (gltf_data){.component = array.component,
        .normalized = array.normalized,
        .width = array.width,
        .element_size = size,
        .count = count};
    data->bytes = norma_io_block(count, size);
    if (!data->bytes) return norma_document_fail_memory(job->g->document, job->error);
    if (array.stride == size) memcpy(data->bytes, array.data, set->vertices * size);
    for (size_t v = array.stride == size ? set->vertices : 0; v < count; ++v)
        memcpy(data->bytes + v * size, array.data + norma_gltf_old_vertex(set, v) * array.stride,
            size);
    return NORMA_DOCUMENT_OK;
}
