/* seams.h: what the files of N501 share: one mesh by itself, or the primitives of a glTF mesh
 * together. */
#ifndef NORMA_CHECK_SEAMS_H
#define NORMA_CHECK_SEAMS_H
#include "check/rules/mesh_rules.h"

/* How many edges along which no seam runs, or whose faces are shaded flat, bend by so many degrees,
 * and how many of them have different normals on both sides: what the file's own crease is. */
enum { SEAM_BENDS = 40 };
typedef struct seam_creases {
    size_t all[SEAM_BENDS], split[SEAM_BENDS];
} seam_creases;

/* seam_angle.c. Angles in radians; 0: no seam there. The faces of m are known and its edges paired.
 * creases: NULL, or the file's: a seam that bends as edges do that are split as well is none. */
double norma_check_seam_least(const char *encoding);
double norma_check_seam_angle(
    const check_mesh *m, size_t position, double least, const seam_creases *creases);
void norma_check_seam_creases(const check_mesh *m, double least, seam_creases *creases);
norma_result norma_check_add_seams(check_mesh *m, check_hits *hits);
/* seams_joined.c: holds a mesh that has siblings until the last of them has come. */
norma_result norma_check_seams_hold(check_mesh *m);
#endif
