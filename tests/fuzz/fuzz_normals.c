/* fuzz_normals.c: normals of faces, vertices and corners, and split, of any arrays with any
 * options: nothing is written beside the normals, each is unit or what was asked for instead, the
 * reasons add up to the report, and one thread in order gives the same bits as several, or jobs run
 * backwards, or portable code. */
#include "made_mesh.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { OF_FACES, OF_VERTICES, OF_CORNERS, SPLIT, WHATS };

typedef struct outcome {
    norma_result result;
    norma_report report;
    float *normals; /* tight */
    uint8_t *reasons;
    uint32_t *corners, *sources;
    size_t count; /* of normals */
} outcome;

static float crease_of(fuzz_bytes *bytes) {
    static const float creases[] = {1.0471976f, 0.f, 3.1415927f, 3.1425f, -1.f, 0.5f, 1e-6f, NAN};
    uint8_t kind = fuzz_u8(bytes);
    return kind == 255 ? fuzz_float(bytes) : creases[kind % (kind > 250 ? 8 : 7)];
}

/* What lies between the normals and behind the last stays as it was. */
static void copy_normals(
    const uint8_t *at, size_t count, size_t stride, size_t room, float *normals) {
    for (size_t i = 0; i < count; ++i) memcpy(normals + 3 * i, at + i * stride, 12);
    for (size_t i = 0; i < room; ++i)
        if ((i >= count * stride || i % stride >= 12) && at[i] != 0xA5)
            fuzz_fail("byte %zu, which belongs to no normal, was written", i);
}

static size_t expected_count(const made_mesh *made, int what) {
    return what == OF_FACES      ? made->faces
           : what == OF_VERTICES ? made->mesh.positions.count
                                 : made->mesh.corner_count;
}

static void run(const made_mesh *made, int what, float crease, const norma_options *given,
    size_t short_by, outcome *out) {
    norma_options options = *given;
    size_t most = expected_count(made, what) > 4096
                      ? 0
                      : expected_count(made, what); /* more than that are counts to be refused */
    size_t capacity = most > short_by ? most - short_by : 0,
           stride = options.normal_stride ? options.normal_stride : 12,
           room = capacity ? (capacity - 1) * stride + 12 : 0;
    uint8_t *memory = malloc(room + 1);
    memset(memory, 0xA5, room + 1);
    *out = (outcome){.normals = calloc(3 * most + 1, sizeof(float)),
        .reasons = calloc(most + 1, 1),
        .corners = calloc(most + 1, 4),
        .sources = calloc(most + 1, 4),
        .count = capacity};
    options.reasons = out->reasons;
    switch (what) {
    case OF_FACES:
        out->result = norma_face_normals(
            &made->mesh, &options, (float *)(void *)memory, capacity, &out->report);
        break;
    case OF_VERTICES:
        out->result = norma_vertex_normals(
            &made->mesh, &options, (float *)(void *)memory, capacity, &out->report);
        break;
    case OF_CORNERS:
        out->result = norma_corner_normals(
            &made->mesh, crease, &options, (float *)(void *)memory, capacity, &out->report);
        break;
    default:
        out->result = norma_split(&made->mesh, crease, &options, out->corners, most, out->sources,
            (float *)(void *)memory, capacity, &out->count, &out->report);
        if (!out->result && out->count > capacity)
            fuzz_fail("%zu new vertices in room for %zu", out->count, capacity);
    }
    if (!out->result) copy_normals(memory, out->count, stride, room, out->normals);
    free(memory);
}

static void free_outcome(outcome *out) {
    free(out->normals);
    free(out->reasons);
    free(out->corners);
    free(out->sources);
}

static int is_given(const float *normal, const norma_options *options) {
    for (int k = 0; k < 3; ++k)
        if (!(normal[k] == options->fallback_normal[k] ||
                (isnan(normal[k]) && isnan(options->fallback_normal[k]))))
            return 0;
    return 1;
}

static void judge(const outcome *out, int what, const norma_options *options) {
    size_t missing = 0;
    for (size_t i = 0; i < out->count; ++i) {
        const float *n = out->normals + 3 * i;
        double length = sqrt((double)n[0] * n[0] + (double)n[1] * n[1] + (double)n[2] * n[2]);
        int unit = fabs(length - 1) < 1e-6, has_none = out->reasons[i] != NORMA_REASON_NONE;
        missing += has_none ? 1 : 0;
        if (out->reasons[i] > NORMA_REASON_CANCELLED)
            fuzz_fail("normal %zu: reason %d", i, out->reasons[i]);
        if (!has_none && !unit) fuzz_fail("normal %zu has length %g", i, length);
        if (has_none && options->fallback == NORMA_FALLBACK_ZERO && length != 0)
            fuzz_fail("normal %zu is missing and has length %g", i, length);
        if (has_none && options->fallback == NORMA_FALLBACK_GIVEN && !is_given(n, options))
            fuzz_fail("normal %zu is missing and not what was given instead", i);
        if (has_none && options->fallback == NORMA_FALLBACK_NEAREST && !unit && length != 0)
            fuzz_fail("normal %zu is missing, and the nearest has length %g", i, length);
    }
    const norma_report *r = &out->report;
    size_t told = (what == OF_FACES ? r->degenerate_faces.count : 0) + r->non_finite.count +
                  r->unreferenced.count + r->cancelled.count;
    if (what != SPLIT && missing != told)
        fuzz_fail("%zu normals are missing, the report tells of %zu", missing, told);
}

static void compare(const outcome *a, const outcome *b, int what, size_t corners) {
    if (a->result != b->result)
        fuzz_fail("result %d, on one thread %d", (int)a->result, (int)b->result);
    if (a->result) return;
    if (a->count != b->count || memcmp(a->normals, b->normals, a->count * 12) != 0 ||
        memcmp(a->reasons, b->reasons, a->count) != 0)
        fuzz_fail("other bits than on one thread");
    if (memcmp(&a->report, &b->report, sizeof a->report) != 0)
        fuzz_fail("another report than on one thread");
    if (what == SPLIT && (memcmp(a->corners, b->corners, corners * 4) != 0 ||
                             memcmp(a->sources, b->sources, a->count * 4) != 0))
        fuzz_fail("other vertices than on one thread");
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fuzz_bytes rest = {bytes, size};
    uint8_t what = fuzz_u8(&rest);
    size_t short_by = what >= 240 ? 1 : 0;
    made_options made;
    outcome out, plain;
    what %= WHATS;
    made_options_take(&rest, &made);
    float crease = crease_of(&rest);
    fuzz_meter_begin(16384);
    made_mesh *mesh = made_mesh_take(&rest);
    run(mesh, what, crease, &made.options, short_by, &out);
    fuzz_allocator_finish(&made.allocator);
    if (!out.result) judge(&out, what, &made.options);
    if (out.result != NORMA_ERROR_MEMORY) {
        norma_options one = made.options;
        one.allocator = (norma_allocator){0};
        one.parallel_for = NULL;
        one.threads = 1;
        one.isa = NORMA_ISA_PORTABLE;
        one.edges = NULL;
        run(mesh, what, crease, &one, short_by, &plain);
        compare(&out, &plain, what, mesh->mesh.corner_count);
        free_outcome(&plain);
    }
    free_outcome(&out);
    made_mesh_free(mesh);
    fuzz_meter_end();
    return 0;
}
