#!/usr/bin/env bash
# Times derivation beside other engines; npm's is fetched into the target folder where node is.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
target=${CARGO_TARGET_DIR:-$repository/target}
modules=$target/peers/node_modules

if command -v npm >/dev/null && [ ! -d "$modules/lindenmayer" ]; then
    npm install --prefix "$target/peers" --no-audit --no-fund --loglevel=error lindenmayer@1.5.4 >/dev/null ||
        echo "npm's lindenmayer cannot be fetched"
fi
CARGO_TARGET_DIR=$target RAYON_NUM_THREADS=1 \
    cargo run --release --quiet --manifest-path "$repository/benches/peers/Cargo.toml" -- "$modules"
