/* text.h: numbers and JSON as text. */
#ifndef NORMA_IO_TEXT_H
#define NORMA_IO_TEXT_H
#include <stddef.h>
#include <stdint.h>
#include <float.h>
#include <string.h>
#include "io/file/file.h"

/* ---- Numbers as text, read and written exactly and whatever the locale. */

/* Blanks between words, the ends of lines among them. */
static inline int norma_is_blank(int byte) { return byte == ' ' || (byte >= '\t' && byte <= '\r'); }

int norma_hex_value(int c);                      /* -1: no hexadecimal digit */
size_t norma_put_utf8(char *out, uint32_t code); /* the bytes that it took, at most four */

/* One character of UTF-8 (RFC 3629: no overlong forms, no surrogates, at most U+10FFFF) at the
 * beginning of left bytes, or of a text that ends in a zero: how many bytes it has, and its code.
 * 0: there is none. */
size_t norma_utf8_take(const char *text, size_t left, uint32_t *code);
/* Not controls (C0, DEL, C1), line and paragraph separators, marks of direction (Unicode's
 * Bidi_Control) and the byte order mark. */
int norma_utf8_is_legible(uint32_t code);

/* How many digits the number at p has, zeros before and after them aside. */
int norma_significant_digits(const char *p, const char *end);

/* Reads the number that begins at text and ends before end: an optional sign, digits with an
 * optional point (".5" and "5." too), an optional exponent; or nan, inf, infinity in any case,
 * or 1.#INF, 1.#IND, 1.#QNAN as old Windows programs write them. *value is the double nearest to
 * the decimal (ties to even), an infinity where it is too large. Returns the first byte after the
 * number, or NULL if no number stands there; *value is then unchanged. Skips no white space. */
const char *norma_number_parse(const char *text, const char *end, double *value);

/* The same for a decimal integer with an optional sign; NULL also where no int64_t holds it. */
const char *norma_number_parse_integer(const char *text, const char *end, int64_t *value);

/* Write the fewest digits that read back as the same number, fixed or with an exponent, with a
 * final 0; return the length without it. A float's text reads back the same directly and by way of
 * double. "nan", "inf", "-inf", "-0". */
size_t norma_number_format_float(float value, char out[32]);
size_t norma_number_format_double(double value, char out[32]);

/* A unit vector's component: at most eight decimals, zeros at the end cut, never "-0". Off by at
 * most 5e-9. Other numbers than those of [-1, 1] as norma_number_format_float. */
size_t norma_number_format_normal(float value, char out[32]);

/* value without sign in decimal; the length. No final 0. */
size_t norma_number_format_integer(uint64_t value, char out[20]);

/* ---- Decimal digits eight at a time, in one 64-bit word; and by them the plain decimals that
 * files mostly hold. Little-endian machines only; others go digit by digit. */

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define NORMA_DIGITS_BY_WORD 1

/* The eight bytes at p, which must be there; digits become 0 to 9. */
static inline uint64_t norma_digits_load(const char *p) {
    uint64_t bytes;
    memcpy(&bytes, p, sizeof bytes);
    return bytes ^ UINT64_C(0x3030303030303030);
}

/* How many of the eight, from the first on, are digits. */
static inline int norma_digits_count(uint64_t bytes) {
    const uint64_t others =
        (((bytes & UINT64_C(0x7f7f7f7f7f7f7f7f)) + UINT64_C(0x7676767676767676)) | bytes) &
        UINT64_C(0x8080808080808080);
    return others ? __builtin_ctzll(others) / 8 : 8;
}

/* The number that the first count of them make, 1 to 8: neighbours are joined to two digits, then
 * four, then eight. */
static inline uint64_t norma_digits_join(uint64_t bytes, int count) {
    bytes <<= 64 - 8 * count;
    bytes = 10 * bytes + (bytes >> 8);
    return ((bytes & UINT64_C(0x000000ff000000ff)) * UINT64_C(0x000f424000000064) +
               (bytes >> 16 & UINT64_C(0x000000ff000000ff)) * UINT64_C(0x0000271000000001)) >>
           32;
}

/* The eight digits, zeros in front, of a number below 10^8, each a byte of 0 to 9: by halves, in
 * both halves of the word at once (Khuong 2017). */
static inline uint64_t norma_digits_split(uint32_t number) {
    const uint64_t fours = number / 10000 | (uint64_t)(number % 10000) << 32;
    const uint64_t upper = (fours * 10486 >> 20) & UINT64_C(0x0000007f0000007f);
    const uint64_t pairs = ((fours - 100 * upper) << 16) + upper;
    const uint64_t tens = (pairs * 103 >> 10) & UINT64_C(0x000f000f000f000f);
    return tens + ((pairs - 10 * tens) << 8);
}

enum { NORMA_PLAIN_LENGTH = 32 }; /* bytes that norma_digits_plain may look at */

/* A sign or none, at most 7 digits, a point, at most 15 digits, where the number they make without
 * their point is at most 2^53 and something other than an exponent follows: then one division by a
 * power of ten is exactly rounded (Clinger 1990). *digits is that number without a point. NULL:
 * something else, or it cannot be told so simply. */
static inline const char *norma_digits_plain(
    const char *text, const char *end, double *value, uint64_t *digits) {
    static const double power[] = {
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
    static const uint32_t scale[] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000};
    const char *p = text;
    if (end - p < NORMA_PLAIN_LENGTH || FLT_EVAL_METHOD != 0) return NULL;
    const int negative = *p == '-';
    p += negative;
    uint64_t bytes = norma_digits_load(p);
    const int whole = norma_digits_count(bytes);
    uint64_t number = whole ? norma_digits_join(bytes, whole) : 0;
    if (whole == 8 || p[whole] != '.') return NULL;
    p += whole + 1;
    bytes = norma_digits_load(p);
    int decimals = norma_digits_count(bytes);
    if (decimals) number = number * scale[decimals] + norma_digits_join(bytes, decimals);
    p += decimals;
    if (decimals == 8) {
        bytes = norma_digits_load(p);
        const int more = norma_digits_count(bytes);
        if (more == 8) return NULL;
        if (more) number = number * scale[more] + norma_digits_join(bytes, more);
        decimals += more;
        p += more;
    }
    if (whole + decimals == 0 || whole + decimals > 19 || number > UINT64_C(1) << 53 ||
        (*p | 0x20) == 'e' || *p == '#')
        return NULL;
    const double magnitude = (double)number / power[decimals];
    *value = negative ? -magnitude : magnitude;
    *digits = number;
    return p;
}
#else
#define NORMA_DIGITS_BY_WORD 0
static inline const char *norma_digits_plain(
    const char *text, const char *end, double *value, uint64_t *digits) {
    (void)text, (void)end, (void)value, (void)digits;
    return NULL;
}
#endif

/* ---- JSON whose text stays where it is. Parsing gives the place of every value; editing gives
 * a new text in which all that was not touched is the bytes it was. Strict RFC 8259, nesting
 * bounded, repeated keys kept (the last one counts, as most readers have it). */

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
/* Values in turn: value is JSON_NONE before the first. 0: there are no more. */
int norma_json_each(const json *j, uint32_t container, uint32_t *value);
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
/* A member's key, behind a comma unless the object has just begun; and one with its number. */
void norma_json_add_key(json_text *text, const char *key);
void norma_json_add_uint_member(json_text *text, const char *key, uint64_t number);

/* ---- edits: a list of changes to one value of a parsed text (0: the root) and what is in it,
 * applied in one go. Failures for want of memory are kept and show at norma_json_write, as changes
 * of other values do. */
typedef struct json_edits json_edits;
json_edits *norma_json_edits_create(const json *j, uint32_t value);
json_edits *norma_json_edits_copy(const json_edits *edits);
void norma_json_edits_destroy(json_edits *edits);
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
/* The same with a text that was made, which is freed; of an empty one, the member is removed. Or an
 * element at the end of an array that is a member, which is made where it is not there. A text that
 * failed makes the edits fail. */
void norma_json_set_made(json_edits *edits, uint32_t object, const char *key, json_text *made);
void norma_json_append_made(json_edits *edits, uint32_t object, const char *key, json_text *made);

/* The text of value (0: the root) with the edits applied. For the root also what stands before and
 * behind it. */
int norma_json_write(
    const json_edits *edits, uint32_t value, json_text *out); /* 0: out of memory */
#endif
