#!/bin/bash
# Sources are never outputs: whatever a command reads (meshes, buffers, lists, baselines, configurations), and whatever those files name (pictures, material libraries), is refused
# as an output of any verb, under any of its names, with status 2 and before anything is written. Every case runs in a fresh copy of one folder, whose files must all be as they were.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
NORMA=${NORMA_BIN:-$tree/bin/norma}
cd "$scratch" || exit 1

mkdir -p fresh/below
printf 'mtllib cloth.mtl "odd name.mtl"\no plate\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n' >fresh/plate.obj
printf 'newmtl cloth\n' >fresh/cloth.mtl
printf 'ply\nformat ascii 1.0\ncomment TextureFile skin.png\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' >fresh/skin.ply
echo picture >fresh/skin.png
# One triangle, its buffer beside it, and pictures by plain, escaped and climbing names.
gltf() {
    printf '{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],"bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"uri":"%s","byteLength":36}],"images":[%s]}' "$1" "$2"
}
printf '\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\77\0\0\0\0' >fresh/crate.bin
cp fresh/crate.bin fresh/below/lid.bin
gltf crate.bin '{"uri":"wood.png"},{"uri":"old%20page.html"},{"uri":"data:image/png;base64,AAAA"},{"uri":7},7' >fresh/crate.gltf
gltf lid.bin '{"uri":"../crate.png"}' >fresh/below/lid.gltf
for name in wood.png 'old page.html' crate.png; do echo "$name" >"fresh/$name"; done
gltf crate.bin '{"uri":"below/cover.gltf"}' >fresh/book.gltf
echo cover.gltf >fresh/below/cover.gltf
ln -s wood.png fresh/link.png
ln fresh/crate.bin fresh/hard.bin
ln -s plate.obj fresh/link.obj
echo '{"fail-on": "never"}' >fresh/.norma.json
printf 'plate.obj\n' >fresh/list.txt
printf '{"schema": "norma-baseline/1", "findings": []}\n' >fresh/old.json

# refused COMMAND...: status 2, one line that says why, and every file as it was.
refused() {
    local status=0 said
    rm -rf now && cp -a fresh now
    said=$(cd now && "$NORMA" "$@" 2>&1 </dev/null >stdout) || status=$?
    rm -f now/stdout
    if [ $status -eq 2 ] && [[ $said == *"would be overwritten"* || $said == *"names the input"* || $said == *"same file"* ]] && [[ $said != *$'\n'* ]] && diff -r --no-dereference fresh now >changed; then
        pass "refused: $*"
    else
        fail "refused: $*" "status $status: $said"$'\n'"$(cat changed 2>/dev/null)"
    fi
}

# written FILE COMMAND...: status 0 or 1, and the file is new or another.
written() {
    local file=$1 status=0 said
    shift
    rm -rf now && cp -a fresh now
    said=$(cd now && "$NORMA" "$@" 2>&1 </dev/null) || status=$?
    if [ $status -le 1 ] && [ -s "now/$file" ] && ! cmp -s "fresh/$file" "now/$file"; then pass "written: $*"; else fail "written: $*" "status $status: $said"; fi
}

# kept LIMIT: too little memory to read an asset frees no buffer of it, whether its names could be read or not.
kept() {
    local status=0 said
    rm -rf now && cp -a fresh now
    gltf tall.bin '' | sed 's/"buffers":\[{"uri":"tall.bin","byteLength":36/"buffers":[{"uri":"tall.bin","byteLength":6000000/; s/"bufferView":0,"componentType":5126,"count":3/"bufferView":0,"componentType":5126,"count":500000/; s/"byteLength":36}\],"buffers"/"byteLength":6000000}],"buffers"/' >now/tall.gltf
    head -c 6000000 /dev/zero >now/tall.bin
    said=$(cd now && "$NORMA" check tall.gltf --max-memory "$1" -o tall.bin 2>&1 </dev/null) || status=$?
    if [ $status -ge 2 ] && [ "$(stat -c %s now/tall.bin)" = 6000000 ]; then pass "kept: a buffer of an asset that takes more than $1"; else fail "kept: a buffer of an asset that takes more than $1" "status $status: $said"; fi
}

for limit in 500K 1M 2M 3M 4M 6M 9M; do kept $limit; done
refused check plate.obj -o plate.obj
refused check plate.obj -o link.obj
refused check . -o plate.obj
refused check . -o below/lid.gltf
refused check plate.obj -o cloth.mtl
refused check plate.obj --format html -o .norma.json
refused check plate.obj --config .norma.json -o .norma.json
refused check --files-from list.txt -o list.txt
refused check plate.obj --baseline old.json -o old.json
refused check plate.obj --write-baseline plate.obj
refused check plate.obj --write-baseline .norma.json
refused check crate.gltf --write-baseline crate.bin
refused check crate.gltf -o report.json --write-baseline wood.png
refused check crate.gltf --fix-unsafe --in-place --write-baseline wood.png
refused check crate.gltf plate.obj --fix-unsafe --in-place --write-baseline crate.bin
refused check crate.gltf -o crate.bin
refused check crate.gltf -o hard.bin
refused check crate.gltf -o 'old page.html'
refused check crate.gltf below/lid.gltf -o crate.png
refused check skin.ply -o skin.png
refused check plate.obj -o new.json --write-baseline new.json
refused check plate.obj skin.ply --fix-unsafe --out-dir .
refused check plate.obj --fix -o link.obj
refused compute plate.obj -o link.obj
refused compute plate.obj skin.ply --out-dir .
refused compute crate.gltf --out-dir .
refused transform plate.obj --scale 2 --out-dir below/..
written report.json check crate.gltf -o report.json
written crate.png check crate.gltf -o crate.png
written base.json check plate.obj --write-baseline base.json
written plate.obj compute plate.obj --in-place
refused check book.gltf --fix-unsafe --select N104 -o below/cover.gltf
written out/plate.obj compute plate.obj --out-dir out
written plate.obj check plate.obj --fix-unsafe --select N104 --in-place

# Standard input that is a file counts as that file, and so does standard output.
rm -rf now && cp -a fresh now && cd now || exit 1
status=0
"$NORMA" compute - --input-format obj -o plate.obj <plate.obj >/dev/null 2>&1 || status=$?
if [ $status -eq 2 ] && cmp -s plate.obj ../fresh/plate.obj; then pass "refused: standard input's own file"; else fail "refused: standard input's own file" "status $status"; fi
status=0
"$NORMA" compute plate.obj -o - >>plate.obj 2>/dev/null || status=$?
if [ $status -eq 2 ] && cmp -s plate.obj ../fresh/plate.obj; then pass "refused: standard output onto the input"; else fail "refused: standard output onto the input" "status $status"; fi
cd ..

if "$NORMA" render fresh/plate.obj -o drawn.png >/dev/null 2>&1; then
    refused render crate.gltf -o wood.png
    refused render crate.gltf -o link.png
    refused render below/lid.gltf -o crate.png
    refused render below/lid.gltf crate.gltf --out-dir .
    refused render skin.ply --out-dir .
    written new.png render crate.gltf -o new.png
else
    skip "render: no picture can be drawn here"
fi
if "$NORMA" view fresh/plate.obj -o page.html >/dev/null 2>&1; then
    refused view crate.gltf -o 'old page.html'
    written new.html view crate.gltf -o new.html
else
    skip "view: the page is not built in"
fi
finish
