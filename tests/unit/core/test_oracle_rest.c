/* test_oracle_rest.c: as test_oracle, the meshes that it leaves: up to 200,000. A file of its own,
 * so that two processors share them. */
#include "check.h"
#include "oracle/net.h"

static void seeds(void **state) {
    (void)state;
    assert_int_equal(net_judge_seeds(50000 / SLOWER + 1, 200000 / SLOWER), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(seeds)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
