/* test_check_again.c: what a check takes over from an earlier one of another document is what it
 * would find itself: files with something wrong are fixed, and checked both ways. */
#include "check.h"
#include "fix_files.h"
#include "check/rules/rules.h"

enum { SEEDS = 1000 / SLOWER };

static norma_document *opened(const broken_file *broken) {
    const norma_document_options options = {
        .struct_size = sizeof options, .lenient = 1, .format = broken->file.format};
    norma_document *document;
    if (norma_document_open_memory(
            broken->file.bytes, broken->file.size, NULL, &options, &document, NULL))
        return NULL;
    return document;
}

/* Every element of every rule. known: NULL, or that of another document. */
static norma_findings *all_of(
    norma_document *document, const check_known *known, norma_check_profile profile) {
    const norma_check_options all = {
        .struct_size = sizeof all, .max_samples = SIZE_MAX, .profile = profile};
    norma_findings *findings;
    assert_int_equal(norma_check_again(document, known, &all, &findings, NULL), NORMA_DOCUMENT_OK);
    return findings;
}

static int is_same_sample(const norma_sample *a, const norma_sample *b) {
    return a->vertex == b->vertex && a->face == b->face && a->normal == b->normal &&
           a->has_position == b->has_position &&
           !memcmp(a->position, b->position, sizeof a->position);
}

static int is_same_finding(const norma_finding *a, const norma_finding *b) {
    int same = a->rule == b->rule && a->severity == b->severity && a->fix == b->fix &&
               a->count == b->count && a->sample_count == b->sample_count &&
               !strcmp(a->where, b->where) && !strcmp(a->message, b->message);
    for (size_t i = 0; same && i < a->sample_count; ++i)
        same = is_same_sample(&a->samples[i], &b->samples[i]);
    return same;
}

static size_t count_differences(const norma_findings *a, const norma_findings *b, uint64_t seed) {
    const size_t count = norma_findings_count(a);
    size_t differ = count != norma_findings_count(b);
    for (size_t i = 0; !differ && i < count; ++i) {
        const norma_finding *is = norma_findings_get(a, i), *was = norma_findings_get(b, i);
        if (is_same_finding(is, was)) continue;
        printf("# seed %llu: %s %s\n#   %s\n", (unsigned long long)seed, is->rule->id, is->message,
            was->message);
        differ = 1;
    }
    return differ;
}

/* Every rule looks at the file again with a judge that is kept; then at what it became. */
static size_t judge_again(
    norma_document *before, norma_document *after, norma_check_profile profile, uint64_t seed) {
    uint8_t all[CHECK_RULE_COUNT];
    const size_t meshes = norma_document_mesh_count(before);
    check_judge *judges = calloc(meshes + 1, sizeof *judges);
    norma_findings *was = all_of(before, NULL, profile), *is = all_of(after, NULL, profile);
    memset(all, 1, sizeof all);
    const check_known same = {before, was, all, judges, 0}, known = {before, was, NULL, judges, 0};
    norma_findings *again[] = {all_of(before, &same, profile), all_of(after, &known, profile),
        all_of(before, &same, profile)};
    const size_t differ = count_differences(was, again[0], seed) +
                          count_differences(is, again[1], seed) +
                          count_differences(was, again[2], seed);
    for (size_t i = 0; i < COUNT_OF(again); ++i) norma_findings_free(again[i]);
    for (size_t i = 0; i < meshes; ++i) norma_check_close_judge(&judges[i]);
    free(judges);
    norma_findings_free(is);
    norma_findings_free(was);
    return differ;
}

static void what_is_known_is_what_is_found(void **state) {
    (void)state;
    size_t changed = 0, differ = 0;
    for (uint64_t seed = 1; seed <= SEEDS; ++seed) {
        broken_file broken;
        norma_fix_summary summary = {0};
        broken_file_make(seed, &broken);
        norma_document *before = opened(&broken), *after = opened(&broken);
        if (before && after &&
            !norma_fix_document(after, &broken.options, broken.unsafe, &summary, NULL) &&
            summary.changed) {
            differ += judge_again(before, after, broken.options.profile, seed);
            ++changed;
        }
        norma_document_close(before);
        norma_document_close(after);
        broken_file_free(&broken);
    }
    printf("# %zu of %d files were changed\n", changed, (int)SEEDS);
    assert_int_equal(differ, 0);
    assert_true(changed > SEEDS / 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_known_is_what_is_found)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
