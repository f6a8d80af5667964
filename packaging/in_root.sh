#!/bin/sh
# packaging/in_root.sh SUITE WORK COMMAND...
#
# Runs COMMAND in a clone of the commit, in a root of Debian (SUITE: bookworm, trixie) that has nothing but
# what the build and a release need: packaging/in_root.sh trixie /var/tmp/trixie packaging/debian.sh. The
# clone is left in WORK/root/rivid; a root that is in WORK is used again. As root, with mmdebstrap and
# network.
set -eu
[ -n "${RIVID_OWN_MOUNTS:-}" ] || RIVID_OWN_MOUNTS=1 exec unshare -m --propagation private "$0" "$@"
suite=$1
mkdir -p "$2"
root=$(cd "$2" && pwd)/root
shift 2
cd "$(dirname "$0")/.."
if [ ! -d "$root" ]; then
  packages=$(paste -sd, packages.txt)
  mmdebstrap --quiet --variant=apt --skip=chroot/mount/dev --include="$packages,build-essential,ca-certificates,debhelper,dh-python,git,lintian" "$suite" "$root"
fi
mount -t proc proc "$root/proc"
cp /etc/resolv.conf "$root/etc/"
[ -d "$root/rivid" ] || git clone -q --no-hardlinks . "$root/rivid"
git -C "$root/rivid" fetch -q "$PWD" HEAD
git -C "$root/rivid" checkout -q --detach FETCH_HEAD
# Nothing of the caller's environment: neither its compilers nor its paths.
exec env -i HOME=/root LC_ALL=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin chroot "$root" sh -c 'cd /rivid && exec "$@"' sh "$@"
