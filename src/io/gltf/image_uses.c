/* image_uses.c: how often the JSON names each texture and each image. Extensions name them in ways
 * of their own, so each number counts whose key, or the key of whose list or object, speaks of
 * textures or images: it is better to copy one in vain than to change what something else shows. */
#include "io/gltf/patch.h"

static int letter(char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; }

/* word: in small letters. */
static int contains(const json *j, uint32_t key, const char *word) {
    const json_token *token = &j->tokens[key];
    for (size_t at = token->start; at < token->end; ++at) {
        size_t k = 0;
        while (word[k] && at + k < token->end && letter(j->text[at + k]) == word[k]) ++k;
        if (!word[k]) return 1;
    }
    return 0;
}

/* Of a value the key under which it, or the lists around it, stand; JSON_NONE: none. */
static uint32_t use_key_of(const json *j, uint32_t token) {
    uint32_t parent = j->tokens[token].parent;
    while (parent != JSON_NONE && j->tokens[parent].type == JSON_ARRAY) {
        token = parent;
        parent = j->tokens[token].parent;
    }
    return parent == JSON_NONE ? JSON_NONE : token - 1;
}

/* What an object that names a texture says besides. */
static int is_other_member(const json *j, uint32_t key) {
    static const char *const others[] = {
        "texCoord", "scale", "strength", "rotation", "offset", "source", "sampler"};
    for (size_t i = 0; i < sizeof others / sizeof *others; ++i)
        if (norma_json_equals(j, key, others[i])) return 1;
    return 0;
}

static int speaks_of(const json *j, uint32_t token, const char *word) {
    const uint32_t key = use_key_of(j, token);
    if (key == JSON_NONE || contains(j, key, word)) return key != JSON_NONE;
    const uint32_t object = j->tokens[key].parent, above = j->tokens[object].parent;
    return above != JSON_NONE && j->tokens[above].type == JSON_OBJECT &&
           contains(j, object - 1, word) && !is_other_member(j, key);
}

static void count_index_uses(
    const gltf *g, const char *word, const char *member, uint32_t *counts, size_t count) {
    const json *j = &g->json;
    uint64_t number;
    for (uint32_t token = 1; token < j->count; ++token) {
        const int is_member = j->tokens[j->tokens[token].parent].type == JSON_OBJECT;
        if (is_member && norma_json_equals(j, token - 1, "extras")) {
            token = j->tokens[token].next - 1;
            continue;
        }
        if (j->tokens[token].type == JSON_NUMBER && norma_json_uint(j, token, &number) &&
            number < count &&
            (speaks_of(j, token, word) ||
                (is_member && member && norma_json_equals(j, token - 1, member))))
            ++counts[number];
    }
}

void norma_gltf_count_texture_uses(const gltf *g, uint32_t *counts, size_t textures) {
    count_index_uses(g, "texture", NULL, counts, textures);
}

void norma_gltf_count_image_uses(const gltf *g, uint32_t *counts, size_t images) {
    count_index_uses(g, "image", "source", counts, images);
}
