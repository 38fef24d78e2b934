#!/usr/bin/env bash
# Times derivation beside other engines, and models read beside other libraries. npm's and PyPI's are fetched into the target
# folder where node and Python are; what cannot be had is left out. `scripts/peers.sh [engines|models [FORMAT]]`
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

# The first Python that numpy has a wheel for.
python() {
    local name
    for name in python3 python3.14 python3.13 python3.12 python3.11; do
        if "$name" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
            echo "$name"
            return
        fi
    done
    return 1
}

# Makes the environment anew when what it is to hold has changed.
environment() { # FOLDER
    local wanted=$repository/benches/peers/requirements.txt python
    if cmp -s "$wanted" "$1/requirements.txt"; then
        return
    fi
    if ! python=$(python); then
        echo "models are not compared: there is no Python from 3.11 on"
        return 1
    fi
    if ! { "$python" -m venv --clear "$1" && "$1/bin/python" -m pip install --quiet --disable-pip-version-check --retries 1 \
        --only-binary :all: --requirement "$wanted"; } >"$target/peers/python.log" 2>&1; then
        echo "models are not compared: trimesh, PyVista and meshio cannot be fetched, $target/peers/python.log says why"
        return 1
    fi
    cp "$wanted" "$1/requirements.txt"
}

models() {
    local folder
    mkdir -p "$target/peers"
    environment "$target/peers/python" || return 0
    folder=$(mktemp -d "$target/peers/models.XXXXXX")
    # shellcheck disable=SC2064
    trap "rm -rf '$folder'" EXIT
    run models "$target/peers/python/bin/python" "$folder" "$@"
}

what=${1:-all}
if [ "$what" != models ]; then engines; fi
if [ "$what" != engines ]; then models "${@:2}"; fi
