#!/bin/bash
# Writes the core as one file, norma.c, beside norma.h, for those who copy two files:
#   scripts/single.sh [FOLDER]          (build/single)
# Internal headers come first, each once (but *.template.h, which are written out where they are included), then every file of src/core and its folders. A file-scope name that several files use gets the file's name in front.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
out=${1:-$root/build/single}
mkdir -p "$out"
out=$(cd "$out" && pwd)
cp "$root/include/norma/norma.h" "$out/norma.h"

# A template is part of each file that includes it.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -r "$root/src/core" "$work"
cd "$work"
grep -lE '^#include ".*\.template\.h"' $(find core -name '*.c') | while read -r file; do
    awk '/^#include ".*\.template\.h"/ { split($0, quoted, "\""); while ((getline line < quoted[2]) > 0) print line; next } { print }' "$file" >"$file.new"
    mv "$file.new" "$file"
done
version=$(sed -nE 's/^#define NORMA_VERSION_(MAJOR|MINOR|PATCH) +([0-9]+).*/\2/p' "$out/norma.h" | paste -sd.)

# The internal headers that the core itself includes, each after those it includes.
included=$(find core -name '*.[ch]' -exec sed -nE 's/^#[[:space:]]*include[[:space:]]*"([^"]+)".*/\1/p' {} + | sort -u)
headers=$(find core -name '*.h' | sort | grep -xF "$included" | while read -r header; do
    echo "$header $header"
    sed -nE 's/^#[[:space:]]*include[[:space:]]*"([^"]+)".*/\1/p' "$header" | sed "s|\$| $header|"
done | tsort)

mapfile -t files < <(find core -name '*.c' | sort)

# Names at file scope: FILE NAME, one a line.
names() {
    awk '
        function emit(name) { if (name != "" && name != "__attribute__") print FILENAME, name }
        /^#[ \t]*define[ \t]+[A-Za-z_]/ { s = $0; sub(/^#[ \t]*define[ \t]+/, "", s); match(s, /^[A-Za-z0-9_]+/); emit(substr(s, 1, RLENGTH)); next }
        { sub(/^(CORE_(INLINE|FOR_[A-Z0-9]+( static)?|IN_[A-Z0-9]+)|IN_VECTORS|FOR_(VECTORS|ROWS) static) /, "static ") }
        { sub(/ __attribute__\(\(vector_size\([^;]*\)\)\);/, ";") }
        /^static [^=;]*\(/ && !/^static [^(]*=/ { s = $0; sub(/\(.*/, "", s); sub(/[ \t]+$/, "", s); sub(/.*[^A-Za-z0-9_]/, "", s); emit(s); next }
        /^static / { s = $0; sub(/[=;].*/, "", s); sub(/\[.*/, "", s); sub(/[ \t]+$/, "", s); sub(/.*[^A-Za-z0-9_]/, "", s); emit(s); next }
        /^typedef (struct|union|enum) [a-z_0-9]+/ || /^(struct|union|enum) [a-z_0-9]+ *\{/ { s = $0; sub(/^typedef /, "", s); split(s, w, /[ \t{;]+/); emit(w[2]) }
        /^typedef .*\);/ { s = $0; sub(/\(.*/, "", s); sub(/.*[^A-Za-z0-9_]/, "", s); emit(s) }
        /^typedef .*[A-Za-z0-9_];/ || /^\} *[a-z_0-9]+;/ { s = $0; sub(/.*\}/, "", s); sub(/;.*/, "", s); sub(/.*[^A-Za-z0-9_]/, "", s); emit(s) }
        /^enum( [a-z_0-9]+)? *\{/ || /^typedef enum/ { inside = 1 }
        inside {
            s = $0; sub(/.*\{/, "", s); end = s ~ /\}/; sub(/\}.*/, "", s); gsub(/\/\*[^*]*\*\//, "", s)
            n = split(s, w, ",")
            for (i = 1; i <= n; i++) { sub(/=.*/, "", w[i]); gsub(/[ \t]/, "", w[i]); if (w[i] ~ /^[A-Za-z_][A-Za-z0-9_]*$/) emit(w[i]) }
            if (end) inside = 0
        }' "${files[@]}" | sort -u
}
all_names=$(names)
clashes=$(printf '%s\n' "$all_names" | awk '{ print $2 }' | sort | uniq -d)

# The switch that leaves a file out; nothing for most.
switch_of() { # FILE
    case $1 in
        core/topology/*) echo NORMA_WITHOUT_ORIENT ;;
        core/plan/morph*) echo NORMA_WITHOUT_MORPHS ;;
        core/plan/*) echo NORMA_WITHOUT_PLANS ;;
        core/tangent/*) echo NORMA_WITHOUT_TANGENTS ;;
    esac
}

body() { # FILE: without includes of ours
    sed -E '/^#[[:space:]]*include[[:space:]]*("|<norma\/)/d; /^#[[:space:]]*define[[:space:]]+_[A-Z0-9_]+_SOURCE/d' "$1"
}

{
    cat <<HEAD
/* norma.c: the core of Norma $version as one file; norma.h beside it is its interface. Made by scripts/single.sh, not meant to be edited.
 *
 *     cc -std=c11 -O2 -ffp-contract=off -c norma.c        link with -lm -pthread
 *
 * Define any of these to leave out what is not needed, and its functions with it:
 *     NORMA_WITHOUT_ORIENT     norma_orient, norma_reverse_winding
 *     NORMA_WITHOUT_PLANS      norma_plan_*, and morph targets, which use them
 *     NORMA_WITHOUT_MORPHS     norma_morph_normals, norma_morph_deltas
 *     NORMA_WITHOUT_TANGENTS   norma_corner_tangents, norma_split_tangents, norma_build, norma_tangent_plan_*
 *     NORMA_WITHOUT_AVX512     code for AVX-512; AVX2 does the same work
 *
HEAD
    sed -e 's/^/ * /' -e 's/ *$//' "$root/LICENSE"
    cat <<'HEAD'
 */
HEAD
    # Feature-test macros must come before any header.
    sed -nE 's/^#[[:space:]]*define[[:space:]]+(_[A-Z0-9_]+_SOURCE)(.*)/#ifndef \1\n#define \1\2\n#endif/p' "${files[@]}" | awk '!(/^#ifndef/ && seen[$0]++) { if (!skip) print } /^#ifndef/ { skip = seen[$0] > 1 } /^#endif/ { skip = 0 }'
    cat <<'HEAD'
#ifdef __cplusplus
#error "norma.c is C: compile it as C11 and link it; norma.h is for C and C++"
#endif
#if defined(NORMA_WITHOUT_PLANS) && !defined(NORMA_WITHOUT_MORPHS)
#define NORMA_WITHOUT_MORPHS
#endif
#ifdef __FAST_MATH__
#error "norma.c needs IEEE arithmetic: compile it without -ffast-math"
#endif
/* No contraction to fused multiply-adds: the bits of every result are part of the contract. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#endif
#if defined(__GNUC__) || defined(__clang__)
#pragma GCC diagnostic ignored "-Wshadow" /* what were files may use each other's names for locals */
#if defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi" /* no vector crosses into another file */
#endif
#if defined(__MINGW32__)
#pragma GCC diagnostic ignored "-Wfloat-conversion" /* in its macros of math.h */
#endif
#endif
#include "norma.h"
HEAD
    for header in $headers; do
        switch=$(switch_of "$header")
        printf '\n/* ---- %s */\n\n' "$header"
        [ -z "$switch" ] || echo "#if !defined($switch)"
        body "$header"
        [ -z "$switch" ] || echo "#endif"
    done
    for file in "${files[@]}"; do
        place=${file#core/} place=${place%.c} place=${place//\//_}
        mine=$(comm -12 <(printf '%s\n' "$all_names" | awk -v f="$file" '$1 == f { print $2 }' | sort) <(printf '%s\n' "$clashes"))
        macros=$(sed -nE 's/^#[[:space:]]*define[[:space:]]+([A-Za-z_][A-Za-z0-9_]*).*/\1/p' "$file" | grep -vE '_SOURCE$' | sort -u || true)
        switch=$(switch_of "$file")
        printf '\n/* ---- %s */\n\n' "$file"
        [ -z "$switch" ] || echo "#if !defined($switch)"
        for name in $mine; do
            printf '%s\n' "$macros" | grep -qx "$name" || echo "#define $name norma_single_${place}_$name"
        done
        body "$file"
        for name in $(printf '%s\n' "$mine" "$macros" | sort -u); do
            printf '#undef %s\n' "$name"
        done
        [ -z "$switch" ] || echo "#endif"
    done
} >"$out/norma.c.new"
mv "$out/norma.c.new" "$out/norma.c"
echo "$out/norma.c and norma.h: $(wc -l <"$out/norma.c") lines"
