/* test_ply.c: the peculiarities of PLY one by one, each in a small file written here: encodings,
 * line ends, creases that split, strips, broken normals, transforms. */
#include "check.h"
#include "document_bytes.h"
#include "ply_rows.h"

#define VERTEX_FLOATS "property float x\nproperty float y\nproperty float z\n"

static document_bytes text_file(const char *text) { return bytes_copy(text, strlen(text)); }

static ply_rows parsed(document_bytes bytes) {
    ply_rows rows;
    assert_true(rows_parse(bytes.data, bytes.size, &rows));
    return rows;
}

static void assert_text(document_bytes bytes, const char *expected) {
    if (bytes.size != strlen(expected) || memcmp(bytes.data, expected, bytes.size) != 0)
        fail_msg("got\n%.*s\nexpected\n%s", (int)bytes.size, (const char *)bytes.data, expected);
}

static const double mirror_x[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

/* ---- the layout of what is written */

static void test_normals_stand_after_z(void **state) {
    (void)state;
    document_bytes in = text_file(
        "ply\nformat ascii 1.0\ncomment  kept  \nelement vertex 3\nproperty float x\nproperty "
        "float y\nproperty float z\ncomment here\n"
        "property uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0  0\t7\n 1.50 0 0 8 \n0 2e0 0 9\n3 0 1 2\n");
    norma_compute_summary summary;
    document_bytes out = bytes_computed(in, "a.ply", NULL, &summary);
    assert_text(out, "ply\nformat ascii 1.0\ncomment  kept  \nelement vertex 3\nproperty float "
                     "x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n"
                     "property float nz\ncomment here\nproperty uchar red\nelement face "
                     "1\nproperty list uchar int vertex_indices\nend_header\n"
                     "0 0  0 0 0 1\t7\n 1.50 0 0 0 0 1 8 \n0 2e0 0 0 0 1 9\n3 0 1 2\n");
    assert_int_equal(summary.changed, 1);
    assert_int_equal(summary.shading, NORMA_SHADING_SMOOTH);
    bytes_free(&in);
    bytes_free(&out);
}

/* Some programs write more values than they declare: they stay where they stand, in rows that are
 * copied too, and are named as not read. */
static void test_surplus_values_stay(void **state) {
    (void)state;
    document_bytes in =
        text_file("ply\nformat ascii 1.0\nelement vertex 4\n" VERTEX_FLOATS
                  "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                  "0 0 0 7 8 \n1 0 0\n0 1 0\t9\n0 0 1 x\n3 0 1 2 255 0\n3 0 3 1\n");
    const norma_compute_options creased = {
        .shading = NORMA_SHADING_CREASE, .crease_angle_rad = 0.5};
    document_bytes out = bytes_computed(in, "a.ply", &creased, NULL),
                   moved = bytes_transformed(in, "a.ply", mirror_x, NULL);
    assert_text(out, "ply\nformat ascii 1.0\nelement vertex 6\n" VERTEX_FLOATS
                     "property float nx\nproperty float ny\nproperty float nz\n"
                     "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                     "0 0 0 0 0 1 7 8 \n1 0 0 0 0 1\n0 1 0 0 0 1\t9\n0 0 1 0 1 0 x\n"
                     "0 0 0 0 1 0 7 8\n1 0 0 0 1 0\n3 0 1 2 255 0\n3 4 3 5\n");
    assert_text(moved, "ply\nformat ascii 1.0\nelement vertex 4\n" VERTEX_FLOATS
                       "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                       "0 0 0 7 8 \n-1 0 0\n0 1 0\t9\n0 0 1 x\n3 0 2 1 255 0\n3 0 1 3\n");
    norma_document *document = bytes_open(in, "a.ply");
    norma_unread unread;
    assert_int_equal(norma_document_unread_count(document), 1);
    assert_int_equal(norma_document_unread(document, 0, &unread), NORMA_DOCUMENT_OK);
    assert_string_equal(unread.where, "line 10");
    assert_string_equal(
        unread.why, "4 rows hold more values than the header declares, first in line 10");
    norma_document_close(document);
    bytes_free(&in);
    bytes_free(&out);
    bytes_free(&moved);
}

#define COMMENTED(vertices, faces)                                                                 \
    "ply\nformat ascii 1.0\nelement vertex " vertices "\n" VERTEX_FLOATS "element face " faces     \
    "\nproperty list uchar int vertex_indices\nend_header\n"

/* Between rows they belong to the header's language no more, but people write them there. They stay
 * beside rows that change, are added or dropped. */
static void test_comments_between_rows_stay(void **state) {
    (void)state;
    static const uint8_t first[] = {1, 0};
    document_bytes in = text_file(COMMENTED("4", "2") "\ncomment a\n0 0 0\n1 0 0\ncomment b 1 2 3\n"
                                                      "comment\n\n0 1 0\n0 0 1\ncomment c\n"
                                                      "3 0 1 2\n comment d\n3 0 3 1\ncomment e\n");
    const norma_compute_options creased = {
        .shading = NORMA_SHADING_CREASE, .crease_angle_rad = 0.5};
    document_bytes out = bytes_computed(in, "a.ply", &creased, NULL),
                   moved = bytes_transformed(in, "a.ply", mirror_x, NULL);
    assert_text(out, "ply\nformat ascii 1.0\nelement vertex 6\n" VERTEX_FLOATS
                     "property float nx\nproperty float ny\nproperty float nz\n"
                     "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                     "\ncomment a\n0 0 0 0 0 1\n1 0 0 0 0 1\ncomment b 1 2 3\ncomment\n\n"
                     "0 1 0 0 0 1\n0 0 1 0 1 0\n0 0 0 0 1 0\n1 0 0 0 1 0\ncomment c\n"
                     "3 0 1 2\n comment d\n3 4 3 5\ncomment e\n");
    assert_text(moved, COMMENTED("4", "2") "\ncomment a\n0 0 0\n-1 0 0\ncomment b 1 2 3\n"
                                           "comment\n\n0 1 0\n0 0 1\ncomment c\n"
                                           "3 0 2 1\n comment d\n3 0 1 3\ncomment e\n");
    norma_document *document = bytes_open(in, "a.ply");
    const norma_mesh_edit edit = {.drop_faces = first};
    assert_int_equal(norma_document_note_count(document), 0);
    assert_int_equal(norma_document_edit(document, &edit, NULL), NORMA_DOCUMENT_OK);
    document_bytes dropped = bytes_of(document);
    assert_text(dropped, COMMENTED("4", "1") "\ncomment a\n0 0 0\n1 0 0\ncomment b 1 2 3\n"
                                             "comment\n\n0 1 0\n0 0 1\ncomment c\n"
                                             " comment d\n3 0 3 1\ncomment e\n");
    norma_document_close(document);
    bytes_free(&in);
    bytes_free(&out);
    bytes_free(&moved);
    bytes_free(&dropped);
}

static void test_crlf_and_no_last_line_break(void **state) {
    (void)state;
    document_bytes in =
        text_file("ply\r\nformat ascii 1.0\r\nelement face 1\r\nproperty list uchar int "
                  "vertex_index\r\nelement vertex 3\r\nproperty float32 x\r\n"
                  "property float32 y\r\nproperty float32 z\r\nend_header\r\n3 0 1 2\r\n0 0 0\r\n1 "
                  "0 0\r\n0 1 0");
    document_bytes out = bytes_computed(in, "a.ply", NULL, NULL);
    assert_text(out,
        "ply\r\nformat ascii 1.0\r\nelement face 1\r\nproperty list uchar int "
        "vertex_index\r\nelement vertex 3\r\nproperty float32 x\r\nproperty float32 y\r\n"
        "property float32 z\r\nproperty float32 nx\r\nproperty float32 ny\r\nproperty float32 "
        "nz\r\nend_header\r\n3 0 1 2\r\n0 0 0 0 0 1\r\n1 0 0 0 0 1\r\n"
        "0 1 0 0 0 1");
    bytes_free(&in);
    bytes_free(&out);
}

/* A body may begin with any byte: after a CR header with 0x0A, after an LF one with 0x0D. */
static void test_bodies_that_begin_with_a_line_end(void **state) {
    (void)state;
    for (int cr = 0; cr < 2; ++cr) {
        char header[400];
        snprintf(header, sizeof header,
            "ply\nformat binary_little_endian 1.0\nelement vertex 3\n" VERTEX_FLOATS
            "element face 1\nproperty list uchar uchar vertex_indices\nend_header\n");
        for (char *at = header; *at && cr; ++at)
            if (*at == '\n') *at = '\r';
        float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
        ((unsigned char *)positions)[0] = cr ? '\n' : '\r';
        const unsigned char face[4] = {3, 0, 1, 2};
        unsigned char file[600];
        const size_t size = strlen(header);
        memcpy(file, header, size);
        memcpy(file + size, positions, sizeof positions);
        memcpy(file + size + sizeof positions, face, sizeof face);
        document_bytes in = bytes_copy(file, size + sizeof positions + sizeof face),
                       out = bytes_computed(in, "a.ply", NULL, NULL);
        ply_rows rows = parsed(out);
        const rows_element *vertex = rows_find(&rows, "vertex");
        assert_int_equal(vertex->count, 3);
        assert_memory_equal(rows_value_of(vertex, 0, 0).at, positions, 12);
        assert_true(rows_number(&rows, vertex, 2, "nz") == 1);
        assert_memory_equal(rows_value_of(rows_find(&rows, "face"), 0, 0).at, face, 4);
        rows_free(&rows);
        bytes_free(&in);
        bytes_free(&out);
    }
}

/* ---- creases */

static const char cube_header[] =
    "element vertex 8\nproperty double weight\n" VERTEX_FLOATS
    "property uchar red\nproperty list uchar short tags\n"
    "element face 6\nproperty list uchar uchar vertex_indices\nproperty float area\nend_header\n";
static const unsigned char cube_faces[6][4] = {
    {0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {2, 3, 7, 6}, {1, 2, 6, 5}, {3, 0, 4, 7}};
static const float cube_axes[6][3] = {
    {0, 0, -1}, {0, 0, 1}, {0, -1, 0}, {0, 1, 0}, {1, 0, 0}, {-1, 0, 0}};

static void add(document_bytes *bytes, const void *data, size_t size) {
    bytes->data = realloc(bytes->data, bytes->size + size + 1);
    memcpy(bytes->data + bytes->size, data, size);
    bytes->size += size;
    bytes->data[bytes->size] = 0;
}

/* In this machine's order, which these tests take to be little-endian. Vertices carry a weight, a
 * colour and a list of 0 to 2 numbers. */
static document_bytes cube(int text) {
    char line[200];
    const char *magic = text ? "ply\nformat ascii 1.0\n" : "ply\nformat binary_little_endian 1.0\n";
    document_bytes bytes = text_file(magic);
    add(&bytes, cube_header, strlen(cube_header));
    for (int i = 0; i < 8; ++i) {
        const float p[3] = {(float)((i + 1) / 2 % 2), (float)(i / 2 % 2), (float)(i / 4)};
        const double weight = i + .25;
        const unsigned char red = (unsigned char)(i * 10), count = (unsigned char)(i % 3);
        const short tags[2] = {(short)(-i), (short)(300 + i)};
        const int length = snprintf(line, sizeof line,
            count == 2 ? "%g %g %g %g %d %d %d %d\n"
            : count    ? "%g %g %g %g %d %d %d\n"
                       : "%g %g %g %g %d %d\n",
            weight, (double)p[0], (double)p[1], (double)p[2], red, count, tags[0], tags[1]);
        if (text)
            add(&bytes, line, (size_t)length);
        else
            add(&bytes, &weight, 8), add(&bytes, p, 12), add(&bytes, &red, 1),
                add(&bytes, &count, 1), add(&bytes, tags, 2u * count);
    }
    for (int i = 0; i < 6; ++i) {
        const float area = (float)i;
        const unsigned char *f = cube_faces[i];
        if (text)
            add(&bytes, line,
                (size_t)snprintf(
                    line, sizeof line, "4 %d %d %d %d %d\n", f[0], f[1], f[2], f[3], i));
        else
            add(&bytes, "\4", 1), add(&bytes, f, 4), add(&bytes, &area, 4);
    }
    return bytes;
}

/* A vertex that no face uses takes part in a split as a face of its own, of which no count tells.
 */
static void test_what_is_idle_is_not_counted(void **state) {
    (void)state;
    static const char text[] =
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 2\nproperty list uchar int vertex_indices\n"
        "end_header\n0 0 0\n1 0 0\n0 1 0\nnan 0 0\n5 5 5\n-inf 1 1\n3 0 1 2\n3 0 1 1\n";
    for (int creases = 0; creases < 2; ++creases) {
        const norma_compute_options options = {.struct_size = sizeof options,
            .shading = creases ? NORMA_SHADING_CREASE : NORMA_SHADING_SMOOTH,
            .crease_angle_rad = 0.5};
        norma_compute_summary summary;
        document_bytes in = {0};
        add(&in, text, sizeof text - 1);
        document_bytes out = bytes_computed(in, "idle.ply", &options, &summary);
        assert_int_equal(summary.faces, 2);
        assert_int_equal(summary.report.degenerate_faces.count, 1);
        assert_int_equal(summary.report.degenerate_faces.first, 1);
        assert_int_equal(summary.report.non_finite.count, 2);
        assert_int_equal(summary.report.unreferenced.count, 1);
        bytes_free(&in);
        bytes_free(&out);
    }
}

static void test_a_crease_splits_with_all_properties(void **state) {
    (void)state;
    for (int text = 0; text < 2; ++text) {
        const norma_compute_options crease = {
            .struct_size = sizeof crease, .shading = NORMA_SHADING_CREASE, .crease_angle_rad = 0.5};
        norma_compute_summary summary;
        document_bytes in = cube(text), out = bytes_computed(in, "cube.ply", &crease, &summary);
        ply_rows old = parsed(in), now = parsed(out);
        const rows_element *before = rows_find(&old, "vertex"), *after = rows_find(&now, "vertex"),
                           *face = rows_find(&now, "face");
        assert_int_equal(summary.vertices_before, 8);
        assert_int_equal(summary.vertices_after, 24);
        assert_int_equal(summary.hard_edges, 12);
        assert_int_equal(summary.edges_counted, 1);
        assert_int_equal(after->count, 24);
        int used[24] = {0};
        for (size_t f = 0; f < 6; ++f) {
            long long list[4];
            assert_int_equal(rows_list(&now, face, f, 0, list), 4);
            assert_true(rows_number(&now, face, f, "area") == (double)f);
            for (int k = 0; k < 4; ++k) {
                const size_t vertex = (size_t)list[k], source = cube_faces[f][k];
                ++used[vertex];
                if (vertex < 8) assert_int_equal(vertex, source);
                static const char *const names[] = {"weight", "x", "y", "z", "red"};
                for (int p = 0; p < 5; ++p)
                    assert_true(rows_number(&now, after, vertex, names[p]) ==
                                rows_number(&old, before, source, names[p]));
                const rows_value tags = rows_value_of(before, source, 5),
                                 copy = rows_value_of(after, vertex, 8);
                assert_int_equal(tags.size, copy.size);
                assert_memory_equal(tags.at, copy.at, tags.size);
                const float normal[3] = {(float)rows_number(&now, after, vertex, "nx"),
                    (float)rows_number(&now, after, vertex, "ny"),
                    (float)rows_number(&now, after, vertex, "nz")};
                for (int axis = 0; axis < 3; ++axis)
                    assert_true(normal[axis] == cube_axes[f][axis]);
            }
        }
        for (int i = 0; i < 24; ++i) assert_int_equal(used[i], 1);
        rows_free(&old);
        rows_free(&now);
        bytes_free(&in);
        bytes_free(&out);
    }
}

/* 30 cubes of 240 vertices fit bytes; split they are 720. The two vertices that no face uses get
 * normals too, and stay two. */
static void test_lists_widen_only_where_needed(void **state) {
    (void)state;
    document_bytes in =
        text_file("ply\nformat binary_little_endian 1.0\nelement vertex 242\n" VERTEX_FLOATS
                  "element face 180\nproperty list uint8 uint8 vertex_indices\nend_header\n");
    for (int i = 0; i < 242; ++i) {
        const float p[3] = {
            (float)((i % 8 + 1) / 2 % 2 + 3 * (i / 8)), (float)(i % 8 / 2 % 2), (float)(i % 8 / 4)};
        add(&in, p, 12);
    }
    for (int i = 0; i < 180; ++i) {
        add(&in, "\4", 1);
        for (int k = 0; k < 4; ++k) {
            const unsigned char index = (unsigned char)(cube_faces[i % 6][k] + 8 * (i / 6));
            add(&in, &index, 1);
        }
    }
    const norma_compute_options flat = {.struct_size = sizeof flat, .shading = NORMA_SHADING_FLAT};
    norma_compute_summary summary;
    document_bytes out = bytes_computed(in, "cubes.ply", &flat, &summary),
                   smooth = bytes_computed(in, "cubes.ply", NULL, NULL);
    assert_non_null(strstr((const char *)out.data, "property list uint8 uint16 vertex_indices\n"));
    assert_non_null(strstr((const char *)out.data, "element vertex 722\n"));
    assert_non_null(
        strstr((const char *)smooth.data, "property list uint8 uint8 vertex_indices\n"));
    assert_int_equal(summary.vertices_after, 722);
    assert_int_equal(summary.filled, 2);
    assert_int_equal(summary.report.unreferenced.count, 2);
    assert_int_equal(summary.report.unreferenced.first, 240);
    assert_int_equal(summary.report.degenerate_faces.count, 0);
    ply_rows rows = parsed(out);
    const rows_element *vertex = rows_find(&rows, "vertex"), *face = rows_find(&rows, "face");
    for (size_t f = 0; f < 180; ++f) {
        long long list[4];
        rows_list(&rows, face, f, 0, list);
        for (int k = 0; k < 4; ++k)
            assert_true(
                rows_number(&rows, vertex, (size_t)list[k], "nz") == (double)cube_axes[f % 6][2]);
    }
    for (size_t i = 240; i < 242; ++i) {
        const double x = rows_number(&rows, vertex, i, "nx"),
                     y = rows_number(&rows, vertex, i, "ny"),
                     z = rows_number(&rows, vertex, i, "nz");
        assert_true(fabs(x) + fabs(y) + fabs(z) == 1);
    }
    rows_free(&rows);
    bytes_free(&in);
    bytes_free(&out);
    bytes_free(&smooth);
}

/* ---- strips */

/* Two strips, a ridge of 90 degrees between the second and the third triangle of the first. */
static const char strips[] =
    "ply\nformat ascii 1.0\nelement vertex 9\n" VERTEX_FLOATS
    "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 1 -1\n1 1 -1\n5 0 0\n6 0 0\n5 1 0\n10 0 1 2 3 4 5 -1 6 7 8\n";

static size_t corners_of(document_bytes bytes, double corners[][3], norma_mesh_info *info) {
    norma_document *document = bytes_open(bytes, "strips.ply");
    norma_mesh_data data;
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    norma_document_mesh_info(document, 0, info);
    const size_t count = data.mesh.corner_count;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t vertex = ((const uint32_t *)data.mesh.corners)[i];
        const size_t stride = data.mesh.positions.stride ? data.mesh.positions.stride : 12;
        float p[3];
        memcpy(p, (const char *)data.mesh.positions.data + stride * vertex, 12);
        for (int axis = 0; axis < 3; ++axis) corners[i][axis] = (double)p[axis];
    }
    norma_document_close(document);
    return count;
}

static double signed_normal(double c[][3], int axis) {
    double u[3], v[3];
    for (int i = 0; i < 3; ++i) u[i] = c[1][i] - c[0][i], v[i] = c[2][i] - c[0][i];
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    return u[a] * v[b] - u[b] * v[a];
}

static void test_strips(void **state) {
    (void)state;
    double before[64][3], after[64][3];
    norma_mesh_info info;
    document_bytes in = text_file(strips);
    assert_int_equal(corners_of(in, before, &info), 15);
    assert_int_equal(info.faces, 5);
    assert_int_equal(info.triangles, 5);
    for (int t = 0; t < 5; ++t)
        assert_true(signed_normal(before + 3 * t, t == 2 || t == 3 ? 1 : 2) == 1);
    const norma_compute_options crease = {
        .struct_size = sizeof crease, .shading = NORMA_SHADING_CREASE, .crease_angle_rad = 0.5};
    norma_compute_summary summary;
    document_bytes split = bytes_computed(in, "strips.ply", &crease, &summary);
    assert_int_equal(summary.vertices_after, 11);
    assert_non_null(strstr((const char *)split.data, "\n13 0 1 2 3 -1 9 10 4 5 -1 6 7 8\n"));
    assert_int_equal(corners_of(split, after, &info), 15);
    for (int t = 0; t < 5; ++t) /* the same triangles, each from any of its corners on */
        for (int axis = 0; axis < 3; ++axis) {
            assert_true(before[3 * t][axis] + before[3 * t + 1][axis] + before[3 * t + 2][axis] ==
                        after[3 * t][axis] + after[3 * t + 1][axis] + after[3 * t + 2][axis]);
            assert_true(signed_normal(before + 3 * t, axis) == signed_normal(after + 3 * t, axis));
        }
    norma_transform_summary moved;
    document_bytes mirrored = bytes_transformed(in, "strips.ply", mirror_x, &moved);
    assert_int_equal(moved.mirrored, 1);
    assert_int_equal(corners_of(mirrored, after, &info), 15);
    for (int t = 0; t < 5; ++t)
        assert_true(signed_normal(after + 3 * t, t == 2 || t == 3 ? 1 : 2) == 1);
    bytes_free(&in);
    bytes_free(&split);
    bytes_free(&mirrored);
}

/* ---- what is kept */

/* Normals that are right already, but for the sign of a zero. */
static void test_signs_of_zeros_stay(void **state) {
    (void)state;
    document_bytes in =
        text_file("ply\nformat binary_little_endian 1.0\nelement vertex 3\n" VERTEX_FLOATS
                  "property float nx\nproperty double ny\nproperty float nz\n"
                  "element face 1\nproperty list uchar uchar vertex_indices\nend_header\n");
    for (int i = 0; i < 3; ++i) {
        const float head[4] = {(float)(i == 1), (float)(i == 2), 0, -0.0f}, nz = 1;
        const double ny = i == 1 ? -0.0 : 0.0;
        add(&in, head, 16), add(&in, &ny, 8), add(&in, &nz, 4);
    }
    add(&in, "\3\0\1\2", 4);
    norma_compute_summary summary;
    document_bytes out = bytes_computed(in, "z.ply", NULL, &summary);
    assert_int_equal(summary.changed, 0);
    assert_true(bytes_equal(in, out));
    bytes_free(&in);
    bytes_free(&out);
}

static void test_a_mesh_without_any_direction(void **state) {
    (void)state;
    const norma_compute_options flat = {.struct_size = sizeof flat, .shading = NORMA_SHADING_FLAT};
    document_bytes in =
        text_file("ply\nformat ascii 1.0\nelement vertex 3\n" VERTEX_FLOATS
                  "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                  "0 0 0\n1 1 1\n2 2 2\n3 0 1 2\n1 2\n");
    for (int i = 0; i < 2; ++i) {
        norma_compute_summary summary;
        document_bytes out = bytes_computed(in, "d.ply", i ? &flat : NULL, &summary);
        assert_non_null(strstr((const char *)out.data,
            "end_header\n0 0 0 0 0 1\n1 1 1 0 0 1\n2 2 2 0 0 1\n3 0 1 2\n1 2\n"));
        assert_int_equal(summary.filled, 3);
        assert_int_equal(summary.report.degenerate_faces.count, 2);
        bytes_free(&out);
    }
    bytes_free(&in);
}

static void test_points_pass_through(void **state) {
    (void)state;
    document_bytes in = text_file(
        "ply\nformat ascii 1.0\nelement vertex 2\n" VERTEX_FLOATS "end_header\n0 0 0\n1 2 3\n");
    norma_document *document = bytes_open(in, "points.ply");
    norma_compute_summary summary;
    assert_int_equal(norma_document_compute(document, NULL, &summary, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(summary.changed, 0);
    assert_int_equal(summary.report.unreferenced.first, SIZE_MAX);
    assert_int_equal(norma_document_note_count(document), 1);
    document_bytes out = bytes_of(document);
    assert_true(bytes_equal(in, out));
    norma_document_close(document);
    bytes_free(&in);
    bytes_free(&out);
}

static const char with_normals[] =
    "ply\nformat ascii 1.0\nelement vertex 5\n" VERTEX_FLOATS
    "property float nx\nproperty float ny\nproperty float nz\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0 0.6000 0 0.80\n1 0 0 0 0 2\n1 1 0 nan 0 1\n0 1 0 0 0 0\n.5 .5 -1 0 1e0 0\n4 0 1 2 3\n3 "
    "0 1 4\n";

static void test_only_missing_and_broken(void **state) {
    (void)state;
    const norma_compute_options missing = {.struct_size = sizeof missing,
                                    .only = NORMA_ONLY_MISSING},
                                broken = {.struct_size = sizeof broken, .only = NORMA_ONLY_BROKEN};
    const norma_compute_options creased = {
        .struct_size = sizeof creased, .only = NORMA_ONLY_BROKEN, .shading = NORMA_SHADING_FLAT};
    norma_compute_summary summary;
    document_bytes in = text_file(with_normals),
                   same = bytes_computed(in, "n.ply", &missing, &summary);
    assert_true(bytes_equal(in, same));
    assert_int_equal(summary.changed, 0);
    document_bytes mended = bytes_computed(in, "n.ply", &broken, &summary),
                   split = bytes_computed(in, "n.ply", &creased, NULL);
    assert_int_equal(summary.changed, 1);
    assert_int_equal(summary.filled, 0);
    const char *const kept[] = {"\n0 0 0 0.6000 0 0.80\n",
        "\n1 1 0 0 0 1\n0 1 0 0 0 1\n.5 .5 -1 0 1e0 0\n4 0 1 2 3\n3 0 1 4\n"};
    for (int i = 0; i < 2; ++i) assert_non_null(strstr((const char *)mended.data, kept[i]));
    assert_null(strstr((const char *)mended.data, "\n1 0 0 0 0 2\n"));
    /* Vertex 1 is broken and on the ridge: it may part. Vertices 0 and 4 are not broken: they keep
     * their normals and get no copy. */
    ply_rows rows = parsed(split);
    assert_int_equal(rows_find(&rows, "vertex")->count, 6);
    assert_non_null(strstr((const char *)split.data, "\n0 0 0 0.6000 0 0.80\n"));
    assert_non_null(strstr((const char *)split.data, "\n3 0 5 4\n"));
    rows_free(&rows);
    bytes_free(&in);
    bytes_free(&same);
    bytes_free(&mended);
    bytes_free(&split);
}

static void test_integer_normals_keep_their_codes(void **state) {
    (void)state;
    static const struct {
        const char *type, *expected;
    } types[] = {{"char", "0 0 0 127 0 0\n"}, {"short", "0 0 0 32767 0 0\n"},
        {"uchar", "property float nx\nproperty float ny\nproperty float nz\n"},
        {"double", "0 0 0 1 0 0\n"}};
    for (size_t i = 0; i < COUNT_OF(types); ++i) {
        char text[600];
        const char *type = types[i].type;
        snprintf(text, sizeof text,
            "ply\nformat ascii 1.0\nelement vertex 3\n" VERTEX_FLOATS
            "property %s nx\nproperty %s ny\nproperty %s nz\nelement face 1\n"
            "property list uchar int vertex_indices\nend_header\n0 0 0 1 2 3\n0 1 0 1 2 3\n0 0 1 1 "
            "2 3\n3 0 1 2\n",
            type, type, type);
        document_bytes in = text_file(text), out = bytes_computed(in, "n.ply", NULL, NULL);
        if (!strstr((const char *)out.data, types[i].expected))
            fail_msg("%s: got %s", type, (const char *)out.data);
        bytes_free(&in);
        bytes_free(&out);
    }
}

/* ---- transforms */

static void test_mirror_turns_faces_and_their_texture(void **state) {
    (void)state;
    document_bytes in =
        text_file("ply\nformat ascii 1.0\nelement vertex 4\n" VERTEX_FLOATS
                  "element face 1\nproperty list uchar int vertex_indices\n"
                  "property list uchar float texcoord\nproperty float nx\nproperty float "
                  "ny\nproperty float nz\nend_header\n"
                  "1 0 0\n2 0 0\n2 1 0.5\n1 1 0.5\n4 0 1 2 3  8 0 0.0 .1 0 .1 .2 0 .2 0.6 0 0.8\n");
    norma_transform_summary summary;
    document_bytes out = bytes_transformed(in, "m.ply", mirror_x, &summary);
    assert_non_null(strstr((const char *)out.data,
        "end_header\n-1 0 0\n-2 0 0\n-2 1 0.5\n-1 1 0.5\n4 0 3 2 1  8 0 0.0 0 .2 .1 .2 .1 0 -0.6"));
    assert_int_equal(summary.mirrored, 1);
    assert_int_equal(summary.changed, 1);
    bytes_free(&in);
    bytes_free(&out);
}

static void test_mirror_turns_binary_faces(void **state) {
    (void)state;
    document_bytes in =
        text_file("ply\nformat binary_little_endian 1.0\nelement vertex 3\n" VERTEX_FLOATS
                  "element face 2\nproperty list uchar short texcoord\n"
                  "property list uchar ushort vertex_index\nend_header\n");
    const size_t header = in.size;
    const float positions[9] = {1, 0, 0, 2, 0, 0, 2, 1, 0};
    const unsigned char faces[2][20] = {
        {6, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 3, 0, 0, 1, 0, 2, 0},
        {6, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 3, 2, 0, 1, 0, 0, 0}};
    const unsigned char turned[2][20] = {
        {6, 1, 0, 2, 0, 5, 0, 6, 0, 3, 0, 4, 0, 3, 0, 0, 2, 0, 1, 0},
        {6, 1, 0, 2, 0, 5, 0, 6, 0, 3, 0, 4, 0, 3, 2, 0, 0, 0, 1, 0}};
    add(&in, positions, sizeof positions);
    add(&in, faces, sizeof faces);
    document_bytes out = bytes_transformed(in, "m.ply", mirror_x, NULL);
    assert_int_equal(out.size, in.size);
    assert_memory_equal(out.data + header + sizeof positions, turned, sizeof turned);
    bytes_free(&in);
    bytes_free(&out);
}

static void test_normals_go_through_the_normal_matrix(void **state) {
    (void)state;
    /* FACTS: diag(2, 0.5, 1) takes (1, 1, 0)/sqrt 2 to (0.2425, 0.9701, 0); plain M would give
     * (0.970, 0.243, 0). */
    const double matrix[16] = {2, 0, 0, 0, 0, .5, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1};
    document_bytes in =
        text_file("ply\nformat ascii 1.0\nelement vertex 1\n" VERTEX_FLOATS
                  "property float nx\nproperty float ny\nproperty float nz\nend_header\n"
                  "1 2 3 0.70710678 0.70710678 0\n");
    document_bytes out = bytes_transformed(in, "m.ply", matrix, NULL);
    assert_non_null(strstr((const char *)out.data, "end_header\n9 9 12 0.24253"));
    ply_rows rows = parsed(out);
    const rows_element *vertex = rows_find(&rows, "vertex");
    assert_true(fabs(rows_number(&rows, vertex, 0, "nx") - 0.24253562503633297) < 1e-7 &&
                fabs(rows_number(&rows, vertex, 0, "ny") - 0.97014250014533188) < 1e-7);
    rows_free(&rows);
    bytes_free(&in);
    bytes_free(&out);
}

static void test_whole_positions_stay_whole_where_they_can(void **state) {
    (void)state;
    const double twice[16] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1},
                 half[16] = {.5, 0, 0, 0, 0, .5, 0, 0, 0, 0, .5, 0, 0, 0, 0, 1};
    const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const char header[] = "ply\nformat binary_big_endian 1.0\nelement vertex 2\nproperty uchar "
                          "x\nproperty uchar y\nproperty uchar z\nproperty uchar r\nend_header\n";
    document_bytes in = text_file(header);
    const unsigned char body[8] = {1, 2, 3, 99, 4, 5, 127, 98};
    add(&in, body, 8);
    norma_transform_summary summary;
    document_bytes doubled = bytes_transformed(in, "m.ply", twice, &summary),
                   halved = bytes_transformed(in, "m.ply", half, NULL);
    document_bytes same = bytes_transformed(in, "m.ply", identity, &summary);
    assert_int_equal(summary.changed, 0);
    assert_true(bytes_equal(in, same));
    const unsigned char expected[8] = {2, 4, 6, 99, 8, 10, 254, 98};
    assert_int_equal(doubled.size, in.size);
    assert_memory_equal(doubled.data + strlen(header), expected, 8);
    ply_rows rows = parsed(halved);
    const rows_element *vertex = rows_find(&rows, "vertex");
    assert_string_equal(vertex->properties[0].type, "float");
    assert_true(rows_number(&rows, vertex, 0, "x") == .5 &&
                rows_number(&rows, vertex, 1, "z") == 63.5 &&
                rows_number(&rows, vertex, 1, "r") == 98);
    rows_free(&rows);
    bytes_free(&in);
    bytes_free(&doubled);
    bytes_free(&halved);
    bytes_free(&same);
}

/* One change after another, and the mesh asked for between. */
static void test_changes_follow_one_another(void **state) {
    (void)state;
    document_bytes in = cube(0);
    norma_document *document = bytes_open(in, "cube.ply");
    const norma_compute_options flat = {.struct_size = sizeof flat, .shading = NORMA_SHADING_FLAT};
    norma_transform_options transform = {.struct_size = sizeof transform};
    memcpy(transform.matrix, mirror_x, sizeof mirror_x);
    norma_mesh_data data;
    norma_mesh_info info;
    assert_int_equal(norma_document_compute(document, &flat, NULL, NULL), NORMA_DOCUMENT_OK);
    norma_document_mesh_info(document, 0, &info);
    assert_int_equal(info.vertices, 24);
    assert_int_equal(info.normals, NORMA_NORMALS_PER_VERTEX);
    assert_int_equal(norma_document_transform(document, &transform, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(data.normals.count, 24);
    const uint32_t *corners = data.mesh.corners;
    for (size_t c = 0; c < 24; ++c) {
        const float *normal = (const float *)data.normals.data + 3 * corners[c];
        const float *axis = cube_axes[c / 4];
        assert_direction(normal, -(double)axis[0], (double)axis[1], (double)axis[2], 1e-5);
    }
    for (size_t f = 0; f < 6; ++f)
        assert_int_equal(corners[4 * f] % 8 == cube_faces[f][0] || corners[4 * f] >= 8, 1);
    document_bytes out = bytes_of(document);
    ply_rows rows = parsed(out);
    assert_int_equal(rows_find(&rows, "vertex")->count, 24);
    rows_free(&rows);
    norma_document_close(document);
    bytes_free(&in);
    bytes_free(&out);
}

/* ---- refusals */

static void test_refusals_name_the_place(void **state) {
    (void)state;
    static const struct {
        const char *text, *says;
    } files[] = {
        {"ply\nformat ascii 1.0\nelement vertex 4000000000\n" VERTEX_FLOATS "end_header\n0 0 0\n",
            "a.ply:9: row 0 of element \"vertex\""},
        {"ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\n" VERTEX_FLOATS
         "end_header\n",
            "a.ply:3: "},
        {"ply\nformat binary_little_endian 1.0\nelement vertex 9223372036854775807\n" VERTEX_FLOATS
         "end_header\n",
            "a.ply:byte "},
        {"ply\nformat ascii 1.0\nelement vertex 1\n" VERTEX_FLOATS "end_header\n0 a 0\n",
            "a.ply:8: "},
        {"ply\nformat ascii 1.0\nelement vertex 1\n" VERTEX_FLOATS
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n3 0 0 1\n",
            "a.ply:11: face 0 names vertex 1"},
        {"ply\nformat ascii 1.0\nelement vertex 1\n" VERTEX_FLOATS
         "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n3 0 0 -1\n",
            "vertex -1"},
        {"ply\nformat ascii 1.0\nelement vertex 1\n" VERTEX_FLOATS
         "property float nx\nend_header\n0 0 0 0\n",
            "nx, ny and nz"},
        {"ply\nformat ascii 1.0\nelement vertex 1\n" VERTEX_FLOATS
         "property float x\nend_header\n0 0 0 0\n",
            "appears twice"},
        {"ply\nformat binary_little_endian 1.0\nelement vertex 0\n" VERTEX_FLOATS
         "element face 1\nproperty list char uchar vertex_indices\nend_header\n\xff",
            "negative length"},
        {"ply\nformat ascii 1.0\nelement vertex 1\n" VERTEX_FLOATS
         "property float nx\nproperty float ny\nproperty float nz\nend_header\n0 0 0 0 0 up\n",
            "a.ply:11: "},
        {"plyx\n", "a.ply:1: "}};
    for (size_t i = 0; i < COUNT_OF(files); ++i) {
        char message[1000];
        document_bytes in = text_file(files[i].text);
        assert_int_not_equal(bytes_try(in, "a.ply", NULL, message), NORMA_DOCUMENT_OK);
        if (!strstr(message, files[i].says))
            fail_msg("\"%s\" does not say \"%s\"", message, files[i].says);
        bytes_free(&in);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_normals_stand_after_z),
        cmocka_unit_test(test_surplus_values_stay),
        cmocka_unit_test(test_comments_between_rows_stay),
        cmocka_unit_test(test_crlf_and_no_last_line_break),
        cmocka_unit_test(test_bodies_that_begin_with_a_line_end),
        cmocka_unit_test(test_what_is_idle_is_not_counted),
        cmocka_unit_test(test_a_crease_splits_with_all_properties),
        cmocka_unit_test(test_lists_widen_only_where_needed),
        cmocka_unit_test(test_strips),
        cmocka_unit_test(test_signs_of_zeros_stay),
        cmocka_unit_test(test_a_mesh_without_any_direction),
        cmocka_unit_test(test_points_pass_through),
        cmocka_unit_test(test_only_missing_and_broken),
        cmocka_unit_test(test_integer_normals_keep_their_codes),
        cmocka_unit_test(test_mirror_turns_faces_and_their_texture),
        cmocka_unit_test(test_mirror_turns_binary_faces),
        cmocka_unit_test(test_normals_go_through_the_normal_matrix),
        cmocka_unit_test(test_whole_positions_stay_whole_where_they_can),
        cmocka_unit_test(test_changes_follow_one_another),
        cmocka_unit_test(test_refusals_name_the_place),
    };
    return cmocka_run_group_tests_name("ply", tests, NULL, NULL);
}
