#!/bin/bash
# scripts/census.sh: shares that were counted by hand, for a folder made for it.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
export NORMA_BIN=${NORMA_BIN:-$tree/bin/norma}
if ! command -v python3 >/dev/null; then
    skip "the census: python3 is not installed"
    finish
    exit
fi
models=$scratch/models
mkdir -p "$models/good" "$models/bad/deep" "$models/listed"
cube=tests/cli/golden/files/cube.obj
turned() { awk '/^f/ { line = $1; for (i = NF; i > 1; --i) line = line " " $i; print line; next } { print }' "$cube"; }
cp "$cube" "$models/good/a.obj"
cp "$cube" "$models/good/b.obj"
turned >"$models/good/c.obj"
turned >"$models/bad/deep/d.obj"
echo 'f 1 2 3' >"$models/bad/e.obj"
cp "$cube" "$models/listed/f.obj"
printf 'file\torigin\tlicence\nlisted/f.obj\tsomebody/models\tCC0\n' >"$models/INDEX.tsv"

cat >"$scratch/expected" <<'TABLE'
| | bad | good | somebody/models | all |
|---|---:|---:|---:|---:|
| models | 2 | 3 | 1 | 6 |
| without fault |  | 67 % | 100 % | 50 % |
| N001 unreadable | 50 % |  |  | 17 % |
| N302 inside-out | 50 % | 33 % |  | 33 % |
TABLE
scripts/census.sh "$models" --profile generated >"$scratch/table" 2>"$scratch/errors"
check "the shares are those counted by hand" diff "$scratch/expected" "$scratch/table"
check "options reach norma check" bash -c '! scripts/census.sh "$0" --select N001 | grep -q N302' "$models"
check "no folder is a usage error" bash -c 'scripts/census.sh "$0/none" 2>/dev/null; [ $? = 2 ]' "$models"
finish
