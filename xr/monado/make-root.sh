#!/usr/bin/env bash
# Makes the place where the real OpenXR runtime of the tests lives, once.
#
# Debian 13 and Ubuntu 24.04 package Monado: there it is installed beside the
# rest of the system. On Debian 12 those packages would replace the C library, so
# a Debian 13 root is made under target/ (about two minutes, 1.2 GB) and
# enter.sh runs commands inside it. Any other system: says so and exits with 3.
#
# RAMUS_MONADO_ROOT names another folder for the root (to share it between clones).
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
repository=$(cd "$here/../.." && pwd)
# shellcheck source=../../scripts/apt.sh
. "$repository/scripts/apt.sh"

root=${RAMUS_MONADO_ROOT:-$repository/target/monado-root}
release=trixie
mapfile -t packages <"$here/packages.txt"
# A root is whole when its stamp names this recipe; raise the number when the way it is made changes.
recipe="1 $release ${packages[*]}"

is_ready() { [ "$(cat "$root/.ready" 2>/dev/null)" = "$recipe" ]; }
is_ready && exit 0
if ! command -v apt-get >/dev/null 2>&1; then
    echo "monado: no apt here, so the real-runtime tests cannot be set up (they need Debian 12 or 13, or Ubuntu 24.04 and later)" >&2
    exit 3
fi
# shellcheck disable=SC1091
. /etc/os-release

case "${ID:-}:${VERSION_ID:-}" in
debian:12) ;;
debian:1[3-9] | ubuntu:2[4-9].*)
    installed "${packages[@]}" && exit 0
    echo "monado: installing ${packages[*]}"
    as_root apt-get update -q
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${packages[@]}"
    exit 0
    ;;
*)
    echo "monado: the real-runtime tests need Debian 12 or 13, or Ubuntu 24.04 and later; this is ${PRETTY_NAME:-another system}" >&2
    exit 3
    ;;
esac

address=$(apt_address_for "$VERSION_CODENAME") || {
    echo "monado: no apt source for $VERSION_CODENAME found under /etc/apt, so there is no mirror to make the root from" >&2
    exit 1
}
key=$(apt_key_for "$VERSION_CODENAME")
key=${key:-/usr/share/keyrings/debian-archive-keyring.gpg}

mkdir -p "$(dirname "$root")"
# Two runs that share a root make it once.
exec 9>"$(dirname "$root")/monado-root.lock"
flock 9
is_ready && exit 0
log=$(dirname "$root")/monado-root.log
: >"$log"
phase() { quietly "$log" "monado: $1" "${@:2}"; }

if ! command -v debootstrap >/dev/null 2>&1; then
    phase "installing debootstrap" as_root sh -c \
        'apt-get update -q && DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends debootstrap'
fi

as_root rm -rf --one-file-system "$root" # a half-made one

phase "making a Debian 13 root (about a minute)" \
    as_root debootstrap --variant=minbase --keyring="$key" "$release" "$root" "$address"

configure() {
    # What the host needs to reach its mirror (proxies, dates), the root needs too.
    as_root cp -a /etc/apt/apt.conf.d/. "$root/etc/apt/apt.conf.d/"
    # These hooks call programs that a minimal root lacks.
    as_root rm -f "$root"/etc/apt/apt.conf.d/{20packagekit,50appstream,70debconf}
    as_root cp -L /etc/resolv.conf "$root/etc/resolv.conf"
    # A test root: speed before safety against power cuts, and no manuals.
    printf 'force-unsafe-io\npath-exclude=/usr/share/doc/*\npath-exclude=/usr/share/man/*\n' |
        as_root tee "$root/etc/dpkg/dpkg.cfg.d/ramus"
    # Services must not start inside.
    printf '#!/bin/sh\nexit 101\n' | as_root tee "$root/usr/sbin/policy-rc.d"
    as_root chmod +x "$root/usr/sbin/policy-rc.d"
}
phase "settings" configure

# No --net here: the packages come through the host's network.
inside() {
    # shellcheck disable=SC2016 # expanded inside
    as_root unshare --mount --propagation private sh -euc \
        'mount --rbind /dev "$0/dev"; mount -t proc proc "$0/proc"; exec chroot "$0" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"' \
        "$root" "$@"
}
phase "package lists" inside apt-get update -q
phase "Monado, Mesa and the validation layers (about a minute)" \
    inside apt-get install -q -y --no-install-recommends "${packages[@]}"
phase "tidying" inside apt-get clean

echo "$recipe" | as_root tee "$root/.ready" >/dev/null
du -sh "$root" 2>/dev/null | awk '{ print "monado: the root is ready, " $1 }'
