/* draco_left_out.c: stands in for draco_decoder.cpp where the library is built without libdraco.
 * Compressed primitives are not read then, which norma check reports as N002. */
#include "io/gltf/draco_decoder.h"

int norma_draco_reads(void) { return 0; }

const char *norma_draco_missing(int of_primitive) {
    return of_primitive ? "compressed with KHR_draco_mesh_compression, and this Norma was built "
                          "without libdraco"
                        : "needs libdraco, which this Norma was built without; save the meshes "
                          "without Draco's compression";
}

draco_result norma_draco_decode(const draco_stream *stream, size_t *found) {
    return (void)stream, *found = 0, DRACO_KIND; /* nothing asks where nothing is read */
}
