/* levels.h: which level of detail a mesh belongs to, as names and MSFT_lod say. */
#ifndef NORMA_IO_TOGETHER_LEVELS_H
#define NORMA_IO_TOGETHER_LEVELS_H
#include <norma/document.h>

/* The number at the end of a name like Rock_LOD2, any case, "_", "-", "." or a blank or nothing
 * between; with_ending: a path, whose folder and ending are left out. Returns whether there is one.
 */
int norma_level_of_name(const char *name, int with_ending, uint32_t *level);
/* Of each glTF node its place in the MSFT_lod of another one, or of one above it; 0: in none. To be
 * freed; NULL: out of memory, or the document is no glTF. */
uint32_t *norma_levels_of_nodes(const norma_document *document);
#endif
