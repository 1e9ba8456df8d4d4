/* ply_part.h: a range of a large PLY's vertices, with every face that takes part in their normals,
 * as a mesh of its own. */
#ifndef NORMA_IO_LARGE_PART_H
#define NORMA_IO_LARGE_PART_H
#include "io/large/bits.h"
#include "io/large/ply_survey.h"

typedef struct large_parts { /* what the parts of one file share */
    large_ply *ply;
    const large_survey *survey;
    large_bits equal; /* vertices that may share their position; without words: nobody does */
    uint32_t anchor;  /* the vertex of the greatest coordinate, which each part holds, so that all
                         of them are scaled alike; UINT32_MAX: none is needed */
    norma_options core;
    double share; /* of the memory that a part is reckoned to take; smaller after it did not fit */
} large_parts;

typedef struct large_part {
    size_t begin, end;          /* the vertices whose normals it gives */
    large_bits members, needed; /* vertices at their positions; those and all of their faces */
    uint32_t *corners, *starts; /* starts: of polygons */
    size_t corner_count, corner_capacity, face_count, face_capacity;
    uint32_t *chunks,
        *chunk_begins; /* the chunks that faces came from, and where they begin here */
    size_t chunk_count;
    void *positions;
    size_t count, first; /* vertices here; the number that begin has among them */
    float *normals;      /* of the vertices from begin on */
    uint8_t *reasons;
    norma_count
        degenerate; /* faces whose first corner is in the range; their numbers in the file */
    float *all_normals;
    uint8_t *all_reasons;
} large_part;

/* The end of the range that begins here and is reckoned to fit. */
size_t norma_large_part_end(const large_parts *parts, size_t begin);
/* How many parts the file is reckoned to take. */
size_t norma_large_part_count(const large_parts *parts);
/* Computes the normals of part->begin to part->end. MEMORY without a message: it does not fit. */
norma_document_result norma_large_part_compute(const large_parts *parts, large_part *part);
void norma_large_part_close(const large_parts *parts, large_part *part);
#endif
