#!/bin/bash
# What packagers are handed (debian/, packaging/) is of the project's version, names only options that CMakeLists.txt has, and is well formed. `make deb` builds the packages.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1

version=$(sed -nE 's/^project\(norma VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
check "debian/changelog is of version $version" bash -c 'head -n 1 debian/changelog | grep -qF "norma ($0)"' "$version"
check "vcpkg.json is of version $version" grep -qF "\"version\": \"$version\"" packaging/vcpkg/norma/vcpkg.json
check "conanfile.py is of version $version" grep -qF "version = \"$version\"" packaging/conan/conanfile.py
for file in debian/rules packaging/vcpkg/norma/portfile.cmake packaging/conan/conanfile.py; do
    unknown=$(grep -oE 'NORMA_[A-Z_]*[A-Z]' $file | sort -u | while read -r name; do grep -qE "^ *(option\(|set\(|find_library\()$name " CMakeLists.txt cmake/dependencies.cmake || echo "$name"; done)
    if [ -z "$unknown" ]; then pass "$file names only options that exist"; else fail "$file names only options that exist" "$unknown"; fi
done
if command -v python3 >/dev/null; then
    check "conanfile.py is Python" python3 -c 'import ast, sys; [ast.parse(open(f).read(), f) for f in sys.argv[1:]]' packaging/conan/conanfile.py packaging/conan/test_package/conanfile.py
    check "vcpkg.json is JSON" python3 -m json.tool packaging/vcpkg/norma/vcpkg.json
else
    skip "packaging/conan, vcpkg.json (no python3)"
fi
# The program of the Conan package's test, against this tree.
check "the test program builds" gcc -std=c11 -Wall -Wextra -Werror -Iinclude packaging/conan/test_package/program.c -o "$scratch/program" "$tree/lib/libnorma-core.a" -lm -pthread
check "the test program runs" "$scratch/program"
finish
