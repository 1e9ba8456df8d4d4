#!/bin/bash
# norma seams: tiles of one surface get the bits of one --together, whatever the jobs; a votes file that is lost, damaged, repeated or of another surface is refused by name.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
cd "$scratch" || exit 1
if ! command -v python3 >/dev/null; then
    skip "python3 is missing"
    finish
    exit
fi

# refuse NAME TEXT OUTPUT COMMAND...: status 3, a text in what it says, and no output.
refuse() {
    local name=$1 text=$2 output=$3 status=0
    shift 3
    "$@" >said 2>&1 || status=$?
    if [ $status = 3 ] && grep -qE -- "$text" said && [ ! -e "$output" ]; then pass "$name"; else fail "$name" "status $status: $(cat said)"; fi
}
# same_files A B: two folders hold the same files.
same_files() { diff -rq "$1" "$2"; }

# ---- 256 tiles, a job for each, joined by a tree in any order
python3 "$root/tests/cli/seams_tiles.py" tiles 16 8 tiles
"$norma" compute tiles --together --out-dir together --quiet
"$norma" compute tiles --smooth --out-dir alone --quiet
mkdir votes
for tile in tiles/*.ply; do "$norma" seams votes "$tile" -o "votes/$(basename "$tile" .ply).votes" --quiet; done
check "the seams count: tiles computed alone differ" bash -c '! diff -rq together alone >/dev/null'
ls votes/*.votes | sort -R >order
split -n l/7 order part.
for part in part.*; do xargs "$norma" seams merge -o "$part.votes" --quiet <"$part"; done
"$norma" seams merge part.a[a-c].votes -o left.votes --quiet
"$norma" seams merge part.a[d-g].votes left.votes -o all.votes --quiet
"$norma" seams apply tiles --votes all.votes --out-dir seams --quiet
check "256 tiles: the bits of one --together" same_files together seams
"$norma" seams merge votes/*.votes -o flat.votes --quiet --tiles 256
check "any tree of merges gives the same file" cmp all.votes flat.votes
"$norma" seams votes tiles -o whole.votes --quiet
check "and so do votes of all tiles at once" cmp all.votes whole.votes
mkdir one
(cd tiles && "$norma" seams apply t003-009.ply --votes ../all.votes -o ../one/t003-009.ply --quiet)
check "a tile by itself, under another path" cmp one/t003-009.ply together/t003-009.ply
cp all.votes inputs.votes
check "a merge may not overwrite what it reads" bash -c "! '$norma' seams merge inputs.votes -o inputs.votes 2>said && grep -q 'inputs.votes' said && cmp all.votes inputs.votes"

# ---- weights, and faces dealt at random
make() { python3 "$root/tests/cli/together_meshes.py" "$@"; }
make cut 5 2 deal
for weight in area uniform max angle-area angle-lengths; do
    "$norma" compute deal?.ply --together --weight $weight --out-dir "by-$weight" --quiet
    "$norma" seams votes deal?.ply --weight $weight -o "$weight.votes" --quiet
    "$norma" seams apply deal?.ply --votes "$weight.votes" --out-dir "seams-$weight" --quiet
    check "weight $weight" same_files "by-$weight" "seams-$weight"
done
check "the summary names the weight of the votes" bash -c "'$norma' seams apply deal0.ply --votes area.votes -o area.ply --json | grep -q '\"weight\": \"area\"'"
refuse "votes by different weights" "max.votes: cannot be merged with area.votes: has another weight" no.votes "$norma" seams merge area.votes max.votes -o no.votes

# ---- a glTF of two nodes, one mirrored and stretched, and a PLY that lies on it
make halves halves
"$norma" compute halves.glb --together -o halves-one.glb --quiet
"$norma" seams votes halves.glb -o halves.votes --quiet
"$norma" seams apply halves.glb --votes halves.votes -o halves-two.glb --quiet
check "nodes of one glTF" cmp halves-one.glb halves-two.glb
"$norma" compute halves.glb deal0.ply --together --out-dir mixed-one --quiet
"$norma" seams votes deal0.ply -o deal0.votes --quiet
refuse "rounded positions and others" "rounded to floats" no.votes "$norma" seams merge halves.votes deal0.votes -o no.votes
"$norma" seams votes deal0.ply --rounded --everywhere -o deal0.votes --quiet
"$norma" seams votes halves.glb --everywhere -o halves.votes --quiet
"$norma" seams merge halves.votes deal0.votes -o mixed.votes --quiet
"$norma" seams apply halves.glb deal0.ply --votes mixed.votes --out-dir mixed-two --quiet
check "a glTF and a PLY, rounded" same_files mixed-one mixed-two

# ---- tiles that touch elsewhere than at borders
python3 - <<'END'
def write(name, points, faces):
    with open(name, "w") as out:
        out.write("".join("v %g %g %g\n" % p for p in points) + "".join("f %s\n" % " ".join(str(i + 1) for i in f) for f in faces))
fan = [(0, 0, 0), (2, 0, 1), (0, 2, 1), (-2, 0, 1), (0, -2, 1)]
write("cone.obj", fan, [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 1)])
write("flag.obj", [(0, 0, 0), (1, 0, -2), (1, 1, -2)], [(0, 1, 2)])
write("down.obj", [(x, y, -3 * z) for x, y, z in fan], [(0, 2, 1), (0, 3, 2), (0, 4, 3), (0, 1, 4)])
END
for other in flag down; do
    "$norma" compute cone.obj $other.obj --together --out-dir "$other-one" --quiet
    "$norma" seams votes cone.obj $other.obj --everywhere -o $other.votes --quiet
    "$norma" seams apply cone.obj $other.obj --votes $other.votes --out-dir "$other-two" --quiet
    check "$other: --everywhere has the bits of one --together" same_files "$other-one" "$other-two"
done
"$norma" seams votes cone.obj flag.obj -o borders.votes --quiet
refuse "a border that touches a tile inside" "cone.obj: the border of another tile touches this one inside, at \(0, 0, 0\)" no.obj "$norma" seams apply cone.obj --votes borders.votes -o no.obj
refuse "votes everywhere and on borders" "everywhere" no.votes "$norma" seams merge flag.votes borders.votes -o no.votes

# ---- lost, repeated, changed
ls votes/*.votes | grep -v t004-004 | xargs "$norma" seams merge -o lost.votes --quiet
refuse "a tile whose votes were lost" "tiles/t004-004.ply: is not among the 255 tiles of lost.votes" no.ply "$norma" seams apply tiles/t004-004.ply --votes lost.votes -o no.ply
refuse "--tiles counts" "the votes are of 255 tiles, expected 256" no.votes "$norma" seams merge lost.votes -o no.votes --tiles 256
refuse "votes that were joined before" "votes/t004-004.votes: has the tile tiles/t004-004.ply, which all.votes has as well|all.votes: has the tile tiles/t004-004.ply" no.votes "$norma" seams merge all.votes votes/t004-004.votes -o no.votes
cp tiles/t001-001.ply copy.ply
refuse "a tile twice" "the same surface as" no.votes "$norma" seams votes tiles/t001-001.ply copy.ply -o no.votes
refuse "votes that are missing" "nowhere.votes: cannot be read" no.votes "$norma" seams merge all.votes nowhere.votes -o no.votes
refuse "apply without its votes" "nowhere.votes: cannot be read" no.ply "$norma" seams apply copy.ply --votes nowhere.votes -o no.ply
python3 - copy.ply <<'END'
import sys
data = bytearray(open(sys.argv[1], "rb").read())
data[data.index(b"end_header\n") + 11 + 2] ^= 1
open(sys.argv[1], "wb").write(data)
END
refuse "a tile that has changed since" "copy.ply: is not among" no.ply "$norma" seams apply copy.ply --votes all.votes -o no.ply
printf 'ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n' >empty.ply
cp empty.ply empty2.ply
"$norma" seams votes empty.ply empty2.ply -o empty.votes --quiet
check "tiles without a face may be equal" "$norma" seams merge empty.votes all.votes -o with-empty.votes --quiet --tiles 258
check "and are applied" "$norma" seams apply empty2.ply --votes with-empty.votes -o empty-out.ply --quiet

# ---- damaged: one bit anywhere, and any length
cat >damage.py <<'END'
import random, subprocess, sys
norma, path = sys.argv[1:]
data = open(path, "rb").read()
random.seed(1)
bad = 0
def try_with(what, name):
    global bad
    open("damaged.votes", "wb").write(what)
    done = subprocess.run([norma, "seams", "merge", "damaged.votes", "-o", "no.votes"], capture_output=True, text=True)
    if done.returncode != 3 or "damaged.votes" not in done.stderr or subprocess.run(["test", "-e", "no.votes"]).returncode == 0:
        print(name, done.returncode, done.stderr)
        bad += 1
for i in list(range(64)) + random.sample(range(len(data)), 150) + [len(data) - 1]:
    changed = bytearray(data)
    changed[i] ^= 1 << random.randrange(8)
    try_with(bytes(changed), "byte %d" % i)
for size in [0, 1, 8, 63, 64, 65, len(data) // 2, len(data) - 8, len(data) - 1]:
    try_with(data[:size], "%d bytes" % size)
try_with(data + b"\0", "a byte too many")
try_with(b"no votes at all" * 100, "another file")
sys.exit(bad != 0)
END
"$norma" seams votes tiles/t00[0-3]-00[0-3].ply -o small.votes --quiet
check "a damaged or truncated file is refused by name" python3 damage.py "$norma" small.votes
python3 -c "
data = bytearray(open('all.votes', 'rb').read()); data[len(data) // 2] ^= 4; open('damaged.votes', 'wb').write(data)"
status=0
for tile in tiles/t008-*.ply; do "$norma" seams apply "$tile" --votes damaged.votes -o "applied-$(basename "$tile")" >/dev/null 2>said || status=$?; done
check "and where apply reads it" bash -c "[ $status = 3 ] && grep -q damaged.votes said"

printf 'no votes' >other.votes
refuse "another file" "other.votes: is not a file of votes; expected a file that norma seams votes or merge wrote" no.votes "$norma" seams merge other.votes all.votes -o no.votes
head -c 1000 all.votes >short.votes
refuse "a truncated file" "short.votes: truncated or damaged votes: does not have the size stated in its header" no.votes "$norma" seams merge short.votes -o no.votes

# ---- forged: its checksums are right, what they cover is not
cat >forge.py <<'END'
import struct, subprocess, sys
norma, path, tile = sys.argv[1:]  # tile: the one that the first records belong to; apply reads no others
data = open(path, "rb").read()
HEAD, BLOCK, MASK = 56, 128, 2**64 - 1
record = struct.unpack_from("<I", data, 16)[0]

def hash_of(part):  # as norma_core_hash
    prime, hash = 0x9E3779B97F4A7C15, len(part) * 0x9E3779B97F4A7C15 & MASK
    whole = len(part) // 4 * 4
    for word in struct.unpack("<%dI" % (whole // 4), part[:whole]) + tuple(part[whole:]):
        hash = (hash ^ hash >> 29 ^ word) * prime & MASK
    return hash ^ hash >> 32

def sealed(head, table, records):
    sums = b"".join(struct.pack("<Q", hash_of(records[i:i + BLOCK * record])) for i in range(0, len(records), BLOCK * record))
    rest = hash_of(b"".join(struct.pack("<Q", hash_of(part)) for part in (head, table, sums)))
    return head + table + records + sums + struct.pack("<Q", rest)

tiles, table_bytes, count = struct.unpack_from("<3Q", data, 32)
head, table, records = data[:HEAD], data[HEAD:HEAD + table_bytes], data[HEAD + table_bytes:HEAD + table_bytes + count * record]
if sealed(head, table, records) != data:
    sys.exit("the checksums are others than this test computes")
def put(part, at, form, *values):
    part = bytearray(part)
    struct.pack_into(form, part, at, *values)
    return bytes(part)
named = table[24:].split(b"\0")[0].decode()  # the first tile of the table
first, second, third = records[:record], records[record:2 * record], records[2 * record:]
nan, huge = float("nan"), 2**62
damaged = "damaged votes"
forged = {
    "a position that is no number": (head, table, put(records, 8, "<d", nan), damaged),
    "an infinite position": (head, table, put(records, record, "<d", float("inf")), damaged),
    "swapped records": (head, table, second + first + third, damaged),
    "blocks in another order": (head, table, records[BLOCK * record:2 * BLOCK * record] + records[:BLOCK * record] + records[2 * BLOCK * record:], damaged),
    "a position twice": (head, table, first + first + third, damaged),
    "a sum beyond all sums": (head, table, put(records, 24, "<q", huge), damaged),
    "a top that no sum has": (head, table, put(records, 24 + 96, "<i", 1000), damaged),
    "a tile less than its table has": (put(head, 32, "<Q", tiles - 1), table, records, damaged),
    "a tile more than its table has": (put(head, 32, "<Q", tiles + 1), table, records, damaged),
    "a name without an end": (head, table[:-1] + b"x", records, damaged),
    "a record less than it has": (put(head, 48, "<Q", count - 1), table, records, "truncated or damaged votes"),
    "a weight that votes cannot have": (put(head, 20, "<I", 77), table, records, damaged),
    "another tile's hash": (head, put(table, 0, "<Q", 1), records, None),
}
bad = 0
for name, (a, b, c, words) in forged.items():
    open("forged.votes", "wb").write(sealed(a, b, c))
    for command in (["merge", "forged.votes", "-o", "no.votes"], ["apply", tile if words else named, "--votes", "forged.votes", "-o", "no.votes.ply"]):
        done = subprocess.run([norma, "seams", *command], capture_output=True, text=True)
        left = subprocess.run("ls no.votes*", shell=True, capture_output=True).returncode == 0
        if words is None and command[0] == "merge":  # only the tile can tell
            subprocess.run("rm -f no.votes", shell=True)
            continue
        wanted = words or "is not among"
        if done.returncode != 3 or done.stderr.count("\n") != 1 or "forged.votes" not in done.stderr or wanted not in done.stderr or left:
            print(name, command[0], done.returncode, done.stderr, left)
            subprocess.run("rm -f no.votes*", shell=True)
            bad += 1
sys.exit(bad != 0)
END
check "a forged file, whose checksums are right, is refused in one line" python3 forge.py "$norma" small.votes tiles/t000-000.ply

# ---- killed
# Kills a command while it has a file open that is new in this folder. 0: so it was, and left no output; 1: it left a part of one; 77: it was never seen so.
cat >kill_writing.py <<'END'
import os, subprocess, sys, time
output, whole, command = sys.argv[1], open(sys.argv[2], "rb").read(), sys.argv[3:]
folder = os.getcwd()
def writes(process, before):
    try:
        files = [os.readlink("/proc/%d/fd/%s" % (process.pid, fd)) for fd in os.listdir("/proc/%d/fd" % process.pid)]
    except OSError:
        return False
    return any(os.path.dirname(file) == folder and os.path.basename(file) not in before for file in files)
for delay in [i * i * 1e-5 for i in range(30)]:
    before = os.listdir()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    seen = False
    while not seen and process.poll() is None:
        seen = writes(process, before)
    time.sleep(delay if seen else 0)
    process.kill()
    killed = process.wait() == -9
    if os.path.exists(output):
        if open(output, "rb").read() != whole:
            sys.exit("%s is there, but not whole" % output)
        os.remove(output)
    elif seen and killed:
        sys.exit(0)
sys.exit(77)
END
for step in votes merge; do
    inputs=(tiles)
    [ $step = votes ] || inputs=(votes/*.votes)
    status=0
    python3 kill_writing.py killed.votes all.votes "$norma" seams $step "${inputs[@]}" -o killed.votes >said 2>&1 || status=$?
    case $status in
    0) pass "$step: killed while it writes, it leaves nothing" ;;
    77) skip "$step: it was never killed while it had a temporary file (no /proc, or too fast)" ;;
    *) fail "$step: killed while it writes, it leaves nothing" "$(cat said)" ;;
    esac
    "$norma" seams $step "${inputs[@]}" -o killed.votes --quiet
    check "$step: and can be run again" cmp killed.votes all.votes
    rm -f killed.votes
done

# ---- memory of a step does not grow with the number of tiles
# Python's own 13 MB would hide it: a child's peak includes its parent's up to exec.
if ${CC:-cc} -std=gnu11 -O2 "$root/bench/run_best.c" -o run_best -lm 2>said; then
    peak() { ./run_best 1 "$norma" seams apply tiles/t001-001.ply --votes "$1" -o peak.ply --quiet --threads 1 | awk '{ print $3 }'; }
    few=$(peak small.votes) many=$(peak all.votes)
    check "apply: $many MB with 256 tiles ($(stat -c %s all.votes) bytes of votes), $few with 16" awk "BEGIN { exit !($few > 1 && $many < $few + 0.4) }"
else
    fail "run_best compiles" "$(cat said)"
fi

# ---- tiles that fail do not stop the others, and each is reported as what it is
for way in "" --json; do
    rm -rf some
    status=0
    errors=0
    [ -z "$way" ] || errors=1
    "$norma" seams apply deal0.ply copy.ply deal1.ply --votes area.votes --out-dir some $way >said 2>said.errors || status=$?
    check "apply${way:+ }$way: one of three is refused, and only it is reported so" bash -c "[ $status = 3 ] && [ ! -e some/copy.ply ] && cmp some/deal0.ply seams-area/deal0.ply && cmp some/deal1.ply seams-area/deal1.ply &&
        [ \$(grep -c 'copy.ply: is not among' said.errors) = 1 ] && ! grep -q 'deal[01]' said.errors && [ \$(grep -c 'some/deal[01].ply' said) = 2 ] && [ \$(grep -c '\"error\"' said) = $errors ]"
done

# ---- levels whose faces at a border have no area: no vote, and yet the same bytes in any order
for level in 0 1; do
    printf 'v 0 0 0\nv %d 0 0\nv %d 0 0\nf 1 2 3\n' $((level + 1)) $((level + 3)) >"flat_LOD$level.obj"
    "$norma" seams votes "flat_LOD$level.obj" -o "flat$level.votes" --quiet
done
"$norma" seams merge flat0.votes flat1.votes -o forth.votes --quiet
"$norma" seams merge flat1.votes flat0.votes -o back.votes --quiet
check "levels without votes: the same bytes in any order" cmp forth.votes back.votes

# ---- usage
expect() {
    local wanted=$1 name=$2 text=$3 status=0
    shift 3
    "$@" >said 2>&1 || status=$?
    if [ "$status" = "$wanted" ] && grep -q -- "$text" said; then pass "$name"; else fail "$name" "status $status: $(cat said)"; fi
}
expect 2 "no step" "expected votes, merge or apply" "$norma" seams
expect 2 "an unknown step" "unknown step 'vote'" "$norma" seams vote
expect 2 "no output" "expected -o FILE" "$norma" seams votes deal0.ply
expect 2 "no votes given" "apply needs --votes" "$norma" seams apply deal0.ply -o no.ply
expect 2 "apply of standard input" "standard input and output cannot be among the files" "$norma" seams apply - --input-format ply --votes area.votes -o no.ply
check "which does not speak of --together" bash -c '! grep -q -- --together said'
expect 2 "visible" "summed over faces" "$norma" seams votes deal0.ply --weight visible -o no.votes
expect 2 "an STL" "facet normals only" "$norma" seams votes "$root/assets/"*.stl -o no.votes
expect 0 "help" "norma seams votes|merge|apply" "$norma" help seams
finish
