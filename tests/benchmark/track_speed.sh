#!/bin/sh
# How fast lake-track is against bare decoding: renders a hard 1080p60 recording of 20 s once, then decodes it with ffmpeg and tracks
# it without and with an overlay, in turn, five times each, and prints the medians of the wall times and their ratios.
# lake-track promises at least 0.85 of ffmpeg's frame rate without an overlay and 0.4 with one. The machine must be otherwise idle.
#
# Usage: tests/benchmark/track_speed.sh [FOLDER OF THE PROGRAMS]   (default: build/release/bin)
set -eu
bin=$(cd "${1:-$(dirname "$0")/../../build/release/bin}" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

"$bin/lake-synth" -o recording --scene hard --seed-number 2024 --duration 20 --quiet >synth.txt

# Appends the wall time of a command, in s, to NAME.s.
measure() {
  name=$1
  shift
  begin=$(date +%s.%N)
  "$@" >/dev/null 2>"$name.err" || { cat "$name.err" >&2; exit 1; }
  end=$(date +%s.%N)
  echo "$begin $end" | awk '{ printf "%.3f\n", $2 - $1 }' >>"$name.s"
}

for round in 1 2 3 4 5; do
  measure ffmpeg ffmpeg -nostdin -v error -i recording/video.mp4 -f null -
  measure plain "$bin/lake-track" recording/video.mp4 --no-overlay --quiet -o plain
  measure overlay "$bin/lake-track" recording/video.mp4 --overlay --quiet -o overlay
done

median() { sort -n "$1.s" | sed -n 3p; }
echo "ffmpeg alone: $(median ffmpeg) s"
for name in plain overlay; do
  # A lake-track that writes no overlay yet is not measured with one.
  [ "$name" = plain ] || [ -f overlay/overlay.mp4 ] || continue
  echo "$(median ffmpeg) $(median $name)" | awk -v name="$name" '{ printf "lake-track, %s: %s s, %.2f of the frame rate of ffmpeg\n", name, $2, $1 / $2 }'
done
