/* twin_key.c: the kept corners are hashed in a row, forwards and backwards, from each of them on:
 * rolling hashes (Karp, Rabin 1987), since the hash of a row that begins one corner later follows
 * in a few operations. The sums over all beginnings do not depend on where the face begins; the two
 * change places in its reversed twin. */
#include "core/face/twin_key.h"

static const uint64_t BASE = UINT64_C(0x9e3779b97f4a7c15), INVERSE = UINT64_C(0xf1de83e19937733d);
_Static_assert(UINT64_C(0x9e3779b97f4a7c15) * UINT64_C(0xf1de83e19937733d) == 1,
    "modulo 2^64, one undoes the other");

static uint64_t mix(uint64_t h) {
    h = (h ^ (h >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    h = (h ^ (h >> 27)) * UINT64_C(0x94d049bb133111eb);
    return h ^ (h >> 31);
}

static uint64_t hash_of(uint32_t welded) { return mix((uint64_t)welded + 1); }

/* Of so many kept corners the hashes are remembered. */
enum { FEW = 8 };

typedef struct row {
    uint64_t ahead, back, power, sum_ahead, sum_back;
} row;

static void add_corner(row *r, uint64_t hash) {
    r->ahead = r->ahead * BASE + hash;
    r->back += hash * r->power;
    r->power *= BASE;
}

/* The first corner moves from the row's begin to its end. */
static void begin_later(row *r, uint64_t hash) {
    const uint64_t moved = hash * (1 - r->power);
    r->sum_ahead += mix(r->ahead);
    r->sum_back += mix(r->back);
    r->ahead = r->ahead * BASE + moved;
    r->back = (r->back - moved) * INVERSE;
}

uint64_t norma_core_twin_key(const core_mesh *mesh, size_t face) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    uint64_t hashes[FEW];
    size_t kept = 0;
    row r = {.power = 1};
    uint32_t here = begin < end ? norma_core_welded_corner(mesh, begin) : 0;
    for (size_t c = begin; c < end; c++) {
        const uint32_t next =
            norma_core_welded_corner(mesh, norma_core_next_in_face(mesh, face, c));
        if (here != next) { /* it is kept */
            const uint64_t hash = hash_of(here);
            if (kept < FEW) hashes[kept] = hash;
            kept++;
            add_corner(&r, hash);
        }
        here = next;
    }
    for (size_t i = 0; i < kept && kept <= FEW; i++) begin_later(&r, hashes[i]);
    for (size_t c = begin; c < end && kept > FEW; c++)
        if (norma_core_is_kept(mesh, face, c))
            begin_later(&r, hash_of(norma_core_welded_corner(mesh, c)));
    const uint64_t way = r.sum_ahead == r.sum_back ? 2 : r.sum_ahead > r.sum_back;
    return ((r.sum_ahead + r.sum_back) & ~(uint64_t)CORE_KEY_WAY) | way;
}
