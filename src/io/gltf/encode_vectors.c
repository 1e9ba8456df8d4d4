/* encode_vectors.c: vectors and covectors of a mesh through one matrix (Turkowski, "Transformations
 * of surface normal vectors", 1990), in double precision from the numbers as stored; and back into
 * the encoding they had. */
#include "io/gltf/gltf.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static double length(const double v[3]) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

static double vector_dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static int finite3(const double v[3]) { return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]); }

static void linear(const double m[16], const double v[3], double out[3]) {
    for (int k = 0; k < 3; k++) out[k] = m[k] * v[0] + m[4 + k] * v[1] + m[8 + k] * v[2];
}

static void normal_map(const double n[9], const double v[3], double out[3]) {
    for (int k = 0; k < 3; k++) out[k] = n[k] * v[0] + n[3 + k] * v[1] + n[6 + k] * v[2];
}

/* Where a matrix flattens, some normals go to zero, but for the rounding of the matrix. */
static double vanishing(const bake_map *map, const double normal[3]) {
    double largest = 0;
    for (int i = 0; i < 9; i++) largest = fmax(largest, fabs(map->normal[i]));
    return map->rank < 3 ? 1e-13 * largest * length(normal) : 0;
}

/* The unit normal; returns the length it had under the unnormalised map, 0 where there was nothing
 * to transform: zero stays zero, what is not finite gets the fallback. */
static double transform_normal(const bake_map *map, const double normal[3], double out[3]) {
    double mapped[3];
    normal_map(map->normal, normal, mapped);
    const double size = length(mapped);
    const int zero = length(normal) == 0,
              lost = !(finite3(normal) && size > vanishing(map, normal));
    for (int k = 0; k < 3; k++) out[k] = zero ? 0 : lost ? map->fallback[k] : mapped[k] / size;
    return lost ? 0 : size;
}

static void some_perpendicular(const double normal[3], double out[3]) {
    int axis = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(normal[i]) < fabs(normal[axis])) axis = i;
    const double e[3] = {axis == 0, axis == 1, axis == 2};
    for (int k = 0; k < 3; k++) out[k] = e[k] - normal[k] * normal[axis];
    const double size = length(out);
    for (int k = 0; k < 3; k++) out[k] /= size;
}

/* x, y, z, sign. normal: the transformed unit normal, zeros: no normal. */
static void transform_tangent(
    const bake_map *map, const double tangent[4], const double normal[3], double out[4]) {
    out[3] = map->mirrored ? -tangent[3] : tangent[3];
    if (length(tangent) == 0) {
        out[0] = out[1] = out[2] = 0;
        return;
    }
    double mapped[3], flat[3];
    linear(map->matrix, tangent, mapped);
    const double along = vector_dot(mapped, normal), whole = length(mapped);
    for (int k = 0; k < 3; k++) flat[k] = mapped[k] - along * normal[k];
    const double size = length(flat);
    if (size > 1e-12 * whole) {
        for (int k = 0; k < 3; k++) out[k] = flat[k] / size;
    } else if (length(normal) > 0) {
        some_perpendicular(normal, out);
    } else {
        out[0] = 1;
        out[1] = out[2] = 0;
    }
}

static void transform_normal_delta(
    const bake_map *map, const double delta[3], const double *base, double out[3]) {
    double unit[3];
    const double size = base ? transform_normal(map, base, unit) : 0;
    normal_map(map->normal, delta, out);
    for (int k = 0; k < 3 && size > 0; k++) out[k] /= size;
}

static void transform_tangent_delta(
    const bake_map *map, const double delta[3], const double *base, double out[3]) {
    double mapped[3] = {0, 0, 0};
    if (base) linear(map->matrix, base, mapped);
    const double size = length(mapped);
    linear(map->matrix, delta, out);
    for (int k = 0; k < 3 && size > 0; k++) out[k] /= size;
}

void norma_gltf_transform_vectors(bake_role role, const bake_map *map, const gltf_array *array,
    const gltf_array *base, double *values) {
    for (size_t i = 0; i < array->count; i++) {
        double in[4] = {0}, with[4] = {0}, normal[3] = {0, 0, 0}, *out = values + i * array->width;
        norma_gltf_doubles(array, i, in);
        if (base) norma_gltf_doubles(base, i, with);
        switch (role) {
        case BAKE_POSITIONS:
            linear(map->matrix, in, out);
            for (int k = 0; k < 3; k++) out[k] += map->matrix[12 + k];
            break;
        case BAKE_NORMALS:
            transform_normal(map, in, out);
            break;
        case BAKE_TANGENTS:
            if (base) transform_normal(map, with, normal);
            transform_tangent(map, in, normal, out);
            break;
        case BAKE_NORMAL_DELTAS:
            transform_normal_delta(map, in, base ? with : NULL, out);
            break;
        case BAKE_TANGENT_DELTAS:
            transform_tangent_delta(map, in, base ? with : NULL, out);
            break;
        case BAKE_POSITION_DELTAS:
        case BAKE_WINDING:
            linear(map->matrix, in, out);
            break;
        }
    }
}

/* ---- encodings */

/* 0: its codes are no integers. */
static int limits(int component, double *low, double *high) {
    const int is_signed = component == GLTF_BYTE || component == GLTF_SHORT;
    if (norma_gltf_is_float(component) || component == GLTF_UINT) return 0;
    *high = norma_gltf_largest_code(component);
    *low = is_signed ? -*high : 0;
    return 1;
}

/* Whether every value is a code of the encoding to within tolerance codes (0.5: in range). */
static int holds_values(
    int component, int normalized, const double *values, size_t count, double tolerance) {
    double low, high;
    if (!limits(component, &low, &high)) return 0;
    const double by = normalized ? high : 1;
    for (size_t i = 0; i < count; i++) {
        const double code = values[i] * by, whole = nearbyint(code);
        if (!(whole >= low && whole <= high && fabs(code - whole) <= tolerance)) return 0;
    }
    return 1;
}

static int allocate_codes(
    gltf_data *data, const gltf_array *stored, int component, int normalized) {
    *data = (gltf_data){.component = component,
        .normalized = normalized,
        .width = stored->width,
        .count = stored->count};
    data->bytes =
        norma_io_allocate(stored->count + 1, stored->width * norma_gltf_component_size(component));
    return data->bytes != NULL;
}

static bake_encoded encode_codes(const gltf_array *stored, const double *values, gltf_data *data) {
    if (!allocate_codes(data, stored, stored->component, stored->normalized)) return BAKE_NO_MEMORY;
    const double by = stored->normalized ? norma_gltf_largest_code(stored->component) : 1;
    const size_t size = norma_gltf_component_size(stored->component);
    for (size_t i = 0; i < stored->count * stored->width; i++)
        norma_gltf_write_number(
            data->bytes + i * size, stored->component, nearbyint(values[i] * by));
    return BAKE_ENCODED;
}

/* Unit vectors by the encoder whose codes readers take for unit; the sign of a tangent beside them.
 */
static bake_encoded encode_directions(
    const gltf_array *stored, const double *values, gltf_data *data) {
    if (!allocate_codes(data, stored, stored->component, 1)) return BAKE_NO_MEMORY;
    const size_t size = norma_gltf_component_size(stored->component), stride = stored->width * size;
    const norma_vec3_view view = {
        values, stored->count, stored->width * sizeof *values, NORMA_FORMAT_DOUBLE};
    if (stored->component == GLTF_BYTE)
        norma_encode_snorm8(view, (int8_t *)data->bytes, stride, stored->count);
    else
        norma_encode_snorm16(view, (int16_t *)(void *)data->bytes, stride, stored->count);
    for (size_t i = 0; i < stored->count && stored->width == 4; i++)
        norma_gltf_write_number(data->bytes + i * stride + 3 * size, stored->component,
            nearbyint(values[4 * i + 3] * norma_gltf_largest_code(stored->component)));
    return BAKE_ENCODED;
}

/* Doubles stay doubles; half floats stay so where they hold the values. */
static int float_component(bake_role role, const gltf_array *stored, const double *values) {
    const int exactly = role == BAKE_POSITIONS || role == BAKE_POSITION_DELTAS;
    int fits = stored->component == GLTF_HALF;
    for (size_t i = 0; fits && i < stored->count * stored->width; i++)
        fits = norma_gltf_fits_half(values[i], exactly);
    return fits ? GLTF_HALF : stored->component == GLTF_DOUBLE ? GLTF_DOUBLE : GLTF_FLOAT;
}

/* Numbers that were finite stay so. */
static bake_encoded encode_floats(
    const gltf_array *stored, int component, const double *values, gltf_data *data) {
    const size_t size = norma_gltf_component_size(component);
    if (!allocate_codes(data, stored, component, 0)) return BAKE_NO_MEMORY;
    for (size_t i = 0; i < stored->count; i++) {
        double before[4] = {0};
        norma_gltf_doubles(stored, i, before);
        for (size_t k = 0; k < stored->width; k++) {
            const double value = values[i * stored->width + k];
            const int is_held = component == GLTF_FLOAT ? isfinite((float)value) : isfinite(value);
            /* infinity less infinity has another sign on each kind of processor */
            norma_gltf_write_number(data->bytes + (i * stored->width + k) * size, component,
                isnan(value) ? (double)NAN : value + 0.0);
            if (!is_held && finite3(before)) {
                free(data->bytes);
                return BAKE_TOO_LARGE;
            }
        }
    }
    return BAKE_ENCODED;
}

bake_encoded norma_gltf_encode(
    bake_role role, const gltf_array *stored, const double *values, gltf_data *data) {
    const int is_signed = stored->component == GLTF_BYTE || stored->component == GLTF_SHORT;
    const size_t count = stored->count * stored->width;
    const int is_place = role == BAKE_POSITIONS || role == BAKE_POSITION_DELTAS,
              is_direction = role == BAKE_NORMALS || role == BAKE_TANGENTS;
    const int is_delta = role == BAKE_NORMAL_DELTAS || role == BAKE_TANGENT_DELTAS;
    bake_encoded encoded;
    if (is_direction && is_signed && stored->normalized)
        encoded = encode_directions(stored, values, data);
    else if ((is_place &&
                 holds_values(stored->component, stored->normalized, values, count, 1e-9)) ||
             (is_delta && is_signed && stored->normalized &&
                 holds_values(stored->component, 1, values, count, 0.5)))
        encoded = encode_codes(stored, values, data);
    else
        encoded = encode_floats(stored, float_component(role, stored, values), values, data);
    data->bounds = is_place;
    return encoded;
}
