/* scattered_positions.c: positions copied into memory of our own, whose pages are large where the
 * system has such. */
#include "core/mesh/scattered_positions.h"

enum {
    IN_CHUNK = 1 << 16,
    FEWEST_TO_COPY = 1 << 19
}; /* fewer are found in the tables of pages that processors keep */

static const size_t TIGHT = 3 * sizeof(float);

static uint32_t distance(uint32_t a, uint32_t b) { return a < b ? b - a : a - b; }

/* How far the corners of some faces in a row lie from the nearest of the faces before: two to four
 * corners back, so that one vertex of all faces is not far from itself. */
static double look_at(const core_mesh *mesh, size_t begin, size_t count) {
    uint32_t at[4];
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        const uint32_t here = norma_core_corner(mesh, begin + i);
        uint32_t nearest = i < 4 ? 0 : UINT32_MAX;
        for (size_t back = 2; back <= 4 && i >= 4; back++) {
            const uint32_t found = distance(here, at[(i - back) % 4]);
            nearest = found < nearest ? found : nearest;
        }
        at[i % 4] = here;
        sum += (double)nearest;
    }
    return sum;
}

/* Of faces in a row in a mesh in some order, corners lie near those before; in one in none, an
 * eighth of all positions away. The bound is an eighth of that. */
int norma_core_is_scattered(const core_mesh *mesh) {
    enum { LOOKS = 32, CORNERS_IN_LOOK = 96, FARTHEST = 64 };
    const size_t count = mesh->corner_count;
    double sum = 0;
    if (count < (size_t)LOOKS * CORNERS_IN_LOOK) return 0;
    for (size_t look = 0; look < LOOKS; look++)
        sum += look_at(mesh, (count - CORNERS_IN_LOOK) / LOOKS * look, CORNERS_IN_LOOK);
    return FARTHEST * sum > (double)LOOKS * CORNERS_IN_LOOK * (double)mesh->positions.count;
}

/* ---- copies */

typedef struct copying {
    const norma_vec3_view *from;
    unsigned char *to;
} copying;

static void copy_chunk(void *context, size_t chunk) {
    const copying *work = context;
    const norma_vec3_view *in = work->from;
    const size_t begin = chunk * IN_CHUNK,
                 end = in->count - begin < IN_CHUNK ? in->count : begin + IN_CHUNK;
    const unsigned char *from = (const unsigned char *)in->data + begin * in->stride;
    unsigned char *to = work->to + begin * TIGHT;
    if (in->stride == TIGHT)
        memcpy(to, from, (end - begin) * TIGHT);
    else
        for (size_t i = begin; i < end; i++, from += in->stride, to += TIGHT)
            memcpy(to, from, TIGHT);
}

norma_result norma_core_copy_scattered(core_call *call, const core_mesh *mesh, core_mesh *own) {
    const size_t count = mesh->positions.count;
    *own = *mesh;
    if (mesh->positions.format != NORMA_FORMAT_FLOAT || count < FEWEST_TO_COPY) return NORMA_OK;
    copying work = {&mesh->positions, norma_core_allocate(call, count, TIGHT)};
    if (!work.to) return NORMA_OK;
    own->positions.data = work.to;
    own->positions.stride = TIGHT;
    const norma_result result =
        norma_core_parallel(call, count / IN_CHUNK + (count % IN_CHUNK != 0), copy_chunk, &work);
    if (result != NORMA_OK) norma_core_release_scattered(call, mesh, own);
    return result;
}

void norma_core_release_scattered(const core_call *call, const core_mesh *mesh, core_mesh *own) {
    if (own->positions.data != mesh->positions.data)
        norma_core_release(
            call, (void *)(uintptr_t)own->positions.data, mesh->positions.count, TIGHT);
    own->positions = mesh->positions;
}
