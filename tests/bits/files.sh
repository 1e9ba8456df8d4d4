#!/bin/bash
# files.sh FOLDER...: the meshes below these folders, one a line, in an order that hangs on no locale: what norma_bits --files reads.
# Not those that Draco packed: not every machine has its library.
[ "$1" != -- ] || shift
find "$@" -type f \( -name '*.obj' -o -name '*.ply' -o -name '*.stl' -o -name '*.gltf' -o -name '*.glb' \) ! -name '*-draco.glb' | LC_ALL=C sort
