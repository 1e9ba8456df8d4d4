#!/bin/bash
# Every glTF of the data set through norma compute. Two judges that are not ours: the Khronos validator may say nothing about an output that it did not say about its
# input, and tests/cli/validator/corners.mjs, which reads both with code of its own, must find all but normals and tangents as they were.
# shellcheck source=tests/support/gltf_judges.sh
source "$(dirname "$0")/../support/gltf_judges.sh"
needs_data

is_judged() { true; }
# What Draco packed is written without it, so its JSON changes; tests/cli/draco.sh judges such files.
is_sound() { [[ $1 != bad/* && $1 != *draco* ]]; }
may_refuse() { [ "$2" != ok ] && [ "$2" != lint ]; }

run_all crease compute
judge crease "all but the normals" corners.mjs
run_all smooth compute --smooth --morphs
judge smooth "all but the normals" corners.mjs
run_all flat compute --flat
judge flat "all but the normals" corners.mjs --flat
finish
