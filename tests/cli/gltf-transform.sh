#!/bin/bash
# Every glTF of the data set through the tool under a matrix, as a node and baked. Two judges that are not ours: the Khronos validator may say nothing about an
# output that it did not say about its input, and what is drawn, as read by tests/cli/validator/world.mjs, must be the input's, moved by the matrix.
# shellcheck source=tests/support/gltf_judges.sh
source "$(dirname "$0")/../support/gltf_judges.sh"
needs_data

# Its buffer ends before views that nothing uses; in the output it does not, and the validator looks into what they now name.
is_judged() { [[ $1 != bad/gltf/IncorrectVertexArrays/* ]]; }
is_sound() { [[ $1 != bad/* && $1 != *draco* ]]; }
may_refuse() {
    case $2 in
    unsupported | ok-or-unsupported | ok-or-clear-error) true ;;
    *) [[ $1 == bad/* ]] ;;
    esac
}

mirrored="0.6 0 1.6 3  0 -0.5 0 -2  -0.8 0 1.2 11  0 0 0 1"
sheared="1 0.5 0 3  0 1 0.25 -2  0.125 0 -1.5 11  0 0 0 1"

run_all node transform --matrix "$mirrored"
judge node "what is drawn" world.mjs --matrix "$mirrored"
run_all baked transform --bake
judge baked "what is drawn" world.mjs --bake
run_all baked-sheared transform --bake --matrix "$sheared"
judge baked-sheared "what is drawn" world.mjs --bake --matrix "$sheared"
finish
