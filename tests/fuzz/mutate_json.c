/* mutate_json.c: JSON that stays JSON: a value is replaced, copied from elsewhere, dropped, doubled
 * or renamed, a member that glTF knows is put in, and the bytes in a data: URI are mutated behind
 * their base64. */
#include "mutate.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- where the values lie */

enum { MOST_VALUES = 4096, DEEPEST = 64 };

typedef struct value {
    size_t begin, end;         /* of the value's text */
    size_t key_begin, key_end; /* of its key's, quotes included; equal: it is no member */
    char kind;                 /* its first character */
} value;

typedef struct parsed {
    const char *text;
    size_t size, at, count;
    value values[MOST_VALUES];
} parsed;

static void skip_blanks(parsed *p) {
    while (p->at < p->size && strchr(" \t\r\n", p->text[p->at]) && p->text[p->at]) ++p->at;
}

static int skip_string(parsed *p) {
    if (p->at >= p->size || p->text[p->at] != '"') return 0;
    for (++p->at; p->at < p->size && p->text[p->at] != '"'; ++p->at)
        p->at += p->text[p->at] == '\\';
    return p->at < p->size ? (++p->at, 1) : 0;
}

static int parse_value(parsed *p, int depth);

static int parse_item(parsed *p, int in_object, int depth) {
    size_t key_begin = p->at, key_end = p->at, number = p->count;
    if (in_object) {
        if (!skip_string(p)) return 0;
        key_end = p->at;
        skip_blanks(p);
        if (p->at >= p->size || p->text[p->at++] != ':') return 0;
        skip_blanks(p);
    }
    if (!parse_value(p, depth)) return 0;
    p->values[number].key_begin = key_begin;
    p->values[number].key_end = key_end;
    return 1;
}

static int parse_items(parsed *p, char end, int depth) {
    ++p->at;
    skip_blanks(p);
    if (p->at < p->size && p->text[p->at] == end) return ++p->at, 1;
    for (;;) {
        if (!parse_item(p, end == '}', depth)) return 0;
        skip_blanks(p);
        if (p->at >= p->size) return 0;
        char c = p->text[p->at++];
        if (c == end) return 1;
        if (c != ',') return 0;
        skip_blanks(p);
    }
}

static int parse_value(parsed *p, int depth) {
    if (p->count == MOST_VALUES || depth == DEEPEST || p->at >= p->size) return 0;
    size_t number = p->count++;
    char kind = p->text[p->at];
    p->values[number] = (value){.begin = p->at, .kind = kind};
    int ok = 1;
    if (kind == '{' || kind == '[') {
        ok = parse_items(p, kind == '{' ? '}' : ']', depth + 1);
    } else if (kind == '"') {
        ok = skip_string(p);
    } else {
        size_t begin = p->at;
        while (p->at < p->size && p->text[p->at] &&
               strchr("+-.0123456789abcdefghijklmnopqrstuvwxyzE", p->text[p->at]))
            ++p->at;
        ok = p->at > begin;
    }
    p->values[number].end = p->at;
    return ok;
}

static int parse(parsed *p, const char *text, size_t size) {
    p->text = text;
    p->size = size;
    p->at = p->count = 0;
    skip_blanks(p);
    return parse_value(p, 0);
}

/* ---- what may stand there instead */

static const char *const numbers[] = {"0", "1", "-1", "2", "3", "4", "5", "12", "16", "36", "255",
    "256", "65535", "65536", "2147483647", "2147483648", "4294967295", "4294967296", "1e10",
    "9007199254740993", "18446744073709551615", "18446744073709551616", "-0", "0.5", "1e-40",
    "1e308", "1e309", "-2147483648", "5120", "5121", "5122", "5123", "5125", "5126", "5130", "5131",
    "34962", "0.7071068"};
static const char *const strings[] = {"\"POSITION\"", "\"NORMAL\"", "\"SCALAR\"", "\"VEC2\"",
    "\"VEC3\"", "\"VEC4\"", "\"MAT4\"", "\"ATTRIBUTES\"", "\"TRIANGLES\"", "\"INDICES\"",
    "\"OCTAHEDRAL\"", "\"QUATERNION\"", "\"EXPONENTIAL\"", "\"EXT_mesh_gpu_instancing\"",
    "\"KHR_mesh_quantization\"", "\"KHR_accessor_float16\"", "\"KHR_accessor_float64\"",
    "\"EXT_meshopt_compression\"", "\"../a.bin\"", "\"a.bin\"", "\"data:,\"",
    "\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"",
    "\"\"", "\"\\u0000\"", "\"\\ud800\"", "\"2.0\"", "\"rotation\"", "\"scale\"", "\"CUBICSPLINE\"",
    "\"BLEND\""};
static const char *const members[] = {"\"POSITION\":0", "\"NORMAL\":1", "\"TANGENT\":0",
    "\"TEXCOORD_0\":0", "\"COLOR_0\":0", "\"JOINTS_0\":0", "\"WEIGHTS_0\":0", "\"indices\":0",
    "\"mode\":5", "\"mode\":6", "\"byteOffset\":4", "\"byteStride\":16", "\"byteLength\":64",
    "\"normalized\":true", "\"count\":3", "\"componentType\":5120", "\"max\":[1,1,1]",
    "\"min\":[0,0,0]", "\"mesh\":0", "\"skin\":0", "\"children\":[1]", "\"children\":[0]",
    "\"scale\":[2,-1,1]", "\"rotation\":[0,0,0.7071068,0.7071068]", "\"translation\":[1,2,3]",
    "\"matrix\":[1,0,0,0,0,2,0,0,0,0,3,0,0,0,0,1]", "\"name\":\"n\"", "\"material\":0",
    "\"doubleSided\":true", "\"targets\":[{\"POSITION\":0}]",
    "\"targets\":[{\"POSITION\":0,\"NORMAL\":1}]", "\"weights\":[0.5]",
    "\"extras\":{\"norma\":{\"ignore\":[\"N2\"]}}",
    "\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":0,\"componentType\":5121},\"values\":{"
    "\"bufferView\":0}}",
    "\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":0,\"SCALE\":0}}}",
    "\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":0,\"byteLength\":40,\"byteStride\":12,"
    "\"count\":3,\"mode\":\"ATTRIBUTES\"}}",
    "\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":0}}",
    "\"extensions\":{\"KHR_materials_variants\":{\"mappings\":[{\"material\":0,\"variants\":[0]}]}"
    "}",
    "\"extensionsRequired\":[\"KHR_mesh_quantization\"]",
    "\"skins\":[{\"joints\":[0],\"inverseBindMatrices\":0}]",
    "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}}],"
    "\"samplers\":[{\"input\":0,\"output\":0}]}]",
    "\"materials\":[{\"normalTexture\":{\"index\":0,\"texCoord\":1}}]",
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":0.1}}]",
    "\"camera\":0", "\"scene\":0", "\"scenes\":[{\"nodes\":[0]}]"};
static const char *const others[] = {
    "null", "true", "false", "{}", "[]", "[[[[[[[[]]]]]]]]", "{\"\":0}", "[0]", "[0,1,2]"};
#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

/* ---- the mutations: text between begin and end becomes other text */

typedef struct splice {
    size_t begin, end;
    const char *text;
    size_t length;
} splice;

static size_t apply(uint8_t *bytes, size_t size, size_t capacity, const splice *s) {
    size_t rest = size - s->end;
    if (s->length > capacity || s->begin + s->length + rest > capacity) return size;
    char *copy = malloc(s->length + 1);
    memcpy(copy, s->text, s->length);
    memmove(bytes + s->begin + s->length, bytes + s->end, rest);
    memcpy(bytes + s->begin, copy, s->length);
    free(copy);
    return s->begin + s->length + rest;
}

static const value *pick(const parsed *p, fuzz_random *random, const char *kinds) {
    size_t at = fuzz_random_below(random, p->count);
    for (size_t i = 0; i < p->count; ++i, at = (at + 1) % p->count)
        if (!kinds || strchr(kinds, p->values[at].kind)) return &p->values[at];
    return NULL;
}

static splice whole(const value *v, const char *text, size_t length) {
    return (splice){v->begin, v->end, text, length};
}

static splice change_number(const parsed *p, fuzz_random *random, char room[64]) {
    const value *v = pick(p, random, "-0123456789");
    if (!v) return (splice){0};
    long long old = atoll(p->text + v->begin) % 1000000000000000000;
    if (fuzz_random_below(random, 2)) {
        const char *text = numbers[fuzz_random_below(random, COUNT(numbers))];
        return whole(v, text, strlen(text));
    }
    int length = snprintf(room, 64, "%lld",
        old / 2 * 2 == old && fuzz_random_below(random, 3) == 0
            ? old / 2
            : old + (long long)fuzz_random_below(random, 9) - 4);
    return whole(v, room, (size_t)length);
}

static splice drop(const parsed *p, fuzz_random *random) {
    const value *v = pick(p, random, NULL);
    if (v == &p->values[0]) return (splice){0};
    size_t begin = v->key_end > v->key_begin ? v->key_begin : v->begin, end = v->end;
    while (end < p->size && p->text[end] && strchr(" \t\r\n", p->text[end])) ++end;
    if (end < p->size && p->text[end] == ',') return (splice){begin, end + 1, "", 0};
    while (begin > 0 && p->text[begin - 1] && strchr(" \t\r\n", p->text[begin - 1])) --begin;
    return begin > 0 && p->text[begin - 1] == ',' ? (splice){begin - 1, v->end, "", 0}
                                                  : (splice){begin, v->end, "", 0};
}

/* A copy of a member or an element stands in front of it. */
static splice repeat(const parsed *p, fuzz_random *random, char *room, size_t capacity) {
    const value *v = pick(p, random, NULL);
    size_t begin = v->key_end > v->key_begin ? v->key_begin : v->begin, length = v->end - begin;
    if (v == &p->values[0] || length + 1 > capacity) return (splice){0};
    memcpy(room, p->text + begin, length);
    room[length] = ',';
    return (splice){begin, begin, room, length + 1};
}

static splice add_member(const parsed *p, fuzz_random *random, char *room, size_t capacity) {
    const value *v = pick(p, random, "{");
    if (!v) return (splice){0};
    const char *text = members[fuzz_random_below(random, COUNT(members))];
    size_t inside = v->begin + 1;
    while (inside < p->size && p->text[inside] && strchr(" \t\r\n", p->text[inside])) ++inside;
    int length = snprintf(room, capacity, "%s%s", text, p->text[inside] == '}' ? "" : ",");
    return (splice){v->begin + 1, v->begin + 1, room, (size_t)length};
}

static splice rename_key(const parsed *p, fuzz_random *random, char *room, size_t capacity) {
    const value *to = pick(p, random, NULL);
    if (to->key_end == to->key_begin) return (splice){0};
    const char *text = members[fuzz_random_below(random, COUNT(members))];
    const value *from = pick(p, random, NULL);
    int known = fuzz_random_below(random, 2) || from->key_end == from->key_begin;
    size_t length = known ? strcspn(text, ":") : from->key_end - from->key_begin;
    if (length > capacity) return (splice){0};
    memcpy(room, known ? text : p->text + from->key_begin, length);
    return (splice){to->key_begin, to->key_end, room, length};
}

/* ---- data: URIs */

static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

static size_t decode(const char *text, size_t length, uint8_t *out) {
    uint32_t bits = 0;
    unsigned held = 0;
    size_t size = 0;
    for (size_t i = 0; i < length && text[i] != '='; ++i) {
        const char *letter = text[i] ? strchr(letters, text[i]) : NULL;
        if (!letter) return size;
        bits = bits << 6 | (uint32_t)(letter - letters);
        held += 6;
        if (held >= 8) {
            held -= 8;
            out[size++] = (uint8_t)(bits >> held);
        }
    }
    return size;
}

static size_t encode(const uint8_t *bytes, size_t size, char *out) {
    size_t length = 0;
    for (size_t i = 0; i < size; i += 3) {
        uint32_t bits = (uint32_t)bytes[i] << 16 |
                        (i + 1 < size ? (uint32_t)bytes[i + 1] << 8 : 0) |
                        (i + 2 < size ? bytes[i + 2] : 0);
        for (int k = 0; k < 4; ++k)
            out[length++] = i + (size_t)k > size ? '=' : letters[bits >> (18 - 6 * k) & 63];
    }
    return length;
}

static splice change_data(const parsed *p, fuzz_random *random, char *room, size_t capacity) {
    static const char head[] = "\"data:application/octet-stream;base64,";
    const value *v = pick(p, random, "\"");
    for (size_t i = 0; v && i < p->count; ++i) {
        if (p->values[i].kind == '"' && p->values[i].end - p->values[i].begin > 6 &&
            memcmp(p->text + p->values[i].begin, "\"data:", 6) == 0) {
            v = &p->values[i];
            if (fuzz_random_below(random, 2)) break;
        }
    }
    const char *comma = v ? memchr(p->text + v->begin, ',', v->end - v->begin) : NULL;
    size_t most = (capacity - sizeof head - 8) / 4 * 3;
    if (!comma || most < 3) return (splice){0};
    uint8_t *plain = malloc(most + p->size + 4);
    size_t size = decode(comma + 1, (size_t)(p->text + v->end - 1 - (comma + 1)), plain);
    size = size <= most ? LLVMFuzzerMutate(plain, size, most) : 0;
    memcpy(room, head, sizeof head - 1);
    size_t length = sizeof head - 1 + encode(plain, size, room + sizeof head - 1);
    room[length++] = '"';
    free(plain);
    return whole(v, room, length);
}

static splice choose(const parsed *p, fuzz_random *random, char *room, size_t capacity) {
    const value *to = pick(p, random, NULL), *from = pick(p, random, NULL);
    const char *text = others[fuzz_random_below(random, COUNT(others))];
    switch (fuzz_random_below(random, 16)) {
    case 0:
    case 1:
    case 2:
    case 3:
        return change_number(p, random, room);
    case 4:
    case 5:
        return drop(p, random);
    case 6:
        return repeat(p, random, room, capacity);
    case 7:
    case 8:
        return add_member(p, random, room, capacity);
    case 9:
        return rename_key(p, random, room, capacity);
    case 10:
    case 11:
    case 12:
        return change_data(p, random, room, capacity);
    case 13:
        return from->end - from->begin < capacity
                   ? whole(to, p->text + from->begin, from->end - from->begin)
                   : (splice){0};
    case 14:
        to = pick(p, random, "\"");
        text = strings[fuzz_random_below(random, COUNT(strings))];
        return to ? whole(to, text, strlen(text)) : (splice){0};
    default:
        return to == &p->values[0] ? (splice){0} : whole(to, text, strlen(text));
    }
}

size_t fuzz_mutate_json(uint8_t *bytes, size_t size, size_t capacity, fuzz_random *random) {
    parsed *p = malloc(sizeof *p);
    char *text = malloc(size + 1), *room = malloc(2 * capacity + 1024);
    size_t mutated = 0;
    memcpy(text, bytes, size);
    text[size] = '\0';
    if (parse(p, text, size)) {
        mutated = size;
        for (int tries = 0; tries < 8 && mutated == size; ++tries) {
            splice s = choose(p, random, room, 2 * capacity);
            if (s.end > 0) mutated = apply(bytes, size, capacity, &s);
            if (s.end > 0 && mutated == size && s.length == s.end - s.begin) break;
        }
    }
    free(room);
    free(text);
    free(p);
    return mutated;
}
