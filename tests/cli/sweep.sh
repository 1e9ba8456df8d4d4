#!/bin/bash
# Every mesh file of the data set through every verb of a tool with sanitizers (NORMA_BIN: build/test/clang/bin/norma). What counts is that the tool lives: exit statuses are
# those that it documents, no sanitizer says a word, no command takes more than SWEEP_SECONDS (120) of the processor. One case a file; a failure shows the command and the stack.
#   tests/cli/sweep.sh             small files through all commands, larger ones through fewer (below); what is left out is said
#   tests/cli/sweep.sh FILE...     these
# SWEEP_TOTAL: seconds after which no further file is begun (300; 0: all are, which takes an hour); the smallest come first, and what is left out is counted as skipped.
# SWEEP_SMALL, SWEEP_MIDDLE: sizes in kB up to which all commands, or those of one pass, are run (256, 3000). FINDS: a folder for each find's command and stack.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
NORMA=${NORMA_BIN:-$tree/bin/norma}
data=${NORMA_DATA:-$root/../shared/data}
small=${SWEEP_SMALL:-256} middle=${SWEEP_MIDDLE:-3000} total=${SWEEP_TOTAL:-300} began=$(date +%s)
[ -x "$NORMA" ] || { fail "the tool is there" "no program at $NORMA"; finish; exit 1; }
[ -d "$data" ] || { skip "the data set is not there"; finish; exit; }
export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_leaks=1:detect_stack_use_after_return=1:allocator_may_return_null=1}
export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1} MESA_SHADER_CACHE_DISABLE=true
export NORMA scratch data small middle total began

# commands FILE KB: one a line; IN and OUT stand for the names.
commands() {
    local kb=$2
    printf '%s\n' 'info IN' 'check IN --info --format json'
    [ "$kb" -le "$middle" ] || return
    printf '%s\n' 'check IN --fix-unsafe -o OUT' 'compute IN -o OUT --crease 40' 'transform IN -o OUT --scale 2,.5,-1 --rotate 1,2,3,40'
    case $1 in *.gltf | *.glb) printf '%s\n' 'transform IN -o OUT --bake' 'tangents IN -o OUT' 'pack IN -o OUT' ;; esac
    [ "$kb" -le "$small" ] || return
    printf '%s\n' 'info IN --json' 'check IN --profile print --format sarif' 'check IN --profile generated --format html -o PAGE' 'check IN --fix -o OUT' 'check IN --fix-unsafe --open-by-rays --profile print -o OUT' \
        'check IN --fix-unsafe --profile generated --dry-run' 'compute IN -o OUT --smooth --weight area' 'compute IN -o OUT --crease 0' 'compute IN -o OUT --crease 180 --weight angle-area --non-manifold smooth' \
        'compute IN -o OUT --flat --weld none' 'compute IN -o OUT --weld 0.001 --weight max --only missing' 'compute IN -o OUT --only broken --threads 3' 'compute IN -o OUT --weight visible --morphs --tangents regenerate' \
        'compute IN --together --out-dir FOLDER' 'transform IN -o OUT --scale 0,1,1' 'transform IN -o OUT --matrix "0 2 0 1 3 0 0 2 0 0 .1 3 0 0 0 1"'
    printf '%s\n' 'compare IN IN' 'seams votes IN --everywhere -o VOTES'
    case $1 in *.gltf | *.glb) printf '%s\n' 'transform IN -o OUT --bake --scale -1,2,1' 'tangents IN -o OUT --mode steady' 'tangents IN -o OUT --only broken' ;; esac
    [ "$kb" -le $((small / 4)) ] || return
    printf '%s\n' 'render IN -o PICTURE --size 48x48 --samples 1' 'render IN -o PICTURE --size 48x48 --samples 1 --show findings' 'render IN -o PICTURE --size 48x48 --samples 1 --show normals,hedgehog,wireframe' 'render IN -o PICTURE --size 48x48 --samples 1 --compare=30,180'
}

# size_of FILE: in kB, with the buffers of a glTF beside it.
size_of() {
    local all=("$1")
    [[ $1 != *.gltf ]] || all+=("$(dirname "$1")"/*.bin)
    stat -L -c %s "${all[@]}" 2>/dev/null | awk '{ sum += $1 } END { print int((sum + 1023) / 1024) }'
}

# one FILE: runs its commands; prints those that went wrong, each with what it said.
one() {
    local file=$1 kb line words status said leaks here=$scratch/$$ bad=0 count=0
    kb=$(size_of "$file")
    mkdir -p "$here/folder"
    while IFS= read -r line; do
        count=$((count + 1))
        words=${line/#/"$NORMA" }
        words=${words// IN/ \"$file\"} words=${words/OUT/\"$here/out.${file##*.}\"} words=${words/PAGE/\"$here/page.html\"} words=${words/VOTES/\"$here/votes\"} words=${words/PICTURE/\"$here/picture.png\"} words=${words/FOLDER/\"$here/folder\"}
        status=0 leaks=1
        case $line in render*) leaks=0 ;; esac # Mesa's
        said=$(export ASAN_OPTIONS="$ASAN_OPTIONS:detect_leaks=$leaks"; ulimit -St "${SWEEP_SECONDS:-120}"; eval "$words" 2>&1 >"$here/stdout" </dev/null) || status=$?
        case $status in 0 | 1 | 2 | 3) grep -qE 'runtime error:|ERROR: [A-Za-z]*Sanitizer' <<<"$said" || continue ;; esac
        bad=$((bad + 1))
        printf 'norma %s   (IN = %s), exit status %s\n' "$line" "${file#"$data"/}" "$status"
        grep -aE 'runtime error:|ERROR:|SUMMARY:|^ *#[0-9]+ |located|allocated by|freed by' <<<"$said" | head -30
        if [ -n "${FINDS:-}" ]; then printf 'norma %s   (IN = %s)\nexit status %s\n\n%s\n' "$line" "$file" "$status" "$said" | head -120 >"$FINDS/$(basename "$file").$count.txt"; fi
    done < <(commands "$file" "$kb")
    rm -rf "$here"
    [ $bad -eq 0 ]
}
# answer FILE: what one printed, in a file of its own, and its end.
answer() {
    local name
    name=$(md5sum <<<"$1" | cut -c1-16)
    if [ "$total" -gt 0 ] && [ $(($(date +%s) - began)) -gt "$total" ]; then echo late >"$scratch/$name.end"; return; fi
    if one "$1" >"$scratch/$name.said"; then echo ok; else echo bad; fi >"$scratch/$name.end"
}
export -f commands size_of one answer

if [ $# -gt 0 ]; then
    printf '%s\n' "$@" >"$scratch/files"
else
    find -L "$data" -type f -regextype egrep -iregex '.*\.(obj|ply|stl|gltf|glb|3mf)' | while IFS= read -r file; do printf '%s\t%s\n' "$(size_of "$file")" "$file"; done |
        sort -n >"$scratch/sizes" # the smallest first
    cut -f2- "$scratch/sizes" >"$scratch/files"
fi
xargs -d '\n' -P "${JOBS:-$(nproc)}" -I{} bash -c 'answer "$0"' {} <"$scratch/files"
late=0
while IFS= read -r file; do
    name=$(md5sum <<<"$file" | cut -c1-16)
    case $(cat "$scratch/$name.end" 2>/dev/null) in
    ok) pass "${file#"$data"/}" ;;
    late) late=$((late + 1)) ;;
    *) fail "${file#"$data"/}" "$(cat "$scratch/$name.said")" ;;
    esac
done <"$scratch/files"
[ $late -eq 0 ] || skip "$late of $(wc -l <"$scratch/files") files, the largest: not begun within $total s"
larger() { awk -v kb="$1" '$1 > kb { n++ } END { print n + 0 }' "$scratch/sizes" 2>/dev/null; }
[ ! -e "$scratch/sizes" ] || echo "# $(wc -l <"$scratch/files") files; left out: all but info and check on $(larger "$middle") files above $middle kB, second ways of each verb on $(larger "$small") above $small kB, render on $(larger $((small / 4))) above $((small / 4)) kB; norma view, which needs the page"
finish
