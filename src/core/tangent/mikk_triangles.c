/* mikk_triangles.c: faces as triangles: quads cut along the shorter diagonal, degenerate triangles
 * (two equal positions) left out. */
#include "core/face/cut_polygon.h"
#include "core/tangent/mikk.h"
#include "core/tangent/tangent_plan.h"

enum { FACES_IN_TASK = 1 << 13 };

typedef struct cutting {
    mikk_mesh *mesh;
    const uint32_t *starts; /* of the tasks' first triangles; NULL for triangles */
    atomic_int degenerate;  /* there is one */
} cutting;

static const tangent_vertex *vertex_of(const tangent_mesh *m, size_t corner) {
    return &m->vertices[norma_core_tangent_key(m, corner)];
}

static float square_2(const float a[2], const float b[2]) {
    const float x = a[0] - b[0], y = a[1] - b[1];
    return x * x + y * y;
}

static float square_3(const float a[3], const float b[3]) {
    const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
}

/* Whether a quad is cut between its first and its third corner. */
static int is_cut_at_first(const tangent_mesh *m, size_t first) {
    const tangent_vertex *v[4];
    for (size_t i = 0; i < 4; i++) v[i] = vertex_of(m, first + i);
    const float t02 = square_2(v[2]->texcoord, v[0]->texcoord),
                t13 = square_2(v[3]->texcoord, v[1]->texcoord);
    if (t02 < t13) return 1;
    if (t13 < t02) return 0;
    return !(square_3(v[3]->position, v[1]->position) < square_3(v[2]->position, v[0]->position));
}

static int equal_3(const float a[3], const float b[3]) {
    return (a[0] == b[0]) & (a[1] == b[1]) & (a[2] == b[2]);
}

static void add_triangle(
    cutting *c, size_t triangle, size_t first, uint32_t i, uint32_t j, uint32_t k) {
    const mikk_mesh *m = c->mesh;
    const size_t corners[3] = {first + i, first + j, first + k};
    const float *at[3];
    for (size_t n = 0; n < 3; n++) {
        const uint32_t vertex = norma_core_tangent_vertex(m->input, corners[n]);
        m->triangles[3 * triangle + n] = vertex;
        if (m->corners) m->corners[3 * triangle + n] = (uint32_t)corners[n];
        at[n] = m->vertices[vertex].position;
    }
    /* A vertex that is not a number is not equal to itself, but is one vertex. */
    const uint32_t *v = m->triangles + 3 * triangle;
    const int degenerate = equal_3(at[0], at[1]) | equal_3(at[0], at[2]) | equal_3(at[1], at[2]) |
                           (v[0] == v[1]) | (v[0] == v[2]) | (v[1] == v[2]);
    m->flags[triangle] = (uint8_t)(degenerate ? MIKK_DEGENERATE : 0);
    if (degenerate) atomic_store_explicit(&c->degenerate, 1, memory_order_relaxed);
}

/* Returns how many triangles it makes. */
static size_t cut_face(cutting *c, size_t face, size_t triangle) {
    const core_mesh *mesh = &c->mesh->input->mesh;
    const size_t first = norma_core_face_begin(mesh, face),
                 count = norma_core_face_end(mesh, face) - first;
    if (count < 3 || count > 4) return count < 3 ? 0 : count - 2; /* polygons: later */
    if (count == 3) {
        add_triangle(c, triangle, first, 0, 1, 2);
        return 1;
    }
    const int at_first = is_cut_at_first(c->mesh->input, first);
    add_triangle(c, triangle, first, 0, 1, at_first ? 2 : 3);
    add_triangle(c, triangle + 1, first, at_first ? 0 : 1, 2, 3);
    return 2;
}

static void cut_task(void *context, size_t task) {
    cutting *c = context;
    const size_t faces = c->mesh->input->mesh.face_count, begin = task * FACES_IN_TASK,
                 end = faces - begin < FACES_IN_TASK ? faces : begin + FACES_IN_TASK;
    size_t triangle = c->starts ? c->starts[task] : begin;
    for (size_t face = begin; face < end; face++) {
        norma_core_tangent_await(c->mesh->input, face + TANGENT_FACES_AHEAD);
        triangle += cut_face(c, face, triangle);
    }
}

/* ---- triangles alone: each is flagged and recorded when it is first looked at */

/* Of each lane, whether two of the three positions are equal. */
static void find_equal(const mikk_batch *b, uint32_t equal[MIKK_LANES]) {
    for (int l = 0; l < MIKK_LANES; l++) equal[l] = 0;
    for (int one = 0; one < 3; one++) {
        const mikk_lane *p = b->position[one], *q = b->position[(one + 1) % 3];
        for (int l = 0; l < MIKK_LANES; l++)
            equal[l] |= (uint32_t)(p[0][l] == q[0][l]) & (uint32_t)(p[1][l] == q[1][l]) &
                        (uint32_t)(p[2][l] == q[2][l]);
    }
}

static void flag_degenerate(cutting *c, size_t triangle, size_t count, const mikk_batch *batch) {
    uint32_t equal[MIKK_LANES];
    find_equal(batch, equal);
    for (size_t l = 0; l < count; l++) {
        const uint32_t *v = c->mesh->triangles + 3 * (triangle + l);
        if (!(equal[l] | (v[0] == v[1]) | (v[0] == v[2]) | (v[1] == v[2]))) continue;
        c->mesh->flags[triangle + l] |= MIKK_DEGENERATE;
        atomic_store_explicit(&c->degenerate, 1, memory_order_relaxed);
    }
}

static void record_task(void *context, size_t task) {
    cutting *c = context;
    const mikk_mesh *m = c->mesh;
    const mikk_kernels *kernels = norma_core_mikk_kernels(m->call->options.isa);
    const size_t begin = task * FACES_IN_TASK,
                 end = m->count - begin < FACES_IN_TASK ? m->count : begin + FACES_IN_TASK;
    mikk_batch batch = {0};
    for (size_t t = begin; t < end; t += MIKK_LANES) {
        const size_t count = end - t < MIKK_LANES ? end - t : MIKK_LANES;
        for (size_t l = 0; l < count; l++) norma_core_tangent_await(m->input, t + l + MIKK_LANES);
        for (size_t i = 3 * t; i < 3 * (t + count); i++)
            m->triangles[i] = norma_core_tangent_vertex(m->input, i);
        memset(m->flags + t, 0, count);
        norma_core_mikk_flag_lanes(m, kernels, t, count, &batch);
        flag_degenerate(c, t, count, &batch);
    }
}

static size_t task_count(const core_mesh *mesh) {
    return mesh->face_count / FACES_IN_TASK + (mesh->face_count % FACES_IN_TASK != 0);
}

/* Sets where each task's triangles begin. Returns how many there are; *most: the corners of the
 * largest face. */
static size_t count_triangles(const core_mesh *mesh, uint32_t *starts, size_t *most) {
    size_t count = 0;
    *most = 3;
    for (size_t face = 0; face < mesh->face_count; face++) {
        const size_t corners = norma_core_face_end(mesh, face) - norma_core_face_begin(mesh, face);
        if (face % FACES_IN_TASK == 0) starts[face / FACES_IN_TASK] = (uint32_t)count;
        if (corners > 2) count += corners - 2;
        if (corners > *most) *most = corners;
    }
    return count;
}

/* Numbers of its corners, three for each of count - 2 triangles. */
static void cut_polygon(
    const tangent_mesh *m, size_t first, size_t count, core_cutter *cutter, uint32_t *numbers) {
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            cutter->points[i][k] = (double)vertex_of(m, first + i)->position[k];
    if (!norma_core_polygon_fans(cutter, count)) {
        (void)norma_core_cut_polygon(cutter, count, numbers);
        return;
    }
    for (uint32_t t = 0; t + 2 < count; t++)
        memcpy(numbers + 3 * t, (uint32_t[]){0, t + 1, t + 2}, 3 * sizeof *numbers);
}

static void cut_polygons(cutting *c, core_cutter *cutter, uint32_t *numbers) {
    const core_mesh *mesh = &c->mesh->input->mesh;
    size_t triangle = 0;
    for (size_t face = 0; face < mesh->face_count; face++) {
        const size_t first = norma_core_face_begin(mesh, face),
                     count = norma_core_face_end(mesh, face) - first,
                     made = count < 3 ? 0 : count - 2;
        if (count > 4) cut_polygon(c->mesh->input, first, count, cutter, numbers);
        for (size_t t = 0; t < made && count > 4; t++)
            add_triangle(
                c, triangle + t, first, numbers[3 * t], numbers[3 * t + 1], numbers[3 * t + 2]);
        triangle += made;
    }
}

static norma_result cut_large_faces(cutting *c, size_t most) {
    const core_call *call = c->mesh->call;
    const size_t size = norma_core_cutter_size(most);
    uint32_t *numbers = norma_core_allocate(call, 3 * most, sizeof *numbers);
    void *memory = norma_core_allocate(call, size, 1);
    const int ready = numbers && memory;
    if (ready) {
        core_cutter cutter;
        norma_core_cutter_begin(&cutter, memory, most, c->mesh->input->mesh.corner_count);
        cut_polygons(c, &cutter, numbers);
    }
    norma_core_release(call, numbers, 3 * most, sizeof *numbers);
    norma_core_release(call, memory, size, 1);
    return ready ? NORMA_OK : NORMA_ERROR_MEMORY;
}

static norma_result allocate(mikk_mesh *m, int own_corners) {
    m->room = m->count;
    m->triangles = norma_core_allocate(m->call, 3 * m->room, sizeof *m->triangles);
    m->flags = norma_core_allocate(m->call, m->room, sizeof *m->flags);
    if (own_corners)
        m->corners = norma_core_allocate(m->call, 3 * m->room, sizeof *m->corners);
    else
        m->records = norma_core_allocate(m->call, 3 * m->room, sizeof *m->records);
    return m->triangles && m->flags && (m->corners || m->records) ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* Good triangles move to the front in their order. */
static norma_result leave_out_degenerate(mikk_mesh *m) {
    size_t kept = 0;
    if (!m->corners) {
        m->corners = norma_core_allocate(m->call, 3 * m->room, sizeof *m->corners);
        if (!m->corners) return NORMA_ERROR_MEMORY;
        for (size_t c = 0; c < 3 * m->count; c++) m->corners[c] = (uint32_t)c;
    }
    for (size_t t = 0; t < m->count; t++) {
        if (m->flags[t] & MIKK_DEGENERATE) continue;
        memmove(m->triangles + 3 * kept, m->triangles + 3 * t, 3 * sizeof *m->triangles);
        memmove(m->corners + 3 * kept, m->corners + 3 * t, 3 * sizeof *m->corners);
        if (m->records) memmove(m->records + 3 * kept, m->records + 3 * t, 3 * sizeof *m->records);
        m->flags[kept++] = m->flags[t];
    }
    m->count = kept;
    return NORMA_OK;
}

/* Which corner of a triangle is the first to hold each of the caller's; what no one holds is to be
 * copied. Marks those that are not first, and second halves of quads. */
static norma_result hold_corners(mikk_mesh *m) {
    const core_mesh *mesh = &m->input->mesh;
    uint32_t *holders = norma_core_allocate(m->call, mesh->corner_count, sizeof *holders);
    if (!holders) return NORMA_ERROR_MEMORY;
    memset(holders, 0xff, mesh->corner_count * sizeof *holders);
    size_t t = 0;
    for (size_t face = 0; face < mesh->face_count; face++) {
        const size_t begin = norma_core_face_begin(mesh, face),
                     end = norma_core_face_end(mesh, face), first = t;
        for (; t < m->count && m->corners[3 * t] < end; t++) {
            for (size_t i = 0; i < 3; i++) {
                uint32_t *holder = &holders[m->corners[3 * t + i]];
                if (*holder != MIKK_NONE) m->flags[t] |= (uint8_t)(MIKK_HELD << i);
                if (*holder == MIKK_NONE) *holder = (uint32_t)(3 * t + i);
            }
            if (t > first && end - begin == 4) m->flags[t] |= MIKK_SECOND;
        }
    }
    const norma_result result = norma_core_mikk_copies(m, holders);
    norma_core_release(m->call, holders, mesh->corner_count, sizeof *holders);
    return result;
}

/* Where the triangles are those that a plan knows, so are the corners at each vertex. Returns
 * whether the flags are, too: what copies a corner hangs on positions, and is found anew. */
static int take_known(mikk_mesh *m) {
    const mikk_mesh *known = m->input->known ? m->input->known->mikk : NULL;
    const size_t size = 3 * m->count * sizeof *m->triangles;
    if (!known || m->count != known->count || !m->corners != !known->corners ||
        memcmp(m->triangles, known->triangles, size) != 0 ||
        (m->corners && memcmp(m->corners, known->corners, size) != 0))
        return 0;
    m->around = known->around;
    m->is_sorted = 1;
    if (known->copy_count) return 0;
    if (!m->records) memcpy(m->flags, known->flags, m->count);
    return 1;
}

norma_result norma_core_mikk_triangles(mikk_mesh *m) {
    const core_mesh *mesh = &m->input->mesh;
    const size_t tasks = task_count(mesh);
    cutting c = {.mesh = m};
    uint32_t *starts = NULL;
    size_t most = 3;
    m->count = mesh->face_count;
    if (mesh->face_starts) {
        starts = norma_core_allocate(m->call, tasks, sizeof *starts);
        if (!starts) return NORMA_ERROR_MEMORY;
        m->count = count_triangles(mesh, starts, &most);
    }
    if (m->count > (UINT32_MAX - 1) / 3) {
        norma_core_release(m->call, starts, tasks, sizeof *starts);
        return NORMA_ERROR_OVERFLOW;
    }
    c.starts = starts;
    m->has_quads = mesh->face_starts && most > 3;
    norma_result result = allocate(m, mesh->face_starts != NULL);
    if (result == NORMA_OK)
        result = norma_core_parallel(m->call, tasks, m->records ? record_task : cut_task, &c);
    if (result == NORMA_OK && most > 4) result = cut_large_faces(&c, most);
    norma_core_release(m->call, starts, tasks, sizeof *starts);
    const int degenerate = atomic_load_explicit(&c.degenerate, memory_order_relaxed);
    if (result == NORMA_OK && degenerate) result = leave_out_degenerate(m);
    if (result == NORMA_OK && take_known(m)) return NORMA_OK;
    return result == NORMA_OK && m->corners ? hold_corners(m) : result;
}
