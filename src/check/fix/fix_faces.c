/* fix_faces.c: faces put right: windings, faces left out, polygons cut. */
#include "check/fix/fix.h"
#include "core/face/cut_polygon.h"
#include "core/topology/topology.h"
#include <stdlib.h>
#include <string.h>

/* ---- Faces put right: windings made to agree (norma_orient), whole bodies turned
 * (turn_bodies.c), faces left out that are there twice or have no area. */

/* ---- parts of a surface: faces that edges join, by exactly equal positions */

/* For each face the least face of its part. NULL: out of memory. */
static uint32_t *find_parts(const core_mesh *mesh) {
    uint32_t *parents = malloc((mesh->face_count + 1) * sizeof *parents);
    fix_edge *edges = malloc((mesh->corner_count + 1) * sizeof *edges);
    if (!parents || !edges) {
        free(parents);
        free(edges);
        return NULL;
    }
    for (size_t face = 0; face < mesh->face_count; face++) parents[face] = (uint32_t)face;
    size_t count = 0;
    for (size_t face = 0; face < mesh->face_count; face++)
        count += norma_fix_face_edges(mesh, face, (uint32_t)face, 0, edges + count);
    qsort(edges, count, sizeof *edges, norma_fix_compare_edges);
    for (size_t i = 1; i < count; i++)
        if (norma_fix_compare_edges(&edges[i - 1], &edges[i]) == 0)
            norma_fix_unite(parents, edges[i - 1].face, edges[i].face);
    for (size_t face = 0; face < mesh->face_count; face++)
        parents[face] = norma_fix_root(parents, (uint32_t)face);
    free(edges);
    return parents;
}

/* ---- windings */

static void note_undecided(const fix_mesh *m, check_rule rule, size_t faces) {
    static const char why[] = "neither volume nor rays show which side is outward";
    char text[CHECK_MESSAGE];
    const norma_rule *rules = norma_rules(NULL);
    norma_check_message(text, "%s %s is not fixed%s%s for %z face%s: %s", rules[rule].id,
        rules[rule].name, *m->info.where ? " at " : "", m->info.where, faces,
        norma_check_plural(faces), why);
    norma_fix_note(m->plan, FIX_RULE(rule), text, why);
}

static int is_shown(const fix_mesh *m, size_t face) {
    return (m->sides[face] & (CORE_SIDE_TURNED | CORE_SIDE_UNDECIDED)) == CORE_SIDE_TURNED;
}

/* A part that is turned as a whole is not what N301 asks for, unless it names one of its faces:
 * then it is wound against another primitive. */
static void leave_whole_parts(const fix_mesh *m, const uint32_t *parts, uint8_t *reverse) {
    uint8_t *stays = calloc(m->mesh.face_count + 1, 1), *named = NULL;
    const int any = norma_fix_mark(m, RULE_N301, MEND_FACE, m->mesh.face_count, &named);
    for (size_t face = 0; stays && face < m->mesh.face_count; face++)
        if (!reverse[face] || (any > 0 && named[face])) stays[parts[face]] = 1;
    for (size_t face = 0; stays && face < m->mesh.face_count; face++)
        reverse[face] &= stays[parts[face]];
    free(named);
    free(stays);
}

/* Those that are shown to be turned: of parts that disagree with themselves (N301). */
static norma_result reverse_turned(const fix_mesh *m, uint8_t *reverse) {
    uint32_t *parts = find_parts(&m->mesh);
    size_t undecided = 0;
    if (!parts) return NORMA_ERROR_MEMORY;
    for (size_t face = 0; face < m->mesh.face_count; face++) {
        reverse[face] = (uint8_t)is_shown(m, face);
        undecided += m->sides[face] & CORE_SIDE_TURNED && m->sides[face] & CORE_SIDE_UNDECIDED;
    }
    leave_whole_parts(m, parts, reverse);
    free(parts);
    if (undecided) note_undecided(m, RULE_N301, undecided);
    return NORMA_OK;
}

/* The parts of faces whose winding is shown to be wrong, and whose normals are right (N201): all
 * that is turned in them, so that they still agree. */
static norma_result reverse_opposed(const fix_mesh *m, uint8_t *reverse) {
    uint8_t *named = NULL;
    const size_t faces = m->mesh.face_count;
    const int any = norma_fix_mark(m, RULE_N201, MEND_FACE, faces, &named);
    uint32_t *parts = any > 0 ? find_parts(&m->mesh) : NULL;
    uint8_t *opposed = any > 0 ? calloc(faces + 1, 1) : NULL;
    const int fine = any == 0 || (parts && opposed);
    size_t undecided = 0;
    for (size_t face = 0; face < faces && any > 0 && fine; face++) {
        if (!named[face]) continue;
        undecided += (m->sides[face] & CORE_SIDE_UNDECIDED) != 0;
        if (is_shown(m, face)) opposed[parts[face]] = 1;
    }
    for (size_t face = 0; face < faces && any > 0 && fine; face++)
        if (opposed[parts[face]] && is_shown(m, face)) reverse[face] = 1;
    if (undecided && fine) note_undecided(m, RULE_N201, undecided);
    free(named);
    free(parts);
    free(opposed);
    return fine ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* A body that is turned as a whole (N302, N304) is turned once, whatever else names its faces. */
static norma_result reorient(fix_mesh *m) {
    const int alike = norma_fix_has(m, RULE_N301), opposed = norma_fix_has(m, RULE_N201);
    int any = 0;
    if (!alike && !opposed && !m->turned) return NORMA_OK;
    uint8_t *reverse = calloc(m->mesh.face_count + 1, 1);
    norma_result result = reverse ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result && alike && m->sides) result = reverse_turned(m, reverse);
    if (!result && opposed && m->sides) result = reverse_opposed(m, reverse);
    for (size_t face = 0; face < m->mesh.face_count && !result; face++) {
        if (m->turned && m->turned[face]) reverse[face] = !m->sides || is_shown(m, face);
        any |= reverse[face];
    }
    if (any && !result)
        m->edit->reverse_faces = reverse;
    else
        free(reverse);
    return result;
}

/* ---- left out: faces that are there twice, faces without area. A face without area may still be
 * what joins its neighbours: where an edge that was closed would be open without it, it stays, and
 * so do those that share edges with it. */

/* Whether as many faces run along the edge one way as the other, all of them or those that stay. */
static int is_balanced(const fix_edge *edges, size_t count, const uint8_t *drop) {
    size_t forth = 0, back = 0;
    for (size_t i = 0; i < count; i++) {
        if (drop && drop[edges[i].face]) continue;
        forth += edges[i].way != 0;
        back += edges[i].way == 0;
    }
    return forth == back;
}

static size_t same_edges(const fix_edge *edges, size_t begin, size_t count) {
    size_t end = begin + 1;
    while (end < count && norma_fix_compare_edges(&edges[begin], &edges[end]) == 0) end++;
    return end - begin;
}

/* Takes the marks from groups of marked faces, joined by edges, without which the surface would be
 * less closed than it is. */
static void keep_joints(const fix_edge *edges, size_t count, uint32_t *groups, uint8_t *drop,
    uint8_t *needed, size_t face_count) {
    for (size_t begin = 0, of; begin < count; begin += of) {
        of = same_edges(edges, begin, count);
        size_t first = SIZE_MAX;
        for (size_t i = begin; i < begin + of; i++) {
            if (!drop[edges[i].face]) continue;
            if (first != SIZE_MAX) norma_fix_unite(groups, edges[first].face, edges[i].face);
            first = i;
        }
        if (first != SIZE_MAX && is_balanced(&edges[begin], of, NULL) &&
            !is_balanced(&edges[begin], of, drop))
            needed[edges[first].face] = 1;
    }
    for (size_t f = 0; f < face_count; f++)
        if (needed[f]) needed[norma_fix_root(groups, (uint32_t)f)] = 1;
    for (size_t f = 0; f < face_count; f++)
        if (needed[norma_fix_root(groups, (uint32_t)f)]) drop[f] = 0;
}

static norma_result keep_closed(const core_mesh *mesh, uint8_t *drop) {
    uint32_t *groups = malloc((mesh->face_count + 1) * sizeof *groups);
    fix_edge *edges = malloc((mesh->corner_count + 1) * sizeof *edges);
    uint8_t *needed = calloc(mesh->face_count + 1, 1);
    size_t count = 0;
    const int fine = groups && edges && needed;
    for (size_t f = 0; fine && f < mesh->face_count; f++) {
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
    for (size_t f = 0; f < m->mesh.face_count; f++) {
        if (!named[f] || drop[f]) continue;
        if (kept < FEW) {
            norma_check_message(text, kept ? "%s, %z" : "%s%z", list, f);
            memcpy(list, text, sizeof list);
        }
        kept++;
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

static norma_result drop_named(fix_mesh *m) {
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

norma_result norma_fix_faces(fix_mesh *m) {
    norma_result result = reorient(m);
    return result ? result : drop_named(m);
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
    for (size_t i = 0; i < count; i++)
        norma_core_position(&m->mesh, norma_core_corner(&m->mesh, begin + i), cutter->points[i]);
    return count > 3 && norma_core_cut_polygon(cutter, count, triangles) == count - 2;
}

static size_t corners_of_largest(const core_mesh *mesh) {
    size_t largest = 0;
    for (size_t face = 0; face < mesh->face_count; face++) {
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
    for (size_t face = 0; face < m->mesh.face_count && fine; face++)
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
