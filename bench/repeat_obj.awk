# repeat_obj.awk: copies of an OBJ beside one another, each with vertices of its own, up to so many
# bytes: a large file as modelling tools write them. awk -v bytes=30000000 -f repeat_obj.awk IN >OUT
{
    line[NR] = $0
    size += length($0) + 1
    if ($1 == "v") {
        v++
        if ($2 > most) most = $2
        if ($2 < least) least = $2
    } else if ($1 == "vt") t++
    else if ($1 == "vn") n++
}
function renumbered(corner, copy,    number, parts) {
    parts = split(corner, number, "/")
    corner = number[1] + copy * v
    if (parts > 1) corner = corner "/" (number[2] == "" ? "" : number[2] + copy * t)
    if (parts > 2) corner = corner "/" (number[3] == "" ? "" : number[3] + copy * n)
    return corner
}
END {
    step = int(1.1 * (most - least)) + 1
    for (copy = 0; copy * size < bytes; copy++)
        for (i = 1; i <= NR; i++) {
            count = split(line[i], field, " ")
            if (field[1] == "v") {
                digits = length(field[2]) - index(field[2], ".")
                printf "v %.*f %s %s\n", digits, field[2] + step * copy, field[3], field[4]
            } else if (field[1] == "f") {
                out = "f"
                for (c = 2; c <= count; c++) out = out " " renumbered(field[c], copy)
                print out
            } else {
                print(field[1] ~ /^[go]$/ ? line[i] "." copy : line[i])
            }
        }
}
