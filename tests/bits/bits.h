/* bits.h: what the parts of the driver share: a hash over results, meshes to compute with, and one
 * function for each part of the library.
 *
 * Plain C without any library but Norma's and the C library, so that it is compiled for every
 * machine. Nothing here takes its input from libm: what is given to the library has the same bits
 * everywhere too. */
#ifndef NORMA_BITS_H
#define NORMA_BITS_H
#include <norma/check.h>
#include <norma/document.h>
#include <norma/norma.h>
#include <stddef.h>
#include <stdint.h>

/* ---- hash.c */

typedef struct bits_hash {
    uint64_t state;
} bits_hash;

bits_hash bits_begin(void);
void bits_add(bits_hash *hash, uint64_t value);
void bits_size(bits_hash *hash, size_t value); /* SIZE_MAX is the same number on 32 bits */
void bits_bytes(bits_hash *hash, const void *bytes, size_t size);
void bits_text(bits_hash *hash, const char *text); /* NULL and "" differ */
void bits_double(
    bits_hash *hash, double value); /* a NaN is a NaN, whatever its sign and payload: machines
                                       differ there and the contract is silent */
void bits_doubles(bits_hash *hash, const double *values, size_t count);
void bits_floats(bits_hash *hash, const float *values, size_t count);
void bits_report(bits_hash *hash, const norma_report *report);
void bits_edges(bits_hash *hash, const norma_edges *edges);

uint64_t bits_random(uint64_t *seed);
double bits_random_unit(uint64_t *seed); /* in [0, 1), a multiple of 2^-32 */
void *bits_room(size_t count,
    size_t size); /* filled with a pattern; ends the program where there is none left */

/* ---- a way to run: who works, with which instructions */

typedef struct bits_way {
    uint32_t threads;
    norma_isa isa;
    norma_parallel_for *jobs;
    const char *name;
} bits_way;

norma_options bits_options(const bits_way *way);

/* ---- meshes, made.c */

typedef struct bits_mesh {
    const char *name;
    norma_mesh mesh;
    int large;       /* fewer calls are made */
    void *blocks[8]; /* what it owns */
    size_t block_count;
} bits_mesh;

size_t bits_made_count(void);
void bits_make(size_t index, bits_mesh *mesh);
void bits_unmake(bits_mesh *mesh);

/* ---- parts: each hashes all results of some calls. The same hash for every way is what is tested.
 */

typedef void bits_of_mesh(const bits_mesh *mesh, const bits_way *way, bits_hash *hash);
bits_of_mesh bits_faces, bits_vertices, bits_corners, bits_split, bits_plans, bits_morphs,
    bits_orient, bits_check, bits_tangents;

void bits_matrices(const bits_mesh *mesh,
    bits_hash *hash); /* calls that neither threads nor an instruction set are chosen for */
void bits_streams(const bits_mesh *mesh, bits_hash *hash);

void bits_findings(const norma_findings *findings, bits_hash *hash);
void bits_file(
    const char *path, const void *bytes, size_t size, const bits_way *way, bits_hash *hash);
/* The meshes of a file as arrays, one after the other. */
typedef void bits_visit(void *user, const bits_mesh *mesh);
void bits_meshes_of_file(
    const char *path, const void *bytes, size_t size, bits_visit *visit, void *user);
#endif
