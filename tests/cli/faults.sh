#!/bin/bash
# Faults while files are written: whatever stops the tool, and wherever, the old file is there or the complete new one, and after an ordinary failure no temporary.
# tests/cli/fault_calls.c runs each command once for each system call of its main, and kills it there, lets the call fail, move fewer bytes, or change an input meanwhile.
#   tests/cli/faults.sh            the cases of make test
#   tests/cli/faults.sh PATTERN    those whose line matches
# FAULT_ALL=1: every verb, format and way to write with every kind of fault; without it, failing calls are not tried where another case has the same way to write.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
export NORMA=${NORMA_BIN:-$tree/bin/norma}
calls=$tree/tests/fault_calls
export MESA_SHADER_CACHE_DISABLE=true LC_ALL=C.UTF-8
# A disk is slow to flush, and what is looked at is the order of calls; two cases run on the disk all the same.
disk=$scratch/disk
fast=$disk
if [ -z "${FAULT_FAST:-}" ] && [ -d /dev/shm ] && [ -w /dev/shm ]; then fast=$(mktemp -d /dev/shm/norma-faults-XXXXXX); trap 'rm -rf "$fast"; [ -n "${NORMA_SCRATCH:-}" ] || rm -rf "$scratch"' EXIT; fi
mkdir -p "$disk" "$fast"

# ---- judging one outcome

files_of() { (cd "$1" && find . -type f ! -name '.norma-*.tmp' | sort); }
folders_of() { (cd "$1" && find . -type d | sort); }
content() { [ -f "$1" ] && md5sum <"$1" || echo none; }
# What an asset holds, wherever in its buffers: all of it as one text with data URIs.
asset() { [ -f "$1" ] && { "$NORMA" transform "$1" --scale 2 -o - --quiet 2>/dev/null || echo "unreadable $1"; } | md5sum || echo none; }

# A mesh that cannot be read is a finding: the report is whole, and says so.
reports_unreadable() { [ "$(tail -c 8 "$1/report.html" 2>/dev/null)" = '</html>' ] && grep -q N001 "$1/report.html"; }

# judge STATE OLD NEW: each file is the old one or the new one, no other is there, and each glTF reads what the old or the new one read.
judge() {
    local state=$1 old=$2 new=$3 file now
    while read -r file; do
        now=$(content "$state/$file")
        [ "$now" = "$(content "$old/$file")" ] || [ "$now" = "$(content "$new/$file")" ] || { [ "$file" = ./report.html ] && reports_unreadable "$state"; } || { echo "$file is neither the old one nor the new one"; return 1; }
        case $file in
        *.gltf) now=$(asset "$state/$file")
            [ "$now" = "$(asset "$old/$file")" ] || [ "$now" = "$(asset "$new/$file")" ] || { echo "$file reads neither what the old one read nor what the new one does"; return 1; } ;;
        esac
    done < <({ files_of "$state"; files_of "$old"; files_of "$new"; } | sort -u)
}

# In which order bytes, names and folders reach the disk, from the trace of a run without a fault.
in_order() {
    awk '
        function folder(path) { return path ~ /\// ? substr(path, 1, length(path) - length(substr(path, match(path, /[^\/]*$/)))) : "" }
        function wrong(why) { print why ": " $0; bad = 1 }
        $1 == "open" { path[$2] = $3; dirty[$2] = 0; if ($0 ~ / create/) { at[$3] = $2; if ($3 !~ /\.norma-[0-9]+-[0-9]+\.tmp$/) wrong("made under its own name") } }
        $1 == "write" { dirty[$2] = 1 }
        $1 == "fsync" { dirty[$2] = 0; if (pending != "" && path[$2] == folder(pending) ".") { pending = ""; ++flushed } }
        $1 == "link" { n = $2; sub(/.*\//, "", n); if (dirty[n]) wrong("named before it was flushed"); at[$3] = n }
        $1 == "rename" {
            if (!($2 in at)) wrong("renamed, and not known")
            else if (dirty[at[$2]]) wrong("renamed before it was flushed")
            if (pending != "") wrong("the folder was not flushed before the next file was renamed")
            pending = $3; ++renamed
        }
        END { if (pending != "") { print "the folder was not flushed after " pending " was renamed"; bad = 1 } if (!renamed) { print "nothing was renamed"; bad = 1 }
              if (!bad) print "# " renamed " files renamed, each flushed before and its folder after"; exit bad }' "$1"
}

# ---- one case: KIND|NAME|SET|COMMAND. Prints its verdict and figures.

one() {
    local kind name set command place lines new line call rest status state temporary said why bad=0 written=0 refused=0 left=0
    IFS='|' read -r kind name set command <<<"$1"
    place=$(mktemp -d "$fast/case-XXXXXX")
    [ "$set" = disk ] && { place=$(mktemp -d "$disk/case-XXXXXX"); set=mixed; }
    lines=$place/lines
    [[ $command == *' render '* || $kind == late* ]] && export FAULT_ONLY_WRITING=1
    kind=${kind#late-}
    # shellcheck disable=SC2086  # words
    "$calls" "$kind" "$fast/sets/$set" "$place/work" "$place/states" -- $command >"$lines" 2>&1 || { echo "not ok $name: $(tail -n 1 "$lines")"; return; }
    new=$(awk -F' [|] ' '/ \| / { state = $3 } END { print state }' "$lines")
    if [ "$kind" = trace ]; then
        why=$(in_order "$lines") && echo "ok $name ($why)" || echo "not ok $name: $why"
        rm -rf "$place"
        return
    fi
    for state in "$place/states"/*; do
        why=$(judge "$state" "$fast/sets/$set" "$place/states/$new") || { bad=1; printf 'not ok %s: %s; after %s\n' "$name" "$why" "$(awk -F' [|] ' -v state="$(basename "$state")" '$3 == state' "$lines" | head -n 1)"; }
        [ -z "${FAULT_SHOW:-}" ] || echo "state $state new $new"
        # After an ordinary failure no folder stays that was made on the way (but where that it is taken away fails).
        call=$(awk -F' [|] ' -v state="$(basename "$state")" '$3 == state' "$lines" | head -n 1)
        [ "$kind" != fail ] || [[ $call == *rmdir* ]] || [ "$(folders_of "$state")" = "$(folders_of "$fast/sets/$set")" ] || [ "$(folders_of "$state")" = "$(folders_of "$place/states/$new")" ] ||
            { bad=1; echo "not ok $name: folders $(folders_of "$state" | tr '\n' ' ') after $call"; }
    done
    while IFS= read -r line; do
        [[ $line == *' | '*' | '* ]] || continue
        call=${line%% | *}; rest=${line#* | }; status=${rest%% | *}; rest=${rest#* | }; state=${rest%% | *}; rest=${rest#* | }; temporary=${rest%% | *}; said=${rest#* | * | }
        why=""
        case $kind:$status in
        kill:-9) left=$((left + temporary)); [ "$state" = "$new" ] && written=$((written + 1)) || refused=$((refused + 1)) ;;
        kill:3) # its worker was killed: what that leaves is what a killed tool leaves, and it is said
            left=$((left + temporary)) refused=$((refused + 1)); [[ $said == 'norma: '*' ended by signal 9 (Killed)'* ]] || why="nothing is said" ;;
        kill:0 | kill:1) # check does the file of a killed worker again
            left=$((left + temporary)) written=$((written + 1)); [ "$state" = "$new" ] || why="all is said to be well, and the outcome is another one" ;;
        *:0 | *:1) written=$((written + 1)); [ "$state" = "$new" ] || why="all is said to be well, and the outcome is another one"; [ "$temporary" = 0 ] || why="a temporary file stays" ;;
        *:3 | *:2) refused=$((refused + 1)); [[ $said == 'norma'*': '* ]] || reports_unreadable "$place/states/$state" || why="nothing is said"; [ "$temporary" = 0 ] || why="a temporary file stays" ;;
        *) why="ends so" ;;
        esac
        [ -z "$why" ] || { bad=1; echo "not ok $name: $why: $line"; }
    done <"$lines"
    [ $bad = 1 ] || echo "ok $name: $((written + refused)) faults, $written done, $refused not, $left left a temporary file"
    [ -n "${FAULT_SHOW:-}" ] || rm -rf "$place"
}

# ---- the cases

sets() {
    local from=$root/tests/cli/golden/files set=$fast/sets
    mkdir -p "$set"/{obj,ply,stl,gltf,glb,shared,mixed,again,linked}
    cp "$from/cube.obj" "$set/obj/in.obj"
    cp "$from/roof.ply" "$set/ply/in.ply"
    cp "$from/corner.stl" "$set/stl/in.stl"
    cp "$from/roof.gltf" "$set/gltf/in.gltf"
    cp "$from/roof.bin" "$set/gltf/"
    cp "$from/roof.glb" "$set/glb/in.glb"
    cp "$from/roof.gltf" "$set/shared/in.gltf"
    cp "$from/roof.gltf" "$set/shared/other.gltf"
    cp "$from/roof.bin" "$set/shared/"
    cp "$from"/{cube.obj,roof.ply,corner.stl,roof.gltf,roof.bin,roof.glb} "$set/mixed/"
    mkdir -p "$set/images/img/deep" "$set/images/out"
    cp "$set/gltf/roof.bin" "$set/images/"
    printf '\211PNG\r\n\032\n' >"$set/images/img/deep/a.png"
    sed '0,/{/s//{"images":[{"uri":"img\/deep\/a.png"}],/' "$set/gltf/in.gltf" >"$set/images/in.gltf"
    # An older output is there already.
    cp "$set"/{obj/in.obj,ply/in.ply,stl/in.stl,gltf/in.gltf,gltf/roof.bin,glb/in.glb} "$set/again/"
    for format in obj ply stl gltf glb; do (cd "$set/again" && "$NORMA" transform "in.$format" --translate 1,0,0 --bake --quiet -o "out.$format" 2>/dev/null || "$NORMA" transform "in.$format" --translate 1,0,0 --quiet -o "out.$format"); done
    mkdir "$set/linked/deep"
    cp "$from/cube.obj" "$set/linked/deep/in.obj"
    ln -s deep/in.obj "$set/linked/in.obj"
    chmod -R u+w "$set"
}

cases() {
    local format verb all="mixed" kind
    for format in obj ply stl gltf glb; do
        for kind in kill fail; do
            echo "$kind|$kind: compute a new $format|$format|$NORMA compute in.$format -o out.$format --threads 1"
            echo "late-$kind|$kind: compute $format in place|$format|$NORMA compute in.$format --in-place --threads 1"
            echo "late-$kind|$kind: compute $format over an older output|again|$NORMA compute in.$format -o out.$format --threads 1"
        done
        for verb in 'transform --scale 2,1,1 --bake' 'check --fix-unsafe --select N'; do
            [[ $verb == transform* && $format != gl* ]] && verb='transform --scale 2,1,1'
            echo "late-kill|kill: ${verb%% *} $format in place|$format|$NORMA $verb in.$format --in-place --threads 1"
            echo "late-kill|kill: ${verb%% *} a new $format|$format|$NORMA $verb in.$format -o out.$format --threads 1"
            [[ -z ${FAULT_ALL:-} && $format != gltf && $format != ply ]] || echo "late-fail|fail: ${verb%% *} $format in place|$format|$NORMA $verb in.$format --in-place --threads 1"
            [ -z "${FAULT_ALL:-}" ] || echo "late-fail|fail: ${verb%% *} a new $format|$format|$NORMA $verb in.$format -o out.$format --threads 1"
        done
        echo "trace|order: compute a new $format|$format|$NORMA compute in.$format -o out.$format"
        echo "trace|order: compute $format in place|$format|$NORMA compute in.$format --in-place"
        echo "trace|order: check --fix-unsafe $format in place|$format|$NORMA check --fix-unsafe --select N in.$format --in-place"
        echo "short|short reads and writes: $format|$format|$NORMA compute in.$format -o out.$format --threads 1"
    done
    all=$(cd "$fast/sets/mixed" && printf '%s ' *.obj *.ply *.stl *.gltf *.glb)
    for verb in compute 'transform --rotate 0,0,1,30' 'check --fix'; do
        echo "late-kill|kill: ${verb%% *} to --out-dir|mixed|$NORMA $verb $all --out-dir out --threads 1"
        [[ -z ${FAULT_ALL:-} && $verb != compute ]] || echo "late-fail|fail: ${verb%% *} to --out-dir|mixed|$NORMA $verb $all --out-dir out --threads 1"
    done
    echo "late-kill|kill: compute all in place on the disk|disk|$NORMA compute $all --in-place --threads 1"
    for kind in late-kill late-fail trace; do echo "$kind|${kind#late-}: a .gltf and its images into another folder|images|$NORMA compute in.gltf -o out/in.gltf --threads 1"; done
    echo "late-kill|kill: compute through a symbolic link|linked|$NORMA compute in.obj --in-place --threads 1"
    for kind in late-kill late-fail trace; do
        echo "$kind|${kind#late-}: one .bin of two assets, in place|shared|$NORMA compute in.gltf --in-place --threads 1"
        echo "$kind|${kind#late-}: a report|mixed|$NORMA check cube.obj --format html -o report.html --threads 1"
        [ -z "$has_page" ] || echo "$kind|${kind#late-}: view|mixed|$NORMA view roof.glb -o page.html --threads 1"
        [ -z "$has_renderer" ] || echo "$kind|${kind#late-}: render|mixed|$NORMA render cube.obj -o picture.png --size 16x16 --renderer software --threads 1"
    done
    echo "kill|kill: a baseline|mixed|$NORMA check cube.obj roof.ply --write-baseline=base.json --threads 1"
}

if [ "${1:-}" = --one ]; then
    fast=$FAULT_FAST calls=$FAULT_CALLS
    disk=$FAULT_DISK
    one "$2"
    exit
fi
[ -x "$NORMA" ] || { fail "the tool is there" "no program at $NORMA"; finish; exit 1; }
[ -x "$calls" ] || { fail "the tool that stops calls is there" "no program at $calls"; finish; exit 1; }
"$calls" trace / / / >/dev/null 2>&1
[ $? != 77 ] || { skip "system calls cannot be stopped on this machine"; finish; exit; }
mkdir -p "$fast/try"
: >"$fast/try/a"
"$calls" kill "$fast/try" "$fast/try-work" "$fast/try-states" -- true 2>/dev/null | grep -q '^runs' || { skip "ptrace is not allowed here"; finish; exit; }
has_page=$("$NORMA" view "$root/tests/cli/golden/files/cube.obj" -o "$scratch/page.html" >/dev/null 2>&1 && echo yes)
has_renderer=$("$NORMA" render "$root/tests/cli/golden/files/cube.obj" -o "$scratch/picture.png" --size 16x16 >/dev/null 2>&1 && echo yes)
[ -n "$has_page" ] || skip "view: this tool was built without the page"
[ -n "$has_renderer" ] || skip "render: nothing can be drawn here"
sets
cases | grep -E -- "${1:-.}" >"$scratch/cases"
FAULT_FAST=$fast FAULT_CALLS=$calls FAULT_DISK=$disk xargs -P "${JOBS:-$(nproc)}" -d '\n' -n 1 bash "$0" --one <"$scratch/cases" >"$scratch/verdicts" 2>"$scratch/errors"
total=0
while IFS= read -r line; do
    case $line in
    'ok '*) pass "${line#ok }"; number=$(sed -nE 's/.*: ([0-9]+) faults.*/\1/p' <<<"$line"); total=$((total + ${number:-0})) ;;
    'not ok '*) fail "${line#not ok }" ;;
    *) echo "# $line" ;;
    esac
done < <(sort -s -k2 "$scratch/verdicts")
[ "$(grep -cE '^(ok|not ok) ' "$scratch/verdicts")" -ge "$(wc -l <"$scratch/cases")" ] || fail "every case gave a verdict" "$(cat "$scratch/errors")"
echo "# $total faults"

# Two assets that share a buffer: the one that was not named reads what it read.
work=$fast/two
cp -r "$fast/sets/shared" "$work"
before=$(asset "$work/other.gltf")
check "an asset in place" "$NORMA" compute "$work/in.gltf" --in-place --quiet
if [ "$(asset "$work/other.gltf")" = "$before" ]; then pass "another asset that shares its .bin reads what it read"; else fail "another asset that shares its .bin reads what it read"; fi
finish
