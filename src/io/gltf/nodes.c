/* nodes.c: where things stand: the models of a tile in its file; the nodes: their matrices, the
 * tree, instances. What a matrix cannot say as translation, rotation and scale is said by two
 * nodes. */
#include "io/gltf/gltf.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- Where the models of a tile of 3D Tiles 1.0 (OGC 18-053r2) stand in its file. */

enum { BYTE_LENGTH = 8, COMPOSITE_HEADER = 16, TABLES = 12, MODEL_TABLES_END = 28 };

typedef struct tile_search {
    const norma_document *document;
    gltf_tile path;   /* the headers above what is looked at, and which have no GLB */
    size_t found;     /* GLBs */
    gltf_tile *tiles; /* written: of the first GLBs, */
    size_t room;      /* so many */
} tile_search;

static norma_document_result fail_tile(const tile_search *s, norma_document_error *error,
    norma_document_result result, size_t byte, const char *message) {
    char place[40];
    snprintf(place, sizeof place, "byte %zu", byte);
    return norma_document_fail(s->document, error, result, place, "%s", message);
}

static void leave_out_tile(tile_search *s, size_t at, const char *instead) {
    if (s->path.left_out++ > 0) return;
    s->path.left_out_at = at;
    s->path.left_out_why = instead;
}

static int has_magic(const unsigned char *at, const char *magic) {
    return memcmp(at, magic, 4) == 0;
}

/* The GLB begins behind a header and four tables, whose lengths the header lists. */
static norma_document_result find_model(
    tile_search *s, size_t at, size_t end, norma_document_error *error) {
    const unsigned char *tile = s->document->source.data + at;
    const int has_instances = has_magic(tile, "i3dm");
    uint64_t begin = MODEL_TABLES_END + (has_instances ? 4 : 0);
    if (end - at < begin)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_MALFORMED, at, "the tile's header is cut");
    const int is_outside = has_instances && norma_gltf_u32(tile + MODEL_TABLES_END) == 0;
    for (int i = TABLES; i < MODEL_TABLES_END; i += 4) begin += norma_gltf_u32(tile + i);
    if (begin > end - at)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_MALFORMED, at + TABLES,
            "the tables are longer than the tile; expected the 28 bytes of a header as 3D Tiles "
            "1.0 has them");
    if (is_outside) {
        leave_out_tile(s, at, "names a glTF file instead of holding one; give that file");
    } else if (s->found++ < s->room) {
        gltf_tile *tile_found = &s->tiles[s->found - 1];
        *tile_found = s->path;
        tile_found->at = at + (size_t)begin;
        tile_found->end = end;
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result look_into_tile(
    tile_search *s, size_t at, size_t end, size_t *next, norma_document_error *error) {
    const unsigned char *tile = s->document->source.data + at;
    if (end - at < COMPOSITE_HEADER)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_MALFORMED, at,
            "expected the header of a tile; found the end");
    const size_t length = norma_gltf_u32(tile + BYTE_LENGTH);
    if (norma_gltf_u32(tile + 4) != 1)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, at + 4,
            "this is not version 1 of a tile, the only one that can be read");
    if (length < COMPOSITE_HEADER || length > end - at)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_MALFORMED, at + BYTE_LENGTH,
            "the tile's length does not fit into the file");
    if (s->path.depth == TILE_DEPTH)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, at,
            "composite tiles are nested more than eight deep");
    *next = at + length;
    s->path.headers[s->path.depth++] = at;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (has_magic(tile, "b3dm") || has_magic(tile, "i3dm"))
        result = find_model(s, at, *next, error);
    else if (has_magic(tile, "cmpt")) {
        size_t inner = at + COMPOSITE_HEADER;
        for (uint32_t i = norma_gltf_u32(tile + 12); i > 0 && !result; --i)
            result = look_into_tile(s, inner, *next, &inner, error);
    } else if (has_magic(tile, "pnts"))
        leave_out_tile(s, at, "has points, which have no faces");
    else
        result = fail_tile(s, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, at,
            "expected a tile that begins with b3dm, i3dm, cmpt or pnts");
    --s->path.depth;
    return result;
}

static norma_document_result look_into_file(tile_search *s, norma_document_error *error) {
    size_t next = 0;
    const norma_document_result result =
        look_into_tile(s, 0, s->document->source.size, &next, error);
    if (result || s->found) return result;
    return norma_document_fail(s->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "the tile %s", s->path.left_out_why ? s->path.left_out_why : "is empty");
}

norma_document_result norma_gltf_find_tiles(const norma_document *document, gltf_tile *tiles,
    size_t room, size_t *found, gltf_tile *left_out, norma_document_error *error) {
    tile_search s = {.document = document, .tiles = tiles, .room = room};
    const norma_document_result result = look_into_file(&s, error);
    *found = s.found;
    *left_out = s.path;
    return result;
}

norma_document_result norma_gltf_find_tile(gltf *g, norma_document_error *error) {
    gltf_tile left_out;
    size_t found;
    if (g->document->format == NORMA_FILE_GLB) return NORMA_DOCUMENT_OK;
    const norma_document_result result =
        norma_gltf_find_tiles(g->document, &g->tile, 1, &found, &left_out, error);
    g->tile.left_out = left_out.left_out;
    g->tile.left_out_at = left_out.left_out_at;
    g->tile.left_out_why = left_out.left_out_why;
    return result;
}

/* ---- What a node's matrix, or its translation, rotation and scale, can say, and how the
 * rest is said by two nodes. Rotation from a matrix: Shepperd 1978. Singular values by Hestenes'
 * one-sided Jacobi rotations (1958), which keep small ones accurate. */

void norma_gltf_matrix_identity(double m[16]) {
    for (int i = 0; i < 16; ++i) m[i] = i % 5 == 0;
}

void norma_gltf_matrix_multiply(const double a[16], const double b[16], double ab[16]) {
    double product[16];
    for (int column = 0; column < 4; ++column) {
        const double *c = b + 4 * column;
        for (int row = 0; row < 3; ++row)
            product[4 * column + row] = a[row] * c[0] + a[4 + row] * c[1] + a[8 + row] * c[2] +
                                        (column == 3 ? a[12 + row] : 0);
        product[4 * column + 3] = column == 3;
    }
    memcpy(ab, product, sizeof product);
}

void norma_gltf_matrix_compose(const gltf_trs *trs, double m[16]) {
    const double *q = trs->rotation, *s = trs->scale;
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double rotation[9] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w),
        2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 2 * (x * z + y * w),
        2 * (y * z - x * w), 1 - 2 * (x * x + y * y)};
    for (int column = 0; column < 3; ++column) {
        for (int row = 0; row < 3; ++row)
            m[4 * column + row] = rotation[3 * column + row] * s[column];
        m[4 * column + 3] = 0;
    }
    memcpy(m + 12, trs->translation, 3 * sizeof *m);
    m[15] = 1;
}

/* The columns of the upper 3x3 times a power of two that brings the largest number near 1, so that
 * no square overflows. Returns its exponent. */
static int scaled_columns(const double m[16], double columns[9]) {
    double largest = 0;
    for (int i = 0; i < 9; ++i) {
        columns[i] = m[4 * (i / 3) + i % 3];
        largest = fmax(largest, fabs(columns[i]));
    }
    int exponent = 0;
    if (largest > 0 && isfinite(largest)) frexp(largest, &exponent);
    for (int i = 0; i < 9; ++i) columns[i] = ldexp(columns[i], -exponent);
    return exponent;
}

int norma_gltf_matrix_invert(const double m[16], double inverse[16]) {
    double c[9], cofactor[9];
    const int exponent = scaled_columns(m, c);
    norma_core_cross(c + 3, c + 6, cofactor);
    norma_core_cross(c + 6, c, cofactor + 3);
    norma_core_cross(c, c + 3, cofactor + 6);
    const double determinant = norma_core_dot(c, cofactor);
    if (determinant == 0) return 0;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            inverse[4 * column + row] = ldexp(cofactor[3 * row + column] / determinant, -exponent);
        inverse[4 * row + 3] = 0;
    }
    for (int row = 0; row < 3; ++row)
        inverse[12 + row] =
            -(inverse[row] * m[12] + inverse[4 + row] * m[13] + inverse[8 + row] * m[14]);
    inverse[15] = 1;
    for (int i = 0; i < 16; ++i)
        if (!isfinite(inverse[i])) return 0;
    return 1;
}

/* Orthonormal columns from count (0 to 3) given ones, the first; m holds three columns.
 * Right-handed where fewer than three are given. */
static void gltf_complete_basis(double columns[9], int count) {
    if (count < 1) {
        const double x[3] = {1, 0, 0};
        memcpy(columns, x, sizeof x);
    }
    if (count < 2) { /* perpendicular to the first, away from the axis that is nearest to it */
        const double *a = columns;
        int axis = 0;
        for (int i = 1; i < 3; ++i)
            if (fabs(a[i]) < fabs(a[axis])) axis = i;
        double e[3] = {0, 0, 0};
        e[axis] = 1;
        norma_core_cross(a, e, columns + 3);
        const double length = sqrt(norma_core_dot(columns + 3, columns + 3));
        for (int i = 3; i < 6; ++i) columns[i] /= length;
    }
    if (count < 3) norma_core_cross(columns, columns + 3, columns + 6);
}

/* Unit columns in place, their lengths into lengths; what is zero is filled with what completes the
 * basis. */
static void normalise_columns(double columns[9], double lengths[3]) {
    int order[3] = {0, 1, 2}, whole = 0;
    for (int i = 0; i < 3; ++i) {
        lengths[i] = sqrt(norma_core_dot(columns + 3 * i, columns + 3 * i));
        if (lengths[i] > 0) order[whole++] = i;
    }
    int at = whole;
    for (int i = 0; i < 3; ++i)
        if (!(lengths[i] > 0)) order[at++] = i;
    double basis[9];
    for (int i = 0; i < whole; ++i)
        for (int k = 0; k < 3; ++k)
            basis[3 * i + k] = columns[3 * order[i] + k] / lengths[order[i]];
    gltf_complete_basis(basis, whole);
    for (int i = 0; i < 3; ++i) memcpy(columns + 3 * order[i], basis + 3 * i, 3 * sizeof *columns);
}

/* Shepperd's method: the largest of four sums decides which component is taken by a root. */
static void rotation_of_columns(const double r[9], double q[4]) {
    const double sums[4] = {
        r[0] - r[4] - r[8], r[4] - r[0] - r[8], r[8] - r[0] - r[4], r[0] + r[4] + r[8]};
    int largest = 3;
    for (int i = 0; i < 3; ++i)
        if (sums[i] > sums[largest]) largest = i;
    const double first = sqrt(fmax(0, 1 + sums[largest])) / 2, quarter = 1 / (4 * first);
    const double skew[3] = {r[5] - r[7], r[6] - r[2], r[1] - r[3]};
    q[largest] = first;
    for (int i = 0; i < 3; ++i) {
        if (largest == 3)
            q[i] = skew[i] * quarter;
        else if (i != largest)
            q[i] = (r[3 * i + largest] + r[3 * largest + i]) * quarter;
    }
    if (largest != 3) q[3] = skew[largest] * quarter;
    double length = sqrt(norma_core_dot(q, q) + q[3] * q[3]);
    if (q[3] < 0) length = -length;
    for (int i = 0; i < 4; ++i) q[i] = q[i] / length + 0.0; /* no negative zeros in files */
}

/* rotation and scale of orthogonal columns; a mirror goes into the first scale, that of columns
 * made up for a singular matrix into theirs. */
static void rotation_and_scale(
    double columns[9], const double lengths[3], int exponent, gltf_trs *trs) {
    double normal[3];
    norma_core_cross(columns, columns + 3, normal);
    const int mirrored = norma_core_dot(normal, columns + 6) < 0;
    int flip = 0;
    for (int i = 0; i < 3; ++i) {
        trs->scale[i] = ldexp(lengths[i], exponent);
        if (!(lengths[i] > 0)) flip = i;
    }
    if (mirrored) {
        trs->scale[flip] = lengths[flip] > 0 ? -trs->scale[flip] : 0;
        for (int k = 0; k < 3; ++k) columns[3 * flip + k] = -columns[3 * flip + k];
    }
    rotation_of_columns(columns, trs->rotation);
}

double norma_gltf_matrix_decompose(const double m[16], gltf_trs *trs) {
    double columns[9], lengths[3], worst = 0;
    const int exponent = scaled_columns(m, columns);
    for (int i = 0; i < 3; ++i) {
        const double *a = columns + 3 * i, *b = columns + 3 * ((i + 1) % 3);
        const double product = sqrt(norma_core_dot(a, a)) * sqrt(norma_core_dot(b, b));
        if (product > 0) worst = fmax(worst, fabs(norma_core_dot(a, b)) / product);
    }
    memcpy(trs->translation, m + 12, sizeof trs->translation);
    if (worst < 1e-3) {
        normalise_columns(columns, lengths);
        rotation_and_scale(columns, lengths, exponent, trs);
    }
    return worst;
}

/* Rotates columns p and q of a, and of v with them, so that those of a become perpendicular.
 * Returns whether they were not. */
static int rotate_node_columns(double a[9], double v[9], int p, int q) {
    double *x = a + 3 * p, *y = a + 3 * q;
    const double xx = norma_core_dot(x, x), yy = norma_core_dot(y, y), xy = norma_core_dot(x, y);
    if (fabs(xy) <= 1e-16 * sqrt(xx) * sqrt(yy)) return 0;
    const double zeta = (yy - xx) / (2 * xy);
    const double t = (zeta < 0 ? -1 : 1) / (fabs(zeta) + sqrt(1 + zeta * zeta)),
                 c = 1 / sqrt(1 + t * t), s = c * t;
    for (int k = 0; k < 3; ++k) {
        const double ax = x[k], vx = v[3 * p + k], vy = v[3 * q + k];
        x[k] = c * ax - s * y[k];
        y[k] = s * ax + c * y[k];
        v[3 * p + k] = c * vx - s * vy;
        v[3 * q + k] = s * vx + c * vy;
    }
    return 1;
}

void norma_gltf_matrix_split(const double m[16], gltf_trs *outer, gltf_trs *inner) {
    double a[9], lengths[3], v[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const int exponent = scaled_columns(m, a);
    for (int sweep = 0, turned = 1; turned && sweep < 60; ++sweep) { /* converges in about six */
        turned = rotate_node_columns(a, v, 0, 1);
        turned |= rotate_node_columns(a, v, 0, 2); /* in this order, which no compiler may change */
        turned |= rotate_node_columns(a, v, 1, 2);
    }
    normalise_columns(a, lengths);
    memcpy(outer->translation, m + 12, sizeof outer->translation);
    rotation_and_scale(a, lengths, exponent, outer);

    rotation_of_columns(v, inner->rotation); /* its inverse: m = outer v^T */
    for (int k = 0; k < 3; ++k) {
        inner->rotation[k] = 0.0 - inner->rotation[k];
        inner->translation[k] = 0;
        inner->scale[k] = 1;
    }
}

/* ---- The places where a node draws its mesh again and again (EXT_mesh_gpu_instancing). */

/* The accessor of their first attribute, which says how many there are; GLTF_NONE: one. */
static uint32_t first_of_instances(const gltf *g, uint32_t attributes) {
    const uint32_t first = norma_json_is(&g->json, attributes, JSON_OBJECT)
                               ? norma_json_first(&g->json, attributes)
                               : JSON_NONE;
    return norma_gltf_number(g, first, g->accessor_count);
}

static norma_document_result read_instance_array(gltf *g, uint32_t token, uint32_t width,
    size_t count, gltf_array *array, norma_document_error *error) {
    const uint32_t accessor = norma_gltf_number(g, token, g->accessor_count);
    if (accessor == GLTF_NONE)
        return norma_gltf_malformed(g, error, token, "the number of an existing accessor");
    const norma_document_result result = norma_gltf_array(g, accessor, array, error);
    if (result) return result;
    return array->width == width && array->count >= count && array->component != GLTF_UINT
               ? NORMA_DOCUMENT_OK
               : norma_gltf_malformed(g, error, token, "one vector for each instance");
}

/* Instances that have no place of their own are as many as the first attribute has elements: those
 * must be there then, or a few bytes would draw a mesh any number of times. */
norma_document_result norma_gltf_read_instances(
    gltf *g, uint32_t node, gltf_instances *instances, norma_document_error *error) {
    static const char *const keys[] = {"TRANSLATION", "ROTATION", "SCALE"};
    gltf_array *const arrays[] = {&instances->translation, &instances->rotation, &instances->scale};
    gltf_array elements;
    const uint32_t attributes = norma_json_member(&g->json,
                       norma_gltf_extension(g, g->nodes[node].token, "EXT_mesh_gpu_instancing"),
                       "attributes"),
                   first = first_of_instances(g, attributes);
    norma_document_result result = NORMA_DOCUMENT_OK;
    int any = 0;
    *instances = (gltf_instances){.attributes = attributes};
    for (int k = 0; k < 3 && !result; ++k) {
        const uint32_t token = norma_json_member(&g->json, attributes, keys[k]);
        if (token == JSON_NONE) continue;
        any = 1;
        result = read_instance_array(
            g, token, k == 1 ? 4 : 3, g->nodes[node].instances, arrays[k], error);
    }
    return result || any || first == GLTF_NONE ? result
                                               : norma_gltf_array(g, first, &elements, error);
}

void norma_gltf_instance_matrix(const gltf_instances *instances, size_t index, double matrix[16]) {
    gltf_trs trs = {{0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1}};
    float f[4];
    if (instances->translation.width) {
        norma_gltf_floats(&instances->translation, index, f);
        for (int k = 0; k < 3; ++k) trs.translation[k] = (double)f[k];
    }
    if (instances->scale.width) {
        norma_gltf_floats(&instances->scale, index, f);
        for (int k = 0; k < 3; ++k) trs.scale[k] = (double)f[k];
    }
    if (instances->rotation.width) {
        norma_gltf_floats(&instances->rotation, index, f);
        double squares = 0;
        for (int k = 0; k < 4; ++k) squares += (double)f[k] * (double)f[k];
        for (int k = 0; k < 4 && squares > 0; ++k) trs.rotation[k] = (double)f[k] / sqrt(squares);
    }
    norma_gltf_matrix_compose(&trs, matrix);
}

/* ---- The ways in which a tile draws its scene again and again (i3dm). Source: OGC 18-053r2, 3D
 * Tiles Specification 1.0, 10.3 (Instanced 3D Model) and Annex A (octahedral vectors). */

typedef struct tile_table { /* the numbers behind the JSON of a feature table */
    const json *j;
    const unsigned char *data;
    size_t size, count;
} tile_table;

/* at: NULL where the table does not have them. 0: they do not lie in the table. */
static int find_tile_array(
    const tile_table *table, const char *key, size_t element, const unsigned char **at) {
    const uint32_t member = norma_json_member(table->j, 0, key);
    uint64_t offset;
    *at = NULL;
    if (member == JSON_NONE) return 1;
    if (!norma_json_uint(table->j, norma_json_member(table->j, member, "byteOffset"), &offset) ||
        offset > table->size || (table->size - (size_t)offset) / element < table->count)
        return 0;
    *at = table->data + offset;
    return 1;
}

/* Places bound the number of instances by the size of the file. */
static int find_tile_arrays(const tile_table *table, gltf_tile *tile) {
    const unsigned char *place, *small_place, *up, *right;
    if (!find_tile_array(table, "POSITION", 12, &place) ||
        !find_tile_array(table, "POSITION_QUANTIZED", 6, &small_place) ||
        !find_tile_array(table, "NORMAL_UP", 12, &tile->up) ||
        !find_tile_array(table, "NORMAL_RIGHT", 12, &tile->right) ||
        !find_tile_array(table, "NORMAL_UP_OCT32P", 4, &up) ||
        !find_tile_array(table, "NORMAL_RIGHT_OCT32P", 4, &right) ||
        !find_tile_array(table, "SCALE", 4, &tile->scale) ||
        !find_tile_array(table, "SCALE_NON_UNIFORM", 12, &tile->scales) || !(place || small_place))
        return 0;
    tile->has_octahedral = !(tile->up && tile->right);
    if (tile->has_octahedral) {
        tile->up = up && right ? up : NULL;
        tile->right = right;
    }
    return 1;
}

/* An array of three numbers. 0: it is something else. */
static int read_center(const json *j, uint32_t numbers, double center[3]) {
    uint32_t element = JSON_NONE;
    int count = 0;
    while (count < 3 && norma_json_each(j, numbers, &element) &&
           norma_json_number(j, element, &center[count]))
        ++count;
    return numbers == JSON_NONE || count == 3;
}

int norma_gltf_read_frame(const gltf *g, double center[3]) {
    const json *j = &g->json;
    const uint32_t rtc = norma_gltf_extension(g, 0, "CESIUM_RTC");
    memcpy(center, g->tile.center, sizeof g->tile.center);
    return !g->tile.is_elsewhere && read_center(j, norma_json_member(j, rtc, "center"), center);
}

norma_document_result norma_gltf_read_tile_instances(gltf *g, norma_document_error *error) {
    gltf_tile *tile = &g->tile;
    if (!tile->depth) return NORMA_DOCUMENT_OK;
    const unsigned char *header = g->document->source.data + tile->headers[tile->depth - 1];
    const int has_instances = memcmp(header, "i3dm", 4) == 0;
    const unsigned char *at = header + (has_instances ? 32 : 28);
    const size_t text = norma_gltf_u32(header + 12);
    json j = {0};
    json_error wrong = {0};
    uint64_t count = 0;
    const int is_json = norma_json_parse((const char *)at, text, NULL, &j, &wrong);
    tile_table table = {&j, at + text, norma_gltf_u32(header + 16), 0};
    int is_good =
        is_json && norma_json_uint(&j, norma_json_member(&j, 0, "INSTANCES_LENGTH"), &count);
    table.count = (size_t)count;
    is_good = is_good && has_instances && find_tile_arrays(&table, tile);
    tile->is_elsewhere =
        has_instances ||
        (is_json && !read_center(&j, norma_json_member(&j, 0, "RTC_CENTER"), tile->center));
    norma_json_free(&j);
    if (!is_json && !wrong.expected) return norma_document_fail_memory(g->document, error);
    if (!has_instances) return NORMA_DOCUMENT_OK;
    if (!is_good)
        tile->not_read = "the tile's instances, as its feature table does not have an element for "
                         "each of INSTANCES_LENGTH in POSITION and the like";
    else if (tile->up || tile->scale || tile->scales)
        tile->instances = (size_t)count;
    return NORMA_DOCUMENT_OK;
}

static double tile_float(const unsigned char *at) {
    const uint32_t bits = norma_gltf_u32(at);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

static void read_tile_direction(
    const gltf_tile *tile, const unsigned char *vectors, size_t index, double out[3]) {
    for (int k = 0; k < 3 && !tile->has_octahedral; ++k)
        out[k] = tile_float(vectors + 12 * index + 4 * (size_t)k);
    if (!tile->has_octahedral) return;
    const uint32_t both = norma_gltf_u32(vectors + 4 * index);
    const double x = (both & 0xFFFF) / 32767.5 - 1, y = (both >> 16) / 32767.5 - 1,
                 z = 1 - fabs(x) - fabs(y);
    out[0] = z < 0 ? (1 - fabs(y)) * (x < 0 ? -1 : 1) : x;
    out[1] = z < 0 ? (1 - fabs(x)) * (y < 0 ? -1 : 1) : y;
    out[2] = z;
    const double length = sqrt(norma_core_dot(out, out));
    for (int k = 0; k < 3; ++k) out[k] /= length;
}

size_t norma_gltf_tile_instance(const norma_document *document, size_t index, double matrix[16]) {
    static const double y_up[16] = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1};
    const gltf_tile *tile = &norma_gltf_of(document)->tile;
    if (index >= tile->instances) return tile->instances;
    double columns[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (tile->up) {
        read_tile_direction(tile, tile->right, index, columns);
        read_tile_direction(tile, tile->up, index, columns + 3);
        norma_core_cross(columns, columns + 3, columns + 6);
    }
    norma_gltf_matrix_identity(matrix);
    for (size_t axis = 0; axis < 3; ++axis) {
        const double all = tile->scale ? tile_float(tile->scale + 4 * index) : 1,
                     one = tile->scales ? tile_float(tile->scales + 12 * index + 4 * axis) : 1;
        for (size_t k = 0; k < 3; ++k) matrix[4 * axis + k] = columns[3 * axis + k] * all * one;
    }
    norma_gltf_matrix_multiply(matrix, y_up, matrix);
    return tile->instances;
}

/* ---- The node tree: local matrices, world matrices in double precision, what each node
 * draws. A tree it must be: a node with two parents, or in a loop, is told by name. */

/* Reads up to count numbers of a member; *there tells whether it is there. 0: of another type or
 * length. */
static int read_node_numbers(
    const gltf *g, uint32_t object, const char *key, uint32_t count, double *out, int *there) {
    const json *j = &g->json;
    uint32_t list = norma_json_member(j, object, key), i = 0;
    *there = list != JSON_NONE;
    if (!*there) return 1;
    if (!norma_json_is(j, list, JSON_ARRAY) || norma_json_size(j, list) != count) return 0;
    for (uint32_t item = JSON_NONE; norma_json_each(j, list, &item);)
        if (!norma_json_number(j, item, &out[i++])) return 0;
    return 1;
}

static norma_document_result read_local(
    const gltf *g, gltf_node *node, norma_document_error *error) {
    gltf_trs trs = {.rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
    int there;
    if (!read_node_numbers(g, node->token, "matrix", 16, node->local, &node->has_matrix))
        return norma_gltf_malformed(g, error, node->token, "16 numbers in \"matrix\"");
    if (node->has_matrix) return NORMA_DOCUMENT_OK;
    if (!read_node_numbers(g, node->token, "translation", 3, trs.translation, &there) ||
        !read_node_numbers(g, node->token, "rotation", 4, trs.rotation, &there) ||
        !read_node_numbers(g, node->token, "scale", 3, trs.scale, &there))
        return norma_gltf_malformed(
            g, error, node->token, "3 numbers in \"translation\" and \"scale\", 4 in \"rotation\"");
    norma_gltf_matrix_compose(&trs, node->local);
    return NORMA_DOCUMENT_OK;
}

static void read_instances(const gltf *g, gltf_node *node) {
    const uint32_t extension = norma_gltf_extension(g, node->token, "EXT_mesh_gpu_instancing"),
                   first =
                       first_of_instances(g, norma_json_member(&g->json, extension, "attributes"));
    node->instanced = extension != JSON_NONE;
    node->instances = first == GLTF_NONE ? 1 : g->accessors[first].count;
}

static norma_document_result read_node(gltf *g, gltf_node *node, norma_document_error *error) {
    node->mesh = node->skin = GLTF_NONE;
    node->name = norma_gltf_read_name(g, node->token);
    if (!node->name) return norma_document_fail_memory(g->document, error);
    if (!norma_gltf_index_member(g, node->token, "mesh", g->mesh_count, &node->mesh))
        return norma_gltf_malformed(
            g, error, node->token, "the number of an existing mesh in \"mesh\"");
    if (!norma_gltf_index_member(g, node->token, "skin", g->skin_count, &node->skin))
        return norma_gltf_malformed(
            g, error, node->token, "the number of an existing skin in \"skin\"");
    if (node->mesh != GLTF_NONE) ++g->meshes[node->mesh].uses;
    read_instances(g, node);
    return read_local(g, node, error);
}

static norma_document_result read_children(gltf *g, uint32_t number, norma_document_error *error) {
    const json *j = &g->json;
    uint32_t children = norma_json_member(j, g->nodes[number].token, "children");
    if (children != JSON_NONE && !norma_json_is(j, children, JSON_ARRAY))
        return norma_gltf_malformed(g, error, children, "an array");
    for (uint32_t item = JSON_NONE; norma_json_each(j, children, &item);) {
        const uint32_t child = norma_gltf_number(g, item, g->node_count);
        if (child == GLTF_NONE)
            return norma_gltf_malformed(g, error, item, "the number of an existing node");
        if (g->nodes[child].parent != GLTF_NONE || child == number)
            return norma_gltf_malformed(
                g, error, item, "a node that is no other node's child and not its own");
        g->nodes[child].parent = number;
    }
    return NORMA_DOCUMENT_OK;
}

/* World matrices from the roots down. A node that no root leads to hangs in a loop. state: 0
 * unknown, 1 done, 2 on the way. */
static norma_document_result place_nodes(
    gltf *g, uint32_t *path, unsigned char *done, norma_document_error *error) {
    for (uint32_t i = 0; i < g->node_count; ++i) {
        uint32_t depth = 0, at = i;
        while (at != GLTF_NONE && !done[at]) {
            if (depth == g->node_count)
                return norma_gltf_malformed(
                    g, error, g->nodes[i].token, "nodes that form a tree, not a loop");
            path[depth++] = at;
            at = g->nodes[at].parent;
        }
        while (depth-- > 0) {
            gltf_node *node = &g->nodes[path[depth]];
            if (node->parent == GLTF_NONE)
                memcpy(node->world, node->local, sizeof node->world);
            else
                norma_matrix_multiply(g->nodes[node->parent].world, node->local, node->world);
            done[path[depth]] = 1;
        }
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_all_nodes(gltf *g, uint32_t list, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    uint32_t number = 0;
    for (uint32_t item = JSON_NONE; !result && norma_json_each(&g->json, list, &item); ++number) {
        g->nodes[number].token = item;
        g->nodes[number].parent = GLTF_NONE;
        result = read_node(g, &g->nodes[number], error);
    }
    for (uint32_t i = 0; !result && i < g->node_count; ++i) result = read_children(g, i, error);
    return result;
}

norma_document_result norma_gltf_read_nodes(gltf *g, norma_document_error *error) {
    uint32_t list;
    norma_document_result result = norma_gltf_read_list(g, "nodes", &list, &g->node_count, error);
    if (result) return result;
    const uint32_t skins = norma_json_member(&g->json, 0, "skins");
    g->skin_count =
        norma_json_is(&g->json, skins, JSON_ARRAY) ? norma_json_size(&g->json, skins) : 0;
    g->nodes = norma_io_allocate(g->node_count, sizeof *g->nodes);
    g->drawing = norma_io_allocate(g->node_count, sizeof *g->drawing);
    uint32_t *path = norma_io_allocate(g->node_count, sizeof *path);
    unsigned char *done = norma_io_allocate(g->node_count, 1);
    if (!g->nodes || !g->drawing || !path || !done)
        result = norma_document_fail_memory(g->document, error);
    if (!result) result = read_all_nodes(g, list, error);
    if (!result) result = place_nodes(g, path, done, error);
    for (uint32_t i = 0; !result && i < g->node_count; ++i) {
        if (g->nodes[i].mesh == GLTF_NONE) continue;
        g->drawing[g->drawing_count++] = i;
        if (g->nodes[i].instanced) result = norma_gltf_place_instances(g, &g->nodes[i], error);
    }
    free(path);
    free(done);
    return result;
}
