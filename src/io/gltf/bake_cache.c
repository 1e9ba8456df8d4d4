/* bake_cache.c: what several primitives share stays shared where the matrix is the same: contents
 * are found again by what they were made of. */
#include "io/gltf/bake.h"
#include "io/gltf/node_matrix.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

void norma_gltf_bake_cache_free(bake_cache *cache) {
    free(cache->entries);
    free(cache->heads);
    free(cache->matrices);
    *cache = (bake_cache){0};
}

static size_t hash(const bake_entry *key) {
    uint64_t h = key->role;
    h = (h ^ key->a) * 0x9E3779B97F4A7C15u;
    h = (h ^ (h >> 32) ^ key->b) * 0x9E3779B97F4A7C15u;
    h = (h ^ (h >> 32) ^ key->map) * 0x9E3779B97F4A7C15u;
    return (size_t)(h ^ (h >> 32));
}

int norma_gltf_bake_cache_find(const bake_cache *cache, const bake_entry *key, uint32_t *data) {
    if (cache->head_count == 0) return 0;
    for (uint32_t i = cache->heads[hash(key) % cache->head_count]; i != GLTF_NONE;
         i = cache->entries[i].after) {
        const bake_entry *entry = &cache->entries[i];
        if (entry->role == key->role && entry->a == key->a && entry->b == key->b &&
            entry->map == key->map) {
            *data = entry->data;
            return 1;
        }
    }
    return 0;
}

static void link_entry(bake_cache *cache, uint32_t number) {
    uint32_t *head = &cache->heads[hash(&cache->entries[number]) % cache->head_count];
    cache->entries[number].after = *head;
    *head = number;
}

static int rehash(bake_cache *cache, size_t head_count) {
    uint32_t *heads = norma_io_allocate(head_count, sizeof *heads);
    if (!heads) return 0;
    free(cache->heads);
    cache->heads = heads;
    cache->head_count = head_count;
    for (size_t i = 0; i < head_count; i++) heads[i] = GLTF_NONE;
    for (size_t i = 0; i < cache->count; i++) link_entry(cache, (uint32_t)i);
    return 1;
}

int norma_gltf_bake_cache_add(bake_cache *cache, const bake_entry *entry) {
    bake_entry *grown =
        cache->count < GLTF_NONE - 1
            ? norma_io_grow(cache->entries, &cache->capacity, cache->count + 1, sizeof *grown)
            : NULL;
    if (!grown) return 0;
    cache->entries = grown;
    if (cache->count >= cache->head_count && !rehash(cache, 2 * cache->head_count + 64)) return 0;
    cache->entries[cache->count] = *entry;
    link_entry(cache, (uint32_t)cache->count++);
    return 1;
}

/* Whether normals stay as they are: the normal matrix is a multiple of the identity, as far as
 * doubles tell. */
static int keeps_directions(const double n[9]) {
    const double size = n[0];
    if (!(size > 0)) return 0;
    for (int i = 0; i < 9; i++)
        if (fabs(n[i] - (i % 4 == 0 ? size : 0)) > 1e-15 * size) return 0;
    return 1;
}

/* The one direction that is left where a matrix flattens: the longest column; +Z where nothing is.
 */
static void find_fallback(bake_map *map) {
    double longest = 0;
    map->fallback[0] = map->fallback[1] = 0;
    map->fallback[2] = 1;
    for (int i = 0; i < 3; i++) {
        const double *c = map->normal + 3 * i,
                     length = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
        if (length <= longest) continue;
        longest = length;
        for (int k = 0; k < 3; k++) map->fallback[k] = c[k] / length;
    }
}

#define MATRIX_ROLE UINT32_MAX

/* The number of an equal matrix seen before, or of this one from now on. The table of contents
 * serves for matrices too: by two halves of a hash of their bits. */
static int identify(bake_cache *cache, bake_map *map) {
    uint64_t bits[16], mixed = 0;
    for (int i = 0; i < 16; i++) map->matrix[i] += 0.0; /* -0 is 0 */
    memcpy(bits, map->matrix, sizeof bits);
    for (int i = 0; i < 16; i++) mixed = (mixed ^ bits[i] ^ (mixed >> 29)) * 0xBF58476D1CE4E5B9u;
    bake_entry key = {MATRIX_ROLE, (uint32_t)mixed, (uint32_t)(mixed >> 32), 0, 0, 0};
    for (; norma_gltf_bake_cache_find(cache, &key, &map->id); key.map++)
        if (memcmp(cache->matrices[map->id], map->matrix, sizeof map->matrix) == 0) return 1;
    double(*grown)[16] = norma_io_grow(
        cache->matrices, &cache->matrix_capacity, cache->matrix_count + 1, sizeof *grown);
    if (!grown) return 0;
    cache->matrices = grown;
    memcpy(cache->matrices[cache->matrix_count], map->matrix, sizeof map->matrix);
    key.data = map->id = (uint32_t)cache->matrix_count++;
    return norma_gltf_bake_cache_add(cache, &key);
}

int norma_gltf_bake_map(bake_cache *cache, const double matrix[16], bake_map *map) {
    norma_matrix_info info;
    memcpy(map->matrix, matrix, sizeof map->matrix);
    norma_normal_matrix_double(matrix, NORMA_WINDING_REVERSED, map->normal, &info);
    map->mirrored = info.mirrored;
    map->rank = info.rank;
    map->turns = !keeps_directions(map->normal);
    find_fallback(map);
    return identify(cache, map);
}
