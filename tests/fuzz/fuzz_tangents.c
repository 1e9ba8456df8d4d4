/* fuzz_tangents.c: tangents of any arrays with any options: nothing is written beside the tangents,
 * each is unit whatever the input, the reasons add up to the report, and one thread in order gives
 * the same bits as several, or jobs run backwards, or portable code. */
#include "made_mesh.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct outcome {
    norma_result result;
    norma_report report;
    float *tangents; /* tight */
    uint8_t *reasons;
} outcome;

typedef struct inputs {
    const norma_mesh *mesh;
    norma_attribute normals, texcoords;
    norma_tangent_mode mode;
} inputs;

/* Values of any format; often one for each position or corner, and then numbered in any way. */
static norma_attribute take_attribute(
    fuzz_bytes *bytes, const norma_mesh *mesh, void **block, uint32_t **numbers) {
    const uint8_t kind = fuzz_u8(bytes);
    const norma_element of = kind & 1 ? NORMA_PER_CORNER : NORMA_PER_VERTEX;
    size_t count = kind & 2   ? fuzz_u8(bytes)
                   : kind & 1 ? mesh->corner_count
                              : mesh->positions.count;
    if (count > 4096) count = 4096; /* more are counts to be refused */
    const norma_vec3_view view = made_view(bytes, count, block);
    if (kind >= 192) {
        *numbers = malloc((mesh->corner_count > 4096 ? 0 : mesh->corner_count) * 4 + 4);
        for (size_t c = 0; c < mesh->corner_count && mesh->corner_count <= 4096; ++c)
            (*numbers)[c] = fuzz_u8(bytes) % (uint32_t)(count + (kind == 255) + 1);
    }
    return (norma_attribute){.data = view.data,
        .count = view.count,
        .stride = view.stride,
        .format = view.format,
        .of = of,
        .corners = *numbers};
}

static void run(const inputs *in, const norma_options *given, outcome *out) {
    norma_options options = *given;
    const size_t count = in->mesh->corner_count > 4096 ? 0 : in->mesh->corner_count,
                 stride = options.normal_stride >= 16 ? options.normal_stride : 16,
                 size = count ? (count - 1) * stride + 16 : 0;
    uint8_t *memory = malloc(size + 1);
    memset(memory, 0xA5, size + 1);
    *out = (outcome){
        .tangents = calloc(4 * count + 1, sizeof(float)), .reasons = calloc(count + 1, 1)};
    options.reasons = out->reasons;
    out->result = norma_corner_tangents(in->mesh, &in->normals, &in->texcoords, in->mode, &options,
        (float *)(void *)memory, count, &out->report);
    for (size_t i = 0; !out->result && i < count; ++i)
        memcpy(out->tangents + 4 * i, memory + i * stride, 16);
    for (size_t i = 0; !out->result && i <= size; ++i)
        if ((i >= size || i % stride >= 16) && memory[i] != 0xA5)
            fuzz_fail("byte %zu, which belongs to no tangent, was written", i);
    free(memory);
}

static void free_outcome(outcome *out) {
    free(out->tangents);
    free(out->reasons);
}

static void judge(const inputs *in, const outcome *out) {
    size_t missing = 0;
    for (size_t i = 0; i < in->mesh->corner_count; ++i) {
        const float *t = out->tangents + 4 * i;
        const double length = sqrt((double)t[0] * (double)t[0] + (double)t[1] * (double)t[1] +
                                   (double)t[2] * (double)t[2]);
        missing += out->reasons[i] != NORMA_REASON_NONE;
        if (out->reasons[i] > NORMA_REASON_CANCELLED)
            fuzz_fail("tangent %zu: reason %d", i, out->reasons[i]);
        if (!(fabs(length - 1) < 2e-3)) fuzz_fail("tangent %zu has length %g", i, length);
        if (fabsf(t[3]) != 1) fuzz_fail("tangent %zu has sign %g", i, (double)t[3]);
    }
    const norma_report *r = &out->report;
    const size_t told = r->degenerate_faces.count + r->non_finite.count + r->cancelled.count;
    if (missing != told) fuzz_fail("%zu tangents are missing, the report has %zu", missing, told);
}

static void compare(const inputs *in, const outcome *a, const outcome *b) {
    if (a->result != b->result)
        fuzz_fail("result %d, on one thread %d", (int)a->result, (int)b->result);
    if (a->result) return;
    if (memcmp(a->tangents, b->tangents, in->mesh->corner_count * 16) != 0 ||
        memcmp(a->reasons, b->reasons, in->mesh->corner_count) != 0 ||
        memcmp(&a->report, &b->report, sizeof a->report) != 0)
        fuzz_fail("other bits than on one thread");
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fuzz_bytes rest = {bytes, size};
    made_options made;
    outcome out, plain;
    void *blocks[2] = {NULL, NULL};
    uint32_t *numbers[2] = {NULL, NULL};
    inputs in = {.mode = (norma_tangent_mode)(fuzz_u8(&rest) % 2)};
    made_options_take(&rest, &made);
    fuzz_meter_begin(16384);
    made_mesh *mesh = made_mesh_take(&rest);
    in.mesh = &mesh->mesh;
    in.normals = take_attribute(&rest, in.mesh, &blocks[0], &numbers[0]);
    in.texcoords = take_attribute(&rest, in.mesh, &blocks[1], &numbers[1]);
    run(&in, &made.options, &out);
    fuzz_allocator_finish(&made.allocator);
    if (!out.result) judge(&in, &out);
    if (out.result != NORMA_ERROR_MEMORY && out.result != NORMA_CANCELLED) {
        norma_options one = made.options;
        one.allocator = (norma_allocator){0};
        one.parallel_for = NULL;
        one.threads = 1;
        one.isa = NORMA_ISA_PORTABLE;
        run(&in, &one, &plain);
        compare(&in, &out, &plain);
        free_outcome(&plain);
    }
    free_outcome(&out);
    for (int i = 0; i < 2; ++i) {
        free(blocks[i]);
        free(numbers[i]);
    }
    made_mesh_free(mesh);
    fuzz_meter_end();
    return 0;
}
