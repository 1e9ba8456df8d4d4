/* member.c: files of one surface, one at a time. */
#include "io/together/member.h"
#include "io/format/format.h"
#include "io/gltf/gltf.h"
#include "io/obj/obj.h"
#include "io/together/levels.h"
#include "io/together/pattern.h"
#include <stdlib.h>
#include <string.h>

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
        if (!norma_matches(o->lock[i], name)) continue;
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

norma_document_result norma_member_open(const norma_together_file *file, size_t number,
    const norma_together_options *options, member *m, norma_document_error *error) {
    const norma_document_options opening = {
        .struct_size = sizeof opening, .format = file->format, .threads = options->threads};
    *m = (member){0};
    norma_document_result result = norma_document_open(file->input, &opening, &m->document, error);
    if (result) return result;
    if (m->document->format == NORMA_FILE_STL)
        return norma_document_fail(m->document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "an STL holds facet normals only, which nothing can share; expected OBJ, PLY or glTF");
    m->level = (uint32_t)number;
    m->has_level = options->levels || norma_level_of_name(file->input, 1, &m->level);
    if (m->document->format >= NORMA_FILE_GLTF &&
        !(m->node_levels = norma_levels_of_nodes(m->document)))
        return norma_document_fail_memory(m->document, error);
    return find_locked(m, file->input, options, error);
}

norma_document_result norma_member_visit(
    member *m, visit_surface *visit, void *user, norma_document_error *error) {
    norma_mesh_data data;
    norma_mesh_info info;
    if (m->document->format >= NORMA_FILE_GLTF)
        return norma_gltf_visit_surfaces(m->document, visit, user, error);
    if (norma_document_mesh_info(m->document, 0, &info) || info.not_read) return NORMA_DOCUMENT_OK;
    const norma_document_result result = norma_document_mesh_data(m->document, 0, &data, error);
    if (result) return result;
    const surface_part whole = {0, 0, 0};
    const document_surface surface = {
        .mesh = &data.mesh, .unit = 1, .parts = &whole, .part_count = 1};
    return visit(user, &surface);
}

/* ---- places */

static double determinant(const double m[16]) {
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
           m[8] * (m[1] * m[6] - m[2] * m[5]);
}

static const double IDENTITY[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static placement place_by(const double world[16], uint32_t level) {
    placement place = {.mirrored = determinant(world) < 0, .level = level};
    memcpy(place.world, world, sizeof place.world);
    place.plain = memcmp(world, IDENTITY, sizeof IDENTITY) == 0;
    return place;
}

static uint32_t level_at(
    const member *m, const document_surface *surface, const norma_node_info *node) {
    norma_mesh_info info;
    uint32_t level = 0;
    if (norma_document_mesh_info(m->document, surface->parts[0].mesh, &info) == NORMA_DOCUMENT_OK &&
        norma_level_of_name(info.name, 0, &level))
        return level;
    if (node && norma_level_of_name(node->name, 0, &level)) return level;
    if (node && m->node_levels && m->node_levels[node->node]) return m->node_levels[node->node];
    return m->has_level ? m->level : 0;
}

/* A skin places its mesh by joints, not by the node: it is compared as it was bound. */
static norma_document_result add_node(const member *m, const document_surface *surface, size_t node,
    placement **places, size_t *count, size_t *room, norma_document_error *error) {
    norma_node_info info;
    norma_document_result result = norma_document_node_info(m->document, node, &info);
    if (result || info.mesh != surface->number) return result;
    for (size_t i = 0; i < info.instances && !result; ++i) {
        double world[16];
        placement *grown = norma_io_grow(*places, room, *count + 1, sizeof *grown);
        if (!grown) return norma_document_fail_memory(m->document, error);
        *places = grown;
        result = norma_document_instance_world(m->document, node, i, world, error);
        grown[(*count)++] =
            place_by(info.skin == SIZE_MAX ? world : IDENTITY, level_at(m, surface, &info));
    }
    return result;
}

norma_document_result norma_member_places(const member *m, const document_surface *surface,
    placement **places, size_t *count, norma_document_error *error) {
    const size_t nodes = norma_document_node_count(m->document);
    norma_document_result result = NORMA_DOCUMENT_OK;
    size_t room = 0;
    *places = NULL;
    *count = 0;
    for (size_t n = 0; n < nodes && !result; ++n)
        result = add_node(m, surface, n, places, count, &room, error);
    if (result || nodes) return result;
    *places = norma_io_grow(NULL, &room, 1, sizeof **places);
    if (!*places) return norma_document_fail_memory(m->document, error);
    (*places)[(*count)++] = place_by(IDENTITY, level_at(m, surface, NULL));
    return NORMA_DOCUMENT_OK;
}
