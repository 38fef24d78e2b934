#!/usr/bin/env bash
# Runs a command where Monado is: enter.sh COMMAND [ARGUMENT…]
#
# With the Debian 13 root (make-root.sh) the command runs inside it; where the
# system itself has Monado, beside it. Either way in namespaces of its own: no
# mount is left behind, no process outlives the command, and the remote driver's
# port, which listens on every address, is reachable by nobody else.
#
# The repository (and the folders of CARGO_TARGET_DIR and RAMUS_SHARED) are there
# under their own paths, so a test binary built outside runs unchanged.
# Exit code 3: there is no Monado here.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
repository=$(cd "$here/../.." && pwd)
root=${RAMUS_MONADO_ROOT:-$repository/target/monado-root}

if [ $# -eq 0 ]; then
    echo "usage: enter.sh COMMAND [ARGUMENT…]" >&2
    exit 2
fi
if [ -e "$root/.ready" ]; then
    mode=root
elif command -v monado-service >/dev/null 2>&1; then
    mode=system
else
    echo "monado: no runtime here; xr/monado/make-root.sh makes one" >&2
    exit 3
fi

namespaces=(--mount --pid --net --ipc --fork --kill-child --propagation private)
# Without root the same works in a user namespace, where the kernel allows those.
[ "$(id -u)" -eq 0 ] || namespaces+=(--user --map-root-user)

export RAMUS_ENTERED=$mode RAMUS_ENTER_ROOT=$root RAMUS_ENTER_FOLDER=$PWD
# Newline-separated folders that the command may need under their own paths.
RAMUS_ENTER_BINDS=$repository
for folder in "${CARGO_TARGET_DIR:-}" "${RAMUS_SHARED:-}"; do
    [ -d "$folder" ] && RAMUS_ENTER_BINDS+=$'\n'$(cd "$folder" && pwd)
done
export RAMUS_ENTER_BINDS

# shellcheck disable=SC2016 # expanded inside
exec unshare "${namespaces[@]}" bash -euc '
    if [ "$RAMUS_ENTERED" = root ]; then
        root=$RAMUS_ENTER_ROOT
        mount --bind "$root" "$root"
        mount --rbind /dev "$root/dev"
        mount -t proc proc "$root/proc"
        mount -t tmpfs tmpfs "$root/tmp"
        mount -t tmpfs tmpfs "$root/run"
        # Mount points are made in memory: the cached root stays as it was made.
        covered=" usr bin sbin lib lib64 etc var tmp run dev proc "
        while IFS= read -r folder; do
            top=${folder#/}
            top=${top%%/*}
            if [[ $covered != *" $top "* ]]; then
                [ -d "$root/$top" ] || mkdir "$root/$top"
                mount -t tmpfs tmpfs "$root/$top"
                covered+="$top "
            fi
            mkdir -p "$root$folder"
            mount --bind "$folder" "$root$folder"
        done <<<"$RAMUS_ENTER_BINDS"
        exec chroot "$root" /bin/bash -euc "
            export PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/tmp LC_ALL=C.UTF-8 TMPDIR=/tmp
            unset LD_LIBRARY_PATH DISPLAY XDG_RUNTIME_DIR XDG_CONFIG_HOME
            ip link set lo up
            cd \"\$RAMUS_ENTER_FOLDER\" 2>/dev/null || cd /
            exec \"\$@\"" enter "$@"
    else
        mount -t proc proc /proc
        ip link set lo up
        exec "$@"
    fi' enter "$@"
