/* mikk_follow.c: triangles without texture area take the sign of the first group that reaches them.
 * Groups come in the order of their first corner; a group spreads from there along the links first
 * to the left, then to the right. Only at vertices of such triangles does this order matter, and
 * only there are groups looked for here. */
#include "core/tangent/mikk.h"

typedef struct following {
    mikk_mesh *mesh;
    uint8_t *touched;       /* of each vertex: such a triangle is there */
    uint32_t *left, *right; /* of each corner at a touched vertex: another corner */
    uint8_t *grouped;       /* of each corner */
    mikk_links links;       /* room for one star */
    uint32_t *next, *previous;
    mikk_edge_table table;
} following;

/* Returns how many corners there are at touched vertices at most in one. */
static size_t touch(following *f) {
    const mikk_mesh *m = f->mesh;
    size_t most = 0;
    memset(f->touched, 0, m->vertex_count);
    for (size_t t = 0; t < m->count; t++)
        for (size_t i = 0; (m->flags[t] & MIKK_FOLLOWS) && i < 3; i++) {
            const uint32_t v = m->triangles[3 * t + i];
            const size_t count = m->around.starts[v + 1] - m->around.starts[v];
            f->touched[v] = 1;
            if (count > most) most = count;
        }
    return most;
}

static uint32_t neighbour(const uint32_t *triangles, uint32_t corner, uint32_t by) {
    return triangles[corner - corner % 3 + (corner + by) % 3];
}

/* From numbers in the star to corners of triangles. */
static void link_star(following *f, uint32_t vertex) {
    const mikk_mesh *m = f->mesh;
    const uint32_t *corners = m->around.corners + m->around.starts[vertex];
    const size_t count = m->around.starts[vertex + 1] - m->around.starts[vertex];
    for (size_t j = 0; j < count; j++) {
        f->next[j] = neighbour(m->triangles, corners[j], 1);
        f->previous[j] = neighbour(m->triangles, corners[j], 2);
    }
    norma_core_mikk_link(f->next, f->previous, count, &f->table, &f->links);
    for (size_t j = 0; j < count; j++) {
        const uint32_t left = f->links.left[j], right = f->links.right[j];
        f->left[corners[j]] = left == MIKK_NONE ? MIKK_NONE : corners[left];
        f->right[corners[j]] = right == MIKK_NONE ? MIKK_NONE : corners[right];
    }
}

/* Along one of the two lists of links, until a triangle is of the other sign. */
static void spread(following *f, const uint32_t *links, uint32_t seed) {
    uint8_t *flags = f->mesh->flags;
    const uint8_t sign = flags[seed / 3] & MIKK_POSITIVE;
    for (uint32_t c = links[seed]; c != MIKK_NONE && !f->grouped[c]; c = links[c]) {
        uint8_t *flag = &flags[c / 3];
        if ((*flag & MIKK_FOLLOWS) && !(*flag & MIKK_FOLLOWED))
            *flag = (uint8_t)((*flag & ~MIKK_POSITIVE) | sign | MIKK_FOLLOWED);
        if ((*flag & MIKK_POSITIVE) != sign) return;
        f->grouped[c] = 1;
    }
}

static void spread_all(following *f) {
    const mikk_mesh *m = f->mesh;
    memset(f->grouped, 0, 3 * m->count);
    for (uint32_t c = 0; c < 3 * m->count; c++) {
        if (!f->touched[m->triangles[c]] || f->grouped[c] || (m->flags[c / 3] & MIKK_FOLLOWS))
            continue;
        f->grouped[c] = 1;
        spread(f, f->left, c);
        spread(f, f->right, c);
    }
}

/* Records have the signs that were found, too. */
static void mark_records(const mikk_mesh *m) {
    for (size_t t = 0; m->records && t < m->count; t++)
        for (size_t i = 0; (m->flags[t] & MIKK_FOLLOWS) && i < 3; i++)
            m->records[3 * t + i].flags = m->flags[t];
}

static norma_result follow(following *f) {
    mikk_mesh *m = f->mesh;
    const core_call *call = m->call;
    const size_t corners = 3 * m->count, most = touch(f);
    f->left = norma_core_allocate(call, corners, sizeof *f->left);
    f->right = norma_core_allocate(call, corners, sizeof *f->right);
    f->grouped = norma_core_allocate(call, corners, 1);
    uint32_t *star = norma_core_allocate(call, 4 * most, sizeof *star);
    norma_result result = norma_core_mikk_table_open(call, most, &f->table);
    if (!f->left || !f->right || !f->grouped || !star) result = NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) {
        f->links = (mikk_links){star, star + most};
        f->next = star + 2 * most;
        f->previous = star + 3 * most;
        for (size_t v = 0; v < m->vertex_count; v++)
            if (f->touched[v]) link_star(f, (uint32_t)v);
        spread_all(f);
        mark_records(m);
    }
    norma_core_mikk_table_close(call, most, &f->table);
    norma_core_release(call, star, 4 * most, sizeof *star);
    norma_core_release(call, f->left, corners, sizeof *f->left);
    norma_core_release(call, f->right, corners, sizeof *f->right);
    norma_core_release(call, f->grouped, corners, 1);
    return result;
}

norma_result norma_core_mikk_follow(mikk_mesh *m) {
    int any = 0;
    for (size_t t = 0; t < m->count; t++) any |= m->flags[t] & MIKK_FOLLOWS;
    if (!any) return NORMA_OK;
    following f = {.mesh = m, .touched = norma_core_allocate(m->call, m->vertex_count, 1)};
    const norma_result result = f.touched ? follow(&f) : NORMA_ERROR_MEMORY;
    norma_core_release(m->call, f.touched, m->vertex_count, 1);
    return result;
}
