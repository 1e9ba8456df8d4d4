#!/bin/bash
# examples/gate: each gate lets a good mesh through and stops a bad one. ComfyUI is a stand-in for its loader; Godot imports a project without a window; Debian's cargo builds a crate with Debian's serde_json.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
gate=$root/examples/gate
mkdir -p "$scratch/bin" "$scratch/models/sub"
ln -s "$(realpath "${NORMA_BIN:-$tree/bin/norma}")" "$scratch/bin/norma"
export PATH=$scratch/bin:$PATH
files=$root/tests/cli/golden/files
cp "$files/cube.obj" "$scratch/models/good.obj"
cp "$files/roof.gltf" "$files/roof.bin" "$scratch/models/sub/"
turned() { awk '/^f/ { line = $1; for (i = NF; i > 1; --i) line = line " " $i; print line; next } { print }' "$files/cube.obj"; }
turned >"$scratch/bad.obj"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n' >"$scratch/zero.obj" # N102, an error in each profile
cd "$scratch" || exit 1

# ---- ComfyUI: what its loader asks of a custom node, by hand.
if command -v python3 >/dev/null; then
    cat >"$scratch/loader.py" <<'PYTHON'
import importlib.util, sys
folder, good, bad = sys.argv[1:]
spec = importlib.util.spec_from_file_location("norma_gate", folder + "/__init__.py", submodule_search_locations=[folder])
module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
for name, node in module.NODE_CLASS_MAPPINGS.items():
    assert name in module.NODE_DISPLAY_NAME_MAPPINGS
    inputs = node.INPUT_TYPES()["required"]
    assert all(isinstance(kind[0], (str, list)) for kind in inputs.values())
    assert len(node.RETURN_TYPES) == len(node.RETURN_NAMES) and isinstance(node.CATEGORY, str)
    run = getattr(node(), node.FUNCTION)
    path, accepted, report = run(path=good, profile="render", fix="nothing", stop=True)
    assert (path, accepted, report) == (good, True, "No problems found"), (path, accepted, report)
    path, accepted, report = run(path=bad, profile="generated", fix="nothing", stop=False)
    assert path == bad and not accepted and "N302" in report and "Usual cause" in report, report
    try:
        run(path=bad, profile="generated", fix="nothing", stop=True)
        raise SystemExit("a bad mesh passed")
    except RuntimeError as error:
        assert "N302" in str(error)
    path, accepted, report = run(path=bad, profile="generated", fix="unsafe", stop=True)
    assert path != bad and accepted, report
    try:
        run(path=bad + ".none", profile="generated", fix="nothing", stop=True)
        raise SystemExit("a missing mesh passed")
    except RuntimeError:
        pass
    assert node.IS_CHANGED(path=bad) == node.IS_CHANGED(path=bad)
PYTHON
    check "ComfyUI (a stand-in for its loader): the node accepts, refuses, fixes" python3 "$scratch/loader.py" "$gate/comfyui" "$scratch/models/good.obj" "$scratch/bad.obj"
else
    skip "ComfyUI: python3 is not installed"
fi

# ---- dependency files
check "a glTF's dependency file names its buffer" bash -c '[ "$("$0" x.d models/sub/roof.gltf)" = "x.d: models/sub/roof.gltf models/sub/roof.bin" ]' "$gate/deps.sh"
# The first run checks all meshes; a second one none; a newer buffer its glTF alone; a bad mesh stops it.
one_gate() { # NAME RUN: RUN prints a line with "check" and the mesh's name for each mesh that is checked
    local name=$1 run=$2 log=$scratch/gate.log
    check "$name: the first run checks all meshes" bash -c '"$0" >"$1" 2>&1 && grep -q good.obj "$1" && grep -q roof.gltf "$1"' "$run" "$log"
    $run >"$log" 2>&1
    check "$name: the second run checks none" bash -c '! grep -qE "good.obj|roof.gltf" "$0"' "$log"
    sleep 1.1
    touch "$scratch/models/sub/roof.bin"
    $run >"$log" 2>&1
    check "$name: a newer buffer has its glTF checked, nothing else" bash -c 'grep -q roof.gltf "$0" && ! grep -q good.obj "$0"' "$log"
    cp "$scratch/zero.obj" "$scratch/models/good.obj"
    check "$name: a bad mesh fails the build, and again" bash -c '! $0 >/dev/null 2>&1 && ! $0 >/dev/null 2>&1' "$run"
    cp "$files/cube.obj" "$scratch/models/good.obj"
}
printf '#!/bin/sh\nmake -f "%s/make/Makefile" PROFILE=render\n' "$gate" >run-make
chmod +x run-make
one_gate make "$scratch/run-make"
printf 'cmake_minimum_required(VERSION 3.20)\nproject(models NONE)\ninclude("%s/cmake/NormaGate.cmake")\nset(NORMA_GATE_PROFILE render)\nnorma_gate(meshes models/good.obj models/sub/roof.gltf)\n' "$gate" >CMakeLists.txt
printf '#!/bin/sh\ncmake -S . -B tree -G Ninja -DNORMA="%s/bin/norma" >/dev/null && cmake --build tree\n' "$scratch" >run-cmake
chmod +x run-cmake
if command -v ninja >/dev/null; then one_gate CMake "$scratch/run-cmake"; else skip "CMake: ninja is not installed"; fi

# ---- pre-commit: the command of its hook, with file names behind it.
entry=$(sed -nE 's/^ *entry: (.*)/\1/p' "$gate/pre-commit-config.yaml")
check "pre-commit: its command accepts a good mesh" $entry "$scratch/models/good.obj"
check "pre-commit: its command refuses a bad one" bash -c '! $0 "$1" >/dev/null' "$entry" "$scratch/bad.obj"

# ---- Rust: cargo builds a crate whose build script is the gate, from the crates that Debian installs, without a network. A build that fails leaves no program.
if [ -x /usr/bin/cargo ] && [ -x /usr/bin/rustc ] && compgen -G "/usr/share/cargo/registry/serde_json-1*" >/dev/null; then
    mkdir -p "$scratch/crate/src" "$scratch/crate/assets/sub" "$scratch/crate/.cargo"
    cp "$gate/rust/build.rs" "$scratch/crate/"
    cp "$files/cube.obj" "$scratch/crate/assets/sub/good.obj"
    printf '[package]\nname = "gated"\nversion = "0.1.0"\nedition = "2021"\n[build-dependencies]\nserde_json = "1"\n' >"$scratch/crate/Cargo.toml"
    printf '[source.crates-io]\nreplace-with = "debian"\n[source.debian]\ndirectory = "/usr/share/cargo/registry"\n' >"$scratch/crate/.cargo/config.toml"
    echo 'fn main() { println!("built"); }' >"$scratch/crate/src/main.rs"
    # crate [VARIABLE=VALUE...]: the output of what cargo builds and runs
    crate() { (cd "$scratch/crate" && env RUSTC=/usr/bin/rustc CARGO_HOME="$scratch/cargo" "$@" timeout 300 /usr/bin/cargo run --offline); }
    refused_crate() { # WORDS [VARIABLE=VALUE...]
        local words=$1
        shift
        ! crate "$@" >"$scratch/crate.log" 2>&1 && grep -q -- "$words" "$scratch/crate.log"
    }
    check "Rust: a good mesh lets cargo build, and run" bash -c '[ "$(tail -1 "$0")" = built ]' <(crate 2>"$scratch/cargo.log" || tail -20 "$scratch/cargo.log")
    cp "$scratch/zero.obj" "$scratch/crate/assets/sub/"
    check "Rust: a new bad mesh stops it, with the rule and its cause" refused_crate "warning: assets/sub/zero.obj: error N102: .*\. Usual cause: "
    echo "v 1 0" >"$scratch/crate/assets/sub/zero.obj"
    check "Rust: an unreadable one does" refused_crate "warning: assets/sub/zero.obj: error N001: "
    check "Rust: it says that norma is missing" refused_crate "none/norma: cannot be run" NORMA=none/norma
    rm "$scratch/crate/assets/sub/zero.obj"
    check "Rust: once the mesh is gone it builds again" bash -c '[ "$(tail -1 "$0")" = built ]' <(crate 2>&1)
else
    skip "Rust: cargo, rustc and serde_json of Debian are not installed"
fi

# ---- Godot: its editor, without a window, imports a project. A triangle with normals is imported, one with normals of no length is not.
if command -v godot3-server >/dev/null && command -v python3 >/dev/null; then
    mkdir -p "$scratch/project"
    cp "$gate/godot/norma_gate.gd" "$scratch/project/"
    printf 'config_version=4\n[application]\nconfig/name="gate"\n' >"$scratch/project/project.godot"
    python3 - "$scratch/project" <<'PYTHON'
import base64, json, struct, sys
for name, normal in ("good", (0, 0, 1)), ("bad", (0, 0, 0)):
    data = struct.pack("<18f", 0, 0, 0, 1, 0, 0, 0, 1, 0, *normal * 3)
    view = {"buffer": 0, "byteLength": 36}
    accessor = {"componentType": 5126, "count": 3, "type": "VEC3"}
    asset = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "name": "part"}],
             "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}}]}],
             "accessors": [{**accessor, "bufferView": 0, "min": [0, 0, 0], "max": [1, 1, 0]}, {**accessor, "bufferView": 1}],
             "bufferViews": [view, {**view, "byteOffset": 36}],
             "buffers": [{"byteLength": 72, "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}]}
    with open(f"{sys.argv[1]}/{name}.gltf", "w") as out:
        json.dump(asset, out)
    with open(f"{sys.argv[1]}/{name}.gltf.import", "w") as out:
        out.write(f'[remap]\n\nimporter="scene"\ntype="PackedScene"\n\n[deps]\n\nsource_file="res://{name}.gltf"\n\n[params]\n\n'
                  'nodes/root_type="Spatial"\nnodes/root_name="Scene Root"\nnodes/root_scale=1.0\nnodes/custom_script="res://norma_gate.gd"\n'
                  'nodes/storage=0\nmaterials/location=1\nmaterials/storage=0\nmeshes/storage=0\nanimation/import=true\nanimation/fps=15\n')
PYTHON
    HOME=$scratch timeout 300 godot3-server --path "$scratch/project" --editor --quit >"$scratch/godot.log" 2>&1
    check "Godot: a good model is imported" bash -c 'ls "$0"/good.gltf-*.scn' "$scratch/project/.import"
    check "Godot: a bad one is not, and the editor says why" bash -c 'grep -q "Norma: error N102.*Usual cause" "$1" && ! ls "$0"/bad.gltf-*.scn 2>/dev/null' "$scratch/project/.import" "$scratch/godot.log"
else
    skip "Godot: godot3-server is not installed"
fi
finish
