/* measure_triangles.template.h: triangles measured and weighed, as many at once as a register has
 * lanes. Included by a file for each instruction set, which says with VECTORS(name) and IN_VECTORS
 * whose vectors these are, and calls the two types vector and mask. The numbers and their bits are
 * those of measure_simd.h. Values stay in registers here; loops over lanes write what each step
 * leaves and read it again. */
#include "core/face/face.h"

/* Cross product and its length, dot products of the corners' edges, squares of the edges opposite
 * to them where the weight needs them, and which triangles doubles decide. */
typedef struct opened_faces {
    vector normal[3], length, dots[3], squares[3];
    mask sure;
} opened_faces;

/* Two of the angles, each turn + atan(tangent), and which corner has which:
 * core_lanes_corner_angles. */
typedef struct sloped_faces {
    vector tangent[2], turn[2];
    mask first_is_0, least_is_2, second_is_least, third_is_least;
} sloped_faces;

IN_VECTORS vector dot_product(const vector a[3], const vector b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* norma_core_triangle_is_sure */
IN_VECTORS mask are_sure(vector square, vector dot) {
    const mask thick = VECTORS(is_at_most)(VECTORS(all)(0x1p-40) * (square + dot * dot), square);
    return VECTORS(both)(thick, VECTORS(both)(VECTORS(is_less)(VECTORS(all)(NORMA_TINIEST), square),
                                    VECTORS(is_less)(square, VECTORS(all)(NORMA_HUGEST))));
}

/* core_lanes_products. p: of each corner, its three axes. */
IN_VECTORS void open_points(vector p[3][3], norma_weight weight, opened_faces *o) {
    vector u[3], v[3], w[3];
    for (int x = 0; x < 3; x++) {
        u[x] = p[1][x] - p[0][x];
        v[x] = p[2][x] - p[0][x];
        w[x] = p[2][x] - p[1][x];
    }
    o->normal[0] = u[1] * v[2] - u[2] * v[1];
    o->normal[1] = u[2] * v[0] - u[0] * v[2];
    o->normal[2] = u[0] * v[1] - u[1] * v[0];
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

/* core_lanes_slopes */
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
    for (int x = 0; x < 3; x++) o->normal[x] = o->normal[x] * inverse;
    s->tangent[0] = above[0] * (belows * below_b);
    s->tangent[1] = above[1] * (belows * below_a);
}

/* norma_core_weight_atan and the turn before it, of both angles side by side. */
IN_VECTORS void turn_faces(const sloped_faces *s, vector angle[2]) {
    const vector *t = s->tangent, z[2] = {t[0] * t[0], t[1] * t[1]},
                 first = VECTORS(all)(CORE_WEIGHT_ATAN_FIRST);
    vector p[2] = {first, first};
#define ADD_TERM(factor)                                                                           \
    for (int k = 0; k < 2; k++) p[k] = p[k] * z[k] + VECTORS(all)(factor);
    CORE_WEIGHT_ATAN_OTHERS(ADD_TERM)
#undef ADD_TERM
    for (int k = 0; k < 2; k++) angle[k] = s->turn[k] + (t[k] + t[k] * (z[k] * p[k]));
}

/* core_lanes_arcs, core_lanes_corner_angles. */
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
