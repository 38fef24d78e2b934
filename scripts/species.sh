#!/usr/bin/env bash
# Draws the species' pictures: those on the bench's tab, and the guide's, in summer, autumn and winter and in other light.
# `scripts/species.sh [RAMUS]`, where RAMUS is the program (built when it is not named).
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$repository"
ramus=${1:-}
if [ -z "$ramus" ]; then
    cargo build --quiet
    ramus=${CARGO_TARGET_DIR:-target}/debug/ramus
fi
pictures=docs/src/images/species
mkdir -p "$pictures"
for project in assets/species/*.ramus; do
    name=$(basename "$project" .ramus)
    "$ramus" export "$project" --sheet "${project%.ramus}.png" --size 160 >/dev/null
    for season in summer autumn winter; do
        "$ramus" export "$project" --season "$season" --sheet "$pictures/$name-$season.png" --size 160 >/dev/null
    done
done
UPDATE_SNAPSHOTS=1 cargo test --quiet --test panels -- --ignored species_in_other_light
