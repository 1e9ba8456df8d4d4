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

static uint64_t hash_of(const core_mesh *mesh, size_t corner) {
    return mix((uint64_t)norma_core_welded_corner(mesh, corner) + 1);
}

uint64_t norma_core_twin_key(const core_mesh *mesh, size_t face) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    uint64_t ahead = 0, back = 0, power = 1, sum_ahead = 0, sum_back = 0;
    for (size_t c = begin; c < end; c++) {
        if (!norma_core_is_kept(mesh, face, c)) continue;
        const uint64_t hash = hash_of(mesh, c);
        ahead = ahead * BASE + hash;
        back += hash * power;
        power *= BASE;
    }
    for (size_t c = begin; c < end; c++) {
        if (!norma_core_is_kept(mesh, face, c)) continue;
        const uint64_t moved = hash_of(mesh, c) * (1 - power); /* from the row's begin to its end */
        sum_ahead += mix(ahead);
        sum_back += mix(back);
        ahead = ahead * BASE + moved;
        back = (back - moved) * INVERSE;
    }
    const uint64_t way = sum_ahead == sum_back ? 2 : sum_ahead > sum_back;
    return ((sum_ahead + sum_back) & ~(uint64_t)CORE_KEY_WAY) | way;
}
