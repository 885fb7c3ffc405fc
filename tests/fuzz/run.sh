#!/usr/bin/env bash
# Fuzzes every reader (trial files, YAML, comparison.json, duty logs, corrections) with libFuzzer and the sanitizers, led by coverage: run.sh [SECONDS each, 60] [NAME…].
# Needs clang and its run-time libraries (Debian: clang libclang-rt-dev). Ends with 1 at the first input that crashes, hangs for 10 s or takes 1 GiB; it is kept in build/fuzz/findings.
set -euo pipefail
cd "$(dirname "$0")/../.."

seconds=${1:-60}
shift || true
command -v clang++ > /dev/null || { echo "tests/fuzz/run.sh: clang++ is not installed (Debian: clang libclang-rt-dev)" >&2; exit 1; }
cmake -S . -B build/fuzz -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ \
  -DCMAKE_CXX_FLAGS_DEBUG="-O1 -g -fsanitize=fuzzer-no-link" -DLAKE_SANITIZE=address,undefined -DLAKE_BUILD_BENCHMARKS=OFF > /dev/null
cmake --build build/fuzz -j 2 --target lake_fuzz

bin=build/fuzz/bin
corpus=build/fuzz/corpus
findings=build/fuzz/findings
mkdir -p "$findings"
"$bin/lake_fuzz_corpus" "$corpus"
for folder in "$corpus"/*/; do
  name=$(basename "$folder")
  if [ $# -gt 0 ] && [[ " $* " != *" $name "* ]]; then continue; fi
  echo "== $name, $seconds s"
  "$bin/lake_fuzz_$name" -max_total_time="$seconds" -max_len=16384 -timeout=10 -rss_limit_mb=1024 -print_final_stats=1 \
    -artifact_prefix="$findings/$name-" "$folder" 2>&1 | grep -E "ERROR|SUMMARY|Test unit|stat::number_of_executed|cov:" | tail -4
done
