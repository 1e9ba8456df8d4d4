/* mesh.c: what must hold of a mesh before anything is computed or written: first its shape, then what its arrays say. */
#include "mesh.h"
#include <math.h>

static norma_result shape_of_positions(const norma_vec3_view *view)
{
    if (!norma_format_size(view->format)) return NORMA_ERROR_ARGUMENT;
    if (view->count && !view->data) return NORMA_ERROR_ARGUMENT;
    if (norma_view_overflows(view)) return NORMA_ERROR_OVERFLOW;
    return view->count > UINT32_MAX - 1 ? NORMA_ERROR_OVERFLOW : NORMA_OK;
}

norma_result norma_core_mesh_shape(const norma_mesh *mesh, core_mesh *checked)
{
    if (!mesh) return NORMA_ERROR_ARGUMENT;
    const norma_result positions = shape_of_positions(&mesh->positions);
    if (positions != NORMA_OK) return positions;
    if (mesh->corner_size != 0 && mesh->corner_size != 1 && mesh->corner_size != 2 && mesh->corner_size != 4) return NORMA_ERROR_ARGUMENT;
    if (!mesh->corners && mesh->corner_count > mesh->positions.count) return NORMA_ERROR_ARGUMENT;
    if (!mesh->face_starts && mesh->corner_count % 3) return NORMA_ERROR_ARGUMENT;
    if (mesh->corner_count > UINT32_MAX - 1 || (mesh->face_starts && mesh->face_count > UINT32_MAX - 1)) return NORMA_ERROR_OVERFLOW;
    *checked = (core_mesh){
        .positions = mesh->positions,
        .corners = mesh->corners,
        .corner_count = mesh->corner_count,
        .corner_size = !mesh->corners ? 0 : mesh->corner_size ? mesh->corner_size : 4,
        .face_starts = mesh->face_starts,
        .face_count = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3,
        .smoothing_groups = mesh->smoothing_groups,
        .hard_edges = mesh->hard_edges,
        .scale = 1,
    };
    checked->positions.stride = norma_view_stride(&mesh->positions);
    return NORMA_OK;
}

uint32_t norma_core_small_corner(const core_mesh *mesh, size_t corner)
{
    uint16_t index;
    if (mesh->corner_size == 0) return (uint32_t)corner;
    if (mesh->corner_size == 1) return ((const uint8_t *)mesh->corners)[corner];
    memcpy(&index, (const unsigned char *)mesh->corners + 2 * corner, sizeof index);
    return index;
}

void norma_core_other_position(const core_mesh *mesh, uint32_t index, double out[3])
{
    norma_view_read(&mesh->positions, index, out);
    if (mesh->positions.format == NORMA_FORMAT_DOUBLE)
        for (int i = 0; i < 3; i++) out[i] *= mesh->scale;
}

static int face_starts_are_valid(const core_mesh *mesh)
{
    if (mesh->face_starts[0] != 0 || mesh->face_starts[mesh->face_count] != mesh->corner_count) return 0;
    for (size_t f = 0; f < mesh->face_count; f++)
        if (mesh->face_starts[f] > mesh->face_starts[f + 1]) return 0;
    return 1;
}

enum { CORNERS_AT_A_TIME = 1 << 20 };

static norma_result check_corners(core_call *call, const core_mesh *mesh)
{
    if (!mesh->corner_size) return NORMA_OK;
    for (size_t begin = 0; begin < mesh->corner_count; begin += CORNERS_AT_A_TIME) {
        if (norma_core_progress(call, (double)begin / (double)mesh->corner_count)) return NORMA_CANCELLED;
        const size_t end = mesh->corner_count - begin < CORNERS_AT_A_TIME ? mesh->corner_count : begin + CORNERS_AT_A_TIME;
        uint32_t largest = 0;
        for (size_t c = begin; c < end; c++) {
            const uint32_t index = norma_core_corner(mesh, c);
            largest = index > largest ? index : largest;
        }
        if (largest >= mesh->positions.count) return NORMA_ERROR_INDEX;
    }
    return NORMA_OK;
}

/* Products of four lengths must fit a double: beyond 2^200 or below 2^-200 all positions are read times a power of two. */
static double scale_of_doubles(const core_mesh *mesh)
{
    double largest = 0;
    for (size_t i = 0; i < mesh->positions.count; i++) {
        double p[3];
        norma_view_read(&mesh->positions, i, p);
        if (!norma_core_finite(p)) continue;
        for (int k = 0; k < 3; k++) largest = fmax(largest, fabs(p[k]));
    }
    if (largest == 0 || (largest > 0x1p-200 && largest < 0x1p200)) return 1;
    const int exponent = ilogb(largest);
    return ldexp(1, exponent < -1000 ? 1000 : -exponent);
}

norma_result norma_core_mesh_content(core_call *call, core_mesh *mesh)
{
    if (mesh->face_starts && !face_starts_are_valid(mesh)) return NORMA_ERROR_ARGUMENT;
    const norma_result result = check_corners(call, mesh);
    if (result == NORMA_OK && mesh->positions.format == NORMA_FORMAT_DOUBLE) mesh->scale = scale_of_doubles(mesh);
    return result;
}
