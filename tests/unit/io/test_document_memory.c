/* test_document_memory.c: documents, checks and fixes without memory. Their interface takes no
 * allocator, so this program is linked with functions of its own in place of the C library's (ld's
 * --wrap, tests/CMakeLists.txt), which fail the n-th time, or from then on, for every n that there
 * is: each call then says that memory is out, or does what it always does, to the byte; nothing is
 * left behind, neither memory nor a file, and what stood there before stands there still. Saving
 * says so only where saving lacks memory, not where the change before it did, and can be called
 * again. */
#define _POSIX_C_SOURCE 200809L
#include "check.h"
#include "document_bytes.h"
#include "gltf_asset.h"
#include "io/gltf/gltf.h"
#include <dirent.h>
#include <errno.h>
#include <norma/check.h>
#include <norma/large.h>
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
    int is_on, from_there_on, again; /* again: what could not be saved is saved again */
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

enum { COMPUTED, TRANSFORMED, RECENTRED, MENDED, JOINED, KINDS };

typedef struct outcome {
    norma_document_result result;
    norma_document_error error;
    size_t findings;
    long save_from;       /* the allocations before saving */
    int changed, retried; /* the change said that it was made; saving again: it was, then */
} outcome;

static norma_document_result of_core(norma_result result) {
    return !result                        ? NORMA_DOCUMENT_OK
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
    case RECENTRED:
        return norma_document_recentre(d, NULL, NULL, &out->error);
    default:
        return mend(d, out);
    }
}

/* By itself a surface of which a part is locked. */
static outcome join(const char *from, const char *to) {
    const char *const lock[] = {"wa*"};
    const norma_together_file file = {.input = from, .output = to};
    const norma_together_options options = {.struct_size = sizeof options,
        .lock = lock,
        .lock_count = 1,
        .threads = 1,
        .in_place = !strcmp(from, to)};
    const norma_compute_options compute = {.struct_size = sizeof compute, .threads = 1};
    outcome out = {.result = NORMA_DOCUMENT_OK};
    out.result = norma_together_compute(&file, 1, &options, &compute, &out.error);
    return out;
}

static outcome run(const char *from, const char *to, int kind) {
    const norma_document_options options = {
        .struct_size = sizeof options, .threads = 1, .lenient = kind == MENDED};
    norma_document *document = NULL;
    outcome out = {.result = NORMA_DOCUMENT_OK};
    if (kind == JOINED) return join(from, to);
    out.result = norma_document_open(from, &options, &document, &out.error);
    if (!out.result) out.result = change(document, kind, &out);
    const norma_save_options save = {.struct_size = sizeof save, .in_place = !strcmp(from, to)};
    out.changed = !out.result;
    out.save_from = memory.calls;
    if (out.changed) out.result = norma_document_save(document, to, &save, &out.error);
    if (out.changed && out.result == NORMA_DOCUMENT_ERROR_MEMORY && memory.again) {
        memory.fail_at = 0;
        memory.from_there_on = 0;
        out.retried = norma_document_save(document, to, &save, NULL) == NORMA_DOCUMENT_OK;
    }
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

/* A file to be changed: one of the golden ones, or given, with those beside it, in the folder that
 * is written to. */
typedef struct source {
    const char *name;
    document_bytes files[3]; /* none: a golden one */
    const char *names[3];
} source;

static void write_files(const source *of) {
    for (int i = 0; i < 3 && of->names[i]; ++i) {
        char path[100];
        snprintf(path, sizeof path, "%s/%s", folder, of->names[i]);
        FILE *file = fopen(path, "wb");
        assert_non_null(file);
        assert_int_equal(fwrite(of->files[i].data, 1, of->files[i].size, file), of->files[i].size);
        assert_int_equal(fclose(file), 0);
    }
}

typedef struct trial {
    const source *of;
    char from[100], to[100];
    int kind;
    outcome whole;
    document_bytes before, expected; /* the folder, as it was, and without a failure */
} trial;

static int is_right(const trial *t, const outcome *out, document_bytes left, long n) {
    if (out->retried) return bytes_equal(left, t->expected);
    if (out->result == NORMA_DOCUMENT_OK)
        return out->findings == t->whole.findings && bytes_equal(left, t->expected);
    if (strstr(out->error.message, "the new file is in its place and complete"))
        return t->kind == JOINED && bytes_equal(left, t->expected); /* what is left is flushing */
    return out->result == NORMA_DOCUMENT_ERROR_MEMORY && bytes_equal(left, t->before) &&
           !(out->changed && (memory.again || (!memory.from_there_on && n <= out->save_from)));
}

/* The n-th run; 0: nothing failed, and it is the last. */
static int try_one(const trial *t, long n, int from_there_on) {
    write_files(t->of);
    memory.calls = memory.live = 0;
    memory.fail_at = n;
    memory.from_there_on = from_there_on;
    memory.is_on = 1;
    const outcome out = run(t->from, t->to, t->kind);
    memory.is_on = 0;
    document_bytes left = take_folder();
    if (!is_right(t, &out, left, n) || memory.live != 0) {
        print_error("%s, kind %d, allocation %ld%s: result %d (%s), %zu findings of %zu, %zu bytes "
                    "in the folder of %zu, saved from %ld on, %ld blocks not given back\n",
            t->from, t->kind, n, from_there_on ? " and all after it" : "", (int)out.result,
            out.error.message, out.findings, t->whole.findings, left.size, t->expected.size,
            out.save_from, memory.live);
        fail();
    }
    bytes_free(&left);
    return memory.calls >= n;
}

static size_t try_all(trial *t) {
    size_t runs = 0;
    write_files(t->of);
    t->before = take_folder();
    write_files(t->of);
    t->whole = run(t->from, t->to, t->kind);
    t->expected = take_folder();
    assert_int_equal(t->whole.result, NORMA_DOCUMENT_OK);
    assert_true(t->expected.size > 0);
    for (int way = 0; way < (t->kind == JOINED ? 2 : 3); ++way) {
        memory.again = way == 2;
        for (long n = way == 2 ? t->whole.save_from + 1 : 1; try_one(t, n, way == 1); ++n) ++runs;
    }
    bytes_free(&t->before);
    bytes_free(&t->expected);
    return runs;
}

/* ---- files */

#define ASSET "{\"asset\":{\"version\":\"2.0\"},"
#define DRAWN "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]"

/* Two buffers beside it. */
static source beside(void) {
    static const char text[] = ASSET DRAWN
        ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":2},\"indices\":1,"
        "\"material\":0}]}],\"materials\":[{\"name\":\"wall\"}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
        "\"min\":[0,0,0],\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5123,\"count\":3,"
        "\"type\":\"SCALAR\"},{\"bufferView\":0,\"byteOffset\":36,\"componentType\":5126,\"count\":"
        "3,"
        "\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":72,\"byteStride\":12},{"
        "\"buffer\":1,"
        "\"byteLength\":6}],\"buffers\":[{\"uri\":\"a.bin\",\"byteLength\":72},{\"uri\":"
        "\"b.bin\",\"byteLength\":6}]}";
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0};
    static const uint16_t corners[] = {0, 1, 2};
    return (source){"beside.gltf",
        {bytes_copy(text, sizeof text - 1), bytes_copy(positions, sizeof positions),
            bytes_copy(corners, sizeof corners)},
        {"beside.gltf", "a.bin", "b.bin"}};
}

static int packed_view(gltf_asset *a, const void *bytes, size_t size, gltf_meshopt m) {
    static const char *const modes[] = {"ATTRIBUTES", "TRIANGLES"};
    char members[300];
    unsigned char *packed = norma_gltf_encode_meshopt(&m, bytes);
    assert_non_null(packed);
    const size_t at = a->bin_size;
    asset_view(a, packed, m.length, "");
    free(packed);
    snprintf(members, sizeof members,
        ",\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":0,\"byteOffset\":%zu,"
        "\"byteLength\":%zu,\"byteStride\":%zu,\"count\":%zu,\"mode\":\"%s\"%s}}",
        at, m.length, m.stride, m.count, modes[m.mode],
        m.filter == GLTF_FILTER_EXPONENTIAL ? ",\"filter\":\"EXPONENTIAL\"" : "");
    return asset_view(a, bytes, size, members);
}

/* Compressed views, which the codecs and filters that they have can hold before and after. */
static source packed(void) {
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0},
                       normals[] = {0, 0, 1, 0, 0, 1, 0, 0, 1};
    static const uint16_t corners[] = {0, 1, 2};
    gltf_asset a = {0};
    char text[300];
    size_t size;
    for (int i = 0; i < 3; ++i) {
        const int view = packed_view(&a,
            i == 0   ? (const void *)positions
            : i == 1 ? (const void *)normals
                     : corners,
            i < 2 ? 36 : 6,
            i < 2 ? (gltf_meshopt){.stride = 12,
                        .count = 3,
                        .mode = GLTF_MODE_ATTRIBUTES,
                        .filter = GLTF_FILTER_EXPONENTIAL}
                  : (gltf_meshopt){.stride = 2, .count = 3, .mode = GLTF_MODE_TRIANGLES});
        snprintf(text, sizeof text,
            "{\"bufferView\":%d,\"componentType\":%d,\"count\":3,\"type\":\"%s\"%s}", view,
            i < 2 ? 5126 : 5123, i < 2 ? "VEC3" : "SCALAR",
            i ? "" : ",\"min\":[0,0,0],\"max\":[1,1,0]");
        asset_accessor(&a, text);
    }
    asset_bytes(&a,
        "\"extensionsUsed\":[\"EXT_meshopt_compression\"]," DRAWN
        ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":2}"
        "]}]",
        &size);
    const source made = {"packed.glb", {bytes_copy(a.glb, size)}, {"packed.glb"}};
    asset_free(&a);
    return made;
}

static void test_each_allocation(void **state) {
    source sources[] = {{.name = "cube.obj"}, {.name = "broken.obj"}, {.name = "groups.obj"},
        {.name = "roof.ply"}, {.name = "corner.stl"}, {.name = "roof.gltf"}, {.name = "roof.glb"},
        beside(), packed()};
    size_t runs = 0;
    (void)state;
    assert_non_null(mkdtemp(folder));
    for (size_t i = 0; i < COUNT_OF(sources); ++i)
        for (int kind = 0; kind < KINDS; ++kind) {
            trial t = {.of = &sources[i], .kind = kind};
            const char *name = sources[i].name;
            if (kind == JOINED && strstr(name, ".stl")) continue;
            snprintf(t.to, sizeof t.to, "%s/%s%s", folder, sources[i].names[0] ? "" : "out",
                sources[i].names[0] ? name : strrchr(name, '.'));
            if (sources[i].names[0])
                strcpy(t.from, t.to);
            else
                snprintf(t.from, sizeof t.from, "tests/cli/golden/files/%s", name);
            runs += try_all(&t);
        }
    for (size_t i = 0; i < COUNT_OF(sources); ++i)
        for (int k = 0; k < 3; ++k) bytes_free(&sources[i].files[k]);
    assert_int_equal(rmdir(folder), 0);
    print_message("%zu failed allocations\n", runs);
    assert_true(runs > 1000);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_each_allocation)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
