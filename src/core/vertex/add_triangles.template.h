/* add_triangles.template.h: triangles of floats or doubles added to the sums of their corners, as
 * many at once as a register has lanes, in registers from corners to rows. Included by a file for
 * each instruction set, as measure_triangles.template.h is. The numbers and their bits are those of
 * add_triangles.c. */

/* What is kept of eight triangles until they are added. */
typedef struct kept_eight {
    _Alignas(64) double row[CORE_LANES][4];
    double weight[3][CORE_LANES];
    double squares[3][CORE_LANES], length[CORE_LANES];
    uint32_t welded[3 * CORE_LANES];
    unsigned sure;
} kept_eight;

static const unsigned char *corners_of(const core_mesh *mesh, size_t f) {
    return (const unsigned char *)mesh->corners + 3 * sizeof(uint32_t) * f;
}

IN_VECTORS void open_faces(
    const core_mesh *mesh, size_t f, int doubles, norma_weight weight, opened_faces *o) {
    const unsigned char *corners = corners_of(mesh, f);
    vector p[3][3];
    for (size_t k = 0; k < 3; k++)
        if (doubles)
            VECTORS(read_doubles)(mesh, corners + k * sizeof(uint32_t), 3 * sizeof(uint32_t), p[k]);
        else
            VECTORS(read_floats)(mesh, corners + k * sizeof(uint32_t), 3 * sizeof(uint32_t), p[k]);
    open_points(p, weight, o);
}

/* ---- adding */

IN_VECTORS void keep_welded(const core_mesh *mesh, size_t f, kept_eight *kept) {
    const unsigned char *corners = corners_of(mesh, f);
    for (size_t c = 0; c < 3 * CORE_LANES; c++) {
        uint32_t at;
        memcpy(&at, corners + c * sizeof at, sizeof at);
        kept->welded[c] = mesh->weld[at];
    }
}

IN_VECTORS void add_kept(
    const core_adder *adder, const kept_eight *kept, size_t f, norma_weight weight) {
    const core_eight eight = {(const double(*)[4])kept->row,
        (const double(*)[CORE_LANES])kept->weight,
        adder->mesh->weld ? (const unsigned char *)kept->welded : corners_of(adder->mesh, f),
        kept->sure};
    core_add_eight(adder, &eight, f, CORE_LANES, weight);
}

/* ---- each weight */

/* Other formulas than the angle itself, of all eight, lane by lane. */
IN_VECTORS void weigh_kept(norma_weight weight, kept_eight *kept) {
    for (int k = 0; k < 3; k++) {
        const double *aa = kept->squares[(k + 2) % 3], *bb = kept->squares[(k + 1) % 3];
        double *of_corner = kept->weight[k];
        CORE_EACH_LANE
        of_corner[i] = norma_core_weight_of(
            weight, aa[i], bb[i], of_corner[i], kept->length[i], kept->length[i]);
    }
}

/* From lane first on. */
IN_VECTORS void keep_weighed(const opened_faces *o, const sloped_faces *s, norma_weight weight,
    int first, kept_eight *kept) {
    vector angle[3];
    VECTORS(store_rows)
    (o->normal[0], o->normal[1], o->normal[2], VECTORS(all)(1), kept->row + first);
    if (core_weighed(weight) == CORE_BY_ANGLE) {
        weigh_faces(s, angle);
        for (int k = 0; k < 3; k++) VECTORS(store)(kept->weight[k] + first, angle[k]);
    }
    if (weight == NORMA_WEIGHT_ANGLE) return;
    VECTORS(store)(kept->length + first, o->length);
    for (int k = 0; k < 3; k++) VECTORS(store)(kept->squares[k] + first, o->squares[k]);
}

/* Where all corners weigh the same. */
IN_VECTORS void keep_even(const opened_faces *o, norma_weight weight, int first, kept_eight *kept) {
    const int by_area = weight == NORMA_WEIGHT_AREA;
    const vector factor = by_area ? o->length : VECTORS(all)(1);
    VECTORS(store_rows)
    (o->normal[0] * factor, o->normal[1] * factor, o->normal[2] * factor, factor,
        kept->row + first);
}

/* The quotients. */
IN_VECTORS void divide_faces(opened_faces *o, norma_weight weight, sloped_faces *s) {
    if (core_weighed(weight) == CORE_BY_ANGLE) {
        slope_faces(o, s);
        return;
    }
    const vector inverse = VECTORS(all)(1) / o->length;
    for (int x = 0; x < 3; x++) o->normal[x] = o->normal[x] * inverse;
}

/* The next faces are read and multiplied and the last eight added while these ones' divisions are
 * under way: what waits for them would otherwise keep the processor from seeing that far ahead. */
IN_VECTORS void add_weighted(
    const core_adder *adder, size_t begin, size_t end, int doubles, norma_weight weight) {
    const core_mesh *mesh = adder->mesh;
    const size_t eights = (end - begin) / CORE_LANES;
    kept_eight kept[2];
    opened_faces next;
    if (eights) open_faces(mesh, begin, doubles, weight, &next);
    for (size_t i = 0; i < eights; i++) {
        const size_t f = begin + i * CORE_LANES;
        kept_eight *this = &kept[i % 2], *last = &kept[(i + 1) % 2];
        this->sure = 0;
        for (int lane = 0; lane < CORE_LANES; lane += LANES) {
            const size_t after = f + (size_t)(lane + LANES);
            opened_faces o = next;
            sloped_faces s;
            divide_faces(&o, weight, &s);
            open_faces(mesh, after + LANES <= end ? after : begin, doubles, weight, &next);
            if (!lane && i > 0) add_kept(adder, last, f - CORE_LANES, weight);
            if (core_weighs_evenly(weight))
                keep_even(&o, weight, lane, this);
            else
                keep_weighed(&o, &s, weight, lane, this);
            this->sure |= VECTORS(bits)(o.sure) << lane;
        }
        if (!core_weighs_evenly(weight) && weight != NORMA_WEIGHT_ANGLE) weigh_kept(weight, this);
        if (mesh->weld) keep_welded(mesh, f, this);
    }
    if (eights) add_kept(adder, &kept[(eights - 1) % 2], begin + (eights - 1) * CORE_LANES, weight);
}

/* Functions of their own: in one with the other, each would be a tenth slower for want of
 * registers. */
FOR_VECTORS static void add_floats(const core_adder *adder, size_t begin, size_t end){
    CORE_LOOP_FOR_WEIGHT(adder->weight, add_weighted, adder, begin, end, 0)}

FOR_VECTORS static void add_doubles(const core_adder *adder, size_t begin, size_t end) {
    CORE_LOOP_FOR_WEIGHT(adder->weight, add_weighted, adder, begin, end, 1)
}

/* Returns the first that is left. */
static size_t add_eights(const core_adder *adder, size_t begin, size_t end) {
    const norma_format format = adder->mesh->positions.format;
    if (adder->scattered)
        return begin; /* waits for memory, for which it is better to ask for much at once: 46 to 63
                         ns here, 43 there */
    if (adder->mesh->corner_size != sizeof(uint32_t)) return begin;
    if (format == NORMA_FORMAT_FLOAT)
        add_floats(adder, begin, end);
    else if (format == NORMA_FORMAT_DOUBLE)
        add_doubles(adder, begin, end);
    else
        return begin;
    return end - (end - begin) % CORE_LANES;
}
