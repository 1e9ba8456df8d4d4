# tables.awk: the tables of docs/speed.md from what make bench left in build/bench, as Markdown. Bold figures miss their target.
#   awk -v table=rivals|skins|core|dress|rest|real|files -f bench/tables.awk build/bench/FILE
function bold(text, verdict) { return verdict == "over" ? "**" text "**" : text }
function put(row, column, text) {
    if (!(row in seen)) { seen[row] = 1; rows[++count] = row }
    cell[row, column] = text
}
function print_rows(columns,    i, k, line) {
    for (i = 1; i <= count; i++) {
        line = "| " rows[i]
        for (k = 1; k <= columns; k++) line = line " | " cell[rows[i], k]
        print line " |"
    }
}
function named(call) { return call in name ? name[call] : call }
BEGIN {
    name["vertices-index-angle"] = "vertex normals, angle, by index"
    name["vertices-index-area"] = "vertex normals, area, by index"
    name["vertices-default"] = "vertex normals, angle, equal positions share"
    name["vertices-default-area"] = "vertex normals, area, equal positions share"
    name["corners-60"] = "corner normals, crease 60"
    name["split-60"] = "split, crease 60"
    name["index"] = "vertex normals, angle, by index"
    name["area"] = "vertex normals, area, by index"
    name["default"] = "vertex normals, angle, equal positions share"
    name["corners"] = "corner normals, crease 60"
    if (table == "rivals") { FS = "\t"; print "| library and call | weight | rows, ns | shuffled, ns | off, degrees |\n|---|---|---|---|---|" }
    if (table == "skins") { FS = "\t"; print "| library and call | ns a vertex | times a copy (target) |\n|---|---|---|" }
    if (table == "core") print "| | 1 thread, ns | times a copy (target) | 2 threads, ns | times a copy (target) |\n|---|---|---|---|---|"
    if (table == "dress") print "| | plain | quads (1.5) | 16-bit corners (1.25) | doubles (1.8) | AVX2 (1.3) |\n|---|---|---|---|---|---|"
    if (table == "rest") print "| | measured | target |\n|---|---|---|"
    if (table == "real") print "| mesh | triangles | by index | default | corners 60 | corners 60, 2 threads |\n|---|---|---|---|---|---|"
    if (table == "files") print "| | MB in | MB out | `cp` | 1 thread | 2 threads | target | memory ÷ input |\n|---|---|---|---|---|---|---|---|"
}
function of_skins() { return $2 ~ /skinned|blend/ }
table == "skins" && NF >= 8 && of_skins() { print "| " $1 ", " $2 " | " $6 " | " ($2 == "skinned normals" ? bold($7 "x", $7 > 4 ? "over" : "") " (4x)" : $7 "x") " |" }
table == "rivals" && NF >= 8 && !of_skins() {
    row = $1 ", " $2 " | " ($3 == "-" ? "" : $3)
    put(row, $4 == "shuffled" ? 2 : 1, $6)
    if ($8 != "-") put(row, 3, $8)
}
table == "core" && $4 ~ /^threads?$/ && $2 ~ /^(rows|shuffled)$/ {
    column = 2 * $3 - 1
    put(named($1) "; " $2, column, $5)
    put(named($1) "; " $2, column + 1, $8 == "asked" ? bold($7, $10) " (" $9 ")" : $7)
}
table == "dress" && $1 ~ /^dress-/ {
    dress["plain"] = 1; dress["quads"] = 2; dress["16-bit"] = 3; dress["doubles"] = 4; dress["avx2"] = 5
    put(named(substr($1, 7)), dress[$2], $2 == "plain" ? $3 : $3 " (" bold($5, $NF) ")")
}
table == "rest" && $1 ~ /^small-/ { print "| 160 triangles, " substr($1, 7) ", " $2 " | " bold($5 " µs", $NF) " | " ($0 ~ /asked/ ? $(NF - 2) " µs" : "") " |" }
table == "rest" && /of memcpy/ {
    label = $0; sub(/ +[0-9.]+ ns each.*/, "", label)
    match($0, /[0-9.]+ of memcpy/)
    print "| " label " | " bold(substr($0, RSTART, RLENGTH - 10) " copies", $NF) " | " $(NF - 1) " |"
}
table == "rest" && /^plans/ { plan = $6 }
table == "rest" && /^(rows|shuffled)$/ { shape = $1 }
table == "rest" && /all moved/ && $NF ~ /x\)$/ { # in multiples of a copy
    target = substr($NF, 1, length($NF) - 1)
    print "| plan of " plan ", " shape ", all moved, " $3 " " $4 " | " bold($7, $7 + 0 > target + 0 ? "over" : "") " | " target " |"
    next
}
table == "rest" && /all moved/ { print "| plan of " plan ", " shape ", all moved, " $3 " " $4 " | " bold($(NF - 4) " " $(NF - 3), $(NF - 4) + 0 > $(NF - 1) + 0 ? "over" : "") " | " $(NF - 1) " " substr($NF, 1, length($NF) - 1) " |" }
table == "rest" && /neighbours moved/ { print "| plan of " plan ", " $1 " neighbours moved | " (plan < 1000000 ? bold($4 " µs", $4 > 30 ? "over" : "") " | 30 µs |" : $4 " µs | |") }
table == "real" && /\|/ && $2 ~ /^[0-9]+$/ { print "| " $1 " | " $2 " | " $4 " | " $8 " | " $12 " | " $13 " |" }
table == "files" && NF > 12 && $(NF - 11) ~ /^[0-9.]+$/ {
    label = substr($0, 1, 26); sub(/ +$/, "", label)
    target = $(NF - 5); best = $(NF - 8) < $(NF - 7) ? $(NF - 8) : $(NF - 7)
    print "| " label " | " $(NF - 11) " | " $(NF - 10) " | " $(NF - 9) " | " $(NF - 8) " | " bold($(NF - 7), best + 0 > target + 0 ? "over" : "") " | " target " | " $(NF - 2) " |"
}
table == "files" && /\(must: / {
    label = substr($0, 1, 26); sub(/ +$/, "", label)
    value = substr($0, 27) + 0; target = $NF + 0
    print "| " label " | | | | | " bold(value, value > target ? "over" : "") " | " target " | |"
}
END { if (count) print_rows(table == "rivals" ? 3 : table == "core" ? 4 : 5) }
