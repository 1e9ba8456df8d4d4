/* lesson_cells.c: the cells of the acid scenes for the page: of each, the right patch and one for
 * each mistake, in numbers and in words. */
#include "../../package/wasm/exports.h"
#include "acid/acid.h"
#include <stdlib.h>

/* Three numbers for each point; normals are as long as the mistake leaves them: zero where they are
 * lost. corners: a triangle's are three. */
typedef struct lesson_patch {
    uint32_t point_count, corner_count;
    float *positions, *normals;
    uint32_t *corners;
} lesson_patch;

size_t WEB_EXPORT(cell_count)(void) { return acid_cell_count; }
size_t WEB_EXPORT(cell_patches)(size_t cell) { return 1 + acid_fault_count(&acid_cells[cell]); }

/* which: what is tested, the sentence of the specification, and where that is. */
const char *WEB_EXPORT(cell_text)(size_t cell, int which) {
    const acid_cell *c = &acid_cells[cell];
    return which == 0 ? c->tested : which == 1 ? c->sentence : c->section;
}

/* The first is right. */
static acid_fault fault_of(size_t cell, size_t patch) {
    return patch ? acid_cells[cell].faults[patch - 1] : ACID_RIGHT;
}

/* which: the mistake's id, what happens, what a renderer does instead; "" where nothing is wrong.
 */
const char *WEB_EXPORT(patch_text)(size_t cell, size_t patch, int which) {
    const char *id = acid_fault_id(fault_of(cell, patch));
    const acid_mistake *mistake = acid_find_mistake(id);
    if (which == 0) return id;
    return !mistake ? "" : which == 1 ? mistake->words : mistake->mend;
}

/* Lines of norma.glsl that do so: at lines[0], lines[1] bytes. 0: there is no such function. */
int WEB_EXPORT(patch_shader)(size_t cell, size_t patch, size_t function, size_t lines[2]) {
    const acid_mistake *mistake = acid_find_mistake(acid_fault_id(fault_of(cell, patch)));
    const char *begin;
    if (!mistake || function >= ACID_MOST_FUNCTIONS || !mistake->functions[function]) return 0;
    lines[1] = acid_mending_lines(mistake->functions[function], &begin);
    lines[0] = (size_t)begin;
    return 1;
}

void WEB_EXPORT(patch_free)(lesson_patch *patch) {
    free(patch->positions);
    free(patch->normals);
    free(patch->corners);
    free(patch);
}

static void take_points(lesson_patch *to, const acid_patch *from) {
    for (size_t i = 0; i < from->vertex_count; ++i) {
        const acid_vertex *vertex = &from->vertices[i];
        const float length = from->has_color ? vertex->length : 1;
        for (size_t k = 0; k < 3; ++k) {
            to->positions[3 * i + k] = vertex->position[k];
            to->normals[3 * i + k] = length * vertex->normal[k];
        }
    }
    for (size_t i = 0; i < from->index_count; ++i) to->corners[i] = from->indices[i];
}

/* NULL: out of memory. */
lesson_patch *WEB_EXPORT(patch_make)(size_t cell, size_t which) {
    acid_patch subject = {0}, reference = {0};
    lesson_patch *patch = calloc(1, sizeof *patch);
    int made = patch && acid_make_subject(&acid_cells[cell], &subject) &&
               acid_make_reference(&acid_cells[cell], &subject, fault_of(cell, which), &reference);
    if (made) {
        *patch = (lesson_patch){.point_count = (uint32_t)reference.vertex_count,
            .corner_count = (uint32_t)reference.index_count,
            .positions = malloc(3 * reference.vertex_count * sizeof(float)),
            .normals = malloc(3 * reference.vertex_count * sizeof(float)),
            .corners = malloc(reference.index_count * sizeof(uint32_t))};
        made = patch->positions && patch->normals && patch->corners;
    }
    if (made) take_points(patch, &reference);
    acid_free_patch(&subject);
    acid_free_patch(&reference);
    if (made) return patch;
    if (patch) patch_free(patch);
    return NULL;
}
