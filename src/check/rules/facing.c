/* facing.c: N201: normals on the other side of their faces. */
#include "check/rules/mesh_rules.h"
#include "check/findings/angle.h"
#include "check/rules/facing.h"
#include <math.h>

/* ---- which is wrong, the normals or the winding */

typedef struct opposed_sides {
    size_t turned, right, undecided;
} opposed_sides;

static norma_result find_sides(check_mesh *m, opposed_sides *sides) {
    uint8_t *of_faces = norma_core_allocate(&m->run->call, m->mesh.face_count, 1);
    norma_result result =
        of_faces ? norma_check_sides(m, m->opposed, of_faces) : NORMA_ERROR_MEMORY;
    *sides = (opposed_sides){0};
    for (size_t f = 0; !result && f < m->mesh.face_count; f++) {
        if (!m->opposed[f]) continue;
        if (of_faces[f] & CORE_SIDE_UNDECIDED)
            sides->undecided++;
        else if (of_faces[f] & CORE_SIDE_TURNED)
            sides->turned++;
        else
            sides->right++;
    }
    norma_core_release(&m->run->call, of_faces, m->mesh.face_count, 1);
    return result;
}

static void describe_sides(const opposed_sides *s, char text[CHECK_MESSAGE]) {
    const char *turn = s->turned == 1 ? "face" : "faces";
    if (!s->turned && !s->undecided)
        norma_check_message(text, "the normals are wrong, the winding is right");
    else if (!s->right && !s->undecided)
        norma_check_message(
            text, "the winding is wrong (%z %s to turn), the normals are right", s->turned, turn);
    else if (!s->right && !s->turned)
        norma_check_message(
            text, "neither volume nor rays show whether the normals or the winding are wrong");
    else if (!s->undecided)
        norma_check_message(text,
            "the normals are wrong at %z of them, the winding of %z %s is wrong", s->right,
            s->turned, turn);
    else
        norma_check_message(text,
            "the normals are wrong at %z of them, the winding of %z %s is wrong, and for %z "
            "neither "
            "volume nor rays show which",
            s->right, s->turned, turn, s->undecided);
}

static void gather_hits(check_mesh *m, check_hits *hits) {
    for (size_t f = 0; f < m->mesh.face_count; f++) {
        size_t far = 0;
        if (!m->opposed[f]) continue;
        norma_check_hit(m->run, hits,
            norma_check_arc_cosine(fmax(norma_check_greatest_cosine(m, f, &far), -1)) *
                (180 / 3.141592653589793),
            norma_check_face(f));
    }
}

static norma_result add_opposed(check_mesh *m) {
    char which[CHECK_MESSAGE];
    const double whole = norma_check_add_areas(m, 0),
                 part = whole > 0 ? m->opposed_area / whole : 0;
    const norma_severity severity = m->on_purpose ? NORMA_SEVERITY_INFO
                                    : part > .01  ? NORMA_SEVERITY_ERROR
                                                  : NORMA_SEVERITY_WARNING;
    opposed_sides sides;
    check_hits hits = {0};
    const norma_result result = find_sides(m, &sides);
    if (result) return result;
    gather_hits(m, &hits);
    describe_sides(&sides, which);
    return norma_check_report(m,
        &(check_report){.rule = RULE_N201,
            .severity = severity,
            .unit = "deg",
            .no_fix = !sides.turned && !sides.right,
            .hits = &hits},
        "%z of %z faces (%g %% of the area) %s lit from behind, as at every corner the normal "
        "points to the back of the face; %s",
        hits.count, m->mesh.face_count, 100 * part, hits.count == 1 ? "is" : "are", which);
}

/* ---- both rules */

norma_result norma_check_facing(check_mesh *m) {
    int other_frame = 0;
    if (!norma_check_normal_count(m) || m->given->info.normals == NORMA_NORMALS_PER_FACET ||
        !m->mesh.face_count || !norma_check_wants_any(m, RULE_N201, RULE_N202))
        return NORMA_OK;
    norma_result result = norma_check_opposed(m);
    if (!result && (m->opposed_count || m->far_count))
        result = norma_check_is_of_another_frame(m, &other_frame);
    if (result || other_frame) return result;
    if (m->opposed_count && norma_check_wants(m, RULE_N201)) result = add_opposed(m);
    return !result && m->far_count && norma_check_wants(m, RULE_N202) ? norma_check_far(m) : result;
}
