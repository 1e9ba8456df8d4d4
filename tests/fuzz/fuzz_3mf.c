/* fuzz_3mf.c: any bytes as a 3MF; and as the XML of a model in one that is otherwise fine, since
 * hardly any mutation of a zip gets past its checksums. */
#include "fuzz.h"
#include <stdlib.h>
#include <string.h>

static void store(uint8_t *to, size_t value, int width) {
    for (int i = 0; i < width; ++i) to[i] = (uint8_t)(value >> 8 * i);
}

static uint32_t sum_of(const uint8_t *bytes, size_t size) {
    uint32_t sum = UINT32_MAX;
    for (size_t i = 0; i < size; ++i) {
        sum ^= bytes[i];
        for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ (sum & 1 ? 0xEDB88320U : 0);
    }
    return ~sum;
}

typedef struct made_zip {
    uint8_t *bytes, directory[200];
    size_t size, directory_size;
} made_zip;

static void add_member(made_zip *z, const char *name, const void *content, size_t size) {
    const size_t length = strlen(name);
    uint8_t *local = z->bytes + z->size, *entry = z->directory + z->directory_size;
    memcpy(local, "PK\3\4\24", 5);
    store(local + 14, sum_of(content, size), 4);
    store(local + 18, size, 4);
    store(local + 22, size, 4);
    store(local + 26, length, 2);
    memcpy(entry, "PK\1\2", 4);
    memcpy(entry + 6, local + 4, 26);
    store(entry + 42, z->size, 4);
    memcpy(entry + 46, name, length);
    memcpy(local + 30, name, length);
    memcpy(local + 30 + length, content, size);
    z->directory_size += 46 + length;
    z->size += 30 + length + size;
}

static void read_model(const uint8_t *bytes, size_t size) {
    static const char rels[] =
        "<R><Relationship Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\" "
        "Target=\"/m\"/></R>";
    made_zip z = {.bytes = calloc(size + 1000, 1)};
    if (!z.bytes) return;
    add_member(&z, "_rels/.rels", rels, sizeof rels - 1);
    add_member(&z, "m", bytes, size);
    const size_t at = z.size;
    memcpy(z.bytes + at, z.directory, z.directory_size);
    uint8_t *end = z.bytes + at + z.directory_size;
    memcpy(end, "PK\5\6", 4);
    store(end + 8, 2, 2);
    store(end + 10, 2, 2);
    store(end + 12, z.directory_size, 4);
    store(end + 16, at, 4);
    fuzz_reader(z.bytes, at + z.directory_size + 22, NORMA_FILE_3MF);
    free(z.bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    if (size && bytes[0] == '<')
        read_model(bytes, size);
    else
        fuzz_reader(bytes, size, NORMA_FILE_3MF);
    return 0;
}
