/* limits.c: how much a file may stand for. Elements that share bytes (many primitives of one
 * accessor, accessors that overlap, accessors without bytes) let a few kilobytes name more
 * triangles than a machine holds; so what is decoded, copied and drawn is measured by the bytes
 * that the file and its buffers hold. */
#include "io/gltf/asset.h"

enum {
    DECODED_A_BYTE = 256,
    CORNERS_A_BYTE = 16,
    VERTICES_A_BYTE = 64,
    MOVES_A_BYTE = 16,
    INSTANCES_A_BYTE = 4,
    COPIED_A_BYTE = 512,
    FREE = 1 << 18,
    FREE_INSTANCES = 1 << 16
};

/* Whether sum stays within the bound when more is added to it; never wraps. */
static int add_within(size_t *sum, size_t more, size_t held, size_t a_byte, size_t granted) {
    const size_t bound = held > (SIZE_MAX - granted) / a_byte ? SIZE_MAX : held * a_byte + granted;
    if (more > bound || *sum > bound - more) return 0;
    *sum += more;
    return 1;
}

norma_document_result norma_gltf_spend(
    gltf *g, uint32_t token, size_t count, size_t size, norma_document_error *error) {
    char place[200];
    if (count <= SIZE_MAX / size &&
        add_within(&g->decoded, count * size, g->held, DECODED_A_BYTE, FREE))
        return NORMA_DOCUMENT_OK;
    norma_gltf_pointer(g, token, place, sizeof place);
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, place,
        "%zu elements from here, with all before them, would take far more memory than the file; "
        "at most %d bytes are read for each byte of it",
        count, DECODED_A_BYTE);
}

norma_document_result norma_gltf_draw(
    gltf *g, const gltf_primitive *p, norma_document_error *error) {
    const size_t corners = p->faces > SIZE_MAX / 3 ? SIZE_MAX : 3 * p->faces,
                 targets = p->target_count,
                 moves =
                     targets && p->vertices > SIZE_MAX / targets ? SIZE_MAX : p->vertices * targets;
    if (!add_within(&g->corners_drawn, corners, g->held, CORNERS_A_BYTE, FREE) ||
        !add_within(&g->vertices_drawn, p->vertices, g->held, VERTICES_A_BYTE, FREE))
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, p->where,
            "%zu triangles of %zu vertices, with those of all primitives before, are far more than "
            "the file has bytes; at most %d corners and %d vertices are read for each byte",
            p->faces, p->vertices, CORNERS_A_BYTE, VERTICES_A_BYTE);
    if (!add_within(&g->vertices_moved, moves, g->held, MOVES_A_BYTE, FREE))
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, p->where,
            "%zu vertices in each of %zu morph targets, with those of all primitives before, are "
            "far more than the file has bytes; at most %d are read for each byte",
            p->vertices, targets, MOVES_A_BYTE);
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_copy_vertices(
    gltf *g, gltf_primitive *p, size_t count, size_t size, norma_document_error *error) {
    g->copied -= p->copied;
    p->copied = 0;
    if ((size && count > SIZE_MAX / size) ||
        !add_within(&g->copied, count * size, g->held, COPIED_A_BYTE, FREE))
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, p->where,
            "%zu vertices of %zu bytes each, with those of all primitives before, would take far "
            "more memory than the file; at most %d bytes are read for each byte of it",
            count, size, COPIED_A_BYTE);
    p->copied = count * size;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_place_instances(
    gltf *g, const gltf_node *node, norma_document_error *error) {
    char place[200];
    size_t held = g->document->source.size;
    for (uint32_t i = 0; i < g->buffer_count; ++i) /* as long as they say: none of them is read yet,
                                                      and one that is shorter will not be */
        held = g->buffers[i].length < SIZE_MAX - held ? held + g->buffers[i].length : SIZE_MAX;
    if (add_within(&g->instances_placed, node->instances, held, INSTANCES_A_BYTE, FREE_INSTANCES))
        return NORMA_DOCUMENT_OK;
    norma_gltf_pointer(g, node->token, place, sizeof place);
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, place,
        "%zu instances, with those of all nodes before, are far more than the file has bytes; at "
        "most %d are read for each byte",
        node->instances, INSTANCES_A_BYTE);
}
