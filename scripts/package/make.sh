#!/usr/bin/env bash
# Builds the release and packs it: build/release/lake_VERSION_ARCH.deb, for `apt install ./lake_….deb` on Debian 12.
set -euo pipefail
cd "$(dirname "$0")/../.."

scripts/install_packages.sh build run optional +help2man
scripts/build.sh release --target programs
(cd build/release && cpack -G DEB)
