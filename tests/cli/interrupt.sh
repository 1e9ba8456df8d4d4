#!/bin/bash
# Ctrl-C at any time: the tool ends soon with status 130, and neither an output nor a temporary file is left; a file that was there stays as it was. Large inputs are made
# here. Soon is 0.2 seconds where the machine has nothing else to do; a busy one may take longer, so what fails the test is ten times that, and the best of some tries is told.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
# A memory file system, so that the disk is not what is measured.
folder=$scratch
[ -w /dev/shm ] && folder=$(mktemp -d /dev/shm/norma-interrupt-XXXXXX)
trap 'rm -rf "$folder"; [ -n "${NORMA_SCRATCH:-}" ] || rm -rf "$scratch"' EXIT

if ! ${CC:-cc} -std=c11 -O2 "$root/bench/make_meshes.c" -o "$scratch/make_meshes" -lm 2>"$scratch/log"; then
    fail "the maker of meshes compiles" "$(cat "$scratch/log")"
    finish
    exit
fi
set -m # children hear SIGINT

# run ARGUMENTS...: in the background.
run() { "$norma" "$@" >/dev/null 2>"$folder/err" & child=$!; }

# interrupt SECONDS ARGUMENTS...: how long it lived on after the signal, in $delay (microseconds), and its status.
interrupt() {
    local after=$1 from
    shift
    run "$@"
    sleep "$after"
    from=${EPOCHREALTIME/./}
    kill -INT "$child" 2>/dev/null
    wait "$child"
    status=$?
    delay=$((${EPOCHREALTIME/./} - from))
}

# at NAME PERCENT OUTPUT ARGUMENTS...: interrupted at that part of the whole time; some other time it may have ended before: then it is tried a little earlier.
at() {
    local name=$1 percent=$2 output=$3 best="" part=$((whole * $2 / 100)) left
    shift 3
    for _ in 1 2 3 4 5 6 7 8; do
        rm -f "$output"
        interrupt "$((part / 1000000)).$(printf %06d $((part % 1000000)))" "$@"
        left=$(find "$folder/out" -type f)
        # Behind the renaming, when all is done, a signal still ends the tool: then the output is whole.
        [ "$left" != "$output" ] || [ "$(cksum <"$output")" != "$whole_sum" ] || status=0
        if [ -n "$left" ] && [ "$status" != 0 ]; then rm -f "$output"; fail "$name" "left behind: $left"; return; fi
        rm -f "$output"
        if [ "$status" = 0 ]; then
            part=$((part * 7 / 10))
            continue
        fi
        if [ "$status" != 130 ]; then fail "$name" "status $status; expected 130: $(cat "$folder/err")"; return; fi
        if [ -z "$best" ] || [ "$delay" -lt "$best" ]; then best=$delay; fi
        [ "$best" -le 200000 ] && break
    done
    if [ -z "$best" ]; then
        fail "$name" "it ended before the signal each time"
    elif [ "$best" -le 2000000 ]; then
        echo "# $name: ended after $best microseconds"
        pass "$name"
    else
        fail "$name" "ended after $best microseconds; expected some 200000"
    fi
}

mkdir "$folder/out"
for kind in obj ply stl glb; do
    "$scratch/make_meshes" "$kind" 1500000 "$folder/in.$kind"
    from=${EPOCHREALTIME/./}
    "$norma" compute "$folder/in.$kind" -o "$folder/out/whole.$kind" --quiet
    whole=$((${EPOCHREALTIME/./} - from))
    whole_sum=$(cksum <"$folder/out/whole.$kind")
    rm -f "$folder/out/whole.$kind"
    for percent in 10 50 85; do
        at "$kind: interrupted after $percent % of its time" "$percent" "$folder/out/cut.$kind" compute "$folder/in.$kind" -o "$folder/out/cut.$kind"
    done
    [ "$kind" = obj ] || rm -f "$folder/in.$kind"
done

# In the middle of writing: the reader of standard output takes a little and then waits, so that the tool hangs in a write.
mkfifo "$folder/pipe"
(exec 3<"$folder/pipe"; head -c 100000 <&3 >/dev/null; exec sleep 20) &
reader=$!
"$norma" compute "$folder/in.obj" -o - >"$folder/pipe" 2>"$folder/err" &
child=$!
sleep 1.5
from=${EPOCHREALTIME/./}
kill -INT "$child" 2>/dev/null
wait "$child"
status=$?
delay=$((${EPOCHREALTIME/./} - from))
kill -- "-$reader" 2>/dev/null
if [ "$status" = 130 ] && [ "$delay" -le 1000000 ]; then pass "interrupted while nobody reads its standard output"; else fail "interrupted while nobody reads its standard output" "status $status after $delay microseconds"; fi

# What was there stays.
head -c 100000 "$folder/in.obj" >"$folder/out/old.obj"
cp "$folder/out/old.obj" "$folder/old"
interrupt 0.05 compute "$folder/in.obj" -o "$folder/out/old.obj"
if [ "$status" = 130 ]; then check "the file of before stays" cmp "$folder/old" "$folder/out/old.obj"; else skip "the file of before stays (it was too quick: status $status)"; fi
# A report on many files is on its way to the disk for a long time: on a file system whose temporary files have names, too.
cat >"$scratch/named.c" <<'END'
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
static int call(const char *name, const char *path, int flags, unsigned mode) {
    int (*next)(const char *, int, ...) = (int (*)(const char *, int, ...))dlsym(RTLD_NEXT, name);
    if ((flags & O_TMPFILE) == O_TMPFILE) return errno = EOPNOTSUPP, -1;
    return next(path, flags, mode);
}
static unsigned mode_of(int flags, va_list rest) { return flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, unsigned) : 0; }
int open(const char *path, int flags, ...) { va_list rest; va_start(rest, flags); unsigned mode = mode_of(flags, rest); va_end(rest); return call("open", path, flags, mode); }
int open64(const char *path, int flags, ...) { va_list rest; va_start(rest, flags); unsigned mode = mode_of(flags, rest); va_end(rest); return call("open64", path, flags, mode); }
END
rm -f "$folder/out"/*
mkdir "$folder/farm"
cp "$root/tests/cli/golden/files/cube.obj" "$folder/farm/0.obj"
for ((i = 1; i < 20000; ++i)); do echo "$folder/farm/$i.obj"; done | xargs -n 1 ln "$folder/farm/0.obj"
named=""
${CC:-cc} -shared -fPIC -o "$scratch/named.so" "$scratch/named.c" -ldl 2>"$scratch/log" && named=$scratch/named.so
for preload in "" $named; do
    echo old >"$folder/out/report.json"
    LD_PRELOAD=$preload "$norma" check "$folder/farm" --no-config -o "$folder/out/report.json" >/dev/null 2>"$folder/err" &
    child=$!
    seen=0
    for _ in {1..100}; do
        [ -z "$(find "$folder/out" -name '.norma-*.tmp')" ] || { seen=1; break; }
        sleep 0.01
        [ -n "$preload" ] || { sleep 0.3; break; }
    done
    kill -INT "$child"
    wait "$child"
    status=$?
    left=$(ls -A "$folder/out")
    name="a report that is interrupted: the old one stays, and nothing else${preload:+, where temporary files have names}"
    if [ $status = 130 ] && [ "$left" = report.json ] && [ "$(cat "$folder/out/report.json")" = old ] && { [ -z "$preload" ] || [ $seen = 1 ]; }; then pass "$name"; else fail "$name" "status $status, seen $seen, left $left"; fi
done
rm -rf "$folder/farm" "$folder/out/report.json"
# Every verb, while it reads a line of 300 megabytes: whatever a reader is at, it ends at once.
rm -f "$folder"/in.*
# long HEAD UNIT TAIL: one line.
long() { printf '%s' "$1"; yes "$2" | tr -d '\n' | head -c 300000000; printf '%s\n' "$3"; }
# ends SIGNAL EXPECTED NAME ARGUMENTS...: the signal after 0.3 seconds, or sooner if it had ended by then.
ends() {
    local signal=$1 expected=$2 name=$3 best="" from pause
    shift 3
    for pause in 0.3 0.1 0.3 0.05; do
        run "$@" <"${input:-/dev/null}"
        sleep "$pause"
        from=${EPOCHREALTIME/./}
        kill "-$signal" "$child" 2>/dev/null
        wait "$child"
        status=$?
        delay=$((${EPOCHREALTIME/./} - from))
        [ "$status" = 0 ] || [ "$status" = 3 ] && continue
        if [ "$status" != "$expected" ]; then fail "$name" "status $status; expected $expected: $(cat "$folder/err")"; return; fi
        if [ -z "$best" ] || [ "$delay" -lt "$best" ]; then best=$delay; fi
        [ "$best" -le 200000 ] && break
    done
    if [ -n "$(find "$folder/out" -type f)" ]; then
        fail "$name" "left behind: $(find "$folder/out" -type f)"
    elif [ -z "$best" ]; then
        skip "$name (it ended before the signal each time)"
    elif [ "$best" -le 2000000 ]; then
        pass "$name"
    else
        fail "$name" "ended after $best microseconds; expected some 200000"
    fi
    rm -f "$folder/out"/*
}
rm -f "$folder/out"/*
triangle=$'v 0 0 0\nv 1 0 0\nv 0 1 0\n'
float=$'property float x\nproperty float y\nproperty float z\n'
for kind in obj ply stl gltf; do
    case $kind in
    obj) long "${triangle}f" ' 1 2 3' '' ;;
    ply) long $'ply\nformat ascii 1.0\nelement vertex 30000000\n'"${float}end_header"$'\n' '1 2 3 ' '' ;;
    stl) long 'solid a facet' ' normal 0 0 1' '' ;;
    gltf) long '{"asset":{"version":"2.0"},"extras":[1' ',1' ']}' ;;
    esac >"$folder/long.$kind"
    for verb in compute transform check info render view; do
        set -- "$folder/long.$kind"
        case $verb in
        compute) set -- "$@" -o "$folder/out/x.$kind" ;;
        transform) set -- "$@" --scale 2 -o "$folder/out/x.$kind" ;;
        render) set -- "$@" -o "$folder/out/x.png" ;;
        view) set -- "$@" -o "$folder/out/x.html" ;;
        esac
        ends INT 130 "$verb reads a long line of $kind" "$verb" "$@"
    done
    [ "$kind" = obj ] || rm -f "$folder/long.$kind"
done
ends TERM 143 "terminated while it reads a long line" info "$folder/long.obj"
rm -f "$folder/long.obj"

# What never comes, or never ends.
mkfifo "$folder/never.obj"
ends INT 130 "a pipe that nobody writes to" info "$folder/never.obj"
exec 4<>"$folder/never.obj"
input="$folder/never.obj" ends INT 130 "names that nobody writes" check --files-from -
input="$folder/never.obj" ends INT 130 "standard input that nobody writes" compute - --input-format obj -o "$folder/out/x.obj"
exec 4<&-
"$norma" check - --input-format obj </dev/zero >"$folder/err" 2>&1
if [ $? = 3 ] && grep -q 'is a device' "$folder/err"; then pass "a device without end is refused"; else fail "a device without end is refused" "$(cat "$folder/err")"; fi

if [ -z "$(find "$folder/out" -name '.norma-*')" ]; then pass "no temporary file"; else fail "no temporary file" "$(ls -A "$folder/out")"; fi
finish
