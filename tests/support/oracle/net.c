/* net.c: see net.h. Each call is made twice: as the case has it, into memory that is guarded,
 * strided and poisoned, and as plainly as can be. Both must give the same bits, and those are
 * judged. */
#include "oracle/net.h"
#include "accountant.h"
#include "oracle/guarded.h"
#include "oracle/judge.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LARGEST_WATCHED = 4000, WATCHED_ONE_IN = 256 };

static void backwards(void *user, size_t count, norma_task *task, void *context) {
    (void)user;
    while (count > 0) task(context, --count);
}

/* ---- handing the mesh over */

static void put(unsigned char *at, double x, norma_format format) {
    const float f = (float)x;
    const int16_t i = format == NORMA_FORMAT_INT16 ? (int16_t)x : 0;
    const uint16_t u = format == NORMA_FORMAT_UINT16 ? (uint16_t)x : 0;
    switch (format) {
    case NORMA_FORMAT_FLOAT:
        memcpy(at, &f, sizeof f);
        return;
    case NORMA_FORMAT_DOUBLE:
        memcpy(at, &x, sizeof x);
        return;
    case NORMA_FORMAT_INT8:
        *(signed char *)at = (signed char)x;
        return;
    case NORMA_FORMAT_UINT8:
        *at = (unsigned char)x;
        return;
    case NORMA_FORMAT_INT16:
        memcpy(at, &i, sizeof i);
        return;
    default:
        memcpy(at, &u, sizeof u);
    }
}

static void hand_over_positions(trial *t) {
    static const size_t sizes[] = {4, 8, 1, 1, 2, 2};
    const made_case *made = t->made;
    const size_t one = sizes[made->format], stride = 3 * one + made->position_gap,
                 count = made->position_count;
    unsigned char *data = trial_array(t, count ? (count - 1) * stride + 3 * one : 0, 1);
    for (size_t v = 0; v < count; ++v)
        for (size_t k = 0; k < 3; ++k)
            put(data + v * stride + k * one, made->positions[v][k], made->format);
    t->mesh.positions =
        (norma_vec3_view){data, count, made->position_gap ? stride : 0, made->format};
}

static void hand_over(trial *t) {
    const made_case *made = t->made;
    norma_mesh *mesh = &t->mesh;
    const size_t size = made->corner_size ? made->corner_size : 4, corners = made->corner_count;
    hand_over_positions(t);
    mesh->corner_count = corners;
    mesh->corner_size = made->corner_size;
    if (!made->soup) {
        unsigned char *names = trial_array(t, corners, size);
        for (size_t i = 0; i < corners; ++i) {
            const uint16_t narrow = (uint16_t)made->corners[i];
            const uint8_t byte = (uint8_t)made->corners[i];
            memcpy(names + i * size,
                size == 4   ? (const void *)&made->corners[i]
                : size == 2 ? (const void *)&narrow
                            : (const void *)&byte,
                size);
        }
        mesh->corners = names;
    }
    if (made->polygons) {
        mesh->face_count = made->face_count;
        mesh->face_starts = memcpy(
            trial_array(t, made->face_count + 1, 4), made->starts, 4 * (made->face_count + 1));
    }
    if (made->has_groups)
        mesh->smoothing_groups =
            memcpy(trial_array(t, made->face_count, 4), made->groups, 4 * made->face_count);
    if (made->has_hard) mesh->hard_edges = memcpy(trial_array(t, corners, 1), made->hard, corners);
}

static int has_instructions(norma_isa isa) {
    const norma_options options = {.isa = isa};
    const norma_mesh none = {0};
    return !norma_face_normals(&none, &options, NULL, 0, NULL);
}

/* ---- one call */

typedef enum element { FACES, VERTICES, CORNERS } element;

static const char *const names[] = {"face normals", "vertex normals", "corner normals"};

typedef struct normals_call {
    trial *t;
    element of;
    norma_options options;
    unsigned char *memory;
    size_t count, stride;
    norma_report report;
    norma_edges edges;
    norma_result result;
} normals_call;

/* What is read before it is written is then no number that anybody wrote. */
#if defined(__GNUC__)
__attribute__((noinline))
#endif
static void
soil_stack(void) {
    unsigned char below[1 << 18];
    memset(below, GUARDED_POISON, sizeof below);
    __asm__ volatile("" : : "r"(below) : "memory");
}

static void perform(void *context) {
    normals_call *c = context;
    if (c->t->made->corner_count > 80) soil_stack();
    float *out = (float *)(void *)c->memory;
    memset(&c->report, GUARDED_POISON, sizeof c->report);
    c->result = c->of == FACES
                    ? norma_face_normals(&c->t->mesh, &c->options, out, c->count, &c->report)
                : c->of == VERTICES
                    ? norma_vertex_normals(&c->t->mesh, &c->options, out, c->count, &c->report)
                    : norma_corner_normals(
                          &c->t->mesh, c->t->made->crease, &c->options, out, c->count, &c->report);
}

static size_t bytes_of(const normals_call *c) {
    return c->count ? (c->count - 1) * c->stride + 12 : 0;
}

static normals_call prepare(trial *t, element of, size_t stride) {
    normals_call c = {.t = t, .of = of, .options = t->options, .stride = stride};
    c.count = of == FACES      ? t->o.face_count
              : of == VERTICES ? t->o.position_count
                               : t->o.corner_count;
    c.memory = trial_array(t, bytes_of(&c), 1);
    c.options.normal_stride = stride == 12 && trial_below(t, 2) ? 0 : stride;
    c.options.reasons = trial_array(t, c.count, 1);
    return c;
}

/* Each byte of a normal, and of a reason, is written once; none beside them; nothing is read. */
static void watch_output(normals_call *c) {
    static unsigned char writes[LARGEST_WATCHED];
    const size_t size = bytes_of(c);
    if (size > LARGEST_WATCHED || c->options.threads > 1) return;
    long reads = guarded_watch(c->memory, size, perform, c, writes);
    if (reads < 0) return;
    if (reads) complain(c->t, "normals are read back, times", (size_t)reads);
    for (size_t i = 0; i < size; ++i)
        if (writes[i] != (i % c->stride < 12)) {
            complain(c->t, names[c->of], 0);
            complain(c->t, writes[i] > 1 ? "written more than once: byte" : "not written: byte", i);
            return;
        }
    reads = guarded_watch(c->options.reasons, c->count, perform, c, writes);
    if (reads) complain(c->t, "reasons are read back, times", (size_t)reads);
    for (size_t i = 0; i < c->count; ++i)
        if (writes[i] != 1) {
            complain(c->t, names[c->of], writes[i]);
            complain(c->t, "not written once: reason", i);
            return;
        }
}

static float *tight_copy(const normals_call *c) {
    float *tight = oracle_allocate(c->count, 12);
    for (size_t i = 0; i < c->count; ++i) memcpy(tight + 3 * i, c->memory + i * c->stride, 12);
    for (size_t i = 0; i < bytes_of(c); ++i)
        if (i % c->stride >= 12 && c->memory[i] != GUARDED_POISON) {
            complain(c->t, "written between normals: byte", i);
            break;
        }
    return tight;
}

static void judge_answer(const normals_call *c, const float *tight) {
    trial *t = c->t;
    const answer a = {tight, c->options.reasons, &c->report, &c->edges};
    if (c->of == FACES) judge_faces(&t->total, t->name, &t->o, &c->options, &a);
    if (c->of == VERTICES) judge_vertices(&t->total, t->name, &t->o, &c->options, &a, 1);
    if (c->of == CORNERS) judge_corners(&t->total, t->name, &t->o, &t->fans, &c->options, &a);
}

/* Returns the normals, to be freed. */
static float *judge_normals(trial *t, element of) {
    normals_call c = prepare(t, of, 12 + t->made->normal_gap), plain = prepare(t, of, 12);
    c.options.edges = of == CORNERS ? &c.edges : NULL;
    plain.options.edges = of == CORNERS ? &plain.edges : NULL;
    plain.options.threads = 1;
    plain.options.isa = NORMA_ISA_PORTABLE;
    plain.options.parallel_for = NULL;
    plain.options.allocator = (norma_allocator){0};
    perform(&c);
    perform(&plain);
    float *tight = tight_copy(&c);
    if (c.result || plain.result) {
        complain(t, names[of], (size_t) - (c.result ? c.result : plain.result));
        return tight;
    }
    if (memcmp(tight, plain.memory, 12 * c.count) ||
        memcmp(c.options.reasons, plain.options.reasons, c.count) ||
        memcmp(&c.report, &plain.report, sizeof c.report) ||
        memcmp(&c.edges, &plain.edges, sizeof c.edges))
        complain(t, "other bits by threads, instructions or stride:", (size_t)of);
    judge_answer(&c, tight);
    if (trial_below(t, WATCHED_ONE_IN) == 0 || t->made->salt == 0) watch_output(&c);
    return tight;
}

/* Whether two positions lie so near to the welding distance that rounding decides. */
static int is_near_distance(const trial *t) {
    const long double d = (long double)t->options.weld_distance;
    for (size_t v = 0; v < t->made->position_count; ++v)
        for (size_t w = 0; w < v; ++w) {
            const double *a = t->made->positions[v], *b = t->made->positions[w];
            const long double x = (long double)a[0] - (long double)b[0],
                              y = (long double)a[1] - (long double)b[1],
                              z = (long double)a[2] - (long double)b[2];
            const long double off = x * x + y * y + z * z - d * d;
            if (fabsl(off) < 1e-12L * d * d && !(off == 0)) return 1;
        }
    return 0;
}

size_t net_judge(const char *name, const made_case *made) {
    trial t = {.name = name, .made = made, .options = made->options, .salt = made->salt};
    accountant scratch = {0};
    guarded_reset();
    t.options.allocator = (norma_allocator){accountant_take, accountant_give, &scratch};
    if (!has_instructions(t.options.isa)) t.options.isa = NORMA_ISA_BEST;
    if (made->backwards) t.options.parallel_for = backwards;
    while (t.options.weld == NORMA_WELD_DISTANCE && is_near_distance(&t))
        t.options.weld_distance *= 0.875;
    hand_over(&t);
    oracle_create(&t.o, &t.mesh, t.options.weld, t.options.weld_distance);
    oracle_fans_create(&t.fans, &t.o, made->crease, t.options.non_manifold, COMPARE_DOUBT_RAD);
    free(judge_normals(&t, FACES));
    free(judge_normals(&t, VERTICES));
    t.corner_normals = judge_normals(&t, CORNERS);
    judge_split(&t);
    judge_plans(&t);
    if (trial_below(&t, 2)) judge_orientation(&t);
    if (trial_below(&t, 2)) judge_tangents(&t);
    if (trial_below(&t, 2)) judge_arguments(&t);
    if (trial_below(&t, 4) == 0) judge_matrices(&t);
    if (scratch.live || scratch.wrong)
        complain(&t, "scratch memory that is not given back:", scratch.live);
    free(t.corner_normals);
    oracle_fans_destroy(&t.fans);
    oracle_destroy(&t.o);
    return t.total.wrong;
}

/* ---- many */

static made_case judged;

static void print_judged(void) {
    made_case_print(&judged, stdout);
    fflush(stdout);
}

size_t net_judge_seeds(uint64_t first, uint64_t last) {
    enum { MOST_WRONG = 20 };
    size_t wrong = 0;
    guarded_on_crash(print_judged);
    for (uint64_t seed = first; seed <= last && wrong < MOST_WRONG; ++seed) {
        char name[40];
        snprintf(name, sizeof name, "seed %llu", (unsigned long long)seed);
        made_case_of_seed(&judged, seed);
        const size_t here = net_judge(name, &judged);
        if (here && !wrong) print_judged();
        wrong += here;
    }
    return wrong;
}
