#!/bin/sh
# tests/install/aarch64.sh NATIVE_BUILD WORK
#
# Unit tests of regressor, solve and simulate for 64 bit ARM under qemu-user, and figures beside those of this
# machine: positions of two simulated loops, regressors and fits to 1e-12; velocities and torques of the loops
# to 1e-9, since a sampled law makes of a rounding of q its gains over a period. NATIVE_BUILD is a built
# preset (build/test). As root, on Debian 12, with mmdebstrap, qemu-user and g++-aarch64-linux-gnu. Libraries
# come into WORK/root alone; a build that is in WORK is gone on with.
set -eu
native=$(cd "$1" && pwd)
mkdir -p "$2"
work=$(cd "$2" && pwd)
cd "$(dirname "$0")/../.."
root=$work/root
if [ ! -d "$root" ]; then
  packages=$(grep -e -dev packages.txt | grep -vE 'fcl|benchmark|python' | paste -sd,)
  # `extract` runs nothing of the packages, and mounts nothing.
  mmdebstrap --quiet --variant=extract --architectures=arm64 --include="libgomp1,libstdc++-12-dev,$packages" bookworm "$root"
  # A path of the machine itself, where cross-linking would look for it.
  sed -i 's#/usr/lib/[^;"]*/libtinyxml.so#tinyxml#' "$root"/usr/lib/*/urdfdom/cmake/urdfdomExport.cmake
fi
cmake -S . -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE=-O2 -DCMAKE_UNITY_BUILD=ON -DRIVID_WARNINGS_AS_ERRORS=ON \
  -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 -DCMAKE_CXX_COMPILER=aarch64-linux-gnu-g++ \
  -DCMAKE_SYSROOT="$root" -DCMAKE_FIND_ROOT_PATH="$root" -DCMAKE_FIND_ROOT_PATH_MODE_PROGRAM=NEVER \
  -DCMAKE_FIND_ROOT_PATH_MODE_LIBRARY=ONLY -DCMAKE_FIND_ROOT_PATH_MODE_INCLUDE=ONLY -DCMAKE_FIND_ROOT_PATH_MODE_PACKAGE=ONLY \
  "-DCMAKE_CROSSCOMPILING_EMULATOR=qemu-aarch64;-L;$root" \
  -DRIVID_BUILD_APPS=OFF -DRIVID_BUILD_BENCHMARKS=OFF -DRIVID_BUILD_EXAMPLES=OFF -DRIVID_PYTHON=OFF
cmake --build "$native" --target machine_figures
tests=$(ninja -C "$work/build" -t targets all | sed -n 's/^\(\(regressor\|simulate\|solve\)_[a-z_]*_test\): phony$/\1/p')
# shellcheck disable=SC2086  # one word a program
cmake --build "$work/build" --target machine_figures $tests
for test in $tests; do
  echo "aarch64.sh: $test"
  qemu-aarch64 -L "$root" "$work/build/tests/$test" --gtest_brief=1
done
for file in data/scara/simulate_s2.toml data/six_axis/simulate.toml; do
  "$native/tests/machine_figures" $file >"$work/here"
  qemu-aarch64 -L "$root" "$work/build/tests/machine_figures" $file >"$work/there"
  python3 - "$work/here" "$work/there" $file <<'PYTHON'
import sys
here, there = ([line.split() for line in open(name)] for name in sys.argv[1:3])
assert len(here) == len(there) > 10
worst = {}
for a, b in zip(here, there):
    assert a[0] == b[0] and len(a) == len(b) > 2, a[0]
    # Of what the column is compared to.
    apart = max(abs(float(x) - float(y)) for x, y in zip(a[2:], b[2:])) / (float(a[1]) or 1.0)
    worst[a[0]] = max(apart, worst.get(a[0], 0.0))
print(f"aarch64.sh: {sys.argv[3]}:", ", ".join(f"{name} {apart:.1e}" for name, apart in worst.items()))
of_the_loop = ("qd", "tau")
sys.exit(any(not apart <= (1e-9 if name in of_the_loop else 1e-12) for name, apart in worst.items()))
PYTHON
done
