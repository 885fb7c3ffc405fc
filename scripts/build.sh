#!/usr/bin/env bash
# build.sh PRESET [OPTION…]: configures build/PRESET and builds it; further options go to `cmake --build`, such as --target programs.
# One compiler for each core, as far as memory reaches.
# Says of each step how many there are and about how long the rest takes, from the time that those before it took.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1
shift

largest_kb=2600000  # of a compiler at work on a room whose sources are one unit
free_kb=$(awk '/^MemAvailable:/ {print $2}' /proc/meminfo 2>/dev/null || true)
cores=$(nproc) fit=$((${free_kb:-999999999} / largest_kb))
jobs=$((fit < 1 ? 1 : fit < cores ? fit : cores))

cmake --preset "$preset"
NINJA_STATUS='[%f/%t %e] ' cmake --build --preset "$preset" --parallel "$jobs" "$@" | while IFS= read -r line; do
  if [[ $line =~ ^\[([0-9]+)/([0-9]+)\ ([0-9]+)[0-9.]*\]\ (.*) ]]; then
    done=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]} left='?'
    if [ "$done" -ge 5 ]; then
      seconds=$((BASH_REMATCH[3] * (all - done) / done))
      left=$([ $seconds -lt 90 ] && echo "$seconds s" || echo "$(((seconds + 30) / 60)) min")
    fi
    line="[$done/$all, $left left] ${BASH_REMATCH[4]}"
  fi
  printf '%s\n' "$line"
done
