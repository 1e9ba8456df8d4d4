#!/bin/bash
# Every public header compiles alone, as C11 and as C++17, with both compilers and warnings as errors.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1

flags="-Iinclude -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Werror -fsyntax-only"
for header in include/norma/*.h; do
    name=${header#include/}
    printf '#include <%s>\n#include <%s>\nint main(void) { return 0; }\n' "$name" "$name" >"$scratch/one.c"
    cp "$scratch/one.c" "$scratch/one.cpp"
    for compiler in gcc clang; do
        # shellcheck disable=SC2086
        check "$name as C11 with $compiler" $compiler -std=c11 -Wstrict-prototypes $flags "$scratch/one.c"
    done
    for compiler in g++ clang++; do
        # shellcheck disable=SC2086
        check "$name as C++17 with $compiler" $compiler -std=c++17 $flags -Wold-style-cast "$scratch/one.cpp"
    done
done
if [ -e ../shared/norma.h ]; then
    # The contract changes nothing that it had: each of its declarations and macros is in the header; spaces, comments and NORMA_API do not count.
    lines() { gcc -fpreprocessed -dD -E -P "$1" 2>/dev/null | sed -e ':joined' -e '/\\$/{N;s/\\\n//;b joined' -e '}' -e 's/^#.*/&;/; s/\bNORMA_API\b//' | tr -d ' \t\n' | tr ';' '\n'; }
    check "norma.h has every declaration of the contract" bash -c '! grep -vxFf "$0" "$1"' <(lines include/norma/norma.h) <(lines ../shared/norma.h)
else
    skip "norma.h against the contract (not here)"
fi
finish
