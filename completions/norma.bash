# Completion of norma's command line for bash. Installed as share/bash-completion/completions/norma.
_norma() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} verb=${COMP_WORDS[1]:-}
    local matrix="--scale --rotate --translate --matrix"
    local files="-o --output --out-dir --in-place --input-format --threads --max-memory --json --quiet --help"
    local values="" options=""
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        mapfile -t COMPREPLY < <(compgen -W "compute seams tangents pack transform matrix check report explain info compare render view acid mcp help --help --version" -- "$word")
        return
    fi
    case $before in
    help) values="compute seams tangents pack transform matrix check report explain info compare render view acid mcp" ;;
    --format) values="text line json sarif html" ;;
    --profile) values="render print generated" ;;
    --color) values="auto always never" ;;
    --fail-on) values="error warning info never" ;;
    --weight) values="angle area uniform max angle-area visible angle-lengths" ;;
    --weld) values="exact none" ;;
    --groups) values="auto ignore" ;;
    --non-manifold) values="hard smooth" ;;
    --mode) values="mikk meshopt steady" ;;
    --tangents) values="keep orthogonalise regenerate" ;;
    --only) values="all missing broken" ;;
    --shading) values="flat gouraud phong" ;;
    --show) values="normals winding error findings matcap zebra tangents hedgehog wireframe" ;;
    --space) values="world view" ;;
    --normals) values="stored computed" ;;
    --lines) values="vertices faces edges" ;;
    --up) values="x y z -x -y -z" ;;
    --background) values="paper white black grey transparent" ;;
    --renderer) values="auto software" ;;
    --input-format) values="obj ply stl gltf glb b3dm i3dm cmpt 3mf" ;;
    --select | --ignore | --max-samples | --lock | --crease | --texcoord | --threads | --max-memory | --scale | --rotate | --translate | --matrix) return ;;
    --out-dir)
        mapfile -t COMPREPLY < <(compgen -d -- "$word")
        return
        ;;
    esac
    if [ -n "$values" ]; then
        mapfile -t COMPREPLY < <(compgen -W "$values" -- "$word")
        return
    fi
    case $verb in
    compute) options="--weight --crease --smooth --flat --groups --weld --non-manifold --only --morphs --tangents --together --lock --levels $files" ;;
    tangents) options="--mode --texcoord --weight --only $files" ;;
    seams) options="votes merge apply --weight --everywhere --rounded --tiles --votes -o --output --out-dir --in-place --input-format --threads --max-memory --json --quiet --help" ;;
    pack) options="--max-error $files" ;;
    transform) options="$matrix --bake $files" ;;
    matrix) options="$matrix --json --help" ;;
    render) options="-o --output --out-dir --shading --show --compare --label --select --clay --lines --line-length --line-width --most-lines --error-top --normals --weight --crease --space --camera --fov --up --light --phong --size --samples --background --renderer $matrix --input-format --threads --max-memory --json --quiet --help" ;;
    check) options="--select --ignore --profile --strict --config --no-config --trust-config --baseline --write-baseline --format --info --color --fail-on --max-samples --page --fix --fix-unsafe --open-by-rays --dry-run --against --max --share --files-from --shard --exit $files" ;;
    report) options="--merge --partial --format -o --output --info --help" ;;
    explain) options="-o --output --json --help" ;;
    view) options="-o --output --out-dir --input-format --threads --max-memory --json --quiet --help" ;;
    compare) options="-o --output --max --share --input-format --threads --max-memory --json --quiet --help" ;;
    mcp) options="--root --read-only --help" ;;
    acid) options="--judge --scene --without -o --output --tap --json --quiet --help" ;;
    info) options="--deep --input-format --threads --max-memory --json --quiet --help" ;;
    esac
    if [[ $word == -* ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$options" -- "$word")
    elif [ "$verb" != matrix ] && [ "$verb" != explain ] && [ "$verb" != help ]; then
        mapfile -t COMPREPLY < <(compgen -d -S / -- "$word"; compgen -f -X '!*.@(obj|ply|stl|gltf|glb|vrm|b3dm|i3dm|cmpt|3mf|OBJ|PLY|STL|GLTF|GLB|VRM)' -- "$word")
        [[ ${COMPREPLY[0]:-} != */ ]] || compopt -o nospace 2>/dev/null
    fi
}
shopt -s extglob
complete -F _norma norma
