/* node_matrix.h: 4x4 matrices as glTF's nodes can say them. Column-major, affine: the last row is
 * taken as 0 0 0 1. */
#ifndef NORMA_IO_GLTF_MATRIX_H
#define NORMA_IO_GLTF_MATRIX_H

typedef struct gltf_trs { /* translation after rotation after scale; one scale is negative where the
                             matrix mirrors */
    double translation[3], rotation[4], scale[3]; /* the rotation as a unit quaternion x, y, z, w */
} gltf_trs;

void norma_gltf_matrix_identity(double m[16]);
int norma_gltf_matrix_is_identity(const double m[16]); /* exactly */
void norma_gltf_matrix_multiply(
    const double a[16], const double b[16], double ab[16]); /* ab may be a or b */
void norma_gltf_matrix_compose(const gltf_trs *trs, double m[16]);

/* 0 where the upper 3x3 is singular or its inverse is not finite; inverse is then undefined. */
int norma_gltf_matrix_invert(const double m[16], double inverse[16]);

/* The translation, rotation and scale nearest to m. Returns how far m is from being that: the
 * largest |cosine| between two of its columns (0: exactly perpendicular; a column of zeros is
 * perpendicular to all). */
double norma_gltf_matrix_decompose(const double m[16], gltf_trs *trs);

/* Any m, sheared and singular ones included, as the product outer inner: its singular value
 * decomposition, inner a rotation. So two nodes, one below the other, hold what one cannot. */
void norma_gltf_matrix_split(const double m[16], gltf_trs *outer, gltf_trs *inner);

/* Orthonormal columns from count (0 to 3) given ones, the first; m holds three columns.
 * Right-handed where fewer than three are given. */
void norma_gltf_complete_basis(double columns[9], int count);
#endif
