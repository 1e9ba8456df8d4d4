/* test_obj.c: OBJ documents. What must not change is compared by a stripper of its own: the text
 * without vn lines and without the normals of faces. */
#include <norma/document.h>
#include "check.h"
#include "mesh_files.h"

/* ---- helpers */

typedef struct text {
    char *bytes;
    size_t size, room;
} text;

static void append(text *t, const void *bytes, size_t size) {
    if (t->size + size + 1 > t->room) {
        t->room = 2 * (t->size + size) + 64;
        t->bytes = realloc(t->bytes, t->room);
        assert_non_null(t->bytes);
    }
    memcpy(t->bytes + t->size, bytes, size);
    t->size += size;
    t->bytes[t->size] = 0;
}

static int take(void *user, const void *bytes, size_t size) {
    append(user, bytes, size);
    return 0;
}

static text read_file(const char *path) {
    text t = {0};
    char block[65536];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    append(&t, "", 0);
    for (size_t size; (size = fread(block, 1, sizeof block, file)) > 0;) append(&t, block, size);
    fclose(file);
    return t;
}

static norma_document *open_text(const char *bytes, size_t size) {
    norma_document *document;
    norma_document_error error = {0};
    const norma_document_options options = {
        .struct_size = sizeof options, .format = NORMA_FILE_OBJ};
    if (norma_document_open_memory(bytes, size, "test.obj", &options, &document, &error))
        fail_msg("%s", error.message);
    return document;
}

static text written(norma_document *document) {
    text t = {0};
    norma_document_error error = {0};
    append(&t, "", 0);
    if (norma_document_write(document, take, &t, &error)) fail_msg("%s", error.message);
    return t;
}

/* The text after computing, which is the caller's to free. */
static text compute(const char *source, size_t size, const norma_compute_options *options,
    norma_compute_summary *summary) {
    norma_document_error error = {0};
    norma_document *document = open_text(source, size);
    if (norma_document_compute(document, options, summary, &error)) fail_msg("%s", error.message);
    text t = written(document);
    norma_document_close(document);
    return t;
}

static void expect_compute(
    const char *source, const norma_compute_options *options, const char *expected) {
    norma_compute_summary summary;
    text t = compute(source, strlen(source), options, &summary);
    assert_string_equal(t.bytes, expected);
    assert_int_equal(summary.changed, strcmp(source, expected) != 0);
    free(t.bytes);
}

static text transform(
    const char *source, size_t size, const double matrix[16], norma_transform_summary *summary) {
    norma_transform_options options = {.struct_size = sizeof options};
    norma_document_error error = {0};
    norma_document *document = open_text(source, size);
    memcpy(options.matrix, matrix, sizeof options.matrix);
    if (norma_document_transform(document, &options, summary, &error))
        fail_msg("%s", error.message);
    text t = written(document);
    norma_document_close(document);
    return t;
}

static void expect_transform(const char *source, const double matrix[16], const char *expected) {
    norma_transform_summary summary;
    text t = transform(source, strlen(source), matrix, &summary);
    assert_string_equal(t.bytes, expected);
    free(t.bytes);
}

static void expect_error(
    const char *source, size_t size, norma_document_result result, const char *message) {
    norma_document *document;
    norma_document_error error = {0};
    const norma_document_options options = {
        .struct_size = sizeof options, .format = NORMA_FILE_OBJ};
    assert_int_equal(
        norma_document_open_memory(source, size, "test.obj", &options, &document, &error), result);
    assert_null(document);
    assert_string_equal(error.message, message);
}

static const double scale_2_half_1[16] = {2, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
static const double mirror_x[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
static const double move_1_2_3[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1};
static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static int is_end(char c) { return c == '\n' || c == '\r'; }
static int is_blank(char c) { return c == ' ' || c == '\t'; }

/* A logical line from p: where it ends, its line end included. */
static const char *line_after(const char *p, const char *end) {
    int comment = 0, backslash = 0, token = 0;
    for (; p < end; ++p) {
        if (is_end(*p)) {
            const char *after = *p == '\r' && p + 1 < end && p[1] == '\n' ? p + 2 : p + 1;
            if (!backslash || comment) return after;
            p = after - 1;
            backslash = token = 0;
            continue;
        }
        comment |= *p == '#' && !token;
        backslash = *p == '\\' || (backslash && is_blank(*p));
        token = !is_blank(*p) && *p != '\\';
    }
    return p;
}

/* Appends the face's text without what follows the second slash of each token, and without slashes
 * that then end it. */
static void strip_face(text *out, const char *p, const char *end) {
    int slashes = 0, comment = 0;
    for (; p < end; ++p) {
        comment |= *p == '#';
        if (is_blank(*p) || is_end(*p) || *p == '\\') slashes = 0;
        if (comment || slashes < 2) append(out, p, 1);
        if (!comment && *p == '/' && ++slashes) {
            int texture = p + 1 < end && p[1] >= '-' && p[1] <= '9' && p[1] != '/';
            if (slashes == 2 || !texture) --out->size;
        }
    }
}

static text stripped(const char *bytes, size_t size) {
    text out = {0};
    const char *end = bytes + size;
    append(&out, "", 0);
    for (const char *p = bytes; p < end;) {
        const char *after = line_after(p, end);
        const char *word = p;
        while (word < after && is_blank(*word)) ++word;
        if (after - word > 2 && word[0] == 'v' && word[1] == 'n' && is_blank(word[2])) {
            p = after;
            continue;
        }
        if (after - word > 1 && word[0] == 'f' && is_blank(word[1]))
            strip_face(&out, p, after);
        else
            append(&out, p, (size_t)(after - p));
        p = after;
    }
    return out;
}

static void assert_same_but_normals(const char *name, const text *a, const text *b) {
    text x = stripped(a->bytes, a->size), y = stripped(b->bytes, b->size);
    size_t i = 0;
    while (i < x.size && i < y.size && x.bytes[i] == y.bytes[i]) ++i;
    if (x.size != y.size || i < x.size)
        fail_msg("%s: differs at byte %zu of the stripped text: \"%.40s\" became \"%.40s\"", name,
            i, x.bytes + i, y.bytes + i);
    free(x.bytes);
    free(y.bytes);
}

/* ---- small texts */

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

static void a_face_gets_its_normal(void **state) {
    (void)state;
    expect_compute(SQUARE "f 1 2 3 4\n", NULL, SQUARE "vn 0 0 1\nf 1//1 2//1 3//1 4//1\n");
    expect_compute(SQUARE "f 1 4 3\nf 1 3 2\n", NULL,
        SQUARE "vn 0 0 -1\nf 1//1 4//1 3//1\nf 1//1 3//1 2//1\n");
}

static void every_mix_of_indices(void **state) {
    (void)state;
    expect_compute(SQUARE "vt 0 0\nvn 1 0 0\nf 1 2/1 3//1 4/1/1\n", NULL,
        SQUARE "vt 0 0\nvn 0 0 1\nf 1//1 2/1/1 3//1 4/1/1\n");
    expect_compute(SQUARE "vt 0 0\nvn 1 0 0\nf -4 -3/-1 -2//-1 -1/-1/-1\n", NULL,
        SQUARE "vt 0 0\nvn 0 0 1\nf -4//1 -3/-1/1 -2//1 -1/-1/1\n");
    expect_compute(SQUARE "f 1/ 2// 3/1/ +4\n", NULL, SQUARE "vn 0 0 1\nf 1//1 2//1 3/1/1 +4//1\n");
}

static void old_normals_go(void **state) {
    (void)state;
    expect_compute("# a\nvn 1 0 0 # gone\n" SQUARE "vn 0 1 0\n  vn 0 0 5\n# b\nf 1//1 2//2 3//3\n",
        NULL, "# a\nvn 0 0 1\n" SQUARE "# b\nf 1//1 2//1 3//1\n");
    expect_compute(
        SQUARE "f 1//1 2//1 3//1\nvn 1 0 0", NULL, SQUARE "vn 0 0 1\nf 1//1 2//1 3//1\n");
}

static void line_endings_stay(void **state) {
    (void)state;
    expect_compute("v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nf 1 2 3\r\n", NULL,
        "v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nvn 0 0 1\r\nf 1//1 2//1 3//1\r\n");
    expect_compute("v 0 0 0\rv 1 0 0\rv 1 1 0\rf 1 2 3\r", NULL,
        "v 0 0 0\rv 1 0 0\rv 1 1 0\rvn 0 0 1\rf 1//1 2//1 3//1\r");
    expect_compute("v 0 0 0\rv 1 0 0\r\nv 1 1 0\n\r\n\rf 1 2 3", NULL,
        "v 0 0 0\rv 1 0 0\r\nv 1 1 0\n\r\n\rvn 0 0 1\rf 1//1 2//1 3//1");
    expect_compute("v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nf 1 2 3\n", NULL,
        "v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nvn 0 0 1\nf 1//1 2//1 3//1\n");
    expect_compute("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3", NULL,
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nf 1//1 2//1 3//1");
    expect_compute("\xef\xbb\xbfvn 1 0 0\r\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", NULL,
        "\xef\xbb\xbfvn 0 0 1\r\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1//1 2//1 3//1\n");
}

static void lines_are_joined(void **state) {
    (void)state;
    expect_compute("v 0 \\\n 0 0\nv 1 0\\\r\n0\nv 1 1 0\nf 1 \\\n2\\\n3\n", NULL,
        "v 0 \\\n 0 0\nv 1 0\\\r\n0\nv 1 1 0\nvn 0 0 1\nf 1//1 \\\n2//1\\\n3//1\n");
    expect_compute(SQUARE "f\\\n 1 2 3 \\ \n # four: \\\nf 1 3 4\\", NULL,
        SQUARE "vn 0 0 1\nf\\\n 1//1 2//1 3//1 \\ \n # four: \\\nf 1//1 3//1 4//1\\");
    /* A name goes on in the next line, a comment does not. */
    expect_compute("# C:\\models\\\n" SQUARE "g a \\\nf 1 2 3\nf 1 2 3\n", NULL,
        "# C:\\models\\\n" SQUARE "g a \\\nf 1 2 3\nvn 0 0 1\nf 1//1 2//1 3//1\n");
    expect_compute(
        "vn 1 \\\n0 0\n" SQUARE "f 1 2 3\n", NULL, "vn 0 0 1\n" SQUARE "f 1//1 2//1 3//1\n");
}

static void blanks_and_comments_stay(void **state) {
    (void)state;
    expect_compute(SQUARE "\t f\t1  2\t 3   # f 1 2 3\n", NULL,
        SQUARE "vn 0 0 1\n\t f\t1//1  2//1\t 3//1   # f 1 2 3\n");
    expect_compute(SQUARE "g face\ng f 1 2 3\nusemtl #f\nfo 1 2 3#x\n", NULL,
        SQUARE "g face\ng f 1 2 3\nusemtl #f\nvn 0 0 1\nfo 1//1 2//1 3//1#x\n");
}

static void other_statements_pass(void **state) {
    static const char before[] =
        "mtllib a b.mtl\no thing\ng a b\nusemtl m\nv 0 0 0 1\nv 1 0 0 0.5\nv 1 1 0 0.1 0.2 0.3\nv "
        "0 1 0 nan nan nan 7\nvt 0\nvp 1 2 3\np 1 -1\nl 1/1 2 3\n"
        "cstype rat bspline\ndeg 3 3\ncurv 0 1 1 2 3 4\nparm u 0 1\nend\ncurv2 1 2\nlod "
        "5\nshadow_obj x.obj\ncall f.obj 1\nxyzzy f 1\n";
    char source[1000], expected[1000];
    (void)state;
    snprintf(source, sizeof source, "%sf 1 2 3 4", before);
    snprintf(expected, sizeof expected, "%svn 0 0 1\nf 1//1 2//1 3//1 4//1", before);
    expect_compute(source, NULL, expected);
    norma_document *document = open_text(source, strlen(source));
    assert_int_equal(norma_document_note_count(document), 1);
    assert_string_equal(norma_document_note(document, 0),
        "1 statements of kinds that OBJ does not have are kept "
        "as they are, the first \"xyzzy\" in line 22");
    norma_document_close(document);
}

static void normals_of_surfaces_stay(void **state) {
    (void)state;
    /* Named by -1 and by 3: they come first, in order, and are named anew. */
    expect_compute(SQUARE "vn 1 0 0\nvn 0.6 0.8 0\nsurf 0 1 0 1 1//-1 2//3 3/1\nvn 0 -1 0 # "
                          "keep\nf 1//1 2//2 3//3\nl 1//2 2\n",
        NULL,
        SQUARE "vn 0.6 0.8 0\nvn 0 -1 0 # keep\nvn 0 0 1\nsurf 0 1 0 1 1//1 2//2 3/1\nf 1//3 2//3 "
               "3//3\nl 1//1 2\n");
    /* A kept line that ended the file without a line end. */
    expect_compute(SQUARE "f 1 2 3\nsurf 0 1 0 1 1//1 2//7\nvn 0 1 0", NULL,
        SQUARE "vn 0 1 0\nvn 0 0 1\nf 1//2 2//2 3//2\nsurf 0 1 0 1 1//1 2//7\n");
}

static void nothing_to_do(void **state) {
    const norma_compute_options missing = {
        .struct_size = sizeof missing, .only = NORMA_ONLY_MISSING};
    const norma_compute_options broken = {.struct_size = sizeof broken, .only = NORMA_ONLY_BROKEN};
    (void)state;
    expect_compute(
        "v 0 0 0\nvn 1 0 0\nvn 5 0 0\np 1\n", NULL, "v 0 0 0\nvn 1 0 0\nvn 5 0 0\np 1\n");
    expect_compute("# nothing", NULL, "# nothing");
    /* normals that are right already keep their spelling, one that is not costs all lines theirs */
    expect_compute(SQUARE "vn -0.0 0 1.000000\nvn 3 0 0\nvn 0 -0 1e0\nf -1//-1 2//1 3//1\n", NULL,
        SQUARE "vn -0.0 0 1.000000\nvn 3 0 0\nvn 0 -0 1e0\nf -1//-1 2//1 3//1\n");
    expect_compute(SQUARE "vn -0.0 0 1.000000\nvn 3 0 0\nf 1//1 2//1 3//2\n", NULL,
        SQUARE "vn 0 0 1\nf 1//1 2//1 3//1\n");
    expect_compute(
        SQUARE "vn 1 0 0\nf -1//-1 2//1 3//1\n", &missing, SQUARE "vn 1 0 0\nf -1//-1 2//1 3//1\n");
    expect_compute(
        SQUARE "vn 1 0 0\nf -1//-1 2//1 3//1\n", &broken, SQUARE "vn 1 0 0\nf -1//-1 2//1 3//1\n");
}

static void only_what_is_missing(void **state) {
    const norma_compute_options options = {
        .struct_size = sizeof options, .only = NORMA_ONLY_MISSING};
    (void)state;
    expect_compute(SQUARE "vn 1 0 0\nvn 7 7 7\nf 1//1 2//1 3\nf 1 3 4\n", &options,
        SQUARE "vn 1 0 0\nvn 7 7 7\nvn 0 0 1\nf 1//1 2//1 3\nf 1//3 3//3 4//3\n");
    /* What names a normal that is not there has none. */
    expect_compute(SQUARE "vn 1 0 0\nf 1//1 2//1 3//1\nf 1//2 3//0 4//-5\n", &options,
        SQUARE "vn 1 0 0\nvn 0 0 1\nf 1//1 2//1 3//1\nf 1//2 3//2 4//2\n");
    expect_compute(SQUARE "vn 1 0 0\nf 1//1 2//-9 3\n", &options,
        SQUARE "vn 1 0 0\nvn 0 0 1\nf 1//1 2//2 3\n");
    /* New lines stand where the first stood, but never behind a face that needs them. */
    expect_compute(SQUARE "f 1 3 4\nvn 1 0 0\nf 1//-1 2//1 3//1\n", &options,
        SQUARE "vn 1 0 0\nvn 0 0 1\nf 1//2 3//2 4//2\nf 1//1 2//1 3//1\n");
}

static void only_what_is_broken(void **state) {
    const norma_compute_options options = {
        .struct_size = sizeof options, .only = NORMA_ONLY_BROKEN};
    (void)state;
    expect_compute(SQUARE "vn 0 0 0\nvn 1 0 0\nvn nan 0 1\nvn 0 0 1.0006\nf 1//1 2//2 3//3 4//4\n",
        &options, SQUARE "vn 1 0 0\nvn 0 0 1\nf 1//2 2//1 3//2 4//2\n");
    expect_compute(SQUARE
        "vn 1 0 0.01\nvn 0 1.0004 0\nvn 0 1e39 0\nvn 9 9 9\nf 1//1 2//2 3//3\nf 1 3 4//2\n",
        &options,
        SQUARE
        "vn 1 0 0.01\nvn 0 1.0004 0\nvn 9 9 9\nvn 0 0 1\nf 1//1 2//2 3//4\nf 1//4 3//4 4//2\n");
    expect_compute(SQUARE "vn 0 0 1\nf 1//1 2//1 3//1 4//0\n", &options,
        SQUARE "vn 0 0 1\nvn 0 0 1\nf 1//1 2//1 3//1 4//2\n");
}

static void what_has_no_normal(void **state) {
    norma_compute_summary summary;
    static const char source[] = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n";
    (void)state;
    expect_compute(source, NULL, "v 0 0 0\nv 1 0 0\nv 2 0 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
    text t = compute(source, strlen(source), NULL, &summary);
    assert_int_equal(summary.filled, 3);
    assert_int_equal(summary.report.degenerate_faces.count, 1);
    free(t.bytes);
    /* One normal per position: counted once, however many corners have it. */
    const norma_compute_options smooth = {
        .struct_size = sizeof smooth, .shading = NORMA_SHADING_SMOOTH};
    t = compute("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 9 9 9\nf 1 2 3\nf 3 2 1\n",
        strlen("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 9 9 9\nf 1 2 3\nf 3 2 1\n"), &smooth, &summary);
    assert_int_equal(summary.filled, 3);
    free(t.bytes);
    /* The nearest one that there is: here of the face to the left. */
    expect_compute("v 0 0 0\nv 0 1 0\nv 0 0 1\nv nan 0 0\nf 1 2 3\nf 1 2 4\n", NULL,
        "v 0 0 0\nv 0 1 0\nv 0 0 1\nv nan 0 0\nvn 1 0 0\nf 1//1 2//1 3//1\nf 1//1 2//1 4//1\n");
}

/* Two squares at a right angle, along 2 3. */
#define ANGLE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 1\nv 1 1 1\n"

static void expect_angle(
    const char *first, const char *second, const norma_compute_options *options, int smooth) {
    char source[500], expected[500];
    snprintf(source, sizeof source, "%s%sf 1 2 3 4\n%sf 2 5 6 3\n", ANGLE, first, second);
    snprintf(expected, sizeof expected,
        "%s%s%sf 1//1 2//%d 3//%d 4//1\n%sf 2//2 5//%d 6//%d 3//2\n", ANGLE, first,
        smooth ? "vn 0 0 1\nvn -0.70710677 0 0.70710677\nvn -1 0 0\n" : "vn 0 0 1\nvn -1 0 0\n",
        smooth ? 2 : 1, smooth ? 2 : 1, second, smooth ? 3 : 2, smooth ? 3 : 2);
    norma_compute_summary summary;
    text t = compute(source, strlen(source), options, &summary);
    assert_string_equal(t.bytes, expected);
    assert_int_equal(summary.hard_edges, smooth ? 0 : 1);
    free(t.bytes);
}

static void groups_decide(void **state) {
    const norma_compute_options ignore = {
        .struct_size = sizeof ignore, .groups = NORMA_GROUPS_IGNORE};
    const norma_compute_options crease80 = {.struct_size = sizeof crease80,
        .shading = NORMA_SHADING_CREASE,
        .crease_angle_rad = 80 / DEGREES};
    const norma_compute_options crease100 = {.struct_size = sizeof crease100,
        .shading = NORMA_SHADING_CREASE,
        .crease_angle_rad = 100 / DEGREES};
    (void)state;
    expect_angle("", "", NULL, 0);
    expect_angle("s 1\n", "", NULL, 1);
    expect_angle("s 1\n", "s 2\n", NULL, 0);
    expect_angle("s 1\n", "s 33\n", NULL, 0); /* the same bit of 32 */
    expect_angle("s 123456789012345\n", "s 123456789012345\n", NULL, 1);
    expect_angle("s 99999999999999999999999\n", "s 99999999999999999999998\n", NULL, 0);
    expect_angle("s 99999999999999999999999\n", "s 99999999999999999999999\n", NULL, 1);
    expect_angle("s 1\n", "s off\n", NULL, 0);
    expect_angle("s off\n", "s 0\n", NULL, 0);
    expect_angle("s 1\n", "s\n", NULL, 0);
    expect_angle("s 1\n", "s 2\ns 1 # back\n", NULL, 1);
    expect_angle("s 1\n", "", &ignore, 0);
    expect_angle("s 1\n", "", &crease80, 0);
    expect_angle("s 1\n", "", &crease100, 1);
    expect_angle("s 1\n", "s 2\n", &crease100, 0);
}

static void a_group_without_faces_is_none(void **state) {
    norma_compute_summary summary;
    static const char source[] = "s 4\ns off\n" SQUARE "f 1 2 3 4\ns 5\n";
    (void)state;
    text t = compute(source, strlen(source), NULL, &summary);
    assert_int_equal(summary.by_groups, 0);
    assert_true(fabs(summary.crease_angle_rad - 60 / DEGREES) < 1e-12);
    free(t.bytes);
}

/* A bent strip of many quads, quad k in group number[k]: the normals across the line between two
 * quads are equal exactly where the groups are, and not 0. */
static void check_strip(const int64_t *numbers, int count) {
    text t = {0};
    char line[200];
    norma_compute_summary summary;
    int hard = 0;
    for (int i = 0; i <= count; ++i) {
        double angle = 0.02 * i;
        append(&t, line,
            (size_t)snprintf(line, sizeof line, "v %.9f %.9f 0\nv %.9f %.9f 1\n", cos(angle),
                sin(angle), cos(angle), sin(angle)));
    }
    for (int i = 0; i < count; ++i)
        append(&t, line,
            (size_t)snprintf(line, sizeof line, "s %lld\nf %d %d %d %d\n", (long long)numbers[i],
                2 * i + 1, 2 * i + 3, 2 * i + 4, 2 * i + 2));
    text out = compute(t.bytes, t.size, NULL, &summary);
    norma_document *document = open_text(out.bytes, out.size);
    norma_mesh_data data;
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    for (int i = 0; i + 1 < count; ++i) {
        int smooth = numbers[i] == numbers[i + 1] && numbers[i] != 0;
        hard += !smooth;
        assert_int_equal(data.corner_normals[4 * i + 1] == data.corner_normals[4 * i + 4], smooth);
        assert_int_equal(data.corner_normals[4 * i + 2] == data.corner_normals[4 * i + 7], smooth);
    }
    assert_int_equal(summary.hard_edges, hard);
    norma_document_close(document);
    free(t.bytes);
    free(out.bytes);
}

static void many_groups(void **state) {
    enum { COUNT = 300 }; /* quads, less than once round */
    int64_t numbers[COUNT];
    uint32_t random = 12345;
    (void)state;
    for (int distinct = 2; distinct <= COUNT; distinct += 31) {
        for (int i = 0; i < COUNT; ++i) {
            random = random * 1664525 + 1013904223;
            numbers[i] = i % 2 ? numbers[i - 1] : (int64_t)(random >> 8) % distinct * 1000003;
        }
        check_strip(numbers, COUNT);
    }
    for (int i = 0; i < COUNT;
         ++i) /* neighbours whose numbers are the same in the last five bits */
        numbers[i] = 1 + i / 3 % 2 * 32 + i / 6;
    check_strip(numbers, COUNT);
}

/* Forty pairs of flaps round one edge, each pair a group: even where non-manifold edges are smooth,
 * no group shares with another. */
static void more_groups_at_an_edge_than_bits(void **state) {
    const norma_compute_options options = {
        .struct_size = sizeof options, .non_manifold = NORMA_NON_MANIFOLD_SMOOTH};
    text t = {0};
    char line[200];
    norma_compute_summary summary;
    (void)state;
    append(&t, line, (size_t)snprintf(line, sizeof line, "v 0 0 0\nv 0 0 1\n"));
    for (int i = 0; i < 80; ++i)
        append(&t, line,
            (size_t)snprintf(line, sizeof line, "v %.9f %.9f 0\n", cos(0.07 * i), sin(0.07 * i)));
    for (int i = 0; i < 80; ++i)
        append(&t, line,
            (size_t)snprintf(line, sizeof line, i % 2 ? "f 1 2 %d\n" : "s %d\nf 2 1 %d\n",
                i % 2 ? i + 3 : i / 2 + 1, i + 3));
    text out = compute(t.bytes, t.size, &options, &summary);
    assert_true(summary.by_groups);
    norma_document *document = open_text(out.bytes, out.size);
    norma_mesh_data data;
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    for (int i = 0; i < 80; ++i)
        for (int k = 0; k < i / 2 * 2; ++k)
            assert_int_not_equal(data.corner_normals[3 * i], data.corner_normals[3 * k]);
    norma_document_close(document);
    free(out.bytes);
    free(t.bytes);
}

static void smooth_and_flat(void **state) {
    const norma_compute_options smooth = {
        .struct_size = sizeof smooth, .shading = NORMA_SHADING_SMOOTH, .weight = NORMA_WEIGHT_AREA};
    const norma_compute_options flat = {.struct_size = sizeof flat, .shading = NORMA_SHADING_FLAT};
    (void)state;
    expect_compute(ANGLE "s 1\nf 1 2 3 4\nf 2 5 6 3\n", &flat,
        ANGLE "s 1\nvn 0 0 1\nvn -1 0 0\nf 1//1 2//1 3//1 4//1\nf 2//2 5//2 6//2 3//2\n");
    expect_compute(ANGLE "s 1\nf 1 2 3 4\ns 2\nf 2 5 6 3\n", &smooth,
        ANGLE "s 1\nvn 0 0 1\nvn -0.70710677 0 0.70710677\nvn -1 0 0\nf 1//1 2//2 3//2 4//1\ns "
              "2\nf 2//2 5//3 6//3 3//2\n");
}

static void numbers_that_end_in_something_else(void **state) {
    static const char source[] = "v 3.1+e2 0 0\nv 1 0 0x\nv 0 1 0\nf 1 2 3\n";
    (void)state;
    expect_compute(source, NULL, "v 3.1+e2 0 0\nv 1 0 0x\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1\n");
    expect_transform("v 3.1+e2 0 1#up\n", mirror_x, "v -3.1 0 1#up\n");
}

static void errors_name_the_place(void **state) {
    static const struct {
        const char *source;
        const char *message;
    } cases[] = {
        {SQUARE "f 1 2\n", "test.obj:5: a face of 2 corners, where at least three were expected"},
        {SQUARE "f 1 2 5\n", "test.obj:5: position 5 of a face, where the file holds 4 positions"},
        {SQUARE "\r\n\rf 1 2 3\r f 1 -5 3\n",
            "test.obj:8: \"-5\" where a position that stands before this face was expected"},
        {SQUARE "f 0/1 2 3\n",
            "test.obj:5: \"0/1\" where a position, numbered from 1, was expected"},
        {SQUARE "f 1 2 x\n",
            "test.obj:5: \"x\" where a corner (v, v/vt, v//vn or v/vt/vn) was expected"},
        {SQUARE "f 1 2 3/1/1/1\n",
            "test.obj:5: \"3/1/1/1\" where a corner (v, v/vt, v//vn or v/vt/vn) was expected"},
        {SQUARE "f 1 2 3.5\n",
            "test.obj:5: \"3.5\" where a corner (v, v/vt, v//vn or v/vt/vn) was expected"},
        {SQUARE "f 1 2 99999999999999999999\n", "test.obj:5: \"99999999999999999999\" where a "
                                                "corner (v, v/vt, v//vn or v/vt/vn) was expected"},
        {SQUARE "f 1 2 9999999999\n",
            "test.obj:5: position 9999999999 of a face, where the file holds 4 positions"},
        {"v 1 2\n",
            "test.obj:1: the statement ends where one of a position's three numbers was expected"},
        {"v 1 2 3\nv 1,5 2 3\n",
            "test.obj:2: \"1,5\" where one of a position's three numbers was expected"},
        {"#\n\nvn 1 2 up\n",
            "test.obj:3: \"up\" where one of a normal's three numbers was expected"},
        {"", "test.obj: the file is empty; expected OBJ statements"},
        {"<html>\n", "test.obj:1: \"<html>\" where an OBJ statement was expected"},
        {"v 0 0 0\n\x01\x02 binary\n",
            "test.obj:2: a byte of value 1 where a statement's text was expected"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); ++i)
        expect_error(cases[i].source, strlen(cases[i].source), NORMA_DOCUMENT_ERROR_MALFORMED,
            cases[i].message);
    expect_error("\xff\xfe"
                 "v\0 \0",
        6, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
        "test.obj: UTF-16 text; expected ASCII or UTF-8 (convert it first)");
}

/* Every byte string that the text begins with is read or refused, never past its end: the buffer is
 * as long as the string. */
static void every_beginning_is_safe(void **state) {
    static const char source[] =
        "v 0 0 \\\r\n0 1\nv 1 0 0\nv 0 1 0\r\nvn 0 0 1 # x\\\nvt 0\rs 3\no a b \ng f\nf 1/1/1 \\ "
        "\n2//-1 -1/1\nsurf 0 1 0 1 1//1\nl 1 2\n\tf -3 -2 -1";
    (void)state;
    for (size_t size = 1; size <= strlen(source); ++size) {
        char *block = malloc(size);
        norma_document *document;
        const norma_document_options options = {
            .struct_size = sizeof options, .format = NORMA_FILE_OBJ};
        assert_non_null(block);
        memcpy(block, source, size);
        if (norma_document_open_memory(block, size, "test.obj", &options, &document, NULL) ==
            NORMA_DOCUMENT_OK) {
            text before = {block, size, 0};
            assert_int_equal(norma_document_compute(document, NULL, NULL, NULL), NORMA_DOCUMENT_OK);
            text after = written(document);
            assert_same_but_normals("beginning", &before, &after);
            free(after.bytes);
            norma_document_close(document);
        }
        free(block);
    }
}

static void what_is_told(void **state) {
    norma_mesh_info info;
    norma_mesh_data data;
    norma_document *document = open_text("o first \no second\n" SQUARE
                                         "vn 0 0 2\ns 7\nf 1//1 2 3//9 4\ns off\nf 1 2 3\n",
        strlen("o first \no second\n" SQUARE "vn 0 0 2\ns 7\nf 1//1 2 3//9 4\ns off\nf 1 2 3\n"));
    (void)state;
    assert_int_equal(norma_document_mesh_count(document), 1);
    assert_int_equal(norma_document_mesh_info(document, 0, &info), NORMA_DOCUMENT_OK);
    assert_string_equal(info.name, "first");
    assert_int_equal(info.vertices, 4);
    assert_int_equal(info.faces, 2);
    assert_int_equal(info.triangles, 3);
    assert_int_equal(info.normals, NORMA_NORMALS_PER_CORNER);
    assert_string_equal(info.encoding, "text");
    assert_int_equal(info.has_smoothing_groups, 1);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(data.mesh.corner_count, 7);
    assert_int_equal(data.normals.count, 1);
    assert_true(((const float *)data.normals.data)[2] == 2);
    assert_int_equal(data.corner_normals[0], 0);
    for (int i = 1; i < 7; ++i) assert_int_equal(data.corner_normals[i], UINT32_MAX);
    assert_int_not_equal(data.mesh.smoothing_groups[0], 0);
    assert_int_equal(data.mesh.smoothing_groups[1], 0);
    norma_document_close(document);
}

/* ---- transforms */

static void transforms_of_text(void **state) {
    (void)state;
    /* The worked example: (1, 1, 0) under diag(2, 0.5, 1); numbers that do not change keep their
     * text. */
    expect_transform(
        "v 1.50 0.0 -00 1 0 0 # red\nv 1 1 1\nvn 0.70710678 0.70710678 0.000\nf 1//1 2//1 1//1\n",
        scale_2_half_1,
        "v 3 0.0 -00 1 0 0 # red\nv 2 0.5 1\nvn 0.24253562 0.97014248 0.000\nf 1//1 2//1 1//1\n");
    expect_transform(SQUARE "f 1 2/2 3//3 4\n", mirror_x,
        "v 0 0 0\nv -1 0 0\nv -1 1 0\nv 0 1 0\nf 1 4 3//3 2/2\n");
    expect_transform("v 0.1 0.2 0.3\nvn 0.6 0.8 0\n", move_1_2_3, "v 1.1 2.2 3.3\nvn 0.6 0.8 0\n");
    expect_transform(SQUARE "vn 9 9 9\nf 1 2 3\n", identity, SQUARE "vn 9 9 9\nf 1 2 3\n");
    expect_transform("v nan inf 1\nvn nan 0 1\nvn 0 0 0\nvn 0 0 2\nf\n", mirror_x,
        "v nan inf 1\nvn nan 0 1\nvn 0 0 0\nvn 0 0 1\nf\n");
    expect_transform("v 1\\\n2 3\nv 1 2 3\nv 4 5 6\nf 1 \\\n2 3 #\n", mirror_x,
        "v -1\\\n2 3\nv -1 2 3\nv -4 5 6\nf 1 \\\n3 2 #\n");
}

static void a_mirror_is_told(void **state) {
    norma_transform_summary summary;
    (void)state;
    text t = transform(SQUARE "f 1 2 3 4\n", strlen(SQUARE "f 1 2 3 4\n"), mirror_x, &summary);
    assert_int_equal(summary.mirrored, 1);
    assert_int_equal(summary.changed, 1);
    assert_int_equal(summary.vertices, 4);
    free(t.bytes);
    t = transform(SQUARE, strlen(SQUARE), identity, &summary);
    assert_int_equal(summary.changed, 0);
    free(t.bytes);
}

/* Far from the origin floats would not do; near it nine digits tell all. */
static void digits_fit_the_precision(void **state) {
    const double third[16] = {1.0 / 3, 0, 0, 0, 0, 1.0 / 3, 0, 0, 0, 0, 1.0 / 3, 0, 0, 0, 0, 1};
    const double far[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4500000, 0, 0, 1};
    (void)state;
    expect_transform("v 1 0 0\nv 0 1 0\n", third, "v 0.33333334 0 0\nv 0 0.33333334 0\n");
    expect_transform("v 1.0000000001 0 0\nv 0 1 0\n", third,
        "v 0.33333333336666665 0 0\nv 0 0.3333333333333333 0\n");
    expect_transform("v 0.123456 0 0\nv 0 1 0\n", far, "v 4500000.123456 0 0\nv 4500000 1 0\n");
}

/* Computing after a mirror, and a mirror after computing, give what the mirrored file gives. */
static void transform_and_compute(void **state) {
    static const char source[] = ANGLE "f 1 2 3 4\nf 2 5 6 3\n";
    norma_document *a = open_text(source, strlen(source)), *b = open_text(source, strlen(source));
    norma_transform_options options = {.struct_size = sizeof options};
    (void)state;
    memcpy(options.matrix, mirror_x, sizeof mirror_x);
    assert_int_equal(norma_document_transform(a, &options, NULL, NULL), 0);
    assert_int_equal(norma_document_compute(a, NULL, NULL, NULL), 0);
    assert_int_equal(norma_document_compute(b, NULL, NULL, NULL), 0);
    assert_int_equal(norma_document_transform(b, &options, NULL, NULL), 0);
    text x = written(a), y = written(b);
    assert_string_equal(x.bytes, "v 0 0 0\nv -1 0 0\nv -1 1 0\nv 0 1 0\nv -1 0 1\nv -1 1 1\nvn 0 0 "
                                 "1\nvn 1 0 0\nf 1//1 4//1 3//1 2//1\nf 2//2 3//2 6//2 5//2\n");
    assert_string_equal(x.bytes, y.bytes);
    assert_int_equal(norma_document_transform(b, &options, NULL, NULL), 0);
    text z = written(b);
    assert_string_equal(
        z.bytes, ANGLE "vn 0 0 1\nvn -1 0 0\nf 1//1 2//1 3//1 4//1\nf 2//2 5//2 6//2 3//2\n");
    free(x.bytes);
    free(y.bytes);
    free(z.bytes);
    norma_document_close(a);
    norma_document_close(b);
}

/* ---- the data set */

static int is_obj(const char *name) {
    size_t length = strlen(name);
    return length > 4 && strcmp(name + length - 4, ".obj") == 0;
}

static void check_unit_normals(const char *name, norma_document *document) {
    norma_mesh_data data;
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    const float *normals = data.normals.data;
    for (size_t c = 0; c < data.mesh.corner_count; ++c) {
        if (!data.corner_normals || data.corner_normals[c] >= data.normals.count)
            fail_msg("%s: corner %zu has no normal", name, c);
        const float *n = normals + 3 * (size_t)data.corner_normals[c];
        double length = sqrt((double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] +
                             (double)n[2] * (double)n[2]);
        if (!(fabs(length - 1) < 1e-6))
            fail_msg("%s: corner %zu has a normal of length %g", name, c, length);
    }
}

typedef struct tally {
    size_t read, refused;
} tally;

static void visit_compute(void *user, const char *path, const char *name) {
    tally *counts = user;
    norma_document *document;
    norma_document_error error = {0};
    norma_compute_summary summary;
    if (!is_obj(name)) return;
    if (norma_document_open(path, NULL, &document, &error)) {
        /* Each says which file, and where in it. */
        assert_non_null(strstr(error.message, path));
        if (strncmp(name, "bad/", 4) != 0 && strcmp(name, "obj/utf16be.obj") != 0)
            fail_msg("%s", error.message);
        ++counts->refused;
        return;
    }
    ++counts->read;
    text before = read_file(path), untouched = written(document);
    assert_int_equal(before.size, untouched.size);
    assert_memory_equal(before.bytes, untouched.bytes, before.size);
    if (norma_document_compute(document, NULL, &summary, &error)) fail_msg("%s", error.message);
    text after = written(document);
    assert_same_but_normals(name, &before, &after);
    norma_document_close(document);
    document = open_text(after.bytes, after.size);
    check_unit_normals(name, document);
    norma_document_close(document);
    /* Once more: the same; only what is missing or broken: nothing. */
    for (int only = NORMA_ONLY_ALL; only <= NORMA_ONLY_BROKEN; ++only) {
        const norma_compute_options options = {
            .struct_size = sizeof options, .only = (norma_only)only};
        text again = compute(after.bytes, after.size, &options, &summary);
        assert_int_equal(again.size, after.size);
        assert_memory_equal(again.bytes, after.bytes, after.size);
        free(again.bytes);
    }
    free(before.bytes);
    free(untouched.bytes);
    free(after.bytes);
}

static void every_file_is_rewritten(void **state) {
    tally counts = {0, 0};
    (void)state;
    const char *folder = data_folder();
    if (!folder) skip();
    data_for_each(folder, visit_compute, &counts);
    print_message("%zu OBJ files read, %zu refused\n", counts.read, counts.refused);
    assert_int_equal(counts.read, 88);
    assert_int_equal(counts.refused, 5);
}

static void bad_files_answer_as_expected(void **state) {
    static const struct {
        const char *name;
        int may_read, may_refuse;
    } files[] = {{"box-incomplete-normals", 1, 1}, {"box-incomplete-positions", 1, 1},
        {"box-incomplete-uvs", 1, 1}, {"comment-only", 1, 1}, {"empty", 0, 1},
        {"face-in-group-name-mid-file", 1, 0}, {"face-in-group-name", 1, 0},
        {"joined-tetrahedra", 1, 0}, {"malformed", 0, 1}, {"malformed2", 1, 0}, {"nan-inf", 1, 1},
        {"nancolor", 1, 0}, {"notenoughindices", 1, 1}, {"truncated", 1, 1}};
    const char *folder = data_folder();
    (void)state;
    if (!folder) skip();
    for (size_t i = 0; i < COUNT_OF(files); ++i) {
        char path[2000];
        norma_document *document;
        norma_document_error error = {0};
        snprintf(path, sizeof path, "%s/bad/obj/%s.obj", folder, files[i].name);
        norma_document_result result = norma_document_open(path, NULL, &document, &error);
        if (result ? !files[i].may_refuse : !files[i].may_read)
            fail_msg("%s: %s", files[i].name, result ? error.message : "was read");
        if (result) assert_memory_equal(error.message, path, strlen(path));
        norma_document_close(document);
    }
}

/* The greatest angle between the corner normals that a file has and those that are computed, and
 * how many corners are within the tolerance. */
static double compare_to_stored(const char *name, const norma_compute_options *options,
    double tolerance, size_t *within, size_t *corners) {
    char path[2000];
    norma_document *stored, *computed;
    norma_mesh_data a, b;
    double worst = 0;
    snprintf(path, sizeof path, "%s/%s", data_folder(), name);
    assert_int_equal(norma_document_open(path, NULL, &stored, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_open(path, NULL, &computed, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_compute(computed, options, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(stored, 0, &a, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(computed, 0, &b, NULL), NORMA_DOCUMENT_OK);
    *corners = a.mesh.corner_count;
    *within = 0;
    for (size_t c = 0; c < *corners; ++c) {
        const float *x = (const float *)a.normals.data + 3 * (size_t)a.corner_normals[c],
                    *y = (const float *)b.normals.data + 3 * (size_t)b.corner_normals[c];
        double angle = degrees_to(y, (double)x[0], (double)x[1], (double)x[2]);
        worst = angle > worst ? angle : worst;
        *within += angle <= tolerance;
    }
    norma_document_close(stored);
    norma_document_close(computed);
    return worst;
}

/* outside: corners that may differ. Where fans touch in a vertex only, neighbours are wound against
 * each other or faces have no area, those programs averaged over all faces of the group; Norma
 * keeps what shares no edge apart. With one normal per position it finds theirs everywhere. */
static void normals_that_other_programs_wrote(void **state) {
    static const struct {
        const char *name;
        norma_shading shading;
        norma_weight weight;
        double tolerance;
        size_t outside;
    } files[] = {
        {"obj/dcc/teapot-smoothing.obj", NORMA_SHADING_DEFAULT, NORMA_WEIGHT_ANGLE_AREA, 0.05, 0},
        {"obj/wuson.obj", NORMA_SHADING_SMOOTH, NORMA_WEIGHT_UNIFORM, 0.1, 0},
        {"obj/wuson.obj", NORMA_SHADING_DEFAULT, NORMA_WEIGHT_UNIFORM, 0.1, 53},
        {"obj/spider.obj", NORMA_SHADING_DEFAULT, NORMA_WEIGHT_UNIFORM, 0.05, 252},
        {"obj/dcc/cube-one-smoothing-group.obj", NORMA_SHADING_DEFAULT, NORMA_WEIGHT_ANGLE, 0.001,
            0},
        {"obj/dcc/cube-authored-normals.obj", NORMA_SHADING_DEFAULT, NORMA_WEIGHT_ANGLE, 0.001, 0},
        {"obj/concave-66gon.obj", NORMA_SHADING_FLAT, NORMA_WEIGHT_ANGLE, 0.01, 0},
        {"obj/box/concave.obj", NORMA_SHADING_FLAT, NORMA_WEIGHT_ANGLE, 0.01, 0},
        {"scan/bunny.obj", NORMA_SHADING_FLAT, NORMA_WEIGHT_ANGLE, 0.003, 0},
        {"scan/fish-low.obj", NORMA_SHADING_FLAT, NORMA_WEIGHT_ANGLE, 0.005, 0},
        {"scan/spot.obj", NORMA_SHADING_FLAT, NORMA_WEIGHT_ANGLE, 0.022, 0},
        {"truth/cube-axis-normals.obj", NORMA_SHADING_DEFAULT, NORMA_WEIGHT_ANGLE, 0.001, 0},
        {"truth/cube-no-bottom.obj", NORMA_SHADING_DEFAULT, NORMA_WEIGHT_ANGLE, 0.001, 0},
        {"transform/max-geometry-transform-instances/max-geometry-transform-instances.truth.obj",
            NORMA_SHADING_DEFAULT, NORMA_WEIGHT_ANGLE, 0.01, 0},
        {"transform/max-geometry-transform/max-geometry-transform.truth.obj", NORMA_SHADING_DEFAULT,
            NORMA_WEIGHT_ANGLE, 0.01, 0},
        {"transform/maya-equal-pivot-scale/maya-equal-pivot-scale.truth.obj", NORMA_SHADING_DEFAULT,
            NORMA_WEIGHT_ANGLE, 0.01, 0},
        {"transform/maya-parented-cubes/maya-parented-cubes.truth.obj", NORMA_SHADING_DEFAULT,
            NORMA_WEIGHT_ANGLE, 0.01, 0},
    };
    (void)state;
    if (!data_folder()) skip();
    for (size_t i = 0; i < COUNT_OF(files); ++i) {
        const norma_compute_options options = {
            .struct_size = sizeof options, .shading = files[i].shading, .weight = files[i].weight};
        size_t within, corners;
        double worst =
            compare_to_stored(files[i].name, &options, files[i].tolerance, &within, &corners);
        if (corners - within != files[i].outside)
            fail_msg("%s: %zu of %zu corners within %g degrees, worst %g", files[i].name, within,
                corners, files[i].tolerance, worst);
    }
}

static norma_document *open_data(const char *name) {
    char path[2000];
    norma_document *document;
    norma_document_error error;
    snprintf(path, sizeof path, "%s/%s", data_folder(), name);
    if (norma_document_open(path, NULL, &document, &error)) fail_msg("%s", error.message);
    return document;
}

/* Max's weights are exact where the vertices lie on a sphere; a regular dodecahedron's face looks
 * where its centre lies. */
static void closed_forms(void **state) {
    const norma_compute_options max = {
        .struct_size = sizeof max, .shading = NORMA_SHADING_SMOOTH, .weight = NORMA_WEIGHT_MAX};
    norma_mesh_data data;
    (void)state;
    if (!data_folder()) skip();
    norma_document *document = open_data("truth/icosphere.obj");
    assert_int_equal(norma_document_compute(document, &max, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    for (size_t c = 0; c < data.mesh.corner_count; ++c) {
        const double *p = (const double *)data.mesh.positions.data +
                          3 * (size_t)((const uint32_t *)data.mesh.corners)[c];
        assert_direction((const float *)data.normals.data + 3 * (size_t)data.corner_normals[c],
            p[0], p[1], p[2], 4e-4);
    }
    norma_document_close(document);
    document = open_data("truth/dodecahedron.obj");
    assert_int_equal(norma_document_compute(document, NULL, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(data.normals.count, 12);
    for (size_t c = 0; c < data.mesh.corner_count; ++c) {
        double centre[3] = {0, 0, 0};
        for (size_t k = c / 5 * 5; k < c / 5 * 5 + 5; ++k)
            for (size_t i = 0; i < 3; ++i)
                centre[i] += ((const double *)data.mesh.positions
                                  .data)[3 * (size_t)((const uint32_t *)data.mesh.corners)[k] + i];
        assert_direction((const float *)data.normals.data + 3 * (size_t)data.corner_normals[c],
            centre[0], centre[1], centre[2], 1e-4);
    }
    norma_document_close(document);
}

static double distance(const double *a, const double *b) {
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

/* What a document holds is what its text, read again, holds, to the precision of the text: half a
 * unit of a float's last place for the float, half for its shortest text. */
static void check_text_of(const char *name, norma_document *document) {
    norma_mesh_data a, b;
    text t = written(document);
    norma_document *again = open_text(t.bytes, t.size);
    assert_int_equal(norma_document_mesh_data(document, 0, &a, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(again, 0, &b, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(a.mesh.positions.count, b.mesh.positions.count);
    assert_int_equal(a.mesh.corner_count, b.mesh.corner_count);
    assert_int_equal(a.normals.count, b.normals.count);
    if (a.mesh.corner_count)
        assert_memory_equal(a.mesh.corners, b.mesh.corners, 4 * a.mesh.corner_count);
    if (a.normals.count)
        assert_memory_equal(a.corner_normals, b.corner_normals, 4 * a.mesh.corner_count);
    for (size_t i = 0; i < a.mesh.positions.count; ++i) {
        const double *p = (const double *)a.mesh.positions.data + 3 * i,
                     *q = (const double *)b.mesh.positions.data + 3 * i;
        const double zero[3] = {0, 0, 0};
        if (isfinite(distance(p, zero)) && !(distance(p, q) <= 1.2e-7 * distance(p, zero)))
            fail_msg("%s: position %zu was written %g away", name, i, distance(p, q));
    }
    for (size_t i = 0; i < 3 * a.normals.count; ++i) {
        double x = (double)((const float *)a.normals.data)[i],
               y = (double)((const float *)b.normals.data)[i];
        if (isfinite(x) && fabs(x - y) > 6e-8)
            fail_msg("%s: normal %zu is %g and was written %g", name, i / 3, x, y);
    }
    norma_document_close(again);
    free(t.bytes);
}

/* A shear that mirrors. Face normals computed and then transformed are those of the transformed
 * file, but for thin faces. */
static void visit_transform(void *user, const char *path, const char *name) {
    static const double matrix[16] = {
        1.5, 0.25, 0, 0, 0.5, -0.75, 0.125, 0, 0, 0.3, 1.1, 0, 10, -20, 30, 1};
    const norma_compute_options flat = {.struct_size = sizeof flat, .shading = NORMA_SHADING_FLAT};
    norma_transform_options options = {.struct_size = sizeof options};
    norma_transform_summary summary;
    norma_document *a, *b;
    norma_mesh_data x, y;
    memcpy(options.matrix, matrix, sizeof matrix);
    if (!is_obj(name) || norma_document_open(path, NULL, &a, NULL)) return;
    assert_int_equal(norma_document_open(path, NULL, &b, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_transform(a, &options, &summary, NULL), NORMA_DOCUMENT_OK);
    check_text_of(name, a);
    assert_int_equal(norma_document_compute(a, &flat, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_compute(b, &flat, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_transform(b, &options, &summary, NULL), NORMA_DOCUMENT_OK);
    check_text_of(name, b);
    assert_int_equal(norma_document_mesh_data(a, 0, &x, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(b, 0, &y, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(x.mesh.corner_count, y.mesh.corner_count);
    if (x.mesh.corner_count)
        assert_memory_equal(x.mesh.corners, y.mesh.corners, 4 * x.mesh.corner_count);
    for (size_t c = 0; c + 2 < x.mesh.corner_count && !x.mesh.face_starts; c += 3) {
        const double *p[3];
        for (size_t k = 0; k < 3; ++k)
            p[k] = (const double *)x.mesh.positions.data +
                   3 * (size_t)((const uint32_t *)x.mesh.corners)[c + k];
        double e0 = distance(p[0], p[1]), e1 = distance(p[1], p[2]), e2 = distance(p[2], p[0]),
               s = (e0 + e1 + e2) / 2;
        if (!(s * (s - e0) * (s - e1) * (s - e2) > 1e-6 * s * s * s * s)) continue;
        const float *n = (const float *)y.normals.data + 3 * (size_t)y.corner_normals[c];
        assert_direction((const float *)x.normals.data + 3 * (size_t)x.corner_normals[c],
            (double)n[0], (double)n[1], (double)n[2], 1e-4);
        ++*(size_t *)user;
    }
    norma_document_close(a);
    norma_document_close(b);
}

static void every_file_is_transformed(void **state) {
    size_t faces = 0;
    (void)state;
    if (!data_folder()) skip();
    data_for_each(data_folder(), visit_transform, &faces);
    assert_true(faces > 100000);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_face_gets_its_normal),
        cmocka_unit_test(every_mix_of_indices), cmocka_unit_test(old_normals_go),
        cmocka_unit_test(line_endings_stay), cmocka_unit_test(lines_are_joined),
        cmocka_unit_test(blanks_and_comments_stay), cmocka_unit_test(other_statements_pass),
        cmocka_unit_test(normals_of_surfaces_stay), cmocka_unit_test(nothing_to_do),
        cmocka_unit_test(only_what_is_missing), cmocka_unit_test(only_what_is_broken),
        cmocka_unit_test(what_has_no_normal), cmocka_unit_test(groups_decide),
        cmocka_unit_test(a_group_without_faces_is_none), cmocka_unit_test(many_groups),
        cmocka_unit_test(more_groups_at_an_edge_than_bits), cmocka_unit_test(smooth_and_flat),
        cmocka_unit_test(numbers_that_end_in_something_else),
        cmocka_unit_test(errors_name_the_place), cmocka_unit_test(every_beginning_is_safe),
        cmocka_unit_test(what_is_told), cmocka_unit_test(transforms_of_text),
        cmocka_unit_test(a_mirror_is_told), cmocka_unit_test(digits_fit_the_precision),
        cmocka_unit_test(transform_and_compute), cmocka_unit_test(every_file_is_rewritten),
        cmocka_unit_test(bad_files_answer_as_expected),
        cmocka_unit_test(normals_that_other_programs_wrote), cmocka_unit_test(closed_forms),
        cmocka_unit_test(every_file_is_transformed)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
