/* tangent_vertices.c: positions, normals and texture coordinates brought together, and which of
 * them are equal; the tangents that are written. */
#include "core/tangent/tangents.h"
#include "core/face/face.h"
#include <math.h>

/* ---- Positions, normals and texture coordinates brought together, and which of
 * them are equal. */

/* ---- attributes, checked and read */

static norma_result check_attribute(
    const norma_attribute *a, size_t numbers, const core_mesh *mesh) {
    if (!a) return mesh->corner_count ? NORMA_ERROR_ARGUMENT : NORMA_OK;
    const size_t size = norma_format_size(a->format), bytes = numbers * size,
                 stride = a->stride ? a->stride : bytes;
    if (!size || (a->of != NORMA_PER_VERTEX && a->of != NORMA_PER_CORNER) || (a->count && !a->data))
        return NORMA_ERROR_ARGUMENT;
    if (a->count > SIZE_MAX / stride || (a->count && (a->count - 1) * stride > SIZE_MAX - bytes))
        return NORMA_ERROR_OVERFLOW;
    if (!a->corners &&
        a->count < (a->of == NORMA_PER_VERTEX ? mesh->positions.count : mesh->corner_count))
        return NORMA_ERROR_ARGUMENT;
    return NORMA_OK;
}

norma_result norma_core_tangent_attributes(tangent_mesh *mesh, norma_tangent_mode mode,
    const norma_attribute *normals, const norma_attribute *texcoords) {
    mesh->in_doubles =
        mode == NORMA_TANGENTS_STEADY && mesh->mesh.positions.format == NORMA_FORMAT_DOUBLE;
    mesh->normals = normals;
    mesh->texcoords = texcoords;
    const norma_result result = check_attribute(normals, 3, &mesh->mesh);
    return result ? result : check_attribute(texcoords, 2, &mesh->mesh);
}

/* A normalised integer as a float: v / most, at least -1. */
static float from_integer(double value, double most) {
    const double scaled = value / most;
    return (float)(scaled < -1 ? -1 : scaled);
}

static float read_attribute_number(norma_format format, const unsigned char *at) {
    float single;
    double wide;
    int16_t i16;
    uint16_t u16;
    switch (format) {
    case NORMA_FORMAT_FLOAT:
        memcpy(&single, at, sizeof single);
        return single;
    case NORMA_FORMAT_DOUBLE:
        memcpy(&wide, at, sizeof wide);
        return (float)wide;
    case NORMA_FORMAT_INT8:
        return from_integer((double)(int8_t)*at, 127);
    case NORMA_FORMAT_UINT8:
        return from_integer((double)*at, 255);
    case NORMA_FORMAT_INT16:
        memcpy(&i16, at, sizeof i16);
        return from_integer((double)i16, 32767);
    default:
        memcpy(&u16, at, sizeof u16);
        return from_integer((double)u16, 65535);
    }
}

/* Inlined: of a number of bytes that is known, a copy is not a call. */
CORE_INLINE void read_attribute(
    const norma_attribute *a, size_t index, size_t numbers, float *out) {
    const size_t size = norma_format_size(a->format),
                 stride = a->stride ? a->stride : numbers * size;
    const unsigned char *at = (const unsigned char *)a->data + index * stride;
    if (a->format == NORMA_FORMAT_FLOAT)
        memcpy(out, at, numbers * sizeof *out);
    else
        for (size_t i = 0; i < numbers; ++i)
            out[i] = read_attribute_number(a->format, at + i * size);
}

static void read_float_position(const norma_vec3_view *view, size_t index, float out[3]) {
    if (view->format == NORMA_FORMAT_FLOAT) {
        memcpy(out, (const unsigned char *)view->data + index * view->stride, 3 * sizeof *out);
        return;
    }
    double wide[3];
    norma_view_read(view, index, wide);
    for (int k = 0; k < 3; ++k) out[k] = (float)wide[k];
}

/* ---- vertices, a slice of the keys in each task */

enum { KEYS_IN_TASK = 1 << 14 };

typedef struct reading {
    const tangent_mesh *mesh;
    atomic_int wrong; /* a corner names no value */
} reading;

/* Returns SIZE_MAX if no such vertex exists. */
static size_t value_of_corner(const norma_attribute *a, size_t position, size_t corner) {
    const size_t value = a->corners                  ? a->corners[corner]
                         : a->of == NORMA_PER_VERTEX ? position
                                                     : corner;
    return value < a->count ? value : SIZE_MAX;
}

int norma_core_tangent_read_key(
    const tangent_mesh *m, size_t key, tangent_vertex *v, double exact[3]) {
    const size_t position = m->by_position ? key : norma_core_corner(&m->mesh, key),
                 normal = value_of_corner(m->normals, position, key),
                 texcoord = value_of_corner(m->texcoords, position, key);
    if (normal == SIZE_MAX || texcoord == SIZE_MAX) return 0;
    if (exact) {
        norma_view_read(&m->mesh.positions, position, exact);
        const float stand_in = norma_core_finite(exact) ? 0 : NAN;
        for (int k = 0; k < 3; ++k) v->position[k] = stand_in;
    } else {
        read_float_position(&m->mesh.positions, position, v->position);
    }
    read_attribute(m->normals, normal, 3, v->normal);
    read_attribute(m->texcoords, texcoord, 2, v->texcoord);
    return 1;
}

static void read_task(void *context, size_t task) {
    reading *r = context;
    const tangent_mesh *m = r->mesh;
    const size_t begin = task * KEYS_IN_TASK,
                 end = m->key_count - begin < KEYS_IN_TASK ? m->key_count : begin + KEYS_IN_TASK;
    for (size_t key = begin; key < end; ++key)
        if (!norma_core_tangent_read_key(
                m, key, &m->vertices[key], m->exact ? m->exact[key] : NULL)) {
            atomic_store_explicit(&r->wrong, 1, memory_order_relaxed);
            return;
        }
}

static norma_result read_all_vertices(tangent_mesh *mesh) {
    reading r = {.mesh = mesh};
    const norma_result result = norma_core_parallel(mesh->call,
        mesh->key_count / KEYS_IN_TASK + (mesh->key_count % KEYS_IN_TASK != 0), read_task, &r);
    if (result) return result;
    return atomic_load_explicit(&r.wrong, memory_order_relaxed) ? NORMA_ERROR_INDEX : NORMA_OK;
}

/* ---- equal ones */

static const uint64_t ODD[4] = {UINT64_C(0x9e3779b97f4a7c15), UINT64_C(0xbf58476d1ce4e5b9),
    UINT64_C(0x94d049bb133111eb), UINT64_C(0xc2b2ae3d27d4eb4f)};

typedef struct vertices_to_weld {
    const tangent_vertex *vertices;
    const double (*exact)[3];
} vertices_to_weld;

static uint64_t hash_exact(const double position[3]) {
    uint64_t sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double number = position[k] + 0.0;
        uint64_t bits;
        memcpy(&bits, &number, sizeof bits);
        sum = norma_core_weld_mix(sum + bits * ODD[k]);
    }
    return sum;
}

static void hash_vertices(const void *context, size_t first, size_t count, uint64_t *hashes) {
    const vertices_to_weld *w = context;
    const tangent_vertex *vertices = w->vertices + first;
    for (size_t i = 0; i < count; ++i) {
        float numbers[8];
        uint32_t bits[8];
        uint64_t sum = 0;
        int nan = 0;
        memcpy(numbers, &vertices[i], sizeof numbers);
        for (int k = 0; k < 8; ++k) {
            nan |= numbers[k] != numbers[k];
            numbers[k] += 0.0F; /* the same bits for -0 and 0 */
        }
        memcpy(bits, numbers, sizeof bits);
        for (int k = 0; k < 4; ++k) sum += (bits[2 * k] | (uint64_t)bits[2 * k + 1] << 32) * ODD[k];
        if (w->exact) sum += hash_exact(w->exact[first + i]);
        hashes[i] = nan ? 0 : norma_core_weld_mix(sum);
    }
}

static int same_vertex(const void *context, uint32_t one, uint32_t other) {
    const vertices_to_weld *w = context;
    float a[8], b[8];
    int same = 1;
    memcpy(a, &w->vertices[one], sizeof a);
    memcpy(b, &w->vertices[other], sizeof b);
    for (int k = 0; k < 8; ++k) same &= a[k] == b[k];
    for (int k = 0; k < 3 && w->exact; ++k) same &= w->exact[one][k] == w->exact[other][k];
    return same;
}

norma_result norma_core_tangent_weld_vertices(core_call *call, const tangent_vertex *vertices,
    const double (*exact)[3], size_t count, uint32_t *weld, size_t *found) {
    const vertices_to_weld context = {vertices, exact};
    const weld_keys keys = {count, &context, hash_vertices, same_vertex};
    return norma_core_weld_keys(call, &keys, weld, found);
}

norma_result norma_core_tangent_weld(tangent_mesh *mesh) {
    const size_t count = mesh->key_count;
    size_t found;
    uint32_t *weld = norma_core_allocate(mesh->call, count, sizeof *weld);
    if (!weld) return NORMA_ERROR_MEMORY;
    const norma_result result = norma_core_tangent_weld_vertices(
        mesh->call, mesh->vertices, (const double(*)[3])mesh->exact, count, weld, &found);
    mesh->weld = weld;
    if (result || found) return result;
    norma_core_release(mesh->call, weld, count, sizeof *weld);
    mesh->weld = NULL;
    return NORMA_OK;
}

static int is_per_vertex(const norma_attribute *a) {
    return a->of == NORMA_PER_VERTEX && !a->corners;
}

norma_result norma_core_tangent_read(tangent_mesh *mesh) {
    mesh->by_position = is_per_vertex(mesh->normals) && is_per_vertex(mesh->texcoords);
    mesh->key_count = mesh->by_position ? mesh->mesh.positions.count : mesh->mesh.corner_count;
    mesh->vertices = norma_core_allocate(mesh->call, mesh->key_count, sizeof *mesh->vertices);
    if (mesh->in_doubles)
        mesh->exact = norma_core_allocate(mesh->call, mesh->key_count, sizeof *mesh->exact);
    const int ready = mesh->vertices && (mesh->exact || !mesh->in_doubles);
    return ready ? read_all_vertices(mesh) : NORMA_ERROR_MEMORY;
}

norma_result norma_core_tangent_open(tangent_mesh *mesh) {
    if (!mesh->mesh.corner_count) return NORMA_OK;
    norma_result result = norma_core_tangent_read(mesh);
    if (!result) result = norma_core_tangent_weld(mesh);
    if (result) norma_core_tangent_close(mesh);
    return result;
}

void norma_core_tangent_close(tangent_mesh *mesh) {
    norma_core_release(mesh->call, mesh->vertices, mesh->key_count, sizeof *mesh->vertices);
    norma_core_release(mesh->call, mesh->exact, mesh->key_count, sizeof *mesh->exact);
    norma_core_release(mesh->call, mesh->weld, mesh->key_count, sizeof *mesh->weld);
    mesh->vertices = NULL;
    mesh->exact = NULL;
    mesh->weld = NULL;
}

/* ---- One place for what reaches the caller. */

norma_result norma_core_tangent_output_open(const norma_options *options, float *tangents,
    size_t count, size_t capacity, tangent_output *output) {
    const size_t least = 4 * sizeof(float), asked = options ? options->normal_stride : 0;
    *output = (tangent_output){.tangents = (unsigned char *)tangents,
        .stride = asked ? asked : least,
        .reasons = options ? options->reasons : NULL};
    if (output->stride < least || (count && !tangents)) return NORMA_ERROR_ARGUMENT;
    if (count > capacity) return NORMA_ERROR_CAPACITY;
    return count && count > SIZE_MAX / output->stride ? NORMA_ERROR_OVERFLOW : NORMA_OK;
}

/* A unit vector perpendicular to n, the same on every machine: the axis that n leans on least, made
 * perpendicular; the first axis where n has no direction. */
static void perpendicular_to_normal(const float normal[3], float out[3]) {
    const double given[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
    double n[3] = {0}, v[3], unit[3];
    int axis = 0;
    if (norma_core_finite(given)) norma_core_normalise(given, n);
    for (int k = 1; k < 3; ++k)
        if (fabs(n[k]) < fabs(n[axis])) axis = k;
    for (int k = 0; k < 3; ++k) v[k] = (k == axis ? 1.0 : 0.0) - n[axis] * n[k];
    norma_core_normalise(v, unit);
    for (int k = 0; k < 3; ++k) out[k] = (float)unit[k] + 0.0F;
}

written_tangent norma_core_tangent_to_write(
    const tangent_vertex *vertex, const corner_tangent *tangent) {
    written_tangent out = {.reason = tangent->reason};
    memcpy(out.numbers, tangent->direction, sizeof tangent->direction);
    out.numbers[3] = tangent->sign;
    if (!norma_core_tangent_is_finite(vertex)) out.reason = NORMA_REASON_NON_FINITE;
    if (out.reason != NORMA_REASON_NONE) perpendicular_to_normal(vertex->normal, out.numbers);
    return out;
}

void norma_core_write_tangent(const tangent_output *output, size_t corner,
    const tangent_vertex *vertex, const corner_tangent *tangent, core_tally *tally) {
    const written_tangent out = norma_core_tangent_to_write(vertex, tangent);
    norma_core_put_tangent(output, corner, &out, tally);
}
