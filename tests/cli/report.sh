#!/bin/bash
# The report of norma check for people and for programs: the command of each fix is pasted into sh, whatever the file is called; colours and widths on a terminal and in a pipe.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
cd "$scratch" || exit 1
[ -x "$norma" ] || { fail "the tool is there" "no program at $norma"; finish; exit 1; }
mkdir bin && ln -s "$norma" bin/norma
PATH=$scratch/bin:$PATH

# A triangle and a normal without a length: N102, which --fix mends.
bad='v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n'

# commands FORMAT FILE: the commands that a report offers.
commands() {
    case $1 in
    text) norma check --no-config -- "$2" | sed -n 's/.* Fix: //p' ;;
    json) norma check --no-config --json -- "$2" | node -e 'for (const { command } of JSON.parse(require("fs").readFileSync(0)).files[0].findings) if (command) console.log(command)' ;;
    sarif) norma check --no-config --format sarif -- "$2" | node -e 'for (const { properties } of JSON.parse(require("fs").readFileSync(0)).runs[0].results) if (properties.command) console.log(properties.command)' ;;
    html) norma check --no-config --format html -- "$2" | grep -o '<code>norma check [^<]*</code>' | sed -e 's/<[^>]*>//g' -e 's/&quot;/"/g' -e 's/&lt;/</g' -e 's/&gt;/>/g' -e 's/&amp;/\&/g' ;;
    esac
}

names=("plain.obj" "two words.obj" "it's.obj" 'say "hi".obj' '$HOME.obj' '`id`.obj' 'a;touch broken-out;.obj' '-o.obj' 'a&b<c>d|e.obj' 'back\slash.obj' '~tilde.obj' '#hash.obj' '100%.obj' 'star*[a].obj'
    $'tab\there.obj' $'line\nend.obj' $'esc\033[31m.obj' 'Stühle 椅子.obj' $'latin\374.obj' $'\342\200\256right.obj' 'folder with spaces/x.y.obj' 'no-ending' $'q\'%\\\n.obj')
mkdir "folder with spaces"
for name in "${names[@]}"; do
    shown=$(printf '%q' "$name")
    case $name in *.obj) fixed=${name%.obj}.fixed.obj ;; *) fixed=$name.fixed.obj ;; esac
    for form in text json sarif html; do
        printf "$bad" >"./$name"
        if [ "$name" = no-ending ]; then
            [ $form = json ] || continue
            command=$(norma check "$name" --input-format obj --json | node -e 'console.log(JSON.parse(require("fs").readFileSync(0)).files[0].findings[0].command)')
        else
            command=$(commands $form "$name" | head -n 1)
        fi
        rm -f "./$fixed"
        output=$(sh -c "$command" 2>&1)
        status=$?
        if [ $status -eq 0 ] && [ -n "$command" ] && [ -f "./$fixed" ] && ! grep -q 'vn 0 0 0' "./$fixed"; then
            pass "$form: the command for $shown fixes it"
        else
            fail "$form: the command for $shown fixes it" "$(printf '%q' "$command") ends with $status: $output"
        fi
        rm -f "./$name" "./$fixed"
    done
done
if [ ! -e broken-out ]; then pass "no name ran a command of its own"; else fail "no name ran a command of its own"; fi

# ---- what belongs to a command is in it
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1.0003\nf 1//1 2//1 3//1\n' >strict.obj
command=$(commands json strict.obj)
if [ -z "$command" ]; then pass "1.0003 is near enough to 1"; else fail "1.0003 is near enough to 1" "$command"; fi
command=$(norma check strict.obj --strict | sed -n 's/.* Fix: //p')
if [[ $command == *--strict* ]] && sh -c "$command" >/dev/null && norma check strict.fixed.obj --strict --quiet --fail-on warning >/dev/null; then
    pass "--strict is kept"
else
    fail "--strict is kept" "$command"
fi

# ---- what was tried is not offered again: a face without area that closes a slit is kept
printf 'v 0 0 0\nv 2 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 2\nf 1 4 2\nf 1 3 5\nf 3 2 5\nf 1 2 3\nf 2 4 5\nf 1 5 4\n' >slit.obj
before=$(norma check slit.obj --info --select N401) after=$(norma check slit.obj --info --select N401 --fix-unsafe --dry-run 2>&1)
if [[ $before != *"Fix: "* && $before == *"no fix: "* && $after == *N401* && $after != *"Fix: "* ]]; then pass "a fix that was tried is not offered again"; else fail "a fix that was tried is not offered again" "$before / $after"; fi

reason=$(norma check slit.obj --select N401 --fix-unsafe --dry-run --json 2>err | sed -n 's/.*"not_fixed": \["N401[^:]*: \([^"]*\)"\].*/\1/p')
if [ -n "$reason" ] && grep -qF "$reason" err; then pass "what could not be fixed is reported with the reason"; else fail "what could not be fixed is reported with the reason" "$reason / $(cat err)"; fi

# ---- a pipe and a terminal
printf "$bad" >wide.obj
if [ "$(norma check wide.obj --quiet | wc -l)" -eq 1 ] && [ "$(norma check wide.obj | grep -c '^wide.obj: error N102 .* Fix: norma check wide.obj --fix --select N102 -o wide.fixed.obj$')" -eq 1 ] && ! norma check wide.obj | grep -q $'\033'; then
    pass "in a pipe nothing is wrapped or coloured"
else
    fail "in a pipe nothing is wrapped or coloured" "$(norma check wide.obj | cat -v)"
fi
if norma check wide.obj --color always | grep -q $'\033\\[1;31merror'; then pass "--color always"; else fail "--color always"; fi
norma check wide.obj --color always -o colored.txt >/dev/null 2>&1
if grep -q $'\033' colored.txt; then pass "--color always into a file"; else fail "--color always into a file"; fi

# terminal COLUMNS COMMAND...: what it prints on a terminal of so many columns.
terminal() {
    COLUMNS_OF=$1 python3 -c '
import fcntl, os, pty, struct, sys, termios
child, terminal = pty.fork()
if child == 0:
    fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 24, int(os.environ["COLUMNS_OF"]), 0, 0))
    os.execvp(sys.argv[1], sys.argv[1:])
text = b""
while True:
    try: part = os.read(terminal, 65536)
    except OSError: break
    if not part: break
    text += part
os.waitpid(child, 0)
sys.stdout.buffer.write(text.replace(b"\r\n", b"\n"))' "${@:2}"
}
export TERM=xterm
for columns in 60 100; do
    text=$(terminal $columns norma check wide.obj)
    longest=$(printf '%s\n' "$text" | sed $'s/\033\\[[0-9;]*m//g' | grep -v 'Fix: ' | wc -L)
    fix=$(printf '%s\n' "$text" | grep -c '^    Fix: norma check wide.obj --fix --select N102 -o wide.fixed.obj$')
    if [ "$longest" -le "$columns" ] && [ "$longest" -gt $((columns - 25)) ] && [ "$fix" -eq 1 ] && [[ $text == *$'\033[1;31merror'* ]]; then
        pass "a terminal of $columns columns: coloured, wrapped, the command on a line of its own"
    else
        fail "a terminal of $columns columns: coloured, wrapped, the command on a line of its own" "$longest, $fix: $text"
    fi
done
for plain in "NO_COLOR=1 norma check wide.obj" "TERM=dumb norma check wide.obj" "norma check wide.obj --color never"; do
    if terminal 80 sh -c "$plain" | grep -q $'\033'; then fail "without colours: $plain"; else pass "without colours: $plain"; fi
done
if NO_COLOR=1 norma check wide.obj --color always | grep -q $'\033'; then pass "--color always goes before NO_COLOR"; else fail "--color always goes before NO_COLOR"; fi

# ---- the form by the name of the report
for form in json sarif html; do
    norma check wide.obj -o "report.$form" >/dev/null 2>&1
    norma check wide.obj --format $form >"expected.$form" 2>/dev/null
    if cmp -s "report.$form" "expected.$form"; then pass "-o report.$form is $form"; else fail "-o report.$form is $form"; fi
done
norma check wide.obj --format text -o text.html >/dev/null 2>&1
if head -n 1 text.html | grep -q '^wide.obj: error N102'; then pass "--format goes before the name"; else fail "--format goes before the name" "$(head -n 3 text.html)"; fi

# ---- shards and their merge: every file once, the report and the status of one run, byte for byte, names that are no UTF-8 included
mkdir farm farm/sub
for i in $(seq 1 13); do printf "$bad" >"farm/$i.obj"; done
for i in $(seq 1 5); do printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >"farm/sub/clean $i.obj"; done
printf 'f 1 2 3\n' >farm/broken.obj
for name in $'x\377.obj' $'x\376.obj' $'sub/\303.obj' 'sub/x&"y.obj' 'sub-1.obj'; do printf "$bad" >"farm/$name"; done
for form in json sarif html; do
    norma check farm -o "whole.$form" >/dev/null 2>&1
    whole=$?
    parts=()
    for i in 1 2 3 4; do
        norma check farm --shard $i/4 -o "part$i.$form" >/dev/null 2>&1
        parts=("part$i.$form" "${parts[@]}")
    done
    norma report --merge "${parts[@]}" -o "merged.$form"
    merged=$?
    if cmp "whole.$form" "merged.$form" >said 2>&1 && [ $whole -eq 3 ] && [ $merged -eq 3 ]; then pass "four shards in $form, merged: one run's bytes"; else fail "four shards in $form, merged: one run's bytes" "$whole, $merged: $(cat said)"; fi
done
files() { grep -o '"path": "[^"]*"' "$1"; }
check "each shard has a part of the files" test "$(for i in 1 2 3 4; do files part$i.json | wc -l; done | sort -n | head -n 1)" -gt 0
for way in ./farm farm/ "$PWD/farm" ././/farm; do
    norma check "$way" --shard 2/4 -o way.json >/dev/null 2>&1
    if [ "$(files way.json | sed "s,\"$way/*,\"farm/,")" = "$(files part2.json)" ]; then pass "the second shard of $way is that of farm"; else fail "the second shard of $way is that of farm" "$(files way.json)"; fi
done
mkdir alone && cp farm/1.obj alone && in=$(for i in 1 2 3 4; do files part$i.json | grep -q '"farm/1.obj"' && echo $i; done)
norma check alone --shard "$in/4" -o way.json >/dev/null 2>&1
check "a file is of the same shard without the others" grep -q 'alone/1.obj' way.json
grep -q '"shard": \[2, 4\], "options": {' part2.json
if [ $? -eq 0 ] && ! grep -q '"shard"' merged.json; then pass "a shard says which it is, the merged report does not"; else fail "a shard says which it is, the merged report does not" "$(head -n 1 part2.json merged.json)"; fi

# refuses NAME WORDS ARGUMENTS...: with status 3 and these words, and nothing is written.
refuses() {
    local name=$1 words=$2 status=0
    shift 2
    rm -f refused.*
    norma report --merge "$@" >said 2>err || status=$?
    if [ $status -eq 3 ] && grep -qF -- "$words" err && ! ls refused.* >/dev/null 2>&1; then pass "$name"; else fail "$name" "status $status: $(cat err)"; fi
}
norma check farm --shard 3/4 --ignore N104 -o other.json >/dev/null 2>&1
norma check farm --shard 3/5 -o five.json >/dev/null 2>&1
for form in json sarif html; do
    refuses "$form: a shard that is missing" 'shards [2, 3] of 4 are missing; --partial' part1.$form part4.$form -o refused.$form
    refuses "$form: a shard that is there twice" "part4.$form: shard 4 of 4 is already in part4.$form" part?.$form part4.$form -o refused.$form
    norma report --merge --partial part1.$form part4.$form -o partial.$form 2>err
    status=$?
    if [ $status -eq 3 ] && grep -q 'shards \[2, 3\] of 4 are missing' err && grep -qE 'missing_shards": \[2, 3\]' partial.$form; then pass "$form: --partial says what is missing"; else fail "$form: --partial says what is missing" "status $status: $(cat err)"; fi
done
refuses 'a shard of other options' 'other.json: was made with other options than part1.json' part1.json part2.json other.json part4.json -o refused.json
# Its options say the same in another order, between other blanks.
python3 -c 'import json, sys; r = json.load(open("part3.json")); r["options"] = dict(reversed(r["options"].items())); json.dump(r, open("turned.json", "w"), indent=1)'
norma report --merge part1.json part2.json turned.json part4.json -o turned-all.json 2>err
check "a shard whose options stand in another order is one of the set: $(cat err)" test -s turned-all.json
refuses 'a shard of another set' 'five.json: is one of 5 shards' part1.json part2.json five.json part4.json -o refused.json
# hostile NAME WORDS SED: the whole report, changed by sed, is refused.
hostile() {
    LC_ALL=C sed -E "$3" whole.json >hostile.json
    if cmp -s whole.json hostile.json; then fail "$1" "sed '$3' changed nothing"; else refuses "$1" "$2" hostile.json -o refused.json; fi
}
hostile 'a member of the report that is there twice' "near 'schema': expected each member of an object once" 's/^\{("schema": [^,]*,)/{\1 \1/'
hostile 'a member of a file that is there twice' "near 'status': expected each member of an object once" '0,/"status"/s/("status": "[a-z]*",)/\1 \1/'
hostile 'bytes that are no UTF-8' 'expected valid UTF-8' '0,/"path": "/s//"path": "\xff/'
hostile 'a half of a pair' 'expected a character' '0,/"path": "/s//"path": "\\ud800/'
hostile 'a number beyond doubles' "near '1e999" '0,/"errors": [0-9]+/s//"errors": 1e999/'
hostile 'a report that ends too early' 'expected a comma or a closing brace' '$s/}[^}]*$//'
hostile 'values nested deeply' 'nested at most 256 deep' "0,/\"errors\": [0-9]+/s//\"errors\": $(printf '[%.0s' $(seq 300))/"
refuses 'a shard and a whole report' 'whole.json is a whole report' part1.json whole.json -o refused.json
norma report --merge --partial part1.json part4.json --format text >said 2>/dev/null
check "--partial: text says what is missing" grep -q '; shards \[2, 3\] are missing$' said

# The status is that of the findings, whatever number a report has.
for number in 0 256 -1 139 2; do
    for form in json sarif html; do
        sed -E "s/\"(exit_status|exitCode)\": [0-9]+/\"\1\": $number/" whole.$form >lies.$form
        norma report --merge lies.$form -o told.$form
        status=$?
        if [ $status -eq 3 ] && cmp -s told.$form whole.$form; then pass "$form: a status of $number in a report is not believed"; else fail "$form: a status of $number in a report is not believed" "$status"; fi
    done
done
for wanted in 0 1; do
    for form in json sarif html; do
        fail_on=$([ $wanted -eq 1 ] && echo info || echo never)
        for i in 1 2; do norma check farm/sub --shard $i/2 --fail-on $fail_on -o $i.$form >/dev/null; done
        norma report --merge 1.$form 2.$form -o both.$form
        merged=$?
        norma check farm/sub --fail-on $fail_on -o one.$form >/dev/null
        if [ $merged -eq $wanted ] && cmp -s one.$form both.$form; then pass "$form: --fail-on $fail_on is kept: status $wanted"; else fail "$form: --fail-on $fail_on is kept: status $wanted" "$merged"; fi
    done
done
mkdir unreadable
norma check farm/sub unreadable -o incomplete.json >/dev/null 2>&1
first=$?
norma report --merge incomplete.json -o told.json
status=$?
if [ $first -eq 3 ] && [ $status -eq 3 ] && grep -q '"complete": false' told.json; then pass "what could not be read and has no entry is no pass"; else fail "what could not be read and has no entry is no pass" "$first, $status"; fi

# --exit job: what is found is no failure of the job.
norma check farm --exit job -o job.json >/dev/null 2>&1
status=$?
if [ $status -eq 0 ] && cmp -s job.json whole.json; then pass "--exit job: findings and unreadable files end with 0"; else fail "--exit job: findings and unreadable files end with 0" "$status"; fi
norma report --merge job.json -o told.json
check "the merge decides then" test $? -eq 3
norma check farm --exit job --config none.json >/dev/null 2>&1
check "--exit job: a wrong configuration ends with 2" test $? -eq 2
norma check farm --exit job -o none/report.json >/dev/null 2>&1
check "--exit job: a report that cannot be written ends with 3" test $? -eq 3

# A shard without files: of many more shards than files.
for i in $(seq 1 9); do norma check farm/sub --shard $i/9 --select N1 -o nine$i.json >/dev/null 2>&1; done
norma check farm/sub --select N1 -o one.json >/dev/null 2>&1
norma report --merge nine?.json -o told.json >/dev/null 2>&1
if [ "$(cat nine?.json | grep -c '"files": 0, ')" -gt 0 ] && cmp -s one.json told.json; then pass "a shard without files is a report like others"; else fail "a shard without files is a report like others"; fi

# SARIF holds 25,000 results: rules with the most of them lose some, and that is said. Shards keep all.
python3 -c '
import json
nodes = [{"name": str(i), "mesh": 0, "scale": [-2, 1, 1] if i % 13 == 0 else [2, 1, 1]} for i in range(26000)]
document = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(26000))}], "nodes": nodes,
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}
json.dump(document, open("nodes.gltf", "w"))'
norma check nodes.gltf --select N6 -o nodes.sarif 2>err
for i in 1 2; do norma check nodes.gltf --select N6 --shard $i/2 -o nodes$i.sarif 2>/dev/null; done
norma report --merge nodes1.sarif nodes2.sarif -o nodes-merged.sarif 2>/dev/null
of() { grep -c "^{\"ruleId\": \"$1\"" "$2"; }
if [ "$(of N601 nodes.sarif)" -eq 23000 ] && [ "$(of N602 nodes.sarif)" -eq 2000 ] && grep -q 'N601: 3000 of 26000 results left out' err && grep -q '"toolExecutionNotifications": \[{"level": "warning", "message": {"text": "N601: 3000 results left out' nodes.sarif &&
    [ $(($(of N601 nodes1.sarif) + $(of N601 nodes2.sarif))) -eq 26000 ] && cmp -s nodes.sarif nodes-merged.sarif; then
    pass "SARIF is cut by rule above 25,000 results, and says so"
else
    fail "SARIF is cut by rule above 25,000 results, and says so" "$(of N601 nodes.sarif) $(of N602 nodes.sarif) $(of N601 nodes-merged.sarif): $(cat err)"
fi
for wrong in 0/3 4/3 3 1/0 a/b 1/2/3; do
    norma check farm --shard $wrong >/dev/null 2>err
    status=$?
    if [ $status -eq 2 ] && grep -q 'expected I/N' err; then pass "--shard $wrong is a usage error"; else fail "--shard $wrong is a usage error" "$(cat err)"; fi
done
norma report --merge part1.json part1.sarif -o mixed.json 2>err
status=$?
if [ $status -eq 3 ] && [ ! -e mixed.json ]; then pass "reports of two kinds are refused, and nothing is written"; else fail "reports of two kinds are refused, and nothing is written" "$status: $(cat err)"; fi
norma report --merge part?.json --format line >merged.txt
norma check farm --format line >whole.txt 2>/dev/null
if [ -s merged.txt ] && cmp -s <(sort merged.txt) <(sort whole.txt); then pass "JSON becomes lines"; else fail "JSON becomes lines" "$(diff <(sort merged.txt) <(sort whole.txt))"; fi

# ---- the page, and the manual of rules
norma check farm -o farm.html >/dev/null 2>&1
if [ "$(grep -c '<section class="file"' farm.html)" -eq 24 ] && [ "$(grep -c "class='m'" farm.html)" -ge 1 ] && [ "$(stat -c %s farm.html)" -lt 1000000 ] && grep -q '<article class="meaning" id="N102">' farm.html && grep -q 'href="#N102"' farm.html; then
    pass "the page has each file, marked faces and what the rules mean"
else
    fail "the page has each file, marked faces and what the rules mean" "$(grep -c '<section class="file"' farm.html) files, $(stat -c %s farm.html) bytes"
fi
# A corner that lies 1e38 sides of its neighbour away: of it only the direction shows, in numbers that a browser can draw.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 3e38 1e38 0\nv 1e38 3e38 2e38\nvn 0 0 0\nvn 0 0 1\nf 1//1 2//2 3//2\nf 1//2 4//2 5//2\n' >far.obj
# Links into the page: what a browser makes of them is the file's name, whatever it is, and the finding's rule.
mkdir linked
for name in "two words.obj" 'a&b<c>d|e.obj' "it's 100%.obj" 'Stühle #?+.obj' 'say "hi".obj'; do printf "$bad" >"linked/$name"; done
norma check linked --no-config --page 'https://x.example/norma.html' -o linked.html
norma check "$PWD/linked" --no-config --page 'https://x.example/norma.html' --format html >linked-absolute.html
if links=$(node -e '
const page = require("fs").readFileSync(process.argv[1], "utf8").replaceAll("&quot;", "\"").replaceAll("&lt;", "<").replaceAll("&gt;", ">").replaceAll("&#39;", "\x27").replaceAll("&amp;", "&");
const addresses = [...page.matchAll(/<a class="place" href="([^"]*)">/g)].map(([, address]) => new URL(address));
const names = addresses.filter(({ origin, pathname, hash }) => origin + pathname === "https://x.example/norma.html" && new URLSearchParams(hash.slice(1)).get("finding").startsWith("N102:")).map(({ searchParams }) => searchParams.get("src"));
const expected = require("fs").readdirSync("linked").map((name) => `linked/${name}`);
if (expected.sort().join("\n") !== names.sort().join("\n")) { console.log(names.join("\n")); process.exit(1); }' linked.html) && cmp -s <(grep -o 'class="place" href="[^"]*"' linked.html | sort) <(grep -o 'class="place" href="[^"]*"' linked-absolute.html | sort); then
    pass "--page: links name file and finding, whatever the name"
else
    fail "--page: links name file and finding, whatever the name" "$links $(grep -o 'class="place" href="[^"]*"' linked.html)"
fi
# To a folder of pages: where norma view writes the page of each file, whatever words name the files.
mkdir -p tree/sub && printf "$bad" >tree/sub/"a #1.obj" && printf "$bad" >tree/b.c.obj
hrefs() { norma check "$@" --no-config --page pages/ --format html | sed -n 's/.*class="place" href="\([^"]*\)#finding=N102:.*/\1/p' | sort | tr '\n' ' '; }
found="$(hrefs tree)$(hrefs "$PWD/tree")$(hrefs tree/sub/*)"
if [ "$found" = "pages/b.c.html pages/sub/a%20%231.html pages/b.c.html pages/sub/a%20%231.html pages/a%20%231.html " ]; then pass "--page FOLDER/: links lead to the pages of norma view"; else fail "--page FOLDER/: links lead to the pages of norma view" "$found"; fi
# Where two pages would meet, both keep their folders, as those of norma view do; where they cannot, both commands refuse.
mkdir -p meet/two && printf "$bad" | tee meet/two/a.obj >meet/a.obj && printf '%s\n' meet/a.obj meet/two/a.obj >meet.txt
found="$(hrefs meet/a.obj meet/two/a.obj)$(hrefs --files-from meet.txt)$(hrefs meet/a.obj meet/two/a.obj --shard 2/2)$(hrefs meet/a.obj meet/two/a.obj --shard 1/2)"
if [ "$found" = "pages/a.html pages/two/a.html pages/a.html pages/two/a.html pages/a.html pages/two/a.html " ]; then pass "--page FOLDER/: two files of one name have a page each"; else fail "--page FOLDER/: two files of one name have a page each" "$found"; fi
cp meet/a.obj meet/a.ply
status=0; norma check meet --no-config --page pages/ --format html >met.html 2>met || status=$?
norma view meet --out-dir pages 2>viewed || true
check "--page FOLDER/: two files for one page are refused, in the words of norma view" bash -c '[ "$0" = 2 ] && [ ! -s met.html ] && grep -q "meet/a.obj and meet/a.ply would both be written to pages/a.html" met && grep -qF "$(sed "s/.*view: //;s/ (.*//" viewed)" met' "$status"
if norma view tree --out-dir pages --quiet 2>/dev/null; then check "norma view writes them there" test -s "pages/sub/a #1.html" -a -s pages/b.c.html; else skip "this norma has no page"; fi
# Without it each file has the command that makes its page, and a shell reads the file's name out of it again.
norma check linked --no-config -o unlinked.html >/dev/null 2>&1
sed -n 's/^<p class="fix">Turn it.*<code>norma view \(.*\) -o .*<\/code><\/p>$/printf "%s\\n" \1/p' unlinked.html | sed "s/&quot;/\"/g;s/&lt;/</g;s/&gt;/>/g;s/&#39;/'/g;s/&amp;/\&/g" | bash | sort >shown.txt
if [ "$(wc -l <shown.txt)" -eq 5 ] && cmp -s shown.txt <(printf '%s\n' linked/* | sort) && ! grep -q "Turn it.*norma view" linked.html; then
    pass "without --page each file has the command that shows it, whatever its name"
else
    fail "without --page each file has the command that shows it, whatever its name" "$(cat shown.txt)"
fi
# Boxes in the octahedron |x|+|y|+|z| <= 1: wholly, or from its middle outwards; each is marked whole.
solids() { awk -v boxes="$1" 'BEGIN { print "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\nf 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6"
    n = split(boxes, size, " "); for (b = 0; b < n; b++) { for (i = 0; i < 8; i++) print "v", (i % 2 ? size[b + 1] : .02 + b / 50), (int(i / 2) % 2 ? size[b + 1] : .02 + b / 50), (i > 3 ? size[b + 1] : .02 + b / 50); k = 6 + 8 * b
    print "f", k+1, k+3, k+4, k+2 "\nf", k+5, k+6, k+8, k+7 "\nf", k+1, k+2, k+6, k+5 "\nf", k+3, k+7, k+8, k+4 "\nf", k+1, k+5, k+7, k+3 "\nf", k+2, k+4, k+8, k+6 } }' >"$2"; norma check "$2" --profile print --no-config --format line; }
if solids .2 solids1.obj | grep -q 'a solid within a solid: 1 component facing outward' && solids .7 solids2.obj | grep -q 'solids overlap: 1 component lies partly in another' &&
    norma check solids2.obj --profile print --select N302 --no-config --format html | grep -c "class='m'" | grep -qx 6; then
    pass "N302: solids that overlap are not said to be within one another, and are marked whole"
else
    fail "N302: solids that overlap are not said to be within one another, and are marked whole" "$(solids .2 solids1.obj; solids .7 solids2.obj)"
fi
check "no link without --page" bash -c '! norma check linked --no-config --format html | grep -q "class=\"place\" href"'
check "--page takes an address without a question" bash -c 'norma check linked --page "norma.html?v=2" -o x.html 2>usage >/dev/null; [ $? -eq 2 ] && grep -q "expected an address without" usage && [ ! -e x.html ]'
check "--page asks for an HTML report" bash -c 'norma check linked --page norma.html 2>usage >/dev/null; [ $? -eq 2 ] && grep -q -- "--page needs --format html" usage'
norma check far.obj --no-config -o far.html >/dev/null 2>&1
if grep -q "<path class='m' d='" far.html && ! grep -Eq "d='[^']*[0-9]{10}" far.html; then pass "a picture of distant corners keeps to small numbers"; else fail "a picture of distant corners keeps to small numbers" "$(grep -o "d='[^']*'" far.html)"; fi
norma explain -o rules.html
without=""
for id in $(norma explain | cut -d ' ' -f 1); do
    [ "$(sed -n "/ id=\"$id\"/,/<\/article>/p" rules.html | grep -c '<svg .*<path')" -eq 2 ] || without+=" $id"
done
if [ -z "$without" ]; then pass "the manual has a picture of wrong and one of right for every rule"; else fail "the manual has a picture of wrong and one of right for every rule" "$without"; fi

# ---- for people: the worst file first, what several files share once, files without problems folded
mkdir worst worst/deep
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n' >worst/a-clean.obj
sed -E 's/^f (.*) (.*) (.*)/f \1 \3 \2/' worst/a-clean.obj >worst/b-inside-out.obj # N302, a warning
for copy in c-copy d-copy deep/e-copy f-copy; do cp worst/b-inside-out.obj "worst/$copy.obj"; done
sed 's/^v 0 0 1/v 0 0 2/' worst/b-inside-out.obj >worst/g-other.obj # the same words, of another mesh
printf "$bad" >worst/y-error.obj                                    # N102
{ printf "$bad"; printf 'v 5 0 0\nv 6 0 0\nv 5 1 0\nvn 0 0 3\nf 4//2 5//2 6//2\n'; } >worst/z-errors.obj # N102, N103
norma check worst --no-config >worst.txt
if [ "$(grep -o '^worst/[a-z/-]*.obj: [a-z]* N...' worst.txt | tr '\n' ' ')" = 'worst/z-errors.obj: error N102 worst/z-errors.obj: error N103 worst/y-error.obj: error N102 worst/b-inside-out.obj: warning N302 worst/g-other.obj: warning N302 ' ]; then
    pass "text: files by their gravest finding, then by how many"
else
    fail "text: files by their gravest finding, then by how many" "$(cat worst.txt)"
fi
if grep -q '^worst/b-inside-out.obj: .* Also in worst/c-copy.obj, worst/d-copy.obj, worst/deep/e-copy.obj and 1 more file. Fix: norma check worst/b-inside-out.obj ' worst.txt && [ "$(grep -c 'Also in' worst.txt)" -eq 1 ] && tail -n 1 worst.txt | grep -q '^3 errors, 6 warnings in 8 of 9 files$'; then
    pass "text: the same mesh in five files is one line, another mesh is not in it, and the totals count all"
else
    fail "text: the same mesh in five files is one line, another mesh is not in it, and the totals count all" "$(cat worst.txt)"
fi
norma check worst --no-config -o worst.html
norma check worst --no-config -o worst.json
sections() { grep -o '<section class="file" data-path="[^"]*"' "$1" | sed 's/.*path="worst.//; s/"//' | tr '\n' ' '; }
if [ "$(sections worst.html)" = 'z-errors.obj y-error.obj b-inside-out.obj c-copy.obj d-copy.obj deep/e-copy.obj f-copy.obj g-other.obj a-clean.obj ' ] && [ "$(grep -o '"path": "[^"]*"' worst.json | head -n 1)" = '"path": "worst/a-clean.obj"' ]; then
    pass "the page: the worst first; JSON: by path"
else
    fail "the page: the worst first; JSON: by path" "$(sections worst.html)"
fi
links=$(sed -n '/<details class="files"/,/<\/details>/p' worst.html | grep -o 'href="#f[0-9a-f]*"' | sed 's/.*#//; s/"//')
missing=""
for link in $links; do grep -q "<h2 id=\"$link\">" worst.html || missing+=" $link"; done
if [ "$(echo "$links" | wc -l)" -eq 8 ] && [ -z "$missing" ] && [ "$(grep -o 'data-same="[0-9a-f]*"' worst.html | sort | uniq -c | sort -n | awk '{ print $1 }' | tr '\n' ' ')" = '1 1 1 1 5 ' ] && sed -n '/<details id="clean">/,$p' worst.html | grep -q '<details><summary><h2 id="f[0-9a-f]*">worst/a-clean.obj'; then
    pass "the page: a list of files with links, the same meshes marked, clean files folded"
else
    fail "the page: a list of files with links, the same meshes marked, clean files folded" "$links / $missing / $(grep -o 'data-same="[0-9a-f]*"' worst.html)"
fi
for form in txt html; do
    norma report --merge worst.json -o merged.$form
    case $form in txt) order=$(grep -o '^worst/[a-z/-]*.obj: [a-z]* N' merged.txt | head -n 1) ;; html) order=$(sections merged.html) ;; esac
    if [[ $order == *z-errors.obj* && $order != a-clean* ]] && { [ $form = html ] || grep -q 'Also in worst/c-copy.obj' merged.txt; }; then pass "JSON as $form: the worst first, too"; else fail "JSON as $form: the worst first, too" "$order"; fi
done
if ! norma check worst farm --no-config --info 2>/dev/null | grep -q places && ! grep -q 'places\|Places' farm.html worst.html; then pass "findings are not called places"; else fail "findings are not called places"; fi
norma check "$PWD/worst" --no-config --format text >absolute.txt
norma check "$PWD/worst" --no-config --format html >absolute.html
if cmp -s absolute.txt worst.txt && ! sed 's/data-path="[^"]*"//' absolute.html | grep -qF "$PWD" && norma check "$PWD/worst" --no-config --json | grep -qF "$PWD/worst/a-clean.obj"; then
    pass "paths in the working folder are relative for people, and as they were given for programs"
else
    fail "paths in the working folder are relative for people, and as they were given for programs" "$(diff absolute.txt worst.txt)"
fi
# A normal map whose picture is missing, in three files of different meshes; one has two of them.
python3 -c '
import base64, json, struct
for name, maps, size in (("one", 1, 1), ("two", 2, 2), ("three", 1, 3)):
    data = struct.pack("<9f9f6f", 0, 0, 0, size, 0, 0, 0, size, 0, *(0, 0, 1) * 3, 0, 0, 1, 0, 0, 1)
    json.dump({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "images": [{"uri": "brick%d.png" % i} for i in range(maps)], "textures": [{"source": i} for i in range(maps)], "materials": [{"normalTexture": {"index": i}} for i in range(maps)],
        "meshes": [{"primitives": [{"material": i, "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}} for i in range(maps)]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [size, size, 0]}, {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC3"}, {"bufferView": 0, "byteOffset": 72, "componentType": 5126, "count": 3, "type": "VEC2"}],
        "bufferViews": [{"buffer": 0, "byteLength": 96}], "buffers": [{"byteLength": 96, "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}]}, open("map-%s.gltf" % name, "w"))'
norma check map-*.gltf --no-config >maps.txt
if [ "$(grep -c N002 maps.txt)" -eq 2 ] && grep -q '^map-two.gltf: warning N002 not-checked: 2 textures are missing or cannot be read: image 0 "brick0.png", image 1 "brick1.png"; .* Also in map-one.gltf, map-three.gltf.$' maps.txt; then pass "missing textures are one line, with their names"; else fail "missing textures are one line, with their names" "$(cat maps.txt)"; fi
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n' >sheet.obj
if norma check sheet.obj --no-config | grep -q '^sheet.obj: No problems found (open edges are not looked at in profile render)$' && norma check worst/a-clean.obj --no-config | grep -q '^worst/a-clean.obj: No problems found$'; then pass "what profile render does not look at is said where there are holes"; else fail "what profile render does not look at is said where there are holes"; fi
norma check worst/b-inside-out.obj --no-config --fix-unsafe -o turned.obj >fixed.txt
if grep -q '^    N302 inside-out  *1  *0$' fixed.txt && ! grep -q 'info\|N204\|N104' fixed.txt; then pass "after a fix: what changed, and no totals of informations"; else fail "after a fix: what changed, and no totals of informations" "$(cat fixed.txt)"; fi
# The picture of a finding in a large mesh shows all of it in a corner, the place marked; of a mesh that the close-up shows whole there is no second picture.
awk 'BEGIN { for (i = 0; i < 30; ++i) for (j = 0; j < 15; ++j) print "v", i, j, 0; print "vn 0 0 1\nvn 0 0 0";
    for (i = 0; i < 29; ++i) for (j = 0; j < 14; ++j) { a = i * 15 + j + 1; n = a == 1 ? 2 : 1; printf "f %d//%d %d//1 %d//1 %d//1\n", a, n, a + 15, a + 16, a + 1 } }' >grid.obj
norma check grid.obj --no-config --select N102 -o grid.html >/dev/null
norma check wide.obj --no-config --select N102 -o wide.html >/dev/null
whole() { sed -n '/<title>The whole model/,/<\/g>/p' "$1"; }
filled() { whole "$1" | grep -o 'h[0-9]*' | tr -d h | awk '{ n += $1 } END { print n + 0 }'; }
rows=$(whole grid.html | grep -o 'M[0-9]* [0-9]*.5h[0-9]*' | sort -u | wc -l)
if [ "$rows" -gt 20 ] && [ "$(filled grid.html)" -gt 800 ] && [ "$(filled grid.html)" -lt 2400 ] && whole grid.html | grep -q "<circle cx='[0-9]*' cy='[0-9]*' r='3.5'" && [ -z "$(whole wide.html)" ]; then pass "a picture shows the whole model beside the close-up"; else fail "a picture shows the whole model beside the close-up" "$rows rows, $(filled grid.html) points"; fi
# The same triangles in nodes: a mesh that the scene draws at 300 places in a row is a thin line of them, though one of them fills the close-up.
python3 -c '
import base64, json, struct
data = struct.pack("<9f9f", 0, 0, 0, 1, 0, 0, 0, 1, 0, *(0, 0, 0), 0, 0, 1, 0, 0, 1)
json.dump({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(300))}], "nodes": [{"mesh": 0, "translation": [3 * i, 0, 0]} for i in range(300)],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}}]}], "buffers": [{"byteLength": 72, "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}], "bufferViews": [{"buffer": 0, "byteLength": 72}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}, {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC3"}]}, open("row.gltf", "w"))'
norma check row.gltf --no-config --select N102 -o row.html >/dev/null
if [ "$(filled row.html)" -gt 50 ] && [ "$(filled row.html)" -lt 260 ]; then pass "the whole model is what the nodes draw, at their places"; else fail "the whole model is what the nodes draw, at their places" "$(filled row.html) points"; fi
# 100 kB that ask for 60 million primitives, all at one place, before the one with the finding, aside: that one is drawn, and most others are not even looked at.
python3 -c '
import json
many = json.load(open("row.gltf"))
many["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
many["accessors"].append({"componentType": 5126, "count": 20000, "type": "VEC3"})
many["meshes"].insert(0, {"primitives": [{"attributes": {"POSITION": 0}}] * 3000})
many["nodes"] = [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}}}, {"mesh": 1, "translation": [20, 0, 0]}]
many["scenes"][0]["nodes"] = [0, 1]
json.dump(many, open("many.gltf", "w"))'
(ulimit -t 10; norma check many.gltf --no-config --select N102 -o many.html >/dev/null 2>said)
if [ "$(filled many.html)" -gt 5 ] && [ "$(filled many.html)" -lt 260 ]; then pass "a picture of millions of primitives is drawn at once, with the one meant"; else fail "a picture of millions of primitives is drawn at once, with the one meant" "$(filled many.html) points; $(cat said)"; fi
# 200 kB that ask for 400,000 triangles, each as large as the picture.
python3 -c '
import base64, json, struct
heap = json.load(open("row.gltf"))
data = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0) * 8 + struct.pack("<9f", 0, 0, 0, 0, 0, 1, 0, 0, 1) * 8
heap["buffers"] = [{"byteLength": 576, "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}]
heap["bufferViews"][0]["byteLength"] = 576
for part in 0, 1: heap["accessors"][part].update({"count": 24, "byteOffset": 288 * part})
heap["accessors"].append({"componentType": 5126, "count": 49999, "type": "VEC3"})
heap["nodes"] = [{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 2}}}}]
heap.update({"extensionsUsed": ["EXT_mesh_gpu_instancing"], "scenes": [{"nodes": [0]}], "extras": "x" * 200000})
json.dump(heap, open("heap.gltf", "w"))'
(ulimit -t 10; norma check heap.gltf --no-config --select N102 -o heap.html >/dev/null 2>said)
if [ "$(filled heap.html)" -gt 1000 ]; then pass "a picture of a heap of large triangles is drawn at once"; else fail "a picture of a heap of large triangles is drawn at once" "$(filled heap.html) points; $(cat said)"; fi
finish
