/* test_ply_data.c: every PLY of the data set read and rewritten. What may change is told by a
 * reader of the test's own: the three normals of each vertex, and where a crease parts faces, the
 * numbers of their corners, for copies of the vertices that they had. */
#include "check.h"
#include "document_bytes.h"
#include "mesh_files.h"
#include "ply_rows.h"

static int is_normal_name(const char *name) {
    return strcmp(name, "nx") == 0 || strcmp(name, "ny") == 0 || strcmp(name, "nz") == 0;
}

static void assert_same_value(rows_value a, rows_value b, const char *what, size_t row) {
    if (a.size != b.size || memcmp(a.at, b.at, a.size) != 0)
        fail_msg("%s of row %zu changed", what, row);
}

/* All properties but the normals. */
static void assert_same_row(
    const rows_element *before, size_t row, const rows_element *after, size_t new_row) {
    for (size_t i = 0; i < before->property_count; ++i) {
        const char *name = before->properties[i].name;
        if (is_normal_name(name)) continue;
        size_t same = 0, k = 0; /* the same occurrence, since names may repeat */
        for (size_t j = 0; j <= i; ++j) same += strcmp(before->properties[j].name, name) == 0;
        while (same > 0) same -= strcmp(after->properties[k++].name, name) == 0;
        assert_same_value(rows_value_of(before, row, (int)i),
            rows_value_of(after, new_row, (int)k - 1), name, row);
    }
}

static void assert_same_faces(const ply_rows *before, const ply_rows *after) {
    long long old[512], now[512];
    const rows_element *face = rows_find(before, "face"), *new_face = rows_find(after, "face");
    const rows_element *vertex = rows_find(before, "vertex"),
                       *new_vertex = rows_find(after, "vertex");
    int list = rows_property_of(face, "vertex_indices");
    list = list < 0 ? rows_property_of(face, "vertex_index") : list;
    for (size_t row = 0; face && list >= 0 && row < face->count; ++row) {
        const size_t count = rows_list(before, face, row, list, NULL);
        assert_true(count < COUNT_OF(old));
        assert_int_equal(rows_list(after, new_face, row, list, NULL), count);
        rows_list(before, face, row, list, old);
        rows_list(after, new_face, row, list, now);
        for (size_t i = 0; i < count; ++i) {
            if (now[i] == old[i]) continue;
            assert_true(
                now[i] >= (long long)vertex->count && now[i] < (long long)new_vertex->count);
            assert_same_row(vertex, (size_t)old[i], new_vertex, (size_t)now[i]);
        }
        for (size_t i = 0; i < face->property_count; ++i)
            if ((int)i != list)
                assert_same_value(rows_value_of(face, row, (int)i),
                    rows_value_of(new_face, row, (int)i), face->properties[i].name, row);
    }
}

/* Everything that is neither a normal nor the number of a corner. */
static void assert_only_normals_changed(document_bytes before, document_bytes after) {
    ply_rows old, now;
    assert_true(rows_parse(before.data, before.size, &old));
    assert_true(rows_parse(after.data, after.size, &now));
    assert_int_equal(old.encoding, now.encoding);
    assert_int_equal(old.element_count, now.element_count);
    for (size_t e = 0; e < old.element_count; ++e) {
        const rows_element *a = &old.elements[e], *b = &now.elements[e];
        assert_string_equal(a->name, b->name);
        const int is_vertex = strcmp(a->name, "vertex") == 0,
                  is_face = strcmp(a->name, "face") == 0;
        assert_true(is_vertex ? b->count >= a->count : b->count == a->count);
        for (size_t row = 0; row < a->count && !is_face; ++row) assert_same_row(a, row, b, row);
    }
    assert_same_faces(&old, &now);
    assert_int_equal(old.rest.size, now.rest.size);
    assert_memory_equal(old.rest.at, now.rest.at, old.rest.size);
    rows_free(&old);
    rows_free(&now);
}

/* The header: the old lines in their order, but for counts and types, and the three new ones. */
static void assert_same_header(document_bytes before, document_bytes after) {
    ply_rows old, now;
    assert_true(
        rows_parse(before.data, before.size, &old) && rows_parse(after.data, after.size, &now));
    const char *a = (const char *)before.data, *b = (const char *)after.data,
               *end_a = a + old.header_size, *end_b = b + now.header_size;
    const char eol = a[3] == '\r' && a[4] != '\n' ? '\r' : '\n';
    while (a < end_a) {
        const size_t length = (size_t)((const char *)memchr(a, eol, (size_t)(end_a - a)) - a) + 1;
        while (strncmp(b, "property float", 14) == 0 &&
               strncmp(strchr(b + 14, ' '), " n", 2) == 0 && strncmp(a, b, length) != 0)
            b = (const char *)memchr(b, eol, (size_t)(end_b - b)) + 1;
        const size_t new_length =
            (size_t)((const char *)memchr(b, eol, (size_t)(end_b - b)) - b) + 1;
        if (strncmp(a, "element vertex", 14) == 0)
            assert_int_equal(strncmp(b, "element vertex", 14), 0);
        else if (length != new_length || memcmp(a, b, length) != 0)
            fail_msg("header line %.*s became %.*s", (int)length, a, (int)new_length, b);
        a += length;
        b += new_length;
    }
    assert_true(b == end_b);
    rows_free(&old);
    rows_free(&now);
}

/* Unit, but for what an encoding can do. */
static void assert_unit_normals(document_bytes bytes, double tolerance) {
    ply_rows rows;
    assert_true(rows_parse(bytes.data, bytes.size, &rows));
    const rows_element *vertex = rows_find(&rows, "vertex");
    const int normal = rows_property_of(vertex, "nx");
    assert_true(normal >= 0);
    const char *type = vertex->properties[normal].type;
    const double scale = strcmp(type, "char") == 0 ? 127 : 1;
    tolerance = scale > 1 ? .00682 : tolerance;
    for (size_t row = 0; row < vertex->count; ++row) {
        const double x = rows_number(&rows, vertex, row, "nx") / scale,
                     y = rows_number(&rows, vertex, row, "ny") / scale,
                     z = rows_number(&rows, vertex, row, "nz") / scale;
        const double length = sqrt(x * x + y * y + z * z);
        if (!(fabs(length - 1) <= tolerance)) fail_msg("normal %zu has length %.9g", row, length);
    }
    rows_free(&rows);
}

static int readable;

static void rewrite_with(
    document_bytes bytes, const char *name, const norma_compute_options *options) {
    norma_compute_summary summary, again;
    document_bytes once = bytes_computed(bytes, name, options, &summary);
    assert_only_normals_changed(bytes, once);
    assert_same_header(bytes, once);
    if (summary.faces > 0)
        assert_unit_normals(once, options->only == NORMA_ONLY_BROKEN ? 5.1e-4 : 1e-6);
    assert_int_equal(summary.changed, !bytes_equal(bytes, once));
    document_bytes twice = bytes_computed(once, name, options, &again);
    if (!bytes_equal(once, twice)) fail_msg("%s: computing twice is not the same as once", name);
    assert_int_equal(again.changed, 0);
    bytes_free(&once);
    bytes_free(&twice);
}

static void rewrite(const char *path, const char *name, const char *expect) {
    if (strncmp(name, "bad/", 4) == 0) return;
    (void)expect;
    document_bytes bytes = bytes_load(path);
    norma_document *document = bytes_open(bytes, name);
    document_bytes same = bytes_of(document);
    norma_document_close(document);
    assert_true(bytes_equal(bytes, same));
    bytes_free(&same);
    const norma_compute_options smooth = {.struct_size = sizeof smooth};
    const norma_compute_options crease = {
        .struct_size = sizeof crease, .shading = NORMA_SHADING_CREASE, .crease_angle_rad = 0.7};
    const norma_compute_options flat = {.struct_size = sizeof flat, .shading = NORMA_SHADING_FLAT};
    const norma_compute_options broken = {.struct_size = sizeof broken, .only = NORMA_ONLY_BROKEN};
    rewrite_with(bytes, name, &smooth);
    rewrite_with(bytes, name, &crease);
    rewrite_with(bytes, name, &flat);
    rewrite_with(bytes, name, &broken);
    bytes_free(&bytes);
    ++readable;
}

static void test_every_file_is_rewritten(void **state) {
    (void)state;
    if (data_for_each_format("ply", rewrite) == 0) skip();
    print_message("%d PLY files rewritten four ways\n", readable);
    assert_true(readable >= 30);
}

static int rejected, refused_wrongly;

/* A message names the file, and a line or a byte in it. */
static void assert_names_place(const char *message, const char *name) {
    const char *at = strstr(message, name);
    if (!at) fail_msg("no file in: %s", message);
    at += strlen(name);
    if (!(strncmp(at, ":byte ", 6) == 0 || (at[0] == ':' && at[1] >= '0' && at[1] <= '9')))
        fail_msg("no place in: %s", message);
}

static void try_bad(const char *path, const char *name, const char *expect) {
    char message[1000];
    norma_mesh_info info = {0};
    if (strncmp(name, "bad/", 4) != 0) return;
    document_bytes bytes = bytes_load(path);
    const norma_document_result result = bytes_try(bytes, name, &info, message);
    if (result) assert_names_place(message, name);
    const int may_pass = strcmp(expect, "reject") != 0, is_empty = info.vertices == 0;
    if (!result && (!may_pass || (strcmp(expect, "reject-or-empty") == 0 && !is_empty))) {
        print_error("%s was read; expected: %s\n", name, expect);
        ++refused_wrongly;
    }
    rejected += result != NORMA_DOCUMENT_OK;
    bytes_free(&bytes);
}

static void test_bad_files(void **state) {
    (void)state;
    if (data_for_each_format("ply", try_bad) == 0) skip();
    print_message("%d bad PLY files rejected\n", rejected);
    assert_int_equal(refused_wrongly, 0);
    assert_true(rejected >= 20);
}

/* ---- files whose normals another program wrote */

static double worst_against_stored(const char *name, const norma_compute_options *options) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", data_folder(), name);
    document_bytes bytes = bytes_load(path), out = bytes_computed(bytes, name, options, NULL);
    ply_rows old, now;
    assert_true(rows_parse(bytes.data, bytes.size, &old) && rows_parse(out.data, out.size, &now));
    const rows_element *face = rows_find(&old, "face"), *new_face = rows_find(&now, "face"),
                       *vertex = rows_find(&old, "vertex"), *new_vertex = rows_find(&now, "vertex");
    const int list = rows_property_of(face, "vertex_indices");
    double worst = 0;
    for (size_t row = 0; row < face->count; ++row) {
        long long a[16], b[16];
        const size_t count = rows_list(&old, face, row, list, a);
        rows_list(&now, new_face, row, list, b);
        for (size_t i = 0; i < count; ++i) {
            const double stored[3] = {rows_number(&old, vertex, (size_t)a[i], "nx"),
                rows_number(&old, vertex, (size_t)a[i], "ny"),
                rows_number(&old, vertex, (size_t)a[i], "nz")};
            const float normal[3] = {(float)rows_number(&now, new_vertex, (size_t)b[i], "nx"),
                (float)rows_number(&now, new_vertex, (size_t)b[i], "ny"),
                (float)rows_number(&now, new_vertex, (size_t)b[i], "nz")};
            worst = fmax(worst, degrees_between(normal, stored));
        }
    }
    rows_free(&old);
    rows_free(&now);
    bytes_free(&bytes);
    bytes_free(&out);
    return worst;
}

static void test_facet_normals_of_other_programs(void **state) {
    (void)state;
    if (!data_folder()) skip();
    const norma_compute_options flat = {.struct_size = sizeof flat, .shading = NORMA_SHADING_FLAT};
    const norma_compute_options by_index = {
        .struct_size = sizeof by_index, .weld = NORMA_WELD_NONE};
    static const struct {
        const char *name;
        double tolerance;
    } files[] = {{"ply/fish-double.ply", .01}, {"ply/fish-double-be.ply", .01},
        {"ply/fish-double-ascii.ply", .01}, {"ply/wuson.ply", 1e-3},
        {"ply/cube-normals-uv.ply", 1e-4}};
    for (size_t i = 0; i < COUNT_OF(files); ++i) {
        const double a = worst_against_stored(files[i].name, &flat),
                     b = worst_against_stored(files[i].name, &by_index);
        print_message("%s: at most %.6f degrees off its stored normals flat, %.6f by index\n",
            files[i].name, a, b);
        if (a > files[i].tolerance || b > files[i].tolerance)
            fail_msg("%s: beyond %g degrees", files[i].name, files[i].tolerance);
    }
}

/* ---- one mesh in the three encodings */

static void append(document_bytes *bytes, const void *data, size_t size) {
    bytes->data = realloc(bytes->data, bytes->size + size + 1);
    memcpy(bytes->data + bytes->size, data, size);
    bytes->size += size;
}

/* Of a little-endian file of floats with lists of uchar and int. */
static document_bytes in_encoding(document_bytes bytes, const ply_rows *rows, int encoding) {
    char text[64];
    document_bytes out = bytes_copy("", 0);
    const char *from = strstr((const char *)bytes.data, "binary_little_endian"),
               *to = encoding == 'a' ? "ascii" : "binary_big_endian";
    append(&out, bytes.data, (size_t)(from - (const char *)bytes.data));
    append(&out, to, strlen(to));
    from += strlen("binary_little_endian");
    append(&out, from, rows->header_size - (size_t)(from - (const char *)bytes.data));
    for (size_t e = 0; e < rows->element_count; ++e) {
        const rows_element *element = &rows->elements[e];
        for (size_t i = 0; i < element->count * element->property_count; ++i) {
            const rows_value value = element->values[i];
            const size_t head = value.size % 4; /* a list's count */
            append(&out, value.at, encoding == 'b' ? head : 0);
            if (encoding == 'a' && head)
                append(&out, text, (size_t)sprintf(text, "%d ", value.at[0]));
            for (size_t at = head; at < value.size; at += 4) {
                const unsigned char swapped[4] = {
                    value.at[at + 3], value.at[at + 2], value.at[at + 1], value.at[at]};
                float number;
                int index;
                memcpy(&number, value.at + at, 4);
                memcpy(&index, value.at + at, 4);
                if (encoding == 'b')
                    append(&out, swapped, 4);
                else
                    append(&out, text,
                        (size_t)(head ? sprintf(text, "%d ", index)
                                      : sprintf(text, "%.9g ", (double)number)));
            }
            if (encoding == 'a' && (i + 1) % element->property_count == 0) append(&out, "\n", 1);
        }
    }
    out.data[out.size] = 0;
    return out;
}

static void test_encodings_agree(void **state) {
    (void)state;
    if (!data_folder()) skip();
    char path[1024];
    snprintf(path, sizeof path, "%s/ply/spot-le.ply", data_folder());
    document_bytes files[3], out[3];
    ply_rows rows[4];
    files[0] = bytes_load(path);
    assert_true(rows_parse(files[0].data, files[0].size, &rows[3]));
    files[1] = in_encoding(files[0], &rows[3], 'b');
    files[2] = in_encoding(files[0], &rows[3], 'a');
    const norma_compute_options crease = {
        .struct_size = sizeof crease, .shading = NORMA_SHADING_CREASE, .crease_angle_rad = 0.4};
    for (int i = 0; i < 3; ++i) {
        out[i] = bytes_computed(files[i], "spot.ply", &crease, NULL);
        assert_true(rows_parse(out[i].data, out[i].size, &rows[i]));
    }
    const size_t count = rows_find(&rows[0], "vertex")->count;
    assert_true(count > 2930);
    for (int i = 1; i < 3; ++i) {
        assert_int_equal(rows_find(&rows[i], "vertex")->count, count);
        for (size_t row = 0; row < count; ++row)
            for (int axis = 0; axis < 3; ++axis) {
                const char name[3] = {'n', (char)('x' + axis), 0};
                const double a = rows_number(&rows[0], rows_find(&rows[0], "vertex"), row, name),
                             b = rows_number(&rows[i], rows_find(&rows[i], "vertex"), row, name);
                assert_true(i == 1 ? a == b : fabs(a - b) <= 5.1e-9);
            }
    }
    for (int i = 0; i < 3; ++i) {
        rows_free(&rows[i]);
        bytes_free(&files[i]);
        bytes_free(&out[i]);
    }
    rows_free(&rows[3]);
}

/* ---- nothing that is cut off or damaged crashes it */

static void damage(const char *path, const char *name, const char *expect) {
    (void)expect;
    document_bytes bytes = bytes_load(path);
    if (bytes.size < 2500) {
        for (size_t size = 0; size < bytes.size; ++size) {
            document_bytes part = bytes_copy(bytes.data, size);
            bytes_try(part, name, NULL, NULL);
            bytes_free(&part);
        }
        for (size_t at = 0; at < bytes.size; ++at) {
            document_bytes changed = bytes_copy(bytes.data, bytes.size);
            changed.data[at] = (unsigned char)(changed.data[at] ^ (1u << at % 8));
            norma_document *document = NULL;
            const norma_compute_options crease = {.struct_size = sizeof crease,
                .shading = NORMA_SHADING_CREASE,
                .crease_angle_rad = 0.4};
            if (!norma_document_open_memory(
                    changed.data, changed.size, name, NULL, &document, NULL) &&
                !norma_document_compute(document, &crease, NULL, NULL)) {
                document_bytes out = bytes_of(document);
                bytes_free(&out);
            }
            norma_document_close(document);
            bytes_free(&changed);
        }
    }
    bytes_free(&bytes);
}

static void test_damage(void **state) {
    (void)state;
    if (data_for_each_format("ply", damage) == 0) skip();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_file_is_rewritten),
        cmocka_unit_test(test_bad_files),
        cmocka_unit_test(test_facet_normals_of_other_programs),
        cmocka_unit_test(test_encodings_agree),
        cmocka_unit_test(test_damage),
    };
    return cmocka_run_group_tests_name("ply data", tests, NULL, NULL);
}
