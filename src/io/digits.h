/* digits.h: decimal digits eight at a time, in one 64-bit word. Little-endian machines only; others go digit by digit. */
#ifndef NORMA_IO_DIGITS_H
#define NORMA_IO_DIGITS_H
#include <stdint.h>
#include <string.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define NORMA_DIGITS_BY_WORD 1

/* The eight bytes at p, which must be there; digits become 0 to 9. */
static inline uint64_t norma_digits_load(const char *p)
{
    uint64_t bytes;
    memcpy(&bytes, p, sizeof bytes);
    return bytes ^ UINT64_C(0x3030303030303030);
}

/* How many of the eight, from the first on, are digits. */
static inline int norma_digits_count(uint64_t bytes)
{
    const uint64_t others = (((bytes & UINT64_C(0x7f7f7f7f7f7f7f7f)) + UINT64_C(0x7676767676767676)) | bytes) & UINT64_C(0x8080808080808080);
    return others ? __builtin_ctzll(others) / 8 : 8;
}

/* The number that the first count of them make, 1 to 8: neighbours are joined to two digits, then four, then eight. */
static inline uint64_t norma_digits_join(uint64_t bytes, int count)
{
    bytes <<= 64 - 8 * count;
    bytes = 10 * bytes + (bytes >> 8);
    return ((bytes & UINT64_C(0x000000ff000000ff)) * UINT64_C(0x000f424000000064) + (bytes >> 16 & UINT64_C(0x000000ff000000ff)) * UINT64_C(0x0000271000000001)) >> 32;
}
#else
#define NORMA_DIGITS_BY_WORD 0
#endif
#endif
