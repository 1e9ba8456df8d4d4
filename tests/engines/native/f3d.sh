#!/bin/bash
# F3D with the glTF reader and renderer of VTK, and the scene's own camera.   f3d.sh SCENE.glb SHOT.png
# KHR_mesh_quantization ends it by a segmentation fault (it leaves positions of bytes unread), so that node is taken out.
set -eu
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
python3 "$(dirname "$0")/../hide.py" "$1" "$scratch/scene.glb" "quantized subject"
xvfb-run -a f3d --dry-run --camera-index 0 --resolution 1600,1200 --output "$2" "$scratch/scene.glb"
f3d --version | awk '/^Version/ { sub(/\.$/, "", $2); f3d = $2 } /^VTK version/ { vtk = $3 } END { print "F3D " f3d " with VTK " vtk }'
