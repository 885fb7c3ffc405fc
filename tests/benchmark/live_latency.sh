#!/bin/sh
# How long after its arrival lake-live has told a frame, and what a frame costs: rendered films of 720p and 1080p at 30, 60
# and 120 Hz, replayed at their own pace as a camera sends them: Motion JPEG, and H.264 without B-frames. Prints the frames
# that came and that were looked at, the latency's median, 95 % quantile and largest, and the processor time of a frame
# (all threads of lake-live: received, recorded, decoded, tracked, rises measured; lake-track's afterwards is not in it).
# The aim is 100 ms for 95 % up to 1080p60. A busy machine makes the latency worse, and the processor time hardly: "busy"
# is what other programs took of the processors meanwhile.
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
  python3 - "$bin/lake-live" "$1" "$2" "$3" <<'PYTHON'
import json
import os
import subprocess
import sys

program, title, video, camera = sys.argv[1:]
TICK_S = 1 / os.sysconf("SC_CLK_TCK")


def busy_s():
    with open("/proc/stat") as file:
        user, nice, system = (int(word) for word in file.readline().split()[1:4])
    return (user + nice + system) * TICK_S


def own_s(process):  # also of one that has ended and was not waited for: without its children, but all of its threads
    with open(f"/proc/{process}/stat") as file:
        words = file.read().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) * TICK_S


counted = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-select_streams", "v", "-show_entries", "stream=nb_read_frames",
                          "-of", "csv=p=0", video], check=True, capture_output=True, text=True)
before_s = busy_s()
began_s = os.times().elapsed
with open("live.json", "w") as said, open("messages", "w") as messages:
    live = subprocess.Popen([program, video, "--replay", "--camera", camera, "--no-overlay", "--json", "-o", "out"], stdout=said,
                            stderr=messages)
    os.waitid(os.P_PID, live.pid, os.WEXITED | os.WNOWAIT)
    live_s = own_s(live.pid)
    code = live.wait()
if code != 0:
    sys.exit(open("messages").read())
all_s = busy_s() - before_s
children = os.times()
others = (all_s - children.children_user - children.children_system) / (os.times().elapsed - began_s) / os.cpu_count()
told = json.load(open("live.json"))
ms = told["latency_ms"]
print(f"{title:<19} {counted.stdout.strip():>5} frames, {told['frames']:>5} looked at; "
      f"{ms['median']:6.1f} {ms['of_95_percent']:6.1f} {ms['largest']:6.1f} ms; "
      f"{1000 * live_s / told['frames']:5.1f} ms of processor; others {100 * max(others, 0):3.0f} % busy", flush=True)
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
