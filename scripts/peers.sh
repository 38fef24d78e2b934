#!/usr/bin/env bash
# Times derivation beside other engines, models read beside other libraries, and centerlines beside VMTK's. npm's and PyPI's are fetched
# into the target folder where node and Python are; what cannot be had is left out.
# `scripts/peers.sh [engines|models [FORMAT]|centerlines [MODEL…]]`
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
target=${CARGO_TARGET_DIR:-$repository/target}

run() { # BINARY ARGUMENTS
    CARGO_TARGET_DIR=$target cargo run --release --quiet --manifest-path "$repository/benches/peers/Cargo.toml" --bin "$1" -- "${@:2}"
}

engines() {
    local modules=$target/peers/node_modules
    if command -v npm >/dev/null && [ ! -d "$modules/lindenmayer" ]; then
        npm install --prefix "$target/peers" --no-audit --no-fund --loglevel=error lindenmayer@1.5.4 >/dev/null ||
            echo "npm's lindenmayer cannot be fetched"
    fi
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
    ;;
engines | models | centerlines) "$what" "${@:2}" ;;
*)
    echo "scripts/peers.sh knows engines, models and centerlines, not $what" >&2
    exit 1
    ;;
esac
