/* face_shapes.c: see shapes.h. */
#include "oracle/shapes.h"
#include <math.h>
#include <stdlib.h>

static const double PI = 3.14159265358979323846;

static void add_quad(mesh_file *mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d, int quads) {
    if (quads) {
        mesh_file_add_face(mesh, (uint32_t[]){a, b, c, d}, 4);
    } else {
        mesh_file_add_face(mesh, (uint32_t[]){a, b, c}, 3);
        mesh_file_add_face(mesh, (uint32_t[]){a, c, d}, 3);
    }
}

void shape_box(mesh_file *mesh, double x, double y, double z, int quads) {
    for (int i = 0; i < 8; ++i)
        mesh_file_add_position(mesh, i & 1 ? x : 0, i & 2 ? y : 0, i & 4 ? z : 0);
    add_quad(mesh, 0, 2, 3, 1, quads);
    add_quad(mesh, 4, 5, 7, 6, quads);
    add_quad(mesh, 0, 1, 5, 4, quads);
    add_quad(mesh, 2, 6, 7, 3, quads);
    add_quad(mesh, 0, 4, 6, 2, quads);
    add_quad(mesh, 1, 3, 7, 5, quads);
}

static void add_sphere_position(
    mesh_file *mesh, size_t segment, size_t segments, size_t ring, size_t rings) {
    const double phi = 2 * PI * (double)(segment % segments) / (double)segments,
                 theta = PI * (double)ring / (double)rings;
    const double r = ring == 0 || ring == rings ? 0 : sin(theta);
    mesh_file_add_position(mesh, r * cos(phi), r * sin(phi),
        ring == 0       ? 1
        : ring == rings ? -1
                        : cos(theta));
}

void shape_uv_sphere(mesh_file *mesh, size_t segments, size_t rings, int seam, int quads) {
    const size_t columns = seam ? segments + 1 : segments, poles = seam ? segments : 1;
    for (size_t i = 0; i < poles; ++i) add_sphere_position(mesh, 0, segments, 0, rings);
    for (size_t ring = 1; ring < rings; ++ring)
        for (size_t i = 0; i < columns; ++i) add_sphere_position(mesh, i, segments, ring, rings);
    for (size_t i = 0; i < poles; ++i) add_sphere_position(mesh, 0, segments, rings, rings);
    const uint32_t south = (uint32_t)(poles + (rings - 1) * columns);
    for (size_t i = 0; i < segments; ++i) {
        const uint32_t here = (uint32_t)i, after = (uint32_t)(seam ? i + 1 : (i + 1) % segments),
                       pole = seam ? here : 0;
        const uint32_t top = (uint32_t)poles, bottom = (uint32_t)(poles + (rings - 2) * columns);
        mesh_file_add_face(mesh, (uint32_t[]){pole, top + here, top + after}, 3);
        for (size_t ring = 1; ring + 1 < rings; ++ring) {
            const uint32_t a = (uint32_t)(poles + (ring - 1) * columns),
                           b = (uint32_t)(a + columns);
            add_quad(mesh, a + here, b + here, b + after, a + after, quads);
        }
        mesh_file_add_face(mesh, (uint32_t[]){bottom + here, south + pole, bottom + after}, 3);
    }
}

void shape_pole_sphere(mesh_file *mesh, size_t segments, size_t rings, int quads) {
    for (size_t ring = 0; ring <= rings; ++ring)
        for (size_t i = 0; i <= segments; ++i) add_sphere_position(mesh, i, segments, ring, rings);
    for (size_t ring = 0; ring < rings; ++ring)
        for (size_t i = 0; i < segments; ++i) {
            const uint32_t a = (uint32_t)(ring * (segments + 1) + i),
                           b = (uint32_t)(a + segments + 1);
            add_quad(mesh, a, b, b + 1, a + 1, quads);
        }
}

void shape_cone(mesh_file *mesh, size_t sides, double height) {
    mesh_file_add_position(mesh, 0, 0, height);
    for (size_t i = 0; i < sides; ++i)
        mesh_file_add_position(mesh, cos(2 * PI * (double)i / (double)sides),
            sin(2 * PI * (double)i / (double)sides), 0);
    for (size_t i = 0; i < sides; ++i)
        mesh_file_add_face(
            mesh, (uint32_t[]){0, (uint32_t)(1 + i), (uint32_t)(1 + (i + 1) % sides)}, 3);
}

void shape_fan(mesh_file *mesh, size_t triangles) { shape_cone(mesh, triangles, 0); }

/* The triangle a, b, c in n * n smaller ones, vertices of its own. */
static void subdivide(
    mesh_file *mesh, const double a[3], const double b[3], const double c[3], size_t n) {
    const uint32_t first = (uint32_t)mesh->position_count;
    for (size_t i = 0; i <= n; ++i)
        for (size_t j = 0; j <= i; ++j) {
            double p[3], length = 0;
            for (int x = 0; x < 3; ++x) {
                p[x] = (a[x] * (double)(n - i) + b[x] * (double)(i - j) + c[x] * (double)j) /
                       (double)n;
                length += p[x] * p[x];
            }
            length = sqrt(length);
            mesh_file_add_position(mesh, p[0] / length, p[1] / length, p[2] / length);
        }
    for (uint32_t i = 0; i < n; ++i)
        for (uint32_t j = 0; j <= i; ++j) {
            const uint32_t here = first + i * (i + 1) / 2 + j, below = here + i + 1;
            mesh_file_add_face(mesh, (uint32_t[]){here, below, below + 1}, 3);
            if (j < i) mesh_file_add_face(mesh, (uint32_t[]){here, below + 1, here + 1}, 3);
        }
}

void shape_octahedron_sphere(mesh_file *mesh, size_t subdivisions) {
    for (int i = 0; i < 8; ++i) {
        const double x[3] = {i & 1 ? -1 : 1, 0, 0}, y[3] = {0, i & 2 ? -1 : 1, 0},
                     z[3] = {0, 0, i & 4 ? -1 : 1};
        const int flip = ((i & 1) + (i >> 1 & 1) + (i >> 2 & 1)) & 1;
        subdivide(mesh, x, flip ? z : y, flip ? y : z, subdivisions);
    }
}

void shape_wavy_grid(mesh_file *mesh, size_t n, int quads) {
    for (size_t j = 0; j <= n; ++j)
        for (size_t i = 0; i <= n; ++i) {
            const double x = 2 * PI * (double)i / (double)n, y = 2 * PI * (double)j / (double)n;
            mesh_file_add_position(mesh, x, y, sin(x) * cos(y));
        }
    for (size_t j = 0; j < n; ++j)
        for (size_t i = 0; i < n; ++i) {
            const uint32_t a = (uint32_t)(j * (n + 1) + i), b = (uint32_t)(a + n + 1);
            add_quad(mesh, a, a + 1, b + 1, b, quads);
        }
}

void shape_soup(mesh_file *out, const mesh_file *mesh) {
    for (size_t f = 0; f < mesh->face_count; ++f) {
        uint32_t corners[64];
        size_t count = 0;
        for (uint32_t c = mesh->starts[f]; c < mesh->starts[f + 1] && count < 64; ++c) {
            const double *p = mesh->positions[mesh->corners[c]];
            corners[count++] = (uint32_t)out->position_count;
            mesh_file_add_position(out, p[0], p[1], p[2]);
        }
        mesh_file_add_face(out, corners, count);
    }
}

void shape_scale(mesh_file *mesh, double factor) {
    for (size_t i = 0; i < mesh->position_count; ++i)
        for (int x = 0; x < 3; ++x) mesh->positions[i][x] *= factor;
}

void shape_round_to_float(mesh_file *mesh) {
    for (size_t i = 0; i < mesh->position_count; ++i)
        for (int x = 0; x < 3; ++x) mesh->positions[i][x] = (double)(float)mesh->positions[i][x];
}

void shape_map(mesh_file *mesh, const double m[9]) {
    for (size_t i = 0; i < mesh->position_count; ++i) {
        double *p = mesh->positions[i], q[3];
        for (int x = 0; x < 3; ++x)
            q[x] = m[3 * x] * p[0] + m[3 * x + 1] * p[1] + m[3 * x + 2] * p[2];
        for (int x = 0; x < 3; ++x) p[x] = q[x];
    }
}

/* Steele, Lea, Flood 2014: SplitMix64. */
uint32_t shape_random(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return (uint32_t)((z ^ z >> 31) >> 32);
}

double shape_random_unit(uint64_t *state) { return (double)shape_random(state) * 0x1p-31 - 1; }
