/* scene.h: what a document tells beside its meshes: materials, attributes, morphs, skins, what was
 * not read. Made on first use, kept until the document is closed. Each format that has any of it
 * gives a table of functions; an entry that is NULL stands for none. Internal to io. */
#ifndef NORMA_IO_SCENE_H
#define NORMA_IO_SCENE_H
#include "io/format/format.h"

typedef struct scene_block scene_block;

typedef struct norma_scene {
    scene_block *blocks;            /* all memory of what follows */
    norma_material_info *materials; /* NULL: not asked for yet; so for all that follows */
    size_t material_count;
    norma_mesh_attributes **attributes; /* for each mesh */
    norma_node_info *nodes; /* for each node of the file: the fields that are not about drawing */
    norma_morph_data **morphs; /* for each target, as the format numbers them */
    norma_skin_info **skins;
    norma_unread *unread;
    size_t unread_count;
    struct gltf_scene *gltf; /* what glTF's own files keep */
} norma_scene;

typedef struct scene_functions {
    norma_document_result (*materials)(norma_document *document,
        norma_document_error *error); /* fills materials and material_count */
    norma_document_result (*attributes)(norma_document *document, size_t mesh,
        norma_mesh_attributes *attributes, norma_document_error *error);
    norma_document_result (*morph)(norma_document *document, size_t mesh, size_t target,
        norma_morph_data *data, norma_document_error *error);
    size_t (*skin_count)(const norma_document *document);
    norma_document_result (*skin)(
        norma_document *document, size_t index, norma_skin_info *info, norma_document_error *error);
    norma_document_result (*unread)(
        norma_document *document, norma_document_error *error); /* fills unread and unread_count */
    norma_document_result (*instance_world)(norma_document *document, size_t node, size_t instance,
        double world[16], norma_document_error *error);
    /* drawn is filled as the file stores the mesh: moves it by its morph targets and its skin */
    norma_document_result (*move_drawn)(norma_document *document, size_t node, size_t mesh,
        norma_drawn_mesh *drawn, norma_document_error *error);
    norma_document_result (*material_maps)(norma_document *document, size_t material,
        norma_material_maps *maps, norma_document_error *error);
    norma_document_result (*normal_map)(norma_document *document, size_t material,
        norma_texture_info *map, norma_document_error *error);
    norma_document_result (*texcoords)(norma_document *document, size_t mesh, size_t set,
        const float **texcoords, size_t *count, norma_document_error *error);
} scene_functions;

extern const scene_functions norma_obj_scene, norma_ply_scene, norma_gltf_scene;

/* Zeroed memory that lives as long as the document; NULL: none is left. */
void *norma_scene_allocate(norma_scene *scene, size_t count, size_t size);
char *norma_scene_text(norma_scene *scene, const char *text);
/* Two lists of rules as one, with a comma between them where both have something. */
char *norma_scene_join(norma_scene *scene, const char *first, const char *second);

norma_scene *norma_scene_create(void);
void norma_scene_destroy(norma_scene *scene); /* NULL is fine */
void norma_scene_forget(
    norma_scene *scene); /* what was told is no longer so: the file's bytes are others now */
#endif
