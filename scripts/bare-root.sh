#!/usr/bin/env bash
# bare-root.sh [FOLDER] makes a bare Debian in FOLDER (default: a new one under /tmp, removed at the end) with exactly what
# README.md names, clones this repository into it and runs `make demo` and `make test` there as a user who is not
# root, with the times of both. Needs root and debootstrap (Debian: apt install debootstrap).
#
# Rust comes from the toolchain of this machine (RUSTUP_HOME, the default toolchain), since Debian's is older than 1.89.
# MAKE_TARGETS="demo" runs that one alone. DEBIAN_SUITE and DEBIAN_MIRROR say which Debian and from where.
set -euo pipefail

repository=$(cd "$(dirname "$0")/.." && pwd)
root=${1:-}
targets=${MAKE_TARGETS:-demo test}
suite=${DEBIAN_SUITE:-bookworm}

fail() {
    printf 'bare-root: %s\n' "$*" >&2
    exit 1
}

[ "$(id -u)" = 0 ] || fail "only root can make a root: run it by sudo"
command -v debootstrap >/dev/null || fail "debootstrap is missing: apt install debootstrap"
toolchain=$(rustc --print sysroot) || fail "rustc is missing: install Rust 1.89 or later"

kept=yes
if [ -z "$root" ]; then
    root=$(mktemp -d /tmp/bare-root.XXXXXX)
    kept=no
fi

clean() {
    ! mountpoint -q "$root/proc" || umount "$root/proc"
    [ "$kept" = yes ] || rm -rf --one-file-system "$root" "$root.log"
}
trap clean EXIT

# What README.md names beside Rust: Python with venv, gcc and make. The certificates are for cargo and pip; git clones.
packages=python3,python3-venv,gcc,libc6-dev,make,ca-certificates
if [ ! -x "$root/usr/bin/make" ]; then
    # The host's own mirror and proxy serve the new root, too.
    mirror=${DEBIAN_MIRROR:-}
    debootstrap --variant=minbase --include="$packages" "$suite" "$root" ${mirror:+"$mirror"} >"$root.log" 2>&1 ||
        fail "debootstrap failed: see $root.log"
fi
for file in /etc/resolv.conf /etc/pip.conf; do
    [ ! -e "$file" ] || install -D -m 644 "$file" "$root$file"
done
[ ! -d /usr/local/share/ca-certificates ] || cp -r /usr/local/share/ca-certificates "$root/usr/local/share/"
cp /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"

id=1000
home=/home/user
grep -q "^user:" "$root/etc/passwd" || chroot "$root" useradd --create-home --uid $id user
if [ ! -d "$root/opt/rust" ]; then
    cp -r "$toolchain" "$root/opt/rust"
    [ ! -e "${CARGO_HOME:-$HOME/.cargo}/config.toml" ] ||
        install -D -m 644 "${CARGO_HOME:-$HOME/.cargo}/config.toml" "$root$home/.cargo/config.toml"
fi
rm -rf "$root$home/gearmesh"
git clone --quiet "$repository" "$root$home/gearmesh"
chown -R $id:$id "$root$home"

for device in null zero random urandom; do
    [ -e "$root/dev/$device" ] || cp -a "/dev/$device" "$root/dev/"
done
# Where processes share semaphores.
install -d -m 1777 "$root/dev/shm"

# Programs find their libraries through it.
mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"

# Nothing of this machine's surroundings but what a network needs.
surroundings=(HOME=$home USER=user PATH=/opt/rust/bin:/usr/bin:/bin LANG=C.UTF-8)
for name in http_proxy https_proxy no_proxy HTTP_PROXY HTTPS_PROXY NO_PROXY PIP_INDEX_URL SSL_CERT_FILE; do
    [ -z "${!name:-}" ] || surroundings+=("$name=${!name}")
done
for target in $targets; do
    printf '== make %s\n' "$target"
    chroot --userspec=$id:$id "$root" env -i "${surroundings[@]}" \
        bash -c "cd $home/gearmesh && time make $target"
done
