#!/bin/bash
# Blender's importer and EEVEE, by OpenGL in software.   blender-eevee.sh SCENE.glb SHOT.png
set -eu
blender --background --factory-startup --python-exit-code 1 --python "$(dirname "$0")/blender.py" -- "$1" "$2" BLENDER_EEVEE >&2
echo "$(blender --version | head -n 1), EEVEE"
