#!/usr/bin/env bash
# Formats all C++ sources; with --check only says which are not formatted.
set -euo pipefail
cd "$(dirname "$0")/.."
mode=-i
[ "${1:-}" != --check ] || mode='--dry-run --Werror'
# shellcheck disable=SC2086
git ls-files '*.cc' '*.h' | xargs clang-format-14 $mode
