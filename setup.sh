#!/bin/sh
# Installs what pellicle needs beyond Rust: Embree 4 (ray tracing) and libclang (for bindgen), from Debian's own packages.
# Safe to run twice; does nothing when everything is there.
set -eu

say() { printf 'setup: %s\n' "$*"; }
fail() { printf 'setup: %s\n' "$*" >&2; exit 1; }

HEADER=/usr/include/embree4/rtcore_config.h
TRIXIE_LIST=/etc/apt/sources.list.d/pellicle-trixie.sources
TRIXIE_PIN=/etc/apt/preferences.d/pellicle-trixie

embree_version() {
    [ -f "$HEADER" ] || return 1
    sed -n 's/^#define RTC_VERSION_STRING "\(.*\)"/\1/p' "$HEADER"
}
has_libclang() {
    # Not libclang-cpp.so, which bindgen cannot use.
    for lib in /usr/lib/llvm-*/lib/libclang.so* /usr/lib/llvm-*/lib/libclang-[0-9]*.so* /usr/lib/*/libclang-[0-9]*.so*; do
        [ -e "$lib" ] && return 0
    done
    return 1
}
check_rust() {
    # rustup installs to ~/.cargo/bin, which a non-login shell may not have on its PATH.
    command -v cargo >/dev/null 2>&1 || [ -x "${HOME:-/root}/.cargo/bin/cargo" ] && return 0
    say "Rust is missing: 'apt-get install cargo' on Debian 13, or rustup (https://rustup.rs). pellicle needs Rust 1.85 or newer."
}

if [ "$(uname -s)" != Linux ] || [ ! -r /etc/os-release ]; then
    fail "this script knows Debian 12 and 13 only. Elsewhere install Embree 4 (>= 4.0, with headers) and libclang, then run cargo build."
fi
. /etc/os-release

need_embree=yes
need_clang=yes
case "$(embree_version || true)" in 4.*) need_embree=no ;; esac
has_libclang && need_clang=no
need_tools=no
{ command -v cc >/dev/null 2>&1 && command -v pkg-config >/dev/null 2>&1; } || need_tools=yes

if [ "$need_embree$need_clang$need_tools" = nonono ]; then
    say "nothing to do: Embree $(embree_version), libclang and a C compiler are installed."
    check_rust
    exit 0
fi

# Decide where Embree 4 comes from before touching anything.
case "${ID:-}:${VERSION_ID:-}" in
    debian:12) source=trixie ;;
    # Once packages came from trixie, a Debian 12 machine may call itself 13: our own pin tells.
    debian:13 | debian:14) if [ -f "$TRIXIE_PIN" ]; then source=trixie; else source=native; fi ;;
    debian:*) [ -n "${VERSION_ID:-}" ] && fail "Debian ${VERSION_ID} is too old; Debian 12 or 13 is needed."
        source=native ;; # testing and unstable carry no VERSION_ID
    *) fail "${PRETTY_NAME:-this system} is not Debian. Install Embree 4 (headers and library) and libclang with its own tools, then run cargo build." ;;
esac

if [ "$(id -u)" = 0 ]; then
    as_root=
elif command -v sudo >/dev/null 2>&1; then
    as_root=sudo
else
    fail "installing packages needs root: run this script as root, or install sudo."
fi

packages=
[ "$need_clang" = yes ] && packages="$packages libclang-dev"
[ "$need_tools" = yes ] && packages="$packages gcc libc6-dev pkg-config"

say "on ${PRETTY_NAME} this will"
[ -n "$packages" ] && say "  - install$packages"
if [ "$need_embree" = yes ] && [ "$source" = native ]; then
    say "  - install libembree-dev (Embree 4)"
elif [ "$need_embree" = yes ]; then
    say "  - add Debian 13 (trixie) as a second package source, pinned at priority 100 so that nothing else moves to it:"
    say "      $TRIXIE_LIST, $TRIXIE_PIN"
    say "  - install libembree-dev (Embree 4) from it; this upgrades libc6 and some 25 packages, and removes none"
fi

log=$(mktemp)
trap 'rm -f "$log"' EXIT
# Runs apt-get quietly; its words are shown only when it fails.
apt() {
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -o Dpkg::Options::=--force-confold "$@" </dev/null >"$log" 2>&1 ||
        { cat "$log" >&2; fail "'apt-get $*' failed (its messages are above)."; }
}
write() { $as_root tee "$1" >/dev/null; }

if [ "$need_embree" = yes ] && [ "$source" = trixie ]; then
    # Reuse the mirror that this machine already has, so that a proxy or a local mirror keeps working.
    mirror=$(sed -n -e 's/^URIs: *\([^ ]*debian\)\/* *$/\1/p' /etc/apt/sources.list.d/*.sources 2>/dev/null | head -n 1)
    [ -n "$mirror" ] || mirror=$(sed -n -e 's/^deb \(\[[^]]*\] \)*\([^ ]*debian\)\/* bookworm .*/\2/p' /etc/apt/sources.list 2>/dev/null | head -n 1)
    write "$TRIXIE_PIN" <<PIN
# Written by pellicle's setup.sh: packages come from trixie only when asked for by name.
Package: *
Pin: release n=trixie
Pin-Priority: 100
PIN
    write "$TRIXIE_LIST" <<LIST
# Written by pellicle's setup.sh, for libembree-dev (Embree 4).
Types: deb
URIs: ${mirror:-http://deb.debian.org/debian}
Suites: trixie
Components: main
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg
LIST
fi

say "updating package lists"
apt update
if [ -n "$packages" ]; then
    say "installing$packages"
    # shellcheck disable=SC2086 -- a list of words
    apt install -y --no-install-recommends $packages
fi
if [ "$need_embree" = yes ]; then
    say "installing libembree-dev"
    if [ "$source" = trixie ]; then
        apt install -y --no-install-recommends -t trixie libembree-dev
    else
        apt install -y --no-install-recommends libembree-dev
    fi
fi

case "$(embree_version || true)" in
    4.*) say "done: Embree $(embree_version) is installed." ;;
    *) fail "libembree-dev was installed, but $HEADER does not show Embree 4. Is another version held back? Try 'apt-cache policy libembree-dev'." ;;
esac
check_rust
