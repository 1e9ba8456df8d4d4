/* large.h: files larger than memory: what is read through windows, what is computed in passes. */
#ifndef NORMA_IO_LARGE_H
#define NORMA_IO_LARGE_H
#include <norma/norma.h>
#include <stddef.h>
#include <stdint.h>
#include "io/file/file.h"
#include "io/format/format.h"
#include <norma/large.h>
#include "io/ply/ply.h"
#include "io/stl/stl.h"

/* ---- Blocks of memory that count against a limit. */

typedef struct large_budget {
    uint64_t most, used; /* bytes */
} large_budget;

/* NULL: beyond the limit, or the system has no more. size and count as they were taken. */
void *norma_large_take(large_budget *budget, size_t count, size_t size);
void *norma_large_take_zeroed(large_budget *budget, size_t count, size_t size);
void norma_large_give(large_budget *budget, void *block, size_t count, size_t size);
/* The block keeps its content; NULL: it stays as it is. */
void *norma_large_grow(
    large_budget *budget, void *block, size_t old_count, size_t count, size_t size);
/* For the core's scratch memory. budget must outlive it. */
norma_allocator norma_large_allocator(large_budget *budget);

/* ---- What the files of this folder share: a file read through a window, what it needs
 * for messages, its budget and its progress. */

/* Where bytes come from, unless from a file of this machine through a window; and what a message
 * says of why not all of them are read at once, and of the way out. */
typedef struct large_source {
    int (*read)(
        void *user, uint64_t offset, void *bytes, size_t size); /* errno or FILE_...; or 0 */
    void *user;
    uint64_t size;
    const char *why, *instead;
} large_source;

typedef struct large_file {
    norma_document *document; /* its name and header, without its body */
    file_window *window;      /* NULL where the source reads otherwise */
    large_source source;
    uint64_t size;
    norma_document_error *error;
    large_budget budget;
    norma_progress *progress;
    void *progress_user;
    double from, to; /* the part of the progress that the step under way takes */
} large_file;

/* Opens it and reads what it begins with, at most so many bytes, into document->source. */
norma_document_result norma_large_open(const char *path, const norma_large_options *options,
    norma_file_format format, large_file *file, norma_document_error *error);
/* The same from another source; error and budget are those of file. */
norma_document_result norma_large_open_source(
    const char *path, norma_file_format format, const large_source *source, large_file *file);
void norma_large_close(large_file *file);

norma_document_result norma_large_fail_memory(large_file *file);
/* What makes it be read whole, which its source does not. */
norma_document_result norma_large_fail_whole(const large_file *file, const char *what);
/* What the system said when the input was read. */
norma_document_result norma_large_fail_read(large_file *file, int system_error);
/* The step under way, from 0 to 1. CANCELLED with its message, or OK. */
norma_document_result norma_large_tell(large_file *file, double fraction);
void norma_large_stage(large_file *file, double from, double to);
/* How many of those that are left are taken at once. */
static inline size_t norma_large_some(uint64_t left, size_t most) {
    return left < most ? (size_t)left : most;
}
norma_document_result norma_large_read(large_file *file, uint64_t offset, void *bytes, size_t size);

/* ---- rows of a file, one after another */

typedef struct large_reader {
    large_file *file;
    unsigned char *buffer;
    size_t capacity, filled, at;
    uint64_t offset; /* of the buffer's first byte in the file */
    norma_document_result result;
} large_reader;

enum { LARGE_BUFFER = 1 << 22, SMALL_BUFFER = 1 << 20 };
int norma_large_reader_open(large_file *file, large_reader *reader); /* 0: out of memory */
void norma_large_reader_close(large_reader *reader);
void norma_large_reader_seek(large_reader *reader, uint64_t offset);
static inline uint64_t norma_large_reader_tell(const large_reader *reader) {
    return reader->offset + reader->at;
}
/* So many bytes from here on, at most SMALL_BUFFER; NULL: the file has fewer, or result is set. */
const unsigned char *norma_large_peek(large_reader *reader, size_t size);

/* ---- A set of vertices, a bit each, that tells how many of its members come before one. */

typedef struct large_bits {
    uint64_t *words;
    uint32_t *before; /* members before each word, once they are counted */
    size_t count;
} large_bits;

/* Empty; 0: out of memory. */
int norma_large_bits_open(large_budget *budget, size_t count, large_bits *bits);
void norma_large_bits_close(large_budget *budget, large_bits *bits);
void norma_large_bits_clear(large_bits *bits);
void norma_large_bits_set_range(large_bits *bits, size_t begin, size_t end);
/* Before norma_large_bits_before; returns how many members there are. */
size_t norma_large_bits_count(large_bits *bits);
/* Members before index, which may be count. */
size_t norma_large_bits_before(const large_bits *bits, size_t index);

static inline void norma_large_bits_set(large_bits *bits, size_t index) {
    bits->words[index >> 6] |= UINT64_C(1) << (index & 63);
}
static inline int norma_large_bits_has(const large_bits *bits, size_t index) {
    return (int)(bits->words[index >> 6] >> (index & 63) & 1);
}
static inline int norma_large_bits_any(const large_bits *bits, size_t begin, size_t end) {
    return norma_large_bits_before(bits, end) > norma_large_bits_before(bits, begin);
}

/* ---- What a large file becomes, on its way to its place. */

typedef struct large_output {
    large_file *file;
    const char *path;
    file_writer *writer;
    uint64_t written;
    int error;
    norma_document_result result; /* of what stopped the writing, beside its error */
} large_output;

/* Whether it may be written there, and opens it. */
norma_document_result norma_large_output_open(
    large_file *file, const char *path, const norma_large_options *options, large_output *output);
/* A norma_write; its failure is told by norma_large_output_result. */
int norma_large_output_write(void *output, const void *bytes, size_t size);
norma_document_result norma_large_output_result(large_output *output);
/* Bytes of the input as they are. Progress from 0 to 1 of the stage. */
norma_document_result norma_large_output_copy(large_output *output, uint64_t begin, uint64_t end);
norma_document_result norma_large_output_read(
    large_output *output, uint64_t offset, void *bytes, size_t size);
norma_document_result norma_large_output_patch(
    large_output *output, uint64_t offset, const void *bytes, size_t size);
/* Into its place, if result is OK and the input has not changed meanwhile; else all of it is gone.
 * Returns result, or what went wrong. */
norma_document_result norma_large_output_close(
    large_output *output, norma_document_result result, uint64_t *size);

/* ---- A binary PLY read through windows: where its elements lie, blocks of its vertices,
 * chunks of its faces. */

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

/* Positions of a block, at most LARGE_BLOCK, as they are given to the core: three floats or three
 * doubles each. */
norma_document_result norma_large_ply_positions(
    large_ply *ply, size_t first, size_t count, void *positions);
/* The same of those vertices from base to before end that are members, counted from base. */
norma_document_result norma_large_gather_positions(
    large_ply *ply, const large_bits *members, size_t base, size_t end, void *positions);
static inline size_t norma_large_position_size(const large_ply *ply) {
    return 3 * (ply->single ? sizeof(float) : sizeof(double));
}
/* One of those that lie in ply->scratch. */
static inline void norma_large_scratch_position(
    const large_ply *ply, size_t i, double position[3]) {
    const float *floats = (const float *)(const void *)ply->scratch;
    for (size_t k = 0; k < 3; ++k)
        position[k] = ply->single ? (double)floats[3 * i + k] : ply->scratch[3 * i + k];
}

/* Writes the header of the output, whose only change is its normals, and chooses their types. */
norma_document_result norma_large_ply_write_header(
    large_ply *ply, norma_write *write, void *user, ply_row *row);
/* The stored normals of a block, to be freed; NULL: there are none. */
norma_document_result norma_large_ply_stored(
    large_ply *ply, size_t first, size_t count, double **stored);
/* The rows of a block with these normals, once they are encoded. */
norma_document_result norma_large_ply_write_rows(
    large_ply *ply, size_t first, size_t count, float *normals, norma_write *write, void *user);

/* The commonest faces: one list, of three, and perhaps numbers beside it. The bytes of such a row;
 * 0: rows are others. And whether so many rows at offset are such, if all before were. */
size_t norma_large_even_row(const large_ply *ply);
norma_document_result norma_large_are_even(
    large_ply *ply, uint64_t offset, size_t count, int *are_even);
/* Decodes the faces from number first on, which begin at *offset, into ply->chunk; *offset moves
 * behind them. */
norma_document_result norma_large_ply_chunk(
    large_ply *ply, uint64_t first, size_t count, uint64_t *offset);

/* ---- The faces of a large PLY, gone through once: where each chunk begins, which
 * vertices it names, and how many faces touch each stretch of vertices. */

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
    return norma_large_some(ply->faces - (uint64_t)chunk * LARGE_CHUNK, LARGE_CHUNK);
}

/* ---- Vertices that may share their position with another one. */

/* Marks every vertex whose position another vertex has too, and hardly any other. any: whether
 * there is one. Reads the vertices as often as its table must be filled. */
norma_document_result norma_large_find_equal(large_ply *ply, large_bits *equal, int *any);

/* ---- A range of a large PLY's vertices, with every face that takes part in their normals,
 * as a mesh of its own. */

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

/* ---- For elements without a normal, the nearest element that has one, among more than
 * memory holds. */

typedef struct large_sites {
    large_file *file;
    size_t count;              /* of elements */
    const large_bits *without; /* those that have no normal */
    int single;                /* positions are floats, else doubles */
    /* The positions of at most 8192 elements from first on, three numbers each. */
    norma_document_result (*positions)(void *context, size_t first, size_t count, void *out);
    void *context;
    uint32_t anchor; /* an element whose coordinate is the greatest; UINT32_MAX: none is needed */
    const norma_options *core;
} large_sites;

/* Hands visit each element without a normal, in ascending order, with its source; UINT32_MAX: no
 * element has a normal. */
typedef norma_document_result large_visit_source(void *context, uint32_t element, uint32_t source);

/* ---- A binary STL read block by block. */

enum { LARGE_FACETS = 1 << 14 };

typedef struct large_facets { /* as a file of its own: a header, then facets */
    unsigned char bytes[STL_HEADER + LARGE_FACETS * STL_FACET];
    float positions[9 * LARGE_FACETS], normals[3 * LARGE_FACETS];
    uint8_t reasons[LARGE_FACETS];
} large_facets;

typedef struct large_stl {
    large_file *file;
    stl_state *state; /* its bytes: those of the block */
    large_facets *block;
    size_t facets;
} large_stl;

/* UNSUPPORTED: text. To be closed in any case. */
norma_document_result norma_large_stl_open(large_file *file, large_stl *stl);
void norma_large_stl_close(large_stl *stl);
/* Facets from first on, at most LARGE_FACETS, into the block's bytes. */
norma_document_result norma_large_stl_read(large_stl *stl, size_t first, size_t count);
/* The block's positions, from its bytes. */
void norma_large_stl_positions(const large_stl *stl, size_t count);

/* ---- A binary PLY or STL larger than memory, handed part by part to those who judge it. */

typedef struct large_walk large_walk;

typedef struct large_vertices { /* vertices in a row */
    size_t first;
    norma_vec3_view positions, normals; /* normals: count 0 where they are not stored here */
} large_vertices;

typedef struct large_surface { /* faces in a row */
    size_t first_face;
    norma_mesh mesh; /* these faces, and the vertices that they name */
    /* The numbers in the file of those vertices; NULL: they follow first_vertex. */
    const uint32_t *vertices;
    size_t first_vertex;
    norma_vec3_view normals; /* of facets; count 0: none */
} large_surface;

/* Faces of a part are a multiple of this, but for those of the last part. */
enum { LARGE_FACES_IN_BLOCK = 1 << 14 };

typedef norma_document_result large_visit_vertices(void *context, const large_vertices *part);
typedef norma_document_result large_visit_surface(void *context, const large_surface *part);

/* The format that they name, or that of the path. */
norma_file_format norma_large_format(const char *path, const norma_large_options *options);

/* UNSUPPORTED where the file can only be read whole. To be closed in any case. options: NULL for
 * the defaults. info: what norma_document_mesh_info says, without triangles. */
norma_document_result norma_large_walk_open(const char *path, const norma_large_options *options,
    norma_progress *progress, void *progress_user, large_walk **walk, norma_mesh_info *info,
    norma_document_error *error);
/* OK, or that the file changed meanwhile. NULL is fine. */
norma_document_result norma_large_walk_close(large_walk *walk, norma_document_result result);

/* Each goes through the file once, from beginning to end, and returns what a visit returns, if that
 * is not OK. from, to: the share of the progress. */
norma_document_result norma_large_walk_vertices(
    large_walk *walk, double from, double to, large_visit_vertices *visit, void *context);
norma_document_result norma_large_walk_surface(
    large_walk *walk, double from, double to, large_visit_surface *visit, void *context);

/* Of a vertex, or with SIZE_MAX the middle of a face. Once norma_large_walk_surface was there. */
norma_document_result norma_large_walk_locate(
    large_walk *walk, size_t vertex, size_t face, double position[3]);

/* ---- The faces of a PLY larger than memory, part by part. */

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

/* ---- Normals computed piece by piece, for each format that can be. */

typedef struct large_compute {
    large_file *file;
    const char *output;
    const norma_large_options *options;
    compute_policy policy;
} large_compute;

norma_document_result norma_large_compute_ply(large_compute *job);
norma_document_result norma_large_compute_stl(large_compute *job);
#endif
