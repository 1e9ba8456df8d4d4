/* test_file_threads.c: files read, computed and written by 1 thread and up to 64: the same
 * arrays, the same bytes, the same messages. The meshes are made here and are large enough for
 * several stretches of text and slices of rows; what an OBJ must hold is known from its making,
 * read back by strtod and not by the library. */
#include "check.h"
#include "document_bytes.h"

enum { SIDE = 130, VERTICES = (SIDE + 1) * (SIDE + 1), FACES = 2 * SIDE * SIDE };
static const uint32_t thread_counts[] = {1, 3, 8, 2, 64};
enum { THREAD_COUNTS = SLOWER > 1 ? 3 : 5 };

/* ---- bytes that grow */

typedef struct text {
    char *data;
    size_t size, room;
} text;

static void add_bytes(text *t, const void *bytes, size_t size) {
    if (t->size + size > t->room) {
        t->room = 2 * (t->size + size);
        t->data = realloc(t->data, t->room);
        assert_non_null(t->data);
    }
    memcpy(t->data + t->size, bytes, size);
    t->size += size;
}

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static void
add(text *t, const char *format, ...) {
    char line[256];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    assert_true(length >= 0 && (size_t)length < sizeof line);
    add_bytes(t, line, (size_t)length);
}

static void add_u32(text *t, uint32_t value) {
    const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8),
        (unsigned char)(value >> 16), (unsigned char)(value >> 24)};
    add_bytes(t, bytes, 4);
}

static void add_float(text *t, double value) {
    const float narrow = (float)value;
    uint32_t bits;
    memcpy(&bits, &narrow, sizeof bits);
    add_u32(t, bits);
}

/* ---- the mesh: a sheet with steps, flat parts (many equal normals), a degenerate face here and
 * there */

static void position(size_t vertex, double out[3]) {
    const size_t row = vertex / (SIDE + 1), column = vertex % (SIDE + 1);
    out[0] = (double)column / 16;
    out[1] = (double)row / 16;
    out[2] = row < SIDE / 3  ? 0
             : row % 16 == 0 ? 0.5
                             : 0.125 * sin((double)(3 * row + column * column) / 40);
}

static void corners(size_t face, uint32_t out[3]) {
    const uint32_t quad = (uint32_t)face / 2, a = quad / SIDE * (SIDE + 1) + quad % SIDE, b = a + 1,
                   c = a + SIDE + 1, d = c + 1;
    out[0] = face % 2 ? b : a;
    out[1] = face % 2 ? d : b;
    out[2] = face % 5003 == 77 ? out[1] : c;
}

/* ---- OBJ in many styles */

enum {
    FULL = 1,
    RELATIVE = 2,
    GROUPS = 4,
    CARRIAGE = 8,
    JOINED = 16,
    POLYGONS = 32,
    LATE_NORMALS = 64
};

static const char *line_end(int style) { return style & CARRIAGE ? "\r\n" : "\n"; }

static void add_corner(text *t, int style, size_t face, uint32_t vertex) {
    const long long number =
        style & RELATIVE ? (long long)vertex - VERTICES : (long long)vertex + 1;
    if (style & JOINED && face % 3 == 0) add(t, " \\%s", line_end(style));
    if (style & FULL || (style & LATE_NORMALS && face > FACES / 2))
        add(t, " %lld/%lld/%lld", number, number, face % 911 == 5 ? VERTICES + 7LL : number);
    else
        add(t, " %lld", number);
}

static text make_obj(int style) {
    text t = {NULL, 0, 0};
    double p[3];
    uint32_t c[3];
    add(&t, "# a sheet \\%so sheet%s", line_end(style), line_end(style));
    for (size_t i = 0; i < VERTICES; ++i) {
        position(i, p);
        add(&t, "v %.6f %.9g %.17g%s", p[0], p[1], p[2], line_end(style));
        if (style & (FULL | LATE_NORMALS))
            add(&t, "vt %.4f %.4f%svn 0 %d 1%s", p[0], p[1], line_end(style), i % 2 ? 0 : 1,
                line_end(style));
    }
    for (size_t i = 0; i < FACES; ++i) {
        if (style & GROUPS && i % 1000 == 0)
            add(&t, "s %d%s", (int)(i / 1000 % 3), line_end(style));
        if (i % 4000 == 9)
            add(&t, "usemtl m%d%sl 1 2 3%s# f 1 2 3%s", (int)i, line_end(style), line_end(style),
                line_end(style));
        corners(i, c);
        add(&t, "f");
        for (int k = 0; k < 3; ++k) add_corner(&t, style, i, c[k]);
        if (style & POLYGONS && i % 10 == 3) add_corner(&t, style, i, c[0] + SIDE);
        add(&t, "%s", line_end(style));
    }
    return t;
}

/* ---- the others */

static text make_stl(void) {
    text t = {NULL, 0, 0};
    double p[3];
    uint32_t c[3];
    const char header[80] = "a sheet";
    add_bytes(&t, header, sizeof header);
    add_u32(&t, FACES);
    for (size_t i = 0; i < FACES; ++i) {
        corners(i, c);
        for (int k = 0; k < 3; ++k) add_float(&t, k == 2 && i % 9);
        for (int k = 0; k < 3; ++k) {
            position(c[k], p);
            for (int axis = 0; axis < 3; ++axis) add_float(&t, p[axis]);
        }
        add_bytes(&t, "\1\2", 2);
    }
    return t;
}

enum { WITH_NORMALS = 1, WITH_QUADS = 2, WITH_FLAGS = 4 };

static text make_ply(int style) {
    text t = {NULL, 0, 0};
    double p[3];
    uint32_t c[3];
    add(&t,
        "ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float "
        "y\nproperty float z\n",
        VERTICES);
    add(&t, "%s",
        style & WITH_NORMALS ? "property float nx\nproperty float ny\nproperty float nz\n" : "");
    add(&t,
        "property uchar red\nelement face %d\nproperty list uchar int "
        "vertex_indices\n%send_header\n",
        FACES, style & WITH_FLAGS ? "property uchar flags\n" : "");
    for (size_t i = 0; i < VERTICES; ++i) {
        position(i, p);
        for (int axis = 0; axis < 3; ++axis) add_float(&t, p[axis]);
        for (int axis = 0; axis < 3 && style & WITH_NORMALS; ++axis) add_float(&t, axis == 2);
        add_bytes(&t, "r", 1);
    }
    for (size_t i = 0; i < FACES; ++i) {
        const int quad = style & WITH_QUADS && i % 10 == 3;
        corners(i, c);
        add_bytes(&t, quad ? "\4" : "\3", 1);
        for (int k = 0; k < 3; ++k) add_u32(&t, c[k]);
        if (quad) add_u32(&t, c[0] + SIDE);
        if (style & WITH_FLAGS) add_bytes(&t, "f", 1);
    }
    return t;
}

static text make_glb(int normals) {
    text t = {NULL, 0, 0};
    const unsigned vectors = 12 * VERTICES, indices = 12 * FACES,
                   bin = vectors * (normals ? 2 : 1) + indices;
    double p[3];
    uint32_t c[3];
    char json[1500];
    int length = snprintf(json, sizeof json,
        "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],"
        "\"scene\":0,"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0%s},\"indices\":1}]}],"
        "\"buffers\":[{\"byteLength\":%u}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":%u},{\"buffer\":0,\"byteOffset\":%u,"
        "\"byteLength\":%u}%s],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\","
        "\"min\":[0,0,-1],\"max\":[9,9,1]},"
        "{\"bufferView\":1,\"componentType\":5125,\"count\":%d,\"type\":\"SCALAR\"}%s]}",
        normals ? ",\"NORMAL\":2" : "", bin, vectors, vectors, indices,
        normals ? ",{\"buffer\":0,\"byteOffset\":0,\"byteLength\":205932}" : "", VERTICES,
        3 * FACES,
        normals ? ",{\"bufferView\":2,\"componentType\":5126,\"count\":17161,\"type\":\"VEC3\"}"
                : "");
    assert_int_equal(vectors, 205932);
    while (length % 4) json[length++] = ' ';
    add_bytes(&t, "glTF\2\0\0\0", 8);
    add_u32(&t, 12 + 8 + (uint32_t)length + 8 + bin);
    add_u32(&t, (uint32_t)length);
    add_bytes(&t, "JSON", 4);
    add_bytes(&t, json, (size_t)length);
    add_u32(&t, bin);
    add_bytes(&t, "BIN\0", 4);
    for (size_t i = 0; i < VERTICES; ++i) {
        position(i, p);
        for (int axis = 0; axis < 3; ++axis) add_float(&t, p[axis]);
    }
    for (size_t i = 0; i < FACES; ++i) {
        corners(i, c);
        for (int k = 0; k < 3; ++k) add_u32(&t, c[k]);
    }
    for (size_t i = 0; i < VERTICES && normals; ++i)
        for (int axis = 0; axis < 3; ++axis) add_float(&t, axis == 2);
    return t;
}

/* ---- the same from any number of threads */

static norma_document *open_with(const text *t, const char *name, uint32_t threads) {
    const norma_document_options options = {.struct_size = sizeof options, .threads = threads};
    norma_document *document;
    norma_document_error error;
    if (norma_document_open_memory(t->data, t->size, name, &options, &document, &error))
        fail_msg("%s", error.message);
    return document;
}

static document_bytes computed_with(const text *t, const char *name, norma_compute_options options,
    uint32_t threads, norma_compute_summary *summary) {
    norma_document_error error;
    norma_document *document = open_with(t, name, threads);
    options.struct_size = sizeof options;
    options.threads = threads;
    if (norma_document_compute(document, &options, summary, &error)) fail_msg("%s", error.message);
    document_bytes bytes = bytes_of(document);
    norma_document_close(document);
    return bytes;
}

/* Every corner is still where it was made, whatever vertices were added: rows and numbers went to
 * their places. */
static void check_surface(document_bytes bytes, const char *name) {
    const text t = {(char *)bytes.data, bytes.size, 0};
    norma_mesh_data data;
    norma_document *document = open_with(&t, name, 1);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    const norma_vec3_view *view = &data.mesh.positions;
    const uint32_t *numbers = data.mesh.corners;
    const size_t size = view->format == NORMA_FORMAT_DOUBLE ? sizeof(double) : sizeof(float),
                 stride = view->stride ? view->stride : 3 * size;
    for (size_t i = 0; i < FACES; ++i) {
        uint32_t c[3];
        corners(i, c);
        for (size_t k = 0; k < 3; ++k) {
            const size_t corner = (data.mesh.face_starts ? data.mesh.face_starts[i] : 3 * i) + k;
            const unsigned char *at =
                (const unsigned char *)view->data + stride * (numbers ? numbers[corner] : corner);
            double p[3];
            position(c[k], p);
            for (size_t axis = 0; axis < 3; ++axis) {
                double wide;
                float narrow;
                memcpy(&narrow, at + axis * size, sizeof narrow);
                if (size == sizeof wide) memcpy(&wide, at + axis * size, sizeof wide);
                assert_true(
                    size == sizeof wide ? fabs(wide - p[axis]) <= 1e-6 : narrow == (float)p[axis]);
            }
        }
    }
    norma_document_close(document);
}

static void compare_threads(const text *t, const char *name, const norma_compute_options *options) {
    norma_compute_summary first, other;
    document_bytes expected = computed_with(t, name, *options, thread_counts[0], &first);
    assert_true(first.changed);
    check_surface(expected, name);
    for (int i = 1; i < THREAD_COUNTS; ++i) {
        document_bytes bytes = computed_with(t, name, *options, thread_counts[i], &other);
        if (!bytes_equal(bytes, expected))
            fail_msg("%s: %u threads write other bytes than one", name, (unsigned)thread_counts[i]);
        assert_int_equal(other.filled, first.filled);
        assert_int_equal(other.hard_edges, first.hard_edges);
        bytes_free(&bytes);
    }
    bytes_free(&expected);
}

static const norma_compute_options by_default = {.struct_size = sizeof by_default},
                                   smooth = {.struct_size = sizeof smooth,
                                       .shading = NORMA_SHADING_SMOOTH},
                                   flat = {.struct_size = sizeof flat,
                                       .shading = NORMA_SHADING_FLAT},
                                   broken = {.struct_size = sizeof broken,
                                       .only = NORMA_ONLY_BROKEN},
                                   creased = {.struct_size = sizeof creased,
                                       .shading = NORMA_SHADING_CREASE,
                                       .crease_angle_rad = 0.35};

static void obj_bytes(void **state) {
    static const int styles[] = {0, FULL, RELATIVE, FULL | RELATIVE | CARRIAGE, GROUPS | POLYGONS,
        JOINED | CARRIAGE | LATE_NORMALS, JOINED | POLYGONS | FULL};
    (void)state;
    for (size_t i = 0; i < sizeof styles / sizeof styles[0]; ++i) {
        text t = make_obj(styles[i]);
        compare_threads(&t, "sheet.obj", &by_default);
        compare_threads(&t, "sheet.obj", i % 2 ? &smooth : &flat);
        compare_threads(&t, "sheet.obj", &broken);
        free(t.data);
    }
}

static void ply_bytes(void **state) {
    static const int styles[] = {0, WITH_NORMALS, WITH_QUADS, WITH_FLAGS | WITH_NORMALS};
    (void)state;
    for (size_t i = 0; i < sizeof styles / sizeof styles[0]; ++i) {
        text t = make_ply(styles[i]);
        compare_threads(&t, "sheet.ply", &by_default);
        compare_threads(&t, "sheet.ply", &creased);
        free(t.data);
    }
}

static void stl_bytes(void **state) {
    (void)state;
    text t = make_stl();
    compare_threads(&t, "sheet.stl", &by_default);
    compare_threads(&t, "sheet.stl", &broken); /* the degenerate faces keep what they have */
    free(t.data);
}

static void glb_bytes(void **state) {
    (void)state;
    for (int normals = 0; normals < 2; ++normals) {
        text t = make_glb(normals);
        compare_threads(&t, "sheet.glb", &by_default);
        compare_threads(&t, "sheet.glb", &smooth);
        compare_threads(&t, "sheet.glb", &flat);
        free(t.data);
    }
}

/* ---- what an OBJ holds */

static void check_obj(const text *t, int style, uint32_t threads) {
    norma_mesh_data data;
    norma_document *document = open_with(t, "sheet.obj", threads);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(data.mesh.positions.count, VERTICES);
    assert_int_equal(data.mesh.positions.format, NORMA_FORMAT_DOUBLE);
    const double *positions = data.mesh.positions.data;
    const uint32_t *found = data.mesh.corners;
    size_t corner = 0;
    for (size_t i = 0; i < VERTICES; ++i) {
        static const char *const formats[] = {"%.6f", "%.9g", "%.17g"};
        double p[3];
        position(i, p);
        for (int axis = 0; axis < 3; ++axis) {
            char word[64];
            snprintf(word, sizeof word, formats[axis], p[axis]);
            assert_true(positions[3 * i + (size_t)axis] == strtod(word, NULL));
        }
    }
    for (size_t i = 0; i < FACES; ++i) {
        uint32_t c[3];
        corners(i, c);
        assert_int_equal(data.mesh.face_starts ? data.mesh.face_starts[i] : 3 * i, corner);
        for (int k = 0; k < 3; ++k) assert_int_equal(found[corner + (size_t)k], c[k]);
        corner += 3;
        if (style & POLYGONS && i % 10 == 3) assert_int_equal(found[corner++], c[0] + SIDE);
    }
    assert_int_equal(data.mesh.corner_count, corner);
    norma_document_close(document);
}

static void obj_arrays(void **state) {
    static const int styles[] = {
        0, RELATIVE | CARRIAGE, FULL | JOINED, POLYGONS | GROUPS | RELATIVE};
    (void)state;
    for (size_t i = 0; i < sizeof styles / sizeof styles[0]; ++i) {
        text t = make_obj(styles[i]);
        check_obj(&t, styles[i], 1);
        check_obj(&t, styles[i], 8);
        free(t.data);
    }
}

/* ---- messages */

static void check_message(const text *t, const char *expected) {
    for (int i = 0; i < THREAD_COUNTS; ++i) {
        const norma_document_options options = {
            .struct_size = sizeof options, .threads = thread_counts[i]};
        norma_document *document;
        norma_document_error error;
        assert_int_equal(
            norma_document_open_memory(t->data, t->size, "sheet.obj", &options, &document, &error),
            NORMA_DOCUMENT_ERROR_MALFORMED);
        assert_null(document);
        assert_string_equal(error.message, expected);
    }
}

static size_t count_lines(const text *t) {
    size_t lines = 0;
    for (size_t i = 0; i < t->size; ++i) lines += t->data[i] == '\n';
    return lines;
}

static void obj_messages(void **state) {
    static const struct {
        const char *line, *message;
    } faults[] = {
        {"v 1 2,5 3\nv 1 x 2", "\"2,5\" where one of a position's three numbers was expected"},
        {"f 1 2 x3\nf 1 y", "\"x3\" where a corner (v, v/vt, v//vn or v/vt/vn) was expected"},
        {"f 1 -99999 3", "\"-99999\" where a position that stands before this face was expected"},
        {"f 1 2", "a face of 2 corners, where at least three were expected"},
        {"f 1 0 3", "\"0\" where a position, numbered from 1, was expected"},
        {"f 1 2 17162", "position 17162 of a face, where the file holds 17161 positions"},
    };
    (void)state;
    assert_int_equal(VERTICES, 17161);
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; ++i) {
        char expected[200];
        text t = make_obj(i % 2 ? JOINED : 0), whole = make_obj(0);
        snprintf(
            expected, sizeof expected, "sheet.obj:%zu: %s", count_lines(&t) + 1, faults[i].message);
        add(&t, "%s\n", faults[i].line);
        add_bytes(&t, strchr(whole.data, '\n') + 1,
            whole.size - (size_t)(strchr(whole.data, '\n') + 1 - whole.data));
        if (i < 5)
            check_message(&t, expected); /* though as much follows, with faults of its own or not */
        else {
            t.size = strlen(faults[i].line) + 1 + (size_t)(strstr(t.data, faults[i].line) - t.data);
            check_message(&t, expected);
        }
        free(whole.data);
        free(t.data);
    }
}

/* ---- cancelling */

static int cancel_at(void *user, double fraction) {
    int *left = user;
    assert_true(fraction >= 0 && fraction <= 1);
    return (*left)-- <= 0;
}

static void cancelled_anywhere(void **state) {
    (void)state;
    text t = make_obj(0);
    for (int calls = 0; calls < 6; ++calls)
        for (int i = 0; i < THREAD_COUNTS; ++i) {
            int left = calls;
            const norma_document_options options = {.struct_size = sizeof options,
                .threads = thread_counts[i],
                .progress = cancel_at,
                .progress_user = &left};
            norma_document *document;
            norma_document_result result =
                norma_document_open_memory(t.data, t.size, "sheet.obj", &options, &document, NULL);
            assert_true(
                result == NORMA_DOCUMENT_CANCELLED || (result == NORMA_DOCUMENT_OK && calls > 0));
            norma_compute_options computing = {.struct_size = sizeof computing,
                .threads = thread_counts[i],
                .progress = cancel_at,
                .progress_user = &left};
            left = calls;
            if (!result)
                assert_int_equal(norma_document_compute(document, &computing, NULL, NULL),
                    NORMA_DOCUMENT_CANCELLED);
            norma_document_close(document);
        }
    free(t.data);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(obj_arrays),
        cmocka_unit_test(obj_bytes),
        cmocka_unit_test(ply_bytes),
        cmocka_unit_test(stl_bytes),
        cmocka_unit_test(glb_bytes),
        cmocka_unit_test(obj_messages),
        cmocka_unit_test(cancelled_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
