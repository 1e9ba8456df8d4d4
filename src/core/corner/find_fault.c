/* find_fault.c: norma_find_fault. The checks are those that every call makes, asked once more with
 * room for what they find. */
#include "core/call/call.h"
#include "core/corner/crease.h"

static norma_result find_wrong_corner(const core_mesh *mesh, norma_fault *fault) {
    for (size_t c = 0; c < mesh->corner_count; c++)
        if (norma_core_corner(mesh, c) >= mesh->positions.count)
            return norma_core_refuse(fault, NORMA_ERROR_INDEX, "mesh->corners", c,
                "the index of a position, below mesh->positions.count");
    return NORMA_OK;
}

norma_result norma_find_fault(const norma_mesh *mesh, const float *crease_angle_rad,
    const norma_options *options, norma_fault *fault) {
    core_mesh checked;
    norma_core_refuse(fault, NORMA_OK, NULL, SIZE_MAX, NULL);
    norma_result result = norma_core_check_options(options, fault);
    if (result == NORMA_OK && crease_angle_rad)
        result = norma_core_check_crease(*crease_angle_rad, fault);
    if (result == NORMA_OK) result = norma_core_check_shape(mesh, &checked, fault);
    if (result == NORMA_OK) result = norma_core_check_face_starts(&checked, fault);
    return result == NORMA_OK ? find_wrong_corner(&checked, fault) : result;
}
