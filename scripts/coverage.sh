#!/usr/bin/env bash
# Which lines of libs the tests run: builds in build/coverage, runs them, and prints a table of the rooms, the least covered first.
# Ends with 1 below 90 % of the lines. Arguments go to ctest: -L fast, -R NAME, …; none: all tests.
# build/coverage/missed.txt names the lines that were not run. Programs that tests start are counted too, and so are worker processes, which end by
# _exit() (tests/coverage/keep_counts.cc); what is killed is not.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/install_packages.sh build run optional cohort manual test
scripts/build.sh coverage
find build/coverage -name '*.gcda' -delete
status=0
ctest --preset coverage --no-tests=error "$@" || status=$?  # lines are counted all the same
scripts/coverage.py build/coverage --least 90
exit "$status"
