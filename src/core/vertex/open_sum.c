/* open_sum.c: sums in any order, with the same bits. */
#include "core/vertex/vertex.h"
#include "core/call/call.h"
#include "core/face/face.h"
#include <math.h>
#include <string.h>

enum { BITS = 32, LEAST_TOP = -30 }; /* below that, the lowest place would be no normal double */

static int32_t place_of_weight(double weight) {
    int exponent;
    if (weight == 0) return LEAST_TOP;
    frexp(weight, &exponent); /* weight is at least 2^(exponent - 1) */
    const int floor_log = exponent - 1, place = (floor_log - (floor_log < 0 ? BITS - 1 : 0)) / BITS;
    return place < LEAST_TOP ? LEAST_TOP : place;
}

static void raise_top(open_sum *sum, int32_t top) {
    const int32_t by = sum->votes ? top - sum->top : 0;
    sum->top = top;
    if (by <= 0) return;
    for (int k = 0; k < 4; ++k)
        for (int place = 0; place < OPEN_SUM_PLACES; ++place)
            sum->digits[k][place] = by < OPEN_SUM_PLACES - place ? sum->digits[k][place + by] : 0;
}

static void add_number(int64_t digits[OPEN_SUM_PLACES], int32_t top, double number) {
    for (int place = OPEN_SUM_PLACES - 1; place >= 0; --place) {
        const int shift = BITS * (top - (OPEN_SUM_PLACES - 1) + place);
        const double digit = trunc(ldexp(number, -shift));
        digits[place] += (int64_t)digit;
        number -= ldexp(digit, shift);
    }
}

void norma_core_open_sum_add(open_sum *sum, double weight, const double vector[3]) {
    if (!isfinite(weight)) return;
    const int32_t place = place_of_weight(weight);
    if (!sum->votes || place > sum->top) raise_top(sum, place);
    sum->votes = 1;
    for (int k = 0; k < 3; ++k) add_number(sum->digits[k], sum->top, weight * vector[k]);
    add_number(sum->digits[3], sum->top, weight);
}

void norma_core_open_sum_join(open_sum *sum, const open_sum *other) {
    open_sum lower = *other;
    if (!other->votes) return;
    if (!sum->votes) {
        *sum = *other;
        return;
    }
    if (lower.top > sum->top)
        raise_top(sum, lower.top);
    else
        raise_top(&lower, sum->top);
    for (int k = 0; k < 4; ++k)
        for (int place = 0; place < OPEN_SUM_PLACES; ++place)
            sum->digits[k][place] += lower.digits[k][place];
}

/* Carried upwards first: then the two halves differ in what they count, and their rounding depends
 * on the sum alone. */
static double number_of_digits(const int64_t digits[OPEN_SUM_PLACES]) {
    const uint64_t mask = 0xFFFFFFFFu;
    const int64_t carry = (digits[0] - (int64_t)((uint64_t)digits[0] & mask)) / (int64_t)(mask + 1),
                  middle = digits[1] + carry,
                  high = digits[2] +
                         (middle - (int64_t)((uint64_t)middle & mask)) / (int64_t)(mask + 1);
    const uint64_t low = ((uint64_t)middle & mask) << BITS | ((uint64_t)digits[0] & mask);
    return (double)high * 0x1p64 + (double)low;
}

void norma_core_open_sum_value(const open_sum *sum, double vector[3], double *weight) {
    for (int k = 0; k < 3; ++k) vector[k] = number_of_digits(sum->digits[k]) * 0x1p-64;
    *weight = number_of_digits(sum->digits[3]) * 0x1p-64;
}

/* ---- faces vote as in norma_vertex_normals, one by one. */

static void vote(const open_voting *voting, size_t f, const core_face *face, open_sum *sums) {
    const core_mesh *mesh = voting->mesh;
    double normal[3];
    for (int k = 0; k < 3; ++k) normal[k] = voting->reversed ? -face->normal[k] : face->normal[k];
    for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); ++c)
        if (norma_core_is_kept(mesh, f, c))
            norma_core_open_sum_add(&sums[norma_core_welded_corner(mesh, c)],
                norma_core_corner_weight(mesh, voting->weight, f, face, c), normal);
}

void norma_core_open_votes(const open_voting *voting, open_sum *sums, norma_count *degenerate) {
    const core_mesh *mesh = voting->mesh;
    for (size_t f = 0; f < mesh->face_count; ++f) {
        core_face face;
        if (voting->silent && voting->silent[f]) continue;
        norma_core_face_geometry(mesh, f, &face);
        if (face.flags & CORE_FACE_DIRECTED)
            vote(voting, f, &face, sums);
        else if ((face.flags & CORE_FACE_FINITE) &&
                 norma_core_face_begin(mesh, f) < norma_core_face_end(mesh, f))
            norma_core_count_one(degenerate, f);
    }
}

int norma_core_open_direction(const open_sum *sum, double direction[3]) {
    double weight;
    for (int k = 0; k < 3; ++k) direction[k] = 0;
    if (!sum->votes) return NORMA_REASON_UNREFERENCED;
    norma_core_open_sum_value(sum, direction, &weight);
    return norma_core_cancels(direction, weight) ? NORMA_REASON_CANCELLED : NORMA_REASON_NONE;
}
