/* scene_memory.c: the memory that what is told of a document lives in. */
#include "io/format/scene.h"
#include <stdlib.h>
#include <string.h>

struct scene_block {
    scene_block *next;
    max_align_t bytes[];
};

void *norma_scene_allocate(norma_scene *scene, size_t count, size_t size) {
    if (size && count > (SIZE_MAX - sizeof(scene_block)) / size) return NULL;
    scene_block *block = norma_io_allocate(sizeof *block + count * size, 1);
    if (!block) return NULL;
    block->next = scene->blocks;
    scene->blocks = block;
    return block->bytes;
}

char *norma_scene_text(norma_scene *scene, const char *text) {
    size_t length = strlen(text);
    char *copy = norma_scene_allocate(scene, length + 1, 1);
    if (copy) memcpy(copy, text, length);
    return copy;
}

char *norma_scene_join(norma_scene *scene, const char *first, const char *second) {
    size_t a = strlen(first), b = strlen(second), comma = a && b;
    char *both = norma_scene_allocate(scene, a + comma + b + 1, 1);
    if (!both) return NULL;
    memcpy(both, first, a);
    if (comma) both[a] = ',';
    memcpy(both + a + comma, second, b);
    return both;
}

norma_scene *norma_scene_create(void) { return norma_io_allocate(1, sizeof(norma_scene)); }

void norma_scene_forget(norma_scene *scene) {
    if (!scene) return;
    for (scene_block *block = scene->blocks, *next; block; block = next) {
        next = block->next;
        free(block);
    }
    *scene = (norma_scene){0};
}

void norma_scene_destroy(norma_scene *scene) {
    if (!scene) return;
    norma_scene_forget(scene);
    free(scene);
}
