/* fuzz_plan.c: plans of any mesh, updated whole and in part, and morph targets. An update of some
 * vertices leaves what one of all would; one of the positions that the plan was made with gives the
 * bits of norma_corner_normals; of corners, where no weld or crease has its say, those of a new
 * plan. */
#include "made_mesh.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static float crease_of(fuzz_bytes *bytes) {
    static const float creases[] = {1.0471976f, 0.f, 3.1415927f, 3.1425f, -1.f, 0.5f, 1e-6f};
    return creases[fuzz_u8(bytes) % 7];
}

/* The first update, at the positions of the mesh, is norma_corner_normals. */
static void compare_with_mesh(const made_mesh *made, float crease, const norma_options *options,
    const float *normals, size_t count) {
    float *other = calloc(3 * count + 1, sizeof *other);
    norma_options plain = *options;
    plain.normal_stride = 0;
    plain.allocator = (norma_allocator){0};
    if (!norma_corner_normals(&made->mesh, crease, &plain, other, count, NULL) &&
        options->fallback != NORMA_FALLBACK_NEAREST)
        for (size_t i = 0; i < count; ++i)
            if (memcmp(normals + 3 * i, other + 3 * i, 12) != 0)
                fuzz_fail("corner %zu: an update at the plan's own positions gives other bits than "
                          "the mesh",
                    i);
    free(other);
}

/* Some vertices move: an update of them leaves the same as one of all. */
static void move(fuzz_bytes *bytes, const norma_plan *plan, const made_mesh *made,
    const norma_options *options, float *normals, size_t count) {
    const norma_vec3_view *old = &made->mesh.positions;
    size_t moved_count = fuzz_u8(bytes) % 16, stride = old->stride;
    static const size_t sizes[] = {12, 24, 3, 3, 6, 6};
    size_t size = sizes[old->format], step = stride ? stride : size,
           room = old->count ? (old->count - 1) * step + size : 0;
    uint32_t *moved = malloc(4 * moved_count + 4);
    uint8_t *places = malloc(room + 1);
    if (room) memcpy(places, old->data, room);
    norma_vec3_view positions = *old;
    positions.data = places;
    int wrong = 0;
    for (size_t i = 0; i < moved_count; ++i) {
        uint8_t byte = fuzz_u8(bytes);
        moved[i] = byte == 255 || old->count == 0 ? fuzz_u32(bytes) : (uint32_t)(byte % old->count);
        wrong |= moved[i] >= old->count;
        for (size_t k = 0; !wrong && k < 3; ++k) {
            float number = fuzz_float(bytes);
            double wide = (double)number;
            if (old->format == NORMA_FORMAT_FLOAT)
                memcpy(places + moved[i] * step + 4 * k, &number, 4);
            else if (old->format == NORMA_FORMAT_DOUBLE)
                memcpy(places + moved[i] * step + 8 * k, &wide, 8);
        }
    }
    float *all = calloc(3 * count + 1, sizeof *all);
    norma_result result =
        norma_plan_update(plan, positions, moved, moved_count, options, normals, count, NULL);
    if (wrong != (result == NORMA_ERROR_INDEX) && result != NORMA_ERROR_MEMORY)
        fuzz_fail("moved: result %d", (int)result);
    if (!result && !norma_plan_update(plan, positions, NULL, 0, options, all, count, NULL) &&
        memcmp(all, normals, 12 * count) != 0)
        fuzz_fail("an update of some leaves other bits than one of all");
    free(all);
    free(places);
    free(moved);
}

static void plan(fuzz_bytes *bytes) {
    made_options made;
    norma_plan *plan = NULL;
    uint8_t kind = fuzz_u8(bytes);
    norma_element of = kind & 1 ? NORMA_PER_CORNER : NORMA_PER_VERTEX;
    float crease = crease_of(bytes);
    made_options_take(bytes, &made);
    made_mesh *mesh = made_mesh_take(bytes);
    norma_result result = norma_plan_create(&mesh->mesh, of, crease, &made.options, &plan);
    if (!result != (plan != NULL))
        fuzz_fail("result %d, and %s plan", (int)result, plan ? "a" : "no");
    if (result) {
        fuzz_allocator_finish(&made.allocator);
        made_mesh_free(mesh);
        return;
    }
    made.allocator.fail_at = 0;
    size_t count = of == NORMA_PER_CORNER ? mesh->mesh.corner_count : mesh->mesh.positions.count;
    float *normals = calloc(3 * count + 1, sizeof *normals);
    norma_options options = made.options;
    options.normal_stride = 0;
    options.edges = NULL;
    if (norma_plan_bytes(plan) >
        65536 + 4096 * (mesh->mesh.corner_count + mesh->mesh.positions.count))
        fuzz_fail("a plan of %zu bytes", norma_plan_bytes(plan));
    result = norma_plan_update(plan, mesh->mesh.positions, NULL, 0, &options, normals, count, NULL);
    if (!result && of == NORMA_PER_CORNER)
        compare_with_mesh(mesh, crease, &options, normals, count);
    if (!result) move(bytes, plan, mesh, &options, normals, count);
    free(normals);
    norma_plan_destroy(plan);
    fuzz_allocator_finish(&made.allocator);
    made_mesh_free(mesh);
}

static void morphs(fuzz_bytes *bytes) {
    enum { MOST = 4 };
    made_options made;
    norma_vec3_view targets[MOST], normals;
    void *blocks[MOST + 1] = {0};
    size_t starts[MOST + 1], count = fuzz_u8(bytes) % (MOST + 1);
    uint8_t kind = fuzz_u8(bytes);
    float smallest = kind & 2 ? fuzz_float(bytes) : 0;
    made_options_take(bytes, &made);
    made_mesh *mesh = made_mesh_take(bytes);
    size_t vertices = mesh->mesh.positions.count < 4096 ? mesh->mesh.positions.count : 0;
    for (size_t t = 0; t < count; ++t)
        targets[t] =
            made_view(bytes, kind & 4 && t == 1 && vertices ? vertices - 1 : vertices, &blocks[t]);
    normals = made_view(bytes, vertices, &blocks[MOST]);
    size_t capacity = kind & 8 ? fuzz_u8(bytes) : count * vertices;
    uint32_t *moved = calloc(capacity + 1, 4);
    float *deltas = calloc(3 * capacity + 1, 4);
    norma_result result = norma_morph_normals(&mesh->mesh, kind & 1 ? &normals : NULL, targets,
        count, smallest, &made.options, starts, moved, deltas, capacity);
    fuzz_allocator_finish(&made.allocator);
    for (size_t t = 0; !result && t < count; ++t) {
        if (starts[0] != 0 || starts[t] > starts[t + 1] || starts[t + 1] > capacity)
            fuzz_fail(
                "target %zu has deltas %zu to %zu of %zu", t, starts[t], starts[t + 1], capacity);
        for (size_t i = starts[t]; i < starts[t + 1]; ++i) {
            if (moved[i] >= vertices || (i > starts[t] && moved[i] <= moved[i - 1]))
                fuzz_fail("delta %zu is of vertex %u", i, (unsigned)moved[i]);
            for (int k = 0; k < 3; ++k)
                if (!(fabsf(deltas[3 * i + (size_t)k]) <= 2.001f || (kind & 1)))
                    fuzz_fail("a delta of %g", (double)deltas[3 * i + (size_t)k]);
        }
    }
    free(moved);
    free(deltas);
    for (size_t t = 0; t <= MOST; ++t) free(blocks[t]);
    made_mesh_free(mesh);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fuzz_bytes rest = {bytes, size};
    fuzz_meter_begin(65536);
    if (fuzz_u8(&rest) % 4)
        plan(&rest);
    else
        morphs(&rest);
    fuzz_meter_end();
    return 0;
}
