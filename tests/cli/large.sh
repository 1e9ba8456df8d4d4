#!/bin/bash
# Files larger than the memory allowed: compute and info stay within --max-memory and give the bytes that they give without it; a signal, a full disk and a kill leave the old
# file whole; a person sees the passes.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
cd "$scratch" || exit 1
cc=${CC:-cc}
for maker in make_meshes run_best; do
    if ! $cc -std=gnu11 -O2 "$root/bench/$maker.c" -o "$maker" -lm 2>log; then
        fail "$maker compiles" "$(cat log)"
        finish
        exit
    fi
done

# peak LIMIT-IN-MB NAME COMMAND...: its largest resident set, mapped files included.
peak() {
    local limit=$1 name=$2 best
    shift 2
    best=$(./run_best 1 "$@" 2>log | awk '{ print int($3) }')
    if [ -n "$best" ] && [ "$best" -le "$limit" ]; then pass "$name ($best of $limit MB)"; else fail "$name" "peak ${best:-unknown} MB; expected at most $limit; $(cat log)"; fi
}

./make_meshes ply 3000000 in.ply
./make_meshes stl 1000000 in.stl
for kind in ply stl; do
    "$norma" compute in.$kind -o whole.$kind --quiet
    rm -f out.$kind
    peak 48 "compute of a $kind stays within 48M" "$norma" compute in.$kind -o out.$kind --max-memory 48M --quiet
    check "$kind: the bytes are those without a limit" cmp whole.$kind out.$kind
    peak 48 "info of a $kind stays within 48M" "$norma" info in.$kind --max-memory 48M
    "$norma" info in.$kind >expected
    check "$kind: info says what it says without a limit" diff <("$norma" info in.$kind --max-memory 48M) expected
done
for weld in none exact; do
    "$norma" compute in.ply --weld $weld --max-memory 48M --threads 1 --json -o out.ply >summary
    check "--weld $weld: the same bytes, the surface has no seam" cmp whole.ply out.ply
done
if grep -qE '"passes": [0-9]+' summary; then pass "the summary counts the passes"; else fail "the summary counts the passes" "$(cat summary)"; fi

status=0
"$norma" compute in.ply --crease 30 -o no.ply --max-memory 48M 2>said || status=$?
if [ "$status" = 3 ] && grep -q 'creases need the whole file; allow more memory' said && [ ! -e no.ply ]; then pass "a crease is refused in passes"; else fail "a crease is refused in passes" "status $status: $(cat said)"; fi
status=0
"$norma" compute in.ply -o - --max-memory 48M >piped 2>said || status=$?
if [ "$status" = 3 ] && [ ! -s piped ]; then pass "standard output is refused in passes"; else fail "standard output is refused in passes" "status $status: $(cat said)"; fi

# check, part by part: what the rules that need no neighbours find in the whole file.
meshes=$root/tests/cli/large_meshes.py
expected_rules=(ply "N002 N101 N102 N103 N401 N402" ply-double-scattered "N002 N101 N102 N103 N401 N402" ply-big-bare "N002 N104 N401 N402" ply-byte "N002 N102 N103 N401 N402 N702"
    ply-quads-scattered "N002 N101 N102 N103 N401 N402 N404 N404 N405" ply-quads-first "N002 N101 N102 N103 N401 N402 N404 N404 N405" stl-leaning "N002 N101 N205 N401 N402"
    ply-far "N002 N101 N102 N103 N401 N402 N701" stl-far "N002 N101 N205 N401 N402 N701")
for ((i = 0; i < ${#expected_rules[@]}; i += 2)); do
    kind=${expected_rules[i]}
    file=$kind.${kind%%-*}
    python3 "$meshes" make "$kind" "$file"
    "$norma" check "$file" --no-config --json >whole.json
    status=$?
    "$norma" check "$file" --no-config --json --max-memory 20M --threads $((i % 3 + 1)) >parts.json
    if [ $? != $status ]; then fail "check $kind: exit status" "$?, whole $status"; fi
    found=$(python3 "$meshes" compare whole.json parts.json 2>said)
    if [ "$found" = "${expected_rules[i + 1]}" ]; then pass "check $kind in parts: $found"; else fail "check $kind in parts" "$found, expected ${expected_rules[i + 1]}; $(cat said)"; fi
done
for kind in ply stl; do peak 48 "check of a $kind stays within 48M" "$norma" check in.$kind --no-config --max-memory 48M --fail-on never; done
# The report on many files goes to its file piece by piece.
mkdir many
{
    for ((i = 0; i < 1000; ++i)); do echo "v $i 0 0"; echo "v $i 1 0"; echo "v $i 0 1"; echo "vn 0 0 0"; done
    for ((i = 1; i <= 1000; ++i)); do echo "f $((3 * i - 2))//$i $((3 * i - 1))//$i $((3 * i))//$i"; done
} >many/1.obj
for ((i = 2; i <= 600; ++i)); do ln many/1.obj "many/$i.obj"; done
for form in json sarif; do
    peak 24 "a report in $form that is larger than the memory it takes" "$norma" check many --no-config --select N102,N103 --max-samples 1000 --fail-on never -o "many.$form"
done
if [ "$(stat -c %s many.json)" -gt 40000000 ]; then pass "that report has more than 40 MB"; else fail "that report has more than 40 MB" "$(stat -c %s many.json)"; fi
# Merging reads reports entry by entry, and keeps of each only where it stands.
python3 - many.sarif <<'END'
import json, sys
finding = {"rule": "N204", "severity": "info", "where": "", "message": "words " * 100}
for part in range(2):
    files = [json.dumps({"path": f"models/{i % 1000}/{i}.obj", "status": "checked", "findings": [finding]}) for i in range(part, 20000, 2)]
    with open(f"part{part}.json", "w") as out: out.write('{"schema": "norma-check/1", "files": [\n' + ",\n".join(files) + '\n], "summary": {"exit_status": 0}}\n')
sarif = json.load(open(sys.argv[1]))
sarif["runs"][0]["results"] *= 20
with open("results.sarif", "w") as out: out.write(json.dumps(sarif))
END
peak 12 "20,000 entries are merged" "$norma" report --merge part0.json part1.json -o merged.json
check "and all are there" python3 -c 'import json; paths = [file["path"] for file in json.load(open("merged.json"))["files"]]; assert len(set(paths)) == 20000 and paths == sorted(paths)'
peak 12 "20,000 entries become lines" "$norma" report --merge part0.json part1.json --info -o merged.line --format line
peak 12 "thousands of results are merged" "$norma" report --merge results.sarif -o merged.sarif
check "and all are there" [ "$(grep -c '^{"ruleId"' merged.sarif)" -eq "$((20 * $(grep -c '^{"ruleId"' many.sarif)))" ]
peak 24 "large entries are merged" "$norma" report --merge many.json -o merged.json

# A report that changes between its two readings. The pipe is full while the merged report is written, so the change comes in time.
for change in ": >changing.json" "truncate -s -2000000 changing.json" "printf x | dd of=changing.json bs=1 seek=3000000 conv=notrunc 2>/dev/null"; do
    cp part0.json changing.json
    "$norma" report --merge changing.json 2>said | { head -c 100 >/dev/null && eval "$change" && cat >/dev/null; }
    status=${PIPESTATUS[0]}
    if [ "$status" = 3 ] && grep -q '^norma: changing.json: byte [0-9]*: the entry of models/.*.obj changed while the reports were joined$' said; then pass "seen: $change"; else fail "seen: $change" "status $status: $(cat said)"; fi
done
for ((try = 0; try < 5; ++try)); do # cut short as soon as the merged report is begun, which may be late
    cp part0.json changing.json
    rm -rf joined && mkdir joined
    "$norma" report --merge changing.json --format html -o joined/all.html 2>said &
    child=$!
    for ((wait = 0; wait < 1000; ++wait)); do
        if [ ! -e /proc/$child/fd ] || readlink /proc/$child/fd/* | grep -q joined; then break; fi
    done
    truncate -s 1000 changing.json
    status=0
    wait $child || status=$?
    if [ "$status" = 3 ]; then break; fi
done
if [ "$status" = 3 ] && grep -q 'changed while the reports were joined' said && [ -z "$(ls -A joined)" ]; then pass "a report cut short leaves no file"; else fail "a report cut short leaves no file" "status $status, $(ls -A joined): $(cat said)"; fi

for form in text line json sarif html; do
    "$norma" check ply.ply --no-config --max-memory 20M --format $form >report 2>said
    if grep -q 'N002' report && grep -q 'N302, N303' report; then pass "$form names the rules that were not applied"; else fail "$form names the rules that were not applied" "$(head -c 2000 report)"; fi
done
in_parts() { # NAME STATUS ARGUMENTS...
    local name=$1 expected=$2 status=0
    shift 2
    "$norma" check --no-config --max-memory 20M "$@" >report 2>said || status=$?
    if [ $status = "$expected" ]; then pass "$name"; else fail "$name" "status $status, expected $expected: $(cat report said)"; fi
}
in_parts "check in parts is no pass" 1 ply-big-bare.ply --fail-on warning
check "and counts as not checked" grep -q '1 not checked' report
./make_meshes ply 200000 sound.ply # those above have faces whose positions are NaN
in_parts "rules that need no neighbours are all there is to it" 0 sound.ply --select N1,N401 --fail-on warning
check "and nothing is left unchecked" sh -c '! grep -q "not checked" report'
in_parts "--fix is refused in parts" 3 ply.ply --fix -o fixed.ply
check "with a reason" grep -q 'fixing needs the whole file' said
check "and writes nothing" [ ! -e fixed.ply ]
in_parts "a baseline in parts is written" 0 ply.ply --write-baseline known.json
in_parts "and known" 0 ply.ply --baseline known.json --fail-on info
for i in 1 2; do "$norma" check --no-config --max-memory 20M ply.ply ply-byte.ply --shard $i/2 --json -o shard$i.json --fail-on never; done
check "shards in parts have their files, each once" [ "$(cat shard1.json shard2.json | grep -oE '"path": "(ply|ply-byte).ply"' | sort | uniq -u | wc -l)" = 2 ]
head -c 1500000 ply.ply >short.ply
in_parts "a file that ends early is unreadable in parts" 3 short.ply
check "and N001 says why" grep -q 'N001 unreadable: .*the file ends' report

# The old file stays: a limit on the size of files stands for a full disk.
mkdir out
head -c 1000000 in.ply >old
set -m
for way in full INT TERM KILL; do
    cp old out/old.ply
    if [ $way = full ]; then
        status=0
        (ulimit -f 20000; "$norma" compute in.ply -o out/old.ply --max-memory 48M >/dev/null 2>said) || status=$?
        expected=3
    else
        "$norma" compute in.ply -o out/old.ply --max-memory 48M >/dev/null 2>said &
        child=$!
        sleep 0.15
        kill -$way $child 2>/dev/null
        wait $child 2>/dev/null
        status=$?
        case $way in INT) expected=130 ;; TERM) expected=143 ;; KILL) expected=137 ;; esac
    fi
    if [ "$status" = 0 ]; then skip "$way: it ended before"; continue; fi
    if [ "$status" = $expected ] && cmp -s old out/old.ply && [ "$(ls -A out)" = old.ply ]; then pass "$way: the old file is whole, and nothing is beside it"; else fail "$way: the old file is whole" "status $status, $(ls -A out): $(cat said)"; fi
done

# In place.
cp in.ply here.ply
"$norma" compute here.ply --in-place --max-memory 48M --quiet
check "in place: the same bytes" cmp whole.ply here.ply

if command -v script >/dev/null; then
    TERM=xterm script -qec "$norma compute in.ply -o out.ply --max-memory 20M" /dev/null </dev/null 2>&1 | tr '\r' '\n' >shown
    if grep -qE '^computing, pass [0-9]+ of [0-9]+, in.ply: +[0-9]+ %' shown; then pass "a person sees the passes"; else skip "a person sees the passes (it was too quick)"; fi
else
    skip "script(1) is not there"
fi
finish
