/* json.h: JSON whose text stays where it is. Parsing gives the place of every value; editing gives
 * a new text in which all that was not touched is the bytes it was. Strict RFC 8259, nesting
 * bounded, repeated keys kept (the last one counts, as most readers have it). */
#ifndef NORMA_IO_JSON_H
#define NORMA_IO_JSON_H
#include "io/file/memory.h"
#include "io/file/watch.h"
#include <stddef.h>
#include <stdint.h>

#define JSON_NONE UINT32_MAX
enum { JSON_DEPTH = 256 };

typedef enum json_type {
    JSON_NULL = 0,
    JSON_FALSE,
    JSON_TRUE,
    JSON_NUMBER,
    JSON_STRING,
    JSON_ARRAY,
    JSON_OBJECT
} json_type;

typedef struct json_token { /* in the order of the text: an object's are key, value, key, value, ...
                             */
    size_t start, end;      /* bytes, quotes and brackets included */
    uint32_t parent;        /* of a key and of a member's value: the object; JSON_NONE: the root */
    uint32_t next;          /* the first token behind this value and all that is in it */
    uint32_t size;          /* elements of an array, members of an object */
    json_type type;
} json_token;

typedef struct json {
    const char *text; /* not owned */
    size_t size;
    json_token *tokens; /* tokens[0] is the root */
    uint32_t count;
} json;

typedef struct json_error {
    size_t byte;          /* where */
    const char *expected; /* what; NULL: out of memory */
} json_error;

/* Nonzero: parsed; the caller frees with norma_json_free, also after a failure. watch: NULL, or
 * asked on the way; where it cancels, an error. */
int norma_json_parse(
    const char *text, size_t size, norma_watch *watch, json *parsed, json_error *error);
void norma_json_free(json *parsed);

/* Value of a member. JSON_NONE: it is missing, or object is not an object (or JSON_NONE). The key
 * of value v of an object is token v - 1. */
uint32_t norma_json_member(const json *j, uint32_t object, const char *key);
uint32_t norma_json_element(
    const json *j, uint32_t array, uint32_t index); /* walks; to visit all use first and next */
uint32_t norma_json_first(const json *j, uint32_t container); /* first value in it, or JSON_NONE */
uint32_t norma_json_next(
    const json *j, uint32_t container, uint32_t value); /* the value after it, or JSON_NONE */
uint32_t norma_json_size(
    const json *j, uint32_t container); /* 0 for JSON_NONE and for what is no container */
int norma_json_is(const json *j, uint32_t token, json_type type); /* 0 for JSON_NONE */
int norma_json_equals(const json *j, uint32_t string,
    const char *text); /* escapes decoded; 0 for what is no string */
int norma_json_uint(const json *j, uint32_t number,
    uint64_t *value); /* also 1.0 and 10e-1; 0: none, below 0, beyond 2^53 */
int norma_json_number(const json *j, uint32_t number, double *value);
/* A string's text where it lies or, if it has escapes, decoded; it has no end but its length. 0: no
 * string, or out of memory. */
typedef struct json_span {
    const char *text;
    size_t length;
    char *owned; /* to be freed */
} json_span;
int norma_json_span(const json *j, uint32_t string, json_span *span);
char *norma_json_string(
    const json *j, uint32_t string); /* decoded, to be freed; NULL: no string, or out of memory */

/* ---- text that grows */
typedef growing_bytes json_text;
void norma_json_add(json_text *text, const char *bytes, size_t size);
void norma_json_add_text(json_text *text, const char *terminated);
void norma_json_add_uint(json_text *text, uint64_t value);
void norma_json_add_number(
    json_text *text, double value); /* shortest that reads back; not for NaN and infinities */
void norma_json_add_float(json_text *text, float value);
void norma_json_add_quoted(json_text *text, const char *utf8); /* as a JSON string */

/* ---- edits: a list of changes to one value of a parsed text (0: the root) and what is in it,
 * applied in one go. Failures for want of memory are kept and show at norma_json_write, as changes
 * of other values do. */
typedef struct json_edits json_edits;
json_edits *norma_json_edits_create(const json *j, uint32_t value);
json_edits *norma_json_edits_copy(const json_edits *edits);
void norma_json_edits_destroy(json_edits *edits);
void norma_json_edits_fail(json_edits *edits);        /* as if memory had run out within them */
int norma_json_edits_failed(const json_edits *edits); /* memory ran out within them */
int norma_json_edits_any(const json_edits *edits);

void norma_json_replace(json_edits *edits, uint32_t value,
    const char *text); /* the whole value; again: the last one counts */
void norma_json_replace_uint(json_edits *edits, uint32_t value, uint64_t number);
void norma_json_remove(json_edits *edits,
    uint32_t value); /* the element; or the member with its key, and all of that name */
void norma_json_append(json_edits *edits, uint32_t array, const char *text);
/* Sets a member of an object that the text has: replaces it (also an earlier set), undoes its
 * removal, or adds it behind the others. */
void norma_json_set(json_edits *edits, uint32_t object, const char *key, const char *text);
void norma_json_set_uint(json_edits *edits, uint32_t object, const char *key, uint64_t number);
void norma_json_unset(
    json_edits *edits, uint32_t object, const char *key); /* removes it where it is */

/* The text of value (0: the root) with the edits applied. For the root also what stands before and
 * behind it. */
int norma_json_write(
    const json_edits *edits, uint32_t value, json_text *out); /* 0: out of memory */
#endif
