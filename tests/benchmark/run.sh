#!/usr/bin/env bash
# One table of lake against its peers, all from this run: tracking against ffmpeg's bare decoding, detection against OpenCV's
# detectors, synthesis against NLopt. About ten minutes; the machine must be otherwise idle.
#
# Usage: tests/benchmark/run.sh [FOLDER OF THE PROGRAMS]   (default: build/test/bin, made by cmake --build --preset test)
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bin=$(cd "${1:-$here/../../build/test/bin}" && pwd)
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT

for name in detection synthesis; do
  "$bin/lake_${name}_benchmark" --benchmark_out="$results/$name.json" --benchmark_out_format=json >/dev/null
done
python3 "$here/table.py" "$results"
"$here/track_speed.sh" "$bin"
