/* odd_asset.h: assets that are valid and odd, made of an input's bytes: views that several
 * accessors share, accessors that overlap, interleaved strides, buffers shorter than their files,
 * files with two names, sparse values over shared views, accessors without a view. */
#ifndef NORMA_FUZZ_ODD_ASSET_H
#define NORMA_FUZZ_ODD_ASSET_H
#include "fuzz.h"

enum { ODD_FILE_SIZE = 640, ODD_TEXT_SIZE = 16384 };
/* What every buffer holds: indices of three kinds below byte 160, then small floats. */
void fuzz_odd_contents(uint8_t contents[ODD_FILE_SIZE]);
/* The text of a .gltf whose buffers have some of these names, or are data: URIs. image may be NULL.
 * Returns its length. */
size_t fuzz_odd_asset(fuzz_bytes *bytes, const char *const *names, size_t name_count,
    const char *image, char text[ODD_TEXT_SIZE]);
#endif
