/* program.c: the normals of a triangle. */
#include <norma/norma.h>
#include <stdio.h>

int main(void) {
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const norma_mesh mesh = {.positions = {.data = positions, .count = 3}, .corner_count = 3};
    float normals[9];
    const norma_result result = norma_vertex_normals(&mesh, NULL, normals, 3, NULL);
    printf("norma %s: %s\n", norma_version(), norma_result_text(result));
    return result || normals[2] < 1;
}
