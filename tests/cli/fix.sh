#!/bin/bash
# norma check --fix over whole folders: what is mended is clean of what a safe fix mends, nothing gets worse, and mending twice changes nothing more.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
data=${NORMA_DATA:-$root/../shared/data}
[ -x "$norma" ] || { fail "the tool is there" "no program at $norma"; finish; exit 1; }

# left HOW REPORT: findings that HOW should have mended, one a line.
left() {
    node -e '
        const [how, file] = process.argv.slice(1), report = JSON.parse(require("fs").readFileSync(file));
        // N201: all other faces there agree with the normal; N202: at a knife\x27s edge there is no other; N301: a Moebius band; N404, N405: what crosses itself, or would be worse
        // cut (cloth.obj); N502: equal positions, but nothing else is.
        const never = new Set(["N201", "N202", "N301", "N404", "N405", "N502"]);
        for (const f of report.files) for (const x of f.findings)
            if (f.status === "checked" && (x.fix === "safe" || (how === "--fix-unsafe" && x.fix && !never.has(x.rule))))
                console.log(f.path, x.rule, x.where, x.count)' -- "$1" "$2"
}

# mend NAME HOW FILE...: mended twice into folders; files of one name are mended apart.
mend() {
    local name=$1 how=$2
    shift 2
    rm -rf "$scratch/once" "$scratch/twice"
    "$norma" check "$@" "$how" --out-dir "$scratch/once" --no-config --json >"$scratch/report.json" 2>"$scratch/err"
    local status=$?
    if [ "$status" = 2 ] || [ ! -s "$scratch/report.json" ]; then fail "$name $how: runs" "status $status: $(head -3 "$scratch/err")"; return; fi
    if [ -n "$(find "$scratch/once" -type f 2>/dev/null | head -1)" ]; then
        "$norma" check "$scratch/once" "$how" --out-dir "$scratch/twice" --no-config --quiet >"$scratch/twice.txt" 2>&1
        local different
        different=$(cd "$scratch/once" && find . -maxdepth 1 -type f \( -name '*.obj' -o -name '*.ply' -o -name '*.stl' -o -name '*.gl*' \) | while read -r file; do
            cmp -s "$file" "$scratch/twice/$file" || echo "$file"
        done)
        if [ -z "$different" ]; then pass "$name $how: mending twice changes nothing more"; else fail "$name $how: mending twice changes nothing more" "$different"; fi
    fi
    local rest
    rest=$(left "$how" "$scratch/report.json")
    if [ -z "$rest" ]; then pass "$name $how: nothing is left that it mends"; else fail "$name $how: nothing is left that it mends" "$rest"; fi
}

cd "$root" || exit 1
mend assets --fix assets
mend assets --fix-unsafe assets
if [ -d "$data" ]; then
    # A folder at a time, since names repeat between them; what is large is left to the benchmark.
    for folder in obj obj/dcc obj/box obj/lint obj/oracle ply stl bad/obj bad/ply bad/stl bad/glb gltf/misc gltf/quantized transform; do
        [ -d "$data/$folder" ] || continue
        mapfile -t files < <(find "$data/$folder" -maxdepth 1 -type f -size -2500k \( -name '*.obj' -o -name '*.ply' -o -name '*.stl' -o -name '*.glb' -o -name '*.gltf' \) | sort)
        [ "${#files[@]}" -gt 0 ] || continue
        mend "$folder" --fix "${files[@]}"
        mend "$folder" --fix-unsafe "${files[@]}"
    done
else
    skip "the folders of the data set (no $data)"
fi
finish
