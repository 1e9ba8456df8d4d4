#!/bin/bash
# Names that two or more files of src define as static (functions, tables, variables; CORE_INLINE is static): one a line, with the files. A name found in a profile or by grep
# should be one place, and a unity build should be possible.
#   scripts/static-names.sh [FOLDER]
cd "${1:-$(dirname "$0")/../src}" || exit 1
find . -name '*.[ch]' -printf '%P\n' | LC_ALL=C sort | xargs awk '
    # Declarations may run over several lines: up to the first { ; or =.
    # The name of a table of an unnamed struct comes after its members.
    /^} / && unnamed { $0 = "static " substr($0, 3) }
    /^}/ { unnamed = 0 }
    /^(static|CORE_INLINE)[ \t]/ { text = ""; open = 1 }
    open {
        text = text " " $0
        if (text ~ /[{;=]/) {
            open = 0
            declared = text ~ /^[^{=]*\)[^{=(]*;/ # a prototype
            sub(/[{;=].*/, "", text)
            sub(/__attribute__ *\(\([^)]*\)*\)+/, "", text)
            if (declared) next
            # a function: the name before its first parenthesis; else the last name, sizes aside
            if (text ~ /\(/) sub(/\(.*/, "", text); else { gsub(/\[[^]]*\]/, "", text); sub(/,.*/, "", text) }
            sub(/[ \t]+$/, "", text); sub(/.*[^A-Za-z0-9_]/, "", text)
            if (text == "struct") { unnamed = 1; next }
            if (text != "" && !seen[text, FILENAME]++) { files[text] = files[text] " " FILENAME; count[text]++ }
        }
    }
    END { for (name in count) if (count[name] > 1) print name ":" files[name] }' | LC_ALL=C sort
