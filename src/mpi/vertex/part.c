/* part.c: what must hold of each rank's part and of all together before anything is computed. */
#include "mpi/vertex/part.h"
#include "core/mesh/weld.h"
#include "core/mesh/weld_buckets.h"
#include "mpi/vertex/gathered_weld.h"
#include <math.h>

enum { LEAST_BUDGET = 1 << 18, BUDGET_OF_TRIANGLE = 8 };

/* ---- each rank by itself, without reading its arrays */

static norma_result check_shape(
    const mpi_call *call, const mpi_input *input, core_mesh *mesh, core_output *output) {
    const norma_result result = norma_core_mesh_shape(input->mesh, mesh);
    if (result != NORMA_OK) return result;
    if (mesh->positions.count && !input->vertex_ids) return NORMA_ERROR_ARGUMENT;
    return norma_core_output_open(
        call->core, input->normals, mesh->positions.count, input->capacity, output);
}

/* ---- all together */

static uint64_t bits_of(double number) {
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    return bits;
}

static int same_options(const mpi_call *call) {
    const norma_options *o = &call->core->options;
    uint64_t numbers[] = {(uint64_t)o->weight, (uint64_t)o->weld, (uint64_t)o->non_manifold,
        (uint64_t)o->fallback, 0, 0, 0, 0};
    if (o->weld == NORMA_WELD_DISTANCE) numbers[4] = bits_of(o->weld_distance + 0.0);
    for (size_t k = 0; k < 3 && o->fallback == NORMA_FALLBACK_GIVEN; k++)
        numbers[5 + k] = bits_of((double)o->fallback_normal[k] + 0.0);
    return norma_mpi_all_equal(call, numbers, sizeof numbers / sizeof *numbers);
}

/* A rank without faces may have an array of none, of which the address says nothing. */
static int same_numbering(const mpi_call *call, const core_mesh *mesh, const uint64_t *ids) {
    const uint64_t with = norma_mpi_sum(call, mesh->face_count && ids),
                   without = norma_mpi_sum(call, mesh->face_count && !ids);
    return !with || !without;
}

static norma_result agree_on_scale(const mpi_call *call, core_mesh *mesh, int *doubles) {
    const int mine = mesh->positions.count && mesh->positions.format == NORMA_FORMAT_DOUBLE;
    double largest = mine ? norma_core_largest_coordinate(mesh) : 0, all = 0;
    *doubles = norma_mpi_largest(call, (uint64_t)mine) != 0;
    MPI_Allreduce(&largest, &all, 1, MPI_DOUBLE, MPI_MAX, call->comm);
    const int mixed = *doubles && mesh->positions.count && !mine;
    if (mine) mesh->scale = norma_core_scale_for(all);
    return norma_mpi_agree(call, mixed ? NORMA_ERROR_ARGUMENT : NORMA_OK);
}

/* Whether each rank's faces all come after those of the ranks before. */
static int ranks_ascend(const mpi_call *call, const mpi_face_order *faces) {
    uint64_t last = 0;
    const int some = faces->count != 0;
    if (some) last = faces->ids[norma_mpi_face(faces, faces->count - 1)];
    const uint64_t before = norma_mpi_largest_before(call, last),
                   others = norma_mpi_sum_before(call, (uint64_t)some);
    const int fine = !some || !others || before < faces->ids[norma_mpi_face(faces, 0)];
    return norma_mpi_largest(call, (uint64_t)!fine) == 0;
}

static norma_result order_faces(
    const mpi_call *call, const uint64_t *ids, mpi_part *part, const core_mesh *mesh) {
    const uint64_t before = norma_mpi_sum_before(call, mesh->face_count);
    const uint64_t with = norma_mpi_sum(call, mesh->face_count && ids);
    norma_result result = norma_mpi_order_faces(
        call->core, mesh->face_count ? ids : NULL, mesh->face_count, &part->faces);
    result = norma_mpi_agree(call, result);
    if (result != NORMA_OK) return result;
    part->faces.first = before;
    part->numbered = with && !ranks_ascend(call, &part->faces);
    return NORMA_OK;
}

/* ---- which positions here are one */

typedef struct number_keys {
    const uint64_t *numbers;
} number_keys;

static void hash_numbers(const void *context, size_t first, size_t count, uint64_t *hashes) {
    const number_keys *keys = context;
    for (size_t i = 0; i < count; i++)
        hashes[i] = norma_core_weld_mix(keys->numbers[first + i] * UINT64_C(0x9e3779b97f4a7c15));
}

static int same_number(const void *context, uint32_t one, uint32_t other) {
    const number_keys *keys = context;
    return keys->numbers[one] == keys->numbers[other];
}

static int numbers_ascend(const uint64_t *numbers, size_t count) {
    for (size_t i = 1; i < count; i++)
        if (numbers[i - 1] >= numbers[i]) return 0;
    return 1;
}

norma_result norma_mpi_weld_numbers(
    core_call *core, const uint64_t *numbers, size_t count, uint32_t **weld) {
    size_t found;
    const number_keys context = {numbers};
    const weld_keys keys = {count, &context, hash_numbers, same_number};
    *weld = NULL;
    if (numbers_ascend(numbers, count)) return NORMA_OK;
    uint32_t *map = norma_core_allocate(core, count, sizeof *map);
    if (!map) return NORMA_ERROR_MEMORY;
    const norma_result result = norma_core_weld_keys(core, &keys, map, &found);
    if (result == NORMA_OK && found)
        *weld = map;
    else
        norma_core_release(core, map, count, sizeof *map);
    return result;
}

/* By number and by distance the map is made here, and the core finds it made. */
static norma_result weld_part(mpi_call *call, mpi_part *part, core_mesh *mesh) {
    core_call *core = call->core;
    const norma_weld weld = core->options.weld;
    uint32_t *map = NULL;
    norma_result result = NORMA_OK;
    if (weld == NORMA_WELD_EXACT) return NORMA_OK;
    if (weld == NORMA_WELD_DISTANCE) result = norma_mpi_weld_gathered(call, mesh, &part->groups);
    if (result == NORMA_OK)
        result = norma_mpi_weld_numbers(
            core, part->groups ? part->groups : part->vertex_ids, part->positions, &map);
    mesh->weld = map;
    return result;
}

/* Releases the map on an error, as opening does. */
static norma_result open_prepared(mpi_call *call, mpi_part *part, core_mesh *mesh) {
    core_call *core = call->core;
    const norma_weld weld = core->options.weld;
    norma_result result = norma_mpi_agree(call, weld_part(call, part, mesh));
    if (result != NORMA_OK) {
        norma_core_unweld(core, mesh);
        return result;
    }
    if (weld != NORMA_WELD_EXACT) core->options.weld = NORMA_WELD_NONE;
    result = norma_core_prepared_mesh_open(core, mesh, CORE_FOR_SUMS, 0, &part->prepared);
    core->options.weld = weld;
    part->is_prepared = result == NORMA_OK;
    return norma_mpi_step(call, 0.2, result);
}

static norma_result open_checked(
    mpi_call *call, const mpi_input *input, core_mesh *mesh, mpi_part *part) {
    norma_result result = norma_mpi_step(call, 0, norma_core_mesh_content(call->core, mesh));
    if (result == NORMA_OK) result = agree_on_scale(call, mesh, &part->doubles);
    if (result == NORMA_OK) result = order_faces(call, input->face_ids, part, mesh);
    if (result == NORMA_OK) result = open_prepared(call, part, mesh);
    return result;
}

norma_result norma_mpi_open_part(
    mpi_call *call, norma_result begun, const mpi_input *input, mpi_part *part) {
    core_mesh mesh;
    *part = (mpi_part){.vertex_ids = input->vertex_ids};
    if (begun == NORMA_OK) begun = check_shape(call, input, &mesh, &part->output);
    const norma_result result = norma_mpi_agree(call, begun);
    if (result != NORMA_OK) return result;
    const int same = same_options(call);
    if (!same_numbering(call, &mesh, input->face_ids) || !same) return NORMA_ERROR_ARGUMENT;
    part->positions = mesh.positions.count;
    part->budget = mesh.corner_count / 3 * BUDGET_OF_TRIANGLE;
    if (part->budget < LEAST_BUDGET) part->budget = LEAST_BUDGET;
    norma_core_stage(call->core, 0, 0.1);
    const norma_result opened = open_checked(call, input, &mesh, part);
    if (opened != NORMA_OK) norma_mpi_close_part(call, part);
    return opened;
}

void norma_mpi_close_part(const mpi_call *call, mpi_part *part) {
    if (part->is_prepared) norma_core_prepared_mesh_close(&part->prepared);
    norma_mpi_order_close(call->core, &part->faces);
    norma_core_release(call->core, part->groups, part->positions, sizeof *part->groups);
    *part = (mpi_part){0};
}
