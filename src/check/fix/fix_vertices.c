/* fix_vertices.c: vertices and positions put right. */
#include "check/fix/fix.h"
#include "core/call/call.h"
#include "core/mesh/mesh.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Positions that are almost equal made equal (N503): all of a cluster become the
 * one of the least number. */

static const double NEAR = 1e-6; /* of the diagonal, as the rule has it */

/* The clusters in which a marked position lies. */
static norma_result snap(fix_mesh *m, const core_mesh *mesh, const uint8_t *marks) {
    size_t count = mesh->positions.count;
    uint8_t *meant = calloc(count + 1, 1), *set = calloc(count + 1, 1);
    double *positions = malloc((count + 1) * 3 * sizeof *positions);
    m->edit->positions = positions;
    m->edit->set_positions = set;
    if (!meant || !set || !positions) {
        free(meant);
        return NORMA_ERROR_MEMORY;
    }
    for (size_t i = 0; i < count; i++)
        if (marks[i]) meant[norma_core_welded(mesh, (uint32_t)i)] = 1;
    for (size_t i = 0; i < count; i++) {
        double own[3];
        uint32_t least = norma_core_welded(mesh, (uint32_t)i);
        norma_core_position(mesh, least, positions + 3 * i);
        norma_core_position(mesh, (uint32_t)i, own);
        set[i] = meant[least] && memcmp(own, positions + 3 * i, sizeof own) != 0;
    }
    free(meant);
    return NORMA_OK;
}

norma_result norma_fix_positions(fix_mesh *m) {
    uint8_t *marks = NULL;
    core_mesh mesh = m->mesh;
    core_call call;
    const int is_3mf = norma_document_format(m->document) == NORMA_FILE_3MF; /* keeps its numbers */
    int any = is_3mf ? 0 : norma_fix_mark(m, RULE_N503, MEND_VERTEX, mesh.positions.count, &marks);
    const norma_options options = {.struct_size = sizeof options,
        .weld = NORMA_WELD_DISTANCE,
        .weld_distance = any > 0 ? NEAR * norma_check_diagonal(&mesh) : 0,
        .threads = m->threads};
    norma_result result = any < 0 ? NORMA_ERROR_MEMORY : norma_core_begin(&call, &options);
    if (!result && any > 0) {
        result = norma_core_weld(&call, &mesh);
        if (!result) result = snap(m, &mesh, marks);
        if (mesh.weld) norma_core_unweld(&call, &mesh);
    }
    free(marks);
    return result;
}

/* ---- Vertices put right: those of a soup that are equal in everything become one
 * (N502), where the faces around them do not look so many ways that their average would be no
 * direction; where they do (N403), the corners of each fan get a vertex of their own, a copy in all
 * but the normal. A step of its own, when nothing else is left to edit in the mesh. */

/* What N403 minds, and what a weld keeps away from. */
static const double CANCELLED = 1e-3, NEARLY_CANCELLED = 2e-3;
static const float SHARPEST_FAN_RAD =
    1.0471976f; /* 60 degrees: with no crease at all some fans would cancel as their vertex does */

typedef struct vertex_sum {
    double normals[3], weights;
} vertex_sum;

/* ---- how much of the normals around a vertex is left in their sum, by angle, as N403 measures */

/* first: the vertex that each is or would become; NULL: itself. */
static void add_corners_of_vertices(const fix_mesh *m, const uint32_t *first, vertex_sum *sums) {
    for (size_t face = 0; face < m->mesh.face_count; face++) {
        core_face geometry;
        norma_core_face_geometry(&m->mesh, face, &geometry);
        if (!(norma_core_dot(geometry.normal, geometry.normal) > 0)) continue;
        for (size_t c = norma_core_face_begin(&m->mesh, face);
             c < norma_core_face_end(&m->mesh, face); c++) {
            vertex_sum *sum = &sums[first ? first[norma_core_corner(&m->mesh, c)]
                                          : norma_core_corner(&m->mesh, c)];
            if (!norma_core_is_kept(&m->mesh, face, c)) continue;
            double weight =
                norma_core_corner_weight(&m->mesh, NORMA_WEIGHT_ANGLE, face, &geometry, c);
            for (int k = 0; k < 3; k++) sum->normals[k] += weight * geometry.normal[k];
            sum->weights += weight;
        }
    }
}

static int cancels(const vertex_sum *sum, double limit) {
    return sum->weights > 0 && !(norma_core_length(sum->normals) >= limit * sum->weights);
}

/* ---- weld */

/* The least of those that become one, of each; the number of vertices that go. */
static size_t part_cancelled(const vertex_sum *sums, size_t count, uint32_t *first) {
    size_t gone = 0;
    for (size_t v = 0; v < count; v++) {
        if (cancels(&sums[first[v]], NEARLY_CANCELLED)) first[v] = (uint32_t)v;
        gone += first[v] != v;
    }
    return gone;
}

static norma_result put_welded(fix_mesh *m, size_t count, size_t left, uint32_t *first) {
    uint32_t *sources = malloc((left + 1) * sizeof *sources),
             *corners = malloc((m->mesh.corner_count + 1) * sizeof *corners);
    size_t next = 0;
    if (!sources || !corners) {
        free(sources);
        free(corners);
        return NORMA_ERROR_MEMORY;
    }
    for (size_t v = 0; v < count; v++) {
        if (first[v] == v) sources[next++] = (uint32_t)v;
        first[v] =
            first[v] == v
                ? (uint32_t)next - 1
                : first[first[v]]; /* its new number; the least comes before those that equal it */
    }
    for (size_t c = 0; c < m->mesh.corner_count; c++)
        corners[c] = first[norma_core_corner(&m->mesh, c)];
    m->edit->source_vertices = sources;
    m->edit->vertex_count = left;
    m->edit->new_corners = corners;
    return NORMA_OK;
}

static norma_result weld(fix_mesh *m) {
    const size_t count = m->data.mesh.positions.count;
    uint32_t *first = malloc((count + 1) * sizeof *first);
    vertex_sum *sums = calloc(count + 1, sizeof *sums);
    const norma_document_result compared =
        first && sums ? norma_document_equal_vertices(m->document, m->index, first, NULL)
                      : NORMA_DOCUMENT_ERROR_MEMORY;
    norma_result result =
        compared == NORMA_DOCUMENT_ERROR_UNSUPPORTED
            ? NORMA_OK
            : NORMA_ERROR_MEMORY; /* more than such a file may stand for: the soup stays */
    if (compared == NORMA_DOCUMENT_OK) {
        add_corners_of_vertices(m, first, sums);
        size_t gone = part_cancelled(sums, count, first);
        result = gone ? put_welded(m, count, count - gone, first) : NORMA_OK;
    }
    free(first);
    free(sums);
    return result;
}

/* ---- split */

typedef struct fan_corner {
    float normal[3];
    uint32_t vertex, corner;
} fan_corner;

static int compare_normals(const float a[3], const float b[3]) {
    for (int k = 0; k < 3; k++)
        if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
    return 0;
}

static int fan_corner_is_less(const void *first, const void *second) {
    const fan_corner *a = first, *b = second;
    int order = compare_normals(a->normal, b->normal);
    return a->vertex != b->vertex ? a->vertex < b->vertex
           : order                ? order < 0
                                  : a->corner < b->corner;
}

static int same_fan(const fan_corner *a, const fan_corner *b) {
    return a->vertex == b->vertex && compare_normals(a->normal, b->normal) == 0;
}

/* The normal of each corner's fan: with the crease that the stored normals show, where it is sharp
 * enough. */
static norma_result find_vertex_fans(fix_mesh *m, float *normals) {
    norma_result result = norma_fix_surface(m); /* for what they show */
    const norma_options options = {.struct_size = sizeof options,
        .weight = m->deviation.weight,
        .non_manifold = NORMA_NON_MANIFOLD_HARD,
        .fallback = NORMA_FALLBACK_NEAREST,
        .threads = m->threads};
    const int sharp = m->deviation.shading == NORMA_SHADING_CREASE &&
                      m->deviation.crease_angle_rad < (double)SHARPEST_FAN_RAD;
    const float crease = m->deviation.shading == NORMA_SHADING_FLAT ? -1.0f
                         : sharp ? (float)m->deviation.crease_angle_rad
                                 : SHARPEST_FAN_RAD;
    const norma_mesh now = norma_fix_mesh_now(m);
    return result
               ? result
               : norma_corner_normals(&now, crease, &options, normals, m->mesh.corner_count, NULL);
}

/* Those that are named, and, since a position is named but once, all others of which the same is
 * so. NULL: out of memory. */
static uint8_t *mark_cancelled(const fix_mesh *m) {
    const size_t count = m->data.mesh.positions.count;
    vertex_sum *sums = calloc(count + 1, sizeof *sums);
    uint8_t *marks = NULL;
    if (sums && norma_fix_mark(m, RULE_N403, MEND_VERTEX, count, &marks) >= 0) {
        add_corners_of_vertices(m, NULL, sums);
        for (size_t v = 0; marks && v < count; v++)
            marks[v] = (uint8_t)(marks[v] || cancels(&sums[v], CANCELLED));
    }
    free(sums);
    return marks;
}

/* The corners at marked vertices, fan by fan. NULL: out of memory. */
static fan_corner *gather_fans(
    const fix_mesh *m, const uint8_t *marks, const float *normals, size_t *count) {
    size_t room = 0;
    for (size_t c = 0; c < m->mesh.corner_count; c++) room += marks[norma_core_corner(&m->mesh, c)];
    fan_corner *fans = malloc((room + 1) * sizeof *fans);
    *count = 0;
    for (size_t c = 0; fans && c < m->mesh.corner_count; c++) {
        fan_corner corner = {.vertex = norma_core_corner(&m->mesh, c), .corner = (uint32_t)c};
        memcpy(corner.normal, normals + 3 * c, sizeof corner.normal);
        if (marks[corner.vertex]) fans[(*count)++] = corner;
    }
    if (fans) norma_core_sort(fans, *count, sizeof *fans, fan_corner_is_less);
    return fans;
}

/* How many vertices are to be added: at each one less than it has fans. */
static size_t count_added(const fan_corner *fans, size_t count) {
    size_t added = 0;
    for (size_t i = 1; i < count; i++)
        added += fans[i].vertex == fans[i - 1].vertex && !same_fan(&fans[i], &fans[i - 1]);
    return added;
}

/* Its tangent is made perpendicular to the normal. */
static void set_tangent(
    fix_mesh *m, size_t to, const fan_corner *from, float *tangents, uint8_t *set) {
    const norma_vec3_view normal = {.data = from->normal, .count = 1, .format = NORMA_FORMAT_FLOAT};
    norma_orthogonalise_tangents(
        m->attributes.tangents + 4 * (size_t)from->vertex, 0, normal, 1, tangents + 4 * to, 0, 1);
    set[to] = 1;
}

typedef struct split_arrays {
    uint32_t *sources, *corners;
    float *normals, *tangents;
    uint8_t *set_normals, *set_tangents; /* NULL, like their numbers, where there are none */
} split_arrays;

/* They are the edit's, also where some are missing. */
static int make_arrays(fix_mesh *m, size_t count, split_arrays *to) {
    const int has_normals =
                  norma_fix_normal_count(m) > 0 && m->info.normals == NORMA_NORMALS_PER_VERTEX,
              has_tangents = has_normals && m->attributes.tangents != NULL;
    norma_mesh_edit *edit = m->edit;
    edit->source_vertices = to->sources = malloc(count * sizeof *to->sources);
    edit->new_corners = to->corners = malloc((m->mesh.corner_count + 1) * sizeof *to->corners);
    edit->normals = to->normals = has_normals ? calloc(count, 3 * sizeof *to->normals) : NULL;
    edit->set_normals = to->set_normals = has_normals ? calloc(count, 1) : NULL;
    edit->tangents = to->tangents = has_tangents ? calloc(count, 4 * sizeof *to->tangents) : NULL;
    edit->set_tangents = to->set_tangents = has_tangents ? calloc(count, 1) : NULL;
    edit->vertex_count = count;
    return to->sources && to->corners && (!has_normals || (to->normals && to->set_normals)) &&
           (!has_tangents || (to->tangents && to->set_tangents));
}

/* The first fan of a vertex keeps its number, others follow behind all. */
static void fill_arrays(fix_mesh *m, const fan_corner *fans, size_t count, split_arrays *to) {
    const size_t vertices = m->data.mesh.positions.count;
    size_t next = vertices, number = 0;
    for (size_t v = 0; v < vertices; v++) to->sources[v] = (uint32_t)v;
    for (size_t c = 0; c < m->mesh.corner_count; c++)
        to->corners[c] = norma_core_corner(&m->mesh, c);
    for (size_t i = 0; i < count; i++) {
        const int another = i > 0 && fans[i].vertex == fans[i - 1].vertex,
                  begins = i == 0 || !same_fan(&fans[i], &fans[i - 1]);
        if (begins) number = another ? next++ : fans[i].vertex;
        to->corners[fans[i].corner] = (uint32_t)number;
        to->sources[number] = fans[i].vertex;
        if (begins && to->normals) {
            memcpy(to->normals + 3 * number, fans[i].normal, sizeof fans[i].normal);
            to->set_normals[number] = 1;
        }
        if (begins && to->tangents)
            set_tangent(m, number, &fans[i], to->tangents, to->set_tangents);
    }
}

/* Vertices of one fan alone are left as they are. */
static size_t drop_single(fan_corner *fans, size_t count) {
    size_t kept = 0;
    for (size_t begin = 0, end; begin < count; begin = end) {
        int several = 0;
        for (end = begin + 1; end < count && fans[end].vertex == fans[begin].vertex; end++)
            several |= !same_fan(&fans[end], &fans[begin]);
        if (several) memmove(fans + kept, fans + begin, (end - begin) * sizeof *fans);
        kept += several ? end - begin : 0;
    }
    return kept;
}

static norma_result split(fix_mesh *m) {
    float *normals = malloc((m->mesh.corner_count + 1) * 3 * sizeof *normals);
    uint8_t *marks = mark_cancelled(m);
    fan_corner *fans = NULL;
    size_t count = 0;
    norma_result result = normals && marks ? find_vertex_fans(m, normals) : NORMA_ERROR_MEMORY;
    if (!result) {
        fans = gather_fans(m, marks, normals, &count);
        result = fans ? NORMA_OK : NORMA_ERROR_MEMORY;
    }
    count = result ? 0 : drop_single(fans, count);
    if (count > 0) {
        split_arrays to;
        if (make_arrays(m, m->data.mesh.positions.count + count_added(fans, count), &to))
            fill_arrays(m, fans, count, &to);
        else
            result = NORMA_ERROR_MEMORY;
    }
    free(normals);
    free(marks);
    free(fans);
    return result;
}

/* ---- all of it */

static int has_vertices(const fix_mesh *m) {
    const norma_file_format format = norma_document_format(m->document);
    return norma_file_format_is_gltf(format) || format == NORMA_FILE_PLY ||
           format == NORMA_FILE_OBJ;
}

/* Vertices without normals, or normals without vertices, are another rule's (N106), which comes
 * first. */
norma_result norma_fix_vertices(fix_mesh *m) {
    const int soup = norma_fix_has(m, RULE_N502), cancelled = norma_fix_has(m, RULE_N403);
    if ((!soup && !cancelled) || !has_vertices(m) || m->attributes.normals_missing ||
        m->attributes.normals_surplus)
        return NORMA_OK;
    if (norma_fix_has_edit(m->edit)) return NORMA_OK; /* the next time */
    norma_result result = soup ? weld(m) : NORMA_OK;
    if (result || !cancelled) return result;
    return m->edit->source_vertices ? NORMA_OK : split(m); /* or the next time */
}
