#!/bin/bash
# Every public header compiles alone, as C11 (but for norma.hpp) and as C++17, with both compilers and warnings as errors.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1

flags="-Iinclude -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Werror -fsyntax-only"
# Those of MPI are a system's: mpicc tells where they are.
mpi=$(mpicc -show 2>/dev/null | grep -oE ' (-I|-isystem) *[^ ]+' | sed -E 's/^ (-I|-isystem) */-isystem /' | tr '\n' ' ')
for header in include/norma/*.h include/norma/*.hpp; do
    name=${header#include/}
    if [ "$name" = norma/mpi.h ] && [ -z "$mpi" ]; then
        skip "$name (no mpicc)"
        continue
    fi
    printf '#include <%s>\n#include <%s>\nint main(void) { return 0; }\n' "$name" "$name" >"$scratch/one.c"
    cp "$scratch/one.c" "$scratch/one.cpp"
    [ "${name%.hpp}" != "$name" ] || for compiler in gcc clang; do
        # shellcheck disable=SC2086
        check "$name as C11 with $compiler" $compiler -std=c11 -Wstrict-prototypes $flags $mpi "$scratch/one.c"
    done
    for compiler in g++ clang++; do
        # shellcheck disable=SC2086
        check "$name as C++17 with $compiler" $compiler -std=c++17 $flags $mpi -Wold-style-cast "$scratch/one.cpp"
    done
done
# Each public function has a comment directly above it, with a line for each parameter. The document, plan or findings that it is about need none, nor do an index
# and a single parameter, nor a function that is another one in a different form and says so.
undocumented=$(awk '
    /^\/\*/ { comment = ""; inside = 1 }
    inside { comment = comment $0 "\n" }
    /\*\/ *$/ { inside = 0; next }
    inside { next }
    /^NORMA_API/ { declaring = 1; text = "" }
    declaring { text = text " " $0 }
    declaring && /;$/ {
        declaring = 0
        name = text; sub(/\(.*/, "", name); sub(/.*[ *]/, "", name)
        list = text; sub(/^[^(]*\(/, "", list); sub(/\);$/, "", list)
        if (comment == "") print FILENAME ": " name " has no comment"
        other = comment; gsub("(^|[^a-z_])" name "([^a-z0-9_]|$)", " ", other)
        count = split(list, parameter, ",")
        for (i = 1; i <= count; i++) {
            p = parameter[i]; gsub(/\[[0-9]*\]/, "", p); sub(/ +$/, "", p); sub(/.*[ *]/, "", p)
            if (count == 1 || i == 1 && p ~ /^(document|plan|findings)$/ || p == "index") continue
            if (comment !~ ("\n \\*   ([a-z_]+, )*" p "(, [a-z_]+)*  ") && other !~ /norma_[a-z0-9_]+ (with|in)|parameters/) print FILENAME ": " name " does not describe " p
        }
        comment = ""
    }
    !declaring && NF { comment = "" }' include/norma/*.h)
if [ -z "$undocumented" ]; then pass "every public function has its parameters described"; else fail "every public function has its parameters described" "$undocumented"; fi
wide=$(awk 'length > 100 { print FILENAME ":" FNR }' include/norma/*.h)
if [ -z "$wide" ]; then pass "no line of a header is longer than 100 columns"; else fail "no line of a header is longer than 100 columns" "$wide"; fi

if [ -e ../shared/norma.h ]; then
    # The contract changes nothing that it had: each of its declarations and macros is in the header; spaces, comments and NORMA_API do not count.
    lines() { gcc -fpreprocessed -dD -E -P "$1" 2>/dev/null | sed -e ':joined' -e '/\\$/{N;s/\\\n//;b joined' -e '}' -e 's/^#.*/&;/; s/\bNORMA_API\b//' | tr -d ' \t\n' | tr ';' '\n'; }
    lines include/norma/norma.h >"$scratch/ours"
    check "norma.h has every declaration of the contract" bash -c '! grep -vxFf "$0" "$1"' "$scratch/ours" <(lines ../shared/norma.h)
else
    skip "norma.h against the contract (not here)"
fi
finish
