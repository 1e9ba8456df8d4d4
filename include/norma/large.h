/* large.h: files that are larger than memory, and one surface that lies in many files.
 *
 * Files larger than memory are read piece by piece, in several passes. The results have the same
 * bits as those of norma_document_compute for a file that fits into memory.
 *
 * Binary PLY (smooth normals) and binary STL (facet normals) can be computed in this way. A PLY
 * takes one pass over its faces to find the vertices they use, and one for each range of vertices
 * that fits into the memory allowed. Faces that do not touch a range are skipped, so a file whose
 * faces and vertices are in about the same order is read about three times, however many passes it
 * takes. An STL is read once.
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
    uint64_t max_memory;      /* bytes that the call may allocate; 0: 512 MiB */
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
 * Errors: NORMA_DOCUMENT_ERROR_UNSUPPORTED if the whole file is needed in memory: for creases,
 * welding by distance, text and triangle strips; NORMA_DOCUMENT_ERROR_MEMORY if even small parts do
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

/* ---- one surface in many files */

typedef struct norma_together_file {
    const char *input, *output;     /* may be equal only with in_place */
    norma_file_format format;       /* unknown: by the path's extension */
    norma_compute_summary *summary; /* written; or NULL */
    uint64_t *size; /* written on success: bytes of the output and of the files beside
                       it that it names; or NULL */
} norma_together_file;

typedef struct norma_together_options {
    size_t struct_size; /* sizeof(norma_together_options) of the caller; 0: the first version */

    /* Meshes, materials, objects and groups (PLY: files) whose name matches one of these patterns
     * (*, ? and [] as in a shell) keep their normals, and what meets them takes those. */
    const char *const *lock;
    size_t lock_count;

    int levels;   /* nonzero: each file is a level of detail, the finest is the first */
    int in_place; /* nonzero: outputs may be inputs */
    uint32_t threads;
    uint64_t max_memory; /* bytes that joining may take; 0: half of 1 GiB */

    /* The folder of a temporary file of some hundred bytes for each vertex; NULL: that of the first
     * output. */
    const char *temporary_folder;

    /* Called when a file's output is complete, before any output is put in place; or NULL. */
    void (*file_done)(void *user, size_t file, const norma_document *document);
    void *file_done_user;

    /* Written: for each pattern of lock how many names it matched, in all files; or NULL. Of a mesh
     * without normals too, which has none to keep. */
    size_t *lock_matches;

    /* A file of votes (norma_seams_merge) of a surface that files[0] is a tile of; NULL: all tiles
     * are given. Only one file may be given then, weight is that of the votes, and lock, levels and
     * creases are refused. */
    const char *votes;
    norma_weight *weight; /* written: that of the votes; or NULL */
} norma_together_options;

/* Computes the normals of one surface that lies in several files, or in several meshes of one:
 * vertices at equal positions in the world share their normal, even across meshes, nodes and files.
 *
 *   files     OBJ, PLY, glTF or GLB
 *   count     of files
 *   options   NULL for the defaults
 *   compute   NULL for the defaults. shading: default, smooth or crease; weld: exact, or a
 *             distance; only: all; progress covers all files
 *   error     written on failure; or NULL
 *
 * Either all outputs are written or none: after a failure, all files are as before, even those that
 * had already been replaced. Sums do not depend on the order of their terms, so each vertex gets
 * the same bits in whatever order the files are given and however the surface is cut.
 *
 * Positions in a glTF are those in the world, rounded to floats. If one of the files is a glTF, all
 * positions are rounded to floats. Otherwise positions are compared as they are. A mesh with a skin
 * is compared in its bind pose. Levels of detail are recognised by names that end in LOD and a
 * number (of a mesh, a node or a file), by MSFT_lod, or by levels: a vertex takes the normal of the
 * finest level that has one there. With creases, edges are also shared across files. All files are
 * then in memory at once, and options->lock and levels are refused.
 *
 * Memory: that of the largest file, and max_memory. All files are read twice. With a weld distance,
 * 28 bytes for each vertex of all files.
 * Errors: NORMA_DOCUMENT_ERROR_UNSUPPORTED for a mesh that is drawn at several places where it
 * would need different normals. */
NORMA_API norma_document_result norma_together_compute(const norma_together_file *files,
    size_t count, const norma_together_options *options, const norma_compute_options *compute,
    norma_document_error *error);

/* ---- one surface in more files than one process should hold */

typedef struct norma_seams_options {
    size_t struct_size;       /* sizeof(norma_seams_options) of the caller; 0: the first version */
    norma_weight weight;      /* of votes; not visible */
    norma_file_format format; /* of tiles; unknown: by each path's extension */

    /* Nonzero: votes at all positions, not only on edges of one face. Needed if tiles touch
     * elsewhere: closed bodies, levels of detail. */
    int everywhere;
    int rounded;  /* nonzero: positions are rounded to floats even if no tile is a glTF */
    size_t tiles; /* of merging: how many there must be; 0: any number */
    uint32_t threads;
    uint64_t max_memory; /* bytes that joining the positions of a tile may take; 0: 64 MiB */
    const char *temporary_folder; /* NULL: that of the output */
    norma_progress *progress;
    void *progress_user;
} norma_seams_options;

typedef struct norma_seams_summary {
    size_t tiles;
    uint64_t positions, bytes; /* bytes: of the output */
} norma_seams_summary;

/* Writes what the faces of some tiles of a surface add at the positions on their borders.
 *
 *   tiles     OBJ, PLY, glTF or GLB
 *   count     of tiles
 *   output    the file of votes, some 140 bytes for each position
 *   options   NULL for the defaults
 *   summary   written; or NULL
 *   error     written on failure; or NULL
 *
 * Three steps make the surface of all tiles seamless, by as many processes as there are: votes of
 * some tiles each, norma_seams_merge, and norma_together_compute with options->votes for each tile.
 * The normals have the same bits as if norma_together_compute got all tiles at once.
 *
 * Memory: that of the largest tile, and of the votes. */
NORMA_API norma_document_result norma_seams_votes(const char *const *tiles, size_t count,
    const char *output, const norma_seams_options *options, norma_seams_summary *summary,
    norma_document_error *error);

/* Joins files of votes, those that it wrote itself too. In whatever order and by whatever tree
 * files are joined, the last one has the same bytes.
 *
 *   votes     files of votes
 *   count     of them
 *   output    the joined file
 *   options   NULL for the defaults; uses tiles and progress
 *   summary   written; or NULL
 *   error     written on failure; or NULL
 *
 * Memory: 17 KB and 0.05 % of its size for each file, and the names of all tiles.
 * Errors: NORMA_DOCUMENT_ERROR_REFUSED if a tile is in two of the files, if these were made with
 * different options, or if there are not options->tiles; NORMA_DOCUMENT_ERROR_MALFORMED for a
 * file that is damaged, as its checksums show. */
NORMA_API norma_document_result norma_seams_merge(const char *const *votes, size_t count,
    const char *output, const norma_seams_options *options, norma_seams_summary *summary,
    norma_document_error *error);

#ifdef __cplusplus
}
#endif
#endif
