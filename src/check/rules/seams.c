/* seams.c: N501: normals that differ along a seam. */
#include "check/rules/rules.h"
#include "core/face/face.h"
#include <math.h>
#include <string.h>

/* ---- The angle between the normals on both sides of a seam of UVs, colours or materials,
 * at positions where the surface itself is smooth; and the finding about them (N501). */

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

static int is_same_vertex(const seam_vertex *a, const seam_vertex *b) {
    return a->vertex == b->vertex && a->texcoord == b->texcoord && a->material == b->material &&
           a->normal == b->normal;
}

/* Distinct vertices at a position; 0 where there is but one, or too many. */
static size_t list_vertices(
    const check_mesh *m, const uint32_t *corners, size_t count, seam_vertex *vertices) {
    size_t distinct = 0;
    for (size_t i = 0; i < count; ++i) {
        seam_vertex v = vertex_of(m, corners[i]);
        size_t k = 0;
        while (k < distinct && !is_same_vertex(&vertices[k], &v)) ++k;
        if (k < distinct)
            ++vertices[k].faces;
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

static double seam_angle_between(const check_mesh *m, size_t first, size_t second) {
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
    for (size_t i = 0; i < count; ++i)
        for (size_t k = i + 1; k < count && vertices[i].faces > 1; ++k)
            if (vertices[k].faces > 1 && differ(m, &vertices[i], &vertices[k]))
                widest =
                    fmax(widest, seam_angle_between(m, vertices[i].normal, vertices[k].normal));
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
    for (size_t i = 0; i < count; ++i) {
        size_t face = norma_core_topology_face(t, corners[i]);
        if (t->partners[corners[i]] == CORE_EDGE_NONE) continue;
        if (!edge_is_smooth(m, corners[i]) ||
            !edge_is_smooth(m, norma_core_previous_kept(&t->mesh, face, corners[i])))
            return 0;
    }
    return 1;
}

static double check_seam_least(const char *encoding) {
    return fmax(LEAST_RAD, 2 * norma_check_encoding_bound(encoding));
}

/* How many edges along which no seam runs, or whose faces are shaded flat, bend by so many degrees,
 * and how many of them have different normals on both sides: what the file's own crease is. */
enum { SEAM_BENDS = 40 };
typedef struct seam_creases {
    size_t all[SEAM_BENDS], split[SEAM_BENDS], smooth[SEAM_BENDS];
} seam_creases;

/* ---- the file's own crease */

static double bend_deg(const check_mesh *m, size_t corner, size_t partner) {
    return norma_check_arc_cosine(
               fmax(-1, fmin(1, bend_cosine(face_at(m, corner), face_at(m, partner))))) *
           (180 / NORMA_PI);
}

/* The other face's corner at the position where an edge that is shared begins. */
static size_t corner_across(const check_mesh *m, size_t corner) {
    const core_topology *t = &m->topology;
    const uint32_t partner = t->partners[corner];
    return norma_core_topology_next(t, norma_core_topology_face(t, partner), partner);
}

typedef struct edge_end {
    int seam, split;
} edge_end;

static edge_end end_of(const check_mesh *m, size_t one, size_t other, double least) {
    const seam_vertex a = vertex_of(m, one), b = vertex_of(m, other);
    return (edge_end){differ(m, &a, &b), seam_angle_between(m, a.normal, b.normal) > least};
}

static int fits_face(const check_mesh *m, size_t corner, double least) {
    const size_t face = norma_core_topology_face(&m->topology, corner);
    return norma_check_cosine_to(m, face, norma_check_normal_of(m, face, corner)) > cos(least);
}

/* Both faces have their own direction as their normal, at both ends of the edge. */
static int edge_is_flat(const check_mesh *m, size_t corner, double least) {
    const size_t partner = m->topology.partners[corner];
    return fits_face(m, corner, least) && fits_face(m, partner, least) &&
           fits_face(m, corner_across(m, corner), least) &&
           fits_face(m, corner_across(m, partner), least);
}

/* An edge is split for another reason than a seam where no seam runs along it, or where both its
 * faces are shaded flat. The ends of one small strip look flat as well: they are outnumbered by the
 * edges within it, which are smooth. */
static void check_seam_creases(const check_mesh *m, double least, seam_creases *creases) {
    const core_topology *t = &m->topology;
    *creases = (seam_creases){{0}, {0}, {0}};
    for (size_t c = 0; c < t->mesh.corner_count; ++c) {
        const uint32_t partner = t->partners[c];
        if (partner >= CORE_EDGE_SPECIAL || partner < c || !norma_check_directed(face_at(m, c)) ||
            !norma_check_directed(face_at(m, partner)))
            continue;
        const double bend = bend_deg(m, c, partner);
        if (bend >= SEAM_BENDS) continue;
        const edge_end begin = end_of(m, c, corner_across(m, c), least),
                       end = end_of(m, corner_across(m, partner), partner, least);
        if ((begin.seam || end.seam) && !(begin.split && end.split && edge_is_flat(m, c, least)))
            continue;
        const size_t split = begin.split || end.split;
        creases->smooth[(size_t)bend] += !split;
        if (bend < least * (180 / NORMA_PI)) continue; /* even flat shading parts nothing there */
        ++creases->all[(size_t)bend];
        creases->split[(size_t)bend] += split;
    }
}

/* The most that an edge at the position bends along which a seam runs. */
static double seam_bend(const check_mesh *m, const uint32_t *corners, size_t count, double least) {
    double most = 0;
    for (size_t i = 0; i < count; ++i) {
        if (m->topology.partners[corners[i]] >= CORE_EDGE_SPECIAL) continue;
        const edge_end end = end_of(m, corners[i], corner_across(m, corners[i]), least);
        if (end.seam && end.split)
            most = fmax(most, bend_deg(m, corners[i], m->topology.partners[corners[i]]));
    }
    return most;
}

/* What the edges that bend as much, and that no seam runs along, say of one that it does. */
typedef enum seam_kind {
    SEAM_CREASE, /* most of them are split: it is meant */
    SEAM_SHOWN,  /* enough of them are smooth: it is not */
    SEAM_OPEN    /* too few of them to tell */
} seam_kind;

static seam_kind judge_seam(const seam_creases *creases, double bend) {
    enum { AROUND = 5, ENOUGH = 5 };
    const size_t middle = (size_t)bend, from = middle > AROUND ? middle - AROUND : 0;
    size_t all = 0, split = 0, smooth = 0;
    for (size_t i = from; i <= middle + AROUND && i < SEAM_BENDS; ++i) {
        all += creases->all[i];
        split += creases->split[i];
        smooth += creases->smooth[i];
    }
    return 2 * split > all ? SEAM_CREASE : smooth >= ENOUGH ? SEAM_SHOWN : SEAM_OPEN;
}

/* In radians; 0: no seam there, or a crease. Negative: it may be meant. */
static double check_seam_angle(
    const check_mesh *m, size_t position, double least, const seam_creases *creases) {
    const core_corners_of_position *around = &m->topology.corners_of;
    seam_vertex vertices[MOST_CORNERS];
    size_t count = around->starts[position + 1] - around->starts[position];
    const uint32_t *corners = &around->corners[around->starts[position]];
    if (count < 4 || count > MOST_CORNERS) return 0;
    const double angle = widest_seam(m, vertices, list_vertices(m, corners, count, vertices));
    if (!(angle > least) || !surface_is_smooth(m, corners, count)) return 0;
    const seam_kind kind =
        creases ? judge_seam(creases, seam_bend(m, corners, count, least)) : SEAM_SHOWN;
    return kind == SEAM_CREASE ? 0 : kind == SEAM_OPEN ? -angle : angle;
}

enum { SHOWN_SEAMS, OPEN_SEAMS }; /* hits; open: they may be meant */

static void hit_seam(const check_run *run, check_sum *seams, double angle, size_t vertex) {
    if (angle != 0)
        norma_check_hit(run, &seams->hits[angle > 0 ? SHOWN_SEAMS : OPEN_SEAMS],
            fabs(angle) * (180 / NORMA_PI), norma_check_vertex(vertex));
}

static norma_result add_seams_of(check_mesh *m, norma_severity severity, check_hits *hits) {
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N501, .severity = severity, .unit = "deg", .hits = hits},
        severity == NORMA_SEVERITY_INFO
            ? "a step in the shading, which may be meant: at %z position%s on seams normals "
              "differ, by up to %g degrees"
            : "a line is visible along a seam: at %z position%s normals differ, by up to %g "
              "degrees, although the surface is smooth",
        hits->count, norma_check_plural(hits->count), hits->worst);
}

/* A few positions make no line: all of them inform then. */
static norma_result check_add_seams(check_mesh *m, check_sum *seams) {
    enum { FEW = 4 };
    check_hits *shown = &seams->hits[SHOWN_SEAMS], *open = &seams->hits[OPEN_SEAMS];
    if (shown->count <= FEW) norma_check_hits_merge(m->run, open, shown);
    const norma_result result = add_seams_of(m, NORMA_SEVERITY_WARNING, shown);
    return result ? result : add_seams_of(m, NORMA_SEVERITY_INFO, open);
}

/* ---- N501 over the primitives of one glTF mesh together, since a seam of materials
 * runs between two of them: they are held until the last one has come, then joined to one mesh. A
 * position counts once, at the last primitive that has it. */

enum { JOINED_IN_BLOCK = 1 << 13 };

typedef struct joined {
    check_run *run;
    norma_check_mesh given;
    check_mesh m;
    check_joined whole;
    double *normals, *angles; /* angles: of a hit, at the vertex that stands for it; else 0 */
    float *texcoords, *colors;
    uint32_t *materials, *members; /* members: of each vertex */
    double least;
    const seam_creases *creases; /* NULL: not known yet */
} joined;

/* ---- the whole */

static int has_all(const check_group *group, int colors) {
    for (size_t i = 0; i < group->seam_count; ++i) {
        const norma_mesh_attributes *a = &group->seams[i]->given->attributes;
        if (colors ? !a->colors
                   : !a->texcoords || a->texcoord_count < group->seams[i]->mesh.positions.count)
            return 0;
    }
    return 1;
}

static norma_result open_joined(joined *j, int texcoords, int colors) {
    const core_call *call = &j->run->call;
    const size_t v = j->whole.mesh.positions.count, c = j->whole.mesh.corner_count;
    j->normals = norma_core_allocate(call, v, 3 * sizeof *j->normals);
    j->angles = norma_core_allocate(call, v, sizeof *j->angles);
    j->members = norma_core_allocate(call, v, sizeof *j->members);
    j->materials = norma_core_allocate(call, c / 3, sizeof *j->materials);
    j->texcoords = texcoords ? norma_core_allocate(call, v, 2 * sizeof *j->texcoords) : NULL;
    j->colors = colors ? norma_core_allocate(call, v, 4 * sizeof *j->colors) : NULL;
    const int fine = j->normals && j->angles && j->members && j->materials &&
                     (!texcoords || j->texcoords) && (!colors || j->colors);
    return fine ? NORMA_OK : NORMA_ERROR_MEMORY;
}

static void close_joined(joined *j) {
    const core_call *call = &j->run->call;
    const size_t v = j->whole.mesh.positions.count, c = j->whole.mesh.corner_count;
    norma_core_release(call, j->m.faces, j->m.mesh.face_count, sizeof *j->m.faces);
    if (j->m.has_topology) norma_core_topology_close(&j->m.topology);
    norma_core_release(call, j->colors, v, 4 * sizeof *j->colors);
    norma_core_release(call, j->texcoords, v, 2 * sizeof *j->texcoords);
    norma_core_release(call, j->materials, c / 3, sizeof *j->materials);
    norma_core_release(call, j->members, v, sizeof *j->members);
    norma_core_release(call, j->angles, v, sizeof *j->angles);
    norma_core_release(call, j->normals, v, 3 * sizeof *j->normals);
    norma_check_unjoin(&j->whole);
}

static void copy_member(joined *j, size_t number, size_t begin, size_t corner) {
    const check_mesh *member = j->run->group->seams[number];
    const norma_mesh_attributes *a = &member->given->attributes;
    const size_t count = member->mesh.positions.count;
    for (size_t v = 0; v < count; ++v) {
        norma_view_read(&member->given->data.normals, v, &j->normals[3 * (begin + v)]);
        j->members[begin + v] = (uint32_t)number;
    }
    if (j->texcoords && count)
        memcpy(&j->texcoords[2 * begin], a->texcoords, 2 * count * sizeof *j->texcoords);
    if (j->colors && count) memcpy(&j->colors[4 * begin], a->colors, 4 * count * sizeof *j->colors);
    for (size_t f = 0; f < member->mesh.face_count; ++f)
        j->materials[corner / 3 + f] =
            a->material < UINT32_MAX ? (uint32_t)a->material : UINT32_MAX;
}

static norma_result fill_joined(joined *j) {
    size_t vertex = 0, corner = 0;
    for (size_t i = 0; i < j->run->group->seam_count; ++i) {
        copy_member(j, i, vertex, corner);
        vertex += j->run->group->seams[i]->mesh.positions.count;
        corner += j->run->group->seams[i]->mesh.corner_count;
    }
    j->given.data.mesh = j->whole.mesh;
    j->given.data.normals = (norma_vec3_view){j->normals, vertex, 0, NORMA_FORMAT_DOUBLE};
    j->given.info.normals = NORMA_NORMALS_PER_VERTEX;
    j->given.attributes.face_materials = j->materials;
    j->given.attributes.texcoords = j->texcoords;
    j->given.attributes.texcoord_count = j->texcoords ? vertex : 0;
    j->given.attributes.colors = j->colors;
    j->m = (check_mesh){.run = j->run,
        .given = &j->given}; /* no rule is wanted: edges and the like are not told of again */
    return norma_core_mesh_shape(&j->given.data.mesh, &j->m.mesh);
}

/* ---- judging */

static void judge_joined_positions(void *context, size_t block, size_t begin, size_t end) {
    joined *j = context;
    const core_corners_of_position *around = &j->m.topology.corners_of;
    (void)block;
    for (size_t p = begin; p < end; ++p) {
        double angle = check_seam_angle(&j->m, p, j->least, j->creases);
        if (angle == 0) continue;
        size_t spot = 0, first = SIZE_MAX;
        for (size_t i = around->starts[p]; i < around->starts[p + 1]; ++i) {
            size_t v = norma_core_corner(&j->m.mesh, around->corners[i]);
            first = v < first ? v : first;
            if (i == around->starts[p] || j->members[v] > j->members[spot] ||
                (j->members[v] == j->members[spot] && v < spot))
                spot = v;
        }
        j->angles[spot] = angle;
    }
}

static norma_result add_members(const joined *j) {
    norma_result result = NORMA_OK;
    size_t begin = 0;
    for (size_t i = 0; i < j->run->group->seam_count && !result; ++i) {
        check_mesh *m = j->run->group->seams[i];
        check_sum seams = {.twice_area = 0};
        for (size_t v = 0; v < m->mesh.positions.count; ++v)
            hit_seam(j->run, &seams, j->angles[begin + v], v);
        begin += m->mesh.positions.count;
        result = check_add_seams(m, &seams);
    }
    return result;
}

static norma_result judge_all(joined *j) {
    memset(j->angles, 0, j->whole.mesh.positions.count * sizeof *j->angles);
    return norma_check_blocks(&j->run->call, j->m.topology.corners_of.position_count,
        JOINED_IN_BLOCK, judge_joined_positions, j);
}

static int has_any(const joined *j) {
    for (size_t v = 0; v < j->whole.mesh.positions.count; ++v)
        if (j->angles[v] != 0) return 1;
    return 0;
}

static norma_result judge_joined(joined *j) {
    seam_creases creases;
    norma_result result = fill_joined(j);
    if (!result) result = norma_check_faces(&j->m);
    if (!result) result = norma_check_pairs(&j->m);
    if (!result) result = judge_all(j);
    if (!result && has_any(j)) {
        check_seam_creases(&j->m, j->least, &creases);
        j->creases = &creases;
        result = judge_all(j);
    }
    return result ? result : add_members(j);
}

norma_result norma_check_seams_joined(check_run *run) {
    const check_group *group = run->group;
    joined j = {.run = run};
    if (!group->seam_count) return NORMA_OK;
    for (size_t i = 0; i < group->seam_count; ++i)
        j.least = fmax(j.least, check_seam_least(group->seams[i]->given->info.encoding));
    norma_result result = norma_check_join_held(group->seams, group->seam_count, &j.whole);
    if (result) return result;
    result = open_joined(&j, has_all(group, 0), has_all(group, 1));
    if (!result) result = judge_joined(&j);
    close_joined(&j);
    return result;
}

/* ---- N501: normals that differ across a seam of UVs, colours or materials in the middle of a
 * smooth surface. The primitives of one glTF mesh are judged together. */

enum { POSITIONS_IN_BLOCK = 1 << 13 };

typedef struct seam_pass {
    const check_mesh *m;
    double least;                /* radians */
    const seam_creases *creases; /* NULL: not known yet */
} seam_pass;

static void judge_seam_positions(const void *context, check_sum *part, size_t begin, size_t end) {
    const seam_pass *pass = context;
    const check_mesh *m = pass->m;
    for (size_t p = begin; p < end; ++p)
        hit_seam(m->run, part, check_seam_angle(m, p, pass->least, pass->creases), p);
}

static int can_be_joined(const check_mesh *m) {
    const norma_mesh_attributes *a = &m->given->attributes;
    int per_vertex = m->given->info.normals == NORMA_NORMALS_PER_VERTEX &&
                     !m->given->data.corner_normals &&
                     norma_check_normal_count(m) == m->mesh.positions.count;
    return per_vertex && !m->mesh.face_starts && !a->corner_texcoords && !a->face_materials;
}

/* The file's own crease is looked for only where there may be a seam. */
static norma_result judge_seams(check_mesh *m, check_sum *seams) {
    const size_t count = m->topology.corners_of.position_count;
    seam_pass pass = {m, check_seam_least(m->given->info.encoding), NULL};
    seam_creases creases;
    norma_result result =
        norma_check_gather(m->run, count, POSITIONS_IN_BLOCK, judge_seam_positions, &pass, seams);
    if (result || !seams->hits[SHOWN_SEAMS].count) return result;
    norma_check_sum_free(seams);
    check_seam_creases(m, pass.least, &creases);
    pass.creases = &creases;
    return norma_check_gather(
        m->run, count, POSITIONS_IN_BLOCK, judge_seam_positions, &pass, seams);
}

norma_result norma_check_seams(check_mesh *m) {
    const norma_mesh_attributes *a = &m->given->attributes;
    if (!m->mesh.face_count || !norma_check_wants(m, RULE_N501) || !norma_check_normal_count(m) ||
        m->given->info.normals == NORMA_NORMALS_PER_FACET ||
        (!m->siblings && !a->texcoords && !a->colors && !a->face_materials))
        return NORMA_OK;
    int other_frame = 0;
    norma_result result = NORMA_OK;
    if (m->siblings && can_be_joined(m)) {
        result = norma_check_is_of_another_frame(m, &other_frame);
        if (!result && !other_frame) m->run->group->seams[m->run->group->seam_count++] = m;
        return result;
    }
    result = norma_check_faces(m);
    if (!result) result = norma_check_pairs(m);
    if (result) return result;
    check_sum seams = {.twice_area = 0};
    result = judge_seams(m, &seams);
    const int any = seams.hits[SHOWN_SEAMS].count || seams.hits[OPEN_SEAMS].count;
    if (!result && any) result = norma_check_is_of_another_frame(m, &other_frame);
    if (!result && any && !other_frame) result = check_add_seams(m, &seams);
    norma_check_sum_free(&seams);
    return result;
}
