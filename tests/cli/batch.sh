#!/bin/bash
# One file's fault never ends a batch: the file is named, as unreadable (N001) in reports, all others are worked on, and the status is 3. A preloaded library ends the tool where it
# opens a file with "faulty" in its name.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
NORMA=${NORMA_BIN:-$tree/bin/norma}
cd "$scratch" || exit 1
if grep -qa __asan_init "$NORMA" || ! ${CC:-cc} -std=gnu11 -shared -fPIC "$root/tests/cli/faulty_file.c" -o faulty_file.so -ldl 2>log; then
    skip "no library can be preloaded here"
    finish
    exit
fi
mkdir models
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 2\nf 1//1 2//1 3//1\n' >models/1.obj
for name in 2 3-faulty 4 5-faulty 6 7 8 9-faulty; do cp models/1.obj models/$name.obj; done
whole='1 2 4 6 7 8'

# faulty COMMAND...: with the library; its status in $status.
faulty() { status=0; LD_PRELOAD=$scratch/faulty_file.so "$NORMA" "$@" >said 2>errors </dev/null || status=$?; }
# expect NAME CONDITION...: of the last command, which must have ended with 3.
expect() {
    local name=$1
    shift
    if [ "$status" -eq 3 ] && "$@"; then pass "$name"; else fail "$name" "status $status: $(cat said errors)"; fi
}
lines() { [ "$(grep -c -- "$2" "$1")" -eq "$3" ]; }
segmentation='norma ended by signal 11 (Segmentation fault) while it worked on this file'

# Reports are those of a run without the faulty files, but for their entries.
for threads in 1 2 8; do
    faulty check models --json --threads $threads
    expect "check, $threads threads: three entries of nine are unreadable" lines said "\"status\": \"unreadable\".*\"rule\": \"N001\".*$segmentation" 3
    grep -v '"status": "unreadable"' said | sed '/^\]/,$d' >others
    "$NORMA" check models --json --threads 1 | grep -v faulty | sed '/^\]/,$d' >wanted
    check "check, $threads threads: the others are as they always are, in order" cmp others wanted
done
# In text, copies of one mesh are one line, which names four of the six.
faulty check models --format text -o report.text
expect "check, text: all files are in the report" bash -c '[ "$(grep -o "models/[0-9]*-faulty.obj" report.text | sort -u | wc -l)" -eq 3 ] && [ "$(grep -oE "models/[0-9].obj" report.text | sort -u | wc -l)" -eq 4 ] && grep -q "Also in models/[0-9].obj, models/[0-9].obj, models/[0-9].obj and 2 more files" report.text'
for form in line sarif html; do
    faulty check models --format $form -o report.$form
    expect "check, $form: all files are in the report" bash -c '[ "$(grep -o "models/[0-9]*-faulty.obj" report.$1 | sort -u | wc -l)" -eq 3 ] && [ "$(grep -oE "models/[0-9].obj" report.$1 | sort -u | wc -l)" -eq 6 ]' _ $form
done
# Files that were done while an earlier one was checked again are told once.
mkdir pairs
for i in $(seq 10 40); do cp models/1.obj pairs/$i.obj && cp models/1.obj pairs/$i-faulty.obj; done
once=yes
for _ in 1 2 3 4 5; do
    faulty check pairs --quiet --threads 8
    [ "$(cat said)" = '62 errors, 0 warnings in 62 of 62 files; 31 not checked' ] || once=$(cat said)
done
if [ "$once" = yes ]; then pass "each file is told once"; else fail "each file is told once" "$once"; fi
FAULTY_SIGNAL=9 faulty check models
expect "a file for which the system kills the process is named" lines said '-faulty.obj: error N001 unreadable: norma ended by signal 9 (Killed) .*perhaps memory ran out' 3
# Where all files were done, none is at fault.
for command in "check $(echo models/[1-2].obj)" "info $(echo models/[1-2].obj)"; do
    # shellcheck disable=SC2086
    FAULTY_END=1 faulty $command
    expect "${command%% *}: a worker that ends after the last file" lines errors '^norma: the worker process ended by signal 9 (Killed) after all files were done; perhaps memory ran out$' 1
done
printf 'models/%s\n' 9-faulty.obj 1.obj >list
faulty check --files-from list --quiet
expect "a list" lines said '1 not checked' 1
faulty check models --write-baseline baseline.json --quiet
check "a baseline has the findings of all that were read" test "$(grep -c N103 baseline.json)" -eq 6
# Only where several files are given: a debugger sees the fault of one.
faulty check models/3-faulty.obj
if [ $status -eq 139 ]; then pass "of one file alone nothing is caught"; else fail "of one file alone nothing is caught" "status $status"; fi

cp -r models fixed
faulty check fixed --fix --in-place
expect "--fix --in-place names them" lines said 'faulty.obj: error N001' 3
for name in $whole; do grep -q 'vn 0 0 1' fixed/"$name".obj || fail "--fix: $name is fixed"; done
check "--fix leaves the faulty ones as they were" cmp fixed/3-faulty.obj models/3-faulty.obj
check "--fix leaves no other file" test "$(find fixed -type f | wc -l)" -eq 9
# Nor does one that ends while a file is put in its place, beside others or alone, behind a link as well.
for threads in 1 8; do
    for verb in 'check --fix' compute; do
        rm -rf placed && mkdir placed placed/b && for name in 1 3-unplaced 5 b/9; do cp models/1.obj placed/$name.obj; done
        ln -s b/9.obj placed/4-unplaced.obj && ln -s 5.obj placed/8.obj
        # shellcheck disable=SC2086  # words
        faulty $verb placed --in-place --threads $threads
        expect "$verb, $threads threads: what was being put in its place is named" grep -q '3-unplaced.obj: .*ended by signal 9' said errors
        check "$verb, $threads threads: and nothing is left of it" test "$(find placed -type f | wc -l)" -eq 4
        check "$verb, $threads threads: nor is it changed" cmp placed/3-unplaced.obj models/1.obj
    done
done

# The other verbs, which write a file for each.
for verb in compute 'transform --scale 2' 'render --size 32x32' view; do
    # shellcheck disable=SC2086  # words
    if ! "$NORMA" $verb models/1.obj --out-dir out >said 2>&1; then skip "$verb: cannot be done here"; continue; fi
    rm -rf out
    # shellcheck disable=SC2086  # words
    faulty $verb models --out-dir out
    expect "$verb: three files are named" lines errors "^norma: models/.-faulty.obj: $segmentation" 3
    check "$verb: the others are written" test "$(ls out | sed 's/\..*//' | paste -sd ' ')" = "$whole"
done
faulty compute models --out-dir out --json
expect "compute --json has an object for each" lines said '"output": null, "error": "models/.-faulty.obj: norma ended' 3
faulty info models
expect "info" lines said '^models/.\.obj: obj' 6
faulty info models --json
expect "info --json" lines said '"error": "models/.-faulty.obj: norma ended' 3
faulty compare fixed models
expect "compare: three pairs are named" lines errors "^norma: models/.-faulty.obj: $segmentation" 3
expect "compare: the others are compared" lines said '^models/.\.obj against fixed/.\.obj: ' 6
faulty compare fixed models --json
expect "compare --json" lines said '"error": "models/.-faulty.obj: norma ended' 3

# What ends the tool ends its workers, and nothing is left behind.
set -m # children hear SIGINT
mkfifo models/pipe.obj
for signal in INT TERM KILL; do
    "$NORMA" check models/1.obj models/pipe.obj -o left.json >/dev/null 2>errors &
    caller=$!
    for _ in $(seq 100); do worker=$(pgrep -P $caller) && [ -n "$worker" ] && break; sleep 0.05; done
    kill -$signal $caller
    wait $caller
    status=$?
    for _ in $(seq 100); do kill -0 "$worker" 2>/dev/null || break; sleep 0.05; done
    if [ -n "$worker" ] && ! kill -0 "$worker" 2>/dev/null && [ $status -gt 128 ] && [ ! -e left.json ] && { [ $signal = KILL ] || [ "$(cat errors)" = 'norma: interrupted' ]; }; then
        pass "SIG$signal ends the worker as well"
    else
        fail "SIG$signal ends the worker as well" "status $status, worker $worker: $(cat errors)"
    fi
done
finish
