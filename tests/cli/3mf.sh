#!/bin/bash
# 3MF with the 3MF Consortium's samples: what must be read is read, what breaks the core specification is refused, and fixes give back what was there before triangles were
# turned. Judges: the text before the damage, byte for byte; unzip; lib3mf (is each mesh manifold and oriented?); Python's zipfile, for the other members' packed bytes.
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

# Of those that must fail, these are about the package, the XML and the meshes; the others are about materials and metadata, which no rule looks at.
refused="2.1.1a 2.1.2 2.3.2a 2.3.2b 3.4.3.1a 3.4.3.1b 3.4a 3.4b 3.4c 4a_InvalidObjectType"
for chapter in $refused; do
    for file in "$suite"/MUSTFAIL/MUSTFAIL_Chapter"$chapter"*.3mf; do
        said=$("$norma" check "$file" 2>&1)
        if [ $? -eq 3 ] && grep -q N001 <<<"$said"; then pass "${file##*/} is refused"; else fail "${file##*/} is refused" "$said"; fi
    done
done

if command -v python3 >/dev/null && command -v unzip >/dev/null; then
    relay "turned triangles" python3 "$root/tests/cli/judge_3mf.py" "$norma" "$scratch" "$suite"/MUSTPASS/*.3mf "$samples"/examples/*/*.3mf
else
    skip "no python3 or no unzip"
fi
finish
