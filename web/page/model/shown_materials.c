/* shown_materials.c: names, colours, texture coordinates and tangents of a model's meshes,
 * and which edges of its triangles are edges of the file's polygons. */
#include "model.h"
#include "../../package/wasm/exports.h"
#include "render/render.h"
#include <stdlib.h>
#include <string.h>

const char *WEB_EXPORT(model_name)(const model *m, uint32_t mesh) {
    return (const char *)m->pack + m->meshes[mesh].record->name;
}

/* The number of its material in the file; VIEW_PACK_NONE: it has none. */
uint32_t WEB_EXPORT(model_material)(const model *m, uint32_t mesh) {
    return m->meshes[mesh].record->material;
}

/* Bits: texture coordinates 0 and 1, tangents, colours, both sides. */
uint32_t WEB_EXPORT(model_attributes)(const model *m, uint32_t mesh) {
    const view_pack_mesh *r = m->meshes[mesh].record;
    const int has[5] = {r->texcoords[0] != VIEW_PACK_NONE, r->texcoords[1] != VIEW_PACK_NONE,
        r->tangents != VIEW_PACK_NONE, r->colours != VIEW_PACK_NONE, r->double_sided != 0};
    uint32_t bits = 0;
    for (int i = 0; i < 5; ++i) bits |= (uint32_t)has[i] << i;
    return bits;
}

static size_t triangle_corner(const model_mesh *mesh, size_t i) {
    return mesh->triangle_corners ? mesh->triangle_corners[i] : i;
}

/* Numbers of each position at each corner of each triangle; zeros where the pack has none. NULL:
 * out of memory. */
static float *take(
    const model *m, const model_mesh *mesh, uint32_t at, size_t numbers, float *out) {
    if (!out) out = calloc(3 * numbers * mesh->triangle_count + 1, sizeof *out);
    if (at == VIEW_PACK_NONE) return out;
    const float *from = (const float *)(const void *)(m->pack + at);
    for (size_t i = 0; out && i < 3 * mesh->triangle_count; ++i)
        memcpy(out + numbers * i,
            from + numbers * model_corner_position(mesh, triangle_corner(mesh, i)),
            numbers * sizeof *out);
    return out;
}

/* set: 0 or 1. Two numbers for each corner of each triangle. */
const float *WEB_EXPORT(model_texcoords)(model *m, uint32_t index, uint32_t set) {
    model_mesh *mesh = &m->meshes[index];
    return mesh->draw_texcoords[set] =
               take(m, mesh, mesh->record->texcoords[set], 2, mesh->draw_texcoords[set]);
}

/* Four numbers of 16 bits; NULL: out of memory. Zeros: the mesh has none. */
const uint16_t *WEB_EXPORT(model_colours)(model *m, uint32_t index) {
    model_mesh *mesh = &m->meshes[index];
    if (!mesh->draw_colours) mesh->draw_colours = calloc(12 * mesh->triangle_count + 1, 2);
    if (mesh->record->colours == VIEW_PACK_NONE) return mesh->draw_colours;
    const unsigned char *from = m->pack + mesh->record->colours;
    for (size_t i = 0; mesh->draw_colours && i < 3 * mesh->triangle_count; ++i)
        memcpy(mesh->draw_colours + 4 * i,
            from + 8 * model_corner_position(mesh, triangle_corner(mesh, i)), 8);
    return mesh->draw_colours;
}

/* MikkTSpace's, along the coordinates of the normal map and the normals that were computed last. */
static void compute_tangents(const model *m, model_mesh *mesh) {
    const size_t corners = mesh->mesh.corner_count, count = mesh->record->position_count;
    const float *uv = (const float *)(const void *)(m->pack + mesh->record->map_texcoords);
    float *made = malloc((4 * corners + 1) * sizeof *made);
    const norma_attribute normal = {.data = mesh->normals,
                              .count = corners,
                              .of = NORMA_PER_CORNER},
                          texcoord = {.data = uv, .count = count, .of = NORMA_PER_VERTEX};
    const norma_options options = {.struct_size = sizeof options};
    if (made && !norma_corner_tangents(&mesh->mesh, &normal, &texcoord, NORMA_TANGENTS_MIKK,
                    &options, made, corners, NULL))
        for (size_t i = 0; i < 3 * mesh->triangle_count; ++i) {
            float *out = mesh->draw_tangents + 4 * i;
            memcpy(out, made + 4 * triangle_corner(mesh, i), 4 * sizeof *out);
            out[3] *= -1; /* v runs downwards */
        }
    free(made);
}

/* The file's, otherwise computed ones; zeros where there are no texture coordinates. */
const float *WEB_EXPORT(model_tangents)(model *m, uint32_t index) {
    model_mesh *mesh = &m->meshes[index];
    mesh->draw_tangents = take(m, mesh, mesh->record->tangents, 4, mesh->draw_tangents);
    if (mesh->draw_tangents && mesh->record->tangents == VIEW_PACK_NONE &&
        mesh->record->map_texcoords != VIEW_PACK_NONE)
        compute_tangents(m, mesh);
    return mesh->draw_tangents;
}

/* Whether the edge from corner i of the triangles to the next one of its triangle runs along a
 * polygon of the file. */
static int is_edge(const model_mesh *mesh, size_t i, size_t *face) {
    const uint32_t *starts = mesh->mesh.face_starts;
    if (!starts) return 1;
    const size_t a = triangle_corner(mesh, i),
                 b = triangle_corner(mesh, i % 3 == 2 ? i - 2 : i + 1);
    while (a >= starts[*face + 1]) ++*face;
    const size_t first = starts[*face], last = starts[*face + 1] - 1;
    return b == (a == last ? first : a + 1) || a == (b == last ? first : b + 1);
}

/* edges: room for three bytes for each triangle: 1 where the edge is drawn. */
void WEB_EXPORT(model_edges)(const model *m, uint32_t index, uint8_t *edges) {
    const model_mesh *mesh = &m->meshes[index];
    size_t face = 0;
    for (size_t i = 0; i < 3 * mesh->triangle_count; ++i)
        edges[i] = (uint8_t)is_edge(mesh, i, &face);
}

/* Where the format does not say which axis points up: 0 y, 1 z. */
int WEB_EXPORT(model_guess_up)(const model *m) {
    const uint32_t count = m->head->mesh_count;
    render_surface *surfaces = calloc((size_t)count + 1, sizeof *surfaces);
    for (uint32_t i = 0; surfaces && i < count; ++i) surfaces[i].mesh = m->meshes[i].mesh;
    const enum render_up usual = m->head->format == NORMA_FILE_OBJ ? RENDER_UP_Y : RENDER_UP_Z;
    const int up = surfaces ? (int)render_guess_up(surfaces, count, usual) : (int)usual;
    free(surfaces);
    return up;
}
