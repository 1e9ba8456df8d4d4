/* meshopt.c: the tangents of meshoptimizer, with its default weights and to its last bit
 * (A. Kapoulkine, meshoptimizer 1.3, meshopt_generateTangents). Godot makes these where a file has
 * none.
 *
 * As in MikkTSpace, corners of triangles that a shared edge joins at a vertex, and whose textures
 * have the same orientation, share the sum of their triangles' tangents. Unlike there, a triangle's
 * tangent is weighted by its angle at the vertex and by the lengths of both edges that meet there,
 * all three in the plane of the vertex's normal, so that slivers beside large triangles count
 * little. A triangle without texture area joins what lies beside it, as long as this has one
 * orientation, and adds nothing.
 *
 * Three things differ. Corners whose sum is none get a vector perpendicular to their normal and a
 * reason; meshoptimizer writes (1, 0, 0). Numbers that are not finite do not spread to neighbours.
 * And of an edge of more than EDGE_MOST faces, each is compared with the next EDGE_MOST only. */
#include "core/tangent/tangents.h"

enum { EDGE_MOST = 256, FEW_CORNERS = 32 };
enum { POSITIVE_TEXTURE = 1, NEGATIVE_TEXTURE = 2 };

typedef struct meshopt_face {
    float tangent[3]; /* unit, along u */
    uint8_t own;      /* its orientation in the texture; 0: no area there, or in space */
    uint8_t joined;   /* of the face that stands for others: the orientation of all of them */
    uint32_t stands;  /* another face that stands for it, or itself */
} meshopt_face;

typedef struct meshopt_mesh {
    const tangent_mesh *input;
    size_t corner_count, face_count;
    uint32_t *vertex_of; /* of each corner */
    core_corners_of_position around;
    uint32_t *group;  /* of each corner another one that it shares its sum with, or itself */
    float (*sums)[3]; /* of each corner that stands for its group */
    meshopt_face *faces;
    uint64_t *after, *before; /* of a star: where its edges lead to, with numbers of corners */
} meshopt_mesh;

static const tangent_vertex *meshopt_vertex(const meshopt_mesh *m, size_t corner) {
    return &m->input->vertices[norma_core_tangent_key(m->input, corner)];
}

static float dot_floats(const float a[3], const float b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static int is_same_place(const tangent_vertex *a, const tangent_vertex *b) {
    return a->position[0] == b->position[0] && a->position[1] == b->position[1] &&
           a->position[2] == b->position[2];
}

/* ---- triangles */

/* Mikkelsen 2008, equations 42 and 48. */
static meshopt_face face_of(
    const tangent_vertex *a, const tangent_vertex *b, const tangent_vertex *c) {
    const float u1 = b->texcoord[0] - a->texcoord[0], v1 = b->texcoord[1] - a->texcoord[1],
                u2 = c->texcoord[0] - a->texcoord[0], v2 = c->texcoord[1] - a->texcoord[1],
                area = u1 * v2 - v1 * u2;
    meshopt_face face = {.own = area > 0 ? POSITIVE_TEXTURE : area < 0 ? NEGATIVE_TEXTURE : 0};
    if (is_same_place(a, b) || is_same_place(a, c) || is_same_place(b, c) ||
        !norma_core_tangent_is_finite(a) || !norma_core_tangent_is_finite(b) ||
        !norma_core_tangent_is_finite(c))
        face.own = 0;
    for (int k = 0; k < 3; ++k)
        face.tangent[k] =
            v2 * (b->position[k] - a->position[k]) - v1 * (c->position[k] - a->position[k]);
    const float length = sqrtf(dot_floats(face.tangent, face.tangent)),
                sign = face.own == POSITIVE_TEXTURE   ? 1.0F
                       : face.own == NEGATIVE_TEXTURE ? -1.0F
                                                      : 0.0F,
                scale = length != 0 ? sign / length : 0;
    for (int k = 0; k < 3; ++k) face.tangent[k] *= scale;
    face.joined = face.own;
    return face;
}

/* ---- Sets of corners and of faces, each named by one of its members (R. Tarjan 1975). */

static uint32_t stand_in_of(meshopt_face *faces, uint32_t face) {
    while (faces[face].stands != face) face = faces[face].stands = faces[faces[face].stands].stands;
    return face;
}

static uint32_t group_of(uint32_t *group, uint32_t corner) {
    while (group[corner] != corner) corner = group[corner] = group[group[corner]];
    return corner;
}

/* Faces that have an area of their own become one with others only through faces that have none:
 * these belong to the first orientation that reaches them. */
static void join_texture_fans(meshopt_mesh *m, uint32_t corner, uint32_t other) {
    meshopt_face *faces = m->faces;
    const uint32_t a = stand_in_of(faces, corner / 3), b = stand_in_of(faces, other / 3);
    if ((faces[a].joined | faces[b].joined) == (POSITIVE_TEXTURE | NEGATIVE_TEXTURE)) return;
    if (a != b && !(faces[corner / 3].own && faces[other / 3].own)) {
        faces[b].stands = a;
        faces[a].joined |= faces[b].joined;
    }
    m->group[group_of(m->group, other)] = group_of(m->group, corner);
}

/* ---- The corners at a vertex, in pairs, in the order of their triangles: the order decides only
 * for triangles without texture area between two orientations. */

static uint32_t vertex_after(const meshopt_mesh *m, uint32_t corner) {
    return m->vertex_of[corner % 3 == 2 ? corner - 2 : corner + 1];
}
static uint32_t vertex_before(const meshopt_mesh *m, uint32_t corner) {
    return m->vertex_of[corner % 3 ? corner - 1 : corner + 2];
}

static void join_few(meshopt_mesh *m, const uint32_t *corners, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        const uint32_t after = vertex_after(m, corners[i]), before = vertex_before(m, corners[i]);
        for (size_t j = i + 1; j < count; ++j)
            if (vertex_after(m, corners[j]) == before || vertex_before(m, corners[j]) == after)
                join_texture_fans(m, corners[i], corners[j]);
    }
}

/* The place of the first of these sorted edges at or behind this one. */
static size_t first_edge(const uint64_t *edges, size_t count, uint64_t edge) {
    size_t low = 0, high = count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (edges[middle] < edge)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The number of the corner at a place, if its edge leads to that vertex; else SIZE_MAX. */
static size_t corner_at(const uint64_t *edges, size_t count, size_t place, uint32_t vertex) {
    return place < count && edges[place] >> 32 == vertex ? (size_t)(uint32_t)edges[place]
                                                         : SIZE_MAX;
}

/* The same pairs as join_few, found among sorted edges. */
static void join_many(meshopt_mesh *m, const uint32_t *corners, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        m->after[i] = (uint64_t)vertex_after(m, corners[i]) << 32 | i;
        m->before[i] = (uint64_t)vertex_before(m, corners[i]) << 32 | i;
    }
    norma_core_sort_numbers(m->after, count);
    norma_core_sort_numbers(m->before, count);
    for (size_t i = 0; i < count; ++i) {
        const uint32_t after = vertex_after(m, corners[i]), before = vertex_before(m, corners[i]);
        size_t out = first_edge(m->after, count, (uint64_t)before << 32 | (i + 1)),
               in = first_edge(m->before, count, (uint64_t)after << 32 | (i + 1));
        for (int left = EDGE_MOST; left > 0; --left) {
            const size_t next_out = corner_at(m->after, count, out, before),
                         next_in = corner_at(m->before, count, in, after),
                         j = next_out < next_in ? next_out : next_in;
            if (j == SIZE_MAX) break;
            join_texture_fans(m, corners[i], corners[j]);
            out += next_out == j;
            in += next_in == j;
        }
    }
}

/* ---- sums */

/* C. Hastings, Approximations for Digital Computers, 1955: within 5e-4. */
static float hastings_acos(float x) {
    const float size = fabsf(x) > 1 ? 1 : fabsf(x),
                angle =
                    (1.570337F + size * (-0.2053972F + size * 0.05147786F)) * sqrtf(1.0F - size);
    return x < 0 ? 3.1415926F - angle : angle;
}

static void put_into_plane(const float v[3], const float normal[3], float out[3]) {
    const float along = dot_floats(v, normal);
    for (int k = 0; k < 3; ++k) out[k] = v[k] - normal[k] * along;
}

static void add_at_corner(const meshopt_mesh *m, uint32_t corner, const float tangent[3],
    const tangent_vertex *next, const tangent_vertex *previous) {
    const tangent_vertex *at = meshopt_vertex(m, corner);
    float part[3], edges[2][3], *sum = m->sums[group_of(m->group, corner)];
    put_into_plane(tangent, at->normal, part);
    for (int k = 0; k < 3; ++k) {
        edges[0][k] = next->position[k] - at->position[k];
        edges[1][k] = previous->position[k] - at->position[k];
    }
    for (int e = 0; e < 2; ++e) put_into_plane(edges[e], at->normal, edges[e]);
    const float length = sqrtf(dot_floats(part, part)),
                lengths = sqrtf(dot_floats(edges[0], edges[0]) * dot_floats(edges[1], edges[1])),
                cosine = dot_floats(edges[0], edges[1]) * (lengths == 0 ? 0 : 1 / lengths);
    float weight = hastings_acos(cosine) * (length == 0 ? 0 : 1 / length);
    weight *= lengths;
    for (int k = 0; k < 3; ++k) sum[k] += part[k] * weight;
}

static void sum_up_faces(const meshopt_mesh *m) {
    for (size_t f = 0; f < m->face_count; ++f) {
        const uint32_t first = (uint32_t)(3 * f);
        for (uint32_t i = 0; m->faces[f].own && i < 3; ++i)
            add_at_corner(m, first + i, m->faces[f].tangent, meshopt_vertex(m, first + (i + 1) % 3),
                meshopt_vertex(m, first + (i + 2) % 3));
    }
}

/* meshoptimizer writes whatever is left of sums that overflow or underflow; a vector that is not
 * unit is none. */
static corner_tangent tangent_at(const meshopt_mesh *m, uint32_t corner) {
    const float *sum = m->sums[group_of(m->group, corner)];
    const meshopt_face *face = &m->faces[corner / 3];
    const float length = sqrtf(dot_floats(sum, sum)), scale = length == 0 ? 0 : 1 / length;
    corner_tangent out = {
        .sign = m->faces[stand_in_of(m->faces, corner / 3)].joined & POSITIVE_TEXTURE ? 1 : -1};
    for (int k = 0; k < 3; ++k) out.direction[k] = sum[k] * scale;
    if (!(fabsf(dot_floats(out.direction, out.direction) - 1) < 1e-3F))
        out.reason = face->own ? NORMA_REASON_CANCELLED : NORMA_REASON_DEGENERATE;
    return out;
}

/* ---- the whole */

static void run_meshopt(meshopt_mesh *m, const tangent_output *output, core_tally *tally) {
    for (size_t f = 0; f < m->face_count; ++f) {
        m->faces[f] = face_of(
            meshopt_vertex(m, 3 * f), meshopt_vertex(m, 3 * f + 1), meshopt_vertex(m, 3 * f + 2));
        m->faces[f].stands = (uint32_t)f;
    }
    for (size_t c = 0; c < m->corner_count; ++c) m->group[c] = (uint32_t)c;
    for (size_t v = 0; v < m->around.position_count; ++v) {
        const uint32_t *corners = m->around.corners + m->around.starts[v];
        const size_t count = m->around.starts[v + 1] - m->around.starts[v];
        if (count <= FEW_CORNERS)
            join_few(m, corners, count);
        else
            join_many(m, corners, count);
    }
    memset(m->sums, 0, m->corner_count * sizeof *m->sums);
    sum_up_faces(m);
    for (size_t c = 0; c < m->corner_count; ++c) {
        const corner_tangent tangent = tangent_at(m, (uint32_t)c);
        norma_core_write_tangent(output, c, meshopt_vertex(m, c), &tangent, tally);
    }
}

norma_result norma_core_meshopt_tangents(
    const tangent_mesh *mesh, const tangent_output *output, core_tally *tally) {
    core_call *call = mesh->call;
    const size_t corners = mesh->mesh.corner_count;
    meshopt_mesh m = {.input = mesh, .corner_count = corners, .face_count = corners / 3};
    if (!corners) return NORMA_OK;
    if (mesh->mesh.face_starts) return NORMA_ERROR_ARGUMENT;
    norma_result result = norma_core_steady_stars(mesh, &m.vertex_of, &m.around);
    m.group = norma_core_allocate(call, corners, sizeof *m.group);
    m.sums = norma_core_allocate(call, corners, sizeof *m.sums);
    m.faces = norma_core_allocate(call, m.face_count, sizeof *m.faces);
    m.after = norma_core_allocate(call, m.around.most, sizeof *m.after);
    m.before = norma_core_allocate(call, m.around.most, sizeof *m.before);
    if (!result && !(m.group && m.sums && m.faces && m.after && m.before))
        result = NORMA_ERROR_MEMORY;
    if (!result) run_meshopt(&m, output, tally);
    norma_core_release(call, m.before, m.around.most, sizeof *m.before);
    norma_core_release(call, m.after, m.around.most, sizeof *m.after);
    norma_core_release(call, m.faces, m.face_count, sizeof *m.faces);
    norma_core_release(call, m.sums, corners, sizeof *m.sums);
    norma_core_release(call, m.group, corners, sizeof *m.group);
    norma_core_release(call, m.vertex_of, corners, sizeof *m.vertex_of);
    if (m.around.starts) norma_core_corners_of_position_release(call, &m.around);
    return result;
}
