#!/bin/bash
# Draws the figures of the guide and of the README into docs/figures (or the folder given), by norma render: small models are written here, the others are in assets.
#   scripts/figures.sh [FOLDER]     the tool is $NORMA_BIN, build/bin/norma unless told otherwise
set -euo pipefail
cd "$(dirname "$0")/.."
norma=${NORMA_BIN:-build/bin/norma}
out=${1:-docs/figures}
models=$(mktemp -d)
trap 'rm -rf "$models"' EXIT
mkdir -p "$out"

# ---- models

# lathe SIDES "r y  r y ..." : a profile from below upwards, turned about the y axis; a radius of 0 closes it.
lathe() {
    awk -v sides="$1" -v profile="$2" 'BEGIN {
        n = split(profile, p, " ") / 2
        for (j = 0; j < n; j++) {
            r = p[2 * j + 1]; first[j] = count + 1; ring[j] = r > 0 ? sides : 1
            for (i = 0; i < ring[j]; i++) { t = 8 * atan2(1, 1) * i / sides; printf "v %.9g %.9g %.9g\n", r * cos(t), p[2 * j + 2], -r * sin(t); count++ }
        }
        for (j = 0; j + 1 < n; j++)
            for (i = 0; i < sides; i++) {
                k = (i + 1) % sides; a = first[j] + i % ring[j]; b = first[j] + k % ring[j]; c = first[j + 1] + k % ring[j + 1]; d = first[j + 1] + i % ring[j + 1]
                if (ring[j] == 1) print "f", a, c, d; else if (ring[j + 1] == 1) print "f", a, b, c; else print "f", a, b, c, d
            }
    }'
}

# sphere SIDES ROWS
sphere() {
    lathe "$1" "$(awk -v rows="$2" 'BEGIN { for (j = 0; j <= rows; j++) { t = 4 * atan2(1, 1) * j / rows; printf "%.9g %.9g ", j % rows ? sin(t) : 0, -cos(t) } }')"
}

# box X Y Z: twelve triangles on eight vertices.
box() {
    awk -v x="$1" -v y="$2" -v z="$3" 'BEGIN {
        for (i = 0; i < 8; i++) print "v", (i % 2 * 2 - 1) * x / 2, (int(i / 2) % 2 * 2 - 1) * y / 2, (int(i / 4) * 2 - 1) * z / 2
        n = split("1 3 4  1 4 2  5 6 8  5 8 7  1 2 6  1 6 5  3 7 8  3 8 4  1 5 7  1 7 3  2 4 8  2 8 6", f, " ")
        for (i = 1; i <= n; i += 3) print "f", f[i], f[i + 1], f[i + 2]
    }'
}

# bevel: a cube whose edges and corners are cut off, so that large faces meet in narrow ones.
bevel() {
    awk 'function v(x, y, z) { printf "v %.9g %.9g %.9g\n", x, y, z }
    function quad(a, b, c, d) { print "f", a, b, c, d }
    # The vertex on the side of axis (0 x, 1 y, 2 z), sign s; the other two axes with signs p, q.
    function id(axis, s, p, q) { return 1 + axis * 8 + (s > 0 ? 4 : 0) + (p > 0 ? 2 : 0) + (q > 0 ? 1 : 0) }
    BEGIN {
        e = 0.84
        for (axis = 0; axis < 3; axis++) for (s = -1; s <= 1; s += 2) for (p = -1; p <= 1; p += 2) for (q = -1; q <= 1; q += 2) {
            c[axis] = s; c[(axis + 1) % 3] = p * e; c[(axis + 2) % 3] = q * e; v(c[0], c[1], c[2])
        }
        for (axis = 0; axis < 3; axis++) {
            quad(id(axis, 1, -1, -1), id(axis, 1, 1, -1), id(axis, 1, 1, 1), id(axis, 1, -1, 1))
            quad(id(axis, -1, -1, -1), id(axis, -1, -1, 1), id(axis, -1, 1, 1), id(axis, -1, 1, -1))
            # Between the sides of this axis and of the next, along the third.
            b = (axis + 1) % 3
            for (s = -1; s <= 1; s += 2) for (t = -1; t <= 1; t += 2) {
                a1 = id(axis, s, t, -1); a2 = id(axis, s, t, 1); b1 = id(b, t, -1, s); b2 = id(b, t, 1, s)
                if (s * t > 0) quad(a1, b1, b2, a2); else quad(a1, a2, b2, b1)
            }
        }
        for (x = -1; x <= 1; x += 2) for (y = -1; y <= 1; y += 2) for (z = -1; z <= 1; z += 2)
            if (x * y * z > 0) print "f", id(0, x, y, z), id(1, y, z, x), id(2, z, x, y); else print "f", id(0, x, y, z), id(2, z, x, y), id(1, y, z, x)
    }'
}

sphere 16 8 >"$models/sphere.obj"
sphere 14 7 >"$models/coarse.obj"
lathe 16 "1 0  0.924 0.383  0.707 0.707  0.383 0.924  0 1" >"$models/dome.obj"
box 1 1 1 >"$models/cube.obj"
box 4 1 1 >"$models/box.obj"
bevel >"$models/bevel.obj"
lathe 28 "0 -1  0.88 -1  1 -0.88  1 -0.4  0.6 -0.4  0.6 0.35  0.86 0.35  0.86 0.74  0.7 0.9  0 0.9" >"$models/knob.obj"
printf 'v -1 0 0.7\nv 1.1 -0.1 0.5\nv 0.2 0.5 -0.9\nf 1 2 3\n' >"$models/face.obj"
printf 'v 0 0.55 0\nv 1 0 0.2\nv 0.35 -0.05 -0.95\nv -0.85 0.05 -0.6\nv -0.9 0 0.5\nv 0.15 -0.1 1\nf 1 2 3\nf 1 3 4\nf 1 4 5\nf 1 5 6\nf 1 6 2\n' >"$models/fan.obj"
printf 'v -1.5 -0.2 0.2\nv -1.5 -0.2 -0.2\nv -0.5 0.35 0.2\nv -0.5 0.35 -0.2\nv 0.5 0.35 0.2\nv 0.5 0.35 -0.2\nv 1.5 -0.2 0.2\nv 1.5 -0.2 -0.2\nf 1 3 4 2\nf 3 5 6 4\nf 5 7 8 6\n' >"$models/strip.obj"

# draw NAME OPTIONS...: one figure, in less than a hundred thousand bytes.
draw() {
    local file=$out/$1.png
    shift
    "$norma" render -o "$file" --quiet --samples 3 "$@"
    if [ "$(wc -c <"$file")" -ge 100000 ]; then
        echo "$0: $file is larger than 100,000 bytes" >&2
        exit 1
    fi
}

three=(--size 300x260 --show hedgehog --lines vertices --line-length 1)
draw face "$models/face.obj" --size 340x240 --camera 24,26 --show hedgehog,wireframe --lines faces --line-width 2
draw vertex "$models/fan.obj" --crease 180 --size 400x280 --camera 24,26 --show hedgehog,wireframe --lines vertices,faces --line-width 2
draw edge "$models/strip.obj" --crease 180 --size 460x200 --camera 0,14 --fov 0 --show hedgehog,wireframe --lines vertices,edges --line-width 1.8 --line-length 0.5
draw shadings "$models/coarse.obj" --compare=flat,gouraud,phong --size 300x280 --phong 0.1,0.8,0.55,45 --crease 180
for model in cube box bevel; do
    draw weights-$model "$models/$model.obj" --compare=angle,area,uniform --crease 180 --size 290x220 --show hedgehog,wireframe --lines vertices --line-length 0.8 --camera 28,24
done
draw creases "$models/knob.obj" --compare=30,60,180 --size 300x300 --camera 25,30
draw scale "$models/sphere.obj" --compare=before,plain,right --scale 2,0.5,1 --camera 20,14 "${three[@]}"
draw shear "$models/sphere.obj" --compare=before,plain,right --matrix "1 1 0 0  0 1 0 0  0 0 1 0  0 0 0 1" --camera 12,10 "${three[@]}"
draw mirror assets/goathead.obj --compare=before,right --scale -1,1,1 --size 360x320 --camera 0,6 --label 'before' --label 'mirrored: faces reversed'
draw flat "$models/dome.obj" --compare=before,plain,right --scale 1,0,1 --camera 20,24 "${three[@]}"
draw wrong-right assets/goathead.obj --compare=plain,right --scale 1,0.4,1 --size 390x274 --camera -42,20 --light -10,60,0.95 \
    --show hedgehog --lines vertices --most-lines 150 --line-width 2 --line-length 3 \
    --label 'WRONG: normals through M' --label 'RIGHT: normals through the normal matrix'

# The way of a normal, step by step: rows of the acid scenes without their marks, in the colours of their normals.
"$norma" acid -o "$models/acid" --quiet
for step in morph:morph skin:skinned instance:instanced model:mirror view:back-side; do
    python3 - "$models/acid/cells/${step#*:}.glb" "$models/way.glb" <<'END'
import json, struct, sys
data = open(sys.argv[1], "rb").read()
size = struct.unpack_from("<I", data, 12)[0]
asset = json.loads(data[20:20 + size])
for node in asset["nodes"]:
    if node.get("name", "").startswith("mark "):
        del node["mesh"]
text = json.dumps(asset).encode()
text += b" " * (-len(text) % 4)
rest = data[20 + size:]
open(sys.argv[2], "wb").write(struct.pack("<III", 0x46546C67, 2, 20 + len(text) + len(rest)) + struct.pack("<II", len(text), 0x4E4F534A) + text + rest)
END
    draw "way-${step%%:*}" "$models/way.glb" --size 760x210 --camera 0,0 --fov 0 --show normals
done

# A baked map with the right tangents and with others; without three.js, whose tangents it is baked for, the old picture stays.
three_js=${NORMA_NPM_TANGENT:-build/npm-tangent/node_modules}
if [ -d "$three_js/three" ]; then
    node tests/tangent/baked.mjs "$three_js" "$models"
    "$norma" tangents "$models/bare.gltf" -o "$models/with.gltf" --quiet
    baked=(--size 300x300 --camera 0,10 --clay=no --background white)
    draw baked-with "$models/with.gltf" "${baked[@]}" --label 'drawn with its map'
    draw baked-other "$models/other.gltf" "${baked[@]}" --label 'one sign of w for both halves'
    draw baked-fine "$models/fine.gltf" "${baked[@]}" --label 'the surface that was baked'
fi

# The report of norma check as a browser shows it; without Chromium the old picture stays.
if command -v chromium >/dev/null; then
    "$norma" check assets/spider.stl --format html -o "$models/report.html" --quiet --fail-on never
    chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --window-size=1040,930 --screenshot="$models/report.png" "file://$models/report.html" >/dev/null 2>&1
    cp "$models/report.png" "$out/report.png"
fi
