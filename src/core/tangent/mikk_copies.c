/* mikk_copies.c: corners that no triangle holds, because their triangles are degenerate: which
 * corner of a triangle each copies. A quad of one good triangle copies the corner of that triangle
 * that lies at the same position; all others the first corner at their vertex. */
#include "core/tangent/mikk.h"

/* Of a face, the corner that no triangle holds, if there is just one; else SIZE_MAX. */
static size_t only_missing(const uint32_t *holders, size_t begin, size_t end) {
    size_t missing = SIZE_MAX, count = 0;
    for (size_t c = begin; c < end; c++)
        if (holders[c] == MIKK_NONE) {
            missing = c;
            count++;
        }
    return count == 1 ? missing : SIZE_MAX;
}

static uint32_t source_in_quad(
    const mikk_mesh *m, const uint32_t *holders, size_t begin, size_t missing) {
    const tangent_mesh *in = m->input;
    const float *at = in->vertices[norma_core_tangent_key(in, missing)].position;
    for (size_t c = begin; c < begin + 4; c++) {
        const float *p = in->vertices[norma_core_tangent_key(in, c)].position;
        if (c != missing && p[0] == at[0] && p[1] == at[1] && p[2] == at[2]) return holders[c];
    }
    return MIKK_NONE;
}

typedef void see_copy(mikk_mesh *m, uint32_t vertex, mikk_copy copy);

static void for_copies(mikk_mesh *m, const uint32_t *holders, see_copy *see) {
    const core_mesh *mesh = &m->input->mesh;
    for (size_t face = 0; face < mesh->face_count; face++) {
        const size_t begin = norma_core_face_begin(mesh, face),
                     end = norma_core_face_end(mesh, face),
                     missing = end - begin == 4 ? only_missing(holders, begin, end) : SIZE_MAX;
        for (size_t c = begin; c < end; c++) {
            if (holders[c] != MIKK_NONE) continue;
            const uint32_t source = c == missing ? source_in_quad(m, holders, begin, c) : MIKK_NONE;
            const uint32_t vertex =
                source == MIKK_NONE ? norma_core_tangent_vertex(m->input, c) : m->triangles[source];
            see(m, vertex, (mikk_copy){source, (uint32_t)c});
        }
    }
}

static void count_copy(mikk_mesh *m, uint32_t vertex, mikk_copy copy) {
    (void)copy;
    m->copy_starts[vertex]++;
}

static void place_copy(mikk_mesh *m, uint32_t vertex, mikk_copy copy) {
    m->copies[--m->copy_starts[vertex]] = copy;
}

norma_result norma_core_mikk_copies(mikk_mesh *m, const uint32_t *holders) {
    const size_t corners = m->input->mesh.corner_count;
    for (size_t c = 0; c < corners; c++) m->copy_count += holders[c] == MIKK_NONE;
    if (!m->copy_count) return NORMA_OK;
    m->copy_starts = norma_core_allocate(m->call, m->vertex_count + 1, sizeof *m->copy_starts);
    m->copies = norma_core_allocate(m->call, m->copy_count, sizeof *m->copies);
    if (!m->copy_starts || !m->copies) return NORMA_ERROR_MEMORY;
    memset(m->copy_starts, 0, (m->vertex_count + 1) * sizeof *m->copy_starts);
    for_copies(m, holders, count_copy);
    uint32_t sum = 0;
    for (size_t v = 0; v <= m->vertex_count; v++) m->copy_starts[v] = sum += m->copy_starts[v];
    for_copies(m, holders, place_copy);
    return NORMA_OK;
}
