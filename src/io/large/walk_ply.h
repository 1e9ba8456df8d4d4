/* walk_ply.h: the faces of a PLY larger than memory, part by part. */
#ifndef NORMA_IO_LARGE_WALK_PLY_H
#define NORMA_IO_LARGE_WALK_PLY_H
#include "io/large/bits.h"
#include "io/large/ply_body.h"
#include "io/large/walk.h"

typedef struct walk_ply {
    large_ply ply;
    uint64_t *offsets; /* of each chunk of faces, and one more: as far as they are known */
    size_t chunk_count, known;
    /* A part: the chunks from first_chunk on. */
    uint32_t *corners, *starts, *vertices;
    void *positions;
    large_bits named;                          /* from least on */
    size_t corner_room, face_room, named_room; /* named_room: of named */
    size_t corner_count, face_count, first_face, vertex_count;
    uint32_t least, most;
} walk_ply;

norma_document_result norma_walk_ply_open(large_file *file, walk_ply *walk);
void norma_walk_ply_close(walk_ply *walk);
norma_document_result norma_walk_ply_vertices(
    walk_ply *walk, large_visit_vertices *visit, void *context);
norma_document_result norma_walk_ply_surface(
    walk_ply *walk, large_visit_surface *visit, void *context);
norma_document_result norma_walk_ply_locate(
    walk_ply *walk, size_t vertex, size_t face, double position[3]);
#endif
