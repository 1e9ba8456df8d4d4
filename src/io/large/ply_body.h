/* ply_body.h: a binary PLY read through windows: where its elements lie, blocks of its vertices,
 * chunks of its faces. */
#ifndef NORMA_IO_LARGE_PLY_H
#define NORMA_IO_LARGE_PLY_H
#include "io/large/large_file.h"
#include "io/ply/ply.h"

enum { LARGE_CHUNK = 4096 /* faces */, LARGE_BLOCK = 8192 /* vertices */ };

typedef struct large_chunk { /* of faces in a row */
    uint64_t offset;
    uint32_t least, most; /* vertices that they name; least above most: none */
} large_chunk;

typedef struct large_faces { /* one chunk, decoded */
    uint32_t *corners, *starts;
    size_t count, corner_count, capacity;
} large_faces;

typedef struct large_ply {
    large_file *file;
    ply_state *state;
    const ply_element *vertex, *face; /* face: NULL, where there is none */
    size_t vertices;
    uint64_t faces;
    int single;          /* positions are read as floats, else as doubles */
    size_t plain_floats; /* 1 + where three floats of this machine lie in a row; 0: elsewhere */
    large_reader rows, blocks; /* of faces; of vertices */
    large_faces chunk;
    double *scratch; /* three numbers for each vertex of a block */
} large_ply;

/* Reads the header and finds the elements. UNSUPPORTED where this PLY can only be read whole:
 * text, lists in vertices, strips. */
norma_document_result norma_large_ply_open(large_file *file, large_ply *ply);
void norma_large_ply_close(large_ply *ply);

/* Rows from first on, at most LARGE_BLOCK. NULL: file->error says why. */
const unsigned char *norma_large_ply_rows(
    large_ply *ply, size_t first, size_t count, norma_document_result *result);
/* The state, as long as a block is looked at, seen as a file of these rows alone. */
typedef struct large_view {
    const unsigned char *bytes;
    size_t begin, vertices;
    uint64_t count;
} large_view;
large_view norma_large_ply_look(large_ply *ply, const unsigned char *rows, size_t count);
void norma_large_ply_look_away(large_ply *ply, const large_view *before);
/* Positions of a block as they are given to the core: three floats or three doubles each. */
norma_document_result norma_large_ply_positions(
    large_ply *ply, size_t first, size_t count, void *positions);
static inline size_t norma_large_position_size(const large_ply *ply) {
    return 3 * (ply->single ? sizeof(float) : sizeof(double));
}

/* Rows of the output. */
typedef struct large_row {
    size_t size, normal[3]; /* bytes; where a normal's numbers lie */
} large_row;
/* Writes the header of the output, whose only change is its normals, and chooses their types. */
norma_document_result norma_large_ply_write_header(
    large_ply *ply, norma_write *write, void *user, large_row *row);
/* The stored normals of a block that is then looked at, to be freed; NULL: there are none. Not
 * looked at after a failure. */
norma_document_result norma_large_ply_stored(
    large_ply *ply, size_t first, size_t count, double **stored, large_view *view);
/* The rows of that block with these normals, once they are encoded; looks away. */
norma_document_result norma_large_ply_write_rows(
    large_ply *ply, const large_view *view, float *normals, norma_write *write, void *user);

/* The commonest faces: one list, of three, and perhaps numbers beside it. The bytes of such a row;
 * 0: rows are others. And whether so many rows at offset are such, if all before were. */
size_t norma_large_even_row(const large_ply *ply);
norma_document_result norma_large_are_even(
    large_ply *ply, uint64_t offset, size_t count, int *are_even);
/* Decodes the faces from number first on, which begin at *offset, into ply->chunk; *offset moves
 * behind them. */
norma_document_result norma_large_ply_chunk(
    large_ply *ply, uint64_t first, size_t count, uint64_t *offset);
#endif
