#!/bin/sh
# Packs inputs into the corpus of a harness, the same bytes from the same files: pack.sh HARNESS FOLDER
set -e
here=$(cd "$(dirname "$0")" && pwd)
name=$1
rm -rf "$here/corpus/.packing"
mkdir -p "$here/corpus/.packing"
cp -r "$2" "$here/corpus/.packing/$name"
tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner --mode='u=rwX,go=rX' -C "$here/corpus/.packing" -cf - "$name" |
  xz -9e > "$here/corpus/$name.tar.xz"
rm -rf "$here/corpus/.packing"
