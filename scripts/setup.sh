#!/usr/bin/env bash
# Installs what is missing: setup.sh run | test | doc | fuzz
#
#   run   what building and starting Ramus needs
#   test  that, and what the tests need
#   doc   what `make doc` needs
#   fuzz  what `make fuzz` needs
#
# Quick when nothing is missing. On Debian and Ubuntu it installs (as root or by
# sudo); on other systems it names the packages and goes on. RAMUS_SETUP=no skips it.
set -euo pipefail

goal=${1:-run}
repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=apt.sh
. "$repository/scripts/apt.sh"
tools=${CARGO_TARGET_DIR:-$repository/target}/tools
export PATH="$tools/bin:$PATH"

# Mesa before 25 draws only one eye in a multiview pass on its software device.
mesa_wanted=25

say() { echo "setup: $*"; }

has() { command -v "$1" >/dev/null 2>&1; }

# apt_get WHAT ARGUMENT…: one line while apt works, its output only where it fails.
apt_get() {
    local log code=0
    log=$(mktemp)
    quietly "$log" "setup: $1" as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y "${@:2}" || code=$?
    [ "$code" -ne 0 ] || rm -f "$log"
    return "$code"
}

apt_update() { apt_get "reading the package lists" update; }

mesa_version() { dpkg-query -W -f '${Version}' mesa-vulkan-drivers 2>/dev/null || true; }

# The backports source has the mirror, key and options of the one that is there.
add_backports() {
    local suite=$1-backports source kind file
    apt_source_for "$suite" "$suite" >/dev/null && return 0
    source=$(apt_source_for "$1" "$suite") || {
        say "no apt source for $1 found under /etc/apt, so $suite cannot be added"
        return 1
    }
    kind=${source%%$'\n'*}
    file=/etc/apt/sources.list.d/$suite.$kind
    say "adding $suite as $file"
    printf '%s\n' "${source#*$'\n'}" | as_root tee "$file" >/dev/null
}

debian_family() {
    local wanted=() missing=() mesa updated=
    wanted=(libvulkan1 libopenxr-loader1)
    has cc || wanted+=(gcc libc6-dev)
    has c++ || wanted+=(g++)
    has pkg-config || wanted+=(pkg-config)
    if [ "$goal" = test ]; then
        wanted+=(vulkan-validationlayers)
        # A desktop without a screen, and a hand at its pointer and keyboard; the libraries are those that a window opens.
        wanted+=(xvfb xdotool libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0)
        has node || wanted+=(nodejs)
        has npm || wanted+=(npm)
        # Snakemake and trimesh, which tests put into the target folder.
        python3 -c 'import ensurepip, venv' >/dev/null 2>&1 || wanted+=(python3-venv)
    fi
    local package
    for package in "${wanted[@]}"; do
        installed "$package" || missing+=("$package")
    done
    if [ ${#missing[@]} -gt 0 ]; then
        apt_update || return 1
        updated=yes
        apt_get "installing ${missing[*]}" install --no-install-recommends "${missing[@]}" || return 1
    fi

    mesa=$(mesa_version)
    if [ -z "$mesa" ] || dpkg --compare-versions "$mesa" lt "$mesa_wanted"; then
        local from=()
        if [ "$VERSION_CODENAME" = bookworm ] && add_backports bookworm; then
            from=(-t bookworm-backports)
            updated=''
        fi
        [ -n "$updated" ] || apt_update || return 1
        apt_get "installing Mesa's Vulkan drivers, version $mesa_wanted or newer (here: ${mesa:-none})" \
            install --no-install-recommends "${from[@]}" mesa-vulkan-drivers || return 1
        mesa=$(mesa_version)
        if dpkg --compare-versions "$mesa" lt "$mesa_wanted"; then
            say "this system's Mesa is $mesa: Ramus runs, but without a graphics card it draws each eye in a pass of its own"
        fi
    fi
}

other_system() {
    say "this is ${PRETTY_NAME:-an unknown system}; Ramus needs a Vulkan driver, the Vulkan and OpenXR loaders and a C++ compiler:"
    say "  Fedora:   sudo dnf install vulkan-loader mesa-vulkan-drivers openxr-libs gcc-c++ vulkan-validation-layers nodejs npm python3"
    say "  Arch:     sudo pacman -S --needed vulkan-icd-loader vulkan-swrast openxr gcc vulkan-validation-layers nodejs npm python3"
    say "  openSUSE: sudo zypper install libvulkan1 libvulkan_lvp libopenxr_loader1 gcc-c++ vulkan-validationlayers nodejs npm python3"
}

# A cargo tool of our own under target/tools, where the machine has none.
cargo_tool() {
    local command=$1 crate=$2
    has "$command" && return 0
    say "building $crate into $tools (a few minutes, once)"
    # Apart from the caller's flags: tools are not linted or instrumented.
    env -u RUSTFLAGS -u CARGO_ENCODED_RUSTFLAGS CARGO_TARGET_DIR="$tools/build" \
        cargo install --locked --root "$tools" "$crate"
    rm -rf "$tools/build"
}

if [ "${RAMUS_SETUP:-yes}" = no ]; then
    exit 0
fi
has cargo || {
    say "no cargo found: install Rust from https://rustup.rs first" >&2
    exit 1
}

if [ "$goal" != doc ]; then
    PRETTY_NAME='' VERSION_CODENAME=''
    # shellcheck disable=SC1091
    [ -r /etc/os-release ] && . /etc/os-release
    if has apt-get && has dpkg-query; then
        debian_family || say "not everything could be installed; going on: \`ramus doctor\` tells what is missing"
    elif ! ldconfig -p 2>/dev/null | grep -q 'libvulkan\.so\.1' || ! ldconfig -p 2>/dev/null | grep -q 'libopenxr_loader\.so\.1'; then
        other_system
    fi
fi
case "$goal" in
run) ;;
test) cargo_tool cargo-nextest cargo-nextest ;;
doc) cargo_tool mdbook mdbook ;;
fuzz) cargo_tool cargo-fuzz cargo-fuzz ;;
*)
    say "what for? run, test, doc or fuzz" >&2
    exit 2
    ;;
esac
