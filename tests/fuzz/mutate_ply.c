/* mutate_ply.c: a PLY header stays lines of words: counts, types, names, formats and whole lines
 * change; the body is bytes. */
#include "mutate.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const types[] = {"char", "uchar", "short", "ushort", "int", "uint", "float",
    "double", "int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64", "list"};
static const char *const names[] = {"x", "y", "z", "nx", "ny", "nz", "vertex_indices",
    "vertex_index", "s", "t", "red", "green", "blue", "alpha", "confidence", "flags"};
static const char *const counts[] = {"0", "1", "2", "3", "4", "8", "255", "65535", "65536",
    "2147483647", "2147483648", "4294967295", "4294967296", "18446744073709551615",
    "18446744073709551616", "-1", "1e3"};
static const char *const lines[] = {"property float nx\nproperty float ny\nproperty float nz\n",
    "property list uchar int vertex_indices\n", "property list uchar uint vertex_index\n",
    "property list ushort ushort vertex_indices\n", "property double x\n",
    "property float x\nproperty float y\nproperty float z\n", "property uchar red\n",
    "element vertex 3\n", "element face 1\n", "element edge 2\n", "element tristrips 1\n",
    "comment c\n", "obj_info o\n", "format ascii 1.0\n", "format binary_little_endian 1.0\n",
    "format binary_big_endian 1.0\n", "property list float int vertex_indices\n",
    "property list char float texcoord\n"};
#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

enum { MOST_PARTS = 256 };
typedef struct part {
    size_t begin, end;
} part;

static size_t header_size(const uint8_t *bytes, size_t size) {
    static const char end[] = "end_header\n";
    if (size < 4 || memcmp(bytes, "ply", 3) != 0) return 0;
    for (size_t i = 0; i + sizeof end - 1 <= size; ++i)
        if (memcmp(bytes + i, end, sizeof end - 1) == 0) return i + sizeof end - 1;
    return 0;
}

static size_t find_parts(
    const uint8_t *bytes, size_t begin, size_t end, const char *between, part *parts) {
    size_t count = 0;
    for (size_t at = begin; at < end && count < MOST_PARTS;) {
        size_t stop = at;
        while (stop < end && !strchr(between, bytes[stop] ? bytes[stop] : 'x')) ++stop;
        if (stop > at) parts[count++] = (part){at, stop};
        at = stop + 1;
    }
    return count;
}

static size_t splice(
    uint8_t *bytes, size_t size, size_t capacity, part old, const char *text, size_t length) {
    size_t rest = size - old.end;
    if (old.begin + length + rest > capacity) return size;
    memmove(bytes + old.begin + length, bytes + old.end, rest);
    memcpy(bytes + old.begin, text, length);
    return old.begin + length + rest;
}

static const char *other_word(const char *word, fuzz_random *random) {
    if (word[0] >= '0' && word[0] <= '9') return counts[fuzz_random_below(random, COUNT(counts))];
    for (size_t i = 0; i < COUNT(types); ++i)
        if (strncmp(word, types[i], strlen(types[i])) == 0)
            return types[fuzz_random_below(random, COUNT(types))];
    return names[fuzz_random_below(random, COUNT(names))];
}

static size_t mutate_header(
    uint8_t *bytes, size_t size, size_t capacity, size_t header, fuzz_random *random) {
    part line[MOST_PARTS], word[MOST_PARTS];
    size_t line_count = find_parts(bytes, 4, header - 11, "\n", line);
    if (!line_count) return LLVMFuzzerMutate(bytes, size, capacity);
    part chosen = line[fuzz_random_below(random, line_count)],
         other = line[fuzz_random_below(random, line_count)],
         after = {chosen.end + 1, chosen.end + 1};
    const char *text = lines[fuzz_random_below(random, COUNT(lines))];
    char copy[256];
    size_t length = other.end + 1 - other.begin;
    switch (fuzz_random_below(random, 8)) {
    case 0:
        return splice(bytes, size, capacity, (part){chosen.begin, chosen.end + 1}, "", 0);
    case 1:
        return splice(bytes, size, capacity, after, text, strlen(text));
    case 2:
        if (length > sizeof copy) return size;
        memcpy(copy, bytes + other.begin, length);
        return splice(bytes, size, capacity, after, copy, length);
    default: {
        size_t words = find_parts(bytes, chosen.begin, chosen.end, " ", word);
        if (!words) return size;
        part at = word[fuzz_random_below(random, words)];
        snprintf(copy, sizeof copy, "%.*s", (int)(at.end - at.begin < 40 ? at.end - at.begin : 40),
            (const char *)bytes + at.begin);
        const char *instead = other_word(copy, random);
        return splice(bytes, size, capacity, at, instead, strlen(instead));
    }
    }
}

size_t fuzz_mutate_ply(uint8_t *bytes, size_t size, size_t capacity, fuzz_random *random) {
    size_t header = header_size(bytes, size);
    if (!header) return 0;
    if (fuzz_random_below(random, 2)) return mutate_header(bytes, size, capacity, header, random);
    return header + (capacity > header
                            ? LLVMFuzzerMutate(bytes + header, size - header, capacity - header)
                            : 0);
}
