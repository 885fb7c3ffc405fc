#!/usr/bin/env bash
# Installs what is needed, builds everything (warnings are errors) and passes all tests. With --fuzz every reader of trial
# files is then fuzzed for a minute (about 15 minutes in all). Other arguments go to ctest (-R NAME, …).
set -euo pipefail
cd "$(dirname "$0")/.."

fuzz=
if [ "${1:-}" = --fuzz ]; then
  fuzz=yes
  shift
fi
scripts/install_packages.sh ${fuzz:+clang libclang-rt-dev}
python3 scripts/check_layers.py
cmake --preset release
cmake --build --preset release
ctest --preset release "$@"
[ -z "$fuzz" ] || tests/fuzz/run.sh 60
