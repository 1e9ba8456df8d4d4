/* solids.h: what the rules on components share: one mesh by itself, or the primitives of a glTF
 * mesh together. */
#ifndef NORMA_CHECK_SOLIDS_H
#define NORMA_CHECK_SOLIDS_H
#include "core/topology/topology.h"
#include "check/rules/mesh_rules.h"

typedef struct check_solids {
    check_mesh *m; /* who is told: rules, place, positions */
    const core_components *components;
    size_t begin, end; /* of the components' faces those that are the mesh's; one that begins there
                          is told of there */
} check_solids;

/* What a component is, from outside in (N302), and whether it is of one side (N304). */
norma_result norma_check_judge_solids(
    const core_topology *topology, core_components *components, int nesting, int sides);
norma_result norma_check_tell_solids(const check_solids *solids);

/* open_edges.c: N307. first: of the mesh's corners in the topology. */
norma_result norma_check_add_open(check_mesh *m, const core_topology *topology, size_t first);
int norma_check_wants_open(const check_run *run, const uint8_t *rules);

/* solids_joined.c: of a mesh that has siblings, until the last one has come. */
norma_result norma_check_solids_hold(check_mesh *m, const core_components *components);
#endif
