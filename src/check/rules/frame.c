/* frame.c: N206: normals of another frame. Nothing that could have been computed from the surface
 * is near them; often they were reversed, mirrored or rotated and the surface was not. */
#include "core/face/triangle.h"
#include "check/explain/explain_normals.h"
#include "check/rules/mesh_rules.h"

static const double FAR_OFF = 0.52359877559829882; /* 30 degrees */

/* The winding is shown to be wrong, or that is undecided, for more than a hundredth of the area
 * where normals and winding disagree: then N201 says so, and to compute all normals again would
 * reverse some that are right. */
static norma_result is_winding_in_doubt(check_mesh *m, int *in_doubt) {
    *in_doubt = 0;
    norma_result result = norma_check_opposed(m);
    if (result || !m->opposed_count) return result;
    double right = 0;
    uint8_t *sides = norma_core_allocate(&m->run->call, m->mesh.face_count, 1);
    result = sides ? norma_check_sides(m, m->opposed, sides) : NORMA_ERROR_MEMORY;
    for (size_t f = 0; !result && f < m->mesh.face_count; f++)
        if (m->opposed[f] && !(sides[f] & (CORE_SIDE_TURNED | CORE_SIDE_UNDECIDED)))
            right += norma_check_twice_area(m, f);
    *in_doubt = !(right > 0.99 * m->opposed_area);
    norma_core_release(&m->run->call, sides, m->mesh.face_count, 1);
    return result;
}

norma_result norma_check_is_of_another_frame(check_mesh *m, int *is) {
    const norma_deviation *deviation;
    int placeholder = 0, in_doubt = 0;
    *is = m->frame == CHECK_YES;
    if (m->frame) return NORMA_OK;
    m->frame = CHECK_NO;
    norma_result result = norma_check_deviation_of(m, &deviation);
    if (result || !deviation->corners || !(deviation->p50_rad > FAR_OFF)) return result;
    result = norma_check_is_placeholder(m, &placeholder);
    if (!result && !placeholder) result = is_winding_in_doubt(m, &in_doubt);
    if (result || placeholder || in_doubt) return result;
    m->frame = CHECK_YES;
    *is = 1;
    return NORMA_OK;
}

/* ---- in words */

static void describe_trial(const explain_trial *trial, char text[CHECK_MESSAGE]) {
    if (trial->flat)
        norma_check_message(text, "flat shading");
    else if (isnan(trial->crease_rad))
        norma_check_message(text, "%s weights, smooth", norma_weight_name(trial->weight));
    else
        norma_check_message(text, "%s weights, crease %g", norma_weight_name(trial->weight),
            trial->crease_rad * (180 / NORMA_PI));
}

static void describe_frame(const explain_frame *f, char text[CHECK_MESSAGE]) {
    const double *axis = f->axis, degrees = f->angle_rad * (180 / NORMA_PI);
    switch (f->kind) {
    case EXPLAIN_FRAME_REVERSED:
        norma_check_message(text, "they are reversed");
        break;
    case EXPLAIN_FRAME_MIRROR:
        norma_check_message(text, "a mirror along the axis (%g, %g, %g) puts them right", axis[0],
            axis[1], axis[2]);
        break;
    case EXPLAIN_FRAME_ROTATION:
        norma_check_message(text,
            "a rotation of %g degrees about the axis (%g, %g, %g) puts them right", degrees,
            axis[0], axis[1], axis[2]);
        break;
    case EXPLAIN_FRAME_BOTH:
        norma_check_message(text,
            "a mirror along the axis (%g, %g, %g) and a rotation of %g degrees about it put them "
            "right",
            axis[0], axis[1], axis[2], degrees);
        break;
    default:
        norma_check_message(text, "no mirror or rotation puts them right, so they may belong to "
                                  "another surface");
    }
}

static norma_result add_frame(check_mesh *m, const explain_frame *frame) {
    char message[CHECK_MESSAGE], how[CHECK_MESSAGE], trial[CHECK_MESSAGE];
    const double degrees = 180 / NORMA_PI, median = m->deviation.p50_rad * degrees;
    check_hits hits = {0};
    describe_frame(frame, how);
    describe_trial(&frame->trial, trial);
    if (frame->kind)
        norma_check_message(message,
            "the normals do not fit the surface: half of them are %g degrees off or more; %s, to "
            "within %g degrees at half of them (%s)",
            median, how, frame->median_rad * degrees, trial);
    else
        norma_check_message(message,
            "the normals do not fit the surface: half of them are %g degrees off or more; %s",
            median, how);
    norma_check_hit(m->run, &hits, median, CHECK_NOWHERE);
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N206,
            .severity = m->on_purpose ? NORMA_SEVERITY_INFO : NORMA_SEVERITY_ERROR,
            .unit = "deg",
            .hits = &hits,
            .message = message});
}

norma_result norma_check_frame(check_mesh *m) {
    explain_frame frame;
    int holds = 0;
    if (!norma_check_wants(m, RULE_N206) || !m->mesh.face_count) return NORMA_OK;
    norma_result result = norma_check_is_of_another_frame(m, &holds);
    if (result || !holds) return result;
    result = norma_check_around(m);
    if (!result)
        result = norma_explain_find_frame(
            &m->run->call, &m->given->data, &m->mesh, &m->topology, &frame);
    return result ? result : add_frame(m, &frame);
}
