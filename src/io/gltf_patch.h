/* gltf_patch.h: what is to become of accessors, views and buffers: filled by gltf_patch.c and gltf_layout.c, written by gltf_write.c. */
#ifndef NORMA_IO_GLTF_PATCH_H
#define NORMA_IO_GLTF_PATCH_H
#include "gltf.h"

void norma_gltf_patch_free(gltf *g);
#endif
