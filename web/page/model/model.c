/* model.c: a pack becomes arrays for the graphics card. The pack may come from a page that somebody
 * edited, so that every offset and index is checked. */
#include "model.h"
#include "core/face/cut_polygon.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- reading a pack */

/* Whether count elements of size bytes lie in the pack at an offset that suits them. */
static int lies_inside(const view_pack_head *head, uint32_t at, uint64_t count, size_t size) {
    return at % 8 == 0 && at <= head->size && count <= (head->size - at) / size;
}

static int has_head(const unsigned char *pack, size_t size) {
    const view_pack_head *head = (const view_pack_head *)(const void *)pack;
    return size >= sizeof *head && head->magic == VIEW_PACK_MAGIC && head->size <= size &&
           lies_inside(head, head->meshes, head->mesh_count, sizeof(view_pack_mesh)) &&
           lies_inside(head, head->draws, head->draw_count, sizeof(view_pack_draw)) &&
           model_findings_are_sound(head, pack);
}

static int is_there(const view_pack_head *head, uint32_t at, uint64_t count) {
    return at == VIEW_PACK_NONE || lies_inside(head, at, count, 4);
}

static int material_is_sound(
    const view_pack_head *head, const unsigned char *pack, const view_pack_mesh *r) {
    const uint32_t pairs[3] = {r->texcoords[0], r->texcoords[1], r->map_texcoords};
    for (int i = 0; i < 3; ++i)
        if (pairs[i] != VIEW_PACK_NONE && !lies_inside(head, pairs[i], r->position_count, 8))
            return 0;
    return r->name < head->size && memchr(pack + r->name, 0, head->size - r->name) &&
           (r->tangents == VIEW_PACK_NONE ||
               lies_inside(head, r->tangents, r->position_count, 16)) &&
           (r->colours == VIEW_PACK_NONE || lies_inside(head, r->colours, r->position_count, 8));
}

static int record_is_sound(const view_pack_head *head, const view_pack_mesh *r) {
    const size_t vector = r->is_double ? 24 : 12;
    const int polygons = r->face_starts != VIEW_PACK_NONE;
    return lies_inside(head, r->positions, r->position_count, vector) &&
           is_there(head, r->corners, r->corner_count) &&
           is_there(head, r->face_starts, (uint64_t)r->face_count + 1) &&
           is_there(head, r->groups, r->face_count) &&
           (r->storage == NORMA_NORMALS_NONE ||
               lies_inside(head, r->normals, r->normal_count, 12)) &&
           is_there(head, r->corner_normals, r->corner_count) &&
           (polygons || (r->corner_count % 3 == 0 && r->face_count == r->corner_count / 3)) &&
           (r->corners != VIEW_PACK_NONE || r->corner_count <= r->position_count);
}

static const void *at_offset(const model *m, uint32_t at) {
    return at == VIEW_PACK_NONE ? NULL : m->pack + at;
}

static void read_record(const model *m, const view_pack_mesh *record, model_mesh *mesh) {
    mesh->record = record;
    mesh->mesh = (norma_mesh){.positions = {at_offset(m, record->positions), record->position_count,
                                  0, record->is_double ? NORMA_FORMAT_DOUBLE : NORMA_FORMAT_FLOAT},
        .corners = at_offset(m, record->corners),
        .corner_count = record->corner_count,
        .face_starts = at_offset(m, record->face_starts),
        .face_count = record->face_count};
    if (record->storage != NORMA_NORMALS_NONE)
        mesh->stored = (norma_vec3_view){
            at_offset(m, record->normals), record->normal_count, 0, NORMA_FORMAT_FLOAT};
    mesh->stored_of_corner = at_offset(m, record->corner_normals);
}

void model_position(const model_mesh *mesh, size_t position, double out[3]) {
    for (size_t axis = 0; axis < 3; ++axis)
        out[axis] = mesh->record->is_double
                        ? ((const double *)mesh->mesh.positions.data)[3 * position + axis]
                        : (double)((const float *)mesh->mesh.positions.data)[3 * position + axis];
}

size_t model_corner_position(const model_mesh *mesh, size_t corner) {
    return mesh->mesh.corners ? ((const uint32_t *)mesh->mesh.corners)[corner] : corner;
}

/* The core checks corners and faces; what it finds wrong is not drawn. */
static int mesh_is_sound(const model_mesh *mesh) {
    float *normals = malloc((size_t)mesh->record->corner_count * 12 + 1);
    const norma_result result =
        normals ? norma_face_normals(&mesh->mesh, NULL, normals, mesh->record->corner_count, NULL)
                : NORMA_ERROR_MEMORY;
    free(normals);
    return !result;
}

/* ---- triangles */

static size_t face_start(const model_mesh *mesh, size_t face) {
    return mesh->mesh.face_starts ? mesh->mesh.face_starts[face] : 3 * face;
}

static size_t count_triangles(const model_mesh *mesh, size_t *most_corners) {
    size_t triangles = 0;
    for (size_t face = 0; face < mesh->mesh.face_count; ++face) {
        const size_t corners = face_start(mesh, face + 1) - face_start(mesh, face);
        triangles += corners > 2 ? corners - 2 : 0;
        *most_corners = corners > *most_corners ? corners : *most_corners;
    }
    return triangles;
}

static void cut_faces(model_mesh *mesh, core_cutter *cutter) {
    uint32_t *out = mesh->triangle_corners;
    for (size_t face = 0; face < mesh->mesh.face_count; ++face) {
        const size_t start = face_start(mesh, face), corners = face_start(mesh, face + 1) - start;
        if (corners < 3) continue;
        for (size_t i = 0; i < corners; ++i)
            model_position(mesh, model_corner_position(mesh, start + i), cutter->points[i]);
        (void)norma_core_cut_polygon(cutter, corners, out);
        for (size_t i = 0; i < 3 * (corners - 2); ++i) out[i] += (uint32_t)start;
        out += 3 * (corners - 2);
    }
}

static int make_triangles(model_mesh *mesh) {
    size_t most = 0;
    core_cutter cutter;
    if (!mesh->mesh.face_starts) {
        mesh->triangle_count = mesh->mesh.corner_count / 3;
        return 1;
    }
    mesh->triangle_count = count_triangles(mesh, &most);
    mesh->triangle_corners = malloc(12 * mesh->triangle_count + 1);
    void *memory = malloc(norma_core_cutter_size(most));
    const int made = mesh->triangle_corners && memory;
    if (made) {
        norma_core_cutter_begin(&cutter, memory, most, mesh->mesh.corner_count);
        cut_faces(mesh, &cutter);
    }
    free(memory);
    return made;
}

/* ---- arrays for the graphics card */

static int is_finite3(const double p[3]) {
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

/* Round the middle of the box of all positions that are finite. */
static void find_ball(model_mesh *mesh) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY},
           p[3];
    mesh->radius = 0;
    for (size_t i = 0; i < mesh->mesh.positions.count; ++i) {
        model_position(mesh, i, p);
        for (int axis = 0; axis < 3 && is_finite3(p); ++axis) {
            low[axis] = fmin(low[axis], p[axis]);
            high[axis] = fmax(high[axis], p[axis]);
        }
    }
    for (int axis = 0; axis < 3; ++axis)
        mesh->centre[axis] =
            low[axis] <= high[axis] ? low[axis] + (0.5 * high[axis] - 0.5 * low[axis]) : 0;
    for (size_t i = 0; i < mesh->mesh.positions.count; ++i) {
        model_position(mesh, i, p);
        if (is_finite3(p))
            mesh->radius =
                fmax(mesh->radius, hypot(hypot(p[0] - mesh->centre[0], p[1] - mesh->centre[1]),
                                       p[2] - mesh->centre[2]));
    }
    if (!(mesh->radius > 0 && isfinite(mesh->radius))) mesh->radius = 1;
}

static size_t triangle_corner(const model_mesh *mesh, size_t i) {
    return mesh->triangle_corners ? mesh->triangle_corners[i] : i;
}

static void fill_positions(model_mesh *mesh) {
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
        double p[3];
        model_position(mesh, model_corner_position(mesh, triangle_corner(mesh, i)), p);
        for (size_t axis = 0; axis < 3; ++axis) {
            const double x = (p[axis] - mesh->centre[axis]) / mesh->radius;
            mesh->draw_positions[3 * i + axis] = isfinite(x) ? (float)x : 0;
        }
    }
}

static int make_arrays(model_mesh *mesh) {
    const size_t corners = 3 * mesh->triangle_count;
    mesh->normals = calloc(3 * mesh->mesh.corner_count + 1, sizeof(float));
    mesh->draw_positions = malloc(12 * corners + 1);
    mesh->draw_normals = mesh->triangle_corners ? malloc(12 * corners + 1) : mesh->normals;
    mesh->draw_values = calloc(corners + 1, sizeof(float));
    if (!mesh->normals || !mesh->draw_positions || !mesh->draw_normals || !mesh->draw_values)
        return 0;
    find_ball(mesh);
    fill_positions(mesh);
    return 1;
}

static int open_mesh(const model *m, const view_pack_mesh *record, model_mesh *mesh) {
    if (!record_is_sound(m->head, record) || !material_is_sound(m->head, m->pack, record)) return 0;
    read_record(m, record, mesh);
    return mesh_is_sound(mesh) && make_triangles(mesh) && make_arrays(mesh);
}

model *model_open(unsigned char *pack, size_t size) {
    model *m = calloc(1, sizeof *m);
    if (!m || !has_head(pack, size)) {
        free(pack);
        free(m);
        return NULL;
    }
    m->pack = pack;
    m->head = (const view_pack_head *)(const void *)pack;
    m->draws = (const view_pack_draw *)(const void *)(pack + m->head->draws);
    m->meshes = calloc((size_t)m->head->mesh_count + 1, sizeof *m->meshes);
    const view_pack_mesh *records = (const view_pack_mesh *)(const void *)(pack + m->head->meshes);
    int sound = m->meshes != NULL;
    for (uint32_t i = 0; i < m->head->mesh_count && sound; ++i)
        sound = open_mesh(m, &records[i], &m->meshes[i]);
    for (uint32_t i = 0; i < m->head->draw_count && sound; ++i)
        sound = m->draws[i].mesh < m->head->mesh_count;
    if (sound) return m;
    model_close(m);
    return NULL;
}

void model_close(model *m) {
    if (!m) return;
    for (uint32_t i = 0; m->meshes && i < m->head->mesh_count; ++i) {
        model_mesh *mesh = &m->meshes[i];
        free(mesh->draw_positions);
        if (mesh->draw_normals != mesh->normals) free(mesh->draw_normals);
        free(mesh->normals);
        free(mesh->draw_values);
        free(mesh->draw_marks);
        free(mesh->draw_texcoords[0]);
        free(mesh->draw_texcoords[1]);
        free(mesh->draw_tangents);
        free(mesh->draw_colours);
        free(mesh->triangle_corners);
        creases_close(mesh->creases);
    }
    free(m->meshes);
    free(m->pack);
    free(m);
}
