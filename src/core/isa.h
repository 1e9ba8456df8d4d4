/* isa.h: which instruction sets this machine runs. Every one gives the bits of the portable C code. */
#ifndef NORMA_CORE_ISA_H
#define NORMA_CORE_ISA_H
#include <norma/norma.h>

int norma_core_has_isa(norma_isa isa);
#endif
