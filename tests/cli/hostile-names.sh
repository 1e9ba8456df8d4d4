#!/bin/bash
# Names are text of strangers: what a terminal obeys (ESC, BEL, C1), what turns the direction of text, what breaks a line and what is no UTF-8 never reaches standard output, standard
# error or a report as it is, whether it stands in a glTF, in .norma.json, in a file's name or on the command line.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
NORMA=${NORMA_BIN:-$tree/bin/norma}
cd "$scratch" || exit 1

# ESC ] 0 ; (window title) BEL, CSI as C1 in UTF-8, right-to-left override, isolate, line separator.
hostile=$'\e]0;owned\a\e[2J\u009b31m\u202egnp\u2066\u2028'
escaped='\u001b]0;owned\u0007\u001b[2J\u009b31m\u202egnp\u2066\u2028\nchair.glb: No problems found'
odd="odd $hostile"$'\xff\xc3('
gltf() {
    printf '{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"name":"%s","mesh":0,"scale":[2,-1,1]}],"materials":[{"name":"%s","doubleSided":true}],"meshes":[{"name":"%s","primitives":[{"material":0,"attributes":{"POSITION":0,"NORMAL":1}}]}],' "$1" "$1" "$1"
    printf '"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":36}],'
    printf '"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}'
}
gltf "$escaped" >named.gltf
cp named.gltf "$odd.gltf"
printf '{"asset":{"version":"2.0"},"extensionsRequired":["%s"],"meshes":7}' "$escaped" >broken.gltf
printf 'ply\n%s\n' "$hostile" >broken.ply
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\n%s 1 2 3\nf 1 2 %s\n' "$hostile" "$hostile" >broken.obj
mkdir keys values empty
cp named.gltf keys && printf '{"%s": 1}' "$escaped" >keys/.norma.json
cp named.gltf values && printf '{%s' "$hostile" >values/.norma.json
printf '%s\n' "missing $hostile.obj" "$hostile/*.ply" "$odd.gltf" >list.txt
# What else holds names: groups and materials, comments and properties, the name of a solid. All with marks of HTML.
marked="$hostile<img src=x onerror=alert(1)>\"'&</script><!--"
word=${marked// /_}
gltf "$(printf '%s' "$escaped" | sed 's/\\n.*//')<img src=x>\\\"'&</script><!--" >marked.gltf
printf 'mtllib %s\no %s\ng %s\nusemtl %s\ns %s\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 0\nvn 0 0 2\nf 1//1 2//2 3//1\nf 1 2 4\nf 1 1 2\n' "$marked" "$marked" "$marked" "$marked" "$marked" >marked.obj
printf 'ply\nformat ascii 1.0\ncomment %s\ncomment TextureFile %s\nobj_info %s\nelement %s 1\nproperty float %s\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' "$marked" "$marked" "$marked" "$word" "$word" >marked.ply
printf 'solid %s\nfacet normal 0 0 2\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid %s\n' "$marked" "$marked" >marked.stl
in_sed=$(printf '%s' "$word" | sed 's/[\/&]/\\&/g')
sed "s/facet normal 0/facet normal $in_sed/" marked.stl >broken.stl
sed "s/^element face 1/element face $in_sed/" marked.ply >broken-count.ply
sed "s/^1\$/$in_sed/" marked.ply >broken-row.ply

# Bytes that may not be there: controls but for the line end, C1, marks of direction, separators; and all must be UTF-8.
is_plain() { ! LC_ALL=C grep -aqP '[\x00-\x09\x0b-\x1f\x7f]|\xc2[\x80-\x9f]|\xe2\x80[\x8e\x8f\xa8-\xae]|\xe2\x81[\xa6-\xa9]|\xd8\x9c' "$1" && iconv -f UTF-8 -t UTF-8 "$1" >/dev/null 2>&1; }

# plain LINES COMMAND...: what it says is plain, and has at most so many lines that begin with "chair.glb".
plain() {
    "$NORMA" "$@" >said 2>&1 </dev/null
    if ! is_plain said; then
        fail "plain: $(printf '%q ' "$@")" "$(cat -A said)"
    elif grep -q '^chair.glb' said; then
        fail "no name begins a line: $(printf '%q ' "$@")" "$(cat -A said)"
    elif [ ! -s said ]; then
        fail "says something: $(printf '%q ' "$@")"
    else
        pass "plain: $(printf '%q ' "$@")"
    fi
}

# report FILE COMMAND...: the same of a file that it writes.
report() {
    local file=$1
    shift
    "$NORMA" "$@" -o "$file" >/dev/null 2>&1 </dev/null
    if [ -s "$file" ] && is_plain "$file"; then pass "plain report: $(printf '%q ' "$@")"; else fail "plain report: $(printf '%q ' "$@")" "$(grep -aP '\x1b|\xc2[\x80-\x9f]|\xe2\x80\xae' "$file" | cat -A | cut -c1-400 | head -5)"; fi
}

for file in named.gltf "$odd.gltf" broken.gltf broken.ply broken.obj marked.gltf marked.obj marked.ply marked.stl broken.stl broken-count.ply broken-row.ply "no $odd.obj" keys/named.gltf values/named.gltf; do
    plain info "$file"
    plain info --json "$file"
    plain check --no-config "$file" --fail-on info
    plain check "$file"
    plain check "$file" --json
    plain check "$file" --fix-unsafe -o fixed.gltf
    plain compute "$file" -o out.gltf
    plain compute "$file" -o out.gltf --json
    plain transform "$file" -o out.gltf --scale 2,1,1
    plain transform "$file" --bake -o out.gltf
    plain view "$file" -o page.html
    plain render "$file" -o picture.png --size 32x32
done
for form in html sarif json text; do
    report "report.$form" check named.gltf "$odd.gltf" broken.obj broken.stl broken-count.ply marked.* --format $form --fail-on never
done
if grep -aoE '.{30}(<img src=x|</script><!--)' report.html >said; then fail "names are text in HTML" "$(cat said)"; else pass "names are text in HTML"; fi

# parses COMMAND...: standard output is JSON, one value for all of it or one a line, also where the command fails.
parses() {
    "$NORMA" "$@" >said 2>/dev/null </dev/null
    if node -e 'const text = require("fs").readFileSync("said", "utf8"); try { JSON.parse(text) } catch { text.trimEnd().split("\n").map(line => JSON.parse(line)) }' 2>error; then
        pass "parses: $(printf '%q ' "$@")"
    else
        fail "parses: $(printf '%q ' "$@")" "$(head -5 error; cut -c1-300 said)"
    fi
}
if command -v node >/dev/null; then
    for form in json sarif; do
        parses check . --no-config --format $form --fail-on never
        check "nothing is printed where a configuration ends the command, $form" bash -c '"$0" check named.gltf keys/named.gltf --format $1 2>/dev/null >said; [ $? = 2 ] && [ ! -s said ]' "$NORMA" $form
    done
    parses info --json named.gltf "$odd.gltf" broken.obj marked.*
    parses info --json --deep marked.*
    parses compute --json named.gltf "$odd.gltf" broken.obj marked.* --out-dir out
else
    skip "JSON that programs read: node is not here"
fi
for old in "{\"$escaped\": 1}" "{\"schema\": \"$escaped\"}" "{\"schema\": \"norma-baseline/1\", \"findings\": [{\"path\": \"$escaped\", \"$escaped\": 1}]}" "{\"$hostile"; do
    printf '%s' "$old" >old.json
    plain check --no-config named.gltf --fail-on info --baseline old.json
done
"$NORMA" check named.gltf --format text -o said.txt --fail-on never >/dev/null 2>&1
check "a name is shown, escaped" grep -qF '\x1B]0;owned\x07\x1B[2J\x9B31m\u202Egnp' said.txt
plain check --files-from list.txt
plain check "$hostile/*.obj"
plain check --config "no $odd.json" named.gltf
plain check --baseline "no $odd.json" named.gltf
plain check named.gltf --select "$odd"
plain compute named.gltf --out-dir "named.gltf/$odd"
plain compute named.gltf -o "no $odd/out.gltf"
plain compute named.gltf "--$odd"
plain compute named.gltf --weight "$odd"
plain explain "$odd"
plain "$odd"
plain help "$odd"
plain matrix --scale "$odd"
mkfifo pipe.json
check "a pipe in place of a configuration is refused at once" timeout 5 bash -c '"$0" check named.gltf --config pipe.json 2>&1 | grep -q "is not a regular file"' "$NORMA"
# The page holds the files that a glTF names; a pipe among them would be waited for without end.
if "$NORMA" view named.gltf -o page.html --quiet 2>/dev/null; then
    mkdir piped && mkfifo piped/image.png
    sed 's|"asset"|"images": [{"uri": "image.png"}], "textures": [{"source": 0}], "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], "asset"|' named.gltf >piped/model.gltf
    # A glTF is looked into before an output is written over: not where it is a pipe, whose writer would be taken for good (one time in ten).
    through_pipe() {
        mkfifo model.pipe
        for _ in $(seq 60); do
            cat "$root/tests/cli/golden/files/roof.glb" >model.pipe &
            timeout 10 "$NORMA" view model.pipe --input-format glb -o page.html --quiet || return 1
        done
    }
    check "a glTF through a pipe over a page that is there is read each time" through_pipe
    check "norma view leaves out an image that is a pipe" timeout 20 "$NORMA" view piped/model.gltf -o piped.html --quiet
fi
mkdir linked && cp named.gltf linked && printf 'secret words' >elsewhere && ln -s ../elsewhere linked/.norma.json
check "a configuration that is a link is refused, and nothing of it is quoted" bash -c '"$0" check linked/named.gltf >said 2>&1; [ $? = 2 ] && grep -q "is a symbolic link" said && ! grep -q secret said' "$NORMA"
# A configuration of another user: ignored, said once, and what lies above it counts; --trust-config, --config and sudo's own caller have it obeyed; root's is everybody's.
if [ "$(id -u)" -eq 0 ]; then
    mkdir -p own/strange/a own/strange/b
    cp named.gltf own/strange/a && cp named.gltf own/strange/b
    echo '{"severity": {"N6": "error"}}' >own/.norma.json
    echo '{"ignore": ["N"]}' >own/strange/.norma.json && chown 1001 own/strange/.norma.json
    asked() { env -u SUDO_UID "$@" check own/strange --quiet; }
    obeyed() { "$@" >said 2>errors; [ $? -eq 0 ] && ! grep -q 'another user' errors; }
    ignored() { asked "$@" >said 2>errors; [ $? -eq 1 ] && [ "$(grep -c 'own/strange/.norma.json: ignored because it or its folder belongs to another user' errors)" -eq 1 ]; }
    check "another user's configuration is ignored, one above it is not" ignored "$NORMA"
    check "with --trust-config it is obeyed" obeyed "$NORMA" check own/strange --quiet --trust-config
    check "with --config it is obeyed" obeyed "$NORMA" check own/strange --quiet --config own/strange/.norma.json
    check "that of the caller of sudo is obeyed" obeyed env SUDO_UID=1001 "$NORMA" check own/strange --quiet
    check "that of another than the caller of sudo is not" ignored env SUDO_UID=1002 "$NORMA"
    chown 0 own/strange/.norma.json && chmod -R a+rX . && cp "$NORMA" tool
    check "root's is obeyed by all" obeyed env python3 -c 'import os, sys; os.setuid(1001); os.execv("./tool", ["tool", "check", "own/strange", "--quiet"])'
    chown 1001 own/strange
    check "nor is one in a folder of another user" ignored "$NORMA"
else
    skip "configurations of other users: only root can make one"
fi
check "a line that does not exist is not told" bash -c '! "$0" check named.gltf --config no.json 2>&1 | grep -q -- ":-1"' "$NORMA"
if "$NORMA" view named.gltf -o page.html >/dev/null 2>&1; then
    cp named.gltf "$odd.gltf"
    "$NORMA" view "$odd.gltf" -o page.html >/dev/null 2>&1
    check "the page shows the file's name escaped" grep -qaF 'odd \x1B]0;owned' page.html
else
    skip "names in pages of norma view: this tool has no page (make web)"
fi
finish
