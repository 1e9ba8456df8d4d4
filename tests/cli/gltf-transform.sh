#!/bin/bash
# Every glTF of the data set through the tool under a matrix, as a node and baked. Two judges that are not ours: the Khronos validator may say nothing about an
# output that it did not say about its input, and what is drawn, as read by tests/cli/validator/world.mjs, must be the input's, moved by the matrix.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
data=${NORMA_DATA:-$root/../shared/data}
norma=${NORMA_BIN:-$tree/bin/norma}
validator=$root/tests/cli/validator
export NODE_PATH=${NODE_PATH:-$root/build/npm/node_modules}

if [ ! -d "$data" ] || ! command -v node >/dev/null; then
    skip "the data set or node is not there"
    finish
    exit
fi

if [ ! -x "$norma" ]; then
    fail "the tool is not built: $norma"
    finish
    exit
fi

# transform_all NAME OPTIONS...: outputs into $scratch/NAME, pairs into NAME.all, those of sound inputs into NAME.sound; refusals of sound files fail.
transform_all() {
    local name=$1 number=0 file out wrong=""
    shift
    : >"$scratch/$name.all"
    : >"$scratch/$name.sound"
    while IFS= read -r file; do
        number=$((number + 1))
        mkdir -p "$scratch/$name/$number"
        out=$scratch/$name/$number/$(basename "$file")
        if "$norma" transform "$data/$file" -o "$out" --quiet "$@" 2>"$scratch/message"; then
            case $file in
            # Its buffer ends before views that nothing uses; in the output it does not, and the validator looks into what they now name.
            bad/gltf/IncorrectVertexArrays/*) ;;
            *) printf '%s\t%s\n' "$data/$file" "$out" >>"$scratch/$name.all" ;;
            esac
            case $file in
            bad/* | *draco*) ;;
            *) printf '%s\t%s\n' "$data/$file" "$out" >>"$scratch/$name.sound" ;;
            esac
        elif [[ $file != bad/* ]] && ! grep -q "^$file	.*	\(unsupported\|ok-or-unsupported\|ok-or-clear-error\)	" <(cut -f1,6 "$data/INDEX.tsv" | sed 's/\t/\t-\t/; s/$/\t/'); then
            wrong+=$(cat "$scratch/message")$'\n'
        fi
    done < <(cut -f1 "$data/INDEX.tsv" | grep -iE '\.(gltf|glb)$')
    if [ -z "$wrong" ]; then pass "$name: $(wc -l <"$scratch/$name.all") of $number files transformed"; else fail "$name: refused" "$wrong"; fi
}

judge() {
    local name=$1 output
    shift
    output=$(node "$validator/compare.mjs" --list "$scratch/$name.all" 2>&1)
    case $? in
    0) pass "$name, validator: $(tail -n 1 <<<"$output")" ;;
    77) skip "$output" ;;
    *) fail "$name, validator" "$output" ;;
    esac
    if output=$(node "$validator/world.mjs" --quiet "$@" --list "$scratch/$name.sound" 2>&1); then
        pass "$name, what is drawn: $(tail -n 1 <<<"$output")"
    else
        fail "$name, what is drawn" "$output"
    fi
}

mirrored="0.6 0 1.6 3  0 -0.5 0 -2  -0.8 0 1.2 11  0 0 0 1"
sheared="1 0.5 0 3  0 1 0.25 -2  0.125 0 -1.5 11  0 0 0 1"

transform_all node --matrix "$mirrored"
judge node --matrix "$mirrored"
transform_all baked --bake
judge baked --bake
transform_all baked-sheared --bake --matrix "$sheared"
judge baked-sheared --bake --matrix "$sheared"
finish
