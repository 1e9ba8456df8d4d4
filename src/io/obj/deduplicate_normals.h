/* deduplicate_normals.h: equal normals are one, numbered in the order of their first use. Internal
 * to obj_compute.c and deduplicate_normals.c. */
#ifndef NORMA_IO_OBJ_NUMBER_H
#define NORMA_IO_OBJ_NUMBER_H
#include <norma/norma.h>

typedef struct obj_numbering {
    const float *normals; /* of elements, three each */
    size_t element_count;
    uint32_t *order;              /* elements in the order of first use; NULL: all, as they are */
    size_t count;                 /* of the order */
    const norma_options *options; /* threads, and who may cancel */
    /* found */
    uint32_t *numbers; /* of each element in the order; of others undefined */
    float *unique;     /* each normal once, by its number */
    size_t unique_count;
} obj_numbering;

typedef enum obj_numbered {
    OBJ_NUMBERED = 0,
    OBJ_NUMBERED_CANCELLED,
    OBJ_NUMBERED_MEMORY
} obj_numbered;

/* What it found is the caller's to free. */
obj_numbered norma_obj_number(obj_numbering *numbering);
#endif
