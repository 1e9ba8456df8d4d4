#!/bin/bash
# include/norma/shaders: each file compiles for what it is for, and runs on a million inputs: every result is the core's (tests/shaders/shader_judge.c). The examples that docs/shaders.md shows
# are those of examples/shaders, and run. GLSL and HLSL run on Mesa (HLSL by way of SPIR-V), WGSL in Chromium.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
shaders=include/norma/shaders
count=${NORMA_SHADER_INPUTS:-1000000}

names_of() { grep -oE '^(fn |[a-z0-9]+ )norma_[a-z0-9_]+\(' "$1" | grep -oE 'norma_[a-z0-9_]+' | sort; }
for file in hlsl wgsl; do check "norma.$file has the functions of norma.glsl" diff <(names_of $shaders/norma.glsl) <(names_of $shaders/norma.$file); done
for example in webgl2.html webgpu.html surface.hlsl; do
    awk -v name="examples/shaders/$example" '$0 == "<!-- " name " -->" { near = 1; next } near && /^```[a-z]/ { inside = 1; next } /^```/ { inside = near = 0 } inside' docs/shaders.md >"$scratch/pasted"
    check "docs/shaders.md shows examples/shaders/$example whole" cmp "$scratch/pasted" "examples/shaders/$example"
done

# shader VERSION FILE: norma.glsl after #version, and FILE after it.
shader() { printf '#version %s\n' "$1"; cat $shaders/norma.glsl "$2"; }
if ! command -v glslangValidator >/dev/null; then
    skip "the shaders compile (glslangValidator is not installed)"
else
    shader "300 es" tests/shaders/main.vert >"$scratch/es.vert"
    shader 330 tests/shaders/main.vert >"$scratch/desktop.vert"
    check "norma.glsl compiles as GLSL ES 3.00" glslangValidator "$scratch/es.vert"
    check "norma.glsl compiles as GLSL 3.30" glslangValidator "$scratch/desktop.vert"
    shader 450 tests/shaders/main.vert | awk '/^out vec4 o0/ { for (i = 0; i < 14; i++) print "layout(location = " i ") out vec4 o" i ";"; next } { print }' >"$scratch/vulkan.vert"
    check "norma.glsl compiles for Vulkan" glslangValidator -V "$scratch/vulkan.vert" -o "$scratch/vulkan.spv"
    check "norma.hlsl compiles" glslangValidator -D -V -S vert -e main -I$shaders tests/shaders/main.hlsl -o "$scratch/hlsl.spv"
    for stage in "vert vertex_main" "frag pixel_main"; do
        # shellcheck disable=SC2086  # two words
        set -- $stage
        check "examples/shaders/surface.hlsl: $2 compiles" glslangValidator -D -V -S "$1" -e "$2" -I$shaders examples/shaders/surface.hlsl -o "$scratch/example.spv"
    done
fi

"${CC:-cc}" -std=c11 -O2 -Iinclude tests/shaders/shader_judge.c "$tree/lib/libnorma-core.a" -lm -o "$scratch/judge" && "$scratch/judge" make "$count" "$scratch/in" || fail "the judge builds"
# judged NAME STATUS: what ran, where it could.
judged() {
    case $2 in
    0) relay "$1" "$scratch/judge" judge "$scratch/in" "$scratch/out" "$count inputs" ;;
    77) skip "$1 runs ($(tail -1 "$scratch/said"))" ;;
    *) fail "$1 runs" "$(cat "$scratch/said")" ;;
    esac
    rm -f "$scratch/out"
}
if ! "${CC:-cc}" -std=c11 -O2 tests/shaders/run_glsl.c -lEGL -lGLESv2 -o "$scratch/run_glsl" 2>/dev/null; then
    skip "GLSL and HLSL run (EGL and OpenGL ES are not installed)"
else
    "$scratch/run_glsl" "$scratch/es.vert" "$scratch/in" "$scratch/out" 2>"$scratch/said"
    judged GLSL $?
    if command -v spirv-cross >/dev/null; then
        renames=$(for i in $(seq 0 13); do printf -- '--rename-interface-variable out %s o%s ' "$i" "$i"; done)
        # shellcheck disable=SC2086  # many words
        spirv-cross --es --version 310 $renames "$scratch/hlsl.spv" --output "$scratch/hlsl.vert" &&
            "$scratch/run_glsl" "$scratch/hlsl.vert" "$scratch/in" "$scratch/out" 2>"$scratch/said"
        judged HLSL $?
    else
        skip "HLSL runs (spirv-cross is not installed)"
    fi
fi
if ! command -v node >/dev/null; then
    skip "WGSL runs (node is not installed)"
else
    cat $shaders/norma.wgsl tests/shaders/main.wgsl >"$scratch/main.wgsl"
    node tests/shaders/run_wgsl.mjs "$scratch/main.wgsl" "$scratch/in" "$scratch/out" 2>"$scratch/said"
    status=$?
    judged WGSL $status
    if [ $status = 77 ]; then skip "the examples run ($(tail -1 "$scratch/said"))"; else relay "examples" node tests/shaders/run_examples.mjs webgl2.html webgpu.html; fi
fi
finish
