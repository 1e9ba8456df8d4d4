#!/bin/bash
# What the library takes from outside and gives to it; numbers and messages under a locale with a decimal comma; the flags against exploits in what was built.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
library=$tree/lib/libnorma.a

# ---- names

# The one object of C++ (draco_decoder.o, where libdraco was found) is looked at by itself; all that is said of the rest holds as if it were not there, but for its norma_ names.
whole=$library
library=$scratch/libnorma.a
cp "$whole" "$library"
if ar t "$whole" | grep -qx draco_decoder.o; then
    (cd "$scratch" && ar x "$whole" draco_decoder.o && ar d "$library" draco_decoder.o)
    strangers=$(nm -u "$scratch/draco_decoder.o" | awk '{ print $2 }' | grep -vE '^(_Z(TI|TV|TVN|TIN|N|NK)?N?5draco|_ZN5draco|_ZNK5draco|_ZTI(St9bad_alloc|St9exception|St12length_error)$|_ZNSt12length_errorC1|_ZNSt12length_errorD1|_ZSt20__throw_length_error|_ZTVN10__cxxabiv1|_ZNSt8ios_base4Init|_Zdl|_Znw|__cxa_|__gxx_personality_v0$|_Unwind_Resume$|__dso_handle$|_GLOBAL_OFFSET_TABLE_$|__stack_chk_fail$|mem(cpy|set)$)')
    if [ -z "$strangers" ]; then pass "its object of C++ imports only libdraco and what every program in C++ does"; else fail "its object of C++ imports only libdraco and what every program in C++ does" "$strangers"; fi
    # Weak ones are templates of libdraco's headers, which any other object may have as well.
    foreign=$(nm --defined-only "$scratch/draco_decoder.o" | awk 'NF == 3 && $2 ~ /[ABCDGRST]/ && $3 !~ /^norma_/ { print $3 }')
    if [ -z "$foreign" ]; then pass "its object of C++ defines no name without norma_ but weak ones"; else fail "its object of C++ defines no name without norma_ but weak ones" "$foreign"; fi
fi
nm -u "$library" 2>/dev/null | awk 'NF == 2 && $1 ~ /^[Uw]$/ { print $2 }' | sort -u >"$scratch/undefined"
nm --defined-only "$whole" 2>/dev/null | awk 'NF == 3 { print $3 }' | sort -u >"$scratch/defined"
comm -23 "$scratch/undefined" "$scratch/defined" >"$scratch/imports"
check "the library imports something" test -s "$scratch/imports"
grep -v '^#' tests/repo/hygiene/allowed-imports.txt | LC_ALL=C sort -u >"$scratch/allowed"
strangers=$(LC_ALL=C comm -23 <(LC_ALL=C sort "$scratch/imports") "$scratch/allowed" | grep -vx __assert_fail)
if [ -z "$strangers" ]; then pass "libnorma.a imports only what tests/repo/hygiene/allowed-imports.txt lists"; else fail "libnorma.a imports only what tests/repo/hygiene/allowed-imports.txt lists" "$strangers"; fi
# Assertions are for our own bugs, and in a build with NDEBUG, as make's and the packages', there are none: a tree without it may import what they end in, its sources with it not.
asserting=$(cd src && grep -rlE '^#include <assert.h>' core io check | sort | tr '\n' ' ')
left=""
for file in $asserting; do
    case $file in *.h) continue ;; esac
    gcc -std=c11 -O1 -DNDEBUG -Iinclude -Isrc -c "src/$file" -o "$scratch/one.o" && nm -u "$scratch/one.o" | grep -q __assert_fail && left="$left $file"
done
if [ -z "$left" ]; then pass "no assertion is left in a build with NDEBUG (looked at: ${asserting:-none})"; else fail "no assertion is left in a build with NDEBUG" "$left"; fi
foreign=$(nm --defined-only "$library" 2>/dev/null | awk 'NF == 3 && $2 ~ /[A-Z]/ && $3 !~ /^norma_/ { print $3 }')
if [ -z "$foreign" ]; then pass "libnorma.a defines no name without norma_"; else fail "libnorma.a defines no name without norma_" "$foreign"; fi
if [ -e "$tree/lib/libnorma.so" ]; then
    foreign=$(nm -D --defined-only "$tree/lib/libnorma.so" | awk '$2 != "A" && $3 !~ /^norma_/ { print $3 }')
    if [ -z "$foreign" ]; then pass "libnorma.so exports no name without norma_"; else fail "libnorma.so exports no name without norma_" "$foreign"; fi
else
    skip "libnorma.so (not built)"
fi
writable=$(objdump -t "$library" 2>/dev/null | awk '$3 == "O" && $4 ~ /^\.(data|bss)/ && $4 !~ /^\.data\.rel\.ro/ { print $4, $NF } $2 == "O" && $3 ~ /^\.(data|bss)/ && $3 !~ /^\.data\.rel\.ro/ { print $3, $NF } /COM/ { print $NF }')
if [ -z "$writable" ]; then pass "the library has no data that could be written: no globals"; else fail "the library has no data that could be written: no globals" "$writable"; fi

# ---- scripts

# A test that cannot be started is a test that does not run.
idle=$(find scripts tests -name '*.sh' ! -path 'tests/support/*' ! -perm -u+x)
if [ -z "$idle" ]; then pass "every script of scripts/ and tests/ can be executed"; else fail "every script of scripts/ and tests/ can be executed" "$idle"; fi

# ---- locale

if command -v localedef >/dev/null && [ -e /usr/share/i18n/locales/de_DE ]; then
    mkdir -p "$scratch/locales"
    check "a German locale is made" localedef -i de_DE -f UTF-8 "$scratch/locales/de_DE.UTF-8"
    check "a program for it builds" gcc -std=c11 -Wall -Wextra -Werror -Iinclude tests/repo/hygiene/locale.c -o "$scratch/locale" "$whole" -lmeshoptimizer -ldraco -lstdc++ -lpng -ljpeg -lz -lm -pthread
    files=$(find assets tests/cli/golden/files -name '*.obj' -o -name '*.stl' -o -name '*.ply' -o -name '*.gltf' -o -name '*.glb' | LC_ALL=C sort)
    # shellcheck disable=SC2086  # a list of words
    check "it runs with a decimal point" bash -c 'LC_ALL=C "$0" . "${@:2}" >"$1"' "$scratch/locale" "$scratch/with-point" $files
    # shellcheck disable=SC2086
    check "it runs with a decimal comma" bash -c 'LOCPATH="$1" LC_ALL=de_DE.UTF-8 "$0" , "${@:3}" >"$2"' "$scratch/locale" "$scratch/locales" "$scratch/with-comma" $files
    check "something was written" test "$(wc -c <"$scratch/with-point")" -gt 100000
    check "the same bytes in both" cmp "$scratch/with-point" "$scratch/with-comma"
    check "the tool's bytes are the same in both" bash -c 'LC_ALL=C "$0" check assets/goathead.obj >"$1/a"; LOCPATH="$1/locales" LC_ALL=de_DE.UTF-8 LANG=de_DE.UTF-8 "$0" check assets/goathead.obj >"$1/b"; test -s "$1/a" && cmp "$1/a" "$1/b"' "$NORMA_BIN" "$scratch"
    printf '#include <locale.h>\n__attribute__((constructor)) static void host(void) { setlocale(LC_ALL, ""); }\n' >"$scratch/host.c"
    check "a library that sets the locale builds" gcc -shared -fPIC "$scratch/host.c" -o "$scratch/host.so"
    for words in "matrix --scale 1.5,2,3 --json" "compute assets/goathead.obj -o $scratch/out.obj --crease 59.5 --json"; do
        # shellcheck disable=SC2086  # a list of words
        check "with that library preloaded the tool's bytes are the same: ${words%% *}" bash -c '"$0" "${@:2}" >"$1/a" && LD_PRELOAD=$1/host.so LOCPATH=$1/locales LC_ALL=de_DE.UTF-8 "$0" "${@:2}" >"$1/b" && test -s "$1/a" && cmp "$1/a" "$1/b"' "$NORMA_BIN" "$scratch" $words
    done
else
    skip "a decimal comma (no localedef, or no source of de_DE: Debian's package locales)"
fi

# ---- hardening

hardened() { # NAME FILE
    local name=$1 file=$2 headers dynamic
    headers=$(readelf -lW "$file")
    dynamic=$(readelf -dW "$file")
    check "$name: position independent" bash -c 'readelf -hW "$0" | grep -q "Type: *DYN"' "$file"
    check "$name: relocations read-only" grep -q GNU_RELRO <<<"$headers"
    check "$name: names bound at once" grep -qE 'BIND_NOW|Flags:.*NOW' <<<"$dynamic"
    check "$name: the stack is not executable" bash -c 'grep GNU_STACK <<<"$0" | grep -q " RW "' "$headers"
    check "$name: no segment to be written and executed" bash -c '! grep -E "^ *LOAD.* RWE " <<<"$0"' "$headers"
    check "$name: no text relocations" bash -c '! grep -q TEXTREL <<<"$0"' "$dynamic"
    check "$name: no search path for libraries" bash -c '! grep -qE "RPATH|RUNPATH" <<<"$0"' "$dynamic"
    check "$name: stack protector" bash -c 'nm -D "$0" | grep -q __stack_chk_fail' "$file"
    check "$name: checked functions of the C library" bash -c 'nm -D "$0" | grep -qE "__[a-z]+_chk"' "$file"
    if [ "$(uname -m)" = x86_64 ]; then
        # The linker tells it of a whole file only where all that is linked in has it; of the code, each function's beginning does.
        check "$name: control-flow protection" bash -c 'objdump -d --no-show-raw-insn "$0" | grep -c endbr64 | { read -r n; [ "$n" -gt 100 ]; }' "$file"
    fi
}
hardened norma "$NORMA_BIN"
[ ! -e "$tree/lib/libnorma.so" ] || hardened libnorma.so "$tree/lib/libnorma.so"
finish
