/* render_scene.h: a scene while it is made: the surfaces of the file's meshes, then those that
 * morph targets or skins move, and where each is drawn. */
#ifndef NORMA_CLI_RENDER_SCENE_H
#define NORMA_CLI_RENDER_SCENE_H
#include "cli/render/render_command.h"

typedef struct scene_maker {
    render_surface *surfaces;
    render_draw *draws;
    size_t surface_count, draw_count;
    size_t *mesh_of; /* the file's number of the mesh of each surface that does not move */
} scene_maker;

/* Fills draws, and adds the surfaces that move. No draw: no node of the file draws a surface. */
norma_document_result render_file_draws(const render_settings *settings, render_scene_file *file,
    scene_maker *m, norma_document_error *error);

/* Its colours, images and sides; mesh: its number in the document. */
norma_document_result render_file_set_material(const render_settings *settings,
    render_scene_file *file, size_t mesh, const norma_mesh_attributes *attributes,
    render_surface *surface, norma_document_error *error);

/* The primitives of a mesh are one body: whether normals are computed for it, and those. */
int render_join_needed(
    const render_settings *settings, const render_surface *surfaces, size_t count);
int render_join_primitives(
    render_scene_file *file, render_surface *first, size_t count, norma_document_error *error);
#endif
