#!/usr/bin/env bash
# clang-tidy on the sources that changed: since the branch left origin/main, or in the last commit if there is no such branch or
# nothing was added to it. check_tidy.sh [BASE]: since BASE. Needs clang-14 and clang-tidy-14.
# A change of more files than LAKE_TIDY_MOST (40) is looked at where it changed most.
set -euo pipefail
cd "$(dirname "$0")/.."
most=${LAKE_TIDY_MOST:-40}

base=${1:-$(git merge-base HEAD origin/main 2>/dev/null || true)}
if [ $# -eq 0 ] && { [ -z "$base" ] || [ "$base" = "$(git rev-parse HEAD)" ]; }; then
  base=$(git rev-parse --verify --quiet HEAD~1 || git hash-object -t tree /dev/null)
fi
mapfile -t files < <(git diff --numstat --no-renames --diff-filter=d "$base" -- 'apps/*.cc' 'libs/*.cc' | sort -rn | cut -f3)
if [ ${#files[@]} -eq 0 ]; then
  echo "clang-tidy: no source changed since $base"
  exit 0
fi
[ ${#files[@]} -le "$most" ] || echo "clang-tidy: ${#files[@]} sources changed; the $most that changed most are checked"
cmake --preset clang > /dev/null
cmake --build --preset clang --target lake_commit > /dev/null
printf '%s\0' "${files[@]:0:$most}" | xargs -0 -n 1 -P 2 clang-tidy-14 --quiet -p build/clang
echo "clang-tidy: no finding in $((${#files[@]} < most ? ${#files[@]} : most)) sources"
