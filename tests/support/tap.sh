# shellcheck shell=bash
# Sourced by the tests that are scripts: each check prints one TAP line ("ok", "not ok", "# SKIP"), which run.sh counts. run.sh sets
# NORMA_TREE (the build tree under test) and NORMA_SCRATCH (an empty folder); by hand, the defaults are build/test/gcc and a new temporary one.
set -u
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
# shellcheck disable=SC2034  # for those who source this
tree=${NORMA_TREE:-$root/build/test/gcc}
if [ -n "${NORMA_SCRATCH:-}" ]; then
    scratch=$NORMA_SCRATCH
else
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
fi
tap_number=0
tap_failed=0

pass() { tap_number=$((tap_number + 1)); echo "ok $tap_number - $1"; }
fail() { tap_number=$((tap_number + 1)); tap_failed=$((tap_failed + 1)); echo "not ok $tap_number - $1"; [ $# -lt 2 ] || printf '%s\n' "$2" | head -n 40 | sed 's/^/# /'; }
skip() { tap_number=$((tap_number + 1)); echo "ok $tap_number # SKIP $1"; }

# check NAME COMMAND...: passes when the command succeeds; its output is shown when it does not.
check() {
    local name=$1 output
    shift
    if output=$("$@" 2>&1); then pass "$name"; else fail "$name" "$output"; fi
}

# relay NAME COMMAND...: the checks of a program that prints TAP, under our numbers; fails too where it did not run to its end. relayed: how many there were.
relay() {
    local name=$1 output line status=0
    shift
    relayed=0
    output=$("$@" 2>"$scratch/relay.err") || status=$?
    while IFS= read -r line; do
        case $line in
        "ok "*"# SKIP "*) skip "$name: ${line#*# SKIP }" ;;
        "ok "*) pass "$name: ${line#* - }" ;;
        "not ok "*) fail "$name: ${line#* - }" ;;
        "# "*) echo "$line"; continue ;;
        *) continue ;;
        esac
        relayed=$((relayed + 1))
    done <<<"$output"
    if ! grep -qx "1\.\.$relayed" <<<"$output" || { [ "$status" -ne 0 ] && ! grep -q '^not ok' <<<"$output"; }; then
        fail "$name ran to its end" "exit status $status after $relayed cases: $(cat "$scratch/relay.err")"
    fi
}

# The last call of each script.
finish() {
    echo "1..$tap_number"
    if [ "$tap_number" -eq 0 ]; then
        echo "not ok 1 - nothing was checked"
    fi
    [ "$tap_failed" -eq 0 ] && [ "$tap_number" -gt 0 ]
}
