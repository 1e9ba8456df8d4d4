#!/bin/bash
# clang-tidy over the library and the tool, shellcheck over the scripts, mandoc over the manual. A tool that is not installed is named and passed over.
set -u
cd "$(dirname "$0")/.." || exit 1
status=0

if command -v clang-tidy >/dev/null; then
    cmake -S . -B build/lint -G Ninja -DCMAKE_C_COMPILER=clang -DNORMA_TESTS=OFF -DNORMA_WEB=OFF >/dev/null || exit 1
    find src -name '*.c' | sort | xargs -P "$(nproc)" -n 4 clang-tidy -p build/lint --quiet 2>/dev/null || status=1
else
    echo "clang-tidy is not installed (Debian: clang-tidy)"
fi
if command -v shellcheck >/dev/null; then
    shellcheck -x -P tests -S warning -e SC2016,SC2001 scripts/*.sh tests/*.sh tests/*/*.sh .ci/run || status=1
else
    echo "shellcheck is not installed (Debian: shellcheck)"
fi
if command -v mandoc >/dev/null; then
    mandoc -T lint -W warning docs/man/*.[1-9] || status=1
else
    echo "mandoc is not installed (Debian: mandoc)"
fi
exit $status
