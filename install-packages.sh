#!/bin/sh
# Installs what packages.txt lists, on Debian 12 and Ubuntu 24.04 or later. Silent unless it fails; where
# everything is installed already it touches neither the network nor sudo.
set -eu
cd "$(dirname "$0")"

missing() {
  while read -r package; do
    status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) || status=absent
    [ "$status" = installed ] || printf '%s ' "$package"
  done <packages.txt
}

fail() {
  echo "install-packages.sh: $1" >&2
  echo "install-packages.sh: rivid needs: $(tr '\n' ' ' <packages.txt)" >&2
  exit 1
}

if ! command -v apt-get >/dev/null 2>&1 || ! command -v dpkg-query >/dev/null 2>&1; then
  fail "no apt here; install the packages named below, or their like, by your system's own means"
fi

packages=$(missing)
packages=${packages% }
[ -n "$packages" ] || exit 0

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
apt update || echo "install-packages.sh: apt-get update failed, going on with the lists at hand" >>"$log"
# shellcheck disable=SC2086  # one word a package is what is wanted
if ! apt install --no-install-recommends $packages; then
  cat "$log" >&2
  fail "apt-get could not install: ${packages}"
fi
