/* new_indices.c: a primitive's new indices. They stay as they are where no corner changed; they
 * widen where added vertices need it, the largest value of each width being no index
 * (glTF 2.0, 3.7.2.1); strips and fans whose corners changed become triangles. */
#include "io/gltf/gltf_compute.h"
#include "io/file/large_memory.h"
#include <stdlib.h>
#include <string.h>

static norma_document_result fail_indices(const gltf_job *job) {
    return norma_document_fail_memory(job->g->document, job->error);
}

static void write_new_index(unsigned char *at, int component, uint32_t value) {
    at[0] = (unsigned char)value;
    if (component != GLTF_UBYTE) at[1] = (unsigned char)(value >> 8);
    if (component == GLTF_UINT) {
        at[2] = (unsigned char)(value >> 16);
        at[3] = (unsigned char)(value >> 24);
    }
}

static int index_component_for(const gltf *g, const gltf_primitive *p, uint32_t largest) {
    int component = p->indices == GLTF_NONE ? GLTF_USHORT : g->accessors[p->indices].component;
    if (component == GLTF_UBYTE && largest >= UINT8_MAX) component = GLTF_USHORT;
    if (component == GLTF_USHORT && largest >= UINT16_MAX) component = GLTF_UINT;
    return component;
}

/* Corners of a triangle list that make no whole triangle stay at its end. */
static size_t left_over(const gltf *g, const gltf_primitive *p) {
    if (p->mode != GLTF_TRIANGLES) return 0;
    return (p->indices == GLTF_NONE ? p->vertices : g->accessors[p->indices].count) - 3 * p->faces;
}

/* Of a strip or fan, what is drawn: triangles that name a vertex twice only lead from one part to
 * the next, and a list needs none. Returns the number of corners. */
static size_t drop_stitches(const uint32_t *old, uint32_t *corners, size_t faces) {
    size_t kept = 0;
    for (size_t f = 0; f < faces; ++f) {
        const uint32_t *of = old + 3 * f;
        if (of[0] == of[1] || of[1] == of[2] || of[2] == of[0]) continue;
        memmove(corners + kept, corners + 3 * f, 3 * sizeof *corners);
        kept += 3;
    }
    return kept ? kept : 3 * faces;
}

/* As the file is to have them, where that is not what they are in memory already. */
static norma_document_result encode_new_indices(
    gltf_job *job, gltf_data *data, const uint32_t *corners, size_t count, const gltf_array *old) {
    const size_t size = norma_gltf_data_size(data);
    data->bytes = norma_io_block(data->count, size);
    if (!data->bytes) return fail_indices(job);
    for (size_t i = 0; i < count; ++i)
        write_new_index(data->bytes + i * size, data->component, corners[i]);
    for (size_t i = count; i < data->count; ++i) {
        uint32_t index = (uint32_t)i;
        if (old->data) norma_gltf_uints(old, i, &index);
        write_new_index(data->bytes + i * size, data->component, index);
    }
    return NORMA_DOCUMENT_OK;
}

static int stores_low_byte_first(void) {
    const uint32_t probe = 1;
    unsigned char first;
    memcpy(&first, &probe, 1);
    return first == 1;
}

/* Takes the corners, which it frees or hands on. */
static norma_document_result put_index_list(
    gltf_job *job, uint32_t number, uint32_t *corners, size_t count, size_t extra) {
    gltf *g = job->g;
    const gltf_primitive *p = &g->primitives[number];
    gltf_array old = {0};
    uint32_t largest = 0;
    norma_document_result result = p->indices == GLTF_NONE
                                       ? NORMA_DOCUMENT_OK
                                       : norma_gltf_array(g, p->indices, &old, job->error);
    if (result) {
        free(corners);
        return result;
    }
    for (size_t i = 0; i < count; ++i) largest = corners[i] > largest ? corners[i] : largest;
    gltf_data data = {.component = index_component_for(g, p, largest),
        .width = 1,
        .count = count + extra,
        .is_indices = 1};
    if (data.component == GLTF_UINT && extra == 0 && stores_low_byte_first()) {
        data.bytes = (unsigned char *)corners;
    } else {
        result = encode_new_indices(job, &data, corners, count, &old);
        free(corners);
    }
    if (result) return result;
    const gltf_slot slot = {.primitive = number, .target = GLTF_SLOT_INDICES};
    uint32_t added = norma_gltf_add_data(g, &data);
    return added != GLTF_NONE && norma_gltf_put(g, &slot, added) ? NORMA_DOCUMENT_OK
                                                                 : fail_indices(job);
}

/* 0, 1, 2, ...: for a primitive without indices whose vertices became more than it draws. */
static norma_document_result put_sequence(gltf_job *job, uint32_t number) {
    const gltf_primitive *p = &job->g->primitives[number];
    uint32_t *corners = norma_io_allocate(p->vertices, sizeof *corners);
    if (!corners) return fail_indices(job);
    for (size_t i = 0; i < p->vertices; ++i) corners[i] = (uint32_t)i;
    return put_index_list(job, number, corners, p->vertices, 0);
}

norma_document_result norma_gltf_put_indices(gltf_job *job, uint32_t number) {
    gltf *g = job->g;
    const gltf_primitive *p = &g->primitives[number];
    const gltf_set *set = &job->sets[job->set_of[number]];
    const uint32_t *old;
    norma_document_result result = norma_gltf_corners(g, number, &old, job->error);
    if (result || set->added_count == 0) return result;
    if (memcmp(old, job->corners[number], 3 * p->faces * sizeof *old) == 0)
        return p->indices == GLTF_NONE ? put_sequence(job, number) : NORMA_DOCUMENT_OK;
    size_t count = 3 * p->faces;
    if (p->mode != GLTF_TRIANGLES) {
        norma_gltf_set_mode(g, 0, number, GLTF_TRIANGLES);
        count = drop_stitches(old, job->corners[number], p->faces);
    }
    uint32_t *corners = job->corners[number];
    job->corners[number] = NULL;
    return put_index_list(job, number, corners, count, left_over(g, p));
}
