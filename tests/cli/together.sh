#!/bin/bash
# norma compute --together: one surface in many files has one normal at each position, the same for any cut and any order, and nothing is written unless all is.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
meshes="$root/tests/cli/together_meshes.py"
cd "$scratch" || exit 1
if ! command -v python3 >/dev/null; then
    skip "python3 is missing"
    finish
    exit
fi
make() { python3 "$meshes" "$@"; }

# expect STATUS NAME TEXT COMMAND...: its exit status, and a text in what it says.
expect() {
    local wanted=$1 name=$2 text=$3 status=0
    shift 3
    "$@" >said 2>&1 || status=$?
    if [ "$status" = "$wanted" ] && grep -q -- "$text" said; then pass "$name"; else fail "$name" "status $status: $(cat said)"; fi
}

# ---- any cut, any order
make cut 1 1 whole
"$norma" compute whole0.ply -o alone.ply --quiet
for cut in "1 5" "3 6" "11 7"; do
    read -r k seed <<<"$cut"
    make cut "$k" "$seed" "cut$k-"
    mapfile -t files < <(printf '%s\n' cut"$k"-*.ply | sort -R)
    "$norma" compute "${files[@]}" --together --out-dir "out$k" --quiet
    check "$k files: within 1e-6 of compute of the whole" make same 1e-6 "out$k"/*.ply -- alone.ply
    check "$k files: the same bits as one file" make same 0 "out$k"/*.ply -- out1/*.ply
done
for weight in area uniform max angle-area angle-lengths; do
    "$norma" compute whole0.ply -o alone.ply --weight $weight --quiet
    "$norma" compute cut3-?.ply --together --out-dir by3 --weight $weight --quiet
    "$norma" compute cut11-*.ply --together --out-dir by11 --weight $weight --quiet
    check "$weight: 3 and 11 files give the same bits" make same 0 by3/*.ply -- by11/*.ply
    check "$weight: within 1e-6 of compute" make same 1e-6 by3/*.ply -- alone.ply
done
make grid grid
"$norma" compute grid.ply -o alone.ply --quiet
"$norma" compute grid0.ply grid1.ply --together --out-dir grids --quiet
check "more records than memory holds: within 1e-6 of compute" make same 1e-6 grids/*.ply -- alone.ply
check "within a distance, the same" "$norma" compute grid0.ply grid1.ply --together --weld 0.001 --out-dir near --quiet
check "within a distance: no other normals" make same 1e-6 near/*.ply -- alone.ply

# ---- creases
for crease in 15 25; do
    "$norma" compute whole0.ply -o alone.ply --crease $crease --quiet
    "$norma" compute whole0.ply --together --crease $crease -o creased1.ply --quiet
    check "crease $crease: within 1e-6 of compute" make corners 1e-6 creased1.ply -- alone.ply
    for k in 3 11; do
        mapfile -t files < <(printf '%s\n' cut"$k"-*.ply | sort -R)
        "$norma" compute "${files[@]}" --together --crease $crease --out-dir "creased$k" --threads $((k % 4)) --quiet
        check "crease $crease, $k files: the same bits as one" make corners 0 "creased$k"/*.ply -- creased1.ply
    done
done
for file in cut3-?.ply; do make obj "$file" "${file%ply}obj"; done
"$norma" compute cut3-?.obj --together --crease 25 --out-dir objects --quiet
check "crease, OBJ: within 1e-6 of PLY" make corners 1e-6 objects/*.obj -- creased1.ply
"$norma" compute cut3-0.obj cut3-1.ply cut3-2.ply --together --crease 25 --out-dir mixed --quiet
check "crease, OBJ and PLY: the bits of PLY alone" make corners 0 mixed/cut3-1.ply mixed/cut3-2.ply mixed/cut3-0.obj -- mixed/cut3-1.ply mixed/cut3-2.ply objects/cut3-0.obj
"$norma" compute cut11-*.ply --together --crease 25 --weld 0.0001 --out-dir nearly --quiet
check "crease, within a distance that joins nothing: no other normals" make corners 1e-6 nearly/*.ply -- creased1.ply

# ---- nodes
make halves halves
"$norma" compute halves.ply -o alone.ply --quiet
"$norma" compute halves.glb -o whole.glb --together --quiet
check "two nodes, one mirrored and stretched: the normals of the whole in the world" make same 1e-6 whole.glb -- alone.ply
make twice twice
"$norma" compute halves.ply -o alone.ply --crease 20 --quiet
"$norma" compute halves.glb -o whole.glb --together --crease 20 --quiet
check "creases through two nodes, one mirrored and stretched" make corners 1e-6 whole.glb -- alone.ply
make steps steps
expect 3 "with creases, a mesh that needs other normals at another node is refused" "transform --bake gives" "$norma" compute steps.glb -o no.glb --together --crease 60
check "it is not refused where the edge between them is hard" "$norma" compute steps.glb -o steps-hard.glb --together --crease 30 --quiet
expect 3 "a mesh that needs other normals at another node is refused" "transform --bake gives" "$norma" compute twice.glb -o no.glb --together
mkdir -p failing/below kept
cp twice.glb failing/below/
expect 3 "and into a folder" "transform --bake gives" "$norma" compute failing --together --out-dir no.folder
check "a run that fails leaves no folder that it made" bash -c '[ ! -e no.folder ]'
expect 3 "and into a folder that is there" "transform --bake gives" "$norma" compute twice.glb --together --out-dir kept
check "a folder that was there stays" bash -c '[ -d kept ]'
check "nothing was written" test ! -e no.glb
"$norma" transform twice.glb --bake -o baked.glb --quiet
check "baked, it is computed" "$norma" compute baked.glb -o yes.glb --together --quiet

# ---- what keeps its normals; levels of detail
cat >body.obj <<'EOF'
o body
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
f 1 2 3 4
EOF
cat >head.obj <<'EOF'
o head
v 0 1 0
v 1 1 0
v 1 2 1
v 0 2 1
vn 0.6 0 0.8
g neck
f 1//1 2//1 3//1 4//1
EOF
"$norma" compute body.obj head.obj --together --lock 'n*k' --out-dir locked --quiet
if cmp -s head.obj locked/head.obj; then pass "what is locked stays, byte for byte"; else fail "what is locked stays" "$(diff head.obj locked/head.obj)"; fi
if grep -qx 'vn 0.6[0-9]* 0 0.8[0-9]*' locked/body.obj && [ "$(grep -c '^vn' locked/body.obj)" = 2 ]; then pass "what meets it takes its normal"; else fail "what meets it takes its normal" "$(cat locked/body.obj)"; fi
"$norma" compute body.obj head.obj --together --out-dir unlocked --quiet
if grep -qx 'vn 0.6[0-9]* 0 0.8[0-9]*' unlocked/body.obj; then fail "without the lock it is computed" "$(cat unlocked/body.obj)"; else pass "without the lock it is computed"; fi
make cut 2 3 levels
for order in "levels0.ply levels1.ply" "levels1.ply levels0.ply"; do
    read -r fine coarse <<<"$order"
    "$norma" compute "$fine" -o alone.ply --quiet
    "$norma" compute "$fine" "$coarse" --together --levels --out-dir levels --quiet
    check "$fine is the finest level: it has its own normals" make same 1e-6 "levels/$fine" -- alone.ply
    check "$fine is the finest level: the other takes them" make subset 0 "levels/$coarse" -- "levels/$fine"
done
cp levels0.ply rock_LOD1.ply
cp levels1.ply rock_lod0.ply
"$norma" compute rock_LOD1.ply rock_lod0.ply --together --out-dir named --quiet
check "names tell the levels" make same 1e-6 named/rock_lod0.ply -- alone.ply

make levels lod
"$norma" compute lod.ply -o alone.ply --quiet
"$norma" compute lod.glb -o lod-done.glb --together --quiet
check "MSFT_lod tells the levels" make same 1e-6 lod-done.glb -- alone.ply
"$norma" compute lod-two.glb -o lod-done.glb --together --quiet
check "without it, both add to the normals" sh -c "! python3 '$meshes' same 1e-6 lod-done.glb -- alone.ply 2>/dev/null"
make skin skin
"$norma" compute skin.ply -o alone.ply --quiet
"$norma" compute skin.glb -o skin-done.glb --together --quiet
check "a mesh with a skin is compared as it was bound" make same 1e-6 skin-done.glb -- alone.ply
make locks locks
"$norma" compute locks.glb -o locks-done.glb --together --lock part1 --quiet
check "glTF: a locked mesh keeps its normals, and what meets it takes them" make locked locks-done.glb

# ---- all or none
mkdir good
cp cut3-?.ply good
head -c 3000 cut3-1.ply >good/cut3-1.ply
cp -r good before
expect 3 "one bad file: an error that names it" "cut3-1.ply" "$norma" compute good --together --in-place
check "one bad file: no file was touched" diff -r before good
expect 3 "a full disk" "cut3-" bash -c "ulimit -f 8; exec '$norma' compute cut3-?.ply --together --out-dir full"
check "a full disk: nothing stays" test -z "$(ls -A full)"
cp cut3-1.ply good
cp cut3-1.ply before
"$norma" compute good --together --in-place --quiet
check "in place: the bits of --out-dir" diff -r good out3 --exclude=whole
rm -rf good
cp -r before good
# A rename that fails when others are in place already: a folder that may not be changed stands in the way of the last one.
mkdir -p good/z
cp cut3-0.ply good/z/last.ply
if [ "$(id -u)" != 0 ]; then
    chmod a-w good/z
    cp -r good before2
    expect 3 "a folder that may not be written" "cannot be written" "$norma" compute good --together --in-place
    check "a folder that may not be written: all is as it was" diff -r before2 good
    chmod u+w good/z
fi
"$norma" compute cut11-*.ply --together --in-place --quiet >/dev/null 2>&1 &
child=$!
kill -KILL $child 2>/dev/null
wait $child 2>/dev/null
check "after a kill every file can be read" "$norma" info cut11-*.ply

# ---- usage
expect 2 "creases and locked normals" "leave out --crease" "$norma" compute cut3-0.ply --together --crease 30 --lock a -o no.ply
expect 2 "creases and levels" "leave out --crease" "$norma" compute cut3-0.ply --together --crease 30 --levels -o no.ply
expect 3 "creases and a coarser level by its name" "levels one by one" "$norma" compute rock_LOD1.ply --together --crease 30 -o no.ply
for words in "--flat" "--weld none" "--weight visible" "--only missing"; do
    # shellcheck disable=SC2086
    expect 2 "$words cannot be combined" "together" "$norma" compute cut3-0.ply --together $words -o no.ply
done
"$norma" compute locks.glb -o locks-done.glb --together --lock prat1 --lock part1 --lock nothing-like-it --quiet 2>said
if [ "$(cat said)" = "norma: --lock 'prat1' matches no mesh, material or group, and locks nothing; did you mean part1?"$'\n'"norma: --lock 'nothing-like-it' matches no mesh, material or group, and locks nothing" ]; then pass "a lock that matches nothing is told, with the nearest name"; else fail "a lock that matches nothing is told, with the nearest name" "$(cat said)"; fi
expect 2 "--lock alone" "need --together" "$norma" compute cut3-0.ply --lock a -o no.ply
printf 'solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n' >a.stl
expect 2 "an STL is refused" "facet normals" "$norma" compute a.stl --together -o no.stl
finish
