#!/bin/sh
# deps.sh TARGET MESH: a dependency file for make and Ninja: TARGET depends on MESH and on the files that it names (buffers and images of a glTF, material libraries of an OBJ), as far
# as they are there.
target=$1 mesh=$2 folder=$(dirname "$2")
escape() { sed 's/[ #\\]/\\&/g; s/\$/$$/g'; }
named() {
    case $mesh in
    *.gltf) grep -oE '"uri"[[:space:]]*:[[:space:]]*"[^"]*"' "$mesh" | sed -E 's/.*"([^"]*)"$/\1/; /^data:/d' ;;
    *.obj) sed -nE 's/^mtllib[[:space:]]+([^\r]*).*/\1/p' "$mesh" ;;
    esac
}
printf '%s: %s' "$(printf %s "$target" | escape)" "$(printf %s "$mesh" | escape)"
named | sort -u | while IFS= read -r name; do
    [ ! -f "$folder/$name" ] || printf ' %s' "$(printf %s "$folder/$name" | escape)"
done
echo
