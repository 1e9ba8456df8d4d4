/* digits.h: decimal digits eight at a time, in one 64-bit word; and by them the plain decimals that
 * files mostly hold. Little-endian machines only; others go digit by digit. */
#ifndef NORMA_IO_DIGITS_H
#define NORMA_IO_DIGITS_H
#include <float.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

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

/* number, from 1 to below 10^8, as text; the length. Eight bytes of out are written. */
static inline size_t norma_digits_write(uint32_t number, char *out) {
    const uint64_t digits = norma_digits_split(number);
    const int zeros = __builtin_ctzll(digits) / 8;
    const uint64_t text = (digits | UINT64_C(0x3030303030303030)) >> (8 * zeros);
    memcpy(out, &text, sizeof text);
    return (size_t)(8 - zeros);
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
#endif
