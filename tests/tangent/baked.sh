#!/bin/bash
# A normal map that was baked for another program's tangents, drawn with Norma's: two mirrored halves of a ball share it. Judged by the surface that was baked, cut so finely that
# it needs no map: the same picture, the seam included. Tangents that the map was not baked for show that the comparison sees a seam.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
modules=${NORMA_NPM_TANGENT:-$root/build/npm-tangent/node_modules}
if ! [ -d "$modules/three" ] || ! command -v node >/dev/null; then
    skip "a baked map: scripts/install-deps.sh has not been run"
    finish
    exit
fi
draw() { "$norma" render "$scratch/$1.gltf" -o "$scratch/$1.png" --camera 0,10 --size 420x420 --clay=no --quiet; }
if ! "$norma" render "$root/assets/goathead.obj" -o "$scratch/any.png" --size 16x16 --quiet 2>/dev/null; then
    skip "a baked map: nothing can be drawn here"
    finish
    exit
fi

# apart ONE ANOTHER LEFT RIGHT: the mean and the largest difference in shades of 255, times 100, between two pictures from one column to the other.
apart() {
    node --input-type=module -e '
        import { readFileSync } from "node:fs";
        const [reader, one, another, left, right] = process.argv.slice(1);
        const { readPng } = await import(reader);
        const a = readPng(readFileSync(one)), b = readPng(readFileSync(another));
        let sum = 0, most = 0, count = 0;
        for (let y = 60; y < 320; y++)
            for (let x = Number(left); x < Number(right); x++) {
                const off = Math.abs(a.at(x, y)[0] - b.at(x, y)[0]);
                sum += off; most = Math.max(most, off); count++;
            }
        console.log(Math.round(100 * sum / count), 100 * most);' \
        "$root/tests/web/png.mjs" "$scratch/$1.png" "$scratch/$2.png" "$3" "$4"
}

check "the models are written" node "$root/tests/tangent/baked.mjs" "$modules" "$scratch"
check "norma tangents" "$norma" tangents "$scratch/bare.gltf" -o "$scratch/with.gltf" --quiet
for model in bare with reference other fine; do check "$model is drawn" draw "$model"; done
check "with Norma's tangents the picture is that of the tangents the map was baked for" cmp "$scratch/with.png" "$scratch/reference.png"
check "without tangents in the file norma render takes the same" cmp "$scratch/bare.png" "$scratch/reference.png"
for place in "left half:60 200" "right half:220 360" "seam:206 214"; do
    # shellcheck disable=SC2086  # two numbers
    read -r mean most < <(apart with fine ${place#*:})
    check "${place%%:*}: as the surface that was baked (mean $mean, most $most hundredths of a shade)" test "$mean" -le 50 -a "$most" -le 500
done
read -r mean most < <(apart other fine 206 214)
check "other tangents show a seam there (mean $mean)" test "$mean" -gt 1000
finish
