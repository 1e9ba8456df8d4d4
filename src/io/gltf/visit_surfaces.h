/* visit_surfaces.h: the surfaces of a glTF, mesh by mesh. */
#ifndef NORMA_IO_GLTF_VISIT_SURFACES_H
#define NORMA_IO_GLTF_VISIT_SURFACES_H
#include "io/format/shared_normals.h"

/* A mesh of which no triangle can be read is left out. */
norma_document_result norma_gltf_visit_surfaces(
    norma_document *document, visit_surface *visit, void *user, norma_document_error *error);
#endif
