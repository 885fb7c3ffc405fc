#!/usr/bin/env bash
# Which lines of libs the tests run: builds in build/coverage, runs them, and prints a table, the least covered file last.
# Ends with 1 below 90 % of the lines. Arguments go to ctest: -L fast, -R NAME, …; none: all tests.
# build/coverage/report.html shows each line. What runs in worker processes alone (processes.cc) is not counted: they end by
# _exit(), which keeps no counts.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/install_packages.sh gcovr
cmake --preset coverage
cmake --build --preset coverage
find build/coverage -name '*.gcda' -delete
status=0
ctest --preset coverage --no-tests=error "$@" || status=$?  # lines are counted all the same
gcovr --root . --filter libs/ --exclude-unreachable-branches --sort-percentage --print-summary \
  --html-details build/coverage/report.html --txt --fail-under-line 90 build/coverage || exit 1
exit "$status"
