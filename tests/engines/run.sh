#!/bin/bash
# Draws the acid scene with each engine, headless and in software, and has norma judge the pictures. Writes tests/engines/verdicts.json,
# docs/engines.md and its pictures. `make engines` installs the engines and calls this.
#   run.sh            all engines
#   run.sh ENGINE...  some: names of pages/*.js and native/*.sh; the others keep their last verdicts
# NORMA_SECONDS: how long one may take to draw (150).
set -u
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
norma=${NORMA_BIN:-$root/build/bin/norma}
out=$root/build/engines
export NORMA_ENGINES=${NORMA_ENGINES:-$root/build/npm-engines} LIBGL_ALWAYS_SOFTWARE=1

[ $# -gt 0 ] || { cd "$here" && set -- pages/*.js native/*.sh; }
mkdir -p "$out"
"$norma" acid -o "$out/scenes" --quiet || exit
for name; do
    name=$(basename "${name%.*}")
    rm -f "$out/$name".*
    if [ -e "$here/pages/$name.js" ]; then draw=(node "$here/browser.mjs" "$name"); else draw=("$here/native/$name.sh"); fi
    # What it prints is its name and version; where it fails, the reason.
    timeout --kill-after=10 600 "${draw[@]}" "$out/scenes/norma-acid.glb" "$out/$name.png" >"$out/$name.said" 2>"$out/$name.err"
    echo $? >"$out/$name.status"
    without=$(node -p '(require(process.argv[1])[process.argv[2]] ?? {}).without ?? ""' "$here/findings.json" "$name")
    "$norma" acid --judge "$out/$name.png" ${without:+--without "$without"} --json >"$out/$name.json" 2>"$out/$name.judge"
    echo "$name: $(tail -n 1 "$out/$name.said") $(grep -o '"summary".*' "$out/$name.json" || cat "$out/$name.judge")"
    names+=("$name")
done
node "$here/report.mjs" "$out" "${names[@]}"
