#!/bin/sh
# How much memory lake-track takes, and how that grows: the sample study's human trial (720p60) looped to 5, 10 and 20 minutes,
# and a recording of 1080p60 and of 2160p60 of 20 and 100 s. Prints frames, the largest resident set in MB, and processor time
# per frame. The aim is less than 400 MB at 1080p and less than 1 GB at 2160p over half an hour.
#
# Usage: tests/benchmark/track_memory.sh [FOLDER OF THE PROGRAMS]   (default: build/release/bin)
set -eu
here=$(cd "$(dirname "$0")" && pwd)
bin=$(cd "${1:-$here/../../build/release/bin}" && pwd)
sample=$(cd "$here/../../data/sts-study" && pwd)/human.mp4
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# Loops a video so many times and tracks it: track TITLE VIDEO TIMES.
track() {
  ffmpeg -nostdin -v error -y -stream_loop $(($3 - 1)) -i "$2" -c copy looped.mp4
  /usr/bin/time -f '%M %U %S' -o used "$bin/lake-track" looped.mp4 --no-overlay --quiet -o out >/dev/null 2>messages ||
    { cat messages >&2; exit 1; }
  frames=$(($(wc -l <out/tracks.csv) - 1))
  awk -v title="$1" -v frames="$frames" \
    '{ printf "%-8s %7d frames %5.0f MB %6.2f ms of processor time a frame\n", title, frames, $1 / 1024, 1000 * ($2 + $3) / frames }' \
    used
}

for times in 18 36 72; do track 720p "$sample" $times; done
"$bin/lake-synth" -o recording --scene hard --seed-number 2024 --duration 20 --crf 23 --quiet >synth.txt
for times in 1 5; do track 1080p recording/video.mp4 $times; done
ffmpeg -nostdin -v error -i recording/video.mp4 -vf scale=3840:2160 -c:v libx264 -preset veryfast -crf 20 large.mp4
for times in 1 5; do track 2160p large.mp4 $times; done
