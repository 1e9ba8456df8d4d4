/* binary_rows.c: a PLY file cut into its rows and properties, read as plainly as can be and without
 * the library. */
#include "ply_rows.h"
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static size_t type_size(const char *type) {
    static const char *const names[] = {"char", "int8", "uchar", "uint8", "short", "int16",
        "ushort", "uint16", "int", "int32", "uint", "uint32", "float", "float32", "double",
        "float64"};
    static const size_t sizes[] = {1, 1, 1, 1, 2, 2, 2, 2, 4, 4, 4, 4, 4, 4, 8, 8};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i)
        if (strcmp(type, names[i]) == 0) return sizes[i];
    return 0;
}

static double number_at(const unsigned char *at, const char *type, int big) {
    unsigned char bytes[8];
    const size_t size = type_size(type);
    for (size_t i = 0; i < size; ++i)
        bytes[i] = at[big ? size - 1 - i : i]; /* this test runs on little-endian machines */
    if (type[0] == 'f' && size == 4) {
        float v;
        memcpy(&v, bytes, 4);
        return (double)v;
    }
    if (size == 8) {
        double v;
        memcpy(&v, bytes, 8);
        return v;
    }
    const int is_signed = type[0] != 'u';
    if (size == 1) return is_signed ? (double)(signed char)bytes[0] : (double)bytes[0];
    if (size == 2) {
        short v;
        memcpy(&v, bytes, 2);
        return is_signed ? (double)v : (double)(unsigned short)v;
    }
    int v;
    memcpy(&v, bytes, 4);
    return is_signed ? (double)v : (double)(unsigned)v;
}

static int parse_line(ply_rows *rows, const char *line) {
    char a[64], b[64], c[64], d[64];
    size_t count;
    rows_element *last = rows->element_count ? &rows->elements[rows->element_count - 1] : NULL;
    if (sscanf(line, "format %63s", a) == 1)
        rows->encoding = a[0] == 'a' ? 'a' : a[7] == 'l' ? 'l' : 'b';
    if (sscanf(line, "element %63s %zu", a, &count) == 2) {
        if (rows->element_count == ROWS_ELEMENTS) return 0;
        rows_element *element = &rows->elements[rows->element_count++];
        snprintf(element->name, sizeof element->name, "%s", a);
        element->count = count;
    } else if (sscanf(line, "property list %15s %15s %63s", b, c, d) == 3 ||
               sscanf(line, "property %15s %63s", c, d) == 2) {
        const int is_list = strncmp(line, "property list", 13) == 0;
        if (!last || last->property_count == ROWS_PROPERTIES) return 0;
        rows_property *property = &last->properties[last->property_count++];
        snprintf(property->name, sizeof property->name, "%s", d);
        snprintf(property->type, sizeof property->type, "%.15s", c);
        snprintf(property->count_type, sizeof property->count_type, "%.15s", is_list ? b : "");
    }
    return 1;
}

static int parse_header(const unsigned char *data, size_t size, ply_rows *rows) {
    char line[512];
    const int cr = size > 4 && data[3] == '\r' && data[4] != '\n';
    for (size_t at = 0; at < size;) {
        size_t length = 0;
        while (at < size && data[at] != (cr ? '\r' : '\n') && length < sizeof line - 1)
            line[length++] = (char)data[at++];
        ++at;
        while (length && isspace((unsigned char)line[length - 1])) --length;
        line[length] = '\0';
        if (!parse_line(rows, line)) return 0;
        if (strcmp(line, "end_header") == 0) {
            rows->header_size = at;
            return 1;
        }
    }
    return 0;
}

static const unsigned char *word(
    const unsigned char *at, const unsigned char *end, rows_value *out) {
    while (at < end && isspace(*at)) ++at;
    out->at = at;
    while (at < end && !isspace(*at)) ++at;
    out->size = (size_t)(at - out->at);
    return at;
}

static const unsigned char *cut_text(const rows_property *property, const unsigned char *at,
    const unsigned char *end, rows_value *out) {
    rows_value item;
    at = word(at, end, out);
    if (!property->count_type[0]) return at;
    for (long left = strtol((const char *)out->at, NULL, 10); left > 0; --left) {
        at = word(at, end, &item);
        out->size = (size_t)(at - out->at);
    }
    return at;
}

static const unsigned char *cut_binary(
    const ply_rows *rows, const rows_property *property, const unsigned char *at, rows_value *out) {
    out->at = at;
    out->size = type_size(property->type);
    if (property->count_type[0])
        out->size = type_size(property->count_type) +
                    (size_t)number_at(at, property->count_type, rows->encoding == 'b') *
                        type_size(property->type);
    return at + out->size;
}

int rows_parse(const unsigned char *data, size_t size, ply_rows *rows) {
    memset(rows, 0, sizeof *rows);
    if (!parse_header(data, size, rows)) return 0;
    const unsigned char *at = data + rows->header_size, *end = data + size;
    for (size_t e = 0; e < rows->element_count; ++e) {
        rows_element *element = &rows->elements[e];
        element->values =
            calloc(element->count * element->property_count + 1, sizeof *element->values);
        for (size_t i = 0; i < element->count * element->property_count; ++i) {
            const rows_property *property = &element->properties[i % element->property_count];
            if (at >= end) return 0;
            at = rows->encoding == 'a' ? cut_text(property, at, end, &element->values[i])
                                       : cut_binary(rows, property, at, &element->values[i]);
        }
    }
    if (at > end) return 0;
    rows->rest = (rows_value){at, (size_t)(end - at)};
    return 1;
}

void rows_free(ply_rows *rows) {
    for (size_t i = 0; i < rows->element_count; ++i) free(rows->elements[i].values);
}

const rows_element *rows_find(const ply_rows *rows, const char *element) {
    for (size_t i = 0; i < rows->element_count; ++i)
        if (strcmp(rows->elements[i].name, element) == 0) return &rows->elements[i];
    return NULL;
}

int rows_property_of(const rows_element *element, const char *name) {
    for (size_t i = 0; element && i < element->property_count; ++i)
        if (strcmp(element->properties[i].name, name) == 0) return (int)i;
    return -1;
}

rows_value rows_value_of(const rows_element *element, size_t row, int property) {
    return element->values[row * element->property_count + (size_t)property];
}

double rows_number(
    const ply_rows *rows, const rows_element *element, size_t row, const char *name) {
    const int property = rows_property_of(element, name);
    const rows_value value = rows_value_of(element, row, property);
    return rows->encoding == 'a'
               ? strtod((const char *)value.at, NULL)
               : number_at(value.at, element->properties[property].type, rows->encoding == 'b');
}

size_t rows_list(
    const ply_rows *rows, const rows_element *element, size_t row, int property, long long *out) {
    const rows_value value = rows_value_of(element, row, property);
    const rows_property *of = &element->properties[property];
    if (rows->encoding == 'a') {
        char *at;
        const size_t count = (size_t)strtol((const char *)value.at, &at, 10);
        for (size_t i = 0; i < count && out; ++i) out[i] = strtoll(at, &at, 10);
        return count;
    }
    const int big = rows->encoding == 'b';
    const size_t count = (size_t)number_at(value.at, of->count_type, big);
    for (size_t i = 0; i < count && out; ++i)
        out[i] = (long long)number_at(
            value.at + type_size(of->count_type) + i * type_size(of->type), of->type, big);
    return count;
}
