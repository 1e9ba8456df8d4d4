/* test_oracle.c: 200,000 small meshes made without taste, each through everything public of the
 * core, against the definitions (tests/support/oracle/net.h); and every mesh that ever failed
 * (tests/fuzz/found/oracle). A seed that fails prints its case; the tool oracle_cases makes it
 * smaller. */
#include "check.h"
#include "oracle/guarded.h"
#include "oracle/net.h"
#include <dirent.h>

enum { SEEDS = 200000 / SLOWER, MOST_WRONG = 20 };

static made_case made;

static void print_case(void) {
    made_case_print(&made, stdout);
    fflush(stdout);
}

static void seeds(void **state) {
    (void)state;
    size_t wrong = 0;
    guarded_on_crash(print_case);
    for (uint64_t seed = 1; seed <= SEEDS && wrong < MOST_WRONG; ++seed) {
        char name[40];
        snprintf(name, sizeof name, "seed %llu", (unsigned long long)seed);
        made_case_of_seed(&made, seed);
        const size_t here = net_judge(name, &made);
        if (here && !wrong) print_case();
        wrong += here;
    }
    assert_int_equal(wrong, 0);
}

static void found(void **state) {
    (void)state;
    static const char folder[] = "tests/fuzz/found/oracle";
    size_t wrong = 0, count = 0;
    DIR *all = opendir(folder);
    for (const struct dirent *entry; all && (entry = readdir(all));) {
        char name[600];
        if (entry->d_name[0] == '.') continue;
        snprintf(name, sizeof name, "%s/%s", folder, entry->d_name);
        wrong += made_case_load(&made, name) ? net_judge(entry->d_name, &made) : 1;
        ++count;
    }
    if (all) closedir(all);
    assert_int_equal(wrong, 0);
    assert_true(count > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(found), cmocka_unit_test(seeds)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
