#!/bin/bash
# Installs into an empty prefix, moves it, and builds programs in C and C++ against it: with CMake and with pkg-config, shared and static.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1

check "installs" cmake --install "$tree" --prefix "$scratch/first"
mv "$scratch/first" "$scratch/usr"
prefix=$scratch/usr
lib=$prefix/$(cd "$prefix" && find lib -name libnorma.a -printf '%h')

for file in bin/norma include/norma/norma.h include/norma/norma.hpp include/norma/document.h include/norma/shaders/norma.glsl include/norma/shaders/norma.hlsl include/norma/shaders/norma.wgsl share/doc/norma/LICENSE; do
    check "has $file" test -f "$prefix/$file"
done
missing=$({ scripts/public-symbols.sh | sed 's#.*#man3/&.3#'; find docs/man -name '*.[1357]' -printf '%f\n' | sed -E 's#.*\.(.)$#man\1/&#'; } |
    while read -r page; do [ -e "$prefix/share/man/$page" ] || echo "$page"; done)
if [ -z "$missing" ]; then pass "has a manual page for every public function and every verb"; else fail "has a manual page for every public function and every verb" "$missing"; fi
for file in bash-completion/completions/norma zsh/site-functions/_norma fish/vendor_completions.d/norma.fish; do
    check "has share/$file" test -s "$prefix/share/$file"
done
check "the installed tool runs" "$prefix/bin/norma" --version

# What the shared library exports is what the headers declare, with a version each.
exported=$(nm -D --defined-only "$lib/libnorma.so" | awk '$2 == "T" { print $3 }' | sort)
declared=$(scripts/public-symbols.sh)
difference=$(diff <(sed 's/@@.*//' <<<"$exported") <(printf '%s\n' "$declared"))
if [ -z "$difference" ]; then pass "libnorma.so exports what the public headers declare"; else fail "libnorma.so exports what the public headers declare" "$difference"; fi
check "every exported symbol has a version" test -z "$(printf '%s\n' "$exported" | grep -v '@@NORMA_[0-9.]*$')"
check "libnorma.so has the soname libnorma.so.0" bash -c 'readelf -d "$0" | grep -q "SONAME.*\[libnorma.so.0\]"' "$lib/libnorma.so"
# The static library marks the same functions as public and hides all others.
visible=$(readelf -sW "$lib/libnorma.a" 2>/dev/null | awk '$5 == "GLOBAL" && $6 == "DEFAULT" && $7 != "UND" { print $8 }' | sort -u)
difference=$(diff <(printf '%s\n' "$visible") <(printf '%s\n' "$declared"))
if [ -z "$difference" ]; then pass "libnorma.a hides what the public headers do not declare"; else fail "libnorma.a hides what the public headers do not declare" "$difference"; fi
# In a static library all names meet those of the program; but for weak ones of C++ (templates of libdraco's headers), of which any number may meet.
strangers=$(nm --defined-only "$lib/libnorma.a" 2>/dev/null | awk 'NF == 3 && $2 ~ /[A-Z]/ && $3 !~ /^norma_/ && !($2 ~ /[VW]/ && $3 ~ /^(DW\.ref\.)?_(Z|_gxx_personality_v0$)/) { print $3 }')
if [ -z "$strangers" ]; then pass "every symbol of libnorma.a begins with norma_"; else fail "every symbol of libnorma.a begins with norma_" "$strangers"; fi
hardened=$(readelf -lW "$prefix/bin/norma"; readelf -dW "$prefix/bin/norma"; readelf -hW "$prefix/bin/norma")
check "the tool is position independent, with relro and bindings resolved at once" bash -c 'grep -q "DYN" <<<"$0" && grep -q GNU_RELRO <<<"$0" && grep -qE "BIND_NOW|Flags:.*NOW" <<<"$0"' "$hardened"

core_declared=$(nm -D --defined-only "$lib/libnorma-core.so" | awk '$2 == "T" { sub(/@@.*/, "", $3); print $3 }' | sort)
check "libnorma-core.so exports what norma.h declares" test "$core_declared" = "$(scripts/public-symbols.sh include/norma/norma.h)"
check "libnorma-core.so needs libc and libm only" bash -c '! readelf -d "$0" | grep NEEDED | grep -vE "lib(c|m)\.so|ld-linux"' "$lib/libnorma-core.so"
twice=$(nm --defined-only "$lib/libnorma.a" 2>/dev/null | awk 'NF == 3 && $2 ~ /[A-Z]/ { print $3 }' | sort | uniq -d)
if [ -z "$twice" ]; then pass "no symbol is twice in libnorma.a"; else fail "no symbol is twice in libnorma.a" "$twice"; fi

# CMake
check "CMake: find_package(norma) configures" cmake -S tests/repo/consumer -B "$scratch/consumer" -G Ninja -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release
check "CMake: consumers build" cmake --build "$scratch/consumer"
for kind in shared static; do
    check "CMake: C, core, $kind, runs" "$scratch/consumer/core-$kind"
    check "CMake: C, documents, $kind, runs" bash -c '"$0" | grep -q "^vn 0 0 1$"' "$scratch/consumer/document-$kind"
    check "CMake: C++, $kind, runs" "$scratch/consumer/cpp-$kind"
done
check "shared and static give the same bits" cmp <("$scratch/consumer/core-shared") <("$scratch/consumer/core-static")
check "norma::norma is the shared library" bash -c 'readelf -d "$0" | grep -q libnorma.so.0' "$scratch/consumer/core-default"
for kind in shared static; do
    check "CMake: the core alone, $kind, gives the same bits" cmp <("$scratch/consumer/core-static") <("$scratch/consumer/alone-$kind")
    check "CMake: with both libraries, $kind, too" cmp <("$scratch/consumer/core-static") <("$scratch/consumer/both-$kind")
done
check "norma::core is the core's shared library, and that alone" bash -c 'readelf -d "$0" | grep -q "libnorma-core.so.0" && ! readelf -d "$0" | grep -q "libnorma.so"' "$scratch/consumer/alone-default"
# The components that a packager makes packages of.
mkdir -p "$scratch/parts"
for part in core core-development; do
    check "the component $part installs" cmake --install "$tree" --prefix "$scratch/parts" --component $part
done
check "the core's components hold the core alone" bash -c 'test -z "$(find "$0" -name "libnorma.*" -o -name "norma.pc" -o -name "document.h" -o -path "*/bin/*")" && test -n "$(find "$0" -name norma-core.pc)"' "$scratch/parts"
printf '%s\n' 'cmake_minimum_required(VERSION 3.25)' 'project(alone C)' 'find_package(norma 0.1 REQUIRED COMPONENTS core)' "add_executable(alone $root/tests/repo/consumer/core.c)" \
    'target_link_libraries(alone PRIVATE norma::core)' 'find_package(norma QUIET COMPONENTS norma)' 'if(norma_FOUND)' 'message(FATAL_ERROR "norma was found without libnorma")' 'endif()' >"$scratch/alone.txt"
mkdir "$scratch/alone" && mv "$scratch/alone.txt" "$scratch/alone/CMakeLists.txt"
check "CMake: find_package(norma COMPONENTS core) is enough for the core" bash -c 'cmake -S "$0" -B "$0/build" -DCMAKE_PREFIX_PATH="$1" && cmake --build "$0/build" && "$0/build/alone"' "$scratch/alone" "$scratch/parts"

# In another project's tree; compiled as scripts/tree.sh does, so that ccache has what is the same.
as_first_tree="-DCMAKE_C_COMPILER=gcc -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE=-O2 -DNORMA_WERROR=ON"
# shellcheck disable=SC2086  # a list of words
check "FetchContent: configures" cmake -S examples/fetchcontent -B "$scratch/engine" -G Ninja $as_first_tree
check "FetchContent: builds the static core and nothing else" bash -c 'cmake --build "$0" && test -z "$(find "$0" -name "libnorma*.so*" -o -name libnorma.a)"' "$scratch/engine"
check "FetchContent: the example prints what it prints here" cmp tests/repo/examples/normals_of_a_mesh.txt <("$scratch/engine/engine")
printf '%s\n' 'cmake_minimum_required(VERSION 3.25)' 'project(tree C CXX)' "add_subdirectory($root norma EXCLUDE_FROM_ALL)" "add_executable(tree $root/tests/repo/consumer/document.c)" \
    'target_link_libraries(tree PRIVATE norma::norma)' >"$scratch/tree.txt"
mkdir "$scratch/tree" && mv "$scratch/tree.txt" "$scratch/tree/CMakeLists.txt"
check "add_subdirectory: norma::norma is there, and the program runs" bash -c 'cmake -S "$0" -B "$0/build" -G Ninja $1 && cmake --build "$0/build" && "$0/build/tree" | grep -q "^vn 0 0 1$"' "$scratch/tree" "$as_first_tree"

# pkg-config
export PKG_CONFIG_PATH=$lib/pkgconfig
check "pkg-config knows the version" test "$(pkg-config --modversion norma)" = "$(sed -nE 's/^project\(norma VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)"
# shellcheck disable=SC2046  # lists of flags
check "pkg-config: C, shared, builds" gcc -std=c11 -Wall -Werror tests/repo/consumer/document.c -o "$scratch/pc-shared" $(pkg-config --cflags --libs norma)
check "pkg-config: C, shared, runs" env LD_LIBRARY_PATH="$lib" "$scratch/pc-shared"
# Static: only libnorma.a to be found; what it needs comes from Libs.private.
mkdir "$scratch/static"
cp "$lib/libnorma.a" "$scratch/static"
# shellcheck disable=SC2046
check "pkg-config: C, static, builds" gcc -std=c11 -Wall -Werror tests/repo/consumer/document.c -o "$scratch/pc-static" -L"$scratch/static" $(pkg-config --static --cflags --libs-only-l --libs-only-other norma)
check "pkg-config: C, static, runs" bash -c '"$0" | grep -q "^vn 0 0 1$" && ! readelf -d "$0" | grep -q libnorma' "$scratch/pc-static"
# shellcheck disable=SC2046
check "pkg-config: C++, shared, builds" clang++ -std=c++17 -Wall -Werror tests/repo/consumer/consumer.cpp -o "$scratch/pc-cpp" $(pkg-config --cflags --libs norma)
check "pkg-config: C++, shared, runs" env LD_LIBRARY_PATH="$lib" "$scratch/pc-cpp"
# shellcheck disable=SC2046
check "pkg-config: the core, shared, builds" gcc -std=c11 -Wall -Werror tests/repo/consumer/core.c -o "$scratch/pc-core" $(pkg-config --cflags --libs norma-core)
check "pkg-config: the core, shared, runs" env LD_LIBRARY_PATH="$lib" "$scratch/pc-core"
# shellcheck disable=SC2046
check "pkg-config: the core in a program without shared libraries builds" gcc -static -std=c11 -Wall -Werror tests/repo/consumer/core.c -o "$scratch/pc-core-static" $(pkg-config --static --cflags --libs norma-core)
check "pkg-config: it runs" cmp <("$scratch/pc-core-static") <("$scratch/consumer/core-static")
finish
