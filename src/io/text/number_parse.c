/* number_parse.c: decimal text to the nearest double.
 *
 * Three ways, each exact: a double times or by a power of ten where both are exact (Clinger 1990);
 * 64-bit digits times or by a power of five in 128 bits; integers of any length. A decimal halfway
 * between two doubles has at most 767 digits, so digits past DIGITS only say "a little more".
 *
 * Plain decimals, nearly all that files hold, are read eight digits at a time within one 64-bit
 * word; all else character by character. */
#include "io/text/number.h"
#include "io/text/number_big.h"
#include "io/text/digits.h"
#include <float.h>
#include <math.h>
#include <string.h>

enum { DIGITS = 800 };

typedef struct decimal { /* mantissa * 10^exponent, mantissa the first 19 significant digits */
    uint64_t mantissa;
    int64_t exponent;
    const char *first, *end; /* the significant digits' text, a point perhaps within */
    int inexact;             /* digits other than 0 follow the 19 */
} decimal;

static int is_digit(char c) { return (unsigned char)(c - '0') < 10; }

/* value = q * 2^exponent, q's top bit set, and a little more where sticky. */
static double round_to_double(uint64_t q, int exponent, int sticky) {
    int shift = 11;                                      /* 64 - 53 bits go */
    if (exponent < -1074 - 11) shift = -1074 - exponent; /* subnormal: more go */
    if (exponent > 1023) return (double)INFINITY;
    if (shift > 64) return 0;
    uint64_t kept = shift < 64 ? q >> shift : 0;
    uint64_t half = UINT64_C(1) << (shift - 1);
    uint64_t rest = shift < 64 ? q & ((half << 1) - 1) : q;
    if (rest > half || (rest == half && (sticky || (kept & 1)))) ++kept;
    return ldexp((double)kept, exponent + shift);
}

#if defined(__SIZEOF_INT128__)
__extension__ typedef unsigned __int128 wide;

static int leading_zeros(uint64_t value) { return __builtin_clzll(value); }

/* mantissa * 10^exponent for |exponent| <= 27, where 5^27 < 2^63. */
static double wide_to_double(uint64_t mantissa, int exponent) {
    uint64_t five = 1;
    for (int i = exponent < 0 ? -exponent : exponent; i; --i) five *= 5;
    if (exponent >= 0) {
        wide product = (wide)mantissa * five;
        uint64_t high = (uint64_t)(product >> 64);
        int shift = high ? 64 - leading_zeros(high) : 0;
        uint64_t q = (uint64_t)(product >> shift);
        int sticky = shift && (product & (((wide)1 << shift) - 1)) != 0;
        int zeros = leading_zeros(q);
        return round_to_double(q << zeros, exponent + shift - zeros, sticky);
    }
    int up = leading_zeros(mantissa);
    int five_up = leading_zeros(five);
    wide numerator =
        (wide)(mantissa << up)
        << 63; /* in [2^126, 2^127), the divisor in [2^63, 2^64): the quotient has 63 or 64 bits */
    uint64_t divisor = five << five_up;
    wide quotient = numerator / divisor;
    int sticky = numerator % divisor != 0;
    uint64_t q = (uint64_t)quotient;
    int zeros = leading_zeros(q);
    return round_to_double(q << zeros, exponent - up - 63 + five_up - zeros, sticky);
}
#endif

/* The double nearest to numerator / denominator * 2^exponent. */
static double divide_to_double(big_number *numerator, big_number *denominator, int exponent) {
    int shift = norma_big_bits(numerator) - norma_big_bits(denominator);
    if (shift > 0)
        norma_big_shift_left(denominator, shift);
    else
        norma_big_shift_left(numerator, -shift);
    uint64_t q = 0;
    int bits = 0;
    exponent += shift + 1;
    while (bits < 64) { /* one bit of the quotient a round; the first may be 0 */
        int bit = norma_big_compare(numerator, denominator) >= 0;
        if (bit) norma_big_subtract(numerator, denominator);
        q = q << 1 | (uint64_t)bit;
        bits += q != 0;
        --exponent;
        norma_big_shift_left(numerator, 1);
    }
    return round_to_double(q, exponent, numerator->count != 0);
}

static double exact_to_double(const decimal *number) {
    big_number numerator, denominator;
    int64_t exponent = number->exponent;
    int digits = 0;
    int more = 0;
    norma_big_set(&numerator, 0);
    norma_big_set(&denominator, 1);
    for (const char *p = number->first; p < number->end; ++p) {
        if (*p == '.') continue;
        if (digits < DIGITS)
            norma_big_multiply_add(&numerator, 10, (uint32_t)(*p - '0'));
        else
            more |= *p != '0';
        ++digits;
    }
    /* exponent counts from the 19th digit, or from the last one where there are fewer. */
    exponent += (digits < 19 ? digits : 19) - (digits < DIGITS ? digits : DIGITS);
    if (more) {
        norma_big_multiply_add(&numerator, 10, 1);
        --exponent;
    }
    if (exponent >= 0)
        norma_big_multiply_power(&numerator, 5, (int)exponent);
    else
        norma_big_multiply_power(&denominator, 5, (int)-exponent);
    return divide_to_double(&numerator, &denominator, (int)exponent);
}

static const double power[23] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12,
    1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

static double to_double(const decimal *number) {
    int64_t exponent = number->exponent;
    if (number->mantissa == 0) return 0;
    if (!number->inexact) {
        if (number->mantissa <= UINT64_C(1) << 53 && exponent >= -22 && exponent <= 22 &&
            FLT_EVAL_METHOD == 0)
            return exponent < 0 ? (double)number->mantissa / power[-exponent]
                                : (double)number->mantissa * power[exponent];
#if defined(__SIZEOF_INT128__)
        if (exponent >= -27 && exponent <= 27)
            return wide_to_double(number->mantissa, (int)exponent);
#endif
    }
    if (exponent > 310) /* the mantissa is at least 1 */
        return (double)INFINITY;
    if (exponent < -400) /* and below 10^19 */
        return 0;
    return exact_to_double(number);
}

double norma_number_of_decimal(uint64_t digits, int exponent) {
    char text[20];
    size_t length = norma_number_format_integer(digits, text);
    decimal number = {digits, exponent, text, text + length, 0};
    return to_double(&number);
}

/* nan, inf, infinity; NULL if it is another word. */
static const char *parse_word(const char *text, const char *end, double *value) {
    static const struct {
        const char *word;
        size_t length;
        double value;
    } words[] = {
        {"infinity", 8, (double)INFINITY}, {"inf", 3, (double)INFINITY}, {"nan", 3, (double)NAN}};
    for (size_t w = 0; w < sizeof words / sizeof words[0]; ++w) {
        size_t i = 0;
        while (i < words[w].length && text + i < end && (text[i] | 0x20) == words[w].word[i]) ++i;
        if (i == words[w].length) {
            *value = words[w].value;
            return text + i;
        }
    }
    return NULL;
}

/* What follows "1." in 1.#INF, 1.#IND, 1.#QNAN, 1.#SNAN, and digits after it; NULL where it is
 * something else. */
static const char *parse_windows(const char *text, const char *end, double *value) {
    static const char words[4][5] = {"#INF", "#IND", "#QNA", "#SNA"};
    if (end - text < 4) return NULL;
    for (int w = 0; w < 4; ++w) {
        if (memcmp(text, words[w], 4) != 0) continue;
        *value = w == 0 ? (double)INFINITY : (double)NAN;
        text += w < 2 ? 4 : 5;
        if (text > end) return NULL;
        while (text < end && is_digit(*text)) ++text;
        return text;
    }
    return NULL;
}

static const char *parse_exponent(const char *text, const char *end, int64_t *exponent) {
    const char *p = text + 1;
    int negative = 0;
    int64_t value = 0;
    if (p < end && (*p == '+' || *p == '-')) negative = *p++ == '-';
    if (p >= end || !is_digit(*p)) return text; /* "1e" is 1, then an e */
    for (; p < end && is_digit(*p); ++p)
        if (value < INT64_C(1000000000000)) value = 10 * value + (*p - '0');
    *exponent += negative ? -value : value;
    return p;
}

#if NORMA_DIGITS_BY_WORD && defined(__SIZEOF_INT128__)
/* Adds the digits at *p to the mantissa and returns how many they were; -1: too near the end of the
 * text for a whole word. More than 19 in all are no matter here. */
static int take_digits(const char **p, const char *end, uint64_t *mantissa) {
    static const uint64_t scale[] = {1, 10, 100, 1000, 10000, 100000, 1000000, 10000000, 100000000};
    int taken = 0, count;
    do {
        if (end - *p < 8) return -1;
        const uint64_t bytes = norma_digits_load(*p);
        count = norma_digits_count(bytes);
        if (count == 0) break;
        *mantissa = *mantissa * scale[count] + norma_digits_join(bytes, count);
        *p += count;
        taken += count;
    } while (count == 8 && taken < 24);
    return taken;
}

/* A sign, digits, a point, digits: at most 19, as shortest doubles have them. NULL: something else,
 * or it cannot be told from here. */
static const char *parse_plain(const char *text, const char *end, double *value) {
    const char *p = text;
    uint64_t mantissa = 0;
    const int negative = p < end && *p == '-';
    p += negative;
    const int whole = take_digits(&p, end, &mantissa);
    if (whole < 0 || p >= end || *p != '.') return NULL;
    ++p;
    const int decimals = take_digits(&p, end, &mantissa);
    if (decimals < 0 || whole + decimals == 0 || whole + decimals > 19 || p >= end ||
        (*p | 0x20) == 'e' || *p == '#' || FLT_EVAL_METHOD != 0)
        return NULL;
    double magnitude = mantissa <= UINT64_C(1) << 53 ? (double)mantissa / power[decimals]
                                                     : wide_to_double(mantissa, -decimals);
    *value = negative ? -magnitude : magnitude;
    return p;
}
#else
static const char *parse_plain(const char *text, const char *end, double *value) {
    (void)text, (void)end, (void)value;
    return NULL;
}
#endif

static const char *parse_any(const char *text, const char *end, double *value) {
    decimal number = {0, 0, NULL, NULL, 0};
    const char *p = text;
    int negative = 0;
    if (p < end && (*p == '-' || *p == '+')) negative = *p++ == '-';
    const char *start = p;
    const char *point = NULL;
    while (p < end && *p == '0') ++p;
    number.first = p;
    while (p < end && is_digit(*p)) number.mantissa = 10 * number.mantissa + (uint64_t)(*p++ - '0');
    int64_t digits = p - number.first;
    if (p < end && *p == '.') {
        point = p++;
        if (digits == 0) {
            while (p < end && *p == '0') ++p;
            number.first = p;
        }
        const char *fraction = p;
        while (p < end && is_digit(*p))
            number.mantissa = 10 * number.mantissa + (uint64_t)(*p++ - '0');
        digits += p - fraction;
        number.exponent = -(p - point - 1);
    }
    number.end = p;
    if (p - start == (point != NULL)) { /* no digit at all */
        p = point ? NULL : parse_word(start, end, value);
        if (p && negative) *value = -*value;
        return p;
    }
    if (point && p < end && *p == '#' && p == point + 1 && p - start == 2 && *start == '1') {
        const char *special = parse_windows(p, end, value);
        if (special && negative) *value = -*value;
        if (special) return special;
    }
    if (digits > 19) { /* the mantissa has overflowed: the first 19 again */
        const char *q = number.first;
        number.mantissa = 0;
        for (int i = 0; i < 19; ++q)
            if (*q != '.') {
                number.mantissa = 10 * number.mantissa + (uint64_t)(*q - '0');
                ++i;
            }
        number.exponent += digits - 19;
        number.inexact = 1;
    }
    if (p < end && (*p | 0x20) == 'e') p = parse_exponent(p, end, &number.exponent);
    *value = negative ? -to_double(&number) : to_double(&number);
    return p;
}

const char *norma_number_parse(const char *text, const char *end, double *value) {
    uint64_t digits;
    const char *next = norma_digits_plain(text, end, value, &digits);
    if (!next) next = parse_plain(text, end, value);
    return next ? next : parse_any(text, end, value);
}

const char *norma_number_parse_integer(const char *text, const char *end, int64_t *value) {
    const char *p = text;
    int negative = 0;
    uint64_t magnitude = 0;
    if (p < end && (*p == '-' || *p == '+')) negative = *p++ == '-';
    const char *first = p;
    const uint64_t limit = (uint64_t)INT64_MAX + (uint64_t)negative;
    for (; p < end && is_digit(*p); ++p) {
        uint64_t digit = (uint64_t)(*p - '0');
        if (magnitude > (limit - digit) / 10) return NULL;
        magnitude = 10 * magnitude + digit;
    }
    if (p == first) return NULL;
    *value = negative ? (int64_t)(0 - magnitude) : (int64_t)magnitude;
    return p;
}
