/* tangents.c: tangents of the made meshes, with normals and texture coordinates made up for them.
 */
#include "bits.h"
#include <stdlib.h>

static float *made_up(size_t count, size_t numbers, uint64_t seed) {
    float *values = bits_room(count * numbers, sizeof *values);
    for (size_t i = 0; i < count * numbers; ++i)
        values[i] = (float)(int)(bits_random(&seed) % 9 + i / numbers % 4) / 8 - .5F;
    return values;
}

void bits_tangents(const bits_mesh *m, const bits_way *way, bits_hash *hash) {
    const size_t count = m->mesh.corner_count, positions = m->mesh.positions.count;
    float *normals = made_up(positions, 3, 23), *texcoords = made_up(positions, 2, 24);
    const norma_attribute normal = {.data = normals, .count = positions},
                          texcoord = {.data = texcoords, .count = positions};
    for (int mode = NORMA_TANGENTS_STEADY; mode <= NORMA_TANGENTS_MIKK; ++mode) {
        float *tangents = bits_room(count, 16);
        uint8_t *reasons = bits_room(count, 1);
        norma_report report;
        norma_options options = bits_options(way);
        options.reasons = reasons;
        const norma_result result = norma_corner_tangents(&m->mesh, &normal, &texcoord,
            (norma_tangent_mode)mode, &options, tangents, count, &report);
        bits_add(hash, (uint64_t)(int64_t)result);
        if (!result) {
            bits_floats(hash, tangents, 4 * count);
            bits_bytes(hash, reasons, count);
            bits_report(hash, &report);
        }
        free(tangents);
        free(reasons);
    }
    free(normals);
    free(texcoords);
}
