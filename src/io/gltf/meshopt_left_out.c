/* meshopt_left_out.c: stands in for meshopt_views.c where the library is built without
 * meshoptimizer. Compressed views are an error that says so, which norma check reports as N002. */
#include "io/gltf/gltf.h"

int norma_gltf_reads_meshopt(void) { return 0; }

norma_document_result norma_gltf_decode_meshopt(
    gltf *g, uint32_t number, norma_document_error *error) {
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
        norma_gltf_pointer(g, g->views[number].meshopt.token).text,
        "is compressed; expected uncompressed data, as this Norma was built without meshoptimizer");
}

unsigned char *norma_gltf_encode_meshopt(gltf_meshopt *m, const unsigned char *bytes) {
    return (void)m, (void)bytes, NULL; /* nothing is compressed that was not decoded */
}
