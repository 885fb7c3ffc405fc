#!/usr/bin/env bash
# Installs what is needed, builds everything (warnings are errors) in build/test, whatever is configured elsewhere, and passes
# all tests; none found is a failure.
# --asan: the same in build/asan with the address and undefined-behaviour sanitizers.
# --asan-readers: of these only the programs that test what reads files and pictures (labelled `reads`).
# --tsan: in build/tsan with the thread sanitizer, the tests of what has threads of its own (labelled `threads`).
# --fuzz: afterwards fuzzes every reader for a minute (about 25 minutes in all, without the build).
# Other arguments go to ctest: -R NAME, -L fast, …
set -euo pipefail
cd "$(dirname "$0")/.."

preset=test target= fuzz=
while [ $# -gt 0 ]; do
  case $1 in
    --asan) preset=asan ;;
    --asan-readers) preset=asan target=lake_reading_tests ;;
    --tsan) preset=tsan ;;
    --fuzz) fuzz=yes ;;
    *) break ;;
  esac
  shift
done
scripts/install_packages.sh ${fuzz:+clang libclang-rt-dev}
python3 scripts/check_layers.py
cmake --preset "$preset"  # which sets all that matters here, whatever the cache holds
cmake --build --preset "$preset" ${target:+--target "$target"}
ctest --preset "$preset" --no-tests=error ${target:+-L reads} "$@" | tee "build/$preset/ctest.txt"
[ -z "$fuzz" ] || tests/fuzz/run.sh 60
