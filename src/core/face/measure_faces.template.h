/* measure_faces.template.h: faces of equally many corners measured and weighed, as many at once as
 * a register has lanes. Included by a file for each instruction set, as
 * measure_triangles.template.h is. The operations are those of face.h and face_geometry.c. */
#include "core/face/face.h"

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
    mask sure, flat;
    face_corner corner[CORE_MOST_CORNERS];
} face_vectors;

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
    for (size_t i = 0; i < CORE_LANES; i++)
        memcpy(eight->names + corners * i, w->at + m->first[m->face[slot + i]],
            corners * sizeof *w->at);
    eight->at = eight->names;
}

IN_VECTORS void copy_eight(const core_faces_alike *w, size_t corners, eight_faces *eight) {
    const norma_format format = w->mesh->positions.format;
    eight->mesh.positions = w->mesh->positions;
    eight->mesh.scale = w->mesh->scale;
    if (format == NORMA_FORMAT_FLOAT || format == NORMA_FORMAT_DOUBLE) return;
    for (uint32_t i = 0; i < CORE_LANES * corners; i++) {
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
    for (size_t k = 0; k < corners; k++)
        if (mesh->positions.format == NORMA_FORMAT_FLOAT)
            VECTORS(read_floats)(mesh, at + k * sizeof *eight->at, step, t->at[k]);
        else
            VECTORS(read_doubles)(mesh, at + k * sizeof *eight->at, step, t->at[k]);
}

/* ---- directions */

/* norma_core_triangle */
IN_VECTORS void direct_triangles(face_vectors *t) {
    vector u[3], v[3], cross[3];
    for (int x = 0; x < 3; x++) {
        u[x] = t->at[1][x] - t->at[0][x];
        v[x] = t->at[2][x] - t->at[0][x];
    }
    cross_product(u, v, cross);
    const vector square = dot_product(cross, cross), dot = dot_product(u, v);
    t->twice_area = VECTORS(root)(square);
    const vector inverse = VECTORS(all)(1) / t->twice_area;
    for (int x = 0; x < 3; x++) t->normal[x] = cross[x] * inverse;
    t->sure = VECTORS(both)(is_between(square),
        VECTORS(is_at_most)(VECTORS(all)(0x1p-40) * (square + dot * dot), square));
}

/* The vector area, a triangle of its fan at a time. */
IN_VECTORS void direct_polygons(face_vectors *t, size_t corners) {
    vector u[3], v[3], term[3], area[3];
    for (int x = 0; x < 3; x++) {
        v[x] = t->at[1][x] - t->at[0][x];
        area[x] = VECTORS(all)(0);
    }
    vector size = dot_product(v, v);
    for (size_t k = 2; k < corners; k++) {
        for (int x = 0; x < 3; x++) {
            u[x] = v[x];
            v[x] = t->at[k][x] - t->at[0][x];
        }
        cross_product(u, v, term);
        for (int x = 0; x < 3; x++) area[x] = area[x] + term[x];
        size = size + dot_product(v, v);
    }
    const vector square = dot_product(area, area),
                 bound = VECTORS(all)(0x1p-22 * (double)(corners + 8)) * size;
    t->twice_area = VECTORS(root)(square);
    for (int x = 0; x < 3; x++) t->normal[x] = area[x] / t->twice_area;
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
    for (size_t k = 0; k < corners; k++) {
        face_corner *c = &t->corner[k];
        const size_t next = k + 1 < corners ? k + 1 : 0;
        for (int x = 0; x < 3; x++) c->edge[x] = t->at[next][x] - t->at[k][x];
        c->square = dot_product(c->edge, c->edge);
    }
    for (size_t k = 0; k < corners; k++) open_corner(t, k, corners);
}

/* norma_core_slope of the length and the size of the dot product. */
IN_VECTORS void slope_corner(face_corner *c) {
    const vector y = c->cross_length, x = VECTORS(greater)(c->dot, VECTORS(negative)(c->dot)),
                 small = VECTORS(lesser)(y, x), large = VECTORS(greater)(x, y);
    const mask steep = VECTORS(is_less)(VECTORS(all)(0.41421356237309503) * large, small),
               falls = VECTORS(is_less)(x, y);
    const vector above =
        VECTORS(choose)(steep, y - x, VECTORS(choose)(falls, VECTORS(negative)(x), y));
    c->tangent = above / VECTORS(choose)(steep, small + large, large);
    c->turn = VECTORS(choose)(steep, VECTORS(all)(0.25 * NORMA_PI),
        VECTORS(choose)(falls, VECTORS(all)(0.5 * NORMA_PI), VECTORS(all)(0)));
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
    t->flat = VECTORS(both)(
        t->flat, VECTORS(is_at_most)(VECTORS(all)(CORE_FLAT_COSINE) * c->cross_length, along));
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
    for (size_t k = 0; k < corners && by == CORE_BY_ANGLE; k++) slope_corner(&t->corner[k]);
    for (size_t k = 0; k < corners && by == CORE_BY_ANGLE; k++)
        VECTORS(store)(&weight[k][lane], turn_corner(t, &t->corner[k], corners));
    for (size_t k = 0; k < corners && by != CORE_BY_FACE && w->weight != NORMA_WEIGHT_ANGLE; k++) {
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
    size_t corners, size_t slot, kept_corners *kept, unsigned *flat) {
    face_vectors t;
    const vector one = VECTORS(all)(1);
    read_faces(eight, slot % CORE_LANES, corners, &t);
    if (corners == 3)
        direct_triangles(&t);
    else
        direct_polygons(&t, corners);
    t.flat = VECTORS(is_equal)(one, one);
    if (w->wanted == CORE_ALL_CORNERS) keep_corners(w, &t, corners, slot, kept);
    VECTORS(store_rows)(t.normal[0], t.normal[1], t.normal[2], one, &w->out->row[slot]);
    VECTORS(store)(&w->out->twice_area[slot / CORE_LANES][slot % CORE_LANES], t.twice_area);
    *flat |= VECTORS(bits)(t.flat) << slot % CORE_LANES;
    return VECTORS(bits)(t.sure) << slot % CORE_LANES;
}

IN_VECTORS void keep_faces(
    const core_faces_alike *w, size_t slot, size_t corners, unsigned sure, unsigned flat) {
    core_measured *out = w->out;
    for (size_t i = 0; i < CORE_LANES; i++) {
        const size_t f = out->face[slot + i];
        const int kept = core_has_kept_corners(out->at + out->first[f], corners);
        out->corners[f] = (uint8_t)((sure >> i & 1U) && kept ? corners : 0);
        out->flat[f] = flat >> i & 1U;
    }
}

IN_VECTORS void measure_eights(
    const core_faces_alike *w, size_t begin, size_t end, size_t corners) {
    const norma_weight weight = w->weight;
    eight_faces eight;
    kept_corners kept;
    for (size_t slot = begin; slot < end; slot += CORE_LANES) {
        unsigned sure = 0, flat = 0;
        name_eight(w, slot, corners, &eight);
        copy_eight(w, corners, &eight);
        for (size_t lane = 0; lane < CORE_LANES; lane += LANES)
            sure |= measure_lanes(w, &eight, corners, slot + lane, &kept, &flat);
        for (size_t k = 0;
             w->wanted == CORE_ALL_CORNERS && k < corners && weight != NORMA_WEIGHT_ANGLE; k++) {
            CORE_LOOP_FOR_WEIGHT(weight, weigh_corner, w, slot, k, corners, &kept)
        }
        keep_faces(w, slot, corners, sure, flat);
    }
}

FOR_VECTORS static void measure_triangles(const core_faces_alike *w, size_t begin, size_t end) {
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
    if (corners == 3)
        measure_triangles(w, begin, end);
    else if (corners == 4)
        measure_quads(w, begin, end);
    else
        measure_others(w, begin, end, corners);
}
