#!/usr/bin/env bash
# Installs what is needed, builds the programs, and goes from the sample study's two videos to an optimal linkage: tracks both
# trials, simulates the paper's design, finds and proves the best one. Ends with the paths of the pictures and tables made.
# demo.sh [FOLDER]: where they go (default lake-out/demo).
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-lake-out/demo}

scripts/install_packages.sh
cmake --preset release -DLAKE_BUILD_TESTS=OFF
cmake --build --preset release
lake=build/release/bin/lake
study=data/sts-study

step() { printf '\n== %s\n' "$*"; }

step "Human trial: markers, leg vectors and knee angle"
"$lake" track $study/human.mp4 --camera $study/camera.yaml -o "$out/human"

step "Exoskeleton trial"
# The exoskeleton's joint is no marker of the leg, so the study file points at it, and at the knee beside it.
mapfile -t seeds < <(sed -n 's/^ *seeds: *\[\(.*\)\].*/\1/p' $study/study.yaml | tr ',' '\n' | paste -d, - - | tr -d '" ')
[ ${#seeds[@]} -gt 0 ] || { echo "demo.sh: $study/study.yaml: no seeds for the exoskeleton trial" >&2; exit 1; }
"$lake" track $study/exo.mp4 --camera $study/camera.yaml --markers ankle,knee,hip,waist,exo_knee \
  "${seeds[@]/#/--seed=}" -o "$out/exo"

step "The published linkage, in four poses"
"$lake" simulate --links 59.081,68.840,55.964,71.849,118.630,287.310 --angles 2,70,110,148 -o "$out/published-design"

step "The best linkage for the published problem, and the proof that there is none better by more than 0.5 degrees"
"$lake" optimize --certify 0.5 -o "$out/best-design"

step "Pictures, videos and drawings"
find "$(realpath "$out")" -type f \( -name '*.png' -o -name '*.svg' -o -name '*.gif' -o -name '*.mp4' -o -name '*.dxf' \) | sort
step "Tables and summaries"
find "$(realpath "$out")" -type f \( -name '*.csv' -o -name '*.json' -o -name '*.yaml' \) | sort
