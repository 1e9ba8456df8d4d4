/* scene_rules.h: the families of rules about what a surface has and where it stands: files,
 * materials, tangents, morph targets, nodes, skins. */
#ifndef NORMA_CHECK_SCENE_RULES_H
#define NORMA_CHECK_SCENE_RULES_H
#include "check/findings/check_run.h"

/* Tangents serve normal maps only: without one, what is wrong with them is worth knowing, no more.
 */
static inline norma_severity norma_check_tangent_severity(const check_mesh *m) {
    return m->given->material.normal_map ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO;
}

norma_result norma_check_missing_normals(check_mesh *m); /* missing_normals.c: N104 to N106 */
norma_result norma_check_tangents(check_mesh *m);        /* tangents.c: N801 to N806 */
norma_result norma_check_tangent_signs(
    check_mesh *m); /* tangent_signs.c: N804, where there are tangents */
norma_result norma_check_tangent_deviation(check_mesh *m); /* tangent_deviation.c: N807 */
norma_result norma_check_morphs(check_mesh *m);            /* morphs.c: N901 to N903 */

/* nodes.c: N601 to N605, with the materials of the meshes that nodes draw (info.mesh and material
 * of scene->meshes). world_of gives the world matrix of one instance of a node by its index in
 * scene->nodes; NULL: there is nothing but the node's own. */
typedef norma_result check_instance_world(
    void *context, size_t index, size_t instance, double world[16]);
norma_result norma_check_nodes(
    check_run *run, const norma_check_scene *scene, check_instance_world *world_of, void *context);
#endif
