/* levels.c: levels of detail, by names and by MSFT_lod. */
#include "io/together/levels.h"
#include "io/gltf/gltf.h"
#include <stdlib.h>
#include <string.h>

enum { MOST_DIGITS = 4 };

static int is_level_digit(char c) { return c >= '0' && c <= '9'; }
static int is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
static int is_divider(char c) { return c == '_' || c == '-' || c == '.' || c == ' '; }

static int ends_in_lod(const char *name, size_t length) {
    static const char lod[] = "lod";
    if (length < 3) return 0;
    for (size_t i = 0; i < 3; ++i)
        if ((name[length - 3 + i] | 0x20) != lod[i]) return 0;
    return length == 3 || !is_letter(name[length - 4]);
}

int norma_level_of_name(const char *name, int with_ending, uint32_t *level) {
    const char *slash = with_ending ? strrchr(name, '/') : NULL;
    name = slash ? slash + 1 : name;
    const char *dot = with_ending ? strrchr(name, '.') : NULL;
    const size_t end = dot ? (size_t)(dot - name) : strlen(name);
    size_t at = end;
    while (at > 0 && is_level_digit(name[at - 1])) --at;
    const size_t digits = at;
    if (at == end || end - at > MOST_DIGITS) return 0;
    if (at > 0 && is_divider(name[at - 1])) --at;
    if (!ends_in_lod(name, at)) return 0;
    *level = (uint32_t)strtoul(name + digits, NULL, 10);
    return 1;
}

/* ---- MSFT_lod */

static void take_ids(const gltf *g, uint32_t node, uint32_t *levels) {
    const json *j = &g->json;
    const uint32_t extension = norma_json_member(
                       j, norma_json_member(j, g->nodes[node].token, "extensions"), "MSFT_lod"),
                   ids = norma_json_member(j, extension, "ids");
    uint32_t level = 0;
    if (!norma_json_is(j, ids, JSON_ARRAY)) return;
    for (uint32_t id = norma_json_first(j, ids); id != JSON_NONE;
         id = norma_json_next(j, ids, id)) {
        uint64_t number;
        ++level;
        if (norma_json_uint(j, id, &number) && number < g->node_count && number != node &&
            levels[number] < level)
            levels[number] = level;
    }
}

/* A parent may come after its children: as often as the tree is deep, at most. */
static void take_from_parents(const gltf *g, uint32_t *levels) {
    int changed = 1;
    for (uint32_t round = 0; changed && round < g->node_count; ++round) {
        changed = 0;
        for (uint32_t n = 0; n < g->node_count; ++n) {
            const uint32_t parent = g->nodes[n].parent;
            if (parent == GLTF_NONE || levels[parent] <= levels[n]) continue;
            levels[n] = levels[parent];
            changed = 1;
        }
    }
}

uint32_t *norma_levels_of_nodes(const norma_document *document) {
    if (document->format < NORMA_FILE_GLTF) return NULL;
    const gltf *g = norma_gltf_of(document);
    uint32_t *levels = norma_io_allocate(g->node_count, sizeof *levels);
    for (uint32_t n = 0; levels && n < g->node_count; ++n) take_ids(g, n, levels);
    if (levels) take_from_parents(g, levels);
    return levels;
}
