#!/bin/sh
# clang-format over every C and C++ file of the repository, with the one .clang-format at its root.
#   scripts/format.sh           formats in place
#   scripts/format.sh --check   changes nothing; names the files that would change and fails
set -eu
cd "$(dirname "$0")/.."
command -v clang-format >/dev/null || { echo "clang-format is not installed (Debian: clang-format)"; exit 1; }
if [ "${1:-}" = --check ]; then set -- --dry-run -Werror; else set -- -i; fi
find include src web tests bench examples \( -name '*.c' -o -name '*.h' -o -name '*.cpp' \) -print0 | xargs -0 clang-format "$@"
