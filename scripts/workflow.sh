#!/usr/bin/env bash
# The workflow makes the very files that `ramus cohort` makes: workflow.sh RAMUS PYTHON FOLDER
#
# PYTHON has Snakemake; FOLDER is made anew and left for whoever wants to look.
set -euo pipefail

ramus=$1 python=$2 folder=$3
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
rm -rf "$folder"
mkdir -p "$folder/models"
cd "$folder"

# Six skeletons in two groups, one of no group, a surface with its endpoints beside it, one without, and one that is broken.
"$python" - <<'PYTHON'
import math

groups = ["model,group"]
for place in range(7):
    size = 1 + place / 5
    nodes = [(0, 0, 0, 4, -1), (0, 60, 0, 3, 1), (20 + place, 100, 0, 2, 2), (-20, 90, 10, 2, 2)]
    with open(f"models/tree {place}.swc", "w") as out:
        for number, (x, y, z, radius, parent) in enumerate(nodes, 1):
            print(number, 3, x * size, y * size, z * size, radius * size, parent, file=out)
    if place < 6:
        groups.append(f"tree {place},{'small' if place < 3 else 'large'}")
with open("groups.csv", "w") as out:
    print(*groups, sep="\n", file=out)

around, rows = 24, 31
for name in ("tube", "other"):
    with open(f"models/{name}.obj", "w") as out:
        for row in range(rows):
            for column in range(around):
                angle = column / around * math.tau
                print("v", row, 2 * math.cos(angle), 2 * math.sin(angle), file=out)
        corner = lambda column, row: row * around + column % around + 1
        for row in range(rows - 1):
            for column in range(around):
                print("f", corner(column, row), corner(column + 1, row), corner(column + 1, row + 1), corner(column, row + 1), file=out)
with open("models/tube.endpoints.csv", "w") as out:
    print("kind,x,y,z\nsource,0,0,0\ntarget,30,0,0", file=out)
with open("models/broken.obj", "w") as out:
    print("v 1 2", file=out)
PYTHON

join() {
    "$python" -m snakemake --snakefile "$repository/workflows/Snakefile" --cores 2 --quiet all \
        --config "ramus=$ramus" models=models groups=groups.csv out=joined
}

join
code=0
"$ramus" cohort models --groups groups.csv --out at-once || code=$?
[ "$code" -eq 1 ] || {
    echo "workflow: ramus cohort ended with $code; the broken model makes it 1" >&2
    exit 1
}
compared=0
for file in at-once/*; do
    cmp "$file" "joined/${file#at-once/}"
    compared=$((compared + 1))
done
[ "$compared" -eq 12 ] || {
    echo "workflow: $compared files instead of 12" >&2
    exit 1
}
grep -q '^broken.obj,,.*broken.obj' joined/models.csv
# Nothing is done twice, and of what is changed no more than that.
before=$(stat -c %Y "joined/analyses/"*)
sleep 1.1
echo '# looked at' >>"models/tree 0.swc"
join
after=$(stat -c %Y "joined/analyses/"*)
changed=$(diff <(echo "$before") <(echo "$after") | grep -c '^>' || true)
# That model's analysis, and the list of them.
[ "$changed" -eq 2 ] || {
    echo "workflow: $changed files were made anew instead of 2" >&2
    exit 1
}
echo "workflow: $compared files are the same, byte for byte"
