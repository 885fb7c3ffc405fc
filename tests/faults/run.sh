#!/usr/bin/env bash
# Faults for long: full disks, little memory, folders without leave to write, odd names, one thread and two, 200 kills of a study, 1000 damaged files.
# run.sh [BUILD, build/test]; half an hour on two idle cores. With the sanitizers, as for the damaged files: run.sh build/asan
set -euo pipefail
cd "$(dirname "$0")/../.."

build=${1:-build/test}
export LAKE_BIN="$PWD/$build/bin"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
trials=tests/faults
failed=()
try() { echo "== $*"; python3 -B "$@" || failed+=("$1"); }

python3 -B $trials/programs.py "$folder/in"
try $trials/limits.py "$folder/in" disk
[[ $build == *asan* ]] || try $trials/limits.py "$folder/in" memory  # the sanitizer itself maps terabytes
try $trials/limits.py "$folder/in" folder
try $trials/names.py "$folder/in"
try $trials/threads.py "$folder/in"
try $trials/kill.py "$folder/in" --count 200
try $trials/mutate.py "$folder/in" --count 1000
[ ${#failed[@]} -eq 0 ] || { echo "failed: ${failed[*]}" >&2; exit 1; }
