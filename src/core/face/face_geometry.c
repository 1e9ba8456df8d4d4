/* face_geometry.c: directions of faces and weights of corners; norma_face_normals. */
#include "core/call/call.h"
#include "core/face/eight_vectors.h"
#include "core/face/face.h"
#include "core/mesh/mesh.h"

/* ---- a face's direction is that of its vector area, sum of (p_i - p_0) x (p_{i+1} - p_0)
 * (Newell's method, Sutherland, Sproull, Schumacker 1974, relative to one vertex, so that no
 * distance from the origin is felt). Doubles where their error bound shows the direction right to
 * 2^-30 rad; exact integers where it does not: thin faces, and all that may have no area at all. */

/* Walks a face's kept corners in ascending order. Callers ask for points 0, 1, 2, ... and then 0
 * again. */
typedef struct kept_walk {
    const core_mesh *mesh;
    size_t face, corner;
} kept_walk;

static void kept_point(const void *context, size_t index, double point[3]) {
    kept_walk *walk = (kept_walk *)(uintptr_t)context;
    if (index == 0)
        walk->corner = norma_core_face_begin(walk->mesh, walk->face);
    else
        ++walk->corner;
    while (!norma_core_is_kept(walk->mesh, walk->face, walk->corner)) ++walk->corner;
    norma_core_position(walk->mesh, norma_core_corner(walk->mesh, walk->corner), point);
}

static void set_direction(core_face *out, const double area[3], double length) {
    for (int k = 0; k < 3; ++k) out->normal[k] = area[k] / length;
    out->twice_area = length;
    out->flags |= CORE_FACE_DIRECTED;
}

static void exact_direction(exact_point *point, const void *context, size_t count, core_face *out) {
    double area[3];
    int exponent;
    if (!norma_core_exact_area(point, context, count, area, &exponent)) return;
    norma_core_normalise(area, out->normal);
    out->twice_area = ldexp(norma_core_length(area), exponent);
    out->flags |= CORE_FACE_DIRECTED;
}

typedef double triangle_points[3][3];

static void triangle_point(const void *context, size_t index, double point[3]) {
    memcpy(point, ((const double(*)[3])context)[index], sizeof(double[3]));
}

static void triangle_direction(triangle_points p, core_face *out) {
    double u[3], v[3];
    norma_core_subtract(p[1], p[0], u);
    norma_core_subtract(p[2], p[0], v);
    if (norma_core_triangle(u, v, out->normal, &out->twice_area)) {
        out->flags |= CORE_FACE_FINITE | CORE_FACE_DIRECTED;
        return;
    }
    out->normal[0] = out->normal[1] = out->normal[2] = out->twice_area = 0;
    if (!norma_core_finite(p[0]) || !norma_core_finite(p[1]) || !norma_core_finite(p[2])) return;
    out->flags |= CORE_FACE_FINITE;
    if (out->flags & CORE_FACE_EDGED) exact_direction(triangle_point, p, 3, out);
}

static void triangle_geometry(const core_mesh *mesh, size_t face, core_face *out) {
    const size_t c = norma_core_face_begin(mesh, face);
    triangle_points p;
    uint32_t at[3], welded[3];
    for (int k = 0; k < 3; ++k) {
        at[k] = norma_core_corner(mesh, c + (size_t)k);
        welded[k] = norma_core_welded(mesh, at[k]);
        norma_core_position(mesh, at[k], p[k]);
    }
    out->kept =
        (uint32_t)((welded[0] != welded[1]) + (welded[1] != welded[2]) + (welded[2] != welded[0]));
    if (out->kept == 3) out->flags = CORE_FACE_EDGED;
    triangle_direction(p, out);
    if (out->kept == 3) return;
    out->normal[0] = out->normal[1] = out->normal[2] = out->twice_area =
        0; /* corners welded over a distance may span an area, which has no vote */
    out->flags &= CORE_FACE_FINITE;
}

/* Counts the kept corners, and tells whether all corners are finite. */
static void polygon_outline(const core_mesh *mesh, size_t face, core_face *out) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    int finite = 1;
    for (size_t c = begin; c < end; ++c) {
        double p[3];
        norma_core_position(mesh, norma_core_corner(mesh, c), p);
        finite &= norma_core_finite(p);
        out->kept += norma_core_is_kept(mesh, face, c) != 0;
    }
    if (finite) out->flags |= CORE_FACE_FINITE;
    if (out->kept < 3) return;
    out->flags |= CORE_FACE_EDGED;
}

static void polygon_direction(const core_mesh *mesh, size_t face, core_face *out) {
    kept_walk walk = {.mesh = mesh, .face = face};
    double origin[3], p[3], u[3] = {0, 0, 0}, v[3] = {0, 0, 0}, term[3], area[3] = {0, 0, 0},
                            size = 0;
    kept_point(&walk, 0, origin);
    for (uint32_t i = 1; i < out->kept; ++i) {
        memcpy(u, v, sizeof u);
        kept_point(&walk, i, p);
        norma_core_subtract(p, origin, v);
        norma_core_cross(u, v, term);
        for (int k = 0; k < 3; ++k) area[k] += term[k];
        size += norma_core_dot(v, v); /* at least the sum of the |u| |v| */
    }
    const double square = norma_core_dot(area, area);
    if (norma_core_area_is_sure(square, size, out->kept))
        set_direction(out, area, sqrt(square));
    else
        exact_direction(kept_point, &walk, out->kept, out);
}

void norma_core_face_geometry(const core_mesh *mesh, size_t face, core_face *out) {
    *out = (core_face){0};
    if (norma_core_face_end(mesh, face) - norma_core_face_begin(mesh, face) == 3) {
        triangle_geometry(mesh, face, out);
        return;
    }
    if (norma_core_face_end(mesh, face) == norma_core_face_begin(mesh, face)) {
        out->flags = CORE_FACE_FINITE;
        return;
    }
    polygon_outline(mesh, face, out);
    if ((out->flags & CORE_FACE_FINITE) && (out->flags & CORE_FACE_EDGED))
        polygon_direction(mesh, face, out);
}

/* ---- some at a time */

const core_kernels *norma_core_kernels(core_level level) {
#if defined(CORE_HAS_AVX512)
    if (level == CORE_AVX512) return norma_core_kernels_avx512();
#endif
#if defined(CORE_HAS_X86)
    if (level == CORE_AVX2) return norma_core_kernels_avx2();
#endif
    (void)level;
    return norma_core_kernels_portable();
}

unsigned norma_core_measure_triangles(const core_call *call, const core_mesh *mesh,
    norma_weight weight, const size_t *faces, size_t count, core_batch *batch) {
    uint32_t at[CORE_LANES][3];
    unsigned decided = 0, edged = 0;
    for (size_t i = 0; i < CORE_LANES; ++i) {
        uint32_t welded[3];
        for (size_t k = 0; k < 3; ++k) {
            at[i][k] = norma_core_corner(mesh, 3 * faces[i < count ? i : 0] + k);
            welded[k] = norma_core_welded(mesh, at[i][k]);
        }
        edged |=
            (unsigned)(welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0])
            << i;
    }
    core_load_edges(mesh, (const uint32_t(*)[3])at, batch);
    norma_core_kernels(call->level)->measure(batch, weight);
    for (size_t i = 0; i < count; ++i) decided |= batch->sure[i] != 0 ? 1U << i : 0;
    return decided & edged;
}

static void take_measured(const core_measured *measured, size_t i, core_face *out) {
    const size_t slot = measured->slot[i];
    *out = (core_face){.twice_area = measured->twice_area[slot / CORE_LANES][slot % CORE_LANES],
        .kept = measured->corners[i],
        .flags = CORE_FACE_DIRECTED | CORE_FACE_FINITE | CORE_FACE_EDGED};
    memcpy(out->normal, measured->row[slot], sizeof out->normal);
}

void norma_core_faces_geometry(
    const core_call *call, const core_mesh *mesh, size_t face, size_t count, core_face *out) {
    core_measured measured;
    norma_core_kernels(call->level)
        ->measure_faces(mesh, face, face + count, NORMA_WEIGHT_UNIFORM, CORE_NO_CORNER, &measured);
    for (size_t i = 0; i < count; ++i) {
        if (measured.corners[i])
            take_measured(&measured, i, &out[i]);
        else
            norma_core_face_geometry(mesh, face + i, &out[i]);
    }
}

/* ---- weights */

typedef struct corner_points {
    double here[3], next[3], previous[3];
} corner_points;

/* The cross product of two edges at a polygon's corner, as rounded doubles have it, made exact
 * where they would not tell a needle from nothing, nor one side of it from the other; its length.
 */
static double settle_corner_cross(const corner_points *p, double squares, double cross[3]) {
    const double square = norma_core_dot(cross, cross);
    if (norma_core_corner_is_sure(square, squares)) return sqrt(square);
    core_face corner = {0};
    exact_direction(triangle_point, p, 3, &corner);
    for (int k = 0; k < 3; ++k) cross[k] = corner.normal[k] * corner.twice_area;
    return corner.twice_area;
}
_Static_assert(sizeof(corner_points) == sizeof(triangle_points), "read as one triangle");

typedef struct corner_edges {
    double aa, bb, ab, cross[3], length; /* products of the two; the length of cross */
} corner_edges;

static void edges_of_corner(const corner_points *p, corner_edges *e) {
    double a[3], b[3];
    norma_core_subtract(p->next, p->here, a);
    norma_core_subtract(p->previous, p->here, b);
    e->aa = norma_core_dot(a, a);
    e->bb = norma_core_dot(b, b);
    e->ab = norma_core_dot(a, b);
    norma_core_cross(a, b, e->cross);
    e->length = settle_corner_cross(p, e->aa * e->bb, e->cross);
}

enum { FEW_CORNERS = 16 };
static int has_many_corners(const core_mesh *mesh, size_t face) {
    return norma_core_face_end(mesh, face) - norma_core_face_begin(mesh, face) > FEW_CORNERS;
}

/* Where the edges do not turn at all, the corner's angle is pi or 0, by the sign of their dot
 * product. area: of the face, summed where it is asked for first. */
static int is_reflex(kept_walk walk, const core_face *face, const corner_points *p,
    const corner_edges *e, exact_area *area) {
    const double along = norma_core_dot(e->cross, face->normal),
                 length = norma_core_length(e->cross);
    if (length == 0 || norma_core_turn_is_sure(along, length)) return along < 0;
    if (!area->known) norma_core_sum_polygon(kept_point, &walk, face->kept, area);
    return norma_core_turns_back(area, p->here, p->next, p->previous);
}

static double polygon_weight(norma_weight weight, kept_walk walk, const core_face *face,
    const corner_points *p, size_t corner) {
    corner_edges e = {0};
    exact_area area;
    area.known = 0;
    if (core_weighed(weight) != CORE_BY_FACE) edges_of_corner(p, &e);
    const int is_marked = walk.mesh->reflex && has_many_corners(walk.mesh, walk.face),
              reflex =
                  core_weighed(weight) == CORE_BY_ANGLE &&
                  (is_marked ? walk.mesh->reflex[corner] : is_reflex(walk, face, p, &e, &area));
    return norma_core_weigh(weight, e.aa, e.bb, e.ab, e.length, face->twice_area, reflex);
}

/* Its one cross product serves at every corner. */
static double triangle_weight(norma_weight weight, const core_face *face, const corner_points *p) {
    double a[3], b[3];
    norma_core_subtract(p->next, p->here, a);
    norma_core_subtract(p->previous, p->here, b);
    return norma_core_weigh(weight, norma_core_dot(a, a), norma_core_dot(b, b),
        norma_core_dot(a, b), face->twice_area, face->twice_area, 0);
}

static void points_of_corner(
    const core_mesh *mesh, size_t number, size_t corner, corner_points *p) {
    norma_core_position(mesh, norma_core_corner(mesh, corner), p->here);
    norma_core_position(
        mesh, norma_core_corner(mesh, norma_core_next_kept(mesh, number, corner)), p->next);
    norma_core_position(
        mesh, norma_core_corner(mesh, norma_core_previous_kept(mesh, number, corner)), p->previous);
}

double norma_core_corner_weight(const core_mesh *mesh, norma_weight weight, size_t number,
    const core_face *face, size_t corner) {
    corner_points p;
    points_of_corner(mesh, number, corner, &p);
    if (norma_core_face_end(mesh, number) - norma_core_face_begin(mesh, number) == 3)
        return triangle_weight(weight, face, &p);
    return polygon_weight(weight, (kept_walk){.mesh = mesh, .face = number}, face, &p, corner);
}

/* ---- which corners of large polygons are reflex: for one corner alone it may take a sum over all,
 * for all of them it takes no more */

enum { FACES_IN_MARKING = 1 << 12 };

typedef struct reflex_marking {
    const core_mesh *mesh;
    uint8_t *reflex;
} reflex_marking;

static void mark_corners_of_face(const reflex_marking *marking, size_t f) {
    const core_mesh *mesh = marking->mesh;
    const size_t begin = norma_core_face_begin(mesh, f), end = norma_core_face_end(mesh, f);
    core_face face;
    exact_area area;
    area.known = 0;
    norma_core_face_geometry(mesh, f, &face);
    for (size_t c = begin; c < end && (face.flags & CORE_FACE_DIRECTED); ++c) {
        corner_points p;
        corner_edges e;
        if (!norma_core_is_kept(mesh, f, c)) continue;
        points_of_corner(mesh, f, c, &p);
        edges_of_corner(&p, &e);
        marking->reflex[c] =
            (uint8_t)is_reflex((kept_walk){.mesh = mesh, .face = f}, &face, &p, &e, &area);
    }
}

static void mark_chunk(void *context, size_t chunk) {
    const reflex_marking *marking = context;
    const size_t count = marking->mesh->face_count, begin = chunk * FACES_IN_MARKING,
                 end = count - begin < FACES_IN_MARKING ? count : begin + FACES_IN_MARKING;
    for (size_t f = begin; f < end; ++f)
        if (has_many_corners(marking->mesh, f)) mark_corners_of_face(marking, f);
}

norma_result norma_core_mark_reflex(core_call *call, core_mesh *mesh) {
    size_t f = 0;
    if (!mesh->face_starts || core_weighed(call->options.weight) != CORE_BY_ANGLE) return NORMA_OK;
    while (f < mesh->face_count && !has_many_corners(mesh, f)) ++f;
    if (f == mesh->face_count) return NORMA_OK;
    reflex_marking marking = {mesh, norma_core_allocate(call, mesh->corner_count, 1)};
    if (!marking.reflex) return NORMA_ERROR_MEMORY;
    const norma_result result = norma_core_parallel(
        call, (mesh->face_count - 1) / FACES_IN_MARKING + 1, mark_chunk, &marking);
    mesh->reflex = marking.reflex;
    return result;
}

/* ---- the kept corners are hashed in a row, forwards and backwards, from each of them on: rolling
 * hashes (Karp, Rabin 1987), since the hash of a row that begins one corner later follows in a few
 * operations. The sums over all beginnings do not depend on where the face begins; the two change
 * places in its reversed twin. */

static const uint64_t BASE = UINT64_C(0x9e3779b97f4a7c15), INVERSE = UINT64_C(0xf1de83e19937733d);
_Static_assert(UINT64_C(0x9e3779b97f4a7c15) * UINT64_C(0xf1de83e19937733d) == 1,
    "modulo 2^64, one undoes the other");

static uint64_t mix(uint64_t h) {
    h = (h ^ (h >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    h = (h ^ (h >> 27)) * UINT64_C(0x94d049bb133111eb);
    return h ^ (h >> 31);
}

static uint64_t hash_of_position(uint32_t welded) { return mix((uint64_t)welded + 1); }

/* Of so many kept corners the hashes are remembered. */
enum { FEW = 8 };

typedef struct row {
    uint64_t ahead, back, power, sum_ahead, sum_back;
} row;

static void add_corner(row *r, uint64_t hash) {
    r->ahead = r->ahead * BASE + hash;
    r->back += hash * r->power;
    r->power *= BASE;
}

/* The first corner moves from the row's begin to its end. */
static void begin_later(row *r, uint64_t hash) {
    const uint64_t moved = hash * (1 - r->power);
    r->sum_ahead += mix(r->ahead);
    r->sum_back += mix(r->back);
    r->ahead = r->ahead * BASE + moved;
    r->back = (r->back - moved) * INVERSE;
}

uint64_t norma_core_twin_key(const core_mesh *mesh, size_t face) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    uint64_t hashes[FEW];
    size_t kept = 0;
    row r = {.power = 1};
    uint32_t here = begin < end ? norma_core_welded_corner(mesh, begin) : 0;
    for (size_t c = begin; c < end; ++c) {
        const uint32_t next =
            norma_core_welded_corner(mesh, norma_core_next_in_face(mesh, face, c));
        if (here != next) { /* it is kept */
            const uint64_t hash = hash_of_position(here);
            if (kept < FEW) hashes[kept] = hash;
            ++kept;
            add_corner(&r, hash);
        }
        here = next;
    }
    for (size_t i = 0; i < kept && kept <= FEW; ++i) begin_later(&r, hashes[i]);
    for (size_t c = begin; c < end && kept > FEW; ++c)
        if (norma_core_is_kept(mesh, face, c))
            begin_later(&r, hash_of_position(norma_core_welded_corner(mesh, c)));
    const uint64_t way = r.sum_ahead == r.sum_back ? 2 : r.sum_ahead > r.sum_back;
    return ((r.sum_ahead + r.sum_back) & ~(uint64_t)CORE_KEY_WAY) | way;
}

/* ---- norma_face_normals. Each face by itself; a weld matters only where it joins positions that
 * differ. */

enum { FACES_IN_CHUNK = 8192 };

typedef struct face_work {
    const core_kernels *kernels;
    const core_mesh *mesh;
    const core_output *output;
} face_work;

static int face_reason(const core_face *face) {
    if (face->flags & CORE_FACE_DIRECTED) return NORMA_REASON_NONE;
    return face->flags & CORE_FACE_FINITE ? NORMA_REASON_DEGENERATE : NORMA_REASON_NON_FINITE;
}

static int take_normal(const core_face *face, float normal[3]) {
    for (int k = 0; k < 3; ++k) normal[k] = (float)face->normal[k] + 0.0F; /* never -0 */
    return face_reason(face);
}

static int normal_of_face(const void *mesh, size_t f, float normal[3]) {
    core_face face;
    norma_core_face_geometry(mesh, f, &face);
    return take_normal(&face, normal);
}

static int take_all_normals(const core_measured *measured, size_t count, float (*normals)[3]) {
    int all = 1;
    for (size_t i = 0; i < count; ++i) all &= measured->corners[i] != 0;
    for (size_t i = 0; all && i < count; ++i)
        for (int k = 0; k < 3; ++k)
            normals[i][k] = (float)measured->row[measured->slot[i]][k] + 0.0F;
    return all;
}

static void write_block(const face_work *work, size_t begin, size_t end, core_tally *tally) {
    core_measured measured;
    float normals[CORE_FACES_AT_ONCE][3];
    work->kernels->measure_faces(
        work->mesh, begin, end, NORMA_WEIGHT_UNIFORM, CORE_NO_CORNER, &measured);
    if (take_all_normals(&measured, end - begin, normals)) {
        norma_core_write_normals(work->output, begin, end - begin, (const float(*)[3])normals);
        return;
    }
    for (size_t f = begin; f < end; ++f) {
        const int reason = normal_of_face(work->mesh, f, normals[0]);
        norma_core_write_element(work->output, f, reason, normals[0], tally);
    }
}

static void write_face_normals(const void *context, size_t begin, size_t end, core_tally *tally) {
    for (size_t f = begin, next; f < end; f = next) {
        next = end - f < CORE_FACES_AT_ONCE ? end : f + CORE_FACES_AT_ONCE;
        write_block(context, f, next, tally);
    }
}

/* The position that stands for a face among its neighbours. A face without corners is at none, and
 * gets the first normal. */
static uint32_t place_of_face(const void *mesh, size_t f) {
    const size_t begin = norma_core_face_begin(mesh, f);
    return begin < norma_core_face_end(mesh, f) ? norma_core_corner(mesh, begin) : UINT32_MAX;
}

static norma_result compute_faces(
    core_call *call, core_mesh *mesh, const core_output *output, norma_report *report) {
    const face_work work = {norma_core_kernels(call->level), mesh, output};
    const core_elements faces = {mesh, mesh->face_count, mesh, normal_of_face, place_of_face};
    core_tally tally = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    norma_core_stage(call, 0.1, 0.3);
    norma_result result = norma_core_welds_near(call) ? norma_core_weld(call, mesh) : NORMA_OK;
    norma_core_stage(call, 0.3, 0.95);
    if (!result)
        result = norma_core_write_chunks(
            call, mesh->face_count, FACES_IN_CHUNK, write_face_normals, &work, &tally);
    const size_t without = tally.degenerate.count + tally.non_finite.count;
    if (!result && output->nearest && without)
        result = norma_core_fill_nearest(call, &faces, output, without);
    if (mesh->weld) norma_core_unweld(call, mesh);
    result = norma_core_finish(call, result);
    if (!result) norma_core_write_report(report, &tally, NULL, NULL);
    return result;
}

norma_result norma_face_normals(const norma_mesh *mesh, const norma_options *options,
    float *normals, size_t capacity, norma_report *report) {
    core_call call;
    core_mesh checked;
    core_output output;
    norma_result result = norma_core_begin(&call, options);
    if (!result) result = norma_core_mesh_shape(mesh, &checked);
    if (!result) norma_core_share(&call, checked.corner_count);
    if (!result)
        result = norma_core_output_open(&call, normals, checked.face_count, capacity, &output);
    norma_core_stage(&call, 0, 0.1);
    if (!result) result = norma_core_mesh_content(&call, &checked);
    return !result ? compute_faces(&call, &checked, &output, report) : result;
}
