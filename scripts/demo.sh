#!/usr/bin/env bash
# Installs what is needed, builds the programs, and runs the sample study: from its two videos to a better exoskeleton. Ends with
# the paths of the report, pictures and tables made.
# demo.sh [FOLDER]: where they go (default lake-out/demo). Run again, it repeats only what has changed.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-lake-out/demo}

scripts/install_packages.sh build run
scripts/build.sh release --target programs

printf '\n== The sample study\n'
build/release/bin/lake run data/sts-study/study.yaml -o "$out"

made() { find "$(realpath "$out")" -type f \( "$@" \) | sort; }
printf '\n== Pictures, videos and drawings\n'
made -name '*.png' -o -name '*.svg' -o -name '*.gif' -o -name '*.mp4' -o -name '*.dxf'
printf '\n== Tables and summaries\n'
made -name '*.csv' -o -name '*.yaml' -o -name 'summary.json' -o -name 'comparison.json'
printf '\n== The report: open it in a browser\n'
realpath "$out/report.html"
