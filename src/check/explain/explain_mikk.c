/* explain_mikk.c: MikkTSpace on the triangles, and on quads: modelling programs compute tangents on
 * quads and export triangles: neighbours in the list that share a diagonal are put together again,
 * and MikkTSpace, which may cut a quad along its other diagonal, is asked about the quads. */
#include "check/explain/explain_tangents.h"
#include "core/face/triangle.h"
#include <math.h>
#include <string.h>

norma_result norma_explain_mikk(core_call *call, const tangent_surface *s, float *tangents) {
    const size_t corners = s->checked.corner_count, vertices = s->checked.positions.count;
    const norma_attribute normals = {.data = s->normals, .count = vertices},
                          texcoords = {.data = s->texcoords, .count = vertices};
    uint8_t *reasons = norma_core_allocate(call, corners, 1);
    const norma_options options = {.struct_size = sizeof options,
        .threads = call->options.threads,
        .allocator = call->options.allocator,
        .reasons = reasons};
    norma_result result = reasons ? norma_corner_tangents(s->mesh, &normals, &texcoords,
                                        NORMA_TANGENTS_MIKK, &options, tangents, corners, NULL)
                                  : NORMA_ERROR_MEMORY;
    for (size_t c = 0; !result && c < corners; c++)
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

static void read_triangle(const tangent_surface *s, size_t face, uint32_t v[3]) {
    for (size_t i = 0; i < 3; i++) v[i] = norma_core_corner(&s->checked, 3 * face + i);
}

/* Where edge i of a is an edge of b that runs the other way, b's third corner, and its place; -1:
 * they do not meet there. */
static int across(const uint32_t a[3], int i, const uint32_t b[3]) {
    for (int k = 0; k < 3; k++)
        if (b[k] == a[(i + 1) % 3] && b[(k + 1) % 3] == a[i]) return (k + 2) % 3;
    return -1;
}

/* Whether two triangles share one edge, but not all corners: that edge, and the apex across it. */
static int is_quad(const uint32_t a[3], const uint32_t b[3], int *edge, int *apex) {
    for (int i = 0; i < 3; i++) {
        *edge = i;
        *apex = across(a, i, b);
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
    for (uint32_t i = 0; i < 4; i++) {
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
    q->quads++;
}

static void add_triangle(quad_mesh *q, const uint32_t a[3], size_t first_corner) {
    for (size_t i = 0; i < 3; i++) {
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
    read_triangle(s, face, a);
    read_triangle(s, face + 1, b);
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
    for (size_t f = 2; f <= count; f++) {
        const double likely = likelihood(s, f - 2), with = sums[f - 2] + likely;
        paired[f - 2] = likely > 0 && with > sums[f - 1];
        sums[f] = paired[f - 2] ? with : sums[f - 1];
    }
    for (size_t f = count; f >= 2; f--)
        if (paired[f - 2]) {
            --f;
            if (f >= 2) paired[f - 2] = 0;
        }
    norma_core_release(call, sums, count + 1, sizeof *sums);
    return NORMA_OK;
}

static void put_together(const tangent_surface *s, const uint8_t *paired, quad_mesh *q) {
    const size_t count = s->checked.face_count;
    for (size_t f = 0; f < count; f++) {
        uint32_t a[3], b[3];
        int edge, apex;
        read_triangle(s, f, a);
        q->starts[q->face_count++] = (uint32_t)q->corner_count;
        if (f + 1 < count && paired[f]) {
            read_triangle(s, f + 1, b);
            (void)is_quad(a, b, &edge, &apex);
            add_quad(q, a, b, edge, apex, 3 * f++);
        } else {
            add_triangle(q, a, 3 * f);
        }
    }
    q->starts[q->face_count] = (uint32_t)q->corner_count;
}

static norma_result compute(
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
    return norma_explain_mikk(call, &quads, of_quads);
}

norma_result norma_explain_mikk_on_quads(
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
    if (*any) result = compute(call, s, &q, of_quads);
    for (size_t c = 0; *any && !result && c < corners; c++)
        memcpy(tangents + 4 * c, of_quads + 4 * (size_t)q.place[c], 4 * sizeof *tangents);
    norma_core_release(call, q.corners, corners, sizeof *q.corners);
    norma_core_release(call, q.starts, faces + 1, sizeof *q.starts);
    norma_core_release(call, q.place, corners, sizeof *q.place);
    norma_core_release(call, of_quads, corners, 4 * sizeof *of_quads);
    norma_core_release(call, paired, faces, 1);
    return result;
}
