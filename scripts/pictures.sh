#!/usr/bin/env bash
# Draws the pictures of the page on the language (docs/src/language.md) from the grammars above them: pictures.sh RAMUS
#
# A block that begins with "```lsys NAME OPTION…" is drawn into docs/src/images/language/NAME.png.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
page=$repository/docs/src/language.md
pictures=$repository/docs/src/images/language
ramus=$1

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$pictures"
grep -E '^```lsys [a-z]' "$page" | while read -r _ name options; do
    awk -v name="$name" '$1 == "```" { on = 0 } on { print } $1 == "```lsys" && $2 == name { on = 1 }' "$page" >"$work/$name.lsys"
    # shellcheck disable=SC2086 # options are words
    "$ramus" derive "$work/$name.lsys" $options --backdrop paper --size 256 --png "$pictures/$name.png"
done
