#!/bin/sh
# submit.sh MODELS JOBS REPORT: norma check over a folder that all nodes see, as an array of JOBS jobs, then the merge. Waits;
# its exit status is that of one run over all files.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
export MODELS="$1" REPORT="$3"
PARTS=$(mktemp -d ./norma-XXXXXX)
export PARTS
trap 'rm -rf "$PARTS"' EXIT
array=$(sbatch --parsable --array="1-$2" --output="$PARTS/%a.log" "$here/check.sbatch")
sbatch --wait --dependency="afterok:$array" --kill-on-invalid-dep=yes --output="$PARTS/merge.log" "$here/merge.sbatch" >/dev/null
