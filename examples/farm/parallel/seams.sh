#!/bin/sh
# seams.sh TILES OUT: one normal at the seams of all PLY tiles of a folder, by GNU parallel: 20 tiles a job.
# -q: spaces and $ in names stay what they are.
set -eu
tiles=$1 out=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$out"
find "$tiles" -maxdepth 1 -name '*.ply' | sort >"$work/tiles"
parallel -q --retries 3 -N 20 norma seams votes {} --threads 1 --quiet -o "$work/{#}.votes" <"$work/tiles"
norma seams merge "$work"/*.votes --tiles "$(wc -l <"$work/tiles")" --quiet -o "$work/all"
parallel -q --retries 3 -N 20 norma seams apply {} --votes "$work/all" --threads 1 --quiet --out-dir "$out" <"$work/tiles"
