#!/usr/bin/env bash
# Installs what is needed, builds everything (warnings are errors) in build/test, whatever is configured elsewhere, and passes
# the tests; none found is a failure.
# --nightly: also the long tests (labelled `nightly`: many seeds, every single fault, clusters, long sessions), the
#   one-definition rule and the build by Clang.
# --asan: in build/asan with the address and undefined-behaviour sanitizers.
# --asan-readers: of these only the programs that test what reads files and pictures (labelled `reads`).
# --tsan: in build/tsan with the thread sanitizer, the tests of what has threads of its own (labelled `threads`).
# --fuzz: afterwards fuzzes every reader for a minute (about 25 minutes in all, without the build).
# Other arguments go to ctest: -R NAME, -L fast, …
set -euo pipefail
cd "$(dirname "$0")/.."

preset=test target='' fuzz='' which=(-LE nightly) nightly=''
while [ $# -gt 0 ]; do
  case $1 in
    --nightly) nightly=yes which=() ;;
    --asan) preset=asan ;;
    --asan-readers) preset=asan target=lake_reading_tests which=(-L reads -LE nightly) ;;
    --tsan) preset=tsan ;;
    --fuzz) fuzz=yes ;;
    *) break ;;
  esac
  shift
done
[ -z "$nightly" ] || export LAKE_LONG_TESTS=1 LAKE_WORLDS=all
export HWLOC_HIDE_ERRORS=2  # else a library of Debian 13 warns in each program where there is no /sys, as in a bare chroot
scripts/install_packages.sh build run optional cohort manual test ${fuzz:+"+clang" "+libclang-rt-dev"}
python3 scripts/check_layers.py
scripts/build.sh "$preset" ${target:+--target "$target"}
ctest --preset "$preset" --no-tests=error ${which[@]+"${which[@]}"} "$@" | tee "build/$preset/ctest.txt"
if [ -n "$nightly" ]; then
  scripts/check_odr.sh
  scripts/install_packages.sh +clang-14
  scripts/build.sh clang
fi
[ -z "$fuzz" ] || tests/fuzz/run.sh 60
