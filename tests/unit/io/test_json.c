/* test_json.c: what is JSON and what is not, and that an edited text keeps every byte that no edit
 * is about. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>
#include "io/text/text.h"

static int parses(const char *text) {
    json j;
    json_error error;
    int ok = norma_json_parse(text, strlen(text), NULL, &j, &error);
    norma_json_free(&j);
    return ok;
}

static void accepts_what_the_rfc_allows(void **state) {
    static const char *const good[] = {"{}", "[]", " [1] ", "0", "-0", "-0.5e+10", "1E5", "\"\"",
        "true", "null", "[[[]],{\"a\":{}}]", "{\"a\":1,\"a\":2}", "\"\\u00e4\\n\\/\\\"\"",
        "\"\xc3\xa4\"", "\t\r\n[ 1 , 2 ]\n", "[1.0,10e-1]"};
    (void)state;
    for (size_t i = 0; i < sizeof good / sizeof *good; ++i) {
        if (!parses(good[i])) fail_msg("refused: %s", good[i]);
    }
}

static void refuses_what_it_does_not(void **state) {
    static const char *const bad[] = {"", " ", "{", "}", "[", "[1", "[1,]", "[,1]", "[1 2]",
        "{\"a\"}", "{\"a\" 1}", "{\"a\":}", "{\"a\":1,}", "{a:1}", "{1:2}", "[1]]", "[1] 2", "01",
        "+1", ".5", "1.", "1e", "1e+", "-", "0x1", "tru", "truex", "nul", "NaN", "Infinity", "\"a",
        "\"\\x\"", "\"\\u12g4\"", "\"a\nb\"", "'a'", "[1}", "{\"a\":1]", "// x\n1", "\"\xff\"",
        "\"\xc0\x80\"", "\"\xed\xa0\x80\"", "\xef\xbb\xbf{}", "[1,,2]", "{\"a\":1:2}", "{\"a\",1}",
        "[\"a\":1]"};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i) {
        if (parses(bad[i])) fail_msg("accepted: %s", bad[i]);
    }
}

static void nesting_is_bounded(void **state) {
    static char text[100001];
    (void)state;
    for (size_t depth = 256; depth <= 50000; depth += 49744) {
        memset(text, '[', depth);
        memset(text + depth, ']', depth);
        text[2 * depth] = '\0';
        assert_int_equal(parses(text), depth == 256);
    }
}

static void values_are_found_and_read(void **state) {
    const char *text =
        "{\"a\":[10, 1.0, 10e-1, -1, 1.5, "
        "9007199254740993000],\"n\\u0061me\":\"\\u00e4\\ud83d\\ude00\\t\",\"a\":[7],\"t\":true}";
    json j;
    json_error error;
    uint64_t value = 0;
    (void)state;
    assert_true(norma_json_parse(text, strlen(text), NULL, &j, &error));
    assert_int_equal(norma_json_size(&j, 0), 4);
    uint32_t a = norma_json_member(&j, 0, "a"); /* the last one of that name counts */
    assert_int_equal(norma_json_size(&j, a), 1);
    assert_true(norma_json_uint(&j, norma_json_element(&j, a, 0), &value));
    assert_int_equal(value, 7);
    uint32_t first = norma_json_first(&j, 0);
    static const int whole[] = {1, 1, 1, 0, 0, 0};
    for (uint32_t i = 0; i < 6; ++i)
        assert_int_equal(norma_json_uint(&j, norma_json_element(&j, first, i), &value), whole[i]);
    assert_int_equal(norma_json_element(&j, first, 6), JSON_NONE);
    char *name = norma_json_string(&j, norma_json_member(&j, 0, "name"));
    assert_string_equal(name, "\xc3\xa4\xf0\x9f\x98\x80\t");
    free(name);
    assert_true(norma_json_is(&j, norma_json_member(&j, 0, "t"), JSON_TRUE));
    assert_int_equal(norma_json_member(&j, 0, "b"), JSON_NONE);
    norma_json_free(&j);
}

typedef struct editing {
    json j;
    json_edits *edits;
} editing;

static void begin(editing *e, const char *text) {
    json_error error;
    assert_true(norma_json_parse(text, strlen(text), NULL, &e->j, &error));
    e->edits = norma_json_edits_create(&e->j, 0);
    assert_non_null(e->edits);
}

static void expect(editing *e, const char *expected) {
    json_text out = {0};
    json_edits *copy = norma_json_edits_copy(e->edits); /* a copy writes the same */
    assert_true(norma_json_write(copy, 0, &out));
    norma_json_add(&out, "", 1);
    assert_string_equal(out.data, expected);
    assert_true(parses(out.data));
    free(out.data);
    norma_json_edits_destroy(copy);
    norma_json_edits_destroy(e->edits);
    norma_json_free(&e->j);
}

static uint32_t at(const editing *e, const char *key) { return norma_json_member(&e->j, 0, key); }

static void nothing_edited_is_the_text(void **state) {
    const char *text = " {\"a\" : [ 1.50 ,\t2e0 ] , \"a\":-0.0,\n \"b\":\"\\u0041\" } \n";
    editing e;
    (void)state;
    begin(&e, text);
    assert_false(norma_json_edits_any(e.edits));
    expect(&e, text);
}

static void replaces_values_alone(void **state) {
    editing e;
    (void)state;
    begin(&e, " {\"a\" : [ 1.50 ,\t2e0 ] , \"b\":{\"c\":1 , \"d\":2}}");
    norma_json_replace_uint(e.edits, norma_json_element(&e.j, at(&e, "a"), 1), 12);
    norma_json_set_uint(e.edits, at(&e, "b"), "c", 5);
    norma_json_set_uint(e.edits, at(&e, "b"), "c", 6);
    expect(&e, " {\"a\" : [ 1.50 ,\t12 ] , \"b\":{\"c\":6 , \"d\":2}}");
}

static void appends_in_the_style_of_the_last(void **state) {
    editing e;
    (void)state;
    begin(&e, "{\n  \"a\": [\n    1,\n    2\n  ],\n  \"b\": [],\n  \"c\": {}\n}");
    norma_json_append(e.edits, at(&e, "a"), "3");
    norma_json_append(e.edits, at(&e, "a"), "4");
    norma_json_append(e.edits, at(&e, "b"), "5");
    norma_json_set(e.edits, at(&e, "c"), "k\"", "6");
    norma_json_set(e.edits, 0, "d", "7");
    norma_json_set(e.edits, 0, "d", "8");
    expect(&e, "{\n  \"a\": [\n    1,\n    2,\n    3,\n    4\n  ],\n  \"b\": [5],\n  \"c\": "
               "{\"k\\\"\":6},\n  \"d\": 8\n}");
}

static void removes_with_the_comma(void **state) {
    editing e;
    (void)state;
    begin(&e, "{\"a\":[1, 2, 3], \"b\":[4, 5, 6], \"c\":[7, 8, 9], \"d\":1, \"e\":2}");
    norma_json_remove(e.edits, norma_json_element(&e.j, at(&e, "a"), 0));
    norma_json_remove(e.edits, norma_json_element(&e.j, at(&e, "b"), 1));
    norma_json_remove(e.edits, norma_json_element(&e.j, at(&e, "b"), 2));
    for (uint32_t i = 0; i < 3; ++i)
        norma_json_remove(e.edits, norma_json_element(&e.j, at(&e, "c"), i));
    norma_json_unset(e.edits, 0, "e");
    norma_json_unset(e.edits, 0, "nothing");
    expect(&e, "{\"a\":[2, 3], \"b\":[4], \"c\":[], \"d\":1}");
}

/* The last of one name counts: without the others, one of them would count instead. */
static void removes_all_of_one_name(void **state) {
    editing e;
    (void)state;
    begin(&e, "{\"a\":[1], \"b\":2, \"\\u0061\":3, \"a\":4, \"c\":[5, 5]}");
    norma_json_remove(e.edits, at(&e, "a"));
    norma_json_remove(e.edits, norma_json_element(&e.j, at(&e, "c"), 0));
    expect(&e, "{\"b\":2, \"c\":[5]}");
}

static void removes_and_appends_in_one_place(void **state) {
    editing e;
    (void)state;
    begin(&e, "{\"a\":[1, 2], \"b\":[3]}");
    norma_json_remove(e.edits, norma_json_element(&e.j, at(&e, "a"), 1));
    norma_json_append(e.edits, at(&e, "a"), "9");
    norma_json_remove(e.edits, norma_json_element(&e.j, at(&e, "b"), 0));
    norma_json_append(e.edits, at(&e, "b"), "8");
    expect(&e, "{\"a\":[1, 9], \"b\":[8]}");
}

static void edits_within_what_goes_are_dropped(void **state) {
    editing e;
    (void)state;
    begin(&e, "{\"a\":{\"b\":[1]},\"c\":{\"d\":2}}");
    norma_json_replace(
        e.edits, norma_json_element(&e.j, norma_json_member(&e.j, at(&e, "a"), "b"), 0), "5");
    norma_json_remove(e.edits, at(&e, "a"));
    norma_json_replace(e.edits, norma_json_member(&e.j, at(&e, "c"), "d"), "6");
    norma_json_replace(e.edits, at(&e, "c"), "true");
    expect(&e, "{\"c\":true}");
}

static void writes_one_value_of_the_text(void **state) {
    editing e;
    json_text out = {0};
    (void)state;
    begin(&e, "{\"a\" : { \"b\" : [ 1 ] } }");
    norma_json_append(e.edits, norma_json_member(&e.j, at(&e, "a"), "b"), "2");
    assert_true(norma_json_write(e.edits, at(&e, "a"), &out));
    assert_int_equal(out.size, strlen("{ \"b\" : [ 1, 2 ] }"));
    assert_memory_equal(out.data, "{ \"b\" : [ 1, 2 ] }", out.size);
    free(out.data);
    norma_json_edits_destroy(e.edits);
    norma_json_free(&e.j);
}

/* RFC 8259, 7: quotes, backslashes and what is below U+0020 are escaped; the rest need not be. Read
 * back it is what it was. */
static void quotes_any_text(void **state) {
    json_text text = {0};
    json j;
    json_error error;
    char all[40] = "";
    (void)state;
    for (char c = 1; c < 0x20; ++c) all[c - 1] = c;
    memcpy(all + 31, "\"\\\x7f\xc3\xa4", 6);
    norma_json_add_quoted(&text, all);
    for (size_t i = 0; i < text.size; ++i) assert_true((unsigned char)text.data[i] >= 0x20);
    assert_true(norma_json_parse(text.data, text.size, NULL, &j, &error));
    char *back = norma_json_string(&j, 0);
    assert_string_equal(back, all);
    free(back);
    norma_json_free(&j);
    free(text.data);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(accepts_what_the_rfc_allows),
        cmocka_unit_test(refuses_what_it_does_not),
        cmocka_unit_test(nesting_is_bounded),
        cmocka_unit_test(values_are_found_and_read),
        cmocka_unit_test(nothing_edited_is_the_text),
        cmocka_unit_test(replaces_values_alone),
        cmocka_unit_test(appends_in_the_style_of_the_last),
        cmocka_unit_test(removes_with_the_comma),
        cmocka_unit_test(removes_all_of_one_name),
        cmocka_unit_test(removes_and_appends_in_one_place),
        cmocka_unit_test(edits_within_what_goes_are_dropped),
        cmocka_unit_test(writes_one_value_of_the_text),
        cmocka_unit_test(quotes_any_text),
    };
    return cmocka_run_group_tests_name("json", tests, NULL, NULL);
}
