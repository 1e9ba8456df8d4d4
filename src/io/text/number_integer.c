/* number_integer.c: whole numbers as decimal text, two digits at a time. */
#include "io/text/number.h"
#include <string.h>

/* "00" to "99": two digits for one division. */
static const char pairs[] = "0001020304050607080910111213141516171819202122232425262728293031323334"
                            "3536373839404142434445464748495051525354555657585960616263646566676869"
                            "707172737475767778798081828384858687888990919293949596979899";

static size_t digits_of(uint64_t value) {
    size_t digits = 1;
    for (; value >= 10000; value /= 10000) digits += 4;
    return digits + (value >= 10) + (value >= 100) + (value >= 1000);
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
