/* together.h: one surface in several files: the files, where their meshes are drawn, what their
 * faces add at each position of the world, and the call that brings all this together. */
#ifndef NORMA_IO_TOGETHER_H
#define NORMA_IO_TOGETHER_H
#include "core/mesh/mesh.h"
#include "io/format/format.h"
#include <norma/large.h>
#include <norma/document.h>
#include <norma/norma.h>
#include <stddef.h>
#include <stdint.h>
#include "core/vertex/vertex.h"

/* ---- A surface of a document where a node draws it: positions in the world, which of them are
 * one, and the faces in an order of corners that depends on the positions alone. */

typedef struct near_positions near_positions;

/* Which positions are one: those that are equal, after rounding to floats where rounded is set; or
 * within a distance, where near is not NULL. */
typedef struct equality {
    int rounded;
    const near_positions *near;
} equality;

typedef struct placement {
    double world[16]; /* column-major; the unit of integers is not in it */
    int mirrored, plain;
    uint32_t level; /* of detail, from 0, the finest */
} placement;

typedef struct world_mesh {
    core_mesh mesh; /* with weld: the first position at the same place; one that is not finite is
                       alone */
    double *positions, (*at)[3]; /* at: of each, what tells it from others */
    uint32_t *corners, *weld, *firsts;
    size_t first_count; /* firsts: those that are finite and welded to themselves, in order */
} world_mesh;

/* Returns NORMA_OK, NORMA_ERROR_MEMORY, or what the core finds wrong. Free it in any case. */
norma_result norma_together_place(const document_surface *surface, const placement *place,
    const equality *equal, world_mesh *world);
void norma_together_free_world(world_mesh *world);

/* What tells a position from others. */
void norma_together_at(const equality *equal, const double position[3], double at[3]);
/* The position in the world. */
void norma_together_position(
    const document_surface *surface, const placement *place, size_t index, double position[3]);

/* ---- One of the files that hold a surface, opened: where its meshes are drawn, at which
 * level of detail, and what of it keeps its normals. */

typedef struct member {
    norma_document *document;
    uint32_t level;
    int has_level; /* of the whole file */
    uint32_t *node_levels;
    uint8_t
        *locked; /* of each mesh (glTF), of each face (OBJ), of the whole (PLY); NULL: nothing */
} member;

void norma_member_close(member *m);

/* ---- Positions of all files that chains of short steps join, and the one that stands for each
 * chain. */

typedef struct near_positions near_positions;

/* NULL: out of memory. */
near_positions *norma_near_begin(void);
void norma_near_free(near_positions *near); /* NULL is fine */
/* Before the end, all positions are added, in any order. 0: out of memory. */
int norma_near_add(near_positions *near, const double at[3]);
norma_result norma_near_end(near_positions *near, double distance, uint32_t threads);
/* The least position of its chain, in the place of one that was added. */
void norma_near_find(const near_positions *near, double at[3]);

/* ---- Records of one size in partitions, in memory while they are few and in a temporary file
 * without a name from then on: what is held in memory does not grow with their number, but for some
 * bytes for every 16 KiB. */

enum { SPILL_PARTITIONS = 256 };

typedef struct spill spill;

/* folder: of the temporary file, which is made when it is needed; it must outlive the spill.
 * record: bytes of one. NULL: out of memory. */
spill *norma_spill_open(const char *folder, size_t record);
void norma_spill_close(spill *s); /* NULL is fine */
/* Each returns 0 or errno. */
int norma_spill_add(spill *s, size_t partition, const void *record);
/* Each partition from its first record on, one after the other. */
void norma_spill_rewind(spill *s);
int norma_spill_next(spill *s, size_t partition, void *record);

/* ---- What the files of one surface say of its positions, and what follows for each. */

/* A position of one mesh at one place. */
typedef struct position_votes {
    double at[3];
    open_sum sum;
    uint32_t rank; /* only those of the least rank decide: 0: it keeps a normal; else its level of
                      detail, from 1 */
    unsigned voters : 31, border : 1; /* how many have votes; it lies on an edge of one face */
} position_votes;

typedef struct position_normal {
    double direction[3]; /* of a kept normal, itself */
    uint8_t reason;      /* why there is none, or NORMA_REASON_NONE */
    uint8_t shared;      /* others have votes there, too */
    uint8_t kept;
} position_normal;

/* The partition of a position. */
size_t norma_together_partition(const double at[3]);
uint64_t norma_together_hash(const double at[3]);
int norma_together_compare(const void *a, const void *b); /* of three doubles, for qsort */

/* Adds what another record says of the same position. */
void norma_together_add_votes(position_votes *to, const position_votes *votes);

/* Sees what all records say of a position, and may say otherwise. Returns 0, or what the join
 * returns then. */
typedef int visit_position(void *user, position_votes *votes);

/* For each record of votes one of normals, in the same partition and order; NULL: visit alone
 * counts, which may be NULL else. memory: bytes that may be taken; a partition that needs more is
 * gone through several times. Returns 0 or errno. */
int norma_together_join(
    spill *votes, spill *normals, uint64_t memory, visit_position *visit, void *user);

/* ---- One call of norma_together_compute, or of norma_seams_votes. */

typedef struct creases creases;
typedef struct seams seams;

/* A file as one of many tiles of a surface. */
typedef struct surface_tile {
    int marks, everywhere; /* whether borders are marked; everywhere: all positions are */
    uint64_t hash, faces;  /* hash: of where its faces lie */
    size_t positions;
    double low[3], high[3];
} surface_tile;

typedef struct together_run {
    const norma_together_file *files;
    size_t count, number; /* number: of the file at hand */
    norma_together_options options;
    norma_compute_options compute;
    norma_document_error *error;
    equality equal;
    near_positions *near;
    spill *votes, *normals;
    seams *seams; /* NULL, or what all tiles of a surface say of which this file is one */
    surface_tile tile;
    creases *creases;   /* NULL: normals are smooth */
    size_t *degenerate; /* faces of each file */
    double center[3];   /* where the origin of all files' positions lies, which is not applied */
    const char *folder; /* of temporary files */
    char *own_folder;
    companion_writers writers; /* of all outputs, complete, waiting to be put in place */
    double passes, passes_done;
} together_run;

/* A surface of the file at hand, and all places where it is drawn; none in a glTF that draws
 * others. */
typedef struct placed_surface {
    together_run *run;
    member *m;
    const document_surface *surface;
    const placement *places;
    size_t count;
} placed_surface;

static inline norma_document_result norma_together_fail_memory(const placed_surface *at) {
    return norma_document_fail_memory(at->m->document, at->run->error);
}

/* member.c */
/* Opens the file at hand and finds out what a member tells. Close it in any case. */
norma_document_result norma_member_open(together_run *run, member *m);
/* Calls visit for each surface. */
typedef norma_document_result visit_placed(void *user, const placed_surface *at);
norma_document_result norma_member_visit(
    together_run *run, member *m, visit_placed *visit, void *user);
char *norma_together_folder_of(const char *path); /* to be freed; NULL: out of memory */
/* Whether positions are rounded to floats: one of the files is a glTF. */
int norma_together_rounds(const norma_together_file *files, size_t count);

/* seams.c: a file of votes. Close it whatever is returned. */
norma_document_result norma_seams_open(
    const char *path, seams **opened, norma_document_error *error);
void norma_seams_close(seams *s); /* NULL is fine */
/* What its votes were made with. */
void norma_seams_choose(const seams *s, norma_weight *weight, int *rounded, int *everywhere);
/* Finds run's file among the tiles, and what others may say of its positions. */
norma_document_result norma_seams_find(together_run *run);
int norma_seams_take(void *seams, position_votes *votes); /* a visit_position; -1: see below */
norma_document_result norma_seams_fail(const together_run *run);

/* join.c */
norma_document_result norma_together_fail_spill(together_run *run, int failed);
/* Nonzero: the caller wants to stop. */
int norma_together_tell(together_run *run, double share_of_file);

/* surface_normals.c: each position of a file, what its faces add there, or the normal that it
 * keeps. */
norma_document_result norma_together_take_votes(together_run *run, member *m);
norma_document_result norma_together_take_positions(together_run *run, member *m);

/* What became of a surface's positions, or with creases of its corners. */
typedef struct surface_normals {
    float *normals;
    uint8_t *reasons;
    size_t count;
} surface_normals;

/* surface_normals.c: the next records of run->normals; made has room. */
norma_document_result norma_together_surface_normals(
    const placed_surface *at, surface_normals *made);
/* A normal of the world in the mesh's own space. */
void norma_together_into_mesh(const placement *place, const position_normal *from, float normal[3]);
/* By more than rounding: then a mesh that is drawn at several places would need one copy for each.
 */
int norma_together_differ(const float a[3], const float b[3]);
norma_document_result norma_together_fail_places(const placed_surface *at);

#endif
