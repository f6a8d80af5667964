#!/bin/sh
# packaging/debian.sh
#
# Makes the Debian source and binary packages of the commit in build/debian, and has them read by lintian. It
# needs, besides packages.txt: ./install-packages.sh debhelper dh-python lintian
set -eu
cd "$(dirname "$0")/.."
version=$(sed -n 's/^project(rivid VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
out=$PWD/build/debian
rm -rf "$out"
mkdir -p "$out"
git archive --format=tar --prefix="rivid-$version/" HEAD | tar -x -C "$out"
if ! dpkg-query -W python3-nanobind >/dev/null 2>&1; then
  /usr/bin/python3 -m venv "$out/tools"
  "$out/tools/bin/pip" install -q --disable-pip-version-check --target "$out/nanobind" "nanobind>=2.2,<4"
  export PYTHONPATH="$out/nanobind" DEB_BUILD_PROFILES=pkg.rivid.nanobind
fi
export DEB_BUILD_OPTIONS="noautodbgsym ${DEB_BUILD_OPTIONS:-}"
(cd "$out/rivid-$version" && dpkg-buildpackage -us -uc "$@")
rm -rf "$out/tools" "$out/nanobind" "$out/rivid-$version"
lintian --fail-on error,warning "$out"/*.changes
