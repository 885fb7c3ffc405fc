#!/usr/bin/env bash
# Installs what is needed, builds everything (warnings are errors) and passes all tests. Arguments go to ctest (-R NAME, …).
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/install_packages.sh
python3 scripts/check_layers.py
cmake --preset release
cmake --build --preset release
ctest --preset release "$@"
