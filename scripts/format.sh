#!/bin/sh
# clang-format over src/check, src/cli and src/render. In the other folders columns are set by hand: .clang-format there switches it off, for editors too.
set -eu
cd "$(dirname "$0")/.."
command -v clang-format >/dev/null || { echo "clang-format is not installed (Debian: clang-format)"; exit 1; }
find src/check src/cli src/render -name '*.[ch]' -print0 | xargs -0 clang-format -i
