/* draco_elsewhere.c: Draco's streams are decoded by npm's draco3dgltf, which JavaScript loads when
 * the first is met (web/package/decoders.js). */
#include "io/gltf/draco_decoder.h"

/* JavaScript reads both structs as 32-bit numbers, one for each member. */
_Static_assert(sizeof(draco_stream) == 8 * 4 && sizeof(draco_values) == 4 * 4, "decoders.js");

__attribute__((import_module("norma"), import_name("draco_decode"))) draco_result carry_stream(
    const draco_stream *stream, size_t *found);

int norma_draco_reads(void) { return 1; }
const char *norma_draco_missing(int of_primitive) { return (void)of_primitive, ""; }

draco_result norma_draco_decode(const draco_stream *stream, size_t *found) {
    *found = 0;
    return carry_stream(stream, found);
}
