/* json_text.c: how numbers and strings stand in JSON. */
#include "io/text/json.h"
#include "io/text/number.h"
#include <string.h>

void norma_json_add(json_text *text, const char *bytes, size_t size) {
    norma_io_append(text, bytes, size);
}

void norma_json_add_text(json_text *text, const char *terminated) {
    norma_json_add(text, terminated, strlen(terminated));
}

void norma_json_add_uint(json_text *text, uint64_t value) {
    char digits[20];
    norma_json_add(text, digits, norma_number_format_integer(value, digits));
}

void norma_json_add_number(json_text *text, double value) {
    char digits[32];
    norma_json_add(text, digits, norma_number_format_double(value, digits));
}

void norma_json_add_float(json_text *text, float value) {
    char digits[32];
    norma_json_add(text, digits, norma_number_format_float(value, digits));
}

void norma_json_add_quoted(json_text *text, const char *utf8) {
    norma_json_add(text, "\"", 1);
    for (; *utf8; ++utf8) {
        unsigned char c = (unsigned char)*utf8;
        if (c == '"' || c == '\\') {
            const char escape[2] = {'\\', (char)c};
            norma_json_add(text, escape, 2);
        } else if (c < 0x20) {
            static const char hex[] = "0123456789abcdef";
            const char escape[6] = {'\\', 'u', '0', '0', hex[c >> 4], hex[c & 15]};
            norma_json_add(text, escape, 6);
        } else {
            norma_json_add(text, utf8, 1);
        }
    }
    norma_json_add(text, "\"", 1);
}
