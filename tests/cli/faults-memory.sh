#!/bin/bash
# Memory that runs out: every allocation of every verb fails once, and from there on, each in a run of its own. The tool then says so, exits with 3 and has written nothing, or
# it can do without, and does and says what it always does.
#   tests/cli/faults-memory.sh [PATTERN]
# FAULT_ALL=1: also with all allocations failing from the n-th on for the long cases.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
export NORMA=${NORMA_BIN:-$tree/bin/norma}
calls=$tree/tests/fault_calls
export MESA_SHADER_CACHE_DISABLE=true LC_ALL=C.UTF-8
fast=$scratch/fast
if [ -d /dev/shm ] && [ -w /dev/shm ]; then fast=$(mktemp -d /dev/shm/norma-faults-XXXXXX); trap 'rm -rf "$fast"; [ -n "${NORMA_SCRATCH:-}" ] || rm -rf "$scratch"' EXIT; fi
mkdir -p "$fast/from"

# one PLACE NAME COMMAND...: prints its verdict.
one() {
    local place=$1 name=$2 final bad number
    shift 2
    [[ $name != *render ]] || export FAULT_PROGRAM=1 # what the graphics libraries do without memory is theirs
    # shellcheck disable=SC2086  # words
    "$calls" "memory=$place/fail.so" "$place/from" "$place/$$" "$place/$$-states" -- $1 >"$place/$$.lines" 2>&1 || { echo "not ok $name: $(tail -n 1 "$place/$$.lines")"; return; }
    final=$(grep ' | ' "$place/$$.lines" | tail -n 1)
    bad=$(awk -F' [|] ' -v final="$final" '
        BEGIN { split(final, end, " [|] ") }
        !/ \| / { next }
        $2 == end[2] && $3 == end[3] && $4 == 0 && $5 == end[5] { next }
        html && $2 == end[2] && $4 == 0 { next } # a picture may be missing
        # Of several files some may be done, each whole; a baseline of what could be looked at is whole as well.
        $2 == 3 && $4 == 0 && ($3 == first || first == "" || $3 == end[3] || may_half) && tolower($6) ~ /memory/ { if (first == "") first = $3; next }
        { print }' may_half="$([[ $name == *baseline* || $name == *folder ]] && echo 1)" html="$([[ $name == *html ]] && echo 1)" "$place/$$.lines" | head -n 12)
    number=$(sed -nE 's/^runs ([0-9]+) .*/\1/p' "$place/$$.lines")
    if [ -z "$bad" ] && [ "$(sed -E 's/^0 [^|]*\| ([0-9-]+) .*/\1/' <<<"$final")" -le 1 ]; then echo "ok $name: $((number - 1)) failed allocations"; else printf 'not ok %s: in the end: %s\n' "$name" "$final"; sed "s/^/# /" <<<"$bad"; fi
}

cases() {
    local format
    for format in cube.obj roof.ply corner.stl roof.gltf roof.glb; do
        echo "compute $format|$NORMA compute $format -o out.${format##*.} --threads 1"
        echo "compute $format in place, flat, json|$NORMA compute $format --in-place --flat --json --threads 2"
        echo "transform $format|$NORMA transform $format -o out.${format##*.} --scale 2,1,1 --threads 1"
        echo "info $format|$NORMA info $format --deep --threads 1"
        echo "check $format|$NORMA check $format --threads 1"
        echo "check --fix $format|$NORMA check --fix $format -o out.${format##*.} --threads 1"
        [ -z "${has_page:-}" ] || echo "view $format|$NORMA view $format -o out.html --threads 1"
    done
    echo "transform --bake, an asset in place|$NORMA transform roof.gltf --in-place --rotate 0,0,1,30 --bake --threads 1"
    echo "check --fix-unsafe, an asset in place|$NORMA check --fix-unsafe --select N roof.gltf --in-place --threads 1"
    echo "check --fix-unsafe glb|$NORMA check --fix-unsafe --select N roof.glb --in-place --threads 1"
    echo "check --fix-unsafe 3mf|$NORMA check --fix-unsafe --select N3 turned.3mf -o out.3mf --threads 1"
    for format in json sarif html; do echo "check --format $format|$NORMA check cube.obj roof.gltf broken.obj --format $format --threads 1"; done
    echo "check of a folder, two threads|$NORMA check . --threads 2"
    echo "check --write-baseline|$NORMA check cube.obj roof.ply --write-baseline=packed/base.json --threads 1"
    echo "check --baseline|$NORMA check cube.obj roof.ply --baseline=known/base.json --threads 1"
    echo "check --config|$NORMA check roof.glb --config=known/config.json --select N601 --threads 1"
    echo "report --merge|$NORMA report --merge known/a.json known/b.json -o out.html"
    echo "tangents|$NORMA tangents charts.gltf -o out.gltf --threads 1"
    echo "pack|$NORMA pack charts.gltf -o out.gltf --max-error 1"
    echo "info --json|$NORMA info cube.obj roof.gltf --json"
    echo "compute to standard output|$NORMA compute cube.obj -o - --threads 1"
    echo "compute to a folder|$NORMA compute cube.obj roof.ply --out-dir out --threads 1"
    echo "compute of what Draco packed|$NORMA compute packed/draco.glb -o out.glb --smooth --quiet --threads 1"
    echo "compare|$NORMA compare roof.gltf cube.obj --threads 1"
    echo "compare --json|$NORMA compare cube.obj cube.obj --json --threads 1"
    [ ! -e "$fast/from/known/shot.png" ] || for form in "-o marked.png" --json --tap; do echo "acid --judge $form|$NORMA acid --judge known/shot.png --scene known/acid.json $form"; done
    echo "seams votes|$NORMA seams votes known/borders.obj roof.ply -o out.votes --threads 1"
    echo "seams merge|$NORMA seams merge known/a.votes known/b.votes -o out.votes --threads 1"
    echo "matrix|$NORMA matrix --scale 2,0.5,1 --rotate 0,1,0,30"
    echo "explain|$NORMA explain N501"
    [ -z "$has_renderer" ] || echo "render|$NORMA render cube.obj -o picture.png --size 16x16 --renderer software --threads 1"
}

if [ "${1:-}" = --one ]; then
    one "$FAULT_PLACE" "${2%%|*}" "${2#*|}"
    exit
fi
[ -x "$NORMA" ] && [ -x "$calls" ] || { fail "the tools are there" "no program at $NORMA or $calls"; finish; exit 1; }
"${CC:-cc}" -O1 -shared -fPIC -o "$fast/fail.so" "$root/tests/cli/faults/fail_allocation.c" -ldl 2>/dev/null && LD_PRELOAD=$fast/fail.so "$NORMA" --version >/dev/null 2>&1 ||
    { skip "allocations cannot be made to fail here: not glibc, or no preloading"; finish; exit; }
has_page=$("$NORMA" view "$root/tests/cli/golden/files/cube.obj" -o "$scratch/page.html" >/dev/null 2>&1 && echo yes)
has_renderer=$("$NORMA" render "$root/tests/cli/golden/files/cube.obj" -o "$scratch/picture.png" --size 16x16 >/dev/null 2>&1 && echo yes)
[ -n "$has_renderer" ] || skip "render: nothing can be drawn here"
cp "$root"/tests/cli/golden/files/* "$fast/from/"
cp "$root/tests/tangent/charts.gltf" "$fast/from/"
rm "$fast/from/malformed.obj"
mkdir "$fast/from/packed"
cp "$root/tests/fuzz/corpus/glb/draco" "$fast/from/packed/draco.glb"
mkdir "$fast/from/known"
(cd "$fast/from" && "$NORMA" check cube.obj roof.ply --write-baseline=known/base.json >/dev/null
    "$NORMA" check cube.obj roof.ply --shard 1/2 -o known/a.json && "$NORMA" check cube.obj roof.ply --shard 2/2 -o known/b.json)
echo '{"profile": "pr\u0069nt", "overrides": [{"files": ["a*", "*"], "ignore": ["N1"]}, {"meshes": ["roof"], "nodes": ["left"], "ignore": ["N6"]}]}' >"$fast/from/known/config.json"
[ ! -x "$tree/tests/acid_screens" ] || (cd "$fast/from/known" && "$tree/tests/acid_screens" layout acid.json && "$tree/tests/acid_screens" shot 1 shot.png >/dev/null)
# More borders than one block of votes has records.
awk 'BEGIN { for (i = 0; i < 100; i++) printf "v %d 0 0\nv %d 1 0\nv %d 0 1\nf %d %d %d\n", i, i, i, 3 * i + 1, 3 * i + 2, 3 * i + 3 }' >"$fast/from/known/borders.obj"
(cd "$fast/from" && "$NORMA" seams votes known/borders.obj -o known/a.votes --quiet && "$NORMA" seams votes roof.ply -o known/b.votes --quiet)
chmod u+w "$fast/from"/*
cases | grep -E -- "${1:-.}" >"$scratch/cases"
FAULT_PLACE=$fast xargs -P "${JOBS:-$(nproc)}" -d '\n' -n 1 bash "$0" --one <"$scratch/cases" >"$scratch/verdicts" 2>"$scratch/errors"
grep -vE '^(check --fix-unsafe|transform --bake)' "$scratch/cases" | grep -E "${FAULT_ALL:+.|}(gltf|ply|broken|folder)" | sed 's/^/from there on: /' >"$scratch/cases-on"
FAULT_FROM_THERE_ON=1 FAULT_PLACE=$fast xargs -r -P "${JOBS:-$(nproc)}" -d '\n' -n 1 bash "$0" --one <"$scratch/cases-on" >>"$scratch/verdicts" 2>>"$scratch/errors"
total=0
while IFS= read -r line; do
    case $line in
    'ok '*) pass "${line#ok }"; number=$(sed -nE 's/.*: ([0-9]+) failed.*/\1/p' <<<"$line"); total=$((total + ${number:-0})) ;;
    'not ok '*) fail "${line#not ok }" ;;
    *) echo "$line" ;;
    esac
done <"$scratch/verdicts"
[ "$(grep -cE '^(ok|not ok) ' "$scratch/verdicts")" -ge "$(cat "$scratch/cases" "$scratch/cases-on" | wc -l)" ] || fail "every case gave a verdict" "$(cat "$scratch/errors")"
# The acid scenes take so many allocations that only some fail: all scenes are there then, or none.
if [ -z "${1:-}" ] && "$NORMA" acid -o "$scratch/all" --quiet 2>/dev/null; then
    bad='' reached=0 refused=0
    for ((n = 1; ; n = n + n / 3 + 1)); do
        rm -rf "$scratch/acid" "$scratch/hit"
        status=0
        FAULT_ALLOCATION=$n LD_PRELOAD=$fast/fail.so "$NORMA" acid -o "$scratch/acid" --quiet 199>"$scratch/hit" 2>"$scratch/said" || status=$?
        [ -s "$scratch/hit" ] || break
        reached=$((reached + 1))
        case $status in
        0) diff -r "$scratch/all" "$scratch/acid" >/dev/null || bad="$bad; allocation $n: not all scenes are there" ;;
        3) refused=$((refused + 1)); grep -qi memory "$scratch/said" && [ ! -e "$scratch/acid" ] || bad="$bad; allocation $n: $(cat "$scratch/said"), $(find "$scratch/acid" -type f 2>/dev/null | wc -l) files are left" ;;
        *) bad="$bad; allocation $n: status $status" ;;
        esac
    done
    if [ -z "$bad" ] && [ $refused -gt 10 ]; then pass "acid -o: $reached failed allocations"; else fail "acid -o: all scenes or none" "$refused of $reached refused$bad"; fi
    total=$((total + reached))
fi
echo "# $total failed allocations"
finish
