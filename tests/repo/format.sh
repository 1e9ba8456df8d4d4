#!/bin/bash
# scripts/format.sh --check: no C or C++ file would be changed by clang-format, and a file that would be is found. Other versions than Debian 12's format differently.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
version=$(clang-format --version 2>/dev/null | sed -nE 's/.*version ([0-9]+).*/\1/p')
if [ "$version" != 14 ]; then
    skip "the format (clang-format 14 is not installed: scripts/install-deps.sh)"
    finish
    exit
fi
check "scripts/format.sh would change nothing" scripts/format.sh --check
mkdir -p "$scratch/tree/scripts" "$scratch/tree/src" "$scratch"/tree/{include,python,web,tests,bench,examples,packaging}
cp scripts/format.sh "$scratch/tree/scripts" && cp .clang-format "$scratch/tree"
printf 'int main( void )\n{ return 0; }\n' >"$scratch/tree/src/bad.c"
check "it names a file that it would change" bash -c '! "$0/scripts/format.sh" --check >"$0/said" 2>&1 && grep -q "src/bad.c" "$0/said"' "$scratch/tree"
check "and formats it" bash -c '"$0/scripts/format.sh" && "$0/scripts/format.sh" --check' "$scratch/tree"
finish
