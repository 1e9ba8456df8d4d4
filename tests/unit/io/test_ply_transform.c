/* test_ply_transform.c: PLY through a matrix where types have to give way: positions beyond floats,
 * strips that a mirror makes longer than their count's type counts. */
#include "check.h"
#include "document_bytes.h"
#include "ply_rows.h"

static const double MIRROR[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static document_bytes text_file(const char *text) { return bytes_copy(text, strlen(text)); }

static void expect_transform(const char *text, const double matrix[16], const char *expected) {
    document_bytes in = text_file(text), out = bytes_transformed(in, "a.ply", matrix, NULL);
    if (out.size != strlen(expected) || memcmp(out.data, expected, out.size) != 0)
        fail_msg("got\n%.*s\nexpected\n%s", (int)out.size, (const char *)out.data, expected);
    bytes_free(&out);
    bytes_free(&in);
}

/* Of the three numbers those that floats do not hold become doubles; the others stay floats. */
static void test_beyond_floats(void **state) {
    static const double large[16] = {1e30, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    (void)state;
    expect_transform("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float "
                     "y\nproperty float32 z\nend_header\n1e10 1 2\n-4 4 5\n",
        large,
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty float y\nproperty "
        "float32 z\nend_header\n1e+40 2 2\n-4e+30 8 5\n");
}

/* Points alone have no winding: a mirror moves them. */
static void test_points_under_a_mirror(void **state) {
    norma_transform_summary summary;
    (void)state;
    document_bytes in =
        text_file("ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float "
                  "y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
                  "end_header\n1 2 3 1 0 0\n-4 5 6 0 0 1\n");
    document_bytes out = bytes_transformed(in, "a.ply", MIRROR, &summary);
    assert_non_null(strstr((const char *)out.data, "end_header\n-1 2 3 -1 0 0\n4 5 6 0 0 1\n"));
    assert_true(summary.mirrored && summary.vertices == 2);
    bytes_free(&out);
    bytes_free(&in);
}

/* ---- strips */

enum { VERTICES = 200 };

static document_bytes strip_file(int binary) {
    static unsigned char file[10000];
    int size = sprintf((char *)file,
        "ply\nformat %s 1.0\nelement vertex %d\nproperty %s x\nproperty %s y\nproperty %s "
        "z\nelement tristrips 1\nproperty list uchar uchar vertex_indices\nend_header\n",
        binary ? "binary_little_endian" : "ascii", VERTICES, binary ? "uchar" : "float",
        binary ? "uchar" : "float", binary ? "uchar" : "float");
    for (int v = 0; v < VERTICES; ++v) {
        const unsigned char numbers[3] = {
            (unsigned char)(v % 2), (unsigned char)v, (unsigned char)(v * 7 % 13)};
        if (binary) memcpy(file + size, numbers, 3);
        size +=
            binary ? 3
                   : sprintf((char *)file + size, "%d %d %d\n", numbers[0], numbers[1], numbers[2]);
    }
    if (binary)
        file[size++] = VERTICES;
    else
        size += sprintf((char *)file + size, "%d", VERTICES);
    for (int v = 0; v < VERTICES; ++v) {
        if (binary)
            file[size++] = (unsigned char)v;
        else
            size += sprintf((char *)file + size, " %d", v);
    }
    return bytes_copy(file, (size_t)size);
}

/* The triangles of the strip, each turned round: in a strip again, which now ends (-1) and begins
 * often, is longer than 255 and needs signs. */
static void test_a_strip_outgrows_its_types(void **state) {
    (void)state;
    for (int binary = 0; binary < 2; ++binary) {
        document_bytes in = strip_file(binary), out = bytes_transformed(in, "a.ply", MIRROR, NULL);
        norma_mesh_data data;
        ply_rows rows;
        assert_non_null(
            strstr((const char *)out.data, "property list ushort short vertex_indices\n"));
        norma_document *document = bytes_open(out, "a.ply");
        assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
        assert_int_equal(data.mesh.corner_count, 3 * (VERTICES - 2));
        const uint32_t *corners = data.mesh.corners;
        for (uint32_t t = 0; t + 2 < VERTICES; ++t) {
            const uint32_t expected[3] = {t, t % 2 ? t + 1 : t + 2,
                t % 2 ? t + 2 : t + 1}; /* of t, t + 1, t + 2, every second one turned already */
            int found = 0;
            for (uint32_t k = 0; k < 3; ++k)
                found |= corners[3 * t] == expected[k] &&
                         corners[3 * t + 1] == expected[(k + 1) % 3] &&
                         corners[3 * t + 2] == expected[(k + 2) % 3];
            if (!found)
                fail_msg("triangle %u is %u %u %u", t, corners[3 * t], corners[3 * t + 1],
                    corners[3 * t + 2]);
        }
        assert_true(rows_parse(out.data, out.size, &rows));
        const rows_element *strips = rows_find(&rows, "tristrips");
        assert_true(rows_list(&rows, strips, 0, 0, NULL) > 255);
        rows_free(&rows);
        norma_document_close(document);
        bytes_free(&out);
        bytes_free(&in);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_beyond_floats),
        cmocka_unit_test(test_points_under_a_mirror),
        cmocka_unit_test(test_a_strip_outgrows_its_types),
    };
    return cmocka_run_group_tests_name("PLY transformed", tests, NULL, NULL);
}
