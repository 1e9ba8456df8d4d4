/* judge_arguments.c: one argument of a call that is right otherwise is made wrong. The call gives
 * the result that DESIGN.md says ("Arguments"), norma_find_fault gives it too, and nothing has been
 * written. See judge.h. */
#include "oracle/guarded.h"
#include "oracle/judge.h"
#include <math.h>
#include <string.h>

typedef struct wrong_call {
    const norma_mesh *mesh;
    norma_mesh copy;
    norma_options *options;
    struct {
        norma_options options;
        unsigned char surplus[16];
    } later; /* of a library to come */
    float crease;
    float *normals;
    size_t capacity;
    int at_output; /* norma_find_fault sees no output */
    norma_result expected;
} wrong_call;

static int break_options(trial *t, wrong_call *c, uint32_t kind) {
    norma_options *o = c->options;
    switch (kind) {
    case 0:
        o->weight = (norma_weight)7;
        return 1;
    case 1:
        o->weld = (norma_weld)3;
        return 1;
    case 2:
        o->non_manifold = (norma_non_manifold)2;
        return 1;
    case 3:
        o->fallback = (norma_fallback)3;
        return 1;
    case 4:
        o->isa = (norma_isa)99;
        return 1;
    case 5:
        o->normal_stride = 1 + trial_below(t, 11);
        return 1;
    case 6:
        o->fallback = NORMA_FALLBACK_GIVEN;
        o->fallback_normal[trial_below(t, 3)] = trial_below(t, 2) ? NAN : INFINITY;
        return 1;
    case 7:
        o->weld = NORMA_WELD_DISTANCE;
        o->weld_distance = trial_below(t, 2) ? (double)NAN : -1;
        return 1;
    default:
        o->struct_size = sizeof c->later;
        c->later.surplus[trial_below(t, 16)] = 1;
        return 1;
    }
}

static int break_mesh(trial *t, wrong_call *c, uint32_t kind) {
    norma_mesh *m = &c->copy;
    const size_t size = m->corner_size ? m->corner_size : 4;
    unsigned char *corners;
    uint32_t *starts;
    switch (kind) {
    case 0:
        c->mesh = NULL;
        return 1;
    case 1:
        m->positions.data = NULL;
        return m->corner_count > 0 && m->positions.count > 0;
    case 2:
        m->positions.format = (norma_format)6;
        return m->positions.count > 0;
    case 3:
        m->corner_size = 3;
        return m->corners && m->corner_count > 0;
    case 4:
        m->corners = NULL;
        return m->corner_count > m->positions.count;
    case 5:
        if (m->face_starts || m->corner_count == 0) return 0;
        --m->corner_count;
        return 1;
    case 6: /* a start that falls, or does not end where corners do */
        if (!m->face_starts || m->face_count < 2) return 0;
        starts = trial_array(t, m->face_count + 1, 4);
        memcpy(starts, m->face_starts, 4 * (m->face_count + 1));
        starts[1 + trial_below(t, (uint32_t)m->face_count)] = UINT32_MAX;
        m->face_starts = starts;
        return 1;
    default: /* a corner names a position that is not there */
        if (!m->corners || m->corner_count == 0 || (size == 1 && m->positions.count > 255))
            return 0;
        corners = trial_array(t, m->corner_count, size);
        memcpy(corners, m->corners, size * m->corner_count);
        memset(corners + size * trial_below(t, (uint32_t)m->corner_count), 0xFF, size);
        m->corners = corners;
        c->expected = NORMA_ERROR_INDEX;
        return 1;
    }
}

static int break_call(trial *t, wrong_call *c) {
    static const float creases[] = {(float)NAN, (float)INFINITY, 3.2F, 180};
    const uint32_t kind = trial_below(t, 22);
    switch (kind) {
    case 0:
        c->crease = creases[trial_below(t, 4)];
        return 1;
    case 1:
        c->at_output = 1;
        c->normals = NULL;
        return c->capacity > 0;
    case 2:
        c->at_output = 1;
        c->expected = NORMA_ERROR_CAPACITY;
        return c->capacity-- > 0;
    default:
        return kind < 12 ? break_options(t, c, kind - 3) : break_mesh(t, c, (kind - 12) % 8);
    }
}

static int is_untouched(const void *memory, size_t size) {
    const unsigned char *at = memory;
    for (size_t i = 0; i < size; ++i)
        if (at[i] != GUARDED_POISON) return 0;
    return 1;
}

void judge_arguments(trial *t) {
    const size_t count = t->o.corner_count;
    wrong_call c = {.copy = t->mesh,
        .later.options = t->options,
        .crease = t->made->crease,
        .capacity = count,
        .expected = NORMA_ERROR_ARGUMENT};
    norma_report report;
    norma_fault fault;
    c.mesh = &c.copy;
    c.options = &c.later.options;
    c.normals = trial_array(t, count, 12);
    uint8_t *reasons = trial_array(t, count, 1);
    float *memory = c.normals;
    c.options->reasons = reasons;
    memset(&report, GUARDED_POISON, sizeof report);
    if (!break_call(t, &c)) return;
    const norma_result result =
        norma_corner_normals(c.mesh, c.crease, c.options, c.normals, c.capacity, &report);
    if (result != c.expected)
        complain(t, "an argument is wrong, and the result is", (size_t)-result);
    const norma_result why = norma_find_fault(c.mesh, &c.crease, c.options, &fault);
    if (why != (c.at_output ? NORMA_OK : c.expected))
        complain(t, "an argument is wrong, and its fault is", (size_t)-why);
    if (!c.at_output && (!fault.argument || !fault.expected))
        complain(t, "a fault does not say which argument", 0);
    if (!is_untouched(memory, 12 * count) || !is_untouched(reasons, count) ||
        !is_untouched(&report, sizeof report))
        complain(t, "written, though an argument is wrong", count);
}
