#!/usr/bin/env bash
# Installs a package in a bare Debian 12 and runs the sample study there as a user would; needs root, mmdebstrap and a Debian mirror.
#   scripts/package/try.sh build/release/lake_….deb
set -euo pipefail
package=$(realpath "$1")
system=$(mktemp -d)
trap 'rm -rf "$system"' EXIT

mmdebstrap --variant=apt bookworm "$system"
cp "$package" "$system/tmp/lake.deb"
chroot "$system" apt-get install -q -y --no-install-recommends /tmp/lake.deb
chroot "$system" lake --version
chroot "$system" lake run /usr/share/doc/lake/examples/data/sts-study/study.yaml -o /root/study
test -s "$system/root/study/report.html"
