#!/bin/bash
# norma render itself, in software, straight from the front and without perspective.   norma.sh SCENE.glb SHOT.png
set -eu
norma=${NORMA_BIN:-$(dirname "$0")/../../../build/bin/norma}
"$norma" render "$1" -o "$2" --size 1600x1200 --camera 0,0 --fov 0 --renderer software --quiet
"$norma" --version | head -n 1
