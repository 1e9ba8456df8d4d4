/* jansson.h: stands in for jansson's where the tool is built without it. No file can be read, and
 * the error says why; the rest is what baseline.c and config.c would then ask of it. */
#ifndef NORMA_CLI_WITHOUT_JANSSON_H
#define NORMA_CLI_WITHOUT_JANSSON_H
#include <stddef.h>
#include <stdio.h>

typedef struct json_t json_t;
typedef long long json_int_t;
typedef struct json_error_t {
    int line;
    char text[80];
} json_error_t;
enum { JSON_REJECT_DUPLICATES = 1, JSON_DECODE_ANY = 4, JSON_SORT_KEYS = 0x80 };

static inline void json_set_alloc_funcs(void *(*allocate)(size_t), void (*release)(void *)) {
    (void)allocate, (void)release;
}
static inline json_t *json_loadf(FILE *file, size_t flags, json_error_t *error) {
    (void)file, (void)flags;
    *error = (json_error_t){.line = -1};
    snprintf(error->text, sizeof error->text, "this norma was built without jansson");
    return NULL;
}
static inline json_t *json_loadb(const char *text, size_t size, size_t flags, json_error_t *error) {
    (void)text, (void)size;
    return json_loadf(NULL, flags, error);
}
static inline char *json_dumps(const json_t *json, size_t flags) {
    return (void)json, (void)flags, NULL;
}
static inline json_t *json_object(void) { return NULL; }
static inline json_t *json_true(void) { return NULL; }
static inline int json_object_set_new(json_t *object, const char *key, json_t *value) {
    return (void)object, (void)key, (void)value, -1;
}
static inline int json_object_set(json_t *object, const char *key, json_t *value) {
    return (void)object, (void)key, (void)value, -1;
}
static inline void json_decref(json_t *json) { (void)json; }
static inline int json_is_array(const json_t *json) { return (void)json, 0; }
static inline int json_is_object(const json_t *json) { return (void)json, 0; }
static inline int json_is_string(const json_t *json) { return (void)json, 0; }
static inline int json_is_boolean(const json_t *json) { return (void)json, 0; }
static inline int json_is_true(const json_t *json) { return (void)json, 0; }
static inline int json_is_false(const json_t *json) { return (void)json, 0; }
static inline int json_is_integer(const json_t *json) { return (void)json, 0; }
static inline int json_is_number(const json_t *json) { return (void)json, 0; }
static inline double json_number_value(const json_t *json) { return (void)json, 0; }
static inline const char *json_string_value(const json_t *json) { return (void)json, NULL; }
static inline json_int_t json_integer_value(const json_t *json) { return (void)json, 0; }
static inline size_t json_array_size(const json_t *json) { return (void)json, 0; }
static inline json_t *json_array_get(const json_t *json, size_t index) {
    return (void)json, (void)index, NULL;
}
static inline json_t *json_object_get(const json_t *json, const char *key) {
    return (void)json, (void)key, NULL;
}
#define json_array_foreach(array, index, value)                                                    \
    for (index = 0; index < json_array_size(array) && (value = json_array_get(array, index));      \
         ++index)
#define json_object_foreach(object, key, value)                                                    \
    for (key = NULL, value = json_object_get(object, key); value; value = NULL)
#endif
