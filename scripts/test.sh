#!/usr/bin/env bash
# Everything that CI checks, stage by stage: test.sh [STAGE…] (all when none is named)
#
# One target folder and one profile (dev, optimised lightly) serve all stages, so
# nothing is built twice. Each stage's time is printed; the first failure ends it.
set -euo pipefail

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$repository"
target=${CARGO_TARGET_DIR:-$repository/target}
stages=(scripts fmt clippy fuzz docs validator trimesh driver monado build-tests doctests tests run workflow)

if [ "${1:-}" = --list ]; then
    echo "${stages[*]}"
    exit 0
fi
[ $# -eq 0 ] || stages=("$@")

# Pictures must not depend on the machine's graphics card: Mesa's software device draws
# them, unless RAMUS_TEST_GPU asks for the card.
if [ -z "${RAMUS_TEST_GPU:-}" ]; then
    for driver in /usr/share/vulkan/icd.d/lvp_icd*.json; do
        [ -r "$driver" ] && export VK_DRIVER_FILES=$driver VK_ICD_FILENAMES=$driver
    done
fi
# Everything that draws does so under the validation layers, and fails on any message.
export RAMUS_VALIDATION=1

summary=''

# Shell scripts parse; the linter looks at them where there is one.
stage_scripts() {
    local script
    for script in .ci/run scripts/*.sh xr/monado/*.sh; do
        bash -n "$script"
    done
    if command -v shellcheck >/dev/null 2>&1; then
        shellcheck -x -P SCRIPTDIR .ci/run scripts/*.sh xr/monado/*.sh
    fi
}

stage_fmt() { cargo fmt --all --check; }

stage_clippy() { cargo clippy --workspace --all-targets --quiet -- -D warnings; }

# The fuzz targets are a workspace of their own, so no other stage sees them; here they compile, `make fuzz` runs them.
stage_fuzz() { CARGO_TARGET_DIR=$target cargo check --manifest-path fuzz/Cargo.toml --locked --quiet; }

stage_docs() { RUSTDOCFLAGS='-D warnings' cargo doc --workspace --no-deps --quiet; }

# npm's glTF validator, the judge of exported files.
stage_validator() {
    [ -f tests/node/package.json ] || { echo "no tests/node here"; return 0; }
    if [ tests/node/package-lock.json -nt tests/node/node_modules/.package-lock.json ]; then
        (cd tests/node && npm ci --no-audit --no-fund --loglevel=error)
    fi
}

# Debian 12's own driver, whose multiview is broken, unpacked beside the installed one: the fallback is tested on it.
stage_driver() {
    local folder=$target/mesa22 parts
    [ ! -r "$folder/lvp_icd.json" ] || return 0
    if ! grep -qs '^VERSION_CODENAME=bookworm' /etc/os-release; then
        echo "driver: only Debian 12 has the broken one; the fallback's test on it is skipped"
        return 0
    fi
    parts=$(mktemp -d)
    if ! (cd "$parts" && apt-get download -q mesa-vulkan-drivers/bookworm && dpkg -x ./*.deb tree); then
        echo "driver: the old driver cannot be had; away from CI the fallback's test on it is skipped"
        rm -rf "$parts"
        [ "${CI:-}" != true ]
        return
    fi
    mkdir -p "$folder"
    cp "$parts"/tree/usr/lib/*/libvulkan_lvp.so "$folder"
    sed "s|\"library_path\": *\"[^\"]*\"|\"library_path\": \"$folder/libvulkan_lvp.so\"|" \
        "$parts"/tree/usr/share/vulkan/icd.d/lvp_icd*.json >"$folder/lvp_icd.json"
    rm -rf "$parts"
}

# The real OpenXR runtime. Away from CI the tests that need it are skipped where it cannot be had.
stage_monado() {
    if ! xr/monado/make-root.sh && [ "${CI:-}" = true ]; then
        return 1
    fi
}

# A Python from 3.11 on, under the target folder, with what a list of PyPI's requires; made anew when the list is another. Its log is the folder's name with .log.
python_with() { # LIST FOLDER
    ! cmp -s "$1" "$2/requirements.txt" || return 0
    local python
    for python in python3 python3.14 python3.13 python3.12 python3.11; do
        if "$python" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then
            "$python" -m venv --clear "$2" &&
                "$2/bin/python" -m pip install --quiet --disable-pip-version-check --requirement "$1" &&
                cp "$1" "$2/requirements.txt"
            return
        fi
    done >"$2.log" 2>&1
    echo "there is no Python from 3.11 on with venv: scripts/setup.sh test installs it on Debian and Ubuntu" >>"$2.log"
    return 1
}

# PyPI's trimesh, which reads exported files.
stage_trimesh() {
    local folder=$target/trimesh
    if ! python_with tests/python/requirements.txt "$folder"; then
        tail -n 3 "$folder.log"
        echo "trimesh cannot be had ($folder.log says why); away from CI the test that reads files with it is skipped"
        [ "${CI:-}" != true ]
    fi
}

stage_build-tests() { cargo nextest run --workspace --no-run --cargo-quiet; }

stage_doctests() { cargo test --workspace --doc --quiet; }

stage_tests() {
    local log=$target/nextest.log failed=''
    [ ! -r "$target/mesa22/lvp_icd.json" ] || export RAMUS_BROKEN_DRIVER=$target/mesa22/lvp_icd.json
    ! cmp -s tests/python/requirements.txt "$target/trimesh/requirements.txt" || export RAMUS_TRIMESH=$target/trimesh/bin/python
    cargo nextest run --workspace --cargo-quiet --no-fail-fast --color never 2>&1 | tee "$log" || failed=yes
    summary=$(grep -E '^ *Summary \[' "$log" | tail -n 1)
    [ -z "$failed" ]
}

# What `make run` starts, on the simulated headset, in a folder of its own.
stage_run() {
    local folder=$target/run-check
    # The tests' own build: another would build the libraries again for other features.
    stage_build-tests
    rm -rf "$folder"
    mkdir -p "$folder"
    # No runtime and no desktop may answer here: this is about the machine without either.
    (cd "$folder" && env -u DISPLAY -u WAYLAND_DISPLAY XR_LOADER_DEBUG=none XR_RUNTIME_JSON=/dev/null "$target/debug/ramus")
    local kind
    for kind in ramus glb png; do
        if [ -z "$(find "$folder/out" -name "*.$kind" -size +0 2>/dev/null)" ]; then
            echo "the program left no .$kind file in $folder/out"
            return 1
        fi
    done
}

# The Snakemake workflow, on two cores here, makes what `ramus cohort` makes, byte for byte.
stage_workflow() {
    local folder=$target/snakemake
    if ! python_with workflows/requirements.txt "$folder"; then
        tail -n 3 "$folder.log"
        echo "workflow: Snakemake cannot be had ($folder.log says why); away from CI the workflow's test is skipped"
        [ "${CI:-}" != true ]
        return
    fi
    stage_build-tests
    scripts/workflow.sh "$target/debug/ramus" "$folder/bin/python" "$target/workflow-check"
}

began=$SECONDS
for stage in "${stages[@]}"; do
    if ! declare -F "stage_$stage" >/dev/null; then
        echo "there is no stage $stage; there are: $("${BASH_SOURCE[0]}" --list)" >&2
        exit 2
    fi
    echo "== $stage"
    stage_began=$SECONDS
    code=0
    # In a subshell of its own, so that `set -e` holds inside the stage.
    if [ "$stage" = tests ]; then
        stage_tests || code=$?
    else
        set +e
        (set -e; "stage_$stage")
        code=$?
        set -e
    fi
    if [ "$code" -ne 0 ]; then
        echo "== $stage failed after $((SECONDS - stage_began)) s"
        [ -z "$summary" ] || echo "$summary"
        # A full disk or memory ends a compiler without saying so.
        df -h "$target" || true
        free -m || true
        exit 1
    fi
    echo "== $stage: $((SECONDS - stage_began)) s"
done
echo "== all stages passed in $((SECONDS - began)) s"
if [ -n "$summary" ]; then
    echo "$summary"
fi
