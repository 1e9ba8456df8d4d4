#!/bin/bash
# Every glTF of the data set through norma compute. Two judges that are not ours: the Khronos validator may say nothing about an output that it did not say about its
# input, and tests/cli/validator/corners.mjs, which reads both with code of its own, must find all but normals and tangents as they were.
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

# compute_all NAME OPTIONS...: outputs into $scratch/NAME, pairs into NAME.all, those of sound inputs into NAME.sound; refusals of sound files fail.
compute_all() {
    local name=$1 number=0 file expect out wrong=""
    shift
    : >"$scratch/$name.all"
    : >"$scratch/$name.sound"
    while IFS=$'\t' read -r file expect; do
        number=$((number + 1))
        mkdir -p "$scratch/$name/$number"
        out=$scratch/$name/$number/$(basename "$file")
        if "$norma" compute "$data/$file" -o "$out" --quiet "$@" 2>"$scratch/message"; then
            printf '%s\t%s\n' "$data/$file" "$out" >>"$scratch/$name.all"
            case $file in
            bad/*) ;;
            *) printf '%s\t%s\n' "$data/$file" "$out" >>"$scratch/$name.sound" ;;
            esac
        elif [ "$expect" = ok ] || [ "$expect" = lint ]; then
            wrong+=$(cat "$scratch/message")$'\n'
        fi
    done < <(cut -f1,6 "$data/INDEX.tsv" | grep -iE '\.(gltf|glb)	')
    if [ -z "$wrong" ]; then pass "$name: $(wc -l <"$scratch/$name.all") of $number files computed"; else fail "$name: refused" "$wrong"; fi
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
    if output=$(node "$validator/corners.mjs" --quiet "$@" --list "$scratch/$name.sound" 2>&1); then
        pass "$name, all but the normals: $(tail -n 1 <<<"$output")"
    else
        fail "$name, all but the normals" "$output"
    fi
}

compute_all crease
judge crease
compute_all smooth --smooth --morphs
judge smooth
compute_all flat --flat
judge flat --flat
finish
