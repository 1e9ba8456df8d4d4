/* sides.c: which faces are turned, and N205. */
#include "check/rules/rules.h"
#include "core/face/unit_length.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Which of the faces that somebody doubts are turned (core/topology/orient.c), with the
 * primitives of a glTF mesh looked at together. Rays say nothing of a material that is seen from
 * both sides. Where neither volume nor rays say anything, the stored normals of facets do: a
 * program that turns a facet seldom turns its normal. */

/* A judge that is kept has positions of its own. */
norma_result norma_check_open_judge(
    const core_mesh *meshes, size_t count, uint32_t threads, check_judge *judge) {
    const norma_options options = {.struct_size = sizeof options, .threads = threads};
    norma_result result = norma_check_join(meshes, count, &judge->whole);
    if (!result) result = norma_core_side_judge_open(&judge->whole.mesh, &options, &judge->sides);
    judge->is_open = !result;
    return result;
}

void norma_check_close_judge(check_judge *judge) {
    if (judge->is_open) norma_core_side_judge_close(&judge->sides);
    norma_check_unjoin(&judge->whole);
    judge->is_open = 0;
}

static norma_result open_group_judge(check_run *run) {
    const check_group *g = run->group;
    norma_result result = NORMA_OK;
    if (g->judge->is_open) return result;
    core_mesh *meshes = calloc(g->count, sizeof *meshes);
    if (!meshes) return NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < g->count && !result; ++i)
        result = norma_core_mesh_shape(&g->meshes[i].data.mesh, &meshes[i]);
    if (!result) result = norma_check_open_judge(meshes, g->count, run->options.threads, g->judge);
    free(meshes);
    return result;
}

/* Of the mesh's faces among all of the group. */
static size_t first_face(const check_mesh *m) {
    size_t first = 0;
    for (size_t i = 0; i < m->number; ++i)
        first += m->run->group->meshes[i].data.mesh.corner_count / 3;
    return first;
}

/* ---- stored normals of facets as evidence */

/* 1: the stored normal is the winding's, nearly; -1: its opposite; 0: neither, or unknown. */
static signed char lean_of_facet(
    const core_mesh *mesh, size_t facet, const norma_vec3_view *normals) {
    core_face geometry;
    double n[3];
    norma_core_face_geometry(mesh, facet, &geometry);
    norma_view_read(normals, facet, n);
    const double square = norma_core_dot(n, n);
    if (!(geometry.flags & CORE_FACE_DIRECTED) || !(square > 1e-12 && square < INFINITY)) return 0;
    const double cosine = norma_core_dot(geometry.normal, n) / sqrt(square);
    return cosine >= CHECK_LEAN_COSINE ? 1 : cosine <= -CHECK_LEAN_COSINE ? -1 : 0;
}

/* Above zero: the stored normals of more of its neighbours point to the same side of the surface as
 * its own does than to the other; below: of fewer. */
static int agreement_of_facet(const core_topology *t, size_t facet, const signed char *leans) {
    int sum = 0;
    const size_t end = norma_core_face_end(&t->mesh, facet);
    for (size_t c = norma_core_face_begin(&t->mesh, facet); c < end; ++c) {
        const uint32_t partner = t->partners[c];
        if (partner < CORE_EDGE_SPECIAL)
            sum += leans[facet] * leans[norma_core_topology_face(t, partner)];
        else if (partner == CORE_EDGE_CONFLICT)
            sum -= leans[facet] * leans[norma_core_topology_face(t, t->others[c])];
    }
    return sum;
}

/* A normal that its neighbours contradict is wrong itself, if it is the opposite of its winding. */
static uint8_t side_by_facets(
    const core_topology *t, size_t facet, const signed char *leans, uint8_t side) {
    const int sum = agreement_of_facet(t, facet, leans);
    if (sum > 0) return leans[facet] < 0 ? CORE_SIDE_TURNED : 0;
    return sum < 0 && leans[facet] < 0 ? 0 : side;
}

/* Of a facet that nobody asked about, rays might say something still. */
static int was_asked(const core_side_judge *j, size_t facet) {
    const uint32_t piece = j->pieces.of[facet], part = j->parts.of[facet];
    return piece != UINT32_MAX && part != UINT32_MAX &&
           (j->known[piece] || j->parts.each[part].flags == 0);
}

norma_result norma_check_sides_by_facets(
    const core_side_judge *j, const norma_vec3_view *normals, uint8_t *sides) {
    const core_topology *t = &j->topology;
    const size_t count = t->mesh.face_count < normals->count ? t->mesh.face_count : normals->count;
    size_t undecided = 0;
    for (size_t f = 0; f < count; ++f)
        undecided += sides[f] & CORE_SIDE_UNDECIDED && was_asked(j, f);
    if (!undecided) return NORMA_OK;
    signed char *leans = norma_core_allocate(&j->call, t->mesh.face_count, sizeof *leans);
    if (!leans) return NORMA_ERROR_MEMORY;
    memset(leans, 0, t->mesh.face_count * sizeof *leans);
    for (size_t f = 0; f < count; ++f) leans[f] = lean_of_facet(&t->mesh, f, normals);
    for (size_t f = 0; f < count; ++f)
        if (sides[f] & CORE_SIDE_UNDECIDED && was_asked(j, f))
            sides[f] = side_by_facets(t, f, leans, sides[f]);
    norma_core_release(&j->call, leans, t->mesh.face_count, sizeof *leans);
    return NORMA_OK;
}

/* ---- faces that lie folded over their neighbours: volume takes them for turned, since they are
 * wound against the rest of their part, and turned they would be as wrong */

static const double FOLD_COSINE = .5; /* of 60 degrees */

int norma_check_is_fold(const core_topology *t, size_t first, size_t second) {
    core_face a, b;
    norma_core_face_geometry(&t->mesh, norma_core_topology_face(t, first), &a);
    norma_core_face_geometry(&t->mesh, norma_core_topology_face(t, second), &b);
    return a.flags & b.flags & CORE_FACE_DIRECTED &&
           norma_core_dot(a.normal, b.normal) > FOLD_COSINE;
}

/* Whether more than folds part a piece from others, or it is most of its part. */
static int is_plain_piece(const core_side_judge *j, uint32_t piece) {
    const core_topology *t = &j->topology;
    const size_t begin = j->pieces.starts[piece], end = j->pieces.starts[piece + 1];
    const uint32_t *part = j->parts.starts + j->parts.of[j->pieces.faces[begin]];
    if (2 * (end - begin) > part[1] - (size_t)part[0]) return 1;
    for (size_t i = begin; i < end; ++i)
        for (size_t c = norma_core_face_begin(&t->mesh, j->pieces.faces[i]);
             c < norma_core_face_end(&t->mesh, j->pieces.faces[i]); ++c)
            if (t->partners[c] == CORE_EDGE_CONFLICT && !norma_check_is_fold(t, c, t->others[c]))
                return 1;
    return 0;
}

/* Each piece is looked at once, and only where it has faces that are called turned. */
norma_result norma_check_sides_at_folds(
    const core_side_judge *j, size_t first, size_t count, uint8_t *sides) {
    enum { NOT_LOOKED_AT, PLAIN, FOLDED };
    uint8_t *pieces = NULL;
    for (size_t f = 0; f < count; ++f) {
        const uint32_t piece = j->pieces.of[first + f];
        if (!norma_check_is_turned(sides[f]) || sides[f] & CORE_SIDE_BY_RAYS || piece == UINT32_MAX)
            continue;
        if (!pieces) {
            pieces = norma_core_allocate(&j->call, j->pieces.count, 1);
            if (!pieces) return NORMA_ERROR_MEMORY;
            memset(pieces, NOT_LOOKED_AT, j->pieces.count);
        }
        if (pieces[piece] == NOT_LOOKED_AT)
            pieces[piece] = is_plain_piece(j, piece) ? PLAIN : FOLDED;
        if (pieces[piece] == FOLDED) sides[f] |= CORE_SIDE_UNDECIDED;
    }
    norma_core_release(&j->call, pieces, j->pieces.count, 1);
    return NORMA_OK;
}

/* ---- asking */

int norma_check_is_turned(uint8_t side) {
    return (side & (CORE_SIDE_TURNED | CORE_SIDE_UNDECIDED)) == CORE_SIDE_TURNED;
}

size_t norma_check_count_turned(
    const check_mesh *m, const uint8_t *asked, const uint8_t *sides, double *twice_area) {
    const core_components *parts = &m->run->group->judge->sides.parts;
    const size_t first = first_face(m);
    size_t count = 0;
    *twice_area = 0;
    for (size_t f = 0; f < m->mesh.face_count; ++f) {
        if (!norma_check_is_turned(sides[f]) || parts->of[first + f] == UINT32_MAX ||
            !(asked[f] || parts->each[parts->of[first + f]].flags & COMPONENT_CONFLICT))
            continue;
        ++count;
        *twice_area += norma_check_twice_area(m, f);
    }
    return count;
}

norma_result norma_check_sides(check_mesh *m, const uint8_t *asked, uint8_t *sides) {
    const size_t first = first_face(m);
    norma_result result = open_group_judge(m->run);
    if (!result && m->on_purpose) { /* nothing asks rays, which would say nothing */
        memset(sides, 0, m->mesh.face_count);
        asked = sides;
    }
    if (!result)
        result = norma_core_side_judge_ask(
            &m->run->group->judge->sides, first, m->mesh.face_count, asked, sides);
    if (!result)
        result = norma_check_sides_at_folds(
            &m->run->group->judge->sides, first, m->mesh.face_count, sides);
    return result || m->given->info.normals != NORMA_NORMALS_PER_FACET
               ? result
               : norma_check_sides_by_facets(
                     &m->run->group->judge->sides, &m->given->data.normals, sides);
}

/* ---- N205: the normals of STL facets against their winding. */

enum { FACETS_IN_BLOCK = 1 << 14 };
static const double NEAR_COSINE = 0.9961946980917455; /* of 5 degrees */
static const double CLEAR_COSINE =
    0.984807753012208;                  /* of 10 degrees: what leans less, or is zero, informs */
static const double LEAST_SHARE = .001; /* of the area: below it, the rule informs */

typedef struct facet_pass {
    const check_mesh *m;
    uint8_t *behind; /* of each face: 1: its normal is on the other side; 2: nearly the opposite of
                        its winding; or NULL */
} facet_pass;

/* A facet that is degenerate has no direction to compare with; its zero normal is as right as any.
 */
static void judge_facet(const facet_pass *pass, check_sum *part, size_t facet) {
    const check_mesh *m = pass->m;
    double n[3], length;
    norma_check_normal(m, facet, n);
    const core_length is = norma_core_judge_length(n, 0, &length);
    const double cosine = norma_check_dot(m->faces[facet].normal, n) / length;
    if (is == CORE_LENGTH_NON_FINITE || !norma_check_directed(&m->faces[facet]) ||
        norma_check_is_sliver(&m->faces[facet]))
        return;
    if (is != CORE_LENGTH_ZERO && cosine < CLEAR_COSINE)
        part->twice_area += norma_check_twice_area(m, facet);
    if (is == CORE_LENGTH_ZERO) {
        ++part->counts[CHECK_FACETS_ZERO];
        norma_check_hit(m->run, &part->hits[0], NAN, norma_check_face(facet));
    } else if (cosine < NEAR_COSINE) {
        if (pass->behind)
            pass->behind[facet] = (uint8_t)((cosine < 0) + (cosine <= -CHECK_LEAN_COSINE));
        norma_check_hit(m->run, &part->hits[0],
            norma_check_arc_cosine(fmax(cosine, -1)) * (180 / 3.141592653589793),
            norma_check_face(facet));
    }
}

static void judge_facets(const void *pass, check_sum *part, size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) judge_facet(pass, part, f);
}

/* Those that no fix of normals is for: wound wrongly while their normals are right, or perhaps. */
static norma_result count_turned(check_mesh *m, const uint8_t *behind, check_sum *sum) {
    const size_t faces = m->mesh.face_count;
    if (!memchr(behind, 1, faces) && !memchr(behind, 2, faces)) return NORMA_OK;
    uint8_t *sides = norma_core_allocate(&m->run->call, faces, 1);
    const norma_result result = sides ? norma_check_sides(m, behind, sides) : NORMA_ERROR_MEMORY;
    for (size_t f = 0; !result && f < faces; ++f) {
        sum->counts[CHECK_FACETS_TURNED] += behind[f] && norma_check_is_turned(sides[f]);
        sum->counts[CHECK_FACETS_UNDECIDED] += behind[f] > 1 && sides[f] & CORE_SIDE_UNDECIDED;
    }
    norma_core_release(&m->run->call, sides, faces, 1);
    return result;
}

norma_result norma_check_facets_add(check_mesh *m, check_sum *sum, double whole_area) {
    check_hits *hits = &sum->hits[0];
    const size_t zeros = sum->counts[CHECK_FACETS_ZERO], turned = sum->counts[CHECK_FACETS_TURNED],
                 undecided = sum->counts[CHECK_FACETS_UNDECIDED];
    const int matters = sum->twice_area > 0 && sum->twice_area >= LEAST_SHARE * whole_area;
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N205,
            .severity = matters ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO,
            .unit = "deg",
            .no_value = zeros == hits->count,
            .no_fix = turned + undecided == hits->count,
            .hits = hits},
        zeros == hits->count ? "shaded by the winding alone: %z of %z facets have a zero normal"
        : zeros ? "shaded differently by each reader: %z of %z facet normals disagree with the "
                  "winding, by up to %g degrees; %z of them are zero"
        : turned == hits->count
            ? "shaded differently by each reader: %z of %z facet normals disagree with the "
              "winding, by up to %g degrees; there the winding is wrong and the normals are right "
              "(N301, N302)"
        : turned + undecided == hits->count
            ? "shaded differently by each reader: %z of %z facet normals disagree with the "
              "winding, by up to %g degrees; neither volume nor rays nor neighbours show for %z of "
              "them which is wrong"
            : "shaded differently by each reader: %z of %z facet normals disagree with the "
              "winding, by up to %g degrees; some use the normal, others the winding",
        hits->count, m->mesh.face_count, hits->worst, zeros ? zeros : undecided);
}

norma_result norma_check_facets_look(check_mesh *m, check_sum *sum, uint8_t *behind) {
    const size_t normals = norma_check_normal_count(m), faces = m->mesh.face_count,
                 count = normals < faces ? normals : faces;
    const facet_pass pass = {m, behind};
    const norma_result result = count ? norma_check_faces(m) : NORMA_OK;
    return result ? result
                  : norma_check_gather(m->run, count, FACETS_IN_BLOCK, judge_facets, &pass, sum);
}

norma_result norma_check_facets(check_mesh *m) {
    const core_call *call = &m->run->call;
    const size_t faces = m->mesh.face_count;
    check_sum sum = {.twice_area = 0};
    if (m->given->info.normals != NORMA_NORMALS_PER_FACET || !faces ||
        !norma_check_wants(m, RULE_N205))
        return NORMA_OK;
    uint8_t *behind = norma_core_allocate(call, faces, 1);
    if (!behind) return NORMA_ERROR_MEMORY;
    memset(behind, 0, faces);
    norma_result result = norma_check_facets_look(m, &sum, behind);
    if (!result) result = count_turned(m, behind, &sum);
    norma_core_release(call, behind, faces, 1);
    if (!result && sum.hits[0].count)
        result = norma_check_facets_add(m, &sum, norma_check_add_areas(m, 0));
    norma_check_sum_free(&sum);
    return result;
}
