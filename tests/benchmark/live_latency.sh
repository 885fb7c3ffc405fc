#!/bin/sh
# How long after its arrival lake-live has told a frame: rendered films of 720p and 1080p at 30, 60 and 120 Hz, replayed at
# their own pace as a camera sends them: Motion JPEG, and H.264 without B-frames. Prints frames that came and that were
# looked at, and the latency's median, 95 % quantile and largest in ms. The aim is 100 ms for 95 % up to 1080p60.
#
# Usage: tests/benchmark/live_latency.sh [FOLDER OF THE PROGRAMS]   (default: build/release/bin)
set -eu
here=$(cd "$(dirname "$0")" && pwd)
bin=$(cd "${1:-$here/../../build/release/bin}" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# play TITLE VIDEO CAMERA
play() {
  rm -rf out
  "$bin/lake-live" "$2" --replay --camera "$3" --no-overlay --json -o out >live.json 2>messages || { cat messages >&2; exit 1; }
  frames=$(ffprobe -v error -count_frames -select_streams v -show_entries stream=nb_read_frames -of csv=p=0 "$2")
  python3 - "$1" "$frames" <<'PYTHON'
import json
import sys
live = json.load(open("live.json"))
ms = live["latency_ms"]
print(f"{sys.argv[1]:<22} {sys.argv[2]:>5} frames, {live['frames']:>5} looked at, "
      f"{ms['median']:6.1f} {ms['of_95_percent']:6.1f} {ms['largest']:6.1f} ms")
PYTHON
}

for size in clean:720p hard:1080p; do
  for rate in 30 60 120; do
    "$bin/lake-synth" --scene "${size%:*}" --exo 18,32 --exoskeleton --duration 8 --rate $rate --seed-number 38 --quiet -o film >synth.txt
    ffmpeg -nostdin -v error -y -i film/video.mp4 -c:v mjpeg -q:v 3 -pix_fmt yuvj420p film.avi
    ffmpeg -nostdin -v error -y -i film/video.mp4 -c:v libx264 -preset veryfast -tune zerolatency -crf 18 film.mp4
    play "${size#*:} $rate Hz MJPEG" film.avi film/camera.yaml
    play "${size#*:} $rate Hz H.264" film.mp4 film/camera.yaml
    rm -rf film
  done
done
