/* face_kernel.template.h: faces measured and weighed, as many at once as a register has lanes.
 * Included by a file for each instruction set, which says with VECTORS(name), FOR_VECTORS and
 * IN_VECTORS whose vectors these are, and calls the two types vector and mask. The operations are
 * those of face.h and face_geometry.c, hence the bits. Values stay in registers; loops over lanes
 * would write what each step leaves and read it again. */
#include "core/face/face.h"

IN_VECTORS vector dot_product(const vector a[3], const vector b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

IN_VECTORS void cross_product(const vector a[3], const vector b[3], vector out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

IN_VECTORS mask is_between(vector x) {
    return VECTORS(both)(VECTORS(is_less)(VECTORS(all)(NORMA_TINIEST), x),
        VECTORS(is_less)(x, VECTORS(all)(NORMA_HUGEST)));
}

/* norma_core_triangle_is_sure */
IN_VECTORS mask are_sure(vector square, vector dot) {
    return VECTORS(both)(is_between(square),
        VECTORS(is_at_most)(VECTORS(all)(0x1p-40) * (square + dot * dot), square));
}

/* norma_core_slope; below is returned. */
IN_VECTORS vector slope_of(vector y, vector x, vector *above, vector *turn) {
    const vector small = VECTORS(lesser)(y, x), large = VECTORS(greater)(x, y);
    const mask steep = VECTORS(is_less)(VECTORS(all)(0.41421356237309503) * large, small),
               falls = VECTORS(is_less)(x, y);
    *above = VECTORS(choose)(steep, y - x, VECTORS(choose)(falls, VECTORS(negative)(x), y));
    *turn = VECTORS(choose)(steep, VECTORS(all)(0.25 * NORMA_PI),
        VECTORS(choose)(falls, VECTORS(all)(0.5 * NORMA_PI), VECTORS(all)(0)));
    return VECTORS(choose)(steep, small + large, large);
}

/* ---- triangles. The two smaller angles by arc tangents, the largest as what they leave of pi,
 * which loses nothing since it is at least pi/3; its corner is that of the least dot product. One
 * division serves the two quotients: dividing is the slowest of all that is done here. */

/* Cross product and its length, dot products of the corners' edges, squares of the edges opposite
 * to them where the weight needs them, and which triangles doubles decide. */
typedef struct opened_faces {
    vector normal[3], length, dots[3], squares[3];
    mask sure;
} opened_faces;

/* Two of the angles, each turn + atan(tangent), and which corner has which. */
typedef struct sloped_faces {
    vector tangent[2], turn[2];
    mask first_is_0, least_is_2, second_is_least, third_is_least;
} sloped_faces;

/* u, v: the edges from the first corner to the second and third; w: from the second to the third.
 */
IN_VECTORS void open_edges(
    const vector u[3], const vector v[3], const vector w[3], norma_weight weight, opened_faces *o) {
    cross_product(u, v, o->normal);
    const vector square = dot_product(o->normal, o->normal);
    o->length = VECTORS(root)(square);
    o->dots[0] = dot_product(u, v);
    o->sure = are_sure(square, o->dots[0]);
    if (core_weighed(weight) == CORE_BY_ANGLE) {
        o->dots[1] = VECTORS(negative)(dot_product(u, w));
        o->dots[2] = dot_product(v, w);
    }
    if (core_weighed(weight) != CORE_BY_FACE && weight != NORMA_WEIGHT_ANGLE) {
        o->squares[0] = dot_product(w, w);
        o->squares[1] = dot_product(v, v);
        o->squares[2] = dot_product(u, u);
    }
}

/* p: of each corner, its three axes. */
IN_VECTORS void open_points(vector p[3][3], norma_weight weight, opened_faces *o) {
    vector u[3], v[3], w[3];
    for (int x = 0; x < 3; ++x) {
        u[x] = p[1][x] - p[0][x];
        v[x] = p[2][x] - p[0][x];
        w[x] = p[2][x] - p[1][x];
    }
    open_edges(u, v, w, weight, o);
}

/* Of three dot products, the middle one and the greatest; the least of the first two is first. */
IN_VECTORS void slope_faces(opened_faces *o, sloped_faces *s) {
    const vector *d = o->dots, one = VECTORS(all)(1);
    s->first_is_0 = VECTORS(is_less)(d[0], d[1]);
    const vector first = VECTORS(lesser)(d[0], d[1]), second = VECTORS(greater)(d[1], d[0]);
    s->least_is_2 = VECTORS(is_less)(d[2], first);
    const vector third = VECTORS(greater)(first, d[2]), least = VECTORS(lesser)(d[2], first);
    s->second_is_least = VECTORS(is_equal)(least, second);
    s->third_is_least = VECTORS(is_equal)(least, third);
    vector above[2];
    const vector below_a = slope_of(o->length, second, &above[0], &s->turn[0]),
                 below_b = slope_of(o->length, third, &above[1], &s->turn[1]);
    const vector inverse = one / o->length, belows = one / (below_a * below_b);
    for (int x = 0; x < 3; ++x) o->normal[x] = o->normal[x] * inverse;
    s->tangent[0] = above[0] * (belows * below_b);
    s->tangent[1] = above[1] * (belows * below_a);
}

/* The quotients. */
IN_VECTORS void divide_faces(opened_faces *o, norma_weight weight, sloped_faces *s) {
    if (core_weighed(weight) == CORE_BY_ANGLE) {
        slope_faces(o, s);
        return;
    }
    const vector inverse = VECTORS(all)(1) / o->length;
    for (int x = 0; x < 3; ++x) o->normal[x] = o->normal[x] * inverse;
}

/* norma_core_weight_atan and the turn before it, of both angles side by side. */
IN_VECTORS void turn_faces(const sloped_faces *s, vector angle[2]) {
    const vector *t = s->tangent, z[2] = {t[0] * t[0], t[1] * t[1]},
                 first = VECTORS(all)(CORE_WEIGHT_ATAN_FIRST);
    vector p[2] = {first, first};
#define ADD_TERM(factor)                                                                           \
    for (int k = 0; k < 2; ++k) p[k] = p[k] * z[k] + VECTORS(all)(factor);
    CORE_WEIGHT_ATAN_OTHERS(ADD_TERM)
#undef ADD_TERM
    for (int k = 0; k < 2; ++k) angle[k] = s->turn[k] + (t[k] + t[k] * (z[k] * p[k]));
}

/* Of equal corners none is another's rest: reversed faces weigh the same. */
IN_VECTORS void weigh_faces(const sloped_faces *s, vector weight[3]) {
    vector angle[2];
    turn_faces(s, angle);
    const vector left = VECTORS(all)(NORMA_PI) - (angle[0] + angle[1]);
    const vector rest = VECTORS(choose)(
        s->third_is_least, angle[1], VECTORS(choose)(s->second_is_least, angle[0], left));
    const vector of_first = VECTORS(choose)(s->least_is_2, angle[1], rest);
    weight[0] = VECTORS(choose)(s->first_is_0, of_first, angle[0]);
    weight[1] = VECTORS(choose)(s->first_is_0, angle[0], of_first);
    weight[2] = VECTORS(choose)(s->least_is_2, rest, angle[1]);
}

/* What other weights than the angle itself are made of, of eight triangles. */
typedef struct kept_edges {
    double squares[3][CORE_LANES], length[CORE_LANES];
} kept_edges;

/* From lane first on: the angles, and the rest. */
IN_VECTORS void keep_weights(const opened_faces *o, const sloped_faces *s, norma_weight weight,
    int first, double *const of_corner[3], kept_edges *kept) {
    vector angle[3];
    if (core_weighed(weight) == CORE_BY_ANGLE) {
        weigh_faces(s, angle);
        for (int k = 0; k < 3; ++k) VECTORS(store)(of_corner[k] + first, angle[k]);
    }
    if (weight == NORMA_WEIGHT_ANGLE) return;
    VECTORS(store)(kept->length + first, o->length);
    for (int k = 0; k < 3 && core_weighed(weight) != CORE_BY_FACE; ++k)
        VECTORS(store)(kept->squares[k] + first, o->squares[k]);
}

/* Other formulas than the angle itself, of all eight, lane by lane. */
IN_VECTORS void weigh_kept(norma_weight weight, const kept_edges *kept, double *const weights[3]) {
    for (int k = 0; k < 3; ++k) {
        const double *aa = kept->squares[(k + 2) % 3], *bb = kept->squares[(k + 1) % 3];
        double *of_corner = weights[k];
        CORE_EACH_LANE
        of_corner[i] = norma_core_weight_of(
            weight, aa[i], bb[i], of_corner[i], kept->length[i], kept->length[i]);
    }
}

/* ---- a batch of triangles, by their edges or by where their corners are */

IN_VECTORS void measure_edges(core_batch *t, norma_weight weight) {
    double *const weights[3] = {t->weight[0], t->weight[1], t->weight[2]};
    kept_edges kept;
    unsigned sure = 0;
    for (int lane = 0; lane < CORE_LANES; lane += LANES) {
        vector u[3], v[3], w[3];
        opened_faces o;
        sloped_faces s;
        for (int x = 0; x < 3; ++x) {
            u[x] = VECTORS(load)(t->u[x] + lane);
            v[x] = VECTORS(load)(t->v[x] + lane);
            w[x] = VECTORS(load)(t->a[x] + lane);
        }
        open_edges(u, v, w, weight, &o);
        divide_faces(&o, weight, &s);
        for (int x = 0; x < 3; ++x) VECTORS(store)(t->normal[x] + lane, o.normal[x]);
        VECTORS(store)(t->twice_area + lane, o.length);
        keep_weights(&o, &s, weight, lane, weights, &kept);
        sure |= VECTORS(bits)(o.sure) << lane;
    }
    for (int i = 0; i < CORE_LANES; ++i) t->sure[i] = sure >> i & 1U;
    if (weight != NORMA_WEIGHT_ANGLE) weigh_kept(weight, &kept, weights);
}

FOR_VECTORS static void measure_batch(core_batch *t, norma_weight weight){
    CORE_LOOP_FOR_WEIGHT(weight, measure_edges, t)}

/* at: three indices of 32 bits of each face, one face after the other. */
IN_VECTORS void open_faces(const core_mesh *mesh, const unsigned char *at, int doubles,
    norma_weight weight, opened_faces *o) {
    const size_t index = sizeof(uint32_t);
    vector p[3][3];
    for (size_t k = 0; k < 3; ++k)
        if (doubles)
            VECTORS(read_doubles)(mesh, at + k * index, 3 * index, p[k]);
        else
            VECTORS(read_floats)(mesh, at + k * index, 3 * index, p[k]);
    open_points(p, weight, o);
}

/* ---- faces of equally many corners */

/* Faces of one block, of which those from one slot to before another have equally many corners. */
typedef struct core_faces_alike {
    const core_mesh *mesh;
    const uint32_t *at; /* of each corner of the block its position, as the mesh names it */
    norma_weight weight;
    core_corners wanted;
    core_measured *out;
} core_faces_alike;

/* Whether no corner is at the position of the one before it. */
CORE_INLINE int core_has_kept_corners(const uint32_t *at, size_t corners) {
    int kept = at[corners - 1] != at[0];
    for (size_t k = 1; k < corners; ++k) kept &= at[k - 1] != at[k];
    return kept;
}

/* What is kept of eight faces until their weights are taken, of each corner. */
typedef struct kept_corners {
    double squares[CORE_MOST_CORNERS][CORE_LANES]; /* of the edge that begins there */
    double length[CORE_MOST_CORNERS][CORE_LANES];  /* of the cross product of its edges */
} kept_corners;

/* Edge k leads from corner k to the next, so that it is also, turned round, an edge of that one:
 * turning it round changes nothing but signs. */
typedef struct face_corner {
    vector edge[3], square;      /* and its square */
    vector cross_length, dot;    /* of the edge before and this one */
    vector along, tangent, turn; /* the angle between them is turn + atan(tangent), or
                                    pi less that */
} face_corner;

typedef struct face_vectors {
    vector at[CORE_MOST_CORNERS][3];
    vector normal[3], twice_area;
    mask sure;
    face_corner corner[CORE_MOST_CORNERS];
} face_vectors;

/* ---- reading */

/* Eight faces: where their corners' positions are. Those of other formats than floats and doubles
 * are copied. */
typedef struct eight_faces {
    core_mesh mesh;
    const uint32_t *at; /* corner k of face i: at[corners i + k] */
    uint32_t names[CORE_LANES * CORE_MOST_CORNERS];
    double points[CORE_LANES * CORE_MOST_CORNERS][3];
} eight_faces;

IN_VECTORS void name_eight(
    const core_faces_alike *w, size_t slot, size_t corners, eight_faces *eight) {
    const core_measured *m = w->out;
    const size_t first = m->first[m->face[slot]], last = m->first[m->face[slot + CORE_LANES - 1]];
    eight->at = w->at + first;
    if (last - first == (CORE_LANES - 1) * corners) return;
    for (size_t i = 0; i < CORE_LANES; ++i)
        memcpy(eight->names + corners * i, w->at + m->first[m->face[slot + i]],
            corners * sizeof *w->at);
    eight->at = eight->names;
}

IN_VECTORS void copy_eight(const core_faces_alike *w, size_t corners, eight_faces *eight) {
    const norma_format format = w->mesh->positions.format;
    eight->mesh.positions = w->mesh->positions;
    eight->mesh.scale = w->mesh->scale;
    if (format == NORMA_FORMAT_FLOAT || format == NORMA_FORMAT_DOUBLE) return;
    for (uint32_t i = 0; i < CORE_LANES * corners; ++i) {
        norma_core_position(w->mesh, eight->at[i], eight->points[i]);
        eight->names[i] = i;
    }
    eight->at = eight->names;
    eight->mesh.positions = (norma_vec3_view){
        eight->points, CORE_LANES * corners, sizeof eight->points[0], NORMA_FORMAT_DOUBLE};
    eight->mesh.scale = 1;
}

IN_VECTORS void read_faces(const eight_faces *eight, size_t lane, size_t corners, face_vectors *t) {
    const core_mesh *mesh = &eight->mesh;
    const size_t step = corners * sizeof *eight->at;
    const unsigned char *at = (const unsigned char *)(eight->at + corners * lane);
    for (size_t k = 0; k < corners; ++k)
        if (mesh->positions.format == NORMA_FORMAT_FLOAT)
            VECTORS(read_floats)(mesh, at + k * sizeof *eight->at, step, t->at[k]);
        else
            VECTORS(read_doubles)(mesh, at + k * sizeof *eight->at, step, t->at[k]);
}

/* ---- directions */

IN_VECTORS void direct_triangles(face_vectors *t) {
    opened_faces o;
    open_points(t->at, NORMA_WEIGHT_UNIFORM, &o);
    const vector inverse = VECTORS(all)(1) / o.length;
    for (int x = 0; x < 3; ++x) t->normal[x] = o.normal[x] * inverse;
    t->twice_area = o.length;
    t->sure = o.sure;
}

/* The vector area, a triangle of its fan at a time. */
IN_VECTORS void direct_polygons(face_vectors *t, size_t corners) {
    vector u[3], v[3], term[3], area[3];
    for (int x = 0; x < 3; ++x) {
        v[x] = t->at[1][x] - t->at[0][x];
        area[x] = VECTORS(all)(0);
    }
    vector size = dot_product(v, v);
    for (size_t k = 2; k < corners; ++k) {
        for (int x = 0; x < 3; ++x) {
            u[x] = v[x];
            v[x] = t->at[k][x] - t->at[0][x];
        }
        cross_product(u, v, term);
        for (int x = 0; x < 3; ++x) area[x] = area[x] + term[x];
        size = size + dot_product(v, v);
    }
    const vector square = dot_product(area, area),
                 bound = VECTORS(all)(0x1p-22 * (double)(corners + 8)) * size;
    t->twice_area = VECTORS(root)(square);
    for (int x = 0; x < 3; ++x) t->normal[x] = area[x] / t->twice_area;
    t->sure = VECTORS(both)(is_between(square), VECTORS(is_at_most)(bound * bound, square));
}

/* ---- corners */

/* A triangle's own cross product serves at each of its corners. */
IN_VECTORS void open_corner(face_vectors *t, size_t k, size_t corners) {
    const face_corner *before = &t->corner[k ? k - 1 : corners - 1];
    face_corner *c = &t->corner[k];
    vector cross[3];
    c->dot = dot_product(c->edge, before->edge);
    c->cross_length = t->twice_area;
    if (corners == 3) return;
    cross_product(before->edge, c->edge, cross);
    const vector square = dot_product(cross, cross), squares = c->square * before->square;
    c->cross_length = VECTORS(root)(square);
    c->along = dot_product(cross, t->normal);
    t->sure =
        VECTORS(both)(t->sure, VECTORS(both)(is_between(square),
                                   VECTORS(is_at_most)(VECTORS(all)(0x1p-40) * squares, square)));
}

IN_VECTORS void open_corners(face_vectors *t, size_t corners) {
    for (size_t k = 0; k < corners; ++k) {
        face_corner *c = &t->corner[k];
        const size_t next = k + 1 < corners ? k + 1 : 0;
        for (int x = 0; x < 3; ++x) c->edge[x] = t->at[next][x] - t->at[k][x];
        c->square = dot_product(c->edge, c->edge);
    }
    for (size_t k = 0; k < corners; ++k) open_corner(t, k, corners);
}

/* Of the length and the size of the dot product. */
IN_VECTORS void slope_corner(face_corner *c) {
    vector above;
    const vector size = VECTORS(greater)(c->dot, VECTORS(negative)(c->dot)),
                 below = slope_of(c->cross_length, size, &above, &c->turn);
    c->tangent = above / below;
}

/* The interior angle: above pi where the corner turns the other way than the polygon. */
IN_VECTORS vector turn_corner(face_vectors *t, const face_corner *c, size_t corners) {
    const vector z = c->tangent * c->tangent, zero = VECTORS(all)(0);
    vector p = VECTORS(all)(CORE_WEIGHT_ATAN_FIRST);
#define ADD_TERM(factor) p = p * z + VECTORS(all)(factor);
    CORE_WEIGHT_ATAN_OTHERS(ADD_TERM)
#undef ADD_TERM
    const vector acute = c->turn + (c->tangent + c->tangent * (z * p)),
                 angle = VECTORS(choose)(
                     VECTORS(is_less)(zero, c->dot), VECTORS(all)(NORMA_PI) - acute, acute);
    if (corners == 3) return angle;
    const vector along = c->along, size = VECTORS(greater)(along, VECTORS(negative)(along));
    t->sure =
        VECTORS(both)(t->sure, VECTORS(is_less)(VECTORS(all)(0x1p-28) * c->cross_length, size));
    return VECTORS(choose)(
        VECTORS(is_less)(along, zero), VECTORS(all)(2 * NORMA_PI) - angle, angle);
}

/* ---- keeping */

IN_VECTORS void keep_corners(
    const core_faces_alike *w, face_vectors *t, size_t corners, size_t slot, kept_corners *kept) {
    const size_t lane = slot % CORE_LANES;
    core_lane *weight = w->out->weight[slot / CORE_LANES];
    const core_weighed_by by = core_weighed(w->weight);
    if (by != CORE_BY_FACE) open_corners(t, corners);
    for (size_t k = 0; k < corners && by == CORE_BY_ANGLE; ++k) slope_corner(&t->corner[k]);
    for (size_t k = 0; k < corners && by == CORE_BY_ANGLE; ++k)
        VECTORS(store)(&weight[k][lane], turn_corner(t, &t->corner[k], corners));
    for (size_t k = 0; k < corners && by != CORE_BY_FACE && w->weight != NORMA_WEIGHT_ANGLE; ++k) {
        VECTORS(store)(&kept->squares[k][lane], t->corner[k].square);
        VECTORS(store)(&kept->length[k][lane], t->corner[k].cross_length);
    }
}

/* Other formulas than the angle itself, of all eight, lane by lane. */
IN_VECTORS void weigh_corner(const core_faces_alike *w, size_t slot, size_t k, size_t corners,
    const kept_corners *kept, norma_weight weight) {
    const double *aa = kept->squares[k], *bb = kept->squares[k ? k - 1 : corners - 1],
                 *length = kept->length[k], *area = w->out->twice_area[slot / CORE_LANES];
    double *out = w->out->weight[slot / CORE_LANES][k];
    CORE_EACH_LANE
    out[i] = norma_core_weight_of(weight, aa[i], bb[i], out[i], length[i], area[i]);
}

/* Returns of each face that is kept a bit. */
IN_VECTORS unsigned measure_lanes(const core_faces_alike *w, const eight_faces *eight,
    size_t corners, size_t slot, kept_corners *kept) {
    face_vectors t;
    const vector one = VECTORS(all)(1);
    read_faces(eight, slot % CORE_LANES, corners, &t);
    if (corners == 3)
        direct_triangles(&t);
    else
        direct_polygons(&t, corners);
    if (!CORE_IS_SMALL && w->wanted == CORE_ALL_CORNERS) keep_corners(w, &t, corners, slot, kept);
    VECTORS(store_rows)(t.normal[0], t.normal[1], t.normal[2], one, &w->out->row[slot]);
    VECTORS(store)(&w->out->twice_area[slot / CORE_LANES][slot % CORE_LANES], t.twice_area);
    return VECTORS(bits)(t.sure) << slot % CORE_LANES;
}

IN_VECTORS void keep_faces(const core_faces_alike *w, size_t slot, size_t corners, unsigned sure) {
    core_measured *out = w->out;
    for (size_t i = 0; i < CORE_LANES; ++i) {
        const size_t f = out->face[slot + i];
        const int kept = core_has_kept_corners(out->at + out->first[f], corners);
        out->corners[f] = (uint8_t)((sure >> i & 1U) && kept ? corners : 0);
    }
}

IN_VECTORS void measure_eights(
    const core_faces_alike *w, size_t begin, size_t end, size_t corners) {
    const norma_weight weight = w->weight;
    eight_faces eight;
    kept_corners kept;
    for (size_t slot = begin; slot < end; slot += CORE_LANES) {
        unsigned sure = 0;
        name_eight(w, slot, corners, &eight);
        copy_eight(w, corners, &eight);
        for (size_t lane = 0; lane < CORE_LANES; lane += LANES)
            sure |= measure_lanes(w, &eight, corners, slot + lane, &kept);
        for (size_t k = 0; !CORE_IS_SMALL && w->wanted == CORE_ALL_CORNERS && k < corners &&
                           weight != NORMA_WEIGHT_ANGLE;
             ++k) {
            CORE_LOOP_FOR_WEIGHT(weight, weigh_corner, w, slot, k, corners, &kept)
        }
        keep_faces(w, slot, corners, sure);
    }
}

FOR_VECTORS static void measure_alike_triangles(
    const core_faces_alike *w, size_t begin, size_t end) {
    measure_eights(w, begin, end, 3);
}
FOR_VECTORS static void measure_quads(const core_faces_alike *w, size_t begin, size_t end) {
    measure_eights(w, begin, end, 4);
}
FOR_VECTORS static void measure_others(
    const core_faces_alike *w, size_t begin, size_t end, size_t corners) {
    if (corners > 4) measure_eights(w, begin, end, corners);
}

static void measure_alike(const core_faces_alike *w, size_t begin, size_t end, size_t corners) {
    if (CORE_IS_SMALL || corners == 3)
        measure_alike_triangles(w, begin, end);
    else if (corners == 4)
        measure_quads(w, begin, end);
    else
        measure_others(w, begin, end, corners);
}

/* ---- blocks of faces of any number of corners: sorted by that number, those of each measured
 * eight at a time */

static int has_plain_corners(const core_mesh *mesh) {
    return mesh->corner_size == sizeof(uint32_t) &&
           (uintptr_t)mesh->corners % _Alignof(uint32_t) == 0;
}

/* Returns the positions of the block's corners as the mesh names them, in named if it does not have
 * them so; out->at: as they are welded. */
static const uint32_t *list_block_corners(
    const core_mesh *mesh, size_t begin, size_t count, uint32_t *named, core_measured *out) {
    const uint32_t *at = named;
    if (has_plain_corners(mesh))
        at = (const uint32_t *)mesh->corners + begin;
    else
        norma_core_read_corners(mesh, begin, count, named);
    out->at = mesh->weld || at == named ? out->room : at;
    for (size_t i = 0; i < count && out->at != at; ++i)
        out->room[i] = norma_core_welded(mesh, at[i]);
    return at;
}

/* Whether all faces have as many corners as the first: that number, else 0. */
static size_t count_alike(const core_mesh *mesh, size_t begin, size_t end) {
    const size_t corners = norma_core_face_end(mesh, begin) - norma_core_face_begin(mesh, begin);
    uint32_t other = 0;
    if (norma_core_face_starts(mesh))
        for (size_t f = begin; f < end; ++f)
            other |= (mesh->face_starts[f + 1] - mesh->face_starts[f]) ^ (uint32_t)corners;
    return !other && corners >= 3 && corners <= CORE_MOST_CORNERS ? corners : 0;
}

/* Of each number of corners, where its slots begin; they end where the next one's begin. */
typedef struct slot_begins {
    size_t of[CORE_MOST_CORNERS + 2];
} slot_begins;

/* The faces in ascending order in eights of equally many corners; lanes that are left over in the
 * last of them repeat its first. */
static void give_slots(const core_mesh *mesh, size_t begin, size_t end, size_t corners_there,
    slot_begins *begins, core_measured *out) {
    uint32_t count[CORE_MOST_CORNERS + 1] = {0};
    uint8_t corners[CORE_FACES_AT_ONCE];
    const size_t first = norma_core_face_begin(mesh, begin);
    for (size_t f = begin; f < end; ++f) {
        const size_t c = norma_core_face_begin(mesh, f), last = norma_core_face_end(mesh, f);
        out->first[f - begin] = (uint32_t)(c - first);
        corners[f - begin] = out->corners[f - begin] = 0;
        if (last - c < 3 || last - c > CORE_MOST_CORNERS || last - first > corners_there) continue;
        corners[f - begin] = (uint8_t)(last - c);
        ++count[last - c];
    }
    size_t slot = 0;
    for (size_t n = 3; n <= CORE_MOST_CORNERS; ++n) {
        begins->of[n] = slot;
        for (size_t i = 0; i < end - begin && count[n]; ++i) {
            if (corners[i] != n) continue;
            out->slot[i] = (uint8_t)slot;
            out->face[slot++] = (uint8_t)i;
        }
        for (; slot % CORE_LANES; ++slot) out->face[slot] = out->face[slot - slot % CORE_LANES];
    }
    begins->of[CORE_MOST_CORNERS + 1] = slot;
}

/* The same where all have equally many. */
static void give_slots_in_order(
    size_t faces, size_t corners, slot_begins *begins, core_measured *out) {
    size_t slot = faces;
    for (size_t i = 0; i < CORE_FACES_AT_ONCE; ++i) {
        out->corners[i] = 0;
        out->slot[i] = out->face[i] = (uint8_t)i;
        out->first[i] = (uint32_t)(corners * i);
    }
    for (; slot % CORE_LANES; ++slot) out->face[slot] = out->face[slot - slot % CORE_LANES];
    for (size_t n = 3; n <= CORE_MOST_CORNERS + 1; ++n) begins->of[n] = n > corners ? slot : 0;
}

static void measure_faces(const core_mesh *mesh, size_t begin, size_t end, norma_weight weight,
    core_corners wanted, core_measured *out) {
    const size_t first = norma_core_face_begin(mesh, begin),
                 corners = norma_core_face_begin(mesh, end) - first,
                 count = corners < CORE_CORNERS_AT_ONCE ? corners : CORE_CORNERS_AT_ONCE,
                 alike = count_alike(mesh, begin, end);
    uint32_t named[CORE_CORNERS_AT_ONCE];
    slot_begins begins;
    const core_faces_alike faces = {
        mesh, list_block_corners(mesh, first, count, named, out), weight, wanted, out};
    if (alike)
        give_slots_in_order(end - begin, alike, &begins, out);
    else
        give_slots(mesh, begin, end, count, &begins, out);
    for (size_t n = 3; n <= CORE_MOST_CORNERS; ++n)
        if (begins.of[n] < begins.of[n + 1])
            measure_alike(&faces, begins.of[n], begins.of[n + 1], n);
}
