#!/bin/bash
# What a release consists of, into build/dist: source archive, Linux binaries, npm package, Python wheel, Blender add-on, single file, bill of materials, checksums.
#   scripts/dist.sh           from the last commit
#   scripts/dist.sh --twice   twice, from two folders, and compares: the same commit gives the same bytes
# Everything is built from the commit's own files, in a folder of its own; times inside archives are the commit's.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD
dist=$root/build/dist

git rev-parse --verify -q HEAD >/dev/null || { echo "scripts/dist.sh needs a git checkout: a release is made from a commit" >&2; exit 1; }
# One commit from the beginning to the end, whatever is committed meanwhile.
commit=${NORMA_DIST_COMMIT:-$(git rev-parse HEAD)}
export NORMA_DIST_COMMIT=$commit

if [ "${1:-}" = --twice ]; then
    scripts/dist.sh
    rm -rf "$dist-first"
    mv "$dist" "$dist-first"
    NORMA_DIST_SOURCE=$root/build/dist-source-two scripts/dist.sh
    diff -r "$dist-first" "$dist" || { echo "Two runs gave different bytes: $dist-first, $dist" >&2; exit 1; }
    rm -rf "$dist-first"
    echo "Two runs gave the same bytes."
    exit 0
fi

[ -z "$(git status --porcelain --untracked-files=no)" ] || echo "Changes that are not committed are left out." >&2
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct "$commit")
export SOURCE_DATE_EPOCH TZ=UTC LC_ALL=C.UTF-8 CCACHE_DISABLE=1
source=${NORMA_DIST_SOURCE:-$root/build/dist-source}
rm -rf "$dist" "$source"
mkdir -p "$dist" "$source"
git archive "$commit" | tar -x -C "$source"
version=$(sed -nE 's/^#define NORMA_VERSION_(MAJOR|MINOR|PATCH) +([0-9]+).*/\2/p' "$source/include/norma/norma.h" | paste -sd.)
machine=$(uname -m)
export CFLAGS="-ffile-prefix-map=$source=." CXXFLAGS="-ffile-prefix-map=$source=."

say() { printf '%s\n' "$*"; }

# step NAME COMMAND...: its output goes to a log, which is shown where it fails.
step() {
    local name=$1
    shift
    say "$name"
    "$@" >"$source/build-$name.log" 2>&1 || { tail -n 30 "$source/build-$name.log" >&2; echo "$name failed; all of it is in $source/build-$name.log" >&2; exit 1; }
}

# archive FOLDER NAME: a tar.gz whose bytes depend on the contents alone.
archive() {
    tar --sort=name --owner=0 --group=0 --numeric-owner --mode=go=rX,u+rw --mtime="@$SOURCE_DATE_EPOCH" -C "$1" -cf - "$2" | gzip -n -9 >"$dist/$2.tar.gz"
}

make_source() { git archive --format=tar --prefix="norma-$version/" "$commit" | gzip -n -9 >"$dist/norma-$version.tar.gz"; }

# binary NAME FLAGS...: a tree of its own, and an archive of the tool with its manual and completions.
binary() {
    local name=$1 tree=$source/build/$1
    shift
    cmake -S "$source" -B "$tree" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PROJECT_INCLUDE="$source/cmake/static.cmake" -DNORMA_WEB=ON -DNORMA_WEB_MODULES="$root/build/npm-bundled/node_modules" \
        -DNORMA_SHARED=OFF -DNORMA_INSTALL=OFF -DNORMA_TESTS=OFF -DNORMA_BITS=OFF -DNORMA_EXAMPLES=OFF "$@"
    cmake --build "$tree" --target norma-cli
    mkdir -p "$tree/$name/man" "$tree/$name/completions"
    install -m 755 "$tree/bin/norma" "$tree/$name/norma"
    strip "$tree/$name/norma"
    cp "$source"/docs/man/*.1 "$tree/$name/man/"
    cp "$source"/completions/* "$tree/$name/completions/"
    cp "$source/LICENSE" "$source/README.md" "$source/CHANGELOG.md" "$tree/$name/"
    cp "$source/web/licences/draco3dgltf.txt" "$tree/$name/LICENSE-Apache-2.0" # the letters of pictures, the decoder in the page
}

# Where a program looks for libraries. An empty place is the folder that somebody happens to be in: a libm.so.6 there would be run.
# (CMake pads the path with colons where there are rules to install the program.)
places() { readelf -d "$1" | sed -nE 's/.*\((RPATH|RUNPATH)\).*\[(.*)\]/\2/p'; }

needed() { readelf -d "$1" | sed -nE 's/.*\(NEEDED\).*\[(.*)\]/\1/p'; }

# For machines with glibc, as nearly all are: libEGL is opened when a picture is drawn; Debian has meshoptimizer as a shared library only, so that lies beside the tool.
make_binary() {
    local name=norma-$version-linux-$machine
    local made=$source/build/$name/$name meshoptimizer
    binary "$name" -DNORMA_WITH_RENDER=ON -DNORMA_WITH_MESHOPTIMIZER=ON -DNORMA_WITH_DRACO=ON "-DCMAKE_BUILD_RPATH=\$ORIGIN/lib"
    mkdir -p "$made/lib"
    meshoptimizer=$(ldd "$source/build/$name/bin/norma" | sed -nE 's/.*libmeshoptimizer[^ ]* => ([^ ]+).*/\1/p')
    cp -L "$meshoptimizer" "$made/lib/"
    [ "$(places "$made/norma")" = "\$ORIGIN/lib" ] || { echo "the tool looks for libraries in: $(places "$made/norma")"; return 1; }
    needed "$made/norma" | grep -vxE 'lib(c|m|stdc\+\+|gcc_s|meshoptimizer)\.so\..*|ld-linux.*' && { echo "libraries that a system may lack"; return 1; }
    archive "$source/build/$name" "$name"
}

# For all others: it needs the kernel alone. A static program cannot open libEGL (Mesa's drivers crash in one), so it draws no pictures, and reads no files that meshoptimizer compressed
# (Debian has an archive of draco, none of meshoptimizer); it says so.
make_static() {
    local name=norma-$version-linux-$machine-static
    binary "$name" -DNORMA_WITH_RENDER=OFF -DNORMA_WITH_MESHOPTIMIZER=OFF -DNORMA_WITH_DRACO=ON -DCMAKE_EXE_LINKER_FLAGS=-static-pie -DCMAKE_C_LINK_PIE_SUPPORTED=NO
    [ -z "$(needed "$source/build/$name/$name/norma")" ] || { echo "the static binary needs shared libraries"; return 1; }
    archive "$source/build/$name" "$name"
}

make_npm() { (cd "$source/build/norma-$version-linux-$machine/web/npm" && npm pack --silent --pack-destination "$dist"); }
make_wheel() { (cd "$source" && scripts/python.sh && cp build/python/*.whl "$dist/"); }

make_single() {
    local name=norma-$version-single
    (cd "$source" && scripts/single.sh "build/$name" && cp LICENSE "build/$name/")
    archive "$source/build" "$name"
}

make_addon() { (cd "$source" && scripts/blender.sh && cp build/blender/*.zip "$dist/"); }

step source make_source
step binary make_binary
step static make_static
step npm make_npm
step wheel make_wheel
[ ! -e "$source/scripts/blender.sh" ] || step addon make_addon
step single make_single
cp "$source/docs/sbom.spdx.json" "$dist/norma-$version.spdx.json"
(cd "$dist" && sha256sum -- * >SHA256SUMS)
rm -rf "$source"
say "A release of norma $version:"
(cd "$dist" && for file in *; do printf '  %-48s %9d bytes\n' "$file" "$(stat -c %s "$file")"; done)
