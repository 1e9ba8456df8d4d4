#!/bin/sh
# Prints the functions that the public headers declare, one a line, sorted: what the shared library must export, and nothing else.
#   scripts/public-symbols.sh [HEADER...]     (all of include/norma but mpi.h, which is that of libnorma-mpi)
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
[ $# -gt 0 ] || set -- "$root"/include/norma/*.h
for header; do
    [ "$header" != "$root/include/norma/mpi.h" ] || continue
    # Function types (typedef) and the casts of no interest end the same way, so typedefs go first.
    ${CC:-cc} -fpreprocessed -dD -E -P "$header" 2>/dev/null | grep -v -e '^#' -e '^ *typedef [^{]*(' | grep -oE '\bnorma_[a-z0-9_]+ *\(' | tr -d ' ('
done | LC_ALL=C sort -u
