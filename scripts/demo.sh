#!/usr/bin/env bash
# Installs what is needed, builds, and runs the main job on the sample study; ends with the paths of the pictures and tables made.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/install_packages.sh
cmake --preset release -DLAKE_BUILD_TESTS=OFF
cmake --build --preset release

out=lake-out/sts-study
for trial in human exo; do
  markers=ankle,knee,hip,waist
  [ "$trial" = human ] || markers+=,exo_knee
  build/release/bin/lake track "data/sts-study/$trial.mp4" --camera data/sts-study/camera.yaml --markers "$markers" -o "$out/$trial"
done

echo
echo "Pictures, videos and tables:"
find "$out" -type f | sort
