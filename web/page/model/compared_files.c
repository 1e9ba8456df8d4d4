/* compared_files.c: two of the page's files compared as norma compare does it, and by how much each
 * corner differs, as values for the picture. */
#include "compare/compare_scene.h"
#include "../../package/wasm/exports.h"
#include "model.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double degrees = 180 / 3.14159265358979323846;

/* NULL: error says why. names: of both, for messages. */
compared_pair *WEB_EXPORT(compared_open)(norma_document *base, norma_document *other,
    const char *base_name, const char *other_name, norma_document_error *error) {
    norma_document *documents[2] = {base, other};
    const char *names[2] = {base_name, other_name};
    compared_pair *pair = calloc(1, sizeof *pair);
    norma_document_result result = pair ? NORMA_DOCUMENT_OK : NORMA_DOCUMENT_ERROR_MEMORY;
    *error = (norma_document_error){0};
    for (int i = 0; i < 2 && !result; ++i) {
        compared_scene *scene = i ? &pair->other : &pair->base;
        result = compared_scene_make(documents[i], names[i], 1, scene, error);
        if (!result && !scene->count) {
            snprintf(error->message, sizeof error->message,
                "%.800s: there is nothing in it to compare", names[i]);
            result = NORMA_DOCUMENT_ERROR_UNSUPPORTED;
        }
    }
    const norma_options options = {.struct_size = sizeof options, .threads = 1};
    if (!result) result = compared_pair_measure(pair, 0, &options, error);
    if (!result) return pair;
    if (pair) compared_pair_close(pair);
    free(pair);
    return NULL;
}

void WEB_EXPORT(compared_close)(compared_pair *pair) {
    compared_pair_close(pair);
    free(pair);
}

/* numbers: corners, those without an angle, degrees and distances (half of the area, 99 % of it, at
 * most), whether normals of base and of other were computed, the place of the largest angle. */
void WEB_EXPORT(compared_numbers)(const compared_pair *pair, double numbers[13]) {
    const norma_comparison *all = &pair->all;
    const compared_scene *scene = &pair->other;
    const double found[10] = {(double)all->corners, (double)all->missing, all->p50_rad * degrees,
        all->p99_rad * degrees, all->max_rad * degrees, all->p50_distance, all->p99_distance,
        all->max_distance, pair->base.computed, scene->computed};
    for (int i = 0; i < 10; ++i) numbers[i] = found[i];
    const compared_piece *piece = scene->pieces;
    for (int axis = 0; axis < 3; ++axis) numbers[10 + axis] = (double)NAN;
    if (all->worst >= pair->corners) return;
    while (all->worst - piece->first_corner >= piece->corners) ++piece;
    const double *at = scene->positions + 3 * (piece->first_position + scene->corners[all->worst]);
    for (int axis = 0; axis < 3; ++axis) numbers[10 + axis] = at[axis];
}

const char *WEB_EXPORT(compared_how)(const compared_pair *pair) { return compared_way(pair); }

/* Draws of a pack go through nodes, their meshes, and instances; pieces through names first. */
static int draw_order(const void *first, const void *second) {
    const compared_piece *a = *(const compared_piece *const *)first,
                         *b = *(const compared_piece *const *)second;
    if (a->node != b->node) return a->node < b->node ? -1 : 1;
    if (a->mesh != b->mesh) return a->mesh < b->mesh ? -1 : 1;
    return a->instance < b->instance ? -1 : a->instance > b->instance;
}

static void take_values(
    const compared_pair *pair, const compared_piece *piece, model_mesh *mesh, int distances) {
    const uint32_t *starts = mesh->mesh.face_starts;
    size_t face = 0;
    if (piece->corners != mesh->mesh.corner_count) return;
    for (size_t k = 0; k < 3 * mesh->triangle_count; ++k) {
        const size_t corner = mesh->triangle_corners ? mesh->triangle_corners[k] : k;
        while (starts && corner >= starts[face + 1]) ++face;
        const size_t begin = starts ? starts[face] : corner - corner % 3,
                     count = starts ? starts[face + 1] - begin : 3, i = corner - begin,
                     at = begin + (piece->mirrored ? (count - i) % count : i);
        const norma_compare_sample *sample = &pair->samples[piece->first_corner + at];
        const double value =
            distances ? (double)sample->distance : (double)sample->angle_rad * degrees;
        if (sample->area > 0) mesh->draw_values[k] = fmaxf(mesh->draw_values[k], (float)value);
    }
}

/* Fills draw_values of other's model: degrees, or distances. A mesh that is drawn in several places
 * shows the largest of them; -1: nothing was compared. 0: out of memory. */
int WEB_EXPORT(compared_values)(const compared_pair *pair, model *m, int distances) {
    const compared_scene *scene = &pair->other;
    const compared_piece **pieces = malloc(scene->count * sizeof *pieces);
    if (!pieces) return 0;
    for (size_t i = 0; i < scene->count; ++i) pieces[i] = &scene->pieces[i];
    qsort((void *)pieces, scene->count, sizeof *pieces, draw_order);
    for (uint32_t i = 0; i < m->head->mesh_count; ++i)
        for (size_t k = 0; k < 3 * m->meshes[i].triangle_count; ++k)
            m->meshes[i].draw_values[k] = -1;
    for (uint32_t draw = 0; draw < m->head->draw_count && draw < scene->count; ++draw)
        take_values(pair, pieces[draw], &m->meshes[m->draws[draw].mesh], distances);
    free((void *)pieces);
    return 1;
}
