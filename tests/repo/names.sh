#!/bin/bash
# The house becomes smaller, never larger: names that two files of src define as static (scripts/static-names.sh lists them) are at most as many as recorded here. Lower the
# number when there are fewer. Files, private headers and lines of src are told for information.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
most=0

scripts/static-names.sh >"$scratch/names"
now=$(wc -l <"$scratch/names")
if [ "$now" -le "$most" ]; then
    pass "$now names are defined static in two files of src; at most $most were before"
else
    fail "$now names are defined static in two files of src; at most $most were before (scripts/static-names.sh lists them; these in files that git says are new or changed)" \
        "$(git status --porcelain src 2>/dev/null | awk '{ sub(/^src\//, "", $NF); print $NF }' | grep -Ff - "$scratch/names")"
fi
# The list must see what it is for.
mkdir -p "$scratch/made/a"
printf 'static int twice(int a) { return a; }\nstatic int declared(void);\nstatic const char words[] = "a";\n' >"$scratch/made/a/one.c"
printf 'static unsigned long long\ntwice(int a,\n    int b) {\n    return 0;\n}\nstatic int declared(void);\nCORE_INLINE void once(void) {}\nstatic const int words[2][3] = {{0}};\n' >"$scratch/made/two.c"
check "a function and a table that two files have are found, a prototype is none" test "$(scripts/static-names.sh "$scratch/made" | tr '\n' ';')" = "twice: a/one.c two.c;words: a/one.c two.c;"
# A comment that names a file is a way to it: strays FOLDER lists the names of C files in FOLDER, includes aside, that
# no file of the tree has.
find . -path ./build -prune -o -path ./.git -prune -o -type f -name '*.[ch]*' -printf '%f\n' | LC_ALL=C sort -u >"$scratch/files"
strays() {
    grep -rohE --include='*.[ch]' --include='*.cpp' --include='*.def' '^[^#].*[A-Za-z0-9_]\.(c|h|cpp|hpp)\b.*' "$1" | grep -oE '[A-Za-z0-9_]+(\.template)?\.(c|h|cpp|hpp)\b' | LC_ALL=C sort -u | LC_ALL=C comm -23 - "$scratch/files"
}
lost=$(strays src)
if [ -z "$lost" ]; then pass "every file that a comment in src names is there"; else fail "every file that a comment in src names is there" "$lost"; fi
printf '/* As in names_that_are_gone.c, unlike corner.h. */\n#include "gone_too.h"\nint a;\n' >"$scratch/made/a/one.c"
check "a name that no file has is found, an include is none" test "$(strays "$scratch/made")" = names_that_are_gone.c
# Habits: ++i where only the step counts, and !result.
strangers() { grep -rnE --include='*.[ch]' --include='*.cpp' '(^ *|; )[A-Za-z_][][A-Za-z0-9_.>-]*(\+\+|--)[;)]|[=!]= NORMA_OK( |\))' "$1"; }
others=$(strangers src)
if [ -z "$others" ]; then pass "src steps by ++i and asks for !result"; else fail "src steps by ++i and asks for !result" "$others"; fi
printf 'for (int i = 0; i < n; i++) a++;\nif (f() != NORMA_OK) return;\n++a;\nb[n++] = a;\n' >"$scratch/made/a/one.c"
check "other habits are found" test "$(strangers "$scratch/made/a/one.c" | wc -l)" = 2
echo "# src: $(find src -name '*.[ch]' -o -name '*.cpp' -o -name '*.def' | wc -l) files, $(find src -name '*.h' | wc -l) private headers, $(find src -type f \( -name '*.[ch]' -o -name '*.cpp' -o -name '*.def' \) -exec cat {} + | wc -l) lines; core: $(find src/core -name '*.[ch]' | wc -l) files, $(find src/core -name '*.[ch]' -exec cat {} + | wc -l) lines"
finish
