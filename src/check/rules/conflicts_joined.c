/* conflicts_joined.c: N301 over the primitives of one glTF mesh together: a part that is wound
 * against a part of another material is seen as one within a material is. */
#include "check/rules/conflicts.h"

static size_t other_face(const core_topology *t, size_t corner) {
    return norma_core_topology_face(t, t->others[corner]);
}

int norma_check_count_conflicts(const core_topology *t, uint8_t *edges) {
    int any = 0;
    for (size_t c = 0; c < t->mesh.corner_count; c++) {
        const size_t face = norma_core_topology_face(t, c);
        if (t->partners[c] != CORE_EDGE_CONFLICT) continue;
        edges[face] = (uint8_t)(edges[face] + (edges[face] < 255));
        any = 1;
    }
    return any;
}

/* Whether the edge is told of at this corner and not at the other. */
static int is_told_here(
    const core_topology *t, size_t corner, const uint8_t *edges, const uint8_t *sides) {
    const size_t here = norma_core_topology_face(t, corner), there = other_face(t, corner);
    const int turned = norma_check_is_turned(sides[here]) - norma_check_is_turned(sides[there]);
    if (turned) return turned > 0;
    return edges[here] != edges[there] ? edges[here] > edges[there] : corner < t->others[corner];
}

norma_result norma_check_conflicts_joined(check_mesh *m, const core_topology *t,
    size_t first_corner, const uint8_t *edges, const uint8_t *sides) {
    check_hits kinds[CONFLICT_KINDS] = {{0}};
    const size_t first = first_corner / 3;
    for (size_t c = first_corner; c < first_corner + m->mesh.corner_count; c++) {
        if (t->partners[c] != CORE_EDGE_CONFLICT || !is_told_here(t, c, edges, sides)) continue;
        const conflict_kind kind = norma_check_conflict_kind(t, c, t->others[c], sides);
        norma_check_hit(m->run, &kinds[kind], 0,
            (check_spot){norma_core_corner(&m->mesh, c - first_corner), c / 3 - first, SIZE_MAX});
    }
    return norma_check_add_conflicts(m, edges + first, sides + first, kinds);
}
