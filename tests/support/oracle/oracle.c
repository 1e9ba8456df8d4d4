/* oracle.c: the mesh as the contract sees it: which positions are one, which corners of a face are
 * left, the exact vector of each face. See oracle.h. */
#include "oracle/oracle.h"
#include "oracle/exact.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void *oracle_allocate(size_t count, size_t size) {
    void *block = calloc(count ? count : 1, size);
    if (!block) {
        fputs("oracle: out of memory\n", stderr);
        abort();
    }
    return block;
}

int oracle_finite(const double p[3]) { return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]); }

/* ---- reading the caller's arrays */

static double read_number(const unsigned char *at, norma_format format) {
    switch (format) {
    case NORMA_FORMAT_FLOAT: {
        float f;
        memcpy(&f, at, sizeof f);
        return (double)f;
    }
    case NORMA_FORMAT_DOUBLE: {
        double d;
        memcpy(&d, at, sizeof d);
        return d;
    }
    case NORMA_FORMAT_INT8: {
        int8_t i;
        memcpy(&i, at, sizeof i);
        return i;
    }
    case NORMA_FORMAT_UINT8:
        return *at;
    case NORMA_FORMAT_INT16: {
        int16_t i;
        memcpy(&i, at, sizeof i);
        return i;
    }
    case NORMA_FORMAT_UINT16: {
        uint16_t i;
        memcpy(&i, at, sizeof i);
        return i;
    }
    }
    abort();
}

static size_t size_of(norma_format format) {
    static const size_t sizes[] = {4, 8, 1, 1, 2, 2};
    return sizes[format];
}

static void read_positions(oracle *o, const norma_vec3_view *view) {
    const size_t size = size_of(view->format), stride = view->stride ? view->stride : 3 * size;
    for (size_t v = 0; v < view->count; ++v)
        for (size_t i = 0; i < 3; ++i)
            o->positions[v][i] = read_number(
                (const unsigned char *)view->data + v * stride + i * size, view->format);
}

static void read_mesh(oracle *o, const norma_mesh *mesh) {
    o->position_count = mesh->positions.count;
    o->positions = oracle_allocate(o->position_count, sizeof *o->positions);
    read_positions(o, &mesh->positions);

    o->corner_count = mesh->corner_count;
    o->corners = oracle_allocate(o->corner_count, sizeof *o->corners);
    for (size_t c = 0; c < o->corner_count; ++c) {
        if (!mesh->corners)
            o->corners[c] = c;
        else if (mesh->corner_size == 1)
            o->corners[c] = ((const uint8_t *)mesh->corners)[c];
        else if (mesh->corner_size == 2)
            o->corners[c] = ((const uint16_t *)mesh->corners)[c];
        else
            o->corners[c] = ((const uint32_t *)mesh->corners)[c];
    }

    o->face_count = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
    o->starts = oracle_allocate(o->face_count + 1, sizeof *o->starts);
    o->faces = oracle_allocate(o->corner_count, sizeof *o->faces);
    for (size_t f = 0; f <= o->face_count; ++f)
        o->starts[f] = mesh->face_starts ? mesh->face_starts[f] : 3 * f;
    for (size_t f = 0; f < o->face_count; ++f)
        for (size_t c = o->starts[f]; c < o->starts[f + 1]; ++c) o->faces[c] = f;
    o->smoothing_groups = mesh->smoothing_groups;
    o->hard_edges = mesh->hard_edges;
}

/* ---- which positions are one */

typedef struct sorted_position {
    double p[3];
    size_t index;
} sorted_position;

static int compare_positions(const void *left, const void *right) {
    const sorted_position *a = left, *b = right;
    for (int i = 0; i < 3; ++i)
        if (a->p[i] != b->p[i]) return a->p[i] < b->p[i] ? -1 : 1;
    return a->index < b->index ? -1 : a->index > b->index;
}

/* Those without a NaN, ascending; returns how many. */
static size_t sort_positions(const oracle *o, sorted_position *sorted) {
    size_t count = 0;
    for (size_t v = 0; v < o->position_count; ++v) {
        const double *p = o->positions[v];
        if (isnan(p[0]) || isnan(p[1]) || isnan(p[2])) continue;
        sorted[count].index = v;
        for (int i = 0; i < 3; ++i) sorted[count].p[i] = p[i] + 0.0; /* -0 becomes 0 */
        ++count;
    }
    qsort(sorted, count, sizeof *sorted, compare_positions);
    return count;
}

static size_t root(size_t *parent, size_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
}

/* Distances within 2^-50 of the limit count as at it: whether 1 + 1e-32 is more than 1 is asked of
 * nobody. */
static int within(const double a[3], const double b[3], double distance) {
    const long double x = (long double)a[0] - (long double)b[0],
                      y = (long double)a[1] - (long double)b[1],
                      z = (long double)a[2] - (long double)b[2];
    return x * x + y * y + z * z <= (long double)distance * (long double)distance * (1 + 0x1p-49L);
}

static void weld_sorted(
    const sorted_position *sorted, size_t count, norma_weld weld, double distance, size_t *parent) {
    for (size_t i = 0; i < count; ++i)
        for (size_t j = i + 1; j < count; ++j) {
            const int equal = !memcmp(sorted[i].p, sorted[j].p, sizeof sorted[i].p);
            if (weld == NORMA_WELD_EXACT && !equal) break;
            if (weld == NORMA_WELD_DISTANCE &&
                sorted[j].p[0] - sorted[i].p[0] > distance * 1.0000001)
                break;
            if (equal || (oracle_finite(sorted[i].p) && oracle_finite(sorted[j].p) &&
                             within(sorted[i].p, sorted[j].p, distance)))
                parent[root(parent, sorted[j].index)] = root(parent, sorted[i].index);
            if (weld == NORMA_WELD_EXACT) break; /* the next of the run continues it */
        }
}

static void weld_positions(oracle *o, norma_weld weld, double distance) {
    size_t *parent = oracle_allocate(o->position_count, sizeof *parent);
    o->shared = oracle_allocate(o->position_count, sizeof *o->shared);
    for (size_t v = 0; v < o->position_count; ++v) parent[v] = v;
    if (weld != NORMA_WELD_NONE) {
        sorted_position *sorted = oracle_allocate(o->position_count, sizeof *sorted);
        weld_sorted(sorted, sort_positions(o, sorted), weld, distance, parent);
        free(sorted);
    }
    size_t *number = oracle_allocate(o->position_count, sizeof *number);
    for (size_t v = 0; v < o->position_count; ++v)
        if (root(parent, v) == v) number[v] = o->shared_count++;
    for (size_t v = 0; v < o->position_count; ++v) o->shared[v] = number[root(parent, v)];
    free(number);
    free(parent);
}

/* ---- which corners of a face are left, and the face's vector */

static void keep_corners(oracle *o, size_t face) {
    const size_t start = o->starts[face], end = o->starts[face + 1];
    size_t left = 0;
    for (size_t c = start; c < end; ++c) {
        const size_t after = c + 1 < end ? c + 1 : start;
        o->kept[c] = o->shared[o->corners[c]] == o->shared[o->corners[after]] ? ORACLE_NONE : c;
        left += o->kept[c] == c;
    }
    if (left < 3) {
        for (size_t c = start; c < end; ++c) o->kept[c] = ORACLE_NONE;
        return;
    }
    for (size_t c = start; c < end;
         ++c) { /* a corner that is not left stands under the next one that is */
        size_t last = c;
        while (o->kept[last] != last) last = last + 1 < end ? last + 1 : start;
        if (o->kept[c] != c) o->kept[c] = last;
        size_t after = last;
        do after = after + 1 < end ? after + 1 : start;
        while (o->kept[after] != after);
        if (last == c) o->next[c] = after;
    }
    for (size_t c = start; c < end; ++c)
        if (o->kept[c] == c) o->previous[o->next[c]] = c;
}

/* Twice the vector area, exactly, in units of 2^(2 exponent); returns the exponent. */
static int exact_area(const oracle *o, size_t face, exact_vec3 *sum) {
    const size_t start = o->kept[o->starts[face]];
    int exponent = 1 << 20;
    exact_vec3 first, here, after;
    exact_init(&first);
    exact_init(&here);
    exact_init(&after);
    for (size_t c = o->starts[face]; c < o->starts[face + 1]; ++c) {
        const int own = exact_exponent(o->positions[o->corners[c]], 3);
        const double *p = o->positions[o->corners[c]];
        if ((p[0] != 0 || p[1] != 0 || p[2] != 0) && own < exponent) exponent = own;
    }
    if (exponent == 1 << 20) exponent = 0;
    exact_set(&first, o->positions[o->corners[start]], exponent);
    for (size_t c = o->next[start]; o->next[c] != start; c = o->next[c]) {
        exact_set(&here, o->positions[o->corners[c]], exponent);
        exact_set(&after, o->positions[o->corners[o->next[c]]], exponent);
        exact_sub(&here, &here, &first);
        exact_sub(&after, &after, &first);
        exact_add_cross(sum, &here, &after);
    }
    exact_clear(&first);
    exact_clear(&here);
    exact_clear(&after);
    return exponent;
}

int oracle_turns_back(const oracle *o, size_t corner) {
    exact_vec3 area, here, a, b, cross;
    mpz_t along;
    mpz_init(along);
    exact_init(&area);
    exact_init(&here);
    exact_init(&a);
    exact_init(&b);
    exact_init(&cross);
    const int exponent = exact_area(o, o->faces[corner], &area);
    exact_set(&here, o->positions[o->corners[corner]], exponent);
    exact_set(&a, o->positions[o->corners[o->next[corner]]], exponent);
    exact_set(&b, o->positions[o->corners[o->previous[corner]]], exponent);
    exact_sub(&a, &a, &here);
    exact_sub(&b, &b, &here);
    exact_cross(&cross, &a, &b);
    exact_dot(along, &cross, &area);
    const int sign = mpz_sgn(along);
    mpz_clear(along);
    exact_clear(&area);
    exact_clear(&here);
    exact_clear(&a);
    exact_clear(&b);
    exact_clear(&cross);
    return sign < 0;
}

static void face_vector(oracle *o, size_t face) {
    exact_vec3 sum;
    exact_init(&sum);
    const int exponent = exact_area(o, face, &sum);
    if (exact_is_zero(&sum)) {
        o->kinds[face] = ORACLE_NO_AREA;
    } else {
        long double n[3];
        exact_round_vec3(n, &sum, 2 * exponent);
        const long double length = sqrtl(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int i = 0; i < 3; ++i) o->directions[face][i] = n[i] / length;
        o->areas[face] = length;
        o->kinds[face] = ORACLE_DIRECTED;
    }
    exact_clear(&sum);
}

static void measure_faces(oracle *o) {
    memset(o->directions, 0, o->face_count * sizeof *o->directions);
    for (size_t f = 0; f < o->face_count; ++f) {
        int finite = 1;
        size_t left = 0;
        for (size_t c = o->starts[f]; c < o->starts[f + 1]; ++c) left += o->kept[c] == c;
        for (size_t c = o->starts[f]; c < o->starts[f + 1]; ++c)
            finite &= oracle_finite(o->positions[o->corners[c]]);
        if (!finite)
            o->kinds[f] = left < 3 ? ORACLE_NON_FINITE_FEW : ORACLE_NON_FINITE;
        else if (left < 3)
            o->kinds[f] = ORACLE_FEW;
        else
            face_vector(o, f);
    }
}

static void read_faces(oracle *o) {
    o->kept = oracle_allocate(o->corner_count, sizeof *o->kept);
    o->next = oracle_allocate(o->corner_count, sizeof *o->next);
    o->previous = oracle_allocate(o->corner_count, sizeof *o->previous);
    o->kinds = oracle_allocate(o->face_count, sizeof *o->kinds);
    o->directions = oracle_allocate(o->face_count, sizeof *o->directions);
    o->areas = oracle_allocate(o->face_count, sizeof *o->areas);
    for (size_t f = 0; f < o->face_count; ++f) keep_corners(o, f);
    measure_faces(o);
}

void oracle_move(oracle *o, const norma_vec3_view *positions) {
    read_positions(o, positions);
    measure_faces(o);
    memset(o->measures, 0, o->corner_count * sizeof *o->measures);
}

static void list_corners_by_position(oracle *o) {
    o->by_shared_start = oracle_allocate(o->shared_count + 2, sizeof *o->by_shared_start);
    o->by_shared = oracle_allocate(o->corner_count, sizeof *o->by_shared);
    for (size_t c = 0; c < o->corner_count; ++c)
        if (o->kept[c] == c) ++o->by_shared_start[o->shared[o->corners[c]] + 2];
    for (size_t s = 2; s < o->shared_count + 2; ++s)
        o->by_shared_start[s] += o->by_shared_start[s - 1];
    for (size_t c = 0; c < o->corner_count; ++c)
        if (o->kept[c] == c) o->by_shared[o->by_shared_start[o->shared[o->corners[c]] + 1]++] = c;
}

void oracle_create(oracle *o, const norma_mesh *mesh, norma_weld weld, double distance) {
    memset(o, 0, sizeof *o);
    read_mesh(o, mesh);
    weld_positions(o, weld, distance);
    read_faces(o);
    list_corners_by_position(o);
    o->measures = oracle_allocate(o->corner_count, sizeof *o->measures);
}

void oracle_destroy(oracle *o) {
    void *const blocks[] = {o->positions, o->starts, o->corners, o->faces, o->shared, o->kept,
        o->next, o->previous, o->kinds, o->directions, o->areas, o->by_shared_start, o->by_shared,
        o->measures};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i) free(blocks[i]);
    memset(o, 0, sizeof *o);
}

/* ---- nearest fallback */

static long double rough_distance(const double a[3], const double b[3]) {
    long double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const long double d = (long double)a[i] - (long double)b[i];
        sum += d * d;
    }
    return sum;
}

static void square_distance(mpz_t out, const double a[3], const double b[3]) {
    exact_vec3 p, q;
    exact_init(&p);
    exact_init(&q);
    exact_set(&p, a, EXACT_LEAST);
    exact_set(&q, b, EXACT_LEAST);
    exact_sub(&p, &p, &q);
    exact_dot(out, &p, &p);
    exact_clear(&p);
    exact_clear(&q);
}

/* The sign of |here - a| - |here - b|; exact numbers are asked where others would not do. */
static int compare_distances(const double here[3], const double a[3], const double b[3]) {
    const long double rough_a = rough_distance(here, a), rough_b = rough_distance(here, b);
    mpz_t x, y;
    if (!memcmp(a, b, 3 * sizeof *a)) return 0;
    if (fabsl(rough_a - rough_b) > 0x1p-60L * (rough_a + rough_b))
        return rough_a < rough_b ? -1 : 1;
    mpz_inits(x, y, NULL);
    square_distance(x, here, a);
    square_distance(y, here, b);
    const int order = mpz_cmp(x, y);
    mpz_clears(x, y, NULL);
    return order;
}

size_t oracle_nearest(
    const oracle *o, const size_t *vertices, const uint8_t *reasons, size_t count, size_t element) {
    const size_t vertex = vertices[element];
    const double *here = o->positions[vertex];
    size_t best = ORACLE_NONE;
    for (size_t i = 0; i < count; ++i) {
        if (reasons[i] != NORMA_REASON_NONE) continue;
        if (!oracle_finite(here)) return i;
        if (!oracle_finite(o->positions[vertices[i]])) continue;
        const int order = best == ORACLE_NONE ? -1
                                              : compare_distances(here, o->positions[vertices[i]],
                                                    o->positions[vertices[best]]);
        if (order < 0 || (order == 0 && vertices[i] == vertex && vertices[best] != vertex))
            best = i;
    }
    return best;
}

long double oracle_angle(const long double a[3], const long double b[3]) {
    const long double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2],
                      z = a[0] * b[1] - a[1] * b[0];
    return atan2l(sqrtl(x * x + y * y + z * z), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}
