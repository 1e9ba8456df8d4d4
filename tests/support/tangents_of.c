/* tangents_of.c: the tangents of meshes, for scripts that compare them with those of other
 * programs.
 *
 *   tangents_of mikk|steady|meshopt THREADS              of meshes that come in on standard input
 *   tangents_of mikk|steady|meshopt THREADS FILE...      of those of files with normals and texture
 *                                                      coordinates, polygons fanned out
 *
 * A mesh: a 32-bit count of corners, three of each triangle; then floats: positions, normals,
 * texture coordinates of the corners. Answered by four floats and a byte, the reason, a corner;
 * for files the mesh itself goes before the answer. */
#include "core/tangent/tangents.h"
#include <norma/document.h>
#include <norma/norma.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct soup {
    size_t corners;
    float *positions, *normals, *texcoords;
} soup;

typedef struct way {
    tangent_maker *maker;
    uint32_t threads;
} way;

static void *room(size_t count, size_t size) {
    void *block = calloc(count + 1, size);
    if (!block) exit(2);
    return block;
}

static soup soup_create(size_t corners) {
    return (soup){corners, room(3 * corners, 4), room(3 * corners, 4), room(2 * corners, 4)};
}

static void soup_free(soup *s) {
    free(s->positions);
    free(s->normals);
    free(s->texcoords);
}

static void compute(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, way how, float *tangents, uint8_t *reasons) {
    const norma_options options = {.reasons = reasons, .threads = how.threads};
    const norma_result result = norma_core_corner_tangents(
        mesh, normals, texcoords, how.maker, &options, tangents, mesh->corner_count, NULL);
    if (!result) return;
    fprintf(stderr, "%s\n", norma_result_text(result));
    exit(1);
}

static void answer(const soup *s, way how, float *tangents, uint8_t *reasons) {
    const norma_mesh mesh = {
        .positions = {.data = s->positions, .count = s->corners}, .corner_count = s->corners};
    const norma_attribute normals = {.data = s->normals, .count = s->corners},
                          texcoords = {.data = s->texcoords, .count = s->corners};
    compute(&mesh, &normals, &texcoords, how, tangents, reasons);
    fwrite(tangents, 16, s->corners, stdout);
    fwrite(reasons, 1, s->corners, stdout);
    fflush(stdout);
}

static void answer_input(uint32_t corners, way how) {
    soup s = soup_create(corners);
    float *tangents = room(corners, 16);
    uint8_t *reasons = room(corners, 1);
    if (fread(s.positions, 12, corners, stdin) != corners ||
        fread(s.normals, 12, corners, stdin) != corners ||
        fread(s.texcoords, 8, corners, stdin) != corners)
        exit(2);
    answer(&s, how, tangents, reasons);
    soup_free(&s);
    free(tangents);
    free(reasons);
}

/* ---- files */

typedef struct file_mesh {
    norma_mesh_data data;
    norma_mesh_attributes more;
} file_mesh;

static uint32_t position_of(const norma_mesh *mesh, size_t corner) {
    uint16_t two;
    uint32_t four;
    if (!mesh->corners) return (uint32_t)corner;
    if (mesh->corner_size == 1) return ((const uint8_t *)mesh->corners)[corner];
    if (mesh->corner_size == 2) {
        memcpy(&two, (const uint8_t *)mesh->corners + 2 * corner, 2);
        return two;
    }
    memcpy(&four, (const uint8_t *)mesh->corners + 4 * corner, 4);
    return four;
}

/* 0: this corner has no normal or no texture coordinates. */
static int add_corner(const file_mesh *m, size_t corner, soup *s) {
    const uint32_t p = position_of(&m->data.mesh, corner),
                   n = m->data.corner_normals ? m->data.corner_normals[corner] : p,
                   t = m->more.corner_texcoords ? m->more.corner_texcoords[corner] : p;
    const norma_vec3_view *views[] = {&m->data.mesh.positions, &m->data.normals};
    const uint32_t numbers[] = {p, n};
    float *to[] = {s->positions + 3 * s->corners, s->normals + 3 * s->corners};
    if (n >= m->data.normals.count || t >= m->more.texcoord_count) return 0;
    for (size_t i = 0; i < 2; ++i) {
        if (views[i]->format != NORMA_FORMAT_FLOAT) return 0;
        const size_t stride = views[i]->stride ? views[i]->stride : 12;
        memcpy(to[i], (const uint8_t *)views[i]->data + numbers[i] * stride, 12);
    }
    memcpy(s->texcoords + 2 * s->corners, m->more.texcoords + 2 * t, 8);
    ++s->corners;
    return 1;
}

static void add_face(const file_mesh *m, size_t first, size_t count, soup *s) {
    for (size_t i = 1; i + 1 < count; ++i) {
        const size_t before = s->corners;
        if (!add_corner(m, first, s) || !add_corner(m, first + i, s) ||
            !add_corner(m, first + i + 1, s))
            s->corners = before;
    }
}

/* The mesh as it is indexed must give what its corners by themselves give. Not so meshoptimizer's:
 * the order of vertices decides for triangles without texture area. */
static void compare_indexed(const file_mesh *m, const char *path, way how, const float *expected) {
    const norma_mesh *mesh = &m->data.mesh;
    if (mesh->face_starts || m->data.corner_normals || m->more.corner_texcoords ||
        how.maker == norma_core_meshopt_tangents)
        return;
    const norma_attribute normals = {.data = m->data.normals.data,
                              .count = m->data.normals.count,
                              .stride = m->data.normals.stride},
                          texcoords = {.data = m->more.texcoords, .count = m->more.texcoord_count};
    float *tangents = room(mesh->corner_count, 16);
    uint8_t *reasons = room(mesh->corner_count, 1);
    compute(mesh, &normals, &texcoords, how, tangents, reasons);
    if (memcmp(tangents, expected, 16 * mesh->corner_count) != 0) {
        fprintf(stderr, "%s: indexed, the mesh has other tangents\n", path);
        exit(1);
    }
    free(tangents);
    free(reasons);
}

static void answer_mesh(const file_mesh *m, const char *path, way how) {
    const norma_mesh *mesh = &m->data.mesh;
    const size_t faces = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
    soup s = soup_create(3 * mesh->corner_count);
    s.corners = 0;
    for (size_t f = 0; f < faces; ++f) {
        const size_t first = mesh->face_starts ? mesh->face_starts[f] : 3 * f,
                     end = mesh->face_starts ? mesh->face_starts[f + 1] : 3 * f + 3;
        add_face(m, first, end - first, &s);
    }
    const uint32_t count = (uint32_t)s.corners;
    float *tangents = room(count, 16);
    uint8_t *reasons = room(count, 1);
    fwrite(&count, 4, 1, stdout);
    fwrite(s.positions, 12, count, stdout);
    fwrite(s.normals, 12, count, stdout);
    fwrite(s.texcoords, 8, count, stdout);
    answer(&s, how, tangents, reasons);
    if (count == mesh->corner_count) compare_indexed(m, path, how, tangents);
    soup_free(&s);
    free(tangents);
    free(reasons);
}

static void answer_file(const char *path, way how) {
    norma_document *document = NULL;
    const norma_document_options options = {.struct_size = sizeof options, .lenient = 1};
    if (norma_document_open(path, &options, &document, NULL)) return;
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i) {
        file_mesh m = {0};
        if (norma_document_mesh_data(document, i, &m.data, NULL) ||
            norma_document_mesh_attributes(document, i, &m.more, NULL))
            continue;
        if (m.data.normals.count && m.more.texcoord_count) answer_mesh(&m, path, how);
    }
    norma_document_close(document);
}

int main(int argc, char **argv) {
    uint32_t corners;
    if (argc < 3) return 2;
    const way how = {!strcmp(argv[1], "mikk")      ? norma_core_mikk_tangents
                     : !strcmp(argv[1], "meshopt") ? norma_core_meshopt_tangents
                                                   : norma_core_steady_tangents,
        (uint32_t)atoi(argv[2])};
    for (int i = 3; i < argc; ++i) answer_file(argv[i], how);
    while (argc == 3 && fread(&corners, sizeof corners, 1, stdin) == 1) answer_input(corners, how);
    return 0;
}
