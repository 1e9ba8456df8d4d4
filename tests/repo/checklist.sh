#!/bin/bash
# The checklists of CONTRIBUTING.md (scripts/checklist.sh) are true: every weight, rule, format and verb that is there is named in all places of its list, and one that is not
# there is missed. No line of CONTRIBUTING.md and CHANGELOG.md is longer than 120 columns.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
check "every weight, rule, format and verb is in all places of its list" scripts/checklist.sh
for made in "weight steep" "rule N999" "format xyz" "verb sing"; do
    # shellcheck disable=SC2086  # two words
    if said=$(scripts/checklist.sh $made); then fail "a $made is missed" "$said"; else check "a $made is missed in more than three places" test "$(grep -c '^MISSING' <<<"$said")" -gt 3; fi
done
wide=$(awk 'length > 120 { print FILENAME ":" FNR ": " length }' CONTRIBUTING.md CHANGELOG.md)
if [ -z "$wide" ]; then pass "no line of CONTRIBUTING.md and CHANGELOG.md is longer than 120 columns"; else fail "no line of CONTRIBUTING.md and CHANGELOG.md is longer than 120 columns" "$wide"; fi
finish
