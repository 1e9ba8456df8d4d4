#!/bin/bash
# Whole programs with threads, for the thread sanitizer: what four threads write is what one writes, byte for byte.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
norma=$tree/bin/norma

check "engine_jobs: jobs and memory of the caller" "$tree/examples/engine_jobs"
for file in assets/goathead.obj "$NORMA_DATA"/large/voxel/veh_tank1.glb "$NORMA_DATA"/large/terrain/jacksboro.ply "$NORMA_DATA"/stl/spider-binary.stl; do
    name=$(basename "$file")
    if [ ! -e "$file" ]; then skip "$name (not here)"; continue; fi
    mkdir -p "$scratch/one" "$scratch/four"
    check "$name: computes with one thread" "$norma" compute "$file" -o "$scratch/one/$name" --threads 1
    check "$name: computes with four threads" "$norma" compute "$file" -o "$scratch/four/$name" --threads 4
    check "$name: the same bytes" cmp "$scratch/one/$name" "$scratch/four/$name"
    check "$name: transforms with four threads" "$norma" transform "$file" -o "$scratch/four/moved-$name" --scale 2,0.5,1 --threads 4
done
finish
