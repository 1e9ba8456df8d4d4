/* own_bytes.h: what of a buffer's file belongs to the asset that names it. */
#ifndef NORMA_IO_GLTF_OWN_BYTES_H
#define NORMA_IO_GLTF_OWN_BYTES_H
#include "io/gltf/asset.h"

typedef struct range {
    size_t start, end;
} range;

typedef struct ranges {
    range *list;
    size_t count, capacity;
} ranges;

int norma_range_add(ranges *r, size_t start, size_t end); /* 0: out of memory */

/* Adds, in order, the bytes of a buffer's file that no asset of its folder names, neither this one
 * as it stands on the disk nor another, below what they call its end; nothing where that cannot be
 * known. Returns 0 or errno. */
int norma_gltf_find_unnamed(const gltf *g, uint32_t buffer, ranges *left);

/* Refuses a buffer's file that does not look like data of an asset: a Makefile, a picture. */
norma_document_result norma_gltf_check_own_data(
    const gltf *g, uint32_t buffer, const file_bytes *file, norma_document_error *error);

/* The first component of a path below a folder that begins with a dot, "." itself aside. */
int norma_gltf_is_hidden(const char *name);
int norma_gltf_has_suffix(const char *name, const char *const *suffixes, size_t count);
#endif
