#!/bin/sh
# How fast lake-track is against bare decoding: renders hard 1080p60 recordings of 20 s, one at a camera's bit rate (CRF 17,
# 17 Mbit/s) and one compressed tightly (CRF 23, 1 Mbit/s, which is decoded three times as fast). Each is decoded with ffmpeg and
# tracked without and with an overlay, in turn, five times each; prints the medians of the wall times and their ratios. Then
# the same without overlay of 2160p (the second one made larger), and of coloured lights and ArUco markers in 720p60.
# lake-track promises at least 0.85 of ffmpeg's frame rate without an overlay and 0.4 with one at a camera's bit rate; the fewer
# bits there are to decode, the more its own work counts. About eight minutes; the machine must be otherwise idle.
#
# Usage: tests/benchmark/track_speed.sh [FOLDER OF THE PROGRAMS]   (default: build/release/bin)
set -eu
bin=$(cd "${1:-$(dirname "$0")/../../build/release/bin}" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# Appends the wall time of a command, in s, to NAME.s.
measure() {
  name=$1
  shift
  begin=$(date +%s.%N)
  "$@" >/dev/null 2>"$name.err" || { cat "$name.err" >&2; exit 1; }
  end=$(date +%s.%N)
  echo "$begin $end" | awk '{ printf "%.3f\n", $2 - $1 }' >>"$name.s"
}

median() { sort -n "$1.s" | sed -n 3p; }

# compare TITLE VIDEO OPTIONS...: tracked without overlay against bare decoding.
compare() {
  title=$1 video=$2
  shift 2
  rm -f ./*.s
  for round in 1 2 3 4 5; do
    measure ffmpeg ffmpeg -nostdin -v error -i "$video" -f null -
    measure plain "$bin/lake-track" "$video" "$@" --no-overlay --quiet -o plain
  done
  echo "$(median ffmpeg) $(median plain)" | awk -v title="$title" \
    '{ printf "%s: ffmpeg alone %s s; lake-track %s s, %.2f of the frame rate of ffmpeg\n", title, $1, $2, $1 / $2 }'
}

# Where the lights are in frame 10 of a rendering.
colors() {
  awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) column[$i] = i }
    $1 == 10 { for (i = split("ankle knee hip waist", name, " "); i > 0; --i)
      options = sprintf("--color @%.0f,%.0f@10 ", $column[name[i] "_x_px"], $column[name[i] "_y_px"]) options
      print options; exit }' "$1"
}

for crf in 17 23; do
  rm -f ./*.s
  "$bin/lake-synth" -o "recording$crf" --scene hard --seed-number 2024 --duration 20 --crf "$crf" --quiet >synth.txt
  video=recording$crf/video.mp4
  for round in 1 2 3 4 5; do
    measure ffmpeg ffmpeg -nostdin -v error -i "$video" -f null -
    measure plain "$bin/lake-track" "$video" --no-overlay --quiet -o plain
    measure overlay "$bin/lake-track" "$video" --overlay --quiet -o overlay
  done
  echo "CRF $crf, $(($(stat -c %s "$video") / 2500)) kbit/s: ffmpeg alone $(median ffmpeg) s"
  for name in plain overlay; do
    echo "$(median ffmpeg) $(median $name)" | awk -v name="$name" '{ printf "  lake-track, %s: %s s, %.2f of the frame rate of ffmpeg\n", name, $2, $1 / $2 }'
  done
done

ffmpeg -nostdin -v error -i recording23/video.mp4 -vf scale=3840:2160 -c:v libx264 -preset veryfast -crf 20 large.mp4
compare 2160p large.mp4
for markers in led aruco; do
  "$bin/lake-synth" -o $markers --markers $markers --seed-number 501 --duration 20 --quiet >synth.txt
done
# shellcheck disable=SC2046  # several options
compare "coloured lights" led/video.mp4 --detector color $(colors led/truth.csv)
compare ArUco aruco/video.mp4 --detector aruco
