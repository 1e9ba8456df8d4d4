#!/bin/bash
# Arrows run downwards only: between layers (cli -> render, check, io -> core), between the rooms of
# a layer (rooms.txt), and between files, of which no two call each other in a circle. The core does
# no input or output and has no variables; the tool uses public headers and functions only.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
rooms=$root/tests/repo/rooms.txt

# includes FOLDER: "FILE NAME" for everything that the files below FOLDER include: a path from src or
# from the root for a file of ours, norma/... for a public header, system/... for the rest.
includes() {
    find "$1" -name '*.[ch]' | sort | while read -r file; do
        sed -nE 's/^[[:space:]]*#[[:space:]]*include[[:space:]]*(["<])([^">]*)[">].*/\1\2/p' "$file" | while read -r name; do
            case $name in
            '"'*) echo "${file#"$1"/} ${name#?}" ;;
            '<norma/'*) echo "${file#"$1"/} ${name#?}" ;;
            *) echo "${file#"$1"/} system/${name#?}" ;;
            esac
        done
    done
}

# upward EDGES: of lines "FILE FILE [WHAT]" (paths from src) those that lead to a room which does not
# stand before the file's own in rooms.txt, or to another layer that its room may not use.
upward() {
    awk -v rooms="$rooms" '
        function room(path) { sub(/\/[^\/]*$/, "", path); return path }
        function layer(path) { sub(/\/.*/, "", path); return path }
        BEGIN {
            while ((getline line < rooms) > 0) {
                if (line ~ /^#/ || line == "") continue
                split(line, word, /[ \t]+/)
                place[word[1]] = ++count
                others[word[1]] = word[2]
            }
        }
        {
            from = room($1); to = room($2)
            if (!(from in place)) { print $0, "(" from " is not in rooms.txt)"; next }
            if (layer($1) != layer($2)) { if ($2 !~ "^(" others[from] ")$") print; next }
            if (!(to in place) || place[to] > place[from]) print
        }' "$1"
}

# circles EDGES: what tsort finds to lead back to itself.
circles() { cut -d' ' -f1,2 "$1" | LC_ALL=C sort -u | tsort 2>&1 >/dev/null | sed 's/^tsort: //'; }

# calls FOLDER OBJECT...: "FILE FILE FUNCTION" for each call from one object to another; a file's
# path is what follows FOLDER in its object's.
calls() {
    local from=$1
    shift
    nm -A "$@" 2>/dev/null | awk -v from="$from" '
        {
            path = $1; sub(/:[0-9a-f]*$/, "", path); sub(".*" from, "", path); sub(/\.o$/, "", path)
            kind = $(NF - 1)
            if (kind == "U") asked[path " " $NF] = 1
            else if (kind ~ /^[TDBRVW]$/) home[$NF] = path
        }
        END {
            for (pair in asked) {
                split(pair, part, " ")
                if (part[2] in home && home[part[2]] != part[1]) print part[1], home[part[2]], part[2]
            }
        }' | sort
}

none() { # NAME OUTPUT: passes when there is no output
    if [ -z "$2" ]; then pass "$1"; else fail "$1" "$2"; fi
}

# ---- includes

includes src >"$scratch/includes"
none "every folder of src is a room of rooms.txt" \
    "$(find src -name '*.[ch]' -printf '%h\n' | sort -u | sed 's|^src/||' | grep -vxFf <(awk '!/^#/ { print $1 }' "$rooms"))"
grep -vE ' (norma|system)/| rules\.def$| shaders\.h$| norma_glsl\.h$' "$scratch/includes" | while read -r from to; do
    [ -e "src/$to" ] || [ -e "$to" ] || { echo "$from $to (no such file)"; continue; }
    echo "$from $to"
done >"$scratch/own"
none "files include only files that stand below them" "$(grep 'no such file' "$scratch/own"; upward <(grep -v 'no such file' "$scratch/own"))"
none "no headers include each other in a circle" "$(circles <(grep -E '\.h [^ ]*\.h$' "$scratch/own"))"
# What the core may take from the C library: no streams, no files, no locale, no environment. Threads come from POSIX.
core_system='system/(stddef|stdint|stdbool|stdlib|string|math|float|limits|stdalign|stdatomic|assert|errno|pthread|sched|threads|unistd|[a-z]*intrin|arm_neon|wasm_simd128|cpuid|sys/mman|sys/auxv)\.h'
none "the core includes of others only norma.h and a C library without input and output" \
    "$(grep '^core/' "$scratch/includes" | grep -vE " (core/[a-z0-9_/]+(\.template)?\.h|norma/norma\.h|$core_system)\$")"
none "MPI is called in src/mpi only" "$(grep ' system/mpi\.h$' "$scratch/includes" | grep -v '^mpi/')"
none "render includes only the core's public header" "$(grep '^render/' "$scratch/includes" | grep ' norma/' | grep -v ' norma/norma\.h$')"
none "public headers include only each other and the freestanding C library, and mpi.h that of MPI" \
    "$(includes include/norma | grep -vE ' (norma/[a-z]+\.h|system/(stddef|stdint)\.h)$' | grep -vx 'mpi\.h system/mpi\.h')"
none "nothing outside the tool reaches into src/cli" "$(grep -rlE '#[[:space:]]*include[[:space:]]*"[^"]*cli/' src web --include='*.[ch]' | grep -v '^src/cli/')"

# ---- calls

# Only what the tree builds now: an old tree may hold objects of files that are gone.
compiled() { sed -nE 's/^ *"output": "([^"]*)",?$/\1/p; s/^ *"command": .* -o ([^ ]*\.o) .*/\1/p' "$tree/compile_commands.json" 2>/dev/null | sort -u | sed "s|^|$tree/|"; }
objects=$(compiled | grep -E '\.dir/src/.*\.o$')
if [ -z "$objects" ]; then
    skip "calls between files (no build tree at $tree)"
else
    # shellcheck disable=SC2086
    calls '/src/' $objects >"$scratch/calls"
    if [ "$(wc -l <"$scratch/calls")" -gt 500 ]; then pass "calls between files are seen"; else fail "calls between files are seen" "$(wc -l <"$scratch/calls")"; fi
    awk '{ print $1 "\n" $2 }' "$scratch/calls" | cut -d/ -f1 | sort -u >"$scratch/layers"
    # Between layers headers decide (above); what is compared here are rooms of one layer.
    none "files call only what stands in their own room or below" "$(upward <(awk '{ split($1, a, "/"); split($2, b, "/"); if (a[1] == b[1]) print }' "$scratch/calls"))"
    none "no two files call each other in a circle" "$(circles "$scratch/calls")"
fi

# The checks themselves must see what they are for: two files that call each other, and an arrow upwards.
mkdir -p "$scratch/made/src/core/face" "$scratch/made/src/core/plan"
echo 'int b(void); int a(void); int a(void) { return b(); }' >"$scratch/made/src/core/face/a.c"
echo 'int a(void); int b(void); int b(void) { return a(); }' >"$scratch/made/src/core/plan/b.c"
for file in core/face/a core/plan/b; do ${CC:-cc} -c "$scratch/made/src/$file.c" -o "$scratch/made/src/$file.c.o"; done
calls '/src/' "$scratch/made/src/core/face/a.c.o" "$scratch/made/src/core/plan/b.c.o" >"$scratch/made.calls"
if circles "$scratch/made.calls" | grep -q 'core/face/a.c'; then pass "a deliberate circle is found"; else fail "a deliberate circle is found" "$(cat "$scratch/made.calls")"; fi
if [ "$(upward "$scratch/made.calls")" = "core/face/a.c core/plan/b.c b" ]; then pass "a deliberate arrow upwards is found"; else fail "a deliberate arrow upwards is found" "$(upward "$scratch/made.calls")"; fi

# ---- what objects ask for

core_objects=$(compiled | grep -E '\.dir/src/core/.*\.o$')
if [ -z "$core_objects" ]; then
    skip "the core's objects (no build tree at $tree)"
else
    # shellcheck disable=SC2086
    asked=$(comm -23 <(nm -u $core_objects | awk '$1 == "U" { print $2 }' | sort -u) <(nm --defined-only $core_objects | awk 'NF == 3 && $2 ~ /[A-Z]/ { print $3 }' | sort -u))
    none "the core's objects ask for nothing of another layer, of streams, files, locales or the environment" \
        "$(printf '%s\n' "$asked" | grep -E '^(f?printf|__.*printf_chk|puts|putchar|f?open|fopen64|open64|read|write|fwrite|fread|fclose|stdout|stderr|stdin|setlocale|localeconv|strto[dfl].*|__strto.*|getenv|exit|time|rand|norma_.*|meshopt_.*)$')"
    # Tables of functions are constants (.data.rel.ro).
    # shellcheck disable=SC2086
    none "the core has no variables of its own" \
        "$(objdump -t $core_objects | awk 'NF > 4 && $(NF-2) ~ /^\.(data|bss|tdata|tbss)/ && $(NF-2) !~ /^\.data\.rel\.ro/ && $2 !~ /d/ && $3 !~ /d/ { print $NF }' | sort -u)"
fi

tool_objects=$(compiled | grep -E 'norma-cli(-objects)?\.dir/(src/cli|web)/.*\.o$')
if [ -n "$tool_objects" ]; then
    # shellcheck disable=SC2086
    asked=$(comm -23 <(nm -u $tool_objects | awk '$1 == "U" && $2 ~ /^norma_/ { print $2 }' | sort -u) <({ nm --defined-only $tool_objects | awk 'NF == 3 && $2 ~ /[A-Z]/ { print $3 }'; scripts/public-symbols.sh; } | sort -u))
    # The library's reader of JSON and UTF-8 serves the tool as well (io/text/json.c).
    none "the tool calls only public functions, and the reader of JSON and UTF-8" "$(grep -vE '^norma_(json|utf8)_' <<<"$asked")"
fi
finish
