#!/bin/bash
# Every verb takes files, folders and quoted patterns: the same files are found, a folder's tree is kept below --out-dir, equal names in two folders do not meet, links out of a
# folder are not followed; lists leave out what is gone and what no reader knows; a file without a surface says why nothing is drawn.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
NORMA=${NORMA_BIN:-$tree/bin/norma}
cd "$scratch" || exit 1
mkdir -p models/a/deep models/b models/.hidden outside other
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >models/top.obj
cp models/top.obj models/a/part.obj
cp models/top.obj models/a/deep/part.obj
cp models/top.obj models/b/part.obj
cp models/top.obj models/.hidden/part.obj
cp models/top.obj outside/secret.obj
cp models/top.obj other/top.obj
ln -s ../outside/secret.obj models/leads-out.obj
ln -s ../outside models/leads-out
ln -s part.obj models/a/stays.obj
echo text >models/readme.txt

# is STATUS EXPECTED COMMAND...: its status, and what is found below out afterwards (or, without --out-dir, its standard output), in one line.
is() {
    local wanted=$1 expected=$2 status=0 said
    shift 2
    rm -rf out
    said=$("$NORMA" "$@" 2>errors </dev/null) || status=$?
    [[ " $* " != *" out "* ]] || said=$(cd out 2>/dev/null && find . -type f | sed 's,^\./,,' | LC_ALL=C sort)
    said=$(printf '%s' "$said" | tr '\n' ' ')
    # shellcheck disable=SC2053  # expected is a pattern
    if [ "$status" -eq "$wanted" ] && [[ "$said" == $expected ]]; then pass "$*"; else fail "$*" "status $status (expected $wanted): $said"$'\n'"expected $expected"$'\n'"$(cat errors)"; fi
}
# says WORDS: on standard error, the last time.
says() { if grep -qF -- "$1" errors; then pass "says: $1"; else fail "says: $1" "$(cat errors)"; fi; }

tree_files='a/deep/part.obj a/part.obj a/stays.obj b/part.obj top.obj'
is 0 "$tree_files" compute models --out-dir out
says 'models/leads-out.obj: skipped because it is a link that leads out of the folder'
is 0 "$tree_files" compute models/ --out-dir out
is 0 "$tree_files" transform models --scale 2 --out-dir out
is 0 "$tree_files" check models --fix-unsafe --select N104 --out-dir out
# Where a fix has nothing to do, that is said, and no copy is written but where it was named.
is 0 '' check models --fix --out-dir out
is 0 '*models/top.obj: nothing was fixed, no file is written*' check models/top.obj --fix --out-dir elsewhere
check "no copy is written" test ! -e elsewhere/top.obj
is 0 '*models/top.obj: nothing was fixed, the output is the input, byte for byte*' check models/top.obj --fix -o copy.obj
check "a copy that was named is written" cmp models/top.obj copy.obj
is 0 'a/deep/part.obj a/part.obj b/part.obj' compute 'models/**/part.obj' --out-dir out
is 0 'a/part.obj b/part.obj' compute 'models/*/part.obj' --out-dir out
is 0 'a/part.obj b/part.obj' compute models/a/part.obj models/b/part.obj --out-dir out
is 0 'part.obj top.obj' compute models/a/part.obj models/top.obj --out-dir out
is 0 'models/top.obj other/top.obj' transform models/top.obj other/top.obj --scale 2 --out-dir out
is 2 '' compute models/top.obj ./models/top.obj models/../models/top.obj --out-dir out
is 0 'models/top.obj: obj*models/a/part.obj: obj*models/a/stays.obj: obj*models/a/deep/part.obj: obj*models/b/part.obj: obj*' info models
is 0 '*in 0 of 5 files' check models --quiet
for verb in info check 'compute --out-dir out' 'transform --scale 2 --out-dir out' 'render --out-dir out' 'view --out-dir out'; do
    # shellcheck disable=SC2086  # words
    is 2 '' $verb 'models/*.nothing'
    says "the pattern 'models/*.nothing' matches no file"
    # shellcheck disable=SC2086  # words
    is 2 '' $verb ''
    says 'the name of an input is empty'
done
is 3 "$tree_files" compute models/.hidden/.. outside/nothing --out-dir out
mkdir hollow
is 3 '' compute hollow --out-dir out
says 'hollow: holds no OBJ, PLY, STL, glTF or 3MF file, nor a tile'
is 2 '' compute models -o one.obj
says 'one -o for 5 inputs'

# Lists, as git gives them.
printf 'models/top.obj\nmodels/readme.txt\nMakefile\nmodels/deleted.obj\nmodels/deleted.txt\n' >list.txt
is 0 '*in 0 of 1 file' check --files-from list.txt --quiet
says 'list.txt: names skipped: 3 of other formats, 1 that do not exist'
printf 'readme.md\n' >list.txt
is 0 '*in 0 of 0 files' check --files-from list.txt --quiet
is 3 '*1 not checked' check models/deleted.obj --quiet
# A name in a list is no pattern: where `chair[1].obj` is gone, `chair1.obj` stays as it is. A list that leaves nothing to check is no pass.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 2\nf 1//1 2//1 3//1\n' >chair1.obj
cp chair1.obj chair1.kept
printf 'chair[1].obj\nmodels/*.obj\nmodels/readme.txt\n' >list.txt
is 3 '*2 not checked' check --files-from list.txt --fix --in-place --quiet
says 'list.txt: names skipped: 1 of other formats, 0 that do not exist'
check "a name of a list is not taken as a pattern" cmp chair1.obj chair1.kept
printf 'chair[1].obj\nmodels/top.obj\n' >list.txt
is 0 '*in 0 of 1 file' check --files-from list.txt --quiet
says 'list.txt: names skipped: 0 of other formats, 1 that do not exist'
printf 'models/deleted.obj\n' >list.txt
is 3 'models/deleted.obj: error N001 unreadable*' check --files-from list.txt
cp chair1.obj 'chair[1].obj'
printf 'chair[1].obj\n' >list.txt
is 0 '*in 0 of 1 file' check --files-from list.txt --fix --in-place --quiet
check "a file with such a name is fixed itself" bash -c 'cmp -s chair1.obj chair1.kept && ! cmp -s "chair[1].obj" chair1.kept'

# Files without a surface.
printf 'v 0 0 0\nv 1 0 0\np 1 2\n' >points.obj
printf 'solid a\nendsolid a\n' >nothing.stl
printf '{"asset":{"version":"2.0"},"extensionsRequired":["NOT_known"],"extensionsUsed":["NOT_known"],"accessors":[{"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[0,0,0]}],"meshes":[{"primitives":[{"mode":0,"attributes":{"POSITION":0}}]}]}' >points.gltf
for verb in render view; do
    "$NORMA" $verb models/top.obj -o drawn.png >/dev/null 2>&1 || "$NORMA" $verb models/top.obj -o drawn.html >/dev/null 2>&1 || { skip "$verb: nothing can be drawn here"; continue; }
    ending=$([ $verb = render ] && echo png || echo html)
    is 0 "${tree_files//.obj/.$ending}" $verb models --out-dir out
    is 3 '' $verb points.obj -o no.$ending
    says 'it holds points without faces'
    is 3 '' $verb nothing.stl -o no.$ending
    says 'it holds no faces'
    is 3 '' $verb points.gltf -o no.$ending
    says 'points have no normals'
    check "$verb: nothing was written" test ! -e no.$ending
done
# Content that cannot be done is 3, whatever the format; the command line alone is 2.
printf 'solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n' >one.stl
is 3 '' transform one.stl --scale 1e300 --out-dir out
says 'one.stl:facet 0: the matrix moves it beyond'
is 2 '' compute one.stl --smooth --out-dir out

# Options that one format of a batch refuses, and a folder that cannot be made: nothing is written.
mkdir batch
cp one.stl batch/b.stl
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' | tee batch/a.obj >batch/c.obj
cp -r batch as-it-was
is 2 '' compute batch --in-place --crease 30
says 'batch/b.stl: STL holds one normal'
is 3 '' check batch/a.obj --fix-unsafe --out-dir none/../made --write-baseline base.json
check "nothing is written then" bash -c 'diff -r batch as-it-was && [ ! -e made ] && [ ! -e base.json ]'

mkdir as-it-was/deep batch/deep
cp batch/a.obj batch/deep
printf '{"no": 1}' >batch/deep/.norma.json
cp -r batch/deep as-it-was
is 2 '' check batch --fix-unsafe --select N104 --in-place
check "nor where a configuration further down is wrong" diff -r batch as-it-was

# Below --out-dir nothing is written through a link; the folder itself may be one.
mkdir -p place/deep tree/deep
cp batch/a.obj tree/deep
ln -s "$PWD/batch" place/link
ln -s "$PWD/batch/b.stl" place/one.stl
rmdir place/deep && ln -s "$PWD/batch" place/deep
is 3 '' compute tree --out-dir place
says 'place/deep: is a symbolic link'
is 3 '' transform one.stl --scale 2 --out-dir place
says 'place/one.stl: is a symbolic link'
check "nothing is written through a link" diff -r batch as-it-was
is 0 '*' compute batch/c.obj --out-dir place/link/new
# 40,000 tilesets that one names are told apart by a table, not each by all: within some tenths of a second, where it were ten.
awk 'BEGIN { printf "{\"asset\":{},\"root\":{\"children\":["; for (i = 0; i < 40000; i++) printf "%s{\"content\":{\"uri\":\"%d.json\"}}", i ? "," : "", i; print "]}}" }' >tileset.json
(ulimit -t 4; exec "$NORMA" check tileset.json) >said 2>&1
is_gone=$?
check "a tileset that names 40,000 others is read in time" test $is_gone -eq 3
check "and the first of them is missing" grep -q '0.json: cannot be read: No such file' said
finish
