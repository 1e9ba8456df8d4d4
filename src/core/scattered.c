/* scattered.c: positions copied into memory of our own, whose pages are large where the system has such. */
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

typedef struct copying { const norma_vec3_view *from; unsigned char *to; } copying;

static void copy_chunk(void *context, size_t chunk)
{
    const copying *work = context;
    const norma_vec3_view *in = work->from;
    const size_t begin = chunk * IN_CHUNK, end = in->count - begin < IN_CHUNK ? in->count : begin + IN_CHUNK;
    const unsigned char *from = (const unsigned char *)in->data + begin * in->stride;
    unsigned char *to = work->to + begin * TIGHT;
    if (in->stride == TIGHT) memcpy(to, from, (end - begin) * TIGHT);
    else
        for (size_t i = begin; i < end; i++, from += in->stride, to += TIGHT) memcpy(to, from, TIGHT);
}

norma_result norma_core_copy_scattered(core_call *call, const core_mesh *mesh, core_mesh *own)
{
    const size_t count = mesh->positions.count;
    *own = *mesh;
    if (mesh->positions.format != NORMA_FORMAT_FLOAT || count < FEWEST_TO_COPY) return NORMA_OK;
    copying work = {&mesh->positions, norma_core_allocate(call, count, TIGHT)};
    if (!work.to) return NORMA_OK;
    own->positions.data = work.to;
    own->positions.stride = TIGHT;
    const norma_result result = norma_core_parallel(call, count / IN_CHUNK + (count % IN_CHUNK != 0), copy_chunk, &work);
    if (result != NORMA_OK) norma_core_release_scattered(call, mesh, own);
    return result;
}

void norma_core_release_scattered(const core_call *call, const core_mesh *mesh, core_mesh *own)
{
    if (own->positions.data != mesh->positions.data) norma_core_release(call, (void *)(uintptr_t)own->positions.data, mesh->positions.count, TIGHT);
    own->positions = mesh->positions;
}
