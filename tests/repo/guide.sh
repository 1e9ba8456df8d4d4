#!/bin/bash
# What docs/guide.md shows is true: the lines below each of its commands (and those of docs/coming-from.md) are lines of the command's output, in that order; its angles and its table of errors are computed
# again from the numbers beside them; its listings of examples are what the examples print; each line of its GLSL is a line of a shader that norma render uses or of examples/glsl, which compile.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
norma=${NORMA_BIN:-$tree/bin/norma}
norma() { "$norma" "$@"; }

commands=0
shown() { # COMMAND, and in $scratch/shown what the guide shows of its output
    commands=$((commands + 1))
    eval "$1" >"$scratch/output" 2>&1
    if awk 'NR == FNR { want[++n] = $0; next } at < n && $0 == want[at + 1] { at++ } END { exit n == 0 || at < n }' "$scratch/shown" "$scratch/output"; then
        pass "guide: $1"
    else
        fail "guide: $1" "$(diff "$scratch/shown" "$scratch/output")"
    fi
}
command=""
while IFS= read -r line; do
    case $line in
    '    $ '*) [ -z "$command" ] || shown "$command"; command=${line#'    $ '}; : >"$scratch/shown" ;;
    '    '*) [ -z "$command" ] || printf '%s\n' "${line#    }" >>"$scratch/shown" ;;
    *) [ -z "$command" ] || shown "$command"; command="" ;;
    esac
done < <(cat docs/guide.md docs/coming-from.md)
if [ "$commands" -ge 10 ]; then pass "guide: $commands commands found"; else fail "guide: commands found" "only $commands"; fi

# angle WORDS "X Y Z" "X Y Z": the guide has the words with the angle between the two directions, in degrees, in place of @.
angle() {
    local words
    words=$(awk -v words="$1" -v a="$2" -v b="$3" 'BEGIN {
        split(a, p, " "); split(b, q, " ")
        x = p[2] * q[3] - p[3] * q[2]; y = p[3] * q[1] - p[1] * q[3]; z = p[1] * q[2] - p[2] * q[1]
        sub(/@/, sprintf("%.1f", atan2(sqrt(x * x + y * y + z * z), p[1] * q[1] + p[2] * q[2] + p[3] * q[3]) * 45 / atan2(1, 1)), words)
        print words }')
    check "guide: $words" grep -qF "$words" docs/guide.md
}
angle "the shortcut gives (1.732, 0.5, 0), @° off" "1.732 0.5 0" "0.866 1 0"
angle "comes out along (1, 0, 30), @° off" "1 0 30" "1 0 0"
angle "transpose makes it (1, 2, 0), which is @° off" "1 2 0" "2 1 0"

wrong=$(awk -F'|' '
    /^\| a \|/ { for (i = 3; i < NF; i++) a[i] = $i; rows = 1 }
    /^\| degrees \|/ { rows = 2; for (i = 3; i < NF; i++) {
        x = (a[i] * a[i] - 1) / (a[i] * a[i] + 1); degrees = sprintf("%.3f", atan2(x, sqrt(1 - x * x)) * 45 / atan2(1, 1))
        if (degrees != sprintf("%.3f", $i + 0)) print "at anisotropy" a[i] "it is " degrees ", not" $i } }
    END { if (rows != 2) print "no table found" }' docs/guide.md)
if [ -z "$wrong" ]; then pass "guide: the table of the largest errors"; else fail "guide: the table of the largest errors" "$wrong"; fi

examples=$(sed -n 's/^<!-- examples\/\(.*\)\.c -->$/\1/p' docs/guide.md)
for name in $examples; do
    awk -v name="$name" '$0 == "<!-- examples/" name ".c -->" { near = 1; next } near && /^```text/ { inside = 1; next } /^```/ { inside = near = 0 } inside' docs/guide.md >"$scratch/listing"
    "$tree/examples/$name" >"$scratch/output"
    if difference=$(diff "$scratch/listing" "$scratch/output"); then pass "guide: what examples/$name.c prints"; else fail "guide: what examples/$name.c prints" "$difference"; fi
done
[ -n "$examples" ] || fail "guide: listings of examples found" "none"

awk '/^```glsl/ { inside = 1; next } /^```/ { inside = 0 } inside && NF { sub(/^ +/, ""); print }' docs/guide.md >"$scratch/glsl"
unknown=$(sed 's/^ *//' src/render/shaders/* examples/glsl/* | grep -vxFf - "$scratch/glsl")
if [ -s "$scratch/glsl" ] && [ -z "$unknown" ]; then pass "guide: its $(wc -l <"$scratch/glsl") lines of GLSL are those of src/render/shaders and examples/glsl"; else fail "guide: its GLSL is that of src/render/shaders" "$unknown"; fi
for shader in examples/glsl/*.vert examples/glsl/*.frag; do
    awk -v name="$shader" '$0 == "<!-- " name " -->" { near = 1; next } near && /^```glsl/ { inside = 1; next } /^```/ { inside = near = 0 } inside' docs/guide.md >"$scratch/pasted"
    check "guide: $shader is shown whole" cmp "$scratch/pasted" "$shader"
done
if command -v glslangValidator >/dev/null; then
    { printf '#version 300 es\nprecision highp float;\n'; cat examples/glsl/normal_matrix.glsl; printf 'out vec4 c;\nvoid main() { c = vec4(normal_matrix_of(mat3(1.0)) * normal_without_matrix(mat3(1.0), vec3(1.0)), 1.0); }\n'; } >"$scratch/normal_matrix.frag"
    for shader in examples/glsl/*.vert examples/glsl/*.frag "$scratch/normal_matrix.frag"; do check "guide: $(basename "$shader") compiles" glslangValidator "$shader"; done
    check "guide: lit.vert and lit.frag link" glslangValidator -l examples/glsl/lit.vert examples/glsl/lit.frag
else
    skip "guide: its GLSL compiles: glslangValidator is not installed"
fi
finish
