/* together.c: norma_together_compute: twice over all files, and their outputs at the end, all or
 * none. */
#include "io/together/together.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- all faces of all files become one mesh, in an order that follows from where they lie:
 * positions by their coordinates, faces by their positions, each from its least position on. What
 * the core computes of that mesh does not depend on the files, their order, or how the surface was
 * cut. */

typedef struct gathered_face {
    const uint32_t *corners; /* numbers of positions, in the mesh's order, from its least on */
    uint32_t count, group;
    uint32_t shift; /* of its corners in the file, after they were reversed under a mirror */
    uint32_t reversed, file; /* file: UINT32_MAX where it is drawn once more */
    size_t begin;            /* of its corners */
} gathered_face;

struct creases {
    double (*positions)[3]; /* of each surface wherever it is drawn */
    size_t position_count, position_room;
    uint32_t *corners; /* those positions; later the numbers of the mesh's */
    size_t corner_count, corner_room;
    gathered_face *faces;
    size_t face_count, face_room;
    int grouped;
    float *normals; /* of each corner, as gathered */
    uint8_t *reasons;
    size_t next_corner; /* of the surface that is asked for next */
};

static norma_document_result fail_creases(const together_run *run) {
    return norma_document_fail_memory(NULL, run->error);
}

static void creases_free(creases *c) {
    if (!c) return;
    void *const blocks[] = {c->positions, c->corners, c->faces, c->normals, c->reasons};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i) free(blocks[i]);
    free(c);
}

/* ---- gathering */

static int make_crease_room(creases *c, const norma_mesh *mesh, size_t faces) {
    double(*positions)[3] = norma_io_grow(c->positions, &c->position_room,
        c->position_count + mesh->positions.count, sizeof *positions);
    if (positions) c->positions = positions;
    uint32_t *corners = norma_io_grow(
        c->corners, &c->corner_room, c->corner_count + mesh->corner_count, sizeof *corners);
    if (corners) c->corners = corners;
    gathered_face *grown =
        norma_io_grow(c->faces, &c->face_room, c->face_count + faces, sizeof *grown);
    if (grown) c->faces = grown;
    return positions && corners && grown &&
           c->position_count + mesh->positions.count < UINT32_MAX &&
           c->corner_count + mesh->corner_count < UINT32_MAX;
}

/* Faces without a group of their own are smooth with all others that have one. */
static void take_soup_faces(
    creases *c, const norma_mesh *mesh, size_t faces, const placement *place, size_t file) {
    const uint32_t base = (uint32_t)c->position_count;
    for (size_t f = 0; f < faces; ++f) {
        const size_t begin = mesh->face_starts ? mesh->face_starts[f] : 3 * f,
                     end = mesh->face_starts ? mesh->face_starts[f + 1] : 3 * f + 3;
        c->grouped |= mesh->smoothing_groups != NULL;
        c->faces[c->face_count++] = (gathered_face){.begin = c->corner_count,
            .count = (uint32_t)(end - begin),
            .group = mesh->smoothing_groups ? mesh->smoothing_groups[f] : UINT32_MAX,
            .reversed = place->mirrored != 0,
            .file = (uint32_t)file};
        for (size_t k = begin; k < end; ++k)
            c->corners[c->corner_count++] =
                base + norma_mesh_corner(mesh, place->mirrored ? end - 1 - (k - begin) : k);
    }
}

static norma_document_result take_creased_surface(void *user, const placed_surface *at) {
    creases *c = user;
    const norma_mesh *mesh = at->surface->mesh;
    const size_t faces = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
    for (size_t i = 0; i < at->count; ++i) {
        if (at->places[i].level)
            return norma_document_fail(at->m->document, at->run->error,
                NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
                "a level of detail takes the normals of a finer one, which creases do not allow; "
                "compute it without a crease, or the levels one by one");
        if (!make_crease_room(c, mesh, faces)) return fail_creases(at->run);
        take_soup_faces(c, mesh, faces, &at->places[i], i ? UINT32_MAX : at->run->number);
        for (size_t v = 0; v < mesh->positions.count; ++v)
            norma_together_position(
                at->surface, &at->places[i], v, c->positions[c->position_count++]);
    }
    return NORMA_DOCUMENT_OK;
}

/* First pass: the faces of a file, wherever they are drawn. */
static norma_document_result creases_take(together_run *run, member *m) {
    if (!run->creases) run->creases = calloc(1, sizeof *run->creases);
    return run->creases ? norma_member_visit(run, m, take_creased_surface, run->creases)
                        : fail_creases(run);
}

/* ---- positions in their order */

typedef struct ordered_position {
    double at[3];
    const double *position;
} ordered_position;

/* Numbers that are none come last, all alike. */
static int compare_vertex_numbers(const double *a, const double *b) {
    for (int k = 0; k < 3; ++k) {
        const int none_a = isnan(a[k]) != 0, none_b = isnan(b[k]) != 0;
        if (none_a != none_b) return none_a - none_b;
        if (a[k] < b[k] || a[k] > b[k]) return a[k] < b[k] ? -1 : 1;
    }
    return 0;
}

static int compare_positions(const void *a, const void *b) {
    const ordered_position *p = a, *q = b;
    const int order = compare_vertex_numbers(p->at, q->at);
    return order ? order : compare_vertex_numbers(p->position, q->position);
}

/* The distinct positions in their order, and of each gathered one its number. Where rounding makes
 * several one, the least stands for them. */
static double *number_positions(const together_run *run, uint32_t *numbers, size_t *distinct) {
    const creases *c = run->creases;
    const equality equal = {.rounded = run->equal.rounded};
    ordered_position *all = norma_io_block(c->position_count, sizeof *all);
    double *positions = norma_io_block(c->position_count, 3 * sizeof *positions);
    *distinct = 0;
    for (size_t i = 0; all && i < c->position_count; ++i) {
        all[i].position = c->positions[i];
        norma_together_at(&equal, c->positions[i], all[i].at);
    }
    if (all && positions) qsort(all, c->position_count, sizeof *all, compare_positions);
    for (size_t i = 0; all && positions && i < c->position_count; ++i) {
        if (i == 0 || compare_vertex_numbers(all[i].at, all[i - 1].at) != 0)
            memcpy(positions + 3 * (*distinct)++, all[i].position, sizeof(double[3]));
        numbers[(size_t)(all[i].position - c->positions[0]) / 3] = (uint32_t)(*distinct - 1);
    }
    if (!all) {
        free(positions);
        positions = NULL;
    }
    free(all);
    return positions;
}

/* ---- faces in their order */

static int compare_turned(const uint32_t *corners, size_t count, size_t a, size_t b) {
    for (size_t k = 0; k < count; ++k) {
        const uint32_t p = corners[(a + k) % count], q = corners[(b + k) % count];
        if (p != q) return p < q ? -1 : 1;
    }
    return 0;
}

/* room: for the corners of the face. */
static void turn_face(gathered_face *face, uint32_t *corners, uint32_t *room) {
    for (uint32_t k = 1; k < face->count; ++k)
        if (corners[k] <= corners[face->shift] &&
            compare_turned(corners, face->count, k, face->shift) < 0)
            face->shift = k;
    memcpy(room, corners, face->count * sizeof *room);
    for (uint32_t k = 0; k < face->count; ++k) corners[k] = room[(face->shift + k) % face->count];
    face->corners = corners;
}

static int compare_faces(const void *a, const void *b) {
    const gathered_face *p = a, *q = b;
    if (p->count != q->count) return p->count < q->count ? -1 : 1;
    for (uint32_t k = 0; k < p->count; ++k)
        if (p->corners[k] != q->corners[k]) return p->corners[k] < q->corners[k] ? -1 : 1;
    return p->group < q->group ? -1 : p->group > q->group;
}

static int turn_mirrored_faces(creases *c, const uint32_t *numbers) {
    uint32_t most = 0;
    for (size_t f = 0; f < c->face_count; ++f)
        most = c->faces[f].count > most ? c->faces[f].count : most;
    uint32_t *room = norma_io_allocate(most, sizeof *room);
    for (size_t i = 0; room && i < c->corner_count; ++i) c->corners[i] = numbers[c->corners[i]];
    for (size_t f = 0; room && f < c->face_count; ++f)
        turn_face(&c->faces[f], c->corners + c->faces[f].begin, room);
    free(room);
    return room != NULL;
}

/* ---- the mesh of all */

typedef struct joint_mesh {
    double *positions;
    size_t position_count;
    uint32_t *corners, *starts, *groups;
    float *normals;
    uint8_t *reasons;
} joint_mesh;

static void free_joint(joint_mesh *j) {
    void *const blocks[] = {j->positions, j->corners, j->starts, j->groups, j->normals, j->reasons};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i) free(blocks[i]);
}

static int order_soup_faces(creases *c, joint_mesh *j) {
    j->corners = norma_io_block(c->corner_count, sizeof *j->corners);
    j->starts = norma_io_block(c->face_count + 1, sizeof *j->starts);
    j->groups = c->grouped ? norma_io_block(c->face_count, sizeof *j->groups) : NULL;
    j->normals = norma_io_block(c->corner_count, 3 * sizeof *j->normals);
    j->reasons = norma_io_allocate(c->corner_count, 1);
    if (!j->corners || !j->starts || (c->grouped && !j->groups) || !j->normals || !j->reasons)
        return 0;
    if (c->face_count) qsort(c->faces, c->face_count, sizeof *c->faces, compare_faces);
    uint32_t at = 0;
    for (size_t f = 0; f < c->face_count; ++f) {
        const gathered_face *face = &c->faces[f];
        j->starts[f] = at;
        if (j->groups) j->groups[f] = face->group;
        memcpy(j->corners + at, face->corners, face->count * sizeof *j->corners);
        at += face->count;
    }
    j->starts[c->face_count] = at;
    return 1;
}

static int stop_creases(void *user, double share) {
    (void)share;
    return norma_together_tell(user, 0);
}

static norma_result count_degenerate_faces(
    together_run *run, const norma_mesh *mesh, const norma_options *given) {
    const creases *c = run->creases;
    norma_options options = *given;
    float *normals = norma_io_block(c->face_count, 3 * sizeof *normals);
    uint8_t *reasons = norma_io_allocate(c->face_count, 1);
    options.reasons = reasons;
    options.fallback = NORMA_FALLBACK_ZERO;
    const norma_result result =
        normals && reasons ? norma_face_normals(mesh, &options, normals, c->face_count, NULL)
                           : NORMA_ERROR_MEMORY;
    for (size_t f = 0; !result && f < c->face_count; ++f)
        if (reasons[f] == NORMA_REASON_DEGENERATE && c->faces[f].file != UINT32_MAX)
            ++run->degenerate[c->faces[f].file];
    free(normals);
    free(reasons);
    return result;
}

static norma_result run_creases(together_run *run, const joint_mesh *j) {
    const creases *c = run->creases;
    const norma_compute_options *o = &run->compute;
    const norma_mesh mesh = {.positions = {.data = j->positions,
                                 .count = j->position_count,
                                 .format = NORMA_FORMAT_DOUBLE},
        .corners = j->corners,
        .corner_count = c->corner_count,
        .corner_size = 4,
        .face_starts = j->starts,
        .face_count = c->face_count,
        .smoothing_groups = o->groups == NORMA_GROUPS_AUTO ? j->groups : NULL};
    const norma_options options = {.struct_size = sizeof options,
        .weight = o->weight,
        .weld = o->weld == NORMA_WELD_DISTANCE ? o->weld : NORMA_WELD_NONE,
        .weld_distance = o->weld_distance,
        .non_manifold = o->non_manifold,
        .fallback = NORMA_FALLBACK_NEAREST,
        .threads = o->threads,
        .reasons = j->reasons,
        .progress = stop_creases,
        .progress_user = run};
    const norma_result result = norma_corner_normals(
        &mesh, (float)o->crease_angle_rad, &options, j->normals, c->corner_count, NULL);
    return result ? result : count_degenerate_faces(run, &mesh, &options);
}

/* Back to the corners as they were gathered. */
static int hand_back(creases *c, const joint_mesh *j) {
    c->normals = norma_io_block(c->corner_count, 3 * sizeof *c->normals);
    c->reasons = norma_io_allocate(c->corner_count, 1);
    if (!c->normals || !c->reasons) return 0;
    for (size_t f = 0; f < c->face_count; ++f) {
        const gathered_face *face = &c->faces[f];
        for (uint32_t k = 0; k < face->count; ++k) {
            const uint32_t turned = (face->shift + k) % face->count;
            const size_t from = j->starts[f] + k,
                         to = face->begin + (face->reversed ? face->count - 1 - turned : turned);
            memcpy(c->normals + 3 * to, j->normals + 3 * from, 3 * sizeof *c->normals);
            c->reasons[to] = j->reasons[from];
        }
    }
    return 1;
}

/* Then the normals of all corners. */
static norma_document_result own_creases_compute(together_run *run) {
    creases *c = run->creases;
    joint_mesh j = {.positions = NULL};
    uint32_t *numbers = norma_io_block(c->position_count, sizeof *numbers);
    if (numbers) j.positions = number_positions(run, numbers, &j.position_count);
    free(c->positions);
    c->positions = NULL;
    int made = numbers && j.positions && turn_mirrored_faces(c, numbers) && order_soup_faces(c, &j);
    free(numbers);
    const norma_result failed = made && c->corner_count ? run_creases(run, &j) : NORMA_OK;
    if (!failed && made) made = hand_back(c, &j);
    free_joint(&j);
    if (failed) return norma_document_fail_core(NULL, run->error, failed);
    return made ? NORMA_DOCUMENT_OK : fail_creases(run);
}

/* ---- of one surface */

/* Of a mesh at one place; made: of each corner. */
static void take_place(creases *c, const placement *place, surface_normals *made) {
    for (size_t i = 0; i < made->count; ++i, ++c->next_corner) {
        position_normal normal = {.kept = 1};
        for (int k = 0; k < 3; ++k)
            normal.direction[k] = (double)c->normals[3 * c->next_corner + (size_t)k];
        norma_together_into_mesh(place, &normal, made->normals + 3 * i);
        made->reasons[i] = c->reasons[c->next_corner];
    }
}

static int make_normals_room(surface_normals *made, size_t count) {
    made->count = count;
    made->normals = norma_io_allocate(count, 3 * sizeof *made->normals);
    made->reasons = norma_io_allocate(count, 1);
    return made->normals && made->reasons;
}

/* Of a mesh that nothing draws: by itself. */
static norma_document_result compute_alone_creased(
    const together_run *run, const document_surface *surface, surface_normals *made) {
    const norma_compute_options *o = &run->compute;
    const norma_options options = {.struct_size = sizeof options,
        .weight = o->weight,
        .non_manifold = o->non_manifold,
        .fallback = NORMA_FALLBACK_NEAREST,
        .threads = o->threads,
        .reasons = made->reasons};
    return norma_document_fail_core(NULL, run->error,
        norma_corner_normals(
            surface->mesh, (float)o->crease_angle_rad, &options, made->normals, made->count, NULL));
}

static norma_document_result creases_surface(const placed_surface *at, surface_normals *made) {
    surface_normals other = {0};
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!at->count) return compute_alone_creased(at->run, at->surface, made);
    if (at->count > 1 && !make_normals_room(&other, made->count)) result = fail_creases(at->run);
    for (size_t i = 0; i < at->count && !result; ++i) {
        take_place(at->run->creases, &at->places[i], i ? &other : made);
        for (size_t c = 0; i && c < made->count && !result; ++c)
            if (norma_together_differ(other.normals + 3 * c, made->normals + 3 * c))
                result = norma_together_fail_places(at);
    }
    free(other.normals);
    free(other.reasons);
    return result;
}

/* ---- norma_together_compute: twice over all files, and their outputs at the end, all or none. */

/* ---- The second pass over a file, and all outputs into place. */

typedef struct writing {
    together_run *run;
    member *m;
    surface_normals *surfaces; /* by their numbers */
    size_t count, room;
} writing;

/* ---- normals */

static size_t count_shared(const together_run *run, const norma_mesh *mesh) {
    return run->creases ? mesh->corner_count : mesh->positions.count;
}

static norma_document_result make_shared_normals(void *user, const placed_surface *at) {
    writing *w = user;
    const size_t number = at->surface->number;
    surface_normals *grown = norma_io_grow(w->surfaces, &w->room, number + 1, sizeof *grown);
    if (!grown) return norma_together_fail_memory(at);
    w->surfaces = grown;
    for (; w->count <= number; ++w->count) w->surfaces[w->count] = (surface_normals){0};
    surface_normals *made = &w->surfaces[number];
    if (!make_normals_room(made, count_shared(w->run, at->surface->mesh)))
        return w->run->creases ? fail_creases(w->run) : norma_together_fail_memory(at);
    return w->run->creases ? creases_surface(at, made) : norma_together_surface_normals(at, made);
}

static norma_result take_summary(
    void *user, size_t surface, const norma_mesh *mesh, float *normals, uint8_t *reasons) {
    const writing *w = user;
    if (surface >= w->count || w->surfaces[surface].count != count_shared(w->run, mesh))
        return NORMA_ERROR_ARGUMENT;
    const surface_normals *made = &w->surfaces[surface];
    memcpy(normals, made->normals, made->count * 3 * sizeof *normals);
    if (reasons) memcpy(reasons, made->reasons, made->count);
    return NORMA_OK;
}

static int tell_written(void *user, double share) { return norma_together_tell(user, 0.8 * share); }

static norma_document_result compute_member(writing *w) {
    together_run *run = w->run;
    norma_document *document = w->m->document;
    norma_compute_summary summary;
    norma_compute_options options = run->compute;
    const shared_normals shared = {w, take_summary, w->m->locked, run->creases != NULL};
    options.weld = NORMA_WELD_EXACT;
    options.progress = tell_written;
    options.progress_user = run;
    document->shared = &shared;
    const norma_document_result result =
        norma_document_compute(document, &options, &summary, run->error);
    document->shared = NULL;
    summary.report.degenerate_faces.count = run->degenerate[run->number];
    summary.report.degenerate_faces.first = SIZE_MAX;
    if (run->files[run->number].summary) *run->files[run->number].summary = summary;
    return result;
}

/* ---- the output */

static int is_writing_cancelled(void *user, double share) {
    (void)share;
    return norma_together_tell(user, 0.9);
}

static norma_document_result prepare_output(writing *w) {
    together_run *run = w->run;
    const norma_together_file *file = &run->files[run->number];
    const norma_save_options options = {.struct_size = sizeof options,
        .in_place = run->options.in_place,
        .progress = is_writing_cancelled,
        .progress_user = run};
    run->writers.size = 0;
    norma_document_result result = norma_document_check_target(
        w->m->document, file->output, run->options.in_place, run->error);
    if (!result)
        result = norma_document_prepare(
            w->m->document, file->output, &options, &run->writers, run->error);
    if (result) return result;
    if (file->size) *file->size = run->writers.size;
    if (run->options.file_done)
        run->options.file_done(run->options.file_done_user, run->number, w->m->document);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result together_write_file(together_run *run, member *m) {
    writing w = {.run = run, .m = m};
    norma_document_result result = norma_member_visit(run, m, make_shared_normals, &w);
    if (!result) result = compute_member(&w);
    if (!result) result = prepare_output(&w);
    for (size_t i = 0; i < w.count; ++i) {
        free(w.surfaces[i].normals);
        free(w.surfaces[i].reasons);
    }
    free(w.surfaces);
    return result;
}

/* ---- into place */

typedef struct output {
    const char *path;
    file_writer *writer;
    size_t number;
} output;

static int compare_outputs(const void *a, const void *b) {
    const output *p = a, *q = b;
    const int order = strcmp(p->path, q->path);
    return order ? order : p->number < q->number ? -1 : p->number > q->number;
}

static void drop_output(together_run *run, size_t number) {
    norma_file_writer_abandon(run->writers.list[number]);
    run->writers.list[number] = NULL;
}

/* Assets of one folder may name one image or one buffer: it is written once where all of them write
 * the same. */
static norma_document_result join_equal_outputs(together_run *run) {
    const size_t count = run->writers.count;
    output *all = norma_io_allocate(count, sizeof *all);
    norma_document_result result =
        all ? NORMA_DOCUMENT_OK : norma_document_fail_memory(NULL, run->error);
    for (size_t i = 0; i < count && !result; ++i)
        all[i] = (output){run->writers.paths[i], run->writers.list[i], i};
    if (!result) qsort(all, count, sizeof *all, compare_outputs);
    for (size_t i = 1, kept = 0; i < count && !result; ++i) {
        const int meet = strcmp(all[kept].path, all[i].path) == 0
                             ? norma_file_writers_meet(all[kept].writer, all[i].writer)
                             : 0;
        if (meet == 0) kept = i;
        if (meet == 1) drop_output(run, all[i].number);
        if (meet == 2) {
            const norma_document named = {.path = run->writers.paths[all[i].number]};
            result = norma_document_fail(&named, run->error, NORMA_DOCUMENT_ERROR_REFUSED, NULL,
                "several outputs would write this file with different bytes; give each a buffer of "
                "its own, for example as GLB");
        }
    }
    free(all);
    return result;
}

static void close_gaps(companion_writers *writers) {
    size_t kept = 0;
    for (size_t i = 0; i < writers->count; ++i) {
        if (!writers->list[i]) {
            free(writers->paths[i]);
            continue;
        }
        writers->list[kept] = writers->list[i];
        writers->paths[kept++] = writers->paths[i];
    }
    writers->count = kept;
}

static norma_document_result together_commit(together_run *run) {
    companion_writers *writers = &run->writers;
    norma_document_result result = join_equal_outputs(run);
    if (result) return result;
    close_gaps(writers);
    if (!writers->count) return NORMA_DOCUMENT_OK;
    result = norma_document_commit(writers, run->error);
    if (result) return result;
    norma_document_free_writers(writers, 0);
    *writers = (companion_writers){0};
    return NORMA_DOCUMENT_OK;
}

/* ---- Norma_together_compute. Once over all files to take down what their faces add at each
 * position; then position by position what follows; then once more over the files, which get it.
 * Nothing of a file is held meanwhile. Outputs are put in place at the end, all or none. */

static const uint64_t JOINING_MEMORY = (uint64_t)1 << 29;

/* ---- options */

static norma_document_result fail_option(norma_document_error *error, const char *what) {
    return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", what);
}

static const char *bad_choice(const norma_compute_options *o) {
    if (o->shading == NORMA_SHADING_FLAT)
        return "flat normals cannot be shared; compute each file by itself";
    if (o->weld == NORMA_WELD_NONE)
        return "without welding nothing is shared; expected exact or a distance";
    if (o->weight == NORMA_WEIGHT_VISIBLE)
        return "the weight visible is not summed over faces and cannot be shared between files; "
               "expected another weight";
    if (o->only != NORMA_ONLY_ALL)
        return "all normals of a joined surface are computed; lock those that should stay";
    return NULL;
}

static const char *bad_crease(const together_run *run) {
    return run->compute.shading == NORMA_SHADING_CREASE &&
                   (run->options.levels || run->options.lock_count)
               ? "levels of detail and locked normals need smooth normals; expected no crease"
               : NULL;
}

static const char *bad_file(const norma_together_file *files, size_t count) {
    if (count && !files) return "no files were given";
    for (size_t i = 0; i < count; ++i)
        if (!files[i].input || !files[i].output) return "a file has no path";
    return NULL;
}

/* ---- the run */

static norma_document_result each_file(
    together_run *run, norma_document_result (*visit)(together_run *run, member *m)) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (run->number = 0; run->number < run->count && !result; ++run->number) {
        member m;
        result = norma_member_open(run, &m);
        if (!result) result = visit(run, &m);
        norma_member_close(&m);
        if (!result && norma_together_tell(run, 1))
            result =
                norma_document_fail(NULL, run->error, NORMA_DOCUMENT_CANCELLED, NULL, "cancelled");
    }
    run->passes_done += 1;
    run->options.lock_matches = NULL; /* the first time over all files counts */
    return result;
}

static norma_document_result join_near(together_run *run) {
    if (run->compute.weld != NORMA_WELD_DISTANCE) return NORMA_DOCUMENT_OK;
    run->near = norma_near_begin();
    if (!run->near) return norma_document_fail_memory(NULL, run->error);
    norma_document_result result = each_file(run, norma_together_take_positions);
    if (result) return result;
    const norma_result joined =
        norma_near_end(run->near, run->compute.weld_distance, run->compute.threads);
    run->equal.near = run->near;
    return joined ? norma_document_fail_memory(NULL, run->error) : NORMA_DOCUMENT_OK;
}

static norma_document_result run_creased(together_run *run) {
    run->degenerate = norma_io_allocate(run->count, sizeof *run->degenerate);
    if (!run->degenerate) return norma_document_fail_memory(NULL, run->error);
    norma_document_result result = each_file(run, creases_take);
    if (!result) result = own_creases_compute(run);
    if (!result) result = each_file(run, together_write_file);
    return result ? result : together_commit(run);
}

static norma_document_result join_all(together_run *run) {
    if (run->compute.shading == NORMA_SHADING_CREASE) return run_creased(run);
    run->votes = norma_spill_open(run->folder, sizeof(position_votes));
    run->normals = norma_spill_open(run->folder, sizeof(position_normal));
    run->degenerate = norma_io_allocate(run->count, sizeof *run->degenerate);
    if (!run->votes || !run->normals || !run->degenerate)
        return norma_document_fail_memory(NULL, run->error);
    norma_document_result result = join_near(run);
    if (!result) result = each_file(run, norma_together_take_votes);
    if (result) return result;
    if (run->seams) result = norma_seams_find(run);
    if (result) return result;
    const int failed = norma_together_join(run->votes, run->normals, run->options.max_memory / 4,
        run->seams ? norma_seams_take : NULL, run->seams);
    if (failed && run->seams && failed < 0) return norma_seams_fail(run);
    if (failed) return norma_together_fail_spill(run, failed);
    norma_spill_close(run->votes);
    run->votes = NULL;
    norma_spill_rewind(run->normals);
    result = each_file(run, together_write_file);
    return result ? result : together_commit(run);
}

/* One tile of a surface whose votes are known. */
static norma_document_result begin_seams_run(together_run *run) {
    const char *bad = run->count != 1 ? "votes go to one file at a time" : NULL;
    if (run->compute.shading != NORMA_SHADING_SMOOTH || run->compute.weld != NORMA_WELD_EXACT ||
        run->options.lock_count || run->options.levels)
        bad = "with votes, normals are smooth and equal positions are joined, and no more";
    if (bad) return fail_option(run->error, bad);
    run->tile.marks = 1;
    const norma_document_result result =
        norma_seams_open(run->options.votes, &run->seams, run->error);
    if (result) return result;
    norma_seams_choose(
        run->seams, &run->compute.weight, &run->equal.rounded, &run->tile.everywhere);
    if (run->options.weight) *run->options.weight = run->compute.weight;
    return result;
}

static void end_run(together_run *run) {
    norma_seams_close(run->seams);
    norma_spill_close(run->votes);
    norma_spill_close(run->normals);
    norma_near_free(run->near);
    creases_free(run->creases);
    norma_document_free_writers(&run->writers, 1);
    free(run->degenerate);
    free(run->own_folder);
}

norma_document_result norma_together_compute(const norma_together_file *files, size_t count,
    const norma_together_options *options, const norma_compute_options *compute,
    norma_document_error *error) {
    together_run run = {.files = files, .count = count, .error = error, .writers = {.outlive = 1}};
    norma_document_clear(error);
    norma_document_copy_options(
        &run.options, sizeof run.options, offsetof(norma_together_options, lock_matches), options);
    norma_document_copy_options(
        &run.compute, sizeof run.compute, offsetof(norma_compute_options, tangents), compute);
    const char *bad = bad_file(files, count);
    if (!bad) bad = norma_document_bad_compute_option(&run.compute);
    if (!bad) bad = bad_choice(&run.compute);
    if (!bad) bad = bad_crease(&run);
    if (bad) return fail_option(error, bad);
    for (size_t i = 0; run.options.lock_matches && i < run.options.lock_count; ++i)
        run.options.lock_matches[i] = 0;
    if (!count) return NORMA_DOCUMENT_OK;
    if (!run.options.max_memory) run.options.max_memory = JOINING_MEMORY;
    if (run.compute.shading == NORMA_SHADING_DEFAULT) run.compute.shading = NORMA_SHADING_SMOOTH;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (run.options.votes) result = begin_seams_run(&run);
    run.equal.rounded |= norma_together_rounds(files, count);
    const int creased = run.compute.shading == NORMA_SHADING_CREASE;
    run.passes = run.compute.weld == NORMA_WELD_DISTANCE && !creased ? 3 : 2;
    run.folder = run.options.temporary_folder;
    if (!run.folder) run.folder = run.own_folder = norma_together_folder_of(files[0].output);
    if (!result) result = run.folder ? join_all(&run) : norma_document_fail_memory(NULL, error);
    end_run(&run);
    return result;
}
