/* test_document_save.c: what document.c decides for every format: options, errors in one line,
 * where a document may be written, and that a failure on the way leaves the old files. The format
 * here is a made-up one that writes what it read, or fails where it is told to. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <string.h>
#include <unistd.h>
#include "io/format/format.h"

typedef struct place {
    char folder[128], source[160], target[160], beside[160];
} place;

typedef struct fake {
    norma_document document;
    norma_document_result write_result, companions_result, compute_result;
    int write_calls, companion_calls, companion_before_write, in_place;
    norma_compute_options compute_options;
    const char *beside;
} fake;

static fake *fake_of(const norma_document *document) {
    return (fake *)(uintptr_t)document; /* its first member */
}

static size_t one_mesh(const norma_document *document) {
    (void)document;
    return 1;
}

static norma_document_result describe(
    const norma_document *document, size_t index, norma_mesh_info *info) {
    (void)document;
    (void)index;
    info->not_read = "points have no normals";
    return NORMA_DOCUMENT_OK;
}

static norma_document_result compute(norma_document *document, const norma_compute_options *options,
    norma_compute_summary *summary, norma_document_error *error) {
    fake_of(document)->compute_options = *options;
    summary->faces = 7;
    return fake_of(document)->compute_result
               ? norma_document_fail(
                     document, error, fake_of(document)->compute_result, "line 3", "found %d", 5)
               : NORMA_DOCUMENT_OK;
}

static norma_document_result write_bytes(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error) {
    fake *made = fake_of(document);
    (void)path;
    ++made->write_calls;
    if (write(user, document->source.data, document->source.size))
        return norma_document_fail(
            document, error, NORMA_DOCUMENT_ERROR_FILE, NULL, "the sink failed");
    return made->write_result
               ? norma_document_fail(document, error, made->write_result, NULL, "told to fail")
               : NORMA_DOCUMENT_OK;
}

static norma_document_result write_companions(norma_document *document, const char *path,
    int in_place, companion_writers *writers, norma_document_error *error) {
    (void)writers;
    fake *made = fake_of(document);
    ++made->companion_calls;
    made->companion_before_write = made->write_calls == 0;
    made->in_place = in_place;
    (void)path;
    return made->companions_result
               ? norma_document_fail(document, error, made->companions_result, NULL, "told to fail")
               : NORMA_DOCUMENT_OK;
}

static int visit_files(const norma_document *document, norma_visit_file *visit, void *user) {
    return visit(user, fake_of(document)->beside) != 0;
}

static const format_functions functions = {.mesh_count = one_mesh,
    .mesh_info = describe,
    .compute = compute,
    .write = write_bytes,
    .write_companions = write_companions,
    .visit_files = visit_files};

static void put(const char *path, const char *text) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static void assert_holds(const char *path, const char *text) {
    file_bytes bytes;
    assert_int_equal(norma_file_open(path, NULL, &bytes), 0);
    assert_int_equal(bytes.size, strlen(text));
    assert_memory_equal(bytes.data, text, bytes.size);
    norma_file_close(&bytes);
}

static int set_up(void **state) {
    place *made = calloc(1, sizeof *made);
    snprintf(made->folder, sizeof made->folder, "/tmp/norma-document-XXXXXX");
    if (!mkdtemp(made->folder)) return -1;
    snprintf(made->source, sizeof made->source, "%s/mesh.obj", made->folder);
    snprintf(made->target, sizeof made->target, "%s/out.obj", made->folder);
    snprintf(made->beside, sizeof made->beside, "%s/beside.obj", made->folder);
    put(made->source, "new");
    put(made->target, "old");
    put(made->beside, "beside");
    *state = made;
    return 0;
}

static int tear_down(void **state) {
    place *here = *state;
    char command[200];
    snprintf(command, sizeof command, "rm -rf '%s'", here->folder);
    int status = system(command);
    free(here);
    return status;
}

static fake fake_document(const place *here) {
    return (fake){.document = {.functions = &functions,
                      .format = NORMA_FILE_OBJ,
                      .path = (char *)(uintptr_t)here->source,
                      .folder = (char *)(uintptr_t) "",
                      .source = {.data = (const unsigned char *)"new", .size = 3}},
        .beside = here->beside};
}

static void assert_no_temporary(const place *here) {
    char command[300];
    snprintf(command, sizeof command, "test -z \"$(ls -A '%s' | grep tmp)\"", here->folder);
    assert_int_equal(system(command), 0);
}

/* ---- saving */

static void saves_the_main_file_last(void **state) {
    const place *here = *state;
    fake made = fake_document(here);
    norma_document_error error;
    assert_int_equal(
        norma_document_save(&made.document, here->target, NULL, &error), NORMA_DOCUMENT_OK);
    assert_holds(here->target, "new");
    assert_int_equal(made.companion_calls, 1);
    assert_int_equal(made.companion_before_write, 0);
    assert_int_equal(made.in_place, 0);
    assert_int_equal(error.result, NORMA_DOCUMENT_OK);
    assert_string_equal(error.message, "");
    assert_no_temporary(here);
}

static void a_failure_anywhere_leaves_the_old_file(void **state) {
    const place *here = *state;
    norma_document_error error;
    fake made = fake_document(here);
    made.write_result = NORMA_DOCUMENT_ERROR_MEMORY;
    assert_int_equal(norma_document_save(&made.document, here->target, NULL, &error),
        NORMA_DOCUMENT_ERROR_MEMORY);
    assert_int_equal(made.companion_calls, 0); /* nothing beside it was touched either */
    assert_holds(here->target, "old");
    made = fake_document(here);
    made.companions_result = NORMA_DOCUMENT_ERROR_REFUSED;
    assert_int_equal(norma_document_save(&made.document, here->target, NULL, &error),
        NORMA_DOCUMENT_ERROR_REFUSED);
    assert_holds(here->target, "old");
    assert_no_temporary(here);
}

static int stop(void *user, double fraction) {
    *(double *)user = fraction;
    return 1;
}

static void a_cancelled_save_leaves_the_old_file(void **state) {
    const place *here = *state;
    norma_document_error error;
    double fraction = -1;
    fake made = fake_document(here);
    const norma_save_options options = {
        .struct_size = sizeof options, .progress = stop, .progress_user = &fraction};
    assert_int_equal(norma_document_save(&made.document, here->target, &options, &error),
        NORMA_DOCUMENT_CANCELLED);
    assert_true(fraction > 0 && fraction <= 1);
    assert_holds(here->target, "old");
    assert_no_temporary(here);
}

static void refuses(const place *here, const char *path, const char *words) {
    norma_document_error error;
    fake made = fake_document(here);
    assert_int_equal(
        norma_document_save(&made.document, path, NULL, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_int_equal(made.write_calls, 0);
    assert_int_equal(error.result, NORMA_DOCUMENT_ERROR_ARGUMENT);
    if (path) assert_int_equal(strncmp(error.message, path, strlen(path)), 0);
    assert_non_null(strstr(error.message, words));
}

static void names_that_may_not_be_written(void **state) {
    const place *here = *state;
    char path[200];
    refuses(here, here->source, "is the input itself");
    snprintf(path, sizeof path, "%s/./mesh.obj", here->folder);
    refuses(here, path, "is the input itself");
    snprintf(path, sizeof path, "%s/link.obj", here->folder);
    assert_int_equal(symlink("mesh.obj", path), 0);
    refuses(here, path, "is the input itself");
    refuses(here, here->beside, "is used by");
    snprintf(path, sizeof path, "%s/out.ply", here->folder);
    refuses(here, path, ".obj");
    snprintf(path, sizeof path, "%s/out", here->folder);
    refuses(here, path, ".obj");
    refuses(here, NULL, "no path");
    assert_holds(here->source, "new");
    assert_holds(here->beside, "beside");
}

static void in_place_may_name_the_source(void **state) {
    const place *here = *state;
    fake made = fake_document(here);
    made.document.source = (file_bytes){.data = (const unsigned char *)"newer", .size = 5};
    const norma_save_options options = {.in_place = 1};
    assert_int_equal(
        norma_document_save(&made.document, here->source, &options, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(made.in_place, 1);
    assert_holds(here->source, "newer");
}

static void a_device_gets_no_companions(void **state) {
    const place *here = *state;
    norma_document_error error;
    fake made = fake_document(here);
    assert_int_equal(
        norma_document_save(&made.document, "/dev/null", NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(made.companion_calls, 0);
    if (access("/dev/full", W_OK)) skip();
    made = fake_document(here);
    assert_int_equal(
        norma_document_save(&made.document, "/dev/full", NULL, &error), NORMA_DOCUMENT_ERROR_FILE);
    assert_string_equal(error.message, "/dev/full: cannot be written: No space left on device");
}

/* ---- computing */

static void options_are_checked_before_the_format_sees_them(void **state) {
    const place *here = *state;
    const norma_compute_options bad[] = {
        {.shading = NORMA_SHADING_CREASE, .crease_angle_rad = NAN},
        {.shading = NORMA_SHADING_CREASE, .crease_angle_rad = -0.1},
        {.shading = NORMA_SHADING_CREASE, .crease_angle_rad = INFINITY},
        {.weld = NORMA_WELD_DISTANCE, .weld_distance = -1},
        {.weld = NORMA_WELD_DISTANCE, .weld_distance = NAN},
        {.weight = (norma_weight)7},
        {.shading = (norma_shading)4},
        {.weld = (norma_weld)3},
        {.groups = (norma_groups)2},
        {.only = (norma_only)3},
        {.non_manifold = (norma_non_manifold)2},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
        norma_document_error error;
        norma_compute_summary summary;
        fake made = fake_document(here);
        assert_int_equal(norma_document_compute(&made.document, &bad[i], &summary, &error),
            NORMA_DOCUMENT_ERROR_ARGUMENT);
        assert_int_equal(made.document.failed, 0); /* nothing was begun */
    }
}

static void options_of_another_version_are_read_as_far_as_they_go(void **state) {
    const place *here = *state;
    fake made = fake_document(here);
    norma_compute_options options = {.struct_size = offsetof(norma_compute_options, only),
        .weight = NORMA_WEIGHT_MAX,
        .only = NORMA_ONLY_BROKEN,
        .morphs = 1};
    assert_int_equal(
        norma_document_compute(&made.document, &options, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(made.compute_options.weight, NORMA_WEIGHT_MAX);
    assert_int_equal(made.compute_options.only, NORMA_ONLY_ALL);
    assert_int_equal(made.compute_options.morphs, 0);
    options.struct_size = 0; /* the first version had all of these */
    assert_int_equal(
        norma_document_compute(&made.document, &options, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(made.compute_options.only, NORMA_ONLY_BROKEN);
    assert_int_equal(norma_document_compute(&made.document, NULL, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(made.compute_options.weight, NORMA_WEIGHT_ANGLE);
}

static void after_a_failed_change_a_document_can_only_be_closed(void **state) {
    const place *here = *state;
    norma_document_error error;
    fake made = fake_document(here);
    made.compute_result = NORMA_DOCUMENT_ERROR_MALFORMED;
    assert_int_equal(
        norma_document_compute(&made.document, NULL, NULL, &error), NORMA_DOCUMENT_ERROR_MALFORMED);
    assert_non_null(strstr(error.message, "mesh.obj:line 3: found 5"));
    assert_int_equal(norma_document_save(&made.document, here->target, NULL, &error),
        NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_holds(here->target, "old");
}

static void summaries_and_what_was_not_read(void **state) {
    const place *here = *state;
    norma_document_error error;
    norma_mesh_data data;
    fake made = fake_document(here);
    assert_int_equal(
        norma_document_mesh_data(&made.document, 0, &data, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "points have no normals"));
    assert_int_equal(
        norma_document_mesh_data(&made.document, 1, &data, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
    made.document.depth = NORMA_DOCUMENT_SUMMARY;
    assert_int_equal(
        norma_document_compute(&made.document, NULL, NULL, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_int_equal(norma_document_save(&made.document, here->target, NULL, &error),
        NORMA_DOCUMENT_ERROR_ARGUMENT);
}

/* ---- matrices */

static norma_document_result take_matrix(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error) {
    (void)document;
    (void)error;
    summary->vertices = (size_t)options->matrix[0];
    return NORMA_DOCUMENT_OK;
}

static void matrices_are_affine_and_finite(void **state) {
    const place *here = *state;
    format_functions with_transform = functions;
    with_transform.transform = take_matrix;
    fake made = fake_document(here);
    made.document.functions = &with_transform;
    norma_transform_options options = {0};
    norma_transform_summary summary;
    assert_int_equal(
        norma_document_transform(&made.document, &options, &summary, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(summary.vertices, 1); /* all zero: the identity */
    options.matrix[0] = 2;
    assert_int_equal(norma_document_transform(&made.document, &options, &summary, NULL),
        NORMA_DOCUMENT_ERROR_ARGUMENT);
    options.matrix[15] = 1;
    assert_int_equal(
        norma_document_transform(&made.document, &options, &summary, NULL), NORMA_DOCUMENT_OK);
    options.matrix[11] = 0.5;
    assert_int_equal(norma_document_transform(&made.document, &options, &summary, NULL),
        NORMA_DOCUMENT_ERROR_ARGUMENT);
    options.matrix[11] = 0;
    options.matrix[12] = INFINITY;
    assert_int_equal(norma_document_transform(&made.document, &options, &summary, NULL),
        NORMA_DOCUMENT_ERROR_ARGUMENT);
}

/* ---- messages */

static void a_message_is_one_line(void **state) {
    (void)state;
    norma_document_error error;
    const norma_document document = {.path = (char *)(uintptr_t) "a\nb\x1b.obj"};
    norma_document_fail(
        &document, &error, NORMA_DOCUMENT_ERROR_MALFORMED, "byte 7", "found '%s'", "x\ty");
    assert_string_equal(error.message, "a?b?.obj:byte 7: found 'x?y'");
    norma_document_fail(NULL, &error, NORMA_DOCUMENT_ERROR_MALFORMED, NULL, "alone");
    assert_string_equal(error.message, "alone");
    assert_int_equal(
        norma_document_fail(NULL, NULL, NORMA_DOCUMENT_ERROR_MALFORMED, NULL, "nowhere"),
        NORMA_DOCUMENT_ERROR_MALFORMED);
}

static void a_message_is_cut_between_characters(void **state) {
    (void)state;
    for (size_t shift = 0; shift < 3; ++shift) {
        norma_document_error error;
        char text[1500] = "";
        memset(text, 'x', shift);
        for (size_t at = shift; at + 3 < sizeof text; at += 3) memcpy(text + at, "\xE2\x82\xAC", 4);
        norma_document_fail(NULL, &error, NORMA_DOCUMENT_ERROR_FILE, NULL, "%s", text);
        size_t length = strlen(error.message);
        assert_true(length > 990 && length < sizeof error.message);
        assert_int_equal((length - shift) % 3, 0);
    }
}

static void notes_are_kept_in_order(void **state) {
    const place *here = *state;
    fake made = fake_document(here);
    for (int i = 0; i < 100; ++i)
        assert_int_equal(norma_document_add_note(&made.document, "note\n%d", i), 1);
    assert_int_equal(norma_document_note_count(&made.document), 100);
    assert_string_equal(norma_document_note(&made.document, 0), "note?0");
    assert_string_equal(norma_document_note(&made.document, 99), "note?99");
    assert_string_equal(norma_document_note(&made.document, 100), "");
    for (size_t i = 0; i < made.document.note_count; ++i) free(made.document.notes[i]);
    free(made.document.notes);
}

/* ---- small things */

static void opening_fails_with_words(void **state) {
    const place *here = *state;
    norma_document_error error;
    norma_document *document = (norma_document *)(uintptr_t)1;
    char path[200];
    snprintf(path, sizeof path, "%s/none.obj", here->folder);
    assert_int_equal(norma_document_open(path, NULL, &document, &error), NORMA_DOCUMENT_ERROR_FILE);
    assert_null(document);
    assert_non_null(strstr(error.message, "No such file"));
    assert_int_equal(
        norma_document_open(here->folder, NULL, &document, &error), NORMA_DOCUMENT_ERROR_FILE);
    snprintf(path, sizeof path, "%s/mesh.xyz", here->folder);
    put(path, "v");
    assert_int_equal(
        norma_document_open(path, NULL, &document, &error), NORMA_DOCUMENT_ERROR_UNSUPPORTED);
    assert_int_equal(
        norma_document_open(NULL, NULL, &document, NULL), NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_int_equal(norma_document_open(path, NULL, NULL, NULL), NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_int_equal(norma_document_open_memory(NULL, 3, "a.obj", NULL, &document, &error),
        NORMA_DOCUMENT_ERROR_ARGUMENT);
    norma_document_close(NULL);
}

static void formats_by_extension(void **state) {
    (void)state;
    assert_int_equal(norma_file_format_of_path("a/b.OBJ"), NORMA_FILE_OBJ);
    assert_int_equal(norma_file_format_of_path("a.obj/b"), NORMA_FILE_UNKNOWN);
    assert_int_equal(norma_file_format_of_path("a.obj.ply"), NORMA_FILE_PLY);
    assert_int_equal(norma_file_format_of_path("a.gltf"), NORMA_FILE_GLTF);
    assert_int_equal(norma_file_format_of_path("a.GlB"), NORMA_FILE_GLB);
    assert_int_equal(norma_file_format_of_path("a.stl"), NORMA_FILE_STL);
    assert_int_equal(norma_file_format_of_path("stl"), NORMA_FILE_UNKNOWN);
    assert_int_equal(norma_file_format_of_path(""), NORMA_FILE_UNKNOWN);
    assert_int_equal(norma_file_format_of_path(NULL), NORMA_FILE_UNKNOWN);
    assert_string_equal(norma_file_format_name(NORMA_FILE_GLB), "glb");
    assert_string_equal(norma_file_format_name(NORMA_FILE_UNKNOWN), "");
}

static void reports_add_up(void **state) {
    (void)state;
    norma_report sum = {0}, part = {.cancelled = {2, 5},
                                .winding_conflicts = {1, 9},
                                .degenerate_faces = {0, SIZE_MAX}};
    norma_policy_add_report(&sum, &part, 0);
    assert_int_equal(sum.cancelled.first, 5);
    norma_policy_add_report(&sum, &part, 1);
    assert_int_equal(sum.cancelled.count, 4);
    assert_int_equal(sum.cancelled.first, SIZE_MAX);
    assert_int_equal(sum.winding_conflicts.count, 2);
    assert_int_equal(sum.degenerate_faces.count, 0);
}

static void sizes_are_checked(void **state) {
    (void)state;
    volatile size_t huge = SIZE_MAX / 2; /* volatile: or the compiler warns of what is asked for */
    size_t capacity = 0;
    assert_null(norma_io_allocate(huge, 8));
    assert_null(norma_io_grow(NULL, &capacity, huge, 8));
    assert_int_equal(capacity, 0);
    int *block = norma_io_grow(NULL, &capacity, 1, sizeof *block);
    assert_non_null(block);
    assert_true(capacity >= 1);
    block[0] = 42;
    size_t before = capacity;
    int *larger = norma_io_grow(block, &capacity, before + 1, sizeof *block);
    assert_non_null(larger);
    assert_true(capacity >= 2 * before);
    assert_int_equal(larger[0], 42);
    assert_null(norma_io_grow(larger, &capacity, huge, sizeof *larger));
    free(larger);
    void *nothing = norma_io_allocate(0, 0);
    assert_non_null(nothing);
    free(nothing);
}

static size_t files_in(const char *folder) {
    size_t count = 0;
    DIR *all = opendir(folder);
    assert_non_null(all);
    for (struct dirent *entry; (entry = readdir(all)) != NULL;) ++count;
    closedir(all);
    return count;
}

/* More bytes than any buffer on the way. */
static void pieces_are_in_place_at_the_end(void **state) {
    enum { PIECES = 100000 };
    const place *at = *state;
    char *all = calloc(PIECES, 7);
    norma_saving *saving;
    norma_document_error error;
    const size_t before = files_in(at->folder);
    assert_non_null(all);
    for (size_t i = 0; i < PIECES; ++i) memcpy(all + 7 * i, "seven.\n", i + 1 < PIECES ? 7 : 6);
    for (int ends = 0; ends < 2; ++ends) {
        assert_int_equal(norma_save_begin(at->target, &saving, &error), NORMA_DOCUMENT_OK);
        for (size_t i = 0; i < PIECES; ++i)
            assert_int_equal(norma_save_piece(saving, all + 7 * i, i + 1 < PIECES ? 7 : 6, &error),
                NORMA_DOCUMENT_OK);
        assert_int_equal(norma_save_piece(saving, NULL, 0, &error), NORMA_DOCUMENT_OK);
        const char *temporary = norma_save_temporary(saving);
        if (temporary) assert_int_equal(access(temporary, F_OK), 0);
        assert_holds(at->target, "old");
        if (ends)
            assert_int_equal(norma_save_end(saving, &error), NORMA_DOCUMENT_OK);
        else
            norma_save_abandon(saving);
        assert_holds(at->target, ends ? all : "old");
        assert_int_equal(files_in(at->folder), before);
    }
    free(all);
}

/* Two files; in the second round the second path has become a folder, so that neither is replaced.
 */
static void several_are_in_place_together(void **state) {
    const place *at = *state;
    char other[4096];
    norma_document_error error;
    snprintf(other, sizeof other, "%s/other", at->folder);
    for (int fails = 0; fails < 2; ++fails) {
        norma_saving *both[2];
        const char *const text = fails ? "newer" : "new";
        assert_int_equal(norma_save_begin(at->target, &both[0], &error), NORMA_DOCUMENT_OK);
        assert_int_equal(norma_save_begin(other, &both[1], &error), NORMA_DOCUMENT_OK);
        for (int i = 0; i < 2; ++i)
            assert_int_equal(
                norma_save_piece(both[i], text, strlen(text), &error), NORMA_DOCUMENT_OK);
        if (fails) assert_int_equal(unlink(other) || mkdir(other, 0777), 0);
        assert_int_equal(norma_save_end_together(both, 2, &error),
            fails ? NORMA_DOCUMENT_ERROR_FILE : NORMA_DOCUMENT_OK);
        assert_holds(at->target, "new");
        if (!fails) assert_holds(other, "new");
    }
    assert_non_null(strstr(error.message, "other: cannot be written"));
    assert_int_equal(rmdir(other), 0);
}

#define TEST(function) cmocka_unit_test_setup_teardown(function, set_up, tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        TEST(saves_the_main_file_last),
        TEST(a_failure_anywhere_leaves_the_old_file),
        TEST(a_cancelled_save_leaves_the_old_file),
        TEST(names_that_may_not_be_written),
        TEST(in_place_may_name_the_source),
        TEST(a_device_gets_no_companions),
        TEST(options_are_checked_before_the_format_sees_them),
        TEST(options_of_another_version_are_read_as_far_as_they_go),
        TEST(after_a_failed_change_a_document_can_only_be_closed),
        TEST(summaries_and_what_was_not_read),
        TEST(matrices_are_affine_and_finite),
        TEST(a_message_is_one_line),
        TEST(a_message_is_cut_between_characters),
        TEST(notes_are_kept_in_order),
        TEST(opening_fails_with_words),
        TEST(formats_by_extension),
        TEST(reports_add_up),
        TEST(sizes_are_checked),
        TEST(pieces_are_in_place_at_the_end),
        TEST(several_are_in_place_together),
    };
    return cmocka_run_group_tests_name("documents, whatever their format", tests, NULL, NULL);
}
