/* fix_cases.c: files for fixes by hand.
 *   fix_cases FROM TO       makes and judges the files of these seeds
 *   fix_cases SEED --keep   and leaves the file in fix-SEED.obj (ply, stl, glb), its options said,
 * and says which rule's fix does harm alone */
#include "fix_files.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void keep(unsigned long long seed, const broken_file *b) {
    static const char *const ends[] = {"", "obj", "ply", "stl", "gltf", "glb"};
    char path[64];
    size_t rules;
    const norma_rule *rule = norma_rules(&rules);
    snprintf(path, sizeof path, "fix-%llu.%s", seed, ends[b->file.format]);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(b->file.bytes, 1, b->file.size, file) != b->file.size) abort();
    fclose(file);
    printf("%s: profile %d, %s%s", path, (int)b->options.profile, b->unsafe ? "unsafe" : "safe",
        b->options.open_by_rays ? ", open by rays" : "");
    for (size_t i = 0; i < rules && b->options.rules; ++i)
        if (b->rules[i]) printf(", %s", rule[i].id);
    printf("\n");
}

static void judge_alone(const broken_file *b) {
    size_t rules;
    uint8_t mask[128];
    const norma_rule *rule = norma_rules(&rules);
    for (size_t i = 0; i < rules; ++i) {
        norma_check_options options = b->options;
        memset(mask, 0, sizeof mask);
        mask[i] = 1;
        options.rules = mask;
        judge_fix(rule[i].id, b->file, &options, b->unsafe, NULL);
    }
}

int main(int count, char **words) {
    size_t wrong = 0, changed = 0;
    if (count != 3) return 2;
    const int keeps = !strcmp(words[2], "--keep");
    const unsigned long long from = strtoull(words[1], NULL, 10),
                             to = keeps ? from : strtoull(words[2], NULL, 10);
    for (unsigned long long seed = from; seed <= to; ++seed) {
        char name[40];
        broken_file b;
        broken_file_make(seed, &b);
        if (keeps) keep(seed, &b);
        snprintf(name, sizeof name, "seed %llu", seed);
        const fix_verdict v = judge_fix(name, b.file, &b.options, b.unsafe, NULL);
        if (keeps) judge_alone(&b);
        wrong += v.wrong != 0;
        changed += v.changed != 0;
        broken_file_free(&b);
        fflush(stdout);
    }
    printf("%zu of %llu files are worse after their fix; %zu were changed\n", wrong, to - from + 1,
        changed);
    return wrong != 0;
}
