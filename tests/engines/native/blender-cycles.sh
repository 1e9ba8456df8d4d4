#!/bin/bash
# Blender's importer and Cycles, on the processor.   blender-cycles.sh SCENE.glb SHOT.png
set -eu
blender --background --factory-startup --python-exit-code 1 --python "$(dirname "$0")/blender.py" -- "$1" "$2" CYCLES >&2
echo "$(blender --version | head -n 1), Cycles"
