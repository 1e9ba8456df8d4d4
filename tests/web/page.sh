#!/bin/bash
# The playground and `norma view` in a browser: what tests/web/page.mjs does there. Screenshots are left in the tree under test, in web/screenshots.
#   tests/web/page.sh              in headless Chromium
#   tests/web/page.sh --firefox    in Firefox on a display of its own (make firefox; several minutes)
# shellcheck disable=SC2016  # single quotes hold what inner shells expand
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
tool=${NORMA_BIN:-$tree/bin/norma}

if [ ! -f "$tree/web/norma.html" ]; then
    skip "the page (this tree is built without -DNORMA_WEB=ON)"
    finish
    exit
fi
check "the page is one file that names no address to load from (links that people press aside)" bash -c '! sed -E "s/<a href=[^>]*>//g" "$0" | grep -qE "(src|href)=\"?(https?:)?//|@import|url\("' "$tree/web/norma.html"
check "the page, three.js in it, is at most 1 MB compressed" node -e 'process.exit(require("zlib").gzipSync(require("fs").readFileSync(process.argv[1]), { level: 9 }).length > 1000000 ? 1 : 0)' "$tree/web/norma.html"
check "norma view writes to standard output" bash -c '"$0" view assets/dodecahedron.obj -o - 2>/dev/null | tail -n 1 | grep -q "</html>"' "$tool"
check "norma view leaves nothing behind where it fails" bash -c '! "$0" view tests/cli/golden/files/malformed.obj -o "$1/x.html" 2>/dev/null && [ -z "$(ls -A "$1")" ]' "$tool" "$(mkdir -p "$scratch/empty" && echo "$scratch/empty")"
browser=${1:-}
browser=${browser#--}
if [ "$browser" = firefox ]; then
    for need in firefox-esr Xvfb; do
        if ! command -v $need >/dev/null; then skip "the page in Firefox ($need is not installed: scripts/install-deps.sh firefox)"; finish; exit; fi
    done
    Xvfb -displayfd 3 -screen 0 1600x1000x24 -nolisten tcp 3>"$scratch/display" >/dev/null 2>&1 &
    xvfb=$!
    trap 'kill $xvfb; [ -n "${NORMA_SCRATCH:-}" ] || rm -rf "$scratch"' EXIT
    for _ in $(seq 100); do [ -s "$scratch/display" ] && break; sleep 0.1; done
    DISPLAY=:$(cat "$scratch/display")
    export DISPLAY
elif ! command -v chromium >/dev/null && ! command -v google-chrome >/dev/null && [ -z "${NORMA_CHROME:-}" ]; then
    skip "the page in a browser (chromium is not installed: scripts/install-deps.sh)"
    finish
    exit
fi
relay "${browser:-browser}" node tests/web/page.mjs "$tree/web" "$tool" "$tree/web/screenshots${browser:+-$browser}" "$browser"
finish
