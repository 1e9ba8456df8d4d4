#!/bin/sh
# Installs what building and testing need and this machine lacks: Debian packages by apt-get (as root or through sudo), and from npm the
# Khronos glTF validator in the versions of tests/cli/validator/package-lock.json, into build/npm, and what the package-lock.json of tests/web, tests/tangent and tests/mcp name, into build/npm-web, build/npm-tangent and build/npm-mcp.
# The decoders of compressed glTF that page and npm package hold, and the page's three.js and mediabunny (web/package-lock.json), come from npm, into build/npm-bundled.
# Where nothing is missing it only looks.
#   scripts/install-deps.sh build   what `make` needs
#   scripts/install-deps.sh web     what the page, the npm package and so `norma view` need to be built
#   scripts/install-deps.sh python  what `make python` needs
#   scripts/install-deps.sh blender that, and Blender, for `make blender`
#   scripts/install-deps.sh bench   that, and the libraries that `make bench` compares with (more than a gigabyte)
#   scripts/install-deps.sh portable    and cross compilers for 64-bit ARM and Windows with what runs their programs
#   scripts/install-deps.sh analyse     and clang-tidy
#   scripts/install-deps.sh mpi     what `make mpi` needs: Open MPI and MPICH
#   scripts/install-deps.sh firefox     Firefox and a display without a screen, for `make firefox`
#   scripts/install-deps.sh engines     the engines of `make engines`, from Debian and npm (tests/engines/package-lock.json), and Chromium
#   scripts/install-deps.sh farms       GNU parallel, Snakemake, Dask and Slurm, on which `make farms` runs examples/farm
#   scripts/install-deps.sh deb     what `make deb` needs
#   scripts/install-deps.sh test    what `make test` needs
#   scripts/install-deps.sh         what building and `make test-all` need
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
what=${1:-all}

# g++: the one file that calls libdraco.
packages="gcc g++ libc6-dev make cmake ninja-build pkg-config libmeshoptimizer-dev libdraco-dev libpng-dev libjpeg-dev zlib1g-dev libegl-dev libgles-dev libegl1 libgl1-mesa-dri"
python_packages="python3-dev python3-numpy python3-setuptools python3-wheel python3-venv"
web_packages="clang lld wasi-libc libclang-rt-dev-wasm32 esbuild"
[ "$what" != web ] || packages=$web_packages
[ "$what" != python ] || packages="$packages $python_packages mypy python3-pytest python3-meshio"
[ "$what" != blender ] || packages="$packages $python_packages blender"
if [ "$what" = bench ]; then
    packages="$packages $web_packages $python_packages g++ libvtk9-dev libopen3d-dev python3-open3d libopenmesh-dev libcgal-dev libassimp-dev libglm-dev libcglm-dev libeigen3-dev"
fi
if [ "$what" = portable ]; then
    packages="$packages $web_packages llvm dpkg-dev gcc-aarch64-linux-gnu g++-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user gcc-mingw-w64-x86-64-posix g++-mingw-w64-x86-64-posix wine wine64"
fi
[ "$what" != analyse ] || packages="$packages clang clang-tidy"
[ "$what" != firefox ] || packages="firefox-esr xvfb"
[ "$what" != engines ] || packages="chromium xvfb xauth f3d godot3 blender python3-numpy python3"
[ "$what" != farms ] || packages="parallel snakemake python3-distributed slurm-wlm python3"
[ "$what" != mpi ] || packages="$packages libopenmpi-dev openmpi-bin libmpich-dev mpich python3-mpi4py python3-meshio python3-h5py"
[ "$what" != deb ] || packages="$packages $web_packages debhelper dpkg-dev fakeroot lintian"
if [ "$what" = all ] || [ "$what" = test ]; then
    # ccache: scripts of the suite compile the sources again, as in a user's tree; clang with its run-time library: the sanitizers and libFuzzer; llvm: names in their reports; gmp: the oracle; jansson: a second reader of glTF in fuzz targets; mandoc: the manual's lint; glslang: compiles the shaders of the guide; python3: makes files.
    packages="$packages ccache clang llvm libclang-rt-14-dev libcmocka-dev libgmp-dev libjansson-dev mandoc locales clang-format glslang-tools python3"
fi
if [ "$what" = all ]; then
    # admesh, lib3mf, unzip: judges of fixed STL and 3MF files; godot3-server, cargo with serde_json: run the gates of examples/gate; spirv-cross: makes GLSL of norma.hlsl, which then runs; curl: fetches a release in the test of the action; chromium: the page's tests; mypy, pytest and meshio (a second reader): those of the Python package.
    packages="$packages admesh lib3mf1 godot3-server cargo rustc librust-serde-json-dev unzip spirv-cross curl $web_packages chromium $python_packages mypy python3-pytest python3-meshio"
fi

missing=""
# shellcheck disable=SC2086  # a list of words
installed=$(dpkg-query -W -f='${Package} ${db:Status-Status}\n' $packages 2>/dev/null || true)
for package in $packages; do
    case "
$installed" in
    *"
$package installed"*) ;;
    *) missing="$missing $package" ;;
    esac
done
[ "$what" != engines ] || command -v npm >/dev/null || missing="$missing npm"
[ "$what" = build ] || [ "$what" = mpi ] || command -v node >/dev/null || missing="$missing nodejs"
case " $packages " in *" wasi-libc "*) command -v npm >/dev/null || missing="$missing npm" ;; esac

if [ -n "$missing" ]; then
    echo "installing:$missing"
    command -v apt-get >/dev/null || { echo "$0: no apt-get here; please install:$missing" >&2; exit 1; }
    sudo=""
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || { echo "$0: neither root nor sudo; please install:$missing" >&2; exit 1; }
        sudo=sudo
    fi
    $sudo apt-get update -qq
    # shellcheck disable=SC2086
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing >/dev/null
fi

failed=0

# from_npm FOLDER PLACE: the packages of FOLDER/package-lock.json, into PLACE. Where that fails (no network), what needs them is left out.
from_npm() {
    if ! cmp -s "$root/$1/package-lock.json" "$2/installed-lock.json"; then
        echo "installing: the packages of $1/package-lock.json from npm"
        mkdir -p "$2"
        cp "$root/$1/package.json" "$root/$1/package-lock.json" "$2"
        if (cd "$2" && npm ci --no-audit --no-fund --ignore-scripts --loglevel=error); then
            cp "$root/$1/package-lock.json" "$2/installed-lock.json"
        else
            echo "$0: npm could not install them; what needs them is left out" >&2
            failed=1
        fi
    fi
}
# A folder that has been built with the page keeps it up to date, so plain make may need what the list names anew.
[ ! -e "$root/build/npm-bundled/installed-lock.json" ] || packages="$packages wasi-libc"
case " $packages " in *" wasi-libc "*) from_npm web "$root/build/npm-bundled" ;; esac
if [ "$what" = engines ]; then
    from_npm tests/engines "$root/build/npm-engines"
fi
[ "$what" != bench ] || from_npm bench/rivals/npm "$root/build/npm-bench"
if [ "$what" = all ]; then
    from_npm tests/cli/validator "$root/build/npm"
    from_npm tests/web "$root/build/npm-web"
    from_npm tests/tangent "$root/build/npm-tangent"
    from_npm tests/mcp "$root/build/npm-mcp"
fi
exit $failed
