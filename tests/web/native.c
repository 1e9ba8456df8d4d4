/* native.c: the native library's answers, byte for byte, for tests/web/bits.mjs. Reads records on
 * standard input, each a head and its bytes, and writes for each the result and the bytes of what
 * was computed. */
#include <norma/norma.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FACES, VERTICES, CORNERS, SPLIT, MATRICES, INFO, TRANSFORM, PLAN_VERTICES, PLAN_CORNERS };

typedef struct head {
    uint32_t operation, weight, weld, format, position_count, position_bytes, corner_count,
        corner_size, non_manifold, fallback; /* corner_size 0: no corners */
    double weld_distance, crease_deg;
} head;

static void *room(size_t bytes) {
    void *block = malloc(bytes ? bytes : 1);
    if (!block) exit(3);
    return block;
}

static void *read_bytes(size_t bytes) {
    void *block = room(bytes);
    if (fread(block, 1, bytes, stdin) != bytes) exit(2);
    return block;
}

static void answer(int32_t result, const void *bytes, size_t size) {
    const uint32_t length = !result ? (uint32_t)size : 0;
    fwrite(&result, 4, 1, stdout);
    fwrite(&length, 4, 1, stdout);
    fwrite(bytes, 1, length, stdout);
}

static float radians(double degrees) { return (float)(degrees * (3.141592653589793 / 180)); }

static void answer_split(const norma_mesh *mesh, double crease_deg, const norma_options *options) {
    const size_t corners = mesh->corner_count;
    size_t count = 0;
    unsigned char *all = room(20 * corners + 4);
    uint32_t *sources = room(4 * corners);
    float *normals = room(12 * corners);
    const norma_result result = norma_split(mesh, radians(crease_deg), options,
        (uint32_t *)(void *)all, corners, sources, normals, corners, &count, NULL);
    memcpy(all + 4 * corners, sources, 4 * count);
    memcpy(all + 4 * corners + 4 * count, normals, 12 * count);
    answer(result, all, 4 * corners + 16 * count);
    free(all);
    free(sources);
    free(normals);
}

/* Made at the first half of the positions, updated at the second; of the second half of the
 * vertices as moved, on top of a full update at the first half. */
static void answer_plan(const head *h, const norma_mesh *mesh, const norma_options *options) {
    const size_t half = (size_t)h->position_count / 2, size = h->position_bytes / 2;
    const norma_element of = h->operation == PLAN_VERTICES ? NORMA_PER_VERTEX : NORMA_PER_CORNER;
    const size_t count = of == NORMA_PER_VERTEX ? half : mesh->corner_count;
    norma_mesh made = *mesh;
    made.positions.count = half;
    norma_vec3_view later = made.positions;
    later.data = (const unsigned char *)made.positions.data + size;
    norma_plan *plan = NULL;
    norma_result result = norma_plan_create(&made, of, radians(h->crease_deg), options, &plan);
    float *normals = room(24 * count);
    uint32_t *moved = room(4 * half);
    for (size_t i = half / 2; i < half; ++i) moved[i - half / 2] = (uint32_t)i;
    if (!result) result = norma_plan_update(plan, later, NULL, 0, options, normals, count, NULL);
    if (!result)
        result = norma_plan_update(
            plan, made.positions, NULL, 0, options, normals + 3 * count, count, NULL);
    if (!result)
        result = norma_plan_update(
            plan, later, moved, half - half / 2, options, normals + 3 * count, count, NULL);
    answer(result, normals, 24 * count);
    norma_plan_destroy(plan);
    free(normals);
    free(moved);
}

static void answer_mesh(const head *h, const void *positions) {
    void *corners = h->corner_size ? read_bytes((size_t)h->corner_count * h->corner_size) : NULL;
    const norma_mesh mesh = {
        .positions = {positions, h->position_count, 0, (norma_format)h->format},
        .corners = corners,
        .corner_count = h->corner_count,
        .corner_size = h->corner_size};
    const norma_options options = {.weight = (norma_weight)h->weight,
        .weld = (norma_weld)h->weld,
        .weld_distance = h->weld_distance,
        .non_manifold = (norma_non_manifold)h->non_manifold,
        .fallback = (norma_fallback)h->fallback};
    const size_t most = h->corner_count > h->position_count ? h->corner_count : h->position_count;
    float *normals = room(12 * most);
    if (h->operation == FACES)
        answer(norma_face_normals(&mesh, &options, normals, most, NULL), normals,
            12 * (size_t)(h->corner_count / 3));
    else if (h->operation == VERTICES)
        answer(norma_vertex_normals(&mesh, &options, normals, most, NULL), normals,
            12 * (size_t)h->position_count);
    else if (h->operation == CORNERS)
        answer(norma_corner_normals(&mesh, radians(h->crease_deg), &options, normals, most, NULL),
            normals, 12 * (size_t)h->corner_count);
    else if (h->operation == SPLIT)
        answer_split(&mesh, h->crease_deg, &options);
    else
        answer_plan(h, &mesh, &options);
    free(normals);
    free(corners);
}

static void answer_info(const float *model) {
    norma_matrix_info info;
    float matrix[9];
    const norma_result result = norma_normal_matrix(model, NORMA_WINDING_REVERSED, matrix, &info);
    const double numbers[10] = {info.determinant, info.anisotropy, info.worst_error_rad,
        (double)info.worst_normal[0], (double)info.worst_normal[1], (double)info.worst_normal[2],
        info.kind, info.rank, info.mirrored, norma_matrix_shortcut(&info)};
    answer(result, numbers, sizeof numbers);
}

static void answer_transform(const head *h, const void *vectors) {
    float *matrix = read_bytes(36), *out = room(12 * (size_t)h->position_count);
    answer(norma_transform_normals(matrix,
               (norma_vec3_view){vectors, h->position_count, 0, (norma_format)h->format}, out, 0,
               h->position_count),
        out, 12 * (size_t)h->position_count);
    free(matrix);
    free(out);
}

static void answer_matrices(const head *h, const float *models) {
    const size_t count = h->position_count;
    float *matrices = room(36 * count);
    answer(norma_normal_matrices(models, count, (norma_winding)h->weld, matrices, count), matrices,
        36 * count);
    free(matrices);
}

int main(void) {
    head h;
    while (fread(&h, sizeof h, 1, stdin) == 1) {
        void *first = read_bytes(h.position_bytes);
        if (h.operation == MATRICES)
            answer_matrices(&h, first);
        else if (h.operation == INFO)
            answer_info(first);
        else if (h.operation == TRANSFORM)
            answer_transform(&h, first);
        else
            answer_mesh(&h, first);
        free(first);
    }
    return 0;
}
