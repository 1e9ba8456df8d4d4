#!/bin/bash
# The core as one file: builds alone with both compilers, and gives the library's bits.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1

check "scripts/single.sh writes norma.c and norma.h" scripts/single.sh "$scratch/single"
cd "$scratch/single" || exit 1
sed 's#<norma/norma.h>#"norma.h"#' "$root/tests/repo/consumer/core.c" >program.c
mkdir -p "$scratch/library"
check "the same program builds against the library" gcc -std=c11 -I"$root/include" "$root/tests/repo/consumer/core.c" -o "$scratch/library/program" "$tree/lib/libnorma.a" -lm -pthread
"$scratch/library/program" >"$scratch/library/output"
for compiler in gcc clang; do
    check "$compiler: norma.c compiles with warnings as errors" $compiler -std=c11 -O2 -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror -Wno-unused-function -c norma.c -o "norma-$compiler.o"
    check "$compiler: a program of norma.c builds" $compiler -std=c11 -O2 program.c "norma-$compiler.o" -lm -pthread -o "program-$compiler"
    check "$compiler: it gives the library's bits" cmp <("./program-$compiler") "$scratch/library/output"
    # As people compile by default: GNU dialect, no flags at all.
    check "$compiler: norma.c compiles without any flag" $compiler -c norma.c -o "plain-$compiler.o"
    check "$compiler: without any flag it gives the library's bits" bash -c '"$0" program.c "plain-$0.o" -lm -pthread -o "plain-$0" && "./plain-$0" | cmp - "$1"' "$compiler" "$scratch/library/output"
done
if defined=$(nm --defined-only norma-gcc.o 2>/dev/null | awk '$2 ~ /[A-Z]/ && $3 !~ /^norma_/ { print $3 }') && [ -z "$defined" ]; then
    pass "its external names begin with norma_"
else
    fail "its external names begin with norma_" "$defined"
fi
finish
