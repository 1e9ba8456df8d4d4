/* large.h: files that are larger than memory. They are read piece by piece, in several passes, and
 * the results have the bits that norma_document_compute gives to a file that fits.
 *
 * Binary PLY (smooth normals) and binary STL (facet normals) can be computed so. A PLY takes one
 * pass over its faces to look at them, and one for each range of vertices that fits into the memory
 * allowed; faces that do not touch a range are skipped, so a file whose faces and vertices are in
 * about the same order is read about three times however many passes it takes. An STL is read once.
 *
 * Memory is counted as it is allocated. Nothing is mapped. */
#ifndef NORMA_LARGE_H
#define NORMA_LARGE_H
#include <norma/document.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef struct norma_large_options {
    size_t struct_size;       /* sizeof(norma_large_options) of the caller; 0: the first version */
    uint64_t max_memory;      /* bytes that the call may allocate; 0: half of 1 GiB */
    norma_file_format format; /* unknown: by the path's extension */
    int in_place;             /* nonzero: the output may be the input */

    /* Called before each pass over a range of vertices, with its number from 1 and how many are
     * expected, which may grow; or NULL. */
    void (*pass)(void *user, size_t number, size_t count);
    void *pass_user;
    uint64_t *size; /* written on success: bytes of the output; or NULL */
    size_t *passes; /* written: passes over ranges of vertices, or over an STL; or NULL */
} norma_large_options;

/* Estimates the memory that opening a file whole and computing its normals takes.
 *
 *   path     the file; only its header is read
 *   format   unknown: by the path's extension
 *   bytes    written: the estimate; 0 if this header cannot be read, or the format needs the whole
 *            file (OBJ, glTF)
 *
 * Returns nonzero if norma_large_compute can take the file in passes. */
NORMA_API int norma_large_need(const char *path, norma_file_format format, uint64_t *bytes);

/* Computes the normals of a file into another, piece by piece.
 *
 *   input     a binary PLY or STL
 *   output    written whole or not at all; a file, no pipe
 *   options   NULL for the defaults
 *   compute   NULL for the defaults. shading: default or smooth for PLY, default or flat for STL;
 *             weld: exact or none
 *   summary   written; or NULL
 *   error     written on failure; or NULL
 *
 * Errors: NORMA_DOCUMENT_ERROR_UNSUPPORTED for what needs the whole file in memory: creases,
 * welding by distance, text, triangle strips; NORMA_DOCUMENT_ERROR_MEMORY if even small parts do
 * not fit. */
NORMA_API norma_document_result norma_large_compute(const char *input, const char *output,
    const norma_large_options *options, const norma_compute_options *compute,
    norma_compute_summary *summary, norma_document_error *error);

/* What norma_large_describe finds. */
typedef struct norma_large_description {
    norma_file_format format;
    size_t vertices, faces, triangles;
    norma_normal_storage normals;
    const char *encoding; /* as in norma_mesh_info; a constant */
    int has_bounds;       /* nonzero: some position is finite */
    double least[3], most[3];
} norma_large_description;

/* Counts what is in a binary PLY or STL, and finds its bounds, piece by piece.
 *
 *   path            the file
 *   options         NULL for the defaults; uses max_memory and format
 *   progress        as in norma_document_options; or NULL
 *   progress_user   passed to progress
 *   description     written
 *   error           written on failure; or NULL
 *
 * Errors: as norma_large_compute. Cost: one reading of the file. */
NORMA_API norma_document_result norma_large_describe(const char *path,
    const norma_large_options *options, norma_progress *progress, void *progress_user,
    norma_large_description *description, norma_document_error *error);

#ifdef __cplusplus
}
#endif
#endif
