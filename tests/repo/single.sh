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
# What may be left out: it compiles without a warning, all that stays links, and what is left out is gone.
strict="-std=c11 -O0 -fPIC -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror"
left_out() { # SWITCH FUNCTION
    # shellcheck disable=SC2086 # a list of options
    check "gcc: norma.c has no warning with $1" gcc $strict "-D$1" -fsyntax-only norma.c # twelve seconds less than compiling
    # shellcheck disable=SC2086 # a list of options
    check "clang: norma.c compiles with $1" clang $strict "-D$1" -c norma.c -o less.o
    check "with $1 the rest links" bash -c 'clang program.c less.o -lm -pthread -o less && ./less | cmp - "$0"' "$scratch/library/output"
    check "with $1 every name is defined" clang -shared -Wl,-z,defs less.o -lm -pthread -o less.so
    if nm --defined-only less.o | grep -q " T $2"; then fail "$1 leaves out $2*"; else pass "$1 leaves out $2*"; fi
}
left_out NORMA_WITHOUT_ORIENT norma_orient
left_out NORMA_WITHOUT_MORPHS norma_morph
left_out NORMA_WITHOUT_PLANS norma_plan
left_out NORMA_WITHOUT_TANGENTS norma_corner_tangents
left_out NORMA_WITHOUT_AVX512 norma_core_units_avx512

# C++ takes the header, not the file.
if said=$(g++ -std=c++17 -x c++ -fsyntax-only norma.c 2>&1); then
    fail "g++: norma.c is refused as C++"
elif grep -q "norma.c is C" <<<"$said"; then
    pass "g++: norma.c is refused as C++, with a reason"
else
    fail "g++: norma.c is refused as C++, with a reason" "$said"
fi
printf '#include "norma.h"\n#include <cstdio>\nint main() { std::puts(norma_version()); }\n' >program.cpp
check "a C++ program links with it" g++ -std=c++17 program.cpp norma-gcc.o -lm -pthread -o program-cpp
# As clang-cl sees it: clang without the GNU extensions' macros.
# shellcheck disable=SC2086 # a list of options
check "clang without __GNUC__: norma.c compiles" clang -fgnuc-version=0 $strict -Wno-literal-range -c norma.c -o "norma-cl.o"
check "clang without __GNUC__: it gives the library's bits" bash -c 'clang program.c norma-cl.o -lm -pthread -o program-cl && ./program-cl | cmp - "$0"' "$scratch/library/output"
if command -v x86_64-w64-mingw32-gcc >/dev/null; then
    # shellcheck disable=SC2086 # a list of options
    check "mingw: norma.c compiles without a warning" x86_64-w64-mingw32-gcc $strict -c norma.c -o norma-mingw.o
    check "mingw: a program of norma.c links" x86_64-w64-mingw32-gcc -std=c11 program.c norma-mingw.o -pthread -o program.exe
else
    skip "mingw (not installed)"
fi
if defined=$(nm --defined-only norma-gcc.o 2>/dev/null | awk '$2 ~ /[A-Z]/ && $3 !~ /^norma_/ { print $3 }') && [ -z "$defined" ]; then
    pass "its external names begin with norma_"
else
    fail "its external names begin with norma_" "$defined"
fi
finish
