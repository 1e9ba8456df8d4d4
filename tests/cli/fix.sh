#!/bin/bash
# norma check --fix over whole folders: what is mended is clean of what a safe fix mends, nothing gets worse, and mending twice changes nothing more.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
data=${NORMA_DATA:-$root/../shared/data}
[ -x "$norma" ] || { fail "the tool is there" "no program at $norma"; finish; exit 1; }

# left HOW REPORT ERRORS: findings that HOW should have mended, one a line; not those of which the tool says that they are not fixed, since another rule would report more
# (wuson.stl: N503 joins parts that then touch in points alone, N303).
left() {
    node -e '
        const [how, file, errors] = process.argv.slice(1), report = JSON.parse(require("fs").readFileSync(file));
        // N201: all other faces there agree with the normal; N202: at a knife\x27s edge there is no other; N301: a Moebius band; N404, N405: what crosses itself, or would be worse
        // cut (cloth.obj); N502: equal positions, but nothing else is; N401: without the face the surface would be open.
        const never = new Set(["N201", "N202", "N301", "N401", "N404", "N405", "N502"]);
        const refused = require("fs").readFileSync(errors, "utf8").split("\n").filter((line) => line.includes(" is not fixed"));
        // Informations are mended by unsafe fixes only where their rule is selected.
        // A count that it names is the count that may be left: facets whose winding is wrong, not their normals (N205).
        const refuses = (path, x) => refused.some((line) => line.startsWith(`norma: ${path}: ${x.rule} `) && x.count <= (line.match(/ is not fixed for ([0-9]+) /)?.[1] ?? Infinity));
        for (const f of report.files) for (const x of f.findings)
            if (!refuses(f.path, x) && f.status === "checked" && (x.fix === "safe" || (how === "--fix-unsafe" && x.fix && x.severity !== "info" && !never.has(x.rule))))
                console.log(f.path, x.rule, x.where, x.count)' -- "$1" "$2" "$3"
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
        # A file is written where something was fixed; where nothing was, there is none, but the file must have been read.
        "$norma" check "$scratch/once" "$how" --out-dir "$scratch/twice" --no-config --json >"$scratch/twice.json" 2>"$scratch/twice.txt"
        local different
        different=$(find "$scratch/twice" -type f 2>/dev/null
            node -e '
                const [folder, file] = process.argv.slice(1), fs = require("fs"), path = require("path");
                const read = new Set(JSON.parse(fs.readFileSync(file)).files.filter((f) => f.status !== "unreadable").map((f) => path.basename(f.path)));
                for (const name of fs.readdirSync(folder)) if (/\.(obj|ply|stl|glb|gltf)$/.test(name) && !read.has(name)) console.log(`${name}: not read again`);' \
                -- "$scratch/once" "$scratch/twice.json" 2>&1)
        if [ -z "$different" ]; then pass "$name $how: mending twice changes nothing more"; else fail "$name $how: mending twice changes nothing more" "$different"; fi
    fi
    local rest
    rest=$(left "$how" "$scratch/report.json" "$scratch/err")
    if [ -z "$rest" ]; then pass "$name $how: nothing is left that it mends"; else fail "$name $how: nothing is left that it mends" "$rest"; fi
}

# harmless NAME FOLDER FILE...: no fix, alone or with all others, opens what is closed (fix-closed.mjs finds edges by itself), and no rule reports more at warning or above than before.
harmless() {
    local name=$1 folder=$2 rule compared=0
    shift 2
    "$norma" check "$@" --no-config --json >"$scratch/before.json" 2>/dev/null
    for rule in N2 N201 N202 N301 N302 N305 N401 N404 N405 N502 N503 N; do
        rm -rf "$scratch/fixed"
        "$norma" check "$@" --fix-unsafe --select "$rule" --no-config --quiet --out-dir "$scratch/fixed" >/dev/null 2>&1
        [ -n "$(find "$scratch/fixed" -type f 2>/dev/null | head -1)" ] || continue # nothing was fixed
        compared=$((compared + 1))
        (cd "$scratch/fixed" && "$norma" check . --no-config --json) >"$scratch/after.json" 2>/dev/null
        node "$root/tests/cli/fix-closed.mjs" "$folder" "$scratch/fixed" >"$scratch/closed" 2>&1
        node -e '
            const weigh = (path) => {
                const sums = new Map();
                for (const file of JSON.parse(require("fs").readFileSync(path)).files)
                    for (const x of file.findings.filter((x) => x.severity !== "info")) {
                        const key = require("path").basename(file.path) + " " + x.rule, sum = sums.get(key) ?? { count: 0, error: false };
                        sums.set(key, { count: sum.count + x.count, error: sum.error || x.severity === "error" });
                    }
                return sums;
            };
            const [before, after] = process.argv.slice(1).map(weigh);
            for (const [key, is] of after) {
                const was = before.get(key) ?? { count: 0, error: false };
                if (is.count > was.count || (is.error && !was.error)) console.log(key, was, is);
            }' "$scratch/before.json" "$scratch/after.json" >"$scratch/grown" 2>&1
        if [ "$(wc -l <"$scratch/closed")" = 1 ] && grep -q ' compared$' "$scratch/closed" && [ ! -s "$scratch/grown" ]; then
            pass "$name --select $rule: nothing is opened, no rule reports more ($(cat "$scratch/closed"))"
        else
            fail "$name --select $rule: nothing is opened, no rule reports more" "$(head -20 "$scratch/closed" "$scratch/grown")"
        fi
    done
    [ "$compared" -gt 0 ] || fail "$name: some rule fixes some file" "none of $# files"
}

cd "$root" || exit 1
# A closed box with a T: a point on one edge that only a face without area joins. The face stays; one that joins nothing goes.
printf 'v %s\n' '0 0 0' '1 0 0' '1 1 0' '0 1 0' '0 0 1' '1 0 1' '1 1 1' '0 1 1' '.5 0 1' >"$scratch/box.obj"
printf 'f %s\n' '1 4 3 2' '5 6 7 8' '1 2 6 9 5' '2 3 7 6' '3 4 8 7' '4 1 5 8' '5 9 6' '1 2 2' >>"$scratch/box.obj"
"$norma" check "$scratch/box.obj" --fix-unsafe --select N401 -o "$scratch/box.fixed.obj" >/dev/null 2>&1
if diff <(grep ^f "$scratch/box.obj" | head -7) <(grep ^f "$scratch/box.fixed.obj") >/dev/null; then
    pass "a face without area that closes a surface stays, another goes"
else
    fail "a face without area that closes a surface stays, another goes" "$(grep ^f "$scratch/box.fixed.obj")"
fi
mend assets --fix assets
mend assets --fix-unsafe assets
harmless assets assets assets/*.obj assets/*.stl
if [ -d "$data" ]; then
    # A folder at a time, since names repeat between them; what is large is left to the benchmark.
    for folder in obj obj/dcc obj/box obj/lint obj/oracle ply stl bad/obj bad/ply bad/stl bad/glb gltf/misc gltf/quantized transform; do
        [ -d "$data/$folder" ] || continue
        mapfile -t files < <(find "$data/$folder" -maxdepth 1 -type f -size -2500k \( -name '*.obj' -o -name '*.ply' -o -name '*.stl' -o -name '*.glb' -o -name '*.gltf' \) | sort)
        [ "${#files[@]}" -gt 0 ] || continue
        mend "$folder" --fix "${files[@]}"
        mend "$folder" --fix-unsafe "${files[@]}"
    done
    for folder in obj obj/dcc obj/lint stl bad/obj bad/stl; do
        mapfile -t files < <(find "$data/$folder" -maxdepth 1 -type f -size -300k \( -name '*.obj' -o -name '*.stl' \) | sort)
        [ "${#files[@]}" -gt 0 ] || continue
        harmless "$folder" "$data/$folder" "${files[@]}"
    done
else
    skip "the folders of the data set (no $data)"
fi
# Where a fix cannot be written, the report is about the file as it is: nothing is said to be fixed, nor counted as if it were.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3\n' >"$scratch/twice.obj"
"$norma" check "$scratch/twice.obj" --fix-unsafe --no-config -o /dev/full >"$scratch/said" 2>/dev/null
check "a fix that cannot be written ends with 3" test $? -eq 3
"$norma" check "$scratch/twice.obj" --no-config 2>/dev/null | grep -v 'infos not listed' >"$scratch/as-it-is"
check "and the report is that of the file as it is" cmp "$scratch/said" "$scratch/as-it-is"

# Meshes are not looked for among all findings, nor findings among all: within half a second of the processor, where it were half a minute.
awk -v n=6000 'BEGIN {
    printf "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":72,\"uri\":\"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAABAAIAAAADAAEAAAACAAMAAQADAAIA\"}],"
    printf "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":24}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\","
    printf "\"min\":[0,0,0],\"max\":[1,1,1]},{\"bufferView\":1,\"componentType\":5123,\"count\":12,\"type\":\"SCALAR\"}],\"meshes\":["
    for (i = 0; i < n; i++) printf "%s{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}", i ? "," : ""
    printf "],\"nodes\":["
    for (i = 0; i < n; i++) printf "%s{\"mesh\":%d,\"translation\":[%d,0,0]}", i ? "," : "", i, 3 * i
    printf "],\"scene\":0,\"scenes\":[{\"nodes\":["
    for (i = 0; i < n; i++) printf "%s%d", i ? "," : "", i
    print "]}]}"
}' >"$scratch/many.gltf"
(ulimit -t 4; exec "$norma" check "$scratch/many.gltf" --no-config --threads 1 --quiet --fix-unsafe -o "$scratch/many.fixed.gltf") >"$scratch/said" 2>&1
check "6,000 meshes are turned in time" test $? -eq 0
check "and all of them" grep -q '^0 errors, 0 warnings' "$scratch/said"

# Nor what is known of each, while one rule is tried: two seconds, where it were thirteen. The fix is refused in each, as N207 would grow.
sed 's/"POSITION":0/"POSITION":0,"NORMAL":0/g' "$scratch/many.gltf" >"$scratch/known.gltf"
(ulimit -t 6; exec "$norma" check "$scratch/known.gltf" --no-config --threads 1 --quiet --fix --select N102 -o "$scratch/known.fixed.gltf") >"$scratch/said" 2>&1
check "one rule is tried in 6,000 meshes in time" grep -q '^6000 errors, 0 warnings' "$scratch/said"
finish
