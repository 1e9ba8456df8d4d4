/* other_asset.h: the JSON of a file that may be an asset, looked into without opening it as a
 * document. */
#ifndef NORMA_IO_GLTF_OTHER_ASSET_H
#define NORMA_IO_GLTF_OTHER_ASSET_H
#include "io/file/file.h"
#include "io/text/json.h"

typedef enum gltf_other {
    GLTF_OTHER_NONE = 0, /* no glTF */
    GLTF_OTHER_READ,     /* *j is the caller's to free, and the file must stay open meanwhile */
    GLTF_OTHER_UNKNOWN,  /* begins like one, and cannot be read */
    GLTF_OTHER_MEMORY    /* out of memory */
} gltf_other;
gltf_other norma_gltf_read_other(const file_bytes *file, json *j);
#endif
