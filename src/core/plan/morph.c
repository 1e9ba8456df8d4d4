/* morph.c: norma_morph_normals. Vertices that share a normal in the base are one vertex of
 * a mesh that is then morphed; both normals come from that mesh, by one plan, so that no seam opens
 * and where nothing moves the delta is exactly zero. */
#include "core/plan/plan.h"
#include <math.h>

typedef struct morph {
    core_call *call;
    core_mesh mesh;                 /* the base */
    const norma_vec3_view *normals; /* NULL, or the base's own */
    uint32_t *group_of, *first_of;  /* of each vertex its group; of each group its first vertex */
    size_t group_count;
    uint32_t *corners;      /* groups */
    double (*positions)[3]; /* of groups */
    float (*base)[3], (*moved)[3];
    uint8_t *base_reasons, *reasons;
    norma_plan *plan;
} morph;

/* ---- groups: one (welded) position, and the bits of one normal */

static void key_of_vertex(const morph *m, uint32_t vertex, double key[4]) {
    key[0] = (double)norma_core_welded(&m->mesh, vertex);
    key[1] = key[2] = key[3] = 0;
    if (!m->normals) return;
    norma_view_read(m->normals, vertex, key + 1);
    for (int k = 1; k < 4; ++k) key[k] += 0.0; /* -0 becomes 0 */
}

static size_t hash_of_key(const double key[4]) {
    uint64_t hash = 0, bits[4];
    memcpy(bits, key, sizeof bits);
    for (int k = 0; k < 4; ++k) {
        hash = (hash ^ bits[k]) * UINT64_C(0x9e3779b97f4a7c15);
        hash ^= hash >> 29;
    }
    return (size_t)hash;
}

static void find_morph_groups(morph *m, uint32_t *table, size_t size) {
    for (uint32_t v = 0; v < m->mesh.positions.count; ++v) {
        double key[4], other[4];
        key_of_vertex(m, v, key);
        size_t at = hash_of_key(key) & (size - 1);
        for (; table[at]; at = (at + 1) & (size - 1)) {
            key_of_vertex(m, m->first_of[table[at] - 1], other);
            if (memcmp(key, other, sizeof key) == 0) break;
        }
        if (!table[at]) {
            m->first_of[m->group_count++] = v;
            table[at] = (uint32_t)m->group_count;
        }
        m->group_of[v] = table[at] - 1;
    }
}

static norma_result group(morph *m) {
    size_t size = 16;
    while (size / 2 < m->mesh.positions.count) size *= 2;
    uint32_t *table = norma_core_allocate(m->call, size, sizeof *table);
    if (!table) return NORMA_ERROR_MEMORY;
    memset(table, 0, size * sizeof *table);
    find_morph_groups(m, table, size);
    norma_core_release(m->call, table, size, sizeof *table);
    for (size_t c = 0; c < m->mesh.corner_count; ++c)
        m->corners[c] = m->group_of[norma_core_corner(&m->mesh, c)];
    return NORMA_OK;
}

/* ---- memory */

static int take_room(morph *m) {
    const size_t vertices = m->mesh.positions.count;
    m->group_of = norma_core_allocate(m->call, vertices, sizeof *m->group_of);
    m->first_of = norma_core_allocate(m->call, vertices, sizeof *m->first_of);
    m->corners = norma_core_allocate(m->call, m->mesh.corner_count, sizeof *m->corners);
    m->positions = norma_core_allocate(m->call, vertices, sizeof *m->positions);
    m->base = norma_core_allocate(m->call, vertices, sizeof *m->base);
    m->moved = norma_core_allocate(m->call, vertices, sizeof *m->moved);
    m->base_reasons = norma_core_allocate(m->call, vertices, 1);
    m->reasons = norma_core_allocate(m->call, vertices, 1);
    return m->group_of && m->first_of && m->corners && m->positions && m->base && m->moved &&
           m->base_reasons && m->reasons;
}

static void give_room(morph *m) {
    const size_t vertices = m->mesh.positions.count;
    norma_plan_destroy(m->plan);
    norma_core_release(m->call, m->group_of, vertices, sizeof *m->group_of);
    norma_core_release(m->call, m->first_of, vertices, sizeof *m->first_of);
    norma_core_release(m->call, m->corners, m->mesh.corner_count, sizeof *m->corners);
    norma_core_release(m->call, m->positions, vertices, sizeof *m->positions);
    norma_core_release(m->call, m->base, vertices, sizeof *m->base);
    norma_core_release(m->call, m->moved, vertices, sizeof *m->moved);
    norma_core_release(m->call, m->base_reasons, vertices, 1);
    norma_core_release(m->call, m->reasons, vertices, 1);
    if (m->mesh.weld) norma_core_unweld(m->call, &m->mesh);
}

/* ---- normals of groups */

static norma_options plan_options(const morph *m, uint8_t *reasons) {
    norma_options options = m->call->options;
    options.struct_size = sizeof options;
    options.weld = NORMA_WELD_NONE;
    options.fallback = NORMA_FALLBACK_ZERO;
    options.normal_stride = 0;
    options.reasons = reasons;
    options.edges = NULL;
    options.progress = NULL;
    return options;
}

static norma_result normals_at(
    morph *m, const norma_vec3_view *positions, float (*normals)[3], uint8_t *reasons) {
    const norma_options options = plan_options(m, reasons);
    for (size_t g = 0; g < m->group_count; ++g)
        norma_view_read(positions, m->first_of[g], m->positions[g]);
    return norma_plan_update(m->plan,
        (norma_vec3_view){m->positions, m->group_count, 0, NORMA_FORMAT_DOUBLE}, NULL, 0, &options,
        (float *)normals, m->group_count, NULL);
}

static norma_result prepare_base(morph *m) {
    const norma_options options = plan_options(m, NULL);
    norma_result result = norma_core_weld(m->call, &m->mesh);
    if (!result && !take_room(m)) result = NORMA_ERROR_MEMORY;
    if (!result) result = group(m);
    if (result) return result;
    for (size_t g = 0; g < m->group_count; ++g)
        norma_view_read(&m->mesh.positions, m->first_of[g], m->positions[g]);
    const norma_mesh groups = {
        .positions = {m->positions, m->group_count, 0, NORMA_FORMAT_DOUBLE},
        .corners = m->corners,
        .corner_count = m->mesh.corner_count,
        .face_starts = m->mesh.face_starts,
        .face_count = m->mesh.face_starts ? m->mesh.face_count : 0,
    };
    result = norma_plan_create(&groups, NORMA_PER_VERTEX, (float)NORMA_PI, &options, &m->plan);
    return !result ? normals_at(m, &m->mesh.positions, m->base, m->base_reasons) : result;
}

/* ---- deltas */

typedef struct morph_output {
    size_t count;
    uint32_t *vertices;
    float *deltas;
} morph_output;

/* What a vertex's normal changes by; 0 where that is nothing. */
static int delta_of(const morph *m, uint32_t vertex, float smallest, float delta[3]) {
    const uint32_t g = m->group_of[vertex];
    double square = 0;
    if (m->reasons[g] || m->base_reasons[g]) return 0;
    for (int k = 0; k < 3; ++k) {
        delta[k] = m->moved[g][k] - m->base[g][k];
        square += (double)delta[k] * (double)delta[k];
    }
    return square > (double)smallest * (double)smallest;
}

static void add_target_deltas(const morph *m, float smallest, morph_output *out) {
    for (uint32_t v = 0; v < m->mesh.positions.count; ++v) {
        float delta[3];
        if (!delta_of(m, v, smallest, delta)) continue;
        if (out->vertices) out->vertices[out->count] = v;
        if (out->deltas) memcpy(out->deltas + 3 * out->count, delta, sizeof delta);
        ++out->count;
    }
}

/* starts: NULL, or where the target's deltas begin. */
static norma_result each_target(morph *m, const norma_vec3_view *targets, size_t count,
    float smallest, size_t *starts, morph_output *out) {
    for (size_t t = 0; t < count; ++t) {
        const norma_result result = normals_at(m, &targets[t], m->moved, m->reasons);
        if (result) return result;
        if (starts) starts[t] = out->count;
        add_target_deltas(m, smallest, out);
        if (norma_core_progress(m->call, (double)t / (double)count)) return NORMA_CANCELLED;
    }
    if (starts) starts[count] = out->count;
    return NORMA_OK;
}

static norma_result fill_deltas(morph *m, const norma_vec3_view *targets, size_t count,
    float smallest, size_t *starts, morph_output *out, size_t capacity) {
    const size_t vertices = m->mesh.positions.count;
    morph_output counted = {0, NULL, NULL};
    norma_result result = prepare_base(m);
    const int must_fit = out->vertices || out->deltas,
              fits = count == 0 || vertices <= capacity / count;
    if (!result && must_fit && !fits)
        result = each_target(m, targets, count, smallest, NULL, &counted);
    if (!result && counted.count > capacity) result = NORMA_ERROR_CAPACITY;
    return !result ? each_target(m, targets, count, smallest, starts, out) : result;
}

static norma_result check_view(const norma_vec3_view *view, size_t count) {
    if (!norma_format_size(view->format) || view->count != count || (count && !view->data))
        return NORMA_ERROR_ARGUMENT;
    return norma_view_overflows(view) ? NORMA_ERROR_OVERFLOW : NORMA_OK;
}

norma_result norma_morph_normals(const norma_mesh *base, const norma_vec3_view *base_normals,
    const norma_vec3_view *targets, size_t target_count, float smallest,
    const norma_options *options, size_t *target_starts, uint32_t *vertices, float *deltas,
    size_t capacity) {
    core_call call;
    morph m = {.call = &call, .normals = base_normals};
    morph_output out = {0, vertices, deltas};
    norma_result result = norma_core_begin(&call, options);
    if (!result && (!(smallest >= 0) || !target_starts || (target_count && !targets)))
        result = NORMA_ERROR_ARGUMENT;
    if (!result) result = norma_core_mesh_shape(base, &m.mesh);
    if (!result) norma_core_share(&call, m.mesh.corner_count);
    if (!result && base_normals) result = check_view(base_normals, m.mesh.positions.count);
    for (size_t t = 0; t < target_count && !result; ++t)
        result = check_view(&targets[t], m.mesh.positions.count);
    if (!result) result = norma_core_mesh_content(&call, &m.mesh);
    if (result) return result;
    result = fill_deltas(&m, targets, target_count, smallest, target_starts, &out, capacity);
    give_room(&m);
    return result;
}

norma_result norma_morph_deltas(const norma_mesh *base, const norma_vec3_view *base_normals,
    const norma_vec3_view *targets, size_t target_count, float smallest,
    const norma_options *options, const norma_morph_output *output) {
    if (!output) return NORMA_ERROR_ARGUMENT;
    return norma_morph_normals(base, base_normals, targets, target_count, smallest, options,
        output->target_starts, output->vertices, output->deltas, output->capacity);
}
