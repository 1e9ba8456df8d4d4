/* ply_split.c: norma_split of what is near, in which only this rank's own positions are seen. */
#include "mpi/file/ply_split.h"
#include "core/smooth/split.h"
#include "mpi/file/ply_lenders.h"

typedef struct split_work {
    mpi_job *job;
    ply_near *near;
    double scale;
    ply_split *split;
    core_call core;
    core_prepared_mesh prepared;
    int is_open;
    uint8_t *skip; /* of each place */
    size_t places; /* with room in skip */
} split_work;

/* ---- the mesh */

/* Of each place the first of its class; the corners of a lender stand by themselves. */
static uint32_t *weld_places(const split_work *work) {
    const ply_near *near = work->near;
    const ply_part *part = &near->part;
    const size_t count = norma_mpi_places(near), faces = near->face_begins[work->job->call.ranks],
                 lent = part->corners - norma_mpi_corner_begin(part, faces);
    uint32_t *weld = norma_core_allocate(&work->core, count, sizeof *weld);
    for (size_t i = 0; weld && i < count - lent; i++)
        weld[i] = i && near->classes[i] == near->classes[i - 1] ? weld[i - 1] : (uint32_t)i;
    for (size_t f = faces; weld && f < part->faces; f++) {
        const size_t begin = part->corner[norma_mpi_corner_begin(part, f)],
                     end = begin + norma_mpi_corner_begin(part, f + 1) -
                           norma_mpi_corner_begin(part, f);
        for (size_t i = begin; i < end; i++)
            for (weld[i] = (uint32_t)begin; near->classes[weld[i]] != near->classes[i];) weld[i]++;
    }
    return weld;
}

static norma_result begin(split_work *work, core_mesh *checked) {
    const mpi_job *job = work->job;
    const ply_part *part = &work->near->part;
    norma_options options = job->options;
    norma_mesh mesh = {.corners = part->corner, .corner_count = part->corners};
    mesh.positions.data = part->positions;
    mesh.positions.count = norma_mpi_places(work->near);
    mesh.positions.format = part->doubles ? NORMA_FORMAT_DOUBLE : NORMA_FORMAT_FLOAT;
    mesh.face_starts = part->face_starts;
    mesh.face_count = part->face_starts ? part->faces : 0;
    options.threads = 1;
    options.weld = NORMA_WELD_NONE; /* the places are welded already */
    options.edges = &work->split->edges;
    return norma_core_begin_with_crease(
        &work->core, &options, &mesh, (float)job->crease_angle_rad, checked);
}

static norma_result open_prepared(split_work *work) {
    core_mesh checked;
    norma_result result = begin(work, &checked);
    if (result == NORMA_OK) result = norma_core_mesh_content(&work->core, &checked);
    if (result != NORMA_OK) return result;
    if (work->near->part.doubles) checked.scale = work->scale;
    if (!(checked.weld = weld_places(work))) return NORMA_ERROR_MEMORY;
    result = norma_core_prepared_mesh_open(&work->core, &checked, CORE_FOR_FANS,
        (double)(float)work->job->crease_angle_rad, &work->prepared);
    work->is_open = result == NORMA_OK;
    return result;
}

static void close_prepared(split_work *work) {
    if (work->is_open) norma_core_prepared_mesh_close(&work->prepared);
    work->is_open = 0;
}

/* ---- faces without a direction */

static norma_result take_loans(split_work *work, const ply_loans *loans) {
    core_prepared_mesh *prepared = &work->prepared;
    norma_result result = NORMA_OK;
    if (loans->count && !prepared->borrowed_from)
        result = norma_core_find_borrowed_directions(prepared);
    for (size_t i = 0; i < loans->count && result == NORMA_OK; i++)
        prepared->borrowed_from[loans->loans[i].face] = loans->loans[i].lender;
    return result;
}

static norma_result lend_directions(split_work *work, uint64_t vertices) {
    ply_loans loans = {0};
    int grown;
    norma_result result =
        norma_mpi_find_lenders(work->job, vertices, &work->prepared, work->near, &loans, &grown);
    if (result == NORMA_OK && grown) {
        close_prepared(work);
        result = open_prepared(work);
    }
    if (result == NORMA_OK) result = take_loans(work, &loans);
    norma_mpi_close_loans(work->job, &loans);
    return norma_mpi_agree(&work->job->call, result);
}

/* ---- counting and splitting */

/* Each where its first corner is; what has no corners is counted by who read it. */
static void count_degenerate(split_work *work) {
    const ply_near *near = work->near;
    norma_count *count = &work->split->report.degenerate_faces;
    *count = (norma_count){0, SIZE_MAX};
    for (size_t f = 0; f < near->face_begins[work->job->call.ranks]; f++) {
        core_face face;
        const size_t begin = norma_mpi_corner_begin(&near->part, f);
        if (!norma_mpi_is_mine(near, near->part.corner[begin])) continue;
        norma_core_prepared_mesh_face(&work->prepared, f, &face);
        if (!(face.flags & CORE_FACE_DIRECTED) && (face.flags & CORE_FACE_FINITE)) count->count++;
    }
}

static norma_result give_vertices(void *context, size_t count, split_vertices *room) {
    const split_work *work = context;
    const core_call *core = &work->job->core;
    ply_split *split = work->split;
    split->count = count;
    split->sources = norma_core_allocate(core, count, sizeof *split->sources);
    split->normals = norma_core_allocate(core, count, 3 * sizeof *split->normals);
    split->reasons = norma_core_allocate(core, count, 1);
    *room = (split_vertices){split->sources, split->normals, split->reasons};
    return split->sources && split->normals && split->reasons ? NORMA_OK : NORMA_ERROR_MEMORY;
}

static uint32_t *give_corners(void *context) {
    const split_work *work = context;
    ply_split *split = work->split;
    return split->corners =
               norma_core_allocate(&work->job->core, split->corner_count, sizeof *split->corners);
}

static norma_result split_mine(split_work *work) {
    ply_split *split = work->split;
    const ply_near *near = work->near;
    const size_t places = norma_mpi_places(near);
    work->skip = norma_core_allocate(&work->core, places, 1);
    work->places = places;
    split->corner_count = near->part.corners;
    if (!work->skip) return NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < places; i++) work->skip[i] = !norma_mpi_is_mine(near, i);
    const split_room room = {give_vertices, give_corners, work};
    const split_output out = {.skip = work->skip, .reasons = &split->corner_reasons, .room = &room};
    const norma_result result =
        norma_core_split_prepared(&work->prepared, NULL, &out, &split->report);
    if (result == NORMA_OK) count_degenerate(work);
    return result;
}

int norma_mpi_split_near(
    mpi_job *job, uint64_t vertices, double scale, ply_near *near, ply_split *split) {
    mpi_call *call = &job->call;
    split_work work = {.job = job, .near = near, .scale = scale, .split = split};
    *split = (ply_split){0};
    norma_result result = norma_mpi_agree(call, open_prepared(&work));
    if (result == NORMA_OK) result = lend_directions(&work, vertices);
    if (result == NORMA_OK) result = norma_mpi_agree(call, split_mine(&work));
    norma_core_release(&work.core, work.skip, work.places, 1);
    close_prepared(&work);
    return norma_mpi_failed_result(job, result);
}

void norma_mpi_release_vertices(mpi_job *job, ply_split *split) {
    const core_call *core = &job->core;
    const size_t count = split->count;
    norma_core_release(core, split->sources, count, sizeof *split->sources);
    norma_core_release(core, split->normals, count, 3 * sizeof *split->normals);
    norma_core_release(core, split->reasons, count, 1);
    split->sources = NULL;
    split->normals = NULL;
    split->reasons = NULL;
    split->count = 0;
}

void norma_mpi_close_split(mpi_job *job, ply_split *split) {
    const core_call *core = &job->core;
    const size_t corners = split->corner_count;
    norma_mpi_release_vertices(job, split);
    norma_core_release(core, split->corners, corners, sizeof *split->corners);
    norma_core_release(core, split->corner_reasons, corners, 1);
    *split = (ply_split){0};
}
