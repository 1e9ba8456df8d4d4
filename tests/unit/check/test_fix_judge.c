/* test_fix_judge.c: whatever a fix writes, over small files made on the spot, over what was ever
 * found (tests/fuzz/found/fix) and over small files of the data set, is judged by a second, naive
 * reading of what a fix may never do (fix_judge.h). */
#include "check.h"
#include "fix_files.h"
#include "mesh_files.h"

enum { SEEDS = 3000 / SLOWER, MOST_BYTES = 12000 / (SLOWER > 1 ? 4 : 1), MOST_WRONG = 12 };

static void made_files(void **state) {
    (void)state;
    size_t wrong = 0, changed = 0;
    for (uint64_t seed = 1; seed <= SEEDS && wrong < MOST_WRONG; ++seed) {
        char name[40];
        broken_file broken;
        snprintf(name, sizeof name, "seed %llu", (unsigned long long)seed);
        broken_file_make(seed, &broken);
        const fix_verdict v = judge_fix(name, broken.file, &broken.options, broken.unsafe, NULL);
        wrong += v.wrong != 0;
        changed += v.changed != 0;
        broken_file_free(&broken);
    }
    printf("# %zu of %d files were changed\n", changed, (int)SEEDS);
    assert_int_equal(wrong, 0);
    assert_true(changed > SEEDS / 5);
}

typedef struct data_run {
    size_t files, changed, wrong;
} data_run;

static norma_file_format format_of(const char *path) {
    static const char *const ends[] = {".obj", ".ply", ".stl", ".gltf", ".glb"};
    static const norma_file_format formats[] = {
        NORMA_FILE_OBJ, NORMA_FILE_PLY, NORMA_FILE_STL, NORMA_FILE_GLTF, NORMA_FILE_GLB};
    for (size_t i = 0; i < COUNT_OF(ends); ++i)
        if (strlen(path) > 5 && !strcmp(path + strlen(path) - strlen(ends[i]), ends[i]))
            return formats[i];
    return NORMA_FILE_UNKNOWN;
}

static void judge_file(void *user, const char *path, const char *name) {
    data_run *run = user;
    static char bytes[MOST_BYTES + 1];
    const norma_file_format format = format_of(path);
    FILE *file = format == NORMA_FILE_UNKNOWN ? NULL : fopen(path, "rb");
    if (!file) return;
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    if (size == sizeof bytes) return;
    ++run->files;
    uint64_t state = run->files;
    for (int i = 0; i < 3; ++i) {
        broken_file b;
        broken_file_options(&state, &b);
        const fix_verdict v =
            judge_fix(name, (fix_file){bytes, size, format}, &b.options, b.unsafe, NULL);
        run->changed += v.changed != 0;
        run->wrong += v.wrong != 0;
    }
}

static void data_files(void **state) {
    (void)state;
    data_run run = {0};
    if (!data_folder()) skip();
    data_for_each(data_folder(), judge_file, &run);
    printf("# %zu files, %zu of three fixes each changed them\n", run.files, run.changed);
    assert_int_equal(run.wrong, 0);
    assert_true(run.files > 50);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(made_files), cmocka_unit_test(data_files)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
