# gltf_judges.sh: what the tests share that put every glTF of the data set through the tool and ask judges that are not ours about the outputs.
# shellcheck shell=bash
# shellcheck source=tests/support/tap.sh
source "$(dirname "${BASH_SOURCE[0]}")/tap.sh"
data=${NORMA_DATA:-$root/../shared/data}
norma=${NORMA_BIN:-$tree/bin/norma}
validator=$root/tests/cli/validator
export NODE_PATH=${NODE_PATH:-$root/build/npm/node_modules}

command -v node >/dev/null || { skip "node is not there"; finish; exit; }
[ -x "$norma" ] || { fail "the tool is there" "no program at $norma"; finish; exit 1; }

needs_data() { [ -d "$data" ] || { skip "the data set is not there"; finish; exit; }; }

# judge_validity NAME LIST: the Khronos validator has nothing to say about an output that it did not say about its input.
judge_validity() {
    local output
    output=$(node "$validator/compare.mjs" --list "$2" 2>&1)
    case $? in
    0) pass "$1, validator: $(tail -n 1 <<<"$output")" ;;
    77) skip "$output" ;;
    *) fail "$1, validator" "$output" ;;
    esac
}

# judge NAME WHAT PROGRAM OPTIONS...: the validator on the pairs in NAME.all, the program on those in NAME.sound.
judge() {
    local name=$1 what=$2 program=$3 output
    shift 3
    judge_validity "$name" "$scratch/$name.all"
    if output=$(node "$validator/$program" --quiet "$@" --list "$scratch/$name.sound" 2>&1); then
        pass "$name, $what: $(tail -n 1 <<<"$output")"
    else
        fail "$name, $what" "$output"
    fi
}

# run_all NAME VERB OPTIONS...: outputs into $scratch/NAME, pairs into NAME.all, those of sound inputs into NAME.sound; refusals of sound files fail.
# The script says which are which: is_judged FILE, is_sound FILE, may_refuse FILE EXPECTATION.
run_all() {
    local name=$1 verb=$2 number=0 file expect out wrong=""
    shift 2
    : >"$scratch/$name.all"
    : >"$scratch/$name.sound"
    while IFS=$'\t' read -r file expect; do
        number=$((number + 1))
        mkdir -p "$scratch/$name/$number"
        out=$scratch/$name/$number/$(basename "$file")
        if "$norma" "$verb" "$data/$file" -o "$out" --quiet "$@" 2>"$scratch/message"; then
            is_judged "$file" && printf '%s\t%s\n' "$data/$file" "$out" >>"$scratch/$name.all"
            is_sound "$file" && printf '%s\t%s\n' "$data/$file" "$out" >>"$scratch/$name.sound"
        elif ! may_refuse "$file" "$expect"; then
            wrong+=$(cat "$scratch/message")$'\n'
        fi
    done < <(cut -f1,6 "$data/INDEX.tsv" | grep -iE '\.(gltf|glb)	')
    if [ -z "$wrong" ]; then pass "$name: $(wc -l <"$scratch/$name.all") of $number files"; else fail "$name: refused" "$wrong"; fi
}
