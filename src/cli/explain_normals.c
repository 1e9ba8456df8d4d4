/* explain_normals.c: which weight and crease explain the normals that a file holds: those whose normals lie nearest to the stored ones, by mean angle. Creases are
 * tried with angle weights, then weights with the best crease, then creases again. */
#include "cli.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct normal_trial {
    norma_weight weight;
    double crease_deg; /* NaN: smooth */
    int flat;
} normal_trial;

typedef struct normal_search {
    const norma_mesh_data *data;
    norma_normal_storage storage;
    uint32_t threads;
    size_t faces;
    float *stored;   /* of each corner; zero: none */
    float *computed; /* room for a normal of each corner, vertex or face */
    float *angles;   /* radians, of the corners where both are */
    size_t angle_count;
} normal_search;

static uint32_t position_of(const norma_mesh *mesh, size_t corner) {
    if (!mesh->corners)
        return (uint32_t)corner;
    switch (mesh->corner_size) {
    case 1:
        return ((const uint8_t *)mesh->corners)[corner];
    case 2:
        return ((const uint16_t *)mesh->corners)[corner];
    default:
        return ((const uint32_t *)mesh->corners)[corner];
    }
}

static void read_stored(const normal_search *search) {
    const norma_mesh *mesh = &search->data->mesh;
    const norma_vec3_view *normals = &search->data->normals;
    size_t stride = normals->stride ? normals->stride : 3 * sizeof(float);
    for (size_t corner = 0; corner < mesh->corner_count; ++corner) {
        size_t number = search->data->corner_normals ? search->data->corner_normals[corner] : position_of(mesh, corner);
        float *stored = search->stored + 3 * corner;
        memset(stored, 0, 3 * sizeof *stored);
        if (number < normals->count)
            memcpy(stored, (const char *)normals->data + number * stride, 3 * sizeof *stored);
    }
}

/* atan2 of cross and dot: right for small angles, whatever the lengths. Negative: one of them is no direction. */
static double angle_between(const float *a, const float *b) {
    double ax = (double)a[0], ay = (double)a[1], az = (double)a[2], bx = (double)b[0], by = (double)b[1], bz = (double)b[2];
    double x = ay * bz - az * by, y = az * bx - ax * bz, z = ax * by - ay * bx, dot = ax * bx + ay * by + az * bz;
    double angle = atan2(sqrt(x * x + y * y + z * z), dot);
    int direction = (ax != 0 || ay != 0 || az != 0) && (bx != 0 || by != 0 || bz != 0);
    return direction && isfinite(angle) ? angle : -1;
}

static norma_result compute(const normal_search *search, const normal_trial *trial) {
    const norma_mesh *mesh = &search->data->mesh;
    const norma_options options = {.struct_size = sizeof options, .weight = trial->weight, .threads = search->threads};
    if (trial->flat)
        return norma_face_normals(mesh, &options, search->computed, search->faces, NULL);
    if (isnan(trial->crease_deg))
        return norma_vertex_normals(mesh, &options, search->computed, mesh->positions.count, NULL);
    return norma_corner_normals(mesh, (float)cli_radians(trial->crease_deg), &options, search->computed, mesh->corner_count, NULL);
}

static void measure(normal_search *search, const normal_trial *trial) {
    const norma_mesh *mesh = &search->data->mesh;
    size_t face = 0;
    search->angle_count = 0;
    for (size_t corner = 0; corner < mesh->corner_count; ++corner) {
        if (mesh->face_starts)
            while (mesh->face_starts[face + 1] <= corner) ++face;
        else
            face = corner / 3;
        size_t number = trial->flat ? face : isnan(trial->crease_deg) ? position_of(mesh, corner) : corner;
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
    return cli_interrupted() ? NORMA_CANCELLED : NORMA_OK;
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
    for (size_t i = 0; i < CLI_COUNT(creases) && !result; ++i)
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

static int compare_floats(const void *a, const void *b) {
    float of_a = *(const float *)a, of_b = *(const float *)b;
    return (of_a > of_b) - (of_a < of_b);
}

static void describe(normal_search *search, const normal_trial *best, cli_explained *explained) {
    size_t count = search->angle_count;
    qsort(search->angles, count, sizeof *search->angles, compare_floats);
    *explained = (cli_explained){
        .weight = best->weight,
        .crease_deg = best->crease_deg,
        .flat = best->flat,
        .p50_deg = cli_to_degrees((double)search->angles[(count - 1) / 2]),
        .p99_deg = cli_to_degrees((double)search->angles[(size_t)(0.99 * (double)(count - 1))]),
        .max_deg = cli_to_degrees((double)search->angles[count - 1]),
    };
}

static norma_document_result fail_search(norma_document_error *error, norma_result result) {
    static const norma_document_result of[] = {NORMA_DOCUMENT_CANCELLED, NORMA_DOCUMENT_ERROR_MEMORY, NORMA_DOCUMENT_ERROR_MALFORMED};
    error->result = of[result == NORMA_CANCELLED ? 0 : result == NORMA_ERROR_MEMORY ? 1 : 2];
    snprintf(error->message, sizeof error->message, "stored normals cannot be explained: %s", norma_result_text(result));
    return error->result;
}

int cli_explain_normals(norma_document *document, size_t mesh, uint32_t threads, cli_explained *explained, norma_document_result *result,
                        norma_document_error *error) {
    norma_mesh_info info;
    norma_mesh_data data;
    *result = norma_document_mesh_info(document, mesh, &info);
    if (*result || info.not_read || info.normals == NORMA_NORMALS_NONE || info.normals == NORMA_NORMALS_PER_FACET || info.faces == 0)
        return 0;
    *result = norma_document_mesh_data(document, mesh, &data, error);
    if (*result || data.mesh.corner_count == 0)
        return 0;
    size_t corners = data.mesh.corner_count, faces = data.mesh.face_starts ? data.mesh.face_count : corners / 3;
    size_t room = corners > data.mesh.positions.count ? corners : data.mesh.positions.count;
    normal_search search = {.data = &data, .storage = info.normals, .threads = threads, .faces = faces};
    room = room > faces ? room : faces;
    search.stored = calloc(corners, 3 * sizeof(float));
    search.computed = calloc(room, 3 * sizeof(float));
    search.angles = calloc(corners, sizeof(float));
    normal_trial best;
    norma_result failed = search.stored && search.computed && search.angles ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!failed) {
        read_stored(&search);
        failed = find_best(&search, &best);
    }
    if (failed)
        *result = fail_search(error, failed);
    else if (search.angle_count)
        describe(&search, &best, explained);
    free(search.stored);
    free(search.computed);
    free(search.angles);
    return !failed && search.angle_count > 0;
}
