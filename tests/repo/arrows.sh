#!/bin/bash
# The layers depend downwards only: cli -> (render, check,) io -> core. The core does no input or output, and the tool uses public headers only.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1

# includes FOLDER: FILE:LINE:NAME of everything that its files include; "src/io/x.h" when a quoted name lies there.
includes() {
    [ -d "$1" ] || return 0
    find "$1" -name '*.[ch]' | sort | while read -r file; do
        sed -nE 's/^[[:space:]]*#[[:space:]]*include[[:space:]]*(["<])([^">]*)[">].*/\1\2/p' "$file" | while read -r name; do
            case $name in
            '"'*) path=$(realpath -m --relative-to=. "$(dirname "$file")/${name#?}")
                  # A quoted name may also be found from src or from include.
                  [ -e "$path" ] || for from in src include; do [ ! -e "$from/${name#?}" ] || path=$from/${name#?}; done
                  echo "$file $path" ;;
            '<norma/'*) echo "$file include/${name#?}" ;;
            *) echo "$file system/${name#?}" ;;
            esac
        done
    done
}

# only NAME FOLDER ALLOWED: fails with each include of FOLDER's files that does not match the extended regular expression.
only() {
    local list bad
    list=$(includes "$2")
    if [ -z "$list" ]; then fail "$1" "no includes found in $2"; return; fi
    bad=$(printf '%s\n' "$list" | grep -vE " ($3)\$")
    if [ -z "$bad" ]; then pass "$1"; else fail "$1" "$bad"; fi
}

# What the core may take from the C library: no streams, no files, no locale, no environment. Threads come from POSIX.
core_system='system/(stddef|stdint|stdbool|stdlib|string|math|float|limits|stdalign|stdatomic|assert|errno|pthread|sched|threads|unistd|[a-z]*intrin|arm_neon|wasm_simd128|cpuid|sys/mman|sys/auxv)\.h'

only "the core includes only itself, norma.h and a C library without input and output" src/core "src/core/[a-z0-9_]+\.h|include/norma/norma\.h|$core_system"
only "io includes only itself, the core and public headers" src/io "src/(io|core)/[a-z0-9_]+\.h|include/norma/[a-z]+\.h|system/.*"
only "check includes only itself, the core and public headers" src/check "src/(check/[a-z0-9_]+\.(h|def)|core/[a-z0-9_]+\.h)|include/norma/[a-z]+\.h|system/.*"
only "render includes only itself and the core's public header" src/render "src/render/[a-z0-9_]+\.h|include/norma/norma\.h|system/.*"
only "the tool includes only itself, the renderer's one header and public headers" src/cli "src/cli/[a-z0-9_]+\.h|src/render/render\.h|include/norma/[a-z]+\.h|system/.*"
only "public headers include only each other and the freestanding C library" include/norma "include/norma/[a-z]+\.h|system/(stddef|stdint)\.h"

# The same of what is linked: what the core's objects ask for that the core does not define.
core_objects=$(find "$tree" -path '*norma-objects.dir/src/core/*.o' 2>/dev/null)
if [ -z "$core_objects" ]; then
    skip "the core's objects (no build tree at $tree)"
else
    # shellcheck disable=SC2086
    undefined=$(nm -u $core_objects | awk '$1 == "U" { print $2 }' | sort -u)
    # shellcheck disable=SC2086
    defined=$(nm --defined-only $core_objects | awk 'NF == 3 && $2 ~ /[A-Z]/ { print $3 }' | sort -u)
    asked=$(comm -23 <(printf '%s\n' "$undefined") <(printf '%s\n' "$defined"))
    bad=$(printf '%s\n' "$asked" | grep -E '^(f?printf|__.*printf_chk|puts|putchar|f?open|fopen64|open64|read|write|fwrite|fread|fclose|stdout|stderr|stdin|setlocale|localeconv|strto[dfl].*|__strto.*|getenv|exit|time|rand|norma_.*|meshopt_.*)$')
    if [ -z "$bad" ]; then pass "the core's objects ask for nothing of another layer, of streams, files, locales or the environment"
    else fail "the core's objects ask for nothing of another layer, of streams, files, locales or the environment" "$bad"; fi

    # shellcheck disable=SC2086
    globals=$(objdump -t $core_objects | awk 'NF > 4 && $(NF-2) ~ /^\.(data|bss|tdata|tbss)/ && $(NF-2) !~ /^\.data\.rel\.ro/ && $2 !~ /d/ && $3 !~ /d/ { print $NF }' | sort -u) # tables of functions are constants
    if [ -z "$globals" ]; then pass "the core has no variables of its own"
    else fail "the core has no variables of its own" "$globals"; fi
fi

tool_objects=$(find "$tree" -path '*norma-cli.dir/src/cli/*.o' 2>/dev/null)
if [ -n "$tool_objects" ]; then
    # shellcheck disable=SC2086
    asked=$(nm -u $tool_objects | awk '$1 == "U" && $2 ~ /^norma_/ { print $2 }' | sort -u)
    # shellcheck disable=SC2086
    own=$(nm --defined-only $tool_objects | awk 'NF == 3 && $2 ~ /[A-Z]/ { print $3 }' | sort -u)
    bad=$(comm -23 <(printf '%s\n' "$asked") <({ printf '%s\n' "$own"; scripts/public-symbols.sh; } | sort -u))
    if [ -z "$bad" ]; then pass "the tool calls only public functions"; else fail "the tool calls only public functions" "$bad"; fi
fi
finish
