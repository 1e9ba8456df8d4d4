/* row_value.c: the types of PLY values; single values, binary in either byte order and as text; the
 * size of a binary row. */
#include "io/ply/ply.h"
#include "io/text/number.h"
#include <math.h>

static const struct {
    const char *name, *bits_name;
    size_t size;
} types[] = {
    [PLY_INT8] = {"char", "int8", 1},
    [PLY_UINT8] = {"uchar", "uint8", 1},
    [PLY_INT16] = {"short", "int16", 2},
    [PLY_UINT16] = {"ushort", "uint16", 2},
    [PLY_INT32] = {"int", "int32", 4},
    [PLY_UINT32] = {"uint", "uint32", 4},
    [PLY_FLOAT] = {"float", "float32", 4},
    [PLY_DOUBLE] = {"double", "float64", 8},
    [PLY_NO_TYPE] = {"", "", 0},
};

size_t norma_ply_type_size(ply_type type) { return types[type].size; }
const char *norma_ply_type_name(ply_type type, int with_bits) {
    return with_bits ? types[type].bits_name : types[type].name;
}

int norma_ply_is_native(ply_encoding encoding) {
    const uint16_t probe = 1;
    unsigned char first;
    memcpy(&first, &probe, 1);
    return encoding == (first ? PLY_LITTLE_ENDIAN : PLY_BIG_ENDIAN);
}

static uint64_t load(const unsigned char *at, size_t size, ply_encoding encoding) {
    uint64_t bits = 0;
    for (size_t i = 0; i < size; ++i)
        bits = bits << 8 | at[encoding == PLY_BIG_ENDIAN ? i : size - 1 - i];
    return bits;
}

static void store(unsigned char *at, size_t size, ply_encoding encoding, uint64_t bits) {
    for (size_t i = 0; i < size; ++i)
        at[encoding == PLY_BIG_ENDIAN ? size - 1 - i : i] = (unsigned char)(bits >> (8 * i));
}

int64_t norma_ply_get_integer(const unsigned char *at, ply_type type, ply_encoding encoding) {
    switch (type) {
    case PLY_INT8:
        return *at < 0x80 ? *at : (int64_t)*at - 0x100;
    case PLY_UINT8:
        return *at;
    case PLY_INT16: {
        int64_t value = (int64_t)load(at, 2, encoding);
        return value < 0x8000 ? value : value - 0x10000;
    }
    case PLY_UINT16:
        return (int64_t)load(at, 2, encoding);
    case PLY_INT32: {
        int64_t value = (int64_t)load(at, 4, encoding);
        return value < INT64_C(0x80000000) ? value : value - INT64_C(0x100000000);
    }
    default:
        return (int64_t)load(at, 4, encoding);
    }
}

double norma_ply_get(const unsigned char *at, ply_type type, ply_encoding encoding) {
    if (type == PLY_FLOAT) {
        uint32_t bits = (uint32_t)load(at, 4, encoding);
        float value;
        memcpy(&value, &bits, sizeof value);
        return (double)value;
    }
    if (type == PLY_DOUBLE) {
        uint64_t bits = load(at, 8, encoding);
        double value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    return (double)norma_ply_get_integer(at, type, encoding);
}

void norma_ply_put(unsigned char *at, ply_type type, ply_encoding encoding, double value) {
    if (type == PLY_FLOAT) {
        float narrow = (float)value;
        uint32_t bits;
        memcpy(&bits, &narrow, sizeof bits);
        store(at, 4, encoding, bits);
    } else if (type == PLY_DOUBLE) {
        uint64_t bits;
        memcpy(&bits, &value, sizeof bits);
        store(at, 8, encoding, bits);
    } else {
        store(at, norma_ply_type_size(type), encoding, (uint64_t)(int64_t)value);
    }
}

int norma_ply_type_holds(ply_type type, double value) {
    static const double lowest[] = {
        [PLY_INT8] = -128, [PLY_INT16] = -32768, [PLY_INT32] = -2147483648.0, [PLY_DOUBLE] = 0};
    static const double highest[] = {[PLY_INT8] = 127,
        [PLY_UINT8] = 255,
        [PLY_INT16] = 32767,
        [PLY_UINT16] = 65535,
        [PLY_INT32] = 2147483647.0,
        [PLY_UINT32] = 4294967295.0,
        [PLY_DOUBLE] = 0};
    if (type == PLY_FLOAT) return !isfinite(value) || fabs(value) < 0x1.ffffffp127;
    if (type == PLY_DOUBLE) return 1;
    return value >= lowest[type] && value <= highest[type] && value == floor(value);
}

size_t norma_ply_format(ply_type type, double value, int unit, char text[32]) {
    if (type == PLY_DOUBLE && !unit) return norma_number_format_double(value, text);
    if (type >= PLY_FLOAT)
        return unit ? norma_number_format_normal((float)value, text)
                    : norma_number_format_float((float)value, text);
    size_t sign = value < 0;
    text[0] = '-';
    size_t length = sign + norma_number_format_integer((uint64_t)(int64_t)fabs(value), text + sign);
    text[length] = '\0';
    return length;
}

size_t norma_ply_property_size(
    const ply_header *header, const ply_property *property, const unsigned char *at) {
    if (!norma_ply_is_list(property)) return norma_ply_type_size(property->type);
    int64_t count = norma_ply_get_integer(at, property->count_type, header->encoding);
    return norma_ply_type_size(property->count_type) +
           (size_t)count * norma_ply_type_size(property->type);
}

const unsigned char *norma_ply_row_end(
    const ply_header *header, const ply_element *element, const unsigned char *row) {
    if (element->list_count == 0) return row + element->fixed_size;
    for (size_t i = 0; i < element->property_count; ++i)
        row += norma_ply_property_size(header, norma_ply_property(header, element, (int)i), row);
    return row;
}

/* ---- rows of one size */

size_t norma_ply_offset_in_row(const ply_header *header, const ply_element *element, int property) {
    size_t offset = 0;
    for (int i = 0; i < property; ++i)
        offset += norma_ply_type_size(norma_ply_property(header, element, i)->type);
    return offset;
}

void norma_ply_decode_rows(const ply_header *header, const ply_element *element,
    const int properties[3], const unsigned char *rows, size_t count, double *values) {
    for (int axis = 0; axis < 3; ++axis) {
        const ply_type type = norma_ply_property(header, element, properties[axis])->type;
        const unsigned char *at = rows + norma_ply_offset_in_row(header, element, properties[axis]);
        for (size_t row = 0; row < count; ++row, at += element->fixed_size)
            values[3 * row + (size_t)axis] = norma_ply_get(at, type, header->encoding);
    }
}

int norma_ply_fits_float(
    const ply_header *header, const ply_element *element, const int properties[3]) {
    for (int axis = 0; axis < 3; ++axis) {
        const ply_type type = norma_ply_property(header, element, properties[axis])->type;
        if (type == PLY_INT32 || type == PLY_UINT32 || type == PLY_DOUBLE) return 0;
    }
    return 1;
}

/* Each float lies before or on the double it comes from. */
void norma_ply_narrow(double *values, size_t count) {
    unsigned char *bytes = (unsigned char *)values;
    for (size_t i = 0; i < count; ++i) {
        const float value = (float)values[i];
        memcpy(bytes + i * sizeof value, &value, sizeof value);
    }
}

uint32_t norma_ply_copy_triangles(
    const unsigned char *at, size_t row_size, size_t count, uint32_t *corners) {
    uint32_t greatest = 0;
    for (size_t i = 0; i < count; ++i, at += row_size, corners += 3) {
        memcpy(corners, at, 12);
        for (size_t k = 0; k < 3; ++k) greatest = corners[k] > greatest ? corners[k] : greatest;
    }
    return greatest;
}
