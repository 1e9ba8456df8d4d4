#!/bin/sh
# clang-format over every C and C++ file of the repository, with the one .clang-format at its root.
#   scripts/format.sh           formats in place
#   scripts/format.sh --check   changes nothing; names the files that would change and fails
set -eu
cd "$(dirname "$0")/.."
command -v clang-format >/dev/null || { echo "clang-format is not installed (Debian: clang-format)"; exit 1; }
files() { find include src python web tests bench examples packaging scripts \( -name '*.c' -o -name '*.h' -o -name '*.cpp' -o -name '*.hpp' \) -print0; }
if [ "${1:-}" = --check ]; then
    files | xargs -0 clang-format --dry-run -Werror
else
    # A split comment or string may need another pass before nothing changes any more.
    for _ in 1 2 3 4; do
        files | xargs -0 clang-format -i
        ! files | xargs -0 clang-format --dry-run -Werror 2>/dev/null || exit 0
    done
    files | xargs -0 clang-format --dry-run -Werror
fi
