/* message.c: messages, put together without the C library's formats, whose numbers follow the
 * locale. */
#include "check/findings/check_run.h"
#include <math.h>
#include <stdarg.h>
#include <string.h>

typedef struct text {
    char *out;
    size_t length;
} text;

static void add(text *t, const char *from, size_t length) {
    size_t room = CHECK_MESSAGE - 1 - t->length;
    length = length < room ? length : room;
    memcpy(t->out + t->length, from, length);
    t->length += length;
}

static void add_size(text *t, size_t value) {
    char digits[24];
    size_t at = sizeof digits;
    do {
        digits[--at] = (char)('0' + value % 10);
        value /= 10;
    } while (value);
    add(t, digits + at, sizeof digits - at);
}

/* Three digits as an integer below 1000 and the power of ten of the first. By divisions alone: the
 * C library's log10 and pow differ between systems. */
static unsigned three_digits(double value, int *power) {
    static const double tens[] = {1e1, 1e2, 1e4, 1e8, 1e16, 1e32, 1e64, 1e128, 1e256};
    *power = 0;
    for (int i = 8; i >= 0; i--)
        if (value >= tens[i]) {
            value /= tens[i];
            *power += 1 << i;
        }
    for (int i = 8; i >= 0 && value < 1; i--)
        if (value * tens[i] < 10) {
            value *= tens[i];
            *power -= 1 << i;
        }
    unsigned digits = (unsigned)(value * 100 + 0.5);
    if (digits >= 1000) {
        digits = (digits + 5) / 10;
        ++*power;
    }
    return digits < 100 ? 100 : digits;
}

/* digits with the point behind the first, zeros behind it left out: 1.02, 1.2, 1. */
static void add_digits(text *t, unsigned digits, int before_point) {
    char all[4] = {
        (char)('0' + digits / 100), (char)('0' + digits / 10 % 10), (char)('0' + digits % 10), 0};
    int last = all[2] != '0' ? 3 : all[1] != '0' ? 2 : 1;
    for (int i = 0; i < 3 && (i < last || i < before_point); i++) {
        if (i == before_point) add(t, ".", 1);
        add(t, &all[i], 1);
    }
}

static void add_small(text *t, unsigned digits, int power) {
    add(t, "0.", 2);
    for (int i = -1; i > power; i--) add(t, "0", 1);
    while (digits % 10 == 0) digits /= 10;
    add_size(t, digits);
}

static void add_large(text *t, unsigned digits, int power) {
    add_digits(t, digits, 3);
    for (int i = 2; i < power; i++) add(t, "0", 1);
}

static void add_number(text *t, double value) {
    int power;
    if (isnan(value) || isinf(value) || value == 0) {
        add(t,
            isnan(value) ? "NaN"
            : value == 0 ? "0"
            : value < 0  ? "-infinity"
                         : "infinity",
            strlen(isnan(value) ? "NaN"
                   : value == 0 ? "0"
                   : value < 0  ? "-infinity"
                                : "infinity"));
        return;
    }
    if (value < 0) add(t, "-", 1);
    unsigned digits = three_digits(fabs(value), &power);
    if (power >= 0 && power < 3) {
        add_digits(t, digits, power + 1);
    } else if (power >= 3 && power < 6) {
        add_large(t, digits, power);
    } else if (power < 0 && power >= -4) {
        add_small(t, digits, power);
    } else {
        add_digits(t, digits, 1);
        add(t, power < 0 ? "e-" : "e", power < 0 ? 2 : 1);
        add_size(t, (size_t)(power < 0 ? -power : power));
    }
}

static void write_message(char out[CHECK_MESSAGE], const char *format, va_list arguments) {
    text t = {out, 0};
    for (const char *at = format; *at; at++) {
        const char *special = at[0] == '%' ? &at[1] : NULL;
        if (!special) {
            add(&t, at, 1);
            continue;
        }
        if (*special == 's') {
            const char *word = va_arg(arguments, const char *);
            add(&t, word, strlen(word));
        } else if (*special == 'z') {
            add_size(&t, va_arg(arguments, size_t));
        } else if (*special == 'g') {
            add_number(&t, va_arg(arguments, double));
        } else {
            add(&t, "%", 1);
        }
        at++;
    }
    out[t.length] = 0;
}

void norma_check_message(char out[CHECK_MESSAGE], const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    write_message(out, format, arguments);
    va_end(arguments);
}

norma_result norma_check_report(check_mesh *m, check_report *report, const char *format, ...) {
    char message[CHECK_MESSAGE];
    va_list arguments;
    va_start(arguments, format);
    write_message(message, format, arguments);
    va_end(arguments);
    report->message = message;
    return norma_check_add(m->run, &m->place, m, report);
}
