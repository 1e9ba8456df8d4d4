/* member.c: files of one surface, one at a time: what is locked, which level of detail it is, where
 * it is drawn. */
#include "io/together/together.h"
#include "io/gltf/gltf.h"
#include "io/obj/obj.h"
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* ---- Matching without recursion: only the last star is ever gone back to. */

/* One of a set, from behind its bracket; *end: behind the closing one. Without that, NULL. */
static int is_in_set(const char *p, char c, const char **end) {
    const int none_of = *p == '!' || *p == '^';
    int found = 0;
    const char *first = p += none_of;
    for (; *p && (*p != ']' || p == first); ++p) {
        if (p[1] == '-' && p[2] && p[2] != ']') {
            found |=
                (unsigned char)p[0] <= (unsigned char)c && (unsigned char)c <= (unsigned char)p[2];
            p += 2;
        } else {
            found |= *p == c;
        }
    }
    *end = *p ? p + 1 : NULL;
    return found != none_of;
}

/* Whether the first element of the pattern matches c, which is no end; *next: behind it. */
static int matches_one(const char *pattern, char c, const char **next) {
    const char *end = NULL;
    *next = pattern + 1;
    if (*pattern == '?') return 1;
    if (*pattern == '[') {
        const int found = is_in_set(pattern + 1, c, &end);
        if (end) *next = end;
        return end ? found : c == '[';
    }
    if (*pattern == '\\' && pattern[1]) {
        *next = pattern + 2;
        return pattern[1] == c;
    }
    return *pattern == c;
}

/* *: anything, ?: one byte, [a-z] and [!a-z]: one of them, or none of them; \\: the next as it is.
 */
static int matches(const char *pattern, const char *name) {
    const char *star = NULL, *again = NULL, *next;
    while (*name) {
        if (*pattern == '*') {
            star = ++pattern;
            again = name;
        } else if (*pattern && matches_one(pattern, *name, &next)) {
            pattern = next;
            ++name;
        } else if (star) {
            pattern = star;
            name = ++again;
        } else {
            return 0;
        }
    }
    while (*pattern == '*') ++pattern;
    return !*pattern;
}

/* ---- Levels of detail, by names and by MSFT_lod. */

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

/* The number at the end of a name like Rock_LOD2, any case, "_", "-", "." or a blank or nothing
 * between; with_ending: a path, whose folder and ending are left out. Returns whether there is one.
 */
static int level_of_name(const char *name, int with_ending, uint32_t *level) {
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
    for (uint32_t id = JSON_NONE; norma_json_each(j, ids, &id);) {
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

/* Of each glTF node its place in the MSFT_lod of another one, or of one above it; 0: in none. To be
 * freed; NULL: out of memory, or the document is no glTF. */
static uint32_t *levels_of_nodes(const norma_document *document) {
    if (!norma_file_format_is_gltf(document->format)) return NULL;
    const gltf *g = norma_gltf_of(document);
    uint32_t *levels = norma_io_allocate(g->node_count, sizeof *levels);
    for (uint32_t n = 0; levels && n < g->node_count; ++n) take_ids(g, n, levels);
    if (levels) take_from_parents(g, levels);
    return levels;
}

/* ---- Positions through the matrix of their node, welded by a hash table. */

void norma_together_free_world(world_mesh *w) {
    void *const blocks[] = {w->positions, w->at, w->corners, w->weld, w->firsts};
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; ++i) free(blocks[i]);
    *w = (world_mesh){0};
}

/* ---- positions */

void norma_together_position(
    const document_surface *surface, const placement *place, size_t index, double position[3]) {
    double p[3];
    const double *m = place->world;
    norma_view_read(&surface->mesh->positions, index, p);
    for (int k = 0; k < 3; ++k) p[k] *= surface->unit;
    for (int k = 0; k < 3; ++k)
        position[k] =
            place->plain ? p[k] : m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
}

void norma_together_at(const equality *equal, const double position[3], double at[3]) {
    for (int k = 0; k < 3; ++k)
        at[k] = (equal->rounded ? (double)(float)position[k] : position[k]) + 0.0;
    if (equal->near) norma_near_find(equal->near, at);
}

static int place_positions(
    const document_surface *surface, const placement *place, const equality *equal, world_mesh *w) {
    const size_t count = surface->mesh->positions.count;
    w->positions = norma_io_block(count, 3 * sizeof(double));
    w->at = norma_io_block(count, sizeof *w->at);
    w->weld = norma_io_block(count, sizeof *w->weld);
    w->firsts = norma_io_block(count, sizeof *w->firsts);
    if (!w->positions || !w->at || !w->weld || !w->firsts) return 0;
    for (size_t i = 0; i < count; ++i) {
        norma_together_position(surface, place, i, w->positions + 3 * i);
        norma_together_at(equal, w->positions + 3 * i, w->at[i]);
    }
    return 1;
}

/* ---- which are one */

static int weld_placed(world_mesh *w, size_t count) {
    size_t size = 16;
    while (size / 2 < count) size *= 2;
    uint32_t *table = norma_io_allocate(size, sizeof *table);
    for (size_t i = 0; table && i < count; ++i) {
        w->weld[i] = (uint32_t)i;
        if (!norma_core_finite(w->at[i])) continue;
        size_t at = (size_t)norma_together_hash(w->at[i]) & (size - 1);
        while (table[at] && memcmp(w->at[table[at] - 1], w->at[i], sizeof w->at[i]) != 0)
            at = (at + 1) & (size - 1);
        if (!table[at]) {
            table[at] = (uint32_t)i + 1;
            w->firsts[w->first_count++] = (uint32_t)i;
        }
        w->weld[i] = table[at] - 1;
    }
    free(table);
    return table != NULL;
}

/* ---- faces */

/* From the corner that lies first, so that what a face adds does not depend on the corner that its
 * file begins with. */
static void turn_placed_faces(world_mesh *w) {
    for (size_t f = 0; f < w->mesh.face_count; ++f) {
        const size_t begin = norma_core_face_begin(&w->mesh, f),
                     count = norma_core_face_end(&w->mesh, f) - begin;
        uint32_t *corners = w->corners + begin;
        size_t first = 0;
        for (size_t k = 1; k < count; ++k)
            if (norma_together_compare(w->at[corners[k]], w->at[corners[first]]) < 0) first = k;
        for (size_t turned = 0; turned < first; ++turned) {
            const uint32_t moved = corners[0];
            memmove(corners, corners + 1, (count - 1) * sizeof *corners);
            corners[count - 1] = moved;
        }
    }
}

static int take_placed_corners(const document_surface *surface, world_mesh *w) {
    const size_t count = surface->mesh->corner_count;
    w->corners = norma_io_block(count, sizeof *w->corners);
    for (size_t c = 0; w->corners && c < count; ++c)
        w->corners[c] = norma_mesh_corner(surface->mesh, c);
    return w->corners != NULL;
}

norma_result norma_together_place(
    const document_surface *surface, const placement *place, const equality *equal, world_mesh *w) {
    const size_t count = surface->mesh->positions.count;
    *w = (world_mesh){0};
    if (!place_positions(surface, place, equal, w) || !weld_placed(w, count) ||
        !take_placed_corners(surface, w))
        return NORMA_ERROR_MEMORY;
    const norma_mesh moved = {
        .positions = {.data = w->positions, .count = count, .format = NORMA_FORMAT_DOUBLE},
        .corners = w->corners,
        .corner_count = surface->mesh->corner_count,
        .face_starts = surface->mesh->face_starts,
        .face_count = surface->mesh->face_count};
    const norma_result result = norma_core_mesh_shape(&moved, &w->mesh);
    if (result) return result;
    w->mesh.scale = 1;
    w->mesh.weld = w->weld;
    turn_placed_faces(w);
    return NORMA_OK;
}

/* ---- Files of one surface, one at a time. */

void norma_member_close(member *m) {
    norma_document_close(m->document);
    free(m->node_levels);
    free(m->locked);
    *m = (member){0};
}

/* ---- what keeps its normals */

static int is_asked_for(void *options, const char *name) {
    const norma_together_options *o = options;
    int asked = 0;
    for (size_t i = 0; i < o->lock_count; ++i) {
        if (!matches(o->lock[i], name)) continue;
        asked = 1;
        if (o->lock_matches) ++o->lock_matches[i];
    }
    return asked;
}

static const char *material_of(norma_document *document, size_t mesh) {
    norma_mesh_attributes attributes;
    norma_material_info material;
    return norma_document_mesh_attributes(document, mesh, &attributes, NULL) ||
                   attributes.material == SIZE_MAX ||
                   norma_document_material_info(document, attributes.material, &material)
               ? ""
               : material.name;
}

/* A mesh without normals has nothing to keep. */
static int keeps_mesh(member *m, size_t mesh, void *options) {
    norma_mesh_info info;
    if (norma_document_mesh_info(m->document, mesh, &info)) return 0;
    const int asked =
        is_asked_for(options, info.name) | is_asked_for(options, material_of(m->document, mesh));
    return asked && !info.not_read && info.normals != NORMA_NORMALS_NONE;
}

static int keeps_whole_file(member *m, const char *path, void *options) {
    norma_mesh_info info;
    const char *slash = strrchr(path, '/');
    const int asked = is_asked_for(options, slash ? slash + 1 : path);
    return asked && !norma_document_mesh_info(m->document, 0, &info) &&
           info.normals != NORMA_NORMALS_NONE;
}

static norma_document_result find_locked(
    member *m, const char *path, const norma_together_options *given, norma_document_error *error) {
    void *options = (void *)(uintptr_t)given;
    norma_mesh_info info;
    if (!given->lock_count) return NORMA_DOCUMENT_OK;
    const size_t meshes = norma_document_mesh_count(m->document);
    const int is_obj = m->document->format == NORMA_FILE_OBJ;
    if (norma_document_mesh_info(m->document, 0, &info)) return NORMA_DOCUMENT_OK; /* no mesh */
    m->locked = norma_io_allocate(is_obj ? info.faces : meshes, 1);
    int ok = m->locked != NULL;
    if (ok && is_obj)
        ok = norma_obj_mark_faces(m->document, is_asked_for, options, m->locked);
    else if (ok && m->document->format == NORMA_FILE_PLY)
        m->locked[0] = (uint8_t)keeps_whole_file(m, path, options);
    else
        for (size_t i = 0; ok && i < meshes; ++i) m->locked[i] = (uint8_t)keeps_mesh(m, i, options);
    return ok ? NORMA_DOCUMENT_OK : norma_document_fail_memory(m->document, error);
}

/* ---- opening */

/* What moves a tile and is not in its nodes is not applied: then all must have the same, and none
 * where others' votes come from files. */
static norma_document_result check_frame(
    together_run *run, const norma_document *document, norma_document_error *error) {
    const int is_gltf = norma_file_format_is_gltf(document->format);
    double center[3] = {0};
    const int is_known = !is_gltf || norma_gltf_read_frame(norma_gltf_of(document), center);
    if (run->number == 0 && !run->seams && !run->tile.marks)
        memcpy(run->center, center, sizeof center);
    if (is_known && center[0] == run->center[0] && center[1] == run->center[1] &&
        center[2] == run->center[2])
        return NORMA_DOCUMENT_OK;
    return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "the RTC_CENTER or the instances of %s are not applied, so seams would be sought at wrong "
        "places; expected tiles in one frame",
        run->number ? "this tile or of another" : "this tile");
}

norma_document_result norma_member_open(together_run *run, member *m) {
    const norma_together_file *file = &run->files[run->number];
    const norma_together_options *options = &run->options;
    norma_document_error *error = run->error;
    const norma_document_options opening = {
        .struct_size = sizeof opening, .format = file->format, .threads = options->threads};
    *m = (member){0};
    norma_document_result result = norma_document_open(file->input, &opening, &m->document, error);
    if (result) return result;
    if (m->document->format == NORMA_FILE_STL)
        return norma_document_fail(m->document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "an STL holds facet normals only, which nothing can share; expected OBJ, PLY or glTF");
    if (m->document->format == NORMA_FILE_3MF)
        return norma_document_fail(m->document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "a 3MF has no normals; expected OBJ, PLY or glTF");
    if (m->document->tile_count)
        return norma_document_fail(m->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "the composite has %zu tiles with meshes; expected one, so split it first",
            m->document->tile_count);
    result = check_frame(run, m->document, error);
    if (result) return result;
    m->level = (uint32_t)run->number;
    m->has_level = options->levels || level_of_name(file->input, 1, &m->level);
    if (norma_file_format_is_gltf(m->document->format) &&
        !(m->node_levels = levels_of_nodes(m->document)))
        return norma_document_fail_memory(m->document, error);
    return find_locked(m, file->input, options, error);
}

/* ---- places */

static const double IDENTITY[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static placement place_by(const double world[16], uint32_t level) {
    placement place = {.mirrored = norma_matrix_determinant(world) < 0, .level = level};
    memcpy(place.world, world, sizeof place.world);
    place.plain = memcmp(world, IDENTITY, sizeof IDENTITY) == 0;
    return place;
}

static uint32_t level_at(
    const member *m, const document_surface *surface, const norma_node_info *node) {
    norma_mesh_info info;
    uint32_t level = 0;
    if (norma_document_mesh_info(m->document, surface->parts[0].mesh, &info) == NORMA_DOCUMENT_OK &&
        level_of_name(info.name, 0, &level))
        return level;
    if (node && level_of_name(node->name, 0, &level)) return level;
    if (node && m->node_levels && m->node_levels[node->node]) return m->node_levels[node->node];
    return m->has_level ? m->level : 0;
}

/* A skin places its mesh by joints, not by the node: it is compared as it was bound. */
static norma_document_result add_node(const member *m, const document_surface *surface, size_t node,
    placement **places, size_t *count, size_t *room, norma_document_error *error) {
    const gltf *g = norma_gltf_of(m->document); /* no other format has both places and normals */
    if (g->nodes[g->drawing[node]].mesh != surface->number) return NORMA_DOCUMENT_OK;
    norma_node_info info;
    norma_document_result result = norma_document_node_info(m->document, node, &info);
    if (result) return result;
    for (size_t i = 0; i < info.instances && !result; ++i) {
        double world[16];
        placement *place = norma_io_add(places, room, count, sizeof *place);
        if (!place) return norma_document_fail_memory(m->document, error);
        result = norma_document_instance_world(m->document, node, i, world, error);
        *place = place_by(info.skin == SIZE_MAX ? world : IDENTITY, level_at(m, surface, &info));
    }
    return result;
}

static norma_document_result member_places(const member *m, const document_surface *surface,
    placement **places, size_t *count, norma_document_error *error) {
    const size_t nodes = norma_document_node_count(m->document);
    norma_document_result result = NORMA_DOCUMENT_OK;
    size_t room = 0;
    *places = NULL;
    *count = 0;
    for (size_t n = 0; n < nodes && !result; ++n)
        result = add_node(m, surface, n, places, count, &room, error);
    if (result || nodes) return result;
    placement *place = norma_io_add(places, &room, count, sizeof *place);
    if (!place) return norma_document_fail_memory(m->document, error);
    *place = place_by(IDENTITY, level_at(m, surface, NULL));
    return NORMA_DOCUMENT_OK;
}

/* ---- all of them */

typedef struct member_visit {
    together_run *run;
    member *m;
    visit_placed *visit;
    void *user;
} member_visit;

static norma_document_result visit_places(void *context, const document_surface *surface) {
    const member_visit *v = context;
    placed_surface at = {.run = v->run, .m = v->m, .surface = surface};
    placement *places;
    norma_document_result result = member_places(v->m, surface, &places, &at.count, v->run->error);
    at.places = places;
    if (!result) result = v->visit(v->user, &at);
    free(places);
    return result;
}

norma_document_result norma_member_visit(
    together_run *run, member *m, visit_placed *visit, void *user) {
    member_visit v = {run, m, visit, user};
    norma_mesh_data data;
    norma_mesh_info info;
    if (norma_file_format_is_gltf(m->document->format))
        return norma_gltf_visit_surfaces(m->document, visit_places, &v, run->error);
    if (norma_document_mesh_info(m->document, 0, &info) || info.not_read) return NORMA_DOCUMENT_OK;
    const norma_document_result result =
        norma_document_mesh_data(m->document, 0, &data, run->error);
    if (result) return result;
    const surface_part whole = {0, 0, 0};
    const document_surface surface = {
        .mesh = &data.mesh, .unit = 1, .parts = &whole, .part_count = 1};
    return visit_places(&v, &surface);
}

int norma_together_rounds(const norma_together_file *files, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        const norma_file_format format =
            files[i].format ? files[i].format : norma_file_format_of_path(files[i].input);
        if (norma_file_format_is_gltf(format)) return 1;
    }
    return 0;
}

char *norma_together_folder_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return !slash          ? norma_io_copy_text(".", 1)
           : slash == path ? norma_io_copy_text("/", 1)
                           : norma_io_copy_text(path, (size_t)(slash - path));
}
