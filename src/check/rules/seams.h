/* seams.h: what the files of N501 share: one mesh by itself, or the primitives of a glTF mesh
 * together. */
#ifndef NORMA_CHECK_SEAMS_H
#define NORMA_CHECK_SEAMS_H
#include "check/rules/mesh_rules.h"

/* seam_angle.c. Angles in radians; 0: no seam there. */
double norma_check_seam_least(const char *encoding);
double norma_check_seam_angle(const check_mesh *m, size_t position, double least);
norma_result norma_check_add_seams(check_mesh *m, check_hits *hits);
/* seams_joined.c: holds a mesh that has siblings until the last of them has come. */
norma_result norma_check_seams_hold(check_mesh *m);
#endif
