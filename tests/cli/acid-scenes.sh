#!/bin/bash
# norma acid -o: the scenes are written the same each time, the validator finds no error, and a reader of glTF that shares nothing with norma finds each subject where its right
# reference is, and each other reference as its mistake makes it.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
cd "$root" || exit 1

if ! "$norma" acid -o "$scratch/a" --quiet 2>"$scratch/err"; then
    if grep -q 'normal maps cannot be written' "$scratch/err"; then skip "the tree was built without images"; else fail "the scenes are written" "$(cat "$scratch/err")"; fi
    finish
    exit
fi
"$norma" acid -o "$scratch/b" --quiet
check "the same to the byte each time" diff -r "$scratch/a" "$scratch/b"
"$norma" acid -o "$scratch/b" --quiet
check "and over what was there" diff -r "$scratch/a" "$scratch/b"
check "a file for each of 24 cells" test "$(find "$scratch/a/cells" -name '*.glb' | wc -l)" = 24

# ---- what is refused
status() { # NAME EXPECTED WORDS COMMAND...
    local name=$1 expected=$2 words=$3 got=0
    shift 3
    "$@" >"$scratch/out" 2>"$scratch/err" || got=$?
    if [ "$got" = "$expected" ] && grep -qF "$words" "$scratch/err"; then pass "$name"; else fail "$name" "status $got, expected $expected: $(cat "$scratch/err")"; fi
}
touch "$scratch/file"
status "a file is no folder" 3 "$scratch/file: the folder cannot be made" "$norma" acid -o "$scratch/file"
status "nor is a folder made in one" 3 "the folder cannot be made" "$norma" acid -o "$scratch/file/below"
status "nothing to do" 2 "expected -o DIR or --judge SHOT.png" "$norma" acid
mkdir -p "$scratch/taken/norma-acid.glb"
status "a folder in the place of a file" 3 "norma-acid.glb" "$norma" acid -o "$scratch/taken"

# ---- files
python3 tests/support/acid_reader.py "$scratch/a" >"$scratch/read" 2>&1
while read -r line; do
    case $line in
    "ok "*) pass "${line#ok * - }" ;;
    "not ok "*)
        read -r why
        fail "${line#not ok * - }" "$why"
        ;;
    esac
done <"$scratch/read"
check "the reader came to its end" grep -qx "1\.\.$(grep -cE '^(not )?ok ' "$scratch/read")" "$scratch/read"
check "the page explains each cell and mistake" python3 -c '
import json, sys
page, layout = open(sys.argv[1] + "/index.html").read(), json.load(open(sys.argv[1] + "/acid.json"))
for cell in layout["cells"]:
    text = page[page.index("<h2 id=\"%s\">" % cell["id"]):].split("<h2", 2)[1]
    assert "blockquote" in text and cell["file"] in text, cell["id"]
    for reference in cell["references"][1:]:
        assert "<dt>%s</dt><dd>" % reference["id"] in text, (cell["id"], reference["id"])
' "$scratch/a"
check "the page shows whole functions of norma.glsl" python3 -c '
import html, re, sys
shown = [html.unescape(text) for text in re.findall("<pre><code>(.*?)</code>", open(sys.argv[1]).read(), re.S)]
glsl = open("include/norma/shaders/norma.glsl").read()
assert len(shown) > 30, len(shown)
for text in shown:
    for function in text.split("\n\n"):
        assert "\n\n" + function + "\n" in glsl or "\n" + function + "\n" in glsl, function
        assert function.startswith("//") or re.match("[a-z0-9]+ norma_", function), function
        assert function.count("{") == function.count("}") > 0, function
' "$scratch/a/index.html"
if [ -d "${NODE_PATH:-$tree/../npm/node_modules}/gltf-validator" ]; then
    check "the validator finds no error" node --input-type=module -e '
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
const { validateBytes } = createRequire(process.argv[1] + "/x.js")("gltf-validator");
let bad = 0;
for (const file of process.argv.slice(2)) {
  const { issues } = await validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 0 });
  for (const { severity, code, pointer, message } of issues.messages)
    if (severity === 0 || (severity === 1 && !/^(MESH_PRIMITIVE_GENERATED_TANGENT_SPACE|NODE_SKINNED_MESH_LOCAL_TRANSFORMS)$/.test(code))) { console.log(file, code, pointer, message); bad = 1; }
}
process.exit(bad);' "${NODE_PATH:-$tree/../npm/node_modules}" "$scratch/a/norma-acid.glb" "$scratch"/a/cells/*.glb
else
    skip "the validator (npm) is not there"
fi
finish
