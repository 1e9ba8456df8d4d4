/* part.c: this rank's part of the mesh, checked and agreed upon, ready to be summed. */
#include "mpi/vertex/vertex.h"
#include "core/mesh/mesh.h"
#include <math.h>
#include <string.h>

/* ---- Faces sorted by their global numbers, digit by digit from the lowest; numbers are
 * read where they are, so that only places move. */

enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS };

static int ascend(const uint64_t *ids, size_t count) {
    for (size_t i = 1; i < count; i++)
        if (ids[i - 1] > ids[i]) return 0;
    return 1;
}

static size_t radix_digit(uint64_t id, int shift) { return (size_t)(id >> shift) & (DIGITS - 1); }

/* Equal digits keep their order. */
static void sort_by_digit(
    const uint64_t *ids, size_t count, int shift, const uint32_t *from, uint32_t *to) {
    uint32_t starts[DIGITS] = {0}, sum = 0;
    for (size_t i = 0; i < count; i++) starts[radix_digit(ids[i], shift)]++;
    for (size_t d = 0; d < DIGITS; d++) {
        const uint32_t here = starts[d];
        starts[d] = sum;
        sum += here;
    }
    for (size_t i = 0; i < count; i++) to[starts[radix_digit(ids[from[i]], shift)]++] = from[i];
}

/* Returns the array that holds the result. */
static uint32_t *sort_places(
    const uint64_t *ids, size_t count, uint32_t *places, uint32_t *others) {
    uint64_t differ = 0;
    for (size_t i = 0; i < count; i++) {
        differ |= ids[i] ^ ids[0];
        places[i] = (uint32_t)i;
    }
    for (int shift = 0; shift < 64 && differ >> shift; shift += DIGIT_BITS) {
        uint32_t *const from = places;
        if (!radix_digit(differ, shift)) continue;
        sort_by_digit(ids, count, shift, from, others);
        places = others;
        others = from;
    }
    return places;
}

norma_result norma_mpi_order_faces(
    const core_call *call, const uint64_t *ids, size_t count, mpi_face_order *order) {
    *order = (mpi_face_order){.ids = ids, .count = count};
    if (!ids || ascend(ids, count)) return NORMA_OK;
    uint32_t *places = norma_core_allocate(call, count, sizeof *places),
             *others = norma_core_allocate(call, count, sizeof *others);
    if (!places || !others) {
        norma_core_release(call, places, count, sizeof *places);
        norma_core_release(call, others, count, sizeof *others);
        return NORMA_ERROR_MEMORY;
    }
    order->order = sort_places(ids, count, places, others);
    norma_core_release(call, order->order == places ? others : places, count, sizeof *places);
    return NORMA_OK;
}

void norma_mpi_order_close(const core_call *call, mpi_face_order *order) {
    norma_core_release(call, order->order, order->count, sizeof *order->order);
    order->order = NULL;
}

/* ---- Chains of steps may run through all ranks, so one of them has all positions
 * before it, in their order of ranks, and joins them as the core does. */

enum { POINT = 3 * sizeof(double) };

/* As the core reads them, its scale applied. */
static norma_result list_points(const mpi_call *call, const core_mesh *mesh, mpi_lists *out) {
    const size_t ranks = (size_t)call->ranks;
    uint64_t *room = norma_core_allocate(call->core, ranks, sizeof *room);
    if (!room) return NORMA_ERROR_MEMORY;
    memset(room, 0, ranks * sizeof *room);
    room[0] = mesh->positions.count;
    const norma_result result = norma_mpi_lists_open(call, room, POINT, out);
    norma_core_release(call->core, room, ranks, sizeof *room);
    for (size_t v = 0; v < mesh->positions.count && result == NORMA_OK; v++) {
        double p[3];
        norma_view_read(&mesh->positions, v, p);
        memcpy(norma_mpi_lists_add(out, 0), p, POINT);
    }
    return result;
}

static norma_result weld_points(
    const mpi_call *call, const mpi_lists *in, double scale, mpi_lists *answers) {
    core_mesh all = {.positions = {.data = in->bytes,
                         .count = norma_mpi_lists_total(call, in),
                         .stride = POINT,
                         .format = NORMA_FORMAT_DOUBLE},
        .scale = scale};
    if (all.positions.count > UINT32_MAX - 1) return NORMA_ERROR_OVERFLOW;
    norma_result result = norma_core_weld(call->core, &all);
    if (result != NORMA_OK) return result;
    result = norma_mpi_lists_like(call, in, sizeof(uint32_t), answers);
    for (size_t i = 0; i < all.positions.count && result == NORMA_OK; i++) {
        const uint32_t group = norma_core_welded(&all, (uint32_t)i);
        memcpy(norma_mpi_record(answers, i), &group, sizeof group);
    }
    norma_core_unweld(call->core, &all);
    return result;
}

static norma_result read_groups(
    const mpi_call *call, const mpi_lists *back, size_t count, uint64_t **groups) {
    *groups = norma_core_allocate(call->core, count, sizeof **groups);
    if (!*groups) return NORMA_ERROR_MEMORY;
    for (size_t v = 0; v < count; v++) {
        uint32_t group;
        memcpy(&group, norma_mpi_record(back, v), sizeof group);
        (*groups)[v] = group;
    }
    return NORMA_OK;
}

/* Collective. *groups: of each position here a number that those that are one have in common; to be
 * released by the caller. NULL on an error. */
static norma_result mpi_weld_gathered(mpi_call *call, const core_mesh *mesh, uint64_t **groups) {
    mpi_lists out = {0}, in = {0}, answers = {0}, back = {0};
    double mine = mesh->scale, scale = 1;
    const size_t count = mesh->positions.count;
    *groups = NULL;
    if (!count) mine = 0; /* a rank without positions knows no scale */
    MPI_Allreduce(&mine, &scale, 1, MPI_DOUBLE, MPI_MAX, call->comm);
    norma_result result = norma_mpi_exchange(call, list_points(call, mesh, &out), &out, &in);
    if (result == NORMA_OK) {
        norma_result local = weld_points(call, &in, scale, &answers);
        if (local == NORMA_OK) local = norma_mpi_lists_like(call, &out, sizeof(uint32_t), &back);
        result = norma_mpi_agree(call, local);
    }
    if (result == NORMA_OK) {
        norma_mpi_answer(call, &answers, &back);
        const norma_result local = read_groups(call, &back, count, groups);
        result = norma_mpi_agree(call, local);
        if (result != NORMA_OK) {
            norma_core_release(call->core, *groups, count, sizeof **groups);
            *groups = NULL;
        }
    }
    norma_mpi_lists_close(call, &in);
    norma_mpi_lists_close(call, &out);
    norma_mpi_lists_close(call, &answers);
    norma_mpi_lists_close(call, &back);
    return result;
}

/* ---- What must hold of each rank's part and of all together before anything is computed. */

enum { LEAST_BUDGET = 1 << 18, BUDGET_OF_TRIANGLE = 8 };

/* ---- each rank by itself, without reading its arrays */

static norma_result mpi_check_shape(
    const mpi_call *call, const mpi_input *input, core_mesh *mesh, core_output *output) {
    const norma_result result = norma_core_mesh_shape(input->mesh, mesh);
    if (result != NORMA_OK) return result;
    if (mesh->positions.count && !input->vertex_ids) return NORMA_ERROR_ARGUMENT;
    return norma_core_output_open(
        call->core, input->normals, mesh->positions.count, input->capacity, output);
}

/* ---- all together */

static uint64_t mpi_bits_of(double number) {
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    return bits;
}

static int ranks_agree_on_options(const mpi_call *call) {
    const norma_options *o = &call->core->options;
    uint64_t numbers[] = {(uint64_t)o->weight, (uint64_t)o->weld, (uint64_t)o->non_manifold,
        (uint64_t)o->fallback, 0, 0, 0, 0};
    if (o->weld == NORMA_WELD_DISTANCE) numbers[4] = mpi_bits_of(o->weld_distance + 0.0);
    for (size_t k = 0; k < 3 && o->fallback == NORMA_FALLBACK_GIVEN; k++)
        numbers[5 + k] = mpi_bits_of((double)o->fallback_normal[k] + 0.0);
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

static norma_result mpi_order_faces(
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
    if (weld == NORMA_WELD_DISTANCE) result = mpi_weld_gathered(call, mesh, &part->groups);
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
    if (result == NORMA_OK) result = mpi_order_faces(call, input->face_ids, part, mesh);
    if (result == NORMA_OK) result = open_prepared(call, part, mesh);
    return result;
}

norma_result norma_mpi_open_part(
    mpi_call *call, norma_result begun, const mpi_input *input, mpi_part *part) {
    core_mesh mesh;
    *part = (mpi_part){.vertex_ids = input->vertex_ids};
    if (begun == NORMA_OK) begun = mpi_check_shape(call, input, &mesh, &part->output);
    const norma_result result = norma_mpi_agree(call, begun);
    if (result != NORMA_OK) return result;
    const int same = ranks_agree_on_options(call);
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
