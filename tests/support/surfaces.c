/* surfaces.c: a torus and a box, by hand, and what norma check says of them. */
#include "surfaces.h"
#include "check.h"

static const double PI = 3.141592653589793;

static surface allocate(size_t vertices, size_t faces) {
    surface s = {.vertices = vertices, .faces = faces};
    s.positions = calloc(vertices + 1, 3 * sizeof(float));
    s.normals = calloc(vertices + 1, 3 * sizeof(float));
    s.texcoords = calloc(vertices + 1, 2 * sizeof(float));
    s.corners = calloc(faces + 1, 3 * sizeof(uint32_t));
    assert_true(s.positions && s.normals && s.texcoords && s.corners);
    return s;
}

surface surface_torus(size_t around, size_t across) {
    surface s = allocate((around + 1) * (across + 1), 2 * around * across);
    for (size_t i = 0, v = 0; i <= around; ++i)
        for (size_t k = 0; k <= across; ++k, ++v) {
            const double a = 2 * PI * (double)(i % around) / (double)around,
                         b = 2 * PI * (double)(k % across) / (double)across;
            const double normal[3] = {cos(a) * cos(b), sin(a) * cos(b), sin(b)},
                         centre[3] = {3 * cos(a), 3 * sin(a), 0};
            for (int d = 0; d < 3; ++d) {
                s.normals[3 * v + (size_t)d] = (float)normal[d];
                s.positions[3 * v + (size_t)d] = (float)(centre[d] + normal[d]);
            }
            s.texcoords[2 * v] = (float)i / (float)around;
            s.texcoords[2 * v + 1] = (float)k / (float)across;
        }
    for (size_t i = 0, c = 0; i < around; ++i)
        for (size_t k = 0; k < across; ++k) {
            const uint32_t here = (uint32_t)(i * (across + 1) + k),
                           next = here + (uint32_t)across + 1;
            const uint32_t two[6] = {here, next, next + 1, here, next + 1, here + 1};
            for (size_t j = 0; j < 6; ++j) s.corners[c++] = two[j];
        }
    return s;
}

surface surface_box(const double centre[3], double half, int inward) {
    surface s = allocate(24, 12);
    for (uint32_t side = 0; side < 6; ++side) {
        const size_t axis = side / 2, u = (axis + 1) % 3, w = (axis + 2) % 3;
        const double sign = side % 2 ? 1 : -1, facing = inward ? -sign : sign;
        for (uint32_t k = 0; k < 4; ++k) {
            float *p = s.positions + 3 * (4 * side + k), *n = s.normals + 3 * (4 * side + k);
            p[axis] = (float)(centre[axis] + sign * half);
            p[u] = (float)(centre[u] + (k == 1 || k == 2 ? half : -half));
            p[w] = (float)(centre[w] + (k >= 2 ? half : -half));
            n[axis] = (float)facing;
        }
        for (uint32_t k = 0; k < 2; ++k) {
            uint32_t *c = s.corners + 3 * (2 * side + k);
            c[0] = 4 * side;
            c[1] = 4 * side + (facing > 0 ? 1 + k : 2 + k);
            c[2] = 4 * side + (facing > 0 ? 2 + k : 1 + k);
        }
    }
    return s;
}

surface surface_join(surface a, surface b) {
    surface s = allocate(a.vertices + b.vertices, a.faces + b.faces);
    memcpy(s.positions, a.positions, 12 * a.vertices);
    memcpy(s.positions + 3 * a.vertices, b.positions, 12 * b.vertices);
    memcpy(s.normals, a.normals, 12 * a.vertices);
    memcpy(s.normals + 3 * a.vertices, b.normals, 12 * b.vertices);
    memcpy(s.texcoords, a.texcoords, 8 * a.vertices);
    memcpy(s.texcoords + 2 * a.vertices, b.texcoords, 8 * b.vertices);
    memcpy(s.corners, a.corners, 12 * a.faces);
    for (size_t c = 0; c < 3 * b.faces; ++c)
        s.corners[3 * a.faces + c] = b.corners[c] + (uint32_t)a.vertices;
    surface_free(&a);
    surface_free(&b);
    return s;
}

surface surface_soup(surface old) {
    surface s = allocate(3 * old.faces, old.faces);
    for (size_t c = 0; c < 3 * old.faces; ++c) {
        memcpy(s.positions + 3 * c, old.positions + 3 * old.corners[c], 12);
        memcpy(s.normals + 3 * c, old.normals + 3 * old.corners[c], 12);
        memcpy(s.texcoords + 2 * c, old.texcoords + 2 * old.corners[c], 8);
        s.corners[c] = (uint32_t)c;
    }
    surface_free(&old);
    return s;
}

void surface_turn_face(surface *s, size_t face) {
    const uint32_t second = s->corners[3 * face + 1];
    s->corners[3 * face + 1] = s->corners[3 * face + 2];
    s->corners[3 * face + 2] = second;
}

size_t surface_add_face(surface *s, const uint32_t corners[3]) {
    s->corners = realloc(s->corners, 12 * (s->faces + 1));
    assert_non_null(s->corners);
    memcpy(s->corners + 3 * s->faces, corners, 12);
    return s->faces++;
}

uint32_t surface_add_vertex(surface *s, const float position[3], const float normal[3]) {
    s->positions = realloc(s->positions, 12 * (s->vertices + 1));
    s->normals = realloc(s->normals, 12 * (s->vertices + 1));
    s->texcoords = realloc(s->texcoords, 8 * (s->vertices + 1));
    assert_true(s->positions && s->normals && s->texcoords);
    memcpy(s->positions + 3 * s->vertices, position, 12);
    memcpy(s->normals + 3 * s->vertices, normal, 12);
    memset(s->texcoords + 2 * s->vertices, 0, 8);
    return (uint32_t)s->vertices++;
}

void surface_free(surface *s) {
    free(s->positions);
    free(s->normals);
    free(s->texcoords);
    free(s->corners);
    free(s->starts);
    *s = (surface){0};
}

norma_findings *surface_findings(
    surface *s, const norma_check_options *options, norma_file_format format) {
    norma_check_mesh *m = &s->mesh;
    norma_findings *findings = NULL;
    m->info.name = "";
    m->info.where = "";
    m->info.vertices = s->vertices;
    m->info.faces = s->faces;
    if (!m->info.encoding) m->info.encoding = "float";
    if (m->info.normals == NORMA_NORMALS_NONE && s->normals)
        m->info.normals = NORMA_NORMALS_PER_VERTEX;
    m->data.mesh = (norma_mesh){.positions = {s->positions, s->vertices, 0, NORMA_FORMAT_FLOAT},
        .corners = s->corners,
        .corner_count = s->starts ? s->starts[s->faces] : 3 * s->faces,
        .face_starts = s->starts,
        .face_count = s->faces};
    m->data.normals = s->normals
                          ? (norma_vec3_view){s->normals,
                                m->info.normals == NORMA_NORMALS_PER_FACET ? s->faces : s->vertices,
                                0, NORMA_FORMAT_FLOAT}
                          : (norma_vec3_view){0};
    m->attributes.material = SIZE_MAX;
    m->attributes.texcoords = s->texcoords;
    m->attributes.texcoord_count = s->texcoords ? s->vertices : 0;
    const norma_check_scene scene = {.meshes = m, .mesh_count = 1, .format = format};
    assert_ok(norma_check_scene_run(&scene, options, &findings));
    return findings;
}

const norma_finding *finding_of(
    const norma_findings *findings, const char *id, norma_severity severity) {
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (!strcmp(finding->rule->id, id) &&
            (severity == NORMA_SEVERITY_NONE || finding->severity == severity))
            return finding;
    }
    return NULL;
}

int findings_trouble(const norma_findings *findings) {
    int trouble = 0;
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (finding->severity <= NORMA_SEVERITY_INFO) continue;
        print_error("%s %s: %s\n", finding->rule->id, finding->where, finding->message);
        trouble = 1;
    }
    return trouble;
}
