/* seams_joined.c: N501 over the primitives of one glTF mesh together, since a seam of materials
 * runs between two of them: they are held until the last one has come, then joined to one mesh. A
 * position counts once, at the last primitive that has it. */
#include "check/rules/seams.h"
#include "core/face/triangle.h"
#include <stdlib.h>
#include <string.h>

enum { POSITIONS_IN_BLOCK = 1 << 13 };

struct check_member {
    const norma_check_mesh *given;
    size_t order, begin; /* begin: its first vertex in the whole */
    core_mesh mesh;
};

typedef struct joined {
    check_run *run;
    norma_check_mesh given;
    check_mesh m;
    size_t vertices, corner_count;
    double *positions, *normals,
        *angles; /* angles: of a hit, at the vertex that stands for it; else 0 */
    float *texcoords, *colors;
    uint32_t *corners, *materials, *members; /* members: of each vertex */
    double least;
    const seam_creases *creases; /* NULL: not known yet */
} joined;

/* Those that are held are judged by norma_check_seams_joined. */
norma_result norma_check_seams_hold(check_mesh *m) {
    check_run *run = m->run;
    if (run->member_count == run->member_room) {
        size_t room = run->member_room ? 2 * run->member_room : 8;
        check_member *members = room > SIZE_MAX / sizeof *members
                                    ? NULL
                                    : realloc(run->members, room * sizeof *members);
        if (!members) return NORMA_ERROR_MEMORY;
        run->members = members;
        run->member_room = room;
    }
    run->members[run->member_count++] =
        (check_member){.given = m->given, .order = m->place.order, .mesh = m->mesh};
    return NORMA_OK;
}

/* ---- the whole */

static int has_all(const check_run *run, int colors) {
    for (size_t i = 0; i < run->member_count; i++) {
        const norma_mesh_attributes *a = &run->members[i].given->attributes;
        if (colors ? !a->colors
                   : !a->texcoords || a->texcoord_count < run->members[i].mesh.positions.count)
            return 0;
    }
    return 1;
}

static norma_result open_joined(joined *j, int texcoords, int colors) {
    const core_call *call = &j->run->call;
    size_t v = j->vertices, c = j->corner_count;
    j->positions = norma_core_allocate(call, v, 3 * sizeof *j->positions);
    j->normals = norma_core_allocate(call, v, 3 * sizeof *j->normals);
    j->angles = norma_core_allocate(call, v, sizeof *j->angles);
    j->members = norma_core_allocate(call, v, sizeof *j->members);
    j->corners = norma_core_allocate(call, c, sizeof *j->corners);
    j->materials = norma_core_allocate(call, c / 3, sizeof *j->materials);
    j->texcoords = texcoords ? norma_core_allocate(call, v, 2 * sizeof *j->texcoords) : NULL;
    j->colors = colors ? norma_core_allocate(call, v, 4 * sizeof *j->colors) : NULL;
    int whole = j->positions && j->normals && j->angles && j->members && j->corners &&
                j->materials && (!texcoords || j->texcoords) && (!colors || j->colors);
    return whole ? NORMA_OK : NORMA_ERROR_MEMORY;
}

static void close_joined(joined *j) {
    const core_call *call = &j->run->call;
    size_t v = j->vertices, c = j->corner_count;
    norma_core_release(call, j->m.faces, j->m.mesh.face_count, sizeof *j->m.faces);
    if (j->m.has_topology) norma_core_topology_close(&j->m.topology);
    norma_core_release(call, j->colors, v, 4 * sizeof *j->colors);
    norma_core_release(call, j->texcoords, v, 2 * sizeof *j->texcoords);
    norma_core_release(call, j->materials, c / 3, sizeof *j->materials);
    norma_core_release(call, j->corners, c, sizeof *j->corners);
    norma_core_release(call, j->members, v, sizeof *j->members);
    norma_core_release(call, j->angles, v, sizeof *j->angles);
    norma_core_release(call, j->normals, v, 3 * sizeof *j->normals);
    norma_core_release(call, j->positions, v, 3 * sizeof *j->positions);
}

static void copy_member(joined *j, size_t number, size_t corner) {
    const check_member *member = &j->run->members[number];
    const norma_mesh_attributes *a = &member->given->attributes;
    size_t begin = member->begin, count = member->mesh.positions.count;
    for (size_t v = 0; v < count; v++) {
        norma_view_read(&member->mesh.positions, v, &j->positions[3 * (begin + v)]);
        norma_view_read(&member->given->data.normals, v, &j->normals[3 * (begin + v)]);
        j->members[begin + v] = (uint32_t)number;
    }
    if (j->texcoords && count)
        memcpy(&j->texcoords[2 * begin], a->texcoords, 2 * count * sizeof *j->texcoords);
    if (j->colors && count) memcpy(&j->colors[4 * begin], a->colors, 4 * count * sizeof *j->colors);
    for (size_t c = 0; c < member->mesh.corner_count; c++)
        j->corners[corner + c] = (uint32_t)begin + norma_core_corner(&member->mesh, c);
    for (size_t f = 0; f < member->mesh.face_count; f++)
        j->materials[corner / 3 + f] =
            a->material < UINT32_MAX ? (uint32_t)a->material : UINT32_MAX;
}

static norma_result fill_joined(joined *j) {
    size_t corner = 0;
    for (size_t i = 0; i < j->run->member_count; i++) {
        copy_member(j, i, corner);
        corner += j->run->members[i].mesh.corner_count;
    }
    j->given.data.mesh =
        (norma_mesh){.positions = {j->positions, j->vertices, 0, NORMA_FORMAT_DOUBLE},
            .corners = j->corners,
            .corner_count = j->corner_count};
    j->given.data.normals = (norma_vec3_view){j->normals, j->vertices, 0, NORMA_FORMAT_DOUBLE};
    j->given.info.normals = NORMA_NORMALS_PER_VERTEX;
    j->given.attributes.face_materials = j->materials;
    j->given.attributes.texcoords = j->texcoords;
    j->given.attributes.texcoord_count = j->texcoords ? j->vertices : 0;
    j->given.attributes.colors = j->colors;
    j->m = (check_mesh){.run = j->run,
        .given = &j->given}; /* no rule is wanted: edges and the like are not told of again */
    return norma_core_mesh_shape(&j->given.data.mesh, &j->m.mesh);
}

/* ---- judging */

static void judge_positions(void *context, size_t block, size_t begin, size_t end) {
    joined *j = context;
    const core_corners_of_position *around = &j->m.topology.corners_of;
    (void)block;
    for (size_t p = begin; p < end; p++) {
        double angle = norma_check_seam_angle(&j->m, p, j->least, j->creases);
        if (angle <= j->least) continue;
        size_t spot = 0, first = SIZE_MAX;
        for (size_t i = around->starts[p]; i < around->starts[p + 1]; i++) {
            size_t v = norma_core_corner(&j->m.mesh, around->corners[i]);
            first = v < first ? v : first;
            if (i == around->starts[p] || j->members[v] > j->members[spot] ||
                (j->members[v] == j->members[spot] && v < spot))
                spot = v;
        }
        j->angles[spot] = angle;
    }
}

static norma_result add_member(joined *j, size_t number) {
    const check_member *member = &j->run->members[number];
    check_mesh m = {.run = j->run, .given = member->given, .mesh = member->mesh};
    check_hits hits = {0};
    char label[CHECK_MESSAGE];
    for (size_t v = 0; v < member->mesh.positions.count; v++)
        if (j->angles[member->begin + v] > 0)
            norma_check_hit(j->run, &hits, j->angles[member->begin + v] * (180 / NORMA_PI),
                norma_check_vertex(v));
    norma_check_label(&member->given->info, label);
    m.place = (check_place){.order = member->order,
        .where = member->given->info.where ? member->given->info.where : "",
        .label = label};
    return norma_check_add_seams(&m, &hits);
}

static norma_result judge_all(joined *j) {
    memset(j->angles, 0, j->vertices * sizeof *j->angles);
    return norma_check_blocks(
        j->run, j->m.topology.corners_of.position_count, POSITIONS_IN_BLOCK, judge_positions, j);
}

static int has_any(const joined *j) {
    for (size_t v = 0; v < j->vertices; v++)
        if (j->angles[v] > 0) return 1;
    return 0;
}

static norma_result judge_joined(joined *j) {
    seam_creases creases;
    norma_result result = fill_joined(j);
    if (!result) result = norma_check_faces(&j->m);
    if (!result) result = norma_check_pairs(&j->m);
    if (!result) result = judge_all(j);
    if (!result && has_any(j)) {
        norma_check_seam_creases(&j->m, j->least, &creases);
        j->creases = &creases;
        result = judge_all(j);
    }
    for (size_t i = 0; i < j->run->member_count && !result; i++) result = add_member(j, i);
    return result;
}

norma_result norma_check_seams_joined(check_run *run) {
    joined j = {.run = run};
    for (size_t i = 0; i < run->member_count; i++) {
        check_member *member = &run->members[i];
        member->begin = j.vertices;
        if (member->mesh.positions.count >= UINT32_MAX - 1 - j.vertices ||
            member->mesh.corner_count >= UINT32_MAX - 1 - j.corner_count)
            return NORMA_ERROR_OVERFLOW;
        j.vertices += member->mesh.positions.count;
        j.corner_count += member->mesh.corner_count;
        double least = norma_check_seam_least(member->given->info.encoding);
        j.least = least > j.least ? least : j.least;
    }
    if (!run->member_count) return NORMA_OK;
    norma_result result = open_joined(&j, has_all(run, 0), has_all(run, 1));
    if (!result) result = judge_joined(&j);
    close_joined(&j);
    run->member_count = 0;
    return result;
}
