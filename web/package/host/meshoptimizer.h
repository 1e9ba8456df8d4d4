/* meshoptimizer.h: what src/io calls of meshoptimizer, as JavaScript gives it by npm's package
 * (web/package/decoders.js). An encoder of which nothing fits returns 0. */
#ifndef NORMA_WEB_MESHOPTIMIZER_H
#define NORMA_WEB_MESHOPTIMIZER_H
#include <stddef.h>

#define FROM_JAVASCRIPT(name) __attribute__((import_module("norma"), import_name(#name))) name

int FROM_JAVASCRIPT(meshopt_decodeVertexBuffer)(
    void *out, size_t count, size_t stride, const unsigned char *bytes, size_t size);
int FROM_JAVASCRIPT(meshopt_decodeIndexBuffer)(
    void *out, size_t count, size_t stride, const unsigned char *bytes, size_t size);
int FROM_JAVASCRIPT(meshopt_decodeIndexSequence)(
    void *out, size_t count, size_t stride, const unsigned char *bytes, size_t size);
size_t FROM_JAVASCRIPT(meshopt_encodeVertexBuffer)(
    unsigned char *out, size_t room, const void *rows, size_t count, size_t stride);
size_t FROM_JAVASCRIPT(meshopt_encodeIndexBuffer)(
    unsigned char *out, size_t room, const unsigned *indices, size_t count);
size_t FROM_JAVASCRIPT(meshopt_encodeIndexSequence)(
    unsigned char *out, size_t room, const unsigned *indices, size_t count);
void FROM_JAVASCRIPT(meshopt_encodeFilterOct)(
    void *rows, size_t count, size_t stride, int bits, const float *floats);

/* No fewer than the library says: a byte that says how for each sixteen, five for an index. */
static inline size_t meshopt_encodeVertexBufferBound(size_t count, size_t stride) {
    return 2 * count * stride + 1024;
}
static inline size_t meshopt_encodeIndexBufferBound(size_t count, size_t vertices) {
    return (void)vertices, 6 * count + 64;
}
static inline size_t meshopt_encodeIndexSequenceBound(size_t count, size_t vertices) {
    return (void)vertices, 6 * count + 64;
}
static inline void meshopt_encodeIndexVersion(int version) { (void)version; /* npm's has 1 */ }
#endif
