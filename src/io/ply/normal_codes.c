/* normal_codes.c: normals as whole numbers: in which types they are stored, and the codes for unit
 * vectors. */
#include "io/ply/ply.h"
#include <stdlib.h>

double norma_ply_normal_scale(
    const ply_header *header, const ply_element *element, const int properties[3]) {
    ply_type first = norma_ply_property(header, element, properties[0])->type;
    for (int axis = 1; axis < 3; ++axis)
        if (norma_ply_property(header, element, properties[axis])->type != first) return 1;
    return first == PLY_INT8 ? 127 : first == PLY_INT16 ? 32767 : 1;
}

void norma_ply_normal_types(const ply_header *header, const ply_element *element,
    const int properties[3], ply_type types[3]) {
    const double scale = norma_ply_normal_scale(header, element, properties);
    for (int axis = 0; axis < 3; ++axis) {
        const ply_type stored = norma_ply_property(header, element, properties[axis])->type;
        types[axis] = stored >= PLY_FLOAT || scale > 1 ? stored : PLY_FLOAT;
    }
}

norma_document_result norma_ply_encode_normals(norma_document *document, const ply_type types[3],
    float *normals, size_t count, norma_document_error *error) {
    if (types[0] >= PLY_FLOAT || count == 0) return NORMA_DOCUMENT_OK;
    const norma_vec3_view view = {.data = normals, .count = count, .format = NORMA_FORMAT_FLOAT};
    const int narrow = types[0] == PLY_INT8;
    int8_t *bytes = narrow ? norma_io_allocate(3 * count, sizeof *bytes) : NULL;
    int16_t *shorts = narrow ? NULL : norma_io_allocate(3 * count, sizeof *shorts);
    if (!bytes && !shorts) return norma_document_fail_memory(document, error);
    norma_result result = narrow ? norma_encode_snorm8(view, bytes, 0, count)
                                 : norma_encode_snorm16(view, shorts, 0, count);
    for (size_t i = 0; i < 3 * count; ++i) normals[i] = narrow ? (float)bytes[i] : (float)shorts[i];
    free(bytes);
    free(shorts);
    return result ? norma_document_fail_core(document, error, result) : NORMA_DOCUMENT_OK;
}
