/* number.c: numbers as text, read and written exactly and whatever the locale. */
#include "io/text/text.h"
#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>

/* ---- Schoolbook arithmetic on positive integers for the rare decimals that machine words
 * cannot decide. */

/* Up to 8192 bits, as much as converting doubles to decimal and back needs. */
enum { BIG_LIMBS = 256 };

typedef struct big_number {
    uint32_t limb[BIG_LIMBS]; /* least first */
    int count;                /* without zeros at the top; 0: zero */
} big_number;

static void big_set(big_number *big, uint64_t value) {
    big->limb[0] = (uint32_t)value;
    big->limb[1] = (uint32_t)(value >> 32);
    big->count = value >> 32 ? 2 : value ? 1 : 0;
}

static void big_multiply_add(big_number *big, uint32_t factor, uint32_t summand) {
    uint64_t carry = summand;
    for (int i = 0; i < big->count; ++i) {
        carry += (uint64_t)big->limb[i] * factor;
        big->limb[i] = (uint32_t)carry;
        carry >>= 32;
    }
    if (carry) {
        assert(big->count < BIG_LIMBS);
        big->limb[big->count++] = (uint32_t)carry;
    }
}

static void big_multiply_power(big_number *big, uint32_t base, int exponent) {
    for (; exponent > 0; --exponent) big_multiply_add(big, base, 0);
}

static void big_shift_left(big_number *big, int bits) {
    int limbs = bits / 32;
    int rest = bits % 32;
    if (!big->count) return;
    assert(big->count + limbs + 1 <= BIG_LIMBS);
    memmove(big->limb + limbs, big->limb, (size_t)big->count * sizeof big->limb[0]);
    memset(big->limb, 0, (size_t)limbs * sizeof big->limb[0]);
    big->count += limbs;
    if (!rest) return;
    uint32_t carry = 0;
    for (int i = limbs; i < big->count; ++i) {
        uint32_t limb = big->limb[i];
        big->limb[i] = limb << rest | carry;
        carry = limb >> (32 - rest);
    }
    if (carry) big->limb[big->count++] = carry;
}

/* number of bits; 0 for zero */
static int big_bits(const big_number *big) {
    if (!big->count) return 0;
    int bits = 32 * (big->count - 1);
    for (uint32_t top = big->limb[big->count - 1]; top; top >>= 1) ++bits;
    return bits;
}

/* < 0, 0, > 0 */
static int big_compare(const big_number *a, const big_number *b) {
    if (a->count != b->count) return a->count - b->count;
    for (int i = a->count - 1; i >= 0; --i)
        if (a->limb[i] != b->limb[i]) return a->limb[i] < b->limb[i] ? -1 : 1;
    return 0;
}

/* smaller <= big */
static void big_subtract(big_number *big, const big_number *smaller) {
    uint64_t borrow = 0;
    for (int i = 0; i < big->count; ++i) {
        uint64_t less = borrow + (i < smaller->count ? smaller->limb[i] : 0);
        borrow = big->limb[i] < less;
        big->limb[i] = (uint32_t)(big->limb[i] - less);
    }
    while (big->count && !big->limb[big->count - 1]) --big->count;
}

/* ---- Whole numbers as decimal text, two digits at a time. */

/* "00" to "99": two digits for one division. */
static const char pairs[] = "0001020304050607080910111213141516171819202122232425262728293031323334"
                            "3536373839404142434445464748495051525354555657585960616263646566676869"
                            "707172737475767778798081828384858687888990919293949596979899";

static size_t digits_of(uint64_t value) {
    size_t digits = 1;
    for (; value >= 10000; value /= 10000) digits += 4;
    return digits + (value >= 10) + (value >= 100) + (value >= 1000);
}

int norma_significant_digits(const char *p, const char *end) {
    int digits = 0, zeros = 0;
    for (; p < end && *p != 'e' && *p != 'E'; ++p) {
        if (*p < '0' || *p > '9' || (digits == 0 && *p == '0')) continue;
        zeros = *p == '0' ? zeros + 1 : 0;
        ++digits;
    }
    return digits - zeros;
}

size_t norma_number_format_integer(uint64_t value, char out[20]) {
    const size_t length = digits_of(value);
    char *p = out + length;
    for (; value >= 100; value /= 100) memcpy(p -= 2, pairs + 2 * (value % 100), 2);
    if (value >= 10)
        memcpy(out, pairs + 2 * value, 2);
    else
        *out = (char)('0' + value);
    return length;
}

/* ---- Decimal text to the nearest double.
 *
 * Three ways, each exact: a double times or by a power of ten where both are exact (Clinger 1990);
 * 64-bit digits times or by a power of five in 128 bits; integers of any length. A decimal halfway
 * between two doubles has at most 767 digits, so digits past DIGITS only say "a little more".
 *
 * Plain decimals, nearly all that files hold, are read eight digits at a time within one 64-bit
 * word; all else character by character. */

enum { DIGITS = 800 };

typedef struct long_decimal { /* mantissa * 10^exponent, mantissa the first 19 significant digits */
    uint64_t mantissa;
    int64_t exponent;
    const char *first, *end; /* the significant digits' text, a point perhaps within */
    int inexact;             /* digits other than 0 follow the 19 */
} long_decimal;

static int number_is_digit(char c) { return (unsigned char)(c - '0') < 10; }

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
__extension__ typedef unsigned __int128 wide_word;

static int leading_zeros(uint64_t value) { return __builtin_clzll(value); }

/* mantissa * 10^exponent for |exponent| <= 27, where 5^27 < 2^63. */
static double number_wide_to_double(uint64_t mantissa, int exponent) {
    uint64_t five = 1;
    for (int i = exponent < 0 ? -exponent : exponent; i; --i) five *= 5;
    if (exponent >= 0) {
        wide_word product = (wide_word)mantissa * five;
        uint64_t high = (uint64_t)(product >> 64);
        int shift = high ? 64 - leading_zeros(high) : 0;
        uint64_t q = (uint64_t)(product >> shift);
        int sticky = shift && (product & (((wide_word)1 << shift) - 1)) != 0;
        int zeros = leading_zeros(q);
        return round_to_double(q << zeros, exponent + shift - zeros, sticky);
    }
    int up = leading_zeros(mantissa);
    int five_up = leading_zeros(five);
    wide_word numerator =
        (wide_word)(mantissa << up)
        << 63; /* in [2^126, 2^127), the divisor in [2^63, 2^64): the quotient has 63 or 64 bits */
    uint64_t divisor = five << five_up;
    wide_word quotient = numerator / divisor;
    int sticky = numerator % divisor != 0;
    uint64_t q = (uint64_t)quotient;
    int zeros = leading_zeros(q);
    return round_to_double(q << zeros, exponent - up - 63 + five_up - zeros, sticky);
}
#endif

/* The double nearest to numerator / denominator * 2^exponent. */
static double divide_to_double(big_number *numerator, big_number *denominator, int exponent) {
    int shift = big_bits(numerator) - big_bits(denominator);
    if (shift > 0)
        big_shift_left(denominator, shift);
    else
        big_shift_left(numerator, -shift);
    uint64_t q = 0;
    int bits = 0;
    exponent += shift + 1;
    while (bits < 64) { /* one bit of the quotient a round; the first may be 0 */
        int bit = big_compare(numerator, denominator) >= 0;
        if (bit) big_subtract(numerator, denominator);
        q = q << 1 | (uint64_t)bit;
        bits += q != 0;
        --exponent;
        big_shift_left(numerator, 1);
    }
    return round_to_double(q, exponent, numerator->count != 0);
}

static double exact_to_double(const long_decimal *number) {
    big_number numerator, denominator;
    int64_t exponent = number->exponent;
    int digits = 0;
    int more = 0;
    big_set(&numerator, 0);
    big_set(&denominator, 1);
    for (const char *p = number->first; p < number->end; ++p) {
        if (*p == '.') continue;
        if (digits < DIGITS)
            big_multiply_add(&numerator, 10, (uint32_t)(*p - '0'));
        else
            more |= *p != '0';
        ++digits;
    }
    /* exponent counts from the 19th digit, or from the last one where there are fewer. */
    exponent += (digits < 19 ? digits : 19) - (digits < DIGITS ? digits : DIGITS);
    if (more) {
        big_multiply_add(&numerator, 10, 1);
        --exponent;
    }
    if (exponent >= 0)
        big_multiply_power(&numerator, 5, (int)exponent);
    else
        big_multiply_power(&denominator, 5, (int)-exponent);
    return divide_to_double(&numerator, &denominator, (int)exponent);
}

static const double power_of_ten[23] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10,
    1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

static double to_double(const long_decimal *number) {
    int64_t exponent = number->exponent;
    if (number->mantissa == 0) return 0;
    if (!number->inexact) {
        if (number->mantissa <= UINT64_C(1) << 53 && exponent >= -22 && exponent <= 22 &&
            FLT_EVAL_METHOD == 0)
            return exponent < 0 ? (double)number->mantissa / power_of_ten[-exponent]
                                : (double)number->mantissa * power_of_ten[exponent];
#if defined(__SIZEOF_INT128__)
        if (exponent >= -27 && exponent <= 27)
            return number_wide_to_double(number->mantissa, (int)exponent);
#endif
    }
    if (exponent > 310) /* the mantissa is at least 1 */
        return (double)INFINITY;
    if (exponent < -400) /* and below 10^19 */
        return 0;
    return exact_to_double(number);
}

static double number_of_decimal(uint64_t digits, int exponent) {
    char text[20];
    size_t length = norma_number_format_integer(digits, text);
    long_decimal number = {digits, exponent, text, text + length, 0};
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
        while (text < end && number_is_digit(*text)) ++text;
        return text;
    }
    return NULL;
}

static const char *parse_exponent(const char *text, const char *end, int64_t *exponent) {
    const char *p = text + 1;
    int negative = 0;
    int64_t value = 0;
    if (p < end && (*p == '+' || *p == '-')) negative = *p++ == '-';
    if (p >= end || !number_is_digit(*p)) return text; /* "1e" is 1, then an e */
    for (; p < end && number_is_digit(*p); ++p)
        if (value < INT64_C(1000000000000)) value = 10 * value + (*p - '0');
    *exponent += negative ? -value : value;
    return p;
}

static const char *parse_any(const char *text, const char *end, double *value) {
    long_decimal number = {0, 0, NULL, NULL, 0};
    const char *p = text;
    int negative = 0;
    if (p < end && (*p == '-' || *p == '+')) negative = *p++ == '-';
    const char *start = p;
    const char *point = NULL;
    while (p < end && *p == '0') ++p;
    number.first = p;
    while (p < end && number_is_digit(*p))
        number.mantissa = 10 * number.mantissa + (uint64_t)(*p++ - '0');
    int64_t digits = p - number.first;
    if (p < end && *p == '.') {
        point = p++;
        if (digits == 0) {
            while (p < end && *p == '0') ++p;
            number.first = p;
        }
        const char *fraction = p;
        while (p < end && number_is_digit(*p))
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
    return next ? next : parse_any(text, end, value);
}

const char *norma_number_parse_integer(const char *text, const char *end, int64_t *value) {
    const char *p = text;
    int negative = 0;
    uint64_t magnitude = 0;
    if (p < end && (*p == '-' || *p == '+')) negative = *p++ == '-';
    const char *first = p;
    const uint64_t limit = (uint64_t)INT64_MAX + (uint64_t)negative;
    for (; p < end && number_is_digit(*p); ++p) {
        uint64_t digit = (uint64_t)(*p - '0');
        if (magnitude > (limit - digit) / 10) return NULL;
        magnitude = 10 * magnitude + digit;
    }
    if (p == first) return NULL;
    *value = negative ? (int64_t)(0 - magnitude) : (int64_t)magnitude;
    return p;
}

/* ---- The fewest digits that read back as the same number.
 *
 * Six digits (fifteen for a double) that read back are the only ones that do, so that, with the
 * zeros at the end cut, they are the fewest; otherwise one digit more is tried after another, up to
 * nine (seventeen); subnormal numbers begin with one. Whether digits read back is asked of exact
 * arithmetic, never assumed. */

static size_t write_fixed(const char *digits, int count, int point, char *out) {
    char *p = out;
    if (point <= 0) {
        *p++ = '0';
        *p++ = '.';
        for (int i = point; i < 0; ++i) *p++ = '0';
    }
    for (int i = 0; i < count || i < point; ++i) {
        if (i == point && point > 0) *p++ = '.';
        *p++ = i < count ? digits[i] : '0';
    }
    return (size_t)(p - out);
}

static size_t write_exponent(const char *digits, int count, int exponent, char *out) {
    char *p = out;
    *p++ = digits[0];
    if (count > 1) *p++ = '.';
    memcpy(p, digits + 1, (size_t)count - 1);
    p += count - 1;
    *p++ = 'e';
    *p++ = exponent < 0 ? '-' : '+';
    char text[20];
    size_t length =
        norma_number_format_integer((uint64_t)(exponent < 0 ? -exponent : exponent), text);
    memcpy(p, text, length);
    return (size_t)(p - out) + length;
}

/* digits * 10^exponent as text; digits not 0. */
static size_t write_decimal(uint64_t digits, int exponent, char *out) {
    char text[20];
    for (; digits % 10 == 0; ++exponent) digits /= 10;
    int count = (int)norma_number_format_integer(digits, text);
    int point = count + exponent; /* digits before the point */
    if (point > -5 && point <= 16) return write_fixed(text, count, point, out);
    return write_exponent(text, count, point - 1, out);
}

/* The integer nearest to mantissa * 2^binary * 10^decimal, which is below 2^60: by long division of
 * integers of any length. */
static uint64_t scale_exact(uint64_t mantissa, int binary, int decimal) {
    big_number numerator, denominator;
    big_set(&numerator, mantissa);
    big_set(&denominator, 1);
    big_multiply_power(
        decimal > 0 ? &numerator : &denominator, 10, decimal > 0 ? decimal : -decimal);
    big_shift_left(binary > 0 ? &numerator : &denominator, binary > 0 ? binary : -binary);
    int shift = big_bits(&numerator) - big_bits(&denominator);
    if (shift < -1) return 0;
    shift = shift < 0 ? 0 : shift;
    big_shift_left(&denominator, shift);
    uint64_t quotient = 0;
    for (int i = 0; i <= shift + 1; ++i) { /* one bit more than the integer has: the half */
        int bit = big_compare(&numerator, &denominator) >= 0;
        if (bit) big_subtract(&numerator, &denominator);
        quotient = quotient << 1 | (uint64_t)bit;
        big_shift_left(&numerator, 1);
    }
    return (quotient + 1) >> 1;
}

/* The same, in 128 bits where they hold it. */
static uint64_t scale(uint64_t mantissa, int binary, int decimal) {
#if defined(__SIZEOF_INT128__)
    if (decimal >= -27 && decimal <= 27) {
        uint64_t five = 1;
        for (int i = decimal < 0 ? -decimal : decimal; i; --i) five *= 5;
        int shift = binary + decimal;
        if (decimal >= 0 && shift <= 0) {
            wide_word product = (wide_word)mantissa * five;
            return shift == 0     ? (uint64_t)product
                   : shift < -120 ? 0
                                  : (uint64_t)(((product >> (-shift - 1)) + 1) >> 1);
        }
        if (decimal < 0 && shift >= 0 && shift < 64)
            return (uint64_t)((((wide_word)mantissa << (shift + 1)) / five + 1) >> 1);
    }
#endif
    return scale_exact(mantissa, binary, decimal);
}

/* Of the numbers whose double has this exponent, that of their first digit: right or one too low,
 * as 1233 / 4096 is a little below log10 of 2. */
static int guess_decimal(int binary) {
    return binary >= 0 ? binary * 1233 / 4096 : -(-binary * 1233 / 4096) - 1;
}

/* value, finite and above 0, to count significant digits: *digits of that many, times 10^return. */
static int round_digits(double value, int count, uint64_t *digits) {
    int binary;
    double fraction = frexp(value, &binary);
    uint64_t mantissa = (uint64_t)ldexp(fraction, 53);
    uint64_t limit = 1;
    for (int i = 0; i < count; ++i) limit *= 10;
    int exponent = guess_decimal(binary - 1) - count + 1;
    *digits = scale(mantissa, binary - 53, -exponent);
    while (*digits >= limit) *digits = scale(mantissa, binary - 53, -++exponent);
    while (*digits < limit / 10) *digits = scale(mantissa, binary - 53, -(--exponent));
    return exponent;
}

/* As nothing between the decimal and its double crosses the middle between two floats, reading by
 * way of double gives the same float. */
static int reads_back_as_float(float value, uint64_t digits, int exponent) {
    double read = number_of_decimal(digits, exponent);
    if ((float)read != value) return 0;
    double below = 0.5 * ((double)nextafterf(value, 0.0f) + (double)value);
    double above = (double)nextafterf(value, INFINITY);
    above = isinf(above) ? (double)value + ((double)value - below) : 0.5 * (above + (double)value);
    return read > below && read < above;
}

static int reads_back(double value, int is_float, uint64_t digits, int exponent) {
    return is_float ? reads_back_as_float((float)value, digits, exponent)
                    : number_of_decimal(digits, exponent) == value;
}

/* number * 10^exponent, rounded once: powers up to the 22nd are doubles. */
static double times_power(double number, int exponent) {
    return exponent < 0 ? number / power_of_ten[-exponent] : number * power_of_ten[exponent];
}

/* The middle between two floats, neither of them subnormal: a bit more than a float has. */
static int is_middle(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (bits & 0x1fffffff) == 0x10000000;
}

/* The shortest digits of a float of ordinary size, in doubles: a number scaled to at most nine
 * digits is off by less than 1e-6, so that its rounding is certain unless it lies near a half.
 * What is read back is rounded once, as by number_of_decimal. 0: it cannot be told so. */
static int shorten_float(double value, uint64_t *digits, int *exponent) {
    if (FLT_EVAL_METHOD != 0 || value < 1e-5 || value >= 1e15) return 0;
    uint64_t bits, limit = 1000000;
    memcpy(&bits, &value, sizeof bits);
    *exponent = guess_decimal((int)(bits >> 52) - 1023) - FLT_DIG + 1;
    *exponent += times_power(value, -*exponent) >= (double)limit;
    for (int count = FLT_DIG; count <= FLT_DECIMAL_DIG; ++count, --*exponent, limit *= 10) {
        const double scaled = times_power(value, -*exponent);
        *digits = (uint64_t)scaled;
        const double rest = scaled - (double)*digits;
        *digits += rest > 0.5;
        if (fabs(rest - 0.5) < 1e-3 || *digits >= limit) return 0;
        const double read = times_power((double)*digits, *exponent);
        if ((double)(float)read == value && !is_middle(read)) return 1;
    }
    return 0;
}

static size_t format_shortest(double value, int is_float, char *out) {
    size_t length = 0;
    if (isnan(value)) {
        memcpy(out, "nan", 4);
        return 3;
    }
    if (signbit(value)) out[length++] = '-';
    value = fabs(value);
    if (isinf(value)) {
        memcpy(out + length, "inf", 3);
        length += 3;
    } else if (value == 0) {
        out[length++] = '0';
    } else {
        int most = is_float ? 9 : 17;
        int subnormal = value < (is_float ? (double)FLT_MIN : DBL_MIN);
        uint64_t digits = 0;
        int exponent = 0, count = subnormal ? 1 : is_float ? FLT_DIG : DBL_DIG;
        if (is_float && shorten_float(value, &digits, &exponent)) count = most + 1;
        for (; count <= most; ++count) {
            exponent = round_digits(value, count, &digits);
            if (reads_back(value, is_float, digits, exponent)) break;
        }
        length += write_decimal(digits, exponent, out + length);
    }
    out[length] = 0;
    return length;
}

size_t norma_number_format_float(float value, char out[32]) {
    return format_shortest((double)value, 1, out);
}

size_t norma_number_format_double(double value, char out[32]) {
    return format_shortest(value, 0, out);
}

static void write_eight(uint32_t number, char *out) {
#if NORMA_DIGITS_BY_WORD
    const uint64_t text = norma_digits_split(number) | UINT64_C(0x3030303030303030);
    memcpy(out, &text, sizeof text);
#else
    for (int i = 6; i >= 0; i -= 2, number /= 100) memcpy(out + i, pairs + 2 * (number % 100), 2);
#endif
}

size_t norma_number_format_normal(float value, char out[32]) {
    if (!(value >= -1.0f && value <= 1.0f)) return norma_number_format_float(value, out);
    char *p = out;
    uint32_t decimals = (uint32_t)(fabs((double)value) * 1e8 + 0.5);
    if (value < 0 && decimals) *p++ = '-';
    *p++ = (char)('0' + decimals / 100000000);
    decimals %= 100000000;
    if (decimals) {
        *p++ = '.';
        write_eight(decimals, p);
        p += 8;
        while (p[-1] == '0') --p;
    }
    *p = 0;
    return (size_t)(p - out);
}
