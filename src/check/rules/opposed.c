/* opposed.c: which faces have normals on their other side at every corner, for the rules on normals
 * against faces. */
#include "check/rules/facing.h"
#include <string.h>

enum { FACES_IN_BLOCK = 1 << 13 };
static const double ACROSS = 1e-6; /* a normal along its face, up to rounding, opposes nothing */

typedef struct facing_part {
    double opposed_area; /* twice */
    size_t opposed, far;
} facing_part;

typedef struct facing_pass {
    const check_mesh *m;
    double across;
    facing_part *parts;
} facing_pass;

double norma_check_greatest_cosine(const check_mesh *m, size_t face, size_t *far) {
    double greatest = -2;
    int whole = 1;
    for (size_t c = norma_core_face_begin(&m->mesh, face); c < norma_core_face_end(&m->mesh, face);
         c++) {
        const size_t number = norma_check_normal_of(m, face, c);
        const double cosine = norma_check_cosine_to(m, face, number);
        if (cosine < CHECK_FAR_COSINE) {
            ++*far;
            atomic_store_explicit(&m->far[number], 1, memory_order_relaxed);
        }
        whole &= !isnan(cosine);
        greatest = cosine > greatest ? cosine : greatest;
    }
    return whole ? greatest : NAN;
}

static void judge_faces(void *context, size_t block, size_t begin, size_t end) {
    const facing_pass *pass = context;
    const check_mesh *m = pass->m;
    facing_part *part = &pass->parts[block];
    for (size_t f = begin; f < end; f++) {
        m->opposed[f] = 0;
        if (!norma_check_directed(&m->faces[f]) || norma_check_is_sliver(&m->faces[f])) continue;
        const double greatest = norma_check_greatest_cosine(m, f, &part->far);
        if (!(greatest < -pass->across) || greatest < -1.5) continue;
        m->opposed[f] = 1;
        part->opposed++;
        part->opposed_area += norma_check_twice_area(m, f);
    }
}

norma_result norma_check_opposed(check_mesh *m) {
    const size_t blocks = norma_check_block_count(m->mesh.face_count, FACES_IN_BLOCK);
    if (m->opposed) return NORMA_OK;
    norma_result result = norma_check_faces(m);
    if (!result) result = norma_check_users(m);
    if (result) return result;
    facing_pass pass = {m, fmax(ACROSS, norma_check_encoding_bound(m->given->info.encoding)),
        norma_core_allocate(&m->run->call, blocks, sizeof *pass.parts)};
    m->opposed = norma_core_allocate(&m->run->call, m->mesh.face_count, 1);
    m->far = norma_core_allocate(&m->run->call, norma_check_normal_count(m), sizeof *m->far);
    result = pass.parts && m->opposed && m->far ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        memset((void *)m->far, 0, norma_check_normal_count(m) * sizeof *m->far);
        memset(pass.parts, 0, blocks * sizeof *pass.parts);
        result = norma_check_blocks(m->run, m->mesh.face_count, FACES_IN_BLOCK, judge_faces, &pass);
    }
    for (size_t i = 0; !result && i < blocks; i++) {
        m->opposed_count += pass.parts[i].opposed;
        m->opposed_area += pass.parts[i].opposed_area;
        m->far_count += pass.parts[i].far;
    }
    norma_core_release(&m->run->call, pass.parts, blocks, sizeof *pass.parts);
    return result;
}
