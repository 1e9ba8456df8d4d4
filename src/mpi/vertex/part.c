/* part.c: a rank's part of a mesh: checked, in the order of its faces, welded, and what it shares
 * with others. */
#include "core/call/call.h"
#include "core/call/table.h"
#include "core/mesh/mesh.h"
#include "mpi/vertex/vertex.h"
#include <math.h>
#include <string.h>

/* ---- Faces sorted by their global numbers, digit by digit from the lowest; numbers are read where
 * they are, so that only places move. */

enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS };

static int ascend(const uint64_t *ids, size_t count) {
    for (size_t i = 1; i < count; ++i)
        if (ids[i - 1] > ids[i]) return 0;
    return 1;
}

static size_t radix_digit(uint64_t id, int shift) { return (size_t)(id >> shift) & (DIGITS - 1); }

/* Equal digits keep their order. */
static void sort_by_digit(
    const uint64_t *ids, size_t count, int shift, const uint32_t *from, uint32_t *to) {
    uint32_t starts[DIGITS] = {0}, sum = 0;
    for (size_t i = 0; i < count; ++i) ++starts[radix_digit(ids[i], shift)];
    for (size_t d = 0; d < DIGITS; ++d) {
        const uint32_t here = starts[d];
        starts[d] = sum;
        sum += here;
    }
    for (size_t i = 0; i < count; ++i) to[starts[radix_digit(ids[from[i]], shift)]++] = from[i];
}

/* Returns the array that holds the result. */
static uint32_t *sort_places(
    const uint64_t *ids, size_t count, uint32_t *places, uint32_t *others) {
    uint64_t differ = 0;
    for (size_t i = 0; i < count; ++i) {
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

/* ---- this rank's part of the mesh, checked and agreed upon, ready to be summed. */

/* ---- Chains of steps may run through all ranks, so one of them has all positions
 * before it, in their order of ranks, and joins them as the core does. */

enum { POINT = 3 * sizeof(double) };

static int first_rank(const void *context, size_t v) { return (void)context, (void)v, 0; }

/* As the core reads them, its scale applied. */
static void write_point(const void *context, size_t v, unsigned char *record) {
    double p[3];
    norma_view_read(&((const core_mesh *)context)->positions, v, p);
    memcpy(record, p, POINT);
}

typedef struct gathered_points {
    const mpi_call *call;
    double scale;
} gathered_points;

static norma_result weld_points(void *context, const mpi_lists *in, mpi_lists *answers) {
    const gathered_points *points = context;
    const mpi_call *call = points->call;
    core_mesh all = {.positions = {.data = in->bytes,
                         .count = norma_mpi_lists_total(call, in),
                         .stride = POINT,
                         .format = NORMA_FORMAT_DOUBLE},
        .scale = points->scale};
    if (all.positions.count > UINT32_MAX - 1) return NORMA_ERROR_OVERFLOW;
    const norma_result result = norma_core_weld(call->core, &all);
    for (size_t i = 0; i < all.positions.count && !result; ++i) {
        const uint32_t group = norma_core_welded(&all, (uint32_t)i);
        memcpy(norma_mpi_record(answers, i), &group, sizeof group);
    }
    if (!result) norma_core_unweld(call->core, &all);
    return result;
}

static norma_result read_groups(
    const mpi_call *call, const mpi_lists *back, size_t count, uint64_t **groups) {
    *groups = norma_core_allocate(call->core, count, sizeof **groups);
    if (!*groups) return NORMA_ERROR_MEMORY;
    for (size_t v = 0; v < count; ++v) {
        uint32_t group;
        memcpy(&group, norma_mpi_record(back, v), sizeof group);
        (*groups)[v] = group;
    }
    return NORMA_OK;
}

/* Collective. *groups: of each position here a number that those that are one have in common; to be
 * released by the caller. NULL on an error. */
static norma_result mpi_weld_gathered(mpi_call *call, const core_mesh *mesh, uint64_t **groups) {
    const size_t count = mesh->positions.count;
    const mpi_listing listing = {count, POINT, first_rank, write_point, mesh};
    gathered_points points = {call, count ? mesh->scale : 0}; /* who has no positions knows none */
    mpi_lists back;
    *groups = NULL;
    norma_mpi_reduce(call, &points.scale, 1, MPI_DOUBLE, MPI_MAX);
    norma_result result =
        norma_mpi_ask(call, MPI_OTHERS, &listing, sizeof(uint32_t), weld_points, &points, &back);
    if (result) return result;
    result = norma_mpi_agree(call, read_groups(call, &back, count, groups));
    if (result) {
        norma_core_release(call->core, *groups, count, sizeof **groups);
        *groups = NULL;
    }
    norma_mpi_lists_close(call, &back);
    return result;
}

/* ---- What must hold of each rank's part and of all together before anything is computed. */

enum { LEAST_BUDGET = 1 << 18, BUDGET_OF_TRIANGLE = 8 };

/* ---- each rank by itself, without reading its arrays */

static norma_result mpi_check_shape(
    const mpi_call *call, const mpi_input *input, core_mesh *mesh, core_output *output) {
    const norma_result result = norma_core_mesh_shape(input->mesh, mesh);
    if (result) return result;
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
    for (size_t k = 0; k < 3 && o->fallback == NORMA_FALLBACK_GIVEN; ++k)
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
    double largest = mine ? norma_core_largest_coordinate(mesh) : 0;
    *doubles = norma_mpi_largest(call, (uint64_t)mine) != 0;
    norma_mpi_reduce(call, &largest, 1, MPI_DOUBLE, MPI_MAX);
    const int mixed = *doubles && mesh->positions.count && !mine;
    if (mine) mesh->scale = norma_core_scale_for(largest);
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
    if (result) return result;
    part->faces.first = before;
    part->numbered = with && !ranks_ascend(call, &part->faces);
    return NORMA_OK;
}

/* ---- which positions here are one */

static void hash_numbers(const void *context, size_t first, size_t count, uint64_t *hashes) {
    const uint64_t *numbers = context;
    for (size_t i = 0; i < count; ++i)
        hashes[i] = norma_core_weld_mix(numbers[first + i] * UINT64_C(0x9e3779b97f4a7c15));
}

static int same_number(const void *context, uint32_t one, uint32_t other) {
    const uint64_t *numbers = context;
    return numbers[one] == numbers[other];
}

static int numbers_ascend(const uint64_t *numbers, size_t count) {
    for (size_t i = 1; i < count; ++i)
        if (numbers[i - 1] >= numbers[i]) return 0;
    return 1;
}

norma_result norma_mpi_weld_numbers(
    core_call *core, const uint64_t *numbers, size_t count, uint32_t **weld) {
    size_t found;
    const weld_keys keys = {count, numbers, hash_numbers, same_number};
    *weld = NULL;
    if (numbers_ascend(numbers, count)) return NORMA_OK;
    uint32_t *map = norma_core_allocate(core, count, sizeof *map);
    if (!map) return NORMA_ERROR_MEMORY;
    const norma_result result = norma_core_weld_keys(core, &keys, map, &found);
    if (!result && found)
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
    if (!result)
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
    if (result) {
        norma_core_unweld(core, mesh);
        return result;
    }
    if (weld != NORMA_WELD_EXACT) core->options.weld = NORMA_WELD_NONE;
    result = norma_core_prepared_mesh_open(core, mesh, CORE_FOR_SUMS, 0, &part->prepared);
    core->options.weld = weld;
    part->is_prepared = !result;
    return norma_mpi_step(call, 0.2, result);
}

static norma_result open_checked(
    mpi_call *call, const mpi_input *input, core_mesh *mesh, mpi_part *part) {
    norma_result result = norma_mpi_step(call, 0, norma_core_mesh_content(call->core, mesh));
    if (!result) result = agree_on_scale(call, mesh, &part->doubles);
    if (!result) result = mpi_order_faces(call, input->face_ids, part, mesh);
    if (!result) result = open_prepared(call, part, mesh);
    return result;
}

norma_result norma_mpi_open_part(
    mpi_call *call, norma_result begun, const mpi_input *input, mpi_part *part) {
    core_mesh mesh;
    *part = (mpi_part){.vertex_ids = input->vertex_ids};
    if (!begun) begun = mpi_check_shape(call, input, &mesh, &part->output);
    const norma_result result = norma_mpi_agree(call, begun);
    if (result) return result;
    const int same = ranks_agree_on_options(call);
    if (!same_numbering(call, &mesh, input->face_ids) || !same) return NORMA_ERROR_ARGUMENT;
    part->positions = mesh.positions.count;
    part->budget = mesh.corner_count / 3 * BUDGET_OF_TRIANGLE;
    if (part->budget < LEAST_BUDGET) part->budget = LEAST_BUDGET;
    norma_core_stage(call->core, 0, 0.1);
    const norma_result opened = open_checked(call, input, &mesh, part);
    if (opened) norma_mpi_close_part(call, part);
    return opened;
}

void norma_mpi_close_part(const mpi_call *call, mpi_part *part) {
    if (part->is_prepared) norma_core_prepared_mesh_close(&part->prepared);
    norma_mpi_order_close(call->core, &part->faces);
    norma_core_release(call->core, part->groups, part->positions, sizeof *part->groups);
    *part = (mpi_part){0};
}

/* ---- each position goes to its home, the rank that a hash of it chooses, which sees who has the
 * same one. A position that one rank alone has is that rank's; one of which a single rank has votes
 * is summed there and lent to its home; all others get a slot at their home. Positions go in rounds
 * by their hash, so that a round holds all of one key and leaves nothing but slots behind. */

enum { MOST_KEY = 24, LEAST_LOANS = 1024 };
static const uint64_t MOST_SLOTS = UINT64_C(1) << MPI_HOME_AT; /* an answer has room for it */

typedef struct key_group {
    uint32_t first, ranks, voters, answer;
} key_group; /* first: a record with its key */

typedef struct share_work {
    mpi_call *call;
    const mpi_keys *keys;
    const uint8_t *part;
    int lend;
    size_t key_size;
    uint64_t round, rounds;
    mpi_sharing *sharing;
} share_work;

/* ---- keys */

static size_t size_of_key(const mpi_keys *keys) {
    return keys->numbers ? sizeof(uint64_t) : 3 * (keys->doubles ? sizeof(double) : sizeof(float));
}

/* -0 is 0. Positions that are no doubles fit floats. */
static void write_key(const mpi_keys *keys, size_t v, unsigned char *key) {
    double p[3];
    if (keys->numbers) {
        memcpy(key, &keys->numbers[v], sizeof keys->numbers[v]);
        return;
    }
    norma_core_position(keys->mesh, (uint32_t)v, p);
    for (size_t k = 0; k < 3; ++k) {
        const double exact = p[k] + 0.0;
        const float single = (float)exact;
        if (keys->doubles)
            memcpy(key + k * sizeof exact, &exact, sizeof exact);
        else
            memcpy(key + k * sizeof single, &single, sizeof single);
    }
}

/* The highest bits choose the home, lower ones the round, the lowest the place in a table. */
static int mpi_home_of(const mpi_call *call, uint64_t hash) {
    return (int)((hash >> 32) * (uint64_t)call->ranks >> 32);
}
static uint64_t round_of(const share_work *work, uint64_t hash) {
    return (hash >> 16 & 0xffff) * work->rounds >> 16;
}

int norma_mpi_home_of_number(const mpi_call *call, uint64_t number) {
    unsigned char key[sizeof number];
    memcpy(key, &number, sizeof number);
    return mpi_home_of(call, norma_core_hash(key, sizeof key));
}

/* ---- Most positions are nowhere near those of another rank. Space (or the range of numbers) is
 * cut into cells; each rank marks in a table, at a hash of each cell, those that it has positions
 * in. The tables of all ranks become one. A position in a cell that one rank alone has marked is
 * that rank's, and need not go to a home. */

enum { LEAST_MARKS = 1 << 10, MOST_MARKS = 1 << 26, MARKS_OF_CELL = 16 };

typedef struct cell_marks {
    uint64_t any, several; /* a bit for each of 64 cells: some rank has it, more than one do */
} cell_marks;

typedef struct share_cells {
    double low[3], scale; /* from positions to cells */
    uint64_t step;        /* from numbers to cells */
    size_t count;         /* of marks, a power of two */
    cell_marks *marks;
} share_cells;

/* As MPI_User_function asks for it. */
static void join_marks(void *in, void *inout, int *count, MPI_Datatype *type) {
    const cell_marks *one = in;
    cell_marks *other = inout;
    (void)type;
    for (int i = 0; i < *count; ++i) {
        other[i].several |= one[i].several | (one[i].any & other[i].any);
        other[i].any |= one[i].any;
    }
}

static void size_cells(const share_work *work, share_cells *cells) {
    double ends[6] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL}, p[3];
    uint64_t last = 0;
    const size_t count = work->sharing->count;
    const uint64_t most = norma_mpi_largest(work->call, count);
    for (cells->count = LEAST_MARKS; cells->count < most && cells->count < MOST_MARKS;)
        cells->count *= 2;
    for (size_t v = 0; v < count; ++v) {
        if (work->part[v] == MPI_ABSENT) continue;
        if (work->keys->numbers) {
            if (work->keys->numbers[v] > last) last = work->keys->numbers[v];
            continue;
        }
        norma_core_position(work->keys->mesh, (uint32_t)v, p);
        for (size_t k = 0; k < 3; ++k) {
            if (-p[k] > ends[k]) ends[k] = -p[k];
            if (p[k] > ends[3 + k]) ends[3 + k] = p[k];
        }
    }
    const uint64_t of_numbers = cells->count / MARKS_OF_CELL;
    cells->step = norma_mpi_largest(work->call, last) / of_numbers + 1;
    norma_mpi_reduce(work->call, ends, 6, MPI_DOUBLE, MPI_MAX);
    double extent = 0;
    for (size_t k = 0; k < 3; ++k) {
        cells->low[k] = -ends[k];
        if (ends[3 + k] + ends[k] > extent) extent = ends[3 + k] + ends[k];
    }
    cells->scale = floor(sqrt((double)of_numbers)) / extent;
    if (!isfinite(cells->scale)) cells->scale = 0;
}

/* Equal keys have equal cells. */
static size_t mark_of(const share_work *work, const share_cells *cells, size_t v) {
    uint64_t cell = 0;
    if (work->keys->numbers) {
        cell = work->keys->numbers[v] / cells->step;
    } else {
        double p[3];
        norma_core_position(work->keys->mesh, (uint32_t)v, p);
        for (size_t k = 0; k < 3; ++k)
            cell = cell << 21 | (uint64_t)((p[k] - cells->low[k]) * cells->scale);
    }
    return (size_t)(norma_core_weld_mix(cell * UINT64_C(0x9e3779b97f4a7c15)) & (cells->count - 1));
}

/* Collective. Opens the marks; with a single rank there are none. */
static norma_result mark_cells(const share_work *work, share_cells *cells) {
    mpi_call *call = work->call;
    MPI_Datatype type;
    MPI_Op join;
    *cells = (share_cells){0};
    if (!work->lend || call->ranks == 1) return NORMA_OK;
    size_cells(work, cells);
    cells->marks = norma_core_allocate(call->core, cells->count / 64, sizeof *cells->marks);
    const norma_result result = norma_mpi_agree(call, cells->marks ? NORMA_OK : NORMA_ERROR_MEMORY);
    if (result) return result;
    memset(cells->marks, 0, cells->count / 64 * sizeof *cells->marks);
    for (size_t v = 0; v < work->sharing->count; ++v) {
        if (work->part[v] == MPI_ABSENT) continue;
        const size_t mark = mark_of(work, cells, v);
        cells->marks[mark / 64].any |= UINT64_C(1) << mark % 64;
    }
    MPI_Type_contiguous((int)sizeof *cells->marks, MPI_BYTE, &type);
    MPI_Type_commit(&type);
    MPI_Op_create(join_marks, 1, &join);
    norma_mpi_reduce(call, cells->marks, (int)(cells->count / 64), type, join);
    call->sent[MPI_CELLS] += cells->count / 64 * sizeof *cells->marks;
    MPI_Op_free(&join);
    MPI_Type_free(&type);
    return NORMA_OK;
}

static int stays_here(const share_work *work, const share_cells *cells, size_t v) {
    if (!work->lend) return 0;
    if (work->call->ranks == 1) return 1;
    const size_t mark = mark_of(work, cells, v);
    return !(cells->marks[mark / 64].several >> mark % 64 & 1);
}

/* ---- sending */

/* sent: positions that go to their homes. A key costs its record where it is sent and where it is
 * received, and its row in the table. No round where nobody sends any. */
static uint64_t rounds_for(const share_work *work, size_t budget, uint64_t sent) {
    const uint64_t each = 2 * (work->key_size + 1) + sizeof(key_group) + 4 * sizeof(uint32_t),
                   mine = sent ? sent * each / budget + 1 : 0,
                   rounds = norma_mpi_largest(work->call, mine);
    return rounds < 0x8000 ? rounds : 0x8000;
}

static mpi_place place_of_own(share_work *work, size_t v) {
    const int votes = work->part[v] == MPI_VOTES;
    return norma_mpi_place(MPI_OWN, 0, votes ? work->sharing->own++ : 0);
}

/* Until its round has given a position its place, it is nowhere, at its home, with the round
 * (counted from 1) for a slot: it is hashed once, however many rounds look for theirs. */
static norma_result plan_rounds(share_work *work, size_t budget) {
    unsigned char key[MOST_KEY];
    share_cells cells;
    uint64_t sent = 0;
    const norma_result result = mark_cells(work, &cells);
    for (size_t v = 0; v < work->sharing->count && !result; ++v) {
        mpi_place place = norma_mpi_place(MPI_NOWHERE, 0, 0);
        if (work->part[v] != MPI_ABSENT) {
            const int far = stays_here(work, &cells, v);
            place = far ? place_of_own(work, v) : norma_mpi_place(MPI_NOWHERE, 0, 1);
            sent += !far;
        }
        work->sharing->places[v] = norma_mpi_keep_place(place);
    }
    norma_core_release(work->call->core, cells.marks, cells.count / 64, sizeof *cells.marks);
    if (result) return result;
    work->rounds = rounds_for(work, budget, sent);
    for (size_t v = 0; v < work->sharing->count && sent; ++v) {
        const mpi_place place = norma_mpi_place_at(work->sharing, v);
        if (norma_mpi_kind(place) != MPI_NOWHERE || !norma_mpi_slot(place)) continue;
        write_key(work->keys, v, key);
        const uint64_t hash = norma_core_hash(key, work->key_size);
        work->sharing->places[v] = norma_mpi_keep_place(
            norma_mpi_place(MPI_NOWHERE, mpi_home_of(work->call, hash), round_of(work, hash) + 1));
    }
    return NORMA_OK;
}

static int home_in_round(const void *context, size_t v) {
    const share_work *work = context;
    const mpi_place place = norma_mpi_place_at(work->sharing, v);
    return norma_mpi_kind(place) == MPI_NOWHERE && norma_mpi_slot(place) == work->round + 1
               ? norma_mpi_home(place)
               : -1;
}

static void write_key_and_part(const void *context, size_t v, unsigned char *record) {
    const share_work *work = context;
    write_key(work->keys, v, record);
    record[work->key_size] = work->part[v];
}

/* ---- at home */

enum { ANSWER_BITS = 30 };

typedef struct key_table {
    const mpi_lists *in;
    size_t key_size, count, slots; /* records; slots is a power of two */
    uint32_t *slot;                /* of the hash: a group + 1; 0: none */
    uint32_t *group_of;            /* of each record */
    key_group *groups;
    uint32_t group_count;
} key_table;

static norma_result open_table(const mpi_call *call, key_table *table) {
    for (table->slots = 16; table->slots < table->count + table->count / 2;) table->slots *= 2;
    table->slot = norma_core_allocate(call->core, table->slots, sizeof *table->slot);
    table->group_of = norma_core_allocate(call->core, table->count, sizeof *table->group_of);
    table->groups = norma_core_allocate(call->core, table->count, sizeof *table->groups);
    if (!table->slot || !table->group_of || !table->groups) return NORMA_ERROR_MEMORY;
    memset(table->slot, 0, table->slots * sizeof *table->slot);
    return NORMA_OK;
}

static void close_table(const mpi_call *call, key_table *table) {
    norma_core_release(call->core, table->slot, table->slots, sizeof *table->slot);
    norma_core_release(call->core, table->group_of, table->count, sizeof *table->group_of);
    norma_core_release(call->core, table->groups, table->count, sizeof *table->groups);
}

typedef struct key_search {
    const key_table *table;
    const unsigned char *key;
} key_search;

static int has_key(const void *context, uint32_t group) {
    const key_search *search = context;
    const key_table *table = search->table;
    return memcmp(norma_mpi_record(table->in, table->groups[group].first), search->key,
               table->key_size) == 0;
}

static void group_record(key_table *table, size_t record) {
    const unsigned char *key = norma_mpi_record(table->in, record);
    const key_search search = {table, key};
    uint32_t *slot = norma_core_table_find(
        table->slot, table->slots, norma_core_hash(key, table->key_size), has_key, &search);
    if (!*slot) {
        table->groups[table->group_count] = (key_group){.first = (uint32_t)record};
        *slot = ++table->group_count;
    }
    key_group *group = &table->groups[*slot - 1];
    table->group_of[record] = *slot - 1;
    ++group->ranks;
    group->voters += key[table->key_size] == MPI_VOTES;
}

/* Nobody asks another rank about a position that has no votes, or no other rank. */
static int mpi_is_alone(const share_work *work, const key_group *group) {
    return group->voters == 0 || (work->lend && group->ranks == 1);
}

static norma_result mpi_give_slots(const share_work *work, key_table *table) {
    uint64_t *slots = &work->sharing->slots[work->call->rank];
    for (uint32_t g = 0; g < table->group_count; ++g) {
        if (mpi_is_alone(work, &table->groups[g])) continue;
        if (*slots >= MOST_SLOTS) return NORMA_ERROR_OVERFLOW;
        table->groups[g].answer = (uint32_t)(*slots)++;
    }
    return NORMA_OK;
}

enum { ANSWER_OWN = 0, ANSWER_SHARED, ANSWER_ASKED, ANSWER_LENT };

/* What is told to the rank of a record. */
static uint32_t answer_to(const share_work *work, const key_group *group, int votes) {
    const uint32_t lends = work->lend && group->voters == 1;
    if (mpi_is_alone(work, group)) return (uint32_t)ANSWER_OWN << ANSWER_BITS;
    const uint32_t kind = !votes ? ANSWER_ASKED : lends ? ANSWER_LENT : ANSWER_SHARED;
    return kind << ANSWER_BITS | group->answer;
}

static norma_result answer_keys(void *context, const mpi_lists *in, mpi_lists *answers) {
    const share_work *work = context;
    key_table table = {
        .in = in, .key_size = work->key_size, .count = norma_mpi_lists_total(work->call, in)};
    norma_result result = open_table(work->call, &table);
    if (!result) {
        for (size_t i = 0; i < table.count; ++i) group_record(&table, i);
        result = mpi_give_slots(work, &table);
    }
    for (size_t i = 0; i < table.count && !result; ++i) {
        const int votes = norma_mpi_record(in, i)[work->key_size] == MPI_VOTES;
        const uint32_t answer = answer_to(work, &table.groups[table.group_of[i]], votes);
        memcpy(norma_mpi_record(answers, i), &answer, sizeof answer);
    }
    close_table(work->call, &table);
    return result;
}

/* ---- what comes back */

static void lend_sum(mpi_sharing *sharing, mpi_place place, uint64_t sum) {
    sharing->loans[sharing->loan_count++] = (mpi_loan){place, sum};
}

static void read_one(share_work *work, size_t v, int home, uint32_t answer) {
    mpi_sharing *sharing = work->sharing;
    const uint32_t kind = answer >> ANSWER_BITS, slot = answer & ((1U << ANSWER_BITS) - 1);
    if (kind == ANSWER_LENT)
        lend_sum(sharing, norma_mpi_place(MPI_SHARED, home, slot), sharing->own);
    sharing->places[v] =
        norma_mpi_keep_place(kind == ANSWER_SHARED  ? norma_mpi_place(MPI_SHARED, home, slot)
                             : kind == ANSWER_ASKED ? norma_mpi_place(MPI_ASKED, home, slot)
                                                    : place_of_own(work, v));
}

static size_t count_lent(const mpi_call *call, const mpi_lists *answers) {
    size_t lent = 0;
    for (size_t i = 0; i < (size_t)answers->starts[call->ranks]; ++i) {
        uint32_t answer;
        memcpy(&answer, norma_mpi_record(answers, i), sizeof answer);
        lent += answer >> ANSWER_BITS == ANSWER_LENT;
    }
    return lent;
}

static norma_result make_room_for_loans(const mpi_call *call, mpi_sharing *sharing, size_t more) {
    if (sharing->loan_count + more <= sharing->loan_room) return NORMA_OK;
    const size_t room = sharing->loan_count + more + sharing->loan_room / 4 + LEAST_LOANS;
    mpi_loan *loans = norma_core_allocate(call->core, room, sizeof *loans);
    if (!loans) return NORMA_ERROR_MEMORY;
    if (sharing->loan_count) memcpy(loans, sharing->loans, sharing->loan_count * sizeof *loans);
    norma_core_release(call->core, sharing->loans, sharing->loan_room, sizeof *loans);
    sharing->loans = loans;
    sharing->loan_room = room;
    return NORMA_OK;
}

static norma_result read_answers(share_work *work, const mpi_lists *answers) {
    const mpi_call *call = work->call;
    const size_t ranks = (size_t)call->ranks;
    int *next = norma_core_allocate(call->core, ranks, sizeof *next); /* of each rank */
    norma_result result = next ? make_room_for_loans(call, work->sharing, count_lent(call, answers))
                               : NORMA_ERROR_MEMORY;
    if (!result) memcpy(next, answers->starts, ranks * sizeof *next);
    for (size_t v = 0; v < work->sharing->count && !result; ++v) {
        const int home = home_in_round(work, v);
        uint32_t answer;
        if (home < 0) continue;
        memcpy(&answer, norma_mpi_record(answers, (size_t)next[home]++), sizeof answer);
        read_one(work, v, home, answer);
    }
    norma_core_release(call->core, next, ranks, sizeof *next);
    return result;
}

/* ---- rounds */

static norma_result run_round(share_work *work) {
    mpi_call *call = work->call;
    const mpi_listing listing = {
        work->sharing->count, work->key_size + 1, home_in_round, write_key_and_part, work};
    mpi_lists back;
    norma_result result =
        norma_mpi_ask(call, MPI_KEYS, &listing, sizeof(uint32_t), answer_keys, work, &back);
    if (!result) result = norma_mpi_agree(call, read_answers(work, &back));
    norma_mpi_lists_close(call, &back);
    return result;
}

static norma_result open_sharing(const mpi_call *call, mpi_sharing *sharing) {
    const size_t ranks = (size_t)call->ranks;
    if (call->ranks > MPI_MOST_RANKS) return NORMA_ERROR_OVERFLOW;
    sharing->places = norma_core_allocate(call->core, sharing->count, sizeof *sharing->places);
    sharing->slots = norma_core_allocate(call->core, ranks, sizeof *sharing->slots);
    if (!sharing->places || !sharing->slots) return NORMA_ERROR_MEMORY;
    sharing->slots[call->rank] = 0;
    return NORMA_OK;
}

norma_result norma_mpi_share(mpi_call *call, const mpi_keys *keys, const uint8_t *part, int lend,
    size_t budget, mpi_sharing *sharing) {
    share_work work = {.call = call,
        .keys = keys,
        .part = part,
        .lend = lend,
        .key_size = size_of_key(keys),
        .sharing = sharing};
    *sharing = (mpi_sharing){.count = keys->mesh->positions.count, .own = 1};
    norma_result result = norma_mpi_agree(call, open_sharing(call, sharing));
    if (!result) result = plan_rounds(&work, budget);
    for (; work.round < work.rounds && !result; ++work.round) result = run_round(&work);
    if (!result) {
        const uint64_t mine = sharing->slots[call->rank];
        MPI_Allgather(&mine, 1, MPI_UINT64_T, sharing->slots, 1, MPI_UINT64_T, call->comm);
    } else {
        norma_mpi_sharing_close(call, sharing);
    }
    return result;
}

void norma_mpi_sharing_close(const mpi_call *call, mpi_sharing *sharing) {
    norma_core_release(call->core, sharing->places, sharing->count, sizeof *sharing->places);
    norma_core_release(call->core, sharing->loans, sharing->loan_room, sizeof *sharing->loans);
    norma_core_release(call->core, sharing->slots, (size_t)call->ranks, sizeof *sharing->slots);
    *sharing = (mpi_sharing){0};
}
