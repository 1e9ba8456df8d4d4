/* overrides.c: which findings an override of a configuration is for, by the names of files, meshes,
 * materials and nodes; and which of its patterns are names of nothing, which a misspelt one is. */
#define _POSIX_C_SOURCE 200809L
#define _XOPEN_SOURCE   700
#include "cli/check/check.h"
#include <stdlib.h>
#include <string.h>

/* ---- whether an override is meant */

/* Brackets, stars and slashes are letters of names as well. */
static int is_name_meant(const char *pattern, const char *name) {
    return strcmp(pattern, name) == 0 || cli_path_matches(pattern, name);
}

static int any_matches(cli_value patterns, const char *name) {
    for (cli_value v = cli_first(patterns); name && v.in; v = cli_next(v))
        if (is_name_meant(cli_string(v), name)) return 1;
    return 0;
}

/* Calls for each name of a kind in a file. */
typedef void see_name(void *user, const char *name);

/* A node by its name, by its path from the root, or by those of the nodes above it, which often
 * draw nothing themselves. */
static void visit_names_of_node(const norma_node_info *node, see_name *see, void *user) {
    char *above = node->path ? strdup(node->path) : NULL;
    see(user, node->name);
    for (char *at = above; at && (at = strchr(at, '/')) != NULL; *at++ = '/') {
        *at = '\0';
        see(user, above);
    }
    see(user, node->path);
    free(above);
}

static const char *below_folder(const check_config *config, const char *path) {
    const size_t length = strlen(config->folder);
    return strncmp(path, config->folder, length) == 0 && path[length] == '/' ? path + length + 1
                                                                             : path;
}

static int is_file_meant(const check_names *names, const check_override *override) {
    const cli_value files = override->lists[CHECK_FILES];
    return !files.in || any_matches(files, below_folder(names->config, names->path));
}

static int is_material_meant(const check_names *names, cli_value patterns, size_t material) {
    norma_material_info info;
    return !norma_document_material_info(names->document, material, &info) &&
           any_matches(patterns, info.name);
}

/* Of an OBJ whose faces have several, all must be meant. */
static int are_materials_meant(const check_names *names, cli_value patterns, size_t mesh) {
    norma_mesh_attributes own;
    norma_mesh_data data;
    uint32_t last = UINT32_MAX;
    if (norma_document_mesh_attributes(names->document, mesh, &own, NULL)) return 0;
    if (!own.face_materials) return is_material_meant(names, patterns, own.material);
    if (norma_document_mesh_data(names->document, mesh, &data, NULL)) return 0;
    const size_t faces = data.mesh.face_starts ? data.mesh.face_count : data.mesh.corner_count / 3;
    for (size_t i = 0; i < faces; last = own.face_materials[i++])
        if ((!i || own.face_materials[i] != last) &&
            !is_material_meant(names, patterns, own.face_materials[i]))
            return 0;
    return 1;
}

typedef struct node_meant {
    cli_value patterns;
    int is_meant;
} node_meant;

static void mean_node(void *user, const char *name) {
    node_meant *node = user;
    node->is_meant |= any_matches(node->patterns, name);
}

static int is_node_meant(cli_value patterns, const norma_node_info *info) {
    node_meant node = {patterns, 0};
    visit_names_of_node(info, mean_node, &node);
    return node.is_meant;
}

/* ---- where a finding is */

struct check_place {
    const char *where;
    size_t mesh;      /* its number in the file */
    size_t primitive; /* as norma_document_mesh_info counts; of a node the first of its mesh */
    size_t node;      /* whose place it is; SIZE_MAX: no node's */
};

static int compare_where(const void *a, const void *b) {
    return strcmp(((const check_place *)a)->where, ((const check_place *)b)->where);
}

static int compare_mesh(const void *a, const void *b) {
    const size_t one = ((const check_place *)a)->mesh, other = ((const check_place *)b)->mesh;
    return (one > other) - (one < other);
}

void check_forget_places(check_names *names) {
    free(names->places);
    names->places = NULL;
    names->placed = NULL;
}

/* Of a document, or of one model of a composite, whose findings follow each other. */
static int list_places(check_names *names, norma_document *document) {
    const size_t meshes = norma_document_mesh_count(document),
                 nodes = norma_document_node_count(document);
    norma_mesh_info mesh;
    norma_node_info node;
    size_t count = 0;
    if (names->placed == document) return 1;
    check_forget_places(names);
    check_place *places = names->places = calloc(meshes + 2 * nodes + 1, sizeof *places);
    if (!places) return 0;
    for (size_t i = 0; i < meshes; ++i)
        if (!norma_document_mesh_info(document, i, &mesh))
            places[count++] = (check_place){mesh.where, mesh.mesh, i, SIZE_MAX};
    const size_t first_node = count;
    for (size_t i = 0; i < nodes; ++i)
        if (!norma_document_node_info(document, i, &node))
            places[count++] = (check_place){
                node.where, node.mesh, node.mesh_count ? node.first_mesh : SIZE_MAX, i};
    names->place_count = count;
    names->drawing_count = count - first_node;
    memcpy(places + count, places + first_node, names->drawing_count * sizeof *places);
    qsort(places, count, sizeof *places, compare_where);
    qsort(places + count, names->drawing_count, sizeof *places, compare_mesh);
    names->placed = document;
    return 1;
}

/* What is wrong with a mesh is seen at every node that draws it: all of them must be meant. */
static int are_nodes_meant(const check_names *names, cli_value patterns, const check_place *place) {
    const check_place *at = names->places + names->place_count, *end = at + names->drawing_count;
    norma_node_info node;
    if (place->node != SIZE_MAX)
        return !norma_document_node_info(names->placed, place->node, &node) &&
               is_node_meant(patterns, &node);
    for (size_t half; (half = (size_t)(end - at)) > 0;) /* the first that draws the mesh */
        if (at[half /= 2].mesh < place->mesh)
            at += half + 1;
        else
            end = at + half;
    end = names->places + names->place_count + names->drawing_count;
    const check_place *first = at;
    for (; at < end && at->mesh == place->mesh; ++at)
        if (norma_document_node_info(names->placed, at->node, &node) ||
            !is_node_meant(patterns, &node))
            return 0;
    return at > first;
}

int check_is_meant(
    check_names *names, const check_override *override, const norma_finding *finding) {
    const cli_value *lists = override->lists;
    norma_mesh_info info;
    size_t tile;
    if (!is_file_meant(names, override)) return 0;
    if (!lists[CHECK_MESHES].in && !lists[CHECK_MATERIALS].in && !lists[CHECK_NODES].in) return 1;
    const check_place wanted = {.where = check_where_in_tile(finding->where, &tile)};
    const check_names own = {.config = names->config,
        .path = names->path,
        .document = norma_document_tile(names->document, tile)};
    if (!own.document) return 0;
    if (!list_places(names, own.document)) return -1;
    const check_place *place =
        bsearch(&wanted, names->places, names->place_count, sizeof wanted, compare_where);
    if (!place || norma_document_mesh_info(own.document, place->primitive, &info)) return 0;
    return (!lists[CHECK_MESHES].in || any_matches(lists[CHECK_MESHES], info.name)) &&
           (!lists[CHECK_MATERIALS].in ||
               are_materials_meant(&own, lists[CHECK_MATERIALS], place->primitive)) &&
           (!lists[CHECK_NODES].in || are_nodes_meant(names, lists[CHECK_NODES], place));
}

/* ---- which patterns match something */

static void visit_names_of(const check_names *names, int list, see_name *see, void *user) {
    norma_mesh_info mesh;
    norma_material_info material;
    norma_node_info node;
    for (size_t i = 0; list == CHECK_MESHES && i < norma_document_mesh_count(names->document); ++i)
        if (!norma_document_mesh_info(names->document, i, &mesh)) see(user, mesh.name);
    for (size_t i = 0;
         list == CHECK_MATERIALS && i < norma_document_material_count(names->document); ++i)
        if (!norma_document_material_info(names->document, i, &material)) see(user, material.name);
    for (size_t i = 0; list == CHECK_NODES && i < norma_document_node_count(names->document); ++i)
        if (!norma_document_node_info(names->document, i, &node))
            visit_names_of_node(&node, see, user);
}

static void visit_names(const check_names *names, int list, see_name *see, void *user) {
    check_names own = *names;
    if (list == CHECK_FILES) see(user, below_folder(names->config, names->path));
    for (size_t tile = 0; (own.document = norma_document_tile(names->document, tile)); ++tile)
        visit_names_of(&own, list, see, user);
}

typedef struct name_marks {
    cli_value patterns;
    unsigned char *matched;
} name_marks;

static void mark_name(void *user, const char *name) {
    const name_marks *marks = user;
    unsigned char *mark = marks->matched;
    for (cli_value v = cli_first(marks->patterns); name && v.in; v = cli_next(v), ++mark)
        if (!*mark && is_name_meant(cli_string(v), name)) *mark = 1;
}

void check_mark_names(const check_names *names) {
    for (size_t i = 0; i < names->config->override_count; ++i) {
        const check_override *override = &names->config->overrides[i];
        const int is_meant = is_file_meant(names, override);
        for (int list = 0; list < CHECK_LISTS; ++list) {
            name_marks marks = {
                override->lists[list], names->config->matched + override->first[list]};
            if (!marks.patterns.in || (!is_meant && list != CHECK_FILES)) continue;
            if (names->document || list == CHECK_FILES)
                visit_names(names, list, mark_name, &marks);
            else /* its names are not known */
                memset(marks.matched, 1, cli_elements(marks.patterns));
        }
    }
}

/* ---- the nearest name of a pattern that matches nothing */

typedef struct nearest_name {
    const char *pattern;
    char word[CLI_LONGEST_WORD + 1];                             /* the pattern without its stars */
    char name[CLI_LONGEST_WORD + 1], part[CLI_LONGEST_WORD + 1]; /* of it, what is near */
} nearest_name;

/* The pattern without its stars is compared with as much of a name: of "leef*" with its beginning,
 * of "*gras" with its end. */
static void compare_with_name(void *user, const char *name) {
    nearest_name *nearest = user;
    char part[CLI_LONGEST_WORD + 1];
    const char *const both[] = {nearest->part, part}, *const *from = both + !nearest->name[0];
    const size_t length = name ? strlen(name) : 0, wanted = strlen(nearest->word),
                 stars = strlen(nearest->pattern);
    if (!length || length > CLI_LONGEST_WORD || !wanted || strcmp(nearest->name, name) == 0) return;
    const int is_end = nearest->pattern[0] == '*', is_begin = nearest->pattern[stars - 1] == '*';
    const size_t taken = (is_end || is_begin) && wanted < length ? wanted : length;
    memcpy(part, name + (is_end && !is_begin ? length - taken : 0), taken);
    part[taken] = '\0';
    if (cli_suggest(nearest->word, from, (size_t)(both + 2 - from), sizeof *both) != part) return;
    strcpy(nearest->name, name);
    strcpy(nearest->part, part);
}

static void begin_nearest(nearest_name *nearest, const char *pattern) {
    size_t length = 0;
    *nearest = (nearest_name){.pattern = pattern};
    for (const char *at = pattern; *at && length < CLI_LONGEST_WORD; ++at)
        if (*at != '*') nearest->word[length++] = *at;
}

/* ---- warnings */

/* Whether all of the configuration's folder was searched; else its files are others of its
 * patterns' as well. */
static int is_searched(const check_config *config, const cli_inputs *inputs) {
    int found = 0;
    for (size_t i = 0; i < inputs->count && !found; ++i) {
        if (!inputs->list[i].within) continue;
        char *folder = strndup(inputs->list[i].path, inputs->list[i].within),
             *whole = folder ? realpath(folder[0] ? folder : ".", NULL) : NULL;
        const size_t length = whole ? strlen(whole) : 0;
        found = whole && strncmp(config->folder, whole, length) == 0 &&
                (config->folder[length] == '/' || !config->folder[length] || length == 1);
        free(folder);
        free(whole);
        while (i + 1 < inputs->count && inputs->list[i + 1].within == inputs->list[i].within &&
               strncmp(inputs->list[i].path, inputs->list[i + 1].path, inputs->list[i].within) == 0)
            ++i;
    }
    return found;
}

/* Looks into the files again, as far as names are. */
static void find_nearest_name(const check_configs *configs, const cli_inputs *inputs,
    const check_override *override, int list, const check_config *config, nearest_name *nearest) {
    const norma_document_options options = {
        .struct_size = sizeof options, .depth = NORMA_DOCUMENT_SUMMARY, .lenient = 1};
    for (size_t i = 0; i < inputs->count; ++i) {
        if (check_config_of(configs, i) != config) continue;
        char *absolute = realpath(inputs->list[i].path, NULL);
        check_names names = {.config = config, .path = absolute ? absolute : inputs->list[i].path};
        if (list == CHECK_FILES || is_file_meant(&names, override)) {
            if (list != CHECK_FILES)
                (void)norma_document_open(inputs->list[i].path, &options, &names.document, NULL);
            visit_names(&names, list, compare_with_name, nearest);
            norma_document_close(names.document);
        }
        free(absolute);
    }
}

static void warn_of_list(const check_configs *configs, const cli_inputs *inputs,
    const check_config *config, const check_override *override, int list) {
    const unsigned char *matched = config->matched + override->first[list];
    if (override->lists[list].in && !cli_elements(override->lists[list]))
        cli_error("%s: overrides: %s: the list is empty, so this override applies to nothing",
            config->path, check_list_keys[list]);
    for (cli_value v = cli_first(override->lists[list]); v.in; v = cli_next(v)) {
        const char *pattern = cli_string(v);
        nearest_name nearest;
        if (*matched++) continue;
        begin_nearest(&nearest, pattern);
        find_nearest_name(configs, inputs, override, list, config, &nearest);
        if (nearest.name[0])
            cli_error("%s: overrides: %s: nothing is called '%s'; did you mean %s?", config->path,
                check_list_keys[list], pattern, nearest.name);
        else if (is_searched(config, inputs))
            cli_error("%s: overrides: %s: nothing is called '%s'", config->path,
                check_list_keys[list], pattern);
    }
}

void check_warn_unmatched(const check_configs *configs, const cli_inputs *inputs) {
    const check_config *last = NULL;
    for (size_t i = 0; i < inputs->count; ++i) {
        const check_config *config = check_config_of(configs, i);
        size_t before = 0;
        if (config == last) continue;
        last = config;
        while (before < i && check_config_of(configs, before) != config) ++before;
        for (size_t k = 0; before == i && k < config->override_count; ++k)
            for (int list = 0; list < CHECK_LISTS; ++list)
                warn_of_list(configs, inputs, config, &config->overrides[k], list);
    }
}
