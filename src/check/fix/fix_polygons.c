/* fix_polygons.c: polygons that readers would cut wrong or differently (N404, N405), cut into
 * triangles that do not fold: ears are clipped (Meisters 1975) in the plane of the polygon's vector
 * area, each time the one with the shortest cut of those that leave no triangle looking far off.
 * What crosses itself has no such triangles and stays; so does what would take longer than polygons
 * of some thousand corners do: time grows with the square of their number. */
#include "check/fix/fix.h"
#include <stdlib.h>
#include <string.h>

typedef struct polygon {
    size_t count;
    double (*points)[3]; /* relative to the first corner */
    double (*flat)[2];   /* in its plane, counter-clockwise */
    double area[3];
    uint32_t *ring; /* corners that are left */
    size_t left;
    uint8_t *gone;  /* of each corner: cut off */
    uint32_t *seen; /* of each corner: up to which one nobody who is left lies in the triangle that
                       cuts it off */
    size_t work;    /* how many looks are left, for all polygons of the mesh */
} polygon;

enum { LEAST_WORK = 1 << 25, WORK_A_CORNER = 1 << 12, AGREEMENT_WORK = 8 };

static void take_work(polygon *p, size_t looks) { p->work -= looks < p->work ? looks : p->work; }

static double cross2(const double a[2], const double b[2], const double c[2]) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Drops the axis along which the vector area is greatest. 0: it has none. */
static int flatten(polygon *p) {
    double *area = p->area;
    memset(p->area, 0, sizeof p->area);
    for (size_t i = 1; i + 1 < p->count; i++)
        for (int k = 0; k < 3; k++) {
            const double *a = p->points[i], *b = p->points[i + 1];
            area[k] += a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        }
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (fabs(area[k]) > fabs(area[axis])) axis = k;
    if (!(fabs(area[axis]) > 0) || !isfinite(area[axis])) return 0;
    for (size_t i = 0; i < p->count; i++) {
        p->flat[i][0] = p->points[i][(axis + 1) % 3];
        p->flat[i][1] = p->points[i][(axis + 2) % 3] * (area[axis] > 0 ? 1 : -1);
    }
    return 1;
}

static int is_inside(const double a[2], const double b[2], const double c[2], const double p[2]) {
    return cross2(a, b, p) >= 0 && cross2(b, c, p) >= 0 && cross2(c, a, p) >= 0;
}

static int same_point(const double a[2], const double b[2]) { return a[0] == b[0] && a[1] == b[1]; }

/* Whether the corner at place i of the ring can be cut off: convex, and no other corner in the
 * triangle. Who was looked at stays so as long as the triangle is the same one. */
static int is_ear(polygon *p, size_t i) {
    const uint32_t before = p->ring[(i + p->left - 1) % p->left], at = p->ring[i],
                   after = p->ring[(i + 1) % p->left];
    const double *a = p->flat[before], *b = p->flat[at], *c = p->flat[after];
    if (!(cross2(a, b, c) > 0)) return 0;
    for (; p->seen[at] < p->count; p->seen[at]++) {
        const uint32_t k = p->seen[at];
        const double *q = p->flat[k];
        if (!p->work) return 0;
        take_work(p, 1);
        if (!p->gone[k] && k != before && k != at && k != after && !same_point(q, a) &&
            !same_point(q, b) && !same_point(q, c) && is_inside(a, b, c, q))
            return 0;
    }
    return 1;
}

static const double FAR_OFF = .5; /* cosine of 60 degrees */

/* Cosine of the angle between a triangle and the polygon's area, at most FAR_OFF: nearer is as
 * good. */
static double agreement(const polygon *p, uint32_t a, uint32_t b, uint32_t c) {
    double ab[3], ac[3], normal[3];
    norma_core_subtract(p->points[b], p->points[a], ab);
    norma_core_subtract(p->points[c], p->points[a], ac);
    norma_core_cross(ab, ac, normal);
    const double product = norma_core_length(normal) * norma_core_length(p->area);
    return product > 0 ? fmin(norma_core_dot(normal, p->area) / product, FAR_OFF) : -1;
}

/* Of cutting off the corner at place i of the ring; where four are left, of what remains as well.
 */
static double cut_agreement(const polygon *p, size_t i) {
    const uint32_t before = p->ring[(i + p->left - 1) % p->left], at = p->ring[i],
                   after = p->ring[(i + 1) % p->left];
    const double ear = agreement(p, before, at, after);
    return p->left == 4 ? fmin(ear, agreement(p, before, after, p->ring[(i + 2) % 4])) : ear;
}

static double cut_length(const polygon *p, size_t i) {
    const double *a = p->points[p->ring[(i + p->left - 1) % p->left]],
                 *c = p->points[p->ring[(i + 1) % p->left]];
    return (a[0] - c[0]) * (a[0] - c[0]) + (a[1] - c[1]) * (a[1] - c[1]) +
           (a[2] - c[2]) * (a[2] - c[2]);
}

/* The place of the best ear; p->left: there is none. */
static size_t find_ear(polygon *p) {
    size_t best = p->left;
    double best_agreement = 0, best_length = 0;
    for (size_t i = 0; i < p->left; i++) {
        if (!is_ear(p, i)) continue;
        take_work(p, AGREEMENT_WORK);
        const double how = cut_agreement(p, i), length = cut_length(p, i);
        if (best < p->left &&
            (how < best_agreement || (how == best_agreement && !(length < best_length))))
            continue;
        best = i;
        best_agreement = how;
        best_length = length;
    }
    return best;
}

static void cut_off(polygon *p, size_t place, uint32_t triangle[3]) {
    triangle[0] = p->ring[(place + p->left - 1) % p->left];
    triangle[1] = p->ring[place];
    triangle[2] = p->ring[(place + 1) % p->left];
    p->gone[triangle[1]] = 1;
    p->seen[triangle[0]] = p->seen[triangle[2]] = 0; /* they have other triangles now */
    memmove(p->ring + place, p->ring + place + 1, (p->left - place - 1) * sizeof *p->ring);
    p->left--;
}

/* Corners of count - 2 triangles; 0: it cannot be cut so, or not in time. */
static int clip_ears(polygon *p, uint32_t *triangles) {
    for (p->left = 0; p->left < p->count; p->left++) p->ring[p->left] = (uint32_t)p->left;
    memset(p->gone, 0, p->count);
    memset(p->seen, 0, p->count * sizeof *p->seen);
    for (size_t done = 0; p->left >= 3; done++) {
        const size_t best = find_ear(p);
        take_work(p, p->left);
        if (best == p->left || !p->work) return 0;
        cut_off(p, best, triangles + 3 * done);
    }
    return 1;
}

static int cut_face(const fix_mesh *m, size_t face, polygon *p, uint32_t *triangles) {
    size_t begin = norma_core_face_begin(&m->mesh, face);
    double first[3];
    p->count = norma_core_face_end(&m->mesh, face) - begin;
    norma_core_position(&m->mesh, norma_core_corner(&m->mesh, begin), first);
    for (size_t i = 0; i < p->count; i++) {
        norma_core_position(&m->mesh, norma_core_corner(&m->mesh, begin + i), p->points[i]);
        if (!norma_core_finite(p->points[i])) return 0;
        for (int k = 0; k < 3; k++) p->points[i][k] -= first[k];
    }
    return p->count > 3 && flatten(p) && clip_ears(p, triangles);
}

static norma_result cut_named(fix_mesh *m, const uint8_t *marks) {
    size_t largest = 0;
    for (size_t face = 0; face < m->mesh.face_count; face++) {
        size_t corners =
            norma_core_face_end(&m->mesh, face) - norma_core_face_begin(&m->mesh, face);
        largest = corners > largest ? corners : largest;
    }
    polygon p = {.points = malloc((largest + 1) * sizeof *p.points),
        .flat = malloc((largest + 1) * sizeof *p.flat),
        .ring = malloc((largest + 1) * sizeof *p.ring)};
    p.gone = malloc(largest + 1);
    p.seen = malloc((largest + 1) * sizeof *p.seen);
    p.work = LEAST_WORK + (m->mesh.corner_count < SIZE_MAX / 2 / WORK_A_CORNER
                                  ? WORK_A_CORNER * m->mesh.corner_count
                                  : SIZE_MAX / 2);
    uint8_t *cut = calloc(m->mesh.face_count + 1, 1);
    uint32_t *triangles = calloc(3 * m->mesh.corner_count + 1, sizeof *triangles);
    int any = 0, fine = p.points && p.flat && p.ring && p.gone && p.seen && cut && triangles;
    for (size_t face = 0; face < m->mesh.face_count && fine; face++)
        if (marks[face] && !(m->edit->drop_faces && m->edit->drop_faces[face]))
            any |= cut[face] = (uint8_t)cut_face(
                m, face, &p, triangles + 3 * norma_core_face_begin(&m->mesh, face));
    if (any) {
        m->edit->cut_faces = cut;
        m->edit->cut_corners = triangles;
    } else {
        free(cut);
        free(triangles);
    }
    free(p.points);
    free(p.flat);
    free(p.ring);
    free(p.gone);
    free(p.seen);
    return fine ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* Where faces are reversed as well, that comes first: the cut waits for the next time. */
norma_result norma_fix_polygons(fix_mesh *m) {
    uint8_t *marks = NULL;
    const norma_file_format format = norma_document_format(m->document);
    if (m->edit->reverse_faces)
        m->waits |= norma_fix_has(m, RULE_N404) || norma_fix_has(m, RULE_N405);
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
