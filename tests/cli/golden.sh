#!/bin/bash
# The command line, word for word: each case of tests/cli/golden/*.case is a command with its exact standard output, standard error and exit status.
#   tests/cli/golden.sh                  compares; TAP on standard output
#   tests/cli/golden.sh --refresh        writes what the tool says now into the cases (read the difference before you commit it)
#   tests/cli/golden.sh [--refresh] matrix.case ...   some of them
# The tool is $NORMA_BIN (build/test/gcc/bin/norma). A case file runs top-down in a folder of its own that holds tests/cli/golden/files, and assets. Its lines:
#   # words              a comment
#   $ command            run by bash, where `norma` is the tool
#   > words              a line of its standard output        ("\ " at the end: without a line's end)
#   ! words              a line of its standard error
#   = 2                  its exit status, where that is not 0
# For a tool under another name (npx norma-mesh): NORMA_SAYS, what its commands call it, and NORMA_LEFT_OUT, a regular expression of the commands that it cannot run.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cases=$root/tests/cli/golden
NORMA=${NORMA_BIN:-$tree/bin/norma}
export NORMA LC_ALL=C.UTF-8
refresh=0
[ "${1:-}" != --refresh ] || { refresh=1; shift; }
[ -x "$NORMA" ] || { fail "the tool is there" "no program at $NORMA"; finish; exit 1; }

# prefixed MARK FILE: its lines with the mark in front.
prefixed() {
    [ -s "$2" ] || return 0
    sed "s/^/$1 /" "$2"
    [ -z "$(tail -c 1 "$2" | tr -d '\n')" ] || printf '\\ \n'
}

# answer COMMAND: what the command says now, as a case file has it. In the folder at hand.
answer() {
    local status=0
    (
        # shellcheck disable=SC2317  # called by the commands of the cases
        norma() { "$NORMA" "$@"; }
        export -f norma
        bash -c "$1"
    ) >"$scratch/stdout" 2>"$scratch/stderr" </dev/null 3<&- || status=$?
    [ -z "${NORMA_SAYS:-}" ] || sed -i "s/$NORMA_SAYS /norma /g" "$scratch/stdout" "$scratch/stderr"
    printf '$ %s\n' "$1"
    prefixed '>' "$scratch/stdout"
    prefixed '!' "$scratch/stderr"
    [ "$status" -eq 0 ] || echo "= $status"
}

run_case() {
    local file=$1 name folder line command expected now number=0
    name=$(basename "$file" .case)
    folder=$scratch/$name
    rm -rf "$folder"
    cp -r "$cases/files" "$folder" && chmod -R u+w "$folder" && ln -s "$root/assets" "$folder/assets" && cd "$folder" || return
    : >"$scratch/refreshed"
    exec 3<"$file"
    line="" command=""
    while IFS= read -r line <&3 || [ -n "$line" ]; do
        case $line in
        '$ '*) [ -z "$command" ] || settle; command=${line#'$ '} expected=$line$'\n' ;;
        '> '* | '! '* | '= '* | '\ ' | '>' | '!') expected+=$line$'\n' ;;
        *) [ -z "$command" ] || settle; printf '%s\n' "$line" >>"$scratch/refreshed" ;;
        esac
    done
    [ -z "$command" ] || settle
    exec 3<&-
    cd "$root" || exit 1
    [ $refresh -eq 0 ] || cmp -s "$scratch/refreshed" "$file" || { cp "$scratch/refreshed" "$file"; echo "# refreshed $name"; }
}

# Runs the command read last and compares it, or writes it down. Shares the variables of run_case.
# The address sanitizer takes address space for itself, far beyond what --max-memory allows here.
sanitized=$(grep -qa __asan_init "$NORMA" && echo yes)

settle() {
    number=$((number + 1))
    if [ -n "$sanitized" ] && [[ $command =~ --max-memory\ (1M|1024K) ]]; then
        skip "$name $number: $command (the tool is built with the address sanitizer)"
        command=""
        return
    fi
    if [ -n "${NORMA_LEFT_OUT:-}" ] && [[ $command =~ $NORMA_LEFT_OUT ]]; then
        skip "$name $number: $command (left out)"
        command=""
        return
    fi
    now=$(answer "$command"; echo .)
    now=${now%.}
    printf '%s' "$now" >>"$scratch/refreshed"
    if [ "$now" = "$expected" ] || [ $refresh -eq 1 ]; then
        pass "$name $number: $command"
    else
        fail "$name $number: $command" "$(diff -u --label expected --label now <(printf '%s' "$expected") <(printf '%s' "$now"))"
    fi
    command=""
}

if [ $# -gt 0 ]; then
    for file in "$@"; do run_case "$cases/$(basename "$file")"; done
else
    for file in "$cases"/*.case; do run_case "$file"; done
fi
finish
