/* fix_tangents.c: tangents put right one by one, or made where a normal map has none: along the
 * direction in which u grows (Lengyel 2001), weighted by the corner's angle, made perpendicular to
 * the normal; the sign from the winding of the UVs as they are stored, v downwards. Where signs of
 * a primitive disagree, those of the smaller side turn round and nothing else does. Vertices are
 * not split. */
#include "check/fix/fix.h"
#include "check/findings/angle.h"
#include <stdlib.h>
#include <string.h>

typedef struct tangent_sum {
    double direction[3];
    double positive, negative; /* UV areas by their sign */
} tangent_sum;

/* ---- sums over faces */

static void read_corner(const fix_mesh *m, size_t corner, double position[3], double uv[2]) {
    uint32_t vertex = norma_core_corner(&m->mesh, corner);
    norma_core_position(&m->mesh, vertex, position);
    uv[0] = uv[1] = 0;
    if (vertex < m->attributes.texcoord_count)
        for (int k = 0; k < 2; k++)
            uv[k] = (double)m->attributes.texcoords[2 * (size_t)vertex + (size_t)k];
}

static double angle_between(const double a[3], const double b[3]) {
    double cross[3] = {
        a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    return norma_core_angle(sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]),
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

/* The direction of growing u in a triangle, unit; 0: its UVs have no area. */
static int grow_u(double p[3][3], double uv[3][2], double direction[3], double *area) {
    double du1 = uv[1][0] - uv[0][0], dv1 = uv[1][1] - uv[0][1], du2 = uv[2][0] - uv[0][0],
           dv2 = uv[2][1] - uv[0][1], squares = 0;
    *area = du1 * dv2 - du2 * dv1;
    if (!(*area != 0) || !isfinite(*area)) return 0;
    for (int k = 0; k < 3; k++) {
        direction[k] =
            ((p[1][k] - p[0][k]) * dv2 - (p[2][k] - p[0][k]) * dv1) * (*area > 0 ? 1 : -1);
        squares += direction[k] * direction[k];
    }
    if (!(squares > 0) || !isfinite(squares)) return 0;
    for (int k = 0; k < 3; k++) direction[k] /= sqrt(squares);
    return 1;
}

static void add_face(const fix_mesh *m, size_t face, tangent_sum *sums) {
    double p[3][3], uv[3][2], direction[3], area;
    size_t begin = norma_core_face_begin(&m->mesh, face);
    for (size_t i = 0; i < 3; i++) read_corner(m, begin + i, p[i], uv[i]);
    if (!grow_u(p, uv, direction, &area)) return;
    int reversed = m->edit->reverse_faces && m->edit->reverse_faces[face];
    area = reversed ? -area : area;
    for (size_t i = 0; i < 3; i++) {
        double a[3], b[3];
        tangent_sum *sum = &sums[norma_core_corner(&m->mesh, begin + i)];
        for (int k = 0; k < 3; k++) {
            a[k] = p[(i + 1) % 3][k] - p[i][k];
            b[k] = p[(i + 2) % 3][k] - p[i][k];
        }
        double angle = angle_between(a, b);
        for (int k = 0; k < 3; k++) sum->direction[k] += angle * direction[k];
        sum->positive += area > 0 ? angle : 0;
        sum->negative += area < 0 ? angle : 0;
    }
}

static tangent_sum *sum_tangents(const fix_mesh *m) {
    tangent_sum *sums = calloc(m->info.vertices + 1, sizeof *sums);
    for (size_t face = 0; sums && m->attributes.texcoords && face < m->mesh.face_count; face++)
        add_face(m, face, sums);
    return sums;
}

/* ---- which */

typedef struct tangent_marks {
    uint8_t *again, *lean, *turned; /* of each vertex: to be made; to be made perpendicular; its
                                       sign turns round. NULL: none */
    int whole;                      /* all are to be made */
} tangent_marks;

/* 1: any; 0: none; -1: out of memory. */
static int mark_vertices(const fix_mesh *m, tangent_marks *marks) {
    static const check_rule rules[] = {RULE_N801, RULE_N802};
    int any = 0;
    marks->whole = !m->attributes.tangents && norma_fix_has(m, RULE_N805);
    for (size_t i = 0; i < sizeof rules / sizeof *rules && any >= 0; i++) {
        int found = norma_fix_mark(m, rules[i], MEND_VERTEX, m->info.vertices, &marks->again);
        any = found < 0 ? found : any | found;
    }
    int leaning =
        any < 0 ? any : norma_fix_mark(m, RULE_N803, MEND_VERTEX, m->info.vertices, &marks->lean);
    int turning = leaning < 0
                      ? leaning
                      : norma_fix_mark(m, RULE_N804, MEND_VERTEX, m->info.vertices, &marks->turned);
    return any < 0 || leaning < 0 || turning < 0 ? -1 : any | leaning | turning | marks->whole;
}

/* ---- making */

static void make_tangent(const tangent_sum *sum, float tangent[4]) {
    for (int k = 0; k < 3; k++) tangent[k] = (float)sum->direction[k];
    tangent[3] = sum->positive > sum->negative ? -1.0f : 1.0f;
}

static int is_marked(const uint8_t *marks, size_t i) { return marks && marks[i]; }

/* A sign that is wrong by itself keeps its vector, to the bit. */
static void turn_signs(const fix_mesh *m, const tangent_marks *marks, float *tangents) {
    for (size_t i = 0; marks->turned && i < m->attributes.tangent_count; i++) {
        if (!marks->turned[i] || is_marked(marks->again, i)) continue;
        if (!is_marked(marks->lean, i))
            memcpy(tangents + 4 * i, m->attributes.tangents + 4 * i, 3 * sizeof *tangents);
        tangents[4 * i + 3] = -m->attributes.tangents[4 * i + 3];
    }
}

static norma_result make_tangents(fix_mesh *m, const tangent_marks *marks) {
    size_t count = m->info.vertices;
    tangent_sum *sums = sum_tangents(m);
    float *tangents = calloc(4 * count + 1, sizeof *tangents),
          *normals = calloc(3 * count + 1, sizeof *normals);
    uint8_t *set = calloc(count + 1, 1);
    m->edit->tangents = tangents;
    m->edit->set_tangents = set;
    norma_result result = sums && tangents && normals && set ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < count && !result; i++) {
        double normal[3] = {0, 0, 0};
        int made = marks->whole || is_marked(marks->again, i);
        set[i] = (uint8_t)(made || is_marked(marks->lean, i) || is_marked(marks->turned, i));
        if (i < norma_fix_normal_count(m)) norma_fix_normal(m, i, normal);
        for (size_t k = 0; k < 3; k++) normals[3 * i + k] = (float)normal[k];
        if (made)
            make_tangent(&sums[i], tangents + 4 * i);
        else if (i < m->attributes.tangent_count)
            memcpy(tangents + 4 * i, m->attributes.tangents + 4 * i, 4 * sizeof *tangents);
    }
    const norma_vec3_view view = {.data = normals, .count = count, .format = NORMA_FORMAT_FLOAT};
    if (!result)
        result = norma_orthogonalise_tangents(tangents, 0, view, count, tangents, 0, count);
    if (!result) turn_signs(m, marks, tangents);
    free(sums);
    free(normals);
    return result;
}

norma_result norma_fix_tangents(fix_mesh *m) {
    tangent_marks marks = {0};
    int any = mark_vertices(m, &marks);
    norma_result result = any < 0 ? NORMA_ERROR_MEMORY : any ? make_tangents(m, &marks) : NORMA_OK;
    free(marks.again);
    free(marks.lean);
    free(marks.turned);
    return result;
}
