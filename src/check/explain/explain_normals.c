/* explain_normals.c: which weight and crease explain stored normals best, and how far they are off.
 */
#include "check/explain/explain.h"
#include "core/face/face.h"
#include <math.h>
#include <string.h>

/* ---- Mean, percentiles and histogram of the angles between stored and computed
 * normals. */

/* Bits of angles, read as integers, have their order; what was not measured is negative, and comes
 * last. */

enum { SUMMARY_CORNERS = 1 << 16, MOST_BITS = 11 };

static const double bounds_deg[NORMA_DEVIATION_BINS] = {
    .01, .02, .05, .1, .2, .5, 1, 2, 5, 10, 15, 20, 30, 45, 60, 90, 120, 180};

double norma_deviation_bound_rad(size_t bin) {
    return bounds_deg[bin < NORMA_DEVIATION_BINS ? bin : NORMA_DEVIATION_BINS - 1] *
           (NORMA_PI / 180);
}

typedef struct angle_part {
    double sum, max;
    size_t worst, count, histogram[NORMA_DEVIATION_BINS];
} angle_part;

typedef struct angle_pass {
    const explain_surface *surface;
    double bounds[NORMA_DEVIATION_BINS];
    angle_part *parts;
} angle_pass;

static size_t bin_of(const angle_pass *pass, double angle) {
    size_t bin = 0;
    while (bin + 1 < NORMA_DEVIATION_BINS && angle >= pass->bounds[bin]) ++bin;
    return bin;
}

static void sum_block(void *context, size_t block, size_t begin, size_t end) {
    const angle_pass *pass = context;
    angle_part *part = &pass->parts[block];
    for (size_t c = begin; c < end; ++c) {
        const double angle = (double)pass->surface->angles[c];
        if (angle < 0) continue;
        part->sum += angle;
        if (angle > part->max) {
            part->max = angle;
            part->worst = c;
        }
        ++part->count;
        ++part->histogram[bin_of(pass, angle)];
    }
}

/* The bits from shift up to top of the angle of a rank, and the rank among those with the same. */
static uint32_t find_digit(
    const explain_surface *s, int shift, int top, uint32_t known, size_t *rank) {
    uint32_t counts[1 << MOST_BITS] = {0}, digit = 0;
    for (size_t c = 0; c < s->checked.corner_count; ++c) {
        uint32_t bits;
        memcpy(&bits, &s->angles[c], sizeof bits);
        if ((uint64_t)(bits ^ known) >> top == 0) ++counts[(bits ^ known) >> shift];
    }
    while (*rank >= counts[digit]) *rank -= counts[digit++];
    return digit;
}

static double find_angle_of_rank(const explain_surface *s, size_t rank) {
    uint32_t bits = 0;
    float angle;
    for (int top = 32, shift; top > 0; top = shift) {
        shift = top > MOST_BITS ? top - MOST_BITS : 0;
        bits |= find_digit(s, shift, top, bits, &rank) << shift;
    }
    memcpy(&angle, &bits, sizeof angle);
    return (double)angle;
}

static void add_angle_part(norma_deviation *d, const angle_part *part, size_t *worst) {
    d->mean_rad += part->sum;
    if (part->max > d->max_rad) {
        d->max_rad = part->max;
        *worst = part->worst;
    }
    d->corners += part->count;
    for (size_t i = 0; i < NORMA_DEVIATION_BINS; ++i) d->histogram[i] += part->histogram[i];
}

norma_result norma_explain_summarise(
    core_call *call, const explain_surface *surface, norma_deviation *d, size_t *worst) {
    const size_t corners = surface->checked.corner_count,
                 blocks = norma_check_block_count(corners, SUMMARY_CORNERS);
    angle_pass pass = {
        .surface = surface, .parts = norma_core_allocate(call, blocks, sizeof *pass.parts)};
    norma_result result = pass.parts ? NORMA_OK : NORMA_ERROR_MEMORY;
    *d = (norma_deviation){.crease_angle_rad = NAN};
    *worst = SIZE_MAX;
    if (!result) {
        for (size_t i = 0; i < NORMA_DEVIATION_BINS; ++i)
            pass.bounds[i] = norma_deviation_bound_rad(i);
        memset(pass.parts, 0, blocks * sizeof *pass.parts);
        result = norma_check_blocks(call, corners, SUMMARY_CORNERS, sum_block, &pass);
        for (size_t i = 0; i < blocks; ++i) add_angle_part(d, &pass.parts[i], worst);
    }
    if (!result && d->max_rad > 0) {
        d->mean_rad /= (double)d->corners;
        d->p50_rad = find_angle_of_rank(surface, (d->corners - 1) / 2);
        d->p99_rad = find_angle_of_rank(surface, (size_t)(0.99 * (double)(d->corners - 1)));
    }
    norma_core_release(call, pass.parts, blocks, sizeof *pass.parts);
    return result;
}

/* ---- A part of a mesh small enough to try many ways of computing normals on, with
 * whole rings around the positions that are looked at. */

/* A part of a mesh with many faces, chosen by numbers alone: the faces around
 * some of its positions. Everything is owned by it. */
typedef struct explain_sample {
    norma_mesh mesh;
    double (*positions)[3];
    uint32_t *corners, *starts, *groups;
    uint8_t *hard_edges;
    uint32_t *sources; /* of each corner the corner of the whole mesh; UINT32_MAX: some faces at its
                          position are not there */
    size_t position_count, corner_count, face_count;
} explain_sample;
enum { EXPLAIN_FACES = 4096 }; /* a mesh of no more is its own sample */

enum { MOST_AT_POSITION = 128 };

typedef struct choice {
    const core_topology *topology;
    uint64_t one_in;
} choice;

static uint64_t mix_bits(uint64_t h) {
    h = (h ^ (h >> 32)) * UINT64_C(0x9e3779b97f4a7c15);
    h = (h ^ (h >> 29)) * UINT64_C(0xbf58476d1ce4e5b9);
    return h ^ (h >> 32);
}

static int is_chosen(const choice *c, uint32_t position) {
    const core_corners_of_position *around = &c->topology->corners_of;
    size_t count = around->starts[position + 1] - around->starts[position];
    return count > 0 && count <= MOST_AT_POSITION && mix_bits(position) % c->one_in == 0;
}

/* The places of the ones, ascending. */
static void list_marked(const uint8_t *marks, size_t count, uint32_t *places) {
    for (const uint8_t *at = marks; (at = memchr(at, 1, count - (size_t)(at - marks))); ++at)
        *places++ = (uint32_t)(at - marks);
}

static size_t mark_place(uint8_t *marks, size_t place) {
    const int is_new = !marks[place];
    marks[place] = 1;
    return (size_t)is_new;
}

/* The faces around all chosen positions; how many. */
static size_t mark_faces(const choice *c, uint8_t *marks) {
    const core_topology *t = c->topology;
    size_t count = 0;
    memset(marks, 0, t->mesh.face_count);
    for (uint32_t p = 0; p < t->corners_of.position_count; ++p) {
        if (!is_chosen(c, p)) continue;
        for (uint32_t i = t->corners_of.starts[p]; i < t->corners_of.starts[p + 1]; ++i)
            count += mark_place(marks, norma_core_topology_face(t, t->corners_of.corners[i]));
    }
    return count;
}

static int allocate(const core_call *call, const core_mesh *mesh, explain_sample *s) {
    s->positions = norma_core_allocate(call, s->corner_count, sizeof *s->positions);
    s->corners = norma_core_allocate(call, s->corner_count, sizeof *s->corners);
    s->sources = norma_core_allocate(call, s->corner_count, sizeof *s->sources);
    s->starts = norma_core_allocate(call, s->face_count + 1, sizeof *s->starts);
    s->groups =
        mesh->smoothing_groups ? norma_core_allocate(call, s->face_count, sizeof *s->groups) : NULL;
    s->hard_edges = mesh->hard_edges ? norma_core_allocate(call, s->corner_count, 1) : NULL;
    return s->positions && s->corners && s->sources && s->starts &&
           (s->groups || !mesh->smoothing_groups) && (s->hard_edges || !mesh->hard_edges);
}

/* places: the positions that the faces use, ascending. */
static void copy_faces(
    const choice *c, const uint32_t *faces, const uint32_t *places, explain_sample *s) {
    const core_topology *t = c->topology;
    size_t at = 0;
    for (size_t i = 0; i < s->face_count; ++i) {
        s->starts[i] = (uint32_t)at;
        if (s->groups) s->groups[i] = t->mesh.smoothing_groups[faces[i]];
        for (size_t corner = norma_core_face_begin(&t->mesh, faces[i]);
             corner < norma_core_face_end(&t->mesh, faces[i]); ++corner, ++at) {
            s->corners[at] =
                (uint32_t)norma_check_last_at(places, s->position_count, t->corners[corner]);
            s->sources[at] = is_chosen(c, t->corners[corner]) ? (uint32_t)corner : UINT32_MAX;
            if (s->hard_edges) s->hard_edges[at] = t->mesh.hard_edges[corner];
        }
    }
    s->starts[s->face_count] = (uint32_t)at;
    for (size_t i = 0; i < s->position_count; ++i)
        norma_core_position(&t->mesh, places[i], s->positions[i]);
    s->mesh = (norma_mesh){.positions = {s->positions, s->position_count, 0, NORMA_FORMAT_DOUBLE},
        .corners = s->corners,
        .corner_count = at,
        .face_starts = t->mesh.face_starts ? s->starts : NULL,
        .face_count = s->face_count,
        .smoothing_groups = s->groups,
        .hard_edges = s->hard_edges};
}

/* The positions that the faces use; how many. */
static size_t mark_places(
    const choice *c, const uint32_t *faces, const explain_sample *s, uint8_t *marks) {
    const core_mesh *mesh = &c->topology->mesh;
    size_t count = 0;
    memset(marks, 0, mesh->positions.count);
    for (size_t i = 0; i < s->face_count; ++i)
        for (size_t corner = norma_core_face_begin(mesh, faces[i]);
             corner < norma_core_face_end(mesh, faces[i]); ++corner)
            count += mark_place(marks, c->topology->corners[corner]);
    return count;
}

static void explain_free_sample(const core_call *call, explain_sample *s) {
    norma_core_release(call, s->positions, s->corner_count, sizeof *s->positions);
    norma_core_release(call, s->corners, s->corner_count, sizeof *s->corners);
    norma_core_release(call, s->sources, s->corner_count, sizeof *s->sources);
    norma_core_release(call, s->starts, s->face_count + 1, sizeof *s->starts);
    norma_core_release(call, s->groups, s->face_count, sizeof *s->groups);
    norma_core_release(call, s->hard_edges, s->corner_count, 1);
    *s = (explain_sample){.face_count = 0};
}

static norma_result copy_sample(
    core_call *call, const choice *c, const uint32_t *faces, explain_sample *s) {
    const core_mesh *mesh = &c->topology->mesh;
    const size_t positions = mesh->positions.count;
    for (size_t i = 0; i < s->face_count; ++i)
        s->corner_count +=
            norma_core_face_end(mesh, faces[i]) - norma_core_face_begin(mesh, faces[i]);
    uint32_t *places = norma_core_allocate(call, s->corner_count, sizeof *places);
    uint8_t *marks = norma_core_allocate(call, positions, 1);
    norma_result result =
        allocate(call, mesh, s) && places && marks ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        s->position_count = mark_places(c, faces, s, marks);
        list_marked(marks, positions, places);
        copy_faces(c, faces, places, s);
    }
    norma_core_release(call, marks, positions, 1);
    norma_core_release(call, places, s->corner_count, sizeof *places);
    if (result) explain_free_sample(call, s);
    return result;
}

static norma_result explain_take_sample(
    core_call *call, const core_topology *topology, explain_sample *sample) {
    const choice c = {topology, topology->mesh.corner_count / EXPLAIN_FACES + 1};
    const size_t all = topology->mesh.face_count;
    *sample = (explain_sample){.face_count = 0};
    uint8_t *marks = norma_core_allocate(call, all, 1);
    if (!marks) return NORMA_ERROR_MEMORY;
    const size_t count = mark_faces(&c, marks);
    uint32_t *faces = norma_core_allocate(call, count, sizeof *faces);
    if (faces) list_marked(marks, all, faces);
    norma_core_release(call, marks, all, 1);
    if (!faces) return NORMA_ERROR_MEMORY;
    sample->face_count = count;
    const norma_result result = copy_sample(call, &c, faces, sample);
    norma_core_release(call, faces, count, sizeof *faces);
    return result;
}

/* ---- Which weight and crease explain the normals that a surface has: those whose
 * normals lie nearest to the stored ones, by mean angle. Creases are tried with angle weights, then
 * weights with the best crease, then creases again; creases between which no edge's angle lies are
 * one. */

static double radians(double degrees) { return degrees * (NORMA_PI / 180); }

static void explain_close(const core_call *call, explain_surface *s) {
    norma_core_release(call, s->stored, s->stored_count, 3 * sizeof *s->stored);
    norma_core_release(call, s->computed, s->room, 3 * sizeof *s->computed);
    norma_core_release(call, s->angles, s->checked.corner_count, sizeof *s->angles);
    *s = (explain_surface){.room = 0};
}

/* ---- one trial */

static norma_result explain_open(
    const core_call *call, const norma_mesh *mesh, int per_vertex, explain_surface *s) {
    *s = (explain_surface){.mesh = mesh, .per_vertex = per_vertex};
    norma_result result = norma_core_mesh_shape(mesh, &s->checked);
    if (result) return result;
    size_t corners = s->checked.corner_count;
    s->room = corners > s->checked.positions.count ? corners : s->checked.positions.count;
    s->room = s->room > s->checked.face_count ? s->room : s->checked.face_count;
    s->stored_count = per_vertex ? s->checked.positions.count : corners;
    s->stored = norma_core_allocate(call, s->stored_count, 3 * sizeof *s->stored);
    s->computed = norma_core_allocate(call, s->room, 3 * sizeof *s->computed);
    s->angles = norma_core_allocate(call, corners, sizeof *s->angles);
    if (s->stored && s->computed && s->angles) {
        memset(s->stored, 0, 3 * s->stored_count * sizeof *s->stored);
        return NORMA_OK;
    }
    explain_close(call, s);
    return NORMA_ERROR_MEMORY;
}

float norma_explain_angle(const float *a, const float *b) {
    const double u[3] = {(double)a[0], (double)a[1], (double)a[2]},
                 v[3] = {(double)b[0], (double)b[1], (double)b[2]};
    double cross[3];
    const double dot = norma_core_dot(u, v);
    if (a[0] == b[0] && a[1] == b[1] && a[2] == b[2]) /* the case of what Norma computed */
        return dot > 0 && dot < INFINITY ? 0 : -1;
    norma_core_cross(u, v, cross);
    const double across = sqrt(norma_core_dot(cross, cross));
    return (across > 0 || dot != 0) && across < INFINITY ? (float)norma_core_angle(across, dot)
                                                         : -1;
}

enum { CORNERS_IN_BLOCK = 3 << 13, FACES_IN_BLOCK = 1 << 13, VERTICES_IN_BLOCK = 1 << 13 };

typedef struct trial_pass {
    explain_surface *surface;
    const explain_trial *trial;
    float *of_vertices; /* NULL, or the angle at each vertex, whose corners all have it */
} trial_pass;

static void measure_vertices(void *context, size_t block, size_t begin, size_t end) {
    const trial_pass *pass = context;
    const explain_surface *s = pass->surface;
    (void)block;
    for (size_t v = begin; v < end; ++v)
        pass->of_vertices[v] = norma_explain_angle(s->stored + 3 * v, s->computed + 3 * v);
}

static void measure_face_angles(void *context, size_t block, size_t begin, size_t end) {
    const trial_pass *pass = context;
    explain_surface *s = pass->surface;
    (void)block;
    for (size_t f = begin; f < end; ++f)
        for (size_t c = norma_core_face_begin(&s->checked, f);
             c < norma_core_face_end(&s->checked, f); ++c)
            s->angles[c] = norma_explain_angle(
                s->stored + 3 * norma_explain_stored_of(s, c), s->computed + 3 * f);
}

/* Of a trial that is not flat. */
static void measure_corners(void *context, size_t block, size_t begin, size_t end) {
    const trial_pass *pass = context;
    explain_surface *s = pass->surface;
    (void)block;
    for (size_t c = begin; c < end; ++c)
        s->angles[c] =
            pass->of_vertices
                ? pass->of_vertices[norma_core_corner(&s->checked, c)]
                : norma_explain_angle(s->stored + 3 * norma_explain_stored_of(s, c),
                      s->computed + 3 * norma_explain_computed_of(s, pass->trial, SIZE_MAX, c));
}

static norma_result measure_trial(core_call *call, explain_surface *s, const explain_trial *trial) {
    size_t vertices = s->checked.positions.count;
    trial_pass pass = {s, trial, NULL};
    norma_result result = NORMA_OK;
    if (s->per_vertex && !trial->flat && isnan(trial->crease_rad)) {
        pass.of_vertices = norma_core_allocate(call, vertices, sizeof *pass.of_vertices);
        result = pass.of_vertices ? norma_check_blocks(
                                        call, vertices, VERTICES_IN_BLOCK, measure_vertices, &pass)
                                  : NORMA_ERROR_MEMORY;
    }
    if (!result && trial->flat)
        result = norma_check_blocks(
            call, s->checked.face_count, FACES_IN_BLOCK, measure_face_angles, &pass);
    else if (!result)
        result = norma_check_blocks(
            call, s->checked.corner_count, CORNERS_IN_BLOCK, measure_corners, &pass);
    norma_core_release(call, pass.of_vertices, vertices, sizeof *pass.of_vertices);
    return result;
}

void norma_explain_tell(const explain_trial *trial, norma_deviation *deviation) {
    deviation->weight = trial->weight;
    deviation->shading = trial->flat                ? NORMA_SHADING_FLAT
                         : isnan(trial->crease_rad) ? NORMA_SHADING_SMOOTH
                                                    : NORMA_SHADING_CREASE;
    deviation->crease_angle_rad = trial->crease_rad;
}

norma_result norma_explain_measure(
    core_call *call, explain_surface *s, const explain_trial *trial) {
    norma_options options = {.struct_size = sizeof options,
        .weight = trial->weight,
        .weld = s->welded ? NORMA_WELD_NONE : NORMA_WELD_EXACT,
        .threads = call->options.threads,
        .allocator = call->options.allocator};
    norma_result result;
    if (trial->flat)
        result = norma_face_normals(s->mesh, &options, s->computed, s->room, NULL);
    else if (isnan(trial->crease_rad))
        result = norma_vertex_normals(s->mesh, &options, s->computed, s->room, NULL);
    else
        result = norma_corner_normals(
            s->mesh, (float)trial->crease_rad, &options, s->computed, s->room, NULL);
    return result ? result : measure_trial(call, s, trial);
}

/* ---- the search */

static const double creases_deg[] = {60, 30, 15, 20, 35, 40, 45, 50, 70, 80, 90, 120,
    180}; /* the likeliest first: of several that explain as well, the first is named */
enum { CREASES = sizeof creases_deg / sizeof *creases_deg, DIHEDRALS = 181 };

typedef struct explain_search {
    core_call *call;
    explain_surface *surface;
    explain_trial best;
    double best_mean;
    size_t below[DIHEDRALS]; /* of each whole degree: how many shared edges bend by no more (and a
                                little) */
} explain_search;

static norma_result mean_angle(explain_search *search, const explain_trial *trial, double *mean) {
    norma_result result = norma_explain_measure(search->call, search->surface, trial);
    const explain_surface *s = search->surface;
    double sum = 0;
    size_t count = 0;
    for (size_t c = 0; !result && c < s->checked.corner_count; ++c) {
        if (s->angles[c] < 0) continue;
        sum += (double)s->angles[c];
        ++count;
    }
    *mean = count ? sum / (double)count : INFINITY;
    return result;
}

/* A later candidate must be better by more than what the encoding's noise could do: the simplest of
 * equals stays. */
static norma_result try_one(explain_search *search, explain_trial candidate) {
    double mean;
    norma_result result = mean_angle(search, &candidate, &mean);
    if (!result && mean < search->best_mean - 1e-6) {
        search->best_mean = mean;
        search->best = candidate;
    }
    return result;
}

/* Floats tell no more. */
static int is_perfect(const explain_search *search) { return search->best_mean < 2e-7; }

static norma_result try_creases(explain_search *search) {
    norma_weight weight = search->best.weight;
    size_t tried[CREASES], count = 0;
    norma_result result = try_one(search, (explain_trial){.weight = weight, .crease_rad = NAN});
    for (size_t i = 0; i < CREASES && !result && !is_perfect(search); ++i) {
        size_t below = search->below[(size_t)creases_deg[i]], known = 0;
        while (known < count && tried[known] != below) ++known;
        if (known < count) continue;
        tried[count++] = below;
        result = try_one(
            search, (explain_trial){.weight = weight, .crease_rad = radians(creases_deg[i])});
        if (i == 0 && !result && !is_perfect(search))
            result =
                try_one(search, (explain_trial){.weight = weight, .flat = 1, .crease_rad = NAN});
    }
    return result;
}

static norma_result find_best_trial(explain_search *search) {
    search->best = (explain_trial){.crease_rad = NAN};
    search->best_mean = INFINITY;
    norma_result result = try_creases(search);
    for (int weight = NORMA_WEIGHT_AREA; norma_weight_name((norma_weight)weight) && !result &&
                                         !search->best.flat && !is_perfect(search);
         ++weight)
        result = try_one(search,
            (explain_trial){.weight = (norma_weight)weight, .crease_rad = search->best.crease_rad});
    if (!result && search->best.weight != NORMA_WEIGHT_ANGLE && !is_perfect(search))
        result = try_creases(search);
    return result;
}

/* ---- the angles of edges */

static void count_dihedral(size_t *below, const core_face *a, const core_face *b) {
    double cross[3];
    if (!(a->flags & b->flags & CORE_FACE_DIRECTED)) return;
    norma_core_cross(a->normal, b->normal, cross);
    double degrees =
        norma_core_angle(sqrt(norma_core_dot(cross, cross)), norma_core_dot(a->normal, b->normal)) /
            radians(1) -
        1e-4;
    for (size_t i = degrees > 0 ? (size_t)ceil(degrees) : 0; i < DIHEDRALS; ++i) ++below[i];
}

static norma_result count_dihedrals(
    core_call *call, const explain_surface *surface, size_t below[DIHEDRALS]) {
    core_topology t;
    norma_result result = norma_core_topology_open(call, &surface->checked, &t);
    if (result) return result;
    result = norma_core_pair_edges(&t, NULL);
    for (size_t c = 0; !result && c < t.mesh.corner_count; ++c) {
        core_face a, b;
        if (t.partners[c] >= CORE_EDGE_SPECIAL || t.partners[c] < c) continue;
        norma_core_face_geometry(&t.mesh, norma_core_topology_face(&t, c), &a);
        norma_core_face_geometry(&t.mesh, norma_core_topology_face(&t, t.partners[c]), &b);
        count_dihedral(below, &a, &b);
    }
    norma_core_topology_close(&t);
    return result;
}

static norma_result search_trials(core_call *call, explain_surface *surface, void *best) {
    explain_search search = {.call = call, .surface = surface};
    norma_result result = count_dihedrals(call, surface, search.below);
    if (!result) result = find_best_trial(&search);
    *(explain_trial *)best = search.best;
    return result;
}

/* ---- every trial */

norma_result norma_explain_each_trial(
    core_call *call, explain_surface *surface, explain_try *visit, void *context, const int *done) {
    size_t below[DIHEDRALS] = {0}, tried[CREASES];
    norma_result result = count_dihedrals(call, surface, below);
    if (!result) result = visit(&(explain_trial){.flat = 1, .crease_rad = NAN}, context);
    for (int weight = 0; norma_weight_name((norma_weight)weight) && !result && !*done; ++weight) {
        explain_trial trial = {.weight = (norma_weight)weight, .crease_rad = NAN};
        size_t count = 0;
        result = visit(&trial, context);
        for (size_t i = 0; i < CREASES && !result && !*done; ++i) {
            size_t known = 0;
            tried[count] = below[(size_t)creases_deg[i]];
            while (tried[known] != tried[count]) ++known;
            if (known < count) continue;
            ++count;
            trial.crease_rad = radians(creases_deg[i]);
            result = visit(&trial, context);
        }
    }
    return result;
}

/* ---- a mesh, by a sample of it where it is large */

typedef struct stored_pass {
    const norma_mesh_data *data;
    const explain_surface *surface;
} stored_pass;

static void read_stored_normal(const norma_mesh_data *data, size_t number, float *stored) {
    double normal[3] = {0};
    if (number < data->normals.count) norma_view_read(&data->normals, number, normal);
    for (int k = 0; k < 3; ++k) stored[k] = (float)normal[k];
}

static size_t stored_number_of(const norma_mesh_data *data, const core_mesh *mesh, size_t corner) {
    return data->corner_normals ? data->corner_normals[corner] : norma_core_corner(mesh, corner);
}

static void read_corner_block(void *context, size_t block, size_t begin, size_t end) {
    const stored_pass *pass = context;
    const explain_surface *s = pass->surface;
    (void)block;
    for (size_t i = begin; i < end; ++i)
        read_stored_normal(pass->data,
            s->per_vertex ? i : stored_number_of(pass->data, &s->checked, i), s->stored + 3 * i);
}

static norma_result visit_sample(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, explain_visit *visit, void *context) {
    explain_sample sample;
    explain_surface surface;
    norma_result result = explain_take_sample(call, topology, &sample);
    if (result) return result;
    result = explain_open(call, &sample.mesh, 0, &surface);
    surface.welded = 1;
    if (!result) {
        for (size_t c = 0; c < sample.mesh.corner_count; ++c)
            if (sample.sources[c] != UINT32_MAX)
                read_stored_normal(data, stored_number_of(data, checked, sample.sources[c]),
                    surface.stored + 3 * c);
        result = visit(call, &surface, context);
        explain_close(call, &surface);
    }
    explain_free_sample(call, &sample);
    return result;
}

static norma_result visit_large(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, explain_visit *visit, void *context) {
    core_topology own;
    if (topology) return visit_sample(call, data, checked, topology, visit, context);
    norma_result result = norma_core_topology_open(call, checked, &own);
    if (result) return result;
    result = norma_core_corners_of_position_build(call, &own.mesh, &own.corners_of);
    if (!result) result = visit_sample(call, data, checked, &own, visit, context);
    norma_core_topology_close(&own);
    return result;
}

/* The surface with its normals; closed in any case where they cannot be read. */
static norma_result open_whole(
    core_call *call, const norma_mesh_data *data, explain_surface *surface) {
    norma_result result = explain_open(call, &data->mesh, !data->corner_normals, surface);
    if (result) return result;
    stored_pass pass = {data, surface};
    result =
        norma_check_blocks(call, surface->stored_count, CORNERS_IN_BLOCK, read_corner_block, &pass);
    if (result) explain_close(call, surface);
    return result;
}

norma_result norma_explain_on_sample(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, explain_visit *visit, void *context) {
    explain_surface surface;
    if (checked->face_count > EXPLAIN_FACES)
        return visit_large(call, data, checked, topology, visit, context);
    norma_result result = open_whole(call, data, &surface);
    if (result) return result;
    result = visit(call, &surface, context);
    explain_close(call, &surface);
    return result;
}

typedef struct near_question {
    const norma_deviation *likely;
    int is_near;
} near_question;

/* The best has the least mean of all, so one below 15 degrees bounds it, and then no more than half
 * of its angles can be above 30 (Markov). */
static norma_result look_for_near(core_call *call, explain_surface *surface, void *context) {
    near_question *q = context;
    const norma_deviation *likely = q->likely;
    const explain_trial trials[] = {likely
                                        ? (explain_trial){likely->weight, likely->crease_angle_rad,
                                              likely->shading == NORMA_SHADING_FLAT}
                                        : (explain_trial){.crease_rad = NAN},
        {.crease_rad = radians(60)}};
    const double far = radians(15);
    explain_search search = {.call = call, .surface = surface, .best_mean = INFINITY};
    norma_result result = NORMA_OK;
    for (size_t i = 0; i < sizeof trials / sizeof *trials && !result && !(search.best_mean < far);
         ++i)
        result = try_one(&search, trials[i]);
    q->is_near = search.best_mean < far;
    return result;
}

norma_result norma_explain_is_near(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, const norma_deviation *likely,
    int *is_near) {
    near_question q = {likely, 0};
    const norma_result result =
        norma_explain_on_sample(call, data, checked, topology, look_for_near, &q);
    *is_near = q.is_near;
    return result;
}

norma_result norma_explain_with(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, norma_deviation *deviation,
    size_t *worst) {
    explain_surface surface;
    explain_trial best;
    norma_result result = open_whole(call, data, &surface);
    if (result) return result;
    result = checked->face_count > EXPLAIN_FACES
                 ? visit_large(call, data, checked, topology, search_trials, &best)
                 : search_trials(call, &surface, &best);
    if (!result) result = norma_explain_measure(call, &surface, &best);
    if (!result) result = norma_explain_summarise(call, &surface, deviation, worst);
    explain_close(call, &surface);
    if (!result && deviation->corners) norma_explain_tell(&best, deviation);
    return result;
}

norma_result norma_explain_normals(const norma_mesh_data *data, norma_normal_storage storage,
    const norma_options *options, norma_deviation *deviation) {
    core_call call;
    core_mesh mesh;
    size_t worst;
    if (!data || !deviation) return NORMA_ERROR_ARGUMENT;
    *deviation = (norma_deviation){.crease_angle_rad = NAN};
    norma_result result = norma_core_begin(&call, options);
    if (!result) result = norma_core_mesh_shape(&data->mesh, &mesh);
    if (!result) result = norma_core_mesh_content(&call, &mesh);
    mesh.scale = 1;
    if (result || storage == NORMA_NORMALS_NONE || storage == NORMA_NORMALS_PER_FACET ||
        !mesh.corner_count || !data->normals.count)
        return result;
    return norma_explain_with(&call, data, &mesh, NULL, deviation, &worst);
}
