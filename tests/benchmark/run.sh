#!/usr/bin/env bash
# One table of lake against its peers, all from this run: tracking against ffmpeg's bare decoding, detection against OpenCV's
# detectors, camera calibration against cv::calibrateCamera, synthesis against NLopt, smoothing against scipy (Debian's
# python3-scipy, if it is there). Processor time and accuracy, but wall time of the tracking. About eleven minutes; the machine
# must be otherwise idle.
#
# Usage: tests/benchmark/run.sh [FOLDER OF THE PROGRAMS]   (default: build/test/bin, made by cmake --build --preset test)
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bin=$(cd "${1:-$here/../../build/test/bin}" && pwd)
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT

for name in detection synthesis calibration smoothing; do
  "$bin/lake_${name}_benchmark" --benchmark_out="$results/$name.json" --benchmark_out_format=json >/dev/null
done
"$bin/lake_smoothing_benchmark" --curves="$results/curves.csv"
scipy_python=python3
[ ! -x /usr/bin/python3 ] || scipy_python=/usr/bin/python3 # Debian's, for which python3-scipy is installed
"$scipy_python" "$here/smoothing_scipy.py" "$results/curves.csv" >"$results/smoothing_scipy.json"
python3 "$here/table.py" "$results"
"$here/track_speed.sh" "$bin"
