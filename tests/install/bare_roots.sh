#!/bin/sh
# tests/install/bare_roots.sh SUITE FOLDER
#
# Installs what lies in FOLDER (build/release) into a root of Debian (SUITE: bookworm, trixie) that has
# nothing else: wheel and .deb without a compiler, `rivid demo`, consumers by CMake and pkg-config, removal
# without a trace, the wheel of the source distribution. As root, with mmdebstrap and network.
set -eu
[ -n "${RIVID_OWN_MOUNTS:-}" ] || RIVID_OWN_MOUNTS=1 exec unshare -m --propagation private "$0" "$@"
suite=$1
files=$(cd "$2" && pwd)
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
root=$work/root
remove() {
  umount "$root/proc" 2>/dev/null || true
  rm -rf --one-file-system "$work"
}
trap remove EXIT
say() { echo "bare_roots.sh: $suite: $1"; }
inside() { # inside WHAT COMMANDS, where COMMANDS stop at the first that fails
  say "$1"
  # Nothing of the caller's environment: neither its compilers nor its paths.
  chroot "$root" env -i HOME=/root LC_ALL=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive sh -exc "$prelude; cd /check; $2" >"$work/log" 2>&1 || {
    tail -n 40 "$work/log"
    say "FAILED: $1"
    exit 1
  }
}
# `none`: nothing may come in. (A pipeline that begins with ! does not stop a script.)
prelude='none() { ! grep .; }
  no_compiler() { for tool in cc c++ gcc g++ clang; do command -v $tool || true; done | none; }
  files() { find / -xdev | grep -v "^/\(proc\|check\|tmp\|var/log\|var/cache\)" | sort; }'
install="apt-get install -y --no-install-recommends"

say "root"
mmdebstrap --quiet --variant=apt --skip=chroot/mount/dev --include=python3-venv "$suite" "$root"
mount -t proc proc "$root/proc"
cp /etc/resolv.conf "$root/etc/"
mkdir "$root/check"
cp -r "$files"/* "$here" "$root/check/"
python=$(chroot "$root" python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])')
# pip inside sees these files alone.
python3 -m venv "$work/venv"
"$work/venv/bin/pip" download -q --dest "$root/check/wheels" --python-version "$python" --only-binary :all: numpy nanobind "scikit-build-core>=0.10" setuptools
pip="pip install -q --no-index --find-links /check/wheels"

inside "no compiler, no rivid" 'no_compiler; files | grep rivid | none; dpkg-query -W -f "\${Package}\n" | sort >packages; python3 -m venv env'
if ls "$files"/*.whl >/dev/null 2>&1; then
  inside "wheel" "env/bin/$pip --find-links . --only-binary :all: rivid; rm -rf demo
    env/bin/rivid demo demo; test -s demo/result/report.html; env/bin/python -c 'import rivid; print(rivid.InputError)'
    env/bin/pip uninstall -qy rivid; find env -name '*rivid*' | none"
fi
inside "Debian packages" "apt-get update; $install ./*.deb; no_compiler; rm -rf demo
  rivid demo demo; test -s demo/result/report.html; rivid identify /usr/share/rivid/scara/scara.toml --output scara;
  cd /; python3 -c 'import rivid; print(rivid.InputError)'; ldd /usr/bin/rivid | grep -E 'libmpi|not found' | none"
inside "consumers" "$install g++ cmake ninja-build pkgconf
  version=\$(dpkg-query -W -f '\${source:Upstream-Version}' librivid-dev); says='13 base parameters of'
  for consumer in consumer headers_consumer; do
    cmake -DWORK_DIR=/check/built -DCONSUMER=/check/install/\$consumer -DPREFIX=/usr -DGENERATOR=Ninja -DCOMPILER=c++ -DRUN_SAYS=\"\$says\" -P install/build_consumer.cmake
  done
  cmake -DWORK_DIR=/check/built -DCONSUMER=/check/install/consumer -DPREFIX=/usr -DPKG_CONFIG=/usr/bin/pkg-config -DCOMPILER=c++ -DLINKAGE=--shared \
    -DVERSION=\$version -DRUN_SAYS=\"\$says\" -P install/build_with_pkg_config.cmake"
inside "removal" "dpkg-query -W -f '\${Package}\n' | sort | comm -13 packages - | xargs apt-get purge -y; files | grep rivid | none"
if [ -d "$files/sdist" ]; then
  inside "source distribution" "$install $(grep -vE 'gtest|fcl|benchmark' "$here/../../packages.txt" | tr '\n' ' ') make
    env/bin/$pip sdist/rivid-*.tar.gz; rm -rf demo; env/bin/rivid demo demo; test -s demo/result/report.html"
fi
say "all good"
