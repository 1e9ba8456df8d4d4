/* other_asset.c: finds and parses the JSON of a .gltf or GLB, whatever the file is called. */
#include "io/gltf/other_asset.h"
#include "io/gltf/asset.h"
#include <string.h>

enum { GLB_TEXT = 20, LARGEST_TEXT = 1 << 28 };

static int begins_like_json(const char *text, size_t size) {
    size_t at = size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    while (at < size && (text[at] == ' ' || (text[at] >= '\t' && text[at] <= '\r'))) ++at;
    return at < size && text[at] == '{';
}

gltf_other norma_gltf_read_other(const file_bytes *file, json *j) {
    const char *text = (const char *)file->data;
    size_t size = file->size;
    json_error wrong;
    if (size > GLB_TEXT && memcmp(text, "glTF", 4) == 0) {
        const size_t length = norma_gltf_u32(file->data + 12);
        text += GLB_TEXT;
        size = length < size - GLB_TEXT ? length : size - GLB_TEXT;
    } else if (!begins_like_json(text, size)) {
        return GLTF_OTHER_NONE;
    }
    if (size > LARGEST_TEXT) return GLTF_OTHER_UNKNOWN;
    if (norma_json_parse(text, size, NULL, j, &wrong)) return GLTF_OTHER_READ;
    norma_json_free(j);
    return wrong.expected ? GLTF_OTHER_UNKNOWN : GLTF_OTHER_MEMORY;
}
