#!/bin/bash
# norma check --fix-unsafe --select N812: normal maps of the other convention get their green channel inverted, in every kind of PNG and wherever an image can stand;
# nothing else that shows the picture changes, and no file is overwritten. The judge of the pixels and chunks is tests/cli/turn_green_files.py, the judge of the files the
# Khronos validator.
# shellcheck source=tests/support/gltf_judges.sh
source "$(dirname "$0")/../support/gltf_judges.sh"
files="$root/tests/cli/turn_green_files.py"
cd "$scratch" || exit 1
if ! command -v python3 >/dev/null; then
    skip "python3 is missing"
    finish
    exit
fi
python3 "$files" make
if "$norma" check view.glb --select N002 --no-config --quiet 2>&1 | grep -q 'built without'; then
    skip "this build decodes no pictures"
    finish
    exit
fi
sha256sum ./* >before
mkdir out
fix() { "$norma" check "$1" --fix-unsafe --select N812 --no-config --quiet "${@:2}" >said 2>&1; }

# ---- every kind, every place
for file in file_*.gltf view.gltf view.glb data.gltf texture_shared_* image_shared_* both_turned.glb view_shared.glb own_use.glb name_taken.gltf; do
    out="out/${file%.*}_out.${file##*.}"
    [ "$file" = name_taken.gltf ] && out=out/out.gltf
    fix "$file" -o "$out"
    status=$?
    if [ $status = 0 ] && why=$(python3 "$files" judge "$file" "$out" 2>&1); then pass "$file"; else fail "$file" "status $status: $(cat said; echo "$why" | tail -n 3)"; fi
    printf '%s\t%s\n' "$scratch/$file" "$scratch/$out" >>pairs
    fix "$out" -o "out/again.${out##*.}"
    if cmp -s "$out" "out/again.${out##*.}"; then pass "$file: fixing twice changes nothing"; else fail "$file: fixing twice changes nothing" "$(cat said)"; fi
    rm -f out/again*
done
judge_validity "the outputs" pairs
if [ "$(grep -o 'out_normal_0[-0-9]*.png' out/out.gltf | sort | tr '\n' ' ')" = "out_normal_0-1.png out_normal_0.png " ]; then pass "a name that the asset has is not taken"; else fail "a name that the asset has is not taken" "$(grep -n png out/out.gltf)"; fi
if sha256sum --quiet -c before >changed 2>&1; then pass "no input has changed"; else fail "no input has changed" "$(cat changed)"; fi

# ---- in place, and on a stream
mkdir place
cp file_rgb8.* rgb8.png place
echo mine >place/file_rgb8_normal_0.png
fix place/file_rgb8.gltf --in-place
if python3 "$files" judge file_rgb8.gltf place/file_rgb8.gltf 2>why && cmp -s rgb8.png place/rgb8.png && [ "$(cat place/file_rgb8_normal_0.png)" = mine ]; then pass "in place, no picture is overwritten"; else fail "in place, no picture is overwritten" "$(cat said why; ls place)"; fi
sha256sum place/* >placed
fix place/file_rgb8.gltf --in-place
if sha256sum --quiet -c placed >changed 2>&1 && [ "$(find place -type f | wc -l)" = 5 ]; then pass "in place twice changes nothing"; else fail "in place twice changes nothing" "$(cat changed; ls place)"; fi
"$norma" check file_rgb8.gltf --fix-unsafe --select N812 --no-config --quiet -o - >stream.gltf 2>said
if python3 "$files" judge file_rgb8.gltf stream.gltf 2>why && [ "$(find . -name 'stream*' | wc -l)" = 1 ]; then pass "on standard output it is a data URI"; else fail "on standard output it is a data URI" "$(tail -n 3 why; head -c 300 said)"; fi

# ---- all or nothing, and what is left with its reason
mkdir small
(ulimit -f 8 && trap '' XFSZ && fix file_rgb8.gltf -o small/file.gltf)
status=$?
if [ $status = 3 ] && [ -z "$(ls small)" ]; then pass "a picture that cannot be written leaves nothing"; else fail "a picture that cannot be written leaves nothing" "status $status: $(ls small; cat said)"; fi
fix halves.gltf -o out/halves.gltf
if [ "$(grep -c '"uri": "halves' out/halves.gltf)" = 3 ] && grep -q halves_normal_1.png out/halves.gltf; then pass "of two halves one is turned, for its material alone"; else fail "of two halves one is turned, for its material alone" "$(grep uri out/halves.gltf; cat said)"; fi
for case in "one_material.gltf|would report" "other_format.glb|in another format" "dangling.glb|names image 3"; do
    file=${case%%|*}
    fix "$file" -o "out/$file"
    if cmp -s "$file" "out/$file" && grep -q "N812 map-green-flipped is not fixed.*${case#*|}" said; then pass "$file is left, with its reason"; else fail "$file is left, with its reason" "$(cat said)"; fi
done
fix cut.gltf -o out/cut.gltf
if grep -q '"cut.png"' out/cut.gltf && [ "$(find out -name 'cut_normal*' | wc -l)" = 0 ]; then pass "a picture that is cut off is left"; else fail "a picture that is cut off is left" "$(cat said)"; fi
finish
