/* tangent_signs.c: N804: the sign of tangents against the winding of the UVs as they are stored, v
 * downwards: +1 if a triangle's signed area in UV is negative, -1 if it is positive. Public sample
 * files follow this, except some that are wrong throughout or in their mirrored islands. A vertex
 * is against its UVs if every face there whose UVs have an area disagrees with its sign. If some
 * vertices of a primitive are against and some with their UVs, one side is wrong, most likely the
 * smaller. If all are against, the normal map may have been made for that. */
#include "check/rules/scene_rules.h"
#include <math.h>
#include <string.h>

enum { WITH = 1, AGAINST = 2 };

static inline double greater(double a, double b) { return a > b ? a : b; }
static inline double largest_of(double a, double b, double c) {
    return greater(fabs(a), greater(fabs(b), fabs(c)));
}

/* Of a triangle in UV: twice its signed area; 0 where that is no more than what rounding the
 * numbers to floats can make, or a sliver's. Relative to the triangle, so that the smallest island
 * counts. */
static double uv_area(const float *a, const float *b, const float *c) {
    const double ab[2] = {(double)b[0] - (double)a[0], (double)b[1] - (double)a[1]},
                 ac[2] = {(double)c[0] - (double)a[0], (double)c[1] - (double)a[1]};
    double area = ab[0] * ac[1] - ab[1] * ac[0];
    double longest =
        greater(largest_of(ab[0], ac[0], ac[0] - ab[0]), largest_of(ab[1], ac[1], ac[1] - ab[1]));
    double far = greater(largest_of((double)a[0], (double)b[0], (double)c[0]),
        largest_of((double)a[1], (double)b[1], (double)c[1]));
    double noise = greater(0x1p-22 * far * longest, 1e-6 * longest * longest);
    return fabs(area) > noise ? area
                              : 0; /* also where one is not finite: nothing is greater than NaN */
}

static uint32_t texcoord_of(const check_mesh *m, size_t corner) {
    const norma_mesh_attributes *a = &m->given->attributes;
    uint32_t number =
        a->corner_texcoords ? a->corner_texcoords[corner] : norma_core_corner(&m->mesh, corner);
    return number < a->texcoord_count ? number : UINT32_MAX;
}

/* A polygon as the fan from its first corner. */
static double face_area(const check_mesh *m, size_t begin, size_t end) {
    const float *uvs = m->given->attributes.texcoords;
    double sum = 0;
    for (size_t c = begin + 1; c + 1 < end; c++) {
        const uint32_t t[3] = {texcoord_of(m, begin), texcoord_of(m, c), texcoord_of(m, c + 1)};
        if (t[0] == UINT32_MAX || t[1] == UINT32_MAX || t[2] == UINT32_MAX) return 0;
        sum += uv_area(uvs + 2 * (size_t)t[0], uvs + 2 * (size_t)t[1], uvs + 2 * (size_t)t[2]);
    }
    return sum;
}

static void judge_faces(const check_mesh *m, uint8_t *verdicts) {
    const norma_mesh_attributes *a = &m->given->attributes;
    for (size_t f = 0; f < m->mesh.face_count; f++) {
        size_t begin = norma_core_face_begin(&m->mesh, f), end = norma_core_face_end(&m->mesh, f);
        double area = face_area(m, begin, end);
        if (area == 0) continue;
        float expected = area < 0 ? 1 : -1;
        for (size_t c = begin; c < end; c++) {
            size_t v = norma_core_corner(&m->mesh, c);
            float sign = v < a->tangent_count ? a->tangents[4 * v + 3] : 0;
            if (sign == 1 || sign == -1) verdicts[v] |= sign == expected ? WITH : AGAINST;
        }
    }
}

static norma_result add(check_mesh *m, const uint8_t *verdicts, size_t with, size_t against) {
    char message[CHECK_MESSAGE];
    check_hits hits = {0};
    int mixed = with > 0, side = mixed && with < against ? WITH : AGAINST;
    for (size_t v = 0; v < m->mesh.positions.count; v++)
        if (verdicts[v] == side) norma_check_hit(m->run, &hits, 0, norma_check_vertex(v));
    if (!mixed)
        norma_check_message(message,
            "%z tangent%s (all whose UVs have an area) %s the opposite of the sign that the UVs "
            "give; correct if the normal map was made for it",
            against, norma_check_plural(against), against == 1 ? "has" : "have");
    else if (side == AGAINST)
        norma_check_message(message,
            "%z tangent%s %s the opposite of the sign that the UVs give, and %z agree%s with the "
            "UVs; "
            "bumps become dents in one of the two groups",
            against, norma_check_plural(against), against == 1 ? "has" : "have", with,
            with == 1 ? "s" : "");
    else
        norma_check_message(message,
            "%z tangent%s %s the sign that the UVs give, and %z the opposite; bumps become dents "
            "in "
            "one of the two groups",
            with, norma_check_plural(with), with == 1 ? "has" : "have", against);
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N804,
            .severity = mixed ? norma_check_tangent_severity(m) : NORMA_SEVERITY_INFO,
            .no_value = 1,
            .no_fix = !mixed,
            .hits = &hits,
            .message = message});
}

norma_result norma_check_tangent_signs(check_mesh *m) {
    size_t count = m->mesh.positions.count, with = 0, against = 0;
    if (!m->given->attributes.texcoords || !count) return NORMA_OK;
    uint8_t *verdicts = norma_core_allocate(&m->run->call, count, 1);
    if (!verdicts) return NORMA_ERROR_MEMORY;
    memset(verdicts, 0, count);
    judge_faces(m, verdicts);
    for (size_t v = 0; v < count; v++) {
        with += verdicts[v] == WITH;
        against += verdicts[v] == AGAINST;
    }
    norma_result result = against ? add(m, verdicts, with, against) : NORMA_OK;
    norma_core_release(&m->run->call, verdicts, count, 1);
    return result;
}
