/* mikk_flags.c: of each triangle, whether the texture has an area on it, and of which sign; and
 * what it adds at its corners, so that this is computed once, with all lanes full, and triangle by
 * triangle: vertices then read the little that they need. */
#include "core/tangent/mikk.h"

enum { TRIANGLES_IN_TASK = 1 << 12 };

typedef struct flagging {
    mikk_mesh *mesh;
    const mikk_kernels *kernels;
} flagging;

static void load(const mikk_mesh *m, size_t triangle, size_t lane, mikk_batch *batch) {
    for (size_t i = 0; i < 3; i++) {
        const tangent_vertex *v = &m->vertices[m->triangles[3 * triangle + i]];
        for (int k = 0; k < 3; k++) batch->position[i][k][lane] = v->position[k];
        for (int k = 0; k < 3; k++) batch->normal[i][k][lane] = v->normal[k];
        for (int k = 0; k < 2; k++) batch->texcoord[i][k][lane] = v->texcoord[k];
    }
}

static uint8_t flags_of(const mikk_derivative *d, size_t lane) {
    const int positive = d->area[lane] > 0,
              follows = mikk_is_zero(d->length_s[lane]) || mikk_is_zero(d->length_t[lane]);
    return (uint8_t)((positive ? MIKK_POSITIVE : 0) | (follows ? MIKK_FOLLOWS : 0));
}

static void record(const mikk_mesh *m, size_t triangle, size_t lane, const mikk_addends *addends) {
    const uint32_t *v = m->triangles + 3 * triangle;
    mikk_record *records = m->records + 3 * triangle;
    for (size_t i = 0; i < 3; i++)
        records[i] = (mikk_record){
            {addends->sum[i][0][lane], addends->sum[i][1][lane], addends->sum[i][2][lane]},
            (uint16_t)addends->ends[i][lane], m->flags[triangle], v[i == 2 ? 0 : i + 1],
            v[i == 0 ? 2 : i - 1]};
}

/* Asks for the vertices of the triangles from this one on. */
static void await_vertices(const mikk_mesh *m, size_t triangle) {
    const size_t rest = m->count - triangle, count = rest < MIKK_LANES ? rest : MIKK_LANES;
    for (size_t c = 3 * triangle; c < 3 * (triangle + count); c++)
        TANGENT_PREFETCH(&m->vertices[m->triangles[c]]);
}

void norma_core_mikk_flag_lanes(const mikk_mesh *m, const mikk_kernels *kernels, size_t triangle,
    size_t count, mikk_batch *batch) {
    mikk_addends out;
    for (size_t l = 0; l < count; l++) load(m, triangle + l, l, batch);
    if (m->records)
        kernels->add_up(batch, &out);
    else
        kernels->derive(batch, &out.derivative);
    for (size_t l = 0; l < count; l++) m->flags[triangle + l] |= flags_of(&out.derivative, l);
    for (size_t l = 0; l < count && m->records; l++) record(m, triangle + l, l, &out);
}

static void flag_task(void *context, size_t task) {
    const flagging *f = context;
    const mikk_mesh *m = f->mesh;
    mikk_batch batch = {0};
    const size_t begin = task * TRIANGLES_IN_TASK,
                 end = m->count - begin < TRIANGLES_IN_TASK ? m->count : begin + TRIANGLES_IN_TASK;
    for (size_t t = begin; t < end; t += MIKK_LANES) {
        const size_t count = end - t < MIKK_LANES ? end - t : MIKK_LANES;
        await_vertices(m, t + count);
        norma_core_mikk_flag_lanes(m, f->kernels, t, count, &batch);
    }
}

static float texture_area(const mikk_mesh *m, size_t triangle) {
    const float *t[3];
    for (size_t i = 0; i < 3; i++) t[i] = m->vertices[m->triangles[3 * triangle + i]].texcoord;
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

norma_result norma_core_mikk_flags(mikk_mesh *m) {
    flagging f = {m, norma_core_mikk_kernels(m->call->options.isa)};
    if (m->records) return NORMA_OK;
    const norma_result result = norma_core_parallel(
        m->call, m->count / TRIANGLES_IN_TASK + (m->count % TRIANGLES_IN_TASK != 0), flag_task, &f);
    if (result != NORMA_OK || !m->has_quads) return result;
    for (size_t t = 1; t < m->count; t++)
        if (m->flags[t] & MIKK_SECOND) agree_on_sign(m, t);
    return NORMA_OK;
}
