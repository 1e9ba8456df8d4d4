/* test_number.c: decimal text against the C library's own strtod and strtof under the C locale,
 * which glibc documents as correctly rounded. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#include "io/text/text.h"

static uint64_t random_state = 88172645463325252u;

static uint64_t next_random(void) {
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return random_state;
}

static uint64_t bits_of(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static void check_parse(const char *text) {
    char *expected_end;
    double expected = strtod(text, &expected_end);
    double value = -1;
    const char *end = norma_number_parse(text, text + strlen(text), &value);
    if (end != expected_end || bits_of(value) != bits_of(expected))
        fail_msg("%s: read as %a up to byte %td, expected %a up to %td", text, value,
            end ? end - text : -1, expected, expected_end - text);
}

static void random_doubles_in_any_precision(void **state) {
    char text[512];
    (void)state;
    for (int i = 0; i < 400000; ++i) {
        uint64_t bits = next_random();
        double value;
        memcpy(&value, &bits, sizeof value);
        if (!isfinite(value)) continue;
        snprintf(text, sizeof text, "%.*e", (int)(next_random() % 22), value);
        check_parse(text);
    }
}

static void random_coordinates(void **state) {
    char text[512];
    (void)state;
    for (int i = 0; i < 2000000; ++i) {
        double value =
            ldexp((double)(int64_t)next_random(), -63) * pow(10, (double)(next_random() % 12) - 5);
        snprintf(text, sizeof text, "%.*f", (int)(next_random() % 20), value);
        check_parse(text);
    }
}

static void random_digits(void **state) {
    char text[512];
    (void)state;
    for (int i = 0; i < 500000; ++i) {
        int length = 1 + (int)(next_random() % 40);
        int point = (int)(next_random() % 42);
        char *p = text;
        for (int k = 0; k < length; ++k) {
            if (k == point) *p++ = '.';
            *p++ = (char)('0' + next_random() % 10);
        }
        snprintf(p, 32, "e%d", (int)(next_random() % 700) - 350);
        check_parse(text);
    }
}

/* The exact middle between two doubles, and the same with a digit more at its end. */
static void halves(void **state) {
    static char text[2048];
    (void)state;
    for (int i = 0; i < 5000; ++i) {
        uint64_t bits = next_random() & (UINT64_MAX >> 1);
        if (i % 4 == 0) bits &= (UINT64_C(1) << 53) - 1;
        double value;
        memcpy(&value, &bits, sizeof value);
        if (!isfinite(value) || value > 1e300) continue;
        double next = nextafter(value, INFINITY);
        /* glibc prints a long double exactly; its 64 bits hold the middle of two doubles. */
        long double middle = ((long double)value + (long double)next) / 2;
        int length = snprintf(text, sizeof text, "%.1100Le", middle);
        check_parse(text);
        char *e = strchr(text, 'e');
        char exponent[32];
        snprintf(exponent, sizeof exponent, "%s", e);
        snprintf(e, sizeof text - (size_t)length, "00001%s", exponent);
        check_parse(text);
    }
}

static void named_cases(void **state) {
    static const char *const cases[] = {"0", "-0", "+0.0", "1", "-1", "+1.5", ".5", "-.5", "5.",
        "1e5", "1E-5", "1e+05", "1e", "1e+", "1e-x", "1.5.5", "00012", "000.00012",
        "9007199254740992", "9007199254740993", "9007199254740994", "9007199254740995",
        "18446744073709551615", "18446744073709551616", "2.2250738585072011e-308",
        "2.2250738585072012e-308", "2.2250738585072014e-308", "4.9406564584124654e-324",
        "2.4703282292062327e-324", "2.4703282292062328e-324", "2.470328229206232720e-324",
        "1.7976931348623157e308", "1.7976931348623158e308", "1.7976931348623159e308", "1.8e308",
        "1e309", "1e-400", "1e999999999999999999999", "1e-999999999999999999999", "0e999999999999",
        "123456789012345678901234567890", "1e23", "8.5e22", "1e22",
        "0.000000000000000000000000000000000000000000000000000000000000000000001",
        "6.631236846766476e-316", "3.2378839133029012e-319", "1.00000000000000011102230246251565",
        "1.00000000000000011102230246251566", "inf", "-inf", "INF", "Infinity", "-iNfInItY",
        "infinit", "1e-5e", "3.14159 2", "7,5", "1/2"};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) check_parse(cases[i]);
}

static void very_long_numbers(void **state) {
    enum { LENGTH = 100000 };
    char *text = malloc(LENGTH + 32);
    (void)state;
    assert_non_null(text);
    memset(text, '0', LENGTH);
    memcpy(text, "0.", 2);
    snprintf(text + LENGTH, 32, "12345e%d", LENGTH);
    check_parse(text);
    memset(text, '7', LENGTH);
    snprintf(text + LENGTH, 32, "e-%d", LENGTH + 3);
    check_parse(text);
    memset(text, '0', LENGTH);
    memcpy(text, "9007199254740993", 16);
    snprintf(text + LENGTH, 32, "1e-%d", LENGTH - 15);
    check_parse(text);
    free(text);
}

static void what_is_no_number(void **state) {
    static const char *const cases[] = {
        "", "+", "-", ".", "-.", "e5", "x", "na", "--1", "+-1", " 1", ".e5", "in", "#INF", ".#INF"};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        double value = 42;
        assert_null(norma_number_parse(cases[i], cases[i] + strlen(cases[i]), &value));
        assert_true(value == 42);
    }
}

static void not_finite(void **state) {
    static const struct {
        const char *text;
        int length, negative, infinite;
    } cases[] = {{"nan", 3, 0, 0}, {"-NaN", 4, 1, 0}, {"NAN(1)", 3, 0, 0}, {"1.#INF", 6, 0, 1},
        {"-1.#INF", 7, 1, 1}, {"1.#INF00", 8, 0, 1}, {"-1.#IND", 7, 1, 0}, {"1.#QNAN0 1", 8, 0, 0},
        {"1.#QNAN", 7, 0, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        double value = 42;
        const char *end =
            norma_number_parse(cases[i].text, cases[i].text + strlen(cases[i].text), &value);
        assert_ptr_equal(end, cases[i].text + cases[i].length);
        assert_true(cases[i].infinite ? isinf(value) : isnan(value));
        assert_int_equal(signbit(value) != 0, cases[i].negative);
    }
}

/* Nothing at or past end is looked at: the number is cut where the buffer is. */
static void the_end_is_respected(void **state) {
    static const char text[] = "-123.456e-12";
    (void)state;
    for (size_t length = 0; length < sizeof text; ++length) {
        char *block = malloc(length ? length : 1);
        char copy[sizeof text] = {0};
        double value = 0;
        assert_non_null(block);
        memcpy(block, text, length);
        memcpy(copy, text, length);
        const char *end = norma_number_parse(block, block + length, &value);
        char *expected_end;
        double expected = strtod(copy, &expected_end);
        assert_int_equal(end ? end - block : 0, expected_end - copy);
        assert_true(value == expected);
        free(block);
    }
}

static void integers(void **state) {
    static const struct {
        const char *text;
        int length;
        int64_t value;
    } cases[] = {{"0", 1, 0}, {"-0", 2, 0}, {"+7", 2, 7}, {"0012x", 4, 12},
        {"9223372036854775807", 19, INT64_MAX}, {"-9223372036854775808", 20, INT64_MIN},
        {"1/2", 1, 1}, {"3.5", 1, 3}, {"9223372036854775808", 0, 0}, {"-9223372036854775809", 0, 0},
        {"99999999999999999999", 0, 0}, {"", 0, 0}, {"-", 0, 0}, {"x", 0, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        int64_t value = 42;
        const char *end = norma_number_parse_integer(
            cases[i].text, cases[i].text + strlen(cases[i].text), &value);
        assert_ptr_equal(end, cases[i].length ? cases[i].text + cases[i].length : NULL);
        assert_true(value == (cases[i].length ? cases[i].value : 42));
    }
}

static int significant_digits(const char *text) {
    int count = 0, zeros = 0;
    for (; *text && *text != 'e'; ++text) {
        if (*text < '0' || *text > '9' || (*text == '0' && !count)) continue;
        zeros = *text == '0' ? zeros + 1 : 0;
        ++count;
    }
    return count - zeros;
}

static void check_double(double value) {
    char text[32], shorter[64];
    size_t length = norma_number_format_double(value, text);
    assert_int_equal(length, strlen(text));
    if (bits_of(strtod(text, NULL)) != bits_of(value))
        fail_msg("%.17g was written %s", value, text);
    int digits = significant_digits(text);
    snprintf(shorter, sizeof shorter, "%.*e", digits > 1 ? digits - 2 : 0, value);
    if (digits > 1 && strtod(shorter, NULL) == value)
        fail_msg("%.17g was written %s, while %s is shorter", value, text, shorter);
}

static void check_float(float value) {
    char text[32], shorter[64];
    size_t length = norma_number_format_float(value, text);
    assert_int_equal(length, strlen(text));
    if (strtof(text, NULL) != value || (float)strtod(text, NULL) != value)
        fail_msg("%.9g was written %s", (double)value, text);
    int digits = significant_digits(text);
    snprintf(shorter, sizeof shorter, "%.*e", digits > 1 ? digits - 2 : 0, (double)value);
    if (digits > 1 && strtof(shorter, NULL) == value &&
        (float)nextafter(strtod(shorter, NULL), 0) == value &&
        (float)nextafter(strtod(shorter, NULL), 2 * (double)value) == value)
        fail_msg("%.9g was written %s, while %s is shorter", (double)value, text, shorter);
}

static void doubles_return(void **state) {
    static const double cases[] = {1, 0.1, 1e22, 1e23, 5e-324, 1.7976931348623157e308,
        2.2250738585072014e-308, 9007199254740993.0, 123456789, 1e16, 1e17, 1e-4, 1e-5, 0.3};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) check_double(cases[i]);
    for (int e = -1074; e < 1024; ++e) check_double(ldexp(1, e));
    for (int i = 0; i < 100000; ++i) {
        uint64_t bits = next_random();
        double value;
        memcpy(&value, &bits, sizeof value);
        if (isfinite(value) && i % 8 == 0) check_double(value);
        check_double(
            ldexp((double)(int64_t)next_random(), -63) * pow(10, (double)(next_random() % 12) - 5));
        check_double((double)(int64_t)(next_random() % 2000000000) / 1e6 - 1000);
    }
}

static void floats_return(void **state) {
    (void)state;
    for (int e = -149; e < 128; ++e) check_float(ldexpf(1, e));
    for (int i = 0; i < 300000; ++i) {
        uint32_t bits = (uint32_t)next_random();
        float value;
        memcpy(&value, &bits, sizeof value);
        if (isfinite(value) && i % 8 == 0) check_float(value);
        check_float((float)ldexp((double)(int64_t)next_random(), -60));
    }
}

static void written_forms(void **state) {
    static const struct {
        double value;
        const char *text;
    } cases[] = {{0, "0"}, {-0.0, "-0"}, {1, "1"}, {-1.5, "-1.5"}, {0.001, "0.001"},
        {1e-5, "0.00001"}, {1e-6, "1e-6"}, {1.25e-7, "1.25e-7"}, {100, "100"},
        {1e15, "1000000000000000"}, {1e16, "1e+16"}, {1.5e300, "1.5e+300"}, {123.456, "123.456"},
        {(double)INFINITY, "inf"}, {-(double)INFINITY, "-inf"}, {(double)NAN, "nan"},
        {5e-324, "5e-324"}};
    char text[32];
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        norma_number_format_double(cases[i].value, text);
        assert_string_equal(text, cases[i].text);
    }
    norma_number_format_float(0.1f, text);
    assert_string_equal(text, "0.1");
    norma_number_format_float(-16777216.0f, text);
    assert_string_equal(text, "-16777216");
    /* 67108900 is in the middle between two floats: read to even, it is this one by chance. */
    norma_number_format_float(67108896.0f, text);
    assert_string_equal(text, "67108896");
}

static void normals_are_near(void **state) {
    static const struct {
        float value;
        const char *text;
    } cases[] = {{0, "0"}, {-0.0f, "0"}, {1, "1"}, {-1, "-1"}, {0.5f, "0.5"}, {-0.25f, "-0.25"},
        {1e-9f, "0"}, {-1e-9f, "0"}, {2e-8f, "0.00000002"}, {0.99999994f, "0.99999994"}};
    char text[32];
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        size_t length = norma_number_format_normal(cases[i].value, text);
        assert_int_equal(length, strlen(text));
        assert_string_equal(text, cases[i].text);
    }
    for (int i = 0; i < 1000000; ++i) {
        float value = (float)ldexp((double)(int64_t)next_random(), -63);
        norma_number_format_normal(value, text);
        if (fabs(strtod(text, NULL) - (double)value) > 5.0001e-9)
            fail_msg("%.9g was written %s", (double)value, text);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(named_cases),
        cmocka_unit_test(random_coordinates), cmocka_unit_test(random_doubles_in_any_precision),
        cmocka_unit_test(random_digits), cmocka_unit_test(halves),
        cmocka_unit_test(very_long_numbers), cmocka_unit_test(what_is_no_number),
        cmocka_unit_test(not_finite), cmocka_unit_test(the_end_is_respected),
        cmocka_unit_test(integers), cmocka_unit_test(doubles_return),
        cmocka_unit_test(floats_return), cmocka_unit_test(written_forms),
        cmocka_unit_test(normals_are_near)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
