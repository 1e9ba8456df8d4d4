/* fix_elements.c: faces, vertices and positions put right. */
#include "check/fix/fix.h"
#include "core/face/cut_polygon.h"
#include <stdlib.h>
#include <string.h>

/* ---- left out: faces that are there twice, faces without area. A face without area may still be
 * what joins its neighbours: where an edge that was closed would be open without it, it stays, and
 * so do those that share edges with it. */

/* Whether as many faces run along the edge one way as the other, all of them or those that stay. */
static int is_balanced(const fix_edge *edges, size_t count, const uint8_t *drop) {
    size_t forth = 0, back = 0;
    for (size_t i = 0; i < count; ++i) {
        if (drop && drop[edges[i].face]) continue;
        forth += edges[i].way != 0;
        back += edges[i].way == 0;
    }
    return forth == back;
}

static size_t same_edges(const fix_edge *edges, size_t begin, size_t count) {
    size_t end = begin + 1;
    while (end < count && norma_fix_compare_edges(&edges[begin], &edges[end]) == 0) ++end;
    return end - begin;
}

/* Takes the marks from groups of marked faces, joined by edges, without which the surface would be
 * less closed than it is. */
static void keep_joints(const fix_edge *edges, size_t count, uint32_t *groups, uint8_t *drop,
    uint8_t *needed, size_t face_count) {
    for (size_t begin = 0, of; begin < count; begin += of) {
        of = same_edges(edges, begin, count);
        size_t first = SIZE_MAX;
        for (size_t i = begin; i < begin + of; ++i) {
            if (!drop[edges[i].face]) continue;
            if (first != SIZE_MAX) norma_core_join_sets(groups, edges[first].face, edges[i].face);
            first = i;
        }
        if (first != SIZE_MAX && is_balanced(&edges[begin], of, NULL) &&
            !is_balanced(&edges[begin], of, drop))
            needed[edges[first].face] = 1;
    }
    for (size_t f = 0; f < face_count; ++f)
        if (needed[f]) needed[norma_core_set_of(groups, (uint32_t)f)] = 1;
    for (size_t f = 0; f < face_count; ++f)
        if (needed[norma_core_set_of(groups, (uint32_t)f)]) drop[f] = 0;
}

static norma_result keep_closed(const core_mesh *mesh, uint8_t *drop) {
    uint32_t *groups = malloc((mesh->face_count + 1) * sizeof *groups);
    fix_edge *edges = malloc((mesh->corner_count + 1) * sizeof *edges);
    uint8_t *needed = calloc(mesh->face_count + 1, 1);
    size_t count = 0;
    const int fine = groups && edges && needed;
    for (size_t f = 0; fine && f < mesh->face_count; ++f) {
        const size_t of = norma_fix_face_edges(mesh, f, (uint32_t)f, 0, edges + count);
        count += of < 3 ? 0 : of; /* fewer: it has no edges */
        groups[f] = (uint32_t)f;
    }
    if (fine) {
        qsort(edges, count, sizeof *edges, norma_fix_compare_edges);
        keep_joints(edges, count, groups, drop, needed, mesh->face_count);
    }
    free(groups);
    free(edges);
    free(needed);
    return fine ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* A primitive of a glTF would not be valid without any face. */
static void keep_one(const fix_mesh *m, uint8_t *drop) {
    const norma_file_format format = norma_document_format(m->document);
    if (norma_file_format_is_gltf(format) && !memchr(drop, 0, m->mesh.face_count)) drop[0] = 0;
}

/* Says which of the named faces stay, the first of them by their numbers. */
static void note_kept(const fix_mesh *m, const uint8_t *named, const uint8_t *drop) {
    enum { FEW = 10 };
    char list[CHECK_MESSAGE] = "", text[CHECK_MESSAGE];
    size_t kept = 0;
    for (size_t f = 0; f < m->mesh.face_count; ++f) {
        if (!named[f] || drop[f]) continue;
        if (kept < FEW) {
            norma_check_message(text, kept ? "%s, %z" : "%s%z", list, f);
            memcpy(list, text, sizeof list);
        }
        ++kept;
    }
    if (!kept) return;
    norma_check_message(text,
        "N401, N305: %z face%s kept%s%s, because closed edges would become open without %s, or it "
        "is the only face of a primitive: face%s %s%s",
        kept, kept == 1 ? " is" : "s are", *m->info.where ? " at " : "", m->info.where,
        kept == 1 ? "it" : "them", norma_check_plural(kept), list, kept > FEW ? ", ..." : "");
    norma_fix_note(m->plan, FIX_RULE(RULE_N401) | FIX_RULE(RULE_N305), text,
        "closed edges would become open, or a primitive would have no face");
}

norma_result norma_fix_faces(fix_mesh *m) {
    uint8_t *marks = NULL;
    const size_t faces = m->mesh.face_count;
    const int twice = norma_fix_mark(m, RULE_N305, MEND_FACE, faces, &marks),
              flat = twice < 0 ? twice : norma_fix_mark(m, RULE_N401, MEND_FACE, faces, &marks);
    norma_result result = twice < 0 || flat < 0 ? NORMA_ERROR_MEMORY : NORMA_OK;
    uint8_t *named = !result && marks ? malloc(faces + 1) : NULL;
    if (named) memcpy(named, marks, faces);
    if (!result && marks) result = named ? keep_closed(&m->mesh, marks) : NORMA_ERROR_MEMORY;
    if (!result && marks) keep_one(m, marks);
    if (!result && marks) note_kept(m, named, marks);
    free(named);
    if (!result && marks && memchr(marks, 1, faces))
        m->edit->drop_faces = marks;
    else
        free(marks);
    return result;
}

/* ---- Polygons that readers would cut wrong or differently (N404, N405) are cut into
 * triangles that do not fold (core/face/cut_polygon.h). Polygons that cross themselves have no such
 * triangles and stay as they are. */

/* triangles: corners of count - 2 triangles, numbered from the first of the face. 0: the face
 * cannot be cut well, or not in time. */
static int cut_named_face(
    const fix_mesh *m, size_t face, core_cutter *cutter, uint32_t *triangles) {
    const size_t begin = norma_core_face_begin(&m->mesh, face),
                 count = norma_core_face_end(&m->mesh, face) - begin;
    for (size_t i = 0; i < count; ++i)
        norma_core_position(&m->mesh, norma_core_corner(&m->mesh, begin + i), cutter->points[i]);
    return count > 3 && norma_core_cut_polygon(cutter, count, triangles) == count - 2;
}

static size_t corners_of_largest(const core_mesh *mesh) {
    size_t largest = 0;
    for (size_t face = 0; face < mesh->face_count; ++face) {
        const size_t corners = norma_core_face_end(mesh, face) - norma_core_face_begin(mesh, face);
        largest = corners > largest ? corners : largest;
    }
    return largest;
}

static norma_result cut_named(fix_mesh *m, const uint8_t *marks) {
    const size_t largest = corners_of_largest(&m->mesh);
    core_cutter cutter;
    void *memory = malloc(norma_core_cutter_size(largest));
    uint8_t *cut = calloc(m->mesh.face_count + 1, 1);
    uint32_t *triangles = calloc(3 * m->mesh.corner_count + 1, sizeof *triangles);
    const int fine = memory && cut && triangles;
    int any = 0;
    if (fine) norma_core_cutter_begin(&cutter, memory, largest, m->mesh.corner_count);
    for (size_t face = 0; face < m->mesh.face_count && fine; ++face)
        if (marks[face] && !(m->edit->drop_faces && m->edit->drop_faces[face]))
            any |= cut[face] = (uint8_t)cut_named_face(
                m, face, &cutter, triangles + 3 * norma_core_face_begin(&m->mesh, face));
    if (any) {
        m->edit->cut_faces = cut;
        m->edit->cut_corners = triangles;
    } else {
        free(cut);
        free(triangles);
    }
    free(memory);
    return fine ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* Where faces are reversed as well, that comes first: the cut waits for the next time. */
norma_result norma_fix_polygons(fix_mesh *m) {
    uint8_t *marks = NULL;
    const norma_file_format format = norma_document_format(m->document);
    if (m->edit->reverse_faces || (format != NORMA_FILE_OBJ && format != NORMA_FILE_PLY))
        return NORMA_OK;
    int folded = norma_fix_mark(m, RULE_N404, MEND_FACE, m->mesh.face_count, &marks);
    int bent =
        folded < 0 ? folded : norma_fix_mark(m, RULE_N405, MEND_FACE, m->mesh.face_count, &marks);
    norma_result result = folded < 0 || bent < 0 ? NORMA_ERROR_MEMORY
                          : folded || bent       ? cut_named(m, marks)
                                                 : NORMA_OK;
    free(marks);
    return result;
}

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
    for (size_t i = 0; i < count; ++i)
        if (marks[i]) meant[norma_core_welded(mesh, (uint32_t)i)] = 1;
    for (size_t i = 0; i < count; ++i) {
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
    for (size_t face = 0; face < m->mesh.face_count; ++face) {
        core_face geometry;
        norma_core_face_geometry(&m->mesh, face, &geometry);
        if (!(norma_core_dot(geometry.normal, geometry.normal) > 0)) continue;
        for (size_t c = norma_core_face_begin(&m->mesh, face);
             c < norma_core_face_end(&m->mesh, face); ++c) {
            vertex_sum *sum = &sums[first ? first[norma_core_corner(&m->mesh, c)]
                                          : norma_core_corner(&m->mesh, c)];
            if (!norma_core_is_kept(&m->mesh, face, c)) continue;
            double weight =
                norma_core_corner_weight(&m->mesh, NORMA_WEIGHT_ANGLE, face, &geometry, c);
            for (int k = 0; k < 3; ++k) sum->normals[k] += weight * geometry.normal[k];
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
    for (size_t v = 0; v < count; ++v) {
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
    for (size_t v = 0; v < count; ++v) {
        if (first[v] == v) sources[next++] = (uint32_t)v;
        first[v] =
            first[v] == v
                ? (uint32_t)next - 1
                : first[first[v]]; /* its new number; the least comes before those that equal it */
    }
    for (size_t c = 0; c < m->mesh.corner_count; ++c)
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
    for (int k = 0; k < 3; ++k)
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
        for (size_t v = 0; marks && v < count; ++v)
            marks[v] = (uint8_t)(marks[v] || cancels(&sums[v], CANCELLED));
    }
    free(sums);
    return marks;
}

/* The corners at marked vertices, fan by fan. NULL: out of memory. */
static fan_corner *gather_fans(
    const fix_mesh *m, const uint8_t *marks, const float *normals, size_t *count) {
    size_t room = 0;
    for (size_t c = 0; c < m->mesh.corner_count; ++c) room += marks[norma_core_corner(&m->mesh, c)];
    fan_corner *fans = malloc((room + 1) * sizeof *fans);
    *count = 0;
    for (size_t c = 0; fans && c < m->mesh.corner_count; ++c) {
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
    for (size_t i = 1; i < count; ++i)
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
    for (size_t v = 0; v < vertices; ++v) to->sources[v] = (uint32_t)v;
    for (size_t c = 0; c < m->mesh.corner_count; ++c)
        to->corners[c] = norma_core_corner(&m->mesh, c);
    for (size_t i = 0; i < count; ++i) {
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
        for (end = begin + 1; end < count && fans[end].vertex == fans[begin].vertex; ++end)
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
