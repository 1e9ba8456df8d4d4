/* fix_files.c: see fix_files.h. */
#define _POSIX_C_SOURCE 200809L
#include "fix_files.h"
#include "oracle/made_case.h"
#include "oracle/shapes.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint32_t below(uint64_t *state, uint32_t count) {
    return (uint32_t)((made_case_random(state) >> 32) % count);
}

static int chance(uint64_t *state, uint32_t one_in) { return below(state, one_in) == 0; }

/* ---- meshes */

static void append(mesh_file *mesh, const mesh_file *part, double scale, double far, int turned) {
    const uint32_t first = (uint32_t)mesh->position_count;
    for (size_t v = 0; v < part->position_count; ++v)
        mesh_file_add_position(mesh, scale * part->positions[v][0] + far,
            scale * part->positions[v][1], scale * part->positions[v][2]);
    for (size_t f = 0; f < part->face_count; ++f) {
        uint32_t corners[512];
        const uint32_t start = part->starts[f], count = part->starts[f + 1] - start;
        for (uint32_t i = 0; i < count && i < 512; ++i)
            corners[i] = first + part->corners[start + (turned ? count - 1 - i : i)];
        if (count <= 512) mesh_file_add_face(mesh, corners, count);
    }
}

static void add_case(mesh_file *mesh, uint64_t *state) {
    static made_case made;
    const uint64_t words[2] = {made_case_random(state), made_case_random(state)};
    uint8_t bytes[16];
    for (int i = 0; i < 16; ++i) bytes[i] = (uint8_t)(words[i / 8] >> 8 * (i % 8));
    made_case_make(&made, bytes, sizeof bytes);
    if (made.face_count > 60 || made.position_count > 250) return;
    const uint32_t first = (uint32_t)mesh->position_count;
    for (size_t v = 0; v < made.position_count; ++v) {
        double p[3];
        for (int k = 0; k < 3; ++k)
            p[k] = fabs(made.positions[v][k]) < 1e6 ? made.positions[v][k] : 0;
        mesh_file_add_position(mesh, p[0], p[1], p[2]);
    }
    for (size_t i = 0; i < made.corner_count; ++i) made.corners[i] += first;
    for (size_t f = 0; f < made.face_count; ++f)
        if (made.starts[f + 1] - made.starts[f] >= 3)
            mesh_file_add_face(
                mesh, made.corners + made.starts[f], made.starts[f + 1] - made.starts[f]);
}

static void add_part(mesh_file *mesh, uint64_t *state) {
    static const double scales[] = {1, 1, 0.5, 2, 0.1};
    mesh_file part = {0};
    const double scale = scales[below(state, 5)], far = chance(state, 2) ? 0 : 3 * below(state, 3);
    const int quads = (int)below(state, 2);
    switch (below(state, 7)) {
    case 0:
        shape_box(&part, 1, 2, 0.5, quads);
        break;
    case 1:
        shape_uv_sphere(&part, 3 + below(state, 5), 2 + below(state, 3), quads, quads);
        break;
    case 2:
        shape_octahedron_sphere(&part, 1 + below(state, 2));
        break;
    case 3:
        shape_wavy_grid(&part, 2 + below(state, 4), quads);
        break;
    case 4:
        shape_cone(&part, 3 + below(state, 9), 1);
        break;
    case 5:
        shape_pole_sphere(&part, 4 + below(state, 3), 3, quads);
        break;
    default:
        add_case(mesh, state);
    }
    append(mesh, &part, scale, far, chance(state, 3));
    mesh_file_free(&part);
}

/* Faces turned, doubled, doubled back to back, left out; corners that name another position;
 * positions moved a little. */
static void damage(mesh_file *mesh, uint64_t *state) {
    const uint32_t faces = (uint32_t)mesh->face_count;
    uint32_t corners[512];
    if (!faces) return;
    const uint32_t f = below(state, faces), start = mesh->starts[f],
                   count = mesh->starts[f + 1] - start;
    if (count > 512) return;
    memcpy(corners, mesh->corners + start, count * sizeof *corners);
    switch (below(state, 6)) {
    case 0:
        for (uint32_t i = 0; i < count; ++i) mesh->corners[start + i] = corners[count - 1 - i];
        return;
    case 1:
        mesh_file_add_face(mesh, corners, count);
        return;
    case 2:
        for (uint32_t i = 0; i < count; ++i) corners[i] = mesh->corners[start + count - 1 - i];
        mesh_file_add_face(mesh, corners, count);
        return;
    case 3: /* the last takes its place */
        if (mesh->starts[faces] - mesh->starts[faces - 1] != count) return;
        memcpy(mesh->corners + start, mesh->corners + mesh->starts[faces - 1],
            count * sizeof *corners);
        mesh->corner_count -= count;
        --mesh->face_count;
        return;
    case 4:
        mesh->corners[start + below(state, count)] = below(state, (uint32_t)mesh->position_count);
        return;
    default: {
        double *p = mesh->positions[mesh->corners[start + below(state, count)]];
        p[below(state, 3)] += ldexp(1, -(int)below(state, 30));
    }
    }
}

/* ---- normals: one for each corner */

/* Some are turned, shortened or gone; now and then all are turned. */
static void damage_normals(float *normals, size_t count, uint64_t *state) {
    static const float scales[] = {0, -1, 0.5F, -1};
    for (uint32_t i = below(state, 4); i > 0 && count; --i) {
        float *n = normals + 3 * below(state, (uint32_t)count);
        const float s = scales[below(state, 4)];
        for (int k = 0; k < 3; ++k) n[k] *= s;
    }
    if (chance(state, 8))
        for (size_t i = 0; i < 3 * count; ++i) normals[i] = -normals[i];
}

static const norma_options up = {.fallback = NORMA_FALLBACK_GIVEN, .fallback_normal = {0, 0, 1}};

/* Of vertices as they are before the mesh is damaged, so that windings come to disagree with them;
 * or of corners as they are now. */
static float *make_normals(mesh_file *mesh, uint64_t *state) {
    const uint32_t kind = below(state, 3), times = chance(state, 4) ? 0 : below(state, 6);
    const norma_mesh whole = mesh_file_view_polygons(mesh);
    float *vertices = calloc(3 * mesh->position_count + 3, sizeof *vertices);
    if (!vertices) abort();
    norma_vertex_normals(&whole, &up, vertices, mesh->position_count, NULL);
    for (uint32_t i = 0; i < times; ++i) damage(mesh, state);
    float *normals = calloc(3 * mesh->corner_count + 3, sizeof *normals);
    if (!normals) abort();
    const norma_mesh damaged = mesh_file_view_polygons(mesh);
    if (kind == 1) damage_normals(vertices, mesh->position_count, state);
    for (size_t c = 0; c < mesh->corner_count; ++c)
        memcpy(normals + 3 * c, vertices + 3 * mesh->corners[c], 12);
    if (kind == 2) {
        norma_corner_normals(
            &damaged, chance(state, 2) ? 1 : 0, &up, normals, mesh->corner_count, NULL);
        damage_normals(normals, mesh->corner_count, state);
    }
    free(vertices);
    if (kind) return normals;
    free(normals);
    return NULL;
}

/* ---- files */

static void write_obj(FILE *file, const mesh_file *mesh, const float *normals) {
    for (size_t v = 0; v < mesh->position_count; ++v)
        fprintf(file, "v %.9g %.9g %.9g\n", mesh->positions[v][0], mesh->positions[v][1],
            mesh->positions[v][2]);
    for (size_t c = 0; normals && c < mesh->corner_count; ++c)
        fprintf(file, "vn %.7g %.7g %.7g\n", (double)normals[3 * c], (double)normals[3 * c + 1],
            (double)normals[3 * c + 2]);
    for (size_t f = 0; f < mesh->face_count; ++f) {
        fputc('f', file);
        for (uint32_t c = mesh->starts[f]; c < mesh->starts[f + 1]; ++c)
            if (normals)
                fprintf(file, " %u//%u", (unsigned)mesh->corners[c] + 1, (unsigned)c + 1);
            else
                fprintf(file, " %u", (unsigned)mesh->corners[c] + 1);
        fputc('\n', file);
    }
}

/* Per vertex: of its last corner. */
static float *of_vertices(const mesh_file *mesh, const float *normals) {
    float *n = calloc(3 * mesh->position_count + 3, sizeof *n);
    if (!n) abort();
    for (size_t c = 0; c < mesh->corner_count; ++c)
        memcpy(n + 3 * mesh->corners[c], normals + 3 * c, 12);
    for (size_t v = 0; v < mesh->position_count; ++v)
        if (n[3 * v] == 0 && n[3 * v + 1] == 0 && n[3 * v + 2] == 0) n[3 * v + 2] = 1;
    return n;
}

static void write_ply(FILE *file, const mesh_file *mesh, const float *normals) {
    float *n = normals ? of_vertices(mesh, normals) : NULL;
    fprintf(file, "ply\nformat ascii 1.0\nelement vertex %zu\n", mesh->position_count);
    fputs("property float x\nproperty float y\nproperty float z\n", file);
    if (n) fputs("property float nx\nproperty float ny\nproperty float nz\n", file);
    fprintf(file, "element face %zu\nproperty list uchar int vertex_indices\nend_header\n",
        mesh->face_count);
    for (size_t v = 0; v < mesh->position_count; ++v) {
        fprintf(file, "%.9g %.9g %.9g", mesh->positions[v][0], mesh->positions[v][1],
            mesh->positions[v][2]);
        if (n)
            fprintf(file, " %.7g %.7g %.7g", (double)n[3 * v], (double)n[3 * v + 1],
                (double)n[3 * v + 2]);
        fputc('\n', file);
    }
    for (size_t f = 0; f < mesh->face_count; ++f) {
        fprintf(file, "%u", (unsigned)(mesh->starts[f + 1] - mesh->starts[f]));
        for (uint32_t c = mesh->starts[f]; c < mesh->starts[f + 1]; ++c)
            fprintf(file, " %u", (unsigned)mesh->corners[c]);
        fputc('\n', file);
    }
    free(n);
}

/* Triangles fanned from the first corner. */
static size_t triangulate(const mesh_file *mesh, uint32_t *corners) {
    size_t count = 0;
    for (size_t f = 0; f < mesh->face_count; ++f)
        for (uint32_t c = mesh->starts[f] + 1; c + 1 < mesh->starts[f + 1]; ++c) {
            corners[count++] = mesh->corners[mesh->starts[f]];
            corners[count++] = mesh->corners[c];
            corners[count++] = mesh->corners[c + 1];
        }
    return count;
}

static void write_stl(FILE *file, const mesh_file *mesh, uint64_t *state) {
    uint32_t *corners = calloc(3 * mesh->corner_count + 1, sizeof *corners);
    if (!corners) abort();
    const size_t count = triangulate(mesh, corners);
    const uint32_t reversed = below(state, 3);
    fputs("solid made\n", file);
    for (size_t i = 0; i < count; i += 3) {
        const double *a = mesh->positions[corners[i]], *b = mesh->positions[corners[i + 1]],
                     *c = mesh->positions[corners[i + 2]];
        double n[3];
        const double s = reversed == 2 && chance(state, 3) ? -1 : chance(state, 30) ? 0 : 1;
        for (int k = 0; k < 3; ++k) {
            const int x = (k + 1) % 3, y = (k + 2) % 3;
            n[k] = (b[x] - a[x]) * (c[y] - a[y]) - (b[y] - a[y]) * (c[x] - a[x]);
        }
        const double l = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), f = l > 0 ? s / l : 0;
        fprintf(file, "facet normal %.7g %.7g %.7g\n outer loop\n", f * n[0], f * n[1], f * n[2]);
        for (size_t k = 0; k < 3; ++k) {
            const double *p = mesh->positions[corners[i + k]];
            fprintf(file, "  vertex %.9g %.9g %.9g\n", p[0], p[1], p[2]);
        }
        fputs(" endloop\nendfacet\n", file);
    }
    fputs("endsolid made\n", file);
    free(corners);
}

static void put32(FILE *file, size_t value) {
    for (int i = 0; i < 4; ++i) fputc((int)(value >> 8 * i & 255), file);
}

static void write_floats(FILE *file, const float *values, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, &values[i], 4);
        put32(file, bits);
    }
}

static void write_glb(FILE *file, const mesh_file *mesh, const float *normals, uint64_t *state) {
    char json[2000];
    uint32_t *corners = calloc(3 * mesh->corner_count + 1, sizeof *corners);
    float *positions = calloc(3 * mesh->position_count + 1, sizeof *positions),
          *n = normals ? of_vertices(mesh, normals) : NULL;
    if (!corners || !positions) abort();
    const size_t count = triangulate(mesh, corners), vertices = mesh->position_count,
                 floats = 12 * vertices, bin = floats * (n ? 2 : 1) + 4 * count;
    double low[3] = {0}, high[3] = {0};
    for (size_t i = 0; i < 3 * vertices; ++i) {
        const size_t k = i % 3;
        const double x = (double)(positions[i] = (float)mesh->positions[i / 3][k]);
        if (i < 3 || x < low[k]) low[k] = x;
        if (i < 3 || x > high[k]) high[k] = x;
    }
    for (size_t v = 0; n && v < vertices; ++v) { /* of a length that readers accept */
        float *p = n + 3 * v;
        const float l = sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        for (int k = 0; k < 3; ++k) p[k] /= l > 0 ? l : 1;
    }
    snprintf(json, sizeof json,
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{"
        "\"mesh\":0}],\"materials\":[{\"doubleSided\":%s}],\"meshes\":[{\"primitives\":[{"
        "\"material\":0,\"indices\":0,\"attributes\":{\"POSITION\":1%s}}]}],\"buffers\":[{"
        "\"byteLength\":%zu}],\"bufferViews\":[{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}"
        ",{\"buffer\":0,\"byteLength\":%zu}],\"accessors\":[{\"bufferView\":0,\"componentType\":"
        "5125,\"count\":%zu,\"type\":\"SCALAR\"},{\"bufferView\":1,\"componentType\":5126,"
        "\"count\":%zu,\"type\":\"VEC3\",\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]}%s",
        chance(state, 5) ? "true" : "false", n ? ",\"NORMAL\":2" : "", bin, bin - 4 * count,
        4 * count, bin - 4 * count, count, vertices, low[0], low[1], low[2], high[0], high[1],
        high[2], n ? "" : "]}");
    if (n)
        snprintf(json + strlen(json), sizeof json - strlen(json),
            ",{\"bufferView\":1,\"byteOffset\":%zu,\"componentType\":5126,\"count\":%zu,\"type\":"
            "\"VEC3\"}]}",
            floats, vertices);
    while (strlen(json) % 4) strcat(json, " ");
    fputs("glTF", file);
    put32(file, 2);
    put32(file, 12 + 8 + strlen(json) + 8 + bin);
    put32(file, strlen(json));
    fputs("JSON", file);
    fputs(json, file);
    put32(file, bin);
    fwrite("BIN\0", 1, 4, file);
    write_floats(file, positions, 3 * vertices);
    if (n) write_floats(file, n, 3 * vertices);
    for (size_t i = 0; i < count; ++i) put32(file, corners[i]);
    free(corners);
    free(positions);
    free(n);
}

void broken_file_options(uint64_t *state, broken_file *out) {
    size_t rules;
    norma_rules(&rules);
    memset(out->rules, 0, sizeof out->rules);
    out->options = (norma_check_options){.struct_size = sizeof out->options,
        .profile = (norma_check_profile)below(state, 4),
        .threads = 1,
        .open_by_rays = chance(state, 3)};
    out->unsafe = !chance(state, 4);
    if (chance(state, 2)) return;
    for (uint32_t i = 1 + below(state, 3); i > 0; --i)
        out->rules[below(state, (uint32_t)rules)] = 1;
    out->options.rules = out->rules;
}

void broken_file_make(uint64_t seed, broken_file *out) {
    static const norma_file_format formats[] = {
        NORMA_FILE_OBJ, NORMA_FILE_PLY, NORMA_FILE_STL, NORMA_FILE_GLB};
    uint64_t state = seed;
    mesh_file mesh = {0};
    char *bytes = NULL;
    size_t size = 0;
    for (uint32_t i = 1 + below(&state, 3); i > 0; --i) add_part(&mesh, &state);
    float *normals = make_normals(&mesh, &state);
    out->file.format = formats[below(&state, 4)];
    FILE *file = open_memstream(&bytes, &size);
    if (!file) abort();
    if (out->file.format == NORMA_FILE_OBJ) write_obj(file, &mesh, normals);
    if (out->file.format == NORMA_FILE_PLY) write_ply(file, &mesh, normals);
    if (out->file.format == NORMA_FILE_STL) write_stl(file, &mesh, &state);
    if (out->file.format == NORMA_FILE_GLB) write_glb(file, &mesh, normals, &state);
    fclose(file);
    out->file.bytes = bytes;
    out->file.size = size;
    broken_file_options(&state, out);
    free(normals);
    mesh_file_free(&mesh);
}

void broken_file_free(broken_file *file) { free((void *)(uintptr_t)file->file.bytes); }
