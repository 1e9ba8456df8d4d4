#!/bin/bash
# The npm package: the same bits as the native library, arguments and errors, types, examples in node and three.js.
#   tests/web/package.sh --refresh     writes the examples' expected output anew
# shellcheck disable=SC2016  # single quotes hold what inner shells expand
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
refresh=${1:-}
package=$tree/web/npm
modules=${NORMA_NPM_WEB:-$root/build/npm-web/node_modules}

# tap NAME COMMAND...: the checks of a program that prints TAP, under our numbers.
tap() {
    local name=$1 output status=0
    shift
    output=$("$@" 2>"$scratch/tap.err") || status=$?
    local cases=0
    while IFS= read -r line; do
        case $line in
        "ok "*"# SKIP "*) skip "$name: ${line#*# SKIP }"; cases=$((cases + 1)) ;;
        "ok "*) pass "$name: ${line#* - }"; cases=$((cases + 1)) ;;
        "not ok "*) fail "$name: ${line#* - }"; cases=$((cases + 1)) ;;
        "# "*) echo "$line" ;;
        esac
    done <<<"$output"
    if ! grep -qx "1\.\.$cases" <<<"$output" || { [ "$status" -ne 0 ] && ! grep -q '^not ok' <<<"$output"; }; then
        fail "$name ran to its end" "exit status $status after $cases cases: $(cat "$scratch/tap.err")"
    fi
}

if [ ! -f "$package/index.js" ]; then
    skip "the npm package (this tree is built without -DNORMA_WEB=ON)"
    finish
    exit
fi

check "the native program compiles" gcc -std=c11 -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror -O1 -Iinclude tests/web/native.c -o "$scratch/native" "$tree/lib/libnorma.a" -lmeshoptimizer -lm -pthread
tap bits node tests/web/bits.mjs "$package" "$scratch/native"
tap calls node tests/web/calls.mjs "$package"

# What the page makes of a file, with the sanitizers of a native compiler.
check "the model's files compile under the sanitizers" gcc -std=c11 -g -O1 -fsanitize=address,undefined -fno-sanitize-recover=all -Wno-attributes -Iinclude -Isrc tests/web/model.c \
    web/page/model/model.c web/page/model/recompute.c web/page/model/crease_slider.c web/page/model/shown_findings.c web/page/model/pick.c web/package/wasm/calls.c web/page/model/model_pack.c web/page/model/pack_findings.c -o "$scratch/model" "$tree/lib/libnorma.a" -lmeshoptimizer -lm -pthread
check "packs of the assets are drawn, and damaged ones drawn or refused" "$scratch/model" assets/*.obj assets/*.stl tests/cli/golden/files/*.obj tests/cli/golden/files/roof.*

version=$(sed -nE 's/^project\(norma VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
check "package.json tells the library's version" test "$(node -p 'require(process.argv[1]).version' "$package/package.json")" = "$version"
check "the module is of a size that one inlines (below 400 kB)" test "$(stat -c %s "$package/norma.wasm")" -lt 400000

# As a user has it: packed by npm, unpacked into node_modules, found by name.
mkdir -p "$scratch/user/node_modules/norma"
if (cd "$package" && npm pack --silent --pack-destination "$scratch" >/dev/null 2>"$scratch/pack.err") && tar -xzf "$scratch/norma-$version.tgz" -C "$scratch/user/node_modules/norma" --strip-components=1; then
    pass "npm pack"
else
    fail "npm pack" "$(cat "$scratch/pack.err")"
fi
cp examples/web/*.mjs tests/web/types.ts "$scratch/user"
for name in three typescript; do [ ! -d "$modules/$name" ] || ln -s "$modules/$name" "$scratch/user/node_modules/$name"; done

for example in examples/web/*.mjs; do
    name=$(basename "$example" .mjs)
    if grep -q 'from "three"' "$example" && [ ! -d "$modules/three" ]; then skip "$name (three is not installed: scripts/install-deps.sh)"; continue; fi
    if ! (cd "$scratch/user" && node "$name.mjs") >"$scratch/$name.out" 2>"$scratch/$name.err"; then
        fail "examples/web/$name.mjs runs" "$(cat "$scratch/$name.err")"
        continue
    fi
    [ "$refresh" != --refresh ] || cp "$scratch/$name.out" "tests/web/expected/$name.txt"
    if difference=$(diff "tests/web/expected/$name.txt" "$scratch/$name.out" 2>&1); then pass "examples/web/$name.mjs prints what it should"; else fail "examples/web/$name.mjs prints what it should" "$difference"; fi
done

if [ -d "$modules/typescript" ]; then
    check "types: tsc --strict" bash -c 'cd "$0" && node node_modules/typescript/bin/tsc --strict --noEmit --module nodenext --target es2022 --skipLibCheck false types.ts' "$scratch/user"
else
    skip "types (typescript is not installed: scripts/install-deps.sh)"
fi
finish
