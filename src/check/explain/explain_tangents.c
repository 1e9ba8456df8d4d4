/* explain_tangents.c: which way of making tangents explains stored ones best. */
#include "check/explain/explain.h"
#include "core/face/face.h"
#include "core/tangent/tangents.h"
#include <math.h>
#include <string.h>

/* ---- Tangents as sums over the triangles at each vertex (E. Lengyel, Computing Tangent
 * Space Basis Vectors for an Arbitrary Mesh, 2001): dP/du of each triangle, added as it is, made
 * perpendicular to the normal; the sign by the sum of dP/dv. Many exporters and engines do so. */

/* A surface with stored tangents: triangles, whose normals and texture coordinates belong to
 * vertices. */
typedef struct tangent_surface {
    const norma_mesh *mesh;
    core_mesh checked;
    const float *texcoords, *stored; /* two and four floats of each vertex */
    float *normals;                  /* three floats of each vertex */
} tangent_surface;

typedef struct vertex_sum {
    double along_u[3], along_v[3];
} vertex_sum;

static void add_triangle(const tangent_surface *s, size_t first, vertex_sum *sums) {
    uint32_t v[3];
    double p[3][3], along_u[3], along_v[3];
    for (size_t i = 0; i < 3; ++i) {
        v[i] = norma_core_corner(&s->checked, first + i);
        norma_core_position(&s->checked, v[i], p[i]);
    }
    const float *a = s->texcoords + 2 * (size_t)v[0], *b = s->texcoords + 2 * (size_t)v[1],
                *c = s->texcoords + 2 * (size_t)v[2];
    const double s1 = (double)b[0] - (double)a[0], s2 = (double)c[0] - (double)a[0],
                 t1 = (double)b[1] - (double)a[1], t2 = (double)c[1] - (double)a[1],
                 area = s1 * t2 - s2 * t1;
    if (!(fabs(area) > 0)) return;
    for (int k = 0; k < 3; ++k) {
        const double x1 = p[1][k] - p[0][k], x2 = p[2][k] - p[0][k];
        along_u[k] = (t2 * x1 - t1 * x2) / area;
        along_v[k] = (s1 * x2 - s2 * x1) / area;
        if (!isfinite(along_u[k]) || !isfinite(along_v[k])) return;
    }
    for (size_t i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            sums[v[i]].along_u[k] += along_u[k];
            sums[v[i]].along_v[k] += along_v[k];
        }
}

/* Rounding leaves something of a sum along the normal; that is no tangent. */
static void finish_vertex(const float *n, const vertex_sum *sum, float tangent[4]) {
    const double normal[3] = {(double)n[0], (double)n[1], (double)n[2]},
                 along = norma_core_dot(normal, sum->along_u);
    double t[3], bitangent[3];
    for (int k = 0; k < 3; ++k) t[k] = sum->along_u[k] - along * normal[k];
    const double length = sqrt(norma_core_dot(t, t));
    norma_core_cross(normal, t, bitangent);
    memset(tangent, 0, 4 * sizeof *tangent);
    if (!(length > 1e-6 * sqrt(norma_core_dot(sum->along_u, sum->along_u)))) return;
    for (int k = 0; k < 3; ++k) tangent[k] = (float)(t[k] / length);
    tangent[3] = norma_core_dot(bitangent, sum->along_v) < 0 ? -1.0F : 1.0F;
}

/* Lengyel 2001. */
static norma_result explain_tangent_sums(
    core_call *call, const tangent_surface *s, float *tangents) {
    const size_t count = s->checked.positions.count;
    vertex_sum *sums = norma_core_allocate(call, count, sizeof *sums);
    if (!sums) return NORMA_ERROR_MEMORY;
    memset(sums, 0, count * sizeof *sums);
    for (size_t f = 0; f < s->checked.face_count; ++f)
        add_triangle(s, norma_core_face_begin(&s->checked, f), sums);
    for (size_t c = 0; c < s->checked.corner_count; ++c) {
        const uint32_t v = norma_core_corner(&s->checked, c);
        finish_vertex(s->normals + 3 * (size_t)v, &sums[v], tangents + 4 * c);
    }
    norma_core_release(call, sums, count, sizeof *sums);
    return NORMA_OK;
}

/* ---- The ways of the core: MikkTSpace on the triangles, and on quads: modelling programs compute
 * tangents on quads and export triangles: neighbours in the list that share a diagonal are put
 * together again, and MikkTSpace, which may cut a quad along its other diagonal, is asked about the
 * quads. */

/* Corners that have none get zeros. */
static norma_result explain_made(
    core_call *call, const tangent_surface *s, tangent_maker *maker, float *tangents) {
    const size_t corners = s->checked.corner_count, vertices = s->checked.positions.count;
    const norma_attribute normals = {.data = s->normals, .count = vertices},
                          texcoords = {.data = s->texcoords, .count = vertices};
    uint8_t *reasons = norma_core_allocate(call, corners, 1);
    const norma_options options = {.struct_size = sizeof options,
        .threads = call->options.threads,
        .allocator = call->options.allocator,
        .reasons = reasons};
    norma_result result = reasons ? norma_core_corner_tangents(s->mesh, &normals, &texcoords, maker,
                                        &options, tangents, corners, NULL)
                                  : NORMA_ERROR_MEMORY;
    for (size_t c = 0; !result && c < corners; ++c)
        if (reasons[c] != NORMA_REASON_NONE) memset(tangents + 4 * c, 0, 4 * sizeof *tangents);
    norma_core_release(call, reasons, corners, 1);
    return result;
}

/* ---- quads */

typedef struct quad_mesh {
    uint32_t *corners, *starts;
    uint32_t *place; /* of each corner of the triangles, its corner here */
    size_t corner_count, face_count, quads;
    int across; /* equal diagonals are cut across the shared edge */
} quad_mesh;

static void read_tangent_triangle(const tangent_surface *s, size_t face, uint32_t v[3]) {
    for (size_t i = 0; i < 3; ++i) v[i] = norma_core_corner(&s->checked, 3 * face + i);
}

/* Where edge i of a is an edge of b that runs the other way, b's third corner, and its place; -1:
 * they do not meet there. */
static int lies_across(const uint32_t a[3], int i, const uint32_t b[3]) {
    for (int k = 0; k < 3; ++k)
        if (b[k] == a[(i + 1) % 3] && b[(k + 1) % 3] == a[i]) return (k + 2) % 3;
    return -1;
}

/* Whether two triangles share one edge, but not all corners: that edge, and the apex across it. */
static int is_quad(const uint32_t a[3], const uint32_t b[3], int *edge, int *apex) {
    for (int i = 0; i < 3; ++i) {
        *edge = i;
        *apex = lies_across(a, i, b);
        if (*apex >= 0 && b[*apex] != a[(i + 2) % 3]) return 1;
    }
    return 0;
}

/* Around the quad: the first triangle's corner opposite to the edge, the edge's start, the second's
 * apex, the edge's end. Where its diagonals are equal, MikkTSpace cuts from the first corner: along
 * the shared edge, or across it. */
static void add_quad(quad_mesh *q, const uint32_t a[3], const uint32_t b[3], int edge, int apex,
    size_t first_corner) {
    const uint32_t opposite = (uint32_t)(edge + 2) % 3, start = (uint32_t)edge,
                   end = (uint32_t)(edge + 1) % 3, turn = q->across ? 0 : 1,
                   far_apex = (uint32_t)apex, at = (uint32_t)q->corner_count,
                   around[4] = {a[opposite], a[start], b[far_apex], a[end]};
    uint32_t places[4];
    for (uint32_t i = 0; i < 4; ++i) {
        places[i] = at + (i + 4 - turn) % 4;
        q->corners[places[i]] = around[i];
    }
    q->place[first_corner + opposite] = places[0];
    q->place[first_corner + start] = places[1];
    q->place[first_corner + end] = places[3];
    q->place[first_corner + 3 + far_apex] = places[2];
    q->place[first_corner + 3 + (far_apex + 1) % 3] = places[3];
    q->place[first_corner + 3 + (far_apex + 2) % 3] = places[1];
    q->corner_count += 4;
    ++q->quads;
}

static void add_mikk_triangle(quad_mesh *q, const uint32_t a[3], size_t first_corner) {
    for (size_t i = 0; i < 3; ++i) {
        q->corners[q->corner_count + i] = a[i];
        q->place[first_corner + i] = (uint32_t)(q->corner_count + i);
    }
    q->corner_count += 3;
}

/* How likely a triangle and the next in the list are one quad: surely if they lie in one plane. */
static double likelihood(const tangent_surface *s, size_t face) {
    uint32_t a[3], b[3];
    int edge, apex;
    core_face first, second;
    double cross[3];
    read_tangent_triangle(s, face, a);
    read_tangent_triangle(s, face + 1, b);
    if (!is_quad(a, b, &edge, &apex)) return 0;
    norma_core_face_geometry(&s->checked, face, &first);
    norma_core_face_geometry(&s->checked, face + 1, &second);
    if (!(first.flags & second.flags & CORE_FACE_DIRECTED)) return .5;
    norma_core_cross(first.normal, second.normal, cross);
    const double bend = norma_core_angle(
        sqrt(norma_core_dot(cross, cross)), norma_core_dot(first.normal, second.normal));
    return 1 / (1 + bend * (180 / NORMA_PI));
}

/* The pairs of neighbours whose likelihoods have the greatest sum: sums over the first triangles,
 * with and without the last pair; then back through them. */
static norma_result choose_pairs(core_call *call, const tangent_surface *s, uint8_t *paired) {
    const size_t count = s->checked.face_count;
    double *sums = norma_core_allocate(call, count + 1, sizeof *sums);
    if (!sums) return NORMA_ERROR_MEMORY;
    sums[0] = sums[1] = 0;
    for (size_t f = 2; f <= count; ++f) {
        const double likely = likelihood(s, f - 2), with = sums[f - 2] + likely;
        paired[f - 2] = likely > 0 && with > sums[f - 1];
        sums[f] = paired[f - 2] ? with : sums[f - 1];
    }
    for (size_t f = count; f >= 2; --f)
        if (paired[f - 2]) {
            --f;
            if (f >= 2) paired[f - 2] = 0;
        }
    norma_core_release(call, sums, count + 1, sizeof *sums);
    return NORMA_OK;
}

static void put_together(const tangent_surface *s, const uint8_t *paired, quad_mesh *q) {
    const size_t count = s->checked.face_count;
    for (size_t f = 0; f < count; ++f) {
        uint32_t a[3], b[3];
        int edge, apex;
        read_tangent_triangle(s, f, a);
        q->starts[q->face_count++] = (uint32_t)q->corner_count;
        if (f + 1 < count && paired[f]) {
            read_tangent_triangle(s, f + 1, b);
            (void)is_quad(a, b, &edge, &apex);
            add_quad(q, a, b, edge, apex, 3 * f++);
        } else {
            add_mikk_triangle(q, a, 3 * f);
        }
    }
    q->starts[q->face_count] = (uint32_t)q->corner_count;
}

static norma_result compute_quads(
    core_call *call, const tangent_surface *s, const quad_mesh *q, float *of_quads) {
    norma_mesh mesh = *s->mesh;
    mesh.corners = q->corners;
    mesh.corner_size = 0;
    mesh.corner_count = q->corner_count;
    mesh.face_starts = q->starts;
    mesh.face_count = q->face_count;
    tangent_surface quads = *s;
    quads.mesh = &mesh;
    quads.checked.corner_count = q->corner_count;
    return explain_made(call, &quads, norma_core_mikk_tangents, of_quads);
}

/* On neighbours in the list put together again. across_ties: quads of two equal diagonals are cut
 * along the one that the triangles do not share. Tangents stay as they are, and *any is 0, where
 * there are no such neighbours. */
static norma_result explain_mikk_on_quads(
    core_call *call, const tangent_surface *s, int across_ties, float *tangents, int *any) {
    const size_t corners = s->checked.corner_count, faces = s->checked.face_count;
    quad_mesh q = {.across = across_ties,
        .corners = norma_core_allocate(call, corners, sizeof *q.corners),
        .starts = norma_core_allocate(call, faces + 1, sizeof *q.starts),
        .place = norma_core_allocate(call, corners, sizeof *q.place)};
    float *of_quads = norma_core_allocate(call, corners, 4 * sizeof *of_quads);
    uint8_t *paired = norma_core_allocate(call, faces, 1);
    norma_result result =
        q.corners && q.starts && q.place && of_quads && paired ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) result = choose_pairs(call, s, paired);
    if (!result) put_together(s, paired, &q);
    *any = !result && q.quads > 0;
    if (*any) result = compute_quads(call, s, &q, of_quads);
    for (size_t c = 0; *any && !result && c < corners; ++c)
        memcpy(tangents + 4 * c, of_quads + 4 * (size_t)q.place[c], 4 * sizeof *tangents);
    norma_core_release(call, q.corners, corners, sizeof *q.corners);
    norma_core_release(call, q.starts, faces + 1, sizeof *q.starts);
    norma_core_release(call, q.place, corners, sizeof *q.place);
    norma_core_release(call, of_quads, corners, 4 * sizeof *of_quads);
    norma_core_release(call, paired, faces, 1);
    return result;
}

/* ---- How the tangents that a surface has were made: by the candidate whose
 * tangents lie nearest to the stored ones. Angles count up to a few degrees, so that what a
 * candidate gives on degenerate faces decides nothing. */

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
    float *turned;        /* NULL, or texture coordinates through the normal map's transform */
    norma_map_error under_mikk, under_meshopt, under_vertex_sums;
    norma_tangent_deviation *found;
} tangent_search;

/* ---- one candidate */

typedef struct tangent_score {
    double sum;
    size_t corners, explained, as_is, negated; /* as_is, negated: corners by their signs */
} tangent_score;

static tangent_score score_angles(const tangent_search *search) {
    const tangent_surface *s = &search->surface;
    tangent_score score = {0};
    for (size_t c = 0; c < s->checked.corner_count; ++c) {
        const float *stored = s->stored + 4 * (size_t)norma_core_corner(&s->checked, c),
                    *made = search->tangents + 4 * c;
        const float angle = search->angles[c] = norma_explain_angle(stored, made);
        if (angle < 0) continue;
        ++score.corners;
        score.sum += fmin((double)angle, MOST);
        score.explained += (double)angle <= search->close;
        score.as_is += stored[3] == made[3];
        score.negated += stored[3] == -made[3];
    }
    return score;
}

/* A later candidate must be better by more than noise: the simplest of equals stays. */
static int judge(tangent_search *search, norma_tangent_source source) {
    const tangent_score score = score_angles(search);
    const double mean = score.corners ? score.sum / (double)score.corners : INFINITY;
    float *angles = search->angles;
    if (!(mean < .99 * search->best_score - 1e-6)) return 0;
    search->best_score = mean;
    search->angles = search->best;
    search->best = angles;
    *search->found = (norma_tangent_deviation){.source = source,
        .negated = score.negated >= score.as_is,
        .transformed = search->turned != NULL,
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
                              : explain_mikk_on_quads(search->call, &search->surface, across_ties,
                                    search->tangents, &any);
    if (!result && !is_explained(search) && any) judge(search, NORMA_TANGENTS_BY_MIKK_ON_QUADS);
    return result;
}

/* Of the angles that the last candidate left. */
static norma_result summarise(
    const tangent_search *search, float *of, norma_deviation *angles, size_t *worst) {
    const explain_surface measured = {.checked = search->surface.checked, .angles = of};
    return norma_explain_summarise(search->call, &measured, angles, worst);
}

/* A way in which renderers make tangents: the candidate in search->tangents. */
static norma_result judge_renderer(
    tangent_search *search, norma_tangent_source source, norma_map_error *under) {
    norma_deviation angles;
    size_t worst;
    const int is_best = judge(search, source);
    const norma_result result =
        summarise(search, is_best ? search->best : search->angles, &angles, &worst);
    if (!result) *under = (norma_map_error){angles.p50_rad, angles.p99_rad, angles.max_rad};
    return result;
}

static norma_result try_mikk(tangent_search *search) {
    const norma_result result =
        explain_made(search->call, &search->surface, norma_core_mikk_tangents, search->tangents);
    return result ? result : judge_renderer(search, NORMA_TANGENTS_BY_MIKK, &search->under_mikk);
}

/* Through the normal map's transform, which some programs heed and some do not: the texture
 * coordinates of all further candidates, if MikkTSpace comes nearer with it. */
static norma_result try_turned(tangent_search *search, const float turn[4]) {
    const size_t vertices = search->surface.checked.positions.count;
    const float *stored = search->surface.texcoords;
    if (is_explained(search) || !(turn[0] != 0 || turn[1] != 0)) return NORMA_OK;
    float *turned = search->turned =
        norma_core_allocate(search->call, vertices, 2 * sizeof *turned);
    if (!turned) return NORMA_ERROR_MEMORY;
    for (size_t v = 0; v < vertices; ++v) {
        turned[2 * v] = turn[0] * stored[2 * v] + turn[1] * stored[2 * v + 1];
        turned[2 * v + 1] = turn[2] * stored[2 * v] + turn[3] * stored[2 * v + 1];
    }
    search->surface.texcoords = turned;
    const double before = search->best_score;
    const norma_map_error under_mikk = search->under_mikk;
    norma_result result = try_mikk(search);
    if (result || search->best_score < before) return result;
    norma_core_release(search->call, turned, vertices, 2 * sizeof *turned);
    search->turned = NULL;
    search->surface.texcoords = stored;
    search->under_mikk = under_mikk;
    return NORMA_OK;
}

static norma_result try_renderers(tangent_search *search) {
    core_call *call = search->call;
    const tangent_surface *s = &search->surface;
    norma_result result = explain_tangent_sums(call, s, search->tangents);
    if (!result)
        result = judge_renderer(search, NORMA_TANGENTS_BY_VERTEX_SUMS, &search->under_vertex_sums);
    if (!result) result = explain_made(call, s, norma_core_meshopt_tangents, search->tangents);
    if (!result) result = judge_renderer(search, NORMA_TANGENTS_BY_MESHOPT, &search->under_meshopt);
    return result;
}

static norma_result find_best(tangent_search *search, const float turn[4]) {
    search->best_score = INFINITY;
    norma_result result = try_mikk(search);
    if (!result) result = try_turned(search, turn);
    if (!result) result = try_quads(search, 0);
    if (!result) result = try_quads(search, 1);
    if (!result) result = try_renderers(search);
    if (result || is_explained(search)) return result;
    result =
        explain_made(search->call, &search->surface, norma_core_steady_tangents, search->tangents);
    if (!result) judge(search, NORMA_TANGENTS_BY_STEADY);
    return result;
}

static norma_result report_best(const tangent_search *search, size_t *worst) {
    norma_deviation angles;
    const norma_result result = summarise(search, search->best, &angles, worst);
    if (result) return result;
    search->found->corners = angles.corners;
    search->found->mean_rad = angles.mean_rad;
    search->found->p50_rad = angles.p50_rad;
    search->found->p99_rad = angles.p99_rad;
    search->found->max_rad = angles.max_rad;
    search->found->under_mikk = search->under_mikk;
    search->found->under_meshopt = search->under_meshopt;
    search->found->under_vertex_sums = search->under_vertex_sums;
    return NORMA_OK;
}

static norma_result search_tangents(tangent_search *search, const float turn[4], size_t *worst) {
    const size_t corners = search->surface.checked.corner_count;
    float *blocks[2] = {norma_core_allocate(search->call, corners, sizeof(float)),
        norma_core_allocate(search->call, corners, sizeof(float))};
    search->tangents = norma_core_allocate(search->call, corners, 4 * sizeof(float));
    search->angles = blocks[0];
    search->best = blocks[1];
    norma_result result =
        search->tangents && blocks[0] && blocks[1] ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t c = 0; !result && c < corners; ++c) blocks[1][c] = -1;
    if (!result) result = find_best(search, turn);
    if (!result) result = report_best(search, worst);
    for (int i = 0; i < 2; ++i) norma_core_release(search->call, blocks[i], corners, sizeof(float));
    norma_core_release(
        search->call, search->turned, search->surface.checked.positions.count, 2 * sizeof(float));
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
    norma_tangent_deviation *deviation, size_t *worst) {
    const size_t vertices = checked->positions.count;
    *deviation = (norma_tangent_deviation){0};
    *worst = SIZE_MAX;
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
    for (size_t v = 0; v < vertices; ++v) {
        double normal[3];
        norma_view_read(&data->normals, v, normal);
        for (size_t k = 0; k < 3; ++k) normals[3 * v + k] = (float)normal[k];
    }
    const norma_result result = search_tangents(&search, attributes->texcoord_turn, worst);
    norma_core_release(call, normals, vertices, 3 * sizeof(float));
    return result;
}

norma_result norma_explain_tangents(const norma_mesh_data *data,
    const norma_mesh_attributes *attributes, const norma_options *options,
    norma_tangent_deviation *deviation) {
    core_call call;
    core_mesh mesh;
    size_t worst;
    if (!data || !attributes || !deviation) return NORMA_ERROR_ARGUMENT;
    *deviation = (norma_tangent_deviation){0};
    norma_result result = norma_core_begin(&call, options);
    if (!result) result = norma_core_mesh_shape(&data->mesh, &mesh);
    if (!result) result = norma_core_mesh_content(&call, &mesh);
    mesh.scale = 1;
    return result ? result
                  : norma_explain_tangents_with(&call, data, attributes, &mesh, deviation, &worst);
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
    case NORMA_TANGENTS_BY_MESHOPT:
        return "meshoptimizer";
    case NORMA_TANGENTS_BY_STEADY:
        return "norma's steady tangents";
    }
    return NULL;
}
