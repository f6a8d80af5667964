#!/bin/sh
# tests/install/libcxx.sh WORK
#
# Library and unit tests by clang 19 with libc++, warnings are errors. Debian builds its C++ libraries for
# libstdc++, so those that rivid links are built in WORK from Debian's sources first. On Debian 12 with
# clang-19, libc++-19-dev, libc++abi-19-dev and dpkg-dev; a build that is in WORK is gone on with.
set -eu
mkdir -p "$1"
work=$(cd "$1" && pwd)
here=$(cd "$(dirname "$0")/../.." && pwd)
prefix=$work/prefix
export CC=clang-19 CXX=clang++-19
if [ ! -d "$prefix" ]; then
  cd "$work"
  mkdir -p lists/partial "$prefix/include" "$prefix/lib"
  cat >sources.sources <<'SOURCES'
Types: deb-src
URIs: http://deb.debian.org/debian
Suites: bookworm
Components: main
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg
SOURCES
  apt="apt-get -qq -o Dir::Etc::sourcelist=$work/sources.sources -o Dir::Etc::sourceparts=/dev/null -o Dir::State::lists=$work/lists"
  $apt update
  $apt source orocos-kdl urdfdom urdfdom-headers console-bridge tinyxml pugixml
  export CXXFLAGS="-stdlib=libc++ -O2 -w" LDFLAGS=-stdlib=libc++
  # shellcheck disable=SC2086  # several flags
  (cd tinyxml-*/ && $CXX $CXXFLAGS -DTIXML_USE_STL -fPIC -c tinystr.cpp tinyxml.cpp tinyxmlerror.cpp tinyxmlparser.cpp &&
    ar rcs "$prefix/lib/libtinyxml.a" ./*.o && cp tinyxml.h tinystr.h "$prefix/include")
  for source in pugixml-*/ console-bridge-*/ urdfdom-headers-*/ urdfdom-[0-9]*/ orocos-kdl-*/orocos_kdl /usr/src/googletest; do
    rm -rf dependency
    cmake -S "$source" -B dependency -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=OFF -DBUILD_TESTING=OFF \
      -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_PREFIX_PATH="$prefix" \
      -DTinyXML_INCLUDE_DIR="$prefix/include" -DTinyXML_LIBRARY="$prefix/lib/libtinyxml.a" >dependency.log
    cmake --build dependency --target install >>dependency.log
  done
  unset CXXFLAGS LDFLAGS
fi
# -fexperimental-library: std::jthread.
cmake -S "$here" -B "$work/rivid" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE=-O1 -DCMAKE_UNITY_BUILD=ON \
  -DCMAKE_CXX_FLAGS="-stdlib=libc++ -fexperimental-library" -DCMAKE_EXE_LINKER_FLAGS="-L$prefix/lib" \
  -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_DISABLE_FIND_PACKAGE_fcl=ON -DRIVID_WARNINGS_AS_ERRORS=ON \
  -DRIVID_BUILD_BENCHMARKS=OFF -DRIVID_PYTHON=OFF
cmake --build "$work/rivid" --target unit_tests
LD_LIBRARY_PATH=$prefix/lib ctest --test-dir "$work/rivid" -L unit -E "fuzz_corpus|readme" --output-on-failure -j2
