/* members.c: members of the JSON, checked, and errors that name their place in it. */
#include "io/gltf/asset.h"
#include <stdio.h>
#include <string.h>

enum { QUOTE = 80 };

char *norma_gltf_pointer(const gltf *g, uint32_t token, char *out, size_t capacity) {
    uint32_t chain[JSON_DEPTH + 1];
    size_t depth = 0, used = 0;
    for (uint32_t t = token;
         t != JSON_NONE && g->json.tokens[t].parent != JSON_NONE && depth < JSON_DEPTH;
         t = g->json.tokens[t].parent)
        chain[depth++] = t;
    out[0] = '\0';
    while (depth-- > 0 && used + 1 < capacity) {
        uint32_t t = chain[depth], parent = g->json.tokens[t].parent, number = 0;
        int written;
        if (g->json.tokens[parent].type == JSON_OBJECT) {
            const json_token *key = &g->json.tokens[t - 1];
            written = snprintf(out + used, capacity - used, "/%.*s",
                (int)(key->end - key->start > 66 ? 64 : key->end - key->start - 2),
                g->text + key->start + 1);
        } else {
            for (uint32_t i = norma_json_first(&g->json, parent); i != t;
                 i = norma_json_next(&g->json, parent, i))
                ++number;
            written = snprintf(out + used, capacity - used, "/%u", (unsigned)number);
        }
        used += written > 0 ? (size_t)written : 0;
    }
    return out;
}

/* The beginning of a value as the file has it, without white space between its parts. */
static void quote(const gltf *g, uint32_t token, char out[QUOTE + 4]) {
    const json_token *t = &g->json.tokens[token];
    size_t used = 0, at = t->start;
    for (int inside = 0; at < t->end && used < QUOTE; ++at) {
        const char c = g->text[at];
        if (c == '"' && (at == t->start || g->text[at - 1] != '\\')) inside = !inside;
        if (inside || !strchr(" \t\r\n", c)) out[used++] = c;
    }
    while (at < t->end && (g->text[at] & 0xC0) == 0x80 && used > 0 && (out[--used] & 0xC0) == 0x80)
        continue;
    strcpy(out + used, at < t->end ? "..." : "");
}

norma_document_result norma_gltf_malformed(
    const gltf *g, norma_document_error *error, uint32_t token, const char *expected) {
    char place[200], found[QUOTE + 4] = "nothing";
    norma_gltf_pointer(g, token, place, sizeof place);
    if (token != JSON_NONE) quote(g, token, found);
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED,
        place[0] ? place : "/", "expected %s; found %s", expected, found);
}

int norma_gltf_size_member(const gltf *g, uint32_t object, const char *key, size_t *value) {
    uint32_t token = norma_json_member(&g->json, object, key);
    uint64_t read;
    if (token == JSON_NONE) return 1;
    if (!norma_json_uint(&g->json, token, &read) || read > SIZE_MAX / 4) return 0;
    *value = (size_t)read;
    return 1;
}

int norma_gltf_index_member(
    const gltf *g, uint32_t object, const char *key, uint32_t limit, uint32_t *value) {
    uint32_t token = norma_json_member(&g->json, object, key);
    uint64_t read;
    if (token == JSON_NONE) return 1;
    if (!norma_json_uint(&g->json, token, &read) || read >= limit) return 0;
    *value = (uint32_t)read;
    return 1;
}
