/* mikk.c: MikkTSpace, step by step: triangles, their signs, then vertex by vertex. Begin at
 * run_mikk, at the end. */
#include "core/tangent/tangents.h"
#include "core/face/cut_polygon.h"

/* ---- Of each triangle, whether the texture has an area on it, and of which sign; and
 * what it adds at its corners, so that this is computed once, with all lanes full, and triangle by
 * triangle: vertices then read the little that they need. */

enum { TRIANGLES_IN_TASK = 1 << 12 };

typedef struct flagging {
    mikk_mesh *mesh;
    const mikk_kernels *kernels;
} flagging;

static void load_triangle_lane(
    const mikk_mesh *m, size_t triangle, size_t lane, mikk_batch *batch) {
    for (size_t i = 0; i < 3; ++i) {
        const tangent_vertex *v = &m->vertices[m->triangles[3 * triangle + i]];
        for (int k = 0; k < 3; ++k) batch->position[i][k][lane] = v->position[k];
        for (int k = 0; k < 3; ++k) batch->normal[i][k][lane] = v->normal[k];
        for (int k = 0; k < 2; ++k) batch->texcoord[i][k][lane] = v->texcoord[k];
    }
}

static uint8_t flags_of(const mikk_derivative *d, size_t lane) {
    const int positive = d->area[lane] > 0,
              follows = mikk_is_zero(d->length_s[lane]) || mikk_is_zero(d->length_t[lane]);
    return (uint8_t)((positive ? MIKK_POSITIVE : 0) | (follows ? MIKK_FOLLOWS : 0));
}

static void record_triangle(
    const mikk_mesh *m, size_t triangle, size_t lane, const mikk_addends *addends) {
    const uint32_t *v = m->triangles + 3 * triangle;
    mikk_record *records = m->records + 3 * triangle;
    for (size_t i = 0; i < 3; ++i)
        records[i] = (mikk_record){
            {addends->sum[i][0][lane], addends->sum[i][1][lane], addends->sum[i][2][lane]},
            (uint16_t)addends->ends[i][lane], m->flags[triangle], v[i == 2 ? 0 : i + 1],
            v[i == 0 ? 2 : i - 1]};
}

static void core_mikk_flag_lanes(const mikk_mesh *m, const mikk_kernels *kernels, size_t triangle,
    size_t count, mikk_batch *batch) {
    mikk_addends out;
    for (size_t l = 0; l < count; ++l) load_triangle_lane(m, triangle + l, l, batch);
    if (mikk_has_records(m))
        kernels->add_up(batch, &out);
    else
        kernels->derive(batch, &out.derivative);
    for (size_t l = 0; l < count; ++l) m->flags[triangle + l] |= flags_of(&out.derivative, l);
    for (size_t l = 0; l < count && mikk_has_records(m); ++l)
        record_triangle(m, triangle + l, l, &out);
}

static void flag_task(void *context, size_t task) {
    const flagging *f = context;
    const mikk_mesh *m = f->mesh;
    mikk_batch batch = {0};
    const size_t begin = task * TRIANGLES_IN_TASK,
                 end = m->count - begin < TRIANGLES_IN_TASK ? m->count : begin + TRIANGLES_IN_TASK;
    for (size_t t = begin; t < end; t += MIKK_LANES) {
        const size_t count = end - t < MIKK_LANES ? end - t : MIKK_LANES;
        core_mikk_flag_lanes(m, f->kernels, t, count, &batch);
    }
}

static float texture_area(const mikk_mesh *m, size_t triangle) {
    const float *t[3];
    for (size_t i = 0; i < 3; ++i) t[i] = m->vertices[m->triangles[3 * triangle + i]].texcoord;
    const float x21 = t[1][0] - t[0][0], y21 = t[1][1] - t[0][1], x31 = t[2][0] - t[0][0],
                y31 = t[2][1] - t[0][1], area = x21 * y31 - y21 * x31;
    return area < 0 ? -area : area;
}

/* Both halves of a quad get one sign: that of the larger one, of the first where they are equal or
 * the second has no area. */
static void agree_on_sign(mikk_mesh *m, size_t second) {
    uint8_t *a = &m->flags[second - 1], *b = &m->flags[second];
    if (((*a ^ *b) & MIKK_POSITIVE) == 0) return;
    const int first_decides =
        (*b & MIKK_FOLLOWS) || texture_area(m, second - 1) >= texture_area(m, second);
    *(first_decides ? b : a) ^= MIKK_POSITIVE;
}

/* Meshes of triangles alone have records, and got their flags with these (record_task). */
static norma_result core_mikk_flags(mikk_mesh *m) {
    flagging f = {m, norma_core_mikk_kernels(m->call->options.isa)};
    if (mikk_has_records(m)) return NORMA_OK;
    const norma_result result = norma_core_parallel(
        m->call, m->count / TRIANGLES_IN_TASK + (m->count % TRIANGLES_IN_TASK != 0), flag_task, &f);
    if (result || !m->has_quads) return result;
    for (size_t t = 1; t < m->count; ++t)
        if (m->flags[t] & MIKK_SECOND) agree_on_sign(m, t);
    return NORMA_OK;
}

/* ---- Corners that no triangle holds, because their triangles are degenerate: which
 * corner of a triangle each copies. A quad of one good triangle copies the corner of that triangle
 * that lies at the same position; all others the first corner at their vertex. */

/* Of a face, the corner that no triangle holds, if there is just one; else SIZE_MAX. */
static size_t only_missing(const uint32_t *holders, size_t begin, size_t end) {
    size_t missing = SIZE_MAX, count = 0;
    for (size_t c = begin; c < end; ++c)
        if (holders[c] == MIKK_NONE) {
            missing = c;
            ++count;
        }
    return count == 1 ? missing : SIZE_MAX;
}

static uint32_t source_in_quad(
    const mikk_mesh *m, const uint32_t *holders, size_t begin, size_t missing) {
    const tangent_mesh *in = m->input;
    const float *at = in->vertices[norma_core_tangent_key(in, missing)].position;
    for (size_t c = begin; c < begin + 4; ++c) {
        const float *p = in->vertices[norma_core_tangent_key(in, c)].position;
        if (c != missing && p[0] == at[0] && p[1] == at[1] && p[2] == at[2]) return holders[c];
    }
    return MIKK_NONE;
}

typedef void see_copy(mikk_mesh *m, uint32_t vertex, mikk_copy copy);

static void for_copies(mikk_mesh *m, const uint32_t *holders, see_copy *see) {
    const core_mesh *mesh = &m->input->mesh;
    for (size_t face = 0; face < mesh->face_count; ++face) {
        const size_t begin = norma_core_face_begin(mesh, face),
                     end = norma_core_face_end(mesh, face),
                     missing = end - begin == 4 ? only_missing(holders, begin, end) : SIZE_MAX;
        for (size_t c = begin; c < end; ++c) {
            if (holders[c] != MIKK_NONE) continue;
            const uint32_t source = c == missing ? source_in_quad(m, holders, begin, c) : MIKK_NONE;
            const uint32_t vertex =
                source == MIKK_NONE ? norma_core_tangent_vertex(m->input, c) : m->triangles[source];
            see(m, vertex, (mikk_copy){source, (uint32_t)c});
        }
    }
}

static void count_copy(mikk_mesh *m, uint32_t vertex, mikk_copy copy) {
    (void)copy;
    ++m->copy_starts[vertex];
}

static void place_copy(mikk_mesh *m, uint32_t vertex, mikk_copy copy) {
    m->copies[--m->copy_starts[vertex]] = copy;
}

static norma_result core_mikk_copies(mikk_mesh *m, const uint32_t *holders) {
    const size_t corners = m->input->mesh.corner_count;
    for (size_t c = 0; c < corners; ++c) m->copy_count += holders[c] == MIKK_NONE;
    if (!m->copy_count) return NORMA_OK;
    m->copy_starts = norma_core_allocate(m->call, m->vertex_count + 1, sizeof *m->copy_starts);
    m->copies = norma_core_allocate(m->call, m->copy_count, sizeof *m->copies);
    if (!m->copy_starts || !m->copies) return NORMA_ERROR_MEMORY;
    memset(m->copy_starts, 0, (m->vertex_count + 1) * sizeof *m->copy_starts);
    for_copies(m, holders, count_copy);
    uint32_t sum = 0;
    for (size_t v = 0; v <= m->vertex_count; ++v) m->copy_starts[v] = sum += m->copy_starts[v];
    for_copies(m, holders, place_copy);
    return NORMA_OK;
}

/* ---- Faces as triangles: quads cut along the shorter diagonal, degenerate triangles
 * (two equal positions) left out. */

enum { FACES_IN_TASK = 1 << 13 };

typedef struct cutting {
    mikk_mesh *mesh;
    const uint32_t *starts; /* of the tasks' first triangles; NULL for triangles */
    atomic_int degenerate;  /* there is one */
} cutting;

static const tangent_vertex *vertex_at_corner(const tangent_mesh *m, size_t corner) {
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
    for (size_t i = 0; i < 4; ++i) v[i] = vertex_at_corner(m, first + i);
    const float t02 = square_2(v[2]->texcoord, v[0]->texcoord),
                t13 = square_2(v[3]->texcoord, v[1]->texcoord);
    if (t02 < t13) return 1;
    if (t13 < t02) return 0;
    return !(square_3(v[3]->position, v[1]->position) < square_3(v[2]->position, v[0]->position));
}

static int equal_3(const float a[3], const float b[3]) {
    return (a[0] == b[0]) & (a[1] == b[1]) & (a[2] == b[2]);
}

static void add_cut_triangle(
    cutting *c, size_t triangle, size_t first, uint32_t i, uint32_t j, uint32_t k) {
    const mikk_mesh *m = c->mesh;
    const size_t corners[3] = {first + i, first + j, first + k};
    const float *at[3];
    for (size_t n = 0; n < 3; ++n) {
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
static size_t cut_mikk_face(cutting *c, size_t face, size_t triangle) {
    const core_mesh *mesh = &c->mesh->input->mesh;
    const size_t first = norma_core_face_begin(mesh, face),
                 count = norma_core_face_end(mesh, face) - first;
    if (count < 3 || count > 4) return count < 3 ? 0 : count - 2; /* polygons: later */
    if (count == 3) {
        add_cut_triangle(c, triangle, first, 0, 1, 2);
        return 1;
    }
    const int at_first = is_cut_at_first(c->mesh->input, first);
    add_cut_triangle(c, triangle, first, 0, 1, at_first ? 2 : 3);
    add_cut_triangle(c, triangle + 1, first, at_first ? 0 : 1, 2, 3);
    return 2;
}

static void cut_task(void *context, size_t task) {
    cutting *c = context;
    const size_t faces = c->mesh->input->mesh.face_count, begin = task * FACES_IN_TASK,
                 end = faces - begin < FACES_IN_TASK ? faces : begin + FACES_IN_TASK;
    size_t triangle = c->starts ? c->starts[task] : begin;
    for (size_t face = begin; face < end; ++face) {
        triangle += cut_mikk_face(c, face, triangle);
    }
}

/* ---- triangles alone: each is flagged and recorded when it is first looked at */

/* Of each lane, whether two of the three positions are equal. */
static void find_equal_corners(const mikk_batch *b, uint32_t equal[MIKK_LANES]) {
    for (int l = 0; l < MIKK_LANES; ++l) equal[l] = 0;
    for (int one = 0; one < 3; ++one) {
        const mikk_lane *p = b->position[one], *q = b->position[(one + 1) % 3];
        for (int l = 0; l < MIKK_LANES; ++l)
            equal[l] |= (uint32_t)(p[0][l] == q[0][l]) & (uint32_t)(p[1][l] == q[1][l]) &
                        (uint32_t)(p[2][l] == q[2][l]);
    }
}

static void flag_degenerate(cutting *c, size_t triangle, size_t count, const mikk_batch *batch) {
    uint32_t equal[MIKK_LANES];
    find_equal_corners(batch, equal);
    for (size_t l = 0; l < count; ++l) {
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
        for (size_t i = 3 * t; i < 3 * (t + count); ++i)
            m->triangles[i] = norma_core_tangent_vertex(m->input, i);
        memset(m->flags + t, 0, count);
        core_mikk_flag_lanes(m, kernels, t, count, &batch);
        flag_degenerate(c, t, count, &batch);
    }
}

static size_t task_count(const core_mesh *mesh) {
    return mesh->face_count / FACES_IN_TASK + (mesh->face_count % FACES_IN_TASK != 0);
}

/* Sets where each task's triangles begin. Returns how many there are; *most: the corners of the
 * largest face. */
static size_t count_mikk_triangles(const core_mesh *mesh, uint32_t *starts, size_t *most) {
    size_t count = 0;
    *most = 3;
    for (size_t face = 0; face < mesh->face_count; ++face) {
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
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k)
            cutter->points[i][k] = (double)vertex_at_corner(m, first + i)->position[k];
    if (!norma_core_polygon_fans(cutter, count)) {
        (void)norma_core_cut_polygon(cutter, count, numbers);
        return;
    }
    for (uint32_t t = 0; t + 2 < count; ++t)
        memcpy(numbers + 3 * t, (uint32_t[]){0, t + 1, t + 2}, 3 * sizeof *numbers);
}

static void cut_polygons(cutting *c, core_cutter *cutter, uint32_t *numbers) {
    const core_mesh *mesh = &c->mesh->input->mesh;
    size_t triangle = 0;
    for (size_t face = 0; face < mesh->face_count; ++face) {
        const size_t first = norma_core_face_begin(mesh, face),
                     count = norma_core_face_end(mesh, face) - first,
                     made = count < 3 ? 0 : count - 2;
        if (count > 4) cut_polygon(c->mesh->input, first, count, cutter, numbers);
        for (size_t t = 0; t < made && count > 4; ++t)
            add_cut_triangle(
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

static norma_result allocate_triangles(mikk_mesh *m, int own_corners) {
    m->room = m->count;
    m->triangles = norma_core_allocate(m->call, 3 * m->room, sizeof *m->triangles);
    m->flags = norma_core_allocate(m->call, m->room, sizeof *m->flags);
    if (!CORE_IS_SMALL && own_corners)
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
        for (size_t c = 0; c < 3 * m->count; ++c) m->corners[c] = (uint32_t)c;
    }
    for (size_t t = 0; t < m->count; ++t) {
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
    for (size_t face = 0; face < mesh->face_count; ++face) {
        const size_t begin = norma_core_face_begin(mesh, face),
                     end = norma_core_face_end(mesh, face), first = t;
        for (; t < m->count && m->corners[3 * t] < end; ++t) {
            for (size_t i = 0; i < 3; ++i) {
                uint32_t *holder = &holders[m->corners[3 * t + i]];
                if (*holder != MIKK_NONE) m->flags[t] |= (uint8_t)(MIKK_HELD << i);
                if (*holder == MIKK_NONE) *holder = (uint32_t)(3 * t + i);
            }
            if (t > first && end - begin == 4) m->flags[t] |= MIKK_SECOND;
        }
    }
    const norma_result result = core_mikk_copies(m, holders);
    norma_core_release(m->call, holders, mesh->corner_count, sizeof *holders);
    return result;
}

/* MEMORY or CANCELLED; release_mikk in any case. */
static norma_result core_mikk_triangles(mikk_mesh *m) {
    const core_mesh *mesh = &m->input->mesh;
    const size_t tasks = task_count(mesh);
    cutting c = {.mesh = m};
    uint32_t *starts = NULL;
    size_t most = 3;
    m->count = mesh->face_count;
    if (norma_core_face_starts(mesh)) {
        starts = norma_core_allocate(m->call, tasks, sizeof *starts);
        if (!starts) return NORMA_ERROR_MEMORY;
        m->count = count_mikk_triangles(mesh, starts, &most);
    }
    if (m->count > (UINT32_MAX - 1) / 3) {
        norma_core_release(m->call, starts, tasks, sizeof *starts);
        return NORMA_ERROR_OVERFLOW;
    }
    c.starts = starts;
    m->has_quads = norma_core_face_starts(mesh) && most > 3;
    norma_result result = allocate_triangles(m, norma_core_face_starts(mesh) != NULL);
    if (!result)
        result =
            norma_core_parallel(m->call, tasks, mikk_has_records(m) ? record_task : cut_task, &c);
    if (!result && most > 4) result = cut_large_faces(&c, most);
    norma_core_release(m->call, starts, tasks, sizeof *starts);
    const int degenerate = atomic_load_explicit(&c.degenerate, memory_order_relaxed);
    if (!result && degenerate) result = leave_out_degenerate(m);
    return !result && m->corners ? hold_corners(m) : result;
}

/* ---- Triangles without texture area take the sign of the first group that reaches them.
 * Groups come in the order of their first corner; a group spreads from there along the links first
 * to the left, then to the right. Only at vertices of such triangles does this order matter, and
 * only there are groups looked for here. */

typedef struct following {
    mikk_mesh *mesh;
    uint8_t *touched;       /* of each vertex: such a triangle is there */
    uint32_t *left, *right; /* of each corner at a touched vertex: another corner */
    uint8_t *grouped;       /* of each corner */
    mikk_links links;       /* room for one star */
    uint32_t *next, *previous;
    mikk_edge_table table;
} following;

/* Returns how many corners there are at touched vertices at most in one. */
static size_t touch(following *f) {
    const mikk_mesh *m = f->mesh;
    size_t most = 0;
    memset(f->touched, 0, m->vertex_count);
    for (size_t t = 0; t < m->count; ++t)
        for (size_t i = 0; (m->flags[t] & MIKK_FOLLOWS) && i < 3; ++i) {
            const uint32_t v = m->triangles[3 * t + i];
            const size_t count = m->around.starts[v + 1] - m->around.starts[v];
            f->touched[v] = 1;
            if (count > most) most = count;
        }
    return most;
}

static uint32_t neighbour(const uint32_t *triangles, uint32_t corner, uint32_t by) {
    return triangles[corner - corner % 3 + (corner + by) % 3];
}

/* From numbers in the star to corners of triangles. */
static void link_star(following *f, uint32_t vertex) {
    const mikk_mesh *m = f->mesh;
    const uint32_t *corners = m->around.corners + m->around.starts[vertex];
    const size_t count = m->around.starts[vertex + 1] - m->around.starts[vertex];
    for (size_t j = 0; j < count; ++j) {
        f->next[j] = neighbour(m->triangles, corners[j], 1);
        f->previous[j] = neighbour(m->triangles, corners[j], 2);
    }
    norma_core_mikk_link(f->next, f->previous, count, &f->table, &f->links);
    for (size_t j = 0; j < count; ++j) {
        const uint32_t left = f->links.left[j], right = f->links.right[j];
        f->left[corners[j]] = left == MIKK_NONE ? MIKK_NONE : corners[left];
        f->right[corners[j]] = right == MIKK_NONE ? MIKK_NONE : corners[right];
    }
}

/* Along one of the two lists of links, until a triangle is of the other sign. */
static void spread_sign(following *f, const uint32_t *links, uint32_t seed) {
    uint8_t *flags = f->mesh->flags;
    const uint8_t sign = flags[seed / 3] & MIKK_POSITIVE;
    for (uint32_t c = links[seed]; c != MIKK_NONE && !f->grouped[c]; c = links[c]) {
        uint8_t *flag = &flags[c / 3];
        if ((*flag & MIKK_FOLLOWS) && !(*flag & MIKK_FOLLOWED))
            *flag = (uint8_t)((*flag & ~MIKK_POSITIVE) | sign | MIKK_FOLLOWED);
        if ((*flag & MIKK_POSITIVE) != sign) return;
        f->grouped[c] = 1;
    }
}

static void spread_all(following *f) {
    const mikk_mesh *m = f->mesh;
    memset(f->grouped, 0, 3 * m->count);
    for (uint32_t c = 0; c < 3 * m->count; ++c) {
        if (!f->touched[m->triangles[c]] || f->grouped[c] || (m->flags[c / 3] & MIKK_FOLLOWS))
            continue;
        f->grouped[c] = 1;
        spread_sign(f, f->left, c);
        spread_sign(f, f->right, c);
    }
}

/* Records have the signs that were found, too. */
static void mark_records(const mikk_mesh *m) {
    for (size_t t = 0; m->records && t < m->count; ++t)
        for (size_t i = 0; (m->flags[t] & MIKK_FOLLOWS) && i < 3; ++i)
            m->records[3 * t + i].flags = m->flags[t];
}

static norma_result follow_signs(following *f) {
    mikk_mesh *m = f->mesh;
    const core_call *call = m->call;
    const size_t corners = 3 * m->count, most = touch(f);
    f->left = norma_core_allocate(call, corners, sizeof *f->left);
    f->right = norma_core_allocate(call, corners, sizeof *f->right);
    f->grouped = norma_core_allocate(call, corners, 1);
    uint32_t *star = norma_core_allocate(call, 4 * most, sizeof *star);
    norma_result result = norma_core_mikk_table_open(call, most, &f->table);
    if (!f->left || !f->right || !f->grouped || !star) result = NORMA_ERROR_MEMORY;
    if (!result) {
        f->links = (mikk_links){star, star + most};
        f->next = star + 2 * most;
        f->previous = star + 3 * most;
        for (size_t v = 0; v < m->vertex_count; ++v)
            if (f->touched[v]) link_star(f, (uint32_t)v);
        spread_all(f);
        mark_records(m);
    }
    norma_core_mikk_table_close(call, most, &f->table);
    norma_core_release(call, star, 4 * most, sizeof *star);
    norma_core_release(call, f->left, corners, sizeof *f->left);
    norma_core_release(call, f->right, corners, sizeof *f->right);
    norma_core_release(call, f->grouped, corners, 1);
    return result;
}

static norma_result core_mikk_follow(mikk_mesh *m) {
    int any = 0;
    for (size_t t = 0; t < m->count; ++t) any |= m->flags[t] & MIKK_FOLLOWS;
    if (!any) return NORMA_OK;
    following f = {.mesh = m, .touched = norma_core_allocate(m->call, m->vertex_count, 1)};
    const norma_result result = f.touched ? follow_signs(&f) : NORMA_ERROR_MEMORY;
    norma_core_release(m->call, f.touched, m->vertex_count, 1);
    return result;
}

/* ---- MikkTSpace, step by step. */

/* A counting sort of the triangles' corners by vertex. */
static norma_result sort_mikk_corners(mikk_mesh *mesh) {
    const core_mesh triangles = {.positions = {.count = mesh->vertex_count},
        .corners = mesh->triangles,
        .corner_count = 3 * mesh->count,
        .corner_size = 4,
        .face_count = mesh->count};
    return norma_core_corners_of_position_build(mesh->call, &triangles, &mesh->around);
}

/* A triangle without texture area takes its sign from others, which may take theirs from
 * triangles far away; and a corner of a quad may take the tangent of one with other texture
 * coordinates. */
static int mikk_hangs_on_others(const mikk_mesh *mesh) {
    int hangs = 0;
    for (size_t t = 0; t < mesh->count; ++t) hangs |= mesh->flags[t] & MIKK_FOLLOWS;
    for (size_t i = 0; i < mesh->copy_count; ++i) hangs |= mesh->copies[i].source != MIKK_NONE;
    return hangs != 0;
}

static norma_result run_mikk(mikk_mesh *mesh, const tangent_output *output, core_tally *tally) {
    norma_core_stage(mesh->call, 0.3, 0.4);
    norma_result result = core_mikk_triangles(mesh);
    norma_core_stage(mesh->call, 0.4, 0.5);
    if (!result) result = core_mikk_flags(mesh);
    if (!result && mesh->input->is_awkward && mikk_hangs_on_others(mesh)) {
        *mesh->input->is_awkward = 1;
        return NORMA_OK;
    }
    norma_core_stage(mesh->call, 0.5, 0.6);
    if (!result) result = sort_mikk_corners(mesh);
    if (!result) result = core_mikk_follow(mesh);
    norma_core_stage(mesh->call, 0.6, 0.97);
    return !result ? norma_core_mikk_stars(mesh, output, tally) : result;
}

static void release_mikk(mikk_mesh *mesh) {
    const core_call *call = mesh->call;
    norma_core_release(call, mesh->triangles, 3 * mesh->room, sizeof *mesh->triangles);
    norma_core_release(call, mesh->corners, 3 * mesh->room, sizeof *mesh->corners);
    norma_core_release(call, mesh->flags, mesh->room, sizeof *mesh->flags);
    norma_core_release(call, mesh->records, 3 * mesh->room, sizeof *mesh->records);
    norma_core_release(call, mesh->copy_starts, mesh->vertex_count + 1, sizeof *mesh->copy_starts);
    norma_core_release(call, mesh->copies, mesh->copy_count, sizeof *mesh->copies);
    if (mesh->around.starts) norma_core_corners_of_position_release(call, &mesh->around);
}

norma_result norma_core_mikk_tangents(
    const tangent_mesh *mesh, const tangent_output *output, core_tally *tally) {
    mikk_mesh mikk = {.call = mesh->call,
        .input = mesh,
        .vertices = mesh->vertices,
        .vertex_count = mesh->key_count};
    if (!mesh->mesh.corner_count) return NORMA_OK;
    const norma_result result = run_mikk(&mikk, output, tally);
    release_mikk(&mikk);
    return result;
}
