#!/bin/bash
# Runs every example and compares what it prints with tests/repo/examples/NAME.txt; the guide's normal-matrix.svg and covector.svg are what figure_svg and covector_svg draw.
#   tests/repo/examples.sh --refresh     writes the expected output anew
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
refresh=${1:-}

for source_file in examples/*.c; do
    name=$(basename "$source_file" .c)
    program=$tree/examples/$name
    arguments=()
    expected=tests/repo/examples/$name.txt
    case $name in
    file_roundtrip) arguments=(assets/goathead.obj "$scratch/goathead.obj") ;;
    figure_svg) expected=docs/figures/normal-matrix.svg ;;
    covector_svg) expected=docs/figures/covector.svg ;;
    esac
    if ! "$program" "${arguments[@]}" >"$scratch/$name.out" 2>"$scratch/$name.err"; then
        fail "$name runs" "$(cat "$scratch/$name.err")"
        continue
    fi
    [ "$refresh" != --refresh ] || cp "$scratch/$name.out" "$expected"
    if difference=$(diff "$expected" "$scratch/$name.out" 2>&1); then pass "$name prints what $expected holds"; else fail "$name prints what $expected holds" "$difference"; fi
    check "$name is of a page (at most 120 lines, the figure 180)" test "$(wc -l <"$source_file")" -le "$([ "$name" = figure_svg ] && echo 180 || echo 120)"
done
finish
