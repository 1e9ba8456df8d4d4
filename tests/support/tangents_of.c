/* tangents_of.c: the tangents of meshes that come in on standard input, one after the other, for
 * scripts that compare them with those of other programs.
 *
 *   tangents_of mikk|steady THREADS
 *
 * A mesh: a 32-bit count of corners, three of each triangle; then floats: positions, normals,
 * texture coordinates of the corners. Answered by four floats and a byte, the reason, a corner. */
#include <norma/norma.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static float *read_floats(size_t count) {
    float *floats = malloc(count * sizeof *floats + 1);
    if (!floats || fread(floats, sizeof *floats, count, stdin) != count) exit(2);
    return floats;
}

static void answer(uint32_t corners, norma_tangent_mode mode, uint32_t threads) {
    float *positions = read_floats(3 * (size_t)corners),
          *normals = read_floats(3 * (size_t)corners),
          *texcoords = read_floats(2 * (size_t)corners),
          *tangents = malloc(16 * (size_t)corners + 1);
    uint8_t *reasons = malloc((size_t)corners + 1);
    const norma_mesh mesh = {
        .positions = {.data = positions, .count = corners}, .corner_count = corners};
    const norma_attribute normal = {.data = normals, .count = corners, .of = NORMA_PER_CORNER},
                          texcoord = {.data = texcoords, .count = corners, .of = NORMA_PER_CORNER};
    const norma_options options = {.reasons = reasons, .threads = threads};
    const norma_result result =
        norma_corner_tangents(&mesh, &normal, &texcoord, mode, &options, tangents, corners, NULL);
    if (result != NORMA_OK) {
        fprintf(stderr, "%s\n", norma_result_text(result));
        exit(1);
    }
    fwrite(tangents, 16, corners, stdout);
    fwrite(reasons, 1, corners, stdout);
    fflush(stdout);
    free(positions);
    free(normals);
    free(texcoords);
    free(tangents);
    free(reasons);
}

int main(int argc, char **argv) {
    uint32_t corners;
    if (argc != 3) return 2;
    const norma_tangent_mode mode =
        strcmp(argv[1], "mikk") ? NORMA_TANGENTS_STEADY : NORMA_TANGENTS_MIKK;
    while (fread(&corners, sizeof corners, 1, stdin) == 1)
        answer(corners, mode, (uint32_t)atoi(argv[2]));
    return 0;
}
