/* seam_angle.c: the angle between the normals on both sides of a seam of UVs, colours or materials,
 * at positions where the surface itself is smooth; and the finding about them (N501). */
#include "check/rules/seams.h"
#include "check/findings/angle.h"
#include "check/rules/facing.h"
#include "core/face/triangle.h"
#include <math.h>
#include <string.h>

enum { MOST_CORNERS = 1024 }; /* at one position; more are a hub, not a seam */
static const double LEAST_RAD = 0.017453292519943295; /* 1 degree */
static const double BEND_COSINE = 0.8660254037844386; /* of 30 degrees */

typedef struct seam_vertex {             /* corners that have all in common */
    uint32_t vertex, texcoord, material; /* texcoord: UINT32_MAX: the vertex's own */
    size_t normal, faces;
} seam_vertex;

static seam_vertex vertex_of(const check_mesh *m, size_t corner) {
    const norma_mesh_attributes *a = &m->given->attributes;
    size_t face = norma_core_topology_face(&m->topology, corner);
    return (seam_vertex){
        .vertex = norma_core_corner(&m->mesh, corner),
        .texcoord = a->corner_texcoords ? a->corner_texcoords[corner] : UINT32_MAX,
        .material = a->face_materials ? a->face_materials[face] : 0,
        .normal = norma_check_normal_of(m, face, corner),
        .faces = 1,
    };
}

static int is_same(const seam_vertex *a, const seam_vertex *b) {
    return a->vertex == b->vertex && a->texcoord == b->texcoord && a->material == b->material &&
           a->normal == b->normal;
}

/* Distinct vertices at a position; 0 where there is but one, or too many. */
static size_t list_vertices(
    const check_mesh *m, const uint32_t *corners, size_t count, seam_vertex *vertices) {
    size_t distinct = 0;
    for (size_t i = 0; i < count; i++) {
        seam_vertex v = vertex_of(m, corners[i]);
        size_t k = 0;
        while (k < distinct && !is_same(&vertices[k], &v)) k++;
        if (k < distinct)
            vertices[k].faces++;
        else
            vertices[distinct++] = v;
    }
    return distinct > 1 ? distinct : 0;
}

static int same_floats(const float *values, size_t width, size_t count, size_t a, size_t b) {
    if (!values || a == b) return 1;
    return a < count && b < count &&
           !memcmp(values + width * a, values + width * b, width * sizeof *values);
}

/* By UV, colour or material: a vertex of its own for a normal alone is a hard edge that somebody
 * made. */
static int differ(const check_mesh *m, const seam_vertex *a, const seam_vertex *b) {
    const norma_mesh_attributes *at = &m->given->attributes;
    size_t uv_a = at->corner_texcoords ? a->texcoord : a->vertex,
           uv_b = at->corner_texcoords ? b->texcoord : b->vertex;
    return a->material != b->material ||
           !same_floats(at->texcoords, 2, at->texcoord_count, uv_a, uv_b) ||
           !same_floats(at->colors, 4, m->mesh.positions.count, a->vertex, b->vertex);
}

static double angle_between(const check_mesh *m, size_t first, size_t second) {
    double a[3], b[3], cross[3];
    if (first == second || first == SIZE_MAX || second == SIZE_MAX) return 0;
    norma_check_normal(m, first, a);
    norma_check_normal(m, second, b);
    if (!norma_core_finite(a) || !norma_core_finite(b)) return 0;
    norma_core_cross(a, b, cross);
    return norma_core_angle(norma_core_length(cross), norma_core_dot(a, b));
}

static double widest_seam(const check_mesh *m, const seam_vertex *vertices, size_t count) {
    double widest = 0;
    for (size_t i = 0; i < count; i++)
        for (size_t k = i + 1; k < count && vertices[i].faces > 1; k++)
            if (vertices[k].faces > 1 && differ(m, &vertices[i], &vertices[k]))
                widest = fmax(widest, angle_between(m, vertices[i].normal, vertices[k].normal));
    return widest;
}

static double bend_cosine(const check_face *a, const check_face *b) {
    return (double)a->normal[0] * (double)b->normal[0] +
           (double)a->normal[1] * (double)b->normal[1] +
           (double)a->normal[2] * (double)b->normal[2];
}

static const check_face *face_at(const check_mesh *m, size_t corner) {
    return &m->faces[norma_core_topology_face(&m->topology, corner)];
}

/* Shared by two faces that have a direction, and bent by less than 30 degrees. */
static int edge_is_smooth(const check_mesh *m, size_t corner) {
    const uint32_t partner = m->topology.partners[corner];
    if (partner >= CORE_EDGE_SPECIAL) return partner == CORE_EDGE_NONE;
    const check_face *a = face_at(m, corner), *b = face_at(m, partner);
    return norma_check_directed(a) && norma_check_directed(b) && bend_cosine(a, b) > BEND_COSINE;
}

/* Every edge at the position: those that begin there, and those that end there, in the same faces.
 */
static int surface_is_smooth(const check_mesh *m, const uint32_t *corners, size_t count) {
    const core_topology *t = &m->topology;
    for (size_t i = 0; i < count; i++) {
        size_t face = norma_core_topology_face(t, corners[i]);
        if (t->partners[corners[i]] == CORE_EDGE_NONE) continue;
        if (!edge_is_smooth(m, corners[i]) ||
            !edge_is_smooth(m, norma_core_previous_kept(&t->mesh, face, corners[i])))
            return 0;
    }
    return 1;
}

double norma_check_seam_least(const char *encoding) {
    return fmax(LEAST_RAD, 2 * norma_check_encoding_bound(encoding));
}

/* ---- the file's own crease */

static double bend_deg(const check_mesh *m, size_t corner, size_t partner) {
    return norma_check_arc_cosine(
               fmax(-1, fmin(1, bend_cosine(face_at(m, corner), face_at(m, partner))))) *
           (180 / NORMA_PI);
}

/* The other face's corner at the position where an edge that is shared begins. */
static size_t across(const check_mesh *m, size_t corner) {
    const core_topology *t = &m->topology;
    const uint32_t partner = t->partners[corner];
    return norma_core_topology_next(t, norma_core_topology_face(t, partner), partner);
}

typedef struct edge_end {
    int seam, split;
} edge_end;

static edge_end end_of(const check_mesh *m, size_t one, size_t other, double least) {
    const seam_vertex a = vertex_of(m, one), b = vertex_of(m, other);
    return (edge_end){differ(m, &a, &b), angle_between(m, a.normal, b.normal) > least};
}

static int fits_face(const check_mesh *m, size_t corner, double least) {
    const size_t face = norma_core_topology_face(&m->topology, corner);
    return norma_check_cosine_to(m, face, norma_check_normal_of(m, face, corner)) > cos(least);
}

/* Both faces have their own direction as their normal, at both ends of the edge. */
static int edge_is_flat(const check_mesh *m, size_t corner, double least) {
    const size_t partner = m->topology.partners[corner];
    return fits_face(m, corner, least) && fits_face(m, partner, least) &&
           fits_face(m, across(m, corner), least) && fits_face(m, across(m, partner), least);
}

/* An edge is split for another reason than a seam where no seam runs along it, or where both its
 * faces are shaded flat. The ends of one small strip look flat as well: they are outnumbered by the
 * edges within it, which are smooth. */
void norma_check_seam_creases(const check_mesh *m, double least, seam_creases *creases) {
    const core_topology *t = &m->topology;
    *creases = (seam_creases){{0}, {0}};
    for (size_t c = 0; c < t->mesh.corner_count; c++) {
        const uint32_t partner = t->partners[c];
        if (partner >= CORE_EDGE_SPECIAL || partner < c || !norma_check_directed(face_at(m, c)) ||
            !norma_check_directed(face_at(m, partner)))
            continue;
        const double bend = bend_deg(m, c, partner);
        if (bend >= SEAM_BENDS || bend < least * (180 / NORMA_PI))
            continue; /* even flat shading
                     parts nothing there */
        const edge_end begin = end_of(m, c, across(m, c), least),
                       end = end_of(m, across(m, partner), partner, least);
        if ((begin.seam || end.seam) && !(begin.split && end.split && edge_is_flat(m, c, least)))
            continue;
        creases->all[(size_t)bend]++;
        creases->split[(size_t)bend] += begin.split || end.split;
    }
}

/* The most that an edge at the position bends along which a seam runs. */
static double seam_bend(const check_mesh *m, const uint32_t *corners, size_t count, double least) {
    double most = 0;
    for (size_t i = 0; i < count; i++) {
        if (m->topology.partners[corners[i]] >= CORE_EDGE_SPECIAL) continue;
        const edge_end end = end_of(m, corners[i], across(m, corners[i]), least);
        if (end.seam && end.split)
            most = fmax(most, bend_deg(m, corners[i], m->topology.partners[corners[i]]));
    }
    return most;
}

/* Most edges that bend as much are split although no seam runs along them. */
static int is_crease(const seam_creases *creases, double bend) {
    enum { AROUND = 5 };
    const size_t middle = (size_t)bend, from = middle > AROUND ? middle - AROUND : 0;
    size_t all = 0, split = 0;
    for (size_t i = from; i <= middle + AROUND && i < SEAM_BENDS; i++) {
        all += creases->all[i];
        split += creases->split[i];
    }
    return 2 * split > all;
}

double norma_check_seam_angle(
    const check_mesh *m, size_t position, double least, const seam_creases *creases) {
    const core_corners_of_position *around = &m->topology.corners_of;
    seam_vertex vertices[MOST_CORNERS];
    size_t count = around->starts[position + 1] - around->starts[position];
    const uint32_t *corners = &around->corners[around->starts[position]];
    if (count < 4 || count > MOST_CORNERS) return 0;
    const double angle = widest_seam(m, vertices, list_vertices(m, corners, count, vertices));
    if (!(angle > least) || !surface_is_smooth(m, corners, count)) return 0;
    return creases && is_crease(creases, seam_bend(m, corners, count, least)) ? 0 : angle;
}

norma_result norma_check_add_seams(check_mesh *m, check_hits *hits) {
    return norma_check_report(m,
        &(check_report){
            .rule = RULE_N501, .severity = NORMA_SEVERITY_WARNING, .unit = "deg", .hits = hits},
        "%z position%s on seams where normals differ, by up to %g degrees, although the surface is "
        "smooth; a line is visible there",
        hits->count, norma_check_plural(hits->count), hits->worst);
}
