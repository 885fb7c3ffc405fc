#!/usr/bin/env bash
# Builds the release and packs it: build/release/lake_VERSION_ARCH.deb, for `apt install ./lake_….deb` on Debian 12.
set -euo pipefail
cd "$(dirname "$0")/../.."

scripts/install_packages.sh help2man
cmake --preset release
cmake --build --preset release --target programs
(cd build/release && cpack -G DEB)
