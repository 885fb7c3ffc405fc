#!/usr/bin/env bash
# Makes a release's tarball of a commit, the same bytes whenever and wherever it is made: names and contents from git, the commit's time for all
# files, no owner, gzip without a name or a time.
#   scripts/package/tarball.sh [COMMIT] [FOLDER]: HEAD, into build/
set -euo pipefail
cd "$(dirname "$0")/../.."
commit=$(git rev-parse --verify "${1:-HEAD}^{commit}")
folder=${2:-build}

version=$(git show "$commit:CMakeLists.txt" | sed -n 's/^project(lake VERSION \([0-9.]*\).*/\1/p')
[ -n "$version" ] || { echo "tarball.sh: CMakeLists.txt of $commit names no version of lake" >&2; exit 1; }
mkdir -p "$folder"
out=$folder/lake-$version.tar.gz
trap 'rm -f "$out.part"' EXIT
git -c tar.umask=0022 -c core.attributesFile=/dev/null archive --format=tar --prefix="lake-$version/" "$commit" | gzip -9n >"$out.part"
mv "$out.part" "$out"
sha256sum "$out"
