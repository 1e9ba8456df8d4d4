/* test_document_memory.c: documents, checks and fixes without memory. Their interface takes no
 * allocator, so this program is linked with functions of its own in place of the C library's (ld's
 * --wrap, tests/CMakeLists.txt), which fail the n-th time, or from then on, for every n that there
 * is: each call then says that memory is out, or does what it always does; nothing is left behind,
 * neither memory nor a file. */
#define _POSIX_C_SOURCE 200809L
#include "check.h"
#include "document_bytes.h"
#include <dirent.h>
#include <errno.h>
#include <norma/check.h>
#include <unistd.h>

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *block, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
char *__real_realpath(const char *path, char *resolved);
void __real_free(void *block);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *block, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
char *__wrap_realpath(const char *path, char *resolved);
void __wrap_free(void *block);

static struct {
    int is_on, from_there_on;
    long calls, fail_at, live;
} memory;

static int fails(void) {
    if (!memory.is_on) return 0;
    const long call = ++memory.calls;
    const int failed = call == memory.fail_at || (memory.from_there_on && call > memory.fail_at);
    if (failed) errno = ENOMEM;
    return failed;
}

static void *counted(void *block) {
    memory.live += memory.is_on && block;
    return block;
}

void *__wrap_malloc(size_t size) { return fails() ? NULL : counted(__real_malloc(size)); }
void *__wrap_calloc(size_t count, size_t size) {
    return fails() ? NULL : counted(__real_calloc(count, size));
}
void *__wrap_aligned_alloc(size_t alignment, size_t size) {
    return fails() ? NULL : counted(__real_aligned_alloc(alignment, size));
}
char *__wrap_realpath(const char *path, char *resolved) {
    return fails() ? NULL : counted(__real_realpath(path, resolved));
}

void *__wrap_realloc(void *block, size_t size) {
    if (fails()) return NULL;
    return block ? __real_realloc(block, size) : counted(__real_realloc(NULL, size));
}

void __wrap_free(void *block) {
    memory.live -= memory.is_on && block;
    __real_free(block);
}

/* ---- what is done */

enum { COMPUTED, TRANSFORMED, MENDED, KINDS };

typedef struct outcome {
    norma_document_result result;
    norma_document_error error;
    size_t findings;
} outcome;

static norma_document_result of_core(norma_result result) {
    return result == NORMA_OK             ? NORMA_DOCUMENT_OK
           : result == NORMA_ERROR_MEMORY ? NORMA_DOCUMENT_ERROR_MEMORY
                                          : NORMA_DOCUMENT_ERROR_ARGUMENT;
}

/* All that it tells; what cannot be told for want of memory is passed over by the next call. */
static norma_document_result read_all(norma_document *d, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; !result && i < norma_document_mesh_count(d); ++i) {
        norma_mesh_info info;
        norma_mesh_data data;
        norma_mesh_attributes attributes;
        norma_deviation deviation;
        result = norma_document_mesh_info(d, i, &info);
        if (!result) result = norma_document_mesh_data(d, i, &data, error);
        if (!result) result = norma_document_mesh_attributes(d, i, &attributes, error);
        if (!result)
            result = of_core(norma_explain_normals(&data, info.normals,
                &(norma_options){.struct_size = sizeof(norma_options), .threads = 1}, &deviation));
    }
    for (size_t i = 0; !result && i < norma_document_node_count(d); ++i) {
        norma_node_info node;
        double world[16];
        result = norma_document_node_info(d, i, &node);
        if (!result) result = norma_document_instance_world(d, i, 0, world, error);
    }
    for (size_t i = 0; !result && i < norma_document_material_count(d); ++i) {
        norma_material_info material;
        result = norma_document_material_info(d, i, &material);
    }
    (void)norma_document_unread_count(d);
    return result;
}

static norma_document_result mend(norma_document *d, outcome *out) {
    static const norma_check_options options = {.struct_size = sizeof options, .threads = 1};
    norma_findings *findings = NULL;
    norma_fix_summary summary;
    norma_document_result result = norma_check_document(d, &options, &findings, &out->error);
    out->findings = result ? 0 : norma_findings_count(findings);
    norma_findings_free(findings);
    return result ? result : norma_fix_document(d, &options, 1, &summary, &out->error);
}

static norma_document_result change(norma_document *d, int kind, outcome *out) {
    const norma_compute_options compute = {.struct_size = sizeof compute, .threads = 1};
    const norma_transform_options transform = {.struct_size = sizeof transform,
        .matrix = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1},
        .bake = 1,
        .threads = 1};
    norma_document_result result;
    switch (kind) {
    case COMPUTED:
        result = read_all(d, &out->error);
        return result ? result : norma_document_compute(d, &compute, NULL, &out->error);
    case TRANSFORMED:
        return norma_document_transform(d, &transform, NULL, &out->error);
    default:
        return mend(d, out);
    }
}

static outcome run(const char *from, const char *to, int kind) {
    const norma_document_options options = {
        .struct_size = sizeof options, .threads = 1, .lenient = kind == MENDED};
    norma_document *document = NULL;
    outcome out = {.result = NORMA_DOCUMENT_OK};
    out.result = norma_document_open(from, &options, &document, &out.error);
    if (!out.result) out.result = change(document, kind, &out);
    if (!out.result) out.result = norma_document_save(document, to, NULL, &out.error);
    norma_document_close(document);
    return out;
}

/* ---- what it leaves */

static char folder[64] = "/tmp/norma-memory-XXXXXX";

/* Everything in the folder, by name; then it is empty. */
static document_bytes take_folder(void) {
    struct dirent **entries;
    document_bytes all = {calloc(1, 1), 0};
    const int count = scandir(folder, &entries, NULL, alphasort);
    assert_true(count >= 2);
    for (int i = 0; i < count; ++i) {
        char path[400];
        snprintf(path, sizeof path, "%s/%s", folder, entries[i]->d_name);
        if (strcmp(entries[i]->d_name, ".") != 0 && strcmp(entries[i]->d_name, "..") != 0) {
            document_bytes bytes = bytes_load(path);
            all.data = realloc(all.data, all.size + strlen(path) + bytes.size + 1);
            assert_non_null(all.data);
            memcpy(all.data + all.size, path, strlen(path));
            memcpy(all.data + all.size + strlen(path), bytes.data, bytes.size);
            all.size += strlen(path) + bytes.size;
            bytes_free(&bytes);
            assert_int_equal(unlink(path), 0);
        }
        free(entries[i]);
    }
    free(entries);
    return all;
}

/* The n-th run; 0: nothing failed, and it is the last. */
static int try_one(const char *from, const char *to, int kind, long n, const outcome *whole,
    document_bytes expected) {
    memory.calls = memory.live = 0;
    memory.fail_at = n;
    memory.is_on = 1;
    outcome out = run(from, to, kind);
    memory.is_on = 0;
    document_bytes left = take_folder();
    const int same = out.result == NORMA_DOCUMENT_OK && out.findings == whole->findings &&
                     bytes_equal(left, expected);
    const int told = out.result == NORMA_DOCUMENT_ERROR_MEMORY && left.size == 0;
    if ((!same && !told) || memory.live != 0) {
        print_error("%s, kind %d, allocation %ld%s: result %d (%s), %zu findings of %zu, %zu bytes "
                    "in the folder of %zu, %ld blocks not given back\n",
            from, kind, n, memory.from_there_on ? " and all after it" : "", (int)out.result,
            out.error.message, out.findings, whole->findings, left.size, expected.size,
            memory.live);
        fail();
    }
    bytes_free(&left);
    return memory.calls >= n;
}

static void test_each_allocation(void **state) {
    static const char *const files[] = {
        "cube.obj", "broken.obj", "groups.obj", "roof.ply", "corner.stl", "roof.gltf", "roof.glb"};
    size_t runs = 0;
    (void)state;
    assert_non_null(mkdtemp(folder));
    for (size_t i = 0; i < COUNT_OF(files); ++i)
        for (int kind = 0; kind < KINDS; ++kind) {
            char from[100], to[100];
            snprintf(from, sizeof from, "tests/cli/golden/files/%s", files[i]);
            snprintf(to, sizeof to, "%s/out%s", folder, strrchr(files[i], '.'));
            const outcome whole = run(from, to, kind);
            document_bytes expected = take_folder();
            assert_int_equal(whole.result, NORMA_DOCUMENT_OK);
            assert_true(expected.size > 0);
            for (memory.from_there_on = 0; memory.from_there_on < 2; ++memory.from_there_on)
                for (long n = 1; try_one(from, to, kind, n, &whole, expected); ++n) ++runs;
            bytes_free(&expected);
        }
    assert_int_equal(rmdir(folder), 0);
    print_message("%zu failed allocations\n", runs);
    assert_true(runs > 1000);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_each_allocation)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
