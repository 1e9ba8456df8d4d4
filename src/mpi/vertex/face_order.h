/* face_order.h: the faces of a part in ascending global number. */
#ifndef NORMA_MPI_FACE_ORDER_H
#define NORMA_MPI_FACE_ORDER_H
#include "core/call/call.h"

typedef struct mpi_face_order {
    const uint64_t *ids; /* of each face, or NULL: they follow one another from first on */
    uint64_t first;
    uint32_t *order; /* NULL: they ascend as they are */
    size_t count;
} mpi_face_order;

/* MEMORY leaves nothing to close. */
norma_result norma_mpi_order_faces(
    const core_call *call, const uint64_t *ids, size_t count, mpi_face_order *order);
void norma_mpi_order_close(const core_call *call, mpi_face_order *order);

static inline size_t norma_mpi_face(const mpi_face_order *order, size_t i) {
    return order->order ? order->order[i] : i;
}
static inline uint64_t norma_mpi_face_id(const mpi_face_order *order, size_t face) {
    return order->ids ? order->ids[face] : order->first + face;
}
#endif
