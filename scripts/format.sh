#!/bin/sh
# clang-format over all C but the public headers, whose columns are set by hand.
set -eu
cd "$(dirname "$0")/.."
command -v clang-format >/dev/null || { echo "clang-format is not installed (Debian: clang-format)"; exit 1; }
find src tests examples -name '*.[ch]' -print0 | xargs -0 clang-format -i
