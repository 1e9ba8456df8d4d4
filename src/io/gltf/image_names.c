/* image_names.c: the files that new images go into, beside the output and named after it:
 * "scene_normal_2.png". No file of other content is overwritten, and none takes a name that the
 * asset has for something else. On a stream they are data: URIs. */
#include "io/gltf/patch.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ATTEMPTS = 10000 };

static int equals_ignoring_case(const char *a, const char *b) {
    for (a += strncmp(a, "./", 2) == 0 ? 2 : 0; *a && *b; ++a, ++b)
        if ((*a >= 'A' && *a <= 'Z' ? *a + 32 : *a) != (*b >= 'A' && *b <= 'Z' ? *b + 32 : *b))
            return 0;
    return *a == *b;
}

/* Whether a buffer or another image has the name; -1: out of memory. */
static int is_named(const gltf *g, const given_image *image, const char *name) {
    const json *j = &g->json;
    const uint32_t images = norma_json_member(j, 0, "images");
    size_t number = 0;
    int failed = 0, found = 0;
    for (uint32_t b = 0; b < g->buffer_count; ++b)
        found |= g->buffers[b].name && equals_ignoring_case(g->buffers[b].name, name);
    for (uint32_t token = norma_json_first(j, images); token != JSON_NONE && !found && !failed;
         token = norma_json_next(j, images, token), ++number) {
        if (number == image->number) continue;
        const given_image *given = norma_document_given_image(g->document, number);
        char *other = given ? NULL : norma_gltf_image_name(j, token, &failed);
        found = (given && given->name && equals_ignoring_case(given->name, name)) ||
                (other && equals_ignoring_case(other, name));
        free(other);
    }
    return failed ? -1 : found;
}

/* Whether nothing is there, or these very bytes; -1: out of memory. */
static int is_free(const given_image *image, const char *path) {
    file_bytes there;
    const int failed = norma_file_open(path, NULL, &there);
    if (failed) return failed == ENOMEM ? -1 : failed == ENOENT || failed == ENOTDIR;
    const int same = there.size == image->size && memcmp(there.data, image->bytes, there.size) == 0;
    norma_file_close(&there);
    return same;
}

/* 1: chosen, 0: not, -1: out of memory. */
static int try_name(gltf *g, given_image *image, const char *path, unsigned attempt) {
    char ending[60];
    int at = snprintf(ending, sizeof ending, "_normal_%zu", image->number);
    if (attempt) at += snprintf(ending + at, 16, "-%u", attempt);
    memcpy(ending + at, ".png", 5);
    char *name = norma_gltf_name_after(path, ending), *folder = norma_gltf_folder_of(path),
         *file = name && folder ? norma_io_join(folder, name) : NULL;
    const int named = file ? is_named(g, image, name) : -1, chosen = named < 0 ? -1
                                                                     : !named ? is_free(image, file)
                                                                              : 0;
    free(folder);
    free(file);
    if (chosen == 1)
        image->name = name;
    else
        free(name);
    return chosen;
}

static int choose_image_name(gltf *g, given_image *image, const char *path) {
    int chosen = 0;
    free(image->name);
    image->name = NULL;
    for (unsigned attempt = 0; chosen == 0 && attempt < MOST_ATTEMPTS; ++attempt)
        chosen = try_name(g, image, path, attempt);
    return chosen;
}

static void set_uri(gltf *g, uint32_t token, const given_image *image, gltf_destination to) {
    json_text uri = {0};
    char *name = to == GLTF_TO_STREAM ? NULL : norma_gltf_uri_encode(image->name);
    const patch_segment whole = {.length = image->size, .bytes = image->bytes};
    norma_json_add_text(&uri, "\"");
    norma_json_add_text(&uri, name ? name : "data:image/png;base64,");
    if (!name) norma_gltf_add_base64(&uri, &whole, 1, NULL);
    norma_json_add(&uri, "\"", 2);
    if (uri.failed || (!name && to != GLTF_TO_STREAM))
        norma_json_edits_fail(g->patch->layout);
    else
        norma_json_set(g->patch->layout, token, "uri", uri.data);
    free(uri.data);
    free(name);
}

norma_document_result norma_gltf_name_images(
    gltf *g, gltf_destination destination, const char *path, norma_document_error *error) {
    norma_document *document = g->document;
    for (size_t i = 0; i < document->image_count && destination != GLTF_TO_MEMORY; ++i) {
        given_image *image = &document->images[i];
        const uint32_t token = norma_json_element(
            &g->json, norma_json_member(&g->json, 0, "images"), (uint32_t)image->number);
        const int chosen = destination == GLTF_TO_STREAM ? 1 : choose_image_name(g, image, path);
        if (chosen < 0) return norma_document_fail_memory(document, error);
        if (chosen == 0)
            return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_REFUSED, NULL,
                "no name is left beside the output for its normal map %zu", image->number);
        if (token != JSON_NONE) set_uri(g, token, image, destination);
    }
    return NORMA_DOCUMENT_OK;
}
