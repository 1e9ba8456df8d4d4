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

if [ -f "$build/web/norma.html" ]; then
    echo
    echo "The same mesh as a page of its own:"
    show norma view "$demo/goathead.obj" -o "$demo/goathead.html"
fi

echo
echo "Look at:"
[ ! -f "$build/web/norma.html" ] || echo "  $root/$build/web/norma.html        the playground: wrong against right, creases, weights, a surface that moves; drop a file on it"
[ ! -f "$demo/goathead.html" ] || echo "  $root/$demo/goathead.html        the mesh in a page"
echo "  $root/$demo/normal-matrix.svg    the picture of it: wrong and right normals side by side (open it in a browser)"
echo "  $root/$demo/goathead.obj         the mesh with its normals"
echo "  $root/$build/bin/norma                 the tool; norma --help, norma compute --help"
