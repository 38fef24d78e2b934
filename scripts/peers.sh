#!/usr/bin/env bash
# Times derivation beside other engines, models read beside other libraries, and centerlines beside VMTK's; times, judges and draws exported trees beside
# ez-tree's. npm's and PyPI's are fetched into the target folder where node and Python are; what cannot be had is left out.
# `scripts/peers.sh [engines|models [FORMAT]|centerlines [MODEL…]|trees [SPECIES…]]`
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
target=${CARGO_TARGET_DIR:-$repository/target}
modules=$target/peers/node_modules

run() { # BINARY ARGUMENTS
    CARGO_TARGET_DIR=$target cargo run --release --quiet --manifest-path "$repository/benches/peers/Cargo.toml" --bin "$1" -- "${@:2}"
}

# Fetches packages of npm in the versions that are wanted.
packages() { # NAME@VERSION…
    local package missing=()
    for package in "$@"; do
        if ! grep -qsF "\"version\": \"${package##*@}\"" "$modules/${package%@*}/package.json"; then missing+=("$package"); fi
    done
    if [ ${#missing[@]} = 0 ]; then return; fi
    if ! command -v npm >/dev/null ||
        ! npm install --prefix "$target/peers" --no-audit --no-fund --loglevel=error "${missing[@]}" >/dev/null; then
        echo "npm's ${missing[*]} cannot be fetched"
        return 1
    fi
}

engines() {
    packages lindenmayer@1.5.4 || true
    RAYON_NUM_THREADS=1 run ramus-peers "$modules"
}

# The first Python from 3.MINOR on, up to 3.14: what is compared has wheels for these.
python() { # MINOR
    local name roots=()
    if command -v pyenv >/dev/null; then
        # pyenv's own names stand for one version only.
        mapfile -t roots < <(printf '%s\n' "$(pyenv root)"/versions/3.*/bin/python3)
    fi
    for name in python3 python3.14 python3.13 python3.12 python3.11 "${roots[@]}"; do
        if "$name" -c "import ensurepip, sys; sys.exit(not (3, $1) <= sys.version_info < (3, 15))" 2>/dev/null; then
            echo "$name"
            return
        fi
    done
    return 1
}

# Makes the environment anew when what it is to hold has changed.
environment() { # FOLDER REQUIREMENTS MINOR WHAT
    local wanted=$repository/benches/peers/$2 python
    if cmp -s "$wanted" "$1/requirements.txt"; then
        return
    fi
    if ! python=$(python "$3"); then
        echo "$4 are not compared: there is no Python from 3.$3 on"
        return 1
    fi
    if ! { "$python" -m venv --clear "$1" && "$1/bin/python" -m pip install --quiet --disable-pip-version-check --retries 1 \
        --only-binary :all: --requirement "$wanted"; } >"$1.log" 2>&1; then
        echo "$4 are not compared: what $2 lists cannot be fetched, $1.log says why"
        return 1
    fi
    cp "$wanted" "$1/requirements.txt"
}

# A shell of its own, which takes away what it made as it ends.
models() ( # [FORMAT]
    local folder
    mkdir -p "$target/peers"
    environment "$target/peers/python" requirements.txt 11 models || return 0
    folder=$(mktemp -d "$target/peers/models.XXXXXX")
    # shellcheck disable=SC2064
    trap "rm -rf '$folder'" EXIT
    run models "$target/peers/python/bin/python" "$folder" "$@"
)

centerlines() ( # [MODEL…]
    local folder models=() model
    mkdir -p "$target/peers"
    environment "$target/peers/vmtk" vmtk.txt 12 centerlines || return 0
    folder=$(mktemp -d "$target/peers/centerlines.XXXXXX")
    # shellcheck disable=SC2064
    trap "rm -rf '$folder'" EXIT
    CARGO_TARGET_DIR=$target cargo build --release --quiet --manifest-path "$repository/Cargo.toml" --bin ramus
    run vessels "$folder"
    for model in "${RAMUS_SHARED:-/nowhere}"/models/truth/*.ply "${RAMUS_SHARED:-/nowhere}"/models/real/*.* "$folder"/*.ply; do
        if [ -f "$model" ] && chosen "$(basename "$model")" "$@"; then models+=("$model"); fi
    done
    PYTHONDONTWRITEBYTECODE=1 "$target/peers/vmtk/bin/python" "$repository/benches/peers/beside_vmtk.py" "$target/release/ramus" "$folder" "${models[@]}"
)

# ez-tree's preset that is nearest to a species: it has oaks, ashes, aspens, pines and bushes.
nearest() { # SPECIES
    case $1 in
    oak) echo oak-large ;;
    birch) echo aspen-large ;;
    spruce) echo pine-large ;;
    maple) echo ash-large ;;
    willow) echo ash-medium ;;
    apple) echo bush-1 ;;
    *) return 1 ;;
    esac
}

# Warnings are told, an error ends the run; so does a file that the validator cannot judge.
valid() { # FILE
    local told
    told=$(node "$repository/scripts/validate-glb.mjs" --modules "$modules" "$1") || true
    echo "$told"
    [[ $told == *": 0 errors,"* ]]
}

# How fast individuals are grown and written, some ten million triangles of them, of three runs the middle one. ez-tree has one thread, and writes nothing.
grown() { # FILE FOLDER THREADS (0: all)
    local export=("$target/release/ramus" export "$1" --format glb --angles 10 --lengths 10 --out "$2" --json) numbers count
    numbers='s/.*"triangles":([0-9]+),"seconds":([-0-9.e]+).*/\1 \2/'
    # What it says besides has been said when the tree itself was written.
    count=$("${export[@]}" --dry-run 2>/dev/null | sed -E "$numbers" | awk '{ print int(1e7 / $1) + 1 }')
    for _ in 1 2 3; do
        RAYON_NUM_THREADS=$3 "${export[@]}" --count "$count" 2>/dev/null
    done | sed -E "$numbers" | sort -g -k 2 | awk -v what="Ramus $(basename "${1%.*}")" -v files="$count files, threads: ${3/#0/all}" \
        'NR == 2 { printf "%s  %d triangles  %.4f s  %.2f million/s  (%s)\n", what, $1, $2, $1 / $2 / 1e6, files }'
    rm -rf "${2:?}"/*
}

draw() { # SHEET LABEL=FILE…
    if ! command -v blender >/dev/null || ! /usr/bin/python3 -c "import numpy" 2>/dev/null; then
        echo "$1 is not drawn: there is no Blender, or no numpy for it (Debian's packages blender and python3-numpy)"
        return
    fi
    blender --background --factory-startup --python-exit-code 1 --python "$repository/benches/peers/pictures.py" -- "$1" 640 "${@:2}" >"$1.log"
}

trees() ( # [SPECIES…]
    local folder=$target/peers/trees names=() name file preset pictures times
    packages three@0.187.0 @dgreenheck/ez-tree@1.1.0 gltf-validator@2.0.0-dev.3.10 || return 0
    CARGO_TARGET_DIR=$target cargo build --release --quiet --manifest-path "$repository/Cargo.toml" --bin ramus
    mkdir -p "$folder"
    # Into memory, where there is a place for it: it is not the disk that is timed.
    times=$(mktemp -d /dev/shm/ramus-peers.XXXXXX 2>/dev/null || mktemp -d "$folder/times.XXXXXX")
    # shellcheck disable=SC2064
    trap "rm -rf '$times'" EXIT
    if [ -n "${1:-}" ]; then
        names=("$@")
    else
        for file in "$repository"/assets/species/*.{lsys,ramus}; do
            if [ -f "$file" ]; then names+=("$(basename "${file%.*}")"); fi
        done
    fi
    for name in "${names[@]}"; do
        # Any grammar can be named, too.
        for file in "$repository"/assets/{species,grammars}/"$name".{lsys,ramus} ""; do
            if [ -f "$file" ]; then break; fi
        done
        if [ -z "$file" ]; then
            echo "there is no $name among the species and the grammars" >&2
            return 1
        fi
        "$target/release/ramus" export "$file" --format glb --out "$folder"
        valid "$folder/$name.glb"
        grown "$file" "$times" 1
        grown "$file" "$times" 0
        pictures=("Ramus $name=$folder/$name.glb")
        if preset=$(nearest "$name"); then
            node "$repository/benches/peers/ez_tree.mjs" "$modules" --time "$preset"
            node "$repository/benches/peers/ez_tree.mjs" "$modules" "$folder" "$preset"
            pictures+=("ez-tree $preset=$folder/$preset.glb")
        fi
        draw "$folder/$name.png" "${pictures[@]}"
    done
)

# Whether a name has one of some parts in it; all names do where none is asked for.
chosen() { # NAME [PART…]
    local name=$1 part
    if [ $# = 1 ]; then return; fi
    for part in "${@:2}"; do
        if [[ $name == *$part* ]]; then return; fi
    done
    return 1
}

what=${1:-all}
case $what in
all)
    engines
    models ""
    centerlines ""
    trees ""
    ;;
engines | models | centerlines | trees) "$what" "${@:2}" ;;
*)
    echo "scripts/peers.sh knows engines, models, centerlines and trees, not $what" >&2
    exit 1
    ;;
esac
