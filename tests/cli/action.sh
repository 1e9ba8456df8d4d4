#!/bin/bash
# action.yml as GitHub's runner would run it: the step "Check", taken out of the file, under `bash --noprofile --norc -eo pipefail` with the inputs in its environment.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
NORMA=${NORMA_BIN:-$tree/bin/norma}
cd "$scratch" || exit 1
mkdir -p action/build/bin
ln -s "$(realpath "$NORMA")" action/build/bin/norma

# The lines below the last "run: |", without their indent.
awk '/^      run: \|$/ { text = ""; inside = 1; next } inside { sub(/^        /, ""); text = text $0 "\n" } END { printf "%s", text }' "$root/action.yml" >step.sh
check "the step is found" grep -q 'sarif' step.sh

# run_step STATUS PATHS OPTIONS FAIL_ON [HTML]: in a folder of meshes, one of which cannot be read.
run_step() {
    local wanted=$1 status=0
    rm -rf work && mkdir -p work/models && cd work || return
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >models/good.obj
    printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n' >models/zero.obj
    printf 'f 1 2 7\n' >models/broken.obj
    cp models/zero.obj 'models/with blank.obj'
    GITHUB_ACTION_PATH=$scratch/action PATHS=$2 OPTIONS=$3 FAIL_ON=$4 SARIF=norma.sarif HTML=${5:-} bash --noprofile --norc -eo pipefail ../step.sh >../said 2>&1 </dev/null || status=$?
    cd ..
    if [ "$status" -eq "$wanted" ]; then pass "status $wanted: paths '$2', options '$3', fail-on $4"; else fail "status $wanted: paths '$2', options '$3', fail-on $4" "status $status: $(cat said)"; fi
}
holds() { if grep -q -- "$2" "work/$1"; then pass "$1 has $2"; else fail "$1 has $2" "$(head -c 1000 "work/$1")"; fi; }

run_step 3 models '' error page.html
holds norma.sarif broken.obj
holds norma.sarif zero.obj
holds norma.sarif N102
holds page.html broken.obj
check "the last run tells what is wrong" grep -q '^models/with blank.obj: error N102 .* Also in models/zero.obj\. ' said
run_step 1 models/zero.obj '' error
check "no page where none is asked for" test ! -e work/page.html
run_step 0 models/good.obj '' error
run_step 0 models/zero.obj '' never
run_step 1 models/good.obj '' info
# Several lines: of paths, with blanks and patterns; of options.
run_step 1 $'models/good.obj\nmodels/with blank.obj\n' '' error
holds norma.sarif 'with%20blank\|with blank'
run_step 1 "models/ze*.obj" '' error
run_step 0 models/zero.obj $'--ignore N1\n--no-config\n\n--max-samples 2' error
run_step 0 models/zero.obj $'--no-config\n--select N3\n' error
# The step before it finds its script in a folder with blanks.
mkdir -p 'with blank/scripts' && printf '#!/bin/sh\necho "got $1 $2"\n' >'with blank/scripts/get-release.sh' && chmod +x 'with blank/scripts/get-release.sh'
sed -nE "s/^      run: '?(.*[^'])'?\$/\1/p" "$root/action.yml" | head -n 1 >get.sh
got=$(GITHUB_ACTION_PATH="$scratch/with blank" REPOSITORY=o/n TAG=v1 bash --noprofile --norc -eo pipefail get.sh 2>&1)
if [ "$got" = "got o/n v1" ]; then pass "the path of the action may have blanks"; else fail "the path of the action may have blanks" "$got"; fi

# The hooks of pre-commit, which runs the words of `entry` and then names of committed files: one that is called like an option is a file all the same.
ln -s "$scratch/action/build/bin" bin
mkdir -p repository outside
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n' >repository/good.obj
named="--write-baseline=$scratch/outside/notes.obj"
mkdir -p "repository/${named%/*}" && cp repository/good.obj "repository/$named"
sed -n 's/^  entry: //p' "$root/.pre-commit-hooks.yaml" >entries
while IFS= read -r entry; do
    printf 'mine\n' >outside/notes.obj
    status=0
    # shellcheck disable=SC2086  # words
    (cd repository && PATH=$scratch/bin:$PATH $entry good.obj "$named") >said 2>&1 </dev/null || status=$?
    if [ $status -eq 0 ] && [ "$(cat outside/notes.obj)" = mine ] && grep -q 'in 0 of 2 files' said; then
        pass "a file called like an option is checked: $entry"
    else
        fail "a file called like an option is checked: $entry" "status $status: $(cat said outside/notes.obj)"
    fi
done <entries
check "there are two hooks" test "$(wc -l <entries)" -eq 2

# The tool of a release, from a folder that stands for the releases: taken with the right checksum, refused with another.
release=norma-$(sed -nE 's/^#define NORMA_VERSION_(MAJOR|MINOR|PATCH) +([0-9]+).*/\2/p' "$root/include/norma/norma.h" | paste -sd.)-linux-$(uname -m)
mkdir -p got/scripts got/include/norma releases "made/$release/lib"
cp "$root/scripts/get-release.sh" got/scripts/
cp "$root/include/norma/norma.h" got/include/norma/
printf '#!/bin/sh\necho "norma of a release"\n' >"made/$release/norma"
chmod +x "made/$release/norma"
tar -czf "releases/$release.tar.gz" -C made "$release"
(cd releases && sha256sum -- *.gz >SHA256SUMS)
check "a release is taken" env NORMA_RELEASES="file://$scratch/releases" got/scripts/get-release.sh o/n v1
check "its tool runs" sh -c 'got/build/bin/norma | grep -q "of a release"'
rm -rf got/build
printf x >>"releases/$release.tar.gz"
check "one with another checksum is refused" sh -c '! NORMA_RELEASES="file://$1/releases" got/scripts/get-release.sh o/n v1 2>/dev/null && [ ! -e got/build ]' sh "$scratch"
check "so is one that is not there" sh -c '! NORMA_RELEASES="file://$1/none" got/scripts/get-release.sh o/n v1 2>/dev/null' sh "$scratch"
# What is misspelt is no success.
run_step 2 models/good.obj '--no-such-option' error
run_step 3 models/misspelt.obj '' error
run_step 3 $'models/good.obj\nmisspelt' '' error
finish
