#!/bin/bash
# Small files that say they are large, deep, endless or elsewhere (tests/cli/hostile_files.c): the tool computes normals for each, and its exit status and message are those of
# tests/cli/golden/hostile.txt; what it refuses leaves no output. Each has 256 MiB (--max-memory) and two seconds.
#   tests/cli/hostile.sh             compares; TAP on standard output
#   tests/cli/hostile.sh --refresh   writes what the tool says now into the table (read the difference before you commit it)
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
NORMA=${NORMA_BIN:-$tree/bin/norma}
golden=$root/tests/cli/golden/hostile.txt
files=$scratch/files
mkdir -p "$files/below" "$scratch/out"
cd "$scratch" || exit 1
"$tree/tests/hostile_files" files || { fail "the files are made"; finish; exit 1; }
cp files/inside.bin files/below/inside.bin
cp files/inside.bin outside.bin
ln -s inside.bin files/link-inside.bin
ln -s ../outside.bin files/link-outside.bin
ln -s .. files/linked
ln -s /dev/zero files/zero

# answer FILE: "STATUS MESSAGE", the message without the file's name in front; of what was done only that it was.
answer() {
    local status=0 said
    rm -rf out/*
    said=$(timeout -k 1 20 "$NORMA" compute --max-memory 256M --threads 2 "files/$1" -o "out/$1" 2>&1 >/dev/null) || status=$?
    [ "$status" -eq 0 ] || [ -z "$(ls -A out)" ] || said="$said (and something was written: $(ls -A out))"
    said=${said#"norma: "}
    printf '%s %s' "$status" "$(printf '%s' "${said//"files/$1"/FILE}" | tr '\n' '|')"
}

# Where the sanitizers slow the tool, or count as memory, only the messages are compared.
now=$scratch/hostile.txt
: >"$now"
slow=""
# What all commands so far have taken of the processor, in milliseconds: a busy machine makes none slower.
count_time() {
    times >"$scratch/times"
    spent=$(awk 'NR == 2 { split($1, used, /[ms]/); split($2, asked, /[ms]/); print int(60000 * (used[1] + asked[1]) + 1000 * (used[2] + asked[2])) }' "$scratch/times")
}
for file in files/*.obj files/*.ply files/*.stl files/*.gltf files/*.glb; do
    file=${file#files/}
    count_time
    began=$spent
    printf '%s\t%s\n' "$file" "$(answer "$file")" >>"$now"
    count_time
    took=$((spent - began))
    [ $took -lt 2000 ] || slow="$slow $file ($took milliseconds)"
done
if [ "${1:-}" = --refresh ]; then
    cp "$now" "$golden"
    exit 0
fi
while IFS=$'\t' read -r file said; do
    expected=$(awk -F '\t' -v file="$file" '$1 == file { print $2 }' "$golden")
    if [ "$said" = "$expected" ]; then pass "$file: $said"; else fail "$file" "said:     $said"$'\n'"expected: $expected"; fi
done <"$now"
if [ "$(wc -l <"$golden")" -eq "$(wc -l <"$now")" ]; then pass "as many files as the table has"; else fail "as many files as the table has"; fi
# The other verbs end as soon with what is large in little.
for file in polygon-of-{300000-corners,upright-teeth}.obj nodes-50000-deep.gltf nested-objects-1000000.gltf many-primitives-of-one-accessor.gltf many-{targets,instances}-of-one-accessor.gltf many-keys-over-many-joints.gltf \
    many-skins.gltf many-primitives-of-one-position.gltf many-nodes-of-one-mesh.gltf many-drawn-meshes.gltf many-attributes.gltf; do
    for verb in check info "transform --scale 2 -o out/$file" "transform --scale 2 --bake -o out/$file" "compute --together --out-dir out/together" "tangents -o out/$file"; do
        [[ $file == *.gltf || ! $verb =~ --bake|--together|tangents ]] || continue
        # shellcheck disable=SC2086  # words
        if (ulimit -t 4; "$NORMA" $verb --max-memory 256M "files/$file" >/dev/null 2>&1; [ $? -le 3 ]); then pass "$verb: $file"; else fail "$verb: $file takes more than four seconds, or ends badly"; fi
    done
done
# --max-memory: what needs more is refused, whatever the verb, and nothing is written; what does not is done as ever.
cp "$root/assets/goathead.obj" goat.obj
for verb in "compute goat.obj -o out/goat.obj" "transform goat.obj --scale 2 -o out/goat.obj" "compute goat.obj -o -" "check goat.obj --fix-unsafe -o out/goat.obj" "info goat.obj"; do
    status=0
    rm -rf out/*
    # shellcheck disable=SC2086  # words
    said=$("$NORMA" $verb --max-memory 1M --threads 2 2>&1 >printed) || status=$?
    said="$said $(grep -o 'out of memory' printed | head -1)"
    if [ "$status" -eq 3 ] && [[ $said == *"out of memory"* ]] && [ -z "$(ls -A out)" ] && [ "$(stat -c %s printed)" -lt 1000 ]; then
        pass "--max-memory 1M: $verb is refused"
    else
        fail "--max-memory 1M: $verb is refused" "status $status: $said; $(ls -A out)"
    fi
done
"$NORMA" compute goat.obj -o out/free.obj >/dev/null
check "--max-memory 64M is enough, with four threads" "$NORMA" compute goat.obj -o out/limited.obj --max-memory 64M --threads 4
check "the same bytes" cmp out/free.obj out/limited.obj
if [ -z "$slow" ]; then pass "none takes two seconds"; else fail "none takes two seconds" "$slow"; fi
finish
