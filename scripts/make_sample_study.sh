#!/usr/bin/env bash
# Makes the samples data/sts-study and data/walk again: the recordings are rendered by lake-synth with fixed seeds.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/build.sh release --target lake-synth

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
common=(--repetitions 3 --rest 0.9 --crf 18 --quiet)
build/release/bin/lake-synth "${common[@]}" --seed-number 2024 --yaw 9 --pitch 3 --roll 0.6 \
  --distortion -0.13,0.03,0.0004,-0.0003,0 -o "$work/human"
# The same person, before the same camera, with an exoskeleton: slower, with another pace within a rise, and with the
# exoskeleton's joint 18 mm in front of the knee and 32 mm above it.
build/release/bin/lake-synth "${common[@]}" --seed-number 2025 --motion-seed 2024 --camera "$work/human/camera.yaml" \
  --pace 1.25 --warp 0.04 --exo 18,32 --exoskeleton -o "$work/exo"

# Another person with two technical markers on the shank, and an exoskeleton that fits: its joint is 3 mm off the knee,
# and its hub, 40 mm proud, hides the knee.
hub=(--repetitions 3 --rest 0.9 --rate 30 --crf 20 --quiet --camera "$work/human/camera.yaml" --motion-seed 2026 --skin 6
  --extra-markers shank1,shank2)
build/release/bin/lake-synth "${hub[@]}" --seed-number 2026 -o "$work/hub-human"
build/release/bin/lake-synth "${hub[@]}" --seed-number 2027 --pace 1.1 --exo 3,0 --exoskeleton --hub 30 \
  --depth exo_knee=40 -o "$work/hub-exo"

mkdir -p data/sts-study
cp "$work/human/camera.yaml" data/sts-study/
for trial in human exo hub-human hub-exo; do
  cp "$work/$trial/video.mp4" "data/sts-study/$trial.mp4"
  cp "$work/$trial/truth.csv" "data/sts-study/$trial-truth.csv"
  cp "$work/$trial/scene.json" "data/sts-study/$trial-scene.json"
done

build/release/bin/lake-synth --movement walking --repetitions 6 --passes 2 --width 1920 --height 560 --radius-px 3.2 \
  --crf 20 --seed-number 2026 --quiet -o "$work/walk"
mkdir -p data/walk
cp "$work/walk/camera.yaml" data/walk/
cp "$work/walk/video.mp4" data/walk/walk.mp4
cp "$work/walk/truth.csv" data/walk/walk-truth.csv
cp "$work/walk/scene.json" data/walk/walk-scene.json
ls -l data/sts-study data/walk
