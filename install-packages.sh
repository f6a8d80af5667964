#!/bin/sh
# Installs what packages.txt lists and the packages that are named behind it, on Debian 12 and 13, and with
# pip into build/venv what the Python package is built and tested with, python/requirements-test.txt, and what
# builds the documentation, docs/site/requirements.txt. It says what it installs, which may take minutes;
# where everything is installed already it is silent and touches neither the network nor sudo. Where pip
# fails, the Python package is left out, unless CI is set.
set -eu
cd "$(dirname "$0")"

missing() {
  { cat packages.txt; for package in "$@"; do echo "$package"; done; } | while read -r package; do
    status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) || status=absent
    [ "$status" = installed ] || printf '%s ' "$package"
  done
}

fail() {
  echo "install-packages.sh: $1" >&2
  echo "install-packages.sh: rivid needs: $(tr '\n' ' ' <packages.txt)" >&2
  exit 1
}

if ! command -v apt-get >/dev/null 2>&1 || ! command -v dpkg-query >/dev/null 2>&1; then
  fail "no apt here; install the packages named below, or their like, by your system's own means"
fi

python_packages() {
  requirements=$(mktemp)
  cat python/requirements-test.txt docs/site/requirements.txt >"$requirements"
  if cmp -s "$requirements" build/venv/requirements.txt; then
    rm -f "$requirements"
    return 0
  fi
  pip_log=$(mktemp)
  if python3 -m venv build/venv >"$pip_log" 2>&1 &&
    build/venv/bin/python -m pip install -q --disable-pip-version-check --retries 2 -r "$requirements" >>"$pip_log" 2>&1; then
    cp "$requirements" build/venv/requirements.txt
    rm -f "$pip_log" "$requirements"
    return 0
  fi
  echo "install-packages.sh: pip could not install $(grep -v '^#' "$requirements" | tr '\n' ' '); its last words:" >&2
  tail -n 3 "$pip_log" >&2
  rm -f "$pip_log" "$requirements"
  if [ -n "${CI:-}" ]; then
    exit 1
  fi
  echo "install-packages.sh: the Python package is left out; all else can be built" >&2
}

packages=$(missing "$@")
packages=${packages% }
if [ -z "$packages" ]; then
  python_packages
  exit 0
fi

if [ "$(id -u)" -eq 0 ]; then
  as_root=""
elif command -v sudo >/dev/null 2>&1; then
  # Without a terminal nobody can type a password: better to fail than to wait.
  if [ -t 0 ]; then as_root="sudo"; else as_root="sudo -n"; fi
else
  fail "missing: ${packages}; run this script as root, or install sudo"
fi
if [ -n "$as_root" ] && ! $as_root true; then
  fail "missing: ${packages}; sudo was refused, run this script as root"
fi

log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt() {
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y -o DPkg::Lock::Timeout=300 "$@" </dev/null >>"$log" 2>&1
}

# A package list that cannot be refreshed (one broken source among many) need not stop the installation.
echo "install-packages.sh: apt-get installs ${packages}; this may take some minutes" >&2
apt update || echo "install-packages.sh: apt-get update failed, going on with the lists at hand" >>"$log"
# shellcheck disable=SC2086  # one word a package is what is wanted
if ! apt install --no-install-recommends $packages; then
  cat "$log" >&2
  fail "apt-get could not install: ${packages}"
fi
python_packages
