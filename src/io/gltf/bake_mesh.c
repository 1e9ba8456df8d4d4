/* bake_mesh.c: --bake: the data of a mesh under a matrix, made once for all that share it, and back
 * in its encoding; and its winding. */
#include "io/gltf/gltf_layout.h"
#include "core/call/table.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double length(const double v[3]) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

static void linear(const double m[16], const double v[3], double out[3]) {
    for (int k = 0; k < 3; ++k) out[k] = m[k] * v[0] + m[4 + k] * v[1] + m[8 + k] * v[2];
}

static void normal_map(const double n[9], const double v[3], double out[3]) {
    for (int k = 0; k < 3; ++k) out[k] = n[k] * v[0] + n[3 + k] * v[1] + n[6 + k] * v[2];
}

/* Where a matrix flattens, some normals go to zero, but for the rounding of the matrix. */
static double vanishing(const bake_map *map, const double normal[3]) {
    double largest = 0;
    for (int i = 0; i < 9; ++i) largest = fmax(largest, fabs(map->normal[i]));
    return map->rank < 3 ? 1e-13 * largest * length(normal) : 0;
}

/* The unit normal; returns the length it had under the unnormalised map, 0 where there was nothing
 * to transform: zero stays zero, what is not finite gets the fallback. */
static double transform_normal(const bake_map *map, const double normal[3], double out[3]) {
    double mapped[3];
    normal_map(map->normal, normal, mapped);
    const double size = length(mapped);
    const int zero = length(normal) == 0,
              lost = !(norma_core_finite(normal) && size > vanishing(map, normal));
    for (int k = 0; k < 3; ++k) out[k] = zero ? 0 : lost ? map->fallback[k] : mapped[k] / size;
    return lost ? 0 : size;
}

static void some_perpendicular(const double normal[3], double out[3]) {
    int axis = 0;
    for (int i = 1; i < 3; ++i)
        if (fabs(normal[i]) < fabs(normal[axis])) axis = i;
    const double e[3] = {axis == 0, axis == 1, axis == 2};
    for (int k = 0; k < 3; ++k) out[k] = e[k] - normal[k] * normal[axis];
    const double size = length(out);
    for (int k = 0; k < 3; ++k) out[k] /= size;
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
    const double along = norma_core_dot(mapped, normal), whole = length(mapped);
    for (int k = 0; k < 3; ++k) flat[k] = mapped[k] - along * normal[k];
    const double size = length(flat);
    if (size > 1e-12 * whole) {
        for (int k = 0; k < 3; ++k) out[k] = flat[k] / size;
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
    for (int k = 0; k < 3 && size > 0; ++k) out[k] /= size;
}

static void transform_tangent_delta(
    const bake_map *map, const double delta[3], const double *base, double out[3]) {
    double mapped[3] = {0, 0, 0};
    if (base) linear(map->matrix, base, mapped);
    const double size = length(mapped);
    linear(map->matrix, delta, out);
    for (int k = 0; k < 3 && size > 0; ++k) out[k] /= size;
}

/* array->count elements of array->width numbers into values. base: the normals that tangents go
 * with, or that deltas of normals are added to, or the tangents that deltas of tangents are; NULL
 * where there are none. */
static void gltf_transform_vectors(bake_role role, const bake_map *map, const gltf_array *array,
    const gltf_array *base, double *values) {
    for (size_t i = 0; i < array->count; ++i) {
        double in[4] = {0}, with[4] = {0}, normal[3] = {0, 0, 0}, *out = values + i * array->width;
        norma_gltf_doubles(array, i, in);
        if (base) norma_gltf_doubles(base, i, with);
        switch (role) {
        case BAKE_POSITIONS:
            linear(map->matrix, in, out);
            for (int k = 0; k < 3; ++k) out[k] += map->matrix[12 + k];
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

/* Whether every value is a code of the encoding to within tolerance codes (0.5: in range). */
static int holds_values(
    int component, int normalized, const double *values, size_t count, double tolerance) {
    const double high = norma_gltf_largest_code(component), by = normalized ? high : 1,
                 low = component == GLTF_BYTE || component == GLTF_SHORT ? -high : 0;
    if (norma_gltf_is_float(component) || component == GLTF_UINT) return 0; /* no such codes */
    for (size_t i = 0; i < count; ++i) {
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
    for (size_t i = 0; i < stored->count * stored->width; ++i)
        norma_gltf_write_number(
            data->bytes + i * size, stored->component, nearbyint(values[i] * by));
    return BAKE_ENCODED;
}

int norma_gltf_encode_units(
    int component, norma_vec3_view units, unsigned char *out, size_t stride) {
    return component == GLTF_BYTE
               ? !norma_encode_snorm8(units, (int8_t *)out, stride, units.count)
               : !norma_encode_snorm16(units, (int16_t *)(void *)out, stride, units.count);
}

/* Unit vectors by the encoder whose codes readers take for unit; the sign of a tangent beside them.
 */
static bake_encoded encode_directions(
    const gltf_array *stored, const double *values, gltf_data *data) {
    if (!allocate_codes(data, stored, stored->component, 1)) return BAKE_NO_MEMORY;
    const size_t size = norma_gltf_component_size(stored->component), stride = stored->width * size;
    const norma_vec3_view view = {
        values, stored->count, stored->width * sizeof *values, NORMA_FORMAT_DOUBLE};
    norma_gltf_encode_units(stored->component, view, data->bytes, stride);
    for (size_t i = 0; i < stored->count && stored->width == 4; ++i)
        norma_gltf_write_number(data->bytes + i * stride + 3 * size, stored->component,
            nearbyint(values[4 * i + 3] * norma_gltf_largest_code(stored->component)));
    return BAKE_ENCODED;
}

/* Doubles stay doubles; half floats stay so where they hold the values. */
static int float_component(bake_role role, const gltf_array *stored, const double *values) {
    const int exactly = role == BAKE_POSITIONS || role == BAKE_POSITION_DELTAS;
    int fits = stored->component == GLTF_HALF;
    for (size_t i = 0; fits && i < stored->count * stored->width; ++i)
        fits = norma_gltf_fits_half(values[i], exactly);
    return fits ? GLTF_HALF : stored->component == GLTF_DOUBLE ? GLTF_DOUBLE : GLTF_FLOAT;
}

/* Numbers that were finite stay so. */
static bake_encoded encode_floats(
    const gltf_array *stored, int component, const double *values, gltf_data *data) {
    const size_t size = norma_gltf_component_size(component);
    if (!allocate_codes(data, stored, component, 0)) return BAKE_NO_MEMORY;
    for (size_t i = 0; i < stored->count; ++i) {
        double before[4] = {0};
        if (stored->data) norma_gltf_doubles(stored, i, before);
        for (size_t k = 0; k < stored->width; ++k) {
            const double value = values[i * stored->width + k];
            const int is_held = component == GLTF_FLOAT ? isfinite((float)value) : isfinite(value);
            /* infinity less infinity has another sign on each kind of processor */
            norma_gltf_write_number(data->bytes + (i * stored->width + k) * size, component,
                isnan(value) ? (double)NAN : value + 0.0);
            if (!is_held && norma_core_finite(before)) {
                free(data->bytes);
                data->bytes = NULL;
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

/* ---- --bake: the data of a mesh under a matrix, made once for all that share it, and its
 * winding. */

#define BAKE_UNCHANGED (UINT32_MAX - 1) /* as data: the slot keeps what it has */

/* ---- What several primitives share stays shared where the matrix is the same: contents
 * are found again by what they were made of. */

void norma_gltf_bake_cache_free(bake_cache *cache) {
    free(cache->entries);
    free(cache->slots);
    free(cache->matrices);
    *cache = (bake_cache){0};
}

enum { ENTRY_KEY = offsetof(bake_entry, data) };

typedef struct wanted_entry {
    const bake_entry *entries, *key;
} wanted_entry;

static int is_wanted_entry(const void *context, uint32_t number) {
    const wanted_entry *w = context;
    return memcmp(&w->entries[number], w->key, ENTRY_KEY) == 0;
}

static uint32_t *entry_slot_of(
    const bake_cache *cache, uint32_t *slots, size_t size, const bake_entry *key) {
    const wanted_entry w = {cache->entries, key};
    return norma_core_table_find(slots, size, norma_core_hash(key, ENTRY_KEY), is_wanted_entry, &w);
}

static int find_entry(const bake_cache *cache, const bake_entry *key, uint32_t *data) {
    const uint32_t found =
        cache->slot_count ? *entry_slot_of(cache, cache->slots, cache->slot_count, key) : 0;
    if (found) *data = cache->entries[found - 1].data;
    return found != 0;
}

static int grow_slots(bake_cache *cache) {
    const size_t size = norma_core_table_size(2 * (cache->count + 1));
    uint32_t *slots = norma_io_allocate(size, sizeof *slots);
    if (!slots) return 0;
    for (uint32_t i = 0; i < cache->count; ++i)
        *entry_slot_of(cache, slots, size, &cache->entries[i]) = i + 1;
    free(cache->slots);
    cache->slots = slots;
    cache->slot_count = size;
    return 1;
}

/* 0: out of memory */
static int add_baked_entry(bake_cache *cache, const bake_entry *entry) {
    if (cache->count >= GLTF_NONE - 1 ||
        (2 * (cache->count + 1) > cache->slot_count && !grow_slots(cache)))
        return 0;
    bake_entry *added =
        norma_io_add(&cache->entries, &cache->capacity, &cache->count, sizeof *added);
    if (!added) return 0;
    *added = *entry;
    *entry_slot_of(cache, cache->slots, cache->slot_count, entry) = (uint32_t)cache->count;
    return 1;
}

/* Whether normals stay as they are: the normal matrix is a multiple of the identity, as far as
 * doubles tell. */
static int keeps_directions(const double n[9]) {
    const double size = n[0];
    if (!(size > 0)) return 0;
    for (int i = 0; i < 9; ++i)
        if (fabs(n[i] - (i % 4 == 0 ? size : 0)) > 1e-15 * size) return 0;
    return 1;
}

/* The one direction that is left where a matrix flattens: the longest column; +Z where nothing is.
 */
static void find_fallback(bake_map *map) {
    double longest = 0;
    map->fallback[0] = map->fallback[1] = 0;
    map->fallback[2] = 1;
    for (int i = 0; i < 3; ++i) {
        const double *c = map->normal + 3 * i, size = length(c);
        if (size <= longest) continue;
        longest = size;
        for (int k = 0; k < 3; ++k) map->fallback[k] = c[k] / size;
    }
}

#define MATRIX_ROLE UINT32_MAX

/* The number of an equal matrix seen before, or of this one from now on. The table of contents
 * serves for matrices too: by two halves of a hash of their bits. */
static int identify(bake_cache *cache, bake_map *map) {
    uint64_t bits[16], mixed = 0;
    for (int i = 0; i < 16; ++i) map->matrix[i] += 0.0; /* -0 is 0 */
    memcpy(bits, map->matrix, sizeof bits);
    for (int i = 0; i < 16; ++i) mixed = (mixed ^ bits[i] ^ (mixed >> 29)) * 0xBF58476D1CE4E5B9u;
    bake_entry key = {MATRIX_ROLE, (uint32_t)mixed, (uint32_t)(mixed >> 32), 0, 0};
    for (; find_entry(cache, &key, &map->id); ++key.map)
        if (memcmp(cache->matrices[map->id], map->matrix, sizeof map->matrix) == 0) return 1;
    double *added = norma_io_add(
        &cache->matrices, &cache->matrix_capacity, &cache->matrix_count, sizeof map->matrix);
    if (!added) return 0;
    memcpy(added, map->matrix, sizeof map->matrix);
    key.data = map->id = (uint32_t)cache->matrix_count - 1;
    return add_baked_entry(cache, &key);
}

int norma_gltf_bake_map(bake_cache *cache, const double matrix[16], bake_map *map) {
    norma_matrix_info info;
    memcpy(map->matrix, matrix, sizeof map->matrix);
    norma_normal_matrix_double(matrix, NORMA_WINDING_REVERSED, map->normal, &info);
    map->mirrored = info.mirrored;
    map->rank = info.rank;
    map->turns = !keeps_directions(map->normal);
    find_fallback(map);
    return identify(cache, map);
}

/* ---- The triangles of a primitive turned round. In a list each keeps its first corner.
 * Strips of an odd number of corners are read backwards, fans too but for their first corner; a
 * strip of an even number would keep its winding, read backwards: it becomes a list. */

typedef struct corner_list {
    uint32_t *corners;
    size_t count;
    uint32_t mode;
} corner_list;

static void swap_corners(uint32_t *a, uint32_t *b) {
    const uint32_t kept = *a;
    *a = *b;
    *b = kept;
}

static void reverse_order(uint32_t *corners, size_t count) {
    for (size_t i = 0; i < count / 2; ++i) swap_corners(&corners[i], &corners[count - 1 - i]);
}

/* FB_ngon_encoding: triangles that follow one another with one first corner are one polygon, a fan;
 * reversed, it is told from the other end. */
static void reverse_polygons(uint32_t *corners, size_t triangles) {
    for (size_t first = 0, after; first < triangles; first = after) {
        for (after = first + 1; after < triangles && corners[3 * after] == corners[3 * first];)
            ++after;
        for (size_t i = 0; i < (after - first) / 2; ++i)
            for (size_t k = 0; k < 3; ++k)
                swap_corners(&corners[3 * (first + i) + k], &corners[3 * (after - 1 - i) + k]);
    }
}

/* An even strip as a list, each triangle turned; triangles of no area by their corners alone are
 * left out. Returns the number of corners. */
static size_t unroll_strip(const uint32_t *strip, size_t count, uint32_t *list) {
    size_t made = 0;
    for (size_t i = 0; i + 2 < count; ++i) {
        const uint32_t a = strip[i], b = strip[i + 1], c = strip[i + 2];
        if (a == b || b == c || c == a) continue;
        list[made++] = a;
        list[made++] = i % 2 ? b : c;
        list[made++] = i % 2 ? c : b;
    }
    return made;
}

static int reverse(corner_list *list, int polygons) {
    if (list->mode == GLTF_TRIANGLES) {
        for (size_t i = 0; i + 2 < list->count; i += 3)
            swap_corners(&list->corners[i + 1], &list->corners[i + 2]);
        if (polygons) reverse_polygons(list->corners, list->count / 3);
    } else if (list->mode == GLTF_FAN) {
        reverse_order(list->corners + 1, list->count - 1);
    } else if (list->count % 2) {
        reverse_order(list->corners, list->count);
    } else {
        uint32_t *unrolled = norma_io_allocate(list->count, 3 * sizeof *unrolled);
        if (!unrolled) return 0;
        const size_t made = unroll_strip(list->corners, list->count, unrolled);
        free(list->corners);
        *list = (corner_list){unrolled, made, GLTF_TRIANGLES};
    }
    return 1;
}

static norma_document_result read_winding(
    gltf *g, const gltf_primitive *primitive, corner_list *list, norma_document_error *error) {
    gltf_array array = {.count = primitive->vertices};
    if (primitive->indices != GLTF_NONE) {
        const norma_document_result result = norma_gltf_array(g, primitive->indices, &array, error);
        if (result) return result;
    }
    list->mode = primitive->mode;
    list->count = array.count;
    list->corners = norma_io_allocate(array.count + 1, sizeof *list->corners);
    if (!list->corners) return norma_document_fail_memory(g->document, error);
    for (size_t i = 0; i < array.count; ++i) {
        list->corners[i] = (uint32_t)i;
        if (primitive->indices != GLTF_NONE) norma_gltf_uints(&array, i, &list->corners[i]);
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result add_turned_corners(gltf *g, const gltf_primitive *primitive,
    const corner_list *list, uint32_t *number, norma_document_error *error) {
    gltf_data data = {.component = norma_gltf_index_component(g, primitive,
                          primitive->indices == GLTF_NONE ? primitive->vertices : 0, GLTF_USHORT),
        .width = 1,
        .count = list->count,
        .is_indices = 1};
    data.bytes = norma_gltf_encode_indices(data.component, list->corners, list->count);
    if (!data.bytes) return norma_document_fail_memory(g->document, error);
    *number = norma_gltf_add_data(g, &data);
    return *number == GLTF_NONE ? norma_document_fail_memory(g->document, error)
                                : NORMA_DOCUMENT_OK;
}

static norma_document_result make_corners(gltf *g, const gltf_primitive *primitive, int polygons,
    bake_entry *entry, norma_document_error *error) {
    corner_list list = {NULL, 0, 0};
    norma_document_result result = read_winding(g, primitive, &list, error);
    if (!result && list.count >= 3 && !reverse(&list, polygons))
        result = norma_document_fail_memory(g->document, error);
    if (!result && list.count < 3) /* nothing to turn */
        entry->data = BAKE_UNCHANGED;
    else if (!result)
        result = add_turned_corners(g, primitive, &list, &entry->data, error);
    free(list.corners);
    return result;
}

static norma_document_result gltf_bake_winding(gltf *g, bake_cache *cache,
    uint32_t primitive_number, uint32_t copy, norma_document_error *error) {
    const gltf_primitive *primitive = &g->primitives[primitive_number];
    if (primitive->mode < GLTF_TRIANGLES) return NORMA_DOCUMENT_OK;
    const int polygons = norma_gltf_extension(g, primitive->token, "FB_ngon_encoding") != JSON_NONE;
    const int indexed = primitive->indices != GLTF_NONE;
    if (!indexed && primitive->vertices >= UINT32_MAX)
        return NORMA_DOCUMENT_OK; /* more than any index names: nothing that a file holds */
    bake_entry entry = {BAKE_WINDING, primitive->indices,
        indexed ? primitive->vertices > 0 : (uint32_t)primitive->vertices,
        2 * primitive->mode + (unsigned)polygons, 0};
    if (!find_entry(cache, &entry, &entry.data)) {
        const norma_document_result result = make_corners(g, primitive, polygons, &entry, error);
        if (result) return result;
        if (!add_baked_entry(cache, &entry)) return norma_document_fail_memory(g->document, error);
    }
    if (entry.data == BAKE_UNCHANGED) return NORMA_DOCUMENT_OK;
    const gltf_slot slot = {copy, primitive_number, GLTF_SLOT_INDICES, NULL};
    if (!norma_gltf_put(g, &slot, entry.data))
        return norma_document_fail_memory(g->document, error);
    const size_t count = indexed ? g->accessors[primitive->indices].count : primitive->vertices;
    if (primitive->mode == GLTF_STRIP && count % 2 == 0)
        norma_gltf_set_mode(g, copy, primitive_number, GLTF_TRIANGLES);
    return NORMA_DOCUMENT_OK;
}

/* ---- Every slot of a mesh that a matrix changes: positions, normals, tangents, the morph
 * targets' deltas of each, the order of the corners. */

typedef struct mesh_baker {
    gltf *g;
    bake_cache *cache;
    const bake_map *map;
    uint32_t node; /* for messages */
} mesh_baker;

static norma_document_result malformed(
    const mesh_baker *b, uint32_t accessor, const char *expected, norma_document_error *error) {
    return norma_gltf_malformed(b->g, error, b->g->accessors[accessor].token, expected);
}

static norma_document_result too_large(
    const mesh_baker *b, uint32_t accessor, norma_document_error *error) {
    char place[60];
    (void)snprintf(place, sizeof place, "accessor %u", (unsigned)accessor);
    return norma_document_fail(b->g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, place,
        "under node %u its coordinates exceed the range of floats; expected a smaller scale",
        (unsigned)b->node);
}

static norma_document_result check_vector_shape(const mesh_baker *b, const bake_entry *entry,
    const gltf_array *array, const gltf_array *base, norma_document_error *error) {
    if (array->width != (entry->role == BAKE_TANGENTS ? 4u : 3u))
        return malformed(b, entry->a,
            entry->role == BAKE_TANGENTS ? "the type VEC4 for tangents" : "the type VEC3", error);
    if (array->component == GLTF_UINT)
        return malformed(b, entry->a, "floats, or integers of at most 16 bits", error);
    if (base && (base->count < array->count || base->width < 3 || base->width > 4 ||
                    base->component == GLTF_UINT))
        return malformed(b, entry->b, "as many vectors as the other attributes have", error);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result make_data(
    const mesh_baker *b, bake_entry *entry, norma_document_error *error) {
    gltf_array array, base;
    norma_document_result result = norma_gltf_array(b->g, entry->a, &array, error);
    if (!result && entry->b != GLTF_NONE) result = norma_gltf_array(b->g, entry->b, &base, error);
    if (!result)
        result = check_vector_shape(b, entry, &array, entry->b == GLTF_NONE ? NULL : &base, error);
    if (result) return result;
    double *values = norma_io_allocate(array.count + 1, array.width * sizeof *values);
    if (!values) return norma_document_fail_memory(b->g->document, error);
    gltf_transform_vectors(
        (bake_role)entry->role, b->map, &array, entry->b == GLTF_NONE ? NULL : &base, values);
    gltf_data data;
    const bake_encoded encoded = norma_gltf_encode((bake_role)entry->role, &array, values, &data);
    free(values);
    if (encoded == BAKE_TOO_LARGE) return too_large(b, entry->a, error);
    if (encoded == BAKE_NO_MEMORY) return norma_document_fail_memory(b->g->document, error);
    if (norma_gltf_is_same(&array, &data)) {
        free(data.bytes);
        entry->data = BAKE_UNCHANGED;
        return NORMA_DOCUMENT_OK;
    }
    entry->data = norma_gltf_add_data(b->g, &data);
    return entry->data == GLTF_NONE ? norma_document_fail_memory(b->g->document, error)
                                    : NORMA_DOCUMENT_OK;
}

/* base: see gltf_transform_vectors. */
static norma_document_result bake_slot(const mesh_baker *b, bake_role role, uint32_t accessor,
    uint32_t base, const gltf_slot *slot, norma_document_error *error) {
    const int is_direction = role != BAKE_POSITIONS && role != BAKE_POSITION_DELTAS;
    if (accessor == GLTF_NONE || (is_direction && !b->map->turns)) return NORMA_DOCUMENT_OK;
    bake_entry entry = {role, accessor, base, b->map->id, 0};
    if (!find_entry(b->cache, &entry, &entry.data)) {
        const norma_document_result result = make_data(b, &entry, error);
        if (result) return result;
        if (!add_baked_entry(b->cache, &entry))
            return norma_document_fail_memory(b->g->document, error);
    }
    if (entry.data != BAKE_UNCHANGED && !norma_gltf_put(b->g, slot, entry.data))
        return norma_document_fail_memory(b->g->document, error);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result bake_attributes(const mesh_baker *b, const gltf_primitive *primitive,
    gltf_slot slot, norma_document_error *error) {
    const int delta = slot.target >= 0;
    const gltf_attributes *base = &primitive->base,
                          *attributes = norma_gltf_set_of(b->g, primitive, slot.target);
    slot.attribute = "POSITION";
    norma_document_result result = bake_slot(b, delta ? BAKE_POSITION_DELTAS : BAKE_POSITIONS,
        attributes->position, GLTF_NONE, &slot, error);
    slot.attribute = "NORMAL";
    if (!result)
        result = bake_slot(b, delta ? BAKE_NORMAL_DELTAS : BAKE_NORMALS, attributes->normal,
            delta ? base->normal : GLTF_NONE, &slot, error);
    slot.attribute = "TANGENT";
    if (!result)
        result = bake_slot(b, delta ? BAKE_TANGENT_DELTAS : BAKE_TANGENTS, attributes->tangent,
            delta ? base->tangent : base->normal, &slot, error);
    return result;
}

norma_document_result norma_gltf_bake_mesh(gltf *g, bake_cache *cache, const mesh_use *use,
    const bake_map *map, size_t *vertices, norma_document_error *error) {
    const mesh_baker b = {g, cache, map, use->node};
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t i = 0; !result && i < g->meshes[use->mesh].primitive_count; ++i) {
        const uint32_t number = g->meshes[use->mesh].first_primitive + i;
        const gltf_primitive *primitive = &g->primitives[number];
        gltf_slot slot = {use->copy, number, GLTF_SLOT_BASE, NULL};
        if (primitive->base.position == GLTF_NONE) continue; /* nothing is drawn */
        for (; !result && slot.target < (int32_t)primitive->target_count; ++slot.target)
            result = bake_attributes(&b, primitive, slot, error);
        if (!result && map->mirrored)
            result = gltf_bake_winding(g, cache, number, use->copy, error);
        *vertices += primitive->vertices;
    }
    return result;
}
