#!/bin/sh
# What `make demo` shows once everything is built: a real mesh gets its normals, a matrix is explained, a picture is drawn.
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
echo "A mesh of 5,522 triangles without normals (assets/goathead.obj) gets them, in a copy that is otherwise the same:"
show norma compute assets/goathead.obj -o "$demo/goathead.obj"
show norma info "$demo/goathead.obj"

echo
echo "What scaling by (2, 0.5, 1) does to normals, and the matrix that carries them rightly:"
show norma matrix --scale 2,0.5,1

"$build/examples/figure_svg" >"$demo/normal-matrix.svg"

echo
echo "Look at:"
echo "  $root/$demo/normal-matrix.svg    the picture of it: wrong and right normals side by side (open it in a browser)"
echo "  $root/$demo/goathead.obj         the mesh with its normals"
echo "  $root/$build/bin/norma                 the tool; norma --help, norma compute --help"
