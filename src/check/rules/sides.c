/* sides.c: which of the faces that somebody doubts are turned (core/orient/sides.c), with the
 * primitives of a glTF mesh looked at together. Rays say nothing of a material that is seen from
 * both sides. */
#include "check/rules/mesh_rules.h"
#include <string.h>

/* All primitives as one mesh; they are triangles. */
static norma_result join_group(check_run *run, norma_mesh *whole) {
    check_group *g = run->group;
    for (size_t i = 0; i < g->count; i++) {
        const norma_mesh *mesh = &g->meshes[i].data.mesh;
        core_mesh shape;
        const norma_result result = norma_core_mesh_shape(mesh, &shape);
        if (result) return result;
        if (shape.positions.count >= UINT32_MAX - 1 - g->vertices || shape.face_starts)
            return NORMA_ERROR_OVERFLOW;
        g->vertices += shape.positions.count;
        g->corner_count += shape.corner_count;
    }
    g->positions = norma_core_allocate(&run->call, g->vertices, 3 * sizeof *g->positions);
    g->corners = norma_core_allocate(&run->call, g->corner_count, sizeof *g->corners);
    if (!g->positions || !g->corners) return NORMA_ERROR_MEMORY;
    size_t vertex = 0, corner = 0;
    for (size_t i = 0; i < g->count; i++) {
        core_mesh shape;
        const norma_result result = norma_core_mesh_shape(&g->meshes[i].data.mesh, &shape);
        if (result) return result;
        for (size_t c = 0; c < shape.corner_count; c++)
            g->corners[corner++] = (uint32_t)vertex + norma_core_corner(&shape, c);
        for (size_t v = 0; v < shape.positions.count; v++)
            norma_view_read(&shape.positions, v, &g->positions[3 * vertex++]);
    }
    *whole = (norma_mesh){.positions = {g->positions, g->vertices, 0, NORMA_FORMAT_DOUBLE},
        .corners = g->corners,
        .corner_count = g->corner_count};
    return NORMA_OK;
}

static norma_result open_judge(check_run *run) {
    check_group *g = run->group;
    if (g->has_judge) return NORMA_OK;
    norma_mesh whole = g->meshes[0].data.mesh;
    norma_result result = g->count > 1 ? join_group(run, &whole) : NORMA_OK;
    const norma_options options = {.struct_size = sizeof options, .threads = run->options.threads};
    if (!result) result = norma_core_side_judge_open(&whole, &options, &g->judge);
    g->has_judge = !result;
    return result;
}

void norma_check_sides_drop(check_run *run) {
    check_group *g = run->group;
    if (g->has_judge) norma_core_side_judge_close(&g->judge);
    norma_core_release(&run->call, g->positions, g->vertices, 3 * sizeof *g->positions);
    norma_core_release(&run->call, g->corners, g->corner_count, sizeof *g->corners);
    *g = (check_group){.meshes = g->meshes, .count = g->count, .orders = g->orders};
}

/* Of the mesh's faces among all of the group. */
static size_t first_face(const check_mesh *m) {
    size_t first = 0;
    for (size_t i = 0; i < m->number; i++)
        first += m->run->group->meshes[i].data.mesh.corner_count / 3;
    return first;
}

int norma_check_is_turned(uint8_t side) {
    return (side & (CORE_SIDE_TURNED | CORE_SIDE_UNDECIDED)) == CORE_SIDE_TURNED;
}

size_t norma_check_count_turned(const check_mesh *m, const uint8_t *asked, const uint8_t *sides) {
    const core_components *parts = &m->run->group->judge.parts;
    const size_t first = first_face(m);
    size_t count = 0;
    for (size_t f = 0; f < m->mesh.face_count; f++)
        count += norma_check_is_turned(sides[f]) && parts->of[first + f] != UINT32_MAX &&
                 (asked[f] || parts->each[parts->of[first + f]].flags & COMPONENT_CONFLICT);
    return count;
}

norma_result norma_check_sides(check_mesh *m, const uint8_t *asked, uint8_t *sides) {
    const size_t first = first_face(m);
    norma_result result = open_judge(m->run);
    if (!result && m->on_purpose) { /* nothing asks rays, which would say nothing */
        memset(sides, 0, m->mesh.face_count);
        asked = sides;
    }
    return result ? result
                  : norma_core_side_judge_ask(
                        &m->run->group->judge, first, m->mesh.face_count, asked, sides);
}
