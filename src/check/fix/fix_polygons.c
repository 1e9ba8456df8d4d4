/* fix_polygons.c: polygons that readers would cut wrong or differently (N404, N405) are cut into
 * triangles that do not fold (core/face/cut_polygon.h). Polygons that cross themselves have no such
 * triangles and stay as they are. */
#include "check/fix/fix.h"
#include "core/face/cut_polygon.h"
#include <stdlib.h>
#include <string.h>

/* triangles: corners of count - 2 triangles, numbered from the first of the face. 0: the face
 * cannot be cut well, or not in time. */
static int cut_face(const fix_mesh *m, size_t face, core_cutter *cutter, uint32_t *triangles) {
    const size_t begin = norma_core_face_begin(&m->mesh, face),
                 count = norma_core_face_end(&m->mesh, face) - begin;
    for (size_t i = 0; i < count; i++)
        norma_core_position(&m->mesh, norma_core_corner(&m->mesh, begin + i), cutter->points[i]);
    return count > 3 && norma_core_cut_polygon(cutter, count, triangles) == count - 2;
}

static size_t largest_face(const core_mesh *mesh) {
    size_t largest = 0;
    for (size_t face = 0; face < mesh->face_count; face++) {
        const size_t corners = norma_core_face_end(mesh, face) - norma_core_face_begin(mesh, face);
        largest = corners > largest ? corners : largest;
    }
    return largest;
}

static norma_result cut_named(fix_mesh *m, const uint8_t *marks) {
    const size_t largest = largest_face(&m->mesh);
    core_cutter cutter;
    void *memory = malloc(norma_core_cutter_size(largest));
    uint8_t *cut = calloc(m->mesh.face_count + 1, 1);
    uint32_t *triangles = calloc(3 * m->mesh.corner_count + 1, sizeof *triangles);
    const int fine = memory && cut && triangles;
    int any = 0;
    if (fine) norma_core_cutter_begin(&cutter, memory, largest, m->mesh.corner_count);
    for (size_t face = 0; face < m->mesh.face_count && fine; face++)
        if (marks[face] && !(m->edit->drop_faces && m->edit->drop_faces[face]))
            any |= cut[face] = (uint8_t)cut_face(
                m, face, &cutter, triangles + 3 * norma_core_face_begin(&m->mesh, face));
    if (any) {
        m->edit->cut_faces = cut;
        m->edit->cut_corners = triangles;
    } else {
        free(cut);
        free(triangles);
    }
    free(memory);
    return fine ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* Where faces are reversed as well, that comes first: the cut waits for the next time. */
norma_result norma_fix_polygons(fix_mesh *m) {
    uint8_t *marks = NULL;
    const norma_file_format format = norma_document_format(m->document);
    if (m->edit->reverse_faces || (format != NORMA_FILE_OBJ && format != NORMA_FILE_PLY))
        return NORMA_OK;
    int folded = norma_fix_mark(m, RULE_N404, MEND_FACE, m->mesh.face_count, &marks);
    int bent =
        folded < 0 ? folded : norma_fix_mark(m, RULE_N405, MEND_FACE, m->mesh.face_count, &marks);
    norma_result result = folded < 0 || bent < 0 ? NORMA_ERROR_MEMORY
                          : folded || bent       ? cut_named(m, marks)
                                                 : NORMA_OK;
    free(marks);
    return result;
}
