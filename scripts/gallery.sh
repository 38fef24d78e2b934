#!/usr/bin/env bash
# Draws the pictures of the gallery (docs/src/gallery.md): gallery.sh RAMUS [NAME…] (all when none is named)
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
pictures=$repository/docs/src/images/gallery
ramus=$1
shift

# What stands on the stage; the others are drawn on paper.
stage=' bush fern honda ternary-d '

mkdir -p "$pictures"
for file in "$repository"/assets/grammars/*.lsys; do
    name=$(basename "$file" .lsys)
    if [ $# -gt 0 ] && [[ " $* " != *" $name "* ]]; then
        continue
    fi
    backdrop=paper
    [[ $stage != *" $name "* ]] || backdrop=stage
    "$ramus" derive "$file" --backdrop "$backdrop" --size 256 --png "$pictures/$name.png"
done
