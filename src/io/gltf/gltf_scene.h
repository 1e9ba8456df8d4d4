/* gltf_scene.h: what the files share that tell what else a glTF's surfaces have. */
#ifndef NORMA_IO_GLTF_SCENE_H
#define NORMA_IO_GLTF_SCENE_H
#include "io/gltf/asset.h"
#include "io/format/scene.h"

/* What several elements share is found out once, so that a small file that names one thing a
 * thousand times costs no more than its size. */
typedef struct gltf_scene {
    const float **decoded;    /* of each accessor; NULL: not yet */
    const float **colors;     /* of each accessor of three numbers, with an alpha of 1 */
    const char *root_ignore;  /* NULL: not yet */
    const char **mesh_ignore; /* of each mesh, that of the root in front */
    const char **node_ignore; /* of each node, those of the nodes above and of the root included */
    struct gltf_animation *animations; /* NULL: not yet */
    uint32_t animation_count;
    const norma_document_error *animation_error; /* NULL: none */
    uint32_t *skins;                             /* the token of each; NULL: not yet */
    size_t effort;                               /* steps that skins and animations took */
    const double **joints;     /* of each skin, a matrix for each joint at rest; NULL: not yet */
    struct gltf_moved **moved; /* of each node that draws, its meshes that morphs or skins move */
    struct gltf_image *images; /* NULL: not yet */
    const uint8_t *shown;      /* of each node: 1 in the scene, 2 not; NULL: not yet */
} gltf_scene;
/* Made on first use; NULL: out of memory. */
gltf_scene *norma_gltf_scene_of(gltf *g);

/* Rules that the extras of an object silence, "N201,N3"; "" for none, NULL: out of memory. Of a
 * list beyond all measure the rest is not taken. */
const char *norma_gltf_ignore(gltf *g, uint32_t token);
const char *norma_gltf_root_ignore(gltf *g);
/* above, and behind it what an object's own extras say. */
const char *norma_gltf_ignored_with(gltf *g, const char *above, uint32_t token);
/* The "name" of an object, "" for none; NULL: out of memory. */
const char *norma_gltf_name(gltf *g, uint32_t token);
/* "/LIST/NUMBER"; NULL: out of memory. */
const char *norma_gltf_where(gltf *g, const char *list, size_t number);
/* An accessor as floats, width of them for each element, tight: the file's own bytes where they are
 * just that, else a decoded copy that the document keeps. */
norma_document_result norma_gltf_decode(
    gltf *g, uint32_t accessor, uint32_t width, const float **floats, norma_document_error *error);

/* materials.c */
uint32_t norma_gltf_normal_use(const gltf *g, uint32_t material); /* the texture's info */
/* Where a texture, by its info, is looked up: everything of it that needs no image. */
norma_texture_info norma_gltf_texture_place(const gltf *g, uint32_t texture);
norma_texture_info norma_gltf_normal_map(const gltf *g, uint32_t material); /* or clear coat's */
int norma_gltf_moves(const norma_texture_info *place); /* its transform is not the identity */
norma_document_result norma_gltf_materials(norma_document *document, norma_document_error *error);

/* skins.c */
size_t norma_gltf_skin_count(const norma_document *document);
norma_document_result norma_gltf_skin(
    norma_document *document, size_t index, norma_skin_info *info, norma_document_error *error);

/* Where in the JSON a skin lies. */
norma_document_result norma_gltf_skin_token(
    gltf *g, uint32_t skin, uint32_t *token, norma_document_error *error);

/* drawn_mesh.c: drawn is filled as the file stores the mesh. */
norma_document_result norma_gltf_move_drawn(norma_document *document, size_t node, size_t mesh,
    norma_drawn_mesh *drawn, norma_document_error *error);

/* material_maps.c; set: gltf_scene.c */
norma_document_result norma_gltf_material_maps(norma_document *document, size_t material,
    norma_material_maps *maps, norma_document_error *error);
norma_document_result norma_gltf_normal_texture(norma_document *document, size_t material,
    norma_texture_info *map, norma_document_error *error);

/* instances.c: where a node draws its mesh, again and again (EXT_mesh_gpu_instancing) */
typedef struct gltf_instances {
    gltf_array translation, rotation, scale;
    int has_translation, has_rotation, has_scale;
    uint32_t attributes; /* the JSON object that names them; JSON_NONE */
} gltf_instances;
norma_document_result norma_gltf_read_instances(
    gltf *g, uint32_t node, gltf_instances *instances, norma_document_error *error);
void norma_gltf_instance_matrix(
    const gltf_instances *instances, size_t index, double matrix[16]); /* within the node */

/* requirements.c: whether a file may require the extension without a word in it changing what its
 * meshes' numbers mean. */
int norma_gltf_is_known(const char *name);
/* Its elements have no bytes at all: zeros by the specification, that an extension or the program
 * that loads the file is to fill. What norma check judges they are not. */
int norma_gltf_is_placeholder(const gltf *g, uint32_t accessor);
/* requirements.c: it asks for a version later than the one that is read here. */
int norma_gltf_needs_later(const gltf *g);

/* The fields of a drawing node's info that are not about what it draws. */
norma_document_result norma_gltf_describe_node(
    const norma_document *document, size_t index, norma_node_info *info);
#endif
