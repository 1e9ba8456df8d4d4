/* number_big.h: positive integers of up to 8192 bits, as much as converting doubles to decimal and
 * back needs. Internal to number_*.c. */
#ifndef NORMA_IO_NUMBER_BIG_H
#define NORMA_IO_NUMBER_BIG_H
#include <stddef.h>
#include <stdint.h>

enum { BIG_LIMBS = 256 };
typedef struct big_number {
    uint32_t limb[BIG_LIMBS]; /* least first */
    int count;                /* without zeros at the top; 0: zero */
} big_number;

/* The double nearest to digits * 10^exponent. */
#endif
