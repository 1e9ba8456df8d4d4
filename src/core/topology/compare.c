/* compare.c: by how much the normals of one surface differ from those of another: corner by corner
 * where both have the same faces, else at the nearest points. */
#include "core/topology/topology.h"
#include <float.h>

enum { COMPARED_AT_ONCE = 2048 };

/* Boxes opened for each point and triangle, and in any case. Surfaces of 100,000 triangles that lie
 * on each other open 6 for each, beside each other 60, a sphere within one of twice its size 200.
 * Points that all triangles are equally far from would open all of them. */
enum { MOST_STEPS = 2000, FEW_STEPS = 1 << 22 };

static const double JUST_ALIKE = 0x1p-20; /* of the size of the base, and of cosines of 1 */

typedef struct compared_face { /* of the other surface */
    double area_of_corner;     /* 0: no direction */
    float direction[3];
} compared_face;

typedef struct compared { /* one of the two */
    const norma_surface *given;
    core_mesh mesh;
} compared;

typedef struct comparing {
    core_call call;
    compared base, other;
    double unit; /* 1 in the scale that both meshes are read in */
    double slack;
    compared_face *faces;
    core_triangle_tree tree;
    core_corners_of_position corners_of;
    uint64_t *order; /* of other's positions: each number in the lower half */
    norma_compare_sample *samples;
    atomic_ullong steps;
    unsigned long long most_steps;
} comparing;

/* ---- the two surfaces, checked */

static uint32_t normal_of_corner(const compared *c, size_t corner) {
    return c->given->corner_normals ? c->given->corner_normals[corner]
                                    : norma_core_corner(&c->mesh, corner);
}

static norma_result check_normals(const compared *c) {
    const norma_vec3_view *normals = &c->given->normals;
    if (!c->mesh.corner_count) return NORMA_OK;
    if (!normals->count || !normals->data || !norma_format_size(normals->format))
        return NORMA_ERROR_ARGUMENT;
    if (norma_view_overflows(normals)) return NORMA_ERROR_OVERFLOW;
    for (size_t i = 0; i < c->mesh.corner_count; ++i) {
        const uint32_t index = normal_of_corner(c, i);
        if (index >= normals->count && (index != UINT32_MAX || !c->given->corner_normals))
            return NORMA_ERROR_INDEX;
    }
    return NORMA_OK;
}

static norma_result check_surface(core_call *call, const norma_surface *given, compared *c) {
    c->given = given;
    if (!given) return NORMA_ERROR_ARGUMENT;
    norma_result result = norma_core_mesh_shape(&given->mesh, &c->mesh);
    if (!result) result = norma_core_mesh_content(call, &c->mesh);
    return !result ? check_normals(c) : result;
}

/* Both are read in one scale; only doubles have one. */
static void read_in_one_scale(comparing *c) {
    const int both = c->base.mesh.positions.format == NORMA_FORMAT_DOUBLE &&
                     c->other.mesh.positions.format == NORMA_FORMAT_DOUBLE;
    const double scale = both ? fmin(c->base.mesh.scale, c->other.mesh.scale) : 1;
    c->base.mesh.scale = c->other.mesh.scale = scale;
    c->unit = 1 / scale;
}

static double size_of_mesh(const core_mesh *mesh) {
    double p[3], sides[3], low[3] = {INFINITY, INFINITY, INFINITY},
                           high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < mesh->corner_count; ++i) {
        norma_core_position(mesh, norma_core_corner(mesh, i), p);
        if (!norma_core_finite(p)) continue;
        for (int k = 0; k < 3; ++k) {
            low[k] = p[k] < low[k] ? p[k] : low[k];
            high[k] = p[k] > high[k] ? p[k] : high[k];
        }
    }
    norma_core_subtract(high, low, sides);
    return low[0] <= high[0] ? norma_core_length(sides) : 0;
}

/* ---- normals and directions */

/* 0: it has none. */
static int read_unit_normal(const compared *c, size_t corner, double unit[3]) {
    const uint32_t index = normal_of_corner(c, corner);
    double normal[3];
    if (index == UINT32_MAX) return 0;
    norma_view_read(&c->given->normals, index, normal);
    if (!norma_core_finite(normal)) return 0;
    norma_core_normalise(normal, unit);
    return unit[0] != 0 || unit[1] != 0 || unit[2] != 0;
}

static double angle_of(const double a[3], const double b[3]) {
    double across[3];
    norma_core_cross(a, b, across);
    return norma_core_angle(norma_core_length(across), norma_core_dot(a, b));
}

static void direction_of_triangle(const core_triangle *t, double unit[3]) {
    double across[3];
    norma_core_cross(t->u, t->v, across);
    norma_core_normalise(across, unit);
}

/* Of the base, at the point of a triangle with these weights. */
static void interpolate_base(const comparing *c, const core_triangle *t, const double weights[2],
    const double direction[3], double unit[3]) {
    const double parts[3] = {1 - weights[0] - weights[1], weights[0], weights[1]};
    double sum[3] = {0, 0, 0};
    for (int i = 0; i < 3; ++i) {
        double normal[3];
        if (parts[i] == 0) continue;
        const int has = read_unit_normal(&c->base, t->corners[i], normal);
        for (int k = 0; k < 3; ++k) sum[k] += parts[i] * (has ? normal : direction)[k];
    }
    if (norma_core_cancels(sum, 1))
        memcpy(unit, direction, 3 * sizeof *unit);
    else
        norma_core_normalise(sum, unit);
}

static void measure_compared_faces(void *context, size_t chunk) {
    comparing *c = context;
    const core_mesh *mesh = &c->other.mesh;
    const size_t first = chunk * COMPARED_AT_ONCE, left = mesh->face_count - first;
    const size_t end = first + (left < COMPARED_AT_ONCE ? left : COMPARED_AT_ONCE);
    for (size_t f = first, count; f < end; f += count) {
        core_face faces[CORE_FACES_AT_ONCE];
        count = end - f < CORE_FACES_AT_ONCE ? end - f : CORE_FACES_AT_ONCE;
        norma_core_faces_geometry(&c->call, mesh, f, count, faces);
        for (size_t i = 0; i < count; ++i) {
            const size_t corners =
                norma_core_face_end(mesh, f + i) - norma_core_face_begin(mesh, f + i);
            compared_face *to = &c->faces[f + i];
            *to = (compared_face){.area_of_corner = 0};
            if (!(faces[i].flags & CORE_FACE_DIRECTED)) continue;
            to->area_of_corner = faces[i].twice_area / 2 / (double)corners * c->unit * c->unit;
            for (int k = 0; k < 3; ++k) to->direction[k] = (float)faces[i].normal[k];
        }
    }
}

static void write_compared(const comparing *c, size_t corner, double area, double distance,
    double angle, uint32_t face, const double normal[3]) {
    norma_compare_sample sample = {.area = area,
        .angle_rad = (float)angle,
        .distance = (float)(distance < 0 ? distance : fmin(distance * c->unit, FLT_MAX)),
        .face = face};
    for (int k = 0; k < 3 && normal; ++k) sample.normal[k] = (float)normal[k] + 0.0F;
    c->samples[corner] = sample;
}

/* ---- corner by corner */

/* Whether a corner is where that of the base is, as far as its face lets corners be told apart. */
static int has_same_corners(const comparing *c, size_t face) {
    const core_mesh *mesh = &c->base.mesh;
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    double a[3], b[3], d[3], shortest = INFINITY, furthest = 0;
    for (size_t i = begin; i < end; ++i) {
        norma_core_position(mesh, norma_core_corner(mesh, i), a);
        norma_core_position(
            mesh, norma_core_corner(mesh, norma_core_next_in_face(mesh, face, i)), b);
        norma_core_subtract(a, b, d);
        shortest = fmin(shortest, norma_core_dot(d, d));
        norma_core_position(&c->other.mesh, norma_core_corner(&c->other.mesh, i), b);
        norma_core_subtract(a, b, d);
        if (norma_core_finite(a) != norma_core_finite(b)) return 0;
        if (norma_core_finite(a)) furthest = fmax(furthest, norma_core_dot(d, d));
    }
    return furthest <= fmax(shortest / 16, c->slack * c->slack);
}

static int has_same_faces(const comparing *c) {
    const core_mesh *base = &c->base.mesh, *other = &c->other.mesh;
    if (base->face_count != other->face_count || base->corner_count != other->corner_count)
        return 0;
    for (size_t f = 0; f < base->face_count; ++f)
        if (norma_core_face_end(base, f) != norma_core_face_end(other, f) ||
            !has_same_corners(c, f))
            return 0;
    return 1;
}

static void compare_same_face(const comparing *c, size_t face) {
    const core_mesh *mesh = &c->base.mesh;
    core_face geometry;
    norma_core_face_geometry(mesh, face, &geometry);
    const int directed = (geometry.flags & CORE_FACE_DIRECTED) != 0;
    for (size_t i = norma_core_face_begin(mesh, face); i < norma_core_face_end(mesh, face); ++i) {
        double from[3], to[3], apart[3], normal[3], other[3];
        norma_core_position(mesh, norma_core_corner(mesh, i), from);
        norma_core_position(&c->other.mesh, norma_core_corner(&c->other.mesh, i), to);
        norma_core_subtract(to, from, apart);
        const int has_base = read_unit_normal(&c->base, i, normal) || directed;
        if (!read_unit_normal(&c->base, i, normal)) memcpy(normal, geometry.normal, sizeof normal);
        const int both = read_unit_normal(&c->other, i, other) && has_base;
        write_compared(c, i, norma_core_finite(to) ? c->faces[face].area_of_corner : 0,
            norma_core_finite(apart) ? norma_core_length(apart) : -1,
            both ? angle_of(other, normal) : -1, (uint32_t)face, has_base ? normal : NULL);
    }
}

static void compare_same_faces(void *context, size_t chunk) {
    const comparing *c = context;
    const size_t first = chunk * COMPARED_AT_ONCE, left = c->other.mesh.face_count - first;
    for (size_t i = 0; i < (left < COMPARED_AT_ONCE ? left : COMPARED_AT_ONCE); ++i)
        compare_same_face(c, first + i);
}

/* ---- at nearest points */

/* Near a point of the other surface: a triangle of the base, and what is asked of it for several of
 * the corners at that point. */
typedef struct near_triangle {
    const core_triangle *triangle;
    double direction[3];
    int is_interpolated;
    double normal[3]; /* of the base, at the point nearest to the corners */
    double angle;     /* between that and the own normal; negative: not known yet */
} near_triangle;

/* The corners of other at one position, one by one. */
typedef struct near_point {
    double point[3];
    double distance;
    size_t nearest; /* any number, best that of one nearby */
    size_t count;
    near_triangle near[CORE_MOST_NEAR];
    uint32_t own_number; /* of the normal of the corner at hand */
    int has_own;
    double own[3];
} near_point;

static void begin_near(const comparing *c, size_t number, near_triangle *near) {
    near->triangle = &c->tree.triangles[number];
    near->is_interpolated = 0;
    near->angle = -1;
    direction_of_triangle(near->triangle, near->direction);
}

/* Those that are as near to a point as the nearest. Returns how many there are. */
static size_t find_near(
    const comparing *c, const double point[3], near_point *at, double *distance) {
    uint32_t numbers[CORE_MOST_NEAR];
    size_t found;
    *distance = sqrt(
        norma_core_triangle_tree_around(&c->tree, point, c->slack, &at->nearest, numbers, &found));
    at->count = found < CORE_MOST_NEAR ? found : CORE_MOST_NEAR;
    for (size_t i = 0; i < at->count; ++i) begin_near(c, numbers[i], &at->near[i]);
    return found;
}

/* Where the nearest triangles are those of another side of a crease, as the corner was moved a
 * little: the nearest one that faces as the corner's face does, if it is within an eighth of the
 * face's shortest edge. */
static int find_own_side(const comparing *c, size_t face, const double point[3],
    const double facing[3], near_triangle *own) {
    const core_mesh *mesh = &c->other.mesh;
    double a[3], b[3], edge[3], shortest = INFINITY;
    for (size_t i = norma_core_face_begin(mesh, face); i < norma_core_face_end(mesh, face); ++i) {
        norma_core_position(mesh, norma_core_corner(mesh, i), a);
        norma_core_position(
            mesh, norma_core_corner(mesh, norma_core_next_in_face(mesh, face, i)), b);
        norma_core_subtract(a, b, edge);
        shortest = fmin(shortest, norma_core_dot(edge, edge));
    }
    const size_t found = norma_core_triangle_tree_facing(&c->tree, point, facing, shortest / 64);
    if (found == c->tree.count) return 0;
    begin_near(c, found, own);
    return 1;
}

static double angle_to_near(const comparing *c, const near_point *at, near_triangle *near) {
    double weights[2];
    if (!near->is_interpolated) {
        (void)norma_core_nearest_in_triangle(near->triangle, at->point, weights);
        interpolate_base(c, near->triangle, weights, near->direction, near->normal);
        near->is_interpolated = 1;
    }
    if (near->angle < 0) near->angle = at->has_own ? angle_of(at->own, near->normal) : 0;
    return near->angle;
}

/* Most corners at a position have one normal. */
static void read_own_normal(const comparing *c, size_t corner, near_point *at) {
    const uint32_t number = normal_of_corner(&c->other, corner);
    if (number == at->own_number) return;
    at->own_number = number;
    at->has_own = read_unit_normal(&c->other, corner, at->own);
    for (size_t i = 0; i < at->count; ++i) at->near[i].angle = -1;
}

/* Of triangles equally near, those that face as the corner's own face does; of these, the one whose
 * normal differs least. */
static void compare_with_near(const comparing *c, size_t corner, size_t face, near_point *at) {
    double facing[3], scores[CORE_MOST_NEAR], best = -INFINITY, least = INFINITY;
    near_triangle own_side, *near = at->near, *found = NULL;
    size_t count = at->count;
    read_own_normal(c, corner, at);
    for (int k = 0; k < 3; ++k) facing[k] = (double)c->faces[face].direction[k];
    for (size_t i = 0; i < count; ++i)
        best = fmax(best, scores[i] = norma_core_dot(near[i].direction, facing));
    if (count && best < CORE_FACES_ALIKE && find_own_side(c, face, at->point, facing, &own_side)) {
        near = &own_side;
        count = 1;
        best = scores[0] = 1;
    }
    for (size_t i = 0; i < count; ++i) {
        if (scores[i] < best - JUST_ALIKE) continue;
        const double angle = angle_to_near(c, at, &near[i]);
        if (!(angle < least)) continue;
        least = angle;
        found = &near[i];
    }
    write_compared(c, corner, c->faces[face].area_of_corner, at->distance,
        at->has_own && count ? least : -1, found ? found->triangle->face : UINT32_MAX,
        found ? found->normal : NULL);
}

/* A point of the face near its corner, where fewer triangles meet. */
static void step_into_face(
    const core_mesh *mesh, size_t face, const double corner[3], double point[3]) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    memcpy(point, corner, 3 * sizeof *point);
    for (size_t i = begin; i < end; ++i) {
        double p[3];
        norma_core_position(mesh, norma_core_corner(mesh, i), p);
        for (int k = 0; k < 3; ++k) point[k] += (p[k] - corner[k]) / (double)(end - begin) / 4;
    }
}

static void compare_nearest_point(const comparing *c, uint32_t position, near_point *at) {
    double inside[3], ignored;
    norma_core_position(&c->other.mesh, position, at->point);
    const uint32_t begin = c->corners_of.starts[position], end = c->corners_of.starts[position + 1];
    const int finite = norma_core_finite(at->point), measured = finite && c->tree.count;
    at->count = 0;
    at->distance = -1;
    const int crowded =
        begin < end && measured && find_near(c, at->point, at, &at->distance) > CORE_MOST_NEAR;
    for (uint32_t i = begin; i < end; ++i) {
        const uint32_t corner = c->corners_of.corners[i];
        const size_t face = norma_core_face_of(&c->corners_of, corner);
        if (!finite || c->faces[face].area_of_corner == 0) {
            write_compared(c, corner, 0, -1, -1, UINT32_MAX, NULL);
            continue;
        }
        if (crowded) {
            step_into_face(&c->other.mesh, face, at->point, inside);
            (void)find_near(c, inside, at, &ignored);
        }
        compare_with_near(c, corner, face, at);
    }
}

/* Points one after another near each other, however a file has them, so that the tree's boxes that
 * one needs are at hand for the next: along Morton's curve in a cube round the base (Morton 1966).
 */
static uint64_t spread_bits(uint64_t bits) {
    bits = (bits | bits << 16) & UINT64_C(0x30000ff);
    bits = (bits | bits << 8) & UINT64_C(0x300f00f);
    bits = (bits | bits << 4) & UINT64_C(0x30c30c3);
    return (bits | bits << 2) & UINT64_C(0x9249249);
}

static void order_points(const comparing *c) {
    const core_box_node *all = c->tree.boxes.nodes;
    double side = 0;
    for (int k = 0; k < 3; ++k) side = fmax(side, all->high[k] - all->low[k]);
    for (size_t i = 0; i < c->corners_of.position_count; ++i) {
        double point[3];
        uint64_t key = 0;
        norma_core_position(&c->other.mesh, (uint32_t)i, point);
        for (int k = 0; k < 3; ++k) {
            const double at = (point[k] - all->low[k]) / side * 1024;
            key |= spread_bits(at > 0 ? (uint64_t)(at < 1023 ? at : 1023) : 0) << k;
        }
        c->order[i] = key << 32 | i;
    }
    norma_core_sort_numbers(c->order, c->corners_of.position_count);
}

/* Steps are the same for any number of threads, and so is this in the end. */
static int is_endless(const comparing *c) {
    return atomic_load_explicit(&c->steps, memory_order_relaxed) > c->most_steps;
}

static void compare_nearest_points(void *context, size_t chunk) {
    const comparing *c = context;
    const size_t first = chunk * COMPARED_AT_ONCE, left = c->corners_of.position_count - first;
    near_point at = {.own_number = UINT32_MAX};
    for (size_t i = 0; i < (left < COMPARED_AT_ONCE ? left : COMPARED_AT_ONCE) && !is_endless(c);
         ++i)
        compare_nearest_point(c, (uint32_t)c->order[first + i], &at);
}

static size_t chunks_of(size_t count) { return (count + COMPARED_AT_ONCE - 1) / COMPARED_AT_ONCE; }

static norma_result compare_in_order(comparing *c) {
    const size_t count = c->corners_of.position_count;
    c->order = norma_core_allocate(&c->call, count, sizeof *c->order);
    if (!c->order) return NORMA_ERROR_MEMORY;
    order_points(c);
    norma_core_stage(&c->call, 0.5, 1);
    c->tree.steps = &c->steps;
    c->most_steps = FEW_STEPS + (unsigned long long)MOST_STEPS * (count + c->tree.count);
    const norma_result result =
        norma_core_parallel(&c->call, chunks_of(count), compare_nearest_points, c);
    norma_core_release(&c->call, c->order, count, sizeof *c->order);
    return !result && is_endless(c) ? NORMA_ERROR_OVERFLOW : result;
}

static norma_result compare_nearest(comparing *c) {
    core_mesh *other = &c->other.mesh;
    c->call.options.weld = NORMA_WELD_EXACT;
    norma_core_stage(&c->call, 0.1, 0.2);
    norma_result result = norma_core_weld(&c->call, other);
    norma_core_stage(&c->call, 0.2, 0.3);
    if (!result) result = norma_core_corners_of_position_build(&c->call, other, &c->corners_of);
    if (!result) {
        result =
            norma_core_triangle_tree_build(&c->call, &c->base.mesh, CORE_TRIANGLES_CUT, &c->tree);
        if (!result) result = compare_in_order(c);
        norma_core_triangle_tree_release(&c->call, &c->tree);
        norma_core_corners_of_position_release(&c->call, &c->corners_of);
    }
    norma_core_unweld(&c->call, other);
    return result;
}

/* ---- the call */

static norma_result compare_surfaces(comparing *c, int *same_faces) {
    const size_t faces = c->other.mesh.face_count;
    read_in_one_scale(c);
    c->slack = JUST_ALIKE * size_of_mesh(&c->base.mesh);
    c->faces = norma_core_allocate(&c->call, faces, sizeof *c->faces);
    if (!c->faces) return NORMA_ERROR_MEMORY;
    norma_core_gather(&c->call);
    norma_core_stage(&c->call, 0, 0.1);
    norma_result result =
        norma_core_parallel(&c->call, chunks_of(faces), measure_compared_faces, c);
    *same_faces = has_same_faces(c);
    norma_core_stage(&c->call, 0.1, 1);
    if (!result)
        result = *same_faces
                     ? norma_core_parallel(&c->call, chunks_of(faces), compare_same_faces, c)
                     : compare_nearest(c);
    norma_core_dismiss(&c->call);
    norma_core_release(&c->call, c->faces, faces, sizeof *c->faces);
    return result;
}

norma_result norma_compare(const norma_surface *base, const norma_surface *other,
    const norma_options *options, norma_compare_sample *samples, size_t capacity, int *same_faces) {
    comparing c = {.samples = samples};
    int same = 0;
    norma_result result = norma_core_begin(&c.call, options);
    norma_core_stage(&c.call, 0, 0);
    if (!result) result = check_surface(&c.call, base, &c.base);
    if (!result) result = check_surface(&c.call, other, &c.other);
    if (result) return result;
    if (c.other.mesh.corner_count && !samples) return NORMA_ERROR_ARGUMENT;
    if (capacity < c.other.mesh.corner_count) return NORMA_ERROR_CAPACITY;
    norma_core_share(&c.call, c.other.mesh.corner_count);
    result = compare_surfaces(&c, &same);
    if (!result && same_faces) *same_faces = same;
    return norma_core_finish(&c.call, result);
}

/* ---- percentiles of area: the areas of floats that begin with the same 16 bits are summed, then
 * those of the floats in the bin of each percentile. The bits of floats that are not negative
 * ascend as they do. All is found in two passes over the samples, which are many. */

enum { AREA_BINS = 1 << 16, SAMPLED = 2 /* angle and distance */, PERCENTILES = 2 };

static const double wanted_parts[PERCENTILES] = {0.5, 0.99};

typedef struct percentile {
    double passed;          /* area before the bin that was found */
    uint32_t first, second; /* that bin: halves of the float's bits */
    uint32_t last;          /* second half of any float that begins with the first */
    double *bins;
} percentile;

typedef struct sampled { /* angles, or distances */
    double area, most;
    double *bins; /* by the first half of the bits */
    percentile percentiles[PERCENTILES];
} sampled;

/* Negative: none. */
static float sampled_value(const norma_compare_sample *s, int distance) {
    return (distance ? s->distance : s->angle_rad) + 0.0F;
}

static uint32_t bits_of_float(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static void sum_samples(const norma_compare_sample *samples, size_t count, double max_angle_rad,
    norma_comparison *sum, sampled all[SAMPLED]) {
    double above = 0;
    for (size_t i = 0; i < count; ++i) {
        const norma_compare_sample *s = &samples[i];
        const float angle = sampled_value(s, 0);
        if (!(s->area > 0)) continue;
        sum->area += s->area;
        ++*(angle >= 0 ? &sum->corners : &sum->missing);
        above += angle >= 0 && (double)angle <= max_angle_rad + 1e-6 ? 0 : s->area;
        if (angle >= 0 && (sum->worst == SIZE_MAX || angle > samples[sum->worst].angle_rad))
            sum->worst = i;
        for (int which = 0; which < SAMPLED; ++which) {
            const float value = sampled_value(s, which);
            if (!(value >= 0)) continue;
            all[which].area += s->area;
            all[which].most = fmax(all[which].most, (double)value);
            all[which].bins[bits_of_float(value) >> 16] += s->area;
        }
    }
    sum->share_above = sum->area > 0 ? fmin(above / sum->area, 1) : 0;
}

static void sum_within_bins(
    const norma_compare_sample *samples, size_t count, sampled all[SAMPLED]) {
    for (size_t i = 0; i < count; ++i)
        for (int which = 0; which < SAMPLED; ++which) {
            const float value = sampled_value(&samples[i], which);
            const uint32_t bits = bits_of_float(value), second = bits & 0xffff;
            if (!(samples[i].area > 0) || !(value >= 0)) continue;
            for (int k = 0; k < PERCENTILES; ++k) {
                percentile *p = &all[which].percentiles[k];
                if (bits >> 16 != p->first) continue;
                p->bins[second] += samples[i].area;
                p->last = second > p->last ? second : p->last;
            }
        }
}

/* The bin in which part of an area is passed; passed: the area before it. */
static uint32_t pass_bins(const double *bins, uint32_t last, double wanted, double *passed) {
    uint32_t bin = 0;
    while (bin < last && *passed + bins[bin] < wanted) *passed += bins[bin++];
    return bin;
}

static double percentile_value(const percentile *p) {
    const uint32_t bits = p->first << 16 | p->second;
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

/* bins: zero, SAMPLED * (1 + PERCENTILES) times AREA_BINS. */
static void sum_up(const norma_compare_sample *samples, size_t count, double max_angle_rad,
    double *bins, norma_comparison *sum) {
    sampled all[SAMPLED] = {{.bins = bins}, {.bins = bins + AREA_BINS}};
    bins += SAMPLED * AREA_BINS;
    sum_samples(samples, count, max_angle_rad, sum, all);
    for (int i = 0; i < SAMPLED * PERCENTILES; ++i, bins += AREA_BINS) {
        sampled *s = &all[i / PERCENTILES];
        percentile *p = &s->percentiles[i % PERCENTILES];
        p->bins = bins;
        p->first = pass_bins(s->bins, bits_of_float((float)s->most) >> 16,
            wanted_parts[i % PERCENTILES] * s->area, &p->passed);
    }
    sum_within_bins(samples, count, all);
    for (int i = 0; i < SAMPLED * PERCENTILES; ++i) {
        sampled *s = &all[i / PERCENTILES];
        percentile *p = &s->percentiles[i % PERCENTILES];
        p->second =
            pass_bins(p->bins, p->last, wanted_parts[i % PERCENTILES] * s->area, &p->passed);
    }
    const percentile *angle = all[0].percentiles, *distance = all[1].percentiles;
    sum->p50_rad = percentile_value(&angle[0]);
    sum->p99_rad = percentile_value(&angle[1]);
    sum->max_rad = all[0].most;
    sum->p50_distance = percentile_value(&distance[0]);
    sum->p99_distance = percentile_value(&distance[1]);
    sum->max_distance = all[1].most;
}

norma_result norma_compare_summary(const norma_compare_sample *samples, size_t count,
    double max_angle_rad, const norma_options *options, norma_comparison *comparison) {
    enum { BINS = SAMPLED * (1 + PERCENTILES) * AREA_BINS };
    core_call call;
    const norma_result result = norma_core_begin(&call, options);
    if (result) return result;
    if (!comparison || (count && !samples) || !(max_angle_rad >= 0)) return NORMA_ERROR_ARGUMENT;
    double *bins = norma_core_allocate(&call, BINS, sizeof *bins);
    if (!bins) return NORMA_ERROR_MEMORY;
    norma_comparison sum = {.worst = SIZE_MAX};
    memset(bins, 0, BINS * sizeof *bins);
    sum_up(samples, count, max_angle_rad, bins, &sum);
    norma_core_release(&call, bins, BINS, sizeof *bins);
    *comparison = sum;
    return NORMA_OK;
}
