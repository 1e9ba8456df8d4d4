/* tileset.c: the files that a tileset of 3D Tiles names as contents of its tiles, and those of the
 * tilesets that it names in turn. Source: OGC 18-053r2, 3D Tiles Specification 1.0, chapter 7; OGC
 * 22-025r4 (1.1) for several contents of a tile and for implicit tiling. */
#include "io/format/format.h"
#include "io/gltf/gltf.h"
#include "io/text/text.h"
#include <stdlib.h>
#include <string.h>

typedef struct tileset_walk {
    norma_visit_file *visit;
    void *user;
    norma_names paths; /* of tilesets; those from next on are to be read yet */
    size_t next;
    int stopped, moves; /* moves: a tile has a transform of its own, or a tileset in another */
} tileset_walk;

static norma_document_result fail_tileset(const char *path, norma_document_error *error,
    norma_document_result result, const char *message, const char *name) {
    const norma_document named = {.path = (char *)(uintptr_t)path};
    return norma_document_fail(&named, error, result, NULL, "%s%s", name, message);
}

static norma_document_result add_tileset(
    tileset_walk *walk, const char *path, norma_document_error *error) {
    return norma_names_number(&walk->paths, path, strlen(path)) == UINT32_MAX
               ? norma_document_fail_memory(NULL, error)
               : NORMA_DOCUMENT_OK;
}

int norma_is_tileset(const char *path) {
    const char *dot = path ? strrchr(path, '.') : NULL;
    return dot && (strcmp(dot, ".json") == 0 || strcmp(dot, ".JSON") == 0);
}

/* Without what a server would be asked. */
static char *name_of_content(const json *j, uint32_t content) {
    uint32_t uri = norma_json_member(j, content, "uri");
    if (uri == JSON_NONE) uri = norma_json_member(j, content, "url"); /* before 1.0 */
    char *text = norma_json_string(j, uri);
    if (text) text[strcspn(text, "?#")] = '\0';
    char *name = text ? norma_gltf_uri_decode(text) : NULL;
    free(text);
    return name;
}

static norma_document_result visit_content(
    tileset_walk *walk, const char *tileset, const char *name, norma_document_error *error) {
    char *folder = norma_gltf_folder_of(tileset), *path = NULL;
    const int is_inside = folder && norma_gltf_path_inside(folder, name, &path);
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!folder)
        result = norma_document_fail_memory(NULL, error);
    else if (!is_inside)
        result = fail_tileset(tileset, error, NORMA_DOCUMENT_ERROR_REFUSED,
            ": the tile is not opened, because it is not a file in the tileset's folder", name);
    else if (norma_is_tileset(path))
        result = add_tileset(walk, path, error);
    else if (norma_file_format_of_path(path) && walk->visit(walk->user, path))
        walk->stopped = 1;
    free(folder);
    free(path);
    return result;
}

static int is_identity(const json *j, uint32_t matrix) {
    uint32_t element = JSON_NONE;
    for (int i = 0; norma_json_each(j, matrix, &element); ++i) {
        double number;
        if (!norma_json_number(j, element, &number) || number != (i % 5 == 0)) return 0;
    }
    return 1;
}

/* The root of all may be turned: that turns every tile alike. */
static int has_moved_tile(const tileset_walk *walk, const json *j) {
    const uint32_t root = walk->next > 1
                              ? JSON_NONE
                              : norma_json_member(j, norma_json_member(j, 0, "root"), "transform");
    for (uint32_t t = 0; t + 1 < j->count; ++t)
        if (norma_json_equals(j, t, "transform") && norma_json_is(j, t + 1, JSON_ARRAY) &&
            t + 1 != root && !is_identity(j, t + 1))
            return 1;
    return 0;
}

/* In the order of the text, which is that of the tiles; contents are known by their members, at any
 * depth. */
static norma_document_result visit_tiles(
    tileset_walk *walk, const char *path, const json *j, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t t = 0; t + 1 < j->count && !result && !walk->stopped; ++t) {
        if (norma_json_equals(j, t, "implicitTiling") && norma_json_is(j, t + 1, JSON_OBJECT))
            return fail_tileset(path, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
                "its tiling is implicit, so it does not list its tiles; give their folder", "");
        const int is_one = norma_json_equals(j, t, "content"),
                  are_several = norma_json_equals(j, t, "contents");
        if (!is_one && !are_several) continue;
        uint32_t content = is_one ? t + 1 : norma_json_first(j, t + 1);
        for (; content != JSON_NONE && !result && !walk->stopped;
             content = is_one ? JSON_NONE : norma_json_next(j, t + 1, content)) {
            char *name = name_of_content(j, content);
            if (name) result = visit_content(walk, path, name, error);
            free(name);
        }
    }
    return result;
}

static norma_document_result read_tileset(
    tileset_walk *walk, const char *path, norma_document_error *error) {
    file_bytes bytes = {0};
    json j = {0};
    json_error wrong;
    const int failed = norma_file_open(path, NULL, &bytes);
    if (failed) return norma_document_fail_file(path, error, "cannot be read", failed);
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!norma_json_parse((const char *)bytes.data, bytes.size, NULL, &j, &wrong))
        result = wrong.expected ? fail_tileset(path, error, NORMA_DOCUMENT_ERROR_MALFORMED,
                                      "; so it is no tileset of 3D Tiles", "is not JSON")
                                : norma_document_fail_memory(NULL, error);
    else if (!norma_json_is(&j, norma_json_member(&j, 0, "root"), JSON_OBJECT) ||
             !norma_json_is(&j, norma_json_member(&j, 0, "asset"), JSON_OBJECT))
        result = fail_tileset(path, error, NORMA_DOCUMENT_ERROR_MALFORMED,
            "expected \"asset\" and \"root\", as a tileset of 3D Tiles has them", "");
    else {
        walk->moves |= has_moved_tile(walk, &j);
        result = visit_tiles(walk, path, &j, error);
    }
    norma_json_free(&j);
    norma_file_close(&bytes);
    return result;
}

static norma_document_result walk_tilesets(
    tileset_walk *walk, const char *path, norma_document_error *error) {
    norma_document_clear(error);
    if (!path || !walk->visit)
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "no path or no function that receives the files was given");
    norma_document_result result = add_tileset(walk, path, error);
    while (!result && !walk->stopped && walk->next < walk->paths.count)
        result = read_tileset(walk, walk->paths.list[walk->next++], error);
    norma_names_free(&walk->paths);
    return result;
}

norma_document_result norma_tileset_visit_tiles(
    const char *path, norma_visit_file *visit, void *user, norma_document_error *error) {
    tileset_walk walk = {.visit = visit, .user = user};
    return walk_tilesets(&walk, path, error);
}

static int pass_by(void *user, const char *path) {
    (void)user;
    (void)path;
    return 0;
}

int norma_tileset_moves_tiles(const char *path) {
    tileset_walk walk = {.visit = pass_by};
    return walk_tilesets(&walk, path, NULL) == NORMA_DOCUMENT_OK && walk.moves;
}
