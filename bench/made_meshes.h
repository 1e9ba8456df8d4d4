/* made_meshes.h: meshes made for measuring, of as many triangles as are asked for. */
#ifndef NORMA_BENCH_MADE_MESHES_H
#define NORMA_BENCH_MADE_MESHES_H
#include <norma/norma.h>

typedef struct made_mesh {
    float (*positions)[3];
    uint32_t *corners; /* NULL: each triangle has corners of its own */
    size_t position_count, corner_count;
} made_mesh;

/* A wavy sheet of about the given number of triangles, a little rough: vertices and faces row by
 * row, two triangles for each four vertices. */
made_mesh made_grid(size_t triangles);
/* Vertices and faces in random order, the same in every run. */
void made_shuffle(made_mesh *mesh);
/* Triangles round one vertex. */
made_mesh made_fan(size_t triangles);
/* Triangles that share nothing. */
made_mesh made_soup(size_t triangles);
/* The same number of vertices all at one position, the tips of triangles that go round it many
 * times. */
made_mesh made_tips(size_t triangles);
void made_free(made_mesh *mesh);
norma_mesh made_view(const made_mesh *mesh);
#endif
