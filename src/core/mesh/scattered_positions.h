/* scattered_positions.h: meshes whose faces name positions far apart. What is read in no order is
 * read through the table of pages as much as through the caches, and the caller's pages are small
 * as a rule: three positions of a triangle took 33 to 50 ns there and 11 ns in pages of 2 MiB. So
 * what is read so is copied first, which takes 1 to 2 ns for 12 bytes. */
#ifndef NORMA_CORE_SCATTERED_H
#define NORMA_CORE_SCATTERED_H
#include "core/mesh/input_mesh.h"

/* Whether faces in a row touch positions all over the mesh; its indices are checked.
 * Looks at some of them. */
int norma_core_is_scattered(const core_mesh *mesh);

/* The mesh with positions of its own, the same numbers, to be released; with the caller's where
 * they are few or there is no memory for them. CANCELLED leaves nothing to release. */
norma_result norma_core_copy_scattered(core_call *call, const core_mesh *mesh, core_mesh *copy);
void norma_core_release_scattered(const core_call *call, const core_mesh *mesh, core_mesh *copy);
#endif
