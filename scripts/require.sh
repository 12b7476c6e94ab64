#!/usr/bin/env bash
# Find what the machine itself must provide; install what is missing where that is allowed, and
# where it is not, say which package to install.
#
# usage: scripts/require.sh python         print the path of a Python that is new enough
#        scripts/require.sh venv FOLDER    make a virtual environment, unless there is a working one
#        scripts/require.sh node           Node.js and npm, to build the front end and test it
#        scripts/require.sh osmesa         OSMesa, with which pyrender draws without a screen
#        scripts/require.sh chromium       Chromium, for the browser tests
#        scripts/require.sh nginx          nginx, to try two servers behind it
#        scripts/require.sh redis          Redis, to try limits that servers share
#        scripts/require.sh faketime       libfaketime, to set the clock beneath a server
#
# NO_INSTALL=1 never installs a system package, only names it.
set -euo pipefail

PYTHON_FLOOR="3.11"
NODE_FLOOR=20

say() { printf '%s\n' "$*" >&2; }

fail() {
    say "error: $1"
    shift
    for line in "$@"; do say "       $line"; done
    exit 1
}

# The command that may install packages here: nothing for root, sudo where it asks no password.
may_install() {
    [ -z "${NO_INSTALL:-}" ] || return 1
    command -v apt-get >/dev/null || return 1
    if [ "$(id -u)" = 0 ]; then
        as_root=()
    elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
        as_root=(sudo -n)
    else
        return 1
    fi
}

# Install Debian packages; false where that is not allowed or does not work.
install_packages() {
    may_install || return 1
    say "Installing system packages: $*"
    "${as_root[@]}" apt-get update -qq </dev/null >&2 || say "warning: the list of packages could not be renewed"
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
        apt-get install -qq -y --no-install-recommends "$@" </dev/null >&2
}

is_new_enough() {
    "$1" -c "import sys; sys.exit(sys.version_info < (${PYTHON_FLOOR/./, }))" 2>/dev/null
}

find_python() {
    local name
    for name in ${PYTHON:-} python3 python3.14 python3.13 python3.12 python3.11; do
        if command -v "$name" >/dev/null && is_new_enough "$name"; then
            command -v "$name"
            return
        fi
    done
    return 1
}

require_python() {
    find_python || { install_packages python3 python3-venv && find_python; } ||
        fail "Python $PYTHON_FLOOR or newer was not found." \
            "Install it (Debian and Ubuntu: apt-get install python3 python3-venv;" \
            "macOS: brew install python), or say where it is: make PYTHON=/path/to/python3"
}

require_venv() {
    local folder="$1" python package
    if [ -x "$folder/bin/python" ] && "$folder/bin/python" -m pip --version >/dev/null 2>&1; then
        return
    fi
    python="$(require_python)"
    if ! "$python" -c 'import ensurepip, venv' 2>/dev/null; then
        package="$("$python" -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')"
        install_packages "$package" ||
            fail "$python cannot make virtual environments." \
                "Install the package $package (Debian and Ubuntu: apt-get install $package)"
    fi
    say "Making the virtual environment $folder with $("$python" --version)"
    "$python" -m venv --clear "$folder"
}

has_node() {
    command -v node >/dev/null && command -v npm >/dev/null &&
        [ "$(node -p 'process.versions.node.split(".")[0]')" -ge "$NODE_FLOOR" ]
}

# A distribution's own Node.js may be too old to be worth installing.
offers_node() {
    local major
    major="$(apt-cache policy nodejs 2>/dev/null | sed -n 's/^ *Candidate: \([0-9]*\)\..*/\1/p')"
    [ "${major:-0}" -ge "$NODE_FLOOR" ]
}

require_node() {
    local found="none"
    has_node && return
    if may_install && offers_node && install_packages nodejs npm && has_node; then return; fi
    if command -v node >/dev/null; then found="$(node --version)"; fi
    fail "Node.js $NODE_FLOOR or newer with npm was not found (found: $found)." \
        "Install the packages nodejs and npm; where the distribution's are too old," \
        "take them from nodejs.org, or use a version manager such as nvm: nvm install $NODE_FLOOR"
}

# Asked of Python, because that is how PyOpenGL will look for the library.
has_osmesa() {
    "$(require_python)" -c 'import ctypes.util, sys; sys.exit(not ctypes.util.find_library("OSMesa"))'
}

require_osmesa() {
    has_osmesa && return
    if install_packages libosmesa6 && has_osmesa; then return; fi
    fail "the library OSMesa was not found; without it the two pictures cannot be drawn." \
        "Install the package libosmesa6 (Debian and Ubuntu: apt-get install libosmesa6;" \
        "Fedora: dnf install mesa-libOSMesa)"
}

has_chromium() {
    [ -n "${CHROMIUM:-}" ] && [ -x "$CHROMIUM" ] && return
    local name
    for name in chromium chromium-browser google-chrome; do
        if command -v "$name" >/dev/null; then return; fi
    done
    return 1
}

require_chromium() {
    has_chromium && return
    if install_packages chromium fonts-dejavu-core && has_chromium; then return; fi
    fail "Chromium was not found; the browser tests need it." \
        "Install the package chromium (Debian: apt-get install chromium fonts-dejavu-core)," \
        "or say where a Chromium or Chrome is: CHROMIUM=/path/to/chrome make test"
}

has_nginx() { PATH="$PATH:/usr/sbin" command -v nginx >/dev/null; }

require_nginx() {
    has_nginx && return
    if install_packages nginx-light && has_nginx; then return; fi
    fail "nginx was not found; two servers are tried behind it." \
        "Install the package nginx-light (Debian and Ubuntu: apt-get install nginx-light)"
}

has_redis() { command -v redis-server >/dev/null; }

require_redis() {
    has_redis && return
    if install_packages redis-server && has_redis; then return; fi
    fail "redis-server was not found; limits that servers share are tried on it." \
        "Install the package redis-server (Debian and Ubuntu: apt-get install redis-server)"
}

has_faketime() { compgen -G "/usr/lib/*/faketime/libfaketimeMT.so.1" >/dev/null; }

require_faketime() {
    has_faketime && return
    if install_packages libfaketime && has_faketime; then return; fi
    fail "libfaketime was not found; the clock is set with it beneath a server." \
        "Install the package libfaketime (Debian and Ubuntu: apt-get install libfaketime)"
}

case "${1:-}" in
    python) require_python ;;
    venv) require_venv "${2:?which folder?}" ;;
    node) require_node ;;
    osmesa) require_osmesa ;;
    chromium) require_chromium ;;
    nginx) require_nginx ;;
    redis) require_redis ;;
    faketime) require_faketime ;;
    *) sed -n 's/^# \{0,1\}//; 2,14p' "$0" >&2; exit 2 ;;
esac
