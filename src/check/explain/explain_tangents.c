/* explain_tangents.c: how the tangents that a surface has were made: by the candidate whose
 * tangents lie nearest to the stored ones. Angles count up to a few degrees, so that what a
 * candidate gives on degenerate faces decides nothing. */
#include "check/explain/explain_tangents.h"
#include "check/explain/explain_normals.h"
#include "core/face/triangle.h"
#include <math.h>
#include <string.h>

static const double MOST = 5 * (NORMA_PI / 180), /* an angle counts up to this */
    CLOSE = .1 * (NORMA_PI / 180),               /* and is explained below this */
    ENOUGH = .9995; /* of the corners explained: nothing else is tried */

typedef struct tangent_search {
    core_call *call;
    tangent_surface surface;
    double close;         /* CLOSE and what the encoding rounds */
    float *tangents;      /* of the candidate that is tried */
    float *angles, *best; /* of each corner, radians; negative: not compared */
    double best_score;    /* mean angle, as it counts */
    norma_tangent_deviation *found;
} tangent_search;

/* ---- one candidate */

static float angle_between(const float *a, const float *b) {
    const double u[3] = {(double)a[0], (double)a[1], (double)a[2]},
                 v[3] = {(double)b[0], (double)b[1], (double)b[2]};
    double cross[3];
    norma_core_cross(u, v, cross);
    const double dot = norma_core_dot(u, v), across = sqrt(norma_core_dot(cross, cross));
    return (across > 0 || dot != 0) && across < INFINITY ? (float)norma_core_angle(across, dot)
                                                         : -1;
}

typedef struct tangent_score {
    double sum;
    size_t corners, explained, as_is, negated; /* as_is, negated: corners by their signs */
} tangent_score;

static tangent_score measure(const tangent_search *search) {
    const tangent_surface *s = &search->surface;
    tangent_score score = {0};
    for (size_t c = 0; c < s->checked.corner_count; c++) {
        const float *stored = s->stored + 4 * (size_t)norma_core_corner(&s->checked, c),
                    *made = search->tangents + 4 * c;
        const float angle = search->angles[c] = angle_between(stored, made);
        if (angle < 0) continue;
        score.corners++;
        score.sum += fmin((double)angle, MOST);
        score.explained += (double)angle <= search->close;
        score.as_is += stored[3] == made[3];
        score.negated += stored[3] == -made[3];
    }
    return score;
}

/* A later candidate must be better by more than noise: the simplest of equals stays. */
static int judge(tangent_search *search, norma_tangent_source source) {
    const tangent_score score = measure(search);
    const double mean = score.corners ? score.sum / (double)score.corners : INFINITY;
    float *angles = search->angles;
    if (!(mean < .99 * search->best_score - 1e-6)) return 0;
    search->best_score = mean;
    search->angles = search->best;
    search->best = angles;
    *search->found = (norma_tangent_deviation){.source = source,
        .negated = score.negated >= score.as_is,
        .signs_other = score.corners - (score.negated >= score.as_is ? score.negated : score.as_is),
        .explained = score.explained};
    return 1;
}

/* ---- the search */

static int is_explained(const tangent_search *search) {
    return (double)search->found->explained >=
           ENOUGH * (double)search->surface.checked.corner_count;
}

static norma_result try_quads(tangent_search *search, int across_ties) {
    int any;
    norma_result result = is_explained(search)
                              ? NORMA_OK
                              : norma_explain_mikk_on_quads(search->call, &search->surface,
                                    across_ties, search->tangents, &any);
    if (!result && !is_explained(search) && any) judge(search, NORMA_TANGENTS_BY_MIKK_ON_QUADS);
    return result;
}

/* Through the normal map's transform, which some programs heed and some do not. */
static norma_result try_turned(tangent_search *search, const float turn[4]) {
    const size_t vertices = search->surface.checked.positions.count;
    const float *stored = search->surface.texcoords;
    if (is_explained(search) || !(turn[0] != 0 || turn[1] != 0)) return NORMA_OK;
    float *turned = norma_core_allocate(search->call, vertices, 2 * sizeof *turned);
    if (!turned) return NORMA_ERROR_MEMORY;
    for (size_t v = 0; v < vertices; v++) {
        turned[2 * v] = turn[0] * stored[2 * v] + turn[1] * stored[2 * v + 1];
        turned[2 * v + 1] = turn[2] * stored[2 * v] + turn[3] * stored[2 * v + 1];
    }
    tangent_surface surface = search->surface;
    surface.texcoords = turned;
    norma_result result = norma_explain_mikk(search->call, &surface, search->tangents);
    if (!result && judge(search, NORMA_TANGENTS_BY_MIKK)) search->found->transformed = 1;
    norma_core_release(search->call, turned, vertices, 2 * sizeof *turned);
    return result;
}

static norma_result find_best(tangent_search *search, const float turn[4]) {
    search->best_score = INFINITY;
    norma_result result = norma_explain_mikk(search->call, &search->surface, search->tangents);
    if (!result) judge(search, NORMA_TANGENTS_BY_MIKK);
    if (!result) result = try_turned(search, turn);
    if (!result) result = try_quads(search, 0);
    if (!result) result = try_quads(search, 1);
    if (result || is_explained(search)) return result;
    result = norma_explain_tangent_sums(search->call, &search->surface, search->tangents);
    if (!result) judge(search, NORMA_TANGENTS_BY_VERTEX_SUMS);
    return result;
}

static norma_result summarise(tangent_search *search) {
    norma_deviation angles;
    const explain_surface measured = {.checked = search->surface.checked, .angles = search->best};
    const norma_result result = norma_explain_summarise(search->call, &measured, &angles);
    if (result) return result;
    search->found->corners = angles.corners;
    search->found->mean_rad = angles.mean_rad;
    search->found->p50_rad = angles.p50_rad;
    search->found->p99_rad = angles.p99_rad;
    search->found->max_rad = angles.max_rad;
    return NORMA_OK;
}

static norma_result search_surface(tangent_search *search, const float turn[4]) {
    const size_t corners = search->surface.checked.corner_count;
    float *blocks[2] = {norma_core_allocate(search->call, corners, sizeof(float)),
        norma_core_allocate(search->call, corners, sizeof(float))};
    search->tangents = norma_core_allocate(search->call, corners, 4 * sizeof(float));
    search->angles = blocks[0];
    search->best = blocks[1];
    norma_result result =
        search->tangents && blocks[0] && blocks[1] ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t c = 0; !result && c < corners; c++) blocks[1][c] = -1;
    if (!result) result = find_best(search, turn);
    if (!result) result = summarise(search);
    for (int i = 0; i < 2; i++) norma_core_release(search->call, blocks[i], corners, sizeof(float));
    norma_core_release(search->call, search->tangents, corners, 4 * sizeof(float));
    return result;
}

/* ---- a mesh of a file */

/* Only glTF stores tangents: triangles, everything by vertex. */
static int is_comparable(const norma_mesh_data *data, const norma_mesh_attributes *attributes) {
    const size_t vertices = data->mesh.positions.count;
    return !data->mesh.face_starts && data->mesh.corner_count && !data->corner_normals &&
           !attributes->corner_texcoords && attributes->texcoords && attributes->tangents &&
           data->normals.count == vertices && attributes->texcoord_count == vertices &&
           attributes->tangent_count == vertices;
}

norma_result norma_explain_tangents_with(core_call *call, const norma_mesh_data *data,
    const norma_mesh_attributes *attributes, const core_mesh *checked,
    norma_tangent_deviation *deviation) {
    const size_t vertices = checked->positions.count;
    *deviation = (norma_tangent_deviation){0};
    if (!is_comparable(data, attributes)) return NORMA_OK;
    tangent_search search = {.call = call,
        .surface = {.mesh = &data->mesh,
            .checked = *checked,
            .texcoords = attributes->texcoords,
            .stored = attributes->tangents,
            .normals = norma_core_allocate(call, vertices, 3 * sizeof(float))},
        .close = CLOSE + norma_check_encoding_bound(attributes->tangent_encoding),
        .found = deviation};
    float *normals = search.surface.normals;
    if (!normals) return NORMA_ERROR_MEMORY;
    for (size_t v = 0; v < vertices; v++) {
        double normal[3];
        norma_view_read(&data->normals, v, normal);
        for (size_t k = 0; k < 3; k++) normals[3 * v + k] = (float)normal[k];
    }
    const norma_result result = search_surface(&search, attributes->texcoord_turn);
    norma_core_release(call, normals, vertices, 3 * sizeof(float));
    return result;
}

norma_result norma_explain_tangents(const norma_mesh_data *data,
    const norma_mesh_attributes *attributes, const norma_options *options,
    norma_tangent_deviation *deviation) {
    core_call call;
    core_mesh mesh;
    if (!data || !attributes || !deviation) return NORMA_ERROR_ARGUMENT;
    *deviation = (norma_tangent_deviation){0};
    norma_result result = norma_core_begin(&call, options);
    if (!result) result = norma_core_mesh_shape(&data->mesh, &mesh);
    if (!result) result = norma_core_mesh_content(&call, &mesh);
    mesh.scale = 1;
    return result ? result : norma_explain_tangents_with(&call, data, attributes, &mesh, deviation);
}

const char *norma_tangent_source_name(norma_tangent_source source) {
    switch (source) {
    case NORMA_TANGENTS_UNCOMPARED:
        return NULL;
    case NORMA_TANGENTS_BY_MIKK:
        return "MikkTSpace on triangles";
    case NORMA_TANGENTS_BY_MIKK_ON_QUADS:
        return "MikkTSpace on quads";
    case NORMA_TANGENTS_BY_VERTEX_SUMS:
        return "sums per vertex";
    }
    return NULL;
}
