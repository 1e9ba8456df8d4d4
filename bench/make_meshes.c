/* make_meshes.c: large meshes for measuring: a grid of triangles, row by row, displaced by waves,
 * with a step every 64 rows so that some edges are hard. make_meshes KIND TRIANGLES FILE KIND: obj
 * (v and f alone), obj-quads, obj-vt and obj-quads-vt (with texture coordinates), obj-full (v, vt,
 * vn and f v/vt/vn, as exporters write), ply, stl (binary), glb, glb-normals; ply-vertices writes
 * no triangles but a binary PLY of TRIANGLES bytes of vertices, as a file with a hole. Files are
 * the same on every machine: no libm result is printed with all its digits. */
#define _FILE_OFFSET_BITS 64
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

typedef struct grid {
    uint32_t side; /* quads along each side */
    size_t vertices, triangles;
} grid;

static void put(FILE *out, const void *bytes, size_t size) {
    if (fwrite(bytes, 1, size, out) != size) {
        perror("make_meshes");
        exit(1);
    }
}

static void put_u32(FILE *out, uint32_t value) {
    const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8),
        (unsigned char)(value >> 16), (unsigned char)(value >> 24)};
    put(out, bytes, 4);
}

static void put_floats(FILE *out, const float *values, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, values + i, sizeof bits);
        put_u32(out, bits);
    }
}

/* Rounded to six decimals, as text files have it, so that every format holds the same surface. */
static float rounded(double value) { return (float)(floor(value * 1e6 + 0.5) / 1e6); }

static void position(const grid *g, size_t vertex, float out[3]) {
    const double row = (double)(vertex / (g->side + 1)), column = (double)(vertex % (g->side + 1)),
                 x = column / g->side, y = row / g->side;
    const double step = floor(row / 64) - floor((row - 1) / 64) > 0 ? 4.0 / g->side : 0;
    out[0] = rounded(10 * x - 5);
    out[1] = rounded(10 * y - 5);
    out[2] = rounded(0.5 * sin(12 * x) * cos(9 * y) + 0.02 * sin(170 * x + 90 * y) + 10 * step);
}

/* Of the smooth surface; near enough for stored normals that are to be replaced. */
static void normal(const grid *g, size_t vertex, float out[3]) {
    const double x = (double)(vertex % (g->side + 1)) / g->side,
                 y = (double)(vertex / (g->side + 1)) / g->side;
    const double dx = -0.6 * cos(12 * x) * cos(9 * y), dy = 0.45 * sin(12 * x) * sin(9 * y),
                 length = sqrt(dx * dx + dy * dy + 1);
    out[0] = (float)(dx / length);
    out[1] = (float)(dy / length);
    out[2] = (float)(1 / length);
}

static void corners(const grid *g, size_t triangle, uint32_t out[3]) {
    const size_t quad = triangle / 2, row = quad / g->side, column = quad % g->side;
    const uint32_t a = (uint32_t)(row * (g->side + 1) + column), b = a + 1, c = a + g->side + 1,
                   d = c + 1;
    out[0] = triangle % 2 ? b : a;
    out[1] = triangle % 2 ? d : b;
    out[2] = c;
}

/* What a statement of an OBJ names beside positions, and how many corners a face has. */
typedef struct obj_kind {
    const char *name;
    int texcoords, normals, quads;
} obj_kind;

static const obj_kind OBJ_KINDS[] = {{"obj", 0, 0, 0}, {"obj-quads", 0, 0, 1}, {"obj-vt", 1, 0, 0},
    {"obj-quads-vt", 1, 0, 1}, {"obj-full", 1, 1, 0}};

static void write_obj_face(const obj_kind *kind, FILE *out, const uint32_t *c, int count) {
    fputc('f', out);
    for (int k = 0; k < count; ++k) {
        fprintf(out, " %u", c[k] + 1);
        if (kind->texcoords) fprintf(out, "/%u", c[k] + 1);
        if (kind->normals) fprintf(out, "/%u", c[k] + 1);
    }
    fputc('\n', out);
}

static void write_obj(const grid *g, FILE *out, const obj_kind *kind) {
    float p[3];
    fprintf(out, "# %zu vertices, %zu triangles\no grid\n", g->vertices, g->triangles);
    for (size_t i = 0; i < g->vertices; ++i) {
        position(g, i, p);
        fprintf(out, "v %.6f %.6f %.6f\n", (double)p[0], (double)p[1], (double)p[2]);
    }
    for (size_t i = 0; i < g->vertices && kind->texcoords; ++i)
        fprintf(out, "vt %.6f %.6f\n", (double)(i % (g->side + 1)) / g->side,
            (double)(i / (g->side + 1)) / g->side);
    for (size_t i = 0; i < g->vertices && kind->normals; ++i) {
        normal(g, i, p);
        fprintf(out, "vn %.4f %.4f %.4f\n", (double)p[0], (double)p[1], (double)p[2]);
    }
    for (size_t i = 0; i < g->triangles; i += kind->quads ? 2 : 1) {
        uint32_t one[3], other[3];
        corners(g, i, one);
        corners(g, i | 1, other);
        const uint32_t quad[4] = {one[0], one[1], other[1], one[2]};
        write_obj_face(kind, out, kind->quads ? quad : one, kind->quads ? 4 : 3);
    }
}

static void write_ply_header(FILE *out, size_t vertices, size_t faces) {
    fprintf(out,
        "ply\nformat binary_little_endian 1.0\nelement vertex %zu\nproperty float x\nproperty "
        "float y\nproperty float z\n",
        vertices);
    fprintf(out, "element face %zu\nproperty list uchar int vertex_indices\nend_header\n", faces);
}

static void write_ply(const grid *g, FILE *out) {
    float p[3];
    uint32_t c[3];
    write_ply_header(out, g->vertices, g->triangles);
    for (size_t i = 0; i < g->vertices; ++i) {
        position(g, i, p);
        put_floats(out, p, 3);
    }
    for (size_t i = 0; i < g->triangles; ++i) {
        corners(g, i, c);
        put(out, "\3", 1);
        for (int k = 0; k < 3; ++k) put_u32(out, c[k]);
    }
}

static void write_stl(const grid *g, FILE *out) {
    const char header[80] = "a grid of triangles";
    const float none[3] = {0, 0, 0};
    float p[3];
    uint32_t c[3];
    put(out, header, sizeof header);
    put_u32(out, (uint32_t)g->triangles);
    for (size_t i = 0; i < g->triangles; ++i) {
        corners(g, i, c);
        put_floats(out, none, 3);
        for (int k = 0; k < 3; ++k) {
            position(g, c[k], p);
            put_floats(out, p, 3);
        }
        put(out, "\0", 2);
    }
}

static void write_glb(const grid *g, FILE *out, int normals) {
    const size_t vectors = 12 * g->vertices, indices = 12 * g->triangles,
                 bin = vectors * (normals ? 2 : 1) + indices;
    char json[2000], own_view[200] = "", own_accessor[200] = "";
    float p[3], least[3] = {INFINITY, INFINITY, INFINITY},
                most[3] = {-INFINITY, -INFINITY, -INFINITY};
    uint32_t c[3];
    for (size_t i = 0; i < g->vertices; ++i) {
        position(g, i, p);
        for (int k = 0; k < 3; ++k) {
            least[k] = p[k] < least[k] ? p[k] : least[k];
            most[k] = p[k] > most[k] ? p[k] : most[k];
        }
    }
    if (normals) {
        snprintf(own_view, sizeof own_view,
            ",{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":34962}",
            vectors + indices, vectors);
        snprintf(own_accessor, sizeof own_accessor,
            ",{\"bufferView\":2,\"componentType\":5126,\"count\":%zu,\"type\":\"VEC3\"}",
            g->vertices);
    }
    int length = snprintf(json, sizeof json,
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{"
        "\"mesh\":0}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0%s},\"indices\":1}]}],"
        "\"buffers\":[{\"byteLength\":%zu}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu,\"target\":34962},{\"buffer\":0,"
        "\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":34963}%s],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":%zu,\"type\":\"VEC3\","
        "\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]},"
        "{\"bufferView\":1,\"componentType\":5125,\"count\":%zu,\"type\":\"SCALAR\"}%s]}",
        normals ? ",\"NORMAL\":2" : "", bin, vectors, vectors, indices, own_view, g->vertices,
        (double)least[0], (double)least[1], (double)least[2], (double)most[0], (double)most[1],
        (double)most[2], 3 * g->triangles, own_accessor);
    while (length % 4) json[length++] = ' ';
    put(out, "glTF", 4);
    put_u32(out, 2);
    put_u32(out, (uint32_t)(12 + 8 + (size_t)length + 8 + bin));
    put_u32(out, (uint32_t)length);
    put(out, "JSON", 4);
    put(out, json, (size_t)length);
    put_u32(out, (uint32_t)bin);
    put(out, "BIN\0", 4);
    for (size_t i = 0; i < g->vertices; ++i) {
        position(g, i, p);
        put_floats(out, p, 3);
    }
    for (size_t i = 0; i < g->triangles; ++i) {
        corners(g, i, c);
        for (int k = 0; k < 3; ++k) put_u32(out, c[k]);
    }
    for (size_t i = 0; i < g->vertices && normals; ++i) {
        normal(g, i, p);
        put_floats(out, p, 3);
    }
}

static void write_hole(FILE *out, size_t bytes) {
    write_ply_header(out, bytes / 12, 0);
    if (fseek(out, (long)(bytes / 12 * 12 - 1), SEEK_CUR)) {
        perror("make_meshes");
        exit(1);
    }
    put(out, "", 1);
}

static const obj_kind *obj_kind_named(const char *name) {
    for (size_t i = 0; i < sizeof OBJ_KINDS / sizeof *OBJ_KINDS; ++i)
        if (!strcmp(name, OBJ_KINDS[i].name)) return &OBJ_KINDS[i];
    return NULL;
}

int main(int count, char **arguments) {
    if (count != 4) {
        fprintf(stderr, "usage: make_meshes obj|obj-quads|obj-vt|obj-quads-vt|obj-full|ply|stl|glb|"
                        "glb-normals|ply-vertices TRIANGLES FILE\n");
        return 2;
    }
    const char *kind = arguments[1];
    const size_t wanted = (size_t)strtoull(arguments[2], NULL, 10);
    grid g = {.side = (uint32_t)ceil(sqrt((double)wanted / 2))};
    g.side = g.side ? g.side : 1;
    g.vertices = (size_t)(g.side + 1) * (g.side + 1);
    g.triangles = 2 * (size_t)g.side * g.side;
    FILE *out = fopen(arguments[3], "wb");
    if (!out) {
        perror(arguments[3]);
        return 1;
    }
    const obj_kind *obj = obj_kind_named(kind);
    if (obj)
        write_obj(&g, out, obj);
    else if (!strcmp(kind, "ply"))
        write_ply(&g, out);
    else if (!strcmp(kind, "stl"))
        write_stl(&g, out);
    else if (!strcmp(kind, "glb") || !strcmp(kind, "glb-normals"))
        write_glb(&g, out, kind[3] != 0);
    else if (!strcmp(kind, "ply-vertices"))
        write_hole(out, wanted);
    else
        return fprintf(stderr, "make_meshes: unknown kind %s\n", kind), 2;
    if (fclose(out)) {
        perror(arguments[3]);
        return 1;
    }
    return 0;
}
