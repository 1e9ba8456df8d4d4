/* scattered.c: positions and corners copied into memory of our own, whose pages are large where the system has such. */
#include "scattered.h"

enum { IN_CHUNK = 1 << 16, FEWEST_TO_COPY = 1 << 19 };    /* fewer are found in the tables of pages that processors keep */

static const size_t TIGHT = 3 * sizeof(float);

/* Of faces in a row in a mesh in some order, the positions span little of it; of one in none, nearly all. */
int norma_core_is_scattered(const core_mesh *mesh)
{
    enum { LOOKS = 32, CORNERS_IN_LOOK = 96, FEWEST_SPANS = 8 };
    const size_t count = mesh->corner_count;
    double sum = 0;
    if (mesh->face_starts || count < (size_t)LOOKS * CORNERS_IN_LOOK) return 0;
    for (size_t look = 0; look < LOOKS; look++) {
        const size_t begin = (count - CORNERS_IN_LOOK) / LOOKS * look;
        uint32_t least = UINT32_MAX, most = 0;
        for (size_t c = begin; c < begin + CORNERS_IN_LOOK; c++) {
            const uint32_t at = norma_core_corner(mesh, c);
            least = at < least ? at : least;
            most = at > most ? at : most;
        }
        sum += (double)(most - least);
    }
    return FEWEST_SPANS * sum > (double)LOOKS * (double)mesh->positions.count;
}

/* ---- copies */

typedef struct copying {
    const unsigned char *from;
    unsigned char       *to;
    size_t               count, stride;                   /* things of three numbers; what they are apart in from */
} copying;

static void copy_chunk(void *context, size_t chunk)
{
    const copying *work = context;
    const size_t begin = chunk * IN_CHUNK, end = work->count - begin < IN_CHUNK ? work->count : begin + IN_CHUNK;
    const unsigned char *from = work->from + begin * work->stride;
    unsigned char *to = work->to + begin * TIGHT;
    if (work->stride == TIGHT) memcpy(to, from, (end - begin) * TIGHT);
    else
        for (size_t i = begin; i < end; i++, from += work->stride, to += TIGHT) memcpy(to, from, TIGHT);
}

/* NULL where there is no memory: then what the caller has must do. */
static norma_result copy(core_call *call, const void *from, size_t count, size_t stride, void **to)
{
    copying work = {from, norma_core_allocate(call, count, TIGHT), count, stride};
    norma_result result = NORMA_OK;
    if (work.to) result = norma_core_parallel(call, count / IN_CHUNK + (count % IN_CHUNK != 0), copy_chunk, &work);
    if (result != NORMA_OK) norma_core_release(call, work.to, count, TIGHT);
    *to = result == NORMA_OK ? work.to : NULL;
    return result;
}

norma_result norma_core_copy_scattered(core_call *call, const core_mesh *mesh, core_copied what, core_mesh *own)
{
    const size_t positions = mesh->positions.count, faces = mesh->face_count;
    void *to = NULL;
    norma_result result = NORMA_OK;
    *own = *mesh;
    if (mesh->positions.format == NORMA_FORMAT_FLOAT && positions >= FEWEST_TO_COPY) result = copy(call, mesh->positions.data, positions, mesh->positions.stride, &to);
    if (to) {
        own->positions.data = to;
        own->positions.stride = TIGHT;
    }
    to = NULL;
    if (result == NORMA_OK && what == CORE_COPY_CORNERS_TOO && mesh->corner_size == sizeof(uint32_t) && faces >= FEWEST_TO_COPY) result = copy(call, mesh->corners, faces, TIGHT, &to);
    if (to) own->corners = to;
    if (result != NORMA_OK) norma_core_release_scattered(call, mesh, own);
    return result;
}

void norma_core_release_scattered(const core_call *call, const core_mesh *mesh, core_mesh *own)
{
    if (own->positions.data != mesh->positions.data) norma_core_release(call, (void *)(uintptr_t)own->positions.data, mesh->positions.count, TIGHT);
    if (own->corners != mesh->corners) norma_core_release(call, (void *)(uintptr_t)own->corners, mesh->face_count, TIGHT);
    own->positions = mesh->positions;
    own->corners = mesh->corners;
}
