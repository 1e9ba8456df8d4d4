/* acid_labels.h: words as triangles. */
#ifndef NORMA_ACID_LABELS_H
#define NORMA_ACID_LABELS_H
#include "acid/acid_mesh.h"

typedef struct acid_ink {
    float *positions; /* three each, four for a stroke */
    uint16_t *indices;
    size_t strokes, capacity;
    int failed;
} acid_ink;

/* A line of ASCII from (x, y), its base line; size: the height of capitals. */
void acid_write_words(acid_ink *ink, const char *text, double x, double y, double size);
/* Lines broken behind hyphens, none wider than width where that can be. */
void acid_write_lines(
    acid_ink *ink, const char *text, double x, double y, double size, double width);
void acid_free_ink(acid_ink *ink);
#endif
