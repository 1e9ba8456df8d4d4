#!/bin/bash
# The Python wheel: built, installed into a bare virtual environment (numpy is the system's), its types checked, its doctests, tests and examples run. Cases are unittest's.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
python=${PYTHON:-/usr/bin/python3}
[ -x "$python" ] || python=python3
if ! "$python" -c 'import numpy, setuptools, wheel, venv, sysconfig, os; assert os.path.exists(sysconfig.get_path("include") + "/Python.h")' 2>/dev/null; then
    skip "the Python wheel: python3-dev, numpy, setuptools, wheel or venv is not installed"
    finish
    exit
fi

if ! wheel=$(PYTHON=$python scripts/python.sh 2>"$scratch/build.err" | tail -n 1); then
    fail "the wheel is built" "$(cat "$scratch/build.err")"
    finish
    exit 1
fi
pass "the wheel is built"
check "it is for every Python from 3.9 on" grep -q 'cp39-abi3' <<<"$wheel"
check "it is of 2 MB at most" test "$(stat -c %s "$wheel")" -le 2000000
# What the extension and the library are linked with: the C library, and what lies beside them.
"$python" -m zipfile -e "$wheel" "$scratch/unpacked"
needed=$(readelf -d "$scratch/unpacked/norma_mesh/_norma.abi3.so" "$scratch"/unpacked/norma_mesh/lib/libnorma.so.* | sed -nE 's/.*\(NEEDED\).*\[([^]]+)\].*/\1/p')
others=$(grep -vE '^lib(c|m|pthread|norma|meshoptimizer|png16|jpeg|z)\.so' <<<"$needed")
if [ -n "$needed" ] && [ -z "$others" ]; then pass "it needs the C library and what it carries"; else fail "it needs the C library and what it carries" "${others:-nothing was read}"; fi

bare=$scratch/bare
"$python" -m venv --system-site-packages "$bare" && "$bare/bin/python" -m pip install --quiet --no-index --no-deps --no-warn-conflicts "$wheel" 2>"$scratch/pip.err"
check "pip installs it into a bare environment" "$bare/bin/python" -c 'import norma_mesh, sys; sys.exit("'"$bare"'" not in norma_mesh.__file__)'
check "norma is on the path" "$bare/bin/norma" --version
if command -v mypy >/dev/null; then
    check "its types pass mypy in strict mode" mypy --strict --cache-dir "$scratch/mypy" --python-executable "$bare/bin/python" python/norma_mesh
    check "its types are those that users expect" mypy --strict --cache-dir "$scratch/mypy" --python-executable "$bare/bin/python" tests/python/typed.py
else
    skip "mypy is not installed"
fi

# unittests FILE: each of its cases is a case here.
unittests() {
    local name
    name=$(basename "$1" .py)
    "$bare/bin/python" "$1" -v >"$scratch/$name.out" 2>&1
    while IFS= read -r line; do
        case $line in
        *" ... ok") pass "$name: ${line%% (*}" ;;
        *" ... skipped "*) skip "$name: ${line%% (*}: ${line##*skipped }" ;;
        *" ... FAIL" | *" ... ERROR") fail "$name: ${line%% (*}" "$(tail -n 60 "$scratch/$name.out")" ;;
        esac
    done < <(grep -E ' \.\.\. (ok|FAIL|ERROR|skipped)' "$scratch/$name.out")
    grep -qE '^OK' "$scratch/$name.out" || fail "$name ends well" "$(tail -n 40 "$scratch/$name.out")"
}
for file in tests/python/test_*.py; do unittests "$file"; done
for module in _calls _files _check _write _surfaces; do
    check "the examples in $module's documentation say what they print" "$bare/bin/python" -c "import doctest, sys, norma_mesh.$module as m; r = doctest.testmod(m); sys.exit(bool(r.failed) or not r.attempted)"
done
check "random arguments are served or refused" "$bare/bin/python" -W ignore tests/python/fuzz_arguments.py 5
# The Blender add-on is made of this wheel; what of it needs Blender is tested by make blender.
if zip=$(scripts/blender.sh 2>"$scratch/addon.err" | tail -n 1) && [ -e "$zip" ]; then
    pass "the Blender add-on is built"
    check "the add-on is smaller than the wheel: it leaves the tool out" test "$(stat -c %s "$zip")" -lt "$(stat -c %s "$wheel")"
    for part in pure versions; do
        if "$python" "tests/blender/test_$part.py" "$zip" -v >"$scratch/$part.out" 2>&1; then pass "the add-on without Blender: $part"; else fail "the add-on without Blender: $part" "$(tail -n 40 "$scratch/$part.out")"; fi
    done
else
    fail "the Blender add-on is built" "$(cat "$scratch/addon.err")"
fi
skip "the Blender add-on in Blender: make blender"
finish
