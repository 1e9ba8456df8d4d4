/* draco_decoder.h: what C sees of libdraco: one stream decoded into the caller's arrays. */
#ifndef NORMA_IO_GLTF_DRACO_DECODER_H
#define NORMA_IO_GLTF_DRACO_DECODER_H
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef struct draco_values { /* what an accessor wants of the stream */
    uint32_t id;              /* the attribute's number in the stream; not for indices */
    uint32_t width;           /* numbers in an element */
    int component;            /* 5120 ... as glTF counts them */
    unsigned char *out;       /* elements back to back */
} draco_values;

typedef struct draco_stream {
    const unsigned char *bytes;
    size_t size, points, faces; /* points and faces: as many as the stream has to hold */
    const draco_values *attributes;
    size_t attribute_count;
    const draco_values *indices; /* NULL: not wanted; else three for each face */
    size_t most;                 /* bytes that the values of all its attributes may take */
} draco_stream;

typedef enum draco_result {
    DRACO_OK = 0,
    DRACO_MEMORY,
    DRACO_BROKEN,    /* damaged or cut short */
    DRACO_KIND,      /* no mesh of the version that glTF has */
    DRACO_FACES,     /* found: how many it holds */
    DRACO_POINTS,    /* found */
    DRACO_LARGE,     /* found: bytes that its attributes would take */
    DRACO_ATTRIBUTE, /* found: which of the attributes it lacks */
    DRACO_WIDTH,     /* found: which of them has another number of components */
    DRACO_VALUE      /* found: which of them holds what the component's type cannot */
} draco_result;

/* found: for some results, as above. */
draco_result norma_draco_decode(const draco_stream *stream, size_t *found);
int norma_draco_reads(void); /* 0: there is no libdraco */
/* Why not: of a primitive, as a clause; else of a file, behind "requires ..., which". "": it reads.
 */
const char *norma_draco_missing(int of_primitive);

#ifdef __cplusplus
}
#endif
#endif
