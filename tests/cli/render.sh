#!/bin/bash
# norma render as people run it: files, numbers, errors, and a few pictures against references in tests/cli/pictures (mean difference at most half a level, at most one pixel
# in a hundred off by more than 8). tests/cli/render.sh --refresh draws the references again: look at them before you commit them.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
compare=$tree/tests/picture_compare
pictures=$root/tests/cli/pictures
cd "$root" || exit 1
[ -x "$norma" ] || { fail "the tool is there" "no program at $norma"; finish; exit 1; }

printf 'v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n' >"$scratch/square.obj"
if ! "$norma" render "$scratch/square.obj" -o "$scratch/square.png" --renderer software --quiet 2>"$scratch/message"; then
    skip "nothing can be drawn here: $(cat "$scratch/message")"
    finish
    exit
fi

# A unit ball by meridians and parallels, its normals exact to nine digits: vertices at 45 degrees between the axes, where plain M errs most.
awk 'BEGIN {
    pi = 4 * atan2(1, 1)
    for (j = 0; j <= 16; j++) for (i = 0; i < 32; i++) {
        p = sprintf("%.12g %.12g %.12g", sin(pi * j / 16) * cos(pi * i / 16), cos(pi * j / 16), -sin(pi * j / 16) * sin(pi * i / 16)); print "v", p; print "vn", p
    }
    for (j = 0; j < 16; j++) for (i = 0; i < 32; i++) {
        a = 32 * j + i + 1; b = 32 * j + (i + 1) % 32 + 1; c = a + 32; d = b + 32
        if (j > 0) printf "f %d//%d %d//%d %d//%d\n", a, a, c, c, b, b
        if (j < 15) printf "f %d//%d %d//%d %d//%d\n", b, b, c, c, d, d
    }
}' >"$scratch/ball.obj"

# value KEY: of the JSON line on standard input.
value() { sed -nE "s/.*\"$1\": (\"[^\"]*\"|[^,}]*).*/\1/p"; }
# near A B: within a ten-thousandth.
near() { awk -v a="$1" -v b="$2" 'BEGIN { exit !(a - b < 1e-4 && b - a < 1e-4) }'; }
# size FILE: width and height as its IHDR has them.
size() { od -An -tu1 -j16 -N8 "$1" | awk '{ print $3 * 256 + $4 "x" $7 * 256 + $8 }'; }

for s in 1.5 2 4 10; do
    expected=$(awk -v s="$s" 'BEGIN { x = (s * s - 1) / (s * s + 1); print atan2(x, sqrt(1 - x * x)) * 45 / atan2(1, 1) }')
    said=$("$norma" render "$scratch/ball.obj" -o "$scratch/a.png" --compare --scale "$s",1,1 --size 64x64 --json | value worst_error_deg)
    if near "$said" "$expected"; then pass "plain M at scale $s errs by asin((s^2-1)/(s^2+1)) = $expected"; else fail "plain M at scale $s" "$said, expected $expected"; fi
done
said=$("$norma" render "$scratch/ball.obj" -o "$scratch/a.png" --compare --scale 3 --rotate 1,2,3,40 --size 64x64 --json | value worst_error_deg)
if near "$said" 0; then pass "and by nothing under a uniform scale and a rotation"; else fail "a uniform scale and a rotation" "$said"; fi
check "two panels side by side, words above and below" test "$(size "$scratch/a.png")" = 128x134

"$norma" render "$scratch/ball.obj" -o "$scratch/b.png" --compare=gouraud,phong --size 64x64 --json >"$scratch/json"
difference=$(value largest_difference <"$scratch/json")
check "--compare=gouraud,phong tells the largest difference" test "$difference" -gt 0
"$norma" render "$scratch/ball.obj" -o "$scratch/b.png" --compare=phong,phong --size 64x64 --json >"$scratch/json"
check "which is 0 between a picture and itself" test "$(value largest_difference <"$scratch/json")" = 0

"$norma" render assets/goathead.obj -o "$scratch/one.png" --quiet --show hedgehog,wireframe --renderer software
"$norma" render assets/goathead.obj -o "$scratch/two.png" --quiet --show hedgehog,wireframe --renderer software
check "two pictures of one input are the same to the bit" cmp "$scratch/one.png" "$scratch/two.png"
"$norma" render assets/goathead.obj -o - --quiet --show hedgehog,wireframe --renderer software | cat >"$scratch/three.png"
check "and so is the one on standard output" cmp "$scratch/one.png" "$scratch/three.png"
"$norma" render - --input-format obj -o "$scratch/three.png" --quiet --show hedgehog,wireframe --renderer software <assets/goathead.obj
check "and the one of standard input" cmp "$scratch/one.png" "$scratch/three.png"
"$norma" render assets/goathead.obj -o "$scratch/view.png" --quiet --space view --renderer software --matrix "1 0.5 0 0  0 0.4 0.1 0  0.2 0 2 0  0 0 0 1"
"$norma" render assets/goathead.obj -o "$scratch/world.png" --quiet --space world --renderer software --matrix "1 0.5 0 0  0 0.4 0.1 0  0.2 0 2 0  0 0 0 1"
check "light in view space and in world space: one picture" "$compare" "$scratch/view.png" "$scratch/world.png" 0.02 0

check "PNG: the chunk sRGB is there" grep -aq sRGB "$scratch/one.png"
printf 'v 0 0 0\n' >"$scratch/point.obj"
cp "$scratch/point.obj" "$scratch/other.obj"
check "a run that draws nothing leaves no folder that it made" bash -c '! "$0" render "$1/point.obj" "$1/other.obj" --out-dir "$1/none" 2>/dev/null && [ ! -e "$1/none" ]' "$norma" "$scratch"
"$norma" render "$scratch/square.obj" assets/spider.stl --out-dir "$scratch/all" --size 40x30 --json >"$scratch/json"
check "several inputs: a picture and a line each" test -s "$scratch/all/square.png" -a -s "$scratch/all/spider.png" -a "$(wc -l <"$scratch/json")" = 2

# A hilly ground over the x and y axes, and the same over x and z; a stool with a flat foot at z = 0; a beast on four pointed feet at z = 0, whose snout is its only point at the least y.
awk 'BEGIN { for (y = 0; y < 6; y++) for (x = 0; x < 6; x++) print "v", x, y, 0.2 * sin(3 * x + y); for (y = 0; y < 5; y++) for (x = 1; x < 6; x++) { a = 6 * y + x; print "f", a, a + 1, a + 7, a + 6 } }' >"$scratch/z-up.obj"
awk '$1 == "v" { print "v", $2, $4, -$3; next } { print }' "$scratch/z-up.obj" >"$scratch/y-up.obj"
printf 'v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 0.9 0.9 3\nv 1.1 0.9 3.1\nv 1 1.1 3.2\nf 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 7\nf 4 1 5 7\nf 5 6 7\n' >"$scratch/foot.obj"
printf 'v -1 -2 0\nv 1 -2 0\nv 1 2 0\nv -1 2 0\nv -1 -2 2\nv 1 -2 2\nv 1 2 2\nv -1 2 2\nv 0 -4 2\nf 1 5 9\nf 2 9 6\nf 3 6 7\nf 4 7 8\nf 5 6 7 8\nf 5 6 9\n' >"$scratch/feet.obj"
for name in z-up=z y-up=y foot=z feet=z; do
    "$norma" render "$scratch/${name%=*}.obj" -o "$scratch/u.png" --size 32x32 --json >"$scratch/json"
    check "--up of ${name%=*}.obj is guessed, and said so" test "$(value up <"$scratch/json") $(value up_guessed <"$scratch/json")" = "\"${name#*=}\" true"
done
"$norma" render "$scratch/z-up.obj" -o "$scratch/u.png" --size 32x32 --up x --json >"$scratch/json"
check "--up is taken where it is given" test "$(value up <"$scratch/json") $(value up_guessed <"$scratch/json")" = '"x" false'
# Seen from the side, the apex of the stool is below its foot where the axis is turned round: the two silhouettes are mirrored top to bottom.
for axis in x y z; do
    "$norma" render "$scratch/foot.obj" -o "$scratch/u.png" --size 64x64 --up "$axis" --fov 0 --camera 0,0 --json >"$scratch/json"
    "$norma" render "$scratch/foot.obj" -o "$scratch/w.png" --size 64x64 --up "-$axis" --fov 0 --camera 0,0 --json >"$scratch/json-"
    check "--up -$axis is the other way round than $axis" awk 'function up(file,  line, m) { getline line <file; sub(/.*"world_to_clip": \[/, "", line); split(line, m, /[],] */); return sprintf("%.4f %.4f %.4f", m[2], m[6], m[10]) }
        BEGIN { split(up(ARGV[1]), a); split(up(ARGV[2]), b); exit !(a[1] == -b[1] && a[2] == -b[2] && a[3] == -b[3] && a[1] a[2] a[3] != "0.00000.00000.0000") }' "$scratch/json" "$scratch/json-"
done
"$norma" render assets/box-rotated.obj -o "$scratch/f.png" --size 100x100 --show findings --quiet
"$norma" render assets/box-rotated.obj -o "$scratch/g.png" --size 100x100 --show findings --select N5 --quiet
check "--select leaves findings of other rules out" bash -c '! cmp -s "$0" "$1"' "$scratch/f.png" "$scratch/g.png"

printf 'v 0 0 0\nv 1 0 0\nl 1 2\n' >"$scratch/lines.obj"
# norma compare: BASE is a plate whose normals are tilted by 20 degrees; in OTHER, the right half has upright ones. So the left half has the first colour of the scale (viridis), the right half the last one.
plate() { printf 'v -1 -1 0\nv 0 -1 0\nv 1 -1 0\nv -1 1 0\nv 0 1 0\nv 1 1 0\nvn 0.3420201433 0 0.9396926208\nvn %s\nf 1//1 2//1 5//1 4//1\nf 2//2 3//2 6//2 5//2\n' "$1"; }
plate '0.3420201433 0 0.9396926208' >"$scratch/base.obj"
plate '0 0 1' >"$scratch/other.obj"
"$norma" compare "$scratch/base.obj" "$scratch/other.obj" -o "$scratch/apart.png" >"$scratch/stdout"
check "norma compare -o names the picture" grep -q "drawn in .*/apart.png" "$scratch/stdout"
check "norma compare -o: colours by the angle" python3 - "$scratch/apart.png" <<'END'
import struct, sys, zlib
data, at, packed = open(sys.argv[1], "rb").read(), 8, b""
while at < len(data):
    size, kind = struct.unpack(">I4s", data[at:at + 8])
    if kind == b"IHDR": width, height, depth, colours = struct.unpack(">IIBB", data[at + 8:at + 18])
    if kind == b"IDAT": packed += data[at + 8:at + 8 + size]
    at += size + 12
assert depth == 8 and colours in (2, 6)
step = 3 if colours == 2 else 4
raw, row, rows = zlib.decompress(packed), bytearray(width * step), []
for y in range(240):
    line = bytearray(raw[y * (width * step + 1) + 1:(y + 1) * (width * step + 1)])
    for i in range(len(line)):
        a, b, c = (line[i - step] if i >= step else 0), row[i], (row[i - step] if i >= step else 0)
        p = a + b - c
        paeth = a if abs(p - a) <= abs(p - b) and abs(p - a) <= abs(p - c) else b if abs(p - b) <= abs(p - c) else c
        line[i] = line[i] + (0, a, b, (a + b) // 2, paeth)[raw[y * (width * step + 1)]] & 255
    row = line
    rows.append(line)
seen = [[[], []], [[], []]]  # of each panel: where in its middle row the first and the last colour stand, as light leaves them
for x in range(width):
    r, g, b = (v / 255 for v in rows[-1][x * step:x * step + 3])
    first, last = (0.267, 0.005, 0.329), (0.993, 0.906, 0.144)
    for k, colour in enumerate((first, last)):
        light = max(r, g, b) / max(colour)
        if 0.6 < light < 1.1 and all(abs(v - light * c) < 0.02 for v, c in zip((r, g, b), colour)): seen[2 * x // width][k].append(x)
print([[(min(part, default=0), max(part, default=0)) for part in panel] for panel in seen])
front, back = seen
sys.exit(not (all(len(part) > 100 for panel in seen for part in panel) and max(front[0]) <= min(front[1]) and max(back[1]) <= min(back[0])))
END
"$norma" compare "$scratch/base.obj" "$scratch/other.obj" -o "$scratch/apart.html" --max 30 --quiet >"$scratch/stdout"
base64 -w 0 "$scratch/apart.png" >"$scratch/apart.base64"
check "norma compare -o: the page holds the same picture" grep -qFf "$scratch/apart.base64" "$scratch/apart.html"
"$norma" compare "$scratch/base.obj" "$scratch/other.obj" -o - 2>"$scratch/stderr" | cmp - "$scratch/apart.png" >"$scratch/message"
check "norma compare -o -: the picture to standard output, the words to standard error" bash -c '[ ! -s "$0" ] && grep -q "at most 20" "$1"' "$scratch/message" "$scratch/stderr"
check "norma compare: the page has what is printed" grep -q 'fine: 0 % of the area is above 30 degrees' "$scratch/apart.html"
status=0
"$norma" compare "$scratch/base.obj" "$scratch/other.obj" -o "$scratch/other.obj" 2>"$scratch/stderr" || status=$?
check "norma compare -o: neither another ending nor an input" bash -c '[ "$0" = 2 ] && grep -q "ends in .png or .html" "$1" && cp "$2/base.obj" "$2/base.png" && ! "$3" compare "$2/base.png" "$2/other.obj" --input-format obj -o "$2/base.png" 2>"$1" && grep -q "would be overwritten" "$1" && cmp "$2/base.png" "$2/base.obj"' "$status" "$scratch/stderr" "$scratch" "$norma"
status=0
"$norma" compare "$scratch/base.obj" "$scratch/other.obj" -o "$scratch/none/x.png" --json >"$scratch/json" 2>"$scratch/stderr" || status=$?
check "norma compare -o: a picture that was not written is an error, not an output" python3 -c 'import json, sys; said = json.load(open(sys.argv[2])); sys.exit(sys.argv[1] != "3" or "x.png" not in said["error"] or "output" in said or "ok" in said)' "$status" "$scratch/json"
check "norma compare -o: a device takes a picture" "$norma" compare "$scratch/base.obj" "$scratch/other.obj" -o /dev/null --quiet
"$norma" render "$scratch/square.obj" -o "$scratch/e.png" --show error --size 64x64 --samples 1 >"$scratch/stdout"
check "errors without stored normals: said plainly" grep -q 'no normals are stored: there is nothing to compare' "$scratch/stdout"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n' >"$scratch/stored.obj"
"$norma" render "$scratch/stored.obj" -o "$scratch/e.png" --crease 30 --size 32x32 >/dev/null 2>"$scratch/stderr"
check "--crease without an effect is noted" grep -q 'note: no effect: --crease' "$scratch/stderr"
"$norma" render "$scratch/square.obj" -o "$scratch/e.png" --crease 30 --size 32x32 >/dev/null 2>"$scratch/stderr"
check "and with one it is not" test ! -s "$scratch/stderr"
cat >"$scratch/images.gltf" <<'END'
{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
"materials":[{"alphaMode":"MASK","pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],"textures":[{"source":1}],"images":[{"uri":"a.png"},{"uri":"nowhere.png"}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],
"buffers":[{"byteLength":60,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/"}]}
END
"$norma" render "$scratch/images.gltf" -o "$scratch/e.png" --size 64x64 >"$scratch/stdout" 2>"$scratch/stderr"
check "an image that cannot be read is named" grep -q 'not drawn: 1 image that cannot be read (/images/1)' "$scratch/stdout"
check "with the reason" grep -q 'note: /images/1 is not drawn: .' "$scratch/stderr"
# Clay shows no colour of a material and is never glass; a mask cuts it, and so does an image with an outline that is blended.
like() { # NAME MATERIAL MATERIAL: both give the same picture
    for material in "$2" "$3"; do
        sed -e "s|\"materials\":.*\"textures\"|\"materials\":[{\"doubleSided\":true,$material}],\"textures\"|" -e 's|nowhere.png|data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAYAAABytg0kAAAAGklEQVR42mM4wSX3X2SLBgMDq82d/1FRXP8BOFIGubJvuY4AAAAASUVORK5CYII=|' "$scratch/images.gltf" >"$scratch/clay.gltf"
        mv "$scratch/clay.png" "$scratch/clay-1.png" 2>/dev/null
        "$norma" render "$scratch/clay.gltf" -o "$scratch/clay.png" --size 64x64 --quiet
    done
    check "$1" cmp "$scratch/clay-1.png" "$scratch/clay.png"
}
image='"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}'
like "an image of colours leaves clay as it is" '"alphaMode":"OPAQUE"' "$image"
cp "$scratch/clay.png" "$scratch/whole.png"
like "what lets light through is clay" '"alphaMode":"OPAQUE"' '"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[0.2,0.4,1,0.3]}'
like "an outline that is blended cuts as a mask does" "\"alphaMode\":\"MASK\",$image" "\"alphaMode\":\"BLEND\",$image"
check "and a mask does cut" bash -c '! cmp -s "$0" "$1"' "$scratch/whole.png" "$scratch/clay.png"

# refused STATUS NAME COMMAND...: its exit status, one line of error, and no picture left.
refused() {
    local wanted=$1 name=$2 status=0
    shift 2
    rm -f "$scratch"/no.png*
    "$@" >"$scratch/stdout" 2>"$scratch/stderr" || status=$?
    if [ "$status" = "$wanted" ] && [ "$(wc -l <"$scratch/stderr")" = 1 ] && [ -z "$(ls "$scratch"/no.png* 2>/dev/null)" ]; then pass "$name"
    else fail "$name" "status $status; $(cat "$scratch/stderr")"; fi
}
refused 3 "a file without a surface is told of" "$norma" render "$scratch/lines.obj" -o "$scratch/no.png"
refused 3 "a file that is not there" "$norma" render "$scratch/nothing.obj" -o "$scratch/no.png"
refused 3 "a folder that is not there" "$norma" render "$scratch/square.obj" -o "$scratch/nowhere/no.png"
refused 2 "--select without findings" "$norma" render "$scratch/square.obj" -o "$scratch/no.png" --select N3
for idle in "--line-length 2" "--most-lines 9" "--line-width 2" "--error-top 9" "--show error --normals computed"; do
    # shellcheck disable=SC2086  # words
    refused 2 "$idle, which nothing looks at" "$norma" render "$scratch/square.obj" -o "$scratch/no.png" $idle
done
refused 3 "a full disk" "$norma" render "$scratch/square.obj" -o /dev/full
refused 2 "more pixels than the renderer draws" "$norma" render "$scratch/square.obj" -o "$scratch/no.png" --size 16000x16 --samples 4
refused 3 "no EGL that could start: one clear error" env __EGL_VENDOR_LIBRARY_DIRS="$scratch/none" "$norma" render "$scratch/square.obj" -o "$scratch/no.png"

# reference NAME OPTIONS...
reference() {
    local name=$1 said
    shift
    "$norma" render "$@" -o "$scratch/$name.png" --quiet --renderer software 2>"$scratch/message" || { fail "$name.png" "$(cat "$scratch/message")"; return; }
    if [ "$refresh" = 1 ]; then mkdir -p "$pictures" && cp "$scratch/$name.png" "$pictures/"; fi
    if said=$("$compare" "$scratch/$name.png" "$pictures/$name.png"); then pass "$name.png is as it was: $said"; else fail "$name.png is as it was" "$said"; fi
}
refresh=0
[ "${1:-}" != --refresh ] || refresh=1
reference shadings assets/dodecahedron.obj --compare=flat,gouraud,phong --crease 180 --size 96x96
reference compare assets/goathead.obj --compare --scale 2,0.5,1 --size 128x96
reference hedgehog assets/dodecahedron.obj --show hedgehog --size 128x128
reference wireframe assets/box-rotated.obj --show winding,wireframe --size 128x128
reference normals assets/goathead.obj --show normals --size 80x80
reference error assets/spider.stl --show error --size 128x128
reference zebra assets/goathead.obj --show zebra --size 128x128
reference matcap assets/goathead.obj --show matcap --size 128x128
reference concave assets/concave-66gon.obj --shading flat --camera 60,20 --size 128x128
reference clear assets/goathead.obj --background transparent --size 96x96

# The guide's figures are what scripts/figures.sh draws, and the guide shows them all.
if NORMA_BIN=$norma scripts/figures.sh "$scratch/figures" >"$scratch/message" 2>&1; then
    for file in "$scratch"/figures/*.png; do
        name=$(basename "$file")
        [ "$name" != report.png ] || continue # a browser's text, which differs with the fonts installed
        if said=$("$compare" "$file" "docs/figures/$name"); then pass "docs/figures/$name is what is drawn now: $said"; else fail "docs/figures/$name is what is drawn now" "$said"; fi
    done
else
    fail "scripts/figures.sh" "$(cat "$scratch/message")"
fi
status=0
"$norma" render assets/goathead.obj -o "$scratch/no.png" --max-memory 20M >/dev/null 2>"$scratch/stderr" || status=$?
if [ "$status" = 3 ] && grep -q 'memory is limited to 20M (--max-memory)' "$scratch/stderr"; then pass "a limit of memory that a driver does not fit in is named"
else fail "a limit of memory that a driver does not fit in is named" "status $status; $(cat "$scratch/stderr")"; fi
unseen=$(for file in docs/figures/*; do grep -q "figures/$(basename "$file")" docs/*.md README.md || echo "$file"; done)
if [ -z "$unseen" ]; then pass "every figure is shown somewhere"; else fail "every figure is shown somewhere" "$unseen"; fi
finish
