/* creases.c: all faces of all files become one mesh, in an order that follows from where they lie:
 * positions by their coordinates, faces by their positions, each from its least position on. What
 * the core computes of that mesh does not depend on the files, their order, or how the surface was
 * cut. */
#include "io/together/together.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

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

void norma_creases_free(creases *c) {
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

typedef struct gathering {
    together_run *run;
    member *m;
} gathering;

static norma_document_result take_creased_surface(void *user, const document_surface *surface) {
    const gathering *g = user;
    creases *c = g->run->creases;
    const norma_mesh *mesh = surface->mesh;
    const size_t faces = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
    placement *places;
    size_t count;
    norma_document_result result =
        norma_member_places(g->m, surface, &places, &count, g->run->error);
    for (size_t i = 0; i < count && !result; ++i) {
        if (places[i].level)
            result = norma_document_fail(g->m->document, g->run->error,
                NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
                "a level of detail takes the normals of a finer one, which creases do not allow; "
                "compute it without a crease, or the levels one by one");
        if (!result && !make_crease_room(c, mesh, faces)) result = fail_creases(g->run);
        if (result) break;
        take_soup_faces(c, mesh, faces, &places[i], i ? UINT32_MAX : g->run->number);
        for (size_t v = 0; v < mesh->positions.count; ++v)
            norma_together_position(surface, &places[i], v, c->positions[c->position_count++]);
    }
    free(places);
    return result;
}

norma_document_result norma_creases_take(together_run *run, member *m) {
    gathering g = {run, m};
    if (!run->creases) run->creases = calloc(1, sizeof *run->creases);
    return run->creases ? norma_member_visit(m, take_creased_surface, &g, run->error)
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

norma_document_result norma_creases_compute(together_run *run) {
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

static int make_creased_normals(surface_normals *made, size_t count) {
    made->count = count;
    made->normals = norma_io_block(count, 3 * sizeof *made->normals);
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

norma_document_result norma_creases_surface(
    together_run *run, member *m, const document_surface *surface, surface_normals *made) {
    const size_t corners = surface->mesh->corner_count;
    surface_normals other = {0};
    placement *places;
    size_t count;
    norma_document_result result = norma_member_places(m, surface, &places, &count, run->error);
    if (!result && !make_creased_normals(made, corners)) result = fail_creases(run);
    if (!result && count > 1 && !make_creased_normals(&other, corners)) result = fail_creases(run);
    if (!result && !count) result = compute_alone_creased(run, surface, made);
    for (size_t i = 0; i < count && !result; ++i) {
        take_place(run->creases, &places[i], i ? &other : made);
        for (size_t c = 0; i && c < corners && !result; ++c)
            if (norma_together_differ(other.normals + 3 * c, made->normals + 3 * c))
                result = norma_together_fail_places(run, m, surface, count);
    }
    free(other.normals);
    free(other.reasons);
    free(places);
    return result;
}
