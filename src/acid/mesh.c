/* mesh.c: meshes of patches, and small pictures of them. A subject's mesh is the surface taken back
 * through the transform that its node, instance, skin or morph applies: positions by the inverse,
 * normals by the transpose. A reference is that mesh posed in numbers, as a renderer would that
 * makes one mistake. */
#include "acid/acid.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- vectors and 3x3 matrices of doubles: sums, products, quotients and square roots only, which
 * give the same bits everywhere */

typedef struct acid_matrix {
    acid_vector column[3];
} acid_matrix;

static acid_vector acid_scaled(acid_vector a, double s) {
    return (acid_vector){s * a.x, s * a.y, s * a.z};
}
static acid_vector acid_sum(acid_vector a, acid_vector b) {
    return (acid_vector){a.x + b.x, a.y + b.y, a.z + b.z};
}
static acid_vector acid_minus(acid_vector a, acid_vector b) {
    return (acid_vector){a.x - b.x, a.y - b.y, a.z - b.z};
}
static double acid_dot(acid_vector a, acid_vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static acid_vector acid_cross(acid_vector a, acid_vector b) {
    return (acid_vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static double acid_length(acid_vector a) { return sqrt(acid_dot(a, a)); }
static acid_vector acid_unit(acid_vector a) { return acid_scaled(a, 1 / acid_length(a)); }

static acid_vector acid_times(const acid_matrix *m, acid_vector v) {
    return acid_sum(acid_sum(acid_scaled(m->column[0], v.x), acid_scaled(m->column[1], v.y)),
        acid_scaled(m->column[2], v.z));
}
static acid_vector acid_transposed_times(const acid_matrix *m, acid_vector v) {
    return (acid_vector){
        acid_dot(m->column[0], v), acid_dot(m->column[1], v), acid_dot(m->column[2], v)};
}
static acid_matrix acid_product(const acid_matrix *a, const acid_matrix *b) {
    return (acid_matrix){
        {acid_times(a, b->column[0]), acid_times(a, b->column[1]), acid_times(a, b->column[2])}};
}
static acid_matrix acid_cofactors(const acid_matrix *m) {
    return (acid_matrix){{acid_cross(m->column[1], m->column[2]),
        acid_cross(m->column[2], m->column[0]), acid_cross(m->column[0], m->column[1])}};
}
static double acid_determinant(const acid_matrix *m) {
    return acid_dot(m->column[0], acid_cross(m->column[1], m->column[2]));
}
/* The transpose of the cofactors over the determinant, times v. */
static acid_vector acid_solve(const acid_matrix *m, acid_vector v) {
    const acid_matrix c = acid_cofactors(m);
    return acid_scaled(acid_transposed_times(&c, v), 1 / acid_determinant(m));
}

/* ---- the height field: an egg with a ridge and a dent, like none of its mirror images or turns */

/* Over the square from -1 to 1 in x and y, and its slopes. */
typedef struct acid_relief {
    double height, along_x, along_y;
} acid_relief;

/* sin 30 degrees to +x, and at 120 and 240 degrees from there. */
const acid_vector acid_lights[ACID_LIGHTS] = {
    {0.5, 0, 0.86602540378443865},
    {-0.25, 0.43301270189221932, 0.86602540378443865},
    {-0.25, -0.43301270189221932, 0.86602540378443865},
};

/* height / (1 + steepness q)^2, q a square, and the slope of that by q. */
static double bump(double height, double steepness, double q, double *by_q) {
    const double d = 1 / (1 + steepness * q), d2 = d * d;
    *by_q = -2 * steepness * height * d2 * d;
    return height * d2;
}

static acid_relief acid_surface(double x, double y) {
    acid_relief relief = {0.36 - 0.44 * x * x - 0.36 * y * y - 0.10 * x * x * x + 0.08 * x * y * y,
        -0.88 * x - 0.30 * x * x + 0.08 * y * y, -0.72 * y + 0.16 * x * y};
    const double across = y - 0.5 * x - 0.35; /* the ridge */
    double by_q;
    relief.height += bump(0.16, 9, across * across, &by_q);
    relief.along_x += by_q * -1.0 * across;
    relief.along_y += by_q * 2.0 * across;
    const double dx = x - 0.30, dy = y + 0.40; /* the dent */
    relief.height += bump(-0.30, 5, dx * dx + dy * dy, &by_q);
    relief.along_x += by_q * 2 * dx;
    relief.along_y += by_q * 2 * dy;
    return relief;
}

static acid_vector acid_surface_normal(const acid_relief *relief) {
    return acid_unit((acid_vector){-relief->along_x, -relief->along_y, 1});
}

/* ---- a patch's memory */

enum { ACID_FACETS_ACROSS = 8, ACID_FACET_PARTS = 4 };

static int allocate_patch(acid_patch *patch, size_t vertices, size_t indices) {
    *patch = (acid_patch){.vertices = calloc(vertices, sizeof *patch->vertices),
        .indices = calloc(indices, sizeof *patch->indices),
        .vertex_count = vertices,
        .index_count = indices};
    return patch->vertices && patch->indices;
}

void acid_free_patch(acid_patch *patch) {
    free(patch->vertices);
    free(patch->indices);
    free(patch->texels);
    *patch = (acid_patch){0};
}

static acid_vector from_floats(const float v[3]) {
    return (acid_vector){(double)v[0], (double)v[1], (double)v[2]};
}

static void round_vector(acid_vector v, float out[3]) {
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

/* ---- the surface in the world, about the patch's centre */

typedef struct acid_spot {
    double x, y;
    acid_vector position, normal, along_u; /* position and frame of what is drawn */
    acid_vector shaded;                    /* the normal after its map; without one: normal */
} acid_spot;

/* Normal-mapped patches are nearly flat: what is seen comes from the map. Less so where normals
 * themselves may be wrong. */
static double height_under_map(const acid_cell *cell) {
    if (cell->map == ACID_MAP_ALONE) return 0.1; /* MikkTSpace's tangents are nearly these */
    return cell->way == ACID_SKIN ? 0.45 : 0.2;
}

static acid_spot surface_spot(const acid_cell *cell, double x, double y, double direction) {
    acid_relief relief = acid_surface(x, y);
    acid_spot spot = {.x = x, .y = y, .shaded = acid_surface_normal(&relief)};
    if (cell->map) {
        const double share = height_under_map(cell);
        relief.height *= share;
        relief.along_x *= share;
        relief.along_y *= share;
    }
    spot.position = acid_scaled((acid_vector){x, y, relief.height}, ACID_HALF);
    spot.normal = acid_surface_normal(&relief);
    spot.along_u = acid_scaled(acid_unit((acid_vector){1, 0, relief.along_x}), direction);
    return spot;
}

/* Corners of facets lie above or below a flatter egg, as by chance. */
static double facet_corner(int column, int row) {
    const double step = 2.0 / ACID_FACETS_ACROSS;
    const acid_relief relief = acid_surface(-1 + step * column, -1 + step * row);
    const int above = (5 * column + 3 * row + column * row) % 7 % 2;
    return 0.4 * relief.height + (above ? 0.17 : -0.17);
}

/* Where a column or row of vertices lies, counted in facets: their outer parts are wider, so that
 * smoothing, which turns normals there, shows in most of each. */
static double facet_place(int index) {
    static const double parts[ACID_FACET_PARTS] = {0, 0.35, 0.5, 0.65};
    return index / ACID_FACET_PARTS + parts[index % ACID_FACET_PARTS];
}

/* The height within a facet: each square of corners is two facets, cut from the lower left. */
static double facet_height(int column, int row) {
    const int i = column / ACID_FACET_PARTS, j = row / ACID_FACET_PARTS;
    const double s = facet_place(column) - i, t = facet_place(row) - j;
    const double a = facet_corner(i, j), b = facet_corner(i + 1, j), c = facet_corner(i, j + 1),
                 d = facet_corner(i + 1, j + 1);
    return s >= t ? a + s * (b - a) + t * (d - b) : a + t * (c - a) + s * (d - c);
}

/* ---- the transform that acts on a vertex */

static acid_matrix acid_step_matrix(const acid_step *step) {
    double q[4];
    acid_step_rotation(step, q);
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const acid_matrix turn = {{{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
        {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
        {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}}};
    acid_matrix m;
    for (int k = 0; k < 3; ++k) m.column[k] = acid_scaled(turn.column[k], step->scale[k]);
    return m;
}

static double joint_weight(double x) { return 0.5 - 0.25 * x; } /* of the first of two */

static acid_matrix blended_joints(const acid_cell *cell, double weight) {
    acid_matrix m = acid_step_matrix(&cell->steps[0]);
    if (cell->way == ACID_SKIN && cell->step_count == 2) {
        const acid_matrix second = acid_step_matrix(&cell->steps[1]);
        for (int k = 0; k < 3; ++k)
            m.column[k] = acid_sum(
                acid_scaled(m.column[k], weight), acid_scaled(second.column[k], 1 - weight));
    }
    return m;
}

static acid_matrix pose_of(const acid_cell *cell, double weight) {
    static const acid_matrix identity = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    if (!cell->step_count) return identity;
    acid_matrix m = blended_joints(cell, weight);
    if (cell->way == ACID_NODES && cell->step_count == 2) {
        const acid_matrix child = acid_step_matrix(&cell->steps[1]);
        m = acid_product(&m, &child);
    }
    return m;
}

/* ---- from the world to the mesh */

/* A singular matrix keeps the plane that its third column's turn is perpendicular to: the surface
 * lies in that plane once drawn, and has the height field's heights above it before. */
static void unflatten(const acid_cell *cell, const acid_spot *spot, acid_vertex *vertex) {
    acid_step turn = cell->steps[0];
    for (int k = 0; k < 3; ++k) turn.scale[k] = 1;
    const acid_matrix r = acid_step_matrix(&turn);
    const acid_vector up = r.column[2];
    const double by_x = -up.x / up.z, by_y = -up.y / up.z;
    const acid_relief relief = acid_surface(spot->x, spot->y);
    acid_vector p =
        acid_transposed_times(&r, (acid_vector){spot->x, spot->y, by_x * spot->x + by_y * spot->y});
    acid_vector u = acid_transposed_times(&r, (acid_vector){1, 0, by_x}),
                v = acid_transposed_times(&r, (acid_vector){0, 1, by_y});
    p.z = relief.height;
    u.z = relief.along_x;
    v.z = relief.along_y;
    round_vector(acid_scaled(p, ACID_HALF), vertex->position);
    round_vector(acid_unit(acid_cross(u, v)), vertex->normal);
}

static void unpose(
    const acid_cell *cell, const acid_spot *spot, double handedness, acid_vertex *vertex) {
    const acid_matrix m = pose_of(cell, (double)vertex->weights[0]);
    const double determinant = acid_determinant(&m);
    if (determinant == 0) {
        unflatten(cell, spot, vertex);
        return;
    }
    const acid_vector tangent = acid_unit(acid_solve(&m, spot->along_u));
    round_vector(acid_solve(&m, spot->position), vertex->position);
    round_vector(acid_unit(acid_transposed_times(&m, spot->normal)), vertex->normal);
    round_vector(tangent, vertex->tangent);
    vertex->tangent[3] = (float)(determinant < 0 ? -handedness : handedness);
}

/* The mesh before the target acts is another surface: this one's mirror image. */
static void unmorph(const acid_spot *spot, acid_vertex *vertex) {
    const double weight = 0.7, length = 0.3;
    const acid_relief relief = acid_surface(-spot->x, spot->y);
    const acid_vector position =
        acid_scaled((acid_vector){spot->x, spot->y, relief.height}, ACID_HALF);
    acid_vector normal = acid_surface_normal(&relief);
    normal.x = -normal.x;
    round_vector(position, vertex->position);
    round_vector(normal, vertex->normal);
    round_vector(acid_scaled(acid_minus(spot->position, position), 1 / weight), vertex->moved);
    round_vector(acid_scaled(acid_minus(acid_scaled(spot->normal, length), normal), 1 / weight),
        vertex->turned);
}

static void round_to_bytes(acid_vertex *vertex) {
    for (int k = 0; k < 3; ++k) {
        vertex->position[k] = (float)floor((double)vertex->position[k] + 0.5);
        vertex->normal[k] = (float)floor(127 * (double)vertex->normal[k] + 0.5) / 127;
    }
}

/* ---- normal maps: a texel for each vertex */

/* For normalTexture.scale, slopes that are nearly as steep everywhere, so that twice and half of
 * them can be told apart. */
static acid_vector steep_texel(double x, double y) {
    const acid_relief relief = acid_surface(x, y);
    const double steepness =
        0.84 / sqrt(relief.along_x * relief.along_x + relief.along_y * relief.along_y + 1e-3);
    return (acid_vector){-steepness * relief.along_x, -steepness * relief.along_y, 1};
}

static void write_texel(
    const acid_cell *cell, const acid_spot *spot, double handedness, uint8_t texel[3]) {
    const acid_vector across = acid_scaled(acid_cross(spot->normal, spot->along_u), handedness);
    acid_vector m = {acid_dot(spot->along_u, spot->shaded), acid_dot(across, spot->shaded),
        acid_dot(spot->normal, spot->shaded)};
    if (cell->normal_scale > 0) m = steep_texel(spot->x, spot->y);
    m = acid_unit(m);
    const double sample[3] = {m.x, m.y, m.z};
    for (int k = 0; k < 3; ++k) texel[k] = (uint8_t)floor((sample[k] + 1) / 2 * 255 + 0.5);
}

/* A texel's place and the texture coordinates of its middle; rows run from the image's top. */
static size_t place_texel(
    const acid_cell *cell, const acid_patch *patch, size_t column, size_t row, float uv[2]) {
    const size_t from =
        (size_t)(cell->mirrored_from ? cell->mirrored_from + 1 : (int)patch->columns);
    const size_t i = column < from ? column : patch->columns - 1 - (column - from),
                 j = patch->rows - 1 - row;
    uv[0] = (float)(((double)i + 0.5) / (double)patch->columns);
    uv[1] = (float)(((double)j + 0.5) / (double)patch->rows);
    return 3 * (j * patch->columns + i);
}

/* ---- grids */

static int quads_across(const acid_cell *cell) {
    return cell->way == ACID_FLAT ? ACID_FACETS_ACROSS * ACID_FACET_PARTS : ACID_SUBDIVIDED;
}

static double place_across(const acid_cell *cell, int index) { /* 0 to 1 */
    return cell->way == ACID_FLAT ? facet_place(index) / ACID_FACETS_ACROSS
                                  : (double)index / ACID_SUBDIVIDED;
}

/* Whether triangles must run the other way round for their front to be seen: glTF reverses them
 * under a node that mirrors. Of a skin it leaves open whether joints count; so where they mirror,
 * the skinned node does as well. */
static int runs_backwards(const acid_cell *cell) {
    const acid_matrix m = pose_of(cell, 0.5);
    if (cell->way == ACID_BACK) return 1;
    return acid_determinant(&m) < 0;
}

static void write_indices(const acid_cell *cell, acid_patch *patch) {
    const size_t backwards = (size_t)runs_backwards(cell), seam = (size_t)cell->mirrored_from;
    uint16_t *at = patch->indices;
    for (size_t row = 0; row + 1 < patch->rows; ++row)
        for (size_t column = 0; column + 1 < patch->columns; ++column) {
            if (cell->mirrored_from && column == seam) continue;
            const size_t a = row * patch->columns + column, c = a + 1 + patch->columns;
            const size_t corners[6] = {a, a + 1, c, a, c, a + patch->columns};
            for (size_t k = 0; k < 6; ++k)
                at[k] = (uint16_t)corners[backwards && k % 3 ? k ^ (k < 3 ? 3 : 1) : k];
            at += 6;
        }
}

static void make_vertex(
    const acid_cell *cell, acid_patch *patch, size_t column, size_t row, acid_vertex *vertex) {
    const int mirrored = cell->mirrored_from && (int)column > cell->mirrored_from;
    const double direction = mirrored ? -1 : 1;
    const int i = (int)column - mirrored;
    const acid_spot spot = surface_spot(
        cell, -1 + 2 * place_across(cell, i), -1 + 2 * place_across(cell, (int)row), direction);
    vertex->weights[0] = cell->step_count == 2 ? (float)joint_weight(spot.x) : 1;
    vertex->weights[1] = 1 - vertex->weights[0];
    unpose(cell, &spot, direction, vertex);
    if (cell->way == ACID_MORPH) unmorph(&spot, vertex);
    if (cell->way == ACID_BYTES) round_to_bytes(vertex);
    if (cell->way == ACID_FLAT)
        vertex->position[2] = (float)(ACID_HALF * facet_height(i, (int)row));
    for (int k = 0; k < 3 && cell->way == ACID_BACK; ++k) vertex->normal[k] = -vertex->normal[k];
    if (cell->map) {
        uint8_t *texel = patch->texels + place_texel(cell, patch, column, row, vertex->uv);
        write_texel(cell, &spot, direction, texel);
    }
}

int acid_make_subject(const acid_cell *cell, acid_patch *patch) {
    const size_t quads = (size_t)quads_across(cell), rows = quads + 1,
                 columns = rows + (cell->mirrored_from > 0);
    const int made = allocate_patch(patch, columns * rows, 6 * quads * quads);
    patch->columns = columns;
    patch->rows = rows;
    patch->texels = cell->map ? calloc(columns * rows, 3) : NULL;
    if (!made || (cell->map && !patch->texels)) {
        acid_free_patch(patch);
        return 0;
    }
    for (size_t row = 0; row < rows; ++row)
        for (size_t column = 0; column < columns; ++column)
            make_vertex(cell, patch, column, row, &patch->vertices[row * columns + column]);
    write_indices(cell, patch);
    return 1;
}

/* ---- the same in the world, with mistakes */

static acid_vector by_normal_matrix(const acid_matrix *m, acid_vector n) {
    const acid_matrix c = acid_cofactors(m);
    return acid_scaled(acid_times(&c, n), acid_determinant(m) < 0 ? -1 : 1);
}

/* M (n / s^2), s the lengths of M's columns: what serves for a rotation of a scale. */
static acid_vector by_separate_scale(const acid_matrix *m, acid_vector n) {
    return acid_times(m, (acid_vector){n.x / acid_dot(m->column[0], m->column[0]),
                             n.y / acid_dot(m->column[1], m->column[1]),
                             n.z / acid_dot(m->column[2], m->column[2])});
}

static acid_vector by_own_node(const acid_cell *cell, acid_vector n) {
    const acid_matrix own = acid_step_matrix(&cell->own);
    return by_normal_matrix(&own, acid_unit(n));
}

/* Skins relative to the node, by plain matrices: its inverse acts as a matrix of positions, and
 * then its normal matrix, which is not the inverse of that. */
static acid_vector by_own_node_twice(const acid_cell *cell, acid_vector n) {
    const acid_matrix own = acid_step_matrix(&cell->own);
    return by_own_node(cell, acid_solve(&own, n));
}

/* The normal as the renderer lights it, before its map; not of unit length where that is the
 * mistake. */
static acid_vector posed_normal(
    const acid_cell *cell, const acid_vertex *vertex, const acid_matrix *m, acid_fault fault) {
    acid_vector n = from_floats(vertex->normal);
    if (cell->way == ACID_MORPH && fault != ACID_NOT_MORPHED)
        n = acid_sum(n, acid_scaled(from_floats(vertex->turned), 0.7));
    const acid_vector right = by_normal_matrix(m, n);
    acid_matrix joint;
    switch (fault) {
    case ACID_OBJECT_SPACE:
    case ACID_INSTANCE_IGNORED:
        return acid_unit(n);
    case ACID_NOT_NORMALIZED:
        return acid_scaled(right, 1 / fabs(acid_determinant(m)));
    case ACID_MODEL_MATRIX:
        return acid_unit(acid_times(m, n));
    case ACID_SEPARATE_SCALE:
        return acid_unit(by_separate_scale(m, n));
    case ACID_REVERSED:
        return acid_scaled(acid_unit(right), -1);
    case ACID_NODE_APPLIED:
        return acid_unit(by_own_node(cell, right));
    case ACID_NODE_NOT_CANCELLED:
        return acid_unit(by_own_node_twice(cell, acid_times(m, n)));
    case ACID_STRONGEST_JOINT:
        joint = acid_step_matrix(&cell->steps[vertex->weights[1] > vertex->weights[0]]);
        return acid_unit(by_normal_matrix(&joint, n));
    case ACID_NOT_FLIPPED:
        return acid_unit(right);
    default:
        return acid_unit(cell->way == ACID_BACK ? acid_scaled(right, -1) : right);
    }
}

static acid_vector perturbed(const acid_cell *cell, const acid_vertex *vertex, const acid_matrix *m,
    acid_fault fault, acid_vector normal, const uint8_t texel[3]) {
    const acid_vector local = from_floats(vertex->tangent);
    const acid_vector tangent = acid_unit(
        fault == ACID_TANGENT_BY_NORMAL_MATRIX ? by_normal_matrix(m, local) : acid_times(m, local));
    double sign = fault == ACID_SIGN_LOST ? 1 : (double)vertex->tangent[3];
    if (fault != ACID_SIGN_KEPT && acid_determinant(m) < 0) sign = -sign;
    acid_vector sample = {
        texel[0] / 255.0 * 2 - 1, texel[1] / 255.0 * 2 - 1, texel[2] / 255.0 * 2 - 1};
    if (cell->normal_scale > 0 && fault == ACID_SCALE_ON_Z) {
        sample.z *= cell->normal_scale;
    } else if (cell->normal_scale > 0 && fault != ACID_SCALE_IGNORED) {
        sample.x *= cell->normal_scale;
        sample.y *= cell->normal_scale;
    }
    if (fault == ACID_GREEN_FLIPPED) sample.y = -sample.y;
    const acid_vector across = acid_scaled(acid_cross(normal, tangent), sign);
    return acid_unit(
        acid_sum(acid_sum(acid_scaled(tangent, sample.x), acid_scaled(across, sample.y)),
            acid_scaled(normal, sample.z)));
}

/* A normal that is too long or too short makes light stronger or weaker, up to the most that a
 * renderer counts: told by the colour of the vertex, since NORMAL must be of unit length. */
static void color_by_length(const acid_cell *cell, acid_vector n, float color[3]) {
    const double white = acid_white(cell), length = acid_length(n);
    for (int k = 0; k < ACID_LIGHTS; ++k) {
        const double lit = acid_dot(acid_lights[k], n) / length,
                     factor = lit * length > 1 ? 1 / lit : length;
        color[k] = (float)fmin(1, white * factor);
    }
}

static void pose_vertex(const acid_cell *cell, const acid_patch *subject, size_t index,
    acid_fault fault, acid_vertex *out) {
    const acid_vertex *vertex = &subject->vertices[index];
    const acid_matrix m = pose_of(cell, (double)vertex->weights[0]);
    acid_vector p = from_floats(vertex->position), n;
    if (cell->way == ACID_MORPH) p = acid_sum(p, acid_scaled(from_floats(vertex->moved), 0.7));
    round_vector(acid_times(&m, p), out->position);
    n = posed_normal(cell, vertex, &m, fault);
    if (cell->map) {
        float uv[2];
        const size_t texel =
            place_texel(cell, subject, index % subject->columns, index / subject->columns, uv);
        n = perturbed(cell, vertex, &m, fault, n, subject->texels + texel);
    }
    if (fault == ACID_NOT_NORMALIZED) {
        color_by_length(cell, n, out->color);
        out->length = (float)acid_length(n);
    }
    round_vector(acid_unit(n), out->normal);
}

/* ---- a mesh without NORMAL */

static acid_vector facet_normal(const acid_patch *patch, const uint16_t corner[3]) {
    const acid_vector a = from_floats(patch->vertices[corner[0]].position),
                      b = from_floats(patch->vertices[corner[1]].position),
                      c = from_floats(patch->vertices[corner[2]].position);
    return acid_cross(acid_minus(b, a), acid_minus(c, a));
}

static int make_flat_faces(const acid_patch *subject, acid_patch *patch) {
    if (!allocate_patch(patch, subject->index_count, subject->index_count)) return 0;
    for (size_t i = 0; i < subject->index_count; ++i) {
        const acid_vector n = facet_normal(subject, subject->indices + i / 3 * 3);
        patch->vertices[i] = subject->vertices[subject->indices[i]];
        round_vector(acid_unit(n), patch->vertices[i].normal);
        patch->indices[i] = (uint16_t)i;
    }
    return 1;
}

/* Sums of area vectors, as engines make normals. */
static int make_smoothed(const acid_patch *subject, acid_patch *patch) {
    acid_vector *sums = calloc(subject->vertex_count, sizeof *sums);
    if (!sums || !allocate_patch(patch, subject->vertex_count, subject->index_count)) {
        free(sums);
        return 0;
    }
    for (size_t i = 0; i < subject->index_count; ++i) {
        acid_vector *sum = &sums[subject->indices[i]];
        *sum = acid_sum(*sum, facet_normal(subject, subject->indices + i / 3 * 3));
        patch->indices[i] = subject->indices[i];
    }
    for (size_t i = 0; i < subject->vertex_count; ++i) {
        patch->vertices[i] = subject->vertices[i];
        round_vector(acid_unit(sums[i]), patch->vertices[i].normal);
    }
    free(sums);
    return 1;
}

static int make_posed(
    const acid_cell *cell, const acid_patch *subject, acid_fault fault, acid_patch *patch) {
    if (!allocate_patch(patch, subject->vertex_count, subject->index_count)) return 0;
    patch->has_color = fault == ACID_NOT_NORMALIZED || fault == ACID_LOST; /* of LOST: black */
    for (size_t i = 0; i < subject->vertex_count; ++i)
        pose_vertex(cell, subject, i, fault, &patch->vertices[i]);
    const size_t backwards = (size_t)runs_backwards(cell);
    for (size_t i = 0; i < subject->index_count; i += 3) {
        patch->indices[i] = subject->indices[i];
        patch->indices[i + 1] = subject->indices[i + 1 + backwards];
        patch->indices[i + 2] = subject->indices[i + 2 - backwards];
    }
    return 1;
}

int acid_make_reference(
    const acid_cell *cell, const acid_patch *subject, acid_fault fault, acid_patch *patch) {
    int made;
    if (cell->way != ACID_FLAT)
        made = make_posed(cell, subject, fault, patch);
    else
        made = fault == ACID_SMOOTHED ? make_smoothed(subject, patch)
                                      : make_flat_faces(subject, patch);
    if (!made) acid_free_patch(patch);
    return made;
}

/* ---- a patch as a small picture, seen from +z in the lights of the scene. Square roots encode it,
 * not sRGB's powers: the same bytes everywhere */

static void shade(const acid_patch *patch, double white, const acid_vertex *const corners[3],
    const double shares[3], uint8_t pixel[3]) {
    double n[3] = {0}, color[3] = {0};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            n[k] += shares[i] * (double)corners[i]->normal[k];
            color[k] += shares[i] * (double)corners[i]->color[k];
        }
    const acid_vector normal = acid_unit((acid_vector){n[0], n[1], n[2]});
    for (int k = 0; k < ACID_LIGHTS; ++k) {
        const double lit =
            (patch->has_color ? color[k] : white) * fmax(0, acid_dot(acid_lights[k], normal));
        pixel[k] = (uint8_t)(255 * sqrt(fmin(1, lit)) + 0.5);
    }
}

/* Of a and b about c: twice their triangle's area, above 0 if they run counterclockwise. */
static double area_of(const double a[2], const double b[2], const double c[2]) {
    return (a[0] - c[0]) * (b[1] - c[1]) - (a[1] - c[1]) * (b[0] - c[0]);
}

static void draw_triangle(
    const acid_patch *patch, double white, const uint16_t *indices, int side, uint8_t *pixels) {
    const acid_vertex *corners[3];
    double at[3][2], low[2] = {side, side}, high[2] = {0, 0};
    for (int i = 0; i < 3; ++i) {
        corners[i] = &patch->vertices[indices[i]];
        for (int k = 0; k < 2; ++k) {
            const double along = (double)corners[i]->position[k] / (2 * ACID_HALF);
            at[i][k] = side * (k ? 0.5 - along : 0.5 + along);
            low[k] = fmax(0, fmin(low[k], floor(at[i][k])));
            high[k] = fmin(side, fmax(high[k], ceil(at[i][k])));
        }
    }
    const double area = area_of(at[0], at[1], at[2]);
    for (int y = (int)low[1]; y < (int)high[1] && area != 0; ++y)
        for (int x = (int)low[0]; x < (int)high[0]; ++x) {
            const double p[2] = {x + 0.5, y + 0.5},
                         shares[3] = {area_of(at[1], at[2], p) / area,
                             area_of(at[2], at[0], p) / area, area_of(at[0], at[1], p) / area};
            if (fmin(shares[0], fmin(shares[1], shares[2])) >= 0)
                shade(patch, white, corners, shares, pixels + 3 * (y * side + x));
        }
}

void acid_draw_patch(const acid_patch *patch, double white, int side, uint8_t *pixels) {
    for (size_t i = 0; i < patch->index_count; i += 3)
        draw_triangle(patch, white, patch->indices + i, side, pixels);
}
