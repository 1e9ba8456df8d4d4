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

void norma_big_set(big_number *big, uint64_t value);
void norma_big_multiply_add(big_number *big, uint32_t factor, uint32_t summand);
void norma_big_multiply_power(big_number *big, uint32_t base, int exponent);
void norma_big_shift_left(big_number *big, int bits);
int norma_big_bits(const big_number *big);                       /* number of bits; 0 for zero */
int norma_big_compare(const big_number *a, const big_number *b); /* < 0, 0, > 0 */
void norma_big_subtract(big_number *big, const big_number *smaller); /* smaller <= big */

/* The double nearest to digits * 10^exponent. */
double norma_number_of_decimal(uint64_t digits, int exponent);
#endif
