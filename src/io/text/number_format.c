/* number_format.c: the fewest digits that read back as the same number.
 *
 * Six digits (fifteen for a double) that read back are the only ones that do, so that, with the
 * zeros at the end cut, they are the fewest; otherwise one digit more is tried after another, up to
 * nine (seventeen); subnormal numbers begin with one. Whether digits read back is asked of exact
 * arithmetic, never assumed. */
#include "io/text/number.h"
#include "io/text/number_big.h"
#include "io/text/digits.h"
#include <float.h>
#include <math.h>
#include <string.h>

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
    norma_big_set(&numerator, mantissa);
    norma_big_set(&denominator, 1);
    norma_big_multiply_power(
        decimal > 0 ? &numerator : &denominator, 10, decimal > 0 ? decimal : -decimal);
    norma_big_shift_left(binary > 0 ? &numerator : &denominator, binary > 0 ? binary : -binary);
    int shift = norma_big_bits(&numerator) - norma_big_bits(&denominator);
    if (shift < -1) return 0;
    shift = shift < 0 ? 0 : shift;
    norma_big_shift_left(&denominator, shift);
    uint64_t quotient = 0;
    for (int i = 0; i <= shift + 1; ++i) { /* one bit more than the integer has: the half */
        int bit = norma_big_compare(&numerator, &denominator) >= 0;
        if (bit) norma_big_subtract(&numerator, &denominator);
        quotient = quotient << 1 | (uint64_t)bit;
        norma_big_shift_left(&numerator, 1);
    }
    return (quotient + 1) >> 1;
}

/* The same, in 128 bits where they hold it. */
static uint64_t scale(uint64_t mantissa, int binary, int decimal) {
#if defined(__SIZEOF_INT128__)
    __extension__ typedef unsigned __int128 wide;
    if (decimal >= -27 && decimal <= 27) {
        uint64_t five = 1;
        for (int i = decimal < 0 ? -decimal : decimal; i; --i) five *= 5;
        int shift = binary + decimal;
        if (decimal >= 0 && shift <= 0) {
            wide product = (wide)mantissa * five;
            return shift == 0     ? (uint64_t)product
                   : shift < -120 ? 0
                                  : (uint64_t)(((product >> (-shift - 1)) + 1) >> 1);
        }
        if (decimal < 0 && shift >= 0 && shift < 64)
            return (uint64_t)((((wide)mantissa << (shift + 1)) / five + 1) >> 1);
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
    double read = norma_number_of_decimal(digits, exponent);
    if ((float)read != value) return 0;
    double below = 0.5 * ((double)nextafterf(value, 0.0f) + (double)value);
    double above = (double)nextafterf(value, INFINITY);
    above = isinf(above) ? (double)value + ((double)value - below) : 0.5 * (above + (double)value);
    return read > below && read < above;
}

static int reads_back(double value, int is_float, uint64_t digits, int exponent) {
    return is_float ? reads_back_as_float((float)value, digits, exponent)
                    : norma_number_of_decimal(digits, exponent) == value;
}

/* number * 10^exponent, rounded once: powers up to the 22nd are doubles. */
static double times_power(double number, int exponent) {
    static const double power[] = {
        1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13};
    return exponent < 0 ? number / power[-exponent] : number * power[exponent];
}

/* The middle between two floats, neither of them subnormal: a bit more than a float has. */
static int is_middle(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (bits & 0x1fffffff) == 0x10000000;
}

/* The shortest digits of a float of ordinary size, in doubles: a number scaled to at most nine
 * digits is off by less than 1e-6, so that its rounding is certain unless it lies near a half.
 * What is read back is rounded once, as by norma_number_of_decimal. 0: it cannot be told so. */
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
