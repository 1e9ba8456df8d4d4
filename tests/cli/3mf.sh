#!/bin/bash
# 3MF with the 3MF Consortium's samples: what must be read is read, what breaks the core specification is refused, and fixes give back what was there before triangles were
# turned. Judges: the text before the damage, byte for byte; unzip; lib3mf (is each mesh manifold and oriented?); Python's zipfile, for the other members' packed bytes; expat, for what is XML.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
samples=${NORMA_DATA:-$root/../shared/data}/fresh/3mf
[ -x "$norma" ] || { fail "the tool is there" "no program at $norma"; finish; exit 1; }
[ -d "$samples" ] || { skip "no samples of 3MF in $samples"; finish; exit; }
suite=$samples/validation-tests/_archive/3mf-Verify

for file in "$suite"/MUSTPASS/*.3mf "$samples"/examples/*/*.3mf; do
    said=$("$norma" check "$file" 2>&1)
    [ $? -lt 2 ] || { fail "${file##*/} is read" "$said"; continue; }
    read_files=$((${read_files:-0} + 1))
done
check "at least 33 samples are read" test "${read_files:-0}" -ge 33

# The 38 that must fail. Refused is what breaks a rule of the core specification about the package, or about resources, objects and the build: yes. The others (no) break rules of
# the materials extension, which Norma keeps as bytes, or nothing that is asked of a reader.
# chapter, refused, why
suite_of_failures() {
    sed 's/^ *//' <<'END'
    Chapter2.1.1a yes the relationship to the model leads nowhere
    Chapter2.1.1b yes a relationship to a texture outside the package
    Chapter2.1.2 yes two models
    Chapter2.1.3 yes a thumbnail that is missing
    Chapter2.1.4 yes two print tickets
    Chapter2.3.2a yes not UTF-8
    Chapter2.3.2b yes a document type: entities
    Chapter2.3.2c no an attribute of another namespace on <vertices>, which the schema allows since core 1.2
    Chapter2.3.2d yes xsi:type
    Chapter2.3.4 yes xml:space
    Chapter3.4.1a no metadata of an unknown name, which readers ignore (as MUSTPASS 3.4.1c has it)
    Chapter3.4.1b no metadata of one name twice: producers must not write it; it is kept as bytes
    Chapter3.4.3.1a yes a build item of an object that does not exist
    Chapter3.4.3.1b yes a build item of an object of the type other
    Chapter3.4a yes two roots
    Chapter3.4b yes no build
    Chapter3.4c yes no resources
    Chapter4a yes an object of an unknown type
    Chapter4b yes an object with pindex and without pid
    Chapter5a yes two resources of one id
    3MF100_Extension_Chapter2_D yes two resources of one id
    3MF100_Extension_Chapter2_M no a colour without a value
    3MF100_Extension_Chapter3_D yes two resources of one id
    3MF100_Extension_Chapter3_M no a group of texture coordinates without a texture
    3MF100_Extension_Chapter4a yes two resources of one id
    3MF100_Extension_Chapter4b no composite materials of colours
    3MF100_Extension_Chapter4c no composite materials of nothing
    3MF100_Extension_Chapter4d no composite materials without indices
    3MF100_Extension_Chapter5 no several properties at once
    3MF100_Extension_Chapter6 no pictures
END
}
while read -r chapter refused why; do
    for file in "$suite"/MUSTFAIL/MUSTFAIL_"$chapter"[a-z_]*.3mf; do
        said=$("$norma" check "$file" 2>&1)
        status=$? judged=$((${judged:-0} + 1))
        if [ "$refused" = yes ]; then
            if [ $status -eq 3 ] && grep -q N001 <<<"$said"; then pass "${file##*/} is refused: $why"; else fail "${file##*/} is refused: $why" "$said"; fi
        else
            if [ $status -lt 2 ]; then pass "${file##*/} is read: $why"; else fail "${file##*/} is read: $why" "$said"; fi
        fi
    done
done < <(suite_of_failures)
check "all 38 files that must fail are in the table" test "${judged:-0}" -eq 38

if command -v python3 >/dev/null && command -v unzip >/dev/null; then
    relay "turned triangles" python3 "$root/tests/cli/judge_3mf.py" "$norma" "$scratch" "$suite"/MUSTPASS/*.3mf "$samples"/examples/*/*.3mf
    relay "XML that is broken a little" python3 "$root/tests/cli/judge_xml.py" "$norma" "$scratch"
else
    skip "no python3 or no unzip"
fi
finish
