#!/bin/sh
# What `make demo` shows after building: it computes the normals of a mesh, explains a matrix and draws a picture.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
cd "$root"
build=${BUILD:-build}
demo=$build/demo
mkdir -p "$demo"
PATH=$(cd "$build/bin" && pwd):$PATH
export PATH

show() {
    printf '\n$ %s\n' "$*"
    "$@"
}

echo
echo "assets/goathead.obj has 5,522 triangles and no normals. Norma computes them into a copy and changes nothing else:"
show norma compute assets/goathead.obj -o "$demo/goathead.obj"
show norma info "$demo/goathead.obj"

echo
echo "Scaling by (2, 0.5, 1) turns normals the wrong way unless they go through the normal matrix:"
show norma matrix --scale 2,0.5,1

"$build/examples/figure_svg" >"$demo/normal-matrix.svg"
picture=""
if norma render --help 2>/dev/null | grep -q -- --compare; then
    echo
    echo "The same, drawn: plain M on one side, the normal matrix on the other:"
    if show norma render "$demo/goathead.obj" -o "$demo/compare.png" --compare --scale 2,0.5,1; then picture=$demo/compare.png; fi
fi
page=""
if [ -f "$build/web/norma.html" ]; then
    echo
    echo "The same mesh as a page of its own:"
    if show norma view "$demo/goathead.obj" -o "$demo/goathead.html"; then page=$demo/goathead.html; fi
fi

# line FILE WORDS
line() { [ -z "$1" ] || [ ! -e "$1" ] || printf '  %-40s %s\n' "$1" "$2"; }
echo
echo "Look at:"
line "$picture" "the picture: wrong and right normals side by side"
line "$page" "the mesh in a page: turn it, change the scale"
line "$build/web/norma.html" "the playground: creases, weights, a moving surface; drop a file on it"
line "$demo/normal-matrix.svg" "why M is wrong for normals (open it in a browser)"
line "$demo/goathead.obj" "the mesh with its normals"
line "$build/bin/norma" "the tool: norma --help, norma compute --help"
