#!/bin/bash
# The tables of docs/speed.md from the last make bench (build/bench): each stands between <!-- bench: TABLE FILES... --> and <!-- end -->.
#   bench/tables.sh [FOLDER]        build/bench
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
folder=${1:-$root/build/bench}
page=$root/docs/speed.md
new=$(mktemp)
inside=""
while IFS= read -r line; do
    [ "$line" != "<!-- end -->" ] || inside=""
    [ -n "$inside" ] || printf '%s\n' "$line"
    [[ $line =~ ^"<!-- bench: "([a-z]+)" "(.*)" -->"$ ]] || continue
    table=${BASH_REMATCH[1]}
    read -ra files <<<"${BASH_REMATCH[2]}"
    (cd "$folder" && ls "${files[@]}") >/dev/null 2>&1 || continue # not measured: the table stays
    inside=1
    if [ "$table" = about ]; then
        head -1 "$folder/${files[0]}"
    else
        awk -v table="$table" -f "$root/bench/tables.awk" "${files[@]/#/$folder/}"
    fi
done <"$page" >"$new"
cat "$new" >"$page"
rm -f "$new"
