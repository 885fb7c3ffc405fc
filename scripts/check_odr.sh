#!/usr/bin/env bash
# Compiles each source by itself, as nothing else in CI does, and holds all rooms together against the one-definition rule: links them into one program with link-time optimisation, which
# compares what the sources define. Nothing is optimised and nothing is run.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/build.sh odr
echo "one definition rule: no violation"
