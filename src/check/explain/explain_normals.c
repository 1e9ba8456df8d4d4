/* explain_normals.c: which weight and crease explain the normals that a surface has: those whose
 * normals lie nearest to the stored ones, by mean angle. Creases are tried with angle weights, then
 * weights with the best crease, then creases again; creases between which no edge's angle lies are
 * one. */
#include "core/face/triangle.h"
#include "check/explain/explain_normals.h"
#include <math.h>
#include <string.h>

static double radians(double degrees) { return degrees * (NORMA_PI / 180); }

/* ---- one trial */

norma_result norma_explain_open(
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
    norma_explain_close(call, s);
    return NORMA_ERROR_MEMORY;
}

void norma_explain_close(const core_call *call, explain_surface *s) {
    norma_core_release(call, s->stored, s->stored_count, 3 * sizeof *s->stored);
    norma_core_release(call, s->computed, s->room, 3 * sizeof *s->computed);
    norma_core_release(call, s->angles, s->checked.corner_count, sizeof *s->angles);
    *s = (explain_surface){.room = 0};
}

/* Right for small angles, whatever the lengths. Negative: one of them is no direction. */
static float angle_between(const float *a, const float *b) {
    const double u[3] = {(double)a[0], (double)a[1], (double)a[2]},
                 v[3] = {(double)b[0], (double)b[1], (double)b[2]};
    double cross[3];
    const double dot = norma_core_dot(u, v);
    if (a[0] == b[0] && a[1] == b[1] && a[2] == b[2]) /* the case of normals that Norma computed */
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

static void measure_vertices(void *context, size_t block) {
    const trial_pass *pass = context;
    const explain_surface *s = pass->surface;
    size_t count = s->checked.positions.count, begin = block * VERTICES_IN_BLOCK,
           end = count - begin < VERTICES_IN_BLOCK ? count : begin + VERTICES_IN_BLOCK;
    for (size_t v = begin; v < end; v++)
        pass->of_vertices[v] = angle_between(s->stored + 3 * v, s->computed + 3 * v);
}

static void measure_faces(void *context, size_t block) {
    const trial_pass *pass = context;
    explain_surface *s = pass->surface;
    size_t count = s->checked.face_count, begin = block * FACES_IN_BLOCK,
           end = count - begin < FACES_IN_BLOCK ? count : begin + FACES_IN_BLOCK;
    for (size_t f = begin; f < end; f++)
        for (size_t c = norma_core_face_begin(&s->checked, f);
             c < norma_core_face_end(&s->checked, f); c++)
            s->angles[c] =
                angle_between(s->stored + 3 * norma_explain_stored_of(s, c), s->computed + 3 * f);
}

/* Of a trial that is not flat. */
static void measure_corners(void *context, size_t block) {
    const trial_pass *pass = context;
    explain_surface *s = pass->surface;
    size_t count = s->checked.corner_count, begin = block * CORNERS_IN_BLOCK,
           end = count - begin < CORNERS_IN_BLOCK ? count : begin + CORNERS_IN_BLOCK;
    for (size_t c = begin; c < end; c++)
        s->angles[c] =
            pass->of_vertices
                ? pass->of_vertices[norma_core_corner(&s->checked, c)]
                : angle_between(s->stored + 3 * norma_explain_stored_of(s, c),
                      s->computed + 3 * norma_explain_computed_of(s, pass->trial, SIZE_MAX, c));
}

static norma_result measure(core_call *call, explain_surface *s, const explain_trial *trial) {
    size_t vertices = s->checked.positions.count;
    trial_pass pass = {s, trial, NULL};
    norma_result result = NORMA_OK;
    if (s->per_vertex && !trial->flat && isnan(trial->crease_rad)) {
        pass.of_vertices = norma_core_allocate(call, vertices, sizeof *pass.of_vertices);
        result = pass.of_vertices ? norma_core_parallel(call,
                                        norma_check_block_count(vertices, VERTICES_IN_BLOCK),
                                        measure_vertices, &pass)
                                  : NORMA_ERROR_MEMORY;
    }
    if (!result && trial->flat)
        result = norma_core_parallel(call,
            norma_check_block_count(s->checked.face_count, FACES_IN_BLOCK), measure_faces, &pass);
    else if (!result)
        result = norma_core_parallel(call,
            norma_check_block_count(s->checked.corner_count, CORNERS_IN_BLOCK), measure_corners,
            &pass);
    norma_core_release(call, pass.of_vertices, vertices, sizeof *pass.of_vertices);
    return result;
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
    return result ? result : measure(call, s, trial);
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
    for (size_t c = 0; !result && c < s->checked.corner_count; c++) {
        if (s->angles[c] < 0) continue;
        sum += (double)s->angles[c];
        count++;
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
    for (size_t i = 0; i < CREASES && !result && !is_perfect(search); i++) {
        size_t below = search->below[(size_t)creases_deg[i]], known = 0;
        while (known < count && tried[known] != below) known++;
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

static norma_result find_best(explain_search *search) {
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
    for (size_t i = degrees > 0 ? (size_t)ceil(degrees) : 0; i < DIHEDRALS; i++) below[i]++;
}

static norma_result count_dihedrals(
    core_call *call, const explain_surface *surface, size_t below[DIHEDRALS]) {
    core_topology t;
    norma_result result = norma_core_topology_open(call, &surface->checked, &t);
    if (result) return result;
    result = norma_core_pair_edges(&t, NULL);
    for (size_t c = 0; !result && c < t.mesh.corner_count; c++) {
        core_face a, b;
        if (t.partners[c] >= CORE_EDGE_SPECIAL || t.partners[c] < c) continue;
        norma_core_face_geometry(&t.mesh, norma_core_topology_face(&t, c), &a);
        norma_core_face_geometry(&t.mesh, norma_core_topology_face(&t, t.partners[c]), &b);
        count_dihedral(below, &a, &b);
    }
    norma_core_topology_close(&t);
    return result;
}

static norma_result search_surface(core_call *call, explain_surface *surface, void *best) {
    explain_search search = {.call = call, .surface = surface};
    norma_result result = count_dihedrals(call, surface, search.below);
    if (!result) result = find_best(&search);
    *(explain_trial *)best = search.best;
    return result;
}

/* ---- every trial */

norma_result norma_explain_each_trial(
    core_call *call, explain_surface *surface, explain_try *visit, void *context, const int *done) {
    size_t below[DIHEDRALS] = {0}, tried[CREASES];
    norma_result result = count_dihedrals(call, surface, below);
    if (!result) result = visit(&(explain_trial){.flat = 1, .crease_rad = NAN}, context);
    for (int weight = 0; norma_weight_name((norma_weight)weight) && !result && !*done; weight++) {
        explain_trial trial = {.weight = (norma_weight)weight, .crease_rad = NAN};
        size_t count = 0;
        result = visit(&trial, context);
        for (size_t i = 0; i < CREASES && !result && !*done; i++) {
            size_t known = 0;
            tried[count] = below[(size_t)creases_deg[i]];
            while (tried[known] != tried[count]) known++;
            if (known < count) continue;
            count++;
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

static void read_normal(const norma_mesh_data *data, size_t number, float *stored) {
    double normal[3] = {0};
    if (number < data->normals.count) norma_view_read(&data->normals, number, normal);
    for (int k = 0; k < 3; k++) stored[k] = (float)normal[k];
}

static size_t number_of(const norma_mesh_data *data, const core_mesh *mesh, size_t corner) {
    return data->corner_normals ? data->corner_normals[corner] : norma_core_corner(mesh, corner);
}

static void read_block(void *context, size_t block) {
    const stored_pass *pass = context;
    const explain_surface *s = pass->surface;
    size_t count = s->stored_count, begin = block * CORNERS_IN_BLOCK,
           end = count - begin < CORNERS_IN_BLOCK ? count : begin + CORNERS_IN_BLOCK;
    for (size_t i = begin; i < end; i++)
        read_normal(pass->data, s->per_vertex ? i : number_of(pass->data, &s->checked, i),
            s->stored + 3 * i);
}

static norma_result visit_sample(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, explain_visit *visit, void *context) {
    explain_sample sample;
    explain_surface surface;
    norma_result result = norma_explain_take_sample(call, topology, &sample);
    if (result) return result;
    result = norma_explain_open(call, &sample.mesh, 0, &surface);
    surface.welded = 1;
    if (!result) {
        for (size_t c = 0; c < sample.mesh.corner_count; c++)
            if (sample.whole[c])
                read_normal(
                    data, number_of(data, checked, sample.sources[c]), surface.stored + 3 * c);
        result = visit(call, &surface, context);
        norma_explain_close(call, &surface);
    }
    norma_explain_free_sample(call, &sample);
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
    norma_result result = norma_explain_open(call, &data->mesh, !data->corner_normals, surface);
    if (result) return result;
    stored_pass pass = {data, surface};
    result = norma_core_parallel(
        call, norma_check_block_count(surface->stored_count, CORNERS_IN_BLOCK), read_block, &pass);
    if (result) norma_explain_close(call, surface);
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
    norma_explain_close(call, &surface);
    return result;
}

norma_result norma_explain_with(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, norma_deviation *deviation) {
    explain_surface surface;
    explain_trial best;
    norma_result result = open_whole(call, data, &surface);
    if (result) return result;
    result = checked->face_count > EXPLAIN_FACES
                 ? visit_large(call, data, checked, topology, search_surface, &best)
                 : search_surface(call, &surface, &best);
    if (!result) result = norma_explain_measure(call, &surface, &best);
    if (!result) result = norma_explain_summarise(call, &surface, deviation);
    norma_explain_close(call, &surface);
    if (!result && deviation->corners) {
        deviation->weight = best.weight;
        deviation->shading = best.flat                ? NORMA_SHADING_FLAT
                             : isnan(best.crease_rad) ? NORMA_SHADING_SMOOTH
                                                      : NORMA_SHADING_CREASE;
        deviation->crease_angle_rad = best.crease_rad;
    }
    return result;
}

norma_result norma_explain_normals(const norma_mesh_data *data, norma_normal_storage storage,
    const norma_options *options, norma_deviation *deviation) {
    core_call call;
    core_mesh mesh;
    if (!data || !deviation) return NORMA_ERROR_ARGUMENT;
    *deviation = (norma_deviation){.crease_angle_rad = NAN};
    norma_result result = norma_core_begin(&call, options);
    if (!result) result = norma_core_mesh_shape(&data->mesh, &mesh);
    if (!result) result = norma_core_mesh_content(&call, &mesh);
    mesh.scale = 1;
    if (result || storage == NORMA_NORMALS_NONE || storage == NORMA_NORMALS_PER_FACET ||
        !mesh.corner_count || !data->normals.count)
        return result;
    return norma_explain_with(&call, data, &mesh, NULL, deviation);
}
