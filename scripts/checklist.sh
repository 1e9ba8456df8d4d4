#!/bin/bash
# Everything that a new weight, rule, format or verb is named in. With a name it says which of these places have it, and fails if one has not; alone, it goes through all names
# that are there (tests/repo/checklist.sh): so the lists stay true.
#   scripts/checklist.sh weight angle-lengths
#   scripts/checklist.sh rule N206
#   scripts/checklist.sh format ply
#   scripts/checklist.sh verb tangents
#   scripts/checklist.sh
set -u
cd "$(dirname "$0")/.." || exit 1

# PLACE | PATTERN (extended regular expression; NAME as given, UPPER with capitals and underscores) | what belongs there
list() {
    case $1 in
    weight) cat <<'LIST' ;;
include/norma/norma.h | NORMA_WEIGHT_UPPER\b | the constant, its formula and source
src/core/call/call.h | "NAME" | the row of the table: the code follows from it
src/cli/text | \bNAME\b | the message
src/cli/compute | \bNAME\b | the help of norma compute
src/cli/tangents | \bNAME\b | the help of norma tangents
src/mpi/tool | \bNAME\b | the help of norma-mpi
tests/support/oracle | NORMA_WEIGHT_UPPER\b | the formula once more, in exact arithmetic
tests/unit/core/test_arguments.c | "NAME" | the list of names
tests/web/bits.mjs | "NAME" | the same hashes by WebAssembly
docs/man/norma-compute.1 | \bNAME\b | the manual of the tool
docs/man/norma_options.3 | UPPER\b | the manual of the library
completions/_norma | \bNAME\b | completion: zsh
completions/norma.bash | \bNAME\b | completion: bash
completions/norma.fish | \bNAME\b | completion: fish
web/package/arguments.js | "?NAME"?\b | the npm package's arguments
web/package/check.js | "?NAME"?\b | the npm package's files
web/package/index.d.ts | "NAME" | its types
web/page/engine.js | NAME | the page's computations
web/page/index.html | NAME | the page's menu
python/norma_mesh | \bNAME\b | the Python package
blender/norma_normals | NAME | the Blender add-on's menu
LIST
    rule) cat <<'LIST' ;;
src/check/findings/rules.def | RULE\(NAME, | id, name, severities, fix and texts
src/check/rules src/check/run src/io | \bRULE_NAME\b | the code that finds it
src/cli/text/rule_pictures.def | \bNAME\b | a picture of wrong and one of right
docs/checking.md | ^. NAME | the table (tests/repo/readme.sh --refresh)
include/norma/check.h docs/man/norma-check.1 tests/unit/check tests/unit/io tests/cli | NAME | a test, or the manual
LIST
    format) cat <<'LIST' ;;
include/norma/document.h | NORMA_FILE_UPPER\b | the constant
src/io/document | NORMA_FILE_UPPER\b | the case in format_functions_of
src/io/format | "NAME" | its name, which is its extension
tests/repo/rooms.txt | io/ | its folder
src/cli/check src/cli/files src/cli/options | \bNAME\b | help texts
docs/man/norma-check.1 | \b(NAME|UPPER)\b | the manual of the tool
docs/man/norma_document.3 | UPPER|glTF | the manual of the library
completions/_norma | \bNAME\b | completion: zsh
completions/norma.bash | \bNAME\b | completion: bash
completions/norma.fish | \bNAME\b | completion: fish
web/page | \bNAME\b | the page's file picker
tests/fuzz | NAME | a fuzz target
assets tests/cli/golden/files | FILE | a small file
README.md | UPPER|glTF | the first sentence
LIST
    verb) cat <<'LIST' ;;
src/cli/main.c | cli_subcommand_NAME\b | the table of commands
src/cli | cli_subcommand_NAME = | options, help and report
docs/man/norma-NAME.1 | Nm norma.NAME | its manual page
docs/man/norma.1 | norma-NAME | the list of commands
completions/_norma | \bNAME\b | completion: zsh
completions/norma.bash | \bNAME\b | completion: bash
completions/norma.fish | \bNAME\b | completion: fish
tests/cli | norma.?.? NAME | golden cases, or a test of its own
README.md | norma NAME | the table of commands
LIST
    *) return 1 ;;
    esac
}

names() {
    case $1 in
    weight) sed -nE 's/^ *W\([A-Z_]+, "([a-z-]+)".*/\1/p' src/core/call/call.h ;;
    rule) sed -nE 's/^RULE\((N[0-9]+),.*/\1/p' src/check/findings/rules.def ;;
    format) printf '%s\n' obj ply stl gltf glb ;;
    verb) grep -oE 'cli_subcommand_[a-z]+' src/cli/main.c | sed 's/cli_subcommand_//' | sort -u ;;
    esac | grep .
}

# look KIND NAME: a line for each place.
look() {
    local kind=$1 name=$2 upper missing=0 places pattern words
    upper=$(tr 'a-z-' 'A-Z_' <<<"$name")
    while IFS='|' read -r places pattern words; do
        # the last | separates; those before belong to the pattern
        while [[ $words == *'|'* ]]; do pattern+="|${words%%|*}" words=${words#*|}; done
        pattern=$(sed 's/^ *//; s/ *$//' <<<"$pattern")
        pattern=${pattern//NAME/$name} pattern=${pattern//UPPER/$upper} places=${places//NAME/$name}
        # shellcheck disable=SC2086  # a list of places
        if if [ "$pattern" = FILE ]; then [ -n "$(find $places -name "*.$name" | head -n 1)" ]; else grep -rqE -- "$pattern" $places 2>/dev/null; fi; then
            [ -n "${QUIET:-}" ] || printf 'ok       %-44s%s\n' "$(echo $places)" "$words"
        else
            printf 'MISSING  %-44s%s (%s %s)\n' "$(echo $places)" "$words" "$kind" "$name"
            missing=1
        fi
    done < <(list "$kind")
    return $missing
}

if [ $# -eq 2 ] && list "$1" >/dev/null; then
    look "$1" "$2"
elif [ $# -eq 0 ]; then
    status=0
    for kind in weight rule format verb; do
        for name in $(names $kind); do QUIET=1 look $kind "$name" || status=1; done
    done
    exit $status
else
    sed -n '2,8s/^# \{0,1\}//p' "$0"
    exit 2
fi
