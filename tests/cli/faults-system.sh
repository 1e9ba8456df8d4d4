#!/bin/bash
# What the system refuses, and what other programs do meanwhile: a full disk, a read-only folder, a limit of size, standard streams that are closed, full or end early,
# signals between reads, inputs that change or become shorter while they are read, two runs over one .bin.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
NORMA=${NORMA_BIN:-$tree/bin/norma}
calls=$tree/tests/fault_calls
export NORMA MESA_SHADER_CACHE_DISABLE=true LC_ALL=C.UTF-8
[ -x "$NORMA" ] && [ -x "$calls" ] || { fail "the tools are there" "no program at $NORMA or $calls"; finish; exit 1; }
files=$root/tests/cli/golden/files
has_page=$("$NORMA" view "$files/cube.obj" -o "$scratch/page.html" >/dev/null 2>&1 && echo yes)
has_renderer=$("$NORMA" render "$files/cube.obj" -o "$scratch/picture.png" --size 16x16 >/dev/null 2>&1 && echo yes)

# Large enough for several writes: a wavy grid of 40,000 triangles as OBJ, and from it what each format needs.
large=$scratch/large
mkdir -p "$large"
awk 'BEGIN { n = 142; for (y = 0; y < n; ++y) for (x = 0; x < n; ++x) printf "v %d %d %.4f\n", x, y, sin(x * .3) * cos(y * .2) * 5
             for (y = 0; y + 1 < n; ++y) for (x = 0; x + 1 < n; ++x) { a = y * n + x + 1; printf "f %d %d %d\nf %d %d %d\n", a, a + 1, a + n, a + 1, a + n + 1, a + n } }' >"$large/grid.obj"
awk 'BEGIN { print "solid g"; n = 100; for (y = 0; y < n; ++y) for (x = 0; x < n; ++x) printf "facet normal 0 0 0\nouter loop\nvertex %d %d 0\nvertex %d %d 0\nvertex %d %d %d\nendloop\nendfacet\n", x, y, x + 1, y, x, y + 1, (x + y) % 3; print "endsolid g" }' >"$large/grid.stl"
awk 'BEGIN { n = 142; printf "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n", n * n, 2 * (n - 1) * (n - 1)
             for (y = 0; y < n; ++y) for (x = 0; x < n; ++x) printf "%d %d %.4f\n", x, y, sin(x * .3) * cos(y * .2) * 5
             for (y = 0; y + 1 < n; ++y) for (x = 0; x + 1 < n; ++x) { a = y * n + x; printf "3 %d %d %d\n3 %d %d %d\n", a, a + 1, a + n, a + 1, a + n + 1, a + n } }' >"$large/grid.ply"
cp "$files"/roof.* "$large/"
state_of() { (cd "$1" && find . -type f -exec md5sum {} + | sort); }

# refused NAME FOLDER COMMAND...: ends with 3 and a message, and leaves the folder as it was.
refused() {
    local name=$1 folder=$2 before said status=0
    shift 2
    before=$(state_of "$folder")
    said=$("$@" 2>&1 >/dev/null) || status=$?
    if [ $status -eq 3 ] && [[ $said == *norma:* ]] && [ "$(state_of "$folder")" = "$before" ]; then pass "$name"; else fail "$name" "status $status: $said$(diff <(echo "$before") <(state_of "$folder"))"; fi
}

# ---- the size of a file limited: SIGXFSZ ignored by the caller, or not
limited() { (ulimit -f "$1"; shift; "$@"); }
ignoring() { (trap '' XFSZ; ulimit -f "$1"; shift; "$@"); }
for input in grid.obj grid.stl grid.ply; do
    for verb in compute 'transform --scale 2,1,1' 'check --fix-unsafe --select N1,N2,N3'; do
        for how in limited ignoring; do
            mkdir -p "$scratch/limit" && cp "$large/$input" "$scratch/limit/"
            # shellcheck disable=SC2086  # words
            refused "$how size: ${verb%% *} $input in place" "$scratch/limit" $how 64 "$NORMA" $verb "$scratch/limit/$input" --in-place
            # shellcheck disable=SC2086
            refused "$how size: ${verb%% *} $input to another file" "$scratch/limit" $how 64 "$NORMA" $verb "$scratch/limit/$input" -o "$scratch/limit/out.${input##*.}"
        done
    done
done
for input in roof.gltf roof.glb; do
    mkdir -p "$scratch/limit" && cp "$large/$input" "$large/roof.bin" "$scratch/limit/"
    refused "limited size: compute $input in place" "$scratch/limit" limited 0 "$NORMA" compute "$scratch/limit/$input" --in-place
    refused "limited size: compute a new ${input##*.}" "$scratch/limit" limited 0 "$NORMA" compute "$scratch/limit/$input" -o "$scratch/limit/out.${input##*.}"
done
refused "limited size: a report" "$scratch/limit" limited 0 "$NORMA" check "$large/grid.obj" --format html -o "$scratch/limit/report.html"
refused "limited size: pack" "$scratch/limit" limited 0 "$NORMA" pack "$root/tests/tangent/charts.gltf" -o "$scratch/limit/packed.gltf"
refused "limited size: the acid scenes" "$scratch/limit" limited 64 "$NORMA" acid -o "$scratch/limit/scenes"
[ -z "$has_page" ] || refused "limited size: view" "$scratch/limit" limited 0 "$NORMA" view "$large/grid.obj" -o "$scratch/limit/page.html"
[ -z "$has_renderer" ] || refused "limited size: render" "$scratch/limit" limited 0 "$NORMA" render "$large/grid.obj" --size 16x16 -o "$scratch/limit/picture.png"

# ---- a full disk, and one that may not be written: a small file system of our own, in a name space of its own where we are not root
full='
    set -u; disk=$1/disk; mkdir -p "$disk"; mount -t tmpfs -o size=4m none "$disk" || exit 77
    cp "$2"/* "$disk/"; dd if=/dev/zero of="$disk/filler" bs=4096 2>/dev/null
    before=$(cd "$disk" && find . -type f -exec md5sum {} + | sort); bad=0; runs=0
    try() { said=$("$@" 2>&1 >/dev/null); status=$?; runs=$((runs + 1))
        [ $status -eq 3 ] && case $said in *norma:*) true ;; *) false ;; esac && [ "$(cd "$disk" && find . -type f -exec md5sum {} + | sort)" = "$before" ] || { bad=1; echo "status $status: $*: $said"; }; }
    every() {
        for f in grid.obj grid.ply grid.stl roof.gltf roof.glb; do
            for verb in compute "transform --scale 2,1,1 --bake" "check --fix-unsafe --select N1,N2,N3"; do
                case $verb$f in transform*grid*) verb="transform --scale 2,1,1" ;; esac
                try "$NORMA" $verb "$disk/$f" --in-place
                try "$NORMA" $verb "$disk/$f" -o "$disk/out.${f##*.}"
            done
        done
        try "$NORMA" check "$disk/grid.obj" --format html -o "$disk/report.html"
        [ -z "$3" ] || try "$NORMA" view "$disk/grid.obj" -o "$disk/page.html"
        [ -z "$4" ] || try "$NORMA" render "$disk/grid.obj" --size 16x16 -o "$disk/picture.png"
    }
    every "$@"
    [ $bad = 1 ] || echo "$runs runs on a full disk"
    mount -o remount,ro "$disk" || exit $bad
    runs=0; every "$@"
    [ $bad = 1 ] || echo "$runs runs on a read-only disk"
    umount "$disk"; exit $bad'
status=0
if [ "$(id -u)" = 0 ]; then said=$(unshare -m bash -c "$full" - "$scratch" "$large" "$has_page" "$has_renderer" 2>&1) || status=$?; else said=$(unshare -rm bash -c "$full" - "$scratch" "$large" "$has_page" "$has_renderer" 2>&1) || status=$?; fi
if [ $status = 0 ]; then pass "a full disk and a read-only one: $(tr '\n' ',' <<<"$said")"
elif [ $status = 77 ] || [[ $said == unshare:* ]]; then skip "no file system can be mounted here: $(head -n 1 <<<"$said")"
else fail "a full disk and a read-only one" "$said"; fi

# ---- a folder without the right to write, for someone who is not root
folder=$scratch/guarded
mkdir -p "$folder" && cp "$large"/grid.* "$large"/roof.* "$folder/" && chmod 755 "$scratch" && chmod a+r "$folder"/* && chmod 555 "$folder"
as_other=()
[ "$(id -u)" != 0 ] || as_other=(setpriv --reuid=65534 --regid=65534 --clear-groups)
if [ "$(id -u)" = 0 ] && ! setpriv --reuid=65534 --regid=65534 --clear-groups test -x "$NORMA" -a -r "$folder/grid.obj" 2>/dev/null; then
    skip "a read-only folder: nobody cannot run the tool where it lies"
else
    for input in grid.obj grid.ply grid.stl roof.gltf roof.glb; do
        for verb in compute 'transform --scale 2 --translate 1,0,0' 'check --fix-unsafe --select N1,N2,N3'; do
            # shellcheck disable=SC2086
            refused "a read-only folder: ${verb%% *} $input in place" "$folder" "${as_other[@]}" "$NORMA" $verb "$folder/$input" --in-place
            # shellcheck disable=SC2086
            refused "a read-only folder: ${verb%% *} $input, new" "$folder" "${as_other[@]}" "$NORMA" $verb "$folder/$input" -o "$folder/out.${input##*.}"
        done
    done
fi
chmod 755 "$folder"

# ---- standard streams
cd "$scratch" || exit 1
cp "$files"/cube.obj "$files"/roof.* .
# says STATUS NAME COMMAND: in a shell, with nothing on standard output that could be taken for a file.
says() {
    local want=$1 name=$2 status=0
    bash -c "$3" >"$scratch/said" 2>&1 </dev/null || status=$?
    if [ "$status" = "$want" ]; then pass "$name"; else fail "$name" "status $status, expected $want: $(cat "$scratch/said")"; fi
}
for command in 'compute cube.obj -o o.obj' 'compute cube.obj -o -' 'info cube.obj' 'info cube.obj --json' 'check cube.obj' 'check cube.obj --format json' 'check cube.obj --format sarif' \
    'check cube.obj --format html' 'matrix --scale 2' 'explain N501' 'transform cube.obj -o - --scale 2' 'help' '--version'; do
    says 3 "closed standard output: $command" "\"\$NORMA\" $command >&-"
    says 3 "full standard output: $command" "\"\$NORMA\" $command >/dev/full"
done
says 0 "closed standard output does not become a file: the output is whole" '"$NORMA" compute cube.obj -o closed.obj >&-; "$NORMA" compute cube.obj -o open.obj >/dev/null; cmp closed.obj open.obj'
# The first file that is opened would get a closed stream's number; its name leads to /dev/null, which has no faces, where that was put there first, and else to nothing.
if [ -d /proc/self/fd ]; then
    says 0 "closed standard output is taken before any file is opened" '"$NORMA" info /proc/self/fd/1 --input-format obj --quiet >&- 2>taken; ! grep -q "No such file" taken'
    says 0 "closed standard input is taken before any file is opened" '"$NORMA" info /proc/self/fd/0 --input-format obj --quiet <&- 2>taken; ! grep -q "No such file" taken'
fi
says 3 "closed standard input" '"$NORMA" info - --input-format obj <&-'
says 3 "all streams closed" '"$NORMA" info cube.obj <&- >&- 2>&-'
says 0 "a reader that leaves early, SIGPIPE" '"$NORMA" compute large/grid.obj -o - --quiet | head -c 10 >/dev/null; [ ${PIPESTATUS[0]} = 141 ]'
says 0 "a reader that leaves early, SIGPIPE ignored" 'trap "" PIPE; "$NORMA" compute large/grid.obj -o - --quiet 2>err | head -c 10 >/dev/null; [ ${PIPESTATUS[0]} = 3 ] && grep -q "Broken pipe" err'
says 0 "a reader of a report that leaves early" 'trap "" PIPE; "$NORMA" check large/grid.obj large/grid.stl --format sarif 2>err | true; status=${PIPESTATUS[0]}; [ $status = 3 ] || [ $status = 0 ]'
says 0 "a slow pipe, by its name" '"$NORMA" compute cube.obj -o direct.obj --quiet; mkfifo slow.obj; { while IFS= read -r l; do printf "%s\n" "$l"; sleep 0.005; done <cube.obj >slow.obj; } & "$NORMA" compute slow.obj -o piped.obj --quiet; cmp direct.obj piped.obj'
says 0 "signals between reads" '{ head -c 100 cube.obj; sleep 0.3; tail -c +101 cube.obj; } | { "$NORMA" compute - --input-format obj -o signalled.obj --quiet & for i in 1 2 3 4 5; do sleep 0.03; kill -STOP $!; kill -CONT $!; kill -WINCH $!; done; wait $!; }; [ ! -e signalled.obj ] || cmp direct.obj signalled.obj'

# ---- inputs that change while they are read. Each run changes the input at another system call; the tool ends with 0 and what it always writes, or with 3 and a message.
changes="shrink scribble"
[ -z "${FAULT_ALL:-}" ] || changes="shrink halve grow scribble"
if [ "$(uname -s)" = Linux ] && "$calls" kill "$files" "$scratch/w" "$scratch/s" -- true >/dev/null 2>&1; then
    for input in grid.obj grid.ply grid.stl roof.gltf roof.glb; do
        mkdir -p "$scratch/from-$input" && cp "$large/$input" "$scratch/from-$input/"
        [ "$input" != roof.gltf ] || cp "$large/roof.bin" "$scratch/from-$input/"
        for change in $changes; do
            target=$input
            [ "$input" != roof.gltf ] || target=roof.bin
            "$calls" "$change=$target" "$scratch/from-$input" "$scratch/w" "$scratch/states-$input-$change" -- "$NORMA" compute "$input" -o "out.${input##*.}" --threads 2 >"$scratch/lines" 2>&1
            bad=$(awk -F' [|] ' '/ \| / && !($2 == 0 || ($2 == 3 && $6 ~ /^norma: /)) || (/ \| / && $4 > 0)' "$scratch/lines" | head -n 5)
            runs=$(sed -nE 's/^runs ([0-9]+) .*/\1/p' "$scratch/lines")
            if [ -z "$bad" ] && [ "${runs:-0}" -gt 10 ]; then pass "$change while $input is read: $runs points, $(awk -F' [|] ' '$2 == 3' "$scratch/lines" | wc -l) refused"; else fail "$change while $input is read" "$bad"; fi
            rm -rf "$scratch/states-$input-$change"
        done
    done
else
    skip "inputs that change: system calls cannot be stopped here"
fi

# ---- two runs at once over one .bin: each is done or refused, and both assets read what they should
mkdir -p both && cp "$files/roof.gltf" both/a.gltf && cp "$files/roof.gltf" both/b.gltf && cp "$files/roof.bin" both/
"$NORMA" compute both/a.gltf -o single.gltf --quiet
bad=0
for _ in 1 2 3 4 5 6 7 8 9 10; do
    cp "$files/roof.gltf" both/a.gltf; cp "$files/roof.gltf" both/b.gltf; cp "$files/roof.bin" both/roof.bin
    "$NORMA" compute both/a.gltf --in-place --quiet 2>/dev/null & first=$!
    "$NORMA" compute both/b.gltf --in-place --flat --quiet 2>/dev/null & second=$!
    wait $first; one=$?; wait $second; two=$?
    for pair in "a:$one:" "b:$two:--flat"; do
        IFS=: read -r name status flat <<<"$pair"
        # shellcheck disable=SC2086
        [ "$status" = 3 ] || "$NORMA" compute "$files/roof.gltf" -o want.gltf --quiet $flat
        [ "$status" = 3 ] || [ "$("$NORMA" info both/$name.gltf --deep --json 2>&1 | sed 's/"path": "[^"]*"//')" = "$("$NORMA" info want.gltf --deep --json 2>&1 | sed 's/"path": "[^"]*"//')" ] || bad=1
        rm -f want*
    done
done
if [ $bad = 0 ]; then pass "two runs at once over one .bin, ten times"; else fail "two runs at once over one .bin"; fi
finish
