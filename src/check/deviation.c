/* deviation.c: N204, and which weight and crease explain the normals that a surface has: those whose normals lie nearest to the stored ones, by mean angle. Creases are
 * tried with angle weights, then weights with the best crease, then creases again. */
#include "../core/face_geometry.h"
#include "../core/triangle.h"
#include "check_internal.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct normal_trial {
    norma_weight weight;
    double crease_deg; /* NaN: smooth */
    int flat;
} normal_trial;

typedef struct normal_search {
    const norma_mesh *mesh;
    core_call *call;
    norma_options options;
    const float *stored; /* of each corner; zero: none */
    float *computed;     /* room for a normal of each corner, vertex or face */
    float *angles;       /* radians, of the corners where both are */
    size_t angle_count;
} normal_search;

static double radians(double degrees) { return degrees * (NORMA_PI / 180); }

static size_t face_count_of(const norma_mesh *mesh) { return mesh->face_starts ? mesh->face_count : mesh->corner_count / 3; }

/* Right for small angles, whatever the lengths. Negative: one of them is no direction. */
static double angle_between(const float *a, const float *b) {
    const double u[3] = {(double)a[0], (double)a[1], (double)a[2]}, v[3] = {(double)b[0], (double)b[1], (double)b[2]};
    double cross[3];
    norma_core_cross(u, v, cross);
    if (!norma_core_finite(u) || !norma_core_finite(v) || norma_core_dot(u, u) == 0 || norma_core_dot(v, v) == 0)
        return -1;
    return norma_core_angle(sqrt(norma_core_dot(cross, cross)), norma_core_dot(u, v));
}

static norma_result compute(const normal_search *search, const normal_trial *trial) {
    const norma_mesh *mesh = search->mesh;
    norma_options options = search->options;
    options.weight = trial->weight;
    if (trial->flat)
        return norma_face_normals(mesh, &options, search->computed, face_count_of(mesh), NULL);
    if (isnan(trial->crease_deg))
        return norma_vertex_normals(mesh, &options, search->computed, mesh->positions.count, NULL);
    return norma_corner_normals(mesh, (float)radians(trial->crease_deg), &options, search->computed, mesh->corner_count, NULL);
}

static void measure(normal_search *search, const normal_trial *trial) {
    core_mesh mesh;
    size_t face = 0;
    search->angle_count = 0;
    if (norma_core_mesh_shape(search->mesh, &mesh))
        return;
    for (size_t corner = 0; corner < mesh.corner_count; ++corner) {
        while (norma_core_face_end(&mesh, face) <= corner) ++face;
        size_t number = trial->flat ? face : isnan(trial->crease_deg) ? norma_core_corner(&mesh, corner) : corner;
        double angle = angle_between(search->stored + 3 * corner, search->computed + 3 * number);
        if (angle >= 0)
            search->angles[search->angle_count++] = (float)angle;
    }
}

static norma_result mean_angle(normal_search *search, const normal_trial *trial, double *mean) {
    norma_result result = compute(search, trial);
    double sum = 0;
    if (result)
        return result;
    measure(search, trial);
    for (size_t i = 0; i < search->angle_count; ++i) sum += (double)search->angles[i];
    *mean = search->angle_count ? sum / (double)search->angle_count : INFINITY;
    return norma_core_progress(search->call, 0) ? NORMA_CANCELLED : NORMA_OK;
}

/* A later candidate must be better by more than what the encoding's noise could do: the simplest of equals stays. */
static norma_result try_one(normal_search *search, normal_trial candidate, normal_trial *best, double *best_mean) {
    double mean;
    norma_result result = mean_angle(search, &candidate, &mean);
    if (!result && mean < *best_mean - 1e-6) {
        *best_mean = mean;
        *best = candidate;
    }
    return result;
}

/* The likeliest first: of several that explain as well, the first is named. */
static norma_result try_creases(normal_search *search, normal_trial *best, double *best_mean) {
    static const double creases[] = {30, 15, 20, 35, 40, 45, 50, 70, 80, 90, 120, 180};
    const norma_weight weight = best->weight;
    norma_result result = try_one(search, (normal_trial){.weight = weight, .crease_deg = NAN}, best, best_mean);
    if (!result)
        result = try_one(search, (normal_trial){.weight = weight, .crease_deg = 60}, best, best_mean);
    if (!result)
        result = try_one(search, (normal_trial){.weight = weight, .flat = 1}, best, best_mean);
    for (size_t i = 0; i < sizeof creases / sizeof *creases && !result; ++i)
        result = try_one(search, (normal_trial){.weight = weight, .crease_deg = creases[i]}, best, best_mean);
    return result;
}

static norma_result find_best(normal_search *search, normal_trial *best) {
    double mean = INFINITY;
    *best = (normal_trial){.crease_deg = NAN};
    norma_result result = try_creases(search, best, &mean);
    for (int weight = NORMA_WEIGHT_AREA; weight <= NORMA_WEIGHT_ANGLE_LENGTHS && !result && !best->flat; ++weight)
        result = try_one(search, (normal_trial){.weight = (norma_weight)weight, .crease_deg = best->crease_deg}, best, &mean);
    if (!result && best->weight != NORMA_WEIGHT_ANGLE)
        result = try_creases(search, best, &mean);
    return result ? result : mean_angle(search, best, &mean);
}

/* ---- what is told of the best */

static const double bounds_deg[NORMA_DEVIATION_BINS] = {.01, .02, .05, .1, .2, .5, 1, 2, 5, 10, 15, 20, 30, 45, 60, 90, 120, 180};

double norma_deviation_bound_rad(size_t bin) { return radians(bounds_deg[bin < NORMA_DEVIATION_BINS ? bin : NORMA_DEVIATION_BINS - 1]); }

static size_t bin_of(double angle) {
    size_t bin = 0;
    while (bin + 1 < NORMA_DEVIATION_BINS && angle >= norma_deviation_bound_rad(bin)) ++bin;
    return bin;
}

static int compare_floats(const void *a, const void *b) {
    float of_a = *(const float *)a, of_b = *(const float *)b;
    return (of_a > of_b) - (of_a < of_b);
}

static void describe(normal_search *search, const normal_trial *best, norma_deviation *deviation) {
    size_t count = search->angle_count;
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += (double)search->angles[i];
        deviation->histogram[bin_of((double)search->angles[i])]++;
    }
    qsort(search->angles, count, sizeof *search->angles, compare_floats);
    deviation->weight = best->weight;
    deviation->shading = best->flat ? NORMA_SHADING_FLAT : isnan(best->crease_deg) ? NORMA_SHADING_SMOOTH : NORMA_SHADING_CREASE;
    deviation->crease_angle_rad = best->flat ? NAN : radians(best->crease_deg);
    deviation->corners = count;
    deviation->mean_rad = sum / (double)count;
    deviation->p50_rad = (double)search->angles[(count - 1) / 2];
    deviation->p99_rad = (double)search->angles[(size_t)(0.99 * (double)(count - 1))];
    deviation->max_rad = (double)search->angles[count - 1];
}

static void read_stored(const norma_mesh_data *data, const core_mesh *mesh, float *stored) {
    for (size_t corner = 0; corner < mesh->corner_count; ++corner) {
        size_t number = data->corner_normals ? data->corner_normals[corner] : norma_core_corner(mesh, corner);
        double normal[3] = {0};
        if (number < data->normals.count)
            norma_view_read(&data->normals, number, normal);
        for (int k = 0; k < 3; k++) stored[3 * corner + (size_t)k] = (float)normal[k];
    }
}

static norma_result explain(core_call *call, const norma_mesh_data *data, const core_mesh *checked, norma_deviation *deviation) {
    size_t corners = checked->corner_count, faces = checked->face_count, room = corners > checked->positions.count ? corners : checked->positions.count;
    room = room > faces ? room : faces;
    float *stored = norma_core_allocate(call, corners, 3 * sizeof *stored);
    float *computed = norma_core_allocate(call, room, 3 * sizeof *computed), *angles = norma_core_allocate(call, corners, sizeof *angles);
    normal_search search = {.mesh = &data->mesh, .call = call, .stored = stored, .computed = computed, .angles = angles};
    search.options = (norma_options){.struct_size = sizeof search.options, .threads = call->options.threads, .allocator = call->options.allocator};
    normal_trial best;
    norma_result result = stored && computed && angles ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        read_stored(data, checked, stored);
        result = find_best(&search, &best);
    }
    if (!result && search.angle_count)
        describe(&search, &best, deviation);
    norma_core_release(call, stored, corners, 3 * sizeof *stored);
    norma_core_release(call, computed, room, 3 * sizeof *computed);
    norma_core_release(call, angles, corners, sizeof *angles);
    return result;
}

norma_result norma_explain_normals(const norma_mesh_data *data, norma_normal_storage storage, const norma_options *options, norma_deviation *deviation) {
    core_call call;
    core_mesh mesh;
    if (!data || !deviation)
        return NORMA_ERROR_ARGUMENT;
    *deviation = (norma_deviation){.crease_angle_rad = NAN};
    norma_result result = norma_core_begin(&call, options);
    if (!result)
        result = norma_core_mesh_shape(&data->mesh, &mesh);
    if (!result)
        result = norma_core_mesh_content(&call, &mesh);
    if (result || storage == NORMA_NORMALS_NONE || storage == NORMA_NORMALS_PER_FACET || !mesh.corner_count || !data->normals.count)
        return result;
    return explain(&call, data, &mesh, deviation);
}

/* ---- N204 */

static const char *weight_name(norma_weight weight) {
    static const char *const names[] = {"angle", "area", "uniform", "max", "angle-area", "visible", "angle-lengths"};
    return names[weight];
}

static void describe_deviation(const norma_deviation *d, size_t count, char message[CHECK_MESSAGE]) {
    char how[CHECK_MESSAGE];
    double degrees = 180 / NORMA_PI;
    if (d->shading == NORMA_SHADING_FLAT)
        norma_check_message(how, "flat shading");
    else if (d->shading == NORMA_SHADING_SMOOTH)
        norma_check_message(how, "%s weights, smooth", weight_name(d->weight));
    else
        norma_check_message(how, "%s weights, crease %g", weight_name(d->weight), d->crease_angle_rad * degrees);
    norma_check_message(message, "%z stored normals are best explained by %s: median %g, 99 %% within %g, at most %g degrees off", count, how, d->p50_rad * degrees, d->p99_rad * degrees, d->max_rad * degrees);
}

/* Normals that corners use: each vertex, each vn. */
static size_t count_normals(const check_mesh *m) {
    size_t count = norma_check_normal_count(m), used = 0;
    for (size_t i = 0; i < count && m->users; i++) used += m->users[i] != UINT32_MAX;
    return m->users ? used : count;
}

norma_result norma_check_deviation(check_mesh *m) {
    norma_deviation deviation;
    char message[CHECK_MESSAGE];
    norma_options options = {.struct_size = sizeof options, .threads = m->run->options.threads};
    if (!norma_check_wants(m, RULE_N204) || !norma_check_normal_count(m) || m->given->info.normals == NORMA_NORMALS_PER_FACET)
        return NORMA_OK;
    norma_result result = norma_check_users(m);
    if (!result)
        result = norma_explain_normals(&m->given->data, m->given->info.normals, &options, &deviation);
    if (result || !deviation.corners)
        return result;
    check_hits hits = {0};
    norma_check_hit(m->run, &hits, deviation.max_rad * (180 / NORMA_PI), CHECK_NOWHERE);
    hits.count = count_normals(m);
    describe_deviation(&deviation, hits.count, message);
    return norma_check_add(m->run, &m->place, m, &(check_report){.rule = RULE_N204, .severity = NORMA_SEVERITY_INFO, .unit = "deg", .hits = &hits, .message = message, .deviation = &deviation});
}
