/* ply_survey.h: the faces of a large PLY, gone through once: where each chunk begins, which
 * vertices it names, and how many faces touch each stretch of vertices. */
#ifndef NORMA_IO_LARGE_SURVEY_H
#define NORMA_IO_LARGE_SURVEY_H
#include "io/large/ply_body.h"

enum { LARGE_STRETCHES = 4096 };

typedef struct large_survey {
    large_chunk *chunks;
    size_t chunk_count;
    size_t stretch;   /* vertices in each stretch */
    size_t stretches; /* how many there are */
    /* Of each stretch: faces with a corner in it, and those of them with one elsewhere too. */
    uint32_t *touching, *crossing;
    /* Of each stretch, and one behind the last: faces whose least vertex comes before it, and whose
     * greatest does. */
    uint64_t *begun, *ended;
    uint64_t corners, triangles; /* triangles: if each face is cut */
    uint64_t end;                /* of the faces in the file */
    int polygons;                /* some face is no triangle */
    norma_count empty;           /* faces without a corner */
} large_survey;

/* Fails on a face that names a vertex which does not exist. Progress from 0 to 1 of the stage. */
norma_document_result norma_large_survey(large_ply *ply, large_survey *survey);
void norma_large_survey_close(large_ply *ply, large_survey *survey);
static inline size_t norma_large_chunk_faces(const large_ply *ply, size_t chunk) {
    const uint64_t left = ply->faces - (uint64_t)chunk * LARGE_CHUNK;
    return left < LARGE_CHUNK ? (size_t)left : LARGE_CHUNK;
}
#endif
