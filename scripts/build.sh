#!/usr/bin/env bash
# build.sh PRESET [OPTION…]: configures build/PRESET and builds it; further options go to `cmake --build`, such as --target programs.
# Says of each step how many there are and about how long the rest takes, from the time that those before it took.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1
shift

cmake --preset "$preset"
NINJA_STATUS='[%f/%t %e] ' cmake --build --preset "$preset" "$@" | awk '
  match($0, /^\[[0-9]+\/[0-9]+ [0-9.]+\] /) {
    split(substr($0, 2, RLENGTH - 3), n, /[\/ ]/)
    left = n[3] * (n[2] - n[1]) / (n[1] > 0 ? n[1] : 1)
    printf "[%d/%d, %s left] %s\n", n[1], n[2], n[1] < 5 ? "?" : left < 90 ? sprintf("%.0f s", left) : sprintf("%.0f min", left / 60), substr($0, RLENGTH + 1)
    fflush()
    next
  }
  { print; fflush() }'
