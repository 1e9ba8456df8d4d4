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
if [[ $before == *"Fix: norma"* && $after == *N401* && $after != *"Fix: "* ]]; then pass "a fix that was tried is not offered again"; else fail "a fix that was tried is not offered again" "$before / $after"; fi

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

# ---- shards and their merge: every file once, the report and the status of one run
mkdir farm farm/sub
for i in $(seq 1 13); do printf "$bad" >"farm/$i.obj"; done
for i in $(seq 1 5); do printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >"farm/sub/clean $i.obj"; done
printf 'f 1 2 3\n' >farm/broken.obj
for form in json sarif; do
    norma check farm -o "whole.$form" >/dev/null 2>&1
    whole=$?
    parts=()
    for i in 1 2 3 4; do
        norma check farm --shard $i/4 -o "part$i.$form" >/dev/null 2>&1
        parts=("part$i.$form" "${parts[@]}")
    done
    norma report --merge "${parts[@]}" -o "merged.$form"
    merged=$?
    # The whole run keeps the order of its folders; paths are sorted here.
    same=$(node -e '
        const [whole, merged] = process.argv.slice(1).map((name) => JSON.parse(require("fs").readFileSync(name)));
        const order = (list, key) => list.sort((a, b) => Buffer.compare(Buffer.from(key(a)), Buffer.from(key(b))));
        const path = (result) => result.locations[0].physicalLocation.artifactLocation.uri;
        if (whole.files) order(whole.files, (file) => file.path); else order(whole.runs[0].results, path);
        const paths = merged.files ? merged.files.map((file) => file.path) : merged.runs[0].results.map(path);
        console.log(require("util").isDeepStrictEqual(whole, merged) && paths.length >= 14);' "whole.$form" "merged.$form")
    if [ "$same" = true ] && [ $whole -eq 3 ] && [ $merged -eq 3 ]; then pass "four shards in $form, merged: as one run"; else fail "four shards in $form, merged: as one run" "$same, $whole, $merged"; fi
done
for status in 0 1; do
    fail_on=$([ $status -eq 1 ] && echo info || echo never)
    norma check farm/sub --shard 1/2 --fail-on $fail_on -o a.json >/dev/null
    norma check farm/sub --shard 2/2 --fail-on $fail_on -o b.json >/dev/null
    norma report --merge a.json b.json -o ab.json
    merged=$?
    if [ $merged -eq $status ]; then pass "--fail-on $fail_on is kept: status $status"; else fail "--fail-on $fail_on is kept: status $status" "$merged"; fi
done
norma check farm/sub --shard 9/9 -o empty.json >/dev/null 2>&1
status=$?
norma report --merge a.json b.json empty.json -o abc.json >/dev/null 2>&1
if [ $status -eq 0 ] && cmp -s ab.json abc.json; then pass "a shard without files is a report like others"; else fail "a shard without files is a report like others" "$status"; fi
for wrong in 0/3 4/3 3 1/0 a/b 1/2/3; do
    norma check farm --shard $wrong >/dev/null 2>err
    status=$?
    if [ $status -eq 2 ] && grep -q 'expected I/N' err; then pass "--shard $wrong is a usage error"; else fail "--shard $wrong is a usage error" "$(cat err)"; fi
done
norma report --merge part1.json part1.sarif -o mixed.json 2>err
status=$?
if [ $status -eq 3 ] && [ ! -e mixed.json ]; then pass "reports of two kinds are refused, and nothing is written"; else fail "reports of two kinds are refused, and nothing is written" "$status: $(cat err)"; fi
norma check farm -o whole.html >/dev/null 2>&1
for i in 1 2 3 4; do norma check farm --shard $i/4 -o "part$i.html" >/dev/null 2>&1; done
norma report --merge part4.html part?.html -o twice.html
norma report --merge part?.html -o merged.html
status=$?
sections() { grep -o '<section class="file" data-path="[^"]*"' "$1" | LC_ALL=C sort; }
totals() { sed -n 's/.*id="totals">//p' "$1"; }
if [ $status -eq 3 ] && [ "$(sections merged.html)" = "$(sections whole.html)" ] && [ "$(totals merged.html)" = "$(totals whole.html)" ] && [ "$(sections merged.html | wc -l)" -eq 19 ] &&
    [ "$(grep -c '<svg' merged.html)" -eq "$(grep -c '<svg' whole.html)" ] && [ "$(sections twice.html | wc -l)" -gt 19 ]; then
    pass "four pages, merged: as one run, with pictures"
else
    fail "four pages, merged: as one run, with pictures" "$status; $(totals merged.html); $(totals whole.html)"
fi
norma report --merge part?.json --format line >merged.txt
norma check farm --format line >whole.txt 2>/dev/null
if [ -s merged.txt ] && cmp -s <(sort merged.txt) <(sort whole.txt); then pass "JSON becomes lines"; else fail "JSON becomes lines" "$(diff <(sort merged.txt) <(sort whole.txt))"; fi

# ---- the page, and the manual of rules
norma check farm -o farm.html >/dev/null 2>&1
if [ "$(grep -c '<section class="file"' farm.html)" -eq 19 ] && [ "$(grep -c "class='m'" farm.html)" -ge 1 ] && [ "$(stat -c %s farm.html)" -lt 1000000 ] && grep -q '<article class="meaning" id="N102">' farm.html && grep -q 'href="#N102"' farm.html; then
    pass "the page has each file, marked faces and what the rules mean"
else
    fail "the page has each file, marked faces and what the rules mean" "$(grep -c '<section class="file"' farm.html) files, $(stat -c %s farm.html) bytes"
fi
# A corner that lies 1e38 sides of its neighbour away: of it only the direction shows, in numbers that a browser can draw.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 3e38 1e38 0\nv 1e38 3e38 2e38\nvn 0 0 0\nvn 0 0 1\nf 1//1 2//2 3//2\nf 1//2 4//2 5//2\n' >far.obj
norma check far.obj --no-config -o far.html >/dev/null 2>&1
if grep -q "<path class='m' d='" far.html && ! grep -Eq "d='[^']*[0-9]{10}" far.html; then pass "a picture of distant corners keeps to small numbers"; else fail "a picture of distant corners keeps to small numbers" "$(grep -o "d='[^']*'" far.html)"; fi
norma explain -o rules.html
without=""
for id in $(norma explain | cut -d ' ' -f 1); do
    [ "$(sed -n "/ id=\"$id\"/,/<\/article>/p" rules.html | grep -c '<svg .*<path')" -eq 2 ] || without+=" $id"
done
if [ -z "$without" ]; then pass "the manual has a picture of wrong and one of right for every rule"; else fail "the manual has a picture of wrong and one of right for every rule" "$without"; fi
finish
