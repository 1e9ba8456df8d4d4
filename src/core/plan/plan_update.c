/* plan_update.c: one update. It writes nothing of the plan: updates of one may run at once. */
#include "core/plan/plan.h"

static size_t element_count(const norma_plan *plan) {
    return plan->of == NORMA_PER_VERTEX ? plan->vertex_count : plan->corner_count;
}

/* ---- vertices without corners */

static void write_lonely(const plan_work *work, uint32_t vertex) {
    double p[3];
    norma_core_position(&work->mesh, vertex, p);
    norma_core_write_element(work->output, vertex,
        norma_core_finite(p) ? NORMA_REASON_UNREFERENCED : NORMA_REASON_NON_FINITE,
        work->output->fallback, work->tally);
}

static size_t lonely_number(const norma_plan *plan, uint32_t vertex) {
    size_t low = 0, high = plan->lonely_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (plan->lonely[middle] < vertex)
            low = middle + 1;
        else
            high = middle;
    }
    return low < plan->lonely_count && plan->lonely[low] == vertex ? low : SIZE_MAX;
}

enum { LONELY_IN_BLOCK = 1 << 16 };

/* Each once, however often it is named. */
static void update_moved_lonely(const plan_work *work) {
    const norma_plan *plan = work->plan;
    uint64_t bits[LONELY_IN_BLOCK / 64];
    for (size_t first = 0; first < plan->lonely_count; first += LONELY_IN_BLOCK) {
        memset(bits, 0, sizeof bits);
        for (size_t i = 0; i < work->moved_count; i++) {
            const size_t number = lonely_number(plan, work->moved[i]);
            if (number == SIZE_MAX || number < first || number - first >= LONELY_IN_BLOCK) continue;
            const uint64_t bit = (uint64_t)1 << (number % 64);
            if (!(bits[(number - first) / 64] & bit)) write_lonely(work, work->moved[i]);
            bits[(number - first) / 64] |= bit;
        }
    }
}

static void update_lonely(const plan_work *work) {
    if (work->plan->of != NORMA_PER_VERTEX) return;
    if (work->moved)
        update_moved_lonely(work);
    else
        for (size_t i = 0; i < work->plan->lonely_count; i++)
            write_lonely(work, work->plan->lonely[i]);
}

static norma_result update(plan_work *work) {
    norma_result result = norma_core_plan_update_blocks(work);
    if (result == NORMA_OK) result = norma_core_plan_update_overflow(work);
    if (result != NORMA_OK) return result;
    update_lonely(work);
    if (!work->moved) norma_core_count_add(&work->tally->degenerate, &work->plan->empty_faces);
    return NORMA_OK;
}

/* ---- the nearest normal: the one fallback that needs all others, and memory to look them up */

typedef struct plan_scratch {
    float *normals;
    uint8_t *reasons;
    uint32_t *vertices; /* per corner: of each corner */
    size_t count;
} plan_scratch;

/* All normals and reasons, whatever moved: a normal may be wanted far from where it changed. */
static norma_result update_scratch(const plan_work *work, plan_scratch *scratch) {
    core_tally tally = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    const core_output output = {.normals = (unsigned char *)scratch->normals,
        .stride = 3 * sizeof(float),
        .reasons = scratch->reasons};
    plan_work all = *work;
    all.output = &output;
    all.moved = NULL;
    all.tally = &tally;
    return update(&all);
}

static uint32_t vertex_of_element(const plan_scratch *scratch, size_t element) {
    return scratch->vertices ? scratch->vertices[element] : (uint32_t)element;
}

static void write_nearest_normal(
    const plan_work *work, const plan_scratch *scratch, core_nearest *nearest) {
    const float zero[3] = {0, 0, 0};
    for (size_t e = 0; e < scratch->count; e++) {
        if (scratch->reasons[e] == NORMA_REASON_NONE) continue;
        const uint32_t source = norma_core_nearest_find(nearest, vertex_of_element(scratch, e));
        norma_core_write_normal(
            work->output, e, source == UINT32_MAX ? zero : scratch->normals + 3 * (size_t)source);
    }
}

static norma_result look_up_nearest(const plan_work *work, const plan_scratch *scratch) {
    core_nearest nearest;
    size_t wanting = 0;
    core_mesh mesh = work->mesh;
    norma_result result = norma_core_nearest_begin(work->call, &mesh, &nearest);
    if (result != NORMA_OK) return result;
    for (size_t e = 0; e < scratch->count; e++) {
        if (scratch->reasons[e] == NORMA_REASON_NONE)
            norma_core_nearest_add(&nearest, vertex_of_element(scratch, e), (uint32_t)e);
        else
            wanting++;
    }
    result = norma_core_nearest_plant(&nearest, wanting);
    if (result == NORMA_OK) write_nearest_normal(work, scratch, &nearest);
    norma_core_nearest_end(&nearest);
    return result;
}

static norma_result fill_plan_from_nearest(const plan_work *work) {
    const norma_plan *plan = work->plan;
    const int per_corner = plan->of == NORMA_PER_CORNER;
    plan_scratch scratch = {.count = element_count(plan)};
    scratch.normals = norma_core_allocate(work->call, scratch.count, 3 * sizeof *scratch.normals);
    scratch.reasons = norma_core_allocate(work->call, scratch.count, 1);
    if (per_corner)
        scratch.vertices = norma_core_allocate(work->call, scratch.count, sizeof *scratch.vertices);
    norma_result result = scratch.normals && scratch.reasons && (!per_corner || scratch.vertices)
                              ? NORMA_OK
                              : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) result = update_scratch(work, &scratch);
    if (result == NORMA_OK && per_corner) {
        norma_core_plan_block_vertices(plan, scratch.vertices);
        norma_core_plan_overflow_vertices(plan, scratch.vertices);
    }
    if (result == NORMA_OK) result = look_up_nearest(work, &scratch);
    norma_core_release(work->call, scratch.normals, scratch.count, 3 * sizeof *scratch.normals);
    norma_core_release(work->call, scratch.reasons, scratch.count, 1);
    norma_core_release(work->call, scratch.vertices, scratch.count, sizeof *scratch.vertices);
    return result;
}

/* ---- the call */

/* All of them in order is all. */
static norma_result check_moved(const norma_plan *plan, const uint32_t **moved, size_t count) {
    uint32_t largest = 0, out_of_order = 0;
    for (size_t i = 0; i < count; i++) {
        largest = (*moved)[i] > largest ? (*moved)[i] : largest;
        out_of_order |= (*moved)[i] ^ (uint32_t)i;
    }
    if (count && largest >= plan->vertex_count) return NORMA_ERROR_INDEX;
    if (count == plan->vertex_count && !out_of_order) *moved = NULL;
    return NORMA_OK;
}

static norma_result open_plan_work(const norma_plan *plan, norma_vec3_view positions,
    const uint32_t *moved, size_t moved_count, core_call *call, plan_work *work) {
    const norma_mesh points = {.positions = positions};
    norma_result result = norma_core_mesh_shape(&points, &work->mesh);
    if (result == NORMA_OK && positions.count != plan->vertex_count) result = NORMA_ERROR_ARGUMENT;
    if (result == NORMA_OK && moved) result = check_moved(plan, &moved, moved_count);
    if (positions.format == NORMA_FORMAT_DOUBLE) work->mesh.scale = plan->scale;
    work->plan = plan;
    work->call = call;
    work->moved = moved;
    work->moved_count = moved_count;
    return result;
}

norma_result norma_plan_update(const norma_plan *plan, norma_vec3_view positions,
    const uint32_t *moved, size_t moved_count, const norma_options *options, float *normals,
    size_t capacity, norma_report *report) {
    core_call call;
    core_output output;
    core_tally tally = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    plan_work work = {.output = &output, .tally = &tally};
    if (!plan) return NORMA_ERROR_ARGUMENT;
    norma_result result = norma_core_begin(&call, options);
    if (result == NORMA_OK)
        result = norma_core_output_open(&call, normals, element_count(plan), capacity, &output);
    if (result == NORMA_OK)
        result = open_plan_work(plan, positions, moved, moved_count, &call, &work);
    if (result == NORMA_OK) norma_core_share(&call, plan->corner_count);
    if (result != NORMA_OK) return result;
    result = update(&work);
    const size_t without =
        tally.non_finite.count + tally.unreferenced.count + tally.cancelled.count;
    if (result == NORMA_OK && output.nearest && (work.moved ? moved_count : without))
        result = fill_plan_from_nearest(&work);
    if (result == NORMA_OK && norma_core_progress(&call, 1)) result = NORMA_CANCELLED;
    if (result == NORMA_OK) norma_core_write_report(report, &tally, NULL, NULL);
    return result;
}
