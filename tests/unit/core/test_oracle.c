/* test_oracle.c: small meshes made without taste, each through everything public of the core,
 * against the definitions (tests/support/oracle/net.h): the first quarter of 200,000, of which
 * test_oracle_rest has the others; and every mesh that ever failed (tests/fuzz/found/oracle). */
#include "check.h"
#include "oracle/net.h"
#include <dirent.h>

static void seeds(void **state) {
    (void)state;
    assert_int_equal(net_judge_seeds(1, 50000 / SLOWER), 0);
}

static void found(void **state) {
    (void)state;
    static const char folder[] = "tests/fuzz/found/oracle";
    static made_case made;
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
