#!/bin/bash
# files.sh FOLDER...: the meshes below these folders, one a line, in an order that hangs on no locale: what norma_bits --files reads.
# Not those that Draco packed, whatever they are called: not every machine has its library, and the message of a mesh that is not read says so.
[ "$1" != -- ] || shift
{
    find "$@" -type f \( -name '*.obj' -o -name '*.ply' -o -name '*.stl' \)
    find "$@" -type f \( -name '*.gltf' -o -name '*.glb' \) -exec grep -LF KHR_draco_mesh_compression -- {} +
} | LC_ALL=C sort
