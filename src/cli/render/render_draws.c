/* render_draws.c: where the surfaces of a file stand, as a viewer of the format draws them at rest:
 * at each instance of each node of its scene, moved by morph targets and skins. */
#include "cli/render/render_scene.h"
#include <stdlib.h>
#include <string.h>

/* The surfaces of a mesh of the file, which come in the order of their meshes. */
static int surfaces_of(
    const scene_maker *m, size_t base_count, size_t mesh, size_t *first, size_t *count) {
    size_t low = 0, high = base_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (m->mesh_of[middle] < mesh)
            low = middle + 1;
        else
            high = middle;
    }
    for (*first = low, *count = 0; low < base_count && m->mesh_of[low] == mesh; ++low) ++*count;
    return *count > 0;
}

/* ---- a surface that moves */

static void find_middle(const norma_mesh *mesh, size_t face, double middle[3]) {
    memset(middle, 0, 3 * sizeof *middle);
    for (size_t corner = 3 * face; corner < 3 * face + 3; ++corner) {
        double p[3];
        norma_view_vector(&mesh->positions, norma_mesh_corner(mesh, corner), p);
        for (int k = 0; k < 3; ++k) middle[k] += p[k] / 3;
    }
}

static int move_dots(render_scene_file *file, render_surface *surface) {
    render_dot *dots = malloc((surface->dot_count + 1) * sizeof *dots);
    if (!dots) return 0;
    for (size_t i = 0; i < surface->dot_count; ++i) {
        dots[i] = surface->dots[i];
        if (dots[i].vertex < surface->mesh.positions.count)
            norma_view_vector(&surface->mesh.positions, dots[i].vertex, dots[i].position);
        else if (3 * dots[i].face < surface->mesh.corner_count) /* a glTF's are triangles */
            find_middle(&surface->mesh, dots[i].face, dots[i].position);
    }
    surface->dots = dots;
    return render_file_keep(file, dots);
}

/* Errors are measured where the file stores normals: between them and those of the mesh as it is
 * stored. */
static int add_moved(
    render_scene_file *file, scene_maker *m, size_t from, const norma_drawn_mesh *drawn) {
    render_surface *surface = &m->surfaces[m->surface_count++];
    *surface = m->surfaces[from];
    surface->stored_surface = &m->surfaces[from];
    surface->mesh.positions = drawn->positions;
    surface->normals = drawn->normals;
    if (surface->tangents) surface->tangents = drawn->tangents;
    surface->expected = NULL;
    return !surface->dots || move_dots(file, surface);
}

/* ---- draws */

typedef struct node_draws { /* the surfaces of one node's mesh */
    size_t node, first, count;
} node_draws;

static norma_document_result drawn_at(const render_scene_file *file, const node_draws *draws,
    size_t instance, size_t surface, norma_drawn_mesh *drawn, norma_document_error *error) {
    return norma_document_drawn_mesh(file->document, draws->node, instance,
        file->document_meshes[draws->first + surface], drawn, error);
}

/* If any of the node's surfaces moves, all of them are made anew, so that they stay one body. */
static norma_document_result move_surfaces(const render_settings *settings, render_scene_file *file,
    scene_maker *m, const node_draws *draws, size_t *first, norma_document_error *error) {
    const size_t begin = m->surface_count;
    norma_drawn_mesh drawn;
    int any = 0;
    *first = draws->first;
    for (size_t k = 0; k < draws->count && !any; ++k) {
        norma_document_result result = drawn_at(file, draws, 0, k, &drawn, error);
        if (result) return result;
        any = drawn.moved;
    }
    for (size_t k = 0; k < draws->count && any; ++k) {
        norma_document_result result = drawn_at(file, draws, 0, k, &drawn, error);
        if (result) return result;
        if (!add_moved(file, m, draws->first + k, &drawn))
            return render_file_fail(
                error, NORMA_DOCUMENT_ERROR_MEMORY, file->input, "out of memory");
    }
    if (any) *first = begin;
    return !any || !render_join_needed(settings, &m->surfaces[begin], draws->count) ||
                   render_join_primitives(file, &m->surfaces[begin], draws->count, error)
               ? NORMA_DOCUMENT_OK
               : error->result;
}

static norma_document_result draw_node(const render_settings *settings, render_scene_file *file,
    scene_maker *m, const node_draws *draws, size_t instances, norma_document_error *error) {
    size_t first;
    norma_document_result result = move_surfaces(settings, file, m, draws, &first, error);
    for (size_t instance = 0; instance < instances && !result; ++instance)
        for (size_t k = 0; k < draws->count && !result; ++k) {
            norma_drawn_mesh drawn;
            result = drawn_at(file, draws, instance, k, &drawn, error);
            file->not_shown += !result && !drawn.shown;
            if (result || !drawn.shown || (drawn.skinned && instance > 0)) continue;
            m->draws[m->draw_count].surface = first + k;
            memcpy(m->draws[m->draw_count++].world, drawn.world, sizeof drawn.world);
        }
    return result;
}

/* Room for all draws, and for the surfaces that may move. */
static norma_document_result make_room(
    render_scene_file *file, scene_maker *m, norma_document_error *error) {
    norma_document *document = file->document;
    size_t draws = 0, moved = 0;
    for (size_t i = 0; i < norma_document_node_count(document); ++i) {
        norma_node_info node;
        norma_mesh_info info;
        size_t first, count;
        norma_document_result result = norma_document_node_info(document, i, &node);
        if (result) return result;
        if (!surfaces_of(m, m->surface_count, node.mesh, &first, &count)) continue;
        draws += count * node.instances;
        int moves = node.skin != SIZE_MAX;
        for (size_t k = 0; k < count && !moves && !result; ++k) {
            result = norma_document_mesh_info(document, file->document_meshes[first + k], &info);
            moves = info.morph_targets > 0;
        }
        if (result) return result;
        moved += moves ? count : 0;
    }
    render_surface *larger =
        realloc(m->surfaces, (m->surface_count + moved + 1) * sizeof *m->surfaces);
    if (larger) m->surfaces = larger;
    m->draws = calloc(draws + 1, sizeof *m->draws);
    return larger && m->draws
               ? NORMA_DOCUMENT_OK
               : render_file_fail(error, NORMA_DOCUMENT_ERROR_MEMORY, file->input, "out of memory");
}

norma_document_result render_file_draws(const render_settings *settings, render_scene_file *file,
    scene_maker *m, norma_document_error *error) {
    const size_t base_count = m->surface_count;
    file->not_shown = 0;
    norma_document_result result = make_room(file, m, error);
    for (size_t i = 0; i < norma_document_node_count(file->document) && !result; ++i) {
        norma_node_info node;
        node_draws draws = {.node = i};
        result = norma_document_node_info(file->document, i, &node);
        if (!result && surfaces_of(m, base_count, node.mesh, &draws.first, &draws.count))
            result = draw_node(settings, file, m, &draws, node.instances, error);
    }
    return result;
}
